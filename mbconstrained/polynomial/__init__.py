"""Polynomial matrices A(s) = A_0 + A_1 s + ... + A_q s^q: evaluation, companion pencil, structure."""

from .matrix import PolynomialMatrix

__all__ = ["PolynomialMatrix"]
