"""Fractions of polynomials: b(s)/a(s) with exact coefficients, D(s)^-1 N(s) of several inputs and outputs, and both as problems of ``mb.solve``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache
from numbers import Rational, Real

import numpy as np

from ..ground.checks import counted, real_array
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import polynomial_text
from ..response.problem import FORCE_FUNCTIONS
from ..response.response import Response
from ..response.solve import solve
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import power, zero

EXPECTED = "expected its coefficients as a list of real numbers, the highest power first, e.g. [1.0, 3.0, 2.0]"


@dataclass(frozen=True)
class RationalFunction:
    """b(s)/a(s) with exact coefficients, lowest power first."""

    numerator: Polynomial  # numerator, denominator: b and a as given, without zeros at the highest powers; b empty where it is zero
    denominator: Polynomial
    left_out: tuple[int, int] = (0, 0)  # number of leading zeros removed from both
    rounded: bool = False  # whether some coefficient was given in float64, known up to its rounding error; other numbers are exact

    @cached_property
    def as_written(self) -> RationalFunction:
        """The fraction with the shortest decimals that round to the floats: 0.1 as 1/10."""
        if not self.rounded:
            return self
        numerator, denominator = (tuple(map(_as_written, p)) for p in (self.numerator, self.denominator))
        return RationalFunction(numerator, denominator, self.left_out, True)

    @cached_property
    def common_factor(self) -> Polynomial:
        """The exact common factor of b and a: of the floats as binary numbers, or else of their decimals."""
        return self._common_factor if len(self._common_factor) > 1 else self.as_written._common_factor

    @cached_property
    def reduced(self) -> RationalFunction:
        """The fraction without its common factor."""
        from ..exact.rational import fractions_of, polynomial

        if len(self.common_factor) == 1:
            return self
        exact = self if len(self._common_factor) > 1 else self.as_written
        factor = polynomial(self.common_factor)
        b, a = (fractions_of(polynomial(p) // factor) for p in (exact.numerator, exact.denominator))
        return RationalFunction(b, a, (0, 0), self.rounded)

    @cached_property
    def written_reduced(self) -> RationalFunction:
        """The fraction without its common factor, with the shortest decimals."""
        return self.reduced if len(self.common_factor) > 1 else self.as_written

    @cached_property
    def zero_poles(self) -> int:
        """n0, the order of the pole of 1/a(s) at s = 0 (Hauksdottir and Sigurdsson, Eq. 34)."""
        return next(k for k, c in enumerate(self.denominator) if c)

    def without_zero_poles(self, gamma: int) -> tuple[RationalFunction, int]:
        """The fraction without zeros and poles at s = 0, and the input I_gamma that has them (Eq. 34).

        >>> reduced, gamma = rational_function([1, 0], [1, 2, 0, 0]).without_zero_poles(-1)  # s / (s^2 (s + 2)) and delta'
        >>> [int(c) for c in reduced.denominator], gamma
        ([2, 1], 0)
        """
        zeros = next((k for k, c in enumerate(self.numerator) if c), 0)
        reduced = RationalFunction(self.numerator[zeros:], self.denominator[self.zero_poles :], rounded=self.rounded)
        return reduced, gamma + self.zero_poles - zeros

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Given coefficients without influence on the response."""
        notices = [
            Notice(NoticeKind.OMITTED, f"{name}: {counted(count, 'leading zero')} left out")
            for name, count in zip(("numerator", "denominator"), self.left_out)
            if count
        ]
        if len(self.common_factor) > 1:
            text = "numerator and denominator have the common factor"
            notices.append(
                Notice(NoticeKind.OMITTED, f"{text} {polynomial_text(self.common_factor)}: it does not act on a response from rest")
            )
        return tuple(notices)

    @cached_property
    def _common_factor(self) -> Polynomial:
        from ..exact.rational import fractions_of, polynomial

        return fractions_of(polynomial(self.numerator).gcd(polynomial(self.denominator))) if self.numerator else ONE


