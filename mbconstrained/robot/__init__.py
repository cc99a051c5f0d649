"""Robots: URDF trees with loops, springs and flexible joints, at rest and linearized. The only room that imports pinocchio.

Imports the rooms up to ``models``. Read ``robot`` first, then in the order of the data: ``description`` (the URDF as checked
data), ``kinematics`` (the pinocchio model and relative poses), ``tangent`` (coordinates), ``connections`` and ``mechanism``
(loops and springs, attached to joints), ``balance`` (forces and stiffness in one configuration), ``equilibrium`` and
``regularity`` (Newton's method and the rank of the loops), ``posture``, ``linearized`` with ``flexible_joint``, and
``visualization``, the data of drawings.
"""
