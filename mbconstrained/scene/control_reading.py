"""From the tables of scenes of kinds "transfer-function" and "state-space" to their models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..checks import nearest
from ..errors import InputError, NoNormalForm, SceneError
from ..models.state_space import StateSpace
from ..response.transfer.rational import rational_function
from ..signals import power, zero
from .control import ControlScene, TransferFunction
from .files import matrix_of
from .forces import input_of
from .problems import at
from .units import shown
from .values import Coordinates, initial_values, state_values

if TYPE_CHECKING:
    from ..mechanics import MechanicalSystem

MATRICES = ("A", "B", "C", "D", "descriptor")


def transfer_function_scene(table, folder: Path, file_name: str) -> ControlScene:
    """Read a scene of kind "transfer-function".

    Raises:
        SceneError: a denominator that is zero, names, units or values that are wrong.
    """
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
    start = initial_values(table.initial, outputs, len(fraction.denominator) - 1, file_name)
    if u is None and not start.any():
        with at(file_name, "model"):
            raise InputError("nothing acts: give gamma = 1 (a step), a [[force]] on the input, or a start of the output")
    found = TransferFunction(model.numerator, model.denominator, zero(1) if u is None else u, start if start.any() else None)
    return ControlScene(inputs, outputs, found)


def state_space_scene(table, folder: Path, file_name: str) -> ControlScene:
    """Read a scene of kind "state-space", as it is.

    Raises:
        SceneError: matrices that do not fit, names, units or values that are wrong.
    """
    model, found = table.model, {}
    for key in MATRICES:
        source = getattr(model, key)
        with at(file_name, f"model.{key}"):
            found[key] = None if source is None else matrix_of(source, folder)
    displacements = displacement_names(model, len(found["A"])) if model.normal_form else ()
    with at(file_name, "model"):
        units = {name: unit for name, unit in model.units.items() if name not in displacements}
        system = StateSpace(**found, states=model.states, inputs=model.inputs, outputs=model.outputs, units=units)
        _check_names((*system.states, *system.inputs, *system.outputs, *displacements))
    inputs, outputs = (_named(names, system.units) for names in (system.inputs, system.outputs))
    u = input_of(table.force, inputs, folder, file_name)
    _check_start(table.initial, file_name)
    start = state_values(table.initial.state, _named(system.states, system.units), file_name)
    if table.initial.rows and not model.normal_form:
        with at(file_name, "initial"):
            raise InputError("a state space starts from its states; write state = { x1 = 0.1 } or state = [0.1, 0]")
    return ControlScene(inputs, outputs, None, system, zero(len(inputs.names)) if u is None else u, start)


def made_mechanical(control: ControlScene, file_name: str, lap: Callable[[str], None]) -> ControlScene:
    """With its mechanical normal form.

    Raises:
        SceneError: there is none; the text names the condition that fails.
    """
    from ..mechanics.normal_form import mechanical_normal_form

    system = control.system
    lap("assemble the model")
    with at(file_name, "model.normal_form"):
        try:
            E = system.E if system.is_descriptor else None
            form = mechanical_normal_form(system.A, system.B, system.C, system.D, descriptor=E)
        except NoNormalForm as problem:
            raise SceneError(f"{file_name}: model.normal_form: {problem}") from problem
    lap("mechanical normal form")
    return replace(control, form=form)


def mechanical_model(control: ControlScene, model, file_name: str) -> tuple[MechanicalSystem, Coordinates]:
    """The second-order system of the normal form, with names and units of its displacements."""
    form, names = control.form, displacement_names(model, len(control.system.states))
    with at(file_name, "model.coordinates"):
        if len(names) != form.size:
            raise InputError(f"found {len(names)} names; expected {form.size}, half as many as states")
    units = {name: model.units.get(name, "m") for name in names}
    with at(file_name, "model.units"):
        system = form.system(names, units)
    return system, Coordinates(names, tuple(units.values()))


def mechanical_start(control: ControlScene, initial, coordinates: Coordinates, file_name: str) -> tuple[ControlScene, np.ndarray]:
    """q and q' at 0- as rows, given themselves or by the states, and the scene with x(0-) of both."""
    if not initial.rows:
        return control, np.array(control.form.displacement_velocity(control.start))
    if initial.state:
        with at(file_name, "initial"):
            raise InputError("found state beside values of the displacements; give one of them")
    values = initial_values(initial, coordinates, 2, file_name)
    return replace(control, start=control.form.state(*values)), values


def displacement_names(model, states: int) -> tuple[str, ...]:
    """The names of the displacements of the normal form."""
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