def rational_function(numerator, denominator) -> RationalFunction:
    """Read b and a.

    >>> fraction = rational_function([0, 1, 1], [1.0, 3.0, 2.0])
    >>> fraction.left_out, [int(c) for c in fraction.common_factor], [int(c) for c in fraction.reduced.denominator]
    ((1, 0), [1, 1], [2, 1])
    """
    read = [_coefficients(value, what) for value, what in ((numerator, "numerator"), (denominator, "denominator"))]
    b, a = (trimmed(coefficients[::-1]) for coefficients, _ in read)
    if not a:
        raise InputError("denominator: every coefficient is zero; a transfer function needs a denominator other than zero")
    left_out = tuple(len(coefficients) - max(len(kept), 1) for (coefficients, _), kept in zip(read, (b, a)))
    return RationalFunction(b, a, left_out, any(rounded for _, rounded in read))


def _coefficients(value, what: str) -> tuple[list[Fraction], bool]:
    """The coefficients as Fractions, and whether some are floats other than whole numbers."""
    items = [value] if isinstance(value, (Real, Decimal)) or (np.ndim(value) == 0 and isinstance(value, np.ndarray)) else value
    if isinstance(items, (str, bytes, dict)) or not isinstance(items, Iterable):
        raise InputError(f"{what}: found {_short(value)}; {EXPECTED}")
    numbers = [_number(item, what, place) for place, item in enumerate(items)]
    if not numbers:
        raise InputError(f"{what}: found no coefficient; {EXPECTED}")
    return numbers, any(
        not isinstance(item, (Rational, Decimal, np.integer)) and c.denominator > 1 for item, c in zip(items, numbers)
    )


def _number(item, what: str, place: int) -> Fraction:
    if isinstance(item, np.ndarray) and item.ndim == 0:
        item = item.item()
    if isinstance(item, (bool, np.bool_)) or not isinstance(item, (Real, Decimal)):
        several = isinstance(item, (Iterable, np.ndarray)) and not isinstance(item, str)
        remedy = "; of several inputs or outputs use mb.matrix_fraction_response" if several else ""
        raise InputError(f"{what}: the coefficient at {place} is {_short(item)}; {EXPECTED}{remedy}")
    try:
        number = (
            Fraction(int(item.numerator), int(item.denominator))
            if isinstance(item, Rational)
            else Fraction(item if isinstance(item, Decimal) else float(item))
        )
        lost = bool(number) and float(number) == 0.0
    except (ValueError, OverflowError):
        raise InputError(
            f"{what}: the coefficient at {place} is {_short(item)}; expected a finite number in the range of float64"
        ) from None
    if lost:
        raise InputError(f"{what}: the coefficient at {place} lies below the range of float64; choose another unit of time")
    return number


def _as_written(number: Fraction) -> Fraction:
    value = float(number)
    return Fraction(repr(value)) if Fraction(value) == number else number


def _short(value) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


# Polynomials in one variable over the rationals: tuples of Fractions, lowest power first, without zeros at the end; the zero polynomial
# is empty. FLINT computes with them: the common factor of degree 3 of two polynomials of degree 63 takes 0.3 ms, where Euclid's
# algorithm on Fractions takes 0.7 s.

Polynomial = tuple[Fraction, ...]

ONE: Polynomial = (Fraction(1),)


def trimmed(coefficients: Sequence[Fraction]) -> Polynomial:
    """The polynomial without zeros at the highest powers."""
    count = max((k + 1 for k, c in enumerate(coefficients) if c), default=0)
    return tuple(coefficients[:count])


# Fractions of polynomial matrices, of several inputs and outputs.


