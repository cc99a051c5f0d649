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
#: 1e-13 where there is one, and stays above 1e-3 where there is none.
BALANCED = 1e-9

#: Loops are closed when they are open by less, in rad or relative to the robot's size: near a singular posture a gap hides a
#: posture that is off by its square root.
CLOSED = 1e-12

#: Where hardly any force acts, the residual is measured against those that this share of the longest step would cause: no
#: posture is known better than to rounding.
LEAST_WAY = 1e-4

#: Rows of loops count as dependent where what is new in them is below this share of the others: the axes of a URDF are often
#: rounded to five or six digits (1.5708), and loops that are planar to that are meant to be planar.
RANK = 1e-5

#: Between RANK and this rows are kept, and told to be almost dependent.
DOUBTFUL_RANK = 1e-4

#: Below this rows are dependent to rounding; between it and RANK to the rounding of what the URDF says, which is told.
EXACT_RANK = 1e-10

#: Loops that the joints keep open by less, in rad or relative to the robot's size, are closed for all that a URDF with five
#: digits says.
ROUNDED = 1e-5

#: Loops that stay open by less, in the same units, may do so because angles in the URDF have two digits: near a posture
#: where rows become dependent the gap is the square root of what these are off by.
TILTED = 0.05

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
        rounded: what to say of rounded angles where loops stay open by little, or an empty string.
    """

    tree: Tree
    load: Load
    free: np.ndarray
    rounded: str = ""

    def at(self, q: np.ndarray) -> Balance:
        """The balance of forces in a configuration."""
        return Balance(self.tree, self.load, q)

    def moved(self, balance: Balance, step: np.ndarray) -> Balance:
        """The balance at q (+) step, the step shortened where it is long."""
        furthest = np.abs(step / (LARGEST_STEP * self.load.lengths)).max(initial=0.0)
        return self.at(self.tree.moved(balance.configuration, step / max(1.0, furthest)))


@dataclass(frozen=True)
class Rows:
    """J of the free coordinates, in coordinates and rows that compare, as far as its rows say something new.

    Attributes:
        left, values, right: its singular vectors and values that count, shapes (m, r), (r,), (r, n).
        combinations: orthonormal combinations of rows that say nothing, one a column, shape (m, m - r).
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
        """r, how many rows say something new."""
        return len(self.values)

    @property
    def narrowest(self) -> float:
        """The smallest relative singular value that is not rounding, 1 where there is none."""
        return float(self.relative[self.relative > EXACT_RANK].min(initial=1.0))

    def shortest(self, gaps: np.ndarray) -> np.ndarray:
        """The shortest d with J d = gaps, as far as any d can."""
        return self.right.T @ (self.left.T @ gaps / self.values)

    def multipliers(self, force: np.ndarray) -> np.ndarray:
        """Those of least norm with J^T lambda = force, as far as any can."""
        return self.left @ (self.right @ force / self.values)

    def reached(self, gaps: np.ndarray) -> np.ndarray:
        """The part of gaps that motions can close."""
        return self.left @ (self.left.T @ gaps)


def rows_of(J: np.ndarray) -> Rows:
    """The rows of a matrix that say something new by more than RANK."""
    left, values, right = np.linalg.svd(J)
    relative = values / (values.max(initial=0.0) or 1.0)
    rank = int((relative > RANK).sum())
    return Rows(left[:, :rank], values[:rank], right[:rank], left[:, rank:], right[rank:].T, relative)


