"""The frequency response of a scene: peaks and antiresonances, its plots, and the shape in which the model moves at each frequency."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..control.transfer_function import transfer_function_response
from ..frequency.features import Antiresonance, Peak, frequencies_by_poles, poles_of
from ..frequency.frequency_response import FrequencyResponse, arrays_of, evaluated, frequency_response
from ..frequency.plots import AXIS_FACTORS, continuous_phase, principal_phase
from ..frequency.pole_residue_form import poles_on_axis
from ..ground.checks import counted
from ..ground.display import TextTable
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind, distinct
from ..ground.tolerances import LINE_ACCURACY
from ..ground.units import force_unit, rate_unit
from ..mechanics.channels import channels
from ..mechanics.harmonic_response import FORCE_TRANSMISSIBILITY
from ..page.animation import Deflections
from ..page.content import Curve, Plot, Scale, TimeFunctions
from ..scene.file import at
from ..scene.run.drawing import LinearRobot, ShapeDrawing
from ..scene.schema.analysis_tables import FrequencyTable
from .base import MOST_ROWS_OF_PAGE, Analysis, Answer, limited

if TYPE_CHECKING:
    from ..mechanics.system import MechanicalSystem
    from ..scene.run.scene_data import SceneData

#: Parts of the stored functions in each decade of the frequency: on a logarithmic axis each is as wide.
PARTS_EACH_DECADE = 8

#: Lines closer to a pole on the axis than this share of its frequency do not determine the height of the picture.
NEAR_POLE = 1e-3

#: Height of the picture above those lines, as a factor.
ABOVE = 10.0

#: Below the highest value of a curve in dB.
LOWEST_DECIBEL = 360.0

#: A response whose largest value is below this share of that of another is zero but for rounding errors, and has no curve.
ABSENT = 1e-13

#: More lines in one plot are drawn from every second, third ... of them.
MOST_LINES = 4000


def _antiresonances(response: FrequencyResponse) -> tuple[Antiresonance, ...]:
    """The antiresonances; none of equations with delays, of which there are infinitely many."""
    return () if response.harmonic.delayed else response.antiresonances


@dataclass(frozen=True, eq=False)
class _Entry:
    """One response of a plot: its indices, its name, and its factor of the displayed unit."""

    i: int
    j: int
    name: str
    factor: float


class _Drawn:
    """The functions of all responses of a page, evaluated once for each set of frequencies."""

    def __init__(self, response: FrequencyResponse, table: FrequencyTable, colors: Sequence[int]):
        self.harmonic, self.table, self.colors = response.harmonic, table, colors
        self.axis_factor = AXIS_FACTORS[table.axis]
        given = response.frequencies_hz[response.frequencies_hz > 0]
        placed = frequencies_by_poles(self.harmonic)
        inside = placed[(placed > given[0]) & (placed < given[-1])]
        lines = np.union1d(given, inside)
        lines = lines[:: len(lines) // MOST_LINES + 1]
        self.poles = np.array([pole.value.imag / (2 * np.pi) for pole in poles_on_axis(poles_of(self.harmonic)) if pole.value.imag])
        self.lines = np.setdiff1d(lines, response.frequencies_hz[[one.line for one in response.poles_on_lines]])
        self.values = evaluated(self.harmonic, self.lines).values
        errors = response.error_estimate[np.isfinite(response.error_estimate)]
        self.is_accurate = bool(errors.max(initial=0.0) <= 2 * LINE_ACCURACY)
        self.known: tuple[np.ndarray, np.ndarray] = (np.zeros(0), np.zeros(0))
        decades = np.log10(self.lines[-1] / self.lines[0]) if len(self.lines) > 1 else 0.0
        parts = np.geomspace(self.lines[0], self.lines[-1], int(PARTS_EACH_DECADE * decades) + 2)[1:-1]
        zeros = [zero.frequency_hz for zero in _antiresonances(response) if abs(zero.damping_ratio) < NEAR_POLE**2]
        self.breaks = np.unique([*parts, *self.poles, *zeros])

    @property
    def is_far(self) -> np.ndarray:
        """Lines that are not near a pole on the axis, shape (F,)."""
        far = np.ones(len(self.lines), dtype=bool)
        for pole in self.poles:
            far &= np.abs(self.lines - pole) > NEAR_POLE * pole
        return far if far.any() else ~far

    def at(self, frequencies: np.ndarray) -> np.ndarray:
        """H, shape (outputs, inputs, F)."""
        if not np.array_equal(self.known[0], frequencies):
            self.known = frequencies, evaluated(self.harmonic, frequencies).values
        return self.known[1]

    def curves(self, entries: list[_Entry], part: Callable[[_Entry, np.ndarray, np.ndarray], np.ndarray]) -> tuple[Curve, ...]:
        """A curve for each response."""
        factor = self.axis_factor

        def functions(frequencies: np.ndarray) -> np.ndarray:
            H = self.at(frequencies / factor)
            return np.array([part(entry, frequencies / factor, H[entry.i, entry.j]) for entry in entries])

        stored = TimeFunctions(functions, factor * self.breaks, 0.0) if self.is_accurate else None
        several = len({entry.i for entry in entries}) < len(entries)
        return tuple(
            Curve(
                entry.name,
                part(entry, self.lines, self.values[entry.i, entry.j]),
                row if several else self.colors[entry.i],
                None if stored is None else (stored, row),
            )
            for row, entry in enumerate(entries)
        )


def _plot(drawn: _Drawn, title: str, unit: str, curves: tuple[Curve, ...], quantity: str, vertical: Scale = "linear") -> Plot:
    axes: dict[str, Any] = {"across_unit": drawn.table.axis, "variable": "frequency", "scales": ("log", vertical)}
    return Plot(title, unit, drawn.axis_factor * drawn.lines, curves, quantity=quantity, **axes)


def _bode(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    is_decibel = drawn.table.amplitude == "dB"
    highest = {each: float(np.abs(each.factor * drawn.values[each.i, each.j][drawn.is_far]).max()) for each in entries}

    def amplitude(entry: _Entry, _, H: np.ndarray) -> np.ndarray:
        size = np.abs(entry.factor * H)
        if not is_decibel:
            return size
        lowest = highest[entry] * 10 ** (-LOWEST_DECIBEL / 20) or 1.0
        return 20 * np.log10(np.maximum(size, lowest))

    present = [each for each in entries if highest[each] > ABSENT * max(highest.values())]
    curves = drawn.curves(present, amplitude)
    if len(drawn.poles):  # an infinite peak has a finite picture
        most = ABOVE * np.array([highest[each] or 1.0 for each in present])
        most = 20 * np.log10(most) if is_decibel else most
        curves = tuple(replace(curve, values=np.minimum(curve.values, limit)) for curve, limit in zip(curves, most))
    if quantity == "transmissibility":
        one = np.full(len(drawn.lines), 0.0 if is_decibel else 1.0)
        curves += (Curve("as the support", one, max(curve.color or 0 for curve in curves) + 1),)
    vertical: Scale = "log" if drawn.table.amplitude == "log" and any((curve.values > 0).any() for curve in curves) else "linear"
    shown = ("dB re 1" if unit == "1" else f"dB re 1 {unit}") if is_decibel else unit
    phases = drawn.curves(present, _phase(drawn, present))
    if not present:
        return []
    return [_plot(drawn, title, shown, curves, quantity, vertical), _plot(drawn, f"phase of the {title}", "°", phases, "phase")]


def _phase(drawn: _Drawn, entries: list[_Entry]) -> Callable[[_Entry, np.ndarray, np.ndarray], np.ndarray]:
    """Phases in degrees, continued beyond 180 by the number of turns at the lines where requested."""
    if drawn.table.phase != "unwrapped":
        return lambda entry, _, H: principal_phase(H)
    dead_times, values = drawn.harmonic.dead_time, drawn.values
    along = {each: continuous_phase(values[each.i, each.j], drawn.lines, dead_times(each.j)) for each in entries}

    def unwrapped(entry: _Entry, frequencies: np.ndarray, H: np.ndarray) -> np.ndarray:
        own = principal_phase(H)
        return own + 360.0 * np.round((np.interp(frequencies, drawn.lines, along[entry]) - own) / 360.0)

    return unwrapped


def _parts(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    plots = []
    for name, part in (("real", np.real), ("imaginary", np.imag)):
        curves = drawn.curves(entries, lambda entry, _, H, part=part: entry.factor * part(H))
        if len(drawn.poles):
            most = ABOVE * max(float(np.abs(curve.values[drawn.is_far]).max()) for curve in curves) or 1.0
            curves = tuple(replace(curve, values=np.clip(curve.values, -most, most)) for curve in curves)
        plots.append(_plot(drawn, f"{name} part of the {title}", unit, curves, f"{name} part"))
    return plots


def _nyquist(drawn: _Drawn, entries: list[_Entry], title: str, quantity: str, unit: str) -> list[Plot]:
    plots = []
    for entry in entries:
        values = entry.factor * drawn.values[entry.i, entry.j]
        most = ABOVE * float(np.abs(values[drawn.is_far]).max()) or 1.0
        values = np.where(np.abs(values) > most, values * most / np.maximum(np.abs(values), most), values)
        curve, across = Curve(entry.name, values.imag), Curve(f"real part of the {quantity}", values.real)
        name = f"Nyquist plot of the {title}" if len(entries) == 1 else f"Nyquist plot of {entry.name}"
        lines = drawn.axis_factor * drawn.lines
        plots.append(Plot(name, unit, lines, (curve,), across, unit, "imaginary part", variable="frequency"))
    return plots


_KINDS = {"bode": _bode, "parts": _parts, "nyquist": _nyquist}


#: Outputs times inputs; more are indistinct in plots and take long.
MOST_RESPONSES = 100

#: Lines for each decade between the limits of a range, besides those that the poles place.
EACH_DECADE = 40

#: Numbers of all deflection shapes; of larger models or more inputs fewer lines have one.
MOST_NUMBERS = 150_000

#: Lines with a deflection shape: neighbours look the same; peaks are among them in any case.
MOST_SHAPES = 600

#: A damping ratio below this is a rounding error.
SMALLEST_RATIO = 1e-12

INVERSES = ("dynamic stiffness", "impedance", "apparent mass")
NOTHING = "–"
HALF_POWER = "bandwidth: between the frequencies of half the power; damping ratio: bandwidth / (2 frequency), negative where the motion grows"
NO_PEAKS = "There are none in this range."


class Frequency(Analysis):
    """Compute the frequency response: peaks, antiresonances, values, Bode plots.

    The steady-state response to loads Re(f e^(i w t)). Omitted options are those of the table [frequency] of the scene, or chosen:
    all prescribed motions or loaded coordinates, and frequencies placed by the poles, so that no peak is missed.
    Writes NAME.frequency.html, .csv and .npz.
    """

    name = "frequency"
    handles_delays = True
    settings = FrequencyTable
    options: ClassVar = {"inputs": "--input", "outputs": "--output"}
    replaced: ClassVar = {"from": ("frequencies",), "to": ("frequencies",)}

    def __init__(self, scene: SceneData, table: FrequencyTable | None = None):
        self.scene, self.table = scene, table or scene.table.frequency or FrequencyTable()
        self.axis_factor = AXIS_FACTORS[self.table.axis]  # the frequency of 1 Hz in the unit of the axis
        self.is_inverse = self.table.quantity in INVERSES  # forces by motions
        control = scene.equations.control
        self.system: MechanicalSystem | None = None if control else scene.equations.system

    @classmethod
    def solve(cls, scene: SceneData, settings: FrequencyTable | None) -> Answer:
        return cls(scene, settings).to_answer()

    @cached_property
    def response(self) -> FrequencyResponse:
        """H in SI at the frequencies."""
        with at(self.scene.file_name, "frequency"):
            return self.empty(self._lines())

    @cached_property
    def empty(self) -> FrequencyResponse:
        """H without frequencies yet, but with its poles and peaks."""
        table, equations = self.table, self.scene.equations
        if self.system is not None:
            inputs, outputs = self._inputs(), self._outputs()
            if len(inputs) * len(outputs or ()) > MOST_RESPONSES:
                raise InputError(
                    f"found {len(inputs)} inputs and {len(outputs)} outputs; expected at most {MOST_RESPONSES} pairs of them: "
                    "name those of interest in inputs and outputs"
                )
            return self._of_system(inputs, outputs, table.quantity, relative_to=table.relative_to)
        mechanical = [key for key in ("quantity", "modal_damping", "loss_factor", "relative_to") if key in table.model_fields_set]
        if mechanical:
            raise InputError(f"{mechanical[0]} belongs to models with mass, damping and stiffness; leave it out")
        if equations.control is None:
            return frequency_response(equations.polynomial_matrix, [], table.inputs, table.outputs)
        if equations.control.system is not None:
            return equations.control.system.frequency_response([], table.inputs, table.outputs, delays=equations.control.delays)
        control = equations.control
        if given := [key for key in ("inputs", "outputs") if key in table.model_fields_set]:
            raise InputError(f"{given[0]}: a transfer function has one input and one output; leave it out")
        fraction = transfer_function_response(control.transfer_function.numerator, control.transfer_function.denominator, 1)
        response = fraction.frequency_response([], delay=sum(control.delays.values()))
        of_input, of_output = control.inputs.names, control.outputs.names
        return replace(response, harmonic=replace(response.harmonic, input_names=of_input, output_names=of_output))

    @property
    def searched(self) -> tuple[tuple[float, float], Sequence[float]]:
        """Limits in Hz between which peaks are searched, and the ends of the range that are given."""
        table = self.table
        given = [table.lowest, table.highest] if table.is_auto else table.lines[[0, -1]].tolist()
        ends = [float(end) for end in given if end is not None]
        return (min(ends), max(ends)) if len(ends) == 2 else (table.lowest or 0.0, table.highest or np.inf), ends

    @cached_property
    def largest(self) -> tuple[np.ndarray, np.ndarray]:
        """The largest |H| of each entry in the range, at a peak or at an end, and its frequency in Hz, shape (outputs, inputs) each.

        Of a range that the poles place, and of an entry without peak, the values are NaN.
        """
        empty, (limits, ends) = self.empty, self.searched
        amplitudes, places = (np.full((len(empty.outputs), len(empty.inputs)), np.nan) for _ in range(2))
        maxima = [(peak.output, peak.input, peak.frequency_hz, peak.amplitude) for peak in empty.peaks]
        at_ends = empty(ends) if len(ends) else None
        if at_ends is not None:
            pairs = np.ndindex(at_ends.values.shape)
            maxima += [(empty.outputs[i], empty.inputs[j], ends[k], float(np.abs(at_ends.values[i, j, k]))) for i, j, k in pairs]
        for output, name, frequency, amplitude in maxima:
            place = empty.outputs.index(output), empty.inputs.index(name)
            if limits[0] <= frequency <= limits[1] and not amplitude <= amplitudes[place]:
                amplitudes[place], places[place] = amplitude, frequency
        return amplitudes, places

    def coordinate_response(self) -> FrequencyResponse:
        """The displacements of all coordinates of a mechanical system by the inputs, without frequencies yet."""
        quantity = self.table.quantity if self.table.quantity == "transmissibility" else "receptance"
        inputs = self.response.outputs if self.is_inverse else self.response.inputs
        return self._of_system(list(inputs), list(self.system.names), quantity)

    def _of_system(self, inputs: list[str], outputs: list[str] | None, quantity: str, **options) -> FrequencyResponse:
        damping = {"modal_damping": self.table.modal_damping, "loss_factor": self.table.loss_factor}
        return self.system.frequency_response([], inputs, outputs, quantity, **damping, **options)

    def _inputs(self) -> list[str]:
        """Inputs of the table, or the prescribed motions, or the loaded coordinates, or all."""
        table, scene = self.table, self.scene.table
        if table.inputs is not None:
            return table.inputs
        motions = [row.name for row in self.system.rows if row.name in scene.prescribed]
        if table.quantity == "transmissibility":
            if not (motions or self.system.rows):
                raise InputError(
                    "quantity: transmissibility is by a prescribed motion, and there is none: add a [[motion]] of the support"
                )
            return motions or [row.name for row in self.system.rows]
        if motions and not (self.is_inverse or table.quantity == FORCE_TRANSMISSIBILITY):
            return motions
        known = channels(self.system, "outputs" if self.is_inverse else "inputs")
        loaded = [load.title for load in scene.force if load.title in known]
        return list(dict.fromkeys(loaded)) or [name for name in self.system.names if name not in scene.prescribed.values()]

    def _outputs(self) -> list[str] | None:
        if self.table.outputs is not None:
            return self.table.outputs
        quantity, elements = self.table.quantity, self.system.elements
        if quantity == "reaction":
            if not self.system.rows:
                raise InputError("quantity: reaction is the force of a constraint row, and there are none")
            return [row.name for row in self.system.rows]
        if quantity == "force":
            return list(elements) or None
        if quantity == FORCE_TRANSMISSIBILITY:
            return None
        if self.is_inverse:
            return self._inputs()
        if self.system.named_directions("outputs"):  # of a robot
            return list(self.system.named_directions("outputs"))
        prescribed = self.scene.table.prescribed.values()
        moving = [name for name in self.system.names if name not in prescribed] or list(self.system.names)
        return [*moving, *(name for name in self.system.quantities if name not in self.system.names)]

    def _lines(self) -> np.ndarray:
        table = self.table
        if not table.is_auto:
            return table.lines
        lines = frequencies_by_poles(self.empty.harmonic)
        low = lines[0] if table.lowest is None else table.lowest
        high = lines[-1] if table.highest is None else table.highest
        if not low < high:
            raise InputError(f"the poles place the frequencies from {lines[0]:g} to {lines[-1]:g} Hz; give both from and to")
        start = low or min(lines[0], high / 1e3)
        further = np.geomspace(start, high, int(EACH_DECADE * np.log10(high / start)) + 2)[1:-1]
        further = further[(further < lines[0]) | (further > lines[-1])]
        return np.unique([low, high, *further, *lines[(lines > low) & (lines < high)]])

    @cached_property
    def shown(self) -> tuple[np.ndarray, np.ndarray]:
        """The units of the responses on the page, in tables and in CSV, and their factors, shape (outputs, inputs) each."""
        units, response = self.scene.equations.coordinates.shown, self.response
        pairs = [
            [units.of_ratio(unit, output, source) for unit, source in zip(row, response.inputs)]
            for row, output in zip(response.units, response.outputs)
        ]
        names, factors = (np.array([[pair[i] for pair in row] for row in pairs]) for i in (0, 1))
        return names, factors.astype(float)

    def _inside(self, features: Sequence[Any]) -> tuple[Any, ...]:
        low, high = self.response.frequencies_hz[[0, -1]]
        return tuple(one for one in features if low <= one.frequency_hz <= high)

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """The peaks within the range, in SI, entry by entry."""
        return self._inside(self.response.peaks)

    @cached_property
    def antiresonances(self) -> tuple[Antiresonance, ...]:
        """The antiresonances within the range."""
        return self._inside(_antiresonances(self.response))

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        own = self.system.damping_notices() if self.system is not None else ()
        loaded = {load.title for load in self.scene.table.force}
        if len(loaded) > 1 and self.table.inputs is None and self.system is not None:
            text = (
                f"{', '.join(self.response.inputs)} are inputs one by one; loads at once of one signal are one input as a [[force]] with "
                "factors, e.g. factors = { left = 1, right = -0.5 }"
            )
            own = (Notice(NoticeKind.OMITTED, text), *own)
        if self.response.harmonic.delayed:
            text = "poles, residues and antiresonances are not listed: delays make infinitely many"
            own = (*own, Notice(NoticeKind.OMITTED, text))
        return distinct(self.scene.notices, self.scene.equations.form_notices, own, self.response.notices)

    def to_answer(self) -> Answer:
        """The response in words, tables, plots and data."""
        scene, response = self.scene, self.response
        others = (*self._static_table(), *self._antiresonance_table())
        return Frequency.of(
            scene,
            facts=tuple(self._facts()),
            tables=(self.peak_table(wide=False), *others),
            notices=self.notices,
            data=self._data(),
            plots=self._plots,
            columns=lambda: {"": dict(self._columns())},
            arrays=lambda: arrays_of(response),
            heading=scene.heading,
            on_page=lambda: {"tables": (self.peak_table(), *others), "animation": self.deflections()},
        )

    def _facts(self) -> Iterator[tuple[str, str]]:
        """Quantity, inputs and outputs, and frequencies."""
        response, table = self.response, self.table
        low, high = (f"{self.axis_factor * f:.4g}" for f in response.frequencies_hz[[0, -1]])
        how = "placed by the poles" if table.is_auto else f"{table.spacing} steps" if table.frequencies is None else "as given"
        count = counted(len(response.frequencies_hz), "frequency", "frequencies")
        yield "quantity", response.harmonic.quantity_of()
        yield "inputs", ", ".join(response.inputs)
        yield "outputs", ", ".join(response.outputs)
        yield "frequencies", f"{low} to {high} {table.axis}, {count}, {how}"
        late = [f"{delay:g} s of {name}" for name, delay in zip(response.inputs, response.harmonic.input_delays) if delay]
        late += [f"{term.delay:g} s of the feedback" for term in response.harmonic.delayed]
        if late:
            yield "dead time", ", ".join(late)
        yield "error estimate", f"{self._error:.2g} of each value"
        if not response.harmonic.delayed and response.rigid_body.any():
            yield "rigid body", "the responses contain 1/s², motion that nothing restores"

    @property
    def _error(self) -> float:
        errors = self.response.error_estimate
        return float(errors[np.isfinite(errors)].max(initial=0.0))

    def _entry(self, output: str, input: str) -> tuple[str, ...]:
        return (output, input) if len(self.response.inputs) > 1 else (output,)

    def peak_table(self, wide: bool = True) -> TextTable:
        """Frequency, amplitude, bandwidth, damping ratio and phase of the peaks, entry by entry; narrow for a terminal."""
        unit, rows = self.table.axis, tuple(map(self._peak_row, self.peaks))
        columns = (f"frequency ({unit})", "amplitude", f"bandwidth ({unit})", "damping ratio", "phase (°)")
        columns = columns if wide else (unit, "amplitude", "bandwidth", "damping", "phase (°)")
        title = f"Peaks of the {self.response.harmonic.quantity_of()}"
        table = TextTable(title, (*self._entry("output", "input"), *columns), rows, HALF_POWER if rows else NO_PEAKS)
        return limited(table, MOST_ROWS_OF_PAGE)

    def _peak_row(self, peak: Peak) -> tuple[str, ...]:
        units, factors = self.shown
        place = self.response.outputs.index(peak.output), self.response.inputs.index(peak.input)
        amplitude, unit = float(factors[place]) * peak.amplitude, str(units[place])
        size = f"{amplitude:.4g}" if np.isfinite(amplitude) else "infinite"
        width, ratio = peak.bandwidth_hz, peak.damping_ratio
        return (
            *self._entry(peak.output, peak.input),
            f"{self.axis_factor * peak.frequency_hz:.5g}",
            size if unit == "1" or size == "infinite" else f"{size} {unit}",
            NOTHING if width is None else f"{self.axis_factor * width:.4g}",
            NOTHING if ratio is None else f"{ratio:.4g}",
            f"{float(np.degrees(peak.phase)) + 0.0:.1f}",
        )

    @cached_property
    def static(self) -> np.ndarray:
        """H at 0 Hz in SI, such as static compliances, infinite where nothing restores, shape (outputs, inputs)."""
        at_rest = self.response([0.0])
        values = np.where(at_rest.error_estimate < 1, at_rest.values.real, 0.0)[..., 0]
        for one in at_rest.poles_on_lines:
            values[np.any(one.pole.residues, axis=0)] = np.inf
        return values

    def _static_table(self) -> tuple[TextTable, ...]:
        """The values at 0 Hz; no table where all are zero, as of velocities."""
        units, factors = self.shown
        rows = []
        for (i, j), value in np.ndenumerate(self.static):
            size = f"{factors[i, j] * value:.5g}" if np.isfinite(value) else "infinite"
            text = size if units[i, j] == "1" or size == "infinite" else f"{size} {units[i, j]}"
            rows.append((*self._entry(self.response.outputs[i], self.response.inputs[j]), text))
        table = TextTable("Static response (0 Hz)", (*self._entry("output", "input"), "value"), tuple(rows))
        return (limited(table, MOST_ROWS_OF_PAGE),) if self.static.any() else ()

    def _antiresonance_table(self) -> tuple[TextTable, ...]:
        """Frequency and damping ratio of the antiresonances; no table where there are none."""
        rows = []
        for zero in self.antiresonances:
            ratio = zero.damping_ratio if abs(zero.damping_ratio) > SMALLEST_RATIO else 0.0
            rows.append((*self._entry(zero.output, zero.input), f"{self.axis_factor * zero.frequency_hz:.5g}", f"{ratio:.4g}"))
        columns = (*self._entry("output", "input"), f"frequency ({self.table.axis})", "damping ratio")
        return (TextTable("Antiresonances", columns, tuple(rows)),) if rows else ()

    def _data(self) -> dict:
        response, f = self.response, self.response.frequencies_hz
        return {
            "source": self.scene.table.source,
            "quantity": response.quantity,
            "inputs": response.inputs,
            "outputs": response.outputs,
            "output_quantities": response.harmonic.output_quantities,
            "units": response.units,
            "static": self.static,
            "frequencies": {"from": f[0], "to": f[-1], "count": len(f)},
            "peaks": [_entries(peak, "amplitude", "bandwidth_hz", "phase", "damping_ratio") for peak in self.peaks],
            "antiresonances": [_entries(zero, "damping_ratio") for zero in self.antiresonances],
            "poles": [{"real": s.real, "imaginary": s.imag} for s in (() if response.harmonic.delayed else response.poles)],
            "poles_on_lines": [{"frequency_hz": one.frequency_hz, "order": one.pole.order} for one in response.poles_on_lines],
            "error_estimate": self._error,
        }

    def _columns(self) -> Iterator[tuple[str, np.ndarray]]:
        """The values in the units shown."""
        response, (units, factors) = self.response, self.shown
        yield "frequency (Hz)", response.frequencies_hz
        values = response.values * factors[:, :, None]
        for i, j in np.ndindex(values.shape[:2]):
            name = f"{response.outputs[i]}/{response.inputs[j]} ({units[i, j]})"
            yield f"real {name}", values[i, j].real
            yield f"imag {name}", values[i, j].imag

    def _plots(self) -> Iterator[Plot]:
        """The plots that the table selects, amplitude and phase of one unit side by side, with a colour for each output."""
        response, (units, factors), names = self.response, self.shown, self.scene.equations.coordinates.names
        if (response.frequencies_hz > 0).sum() < 2:
            return
        colors = [names.index(name) if name in names else i for i, name in enumerate(response.outputs)]
        drawn = _Drawn(response, self.table, colors)
        groups: dict[str, list[_Entry]] = {}
        for i, j in np.ndindex(units.shape):
            name = f"{response.outputs[i]} by {response.inputs[j]}" if len(response.inputs) > 1 else response.outputs[i]
            groups.setdefault(str(units[i, j]), []).append(_Entry(i, j, name, float(factors[i, j])))
        by = f' by "{response.inputs[0]}"' if len(response.inputs) == 1 else ""
        quantities = [response.harmonic.quantity_of([entry.i for entry in entries]) for entries in groups.values()]
        for (unit, entries), quantity in zip(groups.items(), quantities):
            own = f" ({unit})" if quantities.count(quantity) > 1 else ""
            for kind in self.table.plots:
                yield from _KINDS[kind](drawn, entries, f"{quantity}{own}{by}", quantity, unit)

    def deflections(self) -> Deflections | None:
        """Shapes of all coordinates at each frequency under a unit of an input; None where the model has no places, or nothing to draw."""
        system, scene = self.system, self.scene
        if system is None or not scene.table.output.animation:
            return None
        response = self.coordinate_response()
        lines = self._lines_with_shapes(response)
        if len(lines) < 2:
            return None
        H = np.moveaxis(response(lines).values, 0, 2)  # inputs, lines, coordinates
        if not H.any():
            return None
        if scene.equations.robot_scene:
            robot = LinearRobot(scene.equations.robot_scene, scene.table.drawing)
            drawing, factors = robot.drawing, robot.factors(H)
        else:
            sizes = np.abs(H).max(axis=2)
            normed = H / np.where(sizes > 0, sizes, 1.0)[:, :, None]  # as of a mode, whose largest entry is 1
            swinging = ShapeDrawing(scene, list(normed.reshape(-1, H.shape[2])))
            drawing, rows = swinging.drawing, zip(normed, sizes)
            factors = np.array([[swinging.amplitude(shape) / size if size else 1.0 for shape, size in zip(*row)] for row in rows])
        sources = [0 if self.is_inverse else self.response.inputs.index(peak.input) for peak in self.peaks]
        return Deflections(
            drawing,
            scene.equations.coordinates.names,
            tuple(_unit_text(system, name, self.table.quantity) for name in response.inputs),
            self.table.axis,
            self.axis_factor * lines,
            1 / lines,
            H * factors[:, :, None],
            factors,
            tuple((self.axis_factor * peak.frequency_hz, source) for peak, source in zip(self.peaks, sources)),
        )

    def _lines_with_shapes(self, response: FrequencyResponse) -> np.ndarray:
        """Frequencies in Hz, those of the response and all peaks, no more than can be stored, none at a pole."""
        given = self.response.frequencies_hz
        given = given[given > 0]
        low, high = given[[0, -1]] if len(given) else (1.0, 1.0)
        placed = frequencies_by_poles(response.harmonic, with_peaks=False)
        lines = np.union1d(given, placed[(placed > low) & (placed < high)])
        most = max(2, min(MOST_SHAPES, MOST_NUMBERS // (len(response.inputs) * len(response.outputs))))
        lines = lines[np.unique(np.linspace(0, len(lines) - 1, min(most, len(lines))).astype(int))] if len(lines) else lines
        peaks = [peak.frequency_hz for peak in self.peaks if np.isfinite(peak.amplitude) and peak.frequency_hz > 0]
        lines = np.union1d(lines, peaks)
        return np.setdiff1d(lines, [one.frequency_hz for one in response(lines).poles_on_lines])


def _entries(feature: Peak | Antiresonance, *keys: str) -> dict[str, Any]:
    return {key: getattr(feature, key) for key in ("output", "input", "frequency_hz", *keys)}


def _unit_text(system: MechanicalSystem, name: str, quantity: str) -> str:
    """Text of a unit input, such as "1 N on cart" or "1 m of motion of road"."""
    channel = channels(system, "inputs")[name]
    if channel is None or channel.row is None:
        return f"1 {force_unit(channel.unit) if channel else ''} on {name}"
    order = 0 if quantity == "transmissibility" else system.rows[channel.row].order
    return f"1 {rate_unit(channel.unit, order)} of {name}"
