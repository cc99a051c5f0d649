"""The input of least energy from one state to another, in closed form by the controllability Gramian of the finite Jordan pair.

Of x' = the finite part of the equations, z' = J z + B E u with the directions E of the inputs, the states that an input adds at T are

    d = integral from 0 to T of e^{J (T - t)} B E u(t) dt,    W = integral from 0 to T of e^{J s} B E E^T B^T e^{J^T s} ds,

and of all inputs with W l = d, u(t) = E^T B^T e^{J^T (T - t)} l has the least integral of u^T u, l^T d. W is that of a step h so short
that e^{J h} is near 1, from one exponential (Van Loan), doubled: W(2 h) = W(h) + e^{J h} W(h) e^{J^T h}, a sum without cancellation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..control.state_equations import state_values
from ..control.state_space import StateSpace, StateSpaceResponse
from ..ground.checks import counted, listed, real_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError, Overflow, within_float64
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import CLEAR_KEPT, EPS, NOISE_SAFETY
from ..linalg.arrays import block_diag
from ..linalg.blocks import block_slices
from ..linalg.exponential import block_states
from ..polynomial.jordan_pairs import FinitePair
from ..signals.bohl import BohlFunction, Restarts
from ..signals.impulsive import ImpulsiveSmooth
from .boundary import ORDERS, values_by_order
from .channels import channels, chosen_by_name, coordinate_channels
from .motion import Motion
from .system import MechanicalSystem

#: The exponent by which a part of the input may grow between two knots, within the range of float64.
GROWTH_OF_PIECE = 300.0


@dataclass(frozen=True, repr=False, eq=False)
class LeastEnergyInput(Displayed):
    """The input of least energy, and the motion under it.

    ``u(t)`` gives the inputs at times, zero from T on.

    Attributes:
        signal: u with a row for each input, an ``ImpulsiveSmooth``.
        force: the same as ``system.solve`` takes it: forces on the n coordinates, of a state space all its inputs.
        inputs: names of the inputs.
        energy: the integral of u^T u, in the square of the unit of u times s.
        motion: the motion from the start under it (of a state space its response), at rest in the end state if that is an equilibrium.
        duration: T in s.
        error: the largest difference of that motion from the end state at T, relative to the largest displacement or velocity on the way.
        condition: the condition number of the scaled Gramian on the states that are reachable.
        eigenvalues: of the scaled Gramian, descending; that with a force on every coordinate has ones on its diagonal.
        notices: ill-conditioned states.
    """

    signal: ImpulsiveSmooth
    force: ImpulsiveSmooth
    inputs: tuple[str, ...]
    energy: float
    motion: Motion | StateSpaceResponse
    duration: float
    error: float
    condition: float
    eigenvalues: np.ndarray
    notices: tuple[Notice, ...]

    def _summary(self) -> str:
        return f"{', '.join(self.inputs)} over {self.duration:.6g} s, energy {self.energy:.6g}, error at the end {self.error:.2g}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __call__(self, times) -> np.ndarray:
        """u at a time (-> (m,)) or at times (T,) (-> (m, T))."""
        return self.signal(times)


def least_energy_input(
    system: MechanicalSystem | StateSpace,
    inputs: Sequence[str] | str | None = None,
    start=None,
    end=None,
    duration: float | None = None,
    force: ImpulsiveSmooth | None = None,
) -> LeastEnergyInput:
    """Return the input u of least energy, the integral of u^T u, that moves a system from one state to another in the time T.

        u(t) = E^T B^T e^{J^T (T - t)} W^-1 d

    with the finite Jordan pair (C, J, B), the directions E of the inputs, the controllability Gramian W and the states d that the motion
    without u lacks at T. With constraints, massless coordinates and singular descriptors J is that of the reduced dynamics. Forces of the system itself act on.
    The start are values at 0-, as everywhere; the end is the state at T, when the input has ended.

    Args:
        system: a ``MechanicalSystem`` of arrays, or a ``StateSpace``.
        inputs: names of coordinates (forces on them) or of inputs of the system; by default a force on every coordinate, or all inputs.
        start, end: the states: ``{"displacement": {"x1": 0.0}, "velocity": {...}}``, zero where nothing is given, each also as a vector;
            or displacements by name, ``{"x1": 1.0}``. Of a state space the states by name, or as a vector.
        duration: T in s.
        force: what acts as well, as ``system.solve`` takes it; zero by default.

    Returns:
        A ``LeastEnergyInput``: ``.signal``, ``.force``, ``.energy``, ``.motion``, ``.error``, ``.condition``.

    Raises:
        InputError: unknown names, an end state that violates constraints or that the inputs do not reach; the text names what is missing.
        Overflow: a motion grows over the duration beyond the range of float64.

    Sources: Kalman, Ho and Narendra, Contrib. Differ. Equ. 1 (1963) 189-213; Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404.

    >>> cart = MechanicalSystem([[1.0]], names=["cart"])
    >>> u = least_energy_input(cart, inputs=["cart"], end={"cart": 1.0}, duration=2.0)
    >>> bool(np.allclose(u([0.0, 1.0]), [[1.5, 0.0]])), round(u.energy, 12)  # 6 (1 - 2 t / T) / T^2 and 12 / T^3
    (True, 1.5)
    """
    if duration is None:
        raise InputError("duration: give the time T in s between start and end")
    T = real_number(duration, "duration", positive=True)
    plant = _plant(system, inputs, start, end, force)
    blocks = plant.pair.blocks
    with within_float64():
        if any(np.trace(block) / len(block) * T > GROWTH_OF_PIECE for block in blocks):
            raise Overflow(f"duration: motions grow over {T:g} s beyond the range of float64; choose a shorter one")
        reach = _reach(plant, T)
        lacking = _states(plant, plant.last - plant.values(plant.solve(None), T))
        amounts = reach.vectors.T @ (lacking / reach.scale)
        _refuse_unreachable(amounts, reach, plant)
        kept = amounts[: reach.rank] / reach.values[: reach.rank]
        signal = _signal(blocks, plant.driven, reach.vectors[:, : reach.rank] @ kept / reach.scale, T)
        force = signal.mapped(plant.places)
        motion = plant.solve(force)
        error = _error_at_end(plant, motion, T)
    energy, notices = float(amounts[: reach.rank] @ kept), tuple(reach.notices())
    return LeastEnergyInput(signal, force, plant.inputs, energy, motion, T, error, reach.condition, reach.values, notices)


# The plant: the finite part of the equations with the inputs, of a mechanical system or of a state space.


@dataclass(frozen=True, eq=False)
class _Plant:
    """The finite part z' = J z + B (f + D u) of a system, with its states at the start and at the end."""

    pair: FinitePair
    effect: np.ndarray  # B, of a unit on the right-hand side of each equation of motion, shape (k, r)
    driven: np.ndarray  # B D, shape (k, m)
    inputs: tuple[str, ...]  # names of u
    places: np.ndarray  # u as the system is excited by it, shape (p, m)
    last: np.ndarray  # x, and x' where the equations are of second order, at T, shape (1 or 2, n)
    names: tuple[str, ...]  # of the entries of last, as messages name them
    algebraic: str  # the equations that an end state may violate
    solve: Callable[[ImpulsiveSmooth | None], Motion | StateSpaceResponse]  # from the start

    def values(self, motion: Motion | StateSpaceResponse, times) -> np.ndarray:
        """x and its derivatives, as many as in ``last``."""
        return np.array([(motion.derivative(order) if order else motion)(times) for order in range(len(self.last))])

    @property
    def outputs(self) -> np.ndarray:
        """These values of each state, shape (1 n or 2 n, k)."""
        C = self.pair.C
        return np.vstack([C, C @ self.pair.J][: len(self.last)])


