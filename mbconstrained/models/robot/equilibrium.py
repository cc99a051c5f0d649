"""Where a robot stays at rest: Newton's method on the balance of forces with closed loops."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .balance import Balance

#: A step is shortened so that no joint turns further than this (rad), and nothing moves further than this share of
#: the robot's size: the linear equations know nothing of what lies beyond.
LARGEST_STEP = 0.5

MOST_STEPS = 100

#: A residual this small, relative to the forces that balance, is that of an equilibrium: Newton's method reaches
#: 1e-13 where there is one, and stays above 1e-3 where there is none.
BALANCED = 1e-9

#: Where hardly any force acts, the residual is measured against those that this share of the longest step would cause: no
#: posture is known better than to rounding.
LEAST_WAY = 1e-4

#: Singular values below this share of the largest count as zero where a step, the multipliers or a rank are computed:
#: a posture is known to about 1e-13.
RANK = 1e-9

#: Downhill, a stiffness below this share of the largest counts as this: the length of such a step is bounded anyway.
LEAST_STIFFNESS = 1e-6


@dataclass(frozen=True)
class Search:
    """What is known while a posture is sought.

    Attributes:
        balance_at: the balance of forces by configuration.
        free: which coordinates may move, shape (nv,).
        size: of the robot (m).
        reach: how far each coordinate may go in one step (m, rad), shape (nv,).
    """

    balance_at: Callable[[np.ndarray], Balance]
    free: np.ndarray
    size: float
    reach: np.ndarray

    def moved(self, balance: Balance, step: np.ndarray) -> Balance:
        """The balance at q (+) step, the step shortened where it is long."""
        import pinocchio

        furthest = np.abs(step / self.reach).max(initial=0.0)
        return self.balance_at(pinocchio.integrate(balance.model, balance.configuration, step / max(1.0, furthest)))

    def badness(self, state: Equilibrium) -> float:
        """The residual or the gap relative to the size, whichever is larger."""
        return max(state.residual, state.gap / self.size)


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium, or a step on the way to one.

    Attributes:
        balance: of forces, there.
        multipliers: lambda of all rows of all loops, those of least norm, shape (m,).
        residual: largest force that is left, relative to the largest that acts, each over sqrt(M_ii).
        gap: largest opening of a loop (m, rad).
    """

    balance: Balance
    multipliers: np.ndarray
    residual: float
    gap: float


def closed(search: Search, q: np.ndarray, tolerance: float = 0.0) -> np.ndarray:
    """The configuration with closed loops that Gauss-Newton steps reach from q, moving as little as possible.

    Args:
        search: which coordinates may move.
        q: shape (nq,).
        tolerance: the opening of the loops, relative to the size of the robot, that is good enough.
    """
    balance = search.balance_at(q)
    best, least = q, np.inf
    for _ in range(MOST_STEPS):
        gap = np.abs(balance.gaps).max(initial=0.0)
        if gap < least:
            best, least = balance.configuration, gap
        elif least <= BALANCED * search.size:
            break
        if gap <= tolerance * search.size:
            break
        balance = search.moved(balance, _closing_step(balance, search.free))
    return best


def equilibrium(search: Search, q: np.ndarray) -> Equilibrium:
    """The equilibrium that Newton's method reaches from q, or where it reaches none, the one downhill from q.

    Raises:
        InputError: there is none near q.
    """
    start = _state(search, search.balance_at(q))
    found = _followed(search, start, _newton_step)
    if search.badness(found) > BALANCED:  # near a saddle, or no stiffness where the force points
        found = _followed(search, _followed(search, start, _downhill_step), _newton_step)
    _check(found, search.size)
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
        since = 0 if search.badness(found) < search.badness(best) else since + 1
        best = best if since else found
        if search.badness(best) == 0.0 or (since > 2 and search.badness(best) <= BALANCED):
            break
    return best


def _state(search: Search, balance: Balance) -> Equilibrium:
    """Multipliers that balance the forces as well as any can, and what is left."""
    free, scale = search.free, balance.sizes[search.free]
    multipliers = _least_squares((balance.jacobian[:, free] / scale).T, balance.force[free] / scale)
    held = balance.jacobian.T @ multipliers
    left = (balance.force - held)[free] / scale
    usual = [np.abs(K) @ (LEAST_WAY * search.reach) for K in balance.stiffnesses]
    acting = max(np.abs(term[free] / scale).max(initial=0.0) for term in (*balance.forces, held, *usual))
    residual = np.abs(left).max(initial=0.0) / acting if acting else 0.0
    return Equilibrium(balance, multipliers, float(residual), float(np.abs(balance.gaps).max(initial=0.0)))


def _newton_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """[K, -J^T; J, 0] [d; lambda] = [-force; -phi] in the sense of least squares, K with the stiffness of the loop forces.

    Redundant rows and directions without stiffness do no harm.
    """
    balance = state.balance
    K, J, scale = _scaled(state, free)
    unit = np.abs(K).max(initial=0.0) or 1.0
    matrix = np.block([[K / unit, -J.T], [J, np.zeros((len(J), len(J)))]])
    load = np.concatenate([-balance.force[free] / scale / unit, -balance.gaps])
    return _whole(_least_squares(matrix, load)[: len(scale)] / scale, free)


def _downhill_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """Newton's step along the motion with every stiffness taken as positive, so that it lowers the energy, and to the loops."""
    balance = state.balance
    K, J, scale = _scaled(state, free)
    N = null_space(J)
    left = N.T @ ((balance.force - balance.jacobian.T @ state.multipliers)[free] / scale)
    stiffness, ways = np.linalg.eigh(N.T @ (K + K.T) @ N / 2)
    stiffness = np.abs(stiffness)
    least = LEAST_STIFFNESS * (stiffness.max(initial=0.0) or np.abs(left).max(initial=0.0) or 1.0)
    along = N @ ways @ (-(ways.T @ left) / np.maximum(stiffness, least))
    return _whole(along / scale, free) + _closing_step(balance, free)


def _closing_step(balance: Balance, free: np.ndarray) -> np.ndarray:
    """J d = -phi, the shortest such d."""
    scale = balance.sizes[free]
    return _whole(_least_squares(balance.jacobian[:, free] / scale, -balance.gaps) / scale, free)


def _scaled(state: Equilibrium, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """K and J of the free coordinates, measured in units of 1 / sqrt(M_ii), and these sqrt(M_ii)."""
    balance = state.balance
    scale = balance.sizes[free]
    K = balance.stiffness(state.multipliers)[np.ix_(free, free)] / np.outer(scale, scale)
    return K, balance.jacobian[:, free] / scale, scale


def _whole(part: np.ndarray, free: np.ndarray) -> np.ndarray:
    """A step of all coordinates from that of the free ones."""
    step = np.zeros(len(free))
    step[free] = part
    return step


def _check(state: Equilibrium, size: float) -> None:
    load = state.balance.load
    if not state.gap <= BALANCED * size:
        worst = int(np.abs(state.balance.gaps).argmax())
        raise InputError(
            f"equilibrium: the loops do not close near the guess: {load.row_names[worst]} stays open by {state.gap:.3g} "
            f"{load.row_units[worst]}; give a guess that is nearer, or look at the lengths of the links and the joints that are held"
        )
    if not state.residual <= BALANCED:
        raise InputError(
            f"equilibrium: there is none near the guess: {state.residual:.2g} of the largest force stays without balance after "
            f"{MOST_STEPS} steps of Newton's method; give another guess, springs, forces, or joints to hold"
        )


def _least_squares(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(matrix, right, rcond=RANK)[0] if matrix.size else np.zeros(matrix.shape[1])
