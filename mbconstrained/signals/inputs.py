"""Inputs in closed form from t = 0 on: steps, ramps, powers, impulses, harmonics and their products.

Every constructor takes the vector v of shape (r,) that the scalar function of time multiplies.
"""

from __future__ import annotations

import math

import numpy as np

from ..checks import real_array, real_number, whole_number
from ..errors import InputError
from .bohl import BohlFunction
from .impulsive import ImpulsiveSmooth
from .origins import ImpulseOrigin, Origin, TermOrigin, beyond_noise

#: The largest n with (n - 1)! in the range of float64.
LARGEST_FACTORIAL = 171

#: Units of rate are kept within 2^(+-this / power), so that unit^power leaves room for the coefficients.
LARGEST_UNIT_EXPONENT = 300


def zero(size: int) -> ImpulsiveSmooth:
    """The input that is zero, with the given number of rows."""
    size = whole_number(size, "size")
    return ImpulsiveSmooth(BohlFunction(np.zeros((size, 0)), (), np.zeros(0)))


def term(vector, *, power: int = 0, rate: float = 0.0, angular_frequency: float = 0.0, phase: float = 0.0) -> ImpulsiveSmooth:
    """v t^k e^{a t} cos(w t + p) for t >= 0, with k = power, a = rate (1/s), w in rad/s, p = phase in rad.

    >>> float(term([2.0], power=2)(3.0)[0])
    18.0
    """
    vector = _vector(vector)
    power = whole_number(power, "power")
    rate, phase = real_number(rate, "rate"), real_number(phase, "phase")
    frequency = real_number(angular_frequency, "angular_frequency")
    cosine, sine = (beyond_noise(turned, phase) for turned in (math.cos(phase), math.sin(phase)))
    origin = Origin(TermOrigin(vector, power, rate, frequency, phase))
    if frequency == 0:
        return _chain(vector[:, None] * cosine, np.array([[rate]]), power, origin)
    turn = np.array([[rate, -frequency], [frequency, rate]])
    return _chain(np.multiply.outer(vector, [cosine, -sine]), turn, power, origin)


def step(vector) -> ImpulsiveSmooth:
    """v for t >= 0 (I_1 of Hauksdottir's inputs).

    >>> step([1.0, 2.0])(5.0)
    array([1., 2.])
    """
    return term(vector)


def ramp(vector) -> ImpulsiveSmooth:
    """v t for t >= 0 (I_2)."""
    return term(vector, power=1)


def power(vector, gamma: int) -> ImpulsiveSmooth:
    """v I_gamma(t) of Hauksdottir for every integer gamma: t^(gamma-1)/(gamma-1)! for gamma >= 1,
    the (-gamma)-th derivative of Dirac's delta for gamma <= 0.

    >>> float(power([6.0], 3)(2.0)[0])
    12.0
    """
    if isinstance(gamma, bool) or not isinstance(gamma, (int, np.integer)):
        raise InputError(f"gamma: found {gamma!r}; expected a whole number")
    if gamma <= 0:
        return impulse(vector, order=-int(gamma))
    if gamma > LARGEST_FACTORIAL:
        raise InputError(f"gamma: found {gamma}; (gamma - 1)! leaves the range of float64 beyond {LARGEST_FACTORIAL}")
    vector, divisor = _vector(vector), math.factorial(gamma - 1)
    origin = Origin(TermOrigin(vector, power=int(gamma) - 1, divisor=divisor))
    return _chain(vector[:, None] / divisor, np.zeros((1, 1)), int(gamma) - 1, origin)


def impulse(vector, order: int = 0) -> ImpulsiveSmooth:
    """v delta^(order)(t): a Dirac impulse at t = 0, or its derivative."""
    vector = _vector(vector)
    order = whole_number(order, "order")
    zeros = tuple(np.zeros_like(vector) for _ in range(order))
    return ImpulsiveSmooth(zero(len(vector)).smooth, (*zeros, vector)).coming_from(Origin(ImpulseOrigin(vector, order)))


def harmonic(vector, *, angular_frequency: float, phase: float = 0.0) -> ImpulsiveSmooth:
    """v cos(w t + p) for t >= 0, w in rad/s, p in rad."""
    return term(vector, angular_frequency=angular_frequency, phase=phase)


def _vector(value) -> np.ndarray:
    if np.ndim(value) == 0 and not isinstance(value, str):
        raise InputError(f"vector: found {value!r}; expected a list with one number for each row, e.g. [1.0, 0.0]")
    return real_array(value, "vector", shape=(None,))


def _chain(coefficients, diagonal, power, origin) -> ImpulsiveSmooth:
    """The function whose states are (u t)^j e^{diagonal t}, j = power .. 0, read off the highest one.

    The highest power comes first: the generator is then upper (quasi-)triangular, like a real Schur form. The unit u
    is near the rates, so that the couplings of the states are of their size whatever the unit of time is.
    """
    size, unit = len(diagonal), _rate_unit(diagonal, power)
    steps = unit * np.diag(np.arange(power, 0, -1.0), k=1) if power else np.zeros((1, 1))
    generator = np.kron(np.eye(power + 1), diagonal) + np.kron(steps, np.eye(size))
    start = np.zeros(size * (power + 1))
    start[-size] = 1.0
    rows = np.zeros((len(coefficients), size * (power + 1)))
    rows[:, :size] = coefficients / unit**power
    return ImpulsiveSmooth(BohlFunction(rows, (generator,), start)).coming_from(origin)


def _rate_unit(diagonal, power) -> float:
    """A power of two near the largest rate (1 where all are zero) whose power stays within the range of float64."""
    rate = np.abs(diagonal).max()
    if rate == 0 or power == 0:
        return 1.0
    largest = LARGEST_UNIT_EXPONENT / power
    return float(2.0 ** np.round(np.clip(np.log2(rate), -largest, largest)))
