"""The roots of irreducible polynomials as float64 numbers, correctly rounded."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import flint

from .arithmetic import fraction, working_precision

#: In bits: where roots are computed first, and where a real or imaginary part that is still not told apart from the middle of
#: two float64 neighbours is taken to be this middle.
FIRST_PRECISION, LAST_PRECISION = 64, 2**14


def rounded_roots(p: flint.fmpz_poly) -> tuple[complex, ...]:
    """The nearest float64 numbers to the real roots, and to those above the real axis, of an irreducible p.

    A part that is zero is so exactly; one beyond the range of float64 is infinite.

    >>> rounded_roots(flint.fmpz_poly([2, 0, 1])), rounded_roots(flint.fmpz_poly([1, 3]))
    ((1.4142135623730951j,), ((-0.3333333333333333+0j),))
    """
    if p.degree() == 1:
        return (complex(_float(-fraction(flint.fmpq(p[0], p[1])))),)
    for precision in _precisions():
        rounded = [(_rounded(root.real, precision), _rounded(root.imag, precision)) for root in enclosed_roots(p, precision)]
        if all(part is not None for root in rounded for part in root):
            return tuple(complex(*root) for root in rounded if root[1] >= 0)
    raise AssertionError("the last precision rounds everything")


def enclosed_roots(p: flint.fmpz_poly, precision: int) -> list[flint.acb]:
    """Balls around all roots of an irreducible p; real and imaginary parts that are zero are exactly so.

    Args:
        precision: in bits.
    """
    even = p.degree() > 1 and not any(p[k] for k in range(1, p.degree() + 1, 2))
    with working_precision(precision):
        if not even:
            return [root for root, _ in p.complex_roots()]
        squares = [root for root, _ in flint.fmpz_poly(p.coeffs()[::2]).complex_roots()]
        halves = [_square_root(square) for square in squares]
        return [root for half in halves for root in (half, -half)]


def _square_root(square: flint.acb) -> flint.acb:
    """Of a negative number exactly on the imaginary axis."""
    if not square.imag and square.real < 0:
        return flint.acb(0, (-square.real).sqrt())
    return square.sqrt()


def _precisions() -> Iterator[int]:
    precision = FIRST_PRECISION
    while precision <= LAST_PRECISION:
        yield precision
        precision *= 2


def _rounded(ball: flint.arb, precision: int) -> float | None:
    """The nearest float64 number to all of the ball, None where there are two."""
    middle, radius = exact_value(ball.mid()), exact_value(ball.rad())
    if 2 * precision > LAST_PRECISION:
        return _float(middle)
    low, high = _float(middle - radius), _float(middle + radius)
    return low if low == high else None


def exact_value(number: flint.arb) -> Fraction:
    """The value of a ball without a radius."""
    mantissa, exponent = number.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def _float(number: Fraction) -> float:
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number > 0 else float("-inf")
