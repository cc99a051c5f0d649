"""The stationary response to random excitation: covariance, spectral moments, rates, extremes, fatigue."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted, nearest, optional_package, real_array, real_number, whole_number
from ...ground.display import Displayed, TextTable, notice_table, number_text
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, FLOAT64_DIGITS, PROVED_ACCURACY, REPORTED_ERROR, TRUST_LIMIT
from ..frequency_response import evaluated
from ..harmonic import Harmonic
from . import nonstationary, statistics
from .independent_inputs import independent_inputs
from .infinite_variance import Existence, existence
from .spectral_integral import SpectralIntegral, spectral_integral
from .spectral_matrix import SpectralMatrix
from .transfer import SpectralTransfer

if TYPE_CHECKING:
    from ...exact.enclosure.intervals import Enclosure

#: Variances of models with at most so many states squared times inputs are computed exactly: always (about 10 ms), and where their sums of residues
#: leave a doubt (about 0.1 s).
ALWAYS_PROVED, MOST_PROVED = 256, 2048


@dataclass(frozen=True, repr=False, eq=False)
class RandomResponse(Displayed):
    """Stationary Gaussian outputs of zero mean, with the one-sided spectra G_y = H G_u H^H per Hz.

        E[y y^T] = Re integral from 0 to infinity of H(2 pi i f) G_u(f) H(2 pi i f)^H df

    The integrals are exact: logarithms and arc tangents of the poles near each panel of the frequency axis, Gauss's rule for what has no singularity
    there.

    Attributes:
        harmonic: the matrices of H, from the random inputs to the outputs.
        spectra: G_u.

    >>> import mbconstrained as mb
    >>> system = mb.MechanicalSystem([[1.0]], [[0.2]], [[4.0]])
    >>> R = system.random_response({"x1": mb.white_noise(3.2)})  # E[x^2] = G / (4 c k)
    >>> bool(np.isclose(R.rms[0], 1.0, rtol=1e-13)), R.units, R.infinite
    (True, ('m',), {})
    """

    harmonic: Harmonic
    spectra: SpectralMatrix

    def _summary(self) -> str:
        return f"{self.quantity}, {counted(len(self.outputs), 'output')}, {counted(len(self.inputs), 'random input')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table, notice_table(self.notices))

    @property
    def table(self) -> TextTable:
        """RMS values with units, and the rates of upward zero crossings."""
        rates = self.crossing_rate()
        rows = [
            (
                name,
                f"{number_text(rms)} {unit}" if np.isfinite(rms) else "infinite",
                number_text(rate) if np.isfinite(rate) else "infinite",
            )
            for name, rms, unit, rate in zip(self.outputs, self.rms, self.units, rates)
        ]
        return TextTable(f"Random {self.quantity}", ("output", "RMS", "zero crossings (Hz)"), tuple(rows))

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the random inputs."""
        return self.harmonic.input_names

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self.harmonic.output_names

    @property
    def quantity(self) -> str:
        """Quantity of the outputs."""
        return self.harmonic.quantity

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each output."""
        return tuple(map(str, self.harmonic.units))

    @cached_property
    def _independent(self) -> tuple[SpectralTransfer, SpectralMatrix]:
        """H from independent inputs, and their spectra."""
        harmonic, spectra = independent_inputs(self.harmonic, self.spectra)
        return SpectralTransfer(harmonic), spectra

    @cached_property
    def _existence(self) -> dict[int, Existence]:
        return {}

    @cached_property
    def _integrals(self) -> dict[int, tuple[np.ndarray, SpectralIntegral]]:
        return {}

    def _exists(self, power: int) -> Existence:
        if power not in self._existence:
            self._existence[power] = existence(*self._independent, (power,), self.units)
        return self._existence[power]

    def _integral(self, power: int) -> tuple[np.ndarray, SpectralIntegral]:
        """The outputs whose integral exists, and their integrals."""
        power = whole_number(power, "order")
        if power not in self._integrals:
            finite = np.flatnonzero([not reason for reason in self._exists(power).reasons[0]])
            integral = self._without_noise(spectral_integral(*self._independent, (power,), finite), finite)
            self._integrals[power] = finite, self._proved(integral, finite, power)
        return self._integrals[power]

    def _proved(self, integral: SpectralIntegral, finite: np.ndarray, power: int) -> SpectralIntegral:
        """The integral with exact variances, for small models with close or lightly damped modes, where residues lose digits.

        The integral of f^2k G is the variance of the k-th derivative over (2 pi)^2k.
        """
        values, size = integral.values[0].diagonal().real, len(self.harmonic.form.pairs.finite.J) ** 2 * len(self.inputs)
        doubtful = (integral.errors[0] > PROVED_ACCURACY * np.abs(values)).any()
        if size > (MOST_PROVED if doubtful else ALWAYS_PROVED) or power % 2 or self.harmonic.imaginary is not None:
            return integral
        harmonic = replace(self.harmonic, power=self.harmonic.power + power // 2, outputs=self.harmonic.outputs[finite])
        names = tuple(self.outputs[i] for i in finite)
        from .variance_enclosure import enclosed_variances

        try:
            box = enclosed_variances(replace(harmonic, output_names=names), self.spectra, FLOAT64_DIGITS)
        except InputError:  # delayed or partly coherent noise
            return integral
        scale = (2 * np.pi) ** -power
        proved = box.middle * scale
        own = integral.values.copy()
        own[0][np.diag_indices(len(proved))] = proved
        return replace(integral, values=own, errors=(4 * EPS * np.abs(proved))[None])

    def _without_noise(self, integral: SpectralIntegral, finite: np.ndarray) -> SpectralIntegral:
        """Zero for outputs that no input excites, where the integral is rounding error; other outputs without digits are kept."""
        transfer = self._independent[0]
        is_small = integral.values[0].diagonal().real <= integral.errors[0]
        is_noise, is_lost = (is_small & which[finite] for which in (transfer.vanishes, transfer.seems_zero & ~transfer.vanishes))
        values = np.where(is_noise[:, None] | is_noise, 0.0, integral.values)
        return replace(integral, values=values, errors=np.where(is_noise, 0.0, np.where(is_lost, np.inf, integral.errors)))

    @property
    def infinite(self) -> dict[str, str]:
        """The outputs of infinite variance by name, each with its reason."""
        return {name: reason for name, reason in zip(self.outputs, self._exists(0).reasons[0]) if reason}

    @property
    def white_part(self) -> np.ndarray:
        """One-sided intensity per Hz of the white noise in each output, shape (p,); infinite where the output is rougher."""
        return self._exists(0).white_part

    @property
    def covariance(self) -> np.ndarray:
        """E[y y^T], shape (p, p); infinite in rows and columns of outputs of infinite variance."""
        finite, integral = self._integral(0)
        result = np.full((len(self.outputs),) * 2, np.inf)
        result[np.ix_(finite, finite)] = integral.values[0].real
        return result

    @property
    def rms(self) -> np.ndarray:
        """sqrt(E[y^2]), shape (p,)."""
        return np.sqrt(self.moment(0))

    @property
    def error_estimate(self) -> np.ndarray:
        """Estimates of the relative errors of the variances, shape (p,); 0 where they are 0 or infinite, infinite without a digit."""
        return self.moment_error_estimate(0)

    def moment_error_estimate(self, order: int) -> np.ndarray:
        """Estimates of the relative errors of ``moment(order)``, shape (p,); 0 where it is 0 or infinite.

        Args:
            order: 0, 1, 2, ...
        """
        finite, integral = self._integral(order)
        result, values = np.zeros(len(self.outputs)), integral.values[0].diagonal().real
        lost = np.where(integral.errors[0] == np.inf, np.inf, 0.0)
        result[finite] = np.where(values > 0, integral.errors[0] / np.where(values > 0, values, 1.0), lost)
        return result

    def moment(self, order: int) -> np.ndarray:
        """The spectral moment: the integral of f^order G_y(f) df, f in Hz; moment 0 is the variance.

        Args:
            order: 0, 1, 2, ...

        Returns:
            Shape (p,), infinite where the integral does not exist.
        """
        finite, integral = self._integral(order)
        result = np.full(len(self.outputs), np.inf)
        result[finite] = integral.values[0].diagonal().real
        return result

    def rms_in_bands(self, edges_hz) -> np.ndarray:
        """RMS values of the parts of the outputs between frequencies, exact as those of the whole.

        Args:
            edges_hz: shape (B + 1,), ascending from 0 or more; the last may be infinite. ``mb.octave_bands`` gives those of octaves.

        Returns:
            Shape (p, B); infinite where the variance in the band is.

        Raises:
            InputError: edges that do not ascend.

        >>> import mbconstrained as mb
        >>> R = mb.MechanicalSystem([[1.0]], [[0.2]], [[4.0]]).random_response({"x1": mb.white_noise(3.2)})
        >>> parts = R.rms_in_bands([0.0, 0.3, 0.4, np.inf])
        >>> bool(np.isclose(np.square(parts).sum(), 1.0, rtol=1e-13))
        True
        """
        edges = _edges(edges_hz)
        transfer, spectra = self._independent
        squares = np.full((len(self.outputs), len(edges) - 1), np.inf)
        whole = self._finite_within(edges[0], edges[-1])
        part = spectra.within(edges[0], edges[-1])
        squares[whole] = spectral_integral(transfer, part, (0,), whole, edges).parts[:, 0].T
        for band, (low, high) in enumerate(itertools.pairwise(edges) if len(whole) < len(squares) else ()):
            own = np.setdiff1d(self._finite_within(low, high), whole)
            squares[own, band] = spectral_integral(transfer, spectra.within(low, high), (0,), own).values[0].diagonal().real
        return np.sqrt(np.maximum(squares, 0.0))

    def _finite_within(self, low: float, high: float) -> np.ndarray:
        """The indices of the outputs whose variance is finite between two frequencies."""
        transfer, spectra = self._independent
        return np.flatnonzero(
            [not reason for reason in existence(transfer, spectra.within(low, high), (0,), self.units).reasons[0]]
        )

    def cumulative_rms(self, frequencies_hz) -> np.ndarray:
        """Return RMS values of the outputs below frequencies, shape (p, F); infinite where the variance up to there is infinite.

        Args:
            frequencies_hz: positive, ascending, shape (F,).
        """
        f = real_array(frequencies_hz, "frequencies_hz", shape=(None,))
        return np.sqrt(np.cumsum(np.square(self.rms_in_bands([0.0, *f])), axis=1))

    def psd(self, frequencies_hz) -> np.ndarray:
        """Return one-sided power spectral densities of the outputs, shape (p, F), in the squared unit per Hz.

        Args:
            frequencies_hz: shape (F,).
        """
        return self.cross_psd(frequencies_hz).diagonal().T.real

    def cross_psd(self, frequencies_hz) -> np.ndarray:
        """Return one-sided cross spectral densities H G_u H^H, complex, shape (p, p, F).

        Args:
            frequencies_hz: shape (F,).
        """
        transfer, spectra = self._independent
        response, corners = evaluated(transfer.harmonic, frequencies_hz), spectra.corners
        f, H = response.frequencies_hz, response.values
        result = np.zeros((len(H), len(H), len(f)), dtype=complex)
        for a, b in itertools.pairwise(corners):
            own = (f >= a) & ((f < b) | (b == corners[-1]) & (f == b))  # a table holds at both of its ends
            if own.any():
                middle = a + 1.0 if np.isinf(b) else (a + b) / 2
                result[:, :, own] = np.einsum("aif,ijf,bjf->abf", H[..., own], spectra(f[own], middle), H[..., own].conj())
        return result

    def to_xarray(self, frequencies_hz):
        """The spectra as a ``DataArray`` with the dimensions output and frequency (Hz), RMS values and units as coordinates.

        Args:
            frequencies_hz: shape (F,).

        Returns:
            An ``xarray.DataArray``.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        values = self.psd(frequencies_hz)
        coords = {
            "output": list(self.outputs),
            "frequency": ("frequency", np.asarray(frequencies_hz, dtype=float), {"units": "Hz"}),
            "unit": ("output", [f"({unit})^2/Hz" for unit in self.units]),
            "rms": ("output", self.rms),
        }
        return xarray.DataArray(values, coords, ("output", "frequency"), f"spectrum of the {self.quantity}")

    def enclose(self, digits: int = 15) -> Enclosure:
        """Return proved bounds of the variances for exact data: rational for filtered noise, quadrature for tables.

        Args:
            digits: significant digits of each variance.

        Returns:
            An ``Enclosure`` of shape (p,): .lower, .upper (decimal strings), .contains(values), .error_bounds(values).

        Raises:
            InputError: an output of infinite variance, structural damping, partly coherent or delayed noise without a highest frequency.

        >>> import mbconstrained as mb
        >>> R = mb.MechanicalSystem([[1.0]], [[0.75]], [[4.0]]).random_response({"x1": mb.white_noise(2.0)})  # 2 / (4 c k) = 1/6
        >>> box = R.enclose(digits=20)
        >>> print(box.lower[0], box.upper[0])
        0.16666666666666666666666 0.16666666666666666666667
        """
        from .variance_enclosure import enclosed_variances

        return enclosed_variances(self.harmonic, self.spectra, digits)

    # Statistics.

    def _moments(self, *orders: int) -> dict[int, np.ndarray]:
        return {order: self.moment(order) for order in orders}

    def crossing_rate(self, level: float = 0.0) -> np.ndarray:
        """Upward crossings of a level per second (Rice 1945), shape (p,).

        Args:
            level: in the unit of the outputs.
        """
        return statistics.crossing_rate(self._moments(0, 2), real_number(level, "level"))

    @property
    def peak_rate(self) -> np.ndarray:
        """Maxima per second (Rice 1945), shape (p,)."""
        return statistics.peak_rate(self._moments(2, 4))

    @property
    def irregularity(self) -> np.ndarray:
        """Upward zero crossings by maxima, 1 for a narrow band, shape (p,)."""
        return statistics.irregularity(self._moments(0, 2, 4))

    def expected_maximum(self, duration: float) -> np.ndarray:
        """The mean of the largest |y| over a duration in s (Davenport 1964), shape (p,).

        Args:
            duration: in s.
        """
        return statistics.expected_maximum(self._moments(0, 2), duration)

    def damage_rate(self, exponent: float, strength: float = 1.0, method: str = "dirlik") -> np.ndarray:
        """Fatigue damage per second of outputs that are stresses or proportional to them, shape (p,).

        Args:
            exponent: k of the S-N curve N = (strength / amplitude)^k.
            strength: the amplitude that fails in one cycle, in the unit of the outputs.
            method: "dirlik" or "narrow-band".

        Returns:
            In 1/s.
        """
        return statistics.damage_rate(self._moments(0, 1, 2, 4), exponent, strength, method)

    # Functions of time.

    def only(self, *names: str) -> RandomResponse:
        """Return the response of some of the outputs.

        Args:
            names: names of outputs.

        Returns:
            A response.

        Raises:
            InputError: unknown names.
        """
        unknown = [name for name in names if name not in self.outputs]
        if unknown:
            raise InputError(f"outputs: there is no {unknown[0]!r}{nearest(str(unknown[0]), self.outputs)}")
        own, at = self.harmonic, [self.outputs.index(name) for name in names]
        return replace(self, harmonic=replace(own, outputs=own.outputs[at], output_names=names, units=own.units[at]))

    def covariance_over_time(self, times, initial_covariance=None, modulation=None) -> np.ndarray:
        """Return E[y y^T] after white or filtered noise is switched on at t = 0; errors by ``covariance_over_time_error_estimate``.

        Args:
            times: in s, shape (T,).
            initial_covariance: of the displacements and velocities (x, x') at t = 0, shape (2 n, 2 n), with n the number of coordinates; zero by default.
            modulation: pairs (c, b): the intensity is multiplied by sum of c e^{-b t}.

        Returns:
            Shape (T, p, p).

        Raises:
            InputError: excitations with corner frequencies or delays, outputs that white noise reaches directly.
        """
        return nonstationary.covariance_over_time(*self._independent, times, initial_covariance, modulation)[0]

    def covariance_over_time_error_estimate(self, times, initial_covariance=None, modulation=None) -> np.ndarray:
        """Estimates of the errors of ``covariance_over_time``, of each entry relative to sqrt(E[y_a^2] E[y_b^2]), of the same shape.

        Args:
            times, initial_covariance, modulation: as in ``covariance_over_time``.

        Returns:
            Shape (T, p, p); infinite where a variance is lost.

        >>> import mbconstrained as mb
        >>> R = mb.MechanicalSystem([[1.0]], [[0.2]], [[4.0]]).random_response({"x1": mb.white_noise(3.2)})
        >>> bool(R.covariance_over_time_error_estimate([0.1, 10.0]).max() < 1e-12)
        True
        """
        return nonstationary.covariance_over_time(*self._independent, times, initial_covariance, modulation)[1]

    def sample(self, times, seed=None) -> np.ndarray:
        """Return a sample path of the stationary outputs with exactly these spectra.

        Args:
            times: in s, shape (T,), any spacing.
            seed: seed of ``numpy.random.default_rng``.

        Returns:
            Shape (p, T).

        Raises:
            InputError: an output of infinite variance.
        """
        if self.infinite:
            name, reason = next(iter(self.infinite.items()))
            raise InputError(f"sample: the output {name} has infinite variance: {reason}")
        return nonstationary.sample(*self._independent, times, seed)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on outputs of infinite variance, inputs without spectra, and inaccurate values."""
        result = list(self.harmonic.notices)
        result += [
            Notice(NoticeKind.ACCURACY, f'"{name}" has infinite variance: {reason}') for name, reason in self.infinite.items()
        ]
        silent = [name for name, spectrum in zip(self.inputs, self.spectra.spectra) if not spectrum.pieces]
        result += [Notice(NoticeKind.OMITTED, f'the spectrum of "{name}" is zero') for name in silent]
        estimates = self.error_estimate
        for name in (name for name, estimate in zip(self.outputs, estimates) if estimate == np.inf):
            text = f'no digit of the variance of "{name}" is certain: couplings to it are rounding errors next to the other entries; see ``enclose``'
            result.append(Notice(NoticeKind.ACCURACY, text, doubtful=True))
        worst = estimates[np.isfinite(estimates)].max(initial=0.0)
        if worst > REPORTED_ERROR:
            text = f"variances have an estimated relative error of at most {worst:.2g}"
            result.append(Notice(NoticeKind.ACCURACY, text, doubtful=bool(worst > TRUST_LIMIT)))
        return tuple(result)


def _edges(edges_hz) -> np.ndarray:
    """Edges of bands in Hz, all finite except the last."""
    given = np.atleast_1d(np.asarray(edges_hz, dtype=object))
    last = [np.inf] if len(given) and isinstance(given[-1], float) and given[-1] == np.inf else []
    edges = np.append(real_array(given[: len(given) - len(last)].tolist(), "edges_hz", shape=(None,)), last)
    if len(edges) < 2 or not (np.diff(edges) > 0).all() or not edges[0] >= 0:
        raise InputError("edges_hz: expected at least two ascending frequencies from 0 Hz on; the last may be infinite")
    return edges
