"""Robots: URDF trees with loops, springs and flexible joints, at rest and linearized. The only room that imports pinocchio.

Imports the rooms up to ``models``. Read ``robot`` and ``robot_model`` first, then in the order of the data: ``description`` (the URDF as checked
data), ``kinematics`` (the pinocchio model and relative poses), ``tangent`` (coordinates), ``connections`` and ``mechanism``
(loops and springs, attached to joints), ``statics`` (forces at rest, equilibria, the rank of the loops, contacts), ``posture`` and ``posture_search``,
``linearization`` with ``flexible_joint``, ``cartesian_path``, and ``visualization``, the data of drawings.
"""
