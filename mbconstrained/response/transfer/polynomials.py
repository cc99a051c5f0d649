"""Polynomials in one variable over the rationals, as tuples of Fractions, lowest power first, without zeros at the end."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from math import gcd, lcm

Polynomial = tuple[Fraction, ...]

#: A prime: polynomials without a common factor modulo it have none at all, which is found out in no time.
PRIME = 2**61 - 1

ONE: Polynomial = (Fraction(1),)


def trimmed(coefficients: Sequence[Fraction]) -> Polynomial:
    """Without zeros at the highest powers; the zero polynomial is empty."""
    count = max((k + 1 for k, c in enumerate(coefficients) if c), default=0)
    return tuple(coefficients[:count])


def product(one: Polynomial, two: Polynomial) -> Polynomial:
    """one * two.

    >>> [int(c) for c in product((Fraction(1), Fraction(1)), (Fraction(-1), Fraction(1)))]  # (s + 1)(s - 1)
    [-1, 0, 1]
    """
    total = [Fraction(0)] * max(len(one) + len(two) - 1, 0)
    for i, a in enumerate(one):
        for j, b in enumerate(two):
            total[i + j] += a * b
    return trimmed(total)


def divided(one: Polynomial, two: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Quotient and remainder of one / two, two not zero.

    >>> quotient, rest = divided((Fraction(2), Fraction(0), Fraction(1)), (Fraction(1), Fraction(1)))  # (s^2 + 2) / (s + 1)
    >>> [int(c) for c in quotient], [int(c) for c in rest]
    ([-1, 1], [3])
    """
    rest, quotient = list(one), [Fraction(0)] * max(len(one) - len(two) + 1, 0)
    for at in reversed(range(len(quotient))):
        factor = quotient[at] = rest[at + len(two) - 1] / two[-1]
        if factor:
            for k, c in enumerate(two):
                rest[at + k] -= factor * c
    return trimmed(quotient), trimmed(rest[: len(two) - 1])


def common_factor(one: Polynomial, two: Polynomial) -> Polynomial:
    """The greatest common divisor of two polynomials other than zero, its highest coefficient 1 (Euclid's algorithm).

    >>> [int(c) for c in common_factor((Fraction(-2), Fraction(2)), (Fraction(-1), Fraction(0), Fraction(1)))]
    [-1, 1]
    """
    a, b = _primitive(one), _primitive(two)
    if _have_none(a, b):
        return ONE
    while b:
        a, b = b, _primitive(_remainder(a, b))
    return tuple(Fraction(c, a[-1]) for c in a)


def laurent(numerator: Polynomial, denominator: Polynomial, count: int) -> list[Fraction]:
    """The first coefficients of numerator / denominator in descending powers, that of s^(m - n) first.

    >>> [int(c) for c in laurent(ONE, (Fraction(1), Fraction(1)), 4)]  # 1 / (s + 1) = s^-1 - s^-2 + s^-3 - ...
    [1, -1, 1, -1]
    """
    above, below, found = numerator[::-1], denominator[::-1], []
    for k in range(count):
        known = sum(below[i] * found[k - i] for i in range(1, min(k, len(below) - 1) + 1))
        found.append(((above[k] if k < len(above) else 0) - known) / below[0])
    return found


def _primitive(polynomial: Sequence[Fraction | int]) -> tuple[int, ...]:
    """The multiple with whole coefficients that have no common divisor."""
    scale = lcm(*(c.denominator for c in polynomial)) if polynomial else 1
    whole = [int(c * scale) for c in polynomial]
    divisor = reduce(gcd, whole, 0) or 1
    return tuple(c // divisor for c in whole)


def _remainder(one: Sequence[int], two: Sequence[int]) -> tuple[int, ...]:
    """A multiple of the remainder of one / two, in whole numbers."""
    rest = list(one)
    while len(rest) >= len(two):
        leading, shift = rest[-1], len(rest) - len(two)
        rest = [c * two[-1] for c in rest]
        for k, c in enumerate(two):
            rest[shift + k] -= leading * c
        while rest and not rest[-1]:
            rest.pop()
    return tuple(rest)


def _have_none(one: Sequence[int], two: Sequence[int]) -> bool:
    """Whether they have no common factor modulo a prime that no highest coefficient is a multiple of."""
    if one[-1] % PRIME == 0 or two[-1] % PRIME == 0:
        return False
    a, b = ([c % PRIME for c in polynomial] for polynomial in (one, two))
    while b:
        inverse = pow(b[-1], -1, PRIME)
        while len(a) >= len(b):
            factor, shift = a[-1] * inverse % PRIME, len(a) - len(b)
            for k, c in enumerate(b):
                a[shift + k] = (a[shift + k] - factor * c) % PRIME
            while a and not a[-1]:
                a.pop()
        a, b = b, a
    return len(a) == 1
