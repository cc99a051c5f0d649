"""The same questions with symbols: masses, stiffnesses and dampings that are positive and otherwise free."""

from .blocks import Block
from .chains import Chain
from .local_smith import LocalSmithForm
from .matrix import SymbolicPolynomialMatrix
from .pairs import SymbolicInfinitePair, SymbolicJordanPairs, SymbolicPair
from .response import SymbolicResponse, initial_symbols, solve_symbolically
from .structure import ElementaryDivisor, SymbolicStructure, SymbolicZero
