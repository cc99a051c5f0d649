"""Fatigue: rainflow counting of cycles, damage by Miner's rule, and fatigue damage spectra of records and of random excitation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..ground.checks import check_known, counted, real_array, real_number
from ..ground.display import Displayed, TextTable, number_text
from ..ground.errors import InputError
from ..ground.tolerances import EPS, FREE_PART
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from .extrema import fastest_rate
from .harmonic import Harmonic
from .random.random_response import RandomResponse
from .random.spectra import KINDS, Spectrum, spectral_matrix
from .shock_spectrum import QUANTITIES, UNITS, Oscillator, ShockRecord, checked_oscillators, record_of_signal

#: Cycles of functions in closed form that are smaller than this share of the largest one are rounding errors.
SMALLEST_CYCLE = 1e4 * EPS

#: Turning points are searched between times of this distance, in radians of the fastest part of a function, and at most so many times.
STEP, MOST_TIMES = 0.4, 4_000_000

#: Newton's steps from a linear start, whose error they square each.
NEWTON = 3

#: Half cycles of free vibrations after a record that are counted at most.
MOST_FREE = 1_000_000


@dataclass(frozen=True, repr=False, eq=False)
class CycleCount(Displayed):
    """Cycles of a history, each with its range, mean and number: 1, or 1/2 for half cycles.

    Attributes:
        ranges: maximum minus minimum of each cycle, shape (C,), in the order in which they close.
        means: half of maximum plus minimum.
        counts: 1 or 0.5.
        unit: of the history in SI; an empty text where it is unknown.
    """

    ranges: np.ndarray
    means: np.ndarray
    counts: np.ndarray
    unit: str = ""

    def _summary(self) -> str:
        largest = f", ranges up to {number_text(self.ranges.max())}" if len(self.ranges) else ""
        return f"{self.total:g} cycles{largest}"

    def _tables(self) -> tuple[TextTable, ...]:
        ranges = np.unique(self.ranges)[::-1]
        rows = tuple((number_text(one), number_text(self.counts[self.ranges == one].sum())) for one in ranges)
        return (TextTable("Cycles", ("range", "count"), rows),)

    @property
    def total(self) -> float:
        """Number of cycles."""
        return float(self.counts.sum())

    def damage(self, exponent: float, strength: float = 1.0) -> float:
        """Damage by Miner's rule, sum of n / N(a) with N(a) = (strength / a)^exponent cycles of the amplitude a = range / 2 to failure.

        Args:
            exponent: k of the S-N curve.
            strength: the amplitude that fails in one cycle, in the unit of the history.

        Returns:
            1 is failure.
        """
        k, strength = real_number(exponent, "exponent", positive=True), real_number(strength, "strength", positive=True)
        return float(self.counts @ (self.ranges / (2 * strength)) ** k)

    def equivalent_amplitude(self, exponent: float, cycles: float | None = None) -> float:
        """The amplitude of equal cycles that do the same damage.

        Args:
            exponent: k of the S-N curve.
            cycles: number of the equal cycles; as many as there are by default.

        Returns:
            (sum of n a^k / cycles)^(1/k); 0 without cycles.
        """
        number = self.total if cycles is None else real_number(cycles, "cycles", positive=True)
        largest = self.ranges.max(initial=0.0) / 2
        return largest * (self.damage(exponent, largest) / number) ** (1 / exponent) if largest else 0.0

    def exceedance(self, ranges: np.ndarray) -> np.ndarray:
        """Numbers of cycles of at least these ranges."""
        order = np.argsort(self.ranges)
        above = np.append(np.cumsum(self.counts[order][::-1])[::-1], 0.0)
        return above[np.searchsorted(self.ranges[order], ranges)]


def rainflow(history) -> CycleCount:
    """Count the cycles of a history by the rainflow method.

    Three successive turning points give two ranges, of which the first is a cycle when it is not larger than the second: a whole one, or a half
    one where it begins the history. What is left at the end are half cycles. Source: ASTM E1049-85 (2017), section 5.4.4.

    Args:
        history: values of a stress, a force or another quantity in their order, shape (T,); values between turning points do not matter.

    Returns:
        A ``CycleCount``.

    Raises:
        InputError: an array of another shape, values that are not finite.

    The example of the standard, figure 6:

    >>> cycles = rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    >>> cycles.ranges.tolist(), cycles.counts.tolist()
    ([3.0, 4.0, 4.0, 8.0, 9.0, 8.0, 6.0], [0.5, 0.5, 1.0, 0.5, 0.5, 0.5, 0.5])
    >>> cycles.damage(exponent=5.0, strength=100.0) < 1e-6
    True
    """
    values = real_array(history, "history", shape=(None,))
    cycles: list[tuple[float, float, float]] = []
    stack: list[float] = []
    for point in turning_points(values).tolist():
        stack.append(point)
        while len(stack) > 2 and abs(stack[-1] - stack[-2]) >= (own := abs(stack[-2] - stack[-3])):
            cycles.append((own, (stack[-2] + stack[-3]) / 2, 0.5 if len(stack) == 3 else 1.0))
            del stack[-3 : -2 if len(stack) == 3 else -1]
    cycles += [(abs(after - before), (after + before) / 2, 0.5) for before, after in pairwise(stack)]
    return CycleCount(*np.array(cycles).reshape(-1, 3).T)


def turning_points(values: np.ndarray) -> np.ndarray:
    """The first and the last of some values, and those between at which they change their direction."""
    values = values[np.append(True, np.diff(values) != 0)] if len(values) else values
    turns = np.diff(np.sign(np.diff(values))) != 0
    return values[np.concatenate([[True], turns, [True]])] if len(values) > 2 else values


def cycles_of(function: BohlFunction, start: float, end: float) -> list[CycleCount]:
    """The cycles of each row of a function of time, from its turning points in closed form."""
    result = []
    for values in function(_times_with_turns(function, start, end)):
        every = rainflow(values)
        kept = every.ranges > SMALLEST_CYCLE * np.ptp(values)
        result.append(CycleCount(every.ranges[kept], every.means[kept], every.counts[kept]))
    return result


def _times_with_turns(function: BohlFunction, start: float, end: float) -> np.ndarray:
    """Times that resolve a function, and those of the turning points of its rows between them."""
    times, rough = _times(function, start, end), getattr(function, "rough", function)
    turns = []
    for slope, bend in zip(rough.derivative(1)(times), rough.derivative(2)(times)):
        (at,) = (slope[:-1] * slope[1:] < 0).nonzero()
        turns.append(times[at] + _root(np.diff(times)[at], slope[at], slope[at + 1], bend[at], bend[at + 1]))
    return np.unique(np.concatenate([times, *turns]))


def _times(function: BohlFunction, start: float, end: float) -> np.ndarray:
    """Times that resolve the fastest part of a function, with both sides of its knots."""
    wanted = int(np.ceil(fastest_rate(getattr(function, "rough", function)) * (end - start) / STEP)) + 2
    if wanted > MOST_TIMES:
        raise InputError(f"the motion has too many periods until {end:g} s for its cycles to be counted; choose an earlier end")
    knots = function.restarts.knots
    inside = knots[(knots > start) & (knots < end)]
    return np.unique(np.concatenate([np.linspace(start, end, max(wanted, 65)), inside, np.nextafter(inside, start)]))


def _root(h, first, last, bend, last_bend) -> np.ndarray:
    """The sign change of cubics in steps h, with these values and slopes at both ends, by Newton's method from the chord."""
    s = first / (first - last)
    for _ in range(NEWTON):
        a, b = h * bend - (last - first), -h * last_bend + (last - first)
        value = (1 - s) * first + s * last + s * (1 - s) * ((1 - s) * a + s * b)
        slope = last - first + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            s = np.clip(np.nan_to_num(s - value / slope, nan=0.5), 0.0, 1.0)
    return s * h


