"""Descriptor form of a mechanical system, and its matrices by name, for other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..ground.units import force_unit, rate_unit
from .channels import Channel, channels, chosen_by_name, coordinate_channels, row_channels
from .equations import EquationsOfMotion

if TYPE_CHECKING:
    from ..control.discrete_time import DiscreteStateSpace
    from ..control.state_space import StateSpace

#: Suffixes of states and outputs of a coordinate: x, x', x''.
RATES = ("", " velocity", " acceleration")


def to_state_space(
    system: EquationsOfMotion, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None
) -> StateSpace:
    """E z' = A z + B u, y = C z + D u with the states z = (x, x', lambda), for analysis, control and other programs.

        x' = v,   M v' = -C v - K x + A^T lambda + f,   and the constraint rows A x = b, A v = b or A v' = b

    Entries of M, C, K and A are copied, nothing is eliminated or inverted: E is singular where there are constraint rows or massless
    coordinates. ``to_state_space(...).ordinary()`` eliminates, ``.to_scipy()``, ``.to_control()`` and ``.to_dict()`` convert further.
    Where an acceleration is an output, v' is a part of z, too.

    The static and other forces of the system, and the values b of its rows, are no inputs by themselves: the state space describes
    the deviations that the inputs cause.

    Args:
        system: system of arrays.
        inputs: "force on NAME" of a coordinate or "value of ROW" of a constraint row (a support that moves); NAME or ROW alone where
            only one of them has it. By default the forces on all coordinates.
        outputs: "NAME" (displacement), "NAME velocity", "NAME acceleration" of a coordinate, or "ROW reaction", the multiplier of a
            constraint row. By default the displacements of all coordinates.

    Returns:
        The state space, with units of its states, inputs and outputs.

    Raises:
        InputError: an unknown name; the matrices are sparse.

    >>> from mbconstrained import MechanicalSystem
    >>> spring = MechanicalSystem([[2.0]], damping=[[0.4]], stiffness=[[8.0]], names=["cart"])
    >>> space = spring.to_state_space(outputs=["cart", "cart acceleration"])
    >>> space.inputs, space.outputs
    (('force on cart',), ('cart', 'cart acceleration'))
    >>> space(2j)[0].round(6)  # 1/(8 - 2 w^2 + 0.4 i w) at w = 2 rad/s
    array([0.-1.25j])
    """
    system._refuse_delays("to_state_space")
    A, rows, n = system.constraint_matrix, system.rows, system.size
    k, eye = len(rows), np.eye(n)
    named_inputs = _inputs(system, inputs)
    chosen = _outputs(system, outputs)
    with_acceleration = any(output.kind == "2" for output in chosen)
    sizes = (n, n, n * with_acceleration, k)
    x, v, a, multipliers = (slice(end - size, end) for size, end in zip(sizes, np.cumsum(sizes).tolist()))
    N = sum(sizes)
    E, J, B = np.zeros((N, N)), np.zeros((N, N)), np.zeros((N, len(named_inputs)))
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
    for column, (_, _, channel) in enumerate(named_inputs):
        B[motion, column], B[multipliers, column] = np.split(channel.unknowns(system), [n])
    C = np.zeros((len(chosen), N))
    for line, (_, kind, channel) in enumerate(chosen):
        along, C[line, multipliers] = np.split(channel.unknowns(system), [n])
        if kind != "reaction":
            C[line, (x, v, a)[int(kind)]] = along
    states = [f"state {name}{rate}" for rate in RATES[: 2 + with_acceleration] for name in system.names]
    states += [f"state {row.name} reaction" for row in rows]
    unit_of_states = [rate_unit(system.units[name], order) for order in range(2 + with_acceleration) for name in system.names]
    units = dict(zip(states, [*unit_of_states, *(force_unit(row.unit) for row in rows)]))
    units |= {one.name: one.unit for one in (*named_inputs, *chosen)}
    input_names, output_names = [one.name for one in named_inputs], [one.name for one in chosen]
    from ..control.state_space import StateSpace

    return StateSpace(J, B, C, None, E, states, input_names, output_names, units)


def discretize(
    system: EquationsOfMotion,
    step: float,
    hold: int | str = 1,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    *,
    delays: Mapping[str, float] | None = None,
) -> DiscreteStateSpace:
    """Discretize the equations exactly: outputs at t = k step under a hold of the inputs between samples.

    ``system.to_state_space(inputs, outputs).discretize(step, hold)``; massless coordinates and constraints are no obstacle.

    Args:
        system: system of arrays.
        step: in s.
        hold: 0 for inputs that are constant between samples, 1 for linear ones, "impulse" for impulses at the samples.
        inputs, outputs: names as in ``to_state_space``; by default forces on and displacements of all coordinates.
        delays: delays of inputs in s, by the names of the inputs.

    Returns:
        A ``DiscreteStateSpace``.

    Raises:
        InputError: an unknown name, a step that is not positive, an output that would have Dirac impulses.

    >>> from mbconstrained import MechanicalSystem
    >>> cart = MechanicalSystem([[2.0]], names=["cart"]).discretize(0.5, hold=0)
    >>> cart.solve(input=[[4.0]]).output([0, 1, 2]).tolist()  # 4 N on 2 kg for half a second
    [[0.0, 0.25, 0.75]]
    """
    own: Any = system  # robots have points among their outputs
    return own.to_state_space(inputs, outputs).discretize(step, hold, delays=delays)


def system_to_dict(system: EquationsOfMotion) -> dict:
    """The matrices of M x'' + C x' + K x = f + A^T lambda, A x^(level) = b by name, for use by other programs.

    Args:
        system: system of arrays or of sparse matrices, which stay sparse.

    Returns:
        M, C, K, A, static_force and b, with lists: levels of the rows of A, names and units of the coordinates. ``b`` is the constant
        part of the right-hand sides.

    >>> from mbconstrained import Constraint, MechanicalSystem
    >>> pair = MechanicalSystem(np.eye(2), constraints=[Constraint([1, -1], value=0.5)], names=["a", "b"])
    >>> matrices = pair.to_dict()
    >>> matrices["A"].tolist(), matrices["b"].tolist(), matrices["levels"], matrices["names"]
    ([[1.0, -1.0]], [0.5], ['position'], ['a', 'b'])
    """
    system._refuse_delays("to_dict")
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


class _Port(NamedTuple):
    """A channel as an input or output, with its quantity."""

    name: str
    kind: str
    channel: Channel

    @property
    def unit(self) -> str:
        """Unit of the quantity in SI."""
        unit = self.channel.unit
        return force_unit(unit) if self.kind in ("force", "reaction") else rate_unit(unit, int(self.kind))


def _inputs(system: EquationsOfMotion, chosen) -> list[_Port]:
    known: dict[str, _Port | None] = {}
    for name, channel in channels(system, "inputs").items():
        known[name] = port = None if channel is None else _input(system, channel)
        if port is not None:
            known[port.name] = port
    forces = [_input(system, channel) for channel in coordinate_channels(system)]
    known |= {port.name: port for port in (*forces, *(_input(system, channel) for channel in row_channels(system)))}
    return chosen_by_name("inputs", chosen, known, forces)


def _input(system: EquationsOfMotion, channel: Channel) -> _Port:
    if channel.row is None:
        return _Port(f"force on {channel.name}", "force", channel)
    return _Port(f"value of {channel.name}", str(system.rows[channel.row].order), channel)


def _outputs(system: EquationsOfMotion, chosen) -> list[_Port]:
    moving = coordinate_channels(system)
    named = [one for one in channels(system, "outputs").values() if one is not None and one.row is None]
    known: dict[str, _Port | None] = {}
    for one in row_channels(system):
        known[f"{one.name} reaction"] = _Port(f"{one.name} reaction", "reaction", one)
    for order, rate in reversed(list(enumerate(RATES))):
        known |= {f"{one.name}{rate}": _Port(f"{one.name}{rate}", str(order), one) for one in (*moving, *named)}
    return chosen_by_name("outputs", chosen, known, [_Port(one.name, "0", one) for one in moving])
