"""Transfer functions and state spaces: the model with its input and outputs, its zeros, gains and mechanical normal form in reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import add
from typing import TYPE_CHECKING, Any

import numpy as np

from ...control.rational import RationalFunction, rational_function, scalar_force, scalar_matrix
from ...control.state_equations import Transfer, delays_of_inputs, rational_transfer, roots_of
from ...control.state_space import StateSpace
from ...control.transfer_function import transfer_function_response
from ...ground.checks import counted, nearest
from ...ground.display import TextTable, number_text, with_unit
from ...ground.errors import IllConditioned, InputError, NoNormalForm, SceneError, shown
from ...ground.notices import Notice
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...polynomial.structure import polynomial_text
from ...response.choose import unproved
from ...response.response import Response
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import power, zero
from ..coordinates import Coordinates, initial_values, state_values
from ..file import SceneFolder, at
from .data_files import entries_of
from .ends import shaped_inputs
from .forces import input_of
from .model import Decision, Equations, ModelTables

if TYPE_CHECKING:
    from ...control.state_space import StateSpaceResponse
    from ...mechanics.normal_form import NormalForm

#: Zeros are looked for in systems of so many states, and so many pairs of inputs and outputs, at most.
MOST_STATES, MOST_PAIRS = 40, 16


@dataclass(frozen=True, eq=False)
class TransferFunction:
    """A transfer function with its input."""

    # b and a as given, the highest power first
    numerator: list[float]
    denominator: list[float]
    input: int | ImpulsiveSmooth  # gamma of I_gamma, or u with one row
    start: np.ndarray | None = None  # y^(i)(0-) as row i, shape (n, 1); None from rest
    delay: float = 0.0  # dead time of the input in s

    @cached_property
    def fraction(self) -> RationalFunction:
        """b(s)/a(s), exactly."""
        return rational_function(self.numerator, self.denominator)

    @property
    def late_input(self) -> int | ImpulsiveSmooth:
        """The input after its dead time."""
        if not self.delay:
            return self.input
        return (power([1.0], self.input) if isinstance(self.input, int) else self.input).delayed(self.delay)

    @property
    def acting(self) -> RationalFunction:
        """The fraction that acts: from rest without the common factor."""
        return self.fraction.reduced if self.start is None else self.fraction

    @property
    def polynomial_matrix(self) -> PolynomialMatrix:
        """a(s), size one."""
        return scalar_matrix(self.acting.denominator)

    @property
    def force(self) -> ImpulsiveSmooth:
        """b(d/dt) u."""
        return scalar_force(self.acting.numerator, self.late_input)

    def response(self) -> Response | None:
        """y from rest; None where it starts from other values and is solved as other equations are."""
        if self.start is not None:
            return None
        return transfer_function_response(self.numerator, self.denominator, self.late_input)


@dataclass(frozen=True, eq=False)
class ControlScene:
    """The model of a scene of control engineering, with its input."""

    # names and units
    inputs: Coordinates
    outputs: Coordinates
    transfer_function: TransferFunction | None = None  # b(s)/a(s) with its input, or else None
    system: StateSpace | None = None  # the state space, or else None
    input: ImpulsiveSmooth | None = None  # u, p rows, where it is a state space, before its dead times
    start: np.ndarray | None = None  # x(0-), shape (n,), where it is a state space
    form: NormalForm | None = None  # its mechanical normal form, where requested
    delays: Mapping[str, float] = field(default_factory=dict)  # dead times of inputs in s by name, those that are not 0

    @cached_property
    def late_input(self) -> ImpulsiveSmooth:
        """u after its dead times."""
        if not self.delays:
            return self.input
        rows = np.eye(len(self.inputs.names))
        columns = zip(self.inputs.names, rows)
        return reduce(add, (self.input.mapped(np.diag(row)).delayed(self.delays.get(name, 0.0)) for name, row in columns))

    @cached_property
    def response(self) -> StateSpaceResponse:
        """x and y of the state space, with the outputs also where the normal form is solved."""
        return self.system.solve(self.start, self.late_input)

    @cached_property
    def transfers(self) -> tuple[tuple[str, str, Transfer | None], ...]:
        """(input, output, G) of every pair; None where rounding errors hide the zeros of G, or they are not computed."""
        if self.transfer_function is not None:
            return ((self.inputs.names[0], self.outputs.names[0], rational_transfer(self.transfer_function.fraction)),)
        return tuple((u, y, self._transfer(y, u)) for y in self.outputs.names for u in self.inputs.names)

    @property
    def looks_for_zeros(self) -> bool:
        """Whether the zeros of G are computed, which takes long for many states or pairs."""
        pairs = len(self.inputs.names) * len(self.outputs.names)
        return self.system is None or (len(self.system.states) <= MOST_STATES and pairs <= MOST_PAIRS)

    @cached_property
    def dc_gains(self) -> np.ndarray | None:
        """G(0) of a state space, shape (q, p); None where it has a pole at 0."""
        return self.system.dc_gains()

    def _transfer(self, output: str, input: str) -> Transfer | None:
        if not self.looks_for_zeros:
            return None
        try:
            return self.system.transfer(output, input)
        except IllConditioned:
            return None


@dataclass(frozen=True, eq=False)
class ControlEquations(Equations):
    """The equations of a transfer function or state space, or of its mechanical normal form."""

    control: ControlScene = None

    @property
    def has_forces(self) -> bool:
        return self.control.system is not None and bool(self.control.inputs.names)

    def solve(self) -> Response:
        function = self.control.transfer_function
        from_rest = function.response() if function else None
        return from_rest or super().solve()

    @property
    def has_outputs_among_coordinates(self) -> bool:  # type: ignore[override]
        return self.control.form is None

    @property
    def original(self) -> ControlScene | None:
        return self.control if self.control.form is not None else None

    @property
    def coordinates_called(self) -> str:  # type: ignore[override]
        if self.control.form is not None:
            return "coordinates"
        return "output" if self.control.transfer_function else "states and outputs"

    @property
    def root_name(self) -> str:
        return "eigenvalue" if self.system else "pole"

    @property
    def outputs(self) -> Coordinates | None:
        return self.control.outputs if self.control.outputs.names else None

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        if self.control.form is not None:
            return self.control.response.output(times)
        return coordinates[len(coordinates) - len(self.control.outputs.names) :]

    def output_closed_form(self, motion: Any) -> BohlFunction:
        control = self.control
        function = control.response.output_function if control.form is not None else motion.function
        return function.rows(range(function.size - len(control.outputs.names), function.size))

    def output_error_estimate(self, times: np.ndarray) -> float | None:
        return self.control.response.output_error_estimate(times)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:  # type: ignore[override]
        late = tuple((f"dead time of {name}", f"{number_text(delay)} s") for name, delay in self.control.delays.items())
        if self.control.transfer_function is None:
            return late
        fraction = self.control.transfer_function.fraction
        return (
            ("transfer function", f"({polynomial_text(fraction.numerator)}) / ({polynomial_text(fraction.denominator)})"),
            *late,
        )

    @property
    def form_notices(self) -> tuple[Notice, ...]:  # type: ignore[override]
        return self.control.form.notices if self.control.form else ()

    def tables(self, result: Any) -> ModelTables:
        form = [_form_table(self.control.form)] if self.control.form is not None else []
        return ModelTables(first=[_transfer_table(self.control), *form])

    def to_dict(self, result: Any) -> dict:
        control = self.control
        data: dict[str, Any] = {key: getattr(control, key).to_list() for key in ("inputs", "outputs")}
        data["transfer_functions"] = [
            {"input": u, "output": y, "dc_gain": _dc_gain(control, u, y, G), **_transfer_json(G)} for u, y, G in control.transfers
        ]
        data |= {"delays": dict(control.delays)} if control.delays else {}
        return data | ({"normal_form": _form_json(control.form)} if control.form is not None else {})

    def size_decision(self) -> Decision:
        control = self.control
        if control.transfer_function is not None:
            b, a = control.transfer_function.fraction.numerator, control.transfer_function.fraction.denominator
            return True, f"numerator of degree {max(len(b) - 1, 0)}, denominator of degree {len(a) - 1}"
        counts = ((control.system.states, "state"), (control.inputs.names, "input"), (control.outputs.names, "output"))
        return True, ", ".join(counted(len(names), what) for names, what in counts)

    def rows_decision(self, removed: int | None = None, none: str = "") -> Decision:
        return False, f"a {'transfer function' if self.control.transfer_function else 'state space'} has no constraint rows"

    def outputs_decision(self, plots: Sequence[str]) -> Decision:
        if self.outputs is None:
            return False, "there is no C"
        if self.control.form is None:
            return True, "C x + D u, solved for together with the states"
        requested = "output" in plots
        return requested, "C x + D u, of the states that were given" if requested else "output is not among the plots"

    def unproved(self, reason: str, plots: Sequence[str]) -> str:
        return (
            unproved(self.control.response.together.problem)
            if reason and self.control.form and "output" in plots
            else super().unproved(reason, plots)
        )

    @property
    def without_energy(self) -> str:
        if self.control.form:
            return "found energy: the unit masses of a normal form are not those of the machine, whose energy is not known"
        return super().without_energy


MATRICES = ("A", "B", "C", "D", "descriptor")


def transfer_function(table, folder: SceneFolder, file_name: str) -> ControlEquations:
    model = table.model
    with at(file_name, "model"):
        fraction = rational_function(model.numerator, model.denominator)
        ends = (model.input, model.output)
        if wrong := next((name for name in model.units if name not in ends), None):
            known = ", ".join(ends)
            raise InputError(f"units: there is no input or output {shown(wrong)}{nearest(wrong, ends)}; there are {known}")
    inputs, outputs = (_named([name], model.units) for name in (model.input, model.output))
    u = input_of(table.force, inputs, folder, file_name)
    if model.gamma is not None:
        u = model.gamma if u is None else u + power([1.0], model.gamma)
    _check_start(table.initial, file_name)
    if table.initial.state:
        with at(file_name, "initial.state"):
            raise InputError("a transfer function has no states; give displacement, velocity, … or derivatives of its output")
    start = initial_values(table.initial, outputs, len(fraction.denominator) - 1, file_name).astype(float)
    if u is None and not start.any():
        with at(file_name, "model"):
            raise InputError("nothing acts: give gamma = 1 (a step), a [[force]] on the input, or a start of the output")
    own = zero(1) if u is None else u, start if start.any() else None
    G = TransferFunction(model.numerator, model.denominator, *own, float(model.delay))
    delays = {model.input: G.delay} if G.delay else {}
    control, A = ControlScene(inputs, outputs, G, delays=delays), G.polynomial_matrix
    shaped = shaped_inputs(table.force, file_name)
    return ControlEquations(
        outputs, A, np.zeros((A.degree, 1)) if G.start is None else start, G.force, control=control, ends=shaped
    )


def _state_space_scene(table, folder: SceneFolder, file_name: str) -> ControlScene:
    """Read a scene of kind "state-space", without transformation."""
    model, matrices = table.model, {}
    for key in MATRICES:
        source = getattr(model, key)
        with at(file_name, f"model.{key}"):
            matrices[key] = None if source is None else entries_of(source, folder).astype(float)
    displacements = _displacement_names(model, len(matrices["A"])) if model.normal_form else ()
    with at(file_name, "model"):
        units = {name: unit for name, unit in model.units.items() if name not in displacements}
        system = StateSpace(**matrices, states=model.states, inputs=model.inputs, outputs=model.outputs, units=units)
        names = (*system.states, *system.inputs, *system.outputs, *displacements)
        delays = zip(system.inputs, delays_of_inputs(system, {name: float(one) for name, one in model.delays.items()}))
        if repeated := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f'the name "{repeated}" is used twice; states, inputs, outputs and coordinates must differ in name')
    inputs, outputs = (_named(names, system.units) for names in (system.inputs, system.outputs))
    u = input_of(table.force, inputs, folder, file_name)
    _check_start(table.initial, file_name)
    start = state_values(table.initial.state, _named(system.states, system.units), file_name).astype(float)
    if table.initial.rows and not model.normal_form:
        with at(file_name, "initial"):
            raise InputError("a state space starts from its states; write state = { x1 = 0.1 } or state = [0.1, 0]")
    late = {name: delay for name, delay in delays if delay}
    return ControlScene(inputs, outputs, None, system, zero(len(inputs.names)) if u is None else u, start, delays=late)


def _of_normal_form(control: ControlScene, table, file_name: str, lap: Callable[[str], object]) -> ControlEquations:
    """The equations of the mechanical normal form of a state space."""
    from ...mechanics.normal_form import mechanical_normal_form

    space, model, initial = control.system, table.model, table.initial
    lap("assemble the model")
    with at(file_name, "model.normal_form"):
        if space.is_descriptor:
            space.polynomial_matrix().jordan_pairs()  # where det(s E - A) is zero for every s they name the states of the scene
        try:
            form = mechanical_normal_form(space.A, space.B, space.C, space.D, descriptor=space.E if space.is_descriptor else None)
        except NoNormalForm as problem:
            raise SceneError(f"{file_name}: model.normal_form: {problem}") from problem
    lap("mechanical normal form")
    names = _displacement_names(model, 2 * form.size)
    with at(file_name, "model.coordinates"):
        if len(names) != form.size:
            which = "states" if form.infinite is None else "states of the finite part"
            raise InputError(f"found {counted(len(names), 'name')}; expected {form.size}, half as many as {which}")
    massless = _massless_names(form, {*space.states, *space.inputs, *space.outputs, *names})
    units = {name: model.units.get(name, "m") for name in names} | dict.fromkeys(massless, "1")
    with at(file_name, "model.units"):
        system = form.system([*names, *massless], units)
    coordinates, start = Coordinates((*names, *massless), tuple(units.values())), control.start
    if initial.rows and initial.state:
        with at(file_name, "initial"):
            raise InputError("found state and values of the displacements; give one of them")
    if initial.rows:
        values = initial_values(initial, coordinates, 2, file_name).astype(float)
        start = form.state(*values)
    else:
        values = np.array(form.displacement_velocity(start))
    own, force = replace(control, form=form, start=start), form.force(control.late_input)
    return ControlEquations(coordinates, system.polynomial_matrix(), values, force, system, control=own)


def _displacement_names(model, states: int) -> tuple[str, ...]:
    return tuple(model.coordinates or (f"q{i + 1}" for i in range(states // 2)))


def _massless_names(form: NormalForm, others: set[str]) -> tuple[str, ...]:
    """z1, z2, ... for the infinite part, with more letters z where other names are the same."""
    count, letters = form.infinite.size if form.infinite else 0, "z"
    while others & {f"{letters}{place + 1}" for place in range(count)}:
        letters += "z"
    return tuple(f"{letters}{place + 1}" for place in range(count))


def _check_start(initial, file_name: str) -> None:
    if initial.follow:
        with at(file_name, "initial.follow"):
            raise InputError("there are no constraint rows that anything could follow; leave it out")


def _named(names, units) -> Coordinates:
    return Coordinates(tuple(names), tuple(units.get(name, "1") for name in names))


def state_space(table, folder: SceneFolder, file_name: str, lap: Callable[[str], object]) -> ControlEquations:
    """The equations of a scene of kind "state-space", of its normal form where that is requested."""
    control, ends = _state_space_scene(table, folder, file_name), shaped_inputs(table.force, file_name)
    if table.model.normal_form:
        return replace(_of_normal_form(control, table, file_name, lap), ends=ends)
    space = control.system
    A, initial = space.polynomial_matrix_with_outputs(), space.start_with_outputs(control.start)
    coordinates = Coordinates(A.coordinates, tuple(space.units[name] for name in A.coordinates))
    return ControlEquations(coordinates, A, initial, space.force_with_outputs(control.late_input), control=control, ends=ends)


# Reports: transfer functions and the normal form.

MOST_CHANNELS = 16  # pairs of inputs and outputs that are listed; JSON has all
MOST_ZEROS = 8  # of one channel that are listed

HIDDEN, NOT_LOOKED_FOR, POLE_AT_ZERO, NOT_KNOWN = "hidden by rounding", "not looked for", "none: a pole at 0", "not known"


def _transfer_json(G: Transfer | None) -> dict:
    if G is None:
        return {"zeros": None, "poles": None, "gain": None}
    roots = {key: [[z.real, z.imag] for z in roots_of(of_key)] for key, of_key in (("zeros", G.zeros), ("poles", G.poles))}
    return {**roots, "gain": G.gain}


def _form_json(form) -> dict:
    matrices = ("transformation", "stiffness", "damping", "input_matrix", "output_matrix", "feedthrough")
    data = {key: None if getattr(form, key) is None else getattr(form, key).tolist() for key in matrices}
    data |= {"condition": form.condition, "unique": form.is_unique, "freedom": form.freedom}
    if form.infinite is None:
        return data
    infinite = {key: getattr(form.infinite, key).tolist() for key in ("nilpotent", "input_matrix", "states", "rows")}
    return data | {"infinite": {**infinite, "index": form.infinite.index}}


def _transfer_table(control: ControlScene) -> TextTable:
    units = {name: unit for names in (control.inputs, control.outputs) for name, unit in zip(names.names, names.units)}
    rows = [(u, y, *_cells(control, u, y, G, _quotient(units[y], units[u]))) for u, y, G in control.transfers[:MOST_CHANNELS]]
    note = "G(s) = gain times the product of s - zeros over that of s - poles; the DC gain is G(0)."
    late = [f"from {name} times e^(-{number_text(delay)} s)" for name, delay in control.delays.items()]
    note += f" Dead time: G(s) {', '.join(late)}." if late else ""
    if len(control.transfers) > MOST_CHANNELS:
        note += f" The first {MOST_CHANNELS} of {len(control.transfers)} are shown."
    return TextTable("Transfer functions", ("from", "to", "zeros (1/s)", "gain", "DC gain"), tuple(rows), note)


def _cells(control: ControlScene, input: str, output: str, G: Transfer | None, unit: str) -> tuple[str, str, str]:
    dc = _dc_gain(control, input, output, G)
    gain = with_unit(dc, unit) if dc is not None else POLE_AT_ZERO if G is not None else NOT_KNOWN
    if G is None:
        return HIDDEN if control.looks_for_zeros else NOT_LOOKED_FOR, "", gain
    return (_roots(G.zeros), number_text(G.gain), gain) if G.gain else ("G(s) = 0", "0", "0")


def _dc_gain(control: ControlScene, input: str, output: str, G: Transfer | None) -> float | None:
    """G(0), also where the zeros of G are unknown."""
    if G is not None:
        return G.dc_gain
    gains = control.dc_gains
    return None if gains is None else float(gains[control.outputs.names.index(output), control.inputs.names.index(input)])


def _roots(zeros: Sequence) -> str:
    texts = []
    for root in zeros:
        value = complex(root.value)
        text = number_text(value.real) if value.real or not value.imag else ""
        text += f" ± {number_text(value.imag)} i" if value.imag else ""
        texts.append(text.strip() + (f" ({root.multiplicity} times)" if root.multiplicity > 1 else ""))
    more = [f"{len(texts) - MOST_ZEROS} more"] if len(texts) > MOST_ZEROS else []
    return ", ".join(texts[:MOST_ZEROS] + more) or "none"


def _quotient(above: str, below: str) -> str:
    """The unit of a ratio, as printed.

    >>> _quotient("m", "V"), _quotient("m", "1"), _quotient("m", "m"), _quotient("rad", "N*m")
    ('m/V', 'm', '1', 'rad/(N*m)')
    """
    if below in ("1", above):
        return above if below == "1" else "1"
    return f"{above}/({below})" if {"*", "/"} & set(below) else f"{above}/{below}"


def _form_table(form: NormalForm) -> TextTable:
    choice = "there is no other" if form.is_unique else f"one of a family of {form.freedom} dimensions, of small condition"
    rows = [("transformation", f"{2 * form.size} states to {counted(form.size, 'displacement')} and as many velocities; {choice}")]
    if form.infinite is not None:
        size, index = counted(form.infinite.size, "more state"), form.infinite.index
        rows.append(("infinite part", f"{size}, index {index}: massless coordinates, which follow the inputs at once"))
    rows += [(item.name, f"{item.value:.2g}: {item.text}") for item in form.evidence]
    return TextTable("Mechanical normal form", ("what", "value"), tuple(rows))
