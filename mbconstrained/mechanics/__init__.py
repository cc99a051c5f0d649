"""Mechanical systems with constraint rows: constrained form, motion, reactions, modes."""

from .constraint import Constraint
from .element_matrix import ElementMatrix
from .modes import Mode, Modes
from .motion import Motion
from .system import MechanicalSystem

__all__ = ["Constraint", "ElementMatrix", "MechanicalSystem", "Mode", "Modes", "Motion"]
