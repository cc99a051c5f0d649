"""Frequency responses H(i w) = C A(i w)^-1 B: values with errors, poles, residues and derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import factorial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from ..exchange.trajectories import csv_of, write_arrays
from ..exchange.universal import UNIVERSAL, Geometry, write_frequency_responses
from ..ground.by_name import answering
from ..ground.checks import counted, names_of, optional_package, places_of, real_array, real_number
from ..ground.display import Pictured, TextTable, notice_table, number_text
from ..ground.errors import InputError, MbconstrainedError
from ..ground.files import replacing
from ..ground.named_arrays import named_array
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, FLOAT64_DIGITS, LINE_ACCURACY, SUM_SAFETY, TRUST_LIMIT
from ..polynomial.delayed_terms import delayed_terms
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .features import Antiresonance, Peak, antiresonances_of, frequencies_by_poles, peaks_of
from .harmonic import Harmonic
from .pole_residue_form import Pole, PoleOnLine

if TYPE_CHECKING:
    from ..exact.enclosure.intervals import Enclosure


# Frequency response H(i w) = (i w)^p C A(i w)^-1 B with an error estimate of every entry, its poles, residues and polynomial part.

#: Number of lines from which poles and residues of a full A(s) take less time than solutions at all lines.
SUM_LINES = 320

#: Number of coordinates from which a sum over modes in graded coordinates takes less time than the Jordan pairs.
MODAL_SIZE = 40

#: Lines at which the sum of the terms is compared with solutions.
COMPARED = 16


@answering
@dataclass(frozen=True, repr=False, eq=False)
class FrequencyResponse(Pictured):
    """Frequency response H(i w): a load Re(f e^{+i w t}) has the steady-state response Re(H(i w) f e^{+i w t}).

    H(s) = C (s I - J)^-1 B + sum of D_k s^k, from the finite and the infinite Jordan pair of the equations (Moysis et al., Theorem
    2.8); values come from solutions of A(i w) X = B, or from that sum where it is as accurate. Dead times of the inputs multiply
    values by e^(-i w delay); poles, residues, polynomial part and antiresonances are those without them.

    Attributes:
        harmonic: the matrices.
        frequencies_hz: shape (F,).
        values: complex, shape (outputs, inputs, F). At a pole on the axis they are the finite part, and ``error_estimate`` is infinite.
        error_estimate: relative error of each value, shape (outputs, inputs, F).
        poles_on_lines: the frequencies at which H has a pole.

    >>> import mbconstrained as mb
    >>> H = mb.MechanicalSystem([[1.0]], [[0.2]], [[4.0]]).frequency_response([0.0, 1 / np.pi])
    >>> H.values[0, 0].round(6), H.units.item()
    (array([0.25+0.j , 0.  -2.5j]), 'm/N')
    """

    harmonic: Harmonic
    frequencies_hz: np.ndarray
    values: np.ndarray
    error_estimate: np.ndarray
    poles_on_lines: tuple[PoleOnLine, ...] = ()

    _instead: ClassVar = {
        "amplitude": "abs(H.values)",
        "bode": "plot",
        "frequencies": "frequencies_hz",
        "magnitude": "abs(H.values)",
        "nyquist": "plot",
        "phase": "np.angle(H.values)",
    }

    def __post_init__(self):
        for name in ("values", "error_estimate"):
            object.__setattr__(self, name, named_array(getattr(self, name), self.outputs, self.inputs))

    def __getitem__(self, key) -> np.ndarray:
        """The values of an output by one of the inputs, ``H["cart", "road"]``, shape (F,); of a single input ``H["cart"]``.

        Raises:
            InputError: an unknown name; several inputs, of which none is named.

        >>> import mbconstrained as mb
        >>> H = mb.MechanicalSystem([[1.0]], [[0.2]], [[4.0]], names=["cart"]).frequency_response([0.0])
        >>> H["cart"], H["cart", "cart"]
        (array([0.25+0.j]), array([0.25+0.j]))
        """
        if isinstance(key, str):
            if len(self.inputs) > 1:
                raise InputError(f'found one name; expected those of an output and an input, such as ["{key}", "{self.inputs[0]}"]')
            key = key, self.inputs[0]
        return self.values[key]

    def _summary(self) -> str:
        sizes = ((self.outputs, "output"), (self.inputs, "input"), (self.frequencies_hz, "frequency"))
        several = {"frequency": "frequencies"}
        return ", ".join([self.quantity, *(counted(len(own), what, several.get(what)) for own, what in sizes)])

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return self.harmonic.input_names

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return self.harmonic.output_names

    @property
    def quantity(self) -> str:
        """Name of the quantity, such as receptance."""
        return self.harmonic.quantity

    @property
    def units(self) -> np.ndarray:
        """The unit of each entry, shape (outputs, inputs)."""
        return named_array(self.harmonic.units, self.outputs, self.inputs)

    @property
    def angular_frequencies(self) -> np.ndarray:
        """w = 2 pi f in rad/s, shape (F,)."""
        return 2 * np.pi * self.frequencies_hz

    @property
    def poles(self) -> np.ndarray:
        """The poles in 1/s with their conjugates, each once, ascending by modulus; ``residues`` has their orders."""
        return np.array([pole.value for pole in self.harmonic.form.poles], dtype=complex)

    @property
    def residues(self) -> tuple[np.ndarray, ...]:
        """Residues of each pole, R_0, R_1, ..., shape (order, outputs, inputs): the terms R_j / (s - pole)^(j + 1)."""
        return tuple(pole.residues for pole in self.harmonic.form.poles)

    @property
    def polynomial(self) -> np.ndarray:
        """D_0, D_1, ... of the polynomial part, shape (K, outputs, inputs); K = 0 where H vanishes at infinity."""
        return self.harmonic.form.polynomial

    @property
    def rigid_body(self) -> np.ndarray:
        """The coefficient of 1/s^2, shape (outputs, inputs): for receptances the inverse mass of rigid-body motions."""
        at_zero = [pole for pole in self.harmonic.form.poles if not pole.value and pole.order > 1]
        shape = (len(self.outputs), len(self.inputs))
        return at_zero[0].residues[1].real if at_zero else np.zeros(shape)

    def __call__(self, frequencies_hz) -> FrequencyResponse:
        """Return the response at other frequencies."""
        return evaluated(self.harmonic, frequencies_hz)

    def deflection_shape(self, frequency_hz: float, input: str | None = None) -> dict[str, complex]:
        """Return the operating deflection shape: complex amplitudes of all coordinates per unit of an input.

        Args:
            frequency_hz: in Hz.
            input: its name; the first one by default.

        Returns:
            Amplitudes x by the names of the coordinates (and of the constraint rows: their forces, with the opposite sign); x(t) = Re(x e^{i w t}).

        Raises:
            InputError: an unknown input, a negative frequency, or one at a pole on the axis.

        >>> import mbconstrained as mb
        >>> pair = mb.MechanicalSystem([[1.0, 0.0], [0.0, 1.0]], [[0.1, 0.0], [0.0, 0.1]], [[2.0, -1.0], [-1.0, 2.0]], names=["a", "b"])
        >>> shape = pair.frequency_response("auto", ["a"], ["a"]).deflection_shape(0.0)
        >>> {name: round(x.real, 3) for name, x in shape.items()}
        {'a': 0.667, 'b': 0.333}
        """
        self._of_whole_model("deflection_shape")
        f = real_number(frequency_hz, "frequency_hz", minimum=0.0)
        place = 0 if input is None else places_of([input], self.inputs, "input")[0]
        omega = np.atleast_1d(8 * np.arctan(np.longdouble(1)) * f)
        lines = self.harmonic.solver.solve(omega, with_solutions=True)
        if lines.solutions is None or not np.isfinite(lines.errors[:, place]).all():
            raise InputError(f"frequency_hz: {f:g} Hz is at a pole on the axis, where the amplitudes are infinite")
        late = np.exp(-1j * self.harmonic.phases(omega)[place, 0]).astype(complex)
        return dict(zip(self.harmonic.A.coordinates, (lines.solutions[:, place, 0] * late).tolist()))

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """The maxima of |H| over all frequencies, entry by entry: frequency, amplitude, half-power bandwidth, phase.

        Undamped resonances have infinite amplitude.
        """
        return tuple(peak for peak in peaks_of(self.harmonic) if peak.frequency_hz < self._highest_hz)

    @cached_property
    def antiresonances(self) -> tuple[Antiresonance, ...]:
        """The oscillating zeros of each entry, eigenvalues of [[A(s), -b], [c, 0]] (Rosenbrock 1970)."""
        return tuple(zero for zero in antiresonances_of(self.harmonic) if zero.frequency_hz < self._highest_hz)

    @property
    def _highest_hz(self) -> float:
        """The highest frequency at which a reduced model is valid."""
        return np.inf if self.harmonic.left_out is None else self.harmonic.left_out.highest_hz

    def _of_whole_model(self, what: str) -> None:
        if self.harmonic.left_out:
            raise InputError(f"{what}: not available for a reduced model of sparse matrices; name more outputs, or give arrays")

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on poles at lines, inputs without effect, and inaccurate values."""
        result = [*self.harmonic.notices, *(_pole_notice(one, self) for one in self.poles_on_lines)]
        for name, column in zip(self.inputs, np.moveaxis(self.values, 1, 0)):
            if len(self.frequencies_hz) and not column.any() and not self.poles_on_lines:
                result.append(Notice(NoticeKind.OMITTED, f'the input "{name}" reaches none of the outputs: its responses are zero'))
        others = np.setdiff1d(np.arange(len(self.frequencies_hz)), [one.line for one in self.poles_on_lines])
        worst = self.error_estimate[..., others].max(axis=(0, 1), initial=0.0)
        if (bad := worst > 2 * LINE_ACCURACY).any():
            at = others[worst.argmax()]
            text = (
                f"{counted(int(bad.sum()), 'frequency has', 'frequencies have')} values with an estimated relative error above "
                f"{2 * LINE_ACCURACY:g}, at most {worst.max():.2g} at {number_text(self.frequencies_hz[at])} Hz"
            )
            result.append(Notice(NoticeKind.ACCURACY, text, doubtful=bool(worst.max() > TRUST_LIMIT)))
        return tuple(result)

    def enclose(self, frequency_hz: float, digits: int = 12) -> Enclosure:
        """Return proved bounds of H at one frequency, real parts first: exact data, w = 2 pi f with all its digits.

        Args:
            frequency_hz: in Hz.
            digits: significant digits of each value.

        Returns:
            An ``Enclosure`` of shape (2, outputs x inputs): the real and the imaginary parts of the entries, output by output.

        Raises:
            InputError: H has a pole there, or the frequency is negative.
        """
        self._of_whole_model("enclose")
        return _enclosed(self.harmonic, real_number(frequency_hz, "frequency_hz", minimum=0.0), digits)

    def plot(
        self,
        kind: Literal["bode", "nyquist", "parts"] = "bode",
        figure=None,
        *,
        amplitude: Literal["log", "linear", "dB"] = "log",
        unwrapped: bool = True,
        axis: Literal["Hz", "rad/s", "rev/min", "rpm"] = "Hz",
        peaks: bool = True,
    ):
        """Draw the response with matplotlib: a row of axes for each output, a column for each input.

        Args:
            kind: "bode" (amplitude and phase), "nyquist", or "parts" (real and imaginary).
            figure: a matplotlib figure; a new one by default.
            amplitude: the axis of amplitudes, "dB" for 20 log10 |H|.
            unwrapped: whether phases go on beyond 180 degrees.
            axis: the unit of the frequency.
            peaks: whether the peaks of a Bode plot are marked with their frequencies.

        Returns:
            The figure; a transmissibility has a line at 1.

        Raises:
            InputError: an unknown kind or axis.
        """
        from .plots import PlotStyle, draw

        return draw(self, kind, figure, PlotStyle(amplitude, unwrapped, axis, peaks))

    def to_xarray(self):
        """The values as a ``DataArray`` with the dimensions output, input and frequency (Hz), and the error estimate as a coordinate.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        coords = {
            "output": list(self.outputs),
            "input": list(self.inputs),
            "frequency": ("frequency", self.frequencies_hz, {"units": "Hz"}),
            "unit": (("output", "input"), self.units),
            "error_estimate": (("output", "input", "frequency"), self.error_estimate),
        }
        return xarray.DataArray(self.values, coords, ("output", "input", "frequency"), self.quantity)

    def to_pandas(self):
        """The values as a complex ``DataFrame``: the index is the frequency in Hz, the columns are pairs (output, input).

        Raises:
            MissingPackage: pandas is not installed.
        """
        pandas = optional_package("pandas", "to_pandas")
        columns = pandas.MultiIndex.from_product([self.outputs, self.inputs], names=("output", "input"))
        index = pandas.Index(self.frequencies_hz, name="frequency_hz")
        return pandas.DataFrame(self.values.reshape(-1, len(index)).T, index, columns)

    def write(self, path: str | Path, geometry: Geometry | None = None) -> Path:
        """Write the values to a file: CSV (real and imaginary parts with units), NumPy's npz, or a universal file (.uff, data set 58).

        Args:
            path: path of the file, which is replaced when the new one is complete.
            geometry: of a universal file: nodes and directions of the inputs and outputs.

        Returns:
            The path.
        """
        path = Path(path)
        if path.suffix not in (".csv", ".npz", *UNIVERSAL):
            raise InputError(f'path: found the ending "{path.suffix}"; expected .csv, .npz or .uff')
        with replacing(path) as temporary:
            if path.suffix == ".npz":
                write_arrays(temporary, arrays_of(self), ".npz")
            elif path.suffix == ".csv":
                temporary.write_text(_csv_text(self), encoding="utf-8")
            else:
                write_frequency_responses(temporary, self, geometry or Geometry(), path.stem)
        return path


def _pole_notice(one: PoleOnLine, response: FrequencyResponse) -> Notice:
    R = one.pole.residues[-1]
    i, j = np.unravel_index(np.abs(R).argmax(), R.shape)
    real, imag = (part if abs(part) > NOISE * abs(R[i, j]) else 0.0 for part in (R[i, j].real, R[i, j].imag))
    power = f"^{one.pole.order}" if one.pole.order > 1 else ""
    where = "s" if not one.pole.value else f"(s - {one.pole.value.imag:.6g} i)"
    text = (
        f"{number_text(one.frequency_hz)} Hz: {response.quantity} has a pole of order {one.pole.order} there, of "
        f'"{response.outputs[i]}" by "{response.inputs[j]}" the term ({number_text(real)}{imag:+.6g} i) / {where}{power}; '
        "the values are the finite part without the terms of the pole"
    )
    return Notice(NoticeKind.ACCURACY, text)


# Evaluation.


def _checked_frequencies(value) -> np.ndarray:
    """Frequencies in Hz, finite and not negative, as an array (F,)."""
    frequencies = np.atleast_1d(real_array(value, "frequencies_hz"))
    if frequencies.ndim != 1:
        raise InputError(f"frequencies_hz: found an array of shape {frequencies.shape}; expected a list of numbers")
    if frequencies.size and frequencies.min() < 0:
        raise InputError(f"frequencies_hz: found {frequencies.min():g} Hz; expected numbers >= 0 (H(-f) is the conjugate of H(f))")
    return frequencies


def evaluated(harmonic: Harmonic, frequencies_hz) -> FrequencyResponse:
    """The response at these frequencies."""
    if isinstance(frequencies_hz, str):
        if frequencies_hz != "auto":
            raise InputError(f'frequencies_hz: found "{frequencies_hz}"; expected numbers in Hz or "auto"')
        frequencies = frequencies_by_poles(harmonic)
        frequencies = frequencies[frequencies < (harmonic.left_out.highest_hz if harmonic.left_out else np.inf)]
    else:
        frequencies = _checked_frequencies(frequencies_hz)
    harmonic.check(frequencies)
    exact = 8 * np.arctan(np.longdouble(1)) * frequencies  # near a sharp peak a rounded w is another frequency
    omega = exact.astype(float)
    H, errors = _values(harmonic, exact)
    H = H * (1j * omega) ** harmonic.power if harmonic.power else H
    late, phases = np.ones(()), harmonic.phases(exact)
    if harmonic.input_delays:
        late = np.exp(-1j * phases).astype(complex)
        H, errors = H * late, errors + EPS * (1 + phases.astype(float))
    at_rest = _singular_at_rest(harmonic, omega, H, errors)
    errors[..., at_rest] = np.inf  # where K is singular, exactly or up to rounding errors, 0 times A^-1 B is no digit
    _enclose_doubtful(harmonic, np.where(at_rest, np.nan, frequencies), H, errors)
    on_lines = []
    for line in np.flatnonzero(~(errors <= TRUST_LIMIT).all(axis=(0, 1))) if not harmonic.delayed else ():
        s, form = 1j * omega[line], harmonic.form
        if (pole := form.pole_at(s)) is not None:
            shown = pole
            if harmonic.input_delays:
                turned = late[:, line] * np.array([_delayed_term(pole, harmonic.input_delays, j) for j in range(pole.order)])
                shown = replace(pole, residues=turned)
            on_lines.append(PoleOnLine(int(line), float(frequencies[line]), shown))
        elif harmonic.solver.rounded and np.isfinite(errors[..., line]).all():
            continue  # rounding errors of the coefficients are in the poles, too, where no estimate has them
        total, size = form.finite_part(s if pole is None else pole.value, pole)
        gaps = np.abs(s - np.array([one.value for one in form.poles if pole is None or one.value != pole.value], dtype=complex))
        moved = abs(s) / max(gaps.min(initial=np.inf), EPS * abs(s)) if s else 1.0  # the change by an error of the nearest pole
        with np.errstate(over="ignore"):
            own = SUM_SAFETY * NOISE * np.maximum(size / np.maximum(np.abs(total), np.finfo(float).tiny), moved)
        if pole is not None:
            own[pole.residues.any(axis=0)] = np.inf
        if harmonic.input_delays:
            total = late[:, line] * (total + (0.0 if pole is None else _delayed_term(pole, harmonic.input_delays, -1)))
        replaced = ~(errors[..., line] <= np.where(np.isfinite(own), own, 0.0))
        H[..., line] = np.where(replaced, total, H[..., line])
        errors[..., line] = np.where(replaced, own, errors[..., line])
    if harmonic.left_out:
        errors = errors + harmonic.left_out.bound(omega) * omega**harmonic.power / np.maximum(np.abs(H), np.finfo(float).tiny)
    return FrequencyResponse(harmonic, frequencies, H, errors, tuple(on_lines))


def _singular_at_rest(harmonic: Harmonic, omega: np.ndarray, H: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Whether a line is 0 Hz and A(0) is singular to working precision, shape (F,)."""
    at_rest = omega == 0
    doubtful = (errors[..., at_rest] > TRUST_LIMIT) | (H[..., at_rest] == 0)
    if harmonic.delayed or harmonic.left_out or not doubtful.any() or not harmonic.form.is_singular_at_rest:
        return np.zeros_like(at_rest)
    return at_rest


