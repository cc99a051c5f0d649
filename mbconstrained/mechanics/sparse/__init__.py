"""Large sparse systems: modes of lowest frequency by shift-invert, and the response in them with a bound on the rest."""

from .modes import SparseModes
from .motion import SparseMotion
from .system import SparseSystem

__all__ = ["SparseModes", "SparseMotion", "SparseSystem"]
