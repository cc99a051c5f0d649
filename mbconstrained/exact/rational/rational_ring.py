"""The polynomials over the rationals for the core of the exact answers: those of FLINT, shown to users as Fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import flint
import numpy as np
from scipy.linalg import block_diag

from ...ground.checks import whole_number
from ...polynomial.jordan_pairs import in_order
from ...polynomial.structure import FiniteZero, polynomial_text
from ..core.jordan_blocks import JordanChain
from .flint_numbers import enclosed_roots, fraction, fractions_of, rounded_roots, working_precision

#: A longer polynomial is not written out in a representation.
LONGEST_TEXT = 60

#: Bits for a decimal digit.
BITS_PER_DIGIT = 3.33

#: The polynomial s.
X = flint.fmpq_poly([0, 1])


class RationalChain(JordanChain):
    """A ``JordanChain`` with its values at the zeros enclosed in balls."""

    def at(self, digits: int = 15) -> tuple[tuple[flint.acb, np.ndarray], ...]:
        """Pairs of a zero and its v_0 ... v_(k-1), shape (k, r), for all zeros of p: balls that contain the true values.

        ``complex`` turns a ball into a number.
        """
        target, precision = flint.arb(10) ** -whole_number(digits, "digits", minimum=1), int(BITS_PER_DIGIT * digits) + 32
        while True:
            values = self._enclosed(precision)
            if all(_is_narrow([root], target) and all(_is_narrow(v, target) for v in vectors) for root, vectors in values):
                return values
            precision *= 2

    def _enclosed(self, precision: int) -> tuple[tuple[flint.acb, np.ndarray], ...]:
        """The vectors of polynomials at every zero."""
        roots = enclosed_roots(self.term.divisor.numer(), precision)
        with working_precision(precision):
            vectors = [[flint.acb_poly(p) for p in vector] for vector in self.right]
            return tuple((z, np.array([[p(z) for p in vector] for vector in vectors], dtype=object)) for z in roots)


def _is_narrow(balls, target: flint.arb) -> bool:
    """True where no radius is above the target, relative to the largest of the numbers."""
    largest = max((abs(ball).abs_lower() for ball in balls), default=flint.arb(0))
    return all(ball.rad() <= target * largest for ball in balls)


class RationalRing:
    """Q[s]: ``fmpq_poly`` for polynomials and arrays of Fractions for matrices."""

    zero, one = flint.fmpq(0), flint.fmpq(1)
    exported, chain = staticmethod(fractions_of), RationalChain

    def polynomial(self, coefficients: Sequence) -> flint.fmpq_poly:
        """The polynomial with these coefficients, the lowest power first."""
        return flint.fmpq_poly(list(coefficients))

    def coefficients(self, p: flint.fmpq_poly, count: int) -> list[flint.fmpq]:
        """The first coefficients, the lowest power first."""
        return [p[k] for k in range(count)]

    def inverse(self, unit: flint.fmpq_poly, modulus: flint.fmpq_poly) -> flint.fmpq_poly:
        """1 / unit modulo a polynomial."""
        _, inverse, _ = (unit % modulus).xgcd(modulus)
        return inverse

    def factors(self, p: flint.fmpq_poly) -> list[tuple[flint.fmpq_poly, int]]:
        """The monic irreducible factors with their multiplicities, low degrees first."""
        monic = [(flint.fmpq_poly(q) / q[q.degree()], multiplicity) for q, multiplicity in p.numer().factor()[1]]
        return sorted(monic, key=lambda factor: (factor[0].degree(), fractions_of(factor[0])))

    def text(self, p: flint.fmpq_poly) -> str:
        """The polynomial in short, for representations."""
        text = polynomial_text(fractions_of(p))
        return text if len(text) <= LONGEST_TEXT else f"degree {p.degree()}"

    def matrix(self, rows: Sequence[Sequence]) -> np.ndarray:
        """The matrix with these rows."""
        entries = [[fraction(entry) for entry in row] for row in rows]
        return np.array(entries, dtype=object).reshape(len(rows), len(rows[0]) if rows else 0)

    def side_by_side(self, matrices: Sequence[np.ndarray]) -> np.ndarray:
        """Matrices side by side."""
        return np.hstack(matrices)

    def below(self, matrices: Sequence[np.ndarray]) -> np.ndarray:
        """Matrices below each other."""
        return np.vstack(matrices)

    def diagonal(self, matrices: Sequence[np.ndarray]) -> np.ndarray:
        """The block diagonal matrix."""
        return block_diag(*matrices) + Fraction(0)

    def finite_zeros(self, divisors) -> tuple[FiniteZero, ...]:
        """The nearest float64 numbers, in the order of the numeric engine."""
        return in_order([FiniteZero(z, m, exponents) for p, m, exponents in divisors for z in rounded_roots(p.numer())])


RATIONALS = RationalRing()
