"""The equations of a scene with its parameters as symbols and its numbers as the decimals that they are written as."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..mechanics.constraint import LEVELS
from .exact_forces import exact_force
from .exact_lumped import exact_lumped
from .files import entries_of
from .values import Coordinates, constraint_value, initial_entries, state_entries

if TYPE_CHECKING:
    from ..exact.formulas.constrained import Row
    from ..exact.formulas.symbols import Symbols
    from ..exact.symbolic import SymbolicPolynomialMatrix
    from .scene import Scene


@dataclass(frozen=True)
class ExactEquations:
    """What ``solve_symbolically`` is asked.

    Attributes:
        polynomial_matrix: A(s).
        initial: x^(i)(0-) as row i.
        force: r expressions in t.
        shown: the coordinates whose formulas are wanted; others, as the input of a transfer function, only help.
        implied: coordinates whose values at 0- follow from others, with the factors of these.
    """

    polynomial_matrix: SymbolicPolynomialMatrix
    initial: np.ndarray
    force: list[Any]
    shown: tuple[str, ...]
    implied: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def exact_equations(scene: Scene, symbols: Symbols) -> ExactEquations:
    """The equations, exactly.

    Raises:
        InputError: a robot, whose equations come from a posture that is found in floating point.
    """
    kind = scene.table.model.kind
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


def _mechanical(scene: Scene, symbols: Symbols) -> ExactEquations:
    from ..exact.formulas.constrained import exact_form

    coordinates = scene.equations.coordinates
    matrices, rows, static = exact_lumped(scene, symbols) if scene.equations.model is not None else _matrices(scene, symbols)
    form = exact_form(matrices, rows, coordinates.names)
    initial = symbols.all_of(initial_entries(scene.table.initial, coordinates, 2, scene.path.name))
    if scene.table.initial.follow:
        initial = _followed(initial, scene, form.rows)
    applied = exact_force(scene.table.force, coordinates, symbols, scene.path.parent, scene.path.name)
    force = form.force([one + other for one, other in zip(applied, static)])
    return ExactEquations(form.polynomial_matrix, initial, force, coordinates.names)


def _matrices(scene: Scene, symbols: Symbols) -> tuple[list[np.ndarray], list[Row], list]:
    from ..exact.formulas.constrained import Row

    model, coordinates, folder = scene.table.model, scene.equations.coordinates, scene.path.parent
    size = len(coordinates.names)
    given = [getattr(model, key) for key in ("stiffness", "damping", "mass")]
    matrices = [symbols.all_of(np.zeros((size, size)) if source is None else entries_of(source, folder)) for source in given]
    rows = []
    for number, row in enumerate(model.constraint, 1):
        coefficients = symbols.all_of([row.rows.get(name, 0) for name in coordinates.names])
        value = symbols.of(constraint_value(row, coordinates))
        rows.append(Row(row.name or f"constraint {number}", coefficients, LEVELS.index(row.level), value))
    return matrices, rows, [symbols.of(0)] * size


def _followed(initial: np.ndarray, scene: Scene, rows) -> np.ndarray:
    from ..exact.formulas.constrained import followed

    names, given = scene.equations.coordinates.names, scene.table.initial.rows
    found = initial.copy()
    for order, values in enumerate(initial):
        known = np.array([order < len(given) and name in given[order] for name in names])
        found[order] = followed(values, known, rows, order)
    return found


def _coefficients(scene: Scene, symbols: Symbols) -> ExactEquations:
    from ..exact.symbolic import SymbolicPolynomialMatrix

    coordinates, folder, name = scene.equations.coordinates, scene.path.parent, scene.path.name
    matrices = [symbols.all_of(entries_of(source, folder)) for source in scene.table.model.coefficients]
    A = SymbolicPolynomialMatrix(matrices, coordinates.names)
    initial = symbols.all_of(initial_entries(scene.table.initial, coordinates, A.degree, name))
    return ExactEquations(A, initial, exact_force(scene.table.force, coordinates, symbols, folder, name), coordinates.names)


def _state_space(scene: Scene, symbols: Symbols) -> ExactEquations:
    """[[s E - A, 0], [-C, I]] [x; y] = [B; D] u, as ``models.state_space_response`` has it in numbers."""
    from ..exact.symbolic import SymbolicPolynomialMatrix

    system, inputs = scene.equations.control.system, scene.equations.control.inputs
    E, A, B, C, D = _state_matrices(scene, symbols)
    n, q = len(A), len(C)
    constant, leading = (symbols.all_of(np.zeros((n + q, n + q))) for _ in range(2))
    constant[:n, :n], constant[n:, :n], constant[n:, n:] = -A, -C, symbols.all_of(np.eye(q))
    leading[:n, :n] = E
    names = (*system.states, *system.outputs)
    states = Coordinates(system.states, tuple(system.units[name] for name in system.states))
    start = symbols.all_of(state_entries(scene.table.initial.state, states, scene.path.name))
    u = exact_force(scene.table.force, inputs, symbols, scene.path.parent, scene.path.name, inputs=True)
    force = list(np.vstack([B, D]) @ np.array(u, dtype=object)) if u else [symbols.of(0)] * (n + q)
    initial = np.concatenate([start, C @ start])[None]
    outputs = {name: dict(zip(system.states, row)) for name, row in zip(system.outputs, C)}
    return ExactEquations(SymbolicPolynomialMatrix([constant, leading], names), initial, force, names, outputs)


def _state_matrices(scene: Scene, symbols: Symbols) -> list[np.ndarray]:
    """E, A, B, C, D; what is left out is as in the state space that was read."""
    model, system = scene.table.model, scene.equations.control.system
    keys = {"E": model.descriptor, "A": model.A, "B": model.B, "C": model.C, "D": model.D}
    found = {key: getattr(system, key) if source is None else entries_of(source, scene.path.parent) for key, source in keys.items()}
    return [symbols.all_of(matrix) for matrix in found.values()]


def _transfer_function(scene: Scene, symbols: Symbols) -> ExactEquations:
    """[[a(s), -b(s)], [0, 1]] [y; u] = [0; u]: from rest, b(d/dt) acts on u with its jumps."""
    from ..exact.formulas.signals import power_input
    from ..exact.symbolic import SymbolicPolynomialMatrix

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
    u = exact_force(scene.table.force, control.inputs, symbols, scene.path.parent, scene.path.name, inputs=True)[0]
    if model.gamma is not None:
        u = u + power_input(symbols.of(1), symbols.time, model.gamma)
    names = (control.outputs.names[0], control.inputs.names[0])
    initial = symbols.all_of(np.zeros((len(matrices) - 1, 2)))
    given = initial_entries(scene.table.initial, control.outputs, len(a) - 1, scene.path.name)
    initial[: len(given), 0] = symbols.all_of(given[:, 0][: len(initial)])
    return ExactEquations(SymbolicPolynomialMatrix(matrices, names), initial, [symbols.of(0), u], names[:1], {names[1]: {}})
