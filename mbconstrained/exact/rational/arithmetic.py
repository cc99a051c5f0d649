"""Between the numbers of Python and those of FLINT: nothing is rounded on the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import reduce
from math import lcm
from numbers import Integral, Rational
from threading import RLock

import flint

#: The working precision of FLINT belongs to the whole process.
_PRECISION = RLock()


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """Balls are computed with so many bits inside, by one thread at a time; afterwards the precision is what it was."""
    with _PRECISION, flint.ctx.workprec(bits):
        yield


def rational(number) -> flint.fmpq:
    """The exact value of an int, a float, a Fraction, a Decimal or a number of FLINT."""
    if isinstance(number, (flint.fmpq, flint.fmpz)):
        return flint.fmpq(number)
    exact = Fraction(int(number)) if isinstance(number, Integral) else Fraction(number)
    return flint.fmpq(exact.numerator, exact.denominator)


@Rational.register
class _InLowestTerms:
    """A rational number that Fraction takes as it is, without looking for a common divisor: that takes long in long numbers."""

    def __init__(self, number: flint.fmpq):
        self.numerator, self.denominator = int(number.p), int(number.q)


def fraction(number: flint.fmpq) -> Fraction:
    """The same number as a Fraction."""
    return Fraction(_InLowestTerms(flint.fmpq(number)))


def polynomial(coefficients: Iterable) -> flint.fmpq_poly:
    """The polynomial with these coefficients, the lowest power first."""
    return flint.fmpq_poly([rational(number) for number in coefficients])


def fractions_of(p: flint.fmpq_poly) -> tuple[Fraction, ...]:
    """The coefficients of a polynomial, the lowest power first; () for zero."""
    return tuple(fraction(number) for number in p.coeffs())


def common_denominator(polynomials: Iterable[flint.fmpq_poly]) -> flint.fmpz:
    """The least whole number that makes the coefficients of all of them whole."""
    return flint.fmpz(reduce(lcm, (int(p.denom()) for p in polynomials), 1))
