"""Transfer functions with known poles in rational and in multiprecision arithmetic: division, Taylor sums, residues.

Nothing here is shared with the package. Polynomials are lists of Fractions, lowest power first.
"""

from __future__ import annotations

from fractions import Fraction
from math import factorial

import mpmath


def multiplied(*polynomials):
    """Their product."""
    total = [Fraction(1)]
    for p in polynomials:
        longer = [Fraction(0)] * (len(total) + len(p) - 1)
        for i, a in enumerate(total):
            for j, b in enumerate(p):
                longer[i + j] += a * b
        total = longer
    return total


def factors(poles):
    """The polynomials of a list of poles: a rational number, or (a, w) for the pair a +- i w."""
    return [[p[0] ** 2 + p[1] ** 2, -2 * p[0], Fraction(1)] if isinstance(p, tuple) else [-p, Fraction(1)] for p in poles]


def descending(numerator, denominator, gamma, count):
    """{power: coefficient} of b / (a s^gamma) near infinity, the highest ``count`` powers, by long division."""
    rest, found = {k - gamma: Fraction(c) for k, c in enumerate(numerator)}, {}
    n, power = len(denominator) - 1, len(numerator) - len(denominator) - gamma
    for at in range(power, power - count, -1):
        factor = found[at] = rest.get(at + n, Fraction(0)) / denominator[-1]
        for k, c in enumerate(denominator):
            rest[at + k] = rest.get(at + k, Fraction(0)) - factor * c
    return found


def impulses(numerator, denominator, gamma):
    """Factors of Dirac's delta and its derivatives, without zeros at the end."""
    highest = max(len(numerator) - len(denominator) - gamma, -1)
    series = descending(numerator, denominator, gamma, highest + 1) if highest >= 0 else {}
    found = [series[k] for k in range(highest + 1)]
    while found and not found[-1]:
        found.pop()
    return found


def taylor(numerator, denominator, gamma, t, order=0, count=150):
    """y^(order)(t), t > 0, by the Taylor sum at 0+; raises where it has not converged."""
    t, series = Fraction(t), descending(numerator, denominator, gamma, count)
    terms = [c * t ** (-1 - p - order) / factorial(-1 - p - order) for p, c in series.items() if -1 - p - order >= 0]
    total = sum(terms)
    if max(abs(term) for term in terms[-5:]) > Fraction(1, 10**18) * abs(total):
        raise ArithmeticError("the Taylor sum has not converged: take a smaller t or more terms")
    return float(total)


def residues(numerator, poles, gamma, t, digits=60):
    """y(t), t > 0, as the sum of residues of e^(s t) b / (a s^gamma), a monic with the poles given as for ``factors``."""
    with mpmath.workdps(digits):
        places: dict = {}
        for p in [*poles, *[Fraction(0)] * max(gamma, 0)]:
            real, imaginary = p if isinstance(p, tuple) else (p, Fraction(0))
            for sign in (1, -1) if imaginary else (1,):
                places[real, sign * imaginary] = places.get((real, sign * imaginary), 0) + 1
        above = [Fraction(0)] * max(-gamma, 0) + list(numerator)
        found = sum(_residue(above, places, place, mpmath.mpf(t)) for place in places)
        return float(mpmath.re(found))


def _residue(numerator, places, place, t):
    """The coefficient of h^(d - 1) of e^((x + h) t) b(x + h) / product of the other factors."""
    x, d = _complex(place), places[place]
    series = [t**k / mpmath.factorial(k) * mpmath.exp(x * t) for k in range(d)]
    shifted = [sum(_number(c) * mpmath.binomial(j, k) * x ** (j - k) for j, c in enumerate(numerator) if j >= k) for k in range(d)]
    series = _times(series, shifted)
    for other, power in places.items():
        if other != place:
            distance = x - _complex(other)
            for _ in range(power):
                series = _times(series, [(-1) ** k / distance ** (k + 1) for k in range(d)])
    return series[d - 1]


def _times(one, two):
    return [sum(one[i] * two[k - i] for i in range(k + 1)) for k in range(len(one))]


def _complex(place):
    return mpmath.mpc(_number(place[0]), _number(place[1]))


def _number(value):
    value = Fraction(value)
    return mpmath.mpf(value.numerator) / value.denominator
