"""Equilibria of a robot: Newton's method on the balance of forces with closed loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ground.errors import InputError
from ...ground.tolerances import (
    BALANCED,
    LOOP_RANK,
    LOOP_RANK_DOUBTFUL,
    LOOP_RANK_EXACT,
    LOOPS_CLOSED,
    LOOPS_CLOSED_AS_ROUNDED,
    LOOPS_TILTED,
    ZERO_STIFFNESS,
)
from ..kinematics import Tree
from .balance import Balance, Load

#: Largest step of a joint angle (rad), and of a displacement relative to the robot's size: the linear equations do not hold
#: beyond it.
LARGEST_STEP = 0.5

MOST_STEPS = 100

#: Steps without progress after which loops count as impossible to close.
MOST_FRUITLESS = 3

#: Steps in a search for an equilibrium that is given up: none of them is nearer to it, or halves the opening of the loops.
MOST_IN_VAIN = 40

#: Where almost no force acts, the residual is relative to the forces that this share of the longest step would cause, since
#: rounding errors limit every posture.
LEAST_STEP = 1e-4

#: Downhill, a stiffness below this share of the largest counts as this: the length of such a step is bounded anyway.
LEAST_STIFFNESS = 1e-6


@dataclass(frozen=True, eq=False)
class Search:
    """The data of the search for an equilibrium.

    Attributes:
        tree: the robot's joints.
        load: the loads and connections.
        free: which coordinates may move, shape (nv,).
        rounded: advice on rounded angles for loops that stay slightly open, or an empty string.
        names: names of the coordinates, for messages.
    """

    tree: Tree
    load: Load
    free: np.ndarray
    rounded: str = ""
    names: tuple[str, ...] = ()

    def at(self, q: np.ndarray) -> Balance:
        """The balance of forces in a configuration."""
        return Balance(self.tree, self.load, q)

    def moved(self, balance: Balance, step: np.ndarray) -> Balance:
        """The balance at q (+) step, with a long step shortened."""
        furthest = np.abs(step / (LARGEST_STEP * self.load.lengths)).max(initial=0.0)
        return self.at(self.tree.moved(balance.configuration, step / max(1.0, furthest)))


@dataclass(frozen=True, eq=False)
class Rows:
    """The independent rows of J for the free coordinates, in comparable units.

    Attributes:
        left, values, right: its singular vectors and values that count, shapes (m, r), (r,), (r, n).
        combinations: orthonormal combinations of rows that vanish, one a column, shape (m, m - r).
        motions: N, an orthonormal basis of its null space, shape (n, n - r).
        relative: all singular values over the largest, descending.
    """

    left: np.ndarray
    values: np.ndarray
    right: np.ndarray
    combinations: np.ndarray
    motions: np.ndarray
    relative: np.ndarray

    @property
    def rank(self) -> int:
        """The rank r, the number of independent rows."""
        return len(self.values)

    @property
    def narrowest(self) -> float:
        """The smallest relative singular value above rounding error, 1 where there is none."""
        return float(self.relative[self.relative > LOOP_RANK_EXACT].min(initial=1.0))

    def shortest(self, gaps: np.ndarray) -> np.ndarray:
        """The least-squares solution d of least norm of J d = gaps."""
        return self.right.T @ (self.left.T @ gaps / self.values)

    def multipliers(self, force: np.ndarray) -> np.ndarray:
        """The least-squares solution lambda of least norm of J^T lambda = force."""
        return self.left @ (self.right @ force / self.values)

    def reached(self, gaps: np.ndarray) -> np.ndarray:
        """The part of the gaps that motions can close."""
        return self.left @ (self.left.T @ gaps)


def rows_of(J: np.ndarray) -> Rows:
    """The rows of a matrix that are independent by more than LOOP_RANK."""
    left, values, right = np.linalg.svd(J)
    relative = values / (values.max(initial=0.0) or 1.0)
    rank = int((relative > LOOP_RANK).sum())
    return Rows(left[:, :rank], values[:rank], right[:rank], left[:, rank:], right[rank:].T, relative)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """An equilibrium, or a step on the way to one.

    Attributes:
        balance: of forces, there.
        rows: rows of the loops.
        multipliers: lambda of all rows of all loops, those of least norm, shape (m,).
        residual: largest unbalanced force relative to the largest force, both in comparable units.
        gap: largest opening of a loop that motions could close, in rad or relative to the robot's size.
        misfit: largest opening of a loop, in the same units, those included that the joints keep open.
    """

    balance: Balance
    rows: Rows
    multipliers: np.ndarray
    residual: float
    gap: float
    misfit: float

    @property
    def badness(self) -> float:
        """The largest ratio of residual, gap and misfit to its tolerance; at most 1 at an equilibrium."""
        return max(
            self.residual / BALANCED,
            self.gap / LOOPS_CLOSED,
            self.misfit / LOOPS_CLOSED_AS_ROUNDED if self.misfit > LOOPS_CLOSED_AS_ROUNDED else 0.0,
        )


def closed(search: Search, q: np.ndarray) -> Balance:
    """The balance where loops are closed as well as Gauss-Newton steps from q can, moving as little as possible."""
    balance = best = search.at(q)
    least, since = np.inf, 0
    for _ in range(MOST_STEPS):
        gap = np.abs(balance.scaled_gaps).max(initial=0.0)
        since = 0 if gap < least / 2 else since + 1
        if gap < least:
            best, least = balance, gap
        if gap == 0.0 or since > MOST_FRUITLESS:
            break
        shortest = rows_of(balance.scaled_jacobian[:, search.free]).shortest(balance.scaled_gaps)
        balance = search.moved(balance, _whole(-shortest, balance.load, search.free))
    return best


def equilibrium(search: Search, q: np.ndarray) -> Equilibrium:
    """The equilibrium that Newton's method reaches from q, or where it reaches none, the one downhill from q."""
    start = _state(search, search.at(q))
    state = _followed(search, start, _newton_step)
    if state.badness > 1.0:  # near a saddle, or no stiffness where the force points
        state = _followed(search, _followed(search, start, _downhill_step), _newton_step)
    _check(state, search)
    return state


