"""Stationary response to random excitation: spectra, covariances with errors, statistics of peaks."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ...ground.by_name import answering
from ...ground.checks import check_known, counted, optional_package, places_of, real_array, real_number, whole_number
from ...ground.display import Pictured, TextTable, notice_table, number_text
from ...ground.errors import InputError
from ...ground.named_arrays import named_array
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CLUSTER_SAFETY, EPS, FLOAT64_DIGITS, NOISE_SAFETY, PROVED_ACCURACY, REPORTED_ERROR, TRUST_LIMIT
from ...ground.units import density_unit
from ...linalg.arrays import lapack
from ...linalg.precise import relative_degrees
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..frequency_response import evaluated
from ..harmonic import Harmonic
from . import nonstationary
from .spectra import INDEFINITE, PowerLaw, Rational, SpectralMatrix, Spectrum
from .spectral_integral import DelayedTransfer, RefinedPole, SpectralIntegral, SpectralTransfer, spectral_integral

if TYPE_CHECKING:
    from ...exact.enclosure.intervals import Enclosure


# Rates, extremes and fatigue of a stationary Gaussian process, from its spectral moments m_k = integral of f^k G(f) df.
# Sources: Rice, Bell System Technical Journal 24 (1945); Davenport, Proc. Institution of Civil Engineers 28 (1964); Dirlik, thesis, University of
# Warwick (1985), as quoted by Bishop and Sherratt, Finite Element Based Fatigue Calculations (2000).

METHODS = ("dirlik", "narrow-band")


def octave_bands(low: float, high: float) -> np.ndarray:
    """Edges of octaves around 1000 Hz times a power of two, as in IEC 61260-1 with base two.

    Args:
        low, high: in Hz; the bands cover what is between them.

    Returns:
        Ascending, in Hz, for ``RandomResponse.rms_in_bands``.

    Raises:
        InputError: frequencies that are not positive or do not ascend.

    >>> octave_bands(20.0, 80.0).round(3)
    array([11.049, 22.097, 44.194, 88.388])
    """
    low, high = (real_number(one, name, positive=True) for one, name in ((low, "low"), (high, "high")))
    if not low < high:
        raise InputError(f"high: found {high:g} Hz; expected more than low, {low:g} Hz")
    first, last = (np.log2(one / 1000.0) + 0.5 for one in (low, high))
    return 1000.0 * 2.0 ** (np.arange(np.floor(first), np.ceil(last) + 1) - 0.5)


def _root_of_ratio(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """sqrt(above / below): 0 for 0 / 0, infinite where above is infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isinf(above), np.inf, np.where(np.asarray(below) > 0, np.sqrt(np.asarray(above) / below), 0.0))


# Random inputs transformed to independent ones: coherent inputs of one shape are combined, filters become equations.
# Inputs whose spectra are proportional and whose coherences are real have S = G(f) L L^T: B L replaces B, and terms
# that cancel are exactly zero. Filtered noise u = n(s) q, d(s) q = w has a white input w in the equations
#     [[A(s), -b n(s)], [0, d(s)]],
# so that zeros of the filter at poles of the system, and poles of the filter, are treated as all others.


def independent_inputs(harmonic: Harmonic, spectra: SpectralMatrix) -> tuple[Harmonic, SpectralMatrix]:
    """An equivalent process whose inputs are as independent and as white as possible."""
    m = len(spectra.names)
    ratios = np.array([[one.ratio(other) for other in spectra.spectra] for one in spectra.spectra]).reshape(m, m)
    if (np.isnan(ratios) & spectra.coupled).any():
        return harmonic, spectra
    if not spectra.longest_delay:
        harmonic, spectra = _combined(harmonic, spectra, ratios)
    return _with_filters(harmonic, spectra)


