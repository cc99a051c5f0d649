"""Inputs in closed form from t = 0 on: steps, ramps, powers, impulses, harmonics, pulses and records.

Every constructor but ``sampled`` takes the vector v of shape (r,) that a scalar function of time multiplies. Its entries have
the units of the rows that the input loads, such as N or N m. Inputs add, and ``delayed`` moves them to later times.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import check_known, nearest, real_array, real_number, whole_number
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from .bohl import BohlFunction, Restarts
from .impulsive import ExactImpulse, ExactInput, ExactRecord, ExactTerm, ImpulsiveSmooth, without_phase_noise

#: The largest n with (n - 1)! in the range of float64.
LARGEST_FACTORIAL = 171

#: Units of rate are kept within 2^(+-this / power), so that unit^power leaves room for the coefficients.
LARGEST_UNIT_EXPONENT = 300


def zero(size: int) -> ImpulsiveSmooth:
    """The input f(t) = 0.

    Args:
        size: number of rows r.
    """
    size = whole_number(size, "size")
    return ImpulsiveSmooth(BohlFunction(np.zeros((size, 0)), (), np.zeros(0)))


def named_rows(signals: Mapping, places: Mapping[str, int], size: int, what: str, names: str = "coordinate") -> ImpulsiveSmooth:
    """The input with so many rows of which some are given by name, each a signal with one row or a constant; the others are zero.

    >>> named_rows({"load": step(5.0), "cart": 2.0}, {"cart": 0, "load": 1}, 2, "force")(1.0)
    array([2., 5.])
    """
    total = zero(size)
    for name, one in signals.items():
        if name not in places:
            raise InputError(f'{what}: there is no {names} "{name}"{nearest(str(name), places)}')
        signal = one if isinstance(one, ImpulsiveSmooth) else step([real_number(one, f"{what} of {name}")])
        if signal.size != 1:
            raise InputError(f"{what} of {name}: found {signal.size} rows; expected one, as of mb.step(5.0)")
        column = np.zeros((size, 1))
        column[places[name]] = 1.0
        total = total + signal.mapped(column)
    return total


@answering
def term(
    vector,
    *,
    power: int = 0,
    rate: float = 0.0,
    angular_frequency: float | None = None,
    frequency_hz: float | None = None,
    phase: float = 0.0,
) -> ImpulsiveSmooth:
    """The input f(t) = v t^k e^{a t} cos(w t + p) for t >= 0.

    Args:
        vector: v, shape (r,).
        power: k, at least 0.
        rate: a in 1/s.
        angular_frequency: w in rad/s; 0 where neither frequency is given.
        frequency_hz: w / (2 pi) in Hz, instead.
        phase: p in rad.

    Returns:
        An ImpulsiveSmooth with r rows.

    Raises:
        InputError: an argument that is not a finite number, a negative power, or both frequencies.

    >>> from mbconstrained import term
    >>> float(term([2.0], power=2)(3.0)[0])
    18.0
    """
    vector = _vector(vector)
    power = whole_number(power, "power")
    rate, phase = real_number(rate, "rate"), real_number(phase, "phase")
    if angular_frequency is not None and frequency_hz is not None:
        raise InputError("give either angular_frequency (rad/s) or frequency_hz (Hz), not both")
    turns = 0.0 if frequency_hz is None else real_number(frequency_hz, "frequency_hz")
    frequency = 2 * math.pi * turns if angular_frequency is None else real_number(angular_frequency, "angular_frequency")
    cosine, sine = (without_phase_noise(turned, phase) for turned in (math.cos(phase), math.sin(phase)))
    origin = ExactInput(ExactTerm(vector, power, rate, frequency, phase))
    if frequency == 0:
        return _chain(vector[:, None] * cosine, np.array([[rate]]), power, origin)
    turn = np.array([[rate, -frequency], [frequency, rate]])
    return _chain(np.multiply.outer(vector, [cosine, -sine]), turn, power, origin)


@answering
def step(vector) -> ImpulsiveSmooth:
    """The step f(t) = v for t >= 0, I_1 of Hauksdottir's inputs, for v of shape (r,).

    >>> from mbconstrained import step
    >>> step([1.0, 2.0])(5.0)
    array([1., 2.])
    """
    return term(vector)


@answering
def ramp(vector) -> ImpulsiveSmooth:
    """The ramp f(t) = v t for t >= 0, I_2 of Hauksdottir's inputs, for v of shape (r,) per second.

    >>> from mbconstrained import ramp
    >>> ramp([1.0, 2.0])(5.0)
    array([ 5., 10.])
    """
    return term(vector, power=1)


@answering
def power(vector, gamma: int) -> ImpulsiveSmooth:
    """The input f(t) = v I_gamma(t) of Hauksdottir, whose Laplace transform is v s^(-gamma).

    I_gamma(t) = t^(gamma-1) / (gamma-1)! for gamma >= 1, and the (-gamma)-th derivative of Dirac's delta for gamma <= 0.

    Args:
        vector: v, shape (r,).
        gamma: a whole number up to 171.

    Returns:
        An ``ImpulsiveSmooth`` with r rows.

    Raises:
        InputError: a gamma that is not a whole number, or whose factorial leaves the range of float64.

    >>> from mbconstrained import power
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
    origin = ExactInput(ExactTerm(vector, power=int(gamma) - 1, divisor=divisor))
    return _chain(vector[:, None] / divisor, np.zeros((1, 1)), int(gamma) - 1, origin)


