"""Robots: URDF trees with loops and springs, at rest and linearized. The only place that imports pinocchio."""

from .connections import BodySpring, Bushing, Loop
from .flexible_joint import FlexibleJoint
from .linearized import LinearizedRobot
from .point_motion import PointMotion
from .posture import Posture
from .robot import Robot

__all__ = ["BodySpring", "Bushing", "FlexibleJoint", "LinearizedRobot", "Loop", "PointMotion", "Posture", "Robot"]