def _combined(harmonic: Harmonic, spectra: SpectralMatrix, ratios: np.ndarray):
    """Equations with B L for each group of coupled inputs; inputs with a cross spectrum of another shape or a complex one are kept."""
    share = spectra.coherence.copy()
    for (i, j), given in spectra.cross.items():
        own = spectra.spectra[i].ratio(given)
        if np.isnan(own) or own.imag or not own:
            return harmonic, spectra
        share[i, j] = share[j, i] = own.real / np.sqrt(ratios[i, j].real)
    columns, chosen = [], []
    for group in spectra.groups:
        first = group[0]
        size = np.sqrt(ratios[first, group].real)
        factor = _root(share[np.ix_(group, group)]) * size[:, None]
        columns.append(harmonic.inputs[:, group] @ factor)
        chosen += [(spectra.names[first], spectra.spectra[first])] * factor.shape[1]
    names, pieces = tuple(name for name, _ in chosen), tuple(spectrum for _, spectrum in chosen)
    inputs = np.hstack(columns) if columns else harmonic.inputs[:, :0]
    count = len(names)
    return replace(harmonic, inputs=inputs, input_names=names), SpectralMatrix(names, pieces, np.eye(count), np.zeros(count))


def _root(matrix: np.ndarray) -> np.ndarray:
    """L with L L^T = matrix, positive semidefinite, with as many columns as its rank: exact for independent and for fully coherent inputs."""
    if (matrix == np.diag(matrix.diagonal())).all():
        return np.diag(np.sqrt(matrix.diagonal()))
    factor, pivots, rank, _ = lapack.dpstrf(matrix, lower=1, tol=INDEFINITE * matrix.max())
    result = np.zeros_like(matrix)
    result[pivots - 1] = np.tril(factor)
    return result[:, :rank]


def _with_filters(harmonic: Harmonic, spectra: SpectralMatrix) -> tuple[Harmonic, SpectralMatrix]:
    """Equations with the filters as additional unknowns and white noise as input."""
    filtered = [(i, one.pieces[0]) for i, one in enumerate(spectra.spectra) if one.pieces and isinstance(one.pieces[0], Rational)]
    if not filtered:
        return harmonic, spectra
    A, r, extra = harmonic.A.coefficients, harmonic.A.size, len(filtered)
    degree = max(len(A), *(len(part) for _, piece in filtered for part in (piece.numerator, piece.denominator)))
    coefficients, imaginary = np.zeros((degree, r + extra, r + extra)), harmonic.imaginary
    coefficients[: len(A), :r, :r] = A
    inputs, white = np.pad(harmonic.inputs, ((0, extra), (0, 0))), list(spectra.spectra)
    for place, (i, piece) in enumerate(filtered, start=r):
        for k, (above, below) in enumerate(itertools.zip_longest(piece.numerator[::-1], piece.denominator[::-1], fillvalue=0.0)):
            coefficients[k, :r, place] = -above * harmonic.inputs[:, i]
            coefficients[k, place, place] = below
        inputs[:, i] = np.eye(r + extra)[place]
        white[i] = Spectrum((PowerLaw(0.0, np.inf, piece.intensity),), spectra.spectra[i].of, "white noise")
    sizes = harmonic.sizes
    if sizes is not None:
        own = np.abs(coefficients)
        own[: len(sizes), :r, :r] = sizes
        sizes = own
    if imaginary is not None:
        imaginary = np.pad(imaginary, (0, extra))
    outputs = np.pad(harmonic.outputs, ((0, 0), (0, extra)))
    extended = replace(
        harmonic, A=PolynomialMatrix(coefficients), inputs=inputs, outputs=outputs, imaginary=imaginary, sizes=sizes, elements=None
    )
    return extended, replace(spectra, spectra=tuple(white))


# Existence of the variance of an output: poles on the axis, unstable poles, direct paths of white noise, slow decay.
# The integral of f^k G(f) exists at infinity where the exponent of f is below -1, and at a pole on the axis where the spectrum vanishes fast enough.

#: The exponent of a spectrum at zero frequency is measured at this share of the frequencies over which it changes.
NEXT_TO_ZERO = 1e-2


