"""The local Smith form of a polynomial matrix at an irreducible polynomial, with its root polynomials on both sides.

Over the localization of Q[s] at p, pivots of least valuation first, W(s) becomes block diagonal (block LDU): with the pivots of all
smaller exponents in rows I and columns J, those of the exponent k add Phi S^-1 Psi to W(s)^-1,

    Phi = [-W[I, J]^-1 W[I, own columns]; 1],    S^-1 Psi = the own rows of the inverse of W in I and the own rows,

and all of W(s)^-1 is the sum of these. Entries are quotients of minors of W(s), so they never grow beyond those; p^k divides W Phi.
The columns of Phi are the root polynomials of order k of Gohberg, Lancaster and Rodman (Matrix Polynomials, section 1.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import flint

from .cramer import Part, WholeMatrix
from .modular import Pivots, pivots, rooted_primes


@dataclass(frozen=True)
class LocalBlock:
    """All elementary divisors p^k of one exponent k: they add right @ left / (p^k unit) to W(s)^-1.

    Attributes:
        polynomial: p, irreducible, of whole numbers.
        exponent: k.
        right: one root polynomial (a vector of r polynomials) for each of them.
        columns: those of the pivots: there p does not divide the own root polynomial, and the others of the block are zero.
        earlier: the part of W(s) in the pivots of smaller exponents, p^order its share in the determinant.
        upto: the same with the own pivots.
    """

    polynomial: flint.fmpz_poly
    exponent: int
    right: tuple[list[flint.fmpq_poly], ...]
    columns: tuple[int, ...]
    earlier: Part
    upto: Part
    order: int

    @property
    def count(self) -> int:
        """How many elementary divisors p^k there are."""
        return len(self.right)

    @property
    def left(self) -> tuple[list[flint.fmpq_poly], ...]:
        """The row vectors of polynomials that go with the root polynomials."""
        power = self._power(self._order_upto - self.exponent)
        rows = [[entry // power for entry in row] for row in self.upto.left(self.columns)]
        return tuple(_placed(row, self.upto.rows, self.upto.whole.size) for row in rows)

    @property
    def unit(self) -> flint.fmpq_poly:
        """What is left of the determinants of both parts without their powers of p."""
        return (self.earlier.determinant // self._power(self.order)) * (self.upto.determinant // self._power(self._order_upto))

    @property
    def _order_upto(self) -> int:
        return self.order + self.exponent * self.count

    def _power(self, exponent: int) -> flint.fmpq_poly:
        return flint.fmpq_poly(self.polynomial) ** exponent


def local_smith(W: WholeMatrix, p: flint.fmpz_poly, multiplicity: int) -> tuple[LocalBlock, ...]:
    """The blocks by ascending exponents, those of exponent 0 among them.

    Args:
        p: irreducible.
        multiplicity: of p in det W(s).

    The exponents are certain: root polynomials that are independent modulo p are found with exactly these orders, and the
    orders add up to the multiplicity.
    """
    for prime, root in rooted_primes(p):
        found = pivots(W.coefficients, root, prime, multiplicity)
        blocks = None if found is None else _blocks(W, p, found)
        if blocks is not None:
            return blocks
    raise AssertionError("there are infinitely many primes")


def _blocks(W: WholeMatrix, p: flint.fmpz_poly, found: Sequence[Pivots]) -> tuple[LocalBlock, ...] | None:
    """None where the prime number was an unlucky one."""
    blocks, rows, columns, order = [], (), (), 0
    for own in found:
        earlier = W.part(rows, columns)
        right = _root_polynomials(W, flint.fmpq_poly(p), own, earlier, order)
        if right is None:
            return None
        rows, columns = rows + own.rows, columns + own.columns
        blocks.append(LocalBlock(p, own.exponent, right, own.columns, earlier, W.part(rows, columns), order))
        order += own.exponent * len(own.rows)
    return tuple(blocks)


def _root_polynomials(W, p, own: Pivots, earlier: Part, order: int) -> tuple[list, ...] | None:
    """The columns of det(earlier part) Phi / p^order, if p^k divides W times them and they are independent modulo p."""
    power = p**order
    unit = _quotient(earlier.determinant, power)
    if unit is None or not unit % p:
        return None
    found = []
    for column, solution in zip(own.columns, earlier.right(own.columns)):
        entries = [_quotient(-entry, power) for entry in solution]
        if None in entries:
            return None
        vector = _placed([*entries, unit], [*earlier.columns, column], W.size)
        if not _is_root_polynomial(W, vector, p**own.exponent):
            return None
        found.append(vector)
    return tuple(found)


def _is_root_polynomial(W: WholeMatrix, vector, modulus) -> bool:
    """True where p^k divides W(s) times the vector."""
    if modulus.degree() < 1:
        return True
    reduced = [entry % modulus for entry in vector]
    for i in range(W.size):
        row = [flint.fmpq_poly([matrix[i, j] for matrix in W.coefficients]) for j in range(W.size)]
        if sum((a * b for a, b in zip(row, reduced) if a and b), flint.fmpq_poly([0])) % modulus:
            return False
    return True


def _quotient(dividend, divisor) -> flint.fmpq_poly | None:
    """None where something is left over."""
    quotient, rest = divmod(dividend, divisor)
    return None if rest else quotient


def _placed(entries, places, size: int) -> list[flint.fmpq_poly]:
    """A vector with these entries in these places and zeros elsewhere."""
    vector = [flint.fmpq_poly([0])] * size
    for place, entry in zip(places, entries):
        vector[place] = entry
    return vector