@answering
def impulse(vector, order: int = 0) -> ImpulsiveSmooth:
    """The Dirac impulse f(t) = v delta^(order)(t) at t = 0.

    Args:
        vector: v, shape (r,), e.g. in N s for order 0.
        order: order of the derivative of Dirac's delta.

    Returns:
        An ``ImpulsiveSmooth`` with r rows.

    >>> from mbconstrained import impulse
    >>> impulse([2.0], order=1).impulses
    (array([0.]), array([2.]))
    """
    vector = _vector(vector)
    order = whole_number(order, "order")
    zeros = tuple(np.zeros_like(vector) for _ in range(order))
    return ImpulsiveSmooth(zero(len(vector)).smooth, (*zeros, vector)).described_by(ExactInput(ExactImpulse(vector, order)))


@answering
def harmonic(
    vector, *, angular_frequency: float | None = None, frequency_hz: float | None = None, phase: float = 0.0
) -> ImpulsiveSmooth:
    """The harmonic f(t) = v cos(w t + p) for t >= 0.

    Args:
        vector: v, shape (r,).
        angular_frequency: w in rad/s.
        frequency_hz: w / (2 pi) in Hz, instead.
        phase: p in rad; -pi/2 gives a sine.

    Returns:
        An ``ImpulsiveSmooth`` with r rows.

    Raises:
        InputError: no frequency, or both.

    >>> from mbconstrained import harmonic
    >>> harmonic([2.0], angular_frequency=3.0)(0.0)
    array([2.])
    """
    if angular_frequency is None and frequency_hz is None:
        raise InputError("give angular_frequency (rad/s) or frequency_hz (Hz)")
    return term(vector, angular_frequency=angular_frequency, frequency_hz=frequency_hz, phase=phase)


def _vector(value) -> np.ndarray:
    """The vector; a number is one row."""
    if isinstance(value, Mapping):
        raise InputError(f'vector: found {value!r}; inputs by name are written as force={{"cart": mb.step(5.0)}}')
    number = np.ndim(value) == 0 and value is not None and not isinstance(value, str)
    return real_array([value] if number else value, "vector", shape=(None,))


def _chain(coefficients, diagonal, power, origin) -> ImpulsiveSmooth:
    """The function whose states are (u t)^j e^{diagonal t}, j = power .. 0, read off the highest one.

    The highest power comes first: the generator is then upper (quasi-)triangular, like a real Schur form. The unit u
    is near the rates, so that the couplings of the states are of their size whatever the unit of time is.
    """
    size, unit = len(diagonal), _rate_unit(diagonal, power)
    generator = diagonal
    if power:
        steps = unit * np.diag(np.arange(power, 0, -1.0), k=1)
        generator = np.kron(np.eye(power + 1), diagonal) + np.kron(steps, np.eye(size))
    start = np.zeros(size * (power + 1))
    start[-size] = 1.0
    rows = np.zeros((len(coefficients), size * (power + 1)))
    rows[:, :size] = coefficients / unit**power
    return ImpulsiveSmooth(BohlFunction(rows, (generator,), start)).described_by(origin)