# Fatigue damage spectra: the damage of single oscillators on a base that moves, over their natural frequency.


@dataclass(frozen=True, repr=False, eq=False)
class FatigueDamageSpectrum(Displayed):
    """Damage of oscillators z'' + 2 zeta w z' + w^2 z = -a(t) on a base with the acceleration a.

    Attributes:
        frequencies_hz: natural frequencies, shape (F,).
        damage: sum of n (amplitude / strength)^exponent, shape (F,).
        damping_ratio: zeta.
        quantity: quantity whose cycles are counted.
        exponent, strength: of the S-N curve, N = (strength / amplitude)^exponent, the strength in the SI unit of the quantity.
    """

    frequencies_hz: np.ndarray
    damage: np.ndarray
    damping_ratio: float
    quantity: str
    exponent: float
    strength: float

    def _summary(self) -> str:
        own = counted(len(self.frequencies_hz), "frequency", "frequencies")
        return f"{self.quantity}, {own}, exponent {self.exponent:g}, damping ratio {self.damping_ratio:g}"


def fatigue_damage_spectrum(
    excitation: ImpulsiveSmooth | Spectrum,
    frequencies_hz,
    exponent: float,
    damping_ratio: float = 0.05,
    quantity: str = "pseudo-velocity",
    quality_factor: float | None = None,
    strength: float = 1.0,
    duration: float | None = None,
    method: str = "dirlik",
) -> FatigueDamageSpectrum:
    """The fatigue damage spectrum of a base motion: D(f) = sum of n (amplitude / strength)^exponent of an oscillator over its frequency.

    Of a signal the cycles of the closed-form response are counted by the rainflow method, the free vibrations after its end included; turning
    points are not those of samples. Of a random excitation the damage is the rate of ``RandomResponse.damage_rate`` times the duration. Sources:
    Lalanne, Mechanical Vibration and Shock Analysis, vol. 4 and 5 (2014); Henderson and Piersol, Fatigue damage related descriptor for random
    vibration test environments, Sound and Vibration 29 (1995).

    Args:
        excitation: acceleration of the base in one row, a signal as of ``shock_response_spectrum``; or the power spectral density of a motion of the
            base, such as ``mb.psd(f, G, of="acceleration", unit="g^2/Hz")``.
        frequencies_hz: natural frequencies of the oscillators, shape (F,).
        exponent: k of the S-N curve N = (strength / amplitude)^k.
        damping_ratio: zeta > 0.
        quantity: "pseudo-velocity", to which stresses are proportional, or another one of ``shock_response_spectrum``.
        quality_factor: Q = 1 / (2 zeta), in the place of the damping ratio.
        strength: in the SI unit of the quantity; damages of two motions compare without it.
        duration: of the random excitation, in s.
        method: "dirlik" or "narrow-band", of a random excitation.

    Returns:
        A ``FatigueDamageSpectrum``.

    Raises:
        InputError: several rows, frequencies or a damping ratio that are not positive, a signal without an end, no duration.

    A test of 60 s with twice the spectrum does 2^(4/2) times the damage:

    >>> import mbconstrained as mb
    >>> level = [mb.psd([20, 2000], [G, G], of="acceleration", unit="g^2/Hz") for G in (0.01, 0.02)]
    >>> D = [mb.fatigue_damage_spectrum(one, [100.0], exponent=4, duration=60.0).damage[0] for one in level]
    >>> float(round(D[1] / D[0], 9))
    4.0
    """
    f, zeta = checked_oscillators(frequencies_hz, damping_ratio, quality_factor)
    k, strength = real_number(exponent, "exponent", positive=True), real_number(strength, "strength", positive=True)
    check_known(quantity, QUANTITIES, "quantity")
    if not zeta > 0:
        raise InputError("damping_ratio: found 0; undamped oscillators vibrate without end, expected a positive damping ratio")
    own = [(one, QUANTITIES[quantity](one)) for one in (Oscillator(2 * np.pi * each, zeta) for each in f.tolist())]
    if isinstance(excitation, Spectrum):
        if duration is None:
            raise InputError("duration: a random excitation does damage as long as it acts; give duration in s")
        time = real_number(duration, "duration", positive=True)
        damage = [time * _random(excitation, *one, quantity).damage_rate(k, strength, method)[0] for one in own]
    else:
        if duration is not None:
            raise InputError("duration: a signal has its own end; leave it out")
        damage = [rainflow(points).damage(k, strength) for points in _histories(excitation, own)]
    return FatigueDamageSpectrum(f, np.array(damage), zeta, quantity, k, strength)


