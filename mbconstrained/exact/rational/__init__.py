"""The same questions over the rationals: floats are the exact numbers that they are, and nothing is rounded."""

from .blocks import ExactBlock
from .chains import Chain
from .matrix import RationalMatrix
from .pairs import ExactFinitePair, ExactJordanPairs, exact_jordan_pairs
from .singular import regular, regular_matrix
from .structure import ElementaryDivisor, ExactStructure