def _delayed_term(pole: Pole, delays: Sequence[float], order: int) -> np.ndarray:
    """The coefficient of 1 / (s - pole)^(order + 1) in e^(-(s - pole) delay) times the terms of the pole, shape (p, m)."""
    late = np.array(delays)
    return sum(R * (-late) ** (j - order) / factorial(j - order) for j, R in enumerate(pole.residues) if j >= order)


#: Enclosures of doubtful lines may take r^2 (r + 8 m) operations of so many, about 2 s, for a matrix of r rows with m inputs.
ENCLOSING = 12_500_000


def _enclose_doubtful(harmonic: Harmonic, frequencies: np.ndarray, H: np.ndarray, errors: np.ndarray) -> None:
    """Replace inaccurate values, next to sharp peaks, by those of the exact engine, the worst first, as far as its time allows."""
    worst = errors.max(axis=(0, 1), initial=0.0)
    doubtful = np.flatnonzero(~(worst <= 2 * LINE_ACCURACY) & np.isfinite(frequencies))
    if (
        not len(doubtful) or harmonic.sizes is not None
    ):  # coefficients that are computed, such as damping of modes, are no exact data
        return
    size, inputs = harmonic.A.size, harmonic.inputs.shape[1]
    most = ENCLOSING // (size**2 * (size + 8 * inputs))
    for line in sorted(doubtful, key=lambda k: -np.nan_to_num(worst[k], nan=np.inf))[:most]:
        if not harmonic.delayed and harmonic.form.pole_at(2j * np.pi * frequencies[line]):
            continue  # a frequency of 16 digits cannot be nearer to it
        try:
            box = _enclosed(harmonic, float(frequencies[line]), FLOAT64_DIGITS)
        except MbconstrainedError:  # a pole is there, or no enclosure is narrow enough
            continue
        real, imaginary = box.middle.reshape(2, *H.shape[:2])
        H[..., line], errors[..., line] = real + 1j * imaginary, 4 * EPS


