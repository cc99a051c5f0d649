"""One elementary divisor p^k of A(s), finite or infinite: its part (C, J, B) of A(s)^-1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import gcd, lcm

import flint
import numpy as np

from ...jordan.pairs import InfinitePair
from .arithmetic import fraction, fractions_of
from .chains import Chain
from .local_smith import LocalBlock

#: Root polynomials of so few coefficients are divided by one of their entries, so that chains are as simple as they can be:
#: v_0 without a polynomial in z in this place, the other vectors with a zero there. In long ones this would multiply the digits.
SHORT = 8


@dataclass(frozen=True)
class ExactBlock:
    """One elementary divisor p^k: C (s I - J)^-1 B is its part of A(s)^-1.

    J is the hypercompanion matrix of p^k: ones above the diagonal, and k times the negative coefficients of p in the last rows of
    blocks of deg p rows. For a rational zero it is the Jordan block itself, and the columns of C are its chain.

    Attributes:
        p: irreducible, of whole numbers.  exponent: k.
        right: the root polynomial of order k modulo p^k, r polynomials.
        source: gives r polynomials and their common denominator; with it right @ left / (p^k denominator),
            p monic, is the part of A(s)^-1.
    """

    p: flint.fmpz_poly
    exponent: int
    right: tuple[flint.fmpq_poly, ...]
    source: object = field(repr=False)

    @property
    def degree(self) -> int:
        """Of p."""
        return self.p.degree()

    @cached_property
    def C(self) -> np.ndarray:
        """Shape (r, k deg p): the digits of the root polynomial to the base p, each by its coefficients; whole numbers."""
        return digits_of(self.right, self._base, self.exponent)

    @cached_property
    def J(self) -> np.ndarray:
        """Shape (k deg p, k deg p)."""
        return hypercompanion(self.p, self.exponent)

    @cached_property
    def B(self) -> np.ndarray:
        """Shape (k deg p, r). Its entries have up to 2 deg(p^k) times as many digits as the coefficients of det A(s)."""
        left, unit = self.source()
        modulus = self._base**self.exponent
        inverse = inverse_modulo(unit, modulus)
        columns = [self._moments(entry * inverse % modulus) for entry in left]
        return np.array(columns, dtype=object).T

    @cached_property
    def chain(self) -> Chain:
        """v_j = the j-th derivative of the root polynomial over j!, modulo p."""
        derivatives, vectors = list(self.right), []
        for order in range(self.exponent):
            vectors.append(np.array([_padded(entry % self._base, self.degree) for entry in derivatives], dtype=object))
            derivatives = [entry.derivative() / (order + 1) for entry in derivatives]
        return Chain(fractions_of(self._base), tuple(vectors))

    @property
    def _base(self) -> flint.fmpq_poly:
        """p, monic."""
        return flint.fmpq_poly(self.p) / self.p[self.degree]

    def _moments(self, entry: flint.fmpq_poly) -> list[Fraction]:
        """The pairing with the basis p^i s^j: the coefficient of s^(-1-j) in entry / p^(k-i), p monic."""
        found = []
        for i in range(self.exponent):
            modulus = self._base ** (self.exponent - i)
            quotient = (entry % modulus).left_shift(self.degree) // modulus
            found += _padded(quotient, self.degree)[::-1]
        return found


def hypercompanion(p: flint.fmpz_poly, exponent: int) -> np.ndarray:
    """Multiplication by s modulo p^k, shape (k deg p, k deg p), Fractions (Jacobson).

    >>> hypercompanion(flint.fmpz_poly([5, 1]), 2).astype(int).tolist()
    [[-5, 1], [0, -5]]
    """
    degree = p.degree()
    J = np.full((exponent * degree,) * 2, Fraction(0), dtype=object)
    for i in range(len(J) - 1):
        J[i, i + 1] = Fraction(1)
    for last in range(degree - 1, len(J), degree):
        for k in range(degree):
            J[last, last - degree + 1 + k] += -fraction(flint.fmpq(p[k], p[degree]))
    return J


def finite_block(block: LocalBlock, index: int, factors) -> ExactBlock:
    """Of one of the elementary divisors of a local block.

    Args:
        factors: of the rows, W(s) = diag(factors) A(s).
    """
    p, k = block.polynomial, block.exponent
    base = flint.fmpq_poly(p) / p[p.degree()]
    right, scale = _simple(block, index, base**k)
    content = _content(digits_of(right, base, k))

    def source():
        left = [entry * factor * content for entry, factor in zip(block.left[index], factors)]
        return left, block.unit * scale * p[p.degree()] ** k

    return ExactBlock(p, k, tuple(entry / content for entry in right), source)


def infinite_block(block: LocalBlock, index: int, degree: int, factors) -> InfinitePair:
    """The first mu - q + 1 vectors of a chain of the dual at 0, of the order mu >= q, and the rows that go with them."""
    length = block.exponent - degree + 1
    right, scale = _simple(block, index, flint.fmpq_poly([0] * length + [1]))
    C = np.array([_padded(entry, length) for entry in right], dtype=object)
    content = _content(C)
    inverse = inverse_modulo(block.unit * scale, flint.fmpq_poly([0] * length + [1])) * content
    left = [(entry.truncate(length) * inverse * factor).truncate(length) for entry, factor in zip(block.left[index], factors)]
    B = np.array([_padded(entry, length)[::-1] for entry in left], dtype=object).T
    return InfinitePair(C / fraction(content), hypercompanion(flint.fmpz_poly([0, 1]), length), B)


def _simple(block: LocalBlock, index: int, modulus: flint.fmpq_poly) -> tuple[list[flint.fmpq_poly], flint.fmpq_poly]:
    """A root polynomial up to the modulus, as simple as it can be where it is short; and what it was multiplied by."""
    scale = flint.fmpq_poly([1])
    if modulus.degree() <= SHORT:
        scale = inverse_modulo(block.right[index][block.columns[index]], modulus)
    return [entry * scale % modulus for entry in block.right[index]], scale


def digits_of(vector: Sequence[flint.fmpq_poly], base: flint.fmpq_poly, count: int) -> np.ndarray:
    """The coefficients of the digits to the base p, shape (r, count deg p)."""
    rows = []
    for entry in vector:
        row = []
        for _ in range(count):
            entry, digit = divmod(entry, base)
            row += _padded(digit, base.degree())
        rows.append(row)
    return np.array(rows, dtype=object)


def _content(numbers: np.ndarray) -> flint.fmpq:
    """By what they are divided to become whole numbers without a common divisor, the first one of the first column positive."""
    given = [number for number in numbers.T.flat if number]
    denominator = lcm(*(number.denominator for number in given))
    divisor = gcd(*(int(number * denominator) for number in given))
    return flint.fmpq(divisor if given[0] > 0 else -divisor, denominator)


def joined(matrices) -> np.ndarray:
    """Block diagonal, Fractions."""
    total = sum(len(matrix) for matrix in matrices)
    found, place = np.full((total, total), Fraction(0), dtype=object), 0
    for matrix in matrices:
        found[place : place + len(matrix), place : place + len(matrix)] = matrix
        place += len(matrix)
    return found


def inverse_modulo(unit: flint.fmpq_poly, modulus: flint.fmpq_poly) -> flint.fmpq_poly:
    """The inverse of a polynomial that has no divisor in common with the modulus."""
    _, inverse, _ = (unit % modulus).xgcd(modulus)
    return inverse


def _padded(p: flint.fmpq_poly, length: int) -> list[Fraction]:
    """So many coefficients, the lowest power first."""
    return [fraction(p[k]) for k in range(length)]
