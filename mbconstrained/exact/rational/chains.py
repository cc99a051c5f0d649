"""Jordan chains of A(s) for all roots of an irreducible polynomial at once."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import flint
import numpy as np

from ...checks import whole_number
from .arithmetic import polynomial, working_precision
from .roots import enclosed_roots

#: Bits for a decimal digit.
BITS_PER_DIGIT = 3.33


@dataclass(frozen=True)
class Chain:
    """A Jordan chain of A(s) for every root z of an irreducible polynomial at once.

    A(s) (v_0 + v_1 (s - z) + ... + v_(k-1) (s - z)^(k-1)) = O((s - z)^k), v_0 not zero (Moysis et al., Eqs. 19-20).

    Attributes:
        polynomial: irreducible, monic, the lowest power first.
        vectors: v_0 ... v_(k-1) as polynomials in z, each of shape (r, degree): column j multiplies z^j.
    """

    polynomial: tuple[Fraction, ...]
    vectors: tuple[np.ndarray, ...]

    @property
    def length(self) -> int:
        """k."""
        return len(self.vectors)

    def at(self, digits: int = 15) -> tuple[tuple[flint.acb, np.ndarray], ...]:
        """Pairs of a root and its v_0 ... v_(k-1), shape (k, r), for all roots: balls that hold the true values.

        Args:
            digits: the radii are below 10^-digits of the root, and of the largest entry of each vector.

        A ball turns into a number by ``complex``.
        """
        target, precision = flint.arb(10) ** -whole_number(digits, "digits", minimum=1), int(BITS_PER_DIGIT * digits) + 32
        p = polynomial(self.polynomial).numer()
        rows = [[polynomial(row) for row in vector] for vector in self.vectors]
        while True:
            found = _evaluated(rows, enclosed_roots(p, precision), precision)
            if all(_is_narrow([root], target) and all(_is_narrow(v, target) for v in vectors) for root, vectors in found):
                return found
            precision *= 2


def _evaluated(rows, roots, precision: int) -> tuple[tuple[flint.acb, np.ndarray], ...]:
    """The vectors of polynomials at every root."""
    with working_precision(precision):
        polynomials = [[flint.acb_poly(p) for p in vector] for vector in rows]
        return tuple((root, np.array([[p(root) for p in vector] for vector in polynomials], dtype=object)) for root in roots)


def _is_narrow(balls, target: flint.arb) -> bool:
    """True where no radius is above the target, relative to the largest of the numbers."""
    largest = max((abs(ball).abs_lower() for ball in balls), default=flint.arb(0))
    return all(ball.rad() <= target * largest for ball in balls)