def _plant(system: MechanicalSystem | StateSpace, inputs, start, end, force) -> _Plant:
    if isinstance(system, StateSpace):
        return _state_space_plant(system, inputs, start, end, force)
    if not isinstance(system, MechanicalSystem):
        raise InputError(f"system: found {type(system).__name__}; expected a MechanicalSystem or a StateSpace")
    if system.is_sparse:
        raise InputError("system: the Gramian needs all modes; give the matrices of the system as arrays")
    chosen = chosen_by_name("inputs", inputs, channels(system, "inputs"), coordinate_channels(system))
    if rows := [channel.name for channel in chosen if channel.row is not None]:
        raise InputError(f'inputs: "{rows[0]}" is a constraint row; expected coordinates on which forces act')
    places = np.array([channel.direction for channel in chosen]).T
    first, last = _state(system, start, "start"), _state(system, end, "end")
    force, form = None if force is None else system._signal(force), system.constrained_form()
    with within_float64():
        pair = form.polynomial_matrix.jordan_pairs().finite
    on_rows = np.zeros((len(pair.C), system.size))
    on_rows[: form.null_space.shape[1]] = form.null_space.T
    effect = pair.B @ on_rows
    names = (*system.names, *(f"velocity of {name}" for name in system.names))
    return _Plant(
        pair,
        effect,
        effect @ places,
        tuple(channel.name for channel in chosen),
        places,
        last,
        names,
        "the constraints or the equations of massless coordinates",
        lambda u: system.solve(first[0], first[1], _sum(u, force)),
    )


