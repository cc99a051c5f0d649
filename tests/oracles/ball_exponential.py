"""Motions by the exponential of the first-order form in ball arithmetic: independent of pencils, modes and partial fractions.

A regular highest coefficient and a constant force; what the balls leave open is in their radii.
"""

from __future__ import annotations

from fractions import Fraction

import flint
import numpy as np

#: Bits of the arithmetic: 60 digits are left of 1e7 s at 1 rad/s, and of growth and decay by e^100.
BITS = 800


def motion(coefficients, start, time, force=None) -> list[Fraction]:
    """x(time) of A_0 x + A_1 x' + ... = force from x(0), x'(0), ... as rows, to 50 digits of its largest entry."""
    return _fractions(_states(coefficients, start, time, force)[: len(coefficients[0])])


def after_pulse(coefficients, force, duration, time) -> list[Fraction]:
    """x at a time after the end of a constant force of this duration, from rest."""
    q, r = len(coefficients) - 1, len(coefficients[0])
    end = _states(coefficients, np.zeros((q, r)), duration, force)
    return _fractions(_states(coefficients, end, time)[:r])


def _states(coefficients, start, time, force=None) -> list:
    q, r = len(coefficients) - 1, len(coefficients[0])
    flint.ctx.prec, before = BITS, flint.ctx.prec
    try:
        force = np.zeros(r) if force is None else force
        right = flint.arb_mat(
            [[*(-a for lower in coefficients[:-1] for a in map(_ball, lower[i])), _ball(force[i])] for i in range(r)]
        )
        lowest = flint.arb_mat([list(map(_ball, row)) for row in coefficients[-1]]).solve(right)
        rows = [[flint.arb(int(j == i + r)) for j in range(q * r + 1)] for i in range((q - 1) * r)]
        rows += [[lowest[i, j] for j in range(q * r + 1)] for i in range(r)]
        matrix = flint.arb_mat([*rows, [flint.arb(0)] * (q * r + 1)])
        states = flint.arb_mat([[_ball(value)] for value in [*np.ravel(start), 1]])
        return list((matrix * _ball(time)).exp() * states)[:-1]
    finally:
        flint.ctx.prec = before


def _ball(value):
    if isinstance(value, flint.arb):
        return value
    fraction = Fraction(value)
    return flint.arb(fraction.numerator) / flint.arb(fraction.denominator)


def _fractions(balls) -> list[Fraction]:
    middles = [_exact(ball.mid()) for ball in balls]
    radius = max(_exact(ball.rad()) for ball in balls)
    assert radius <= max(map(abs, middles)) / 10**50
    return middles


def _exact(ball) -> Fraction:
    mantissa, exponent = ball.man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