def _enclosed(harmonic: Harmonic, frequency_hz: float, digits: int) -> Enclosure:
    """Enclosures of real and imaginary parts at a frequency."""
    from ..exact.enclosure.intervals import enclosed_transfer

    own = harmonic
    A = own.A if own.elements is None else own.elements()
    matrices = A, own.imaginary, own.inputs, own.outputs, own.power
    return enclosed_transfer(*matrices, frequency_hz, digits, own.delayed, own.input_delays)


#: Rounding errors of residues, where they are not measured.
NOISE = 64 * EPS


def _values(harmonic: Harmonic, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """C A^-1 B and relative errors: by the sum of all terms where that is cheaper and accurate, else by solutions."""
    solver = harmonic.solver
    if harmonic.delayed or len(omega) < SUM_LINES or solver.is_sparse(omega):
        lines = solver.solve(omega)
        return lines.values, lines.relative
    modal = harmonic.modal_sum if harmonic.A.size > MODAL_SIZE else None
    H, sizes = (modal or replace(harmonic.form, power=0)).values(1j * omega.astype(float))
    order = np.argsort(omega, kind="stable")
    places = np.unique(np.linspace(0, len(omega) - 1, COMPARED).astype(int))
    compared = order[places]
    lines = solver.solve(omega[compared])
    difference = np.abs(lines.values - H[..., compared]) / sizes[..., compared]
    rank = np.argsort(order)
    noise = _largest_nearby(np.where(np.isfinite(difference), difference, 0.0).max(axis=(0, 1)), places, rank)
    with np.errstate(divide="ignore", invalid="ignore"):
        errors = SUM_SAFETY * np.maximum(noise, NOISE / SUM_SAFETY) * sizes / np.abs(H)
    reachable = np.maximum(LINE_ACCURACY, _largest_nearby(lines.relative.max(axis=(0, 1)), places, rank))  # that of solutions
    left = np.flatnonzero(~(errors <= reachable).all(axis=(0, 1)))
    if len(left):
        lines = solver.solve(omega[left])
        relative = lines.relative
        better = ~(errors[..., left] <= relative)
        H[..., left] = np.where(better, lines.values, H[..., left])
        errors[..., left] = np.where(better, relative, errors[..., left])
    return H, errors


def _largest_nearby(values: np.ndarray, places: np.ndarray, rank: np.ndarray) -> np.ndarray:
    """The largest of the values at the four nearest places around each rank; infinite values do not count."""
    padded = np.pad(np.where(np.isfinite(values), values, 0.0), 2, mode="edge")
    return np.max([padded[np.searchsorted(places, rank) + k] for k in range(4)], axis=0)


def frequency_response(A: PolynomialMatrix, frequencies_hz, inputs=None, outputs=None, *, delayed=None) -> FrequencyResponse:
    """Return the frequency response H(i w) = C A(i w)^-1 B of A(d/dt) x = B u, y = C x.

    Args:
        A: A(s), size r.
        frequencies_hz: in Hz, shape (F,), or "auto": placed by the poles so that no peak is missed.
        inputs: B, shape (r, m), or names of equations; all of them by default.
        outputs: C, shape (p, r), or names of coordinates; all of them by default.
        delayed: terms with dead time, as of ``mbconstrained.solve``: H = C (A(s) + sum of A_j(s) e^(-s delay_j))^-1 B.

    Returns:
        A ``FrequencyResponse``.

    Raises:
        InputError: shapes that do not match, unknown names, frequencies that are negative or not finite.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> H = frequency_response(PolynomialMatrix([[[1.0]], [[1.0]]]), [0.0])
    >>> H.values.item(), H.poles.tolist()
    ((1+0j), [(-1+0j)])
    """
    if not isinstance(A, PolynomialMatrix):
        raise InputError(f"A: found an object of type {type(A).__name__}; expected a PolynomialMatrix")
    B, input_names = _selected(inputs, A.equations, "input", A.size)
    C, output_names = _selected(outputs, A.coordinates, "output", A.size)
    units = np.full((len(C), len(B)), "")
    harmonic = Harmonic(A, B.T, C, input_names=input_names, output_names=output_names, units=units)
    return evaluated(replace(harmonic, delayed=delayed_terms(delayed, A.size)), frequencies_hz)


def _selected(chosen, names: Sequence[str], what: str, size: int) -> tuple[np.ndarray, tuple[str, ...]]:
    """Rows of a given matrix, or of the identity, with names."""
    if chosen is None:
        return np.eye(size), tuple(names)
    if isinstance(chosen, str) or (isinstance(chosen, (list, tuple)) and all(isinstance(one, str) for one in chosen)):
        places = places_of([chosen] if isinstance(chosen, str) else chosen, names, what)
        return np.eye(size)[places], tuple(names[i] for i in places)
    shape = (size, None) if what == "input" else (None, size)
    matrix = real_array(chosen, f"{what}s", shape=shape)
    rows = matrix.T if what == "input" else matrix
    return rows, names_of(None, len(rows), f"{what}s", what + " ")


def arrays_of(response: FrequencyResponse) -> dict[str, np.ndarray]:
    """Frequencies, values, error estimates, names, units and quantity, by name."""
    texts = {"outputs": np.array(response.outputs), "inputs": np.array(response.inputs), "units": np.array(response.units)}
    numbers = {name: getattr(response, name) for name in ("frequencies_hz", "values", "error_estimate")}
    return {**numbers, **texts, "quantity": np.array(response.quantity)}


def _csv_text(response: FrequencyResponse) -> str:
    """Real and imaginary parts with names and units, one line for each frequency."""
    columns = {"frequency (Hz)": response.frequencies_hz}
    for i, output in enumerate(response.outputs):
        for j, input in enumerate(response.inputs):
            for part in ("real", "imag"):
                columns[f"{part} {output}/{input} ({response.units[i, j]})"] = getattr(response.values[i, j], part)
    return csv_of(columns)