def _state_space_plant(system: StateSpace, inputs, start, end, force) -> _Plant:
    if not (force is None or isinstance(force, ImpulsiveSmooth)):
        raise InputError(f"force: found {type(force).__name__}; expected an input, such as mb.step([1.0, 0.0])")
    known = dict(zip(system.inputs, range(len(system.inputs))))
    if not known:
        raise InputError("system: the state space has no inputs; give B")
    chosen = chosen_by_name("inputs", inputs, known, tuple(known.values()))
    first, last = (state_values(given, system.states, what) for what, given in (("start", start), ("end", end)))
    with within_float64():
        pair = system.polynomial_matrix().jordan_pairs().finite
    return _Plant(
        pair,
        pair.B,
        pair.B @ system.B[:, chosen],
        tuple(system.inputs[place] for place in chosen),
        np.eye(len(known))[:, chosen],
        last[None],
        system.states,
        "the algebraic equations",
        lambda u: system.solve(first, _sum(u, force)),
    )


def _sum(one: ImpulsiveSmooth | None, other: ImpulsiveSmooth | None) -> ImpulsiveSmooth | None:
    return one if other is None else other if one is None else one + other


def _state(system: MechanicalSystem, given, what: str) -> np.ndarray:
    """x and x', shape (2, n); zero where nothing is given."""
    values = np.zeros((2, system.size))
    for row, numbers in zip(values, values_by_order(given, system.names, ORDERS[:2], what).values()):
        for name, number in numbers.items():
            row[system.names.index(name)] = number
    return values


@dataclass(frozen=True, eq=False)
class _Reach:
    """The Gramian by its eigenvalues, in units of the states in which that with a force on every equation has ones on its diagonal."""

    scale: np.ndarray  # the units of the states, shape (k,)
    values: np.ndarray  # eigenvalues, descending
    vectors: np.ndarray  # a column each
    noise: float  # bound of rounding errors of an eigenvalue

    @property
    def rank(self) -> int:
        """The number of combinations of the states that the inputs reach."""
        return int((self.values > self.noise).sum())

    @property
    def condition(self) -> float:
        """The condition number on the states that are reachable."""
        return float(self.values[0] / self.values[self.rank - 1]) if self.rank else 1.0

    def notices(self) -> Iterator[Notice]:
        """The notice of a rank without a clear gap."""
        if self.rank and self.values[self.rank - 1] < CLEAR_KEPT * self.noise:
            text = (
                f"the Gramian is ill-conditioned: of its {counted(len(self.values), 'scaled eigenvalue')} {self.rank} count as reachable, "
                f"the smallest is {self.values[self.rank - 1]:.2g} with rounding errors of {self.noise:.2g}; a longer duration or more "
                "inputs condition it better"
            )
            yield Notice(NoticeKind.RANK, text, doubtful=True)


def _reach(plant: _Plant, T: float) -> _Reach:
    blocks, pair = plant.pair.blocks, plant.pair
    scale = np.sqrt(np.diag(gramian(blocks, plant.effect, T)))
    scale = np.where(scale > 0, scale, np.max(scale, initial=0.0) or 1.0)
    values, vectors = (one[..., ::-1] for one in np.linalg.eigh(gramian(blocks, plant.driven, T) / np.outer(scale, scale)))
    noise = NOISE_SAFETY * EPS * max(len(values), 1) * max(pair.coupling, 1.0) * max(values.max(initial=0.0), EPS)
    return _Reach(scale, values, vectors, noise)


def _error_at_end(plant: _Plant, motion: Motion | StateSpaceResponse, T: float) -> float:
    """The largest difference from the end state, relative to the largest value of its order on the way."""
    errors = np.abs(plant.values(motion, T) - plant.last).max(axis=1, initial=0.0)
    sizes = np.abs(plant.values(motion, np.linspace(0.0, T, 33))).max(axis=(1, 2), initial=0.0)
    return float(max(error / size if size else 0.0 for error, size in zip(errors, sizes)))


