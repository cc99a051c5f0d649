"""Forces as expressions in t, zero before they begin."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from ...errors import InputError

#: A record of more samples gives a formula that nobody reads.
MOST_SAMPLES = 30


def begun(expression: sympy.Expr, t: sympy.Symbol, delay: sympy.Expr) -> sympy.Expr:
    """f(t - delay), zero before.

    >>> t = sympy.Symbol("t")
    >>> begun(t, t, sympy.Integer(2))
    (t - 2)*Heaviside(t - 2)
    """
    if delay == 0:
        return expression
    later = expression.subs(t, t - delay)
    return later if expression.has(sympy.DiracDelta) else later * sympy.Heaviside(t - delay)


def term(value, t: sympy.Symbol, power: int = 0, rate=0, frequency=0, phase=0) -> sympy.Expr:
    """value t^power e^(rate t) cos(frequency t + phase)."""
    cosine = sympy.cos(frequency * t + phase) if frequency != 0 else sympy.cos(phase)
    return value * t**power * sympy.exp(rate * t) * cosine


def power_input(value, t: sympy.Symbol, gamma: int) -> sympy.Expr:
    """value I_gamma: t^(gamma-1)/(gamma-1)!, for gamma <= 0 a derivative of Dirac's delta."""
    if gamma <= 0:
        return impulse(value, t, -gamma)
    return value * t ** (gamma - 1) / sympy.factorial(gamma - 1)


def impulse(value, t: sympy.Symbol, order: int) -> sympy.Expr:
    """value times a derivative of Dirac's delta."""
    return value * (sympy.DiracDelta(t, order) if order else sympy.DiracDelta(t))


def pulse(value, t: sympy.Symbol, start, duration) -> sympy.Expr:
    """value from start on, for the duration."""
    end = start + duration
    return value * ((sympy.Heaviside(t - start) if start != 0 else sympy.S.One) - sympy.Heaviside(t - end))


def sampled(times: Sequence, values: Sequence, t: sympy.Symbol) -> sympy.Expr:
    """Linear between samples, zero outside.

    Raises:
        InputError: too many samples for a formula.
    """
    if len(times) > MOST_SAMPLES:
        raise InputError(f"a record of {len(times)} samples makes no formula that can be read; expected at most {MOST_SAMPLES}")
    total = sympy.S.Zero
    for start, end, first, last in zip(times, times[1:], values, values[1:]):
        if end != start:
            line = first + (last - first) / (end - start) * (t - start)
            total += sympy.expand(line) * (sympy.Heaviside(t - start) - sympy.Heaviside(t - end))
    return total


def angle(radians: sympy.Expr) -> sympy.Expr:
    """A phase; a decimal that is a whole number of degrees but for its rounding is that.

    >>> angle(sympy.Rational("0.5235987755982988")), angle(sympy.Rational(1, 2))
    (pi/6, 1/2)
    """
    if not radians.is_Rational or radians == 0:
        return radians
    degrees = sympy.Integer(round(radians * 180 / sympy.pi.evalf(40)))
    exact = degrees * sympy.pi / 180
    return exact if abs((radians - exact).evalf(40)) <= abs(radians) * sympy.Float(2) ** -51 else radians
