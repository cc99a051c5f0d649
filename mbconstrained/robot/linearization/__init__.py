"""Linearized robots: ``linearized`` has their equations of motion, from ``stiffness`` and ``inertia``; ``robot_parameters`` their derivatives."""
