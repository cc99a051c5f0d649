"""Where a robot stays at rest: Newton's method on the balance of forces with closed loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .balance import Balance, Load
from .tree import Tree

#: A step is shortened so that no joint turns further than this (rad), and nothing moves further than this share of
#: the robot's size: the linear equations know nothing of what lies beyond.
LARGEST_STEP = 0.5

MOST_STEPS = 100

#: Steps after which loops that do not come nearer will not close.
MOST_FRUITLESS = 3

#: A residual this small, relative to the forces that balance, is that of an equilibrium: Newton's method reaches
#: 1e-13 where there is one, and stays above 1e-3 where there is none. Loops count as closed likewise.
BALANCED = 1e-9

#: Where hardly any force acts, the residual is measured against those that this share of the longest step would cause: no
#: posture is known better than to rounding.
LEAST_WAY = 1e-4

#: Rows of loops count as dependent where what is new in them is below this share of the others: the axes of a URDF are often
#: rounded to five or six digits (1.5708), and loops that are planar to that are meant to be planar.
RANK = 1e-5

#: A stiffness below this share of the largest is none: rounding.
FLAT = 1e-13

#: Downhill, a stiffness below this share of the largest counts as this: the length of such a step is bounded anyway.
LEAST_STIFFNESS = 1e-6


@dataclass(frozen=True)
class Search:
    """What is known while a posture is sought.

    Attributes:
        tree: the robot's joints.
        load: what acts.
        free: which coordinates may move, shape (nv,).
    """

    tree: Tree
    load: Load
    free: np.ndarray

    def at(self, q: np.ndarray) -> Balance:
        """The balance of forces in a configuration."""
        return Balance(self.tree, self.load, q)

    def moved(self, balance: Balance, step: np.ndarray) -> Balance:
        """The balance at q (+) step, the step shortened where it is long."""
        furthest = np.abs(step / (LARGEST_STEP * self.load.lengths)).max(initial=0.0)
        return self.at(self.tree.moved(balance.configuration, step / max(1.0, furthest)))


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium, or a step on the way to one.

    Attributes:
        balance: of forces, there.
        multipliers: lambda of all rows of all loops, those of least norm, shape (m,).
        residual: largest force that is left, relative to the largest that acts (both times what coordinates are measured in).
        gap: largest opening of a loop, in rad or relative to the robot's size.
    """

    balance: Balance
    multipliers: np.ndarray
    residual: float
    gap: float

    @property
    def badness(self) -> float:
        """The residual or the gap, whichever is larger."""
        return max(self.residual, self.gap)


def closed(search: Search, q: np.ndarray, tolerance: float = 0.0) -> Balance:
    """The balance where loops are closed as well as Gauss-Newton steps from q can, moving as little as possible.

    Args:
        search: which coordinates may move.
        q: shape (nq,).
        tolerance: the opening of the loops, in rad or relative to the size of the robot, that is good enough.
    """
    balance = best = search.at(q)
    least, since = np.inf, 0
    for _ in range(MOST_STEPS):
        gap = opening(balance)
        since = 0 if gap < least / 2 else since + 1
        if gap < least:
            best, least = balance, gap
        if gap <= tolerance or since > MOST_FRUITLESS:
            break
        balance = search.moved(balance, _closing_step(balance, search.free))
    return best


def opening(balance: Balance) -> float:
    """The largest gap of a loop, in rad or relative to the size of the robot."""
    return float(np.abs(balance.gaps / balance.load.row_lengths).max(initial=0.0))


def equilibrium(search: Search, q: np.ndarray) -> Equilibrium:
    """The equilibrium that Newton's method reaches from q, or where it reaches none, the one downhill from q.

    Raises:
        InputError: there is none near q.
    """
    start = _state(search, search.at(q))
    found = _followed(search, start, _newton_step)
    if found.badness > BALANCED:  # near a saddle, or no stiffness where the force points
        found = _followed(search, _followed(search, start, _downhill_step), _newton_step)
    _check(found)
    return found


def null_space(J: np.ndarray) -> np.ndarray:
    """An orthonormal basis N of null(J), one vector a column."""
    _, values, right = np.linalg.svd(J)
    return right[int((values > RANK * values.max(initial=0.0)).sum()) :].T