def _followed(search: Search, start: Equilibrium, step) -> Equilibrium:
    """The best state of a sequence of steps, which ends when they fail."""
    state, best, since = start, start, 0
    least, is_open = start.misfit, 0
    for _ in range(MOST_STEPS):
        state = _state(search, search.moved(state.balance, step(state, search.free)))
        since = 0 if state.badness < best.badness else since + 1
        best = best if since else state
        closes = state.misfit <= max(least / 2, LOOPS_CLOSED_AS_ROUNDED)
        least, is_open = (min(least, state.misfit), 0) if closes else (least, is_open + 1)
        if best.badness == 0.0 or (since > 2 and best.badness <= 1.0) or max(is_open, since) >= MOST_IN_VAIN:
            break
    return best


def _state(search: Search, balance: Balance) -> Equilibrium:
    """The state with the multipliers that balance the forces best, and its residual."""
    free, load = search.free, balance.load
    lengths, rows = load.lengths[free], rows_of(balance.scaled_jacobian[:, free])
    multipliers = rows.multipliers(balance.force[free] * lengths) / load.row_lengths
    loop_force = balance.jacobian.T @ multipliers
    left = (balance.force - loop_force)[free] * lengths
    usual = [np.abs(K) @ (LEAST_STEP * LARGEST_STEP * load.lengths) for K in balance.stiffnesses]
    acting = max(np.abs(term[free] * lengths).max(initial=0.0) for term in (*balance.forces, loop_force, *usual))
    residual = np.abs(left).max(initial=0.0) / acting if acting else 0.0
    gaps = balance.scaled_gaps
    gap, misfit = (float(np.abs(part).max(initial=0.0)) for part in (rows.reached(gaps), gaps))
    return Equilibrium(balance, rows, multipliers, float(residual), gap, misfit)


def _newton_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """[K, -J^T; J, 0] [d; lambda] = [-force; -phi], K with the stiffness of the loop forces, by the null space of J.

    Redundant rows and directions without stiffness are harmless: d has the least norm.
    """
    K, left, close = _linear(state, free)
    N = state.rows.motions
    along = N @ np.linalg.lstsq(N.T @ K @ N, -N.T @ (left + K @ close), rcond=ZERO_STIFFNESS)[0] if N.size else 0.0
    return _whole(close + along, state.balance.load, free)


def _downhill_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """Newton's step with the absolute values of all stiffnesses along the motion, which lowers the energy, and onto the loops."""
    K, left, close = _linear(state, free)
    N = state.rows.motions
    stiffness, directions = np.linalg.eigh(N.T @ (K + K.T) @ N / 2)
    stiffness, along = np.abs(stiffness), directions.T @ N.T @ left
    least = LEAST_STIFFNESS * (stiffness.max(initial=0.0) or np.abs(along).max(initial=0.0) or 1.0)
    return _whole(close - N @ directions @ (along / np.maximum(stiffness, least)), state.balance.load, free)


def _linear(state: Equilibrium, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K, the unbalanced forces, and the shortest step onto the loops, for the free coordinates in comparable units."""
    balance, load = state.balance, state.balance.load
    lengths = load.lengths[free]
    K = balance.stiffness(state.multipliers)[np.ix_(free, free)] * np.outer(lengths, lengths)
    left = (balance.force - balance.jacobian.T @ state.multipliers)[free] * lengths
    return K, left, -state.rows.shortest(balance.scaled_gaps)


def _whole(part: np.ndarray, load: Load, free: np.ndarray) -> np.ndarray:
    """A step of all coordinates (m, rad) from one of the free coordinates in comparable units."""
    step = np.zeros(len(free))
    step[free] = part * load.lengths[free]
    return step


def _check(state: Equilibrium, search: Search) -> None:
    singular = (
        f"; near here the rows of the loops become dependent (relative singular value {state.rows.narrowest:.1e}): the posture is "
        "singular, choose one away from it"
        if state.rows.narrowest < LOOP_RANK_DOUBTFUL
        else ""
    )
    if state.gap > LOOPS_CLOSED or state.misfit > LOOPS_CLOSED_AS_ROUNDED:
        row, gap, unit = state.balance.widest_gap
        nearer = "; give a guess that is nearer, or check the lengths of the links and the fixed joints"
        advice = f"; {search.rounded}" if search.rounded and state.misfit < LOOPS_TILTED else singular or nearer
        raise InputError(f"equilibrium: the loops do not close near the guess: {row} stays open by {gap:.3g} {unit}{advice}")
    if not state.residual <= BALANCED:
        advice = singular or "; give another guess, springs, loops, forces, or joints to hold"
        raise InputError(
            f"equilibrium: there is none near the guess: {_unbalanced(state, search)} stay without balance, {state.residual:.2g} of the "
            f"largest force, and steps of Newton's method lead no nearer{advice}"
        )


def _unbalanced(state: Equilibrium, search: Search) -> str:
    """The coordinate with the largest unbalanced force in comparable units, and that force."""
    left = np.where(search.free, state.balance.force - state.balance.jacobian.T @ state.multipliers, 0.0)
    worst = int(np.abs(left * search.load.lengths).argmax())
    unit = "N m" if search.load.units[worst] == "rad" else "N"
    return f"{abs(left[worst]):.4g} {unit} on {search.names[worst]}"
