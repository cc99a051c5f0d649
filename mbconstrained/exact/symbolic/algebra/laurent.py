"""Laurent coefficients at infinity by long division: H_i of A(s)^-1 = adj A / det A, and those of one quotient."""

from __future__ import annotations

import numbers
from collections import deque
from collections.abc import Iterator
from itertools import count
from typing import TYPE_CHECKING

import sympy
from sympy.polys.matrices import DomainMatrix

from ....errors import InputError
from ..field.fields import expression_of

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


def series_at_infinity(numerator: sympy.Poly, denominator: sympy.Poly, lowest: int) -> dict[int, object]:
    """{i: h_i} with numerator / denominator = sum of h_i s^i near infinity, i >= lowest, elements of the field."""
    highest = numerator.degree() - denominator.degree() if numerator else lowest - 1
    powers = range(highest, lowest - 1, -1)
    return dict(zip(powers, _quotients(numerator, denominator, highest), strict=False))


def _quotients(numerator: sympy.Poly, denominator: sympy.Poly, highest: int) -> Iterator:
    """h_i of numerator / denominator from i = highest down, h_i = 0 above: d_n h_i = b_(n+i) - sum over j < n of d_j h_(n+i-j)."""
    leading, *lower = denominator.rep.to_list()
    above, zero, scale = numerator.rep.to_dict(), denominator.domain.zero, denominator.domain.one / leading
    known = deque([zero] * len(lower), maxlen=len(lower))  # h_(i+1), h_(i+2), ...
    for power in count(highest, -1):
        total = above.get((power + len(lower),), zero)
        found = sum((-d * h for d, h in zip(lower, known) if d and h), total) * scale
        known.appendleft(found)
        yield found


class Laurent:
    """A(s)^-1 = sum over i <= highest of H_i s^i near infinity (Moysis et al., Eq. 18), by long division.

    Coefficients are computed from the highest down and kept.
    """

    def __init__(self, A: SymbolicPolynomialMatrix):
        self.field, self.shape, below = A.field, (A.size, A.size), A.determinant
        self.highest = max(entry.degree() for row in A.adjugate for entry in row if not entry.is_zero) - below.degree()
        self._entries = [_quotients(entry, below, self.highest) for row in A.adjugate for entry in row]
        self._known: list[DomainMatrix] = []

    def __repr__(self) -> str:
        return f"Laurent(size={self.shape[0]}, highest={self.highest})"

    def __call__(self, index: int) -> sympy.ImmutableMatrix:
        """H_i.

        Raises:
            InputError: the index is not a whole number.
        """
        if isinstance(index, bool) or not isinstance(index, numbers.Integral):
            raise InputError(f"index: found {index!r}; expected a whole number")
        rows = self.elements(int(index)).to_list()
        return sympy.ImmutableMatrix([[expression_of(self.field, entry) for entry in row] for row in rows])

    def elements(self, index: int) -> DomainMatrix:
        """H_i as a matrix over the field."""
        if index > self.highest:
            return DomainMatrix.zeros(self.shape, self.field).to_dense()
        while len(self._known) <= self.highest - index:
            entries, size = [next(entry) for entry in self._entries], self.shape[0]
            self._known.append(DomainMatrix([entries[i : i + size] for i in range(0, size**2, size)], self.shape, self.field))
        return self._known[self.highest - index]


def jump_projector(A: SymbolicPolynomialMatrix, laurent: Laurent) -> sympy.ImmutableMatrix:
    """P of a free motion: the values at 0+ are P times those at 0- (Moysis et al., Eq. 98), shape (q r, q r).

    col(C, CJ, ..., CJ^(q-1)) [J^(q-1)B ... B] has the blocks H_(c-a-q), whatever the pair, and M1 has A_(q-c+b) at (c, b), c >= b.
    """
    q, total = A.degree, sympy.zeros(A.size * A.degree, A.size * A.degree)
    coefficients = [DomainMatrix(rows, laurent.shape, A.field) for rows in A.elements]
    for a in range(q):
        for b in range(q):
            block = DomainMatrix.zeros(laurent.shape, A.field).to_dense()
            for c in range(b, q):
                block += laurent.elements(c - a - q) * coefficients[q - c + b]
            total[a * A.size, b * A.size] = sympy.Matrix([[A.expression(entry) for entry in row] for row in block.to_list()])
    return total.as_immutable()
