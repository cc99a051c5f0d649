"""Power spectral densities: tables and rational ones, their pieces in closed form; and the Hermitian matrix of those of several inputs."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...ground.by_name import answering
from ...ground.checks import check_known, nearest, real_array, real_number
from ...ground.display import Displayed, number_text
from ...ground.errors import InputError
from ...ground.tolerances import EPS, SPECTRAL_ACCURACY

# Pieces of power spectral densities between corner frequencies: power laws, straight lines, filtered white noise; analytic functions of f.


@dataclass(frozen=True)
class PowerLaw:
    """G(f) = level (f / lower)^exponent between two corner frequencies in Hz; a constant where the exponent is 0."""

    lower: float
    upper: float  # may be infinite where the exponent is 0
    level: complex
    exponent: float = 0.0

    #: G ~ f^slope towards infinity.
    slope = 0

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        return self.level * (f / self.lower) ** self.exponent if self.exponent else np.full(np.shape(f), self.level, dtype=complex)

    def within(self, low: float, high: float) -> PowerLaw:
        """The power law between two other frequencies."""
        return PowerLaw(low, high, self(np.array(low)).item() if self.exponent and low > self.lower else self.level, self.exponent)

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        same = isinstance(other, PowerLaw) and (self.lower, self.upper) == (other.lower, other.upper)
        return other.level / self.level if same and abs(self.exponent - other.exponent) <= SPECTRAL_ACCURACY else np.nan

    @property
    def singularities(self) -> tuple[complex, ...]:
        """Frequencies near which G is not analytic."""
        return (0j,) if self.exponent else ()


@dataclass(frozen=True)
class Line:
    """A straight line between two corner frequencies in Hz."""

    lower: float
    upper: float
    level: complex  # G at the lower corner
    end: complex  # and at the upper one

    slope = 0

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        part = (f - self.lower) / (self.upper - self.lower)
        return self.level * (1 - part) + self.end * part

    def within(self, low: float, high: float) -> Line:
        """The line between two other frequencies."""
        return Line(low, high, *self(np.array([low, high])).tolist())

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        if not isinstance(other, Line) or (self.lower, self.upper) != (other.lower, other.upper):
            return np.nan
        own, given = np.array([self.level, self.end]), np.array([other.level, other.end])
        c = np.vdot(own, given) / np.vdot(own, own)
        return c if (np.abs(given - c * own) <= SPECTRAL_ACCURACY * np.abs(given).max()).all() else np.nan

    @property
    def singularities(self) -> tuple[complex, ...]:
        """No singularities of a line; those of its square root, in cross spectra, are at its zero."""
        rise = self.end - self.level
        return (complex(self.lower - self.level * (self.upper - self.lower) / rise),) if rise else ()


@dataclass(frozen=True)
class Rational:
    """G(f) = intensity |F(i w)|^2, F(s) = numerator(s) / denominator(s), w = 2 pi f: white noise through a filter."""

    intensity: float  # of the white noise, one-sided per Hz
    numerator: tuple[float, ...]  # coefficients, highest power first
    denominator: tuple[float, ...]
    lower: float = 0.0
    upper: float = np.inf

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """G at real or complex frequencies in Hz."""
        s = 2j * np.pi * np.asarray(f, dtype=complex)
        above = np.polyval(self.numerator, s) * np.polyval(self.numerator, -s)
        return self.intensity * above / (np.polyval(self.denominator, s) * np.polyval(self.denominator, -s))

    def within(self, low: float, high: float) -> Rational:
        """The rational spectrum between two other frequencies."""
        return replace(self, lower=low, upper=high)

    def ratio(self, other) -> complex:
        """c with other = c times this piece, or NaN."""
        same = isinstance(other, Rational) and (self.numerator, self.denominator) == (other.numerator, other.denominator)
        return other.intensity / self.intensity if same else np.nan

    @property
    def slope(self) -> int:
        """G ~ f^slope towards infinity."""
        return 2 * (len(self.numerator) - len(self.denominator))

    @property
    def singularities(self) -> tuple[complex, ...]:
        """The poles of F as complex frequencies, in both half planes."""
        at = np.roots(self.denominator) / (2j * np.pi)
        return tuple(at) + tuple(at.conj())


# One-sided power spectral densities per Hz: tables, white noise, and rational spectra of shaping filters, as pieces between corner frequencies.
#     E[u^2] = integral from 0 to infinity of G(f) df
# A two-sided density S per rad/s of the same process is S(w) = G(w / 2 pi) / (4 pi). Every density is analytic between its corner
# frequencies, so that it can be evaluated at complex frequencies, where the integrals have their residues.

#: Random quantities, and their orders of derivative of a displacement.
KINDS = {"force": None, "displacement": 0, "velocity": 1, "acceleration": 2}

#: Units of random quantities, by kind: the factor to SI units.
_LENGTHS = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1 / 1000**2,
    "in": 0.0254,
    "ft": 0.3048,
    "rad": 1.0,
    "deg": np.pi / 180,
    "1": 1.0,
}
_RATES = {f"{name}/s": factor for name, factor in _LENGTHS.items()}
_ACCELERATIONS = {**{f"{name}/s^2": factor for name, factor in _LENGTHS.items()}, "g": 9.80665, "g0": 9.80665}
_FORCES = {"N": 1.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "N m": 1.0, "Nm": 1.0, "N*m": 1.0, "J": 1.0}
UNITS = {"force": _FORCES, "displacement": _LENGTHS, "velocity": _RATES, "acceleration": _ACCELERATIONS}

INTERPOLATIONS = ("log-log", "linear", "steps")


@dataclass(frozen=True, repr=False)
class Spectrum(Displayed):
    """The one-sided power spectral density G(f) of a random excitation, per Hz; zero outside its pieces.

    Attributes:
        pieces: between corner frequencies, ascending.
        of: "force" (also a moment), "displacement", "velocity" or "acceleration".
        name: description for printing.

    >>> import mbconstrained as mb
    >>> table = mb.psd([10, 100], [1.0, 0.1], of="acceleration", unit="g^2/Hz")
    >>> table(np.array([5.0, 10.0])).round(4), table
    (array([ 0.    , 96.1704]), Spectrum(of acceleration, table from 10 Hz to 100 Hz, 1 g^2/Hz = 96.1704 (m/s^2)^2/Hz))
    """

    pieces: tuple
    of: str = "force"
    name: str = ""

    def _summary(self) -> str:
        return f"of {self.of}, {self.name}"

    def __call__(self, frequencies_hz) -> np.ndarray:
        """G at frequencies in Hz, in SI units squared per Hz."""
        f = real_array(frequencies_hz, "frequencies_hz")
        result = np.zeros(f.shape, dtype=complex)
        for piece in self.pieces:
            inside = (f >= piece.lower) & (f <= piece.upper)
            result[inside] = piece(f[inside])
        return result if self.is_complex else result.real

    def within(self, low: float, high: float) -> Spectrum:
        """Return the spectrum between two frequencies, zero outside.

        Args:
            low, high: frequencies in Hz.

        Returns:
            A spectrum.
        """
        pieces = [piece.within(max(low, piece.lower), min(high, piece.upper)) for piece in self.pieces]
        return replace(self, pieces=tuple(piece for piece in pieces if piece.lower < piece.upper))

    @property
    def is_complex(self) -> bool:
        """Whether it is a cross spectrum with complex values."""
        return any(np.iscomplexobj(getattr(piece, "level", 0.0)) for piece in self.pieces)

    def piece_at(self, frequency_hz: float):
        """Return the piece that contains this frequency, or None."""
        return next((piece for piece in self.pieces if piece.lower <= frequency_hz <= piece.upper), None)

    def ratio(self, other: Spectrum) -> complex:
        """c with other = c times this spectrum; NaN where there is none.

        Args:
            other: a spectrum, or a cross spectrum.

        Returns:
            A complex number.

        >>> white_noise(2.0).ratio(white_noise(3.0))
        (1.5+0j)
        """
        if len(self.pieces) != len(other.pieces) or not self.pieces:
            return complex(np.nan)
        ratios = [one.ratio(two) for one, two in zip(self.pieces, other.pieces)]
        agree = np.ptp(np.real(ratios)) + np.ptp(np.imag(ratios)) <= SPECTRAL_ACCURACY * abs(ratios[0])
        return complex(ratios[0]) if agree else complex(np.nan)

    @property
    def corners(self) -> tuple[float, ...]:
        """Frequencies in Hz at which pieces begin and end."""
        return tuple(sorted({edge for piece in self.pieces for edge in (piece.lower, piece.upper)}))


@answering
def psd(frequencies_hz, values, of: str = "force", unit: str | None = None, interpolation: str = "log-log") -> Spectrum:
    """Tabulated one-sided power spectral density, zero outside the table.

    Args:
        frequencies_hz: corner frequencies in Hz, ascending, shape (F,).
        values: G at the corners, shape (F,); with "steps" shape (F - 1,), each from its frequency to the next.
        of: random quantity: "force" (also a moment), or the "displacement", "velocity" or "acceleration" of a prescribed motion.
        unit: of the values, such as "g^2/Hz", "(m/s^2)^2/Hz" or "N^2/Hz"; "N^2 s/rad" and other units per rad/s are those of a two-sided density
            over the angular frequency, G(f) = 4 pi S(2 pi f). SI units by default.
        interpolation: "log-log" (straight lines in a plot with logarithmic axes, as in test standards), "linear" or "steps".

    Returns:
        A ``Spectrum``.

    Raises:
        InputError: frequencies that do not ascend, negative values, units that are not those of a density.

    >>> float(psd([1.0, 4.0], [1.0, 16.0])(2.0))
    4.0
    """
    f = real_array(frequencies_hz, "frequencies_hz", shape=(None,))
    check_known(of, KINDS, "of")
    check_known(interpolation, INTERPOLATIONS, "interpolation")
    is_cross = np.iscomplexobj(np.asarray(values))
    G = np.asarray(values, dtype=complex) if is_cross else real_array(values, "values", shape=(None,))
    count = len(f) - (interpolation == "steps")
    if len(f) < 2:
        raise InputError(f"frequencies_hz: found {len(f)}; expected at least two corner frequencies")
    if G.shape != (count,):
        raise InputError(
            f"values: found {G.size} for {len(f)} frequencies; expected {count}{', one for each band' * (count < len(f))}"
        )
    if f[0] < 0:
        raise InputError(f"frequencies_hz: found {f[0]:g} Hz; a one-sided density has frequencies >= 0")
    bad = np.flatnonzero(np.diff(f) <= 0)
    if len(bad):
        first = bad[0]
        raise InputError(
            f"frequencies_hz: {f[first]:g} Hz is followed by {f[first + 1]:g} Hz; expected ascending frequencies, each once"
        )
    if not is_cross and (G < 0).any():
        place = int(np.argmin(G))
        raise InputError(f"values: found {G[place]:g} at {f[place]:g} Hz; a power spectral density is not negative")
    if interpolation == "log-log" and (is_cross or (G == 0).any() or f[0] == 0):
        what = "a frequency of 0 Hz" if f[0] == 0 else "complex values" if is_cross else "a value of 0"
        raise InputError(f'{what} has no place on logarithmic axes; expected positive numbers, or interpolation="linear"')
    G = G * _factor(unit, of)
    if interpolation == "steps":
        pieces = [PowerLaw(a, b, level) for a, b, level in zip(f, f[1:], G)]
    elif interpolation == "linear":
        pieces = [Line(a, b, one, two) for a, b, one, two in zip(f, f[1:], G, G[1:])]
    else:
        slopes = np.diff(np.log(G)) / np.diff(np.log(f))
        pieces = [PowerLaw(a, b, level, slope if c != level else 0.0) for a, b, level, c, slope in zip(f, f[1:], G, G[1:], slopes)]
    own = tuple(piece for piece in pieces if piece.level or getattr(piece, "end", 0))
    return Spectrum(own, of, f"table from {f[0]:g} Hz to {f[-1]:g} Hz{_conversion(unit, of)}")


@answering
def white_noise(intensity: float, of: str = "force", unit: str | None = None) -> Spectrum:
    """White noise of the one-sided intensity G per Hz; a force on one mass gives E[x^2] = G / (4 c k).

    Args:
        intensity: G; a two-sided S0 per rad/s is G = 4 pi S0.
        of, unit: as in ``psd``.

    Returns:
        A ``Spectrum``.

    >>> white_noise(2.0)
    Spectrum(of force, white noise)
    """
    check_known(of, KINDS, "of")
    level = real_number(intensity, "intensity", minimum=0.0) * _factor(unit, of)
    return Spectrum((PowerLaw(0.0, np.inf, level),) if level else (), of, f"white noise{_conversion(unit, of)}")


@answering
def rational_spectrum(
    intensity: float, numerator: Sequence[float], denominator: Sequence[float], of: str = "force", unit: str | None = None
) -> Spectrum:
    """White noise of intensity G0 through a filter F(s): G(f) = G0 |F(2 pi i f)|^2.

    Args:
        intensity: G0, one-sided per Hz.
        numerator, denominator: of F, highest power of s first, as in scipy.signal.
        of, unit: as in ``psd``, of the filtered noise.

    Returns:
        A ``Spectrum``.

    Raises:
        InputError: a filter that is not stable.

    >>> float(rational_spectrum(3.0, [1.0], [1.0, 1.0])(1 / (2 * np.pi)).round(12))
    1.5
    """
    above = np.trim_zeros(real_array(numerator, "numerator", shape=(None,)), "f")
    below = np.trim_zeros(real_array(denominator, "denominator", shape=(None,)), "f")
    if not len(below):
        raise InputError("denominator: found 0; expected coefficients, highest power of s first")
    poles = np.roots(below)
    if len(poles) and poles.real.max() >= 0:
        raise InputError(
            f"denominator: found a root {poles[poles.real.argmax()]:.4g}; a filter of noise needs roots with negative real parts"
        )
    level = real_number(intensity, "intensity", minimum=0.0) * _factor(unit, of)
    pieces = (Rational(level, tuple(above), tuple(below)),) if level and len(above) else ()
    return Spectrum(pieces, of, f"filtered white noise{_conversion(unit, of)}")


@answering
def kanai_tajimi(intensity: float, frequency_hz: float = 2.5, damping_ratio: float = 0.6, unit: str | None = None) -> Spectrum:
    """Ground acceleration of an earthquake: white noise through a layer of soil, F(s) = (2 z w s + w^2) / (s^2 + 2 z w s + w^2).

    Args:
        intensity: one-sided, of the acceleration of the rock.
        frequency_hz: of the soil.
        damping_ratio: z of the soil.
        unit: unit of the intensity, as in ``psd``.

    Returns:
        A ``Spectrum`` of acceleration. Source: Tajimi, Proc. 2nd World Conference on Earthquake Engineering (1960).

    >>> float(kanai_tajimi(0.1)(0.0).round(12))
    0.1
    """
    w = 2 * np.pi * real_number(frequency_hz, "frequency_hz", positive=True)
    z = real_number(damping_ratio, "damping_ratio", positive=True)
    spectrum = rational_spectrum(intensity, [2 * z * w, w**2], [1.0, 2 * z * w, w**2], "acceleration", unit)
    return Spectrum(spectrum.pieces, spectrum.of, f"Kanai-Tajimi, soil of {frequency_hz:g} Hz{_conversion(unit, spectrum.of)}")


@answering
def dryden(rms: float, speed: float, length: float, component: str = "longitudinal") -> Spectrum:
    """The velocity of atmospheric turbulence along a flight: sigma^2 as total power, correlation length L, flight speed V.

    Args:
        rms: sigma in m/s.
        speed: V in m/s.
        length: L in m.
        component: "longitudinal", F = 1 / (1 + T s), or "lateral" and "vertical", F = (1 + sqrt(3) T s) / (1 + T s)^2, with T = L / V.

    Returns:
        A ``Spectrum`` of velocity. Source: MIL-HDBK-1797, section 3.7.

    >>> dryden(1.0, 50.0, 200.0)
    Spectrum(of velocity, Dryden, longitudinal)
    """
    sigma, T = (
        real_number(rms, "rms", minimum=0.0),
        real_number(length, "length", positive=True) / real_number(speed, "speed", positive=True),
    )
    check_known(component, ("longitudinal", "lateral", "vertical"), "component")
    if component == "longitudinal":
        above, below, intensity = [1.0], [T, 1.0], 4 * sigma**2 * T
    else:
        above, below, intensity = [np.sqrt(3.0) * T, 1.0], [T**2, 2 * T, 1.0], 2 * sigma**2 * T
    return Spectrum(rational_spectrum(intensity, above, below, "velocity").pieces, "velocity", f"Dryden, {component}")


#: ISO 8608:2016, table C.1: geometric mean of the displacement density at 0.1 cycles/m in m^3, and the range of spatial frequencies.
ROAD_CLASSES = {letter: 16 / 1000**2 * 4.0**number for number, letter in enumerate("ABCDEFGH")}
ROAD_RANGE = (0.011, 2.83)


@answering
def road_profile(road_class: str, speed: float, waviness: float = 2.0) -> Spectrum:
    """The displacement of a wheel on a road of ISO 8608: G(n) = G(n0) (n / n0)^-waviness, n0 = 0.1 cycles/m, n = f / speed.

    Args:
        road_class: "A" (very good) to "H".
        speed: speed of the vehicle in m/s.
        waviness: exponent; 2 in the standard.

    Returns:
        A ``Spectrum`` of displacement between the spatial frequencies 0.011 and 2.83 cycles/m. Source: ISO 8608:2016, Annex C.

    >>> round(float(road_profile("A", 10.0)(1.0)), 12)
    1.6e-06
    """
    if road_class not in ROAD_CLASSES:
        raise InputError(f"road_class: found {road_class!r}; expected a letter from A to H")
    v, w = real_number(speed, "speed", positive=True), real_number(waviness, "waviness")
    low, high = ROAD_RANGE
    level = ROAD_CLASSES[road_class] * (low / 0.1) ** -w / v
    return Spectrum((PowerLaw(low * v, high * v, level, -w),), "displacement", f"ISO 8608 class {road_class} at {v:g} m/s")


def _factor(unit: str | None, of: str) -> float:
    """Conversion factor from a unit of a density to SI units squared per Hz, one-sided."""
    if unit is None:
        return 1.0
    text = re.sub("[·*]", " ", unit.replace("**", "^").replace("²", "^2")).strip() if isinstance(unit, str) else ""
    for pattern, rate in (
        ("/s", "/s"),
        ("/s\\^2/ ?Hz", "/s"),
        ("/s\\^3", "/s^2"),
        ("/s\\^4/ ?Hz", "/s^2"),
    ):  # m^2/s^3 is (m/s^2)^2/Hz
        text = re.sub(rf"^(\w+)\^2{pattern}$", rf"(\1{rate})^2/Hz", text)
    known = UNITS[of]
    match = re.fullmatch(r"\(?([^()]*?)\)?\^2\s*(/\s*Hz|s/rad|/\s*\(rad/s\)|s)", text)
    name = match[1].strip() if match else ""
    if name not in known:
        examples = {"force": "N^2/Hz", "displacement": "mm^2/Hz", "velocity": "(m/s)^2/Hz", "acceleration": "g^2/Hz"}
        advice = f'; "{text}" is no density: it must be a unit squared per Hz' if text in known else ""
        raise InputError(f'unit: found {unit!r} for a density of {of}; expected for example "{examples[of]}"{advice}')
    return known[name] ** 2 * (4 * np.pi if "rad" in match[2] else 1.0)


def _conversion(unit: str | None, of: str) -> str:
    """Conversion of a density from this unit, as text; "" for SI units."""
    factor, si = _factor(unit, of), {"force": "N", "displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}[of]
    if factor == 1:
        return ""
    two_sided = "two-sided per rad/s, G = 4 pi S(2 pi f): " if "rad" in (unit or "").split("^2")[-1] else ""
    angle = "rad" + si[1:] if re.search(r"rad|deg|N ?\*?m", (unit or "").split("^2")[0]) and si != "N" else si
    return f", {two_sided}1 {unit} = {number_text(factor)} {f'({angle})' if '/' in angle else angle}^2/Hz"


# Several random inputs: independent, partly coherent, delayed, or with cross spectra.

#: A Hermitian matrix counts as positive semidefinite where no eigenvalue is below this share of the largest one.
INDEFINITE = 1e4 * EPS

#: Frequencies between two corners at which that is tested.
EACH_PIECE = 9


@dataclass(frozen=True, eq=False)
class SpectralMatrix:
    """S(f) with the spectra on the diagonal and S_ij = coherence_ij sqrt(S_i S_j) e^{-i w (delay_i - delay_j)}, or given cross spectra."""

    names: tuple[str, ...]  # names of the m inputs
    spectra: tuple[Spectrum, ...]  # spectra of each
    coherence: np.ndarray  # square roots of the ordinary coherence, symmetric, shape (m, m)
    delays: np.ndarray  # in s, shape (m,)
    cross: Mapping[tuple[int, int], Spectrum] = field(default_factory=dict)  # given entries (i, j) with i < j

    @property
    def corners(self) -> np.ndarray:
        """Corner frequencies of all entries in Hz, ascending; the last may be infinite."""
        return np.unique([corner for spectrum in (*self.spectra, *self.cross.values()) for corner in spectrum.corners])

    @property
    def longest_delay(self) -> float:
        """The largest difference of two delays in s."""
        return max(self.shifts, default=0.0)

    @property
    def coupled(self) -> np.ndarray:
        """Which inputs are coherent or have a cross spectrum, shape (m, m)."""
        coupled = self.coherence != 0
        for i, j in self.cross:
            coupled[i, j] = coupled[j, i] = True
        return coupled

    @property
    def groups(self) -> list[list[int]]:
        """The indices of inputs that depend on each other, directly or indirectly."""
        from scipy.sparse.csgraph import connected_components

        count, label = connected_components(self.coupled, directed=False)
        return [np.flatnonzero(label == number).tolist() for number in range(count)]

    def of_inputs(self, chosen: list[int]) -> SpectralMatrix:
        """The matrix of some of the inputs."""
        at = {i: place for place, i in enumerate(chosen)}
        cross = {(at[i], at[j]): given for (i, j), given in self.cross.items() if i in at and j in at}
        names, spectra = tuple(self.names[i] for i in chosen), tuple(self.spectra[i] for i in chosen)
        return SpectralMatrix(names, spectra, self.coherence[np.ix_(chosen, chosen)], self.delays[chosen], cross)

    @property
    def delayed_pairs(self) -> list[tuple[int, int]]:
        """Coherent inputs (i, j) with different delays, i > j."""
        return [
            (i, j) for i in range(len(self.delays)) for j in range(i) if self.coherence[i, j] and self.delays[i] != self.delays[j]
        ]

    @property
    def shifts(self) -> list[float]:
        """The moduli of the differences of these delays in s."""
        return [abs(self.delays[i] - self.delays[j]) for i, j in self.delayed_pairs]

    def singularities(self, middle: float) -> list[complex]:
        """Frequencies near which the piece at ``middle`` is not analytic."""
        chosen = [spectrum.piece_at(middle) for spectrum in (*self.spectra, *self.cross.values())]
        pairs = ((i, j) for i in range(len(self.spectra)) for j in range(i) if self.coherence[i, j])
        has_roots = any(chosen[i] != chosen[j] for i, j in pairs)
        return [
            one for piece in chosen if piece is not None and (has_roots or not hasattr(piece, "end")) for one in piece.singularities
        ]

    def slopes(self, middle: float) -> np.ndarray:
        """The exponent of f of each spectrum towards infinity, minus infinity where it is zero, shape (m,)."""
        pieces = [spectrum.piece_at(middle) for spectrum in self.spectra]
        return np.array([-np.inf if piece is None else piece.slope for piece in pieces])

    def __call__(self, f: np.ndarray, middle: float) -> np.ndarray:
        """S at real or complex frequencies, continued from the pieces at ``middle``, shape (m, m, F)."""
        f = np.asarray(f)
        pieces = [spectrum.piece_at(middle) for spectrum in self.spectra]
        own = [np.zeros(f.shape, dtype=complex) if piece is None else np.asarray(piece(f), dtype=complex) for piece in pieces]
        m = len(pieces)
        S = np.zeros((m, m, len(f)), dtype=complex)
        for i in range(m):
            S[i, i] = own[i]
            for j in range(i):
                given = self.cross.get((j, i))
                if given is not None:
                    piece = given.piece_at(middle)
                    if piece is not None:
                        S[j, i], S[i, j] = piece(f), np.conj(piece(np.conj(f)))
                elif self.coherence[i, j]:
                    size = own[i] if pieces[i] == pieces[j] else np.sqrt(own[i]) * np.sqrt(own[j])
                    turn = np.exp(-2j * np.pi * f * (self.delays[i] - self.delays[j]))
                    S[i, j], S[j, i] = self.coherence[i, j] * size * turn, self.coherence[i, j] * size / turn
        return S

    def within(self, low: float, high: float) -> SpectralMatrix:
        """The matrix between two frequencies, zero outside."""
        spectra = tuple(spectrum.within(low, high) for spectrum in self.spectra)
        return replace(self, spectra=spectra, cross={key: spectrum.within(low, high) for key, spectrum in self.cross.items()})

    def check(self) -> None:
        """Refuse a matrix that is not positive semidefinite."""
        corners = self.corners
        if not len(corners) or not (self.cross or (self.coherence != np.eye(len(self.names))).any()):
            return
        ends = np.append(corners[:-1], corners[-1] if np.isfinite(corners[-1]) else corners[-2] + 1.0)
        for f in np.unique(np.linspace(ends[:-1], ends[1:], EACH_PIECE)):
            values = np.linalg.eigvalsh(self(np.array([f]), f)[..., 0])
            if values[0] < -INDEFINITE * max(values[-1], np.finfo(float).tiny):
                raise InputError(
                    f"the spectra of {', '.join(self.names)} are not those of one process: at {f:g} Hz their Hermitian matrix has a negative eigenvalue; "
                    "expected |S_ij|^2 <= S_ii S_jj and coherences that fit each other"
                )


def spectral_matrix(excitation: Mapping, coherence=None, delays: Mapping | None = None) -> SpectralMatrix:
    """The spectral matrix of a table of spectra."""
    if not isinstance(excitation, Mapping) or not excitation:
        raise InputError('excitation: expected a table of spectra by the names of inputs, such as {"base": mb.psd(...)}')
    for name, spectrum in excitation.items():
        if not isinstance(spectrum, Spectrum):
            raise InputError(
                f"excitation of {name}: found an object of type {type(spectrum).__name__}; expected mb.psd(...) or mb.white_noise(...)"
            )
        if spectrum.is_complex and not isinstance(name, tuple):
            raise InputError(f"excitation of {name}: found complex values, which only cross spectra of two inputs have")
    names = tuple(name for name in excitation if not isinstance(name, tuple))
    places = {name: place for place, name in enumerate(names)}

    def pair(key) -> tuple[int, int]:
        if not isinstance(key, tuple) or len(key) != 2 or key[0] == key[1]:
            raise InputError(f"found {key!r}; expected a pair of names of different inputs")
        for name in key:
            if name not in places:
                raise InputError(f"{key}: there is no input {name!r}{nearest(str(name), names)}")
        return places[key[0]], places[key[1]]

    if delays is not None and not isinstance(delays, Mapping):
        raise InputError(f"delays: found {delays!r}; expected a table by the names of inputs, such as {{{names[0]!r}: 0.1}}")
    gamma, shift, cross = np.eye(len(names)), np.zeros(len(names)), {}
    for name, value in (delays or {}).items():
        if name not in places:
            raise InputError(f"delays: there is no input {name!r}{nearest(str(name), names)}")
        shift[places[name]] = real_number(value, f"delay of {name}")
    if isinstance(coherence, Mapping):
        for key, value in coherence.items():
            i, j = pair(key)
            gamma[i, j] = gamma[j, i] = _coherence(value, f"coherence of {key[0]} and {key[1]}")
    elif coherence is not None or delays:
        share = 1.0 if coherence is None else _coherence(coherence, "coherence")
        gamma = np.full(gamma.shape, share)
        np.fill_diagonal(gamma, 1.0)
    for key, spectrum in excitation.items():
        if isinstance(key, tuple):
            i, j = pair(key)
            if key[::-1] in excitation:
                raise InputError(
                    f"excitation: the cross spectrum of {key[0]} and {key[1]} is given twice, in both orders; give one"
                )
            if shift[i] != shift[j]:
                raise InputError(
                    f"delays: {key[0]} and {key[1]} have a cross spectrum, which has their delay already; give one of both"
                )
            cross[min(i, j), max(i, j)] = spectrum if i < j else _conjugate(spectrum)
    result = SpectralMatrix(names, tuple(excitation[name] for name in names), gamma, shift, cross)
    result.check()
    return result


def _coherence(value, what: str) -> float:
    number = real_number(value, what, minimum=0.0)
    if number > 1:
        raise InputError(f"{what}: found {number:g}; expected a number from 0 to 1")
    return float(np.sqrt(number))


def _conjugate(spectrum: Spectrum) -> Spectrum:
    pieces = [
        replace(piece, level=np.conj(piece.level), **({"end": np.conj(piece.end)} if hasattr(piece, "end") else {}))
        for piece in spectrum.pieces
    ]
    return Spectrum(tuple(pieces), spectrum.of, spectrum.name)