@dataclass(frozen=True, eq=False)
class Existence:
    """Reasons why integrals of f^k G(f) are infinite."""

    reasons: np.ndarray  # for each output a sentence, "" where the integral is finite, shape (p,)
    white_part: np.ndarray  # one-sided intensity per Hz of the white part of each output; infinite where it is rougher, shape (p,)

    @property
    def finite(self) -> np.ndarray:
        """The places of the outputs whose integrals are finite."""
        return np.flatnonzero(self.reasons == "")


def existence(transfer: SpectralTransfer, spectra: SpectralMatrix, power: int, units: tuple[str, ...]) -> Existence:
    """Existence of the spectral integrals."""
    if isinstance(transfer, DelayedTransfer):
        return _existence_with_delays(transfer, spectra)
    p = len(transfer.harmonic.outputs)
    reasons = np.full(p, "", dtype=object)
    has_structural_damping = transfer.harmonic.imaginary is not None  # then H holds for f > 0 and has no stable poles below
    for pole in transfer.poles:
        if has_structural_damping and pole.value.imag < 0:
            continue
        for output in np.flatnonzero(pole.residues.any(axis=(0, 2))).tolist():
            reasons[output] = reasons[output] or _at_pole(pole, output, spectra, power)
    white = np.zeros(p)
    corners = spectra.corners
    if len(corners) and np.isinf(corners[-1]):
        exponents, white = _growth(transfer, spectra, corners[-2] + 1.0)
        for output in np.flatnonzero((exponents + power >= -1) & (reasons == "")).tolist():
            known = np.isfinite(white[output])
            intensity = f"; its intensity is {number_text(white[output])} {density_unit(units[output])}" if known else ""
            reasons[output] = (
                f"white noise reaches it directly{intensity}"
                if exponents[output] == 0 and not power
                else f"its spectrum{' times f^' + str(power) if power else ''} falls no faster than f^{exponents[output] + power:g}"
            )
    return Existence(reasons, white)


def _existence_with_delays(transfer: DelayedTransfer, spectra: SpectralMatrix) -> Existence:
    """Existence by the characteristic roots: residues, which decide on what reaches an output, are unknown."""
    p, roots = len(transfer.harmonic.outputs), transfer.roots
    reasons = np.full(p, "", dtype=object)
    for pole in transfer.poles:
        f0 = abs(pole.value.imag) / (2 * np.pi)
        if pole.on_axis and len(spectra.corners) and spectra.corners[0] <= f0 <= spectra.corners[-1]:
            raise InputError(
                f"random_response: with delays a motion of {number_text(f0)} Hz without damping, within the spectra, is not decided on; "
                "give spectra without this frequency, or damping"
            )
        if pole.value.real > 0 and not pole.on_axis:
            reasons[:] = f"the motion with the eigenvalue {roots.eigenvalues[0]:.4g} 1/s is unstable and grows"
    return Existence(reasons, np.zeros(p))


def _at_pole(pole: RefinedPole, output: int, spectra: SpectralMatrix, power: int) -> str:
    """The reason for which a pole makes the integral infinite, or ""."""
    f0 = abs(pole.value.imag) / (2 * np.pi)
    if pole.value.real > 0 and not pole.on_axis:
        reached = pole.residues[:, output, [piece for piece in range(len(spectra.spectra)) if spectra.spectra[piece].pieces]]
        return f"the motion with the eigenvalue {pole.value:.4g} 1/s is unstable and grows" if reached.any() else ""
    if not pole.on_axis:
        return ""
    for a, b in itertools.pairwise(spectra.corners):
        if not a <= f0 <= b:
            continue
        middle = a + 1.0 if np.isinf(b) else (a + b) / 2
        for j in range(pole.order - 1, -1, -1):
            rise = _rise(spectra, middle, pole.residues[j][output], f0) + (0 if f0 else power)
            if rise - 2 * (j + 1) <= -1:
                kind = "a rigid-body motion" if not f0 else "an undamped motion"
                return f"{kind} of {number_text(f0)} Hz has no damping and its excitation does not vanish there"
    return ""


