"""The structure of a regular A(s): zeros with multiplicities, finite and at infinity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Rational

import numpy as np

from ..ground.checks import counted
from ..ground.display import Displayed, TextTable
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, NOISE_SAFETY
from ..linalg.staircase import GENERIC
from .coefficients import PolynomialCoefficients
from .decoupling import scaled_companion


@dataclass(frozen=True)
class FiniteZero:
    """A zero of A(s), that is a root of det A(s).

    Attributes:
        value: the zero in 1/s; of a complex pair the one above the real axis stands for both.
        multiplicity: its multiplicity as a root of det A(s) (that of each of the two, for a pair).
        partial_multiplicities: the degrees of its elementary divisors (s - value)^k, ascending; they add up to the
            multiplicity. Two uncoupled oscillators that are alike have (1, 1), critical damping has (2,).
        clear: False where rounding leaves the multiplicities in doubt.
    """

    value: complex
    multiplicity: int
    partial_multiplicities: tuple[int, ...] = field(default=(), compare=False)
    clear: bool = field(default=True, compare=False)

    @property
    def count(self) -> int:
        """Number of roots of det A(s) for this entry."""
        return self.multiplicity * (2 if self.value.imag else 1)


@dataclass(frozen=True, repr=False)
class Structure(Displayed):
    """Zeros of A(s), finite and infinite (Moysis et al., Eqs. 5-15, with u counting q_i > 0 only).

    Attributes:
        size, degree: r and the declared q.
        finite_zeros: the zeros with multiplicities, ascending by modulus; where moduli agree to rounding, by the real
            part, then by the imaginary part.
        infinite_divisors: degrees mu_1 <= ... <= mu_r of the infinite elementary divisors (zeros included).
    """

    size: int
    degree: int
    finite_zeros: tuple[FiniteZero, ...]
    infinite_divisors: tuple[int, ...]

    def _summary(self) -> str:
        infinite = [degree for degree in self.infinite_divisors if degree]
        at_infinity = f", infinite elementary divisors of degrees {', '.join(map(str, infinite))}" if infinite else ""
        return f"size {self.size}, degree {self.degree}, {counted(self.finite_count, 'finite zero')}{at_infinity}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((str(zero.value), str(zero.multiplicity), str(zero.partial_multiplicities)) for zero in self.finite_zeros)
        return (TextTable("Finite zeros", ("zero (1/s)", "multiplicity", "partial multiplicities"), tuple(rows)),)

    @property
    def finite_count(self) -> int:
        """n = deg det A(s)."""
        return self.size * self.degree - sum(self.infinite_divisors)

    @property
    def at_infinity(self) -> tuple[int, ...]:
        """q_1 >= ... >= q_r of the Smith form at infinity diag(s^q_i); a negative q_i is an infinite zero (Eq. 14)."""
        return tuple(self.degree - degree for degree in self.infinite_divisors)

    @property
    def highest_impulse(self) -> int:
        """q_hat_r, the highest order of an infinite zero (0 when there is none): impulses have lower orders."""
        return max([0, *(-order for order in self.at_infinity)])

    @property
    def infinite_chains(self) -> tuple[int, ...]:
        """Chain lengths of the minimal infinite pair: |q_i| + 1 for every q_i <= 0 (Eqs. 23-24, corrected)."""
        return tuple(1 - order for order in self.at_infinity if order <= 0)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on zeros whose multiplicities are uncertain by rounding errors."""
        return tuple(
            Notice(
                NoticeKind.RANK,
                f"zero {zero.value:.6g}: taken as one zero with the partial multiplicities {zero.partial_multiplicities}, but "
                "rounding of the data could make it simpler, or split it",
                doubtful=True,
            )
            for zero in self.finite_zeros
            if not zero.clear
        )


# Which equations and coordinates make a polynomial matrix singular.


def singular_message(A: PolynomialCoefficients) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """A sentence on why det A(s) = 0 for every s, with the indices of the equations and coordinates involved."""
    scaled = scaled_companion(A).coefficients
    involved_rows, involved_columns = np.zeros(A.size, bool), np.zeros(A.size, bool)
    for s in GENERIC:
        value = sum(matrix * s**power for power, matrix in enumerate(scaled))
        u, sizes, vh = np.linalg.svd(value)
        null = sizes <= NOISE_SAFETY * EPS * A.size * max(sizes[0], EPS)
        null[-1] = True  # singular at every s: the least one belongs to it
        involved_rows |= _support(u[:, null])
        involved_columns |= _support(vh[null].conj().T)
    equations, coordinates = (tuple(map(int, np.flatnonzero(side))) for side in (involved_rows, involved_columns))
    return singular_sentence([A.equations[i] for i in equations], [A.coordinates[i] for i in coordinates]), equations, coordinates


def singular_sentence(equations: Sequence[str], coordinates: Sequence[str]) -> str:
    """Text on dependent equations and free coordinates, with a remedy."""
    rows, columns = (", ".join(f'"{name}"' for name in names) for names in (equations, coordinates))
    return (
        f"det A(s) is zero for every s, the motion is not determined: the equations {rows} are dependent or empty, "
        f"and the coordinates {columns} can move without any force. Attach what is free (by a mass, spring, damper or "
        "constraint; in a state space by an equation), or remove redundant equations."
    )


def _support(vectors) -> np.ndarray:
    size = np.abs(vectors).max(axis=1, initial=0.0)
    return size > EPS**0.5 * size.max(initial=0.0)


def polynomial_text(coefficients: Sequence[Rational]) -> str:
    """A polynomial in s as text, with six digits."""
    text = ""
    for power, c in reversed(list(enumerate(coefficients))):
        if c:
            sign = (" - " if c < 0 else " + ") if text else "-" * (c < 0)
            size = f"{float(abs(c)):.6g}" if abs(c) != 1 or not power else ""
            variable = "s" * (power > 0) + f"^{power}" * (power > 1)
            text += sign + " ".join(filter(None, (size, variable)))
    return text or "0"
