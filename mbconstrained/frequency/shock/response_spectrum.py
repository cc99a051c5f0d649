"""Shock response spectra: the peaks of single oscillators on a base that follows a signal, over their natural frequency."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...ground.checks import counted, nearest, optional_package, real_array, real_number
from ...ground.display import Displayed
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, STEP_AGREEMENT
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...response.solve import solve
from ...signals.exact_inputs import ExactRecord
from ...signals.impulsive import ImpulsiveSmooth
from .extrema import extrema
from .oscillator import Oscillator

#: Quantities as (c_0, c_1) of c_0 y + c_1 y', where -y is the displacement relative to the base.
QUANTITIES = {
    "absolute acceleration": lambda o: (o.w**2, 2 * o.zeta * o.w),
    "relative displacement": lambda o: (-1.0, 0.0),
    "relative velocity": lambda o: (0.0, -1.0),
    "pseudo-velocity": lambda o: (-o.w, 0.0),
    "pseudo-acceleration": lambda o: (-(o.w**2), 0.0),
}
UNITS = dict(zip(QUANTITIES, ("m/s^2", "m", "m/s", "m/s", "m/s^2")))

INTERPOLATIONS = ("linear", "band-limited")

#: The spectra that a shock response spectrum has.
PARTS = ("maximax", "positive", "negative", "primary", "residual")

#: A band-limited record is resampled so that a period of the highest frequency of the spectrum has so many samples, at most so many times.
SAMPLES_OF_PERIOD, MOST_SAMPLES = 40, 64

#: A signal has ended where it is smaller than so many rounding errors of its largest value.
ENDED = 1e3


@dataclass(frozen=True, repr=False, eq=False)
class ShockResponseSpectrum(Displayed):
    """Peaks of oscillators z'' + 2 zeta w z' + w^2 z = -a(t) on a base with the acceleration a.

    Attributes:
        frequencies_hz: natural frequencies, shape (F,).
        damping_ratio: zeta.
        quantity: quantity of the peaks.
        primary_positive, primary_negative: largest values and moduli of the smallest ones during the shock, shape (F,).
        residual_positive, residual_negative: largest positive and negative peak after its end.
        notices: notices on the interpretation of the signal.

    >>> import mbconstrained as mb
    >>> step = mb.pulse([1.0], duration=1000.0)  # a step doubles: an undamped oscillator has the peak 2
    >>> float(mb.shock_response_spectrum(step, [1.0], damping_ratio=0.0).maximax[0].round(9))
    2.0
    """

    frequencies_hz: np.ndarray
    damping_ratio: float
    quantity: str
    primary_positive: np.ndarray
    primary_negative: np.ndarray
    residual_positive: np.ndarray
    residual_negative: np.ndarray
    notices: tuple[Notice, ...] = field(default=())

    def _summary(self) -> str:
        return f"{self.quantity}, {counted(len(self.frequencies_hz), 'frequency', 'frequencies')}, damping ratio {self.damping_ratio:g}"

    @property
    def unit(self) -> str:
        """Unit of the values, for a base acceleration in m/s^2."""
        return UNITS[self.quantity]

    @property
    def positive(self) -> np.ndarray:
        """Largest values at any time, shape (F,)."""
        return np.maximum(self.primary_positive, self.residual_positive)

    @property
    def negative(self) -> np.ndarray:
        """Moduli of the smallest values at any time, shape (F,)."""
        return np.maximum(self.primary_negative, self.residual_negative)

    @property
    def primary(self) -> np.ndarray:
        """Largest moduli during the shock, shape (F,)."""
        return np.maximum(self.primary_positive, self.primary_negative)

    @property
    def residual(self) -> np.ndarray:
        """Largest moduli after the shock, shape (F,)."""
        return np.maximum(self.residual_positive, self.residual_negative)

    @property
    def maximax(self) -> np.ndarray:
        """Largest moduli at any time, shape (F,)."""
        return np.maximum(self.primary, self.residual)

    def to_xarray(self):
        """Return all parts as a ``DataArray`` with the dimensions part and frequency (Hz).

        Returns:
            An ``xarray.DataArray``; its attributes are the unit and the damping ratio.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        coords = {"part": list(PARTS), "frequency": ("frequency", self.frequencies_hz, {"units": "Hz"})}
        attributes = {"units": self.unit, "damping_ratio": self.damping_ratio}
        values = [getattr(self, part) for part in PARTS]
        return xarray.DataArray(values, coords, ("part", "frequency"), self.quantity, attributes)


