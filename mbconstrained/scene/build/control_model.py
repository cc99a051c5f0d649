"""Scenes of kinds "transfer-function" and "state-space": the model with its input and its outputs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...control.matrix_fraction import scalar_force, scalar_matrix
from ...control.rational import RationalFunction, rational_function
from ...control.state_equations import Transfer, rational_transfer
from ...control.state_space import StateSpace
from ...control.transfer_function import transfer_function_response
from ...ground.checks import nearest
from ...ground.errors import IllConditioned, InputError, NoNormalForm, SceneError, shown
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...response.response import Response
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import power, zero
from ..file.messages import at
from ..quantities.coordinates import Coordinates, initial_values, state_values
from .data_files import entries_of
from .forces import input_of

if TYPE_CHECKING:
    from ...control.state_space import StateSpaceResponse
    from ...mechanics.normal_form import NormalForm
    from ...mechanics.system import MechanicalSystem

#: Zeros are looked for in systems of so many states, and so many pairs of inputs and outputs, at most.
MOST_STATES, MOST_PAIRS = 40, 16


@dataclass(frozen=True, eq=False)
class TransferFunction:
    """A transfer function with its input.

    Attributes:
        numerator, denominator: b and a as given, the highest power first.
        input: gamma of I_gamma, or u with one row.
        start: y^(i)(0-) as row i, shape (n, 1); None from rest.
    """

    numerator: list[float]
    denominator: list[float]
    input: int | ImpulsiveSmooth
    start: np.ndarray | None = None

    @cached_property
    def fraction(self) -> RationalFunction:
        """b(s)/a(s), exactly."""
        return rational_function(self.numerator, self.denominator)

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
        return scalar_force(self.acting.numerator, self.input)

    def response(self) -> Response | None:
        """y from rest; None where it starts from other values and is solved as other equations are."""
        if self.start is not None:
            return None
        return transfer_function_response(self.numerator, self.denominator, self.input)


@dataclass(frozen=True, eq=False)
class ControlScene:
    """The model of a scene of control engineering, with its input.

    Attributes:
        inputs, outputs: names and units.
        transfer_function: b(s)/a(s) with its input, or else None.
        system: the state space, or else None.
        input: u, p rows, where it is a state space.
        start: x(0-), shape (n,), where it is a state space.
        form: its mechanical normal form, where requested.
    """

    inputs: Coordinates
    outputs: Coordinates
    transfer_function: TransferFunction | None = None
    system: StateSpace | None = None
    input: ImpulsiveSmooth | None = None
    start: np.ndarray | None = None
    form: NormalForm | None = None

    @cached_property
    def response(self) -> StateSpaceResponse:
        """x and y of the state space, with the outputs also where the normal form is solved."""
        return self.system.solve(self.start, self.input)

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        """The outputs: the last coordinates, or computed from the states where the normal form is solved.

        Args:
            times: shape (T,), in s.
            coordinates: their values there, shape (r, T).

        Returns:
            Values of shape (q, T).
        """
        if self.form is not None:
            return self.response.output(times)
        return coordinates[len(coordinates) - len(self.outputs.names) :]

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


MATRICES = ("A", "B", "C", "D", "descriptor")


def transfer_function_scene(table, folder: Path, file_name: str) -> ControlScene:
    """Read a scene of kind "transfer-function"."""
    model = table.model
    with at(file_name, "model"):
        fraction = rational_function(model.numerator, model.denominator)
        _check_units(model.units, (model.input, model.output))
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
    transfer_function = TransferFunction(
        model.numerator, model.denominator, zero(1) if u is None else u, start if start.any() else None
    )
    return ControlScene(inputs, outputs, transfer_function)


def state_space_scene(table, folder: Path, file_name: str) -> ControlScene:
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
        _check_names((*system.states, *system.inputs, *system.outputs, *displacements))
    inputs, outputs = (_named(names, system.units) for names in (system.inputs, system.outputs))
    u = input_of(table.force, inputs, folder, file_name)
    _check_start(table.initial, file_name)
    start = state_values(table.initial.state, _named(system.states, system.units), file_name).astype(float)
    if table.initial.rows and not model.normal_form:
        with at(file_name, "initial"):
            raise InputError("a state space starts from its states; write state = { x1 = 0.1 } or state = [0.1, 0]")
    return ControlScene(inputs, outputs, None, system, zero(len(inputs.names)) if u is None else u, start)


def mechanical_scene(
    control: ControlScene, table, file_name: str, lap: Callable[[str], object]
) -> tuple[ControlScene, MechanicalSystem, Coordinates, np.ndarray]:
    """A state space in its mechanical normal form."""
    from ...mechanics.normal_form import mechanical_normal_form

    space, model, initial = control.system, table.model, table.initial
    lap("assemble the model")
    with at(file_name, "model.normal_form"):
        try:
            form = mechanical_normal_form(space.A, space.B, space.C, space.D, descriptor=space.E if space.is_descriptor else None)
        except NoNormalForm as problem:
            raise SceneError(f"{file_name}: model.normal_form: {problem}") from problem
    lap("mechanical normal form")
    names = _displacement_names(model, len(space.states))
    with at(file_name, "model.coordinates"):
        if len(names) != form.size:
            raise InputError(f"found {len(names)} names; expected {form.size}, half as many as states")
    units = {name: model.units.get(name, "m") for name in names}
    with at(file_name, "model.units"):
        system = form.system(names, units)
    coordinates, start = Coordinates(names, tuple(units.values())), control.start
    if initial.rows and initial.state:
        with at(file_name, "initial"):
            raise InputError("found state and values of the displacements; give one of them")
    if initial.rows:
        values = initial_values(initial, coordinates, 2, file_name).astype(float)
        start = form.state(*values)
    else:
        values = np.array(form.displacement_velocity(start))
    return replace(control, form=form, start=start), system, coordinates, values


def _displacement_names(model, states: int) -> tuple[str, ...]:
    return tuple(model.coordinates or (f"q{i + 1}" for i in range(states // 2)))


def _check_start(initial, file_name: str) -> None:
    if initial.follow:
        with at(file_name, "initial.follow"):
            raise InputError("there are no constraint rows that anything could follow; leave it out")


def _named(names, units) -> Coordinates:
    return Coordinates(tuple(names), tuple(units.get(name, "1") for name in names))


def _check_units(units, names) -> None:
    for name in units:
        if name not in names:
            known = ", ".join(names)
            raise InputError(f"units: there is no input or output {shown(name)}{nearest(name, names)}; there are {known}")


def _check_names(names) -> None:
    if repeated := next((name for name in names if names.count(name) > 1), None):
        raise InputError(f'the name "{repeated}" is used twice; states, inputs, outputs and coordinates must differ in name')
