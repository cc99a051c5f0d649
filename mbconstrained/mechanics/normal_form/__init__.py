"""First-order state-space systems turned into second-order, mechanical ones (Mayet and Kammermeier, corrected)."""

from .form import NormalForm
from .transformation import mechanical_normal_form

__all__ = ["NormalForm", "mechanical_normal_form"]
