"""The structure of A(s) over the rationals: nothing is decided by a tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import flint

from ...jordan.zeros import in_order
from ...polynomial.structure import FiniteZero, Structure
from ...response.transfer.rational import shown
from .arithmetic import fractions_of, polynomial
from .local_smith import LocalBlock
from .matrix import RationalMatrix
from .roots import rounded_roots

#: A longer polynomial is not written out where a divisor is shown.
LONGEST_SHOWN = 60


@dataclass(frozen=True, repr=False)
class ElementaryDivisor:
    """The powers of one irreducible polynomial among the elementary divisors of A(s).

    Attributes:
        polynomial: irreducible over the rationals, monic, the lowest power first.
        exponents: ascending; the partial multiplicities of each of its roots.
    """

    polynomial: tuple[Fraction, ...]
    exponents: tuple[int, ...]

    def __repr__(self) -> str:
        """Its polynomial in s with rounded coefficients, or its degree where that is long."""
        text = shown(self.polynomial)
        return f"ElementaryDivisor({text if len(text) <= LONGEST_SHOWN else f'degree {self.degree}'}, exponents {self.exponents})"

    @property
    def degree(self) -> int:
        """Of the polynomial: how many zeros of A(s) it stands for, multiplicities aside."""
        return len(self.polynomial) - 1


@dataclass(frozen=True)
class ExactStructure(Structure):
    """Zeros of A(s), finite and infinite, with the exact polynomials that the finite ones are roots of.

    The values of ``finite_zeros`` are the nearest float64 numbers to the true zeros. No decision is in doubt: ``notices`` is empty.

    Attributes:
        determinant: det A(s), the lowest power first.
        elementary_divisors: by degree, then by coefficients.
        smith_form: the r invariant polynomials, monic, the lowest power first; each divides the next (Moysis et al., Eq. 5).

    >>> import mbconstrained as mb
    >>> structure = mb.PolynomialMatrix([[[0.5, 0], [0, 0.5]], [[0, 1], [0, 0]], [[1, 0], [0, 1]]]).structure(exact=True)
    >>> for divisor in structure.elementary_divisors:
    ...     print(*divisor.polynomial, divisor.exponents)
    1/2 0 1 (2,)
    >>> [len(polynomial) - 1 for polynomial in structure.smith_form], structure.infinite_divisors
    ([0, 4], (0, 0))
    """

    determinant: tuple[Fraction, ...] = field(repr=False)
    elementary_divisors: tuple[ElementaryDivisor, ...]

    @property
    def smith_form(self) -> tuple[tuple[Fraction, ...], ...]:
        """The r invariant polynomials."""
        found = [flint.fmpq_poly([1])] * self.size
        for divisor in self.elementary_divisors:
            for place, exponent in enumerate(reversed(divisor.exponents), start=1):
                found[-place] *= polynomial(divisor.polynomial) ** exponent
        return tuple(fractions_of(p) for p in found)


def irreducible_factors(determinant: flint.fmpq_poly) -> list[tuple[flint.fmpz_poly, int]]:
    """(p, multiplicity) of the irreducible factors, by degree and then by the coefficients of the monic polynomial."""
    _, factors = determinant.numer().factor()
    return sorted(factors, key=lambda factor: (factor[0].degree(), monic(factor[0])))


def monic(p: flint.fmpz_poly) -> tuple[Fraction, ...]:
    """The same roots, the leading coefficient 1."""
    return fractions_of(flint.fmpq_poly(p) / p[p.degree()])


def exact_structure(R: RationalMatrix, factors, local: Sequence, at_infinity: Sequence[LocalBlock]) -> ExactStructure:
    """The structure from the local Smith forms.

    Args:
        factors: the irreducible factors of det A(s) with their multiplicities.
        local: the local Smith forms at these, None where the multiplicity is 1.
        at_infinity: the local Smith form of the dual at s = 0.
    """
    divisors = [ElementaryDivisor(monic(p), _exponents(blocks) if blocks else (1,)) for (p, _), blocks in zip(factors, local)]
    return ExactStructure(
        size=R.size,
        degree=R.degree,
        finite_zeros=_finite_zeros(factors, divisors),
        infinite_divisors=tuple(block.exponent for block in at_infinity for _ in range(block.count)),
        determinant=fractions_of(R.determinant),
        elementary_divisors=tuple(divisors),
    )


def _exponents(blocks: Sequence[LocalBlock]) -> tuple[int, ...]:
    return tuple(block.exponent for block in blocks if block.exponent for _ in range(block.count))


def _finite_zeros(factors, divisors: Sequence[ElementaryDivisor]) -> tuple[FiniteZero, ...]:
    """The roots of the irreducible factors, in the order in which the numeric engine has them."""
    return in_order(
        [
            FiniteZero(value, multiplicity, divisor.exponents)
            for (p, multiplicity), divisor in zip(factors, divisors)
            for value in rounded_roots(p)
        ]
    )
