"""From the tables of a scene to its equations: matrices, start, force, with names and units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..notices import Notice
from ..polynomial import PolynomialMatrix
from ..response import Response, solve
from ..response.parts import start_of
from ..signals import ImpulsiveSmooth, zero
from .expressed import Expressed
from .files import matrix_of
from .following import following
from .forces import force_of
from .problems import at
from .units import quantity
from .values import Coordinates, beyond_noise, constraint_value, initial_values

if TYPE_CHECKING:
    from ..mechanics import MechanicalSystem
    from ..models.lumped import LumpedModel
    from ..models.robot import Posture, Robot
    from .control import ControlScene
    from .robot import RobotScene


#: What entries between coordinates in m are.
ENTRY_UNITS = {"mass": "kg", "damping": "N*s/m", "stiffness": "N/m"}


@dataclass(frozen=True)
class Equations:
    """What a scene asks to be solved.

    Attributes:
        coordinates: names and units.
        polynomial_matrix: A(s), for a mechanical system that of its constrained form.
        initial: x^(i)(0-) as row i, shape (q, r).
        force: on [0, inf), or None.
        system: mass, damping, stiffness and constraint rows; None where A(s) was given itself.
        model: the lumped model behind the system, or None.
        robot_scene: the robot behind the system with its posture, inputs and outputs, or None.
        control: the transfer function or state space behind the equations with its inputs and outputs, or None.
    """

    coordinates: Coordinates
    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: ImpulsiveSmooth | None
    system: MechanicalSystem | None = None
    model: LumpedModel | None = None
    robot_scene: RobotScene | None = None
    control: ControlScene | None = None

    @property
    def coordinates_called(self) -> str:
        """What the coordinates are to those who wrote the scene."""
        if not self.has_outputs_among_coordinates:
            return "coordinates"
        return "output" if self.control.transfer_function else "states and outputs"

    @property
    def outputs(self) -> Coordinates | None:
        """Names and units of what is read off the coordinates, or None."""
        found = self.control or self.robot_scene
        return found.outputs if found and found.outputs.names else None

    @property
    def form_notices(self) -> tuple[Notice, ...]:
        """What makes the mechanical normal form doubtful, where there is one."""
        return self.control.form.notices if self.control and self.control.form else ()

    @property
    def has_outputs_among_coordinates(self) -> bool:
        """Whether the outputs are solved for like coordinates."""
        return self.control is not None and self.control.form is None

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        """The outputs at times (T,), shape (q, T), from the coordinates there."""
        if self.control is not None:
            return self.control.output_values(times, coordinates)
        return self.robot_scene.system.output_matrix @ coordinates

    @property
    def robot(self) -> Robot | None:
        """The robot behind the system, or None."""
        return self.robot_scene and self.robot_scene.robot

    @property
    def posture(self) -> Posture | None:
        """The equilibrium about which the robot moves, or None."""
        return self.robot_scene and self.robot_scene.posture

    @property
    def right_hand_side(self) -> ImpulsiveSmooth:
        """What stands on the right of A(d/dt) x: forces, static offsets and constraint values."""
        force = zero(len(self.coordinates.names)) if self.force is None else self.force
        return force if self.system is None else self.system.constrained_form().force(self.system.force + force)

    @property
    def is_free(self) -> bool:
        """Whether nothing stands on the right."""
        return self.right_hand_side.is_zero

    @property
    def start_fits(self) -> bool:
        """Whether the values at 0- go on without a jump or an impulse."""
        start = start_of(self.polynomial_matrix.jordan_pairs().form, self.initial, self.right_hand_side)
        jumps = any(beyond_noise(jump, old, jump + old).size for jump, old in zip(start.jump, self.initial))
        return not (jumps or any(impulse.any() for impulse in start.impulses))

    def solve(self) -> Response:
        """The answer: a Motion where there is a mechanical system, else a Response."""
        if self.system is not None:
            return self.system.solve(*self.initial, force=self.force)
        from_rest = self.control.transfer_function.response() if self.control and self.control.transfer_function else None
        return from_rest or solve(self.polynomial_matrix, initial=self.initial, force=self.force)


def equations_of(table, folder: Path, file_name: str, lap: Callable[[str], None] = lambda stage: None) -> Equations:
    """Assemble the equations of a scene; of a robot's stages ``lap`` is told as each is done.

    Raises:
        SceneError: unknown names, values of the wrong kind, files that cannot be read, contradictory constraints.
    """
    if table.model.kind == "lumped":
        return _lumped(table, folder, file_name)
    if table.model.kind == "robot":
        return _robot(table, folder, file_name, lap)
    if table.model.kind == "transfer-function":
        return _transfer_function(table, folder, file_name)
    if table.model.kind == "state-space":
        return _state_space(table, folder, file_name, lap)
    if table.model.coefficients is not None:
        return _coefficients(table, folder, file_name)
    return _matrices(table, folder, file_name)


def _lumped(table, folder: Path, file_name: str) -> Equations:
    from .lumped import lumped_model

    model = lumped_model(table.model, file_name)
    with at(file_name, "model"):
        system = model.assemble()
    coordinates = Coordinates(tuple(model.coordinates), tuple(model.units[name] for name in model.coordinates))
    return _mechanical(table, system, coordinates, folder, file_name, model)


def _robot(table, folder: Path, file_name: str, lap) -> Equations:
    from .robot import robot_scene

    found = robot_scene(table.model, folder, file_name, lap)
    return _mechanical(table, found.system, found.coordinates, folder, file_name, robot_scene=found)


def _transfer_function(table, folder: Path, file_name: str) -> Equations:
    from .control_reading import transfer_function_scene

    control = transfer_function_scene(table, folder, file_name)
    found = control.transfer_function
    initial = found.start if found.start is not None else np.zeros((found.polynomial_matrix.degree, 1))
    return Equations(control.outputs, found.polynomial_matrix, initial, found.force, control=control)


def _state_space(table, folder: Path, file_name: str, lap) -> Equations:
    from ..models.state_space_response import force_with_outputs, start_with_outputs
    from .control_reading import (
        made_mechanical,
        mechanical_model,
        mechanical_start,
        state_space_scene,
    )

    control = state_space_scene(table, folder, file_name)
    if table.model.normal_form:
        control = made_mechanical(control, file_name, lap)
        system, coordinates = mechanical_model(control, table.model, file_name)
        control, initial = mechanical_start(control, table.initial, coordinates, file_name)
        force = control.form.force(control.input)
        return Equations(coordinates, system.polynomial_matrix(), initial, force, system, control=control)
    system = control.system
    A, initial = system.polynomial_matrix_with_outputs(), start_with_outputs(system, control.start)
    coordinates = Coordinates(A.coordinates, tuple(system.units[name] for name in A.coordinates))
    return Equations(coordinates, A, initial, force_with_outputs(system, control.input), control=control)


def _matrices(table, folder: Path, file_name: str) -> Equations:
    from ..mechanics import Constraint, MechanicalSystem

    matrices = {}
    for key in ("mass", "damping", "stiffness"):
        source = getattr(table.model, key)
        with at(file_name, f"model.{key}"):
            matrices[key] = None if source is None else _square(matrix_of(source, folder))
    coordinates = _coordinates(table.model, len(matrices["mass"]), file_name)
    _check_kinds(table.model, coordinates, file_name)
    constraints = []
    for number, row in enumerate(table.model.constraint, 1):
        with at(file_name, f"model.constraint[{number}]"):
            coefficients, value = _row(row, coordinates), constraint_value(row, coordinates)
            unit = _common_unit(row, coordinates)
            constraints.append(Constraint(coefficients, level=row.level, value=value, names=row.name, unit=unit))
    units = dict(zip(coordinates.names, coordinates.units))
    with at(file_name, "model"):
        system = MechanicalSystem(**matrices, constraints=constraints, names=coordinates.names, units=units)
    return _mechanical(table, system, coordinates, folder, file_name)


def _check_kinds(model, coordinates: Coordinates, file_name: str) -> None:
    """Parameters in a mass matrix are masses, and so on, between coordinates in m; otherwise units mix."""
    in_metres = [i for i, unit in enumerate(coordinates.units) if unit == "m"]
    for key, unit in ENTRY_UNITS.items():
        entries = getattr(model, key)
        if not isinstance(entries, np.ndarray) or len(entries) != len(coordinates.names):
            continue
        for i, j in product(in_metres, in_metres):
            if isinstance(entries[i, j], Expressed):
                with at(file_name, f"model.{key}[{i + 1}][{j + 1}]"):
                    quantity(entries[i, j], unit)


def _mechanical(table, system, coordinates, folder, file_name, model=None, robot_scene=None) -> Equations:
    with at(file_name, "model"):
        polynomial_matrix = system.polynomial_matrix()
    initial = initial_values(table.initial, coordinates, 2, file_name)
    if table.initial.follow:
        initial = following(initial, table.initial, system, coordinates, file_name)
    force = force_of(table.force, coordinates, folder, file_name, robot_scene and robot_scene.system)
    return Equations(coordinates, polynomial_matrix, initial, force, system, model, robot_scene)


def _coefficients(table, folder: Path, file_name: str) -> Equations:
    matrices = []
    for number, source in enumerate(table.model.coefficients):
        with at(file_name, f"model.coefficients[{number + 1}] (A_{number})"):
            matrices.append(_square(matrix_of(source, folder)))
    coordinates = _coordinates(table.model, len(matrices[0]), file_name)
    with at(file_name, "model.coefficients"):
        A = PolynomialMatrix(matrices, coordinates=coordinates.names)
    if table.initial.follow:
        with at(file_name, "initial.follow"):
            raise InputError("equations given by coefficients have no constraint rows to follow; give all values")
    initial = initial_values(table.initial, coordinates, A.degree, file_name)
    return Equations(coordinates, A, initial, force_of(table.force, coordinates, folder, file_name))


def _square(matrix: np.ndarray) -> np.ndarray:
    rows, columns = matrix.shape
    if rows != columns or not rows:
        raise InputError(f"found {rows} rows and {columns} columns; expected a square matrix")
    return matrix


def _coordinates(model, count: int, file_name: str) -> Coordinates:
    names = tuple(model.coordinates or (f"x{i + 1}" for i in range(count)))
    with at(file_name, "model.coordinates"):
        if len(names) != count:
            raise InputError(f"found {len(names)} names; expected {count}, one for each row of the matrices")
        if repeated := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f'the name "{repeated}" is used twice; names must differ')
    with at(file_name, "model.units"):
        plain = Coordinates(names, ("m",) * count)
        units = {plain.number(name): unit for name, unit in model.units.items()}
    return Coordinates(names, tuple(units.get(i, "m") for i in range(count)))


def _common_unit(table, coordinates: Coordinates) -> str | None:
    """The unit of the coordinates named in a row, also of those with the factor 0; None where it differs."""
    units = {coordinates.units[coordinates.number(name)] for name in table.rows}
    return units.pop() if len(units) == 1 else None


def _row(table, coordinates: Coordinates) -> np.ndarray:
    row = np.zeros(len(coordinates.names))
    for name, factor in table.rows.items():
        row[coordinates.number(name)] = factor
    return row