def _followed(search: Search, start: Equilibrium, step) -> Equilibrium:
    """The best of the states that steps lead to."""
    found, best, since = start, start, 0
    for _ in range(MOST_STEPS):
        found = _state(search, search.moved(found.balance, step(found, search.free)))
        since = 0 if found.badness < best.badness else since + 1
        best = best if since else found
        if best.badness == 0.0 or (since > 2 and best.badness <= BALANCED):
            break
    return best


def _state(search: Search, balance: Balance) -> Equilibrium:
    """Multipliers that balance the forces as well as any can, and what is left."""
    free, lengths, row_lengths = search.free, balance.load.lengths[search.free], balance.load.row_lengths
    J = balance.jacobian / row_lengths[:, None]
    multipliers = _least_squares((J[:, free] * lengths).T, balance.force[free] * lengths)
    held = J.T @ multipliers
    left = (balance.force - held)[free] * lengths
    usual = [np.abs(K) @ (LEAST_WAY * LARGEST_STEP * balance.load.lengths) for K in balance.stiffnesses]
    acting = max(np.abs(term[free] * lengths).max(initial=0.0) for term in (*balance.forces, held, *usual))
    residual = np.abs(left).max(initial=0.0) / acting if acting else 0.0
    return Equilibrium(balance, multipliers / row_lengths, float(residual), opening(balance))


def _newton_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """[K, -J^T; J, 0] [d; lambda] = [-force; -phi], K with the stiffness of the loop forces, by the null space of J.

    Redundant rows and directions without stiffness do no harm: the shortest d is taken.
    """
    K, J, lengths = _scaled(state, free)
    N, close = null_space(J), _closing_step(state.balance, free)[free] / lengths
    left = N.T @ (_left(state)[free] * lengths + K @ close)
    along = N @ np.linalg.lstsq(N.T @ K @ N, -left, rcond=FLAT)[0] if N.size else 0.0
    return _whole((close + along) * lengths, free)


def _downhill_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """Newton's step along the motion with every stiffness taken as positive, so that it lowers the energy, and to the loops."""
    K, J, lengths = _scaled(state, free)
    N = null_space(J)
    left = N.T @ (_left(state)[free] * lengths)
    stiffness, ways = np.linalg.eigh(N.T @ (K + K.T) @ N / 2)
    stiffness = np.abs(stiffness)
    least = LEAST_STIFFNESS * (stiffness.max(initial=0.0) or np.abs(left).max(initial=0.0) or 1.0)
    along = N @ ways @ (-(ways.T @ left) / np.maximum(stiffness, least))
    return _whole(along * lengths, free) + _closing_step(state.balance, free)


def _left(state: Equilibrium) -> np.ndarray:
    """What of the forces the multipliers do not balance, shape (nv,)."""
    return state.balance.force - state.balance.jacobian.T @ state.multipliers


def _closing_step(balance: Balance, free: np.ndarray) -> np.ndarray:
    """J d = -phi, the shortest such d."""
    lengths, row_lengths = balance.load.lengths[free], balance.load.row_lengths
    J = balance.jacobian[:, free] * lengths / row_lengths[:, None]
    return _whole(_least_squares(J, -balance.gaps / row_lengths) * lengths, free)


def _scaled(state: Equilibrium, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K and J of the free coordinates in units that compare, and these units."""
    balance = state.balance
    lengths = balance.load.lengths[free]
    K = balance.stiffness(state.multipliers)[np.ix_(free, free)] * np.outer(lengths, lengths)
    return K, balance.jacobian[:, free] * lengths / balance.load.row_lengths[:, None], lengths


def _whole(part: np.ndarray, free: np.ndarray) -> np.ndarray:
    """A step of all coordinates from that of the free ones."""
    step = np.zeros(len(free))
    step[free] = part
    return step


def _check(state: Equilibrium) -> None:
    load, balance = state.balance.load, state.balance
    if not state.gap <= BALANCED:
        worst = int(np.abs(balance.gaps / load.row_lengths).argmax())
        raise InputError(
            f"equilibrium: the loops do not close near the guess: {load.row_names[worst]} stays open by "
            f"{abs(balance.gaps[worst]):.3g} {load.row_units[worst]}; give a guess that is nearer, or look at the lengths of the "
            "links and the joints that are held"
        )
    if not state.residual <= BALANCED:
        raise InputError(
            f"equilibrium: there is none near the guess: {state.residual:.2g} of the largest force stays without balance after "
            f"{MOST_STEPS} steps of Newton's method; give another guess, springs, forces, or joints to hold"
        )


def _least_squares(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix, right, rcond=RANK)[0] if matrix.size else np.zeros(matrix.shape[1])