@dataclass(frozen=True)
class Equilibrium:
    """An equilibrium, or a step on the way to one.

    Attributes:
        balance: of forces, there.
        rows: of the loops.
        multipliers: lambda of all rows of all loops, those of least norm, shape (m,).
        residual: largest force that is left, relative to the largest that acts (both times what coordinates are measured in).
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
        """How far beyond what is allowed residual, gap and misfit are; at most 1 where it is an equilibrium."""
        return max(self.residual / BALANCED, self.gap / CLOSED, self.misfit / ROUNDED if self.misfit > ROUNDED else 0.0)


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
    """The equilibrium that Newton's method reaches from q, or where it reaches none, the one downhill from q.

    Raises:
        InputError: there is none near q.
    """
    start = _state(search, search.at(q))
    found = _followed(search, start, _newton_step)
    if found.badness > 1.0:  # near a saddle, or no stiffness where the force points
        found = _followed(search, _followed(search, start, _downhill_step), _newton_step)
    _check(found, search.rounded)
    return found


def _followed(search: Search, start: Equilibrium, step) -> Equilibrium:
    """The best of the states that steps lead to."""
    found, best, since = start, start, 0
    for _ in range(MOST_STEPS):
        found = _state(search, search.moved(found.balance, step(found, search.free)))
        since = 0 if found.badness < best.badness else since + 1
        best = best if since else found
        if best.badness == 0.0 or (since > 2 and best.badness <= 1.0):
            break
    return best


def _state(search: Search, balance: Balance) -> Equilibrium:
    """Multipliers that balance the forces as well as any can, and what is left."""
    free, load = search.free, balance.load
    lengths, rows = load.lengths[free], rows_of(balance.scaled_jacobian[:, free])
    multipliers = rows.multipliers(balance.force[free] * lengths) / load.row_lengths
    held = balance.jacobian.T @ multipliers
    left = (balance.force - held)[free] * lengths
    usual = [np.abs(K) @ (LEAST_WAY * LARGEST_STEP * load.lengths) for K in balance.stiffnesses]
    acting = max(np.abs(term[free] * lengths).max(initial=0.0) for term in (*balance.forces, held, *usual))
    residual = np.abs(left).max(initial=0.0) / acting if acting else 0.0
    gaps = balance.scaled_gaps
    gap, misfit = (float(np.abs(part).max(initial=0.0)) for part in (rows.reached(gaps), gaps))
    return Equilibrium(balance, rows, multipliers, float(residual), gap, misfit)


def _newton_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """[K, -J^T; J, 0] [d; lambda] = [-force; -phi], K with the stiffness of the loop forces, by the null space of J.

    Redundant rows and directions without stiffness do no harm: the shortest d is taken.
    """
    K, left, close = _linear(state, free)
    N = state.rows.motions
    along = N @ np.linalg.lstsq(N.T @ K @ N, -N.T @ (left + K @ close), rcond=FLAT)[0] if N.size else 0.0
    return _whole(close + along, state.balance.load, free)


def _downhill_step(state: Equilibrium, free: np.ndarray) -> np.ndarray:
    """Newton's step along the motion with every stiffness taken as positive, so that it lowers the energy, and to the loops."""
    K, left, close = _linear(state, free)
    N = state.rows.motions
    stiffness, ways = np.linalg.eigh(N.T @ (K + K.T) @ N / 2)
    stiffness, along = np.abs(stiffness), ways.T @ N.T @ left
    least = LEAST_STIFFNESS * (stiffness.max(initial=0.0) or np.abs(along).max(initial=0.0) or 1.0)
    return _whole(close - N @ ways @ (along / np.maximum(stiffness, least)), state.balance.load, free)


def _linear(state: Equilibrium, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the free coordinates, in units that compare: K, the forces that are left, and the shortest way onto the loops."""
    balance, load = state.balance, state.balance.load
    lengths = load.lengths[free]
    K = balance.stiffness(state.multipliers)[np.ix_(free, free)] * np.outer(lengths, lengths)
    left = (balance.force - balance.jacobian.T @ state.multipliers)[free] * lengths
    return K, left, -state.rows.shortest(balance.scaled_gaps)


def _whole(part: np.ndarray, load: Load, free: np.ndarray) -> np.ndarray:
    """A step of all coordinates (m, rad) from that of the free ones in units that compare."""
    step = np.zeros(len(free))
    step[free] = part * load.lengths[free]
    return step


def _check(state: Equilibrium, rounded: str) -> None:
    singular = (
        f"; near here the rows of the loops become dependent (relative singular value {state.rows.narrowest:.1e}): the posture is "
        "singular, choose one away from it"
        if state.rows.narrowest < DOUBTFUL_RANK
        else ""
    )
    if state.gap > CLOSED or state.misfit > ROUNDED:
        row, gap, unit = state.balance.widest_gap
        nearer = "; give a guess that is nearer, or look at the lengths of the links and the joints that are held"
        advice = f"; {rounded}" if rounded and state.misfit < TILTED else singular or nearer
        raise InputError(f"equilibrium: the loops do not close near the guess: {row} stays open by {gap:.3g} {unit}{advice}")
    if not state.residual <= BALANCED:
        advice = singular or "; give another guess, springs, forces, or joints to hold"
        raise InputError(
            f"equilibrium: there is none near the guess: {state.residual:.2g} of the largest force stays without balance after "
            f"{MOST_STEPS} steps of Newton's method{advice}"
        )