def _rise(spectra: SpectralMatrix, middle: float, R: np.ndarray, f0: float) -> float:
    """The exponent of |f - f0| of R S R^H at a pole on the axis, infinite where it vanishes; for f0 = 0 from next to it."""

    def reached(f: float) -> float:
        S = spectra(np.array([f + 0j]), middle)[..., 0]
        value, size = (R @ S @ R.conj()).real, np.abs(R) @ np.abs(S) @ np.abs(R)
        return value if value > CLUSTER_SAFETY * EPS * size else 0.0

    if f0:
        return 0.0 if reached(f0) else np.inf
    lengths = [1.0, *(1 / abs(one) for one in spectra.singularities(middle) if one), 2 * np.pi * spectra.longest_delay]
    lengths.append(1 / spectra.corners[spectra.corners > 0][0])
    f = NEXT_TO_ZERO / max(lengths)
    one, two = reached(f), reached(2 * f)
    return float(np.round(np.log2(two / one))) if one else np.inf


def _growth(transfer: SpectralTransfer, spectra: SpectralMatrix, middle: float) -> tuple[np.ndarray, np.ndarray]:
    """The exponent of f of the spectrum of each output towards infinity, and the intensity of its white part, both of shape (p,)."""
    harmonic = transfer.harmonic
    slopes, D = spectra.slopes(middle), transfer.polynomial
    p = len(harmonic.outputs)
    exponents, white = np.full(p, -np.inf), np.zeros(p)
    S = spectra(np.array([middle + 0j]), middle)[..., 0]
    decays = _decays(transfer)
    for output in range(p):
        for entry, slope in enumerate(slopes):
            if np.isfinite(slope):
                exponents[output] = max(exponents[output], slope - 2 * decays[output, entry])
        if exponents[output] == 0:
            flat = [entry for entry, slope in enumerate(slopes) if slope == 0]
            if len(D) and flat:
                row = D[0, output, flat]
                white[output] = (row @ S[np.ix_(flat, flat)] @ row.conj()).real
        elif exponents[output] > 0:
            white[output] = np.inf
    return exponents, white


def _decays(transfer: SpectralTransfer) -> np.ndarray:
    """The relative degrees: H ~ s^-decay towards infinity, shape (p, m), infinite where H is zero."""
    harmonic = transfer.harmonic
    degrees = relative_degrees(harmonic.coefficients, harmonic.inputs, harmonic.outputs)
    if degrees is not None:
        return degrees - harmonic.power
    decays, D = _numerical_decays(transfer), transfer.polynomial
    for k in range(len(D)):
        decays[D[k] != 0] = -k
    return decays


def _numerical_decays(transfer: SpectralTransfer) -> np.ndarray:
    """The relative degrees of large models, from C J^k B without rounding errors."""
    form = transfer.harmonic.form
    J, C, right = form.pairs.finite.J, form.outputs @ form.pairs.finite.C, form.pairs.finite.B @ form.inputs
    result, right_size = np.full((len(C), right.shape[1]), np.inf), np.abs(right)
    for index in range(len(J) + 1):
        values, noise = C @ right, NOISE_SAFETY * EPS * max(len(J), 1) * np.abs(C) @ right_size
        if index >= form.power:
            first = (np.abs(values) > noise) & np.isinf(result)
            result[first] = index + 1 - form.power
        right, right_size = J @ right, np.abs(J) @ right_size
        if np.isfinite(result).all():
            break
    return result


# The stationary response to random excitation: covariance, spectral moments, rates, extremes, fatigue.

#: Variances of models with at most so many states squared times inputs are computed exactly: always (about 10 ms), and where their sums of residues
#: leave a doubt (about 0.1 s).
ALWAYS_PROVED, MOST_PROVED = 256, 2048


