"""The [parameters] of a scene: as parameters of its mechanical system with derivatives, and as symbols of exact equations.

The expressions of the scene are evaluated with p + i h in the place of p (``models.lumped``). The equations of robots and
of modal damping come from an equilibrium or from modes, those of a rotor depend on its speed: these are assembled for values around p (``Parameter.of_function``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.errors import InputError
from ...ground.tolerances import COMPLEX_STEP
from ...mechanics.constraints import LEVELS, row_names
from ...mechanics.parameter import Parameter
from ...models.lumped import complex_parameter, coordinate_row, exact_elements, incidence_of
from ..coordinates import FORCE_UNITS, Coordinates, constraint_row, force_value, initial_values, state_values
from ..file import SceneFolder, at
from ..run.scene_data import SceneData
from .data_files import entries_of
from .forces import sampled_force

if TYPE_CHECKING:
    from ...exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
    from ...exact.symbolic_equations import Row, Symbols


class ComplexNumbers:
    """Entries of a scene as numbers, with p + i h in place of one parameter.

    Args:
        values: values of all parameters.
        name: name of p.
        step: h.
    """

    def __init__(self, values: Mapping[str, float], name: str, step: float):
        self.values: dict[str, Any] = {**values, "pi": np.pi, name: complex(values[name], step)}

    def of(self, entry) -> Any:
        """A number unchanged, an expression by its value."""
        tree = getattr(entry, "tree", None)
        return float(entry) if tree is None else tree.value(float, self.values)

    def slope(self, entries, step: float) -> np.ndarray:
        """The derivatives of an array of entries."""
        return np.array([complex(self.of(entry)).imag / step for entry in np.asarray(entries, dtype=object).flat]).reshape(
            np.shape(entries)
        )


def scene_parameters(scene: SceneData, assembled: Callable[[SceneData, str, float], SceneData]) -> Iterator[Parameter]:
    if scene.equations.system is None:
        raise InputError("sensitivities need mass, damping and stiffness: a model of kind lumped, matrices or robot")
    model, values = scene.table.model, scene.parameters.values
    for name, value in values.items():
        unit = scene.parameters.units[name]
        follows = model.modal_damping is not None or getattr(scene.equations.system, "mass_damping", None) == "relative"
        if model.kind not in ("lumped", "matrices") or follows or scene.equations.rotor:
            system = lambda value, name=name: assembled(scene, name, value).equations.system  # noqa: E731
            yield Parameter.of_function(name, value, system, unit)
            continue
        step = COMPLEX_STEP * (abs(value) or 1.0)
        numbers = ComplexNumbers(values, name, step)
        parameter = (
            _of_elements(scene, name, value, numbers, step) if model.kind == "lumped" else _of_matrices(scene, name, numbers, step)
        )
        yield replace(_with_rayleigh(scene, parameter, numbers, step), unit=unit)


def _of_elements(scene: SceneData, name: str, value: float, numbers: ComplexNumbers, step: float) -> Parameter:
    model, gravity = scene.equations.model, scene.table.model.gravity
    elements = exact_elements(model.elements, numbers.of)
    pull = numbers.of(0.0 if gravity is None else gravity)
    return complex_parameter(name, value, elements, model.coordinates, step, "", pull)


def _of_matrices(scene: SceneData, name: str, numbers: ComplexNumbers, step: float) -> Parameter:
    model, coordinates = scene.table.model, scene.equations.coordinates
    slopes: dict[str, Any] = {}
    for key in ("stiffness", "damping", "mass"):
        source = getattr(model, key)
        slopes[key] = 0.0 if source is None else numbers.slope(entries_of(source, scene.folder), step)
    rows = {}
    for row, own in zip(model.constraint, row_names(scene.equations.system.constraints)):
        factors, value, _ = constraint_row(row, coordinates)
        slope = numbers.slope([factors.get(one, 0.0) for one in coordinates.names], step)
        rows[own] = (slope, float(numbers.slope(value, step)))
    return Parameter(name, scene.parameters.values[name], **slopes, rows=rows)


def _with_rayleigh(scene: SceneData, parameter: Parameter, numbers: ComplexNumbers, step: float) -> Parameter:
    """C + a M + b K with a and b depending on the parameter."""
    rayleigh, system = scene.table.model.rayleigh_damping, scene.equations.system
    if rayleigh is None:
        return parameter
    a, b = (complex(numbers.of(factor)).imag / step for factor in (rayleigh.mass, rayleigh.stiffness))
    own = parameter.with_damping(float(rayleigh.mass), float(rayleigh.stiffness))
    return replace(own, damping=own.damping + a * system.mass + b * system.stiffness)


@dataclass(frozen=True, eq=False)
class ExactEquations:
    """The arguments of ``solve_symbolically``."""

    polynomial_matrix: SymbolicPolynomialMatrix  # A(s)
    initial: np.ndarray  # x^(i)(0-) as row i
    force: list[Any]  # r expressions in t
    shown: tuple[str, ...]  # the coordinates whose formulas are wanted; others, as the input of a transfer function, only help
    # coordinates whose values at 0- follow from others, with the factors of these
    implied: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def exact_equations(scene: SceneData, symbols: Symbols) -> ExactEquations:
    kind = scene.table.model.kind
    if reason := next((end for end in scene.equations.ends if end.key != "shapers"), None):
        raise InputError(f"there is no formula with symbols for a motion with {reason.title.lower()}; leave [{reason.key}] out")
    if kind == "robot":
        raise InputError(
            "there is no formula with symbols for a robot: its equilibrium and its linearized equations are computed in floating "
            "point; a model of kind lumped or matrices has one"
        )
    if kind == "transfer-function":
        return _transfer_function(scene, symbols)
    if kind == "state-space":
        return _state_space(scene, symbols)
    if kind == "matrices" and scene.table.model.coefficients is not None:
        return _coefficients(scene, symbols)
    return _mechanical(scene, symbols)


def _mechanical(scene: SceneData, symbols: Symbols) -> ExactEquations:
    from ...exact.symbolic_equations import exact_form

    if scene.table.motion:
        raise InputError("there is no formula with symbols for a model with prescribed motions ([[motion]])")
    if scene.equations.rotor is not None:
        raise InputError("there is no formula with symbols for a rotor; give the matrices at one speed, or leave the formula out")
    coordinates = scene.equations.coordinates
    matrices, rows, static = _exact_lumped(scene, symbols) if scene.equations.model is not None else _matrices(scene, symbols)
    model = scene.table.model
    if model.modal_damping is not None:
        raise InputError(
            "there is no formula with symbols for modal damping, whose modes are computed in floating point; leave it out"
        )
    if model.rayleigh_damping is not None:
        K, C, M = matrices
        matrices = [K, C + symbols.of(model.rayleigh_damping.mass) * M + symbols.of(model.rayleigh_damping.stiffness) * K, M]
    form = exact_form(matrices, rows, coordinates.names)
    initial = symbols.all_of(initial_values(scene.table.initial, coordinates, 2, scene.path.name))
    if scene.table.initial.follow:
        initial = _followed(initial, scene, form.rows)
    applied = _exact_force(scene.table.force, coordinates, symbols, scene.folder, scene.path.name)
    force = form.force([one + other for one, other in zip(applied, static)])
    return ExactEquations(form.polynomial_matrix, initial, force, coordinates.names)


def _matrices(scene: SceneData, symbols: Symbols) -> tuple[list[np.ndarray], list[Row], list]:
    from ...exact.symbolic_equations import Row

    model, coordinates, folder = scene.table.model, scene.equations.coordinates, scene.folder
    size = len(coordinates.names)
    given = [getattr(model, key) for key in ("stiffness", "damping", "mass")]
    matrices = [symbols.all_of(np.zeros((size, size)) if source is None else entries_of(source, folder)) for source in given]
    rows = []
    for number, row in enumerate(model.constraint, 1):
        factors, value, _ = constraint_row(row, coordinates)
        coefficients = symbols.all_of([factors.get(name, 0) for name in coordinates.names])
        rows.append(Row(row.name or f"constraint {number}", coefficients, LEVELS.index(row.level), symbols.of(value)))
    return matrices, rows, [symbols.of(0)] * size


def _followed(initial: np.ndarray, scene: SceneData, rows) -> np.ndarray:
    from ...exact.symbolic_equations import followed

    names, given = scene.equations.coordinates.names, scene.table.initial.rows
    values_at_start = initial.copy()
    for order, values in enumerate(initial):
        known = np.array([order < len(given) and name in given[order] for name in names])
        values_at_start[order] = followed(values, known, rows, order)
    return values_at_start


def _coefficients(scene: SceneData, symbols: Symbols) -> ExactEquations:
    from ...exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix

    coordinates, folder, name = scene.equations.coordinates, scene.folder, scene.path.name
    matrices = [symbols.all_of(entries_of(source, folder)) for source in scene.table.model.coefficients]
    A = SymbolicPolynomialMatrix(matrices, coordinates.names)
    initial = symbols.all_of(initial_values(scene.table.initial, coordinates, A.degree, name))
    return ExactEquations(A, initial, _exact_force(scene.table.force, coordinates, symbols, folder, name), coordinates.names)


def _state_space(scene: SceneData, symbols: Symbols) -> ExactEquations:
    """[[s E - A, 0], [-C, I]] [x; y] = [B; D] u, the exact form of ``control.state_space``."""
    from ...exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix

    system, inputs = scene.equations.control.system, scene.equations.control.inputs
    sources = ((key, getattr(scene.table.model, "descriptor" if key == "E" else key)) for key in "EABCD")
    E, A, B, C, D = (  # omitted matrices as in the state space
        symbols.all_of(getattr(system, key) if source is None else entries_of(source, scene.folder)) for key, source in sources
    )
    n, q = len(A), len(C)
    constant, leading = (symbols.all_of(np.zeros((n + q, n + q))) for _ in range(2))
    constant[:n, :n], constant[n:, :n], constant[n:, n:] = -A, -C, symbols.all_of(np.eye(q))
    leading[:n, :n] = E
    names = (*system.states, *system.outputs)
    states = Coordinates(system.states, tuple(system.units[name] for name in system.states))
    start = symbols.all_of(state_values(scene.table.initial.state, states, scene.path.name))
    late = {name: symbols.of(delay) for name, delay in scene.table.model.delays.items()}
    u = _exact_force(scene.table.force, inputs, symbols, scene.folder, scene.path.name, late)
    force = list(np.vstack([B, D]) @ np.array(u, dtype=object)) if u else [symbols.of(0)] * (n + q)
    initial = np.concatenate([start, C @ start])[None]
    outputs = {name: dict(zip(system.states, row)) for name, row in zip(system.outputs, C)}
    return ExactEquations(SymbolicPolynomialMatrix([constant, leading], names), initial, force, names, outputs)


def _transfer_function(scene: SceneData, symbols: Symbols) -> ExactEquations:
    """[[a(s), -b(s)], [0, 1]] [y; u] = [0; u]: from rest, b(d/dt) acts on u with its jumps."""
    from ...exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
    from ...exact.symbolic_equations import begun, power_input

    model, control = scene.table.model, scene.equations.control
    a, b = (symbols.all_of(coefficients[::-1]) for coefficients in (model.denominator, model.numerator))
    degree = max(len(a), len(b)) - 1
    matrices = [symbols.all_of(np.zeros((2, 2))) for _ in range(degree + 1)]
    for place, polynomial in ((0, a), (1, -b)):
        for matrix, coefficient in zip(matrices, polynomial):
            matrix[0, place] = coefficient
    matrices[0][1, 1] = symbols.of(1)
    while len(matrices) > 1 and not any(matrices[-1].flat):
        matrices.pop()
    names = (control.outputs.names[0], control.inputs.names[0])
    delay = symbols.of(model.delay)
    u = _exact_force(scene.table.force, control.inputs, symbols, scene.folder, scene.path.name, {names[1]: delay})[0]
    if model.gamma is not None:
        u = u + begun(power_input(symbols.of(1), symbols.time, model.gamma), symbols.time, delay)
    initial = symbols.all_of(np.zeros((len(matrices) - 1, 2)))
    given = initial_values(scene.table.initial, control.outputs, len(a) - 1, scene.path.name)
    initial[: len(given), 0] = symbols.all_of(given[:, 0][: len(initial)])
    return ExactEquations(SymbolicPolynomialMatrix(matrices, names), initial, [symbols.of(0), u], names[:1], {names[1]: {}})


def _exact_force(
    tables: Sequence,
    coordinates: Coordinates,
    symbols: Symbols,
    folder: SceneFolder,
    file_name: str,
    dead_times: Mapping[str, Any] | None = None,
) -> list[Any]:
    """The sum of the forces on each coordinate, or of the signals on each input, whose dead times are given where they are not 0."""
    from ...exact import symbolic_equations as signals

    force = [symbols.of(0)] * len(coordinates.names)
    for number, table in enumerate(tables, 1):
        with at(file_name, f"force[{number}]"):
            if table.shaper is not None:
                raise InputError("formulas know no input shapers; write the delayed copies as [[force]] tables")
            for name, factor in (table.factors or {table.coordinate: 1}).items():
                place = coordinates.number(name)
                unit = coordinates.units[place]
                unit = FORCE_UNITS.get(unit) if dead_times is None else unit
                late = symbols.of(table.later) + (dead_times or {}).get(name, symbols.of(0))
                signal = symbols.of(factor) * _signal(table, unit, symbols, folder, signals)
                force[place] = force[place] + signals.begun(signal, symbols.time, late)
    return force


def _signal(table, unit: str | None, symbols: Symbols, folder: SceneFolder, signals) -> Any:
    t, of = symbols.time, symbols.of
    if table.kind == "sampled":
        times, values = sampled_force(table, unit, folder)
        return signals.sampled(*([of(entry) for entry in entries] for entries in (times, values)), t)
    value = of(force_value(table.value, unit, table.time_power))
    if table.kind == "pulse":
        if table.shape != "rectangle":
            raise InputError(
                f'formulas know rectangular pulses only, and this is a {table.shape}; write it as [[force]] of kind "term"'
            )
        return signals.pulse(value, t, of(table.start), of(table.duration))
    if table.kind in ("impulse", "power"):
        return signals.power_input(value, t, -table.order if table.kind == "impulse" else table.gamma)
    return signals.term(value, t, **_term(table, symbols, signals))


def _term(table, symbols: Symbols, signals) -> dict:
    """The factors of a step, ramp, harmonic force or term in t."""
    if table.kind in ("step", "ramp"):
        return {"power": 1} if table.kind == "ramp" else {}
    frequency = symbols.of(table.angular_frequency) if table.angular_frequency is not None else None
    if frequency is None:  # 0 may be the default of a parameter
        frequency = 2 * symbols.pi * symbols.of(0 if table.frequency is None else table.frequency)
    cosine = {"frequency": frequency, "phase": signals.angle(symbols.of(table.phase))}
    return cosine if table.kind == "harmonic" else {"power": table.power, "rate": symbols.of(table.rate), **cosine}


def _exact_lumped(scene: SceneData, symbols: Symbols) -> tuple[list[np.ndarray], list[Row], np.ndarray]:
    """K, C, M as arrays of expressions, the constraint rows, and the static force of rest lengths and weights."""
    from ...exact.symbolic_equations import Row

    table, names = scene.table.model, scene.equations.coordinates.names
    factors = incidence_of(exact_elements(scene.equations.model.elements, symbols.of), names, object)
    static = factors.static_force(symbols.of(0 if table.gravity is None else table.gravity))  # 0 may be the default of a parameter
    rows = [
        Row(tie.name, symbols.all_of(coordinate_row(tie.row, names, object)), LEVELS.index(tie.level), symbols.of(tie.row_value))
        for tie in factors.ties
    ]
    matrices = (factors.springs.product, factors.dampers.product, np.diag(factors.masses))
    return [symbols.all_of(matrix) for matrix in matrices], rows, symbols.all_of(static)  # sums of nothing are numbers
