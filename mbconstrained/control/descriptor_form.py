"""Descriptor form of a mechanical system, and its matrices by name, for other programs; ``MechanicalSystem`` has both as methods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..ground.checks import nearest
from ..ground.coordinate_units import force_unit, rate_unit
from ..ground.errors import InputError
from ..mechanics.system import MechanicalSystem
from .state_space import StateSpace

#: What is said of a coordinate, in the names of states and outputs: x, x', x''.
RATES = ("", " velocity", " acceleration")


def to_state_space(
    system: MechanicalSystem, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None
) -> StateSpace:
    """E z' = A z + B u, y = C z + D u with the states z = (x, x', lambda), for analysis, control and other programs.

        x' = v,   M v' = -C v - K x + A^T lambda + f,   and the constraint rows A x = b, A v = b or A v' = b

    Entries of M, C, K and A are copied, nothing is eliminated or inverted: E is singular where there are constraint rows or massless
    coordinates. ``to_state_space(...).ordinary()`` eliminates, ``.to_scipy()``, ``.to_control()`` and ``.to_dict()`` convert further.
    Where an acceleration is an output, v' is a part of z, too.

    The static and other forces of the system, and the values b of its rows, are no inputs by themselves: the state space describes
    the deviations that the inputs cause.

    Args:
        system: of arrays.
        inputs: "force on NAME" of a coordinate or "value of ROW" of a constraint row (a support that moves); NAME or ROW alone where
            only one of them has it. By default the forces on all coordinates.
        outputs: "NAME" (displacement), "NAME velocity", "NAME acceleration" of a coordinate, or "ROW reaction", the multiplier of a
            constraint row. By default the displacements of all coordinates.

    Returns:
        The state space, with units of its states, inputs and outputs.

    Raises:
        InputError: an unknown name; the matrices are sparse.

    >>> spring = MechanicalSystem([[2.0]], damping=[[0.4]], stiffness=[[8.0]], names=["cart"])
    >>> space = spring.to_state_space(outputs=["cart", "cart acceleration"])
    >>> space.inputs, space.outputs
    (('force on cart',), ('cart', 'cart acceleration'))
    >>> space(2j)[0].round(6)  # 1/(8 - 2 w^2 + 0.4 i w) at w = 2 rad/s
    array([0.-1.25j])
    """
    A, rows, n = system.constraint_matrix, system.rows, system.size
    k, eye = len(rows), np.eye(n)
    named_inputs = _inputs(system, inputs)
    chosen = _outputs(system, outputs)
    with_acceleration = any(output.kind == "acceleration" for output in chosen)
    sizes = {"x": n, "v": n, "a": n * with_acceleration, "lambda": k}
    ends = np.cumsum(list(sizes.values()))
    parts = {name: slice(int(end) - size, int(end)) for (name, size), end in zip(sizes.items(), ends)}
    N = int(ends[-1])
    E, J, B = np.zeros((N, N)), np.zeros((N, N)), np.zeros((N, len(named_inputs)))
    x, v, a, multipliers = parts.values()
    E[x, x], J[x, v] = eye, eye
    motion = a if with_acceleration else v
    J[motion, x], J[motion, v], J[motion, multipliers] = -system.stiffness, -system.damping, A.T
    if with_acceleration:
        E[v, v], J[v, a], J[a, a] = eye, eye, -system.mass
    else:
        E[v, v] = system.mass
    for place, row in enumerate(rows):
        equation, level = multipliers.start + place, row.order
        if level == 2 and not with_acceleration:
            E[equation, v] = A[place]
        else:
            J[equation, (x, v, a)[level]] = -A[place]
    for column, (_, kind, place) in enumerate(named_inputs):
        B[(motion if kind == "force" else multipliers).start + place, column] = 1.0
    C = np.zeros((len(chosen), N))
    for line, output in enumerate(chosen):
        part = {"displacement": x, "velocity": v, "acceleration": a, "reaction": multipliers}[output.kind]
        C[line, part.start + output.place] = 1.0
    states = [f"state {name}{rate}" for rate in RATES[: 2 + with_acceleration] for name in system.names]
    states += [f"state {row.name} reaction" for row in rows]
    units = dict(zip(states, _state_units(system, 2 + with_acceleration)))
    units |= {one.name: one.unit(system) for one in (*named_inputs, *chosen)}
    input_names, output_names = [one.name for one in named_inputs], [one.name for one in chosen]
    return StateSpace(J, B, C, None, E, states, input_names, output_names, units)


def system_to_dict(system: MechanicalSystem) -> dict:
    """The matrices of M x'' + C x' + K x = f + A^T lambda, A x^(level) = b by name, as other programs need them.

    Args:
        system: of arrays or of sparse matrices, which stay sparse.

    Returns:
        M, C, K, A, static_force and b, with lists: levels of the rows of A, names and units of the coordinates. ``b`` is the constant
        part of the right-hand sides.

    >>> from mbconstrained import Constraint
    >>> pair = MechanicalSystem(np.eye(2), constraints=[Constraint([1, -1], value=0.5)], names=["a", "b"])
    >>> matrices = pair.to_dict()
    >>> matrices["A"].tolist(), matrices["b"].tolist(), matrices["levels"], matrices["names"]
    ([[1.0, -1.0]], [0.5], ['position'], ['a', 'b'])
    """
    if system.is_sparse:
        values = [constraint.values for constraint in system.constraints]
        b, levels = np.concatenate([*values, np.zeros(0)]), [c.level for c in system.constraints for _ in c.values]
    else:
        b, levels = np.array([row.value for row in system.rows]), [row.level for row in system.rows]
    matrices = {"M": system.mass, "C": system.damping, "K": system.stiffness, "A": system.constraint_matrix}
    copies = {name: matrix.copy() for name, matrix in matrices.items()}
    units = [system.units[name] for name in system.names]
    lists = {"levels": levels, "names": list(system.names), "units": units}
    return {**copies, "b": b, "static_force": system.static_force.copy(), **lists}


class _Channel(NamedTuple):
    """An input or output: the kind of quantity, and the place of its coordinate or row."""

    name: str
    kind: str
    place: int

    def unit(self, system: MechanicalSystem) -> str:
        """In SI."""
        if self.kind in ("value", "reaction"):
            row = system.rows[self.place]
            return rate_unit(row.unit, row.order) if self.kind == "value" else force_unit(row.unit)
        unit = system.units[system.names[self.place]]
        order = ("displacement", "velocity", "acceleration").index(self.kind) if self.kind != "force" else 0
        return force_unit(unit) if self.kind == "force" else rate_unit(unit, order)


def _inputs(system: MechanicalSystem, chosen) -> list[_Channel]:
    forces = {f"force on {name}": _Channel(f"force on {name}", "force", i) for i, name in enumerate(system.names)}
    values = {f"value of {row.name}": _Channel(f"value of {row.name}", "value", i) for i, row in enumerate(system.rows)}
    short = {row.name: values[f"value of {row.name}"] for row in system.rows}
    short |= {name: forces[f"force on {name}"] for name in system.names if name not in short}
    return _channels("inputs", chosen, {**short, **forces, **values}, list(forces.values()))


def _outputs(system: MechanicalSystem, chosen) -> list[_Channel]:
    names, rows = system.names, system.rows
    kinds = ("displacement", "velocity", "acceleration")
    known = {f"{row.name} reaction": _Channel(f"{row.name} reaction", "reaction", i) for i, row in enumerate(rows)}
    for kind, rate in reversed(list(zip(kinds, RATES))):
        known |= {f"{name}{rate}": _Channel(f"{name}{rate}", kind, i) for i, name in enumerate(names)}
    return _channels("outputs", chosen, known, [known[name] for name in names])


def _channels(what: str, chosen, known: dict[str, _Channel], default: list[_Channel]) -> list[_Channel]:
    if chosen is None:
        return default
    if isinstance(chosen, str) or not isinstance(chosen, Sequence):
        raise InputError(f"{what}: found {chosen!r}; expected a list of names, e.g. {[channel.name for channel in default[:1]]}")
    for name in chosen:
        if name not in known:
            hint = nearest(str(name), known)
            listed = ", ".join(f'"{channel}"' for channel in list(known)[-8:])
            raise InputError(f'{what}: there is no "{name}"{hint}; known are, among others, {listed}')
    return [known[name] for name in chosen]


def _state_units(system: MechanicalSystem, rates: int) -> list[str]:
    own = [rate_unit(system.units[name], order) for order in range(rates) for name in system.names]
    return own + [force_unit(row.unit) for row in system.rows]
