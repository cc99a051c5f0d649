"""The same questions with symbols: masses, stiffnesses and dampings that are positive and otherwise free."""

from .blocks import Block
from .chains import Chain
from .local_smith import LocalSmithForm
from .matrix import SymbolicPolynomialMatrix
from .pairs import SymbolicInfinitePair, SymbolicJordanPairs, SymbolicPair
from .response import SymbolicResponse, solve_symbolically
from .sources import initial_symbols
from .structure import ElementaryDivisor, SymbolicStructure, SymbolicZero
