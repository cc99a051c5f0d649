"""The structure of a regular A(s): zeros with multiplicities, and what happens at infinity."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..notices import Notice


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
        """How many roots of det A(s) this entry stands for."""
        return self.multiplicity * (2 if self.value.imag else 1)


@dataclass(frozen=True)
class Structure:
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
        """The zeros whose multiplicities rounding leaves in doubt."""
        return tuple(
            Notice(
                "multiplicity",
                f"zero {zero.value:.6g}: taken as one zero with the partial multiplicities {zero.partial_multiplicities}, but "
                "rounding of the data could make it simpler, or split it",
                doubtful=True,
            )
            for zero in self.finite_zeros
            if not zero.clear
        )