def _rate_unit(diagonal, power) -> float:
    """A power of two near the largest rate (1 where all are zero) whose power stays within the range of float64."""
    rate = np.abs(diagonal).max()
    if rate == 0 or power == 0:
        return 1.0
    largest = LARGEST_UNIT_EXPONENT / power
    return float(2.0 ** np.round(np.clip(np.log2(rate), -largest, largest)))


#: J of a linear piece of a record, whose two states are its value and its slope.
LINEAR = np.array([[0.0, 1.0], [0.0, 0.0]])


@answering
def pulse(vector, *, start: float = 0.0, duration: float, shape: str = "rectangle") -> ImpulsiveSmooth:
    """A pulse of peak v for start <= t < start + duration, zero before and after, with u = (t - start) / duration:

    f = v (rectangle), v sin(pi u) (half-sine), v (1 - cos(2 pi u)) / 2 (versed-sine), v (1 - |2 u - 1|) (triangle), v u (sawtooth).

    Args:
        vector: v, shape (r,).
        start: in s, at least 0.
        duration: in s, greater than 0.
        shape: "rectangle", "half-sine", "versed-sine", "triangle" or "sawtooth", which ends at its peak.

    Returns:
        An ``ImpulsiveSmooth`` with r rows.

    Raises:
        InputError: an unknown shape, times out of range, or a duration that rounding removes.

    >>> from mbconstrained import pulse
    >>> pulse([2.0], start=1.0, duration=0.5)([0.5, 1.0, 1.4, 1.5])
    array([[0., 2., 2., 0.]])
    >>> pulse([2.0], duration=0.5, shape="half-sine")([0.125, 0.25]).round(6)
    array([[1.414214, 2.      ]])
    """
    check_known(shape, PULSES, "shape")
    start, duration = real_number(start, "start", minimum=0.0), real_number(duration, "duration", positive=True)
    end = start + duration
    if end == start:
        raise InputError(f"duration: {duration:g} s vanishes next to the start at {start:g} s; give a longer one")
    if end == np.inf:
        raise InputError(f"duration: {duration:g} s after the start at {start:g} s is beyond the range of float64; shorten it")
    vector = _vector(vector)
    if shape != "rectangle":
        return PULSES[shape](vector, duration).delayed(start)
    restarts = Restarts(np.array([0.0, duration]), np.array([[1.0, 0.0]]), np.array([[1.0, -1.0]]))
    pulse_at_zero = ImpulsiveSmooth(BohlFunction(vector[:, None], (np.zeros((1, 1)),), restarts))
    parts = ExactInput(ExactTerm(vector)), ExactInput(ExactTerm(-vector)).delayed(duration)
    return pulse_at_zero.described_by(*parts).delayed(start)


def _half_sine(v: np.ndarray, T: float) -> ImpulsiveSmooth:
    sine = harmonic(v, angular_frequency=np.pi / T, phase=-np.pi / 2)
    return sine + sine.delayed(T)


def _versed_sine(v: np.ndarray, T: float) -> ImpulsiveSmooth:
    wave = step(v / 2) + harmonic(-v / 2, angular_frequency=2 * np.pi / T)
    return wave + (-1.0 * wave).delayed(T)


def _triangle(v: np.ndarray, T: float) -> ImpulsiveSmooth:
    rise = ramp(2 * v / T)
    return rise + (-2.0 * rise).delayed(T / 2) + rise.delayed(T)


def _sawtooth(v: np.ndarray, T: float) -> ImpulsiveSmooth:
    return ramp(v / T) + (ramp(-v / T) + step(-v)).delayed(T)


#: The shapes of pulses.
PULSES: dict[str, Callable] = {
    "rectangle": pulse,
    "half-sine": _half_sine,
    "versed-sine": _versed_sine,
    "triangle": _triangle,
    "sawtooth": _sawtooth,
}


