"""The steady state under constant and harmonic loads, or under a periodic record: amplitude and phase of every coordinate and reaction.

    f(t) = Re sum of F_l e^{i w_l t}  gives  x(t) = Re sum of H(i w_l) F_l e^{i w_l t}

A record that is linear between its samples and repeated with a period has the Fourier coefficients of its corners and jumps in closed
form; each harmonic is exact, and so is its answer. Their sum converges slowly where loads jump: values in time are those of the motion
in one period that ends as it begins, z(T) = Phi z(0) + g, z(0) = (1 - Phi)^-1 g, in closed form.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...frequency.frequency_response import evaluated
from ...frequency.harmonic import Harmonic
from ...ground.checks import counted, real_array, real_number, whole_number
from ...ground.coordinate_units import force_unit
from ...ground.display import Displayed, TextTable, number_text
from ...ground.errors import InputError
from ...ground.tolerances import SAME_FREQUENCY
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.impulsive import ExactInput, ExactRecord, ExactTerm, ImpulsiveSmooth
from ..equations import EquationsOfMotion
from .harmonic_equations import saddle_point

if TYPE_CHECKING:
    from ..motion import Motion

#: Harmonics of a periodic record, where their number is not given.
HARMONICS = 50


@dataclass(frozen=True, repr=False, eq=False)
class SteadyState(Displayed):
    """Steady state x(t) = Re sum of displacement_amplitudes e^{i w t}, after all free motion has decayed; lambda likewise.

    Attributes:
        names, rows: names and rows of the coordinates and of the constraint rows.
        frequencies_hz: w / (2 pi), ascending, shape (L,); 0 for the mean.
        displacement_amplitudes: complex, shape (n, L).
        reaction_amplitudes: complex, shape (k, L).
        error_estimate: the largest relative error of the amplitudes at each frequency, relative to the largest of them, shape (L,).
        units: units of the coordinates and of the reactions, by name.
        period: T in s of records; None for harmonic loads.
        motion: the motion in one period in closed form, where all loads repeat with it; None where values in time are sums of harmonics.

    The amplitudes and phases are ``abs`` and ``numpy.angle`` of the complex ones.

    >>> import mbconstrained as mb
    >>> system = mb.MechanicalSystem([[1.0]], [[0.5]], [[4.0]])
    >>> steady = system.steady_state(mb.harmonic([3.0], angular_frequency=2.0))  # at resonance c w x = 3
    >>> bool(np.isclose(abs(steady.displacement_amplitudes[0, 0]), 3.0)), bool(np.isclose(steady.displacement(np.pi / 4)[0], 3.0))
    (True, True)
    """

    names: tuple[str, ...]
    rows: tuple[str, ...]
    frequencies_hz: np.ndarray
    displacement_amplitudes: np.ndarray
    reaction_amplitudes: np.ndarray
    error_estimate: np.ndarray
    units: dict[str, str]
    period: float | None = None
    motion: Motion | None = None

    def _summary(self) -> str:
        lines = counted(len(self.frequencies_hz), "frequency", "frequencies")
        return f"{counted(len(self.names), 'coordinate')}, {lines}"

    def _tables(self) -> tuple[TextTable, ...]:
        cells = []
        for names, amplitudes in ((self.names, self.displacement_amplitudes), (self.rows, self.reaction_amplitudes)):
            for name, row in zip(names, amplitudes):
                for f, z in zip(self.frequencies_hz, row):
                    cells.append((name, number_text(f), f"{abs(z):.6g} {self.units[name]}", f"{np.degrees(np.angle(z)):.2f}"))
        return (TextTable("Steady state", ("of", "frequency (Hz)", "amplitude", "phase (°)"), tuple(cells)),)

    @property
    def angular_frequencies(self) -> np.ndarray:
        """w in rad/s, shape (L,)."""
        return 2 * np.pi * self.frequencies_hz

    def displacement(self, times) -> np.ndarray:
        """x at times in s, shape (n,) or (n, T)."""
        if self.motion is not None:
            return self.motion.displacement(self._in_period(times))
        return self._sum(self.displacement_amplitudes, times)

    def velocity(self, times) -> np.ndarray:
        """x' at times in s, shape (n,) or (n, T)."""
        if self.motion is not None:
            return self.motion.velocity(self._in_period(times))
        return self._sum(1j * self.angular_frequencies * self.displacement_amplitudes, times)

    def reaction(self, times) -> np.ndarray:
        """The reactions of the constraint rows at times in s, shape (k,) or (k, T), without their Dirac impulses."""
        if self.motion is not None:
            return self.motion.reaction(self._in_period(times))
        return self._sum(self.reaction_amplitudes, times)

    def deflection_shape(self, frequency_hz: float) -> np.ndarray:
        """The operating deflection shape at one of the frequencies: complex amplitudes of all coordinates, shape (n,).

        Args:
            frequency_hz: one of ``frequencies_hz``, in Hz.

        Returns:
            x(t) = Re(shape e^{i w t}); of a robot ``linear.output_matrix @ shape`` has that of its points.

        Raises:
            InputError: no load has this frequency.
        """
        f = real_number(frequency_hz, "frequency_hz", minimum=0.0)
        near = np.flatnonzero(np.abs(self.frequencies_hz - f) <= SAME_FREQUENCY * f)
        if not len(near):
            known = ", ".join(number_text(one) for one in self.frequencies_hz[:6])
            raise InputError(
                f"frequency_hz: no load has {f:g} Hz; expected one of {known}{', ...' * (len(self.frequencies_hz) > 6)}"
            )
        return self.displacement_amplitudes[:, near[0]].copy()

    def _in_period(self, times) -> np.ndarray:
        return np.mod(real_array(times, "times"), self.period)

    @cached_property
    def _turning(self) -> np.ndarray:
        return 1j * self.angular_frequencies

    def _sum(self, amplitudes, times) -> np.ndarray:
        times = real_array(times, "times")
        return np.real(amplitudes @ np.exp(np.multiply.outer(self._turning, times)))