def shock_response_spectrum(
    signal: ImpulsiveSmooth,
    frequencies_hz,
    damping_ratio: float = 0.05,
    quantity: str = "absolute acceleration",
    interpolation: str = "linear",
    quality_factor: float | None = None,
) -> ShockResponseSpectrum:
    """The shock response spectrum of a base acceleration, from the true extrema of the closed-form motion.

    Args:
        signal: acceleration of the base in one row: ``mb.sampled`` records (piecewise linear, any spacing), ``mb.pulse``, or sums of other inputs with
            an end, such as half sines.
        frequencies_hz: natural frequencies of the oscillators, shape (F,).
        damping_ratio: zeta >= 0, of any size.
        quantity: "absolute acceleration", "relative displacement", "relative velocity", "pseudo-velocity" or "pseudo-acceleration".
        interpolation: of a record: "linear" between samples, or "band-limited" (evenly spaced samples of a signal without frequencies above half of
            their rate, resampled by the Fourier transform).
        quality_factor: Q = 1 / (2 zeta), in the place of the damping ratio.

    Returns:
        A ``ShockResponseSpectrum``: ``maximax``, ``positive``, ``negative``, ``primary``, ``residual``.

    Raises:
        InputError: several rows, frequencies that are not positive, a signal without an end.

    A half sine of 1 m/s^2; its largest peak is 1.76846 at f T = 0.80994:

    >>> import mbconstrained as mb
    >>> half = mb.harmonic([1.0], angular_frequency=np.pi, phase=-np.pi / 2)  # sin(pi t), T = 1 s
    >>> peak = mb.shock_response_spectrum(half + half.delayed(1.0), [0.80993678585149450784], damping_ratio=0.0)
    >>> float(peak.maximax[0].round(12))
    1.768457653994
    """
    f, zeta = _checked(signal, frequencies_hz, damping_ratio, quality_factor)
    if quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    if interpolation not in INTERPOLATIONS:
        raise InputError(f"interpolation: found {interpolation!r}; expected one of {', '.join(INTERPOLATIONS)}")
    record, notices = _record(signal), []
    if record is not None:
        times, values = record
        if interpolation == "band-limited":
            times, values = _resampled(times, values, float(f.max()))
            text = f"the record is read as band-limited, resampled to {counted(len(times), 'sample')}"
        else:
            text = 'the record is read as linear between its samples; interpolation="band-limited" reads it without frequencies above half of its rate'
        notices.append(Notice(NoticeKind.ACCURACY, text))
    rows = []
    for own in f:
        oscillator = Oscillator(2 * np.pi * float(own), zeta)
        output = QUANTITIES[quantity](oscillator)
        rows.append(
            oscillator.peaks(times, values, output) if record is not None else _closed_form_peaks(signal, oscillator, output)
        )
    high, low, after_high, after_low = np.array(rows).reshape(-1, 4).T
    return ShockResponseSpectrum(f, zeta, quantity, high, 0.0 - low, after_high, 0.0 - after_low, tuple(notices))


def _checked(signal, frequencies_hz, damping_ratio, quality_factor) -> tuple[np.ndarray, float]:
    """Frequencies in Hz and the damping ratio."""
    if not isinstance(signal, ImpulsiveSmooth):
        raise InputError(
            f"signal: found an object of type {type(signal).__name__}; expected an input such as mb.sampled(times, values)"
        )
    if signal.size != 1:
        raise InputError(f"signal: found {signal.size} rows; expected the acceleration of the base in one row")
    f = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
    if f.ndim != 1 or not (f > 0).all():
        raise InputError("frequencies_hz: expected a list of positive natural frequencies in Hz")
    if quality_factor is not None:
        return f, 1 / (2 * real_number(quality_factor, "quality_factor", positive=True))
    return f, real_number(damping_ratio, "damping_ratio", minimum=0.0)


def _record(signal: ImpulsiveSmooth) -> tuple[np.ndarray, np.ndarray] | None:
    """Times and values of a signal that is one record."""
    parts = signal.exact_parts
    if len(parts) != 1 or not isinstance(parts[0].data, ExactRecord) or parts[0].derivatives:
        return None
    values = parts[0].data.values
    for factor in parts[0].maps:
        values = factor @ values if np.ndim(factor) else factor * values
    return parts[0].data.times + parts[0].rounded_time(), values[0]


def _resampled(times: np.ndarray, values: np.ndarray, highest: float) -> tuple[np.ndarray, np.ndarray]:
    """A band-limited record with more samples, zeros around it."""
    from scipy.signal import resample

    h = np.diff(times)
    if np.ptp(h) > STEP_AGREEMENT * h.max():
        raise InputError('interpolation: "band-limited" expects evenly spaced samples; those of this record are uneven')
    step = (times[-1] - times[0]) / len(h)
    factor = int(np.clip(np.ceil(SAMPLES_OF_PERIOD * highest * step), 1, MOST_SAMPLES))
    padded = np.pad(values, (0, len(values)))
    fine = resample(padded, factor * len(padded))[: factor * (len(values) - 1) + 1]
    return times[0] + step / factor * np.arange(len(fine)), fine


def _closed_form_peaks(signal: ImpulsiveSmooth, oscillator: Oscillator, output) -> tuple[float, float, float, float]:
    """Peaks during and after a signal that is zero after its last knot."""
    knots = np.asarray(signal.knots, dtype=float)
    end = float(knots[-1]) if len(knots) else 0.0
    later = np.abs(signal(end + np.linspace(0.0, max(end, 1.0), 9)[1:])).max()
    during = np.abs(signal(np.linspace(0.0, end, 257))).max() if end else 0.0
    if not end or later > ENDED * EPS * during:
        raise InputError("signal: it does not end; expected a record or a pulse, which is zero after some time")
    w, z = oscillator.w, oscillator.zeta
    x = solve(PolynomialMatrix([[[w**2]], [[2 * z * w]], [[1.0]]]), force=signal)
    c0, c1 = output
    peaks = extrema(x.function.differential(np.array([[c0]]), np.array([[c1]])), 0.0, end)
    last = float(x(np.array([end]))[0, 0]), float(x.derivative(1)(np.array([end]))[0, 0])
    after = oscillator.residual(*last, output)
    return max(float(peaks.maximum[0]), 0.0), min(float(peaks.minimum[0]), 0.0), *after
