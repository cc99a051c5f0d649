"""Peaks and antiresonances of each entry of a frequency response, and frequencies that resolve all of them.

Maxima of |H| are zeros of Re(i H'(i w) / H(i w)), which is computed from poles and residues: between frequencies that are placed by
the poles each change of its sign is refined to rounding error. Zeros of an entry are eigenvalues.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..ground.errors import InputError, SingularPolynomialMatrix
from ..ground.tolerances import AUTO_DISTANCE, EPS, ZERO_AGREEMENT
from ..polynomial.characteristic_roots import rightmost_roots
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .pole_residue_form import Pole, poles_on_axis

if TYPE_CHECKING:
    from .harmonic import Harmonic

#: Distances from a pole at which lines are placed, as multiples of its distance from the axis: the first ratio of the series, and how
#: many lines there are between a pole and twice its frequency at most.
FIRST, RATIO, MOST = 0.25, 1.5, 60

#: Lines for each decade between the poles, and how far the range goes beyond them.
EACH_DECADE, BEYOND = 40, 10.0

#: The sum of the modes and the solution at a peak agree to this share of it; what is larger is no peak but rounding errors.
PEAK_AGREEMENT = 0.01


@dataclass(frozen=True)
class Peak:
    """A maximum of |H| of one entry over the frequency.

    Attributes:
        output, input: names.
        frequency_hz: in Hz.
        amplitude: |H|; infinite at a pole on the axis.
        bandwidth_hz: between the two frequencies with |H| = amplitude / sqrt(2); None where |H| does not fall so far on both sides.
        phase: phase of H, in rad; at a pole on the axis just below it.
        grows: whether the eigenvalue nearest to the peak lies in the right half plane: the peak is that of a motion that is not reached.
    """

    output: str
    input: str
    frequency_hz: float
    amplitude: float
    bandwidth_hz: float | None
    phase: float
    grows: bool = False

    @property
    def damping_ratio(self) -> float | None:
        """bandwidth / (2 frequency), negative next to an eigenvalue that grows; None without a bandwidth."""
        if self.bandwidth_hz is None:
            return None
        return (-1.0 if self.grows else 1.0) * self.bandwidth_hz / (2 * self.frequency_hz)


@dataclass(frozen=True)
class Antiresonance:
    """An oscillating zero of one entry, H(zero) = 0.

    Attributes:
        output, input: names.
        zero: in 1/s, above the real axis.
    """

    output: str
    input: str
    zero: complex

    @property
    def frequency_hz(self) -> float:
        """Frequency in Hz, Im zero / (2 pi): |H| vanishes there for a zero on the axis, and has a minimum near a close one."""
        return self.zero.imag / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re zero / |zero|, negative in the right half plane."""
        return -self.zero.real / abs(self.zero)


#: Characteristic roots of equations with delays for each coordinate, the rightmost ones.
ROOTS = 3


def poles_of(harmonic: Harmonic) -> tuple[Pole, ...]:
    """The poles; with delays the rightmost characteristic roots, without residues, or the poles without the delayed terms."""
    if not harmonic.delayed:
        return harmonic.form.poles
    try:
        values = rightmost_roots(harmonic.A, harmonic.delayed, ROOTS * harmonic.A.size).eigenvalues
    except InputError:  # of neutral type, or too many
        values = harmonic.A.eigenvalues
    residues = np.zeros((1, len(harmonic.outputs), harmonic.inputs.shape[1]))
    return tuple(Pole(complex(value), residues, None) for value in values)


def frequencies_by_poles(harmonic: Harmonic, with_peaks: bool = True) -> np.ndarray:
    """Frequencies in Hz from a decade below the poles to a decade above, dense where a pole is near the axis, and all peaks."""
    poles = poles_of(harmonic)
    moduli = np.array([abs(pole.value) for pole in poles if pole.value]) if poles else np.zeros(0)
    low, high = (moduli.min(), moduli.max()) if len(moduli) else (1.0, 1.0)
    decades = np.log10(high / low) + 2 * np.log10(BEYOND)
    lines = [np.geomspace(low / BEYOND, high * BEYOND, int(EACH_DECADE * decades) + 2)]
    steps = FIRST * RATIO ** np.arange(MOST)
    for pole in poles:
        if pole.value.imag > 0:
            scale = max(abs(pole.value.real), AUTO_DISTANCE * pole.value.imag)
            offsets = scale * steps
            offsets = offsets[offsets < pole.value.imag]
            lines.append(pole.value.imag + np.concatenate([-offsets, offsets]))
            if abs(pole.value.real) >= AUTO_DISTANCE * pole.value.imag:
                lines.append(np.array([pole.value.imag]))
    if with_peaks:
        lines.append(np.array([2 * np.pi * peak.frequency_hz for peak in peaks_of(harmonic) if np.isfinite(peak.amplitude)]))
    omega = np.unique(np.concatenate(lines))
    on_axis = np.array([pole.value.imag for pole in poles_on_axis(poles)])
    if len(on_axis):
        omega = omega[np.abs(omega[:, None] - on_axis).min(axis=1) > AUTO_DISTANCE * EPS**0.5 * omega]
    return omega[omega > 0] / (2 * np.pi)


