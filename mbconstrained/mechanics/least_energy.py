"""The input of least energy from one state to another, in closed form by the controllability Gramian of the finite Jordan pair.

Of x' = the finite part of the equations, z' = J z + B E u with the directions E of the inputs, the states that an input adds at T are

    d = integral from 0 to T of e^{J (T - t)} B E u(t) dt,    W = integral from 0 to T of e^{J s} B E E^T B^T e^{J^T s} ds,

and of all inputs with W l = d, u(t) = E^T B^T e^{J^T (T - t)} l has the least integral of u^T u, l^T d. W is that of a step h so short
that e^{J h} is near 1, from one exponential (Van Loan), doubled: W(2 h) = W(h) + e^{J h} W(h) e^{J^T h}, a sum without cancellation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..ground.checks import counted, listed, real_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError, Overflow, within_float64
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import CLEAR_KEPT, EPS, NOISE_SAFETY
from ..linalg.blocks import block_slices
from ..linalg.exponential import block_states
from ..signals.bohl import BohlFunction, Restarts
from ..signals.impulsive import ImpulsiveSmooth
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
        force: the same on the n coordinates, as ``system.solve(force=...)`` takes it.
        inputs: names of the inputs.
        energy: the integral of u^T u, in the square of the unit of u times s.
        motion: the motion from the start under it, at rest in the end state if that is an equilibrium.
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
    motion: Motion
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
    system: MechanicalSystem, inputs: Sequence[str] | str | None = None, start=None, end=None, duration: float | None = None
) -> LeastEnergyInput:
    """Return the input u of least energy, the integral of u^T u, that moves a system from one state to another in the time T.

        u(t) = E^T B^T e^{J^T (T - t)} W^-1 d

    with the finite Jordan pair (C, J, B), the directions E of the inputs, the controllability Gramian W and the states d that the motion
    without u lacks at T. With constraints and massless coordinates J is that of the reduced dynamics. Forces of the system itself act on.
    The start are values at 0-, as everywhere; the end is the state at T, when the input has ended.

    Args:
        system: a ``MechanicalSystem`` of arrays.
        inputs: names of coordinates (forces on them) or of inputs of the system; by default a force on every coordinate.
        start, end: the states: ``{"displacement": {"x1": 0.0}, "velocity": {...}}``, zero where nothing is given, each also as a vector;
            or displacements by name, ``{"x1": 1.0}``.
        duration: T in s.

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
    if not isinstance(system, MechanicalSystem):
        raise InputError(f"system: found {type(system).__name__}; expected a MechanicalSystem")
    if system.is_sparse:
        raise InputError("system: the Gramian needs all modes; give the matrices of the system as arrays")
    if duration is None:
        raise InputError("duration: give the time T in s between start and end")
    T = real_number(duration, "duration", positive=True)
    known = channels(system, "inputs")
    chosen = chosen_by_name("inputs", inputs, known, coordinate_channels(system))
    if rows := [channel.name for channel in chosen if channel.row is not None]:
        raise InputError(f'inputs: "{rows[0]}" is a constraint row; expected coordinates on which forces act')
    directions = np.array([channel.direction for channel in chosen])
    first, last = _state(system, start, "start"), _state(system, end, "end")
    form = system.constrained_form()
    with within_float64():
        pair = form.polynomial_matrix.jordan_pairs().finite
        blocks = pair.blocks
        if any(np.trace(block) / len(block) * T > GROWTH_OF_PIECE for block in blocks):
            raise Overflow(f"duration: motions grow over {T:g} s beyond the range of float64; choose a shorter one")
        free = system.solve(first[0], first[1])
        missing = last - np.array([free.displacement(T), free.velocity(T)])
        states = _states(pair, missing, T, system, last)
        on_rows = np.zeros((len(pair.C), system.size))
        on_rows[: form.null_space.shape[1]] = form.null_space.T
        effect = pair.B @ on_rows  # of a force on each coordinate
        scale = np.sqrt(np.diag(gramian(blocks, effect, T)))
        scale = np.where(scale > 0, scale, np.max(scale, initial=0.0) or 1.0)
        driven = effect @ directions.T
        scaled = gramian(blocks, driven, T) / np.outer(scale, scale)
        values, vectors = (one[..., ::-1] for one in np.linalg.eigh(scaled))
        noise = NOISE_SAFETY * EPS * max(len(values), 1) * max(pair.coupling, 1.0) * max(values.max(initial=0.0), EPS)
        rank = int((values > noise).sum())
        amounts = vectors.T @ (states / scale)
        _refuse_unreachable(amounts, values, rank, vectors * scale[:, None], pair, system, chosen, noise)
        weights = vectors[:, :rank] @ (amounts[:rank] / values[:rank]) / scale
        energy = float((amounts[:rank] ** 2 / values[:rank]).sum())
        signal = _signal(blocks, driven, weights, T)
        force = signal.mapped(directions.T)
        motion = system.solve(first[0], first[1], force)
        reached = np.array([motion.displacement(T), motion.velocity(T)])
        between = np.linspace(0.0, T, 33)
        sizes = [np.abs(one(between)).max(initial=0.0) for one in (motion.displacement, motion.velocity)]
        errors = np.abs(reached - last).max(axis=1, initial=0.0)
    error = float(max((error / size if size else 0.0) for error, size in zip(errors, sizes)))
    condition = float(values[0] / values[rank - 1]) if rank else 1.0
    notices = []
    if rank and values[rank - 1] < CLEAR_KEPT * noise:
        text = (
            f"the Gramian is ill-conditioned: of its {counted(len(values), 'scaled eigenvalue')} {rank} count as reachable, the smallest is "
            f"{values[rank - 1]:.2g} with rounding errors of {noise:.2g}; a longer duration or more inputs condition it better"
        )
        notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    names = tuple(channel.name for channel in chosen)
    return LeastEnergyInput(signal, force, names, energy, motion, T, error, condition, values, tuple(notices))


