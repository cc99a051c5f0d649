"""Conversion between numbers of Python and FLINT, roots of irreducible polynomials, and interpolation at whole numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import reduce
from itertools import count
from math import lcm
from numbers import Integral, Rational
from threading import RLock

import flint

#: The working precision of FLINT belongs to the whole process.
_PRECISION = RLock()

#: In bits: where roots are computed first, and where a real or imaginary part that still cannot be distinguished from the middle of
#: two float64 neighbours counts as this middle.
FIRST_PRECISION, LAST_PRECISION = 64, 2**14


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """A context with a precision of balls, for one thread at a time; afterwards the previous precision is restored."""
    with _PRECISION, flint.ctx.workprec(bits):
        yield


def rational(number) -> flint.fmpq:
    """The exact value of an int, a float, a Fraction, a Decimal or a number of FLINT."""
    if isinstance(number, (flint.fmpq, flint.fmpz)):
        return flint.fmpq(number)
    if isinstance(number, float):
        return flint.fmpq(*number.as_integer_ratio())
    exact = Fraction(int(number)) if isinstance(number, Integral) else Fraction(number)
    return flint.fmpq(exact.numerator, exact.denominator)


@Rational.register
class _InLowestTerms:
    """A rational number that Fraction accepts without computing a greatest common divisor, which is slow for long numbers."""

    def __init__(self, number: flint.fmpq):
        self.numerator, self.denominator = int(number.p), int(number.q)


def fraction(number: flint.fmpq) -> Fraction:
    """The number as a Fraction."""
    return Fraction(_InLowestTerms(flint.fmpq(number)))


def polynomial(coefficients: Iterable) -> flint.fmpq_poly:
    """The polynomial with these coefficients, the lowest power first."""
    return flint.fmpq_poly([rational(number) for number in coefficients])


def fractions_of(p: flint.fmpq_poly) -> tuple[Fraction, ...]:
    """The coefficients of a polynomial, the lowest power first; () for zero."""
    return tuple(fraction(number) for number in p.coeffs())


def common_denominator(polynomials: Iterable[flint.fmpq_poly]) -> flint.fmpz:
    """The least whole number that makes all coefficients whole."""
    return flint.fmpz(reduce(lcm, (int(p.denom()) for p in polynomials), 1))


def exact_value(number: flint.arb) -> Fraction:
    """The value of a ball without a radius."""
    mantissa, exponent = number.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


# Interpolation.


def whole_numbers() -> Iterator[int]:
    """0, 1, -1, 2, -2, ..."""
    yield 0
    for number in count(1):
        yield number
        yield -number


def interpolated(points: Sequence[int], values: flint.fmpz_mat) -> list[flint.fmpq_poly]:
    """The polynomials that take the values in the rows at the points (Lagrange)."""
    vanishing = flint.fmpz_poly([1])
    for point in points:
        vanishing *= flint.fmpz_poly([-point, 1])
    basis, weights = [], []
    for point in points:
        others = vanishing // flint.fmpz_poly([-point, 1])
        basis.append([others[k] for k in range(len(points))])
        weights.append(others(point))
    denominator = reduce(lcm, map(int, weights), 1)
    scaled = [[entry * (denominator // weight) for entry in row] for row, weight in zip(basis, weights)]
    return [flint.fmpq_poly(row, denominator) for row in (values * flint.fmpz_mat(scaled)).tolist()]


# Roots of irreducible polynomials.


def rounded_roots(p: flint.fmpz_poly) -> tuple[complex, ...]:
    """The nearest float64 numbers to the real roots of an irreducible p and to those above the real axis.

    A part that is zero is so exactly; one beyond the range of float64 is infinite.

    >>> rounded_roots(flint.fmpz_poly([2, 0, 1])), rounded_roots(flint.fmpz_poly([1, 3]))
    ((1.4142135623730951j,), ((-0.3333333333333333+0j),))
    """
    if p.degree() == 1:
        return (complex(_float(-fraction(flint.fmpq(p[0], p[1])))),)
    precision = FIRST_PRECISION
    while True:
        parts = [(_rounded(z.real, precision), _rounded(z.imag, precision)) for z in enclosed_roots(p, precision)]
        if all(part is not None for pair in parts for part in pair):
            return tuple(complex(*pair) for pair in parts if pair[1] >= 0)
        precision *= 2


def enclosed_roots(p: flint.fmpz_poly, precision: int) -> list[flint.acb]:
    """Balls around all roots of an irreducible p; real and imaginary parts that are zero are exactly so."""
    even = p.degree() > 1 and not any(p[k] for k in range(1, p.degree() + 1, 2))
    with working_precision(precision):
        if not even:
            return [root for root, _ in p.complex_roots()]  # type: ignore[has-type]
        squares = [root for root, _ in flint.fmpz_poly(p.coeffs()[::2]).complex_roots()]  # type: ignore[has-type]
        return [root for half in (square.sqrt() for square in squares) for root in (half, -half)]  # exactly imaginary where it is


def _rounded(ball: flint.arb, precision: int) -> float | None:
    """The float64 number nearest to every number in the ball; None where there are two."""
    middle, radius = exact_value(ball.mid()), exact_value(ball.rad())
    if 2 * precision > LAST_PRECISION:
        return _float(middle)
    low, high = _float(middle - radius), _float(middle + radius)
    return low if low == high else None


def _float(number: Fraction) -> float:
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number > 0 else float("-inf")