def _random(spectrum: Spectrum, oscillator: Oscillator, output, quantity: str) -> RandomResponse:
    """The response r = c_0 y + c_1 y' of an oscillator, y'' + 2 z w y' + w^2 y = a."""
    if spectrum.of not in KINDS or KINDS[spectrum.of] is None:
        raise InputError(
            f'excitation: found a spectrum of a {spectrum.of}; expected that of a motion of the base, of="acceleration", …'
        )
    w, z, (c0, c1) = oscillator.w, oscillator.zeta, output
    A = PolynomialMatrix([[[w**2, 0], [-c0, 1]], [[2 * z * w, 0], [-c1, 0]], [[1, 0], [0, 0]]])
    names, unit = (("base",), (quantity,)), np.array([UNITS[quantity]])
    return RandomResponse(
        Harmonic(A, np.array([[1.0], [0.0]]), np.array([[0.0, 1.0]]), 2 - KINDS[spectrum.of], None, None, *names, unit, quantity),
        spectral_matrix({"base": spectrum}, None, None),
    )


def _histories(signal: ImpulsiveSmooth, oscillators) -> Iterator[np.ndarray]:
    """Turning points of each oscillator during a signal and after it."""
    samples = record_of_signal(signal)
    for oscillator, output in oscillators:
        own = _under_record(ShockRecord(*samples), oscillator, output) if samples else _under_signal(signal, oscillator, output)
        points, last = own
        yield np.concatenate([[0.0], points, _free(oscillator, output, *last)])


