"""Robots: URDF trees with loops, springs and flexible joints, at rest and linearized. The only room that imports pinocchio.

Imports the rooms up to ``models``. Read ``robot`` and ``robot_model`` first, then in the order of the data: ``description`` (the URDF as checked
data), ``kinematics`` (the pinocchio model and relative poses), ``tangent`` (coordinates), ``connections`` (loops and springs, attached to joints),
``statics`` (forces at rest, equilibria, stiffness), ``posture_search`` (with the rank of the loops and contacts), ``linearized`` with
``flexible_joint`` and ``linear_range``, ``cartesian_path``, and ``visualization``, the data of drawings.
"""
