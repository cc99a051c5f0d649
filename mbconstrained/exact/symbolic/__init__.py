"""The same questions with symbols: masses, stiffnesses and dampings that are positive and otherwise free."""

from .algebra.blocks import Block
from .algebra.chains import Chain
from .algebra.local_smith import LocalSmithForm
from .algebra.matrix import SymbolicPolynomialMatrix
from .algebra.pairs import SymbolicInfinitePair, SymbolicJordanPairs, SymbolicPair
from .algebra.structure import ElementaryDivisor, SymbolicStructure, SymbolicZero
from .response.response import SymbolicResponse, solve_symbolically
from .response.sources import initial_symbols