def peaks_of(harmonic: Harmonic) -> Iterator[Peak]:
    """The maxima of |H| of each entry, those at poles on the axis first; dead times of inputs turn the phases."""
    late = dict(zip(harmonic.input_names, harmonic.input_delays))
    for peak in _undelayed_peaks(harmonic):
        turned = peak.phase - 2 * np.pi * peak.frequency_hz * late.get(peak.input, 0.0)
        yield replace(peak, phase=float(np.angle(np.exp(1j * turned)))) if late else peak


def _undelayed_peaks(harmonic: Harmonic) -> Iterator[Peak]:
    poles, grid = poles_of(harmonic), 2 * np.pi * frequencies_by_poles(harmonic, with_peaks=False)
    for i, output in enumerate(harmonic.output_names):
        for j, input in enumerate(harmonic.input_names):
            entry = _DelayedEntry(harmonic, i, j) if harmonic.delayed else _ResponseEntry(harmonic, poles, i, j)
            for pole in poles_on_axis(poles):
                if pole.value.imag and pole.residues[-1, i, j]:
                    phase = float(np.angle(pole.residues[-1, i, j] * (1j) ** pole.order))
                    yield Peak(output, input, pole.value.imag / (2 * np.pi), np.inf, 0.0, phase)
            for peak in _maxima(entry, grid, output, input):
                yield replace(peak, grows=_grows(poles, peak))


def _grows(poles: tuple[Pole, ...], peak: Peak) -> bool:
    at = 2j * np.pi * peak.frequency_hz
    return bool(poles) and min((pole.value for pole in poles), key=lambda value: abs(value - at)).real > 0


def _maxima(entry: _ResponseEntry, grid, output: str, input: str) -> Iterator[Peak]:
    slopes = entry.slope(grid)
    if not np.isfinite(slopes).all():  # an entry that is zero has no peaks
        return
    signs = np.sign(slopes)
    for at in np.flatnonzero((signs[:-1] > 0) & (signs[1:] < 0)):
        if entry.has_pole_between(grid[at], grid[at + 1]):
            continue
        peak = _root(lambda w: float(entry.slope(np.array([w]))[0]), grid[at], grid[at + 1])
        if peak is None:  # a sign of rounding errors
            continue
        value = entry.value(peak)
        if not abs(entry.sums(np.array([peak]))[0][0] - value) <= PEAK_AGREEMENT * abs(value):
            continue  # of the rounding errors of residues, in an entry that is zero
        rising = np.flatnonzero(signs[: at + 1] < 0)
        falling = np.flatnonzero(signs[at + 1 :] > 0)
        low = grid[rising[-1] + 1] if len(rising) else grid[0]
        high = grid[at + falling[0]] if len(falling) else grid[-1]
        ends = [entry.half_power(peak, end, abs(value)) for end in (low, high)]
        width = None if None in ends else (ends[1] - ends[0]) / (2 * np.pi)
        yield Peak(output, input, peak / (2 * np.pi), abs(value), width, float(np.angle(value)))


def _root(function, low: float, high: float) -> float | None:
    """The sign change of a function between two points, to rounding error; None where both signs are one.

    In a stop band the terms cancel, and the sign of what is left differs from one order of the sum to another.
    """
    from scipy.optimize import brentq

    if not function(low) * function(high) <= 0:
        return None
    return float(brentq(function, low, high, rtol=4 * EPS, xtol=EPS * high))