def steady_state(
    system: EquationsOfMotion,
    force: ImpulsiveSmooth | None = None,
    period: float | None = None,
    harmonics: int = HARMONICS,
    modal_damping=None,
    loss_factor=None,
) -> SteadyState:
    """The motion under harmonic loads after all free motion has decayed: amplitude and phase of every coordinate and reaction.

    The static force of the system, its own excitation and the values of its constraint rows count too.
    """
    if system.is_sparse:
        raise InputError("steady_state: not available for sparse matrices; give arrays, as mass.toarray()")
    if period is not None:
        period, harmonics = real_number(period, "period", positive=True), whole_number(harmonics, "harmonics", minimum=1)
    n, rows = system.size, system.rows
    loads: dict[float, np.ndarray] = defaultdict(lambda: np.zeros(n + len(rows), dtype=complex))
    for omega, amplitude in _spectrum(system._applied(force), period, harmonics):
        loads[omega][:n] += amplitude
    for place, row in enumerate(rows, start=n):
        loads[0.0][place] += row.value
        for omega, amplitude in _spectrum(row.signal, period, harmonics) if getattr(row, "signal", None) is not None else ():
            loads[omega][place] += amplitude[0]
    omegas = sorted(omega for omega, load in loads.items() if load.any())
    coefficients, imaginary, sizes = saddle_point(system, [row.order for row in rows], modal_damping, loss_factor)
    names = (*system.names, *(row.name for row in rows))
    A, C = PolynomialMatrix(coefficients, names), np.diag(np.repeat([1.0, -1.0], [n, len(rows)]))
    answers, errors = np.zeros((len(C), len(omegas)), dtype=complex), np.zeros(len(omegas))
    for line, omega in enumerate(omegas):
        parts = np.stack([loads[omega].real, loads[omega].imag], axis=1)
        structural = imaginary if omega else None
        own = Harmonic(A, parts, C, 0, structural, sizes, ("real part", "imaginary part"), names, np.full((len(C), 2), ""))
        H = evaluated(own, [omega / (2 * np.pi)])
        if H.poles_on_lines:
            raise InputError(
                f"force: at {number_text(omega / (2 * np.pi))} Hz it acts on an undamped motion of this frequency, which grows; "
                "there is no steady state without damping"
            )
        answers[:, line] = H.values[..., 0] @ [1.0, 1j]
        size = np.abs(H.values[..., 0])
        errors[line] = (H.error_estimate[..., 0] * size).max() / max(size.max(), np.finfo(float).tiny)
    units = {**system.units, **{row.name: force_unit(row.unit) for row in rows}}
    f = np.array(omegas) / (2 * np.pi)
    motion = None
    if period is not None and not (loss_factor or system.loss_factors) and _repeats(omegas, period):
        damped = system if modal_damping is None else system.with_modal_damping(modal_damping)
        motion = _periodic_motion(damped, force, period)
    return SteadyState(system.names, names[n:], f, answers[:n], answers[n:], errors, units, period, motion)