def _state(system: MechanicalSystem, given, what: str) -> np.ndarray:
    """x and x', shape (2, n)."""
    words = ("displacement", "velocity")
    if given is None:
        return np.zeros((2, system.size))
    if not isinstance(given, dict):
        raise InputError(f'{what}: found {type(given).__name__}; expected {{"displacement": {{...}}, "velocity": {{...}}}}')
    nested = {word: given[word] for word in words if word in given and np.ndim(given[word]) + isinstance(given[word], dict)}
    direct = {name: value for name, value in given.items() if name not in nested}
    if direct and "displacement" in nested:
        raise InputError(f'{what}: give displacements by name or in the table "displacement", not both')
    try:
        return system._start(nested.get("displacement", direct), nested.get("velocity"))
    except InputError as problem:
        raise InputError(f"{what}: {problem}") from None


def gramian(blocks: Sequence[np.ndarray], driven: np.ndarray, T: float) -> np.ndarray:
    """The integral from 0 to T of e^{J s} D D^T e^{J^T s} ds, shape (n, n), for D of shape (n, m)."""
    n = len(driven)
    if not n:
        return np.zeros((0, 0))
    J = scipy.linalg.block_diag(*blocks)
    doublings = max(0, int(np.ceil(np.log2(max(2 * np.abs(J).sum(axis=1).max() * T, 1.0)))))
    h = T / 2.0**doublings
    power = scipy.linalg.expm(h * np.block([[-J, driven @ driven.T], [np.zeros((n, n)), J.T]]))
    total = power[n:, n:].T @ power[:n, n:]
    for _ in range(doublings):
        step = block_states(blocks, np.eye(n), np.full(n, h))
        total = total + step @ total @ step.T
        h *= 2
    return (total + total.T) / 2


def _states(pair, missing: np.ndarray, T: float, system, last) -> np.ndarray:
    """The states of the finite pair with given displacements and velocities, or the error that names what violates the equations."""
    n = len(pair.B)
    J = pair.J
    both = np.vstack([pair.C, pair.C @ J])
    sizes = np.abs(both).max(axis=1, initial=0.0)
    columns = np.abs(both).max(axis=0, initial=0.0)
    rows = np.where(sizes > 0, 1 / np.where(sizes > 0, sizes, 1.0), 1.0)
    scaled = rows[:, None] * both / np.where(columns > 0, columns, 1.0)
    right = rows * missing.ravel()
    result = np.linalg.lstsq(scaled, right, rcond=None)[0] if n else np.zeros(0)
    off = np.abs(scaled @ result - right)
    size = np.abs(rows * last.ravel()).max(initial=0.0) + np.abs(right).max(initial=0.0)
    if off.max(initial=0.0) > EPS**0.5 * size:
        place = int(off.argmax())
        name, word = system.names[place % system.size], ("displacement", "velocity")[place // system.size]
        raise InputError(
            f"end: the {word} of {name} is {last.ravel()[place]:.6g}, which violates the constraints or the equations of massless coordinates "
            f"by {(off[place] / rows[place]):.3g}; give an end state that satisfies them"
        )
    return result / np.where(columns > 0, columns, 1.0)


def _refuse_unreachable(amounts, values, rank, shapes, pair, system, chosen, noise) -> None:
    """Raise the error that names the combination of displacements and velocities which the inputs do not reach."""
    rest = amounts[rank:]
    if np.abs(rest).max(initial=0.0) <= EPS**0.5 * np.abs(amounts).max(initial=0.0):
        return
    lacking = shapes[:, rank:] @ rest
    moved = np.concatenate([pair.C @ lacking, pair.C @ pair.J @ lacking])
    words = [*system.names, *(f"velocity of {name}" for name in system.names)]
    visible = np.abs(moved) > EPS**0.5 * np.abs(moved).max(initial=0.0)
    parts = [f"{number:.4g} in {word}" for number, word, shown in zip(moved, words, visible) if shown]
    are = "is" if len(rest) == 1 else "are"
    next_kept = f", the smallest that is {values[rank - 1]:.2g}" if rank else ""
    raise InputError(
        f"end: the inputs {listed([channel.name for channel in chosen])} do not reach this state: {counted(len(rest), 'combination')} of the "
        f"{counted(len(values), 'state')} {are} beyond them, and {listed(parts, 6)} would be missing (scaled eigenvalues of the Gramian: the largest not "
        f"counted {values[rank]:.2g}{next_kept}, rounding errors {noise:.2g}); add an input, or choose an end state without that part"
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