class _ResponseEntry:
    """An entry of H by its poles and residues, and by solutions."""

    def __init__(self, harmonic: Harmonic, poles: tuple[Pole, ...], i: int, j: int):
        self.harmonic, self.place = harmonic, (i, j)
        self.terms = [(pole.value, k + 1, pole.residues[k, i, j]) for pole in poles for k in range(pole.order)]
        self.terms = [term for term in self.terms if term[2]]
        self.values = np.array([value for value, _, _ in self.terms])[:, None]
        self.orders = np.array([order for _, order, _ in self.terms])[:, None]
        self.residues = np.array([residue for _, _, residue in self.terms])[:, None]
        self.polynomial = harmonic.form.polynomial[:, i, j]

    def sums(self, omega) -> tuple[np.ndarray, np.ndarray]:
        """H and its derivative by s."""
        s = 1j * np.asarray(omega)
        distance = 1 / (s - self.values)
        each = self.residues * distance**self.orders
        D = self.polynomial[:, None] * np.ones(len(s))
        powers = np.arange(len(D))[:, None]
        H = each.sum(axis=0) + (D * s**powers).sum(axis=0)
        slope = -(self.orders * each * distance).sum(axis=0)
        return H, slope + (powers[1:] * D[1:] * s ** (powers[1:] - 1)).sum(axis=0)

    def slope(self, omega) -> np.ndarray:
        """d log|H| / dw."""
        H, derivative = self.sums(omega)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.real(1j * derivative / H)

    def value(self, omega: float) -> complex:
        """H by a solution."""
        lines = self.harmonic.solver.solve(np.array([omega]))
        return complex(lines.values[(*self.place, 0)] * (1j * omega) ** self.harmonic.power)

    def has_pole_between(self, low: float, high: float) -> bool:
        """Whether |H| is infinite in an interval."""
        return any(low <= value.imag <= high and abs(value.real) <= AUTO_DISTANCE * EPS**0.5 * high for value, _, _ in self.terms)

    def half_power(self, peak: float, end: float, amplitude: float) -> float | None:
        """The frequency between a peak and the end of its slope where |H|^2 is half of its maximum."""

        def excess(w: float) -> float:
            return abs(self.sums(np.array([w]))[0][0]) ** 2 / amplitude**2 - 0.5

        return _root(excess, *sorted((peak, end))) if excess(end) < 0 else None


class _DelayedEntry(_ResponseEntry):
    """An entry of H with delays, by solutions."""

    def __init__(self, harmonic: Harmonic, i: int, j: int):
        self.harmonic, self.place, self.terms = harmonic, (i, j), []

    def sums(self, omega) -> tuple[np.ndarray, np.ndarray]:
        own, (i, j) = self.harmonic, self.place
        s = 1j * np.asarray(omega)[:, None, None]
        A, slope = 0j, 0j
        for k, matrix in enumerate(own.coefficients):
            A, slope = A + s**k * matrix, slope + (k * s ** (k - 1) * matrix if k else 0)
        for term in own.delayed:
            turned = np.exp(-s * term.delay)
            for k, matrix in enumerate(term.coefficients):
                rate = k * s ** (k - 1) if k else 0
                A, slope = A + turned * s**k * matrix, slope + turned * (rate - term.delay * s**k) * matrix
        X = np.linalg.solve(A, np.broadcast_to(own.inputs[:, [j]], (len(s), len(own.inputs), 1)))
        moved = np.linalg.solve(A, -slope @ X)
        H, rate = ((own.outputs[i] @ one)[:, 0] for one in (X, moved))
        s, p = s[:, 0, 0], own.power
        return s**p * H, s**p * rate + (p * s ** (p - 1) * H if p else 0)


def antiresonances_of(harmonic: Harmonic) -> Iterator[Antiresonance]:
    """The oscillating zeros of each entry, ascending by frequency."""
    if harmonic.delayed:
        raise InputError(
            "antiresonances: not available for equations with delays, whose zeros are infinitely many; see the minima of |H|"
        )
    poles = harmonic.form.poles
    for i, output in enumerate(harmonic.output_names):
        for j, input in enumerate(harmonic.input_names):
            entry = _ResponseEntry(harmonic, poles, i, j)
            for zero in _zeros(harmonic, i, j):
                if zero.imag > 0 and _vanishes(entry, zero):
                    yield Antiresonance(output, input, zero)


def _zeros(harmonic: Harmonic, i: int, j: int) -> list[complex]:
    """Zeros of det [[A(s), -b], [c, 0]], with a complex A(s) in its real form."""
    A, inputs, outputs = harmonic.real
    b, c, r = inputs[:, [j]], outputs[[i]], A.size
    if np.iscomplexobj(c):
        half = r // 2
        b = np.hstack([b, np.roll(b, half, axis=0)])
        c = np.vstack([c.real, np.hstack([0 * c.real[:, half:], c.real[:, :half]])])
    coefficients = [np.pad(matrix, ((0, b.shape[1]),) * 2) for matrix in A.coefficients]
    coefficients[0][:r, r:], coefficients[0][r:, :r] = -b, c
    try:
        zeros = PolynomialMatrix(coefficients).jordan_pairs().structure.finite_zeros
    except SingularPolynomialMatrix:  # H = 0
        return []
    return sorted((zero.value for zero in zeros), key=lambda root: (root.imag, root.real))


def _vanishes(entry: _ResponseEntry, zero: complex) -> bool:
    """Whether the entry itself vanishes: an eigenvalue that it does not contain is a zero of the determinant as well."""
    s = complex(zero)
    distances = s - entry.values[:, 0]
    if (np.abs(distances) <= ZERO_AGREEMENT * abs(s)).any():
        return False
    each = entry.residues[:, 0] / distances ** entry.orders[:, 0]
    polynomial = entry.polynomial * s ** np.arange(len(entry.polynomial))
    total, size = each.sum() + polynomial.sum(), np.abs(each).sum() + np.abs(polynomial).sum()
    return bool(size > 0 and abs(total) <= ZERO_AGREEMENT * size)