@answering
@dataclass(frozen=True, repr=False, eq=False)
class RandomResponse(Pictured):
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
        return TextTable(f"Random {self.harmonic.quantity_of()}", ("output", "RMS", "zero crossings (Hz)"), tuple(rows))

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
        if not self.harmonic.delayed:
            harmonic, spectra = independent_inputs(self.harmonic, self.spectra)
            return SpectralTransfer(harmonic), spectra
        if len(self.spectra.corners) and np.isinf(self.spectra.corners[-1]):
            raise InputError(
                "random_response: with delays spectra need a highest frequency; give tables such as mb.psd([1.0, 100.0], [g, g], …) for white noise"
            )
        if self.harmonic.imaginary is not None:
            raise InputError("random_response: loss factors are not available with delays; give viscous or modal damping")
        return DelayedTransfer(self.harmonic), self.spectra

    @cached_property
    def _existence(self) -> dict[int, Existence]:
        return {}

    @cached_property
    def _integrals(self) -> dict[int, tuple[np.ndarray, SpectralIntegral]]:
        return {}

    def _exists(self, power: int) -> Existence:
        if power not in self._existence:
            self._existence[power] = existence(*self._independent, power, self.units)
        return self._existence[power]

    def _integral(self, power: int) -> tuple[np.ndarray, SpectralIntegral]:
        """The outputs whose integral exists, and their integrals."""
        power = whole_number(power, "order")
        if power not in self._integrals:
            finite = self._exists(power).finite
            integral = self._without_noise(spectral_integral(*self._independent, power, finite), finite)
            self._integrals[power] = finite, self._proved(integral, finite, power)
        return self._integrals[power]

    def _proved(self, integral: SpectralIntegral, finite: np.ndarray, power: int) -> SpectralIntegral:
        """The integral with exact variances, for small models with close or lightly damped modes, where residues lose digits.

        The integral of f^2k G is the variance of the k-th derivative over (2 pi)^2k.
        """
        if self.harmonic.delayed:
            return integral
        values, size = integral.values.diagonal().real, len(self.harmonic.form.pairs.finite.J) ** 2 * len(self.inputs)
        doubtful = (integral.errors > PROVED_ACCURACY * np.abs(values)).any()
        if size > (MOST_PROVED if doubtful else ALWAYS_PROVED) or power % 2 or self.harmonic.imaginary is not None:
            return integral
        from .variance_enclosure import enclosed_variances

        names, outputs = tuple(self.outputs[i] for i in finite), self.harmonic.outputs[finite]
        harmonic = replace(self.harmonic, power=self.harmonic.power + power // 2, outputs=outputs, output_names=names)
        try:
            box = enclosed_variances(harmonic, self.spectra, FLOAT64_DIGITS)
        except InputError:  # delayed or partly coherent noise
            return integral
        proved, own = box.middle * (2 * np.pi) ** -power, integral.values.copy()
        np.fill_diagonal(own, proved)
        return replace(integral, values=own, errors=4 * EPS * np.abs(proved))

    def _without_noise(self, integral: SpectralIntegral, finite: np.ndarray) -> SpectralIntegral:
        """Zero for outputs that no input excites, where the integral is rounding error; other outputs without digits are kept."""
        transfer = self._independent[0]
        is_small = integral.values.diagonal().real <= integral.errors
        is_noise, is_lost = (is_small & which[finite] for which in (transfer.vanishes, transfer.seems_zero & ~transfer.vanishes))
        values = np.where(is_noise[:, None] | is_noise, 0.0, integral.values)
        return replace(integral, values=values, errors=np.where(is_noise, 0.0, np.where(is_lost, np.inf, integral.errors)))

    @property
    def infinite(self) -> dict[str, str]:
        """The outputs of infinite variance by name, each with its reason."""
        return {name: reason for name, reason in zip(self.outputs, self._exists(0).reasons) if reason}

    @property
    def white_part(self) -> np.ndarray:
        """One-sided intensity per Hz of the white noise in each output, shape (p,); infinite where the output is rougher."""
        return named_array(self._exists(0).white_part, self.outputs)

    @property
    def covariance(self) -> np.ndarray:
        """E[y y^T], shape (p, p); infinite in rows and columns of outputs of infinite variance."""
        finite, integral = self._integral(0)
        result = np.full((len(self.outputs),) * 2, np.inf)
        result[np.ix_(finite, finite)] = integral.values.real
        return named_array(result, self.outputs, self.outputs)

    @property
    def rms(self) -> np.ndarray:
        """sqrt(E[y^2]), shape (p,)."""
        return named_array(np.sqrt(self.moment(0)), self.outputs)

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
        result, values = np.zeros(len(self.outputs)), integral.values.diagonal().real
        lost = np.where(integral.errors == np.inf, np.inf, 0.0)
        result[finite] = np.where(values > 0, integral.errors / np.where(values > 0, values, 1.0), lost)
        return named_array(result, self.outputs)

    def moment(self, order: int) -> np.ndarray:
        """The spectral moment: the integral of f^order G_y(f) df, f in Hz; moment 0 is the variance.

        Args:
            order: 0, 1, 2, ...

        Returns:
            Shape (p,), infinite where the integral does not exist.
        """
        finite, integral = self._integral(order)
        result = np.full(len(self.outputs), np.inf)
        result[finite] = integral.values.diagonal().real
        return named_array(result, self.outputs)

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
        squares[whole] = spectral_integral(transfer, part, 0, whole, edges).parts.T
        for band, (low, high) in enumerate(itertools.pairwise(edges) if len(whole) < len(squares) else ()):
            own = np.setdiff1d(self._finite_within(low, high), whole)
            squares[own, band] = spectral_integral(transfer, spectra.within(low, high), 0, own).values.diagonal().real
        return named_array(np.sqrt(np.maximum(squares, 0.0)), self.outputs)

    def _finite_within(self, low: float, high: float) -> np.ndarray:
        """The indices of the outputs whose variance is finite between two frequencies."""
        transfer, spectra = self._independent
        return existence(transfer, spectra.within(low, high), 0, self.units).finite

    def cumulative_rms(self, frequencies_hz) -> np.ndarray:
        """Return RMS values of the outputs below frequencies, shape (p, F); infinite where the variance up to there is infinite.

        Args:
            frequencies_hz: positive, ascending, shape (F,).
        """
        f = real_array(frequencies_hz, "frequencies_hz", shape=(None,))
        return named_array(np.sqrt(np.cumsum(np.square(self.rms_in_bands([0.0, *f])), axis=1)), self.outputs)

    def psd(self, frequencies_hz) -> np.ndarray:
        """Return one-sided power spectral densities of the outputs, shape (p, F), in the squared unit per Hz.

        Args:
            frequencies_hz: shape (F,).
        """
        return named_array(self.cross_psd(frequencies_hz).diagonal().T.real, self.outputs)

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
        return named_array(result, self.outputs, self.outputs)

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
            "unit": ("output", list(map(density_unit, self.units))),
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
            InputError: an output of infinite variance, structural damping, equations with delays, partly coherent or delayed noise without a highest frequency.

        >>> import mbconstrained as mb
        >>> R = mb.MechanicalSystem([[1.0]], [[0.75]], [[4.0]]).random_response({"x1": mb.white_noise(2.0)})  # 2 / (4 c k) = 1/6
        >>> box = R.enclose(digits=20)
        >>> print(box.lower[0], box.upper[0])
        0.16666666666666666666666 0.16666666666666666666667
        """
        from .variance_enclosure import enclosed_variances

        if self.harmonic.delayed:
            raise InputError("enclose: proved variances are not available with delays; error_estimate has their errors")
        return enclosed_variances(self.harmonic, self.spectra, digits)

    # Statistics.

    def crossing_rate(self, level: float = 0.0) -> np.ndarray:
        """Upward crossings of a level per second, sqrt(m_2 / m_0) e^{-level^2 / 2 m_0} (Rice 1945), shape (p,).

        Args:
            level: in the unit of the outputs.
        """
        level, variance = real_number(level, "level"), self.moment(0)
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = _root_of_ratio(self.moment(2), variance) * np.exp(-np.square(level) / (2 * variance))
        return named_array(np.where(variance > 0, rate, 0.0), self.outputs)

    @property
    def peak_rate(self) -> np.ndarray:
        """Maxima per second, sqrt(m_4 / m_2) (Rice 1945), shape (p,)."""
        return named_array(_root_of_ratio(self.moment(4), self.moment(2)), self.outputs)

    @property
    def irregularity(self) -> np.ndarray:
        """Upward zero crossings by maxima, m_2 / sqrt(m_0 m_4): 1 for a narrow band, shape (p,)."""
        peaks = np.maximum(self.peak_rate, np.finfo(float).tiny)
        ratio = np.where(np.isinf(peaks), 0.0, _root_of_ratio(self.moment(2), self.moment(0))) / peaks
        return named_array(ratio, self.outputs)

    def expected_maximum(self, duration: float) -> np.ndarray:
        """The mean of the largest |y| over a duration, sigma (g + 0.5772 / g), g = sqrt(2 ln(2 n T)), n the rate of upward zero crossings.

        Source: Davenport (1964).

        Args:
            duration: T in s.

        Returns:
            Shape (p,).

        Raises:
            InputError: a duration of less than some periods.
        """
        T, variance = real_number(duration, "duration", positive=True), self.moment(0)
        cycles = 2 * self.crossing_rate() * T
        if (cycles[np.isfinite(cycles) & (variance > 0)] < np.e).any():
            raise InputError(f"duration: found {T:g} s, about {cycles.min() / 2:.2g} periods; the formula holds for many periods")
        with np.errstate(divide="ignore", invalid="ignore"):
            g = np.sqrt(2 * np.log(np.maximum(cycles, np.e)))
        largest = np.where(np.isinf(variance), np.inf, np.sqrt(variance) * (g + np.euler_gamma / g))
        return named_array(largest, self.outputs)

    def damage_rate(self, exponent: float, strength: float = 1.0, method: str = "dirlik") -> np.ndarray:
        """Fatigue damage per second by Miner's rule, cycles of the amplitude a taking N(a) = (strength / a)^exponent of them, shape (p,).

        Narrow band: n (sqrt(2) sigma / strength)^k Gamma(1 + k / 2); Dirlik's formula counts the ranges of a broad band. Where m_4 is infinite its limit
        stands, which is the formula of the narrow band with the mean frequency m_1 / m_0 in the place of n, for k > 1.

        Args:
            exponent: k of the S-N curve N = (strength / amplitude)^k.
            strength: the amplitude that fails in one cycle, in the unit of the outputs.
            method: "dirlik" or "narrow-band".

        Returns:
            In 1/s.
        """
        k, strength = real_number(exponent, "exponent", positive=True), real_number(strength, "strength", positive=True)
        check_known(method, METHODS, "method")
        moments = {order: self.moment(order) for order in (0, 1, 2, 4)}
        sigma = np.sqrt(moments[0]) / strength
        each = (np.sqrt(2.0) * sigma) ** k * scipy.special.gamma(1 + k / 2)
        if method == "narrow-band":
            return self.crossing_rate() * each
        ratio, rate = np.minimum(self.irregularity, 1.0), self.peak_rate
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = moments[1] / moments[0] * _root_of_ratio(moments[2], moments[4])
            first = np.clip(2 * (mean - ratio**2) / (1 + ratio**2), 0.0, 1.0)
            R = np.where(ratio < 1, (ratio - mean - first**2) / (1 - ratio - first + first**2), 0.0)
            second = np.where(R != 1, (1 - ratio - first + first**2) / (1 - R), 0.0)
            third = 1 - first - second
            Q = np.where(first > 0, 1.25 * (ratio - third - second * R) / first, 0.0)
            shape = first * np.abs(Q) ** k * scipy.special.gamma(1 + k) + np.sqrt(2.0) ** k * scipy.special.gamma(1 + k / 2) * (
                second * np.abs(R) ** k + third
            )
            damage, limit = rate * sigma**k * shape, moments[1] / moments[0] * each if k > 1 else np.inf
        damage = np.where(np.isinf(moments[4]), np.where(np.isinf(moments[2]), np.inf, limit), damage)
        return named_array(np.where(moments[0] > 0, damage, 0.0), self.outputs)

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
        own, at = self.harmonic, places_of(names, self.outputs, "output")
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
        transfer = self._independent[0]
        if isinstance(transfer, DelayedTransfer):
            result += [notice for notice in transfer.roots.notices if notice.doubtful]
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
