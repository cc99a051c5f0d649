"""Numbers with their kinds of quantity, as expressions of parameters calculate with them: exactly, and refusing to add kg to m."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from fractions import Fraction

from ..errors import InputError
from .dimensions import Dimension, described

MOST_BITS = 20_000  # of a numerator or denominator: beyond, a power has been raised to a power too often


@dataclass(frozen=True)
class Measured:
    """A number, exactly, with its kind of quantity.

    Attributes:
        value: in SI.
        dimension: None where it is not known: a parameter that is a plain number may be anything in SI.
        is_factor: whether it is a number written in an expression: a factor without a dimension, but as a summand anything.
    """

    value: Fraction
    dimension: Dimension | None = None
    is_factor: bool = False

    @classmethod
    def written(cls, text: str) -> Measured:
        """A number in an expression."""
        return cls(Fraction(text), None, True)

    def __add__(self, other: Measured) -> Measured:
        return self._with(self.value + other.value, _common(self, other, "adds"), self.is_factor and other.is_factor)

    def __sub__(self, other: Measured) -> Measured:
        return self._with(self.value - other.value, _common(self, other, "subtracts"), self.is_factor and other.is_factor)

    def __mul__(self, other: Measured) -> Measured:
        return self._with(self.value * other.value, _product(self, other, 1), self.is_factor and other.is_factor)

    def __truediv__(self, other: Measured) -> Measured:
        if not other.value:
            raise InputError("it divides by zero with the default values of the parameters")
        return self._with(self.value / other.value, _product(self, other, -1), self.is_factor and other.is_factor)

    def __pow__(self, exponent: int) -> Measured:
        if not self.value and exponent < 0:
            raise InputError("it divides by zero with the default values of the parameters")
        if max(self.value.numerator.bit_length(), self.value.denominator.bit_length()) * abs(exponent) > MOST_BITS:
            raise InputError("its value has far too many digits")
        dimension = None if self.dimension is None else _combined(self.dimension, exponent)
        return self._with(self.value**exponent, dimension, self.is_factor)

    def _with(self, value: Fraction, dimension: Dimension | None, is_factor: bool) -> Measured:
        if max(value.numerator.bit_length(), value.denominator.bit_length()) > MOST_BITS:
            raise InputError("its value has far too many digits")
        return Measured(value, dimension, is_factor)


def _common(one: Measured, two: Measured, does: str) -> Dimension | None:
    """The kind of a sum."""
    if one.dimension is None or two.dimension is None:
        return one.dimension or two.dimension
    if one.dimension.exponents != two.dimension.exponents:
        raise InputError(f"it {does} {described(one.dimension)} and {described(two.dimension)}")
    return one.dimension if one.dimension.radian == two.dimension.radian else Dimension(one.dimension.exponents, None)


def _product(one: Measured, two: Measured, exponent: int) -> Dimension | None:
    """The kind of one times two^exponent."""
    if two.is_factor:
        return one.dimension
    if two.dimension is None or (one.dimension is None and not one.is_factor):
        return None
    first = Dimension(frozenset(), None) if one.is_factor else one.dimension
    return two.dimension if one.is_factor and exponent == 1 else _combined(first, 1, two.dimension, exponent)


def _combined(one: Dimension, power: int, two: Dimension | None = None, exponent: int = 1) -> Dimension:
    """one^power two^exponent; radians, which are not written in products, may be left in it or not."""
    found: Counter = Counter()
    for unit, count in one.exponents:
        found[unit] += power * count
    for unit, count in two.exponents if two else ():
        found[unit] += exponent * count
    return Dimension(frozenset((unit, count) for unit, count in found.items() if count), None)
