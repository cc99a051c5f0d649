"""Mechanical systems with constraint rows: constrained form, motion, reactions, modes."""

from .constraint import Constraint
from .modes import Mode, Modes
from .motion import Motion
from .system import MechanicalSystem

__all__ = ["Constraint", "MechanicalSystem", "Mode", "Modes", "Motion"]