def matrix_fraction_response(numerator, denominator, input: ImpulsiveSmooth) -> Response:
    """Solve D(d/dt) y = N(d/dt) u from rest, transfer matrix D(s)^-1 N(s), by the Jordan pairs of D(s).

    D and N may have any degrees and common left factors, the leading coefficient of D may be singular: poles of
    D(s)^-1 N(s) at infinity are Dirac impulses. A common left factor with zeros in the right half plane is not
    removed, as that of a scalar transfer function is: its rounding error grows, which ``error_estimate`` reports.

    Args:
        numerator: N_0, N_1, ..., ascending powers, each of shape (r, p).
        denominator: D_0, D_1, ..., ascending powers, each of shape (r, r); or a ``PolynomialMatrix``.
        input: u with p rows, see ``mbconstrained.signals``.

    Returns:
        y, r rows.

    Raises:
        InputError: shapes that do not fit, values that are not finite, an input that is none.
        SingularPolynomialMatrix: det D(s) = 0 for every s.

    >>> from mbconstrained import step
    >>> y = matrix_fraction_response([[[1.0], [4.0]]], [np.diag([1.0, 2.0]), np.eye(2)], step([1.0]))
    >>> bool(np.allclose(y(1.0), [1 - np.exp(-1), 2 - 2 * np.exp(-2)]))  # 1 / (s + 1) and 4 / (s + 2)
    True
    """
    D = denominator if isinstance(denominator, PolynomialMatrix) else PolynomialMatrix(denominator)
    N = _checked_numerator(numerator, D.size)
    return solve(D, force=operated(N, checked_input(input, N[0].shape[1], "input")))


def _checked_numerator(numerator, rows: int) -> list[np.ndarray]:
    if not isinstance(numerator, Iterable):
        raise InputError(f"numerator: found {numerator!r}; expected a list of matrices [N_0, N_1, ...]")
    matrices = [real_array(matrix, f"N_{index}", shape=(rows, None)) for index, matrix in enumerate(numerator)]
    if not matrices:
        raise InputError("numerator: it needs at least one coefficient, N_0; none was given")
    for index, N in enumerate(matrices):
        if N.shape != matrices[0].shape:
            raise InputError(f"N_{index} has shape {N.shape}, but N_0 has {matrices[0].shape}; all must agree")
    return matrices


# Transfer functions as problems of ``mb.solve``: a(s) as a polynomial matrix of size one, b(d/dt) u as its force.

#: Up to this order a(s) is decoupled with more digits than float64: it takes some tenths of a second at most.
PRECISE_ORDER = 24

#: So many float64 numbers, each what the ones before it leave, add up to an exact coefficient, to 1e-64 of it.
PARTS = 4


@lru_cache(maxsize=64)
def scalar_matrix(denominator: Polynomial, rounded: bool = True) -> PolynomialMatrix:
    """a(s), exact where its order allows, computed once for all inputs, with its zeros."""
    values = np.array([float(c) for c in denominator])[:, None, None]
    exact = len(denominator) - 1 <= PRECISE_ORDER
    coefficients = [_exactly(c) for c in denominator] if exact else values
    return PolynomialMatrix(coefficients, ["y"], ["a(d/dt) y = b(d/dt) u"], EPS * np.abs(values) if rounded else None)


def _exactly(coefficient: Fraction) -> Factors:
    parts = []
    while coefficient and len(parts) < PARTS:
        parts.append(float(coefficient))
        coefficient -= Fraction(parts[-1])
    return Factors(np.ones((1, len(parts))), np.array(parts), np.ones((len(parts), 1)))


def scalar_force(numerator: Polynomial, u: int | ImpulsiveSmooth) -> ImpulsiveSmooth:
    """The excitation b(d/dt) u of one equation."""
    if isinstance(u, ImpulsiveSmooth):
        return operated([np.array([[float(b)]]) for b in numerator] or [np.zeros((1, 1))], u)
    return sum((power([float(b)], u - k) for k, b in enumerate(numerator) if b), zero(1))


def operated(matrices: Sequence[np.ndarray], u: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """N_0 u + N_1 u' + ..., the derivatives in the sense of distributions."""
    total = zero(len(matrices[0]))
    for index, N in enumerate(matrices):
        u = u.distribution_derivative() if index else u
        total = total + u.mapped(N) if N.any() else total
    return total


def checked_input(u, size: int, what: str) -> ImpulsiveSmooth:
    """A validated input."""
    if not isinstance(u, ImpulsiveSmooth):
        raise InputError(f"{what}: found {type(u).__name__}; make it with {FORCE_FUNCTIONS}")
    if u.size != size:
        raise InputError(f"{what}: it has {counted(u.size, 'row')}; expected {size}, one for each input")
    return u