def _under_record(record: ShockRecord, oscillator: Oscillator, output) -> tuple[np.ndarray, tuple[float, float]]:
    """The response at samples and at turning points between them; y and y' at the end."""
    w, (c0, c1) = oscillator.w, output
    parts = np.maximum(np.ceil(record.h * w / STEP), 1).astype(int)
    if record.step is not None:  # even steps stay even, and are filtered
        parts[:] = parts.max()
    places = np.append(np.concatenate([k + np.arange(n) / n for k, n in enumerate(parts)]), len(parts))
    samples = np.arange(len(record.times))
    fine = ShockRecord(np.interp(places, samples, record.times), np.interp(places, samples, record.values))
    y, v = oscillator.states(fine)
    before, after = (
        (y[:-1], v[:-1], fine.values[:-1], fine.slopes),
        (y[1:], v[1:], fine.values[:-1] + fine.slopes * fine.h, fine.slopes),
    )
    first, last = oscillator._rates(*before, output), oscillator._rates(*after, output)
    (at,) = (first[2] * last[2] < 0).nonzero()
    y0, v0, a0, slope = (one[at] for one in before)
    tau = _root(fine.h[at], first[2][at], last[2][at], first[3][at], last[3][at])
    top = np.dot(output, oscillator.inside(y0, v0, a0, slope, tau)) if len(at) else []
    return np.insert(c0 * y + c1 * v, at + 1, top), (y[-1], v[-1])


def _under_signal(signal: ImpulsiveSmooth, oscillator: Oscillator, output) -> tuple[np.ndarray, tuple[float, float]]:
    function, end, last = oscillator.under(signal, output)
    return function(_times_with_turns(function, 0.0, end))[0], last


def _free(oscillator: Oscillator, output, y: float, v: float) -> np.ndarray:
    """Turning points of the free vibration from y and y': a geometric sequence of alternating sign."""
    first = float(oscillator._zero(*oscillator._rates(np.array(y), np.array(v), 0.0, 0.0, output)[2:4]))
    if not np.isfinite(first):
        return np.zeros(1)
    top = float(np.dot(output, oscillator.free(y, v, np.array(first))))
    if oscillator.zeta >= 1:
        return np.array([top, 0.0])
    decay = np.pi * oscillator.zeta / np.sqrt((1 - oscillator.zeta) * (1 + oscillator.zeta))
    count = min(int(np.log(1 / FREE_PART) / decay) + 2, MOST_FREE)
    return top * np.exp(-decay * np.arange(count)) * (-1.0) ** np.arange(count)
