"""The frequency response of a scene, with its peaks and antiresonances, in the units of [output]; and its files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....control.transfer_function import transfer_function_response
from ....frequency.features import Antiresonance, Peak, frequencies_by_poles
from ....frequency.frequency_response import FrequencyResponse, arrays_of, csv_text, frequency_response
from ....frequency.plots import AXIS_FACTORS
from ....ground.errors import InputError
from ....ground.notices import Notice, NoticeKind, distinct
from ....mechanics.channels import channels
from ...file.messages import at
from ...schema.analyses.frequency_table import FrequencyTable
from ..scene_data import SceneData
from .scene_response import SceneResponse

if TYPE_CHECKING:
    from ....mechanics.system import MechanicalSystem

#: Outputs times inputs; more are indistinct in plots and take long.
MOST_RESPONSES = 100

#: Lines for each decade between the limits of a range, besides those that the poles place.
EACH_DECADE = 40

INVERSES = ("dynamic stiffness", "impedance", "apparent mass")


@dataclass(frozen=True, eq=False)
class Shown:
    """Names and factors of the units in which responses are shown, shape (outputs, inputs) each."""

    units: np.ndarray
    factors: np.ndarray


class FrequencyData(SceneResponse):
    """The frequency response of a scene, without its page.

    Attributes:
        scene: the scene.
        table: [frequency], or the one that the command line gives.
    """

    kind = "frequency"

    def __init__(self, scene: SceneData, table: FrequencyTable | None = None):
        super().__init__(scene.name, scene.table.output)
        self.scene = scene
        self.table = table or scene.table.frequency or FrequencyTable()

    @property
    def axis_factor(self) -> float:
        """The frequency of 1 Hz in the unit of the axis."""
        return AXIS_FACTORS[self.table.axis]

    @property
    def is_inverse(self) -> bool:
        """Whether forces by motions are given, such as dynamic stiffness."""
        return self.table.quantity in INVERSES

    @property
    def system(self) -> MechanicalSystem | None:
        """The mechanical system; None where the scene has coefficients, states or a transfer function."""
        control = self.scene.equations.control
        return None if control else self.scene.equations.system

    @cached_property
    def response(self) -> FrequencyResponse:
        """H in SI at the frequencies.

        Raises:
            SceneError: unknown names, a quantity that does not fit, too many responses.
        """
        with at(self.scene.file_name, "frequency"):
            return self.empty(self._lines(self.empty))

    @cached_property
    def empty(self) -> FrequencyResponse:
        """H without frequencies yet, but with its poles and peaks."""
        table, equations = self.table, self.scene.equations
        if self.system is not None:
            inputs, outputs = self._inputs(), self._outputs()
            if len(inputs) * len(outputs) > MOST_RESPONSES:
                raise InputError(
                    f"found {len(inputs)} inputs and {len(outputs)} outputs; expected at most {MOST_RESPONSES} pairs of them: "
                    "name those of interest in inputs and outputs"
                )
            damping = {"modal_damping": table.modal_damping, "loss_factor": table.loss_factor}
            return self.system.frequency_response([], inputs, outputs, table.quantity, **damping, relative_to=table.relative_to)
        mechanical = [key for key in ("quantity", "modal_damping", "loss_factor", "relative_to") if key in table.model_fields_set]
        if mechanical:
            raise InputError(f"{mechanical[0]} belongs to models with mass, damping and stiffness; leave it out")
        if equations.control is None:
            return frequency_response(equations.polynomial_matrix, [], table.inputs, table.outputs)
        if equations.control.system is not None:
            return equations.control.system.frequency_response([], table.inputs, table.outputs)
        control = equations.control
        if given := [key for key in ("inputs", "outputs") if key in table.model_fields_set]:
            raise InputError(f"{given[0]}: a transfer function has one input and one output; leave it out")
        fraction = transfer_function_response(control.transfer_function.numerator, control.transfer_function.denominator, 1)
        response = fraction.frequency_response([])
        of_input, of_output = control.inputs.names, control.outputs.names
        return replace(response, harmonic=replace(response.harmonic, input_names=of_input, output_names=of_output))

    @cached_property
    def largest(self) -> tuple[np.ndarray, np.ndarray]:
        """The largest |H| of each entry in the range, at a peak or at an end, and its frequency in Hz, shape (outputs, inputs) each.

        Of a range that the poles place, and of an entry without peak, the values are NaN.
        """
        empty, table = self.empty, self.table
        ends = table.lines[[0, -1]] if not table.is_auto else [end for end in (table.lowest, table.highest) if end is not None]
        limits = (min(ends), max(ends)) if len(ends) == 2 else (table.lowest or 0.0, table.highest or np.inf)
        amplitudes, places = (np.full((len(empty.outputs), len(empty.inputs)), np.nan) for _ in range(2))
        maxima = [(peak.output, peak.input, peak.frequency_hz, peak.amplitude) for peak in empty.peaks]
        at_ends = empty(ends) if len(ends) else None
        if at_ends is not None:
            pairs = np.ndindex(at_ends.values.shape)
            maxima += [(empty.outputs[i], empty.inputs[j], ends[k], float(np.abs(at_ends.values[i, j, k]))) for i, j, k in pairs]
        for output, name, frequency, amplitude in maxima:
            at = empty.outputs.index(output), empty.inputs.index(name)
            if limits[0] <= frequency <= limits[1] and not amplitude <= amplitudes[at]:
                amplitudes[at], places[at] = amplitude, frequency
        return amplitudes, places

    def coordinate_response(self) -> FrequencyResponse:
        """The displacements of all coordinates of a mechanical system by the inputs, without frequencies yet."""
        table, own = self.table, self.response
        quantity = table.quantity if table.quantity == "transmissibility" else "receptance"
        damping = {"modal_damping": table.modal_damping, "loss_factor": table.loss_factor}
        inputs = own.outputs if self.is_inverse else own.inputs
        return self.system.frequency_response([], list(inputs), list(self.system.names), quantity, **damping)

    def _inputs(self) -> list[str]:
        """Inputs of the table, or the prescribed motions, or the loaded coordinates, or all."""
        table, scene = self.table, self.scene.table
        if table.inputs is not None:
            return table.inputs
        motions = self._motions
        if table.quantity == "transmissibility":
            if not (motions or self.system.rows):
                raise InputError(
                    "quantity: transmissibility is by a prescribed motion, and there is none: add a [[motion]] of the support"
                )
            return motions or [row.name for row in self.system.rows]
        if motions and not self.is_inverse:
            return motions
        known = channels(self.system, "outputs" if self.is_inverse else "inputs")
        loaded = [load.title for load in scene.force if load.title in known]
        return list(dict.fromkeys(loaded)) or [name for name in self.system.names if name not in self._prescribed]

    @property
    def _motions(self) -> list[str]:
        names = [name for motion in self.scene.table.motion for name in motion.rows]
        return [row.name for row in self.system.rows if row.name in names]

    @property
    def _prescribed(self) -> set[str]:
        return {coordinate for motion in self.scene.table.motion for coordinate, _ in motion.rows.values()}

    def _outputs(self) -> list[str]:
        if self.table.outputs is not None:
            return self.table.outputs
        if self.table.quantity == "reaction":
            if not self.system.rows:
                raise InputError("quantity: reaction is the force of a constraint row, and there are none")
            return [row.name for row in self.system.rows]
        elements = self.system.elements
        if self.table.quantity == "force":
            return list(elements)
        if self.is_inverse:
            return self._inputs()
        if self.system.named_directions("outputs"):  # of a robot
            return list(self.system.named_directions("outputs"))
        moving = [name for name in self.system.names if name not in self._prescribed] or list(self.system.names)
        if self.table.quantity not in ("receptance", "transmissibility"):
            return moving
        shown = [one.of for one in self.scene.table.output.quantity if one.of in elements and one.quantity in (None, "force")]
        return [*moving, *(name for name in dict.fromkeys(shown) if name not in self.system.names)]

    def _lines(self, empty: FrequencyResponse) -> np.ndarray:
        table = self.table
        if not table.is_auto:
            return table.lines
        lines = frequencies_by_poles(empty.harmonic)
        low = lines[0] if table.lowest is None else table.lowest
        high = lines[-1] if table.highest is None else table.highest
        if not low < high:
            raise InputError(f"the poles place the frequencies from {lines[0]:g} to {lines[-1]:g} Hz; give both from and to")
        start = low or min(lines[0], high / 1e3)
        further = np.geomspace(start, high, int(EACH_DECADE * np.log10(high / start)) + 2)[1:-1]
        further = further[(further < lines[0]) | (further > lines[-1])]
        return np.unique([low, high, *further, *lines[(lines > low) & (lines < high)]])

    @cached_property
    def shown(self) -> Shown:
        """The units of the responses on the page, in tables and in CSV."""
        units, response = self.scene.equations.coordinates.shown, self.response
        pairs = [[units.of_ratio(unit) for unit in row] for row in response.units]
        names, factors = (np.array([[pair[i] for pair in row] for row in pairs]) for i in (0, 1))
        return Shown(names, factors.astype(float))

    @cached_property
    def in_shown_units(self) -> FrequencyResponse:
        """The values in these units; peaks, poles and residues stay those of ``response``."""
        own = self.response
        harmonic = replace(own.harmonic, units=self.shown.units)
        return replace(own, harmonic=harmonic, values=own.values * self.shown.factors[:, :, None])

    def _is_inside(self, frequency_hz: float) -> bool:
        lines = self.response.frequencies_hz
        return bool(lines[0] <= frequency_hz <= lines[-1])

    @cached_property
    def peaks(self) -> tuple[Peak, ...]:
        """The peaks within the range, in SI, entry by entry."""
        return tuple(peak for peak in self.response.peaks if self._is_inside(peak.frequency_hz))

    @cached_property
    def antiresonances(self) -> tuple[Antiresonance, ...]:
        """The antiresonances within the range."""
        return tuple(zero for zero in self.response.antiresonances if self._is_inside(zero.frequency_hz))

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on the response, and doubts about it."""
        own = self.system.damping_notices() if self.system is not None else ()
        loaded = {load.title for load in self.scene.table.force}
        if len(loaded) > 1 and self.table.inputs is None and self.system is not None:
            text = (
                f"{', '.join(self.response.inputs)} are inputs one by one; loads at once of one signal are one input as a [[force]] with "
                "factors, e.g. factors = { left = 1, right = -0.5 }"
            )
            own = (Notice(NoticeKind.OMITTED, text), *own)
        return distinct(self.scene.notices, self.scene.equations.form_notices, own, self.response.notices)

    @property
    def csv(self) -> dict[str, str]:
        """The values in the units shown."""
        return {"": csv_text(self.in_shown_units)}

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """Frequencies, values, error estimates, names and units."""
        return arrays_of(self.response)
