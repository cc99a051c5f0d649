"""A(s) -> the finite pair (C, J, B) and the infinite pair (C, J, B), with their evidence."""

from .pairs import FinitePair, InfinitePair, JordanPairs

__all__ = ["FinitePair", "InfinitePair", "JordanPairs"]
