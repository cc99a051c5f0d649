"""The model of a scene from its tables: matrices, initial values, force, with names and units."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import counted
from ...ground.errors import InputError, SingularPolynomialMatrix, shown
from ...ground.quantities import Expressed, quantity
from ...ground.tolerances import CONSISTENT_ROWS
from ...linalg.scaling import equilibration
from ...mechanics.channels import channels
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..coordinates import DERIVATIVES, Coordinates, constraint_row, initial_values
from ..file import SceneFolder, SceneName, at
from .data_files import entries_of
from .ends import shaped, shaped_inputs, with_end
from .forces import NONE_SHAPED, Shapers, force_of, load_patterns, loads_of, prescribed_motions, shapers_of, unbalance_loads
from .model import Equations, no_modes
from .switched import known, phase_system, refuse_with_switches, switching_of, transition_of

if TYPE_CHECKING:
    from ...mechanics.switched.switched_system import SwitchedSystem
    from ...mechanics.system import MechanicalSystem
    from ...models.lumped import LumpedModel
    from .robot_model import RobotScene


def lumped_model(table, file_name: str) -> LumpedModel:
    """The model: bodies first, in the order of the file, then what joins them; a SceneError names the file and the entry."""
    from ...models.lumped import LumpedModel

    model = LumpedModel()
    for key, number, entry in table.elements:
        owner = f' (of "{entry.name}")' if entry.name else ""
        with at(file_name, f"model.{key}[{number}]{owner}"):
            add = model.constrain if key == "constraint" else getattr(model, key)
            add(**entry.given)
    joined = {name for element in model.elements for name in element.ends}
    for number, node in enumerate(table.node, 1):
        if node.name not in joined:
            with at(file_name, f'model.node[{number}] (of "{node.name}")'):
                raise InputError(
                    "nothing is attached to this joint, which has no mass, so that its position is undetermined; join it by a spring, "
                    "a damper or a constraint, or take it out"
                )
    if table.gravity is not None:
        with at(file_name, "model.gravity"):
            model.gravity(table.gravity)
    return model


#: Quantities of entries between coordinates in m, between one in m and one in rad, and between coordinates in rad.
ENTRY_UNITS = {
    "mass": ("kg", "kg*m/rad", "kg*m^2"),
    "damping": ("N*s/m", "N*s/rad", "N*m*s/rad"),
    "stiffness": ("N/m", "N/rad", "N*m/rad"),
    "gyroscopic": ("kg", "kg*m/rad", "kg*m^2"),
    "circulatory": ("N*s/m", "N*s/rad", "N*m*s/rad"),
}


def equations_of(table, folder: SceneFolder, file_name: SceneName, lap: Callable[[str], object] = lambda stage: None) -> Equations:
    """Assemble the equations of a scene, with the input or the motion that reaches its end where one is given."""
    kind = table.model.kind
    if kind == "state-space":
        from .control_model import state_space

        equations = state_space(table, folder, file_name, lap)
    elif kind == "transfer-function":
        from .control_model import transfer_function

        equations = transfer_function(table, folder, file_name)
    elif kind == "robot":
        from .robot_model import robot_scene, robot_switches

        robot = robot_scene(table.model, table.robot, folder.path, file_name, lap)
        parts = robot_switches(table.model, robot.data, file_name)
        machine = (lambda moved: moved[0].with_switches(*parts)) if parts else None
        equations = _mechanical(table, robot.system, robot.coordinates, folder, file_name, robot=robot, machine=machine)
    else:
        of_kind = _lumped if kind == "lumped" else _matrices if table.model.coefficients is None else _coefficients
        equations = of_kind(table, folder, file_name)
    if table.boundary is None and table.least_energy is None:
        return equations
    lap("assemble the model")
    equations = with_end(table, equations, file_name)
    lap("boundary values" if table.boundary else "input of least energy")
    return equations


def _lumped(table, folder: SceneFolder, file_name: str) -> Equations:

    model = lumped_model(table.model, file_name)
    with at(file_name, "model"):
        system = model.common_system() if model.has_switches else model.assemble()
    coordinates = Coordinates(tuple(model.coordinates), tuple(model.units[name] for name in model.coordinates))
    if not model.has_switches:
        return _mechanical(table, system, coordinates, folder, file_name, model)
    from ...mechanics.switched.switched_system import SwitchedSystem

    switches = model.switches()
    return _mechanical(
        table,
        system,
        coordinates,
        folder,
        file_name,
        model,
        machine=lambda systems: SwitchedSystem.of_switches(systems[0], switches),
    )


def _matrices(table, folder: SceneFolder, file_name: str) -> Equations:
    model = table.model
    matrices = _matrices_of(model, ENTRY_UNITS, folder, file_name, "model")
    coordinates = _coordinates(model, len(matrices["mass"]), file_name)
    _check_kinds(model, coordinates, file_name, "model")
    if not model.phase:
        system = _system_of(model, matrices, {"model": model}, coordinates, file_name)
        return _mechanical(table, system, coordinates, folder, file_name)
    systems = {}
    for number, phase in enumerate(model.phase, 1):
        place = f'model.phase[{number}] (of "{phase.name}")'
        own = _matrices_of(phase, PHASE_MATRICES, folder, file_name, place)
        _check_kinds(phase, coordinates, file_name, place)
        own = {**matrices, **{key: matrix for key, matrix in own.items() if matrix is not None}}
        systems[phase.name] = _system_of(model, own, {"model": model, place: phase}, coordinates, file_name)
    with at(file_name, "model.start"):
        start = known(model.start or model.phase[0].name, systems, "phase")
    transitions = [transition_of(one, systems, coordinates, number, file_name) for number, one in enumerate(model.transition, 1)]
    names = [start, *(name for name in systems if name != start)]
    first, *others = (systems[name] for name in names)

    def machine(moved: Sequence[MechanicalSystem]) -> SwitchedSystem:
        from ...mechanics.switched.switched_system import SwitchedSystem

        return SwitchedSystem(dict(zip(names, moved)), transitions)

    return _mechanical(table, first, coordinates, folder, file_name, machine=machine, others=others)


#: The matrices that a phase may have of its own.
PHASE_MATRICES = ("mass", "damping", "stiffness")


def _matrices_of(owner, keys: Iterable[str], folder: SceneFolder, file_name: str, where: str) -> dict[str, np.ndarray | None]:
    matrices = {}
    for key in keys:
        source = getattr(owner, key)
        with at(file_name, f"{where}.{key}"):
            matrices[key] = None
            if source is not None:
                entries = entries_of(source, folder)
                rows, columns = entries.shape
                if rows != columns or not rows:
                    raise InputError(f"found {rows} rows and {columns} columns; expected a square matrix")
                matrices[key] = entries.astype(float)  # parameters at their default values
    return matrices


def _system_of(model, matrices, owners: Mapping[str, Any], coordinates: Coordinates, file_name: str) -> MechanicalSystem:
    """The system of matrices with the constraint rows of tables by their place, and the unbalance of the model."""
    from ...mechanics.constraints import Constraint
    from ...mechanics.element_matrix import unbalance_of
    from ...mechanics.system import MechanicalSystem

    constraints = []
    for where, owner in owners.items():
        for number, row in enumerate(owner.constraint, 1):
            with at(file_name, f"{where}.constraint[{number}]"):
                factors, value, unit = constraint_row(row, coordinates)
                coefficients = np.array([factors.get(name, 0.0) for name in coordinates.names], float)
                constraints.append(Constraint(coefficients, level=row.level, value=value, names=row.name, unit=unit))
    units = dict(zip(coordinates.names, coordinates.units))
    with at(file_name, list(owners)[-1]):
        system = MechanicalSystem(**matrices, constraints=constraints, names=coordinates.names, units=units)
    for number, entry in enumerate(model.unbalance, 1):
        with at(file_name, f"model.unbalance[{number}]"):
            system.unbalance = np.zeros(system.size, dtype=complex) if system.unbalance is None else system.unbalance
            system.unbalance += unbalance_of(*map(coordinates.number, entry.coordinates), entry.moment, entry.angle, system.size)
    return system


def _check_kinds(owner, coordinates: Coordinates, file_name: str, where: str) -> None:
    """Check that entries with units are masses in a mass matrix and so on, between coordinates in m and rad."""
    known = [i for i, unit in enumerate(coordinates.units) if unit in ("m", "rad")]
    for key, units in ENTRY_UNITS.items():
        entries = getattr(owner, key, None)
        if not isinstance(entries, np.ndarray) or len(entries) != len(coordinates.names):
            continue
        for i, j in product(known, known):
            if isinstance(entries[i, j], Expressed):
                with at(file_name, f"{where}.{key}[{i + 1}][{j + 1}]"):
                    quantity(entries[i, j], units[(coordinates.units[i] == "rad") + (coordinates.units[j] == "rad")])


def _mechanical(
    table,
    system,
    coordinates,
    folder,
    file_name,
    model: LumpedModel | None = None,
    robot: RobotScene | None = None,
    machine: Callable[[Sequence[MechanicalSystem]], SwitchedSystem] | None = None,
    others: Sequence[MechanicalSystem] = (),
) -> Equations:
    """The equations of a mechanical system with the motions, damping, speed, start and loads of the scene; those that switch are made by
    a machine of this system and others."""
    given = table, (system, *others), coordinates, folder, file_name, robot
    moved, of_motions, shapers = _moving(*given, NONE_SHAPED), NONE_SHAPED, NONE_SHAPED
    if any(motion.shaper for motion in table.motion):
        of_motions = shapers_of(table.motion, "motion", moved[0][0].modes, file_name)
        moved = _moving(*given, of_motions)
    system, rotor = moved[0]
    if any(load.shaper for load in table.force):
        shapers = shapers_of(table.force, "force", system.modes, file_name)
    linearized = robot and system
    initial = initial_values(table.initial, coordinates, 2, file_name).astype(float)
    if table.initial.follow:
        initial = consistent_values(initial, table.initial, system, coordinates, file_name)
    loads = loads_of(table.force, coordinates, folder, file_name, linearized, shapers) if table.force else ()
    if rotor is not None and rotor.unbalance is not None:
        loads += unbalance_loads(rotor.unbalance, table.model.speed or 0.0, coordinates)
    switching = None
    if machine is not None:
        refuse_with_switches(table, (*of_motions.values(), *shapers.values()), file_name)
        with at(file_name, "model"):
            switched = machine([one for one, _ in moved])
        switching = switching_of(table, switched, initial, force_of(loads), file_name)
        system = phase_system(switching)
        rotor = None if rotor is None else machine([one for _, one in moved]).phase(*switching.phase)
    with at(file_name, "model"):
        polynomial_matrix = system.undelayed_form().polynomial_matrix
    if any(load.factors for load in table.force):
        patterns = load_patterns(table.force, coordinates, channels(system, "inputs"), file_name, linearized)
        for one in (system, rotor):
            if one is not None:
                one.load_patterns = patterns
    problem = coordinates, polynomial_matrix, initial, force_of(loads), system
    ends = shaped(table.motion, of_motions, table.force, shapers) if of_motions or shapers else ()
    if robot is None:
        return Equations(*problem, model, loads=loads, rotor=rotor, ends=ends, switching=switching)
    from .robot_model import RobotEquations

    own = replace(robot, system=system)
    return RobotEquations(*problem, robot_scene=own, loads=loads, rotor=rotor, ends=ends, switching=switching)


def _moving(
    table,
    systems: Sequence[MechanicalSystem],
    coordinates: Coordinates,
    folder: SceneFolder,
    file_name: str,
    robot: RobotScene | None,
    shapers: Shapers,
) -> list[tuple[MechanicalSystem, MechanicalSystem | None]]:
    """The systems with prescribed motions, damping and speed, each with its rotor at rest; None without rotation."""
    linearized, speed = robot and robot.system, getattr(table.model, "speed", None)  # a robot knows inputs by name
    prescribed = prescribed_motions(table.motion, coordinates, folder, file_name, linearized, shapers) if table.motion else ()
    moved = []
    for own in systems:
        with at(file_name, "motion"):
            if linearized and table.motion:  # a moving base is at rest where nothing else is prescribed
                own = linearized.without_rows(f"motion of {name}" for name in table.prescribed.values())
            own = own.with_constraints(*prescribed) if prescribed else own
        own = _damped(table, own, file_name)  # of the modes with the supports at rest
        with at(file_name, "model.speed"):
            if not own.turns and speed is not None:
                raise InputError(
                    "nothing of this model turns; give it a rotor, a gyroscopic or a circulatory matrix, or leave it out"
                )
            moved.append((own.at_speed(speed or 0.0), own) if own.turns else (own, None))
    return moved


def _damped(table, system: MechanicalSystem, file_name: str) -> MechanicalSystem:
    """The system with the damping of the model as a whole; for base excitation damping acts on the relative motion."""
    model = table.model
    if (rayleigh := model.rayleigh_damping) is not None:
        relative = rayleigh.relative
        if relative is None:
            relative = not system.is_sparse and (
                any(entry.of != "force" for entry in (table.random.input if table.random else ()))
                or any(motion.kind == "sampled" for motion in table.motion)
            )
        with at(file_name, "model.rayleigh_damping"):
            system = system.with_rayleigh_damping(rayleigh.mass, rayleigh.stiffness, relative)
    if model.modal_damping is not None:
        with at(file_name, "model.modal_damping"):
            system = system.with_modal_damping(model.modal_damping)
    return system


def _coefficients(table, folder: SceneFolder, file_name: str) -> Equations:
    model, matrices = table.model, []
    for number, source in enumerate(model.coefficients):
        with at(file_name, f"model.coefficients[{number + 1}] (A_{number})"):
            matrices.append(_filled(entries_of(source, folder)))
    rows, columns = matrices[0].shape
    coordinates = _coordinates(model, columns, file_name)
    with at(file_name, "model.coefficients"):
        A = PolynomialMatrix(matrices, coordinates=coordinates.names, equations=model.equations)
    if table.initial.follow:
        with at(file_name, "initial.follow"):
            raise InputError("equations given by coefficients have no constraint rows to follow; give all values")
    initial = initial_values(table.initial, coordinates, A.degree, file_name).astype(float)
    shapers = shapers_of(table.force, "force", None, file_name)
    named = model.equations is None and rows == columns
    places = coordinates if named else Coordinates(A.equations, ("1",) * rows)
    loads = loads_of(table.force, places, folder, file_name, shapers=shapers)
    equations = Equations(coordinates, A, initial, force_of(loads), loads=loads, ends=shaped_inputs(table.force, file_name))
    if A.is_square and not table.motion and A.is_regular:
        return equations
    return _with_free_coordinates(table, equations, folder, file_name)


def _with_free_coordinates(table, equations: Equations, folder: SceneFolder, file_name: str) -> Equations:
    """The equations with free coordinates that move as [[motion]] tables have it, and without redundant ones; both are checked."""
    from ...response.solvability import completed, solvability

    A, coordinates = equations.polynomial_matrix, equations.coordinates
    if table.time.step_domain == "discrete":
        with at(file_name, "time.step_domain"):
            raise InputError(
                "in discrete time coefficients must be those of a regular system: square, with det A(z) not zero for every z"
            )
    for key in (key for key in ("frequency", "random", "campbell", "orders") if getattr(table, key) is not None):
        with at(file_name, key):
            raise InputError(no_modes(key))
    if not table.motion and (report := solvability(A, equations.initial, equations.force)).freedom:
        choices = "; or ".join(f'[[motion]] with coordinate = "{name}"' for name in report.may_be_chosen)
        where = "det A(s) is zero for every s: " * A.is_square
        raise SingularPolynomialMatrix(
            f"{file_name}: model.coefficients: {where}the equations leave {counted(report.freedom, 'coordinate')} free. Choose "
            f"{'its motion' if report.freedom == 1 else 'their motions'} by {choices}\n{report.summary()}"
        )
    free, shapers = {}, shapers_of(table.motion, "motion", None, file_name)
    for number, row in enumerate(prescribed_motions(table.motion, coordinates, folder, file_name, shapers=shapers), 1):
        with at(file_name, f"motion[{number}]"):
            name = coordinates.names[int(np.argmax(np.abs(row.rows[0])))]
            if row.level != "position" or name in free:
                raise InputError(
                    f'the motion of "{name}" is chosen once, at the level "position"; found {"a second one" if name in free else row.level}'
                )
            free[name] = row.signal
    with at(file_name, "motion" if free else "model.coefficients"):
        problem, report = completed(A, equations.initial, equations.force, free)
    return replace(equations, polynomial_matrix=problem.polynomial_matrix, force=problem.force, solvability=report)


def _filled(matrix: np.ndarray) -> np.ndarray:
    """A matrix with its parameters at their default values, or an InputError."""
    if not matrix.size:
        raise InputError("found an empty matrix; expected rows of numbers")
    return matrix.astype(float)


def _coordinates(model, count: int, file_name: str) -> Coordinates:
    names = tuple(model.coordinates or (f"x{i + 1}" for i in range(count)))
    with at(file_name, "model.coordinates"):
        if len(names) != count:
            raise InputError(f"found {len(names)} names; expected {count}, one for each row of the matrices")
        if repeated := next((name for name in names if names.count(name) > 1), None):
            raise InputError(f'the name "{repeated}" is used twice; names must differ')
    with at(file_name, "model.units"):
        in_metres = Coordinates(names, ("m",) * count)
        units = {in_metres.number(name): unit for name, unit in model.units.items()}
    return Coordinates(names, tuple(units.get(i, "m") for i in range(count)))


# Consistent initial values: those not given follow from the constraint rows.


def consistent_values(
    initial: np.ndarray, table, system: MechanicalSystem | None, coordinates: Coordinates, file_name: str
) -> np.ndarray:
    """The values at 0-, with those omitted from the [initial] table chosen to satisfy the constraint rows.

    Rows A x^(level) = b at position level hold for positions, and with the derivative of b for velocities (0 where b is constant),
    where those at velocity level join them. Omitted values remain 0 where the rows hold with 0, and in coordinates of no row.
    """
    if system is None or not system.rows:
        with at(file_name, "initial.follow"):
            raise InputError("there are no constraint rows from which values could follow; leave it out")
    values = initial.copy()
    for order, row in enumerate(initial):
        given = table.rows[order] if order < len(table.rows) else {}
        known = np.array([name in given for name in coordinates.names])
        with at(file_name, f"initial.{DERIVATIVES[order]}"):
            values[order] = _completed(row, known, system, order, coordinates.names)
    return values


def _completed(values: np.ndarray, known: np.ndarray, system: MechanicalSystem, order: int, names) -> np.ndarray:
    chosen = [i for i, row in enumerate(system.rows) if row.order <= order]
    A = system.constraint_matrix[chosen]
    b = np.array([system.rows[i].right_side(order)(0.0)[0] for i in chosen])
    if _holds(A, values, b).all():
        return values
    free = np.flatnonzero(~known & A.any(axis=0))
    result = values.copy()
    result[free] = _solved(A[:, free], b - A @ values, [names[i] for i in free])
    satisfied = _holds(A, result, b)
    if not satisfied.all():
        worst = system.rows[chosen[int(np.argmin(satisfied))]].name
        raise InputError(f"the given values contradict the constraint row {shown(worst)}; leave out one of them, or follow")
    return result


def _holds(A: np.ndarray, x: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Which rows of A x = b hold to rounding errors, in units in which the entries of A are of one size."""
    _, columns = _scales(A)
    size = np.abs(A * columns).max(axis=1, initial=0.0) * np.abs(x / columns).max(initial=0.0)
    return np.abs(A @ x - b) <= CONSISTENT_ROWS * (size + np.abs(b))


def _scales(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return equilibration(np.abs(A)) if A.size else (np.ones(A.shape[0]), np.ones(A.shape[1]))


def _solved(A: np.ndarray, b: np.ndarray, names: list[str]) -> np.ndarray:
    """The least-squares solution of A x = b."""
    rows, columns = _scales(A)
    u, s, vt = np.linalg.svd(rows[:, None] * A * columns)
    rank = int((s > CONSISTENT_ROWS * s.max(initial=0.0)).sum())
    null = vt[rank:]
    loose = [name for name, column in zip(names, null.T) if np.abs(column).max(initial=0.0) > CONSISTENT_ROWS]
    if loose:
        many = f"{len(null)} of them" if len(null) > 1 else "one of them"
        raise InputError(f"the constraint rows leave {', '.join(map(shown, loose))} open; give {many} a value")
    return columns * (vt[:rank].T @ ((u[:, :rank].T @ (rows * b)) / s[:rank]))