@answering
def sampled(times, values) -> ImpulsiveSmooth:
    """A record: linear between its samples, zero before the first and after the last one.

    The record jumps at its first and last sample where the values there are not zero. Two samples at the same time are a
    jump from the first value to the second.

    Args:
        times: shape (T,), T >= 2, in s, ascending, the first at least 0; a time may appear twice.
        values: shape (r, T), or (T,) of one row.

    Returns:
        An ``ImpulsiveSmooth`` with r rows.

    Raises:
        InputError: shapes that do not match; times that do not ascend, appear three times or are too close.

    >>> from mbconstrained import sampled
    >>> triangle = sampled([1.0, 2.0, 3.0], [[0.0, 4.0, 0.0]])
    >>> triangle([0.5, 1.5, 2.0, 2.25, 9.0])
    array([[0., 2., 4., 3., 0.]])
    """
    times = real_array(times, "times", shape=(None,))
    values = _rows(values, len(times))
    first = _first_samples(times)
    last = np.append(first[1:], len(times)) - 1
    acting = np.flatnonzero(values.any(axis=1))  # rows that stay zero need no states
    knots, left, right = times[first], values[np.ix_(acting, first)], values[np.ix_(acting, last)]
    slopes, changes = _slopes(knots, left, right)
    jumps = right - left
    jumps[:, 0], jumps[:, -1] = right[:, 0], -left[:, -1]
    right[:, -1] = 0.0
    start = _from_zero(Restarts(knots, _alternating(right, slopes), _alternating(jumps, changes)))
    rows = np.kron(np.eye(len(values))[:, acting], [1.0, 0.0])
    record = ImpulsiveSmooth(BohlFunction(rows, (LINEAR,) * len(acting), start))
    return record.described_by(ExactInput(ExactRecord(times, values)))


def _rows(values, count: int) -> np.ndarray:
    values = real_array(values, "values")
    values = values[None] if values.ndim == 1 else values
    if values.ndim != 2 or values.shape[1] != count:
        shape = " x ".join(map(str, values.shape)) or "a single number"
        raise InputError(f"values: found shape {shape}; expected one row per coordinate, each of {count} values, e.g. [[1, 2]]")
    return values


def _first_samples(times) -> np.ndarray:
    """The index of the first sample at each time."""
    if len(times) < 2:
        raise InputError(f"times: found {len(times)}; a record needs at least two samples")
    if times[0] < 0:
        raise InputError(f"times: the first is {times[0]:g} s; a record begins at t = 0 or later")
    gaps = np.diff(times)
    if (gaps < 0).any():
        at = int(np.argmax(gaps < 0))
        raise InputError(f"times: {times[at]:.17g} s is followed by {times[at + 1]:.17g} s; times must ascend")
    if (same := (gaps[1:] == 0) & (gaps[:-1] == 0)).any():
        raise InputError(
            f"times: {times[int(np.argmax(same))]:.17g} s appears three times; twice is a jump, from the value before to the value after"
        )
    first = np.flatnonzero(np.append(True, gaps > 0))
    if len(first) < 2:
        raise InputError(f"times: all are {times[0]:g} s; a record needs a duration")
    return first


def _slopes(knots, left, right) -> tuple[np.ndarray, np.ndarray]:
    """The slope after each knot, and its change there, zero where that is rounding error."""
    gaps = np.diff(knots)
    with np.errstate(over="ignore", invalid="ignore"):
        slopes = (left[:, 1:] - right[:, :-1]) / gaps
        size = np.abs(left[:, 1:]) + np.abs(right[:, :-1]) + np.abs(slopes) * (knots[1:] + knots[:-1])
        noise = noise_of(size / gaps)
    if not np.isfinite(noise).all():
        at = int(np.argmin(np.isfinite(noise).all(axis=0)))
        raise InputError(f"values: the slope after t = {knots[at]:.17g} s is beyond the range of float64; the times are too close")
    nothing = np.zeros((len(left), 1))
    slopes, noise = np.hstack([nothing, slopes, nothing]), np.hstack([nothing, noise, nothing])
    changes = np.diff(slopes, axis=1)
    real = np.abs(changes) > np.maximum(noise[:, 1:], noise[:, :-1])
    return slopes[:, 1:], np.where(real, changes, 0.0)


def _alternating(values, slopes) -> np.ndarray:
    """Value and slope of every row, one below the other, shape (2 r, K)."""
    return np.stack([values, slopes], axis=1).reshape(2 * len(values), values.shape[1])


def _from_zero(record: Restarts) -> Restarts:
    """The record with the knot 0 in front, where it starts later."""
    if record.knots[0] == 0:
        return record
    nothing = np.zeros((len(record.states), 1))
    return Restarts(np.append(0.0, record.knots), np.hstack([nothing, record.states]), np.hstack([nothing, record.jumps]))