def _repeats(omegas, period: float) -> bool:
    """Whether all loads have a whole number of oscillations in a period."""
    turns = np.array(omegas) * period / (2 * np.pi)
    return bool((np.abs(turns - np.rint(turns)) <= SAME_FREQUENCY * np.maximum(turns, 1.0)).all())


def _periodic_motion(system: EquationsOfMotion, force: ImpulsiveSmooth | None, period: float) -> Motion | None:
    """The motion whose values just before the end of a period equal those at its start; None where it is not determined."""
    n = system.size
    forced = system.solve(force=force)
    end = np.array([forced.displacement(period), forced.velocity(period)])
    before = end - sum(
        (one.jump[:2] for one in forced.events if abs(one.time - period) <= SAME_FREQUENCY * period), np.zeros((2, n))
    )
    starts = np.concatenate([np.eye(n), np.zeros((n, n))]), np.concatenate([np.zeros((n, n)), np.eye(n)])
    several = system.solve(*starts, force=force)
    transition = np.hstack([several.displacement(period), several.velocity(period)]) - end.reshape(-1)
    try:
        start = np.linalg.solve(np.eye(2 * n) - transition.T, before.reshape(-1))
    except np.linalg.LinAlgError:
        return None
    return system.solve(start[:n], start[n:], force=force)


def _spectrum(signal: ImpulsiveSmooth, period: float | None, harmonics: int) -> Iterator[tuple[float, np.ndarray]]:
    """Angular frequencies w and amplitudes F of f(t) = Re sum of F e^{i w t}, F of shape (r,)."""
    for part in signal.exact_parts:
        data = part.data
        if part.derivatives == 0 and isinstance(data, ExactTerm) and not data.power and not data.rate:
            turn = np.exp(1j * (data.phase - data.angular_frequency * part.rounded_time()))
            vector = _mapped(part, data.vector) / data.divisor
            negative = data.angular_frequency < 0
            yield abs(data.angular_frequency), vector * (turn.conj() if negative else turn if data.angular_frequency else turn.real)
        elif part.derivatives == 0 and isinstance(data, ExactRecord) and period is not None:
            times = data.times + part.rounded_time()
            if times[0] < 0 or times[-1] > period * (1 + np.finfo(float).eps):
                raise InputError(
                    f"period: found {period:g} s; the samples of a record reach from {times[0]:g} s to {times[-1]:g} s"
                )
            for k in range(harmonics + 1):
                yield 2 * np.pi * k / period, _mapped(part, fourier_coefficient(times, data.values, period, k))
        else:
            raise InputError(
                "force: a steady state needs constant and harmonic loads (mb.step, mb.harmonic), or records (mb.sampled) with a period"
            )


def _mapped(part: ExactInput, vector: np.ndarray) -> np.ndarray:
    for factor in part.maps:
        vector = factor @ vector if np.ndim(factor) else factor * vector
    return vector


def fourier_coefficient(times, values, period: float, order: int) -> np.ndarray:
    """F_k of f(t) = Re sum of F_k e^{2 pi i k t / T}, of samples joined by straight lines, zero outside them, repeated with T.

    Over a line from a to b the integral of f e^{-i w t} is h e^{-i w m} ((a + b)/2 even(y) - i (b - a)/2 odd(y)), m its middle; the
    functions of w h / 2 are taken without cancellation.
    """
    h, w = np.diff(times), 2 * np.pi * order / period
    middle, mean, half = (times[1:] + times[:-1]) / 2, (values[:, 1:] + values[:, :-1]) / 2, np.diff(values, axis=1) / 2
    y = w * h / 2  # on the line f = mean + half u, u from -1 to 1: the integrals of cos(y u) and u sin(y u)
    even, odd = np.sinc(y / np.pi), _first_moment(y)
    total = ((mean * even - 1j * half * odd) * (h * np.exp(-1j * w * middle))).sum(axis=1)
    return total / period * (1 if order == 0 else 2)


def _first_moment(y: np.ndarray) -> np.ndarray:
    """(sin y - y cos y) / y^2, half the integral of u sin(y u) over [-1, 1]; its series for small y."""
    small = np.abs(y) < 1
    safe = np.where(small, 1.0, y)
    series, term = np.zeros_like(y), y / 3
    for k in range(1, 12):
        series = series + term
        term = -term * y**2 / (2 * k * (2 * k + 3))
    return np.where(small, series, (np.sin(safe) - safe * np.cos(safe)) / safe**2)
