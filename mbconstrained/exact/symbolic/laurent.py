"""The Laurent coefficients H_i of A(s)^-1 at infinity, by long division of adj A by det A."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy
from sympy.polys.matrices import DomainMatrix

from ...errors import InputError
from .fields import expression_of

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


class Laurent:
    """A(s)^-1 = sum over i <= highest of H_i s^i near infinity (Moysis et al., Eq. 18).

    With det A = sum of d_j s^j of degree n and adj A = sum of N_t s^t, d_n H_(t-n) = N_t - sum over j < n of d_j H_(t-j).
    Coefficients are computed from the highest down and kept.
    """

    def __init__(self, A: SymbolicPolynomialMatrix):
        self.field, self.shape = A.field, (A.size, A.size)
        *self._lower, leading = A.determinant.rep.to_list()[::-1]
        self._scale = A.field.one / leading
        self._numerators = [[entry.rep.to_dict() for entry in row] for row in A.adjugate]
        self.highest = max(power for row in self._numerators for entry in row for (power,) in entry or {(0,)}) - len(self._lower)
        self._known: list[DomainMatrix] = []

    def __call__(self, index: int) -> sympy.ImmutableMatrix:
        """H_i.

        Raises:
            InputError: the index is not a whole number.
        """
        if isinstance(index, bool) or not isinstance(index, (int, sympy.Integer)):
            raise InputError(f"index: found {index!r}; expected a whole number")
        rows = self.elements(int(index)).to_list()
        return sympy.ImmutableMatrix([[expression_of(self.field, entry) for entry in row] for row in rows])

    def elements(self, index: int) -> DomainMatrix:
        """H_i as a matrix over the field."""
        if index > self.highest:
            return DomainMatrix.zeros(self.shape, self.field).to_dense()
        while len(self._known) <= self.highest - index:
            self._known.append(self._next(self.highest - len(self._known)))
        return self._known[self.highest - index]

    def _next(self, index: int) -> DomainMatrix:
        n = len(self._lower)
        zero = self.field.zero
        total = DomainMatrix([[entry.get((index + n,), zero) for entry in row] for row in self._numerators], self.shape, self.field)
        for j, d in enumerate(self._lower):
            if d and index + n - j <= self.highest:
                total -= self.elements(index + n - j) * d
        return total * self._scale


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
