"""Mechanical systems with constraint rows: constrained form, motion, reactions, modes."""

from .constraint import Constraint
from .element_matrix import ElementMatrix
from .energy_parts import EnergyParts, EnergyShares
from .modes import Mode, Modes
from .motion import Motion
from .normal_form import NormalForm, mechanical_normal_form
from .system import MechanicalSystem

__all__ = ["Constraint", "ElementMatrix", "EnergyParts", "EnergyShares", "MechanicalSystem", "Mode", "Modes", "Motion", "NormalForm", "mechanical_normal_form"]