def gramian(blocks: Sequence[np.ndarray], driven: np.ndarray, T: float) -> np.ndarray:
    """The integral from 0 to T of e^{J s} D D^T e^{J^T s} ds, shape (n, n), for D of shape (n, m)."""
    n = len(driven)
    if not n:
        return np.zeros((0, 0))
    J = block_diag(*blocks)
    doublings = max(0, int(np.ceil(np.log2(max(2 * np.abs(J).sum(axis=1).max() * T, 1.0)))))
    h = T / 2.0**doublings
    power = scipy.linalg.expm(h * np.block([[-J, driven @ driven.T], [np.zeros((n, n)), J.T]]))
    total = power[n:, n:].T @ power[:n, n:]
    for _ in range(doublings):
        step = block_states(blocks, np.eye(n), np.full(n, h))
        total = total + step @ total @ step.T
        h *= 2
    return (total + total.T) / 2


def _states(plant: _Plant, missing: np.ndarray) -> np.ndarray:
    """The states of the finite pair with given values, or the error that names what violates the equations."""
    both, last, missing = plant.outputs, plant.last.ravel(), missing.ravel()
    sizes = np.abs(both).max(axis=1, initial=0.0)
    columns = np.abs(both).max(axis=0, initial=0.0)
    rows = np.where(sizes > 0, 1 / np.where(sizes > 0, sizes, 1.0), 1.0)
    scaled = rows[:, None] * both / np.where(columns > 0, columns, 1.0)
    right = rows * missing
    result = np.linalg.lstsq(scaled, right, rcond=None)[0] if len(columns) else np.zeros(0)
    off = np.abs(scaled @ result - right)
    size = np.abs(rows * last).max(initial=0.0) + np.abs(right).max(initial=0.0)
    if off.max(initial=0.0) > EPS**0.5 * size:
        place = int(off.argmax())
        word = "displacement of " if len(plant.last) > 1 and place < plant.last.shape[1] else ""
        raise InputError(
            f"end: the {word}{plant.names[place]} is {last[place]:.6g}, which violates {plant.algebraic} "
            f"by {(off[place] / rows[place]):.3g}; give an end state that satisfies them"
        )
    return result / np.where(columns > 0, columns, 1.0)


def _refuse_unreachable(amounts: np.ndarray, reach: _Reach, plant: _Plant) -> None:
    """Raise the error that names the combination of displacements and velocities which the inputs do not reach."""
    rank, values = reach.rank, reach.values
    rest = amounts[rank:]
    if np.abs(rest).max(initial=0.0) <= EPS**0.5 * np.abs(amounts).max(initial=0.0):
        return
    moved = plant.outputs @ ((reach.vectors * reach.scale[:, None])[:, rank:] @ rest)
    visible = np.abs(moved) > EPS**0.5 * np.abs(moved).max(initial=0.0)
    parts = [f"{number:.4g} in {name}" for number, name, shown in zip(moved, plant.names, visible) if shown]
    are = "is" if len(rest) == 1 else "are"
    next_kept = f", the smallest that is {values[rank - 1]:.2g}" if rank else ""
    raise InputError(
        f"end: the inputs {listed(plant.inputs)} do not reach this state: {counted(len(rest), 'combination')} of the "
        f"{counted(len(values), 'state')} {are} beyond them, and {listed(parts, 6)} would be missing (scaled eigenvalues of the Gramian: the largest not "
        f"counted {values[rank]:.2g}{next_kept}, rounding errors {reach.noise:.2g}); add an input, or choose an end state without that part"
    )


def _signal(blocks, driven: np.ndarray, weights: np.ndarray, T: float) -> ImpulsiveSmooth:
    """D^T e^{J^T (T - t)} l on [0, T), zero later, with knots where a part begins that grows from less than float64 can represent."""
    rates = np.array([-np.trace(block) / len(block) for block in blocks])
    begins = T - GROWTH_OF_PIECE / rates[rates * T > GROWTH_OF_PIECE]
    knots = np.unique(np.concatenate([[0.0], begins, [T]]))
    order = np.concatenate([[0], *(np.arange(at.start, at.stop)[::-1] for at in block_slices(blocks))]).astype(int)[1:]
    # the transpose of a quasi-triangular block is one again in reversed order
    backward = tuple(block.T[::-1, ::-1] for block in blocks)
    states = block_states(backward, weights[order], T - knots) if len(order) else np.zeros((0, len(knots)))
    jumps = np.zeros_like(states)
    jumps[:, 0], jumps[:, -1], states[:, -1] = states[:, 0], -states[:, -1], 0.0
    generators = tuple(-block for block in backward)
    return ImpulsiveSmooth(BohlFunction(driven.T[:, order], generators, Restarts(knots, states, jumps)))
