"""The balance of forces of a robot at rest, its equilibria, and their stiffness.

In one configuration

    g(q) + tau_springs(q) - tau_applied(q) = J^T lambda,   phi(q) = 0

with gravity g, the loops' rows phi and their multipliers lambda. The derivative of the left side, and that of the
right side at constant lambda (the geometric stiffness of the loop forces), are exact; nothing is differenced.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..ground.checks import listed, nearest
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    BALANCED,
    EPS,
    LOOP_RANK,
    LOOP_RANK_DOUBTFUL,
    LOOP_RANK_EXACT,
    LOOPS_CLOSED,
    LOOPS_CLOSED_AS_ROUNDED,
    LOOPS_TILTED,
    NOISE_SAFETY,
    SYMMETRIC_STIFFNESS,
    ZERO_STIFFNESS,
    noise_of,
)
from ..ground.units import force_unit
from .connections import AXES, Attached, AttachedTendon, BodySpring, Bushing, PointMotion, StretchedTendon
from .kinematics import Anchor, Kinematics, RelativePose, Tree, cross_matrix
from .robot_model import RobotModel
from .tangent import MimicRow, joint_displacements


@dataclass(frozen=True, eq=False)
class Load:
    """The loads and connections of a robot besides gravity."""

    # attached connections
    loops: tuple[Attached, ...]
    springs: tuple[Attached, ...]
    mimic_rows: tuple[MimicRow, ...]  # of joints that follow others; these rows come after those of the loops
    # by tangent coordinate, shape (nv,); only of joints with one degree of freedom
    joint_stiffness: np.ndarray
    joint_rest: np.ndarray
    joint_force: np.ndarray  # constant forces and torques of the joints, shape (nv,)
    point_forces: Mapping[PointMotion, tuple[Anchor, float]]  # motions of points, with the force or torque along each
    units: tuple[str, ...]  # "m" or "rad" for each coordinate
    size: float  # a characteristic length of the robot (m)
    tendons: tuple[AttachedTendon, ...] = ()  # attached tendons

    @cached_property
    def lengths(self) -> np.ndarray:
        """Units that make coordinates comparable: the robot's size (m) for displacements, 1 for angles; shape (nv,)."""
        return np.where(np.array(self.units) == "m", self.size, 1.0)

    @cached_property
    def row_lengths(self) -> np.ndarray:
        """Units of the rows of loops, shape (m,)."""
        return np.where(np.array(self.row_units) == "m", self.size, 1.0)

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows of all loops and mimic_rows."""
        return (*(name for item in self.loops for name in item.connection.row_names), *(item.name for item in self.mimic_rows))

    @cached_property
    def row_units(self) -> tuple[str, ...]:
        """ "m" or "rad" for each of them."""
        return (*(unit for item in self.loops for unit in item.connection.row_units), *(item.unit for item in self.mimic_rows))

    @property
    def has_rows(self) -> bool:
        """Whether there are rows of loops or mimic joints."""
        return bool(self.loops or self.mimic_rows)


class Balance:
    """Forces and their derivatives by the nv tangent coordinates, in one configuration q."""

    def __init__(self, tree: Tree, load: Load, configuration: np.ndarray):
        self.tree, self.load = tree, load
        self.configuration = configuration
        self.kinematics = Kinematics(tree, configuration)

    @cached_property
    def gravity(self) -> np.ndarray:
        """g, shape (nv,)."""
        return self.tree.gravity(self.configuration)

    @cached_property
    def forces(self) -> tuple[np.ndarray, ...]:
        """The terms of the left side, each of shape (nv,)."""
        springs = [*(element.force for element in self.elastic), *(tendon.force for tendon in self.tendons)]
        applied = [-value * row for row, value in self._rows]
        return (self.gravity, self.load.joint_stiffness * self.joint_stretch, *springs, -self.load.joint_force, *applied)

    @property
    def force(self) -> np.ndarray:
        """The left side, shape (nv,)."""
        return np.sum(self.forces, axis=0)

    @cached_property
    def stiffnesses(self) -> tuple[np.ndarray, ...]:
        """The derivatives of the forces, each of shape (nv, nv)."""
        springs = [element.stiffness for element in self.elastic]
        applied = [-value * self._row_change(motion, anchor) for motion, (anchor, value) in self.load.point_forces.items()]
        gravity = self.tree.gravity_stiffness(self.configuration)
        tendons = [tendon.stiffness for tendon in self.tendons]
        return (gravity, np.diag(self.load.joint_stiffness), *springs, *applied, *tendons)

    @cached_property
    def elastic(self) -> list[Elastic]:
        """Contributions of the springs and bushings."""
        return [elastic(item.connection, item.pose(self.kinematics), item.rest_length) for item in self.load.springs]

    @cached_property
    def tendons(self) -> list[StretchedTendon]:
        """Contributions of the tendons."""
        return [StretchedTendon(item, self.kinematics) for item in self.load.tendons]

    @property
    def dampings(self) -> list[np.ndarray]:
        """D of each spring, bushing and tendon, shape (nv, nv)."""
        return [*(item.damping for item in self.elastic), *(item.damping for item in self.tendons)]

    @cached_property
    def _poses(self):
        return [(item, item.pose(self.kinematics)) for item in self.load.loops]

    @cached_property
    def gaps(self) -> np.ndarray:
        """phi, the rows of all loops and mimic_rows (m, rad), shape (m,)."""
        mimicked = [item.gap(self.tree.model, self.configuration) for item in self.load.mimic_rows]
        return np.concatenate([*(item.connection.gaps(pose.value, item.rest_length) for item, pose in self._poses), mimicked])

    @cached_property
    def loops(self) -> list[tuple[Attached, RelativePose, np.ndarray, slice]]:
        """Each loop with its pose, the derivative of its rows by phi, shape (k, 6), and the places of these rows among all."""
        loops, stop = [], 0
        for item, pose in self._poses:
            gradient = item.connection.gradient(pose.value)
            loops.append((item, pose, gradient, slice(stop, stop := stop + len(gradient))))
        return loops

    @cached_property
    def jacobian(self) -> np.ndarray:
        """J = d phi / dq, shape (m, nv)."""
        closing = [gradient @ pose.jacobian for _, pose, gradient, _ in self.loops]
        return np.vstack(
            [np.zeros((0, self.tree.model.nv)), *closing, *(item.row(self.tree.model) for item in self.load.mimic_rows)]
        )

    @cached_property
    def scaled_gaps(self) -> np.ndarray:
        """phi in rad or relative to the robot's size, so that rows are comparable, shape (m,)."""
        return self.gaps / self.load.row_lengths

    @cached_property
    def scaled_jacobian(self) -> np.ndarray:
        """J in comparable coordinates and rows, shape (m, nv)."""
        return self.jacobian * self.load.lengths / self.load.row_lengths[:, None]

    @property
    def widest_gap(self) -> tuple[str, float, str]:
        """Name of the row with the largest gap, the gap (m, rad), and the unit."""
        worst = int(np.abs(self.scaled_gaps).argmax())
        return self.load.row_names[worst], abs(self.gaps[worst]), self.load.row_units[worst]

    def geometric(self, multipliers: np.ndarray) -> tuple[np.ndarray, ...]:
        """d(J^T lambda)/dq at constant lambda, a matrix (nv, nv) for each loop."""
        parts = []
        for item, pose, gradient, places in self.loops:
            own = multipliers[places]
            curvature = item.connection.curvature(pose.value, own)
            parts.append(pose.hessian(gradient.T @ own) + (pose.jacobian.T @ curvature @ pose.jacobian if curvature.any() else 0.0))
        return tuple(parts)

    def stiffness(self, multipliers: np.ndarray) -> np.ndarray:
        """The derivative of the left side less that of the right, shape (nv, nv)."""
        return np.sum(self.stiffnesses, axis=0) - np.sum(self.geometric(multipliers), axis=0)

    @cached_property
    def mass(self) -> np.ndarray:
        """M, shape (nv, nv), rotors not included."""
        return sum((tendon.inertia for tendon in self.tendons), self.tree.mass(self.configuration))

    @cached_property
    def sizes(self) -> np.ndarray:
        """sqrt(M_ii): in coordinates times these, metres and radians of any body count alike; shape (nv,)."""
        diagonal = np.sqrt(np.maximum(np.diag(self.mass), 0.0))  # negative moments of inertia are possible
        least = diagonal[diagonal > 0].min(initial=np.inf)
        return np.where(diagonal > 0, diagonal, least if np.isfinite(least) else 1.0)

    @cached_property
    def entry_sizes(self) -> np.ndarray:
        """sqrt(M_ii M_jj): the scale of the entries of M, D and K, shape (nv, nv)."""
        return np.outer(self.sizes, self.sizes)

    def row(self, motion: PointMotion, anchor: Anchor) -> np.ndarray:
        """The rate of the motion of a point, which is at an anchor, by that of each coordinate, shape (nv,)."""
        if motion.turn:
            return np.array(motion.along) @ self.kinematics.velocity(anchor.joint)[3:]
        return np.array(motion.along) @ self.kinematics.of_point(anchor.joint, self.kinematics.frame(anchor)[1])

    @cached_property
    def _rows(self):
        return [(self.row(motion, anchor), value) for motion, (anchor, value) in self.load.point_forces.items()]

    def _row_change(self, motion: PointMotion, anchor: Anchor) -> np.ndarray:
        """d(row^T) / dq, shape (nv, nv), of a force or torque that keeps its direction."""
        along, point = np.array(motion.along), self.kinematics.frame(anchor)[1]
        if motion.turn:
            return self.kinematics.turning(anchor.joint, np.concatenate([np.zeros(3), along]))
        arm = np.cross(self.kinematics.of_point(anchor.joint, point), along, axis=0)
        kept = self.kinematics.turning(anchor.joint, np.concatenate([along, np.cross(point, along)]))
        return kept + self.kinematics.velocity(anchor.joint)[3:].T @ arm

    @cached_property
    def joint_stretch(self) -> np.ndarray:
        """The displacement of each joint from its rest, for a continuous one modulo a full turn, shape (nv,)."""
        return joint_displacements(self.tree.model, self.configuration, self.load.joint_rest)


@dataclass(frozen=True, eq=False)
class Elastic:
    """The contributions of an element with the energy U(phi) to the equations in one configuration."""

    pose: RelativePose  # phi with its derivatives by the coordinates
    slope: np.ndarray  # dU/dphi, shape (6,)
    curvature: np.ndarray  # U'', shape (6, 6)
    damper: np.ndarray  # D, shape (6, 6)

    @property
    def wrench(self) -> np.ndarray:
        """-dU/dphi, the force and torque on body2 in the frame on body1, shape (6,)."""
        return -self.slope

    @cached_property
    def force(self) -> np.ndarray:
        """dU/dq = J^T dU/dphi, shape (nv,)."""
        return self.pose.jacobian.T @ self.slope

    @cached_property
    def stiffness(self) -> np.ndarray:
        """d force / dq = J^T U'' J + the second derivative of phi in the direction dU/dphi, shape (nv, nv)."""
        return self.pose.jacobian.T @ self.curvature @ self.pose.jacobian + self.pose.hessian(self.slope)

    @cached_property
    def damping(self) -> np.ndarray:
        """J^T D J, shape (nv, nv)."""
        return self.pose.jacobian.T @ self.damper @ self.pose.jacobian


def elastic(element: BodySpring | Bushing, pose: RelativePose, rest_length: float) -> Elastic:
    """The contributions of an element whose frames have this relative pose."""
    is_spring = isinstance(element, BodySpring)
    return Elastic(pose, *(_spring(element, pose.value, rest_length) if is_spring else _bushing(element, pose.value)))


def _spring(spring: BodySpring, phi: np.ndarray, rest_length: float):
    """U = k (|p| - l0)^2 / 2: tension along p, and across it the tension over the length."""
    length, slope, curvature, damping = np.linalg.norm(phi[:3]), np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6))
    if not length and (rest_length or spring.damping):
        raise InputError(f"{spring.label}: both its ends are at the same place, so that it has no direction; move one of them")
    tension = spring.stiffness * (length - rest_length)
    across = spring.stiffness if not rest_length else tension / length
    along = np.outer(phi[:3], phi[:3]) / length**2 if length else np.eye(3)
    slope[:3] = across * phi[:3]
    curvature[:3, :3] = spring.stiffness * along + across * (np.eye(3) - along)
    damping[:3, :3] = spring.damping * along
    return slope, curvature, damping


def _bushing(bushing: Bushing, phi: np.ndarray):
    """U = phi^T K phi / 2."""
    K = np.array([*bushing.stiffness, *bushing.turning_stiffness])
    return K * phi, np.diag(K), np.diag([*bushing.damping, *bushing.turning_damping])


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
    """The data of the search for an equilibrium."""

    tree: Tree  # the robot's joints
    load: Load  # the loads and connections
    free: np.ndarray  # which coordinates may move, shape (nv,)
    rounded: str = ""  # advice on rounded angles for loops that stay slightly open, or an empty string
    names: tuple[str, ...] = ()  # names of the coordinates, for messages

    def at(self, q: np.ndarray) -> Balance:
        """The balance of forces in a configuration."""
        return Balance(self.tree, self.load, q)

    def moved(self, balance: Balance, step: np.ndarray) -> Balance:
        """The balance at q (+) step, with a long step shortened."""
        furthest = np.abs(step / (LARGEST_STEP * self.load.lengths)).max(initial=0.0)
        return self.at(self.tree.moved(balance.configuration, step / max(1.0, furthest)))


@dataclass(frozen=True, eq=False)
class Rows:
    """The independent rows of J for the free coordinates, in comparable units."""

    # its singular vectors and values that count, shapes (m, r), (r,), (r, n)
    left: np.ndarray
    values: np.ndarray
    right: np.ndarray
    combinations: np.ndarray  # orthonormal combinations of rows that vanish, one a column, shape (m, m - r)
    motions: np.ndarray  # N, an orthonormal basis of its null space, shape (n, n - r)
    relative: np.ndarray  # all singular values over the largest, descending

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
    """An equilibrium, or a step on the way to one."""

    balance: Balance  # of forces, there
    rows: Rows  # rows of the loops
    multipliers: np.ndarray  # lambda of all rows of all loops, those of least norm, shape (m,)
    residual: float  # largest unbalanced force relative to the largest force, both in comparable units
    gap: float  # largest opening of a loop that motions could close, in rad or relative to the robot's size
    misfit: float  # largest opening of a loop, in the same units, those included that the joints keep open

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
        left = np.where(search.free, state.balance.force - state.balance.jacobian.T @ state.multipliers, 0.0)
        worst = int(np.abs(left * search.load.lengths).argmax())  # in comparable units
        force = f"{abs(left[worst]):.4g} {force_unit(search.load.units[worst])} on {search.names[worst]}"
        advice = singular or "; give another guess, springs, loops, forces, or joints to hold"
        raise InputError(
            f"equilibrium: there is none near the guess: {force} stay without balance, {state.residual:.2g} of the largest force, and "
            f"steps of Newton's method lead no nearer{advice}"
        )


@dataclass(frozen=True, repr=False, eq=False)
class Posture(Displayed):
    """An equilibrium of a robot.

    Attributes:
        robot: the robot.
        configuration: q, shape (nq,).
        joints: configuration by joint: a number (rad, m), or the numbers of a joint with several degrees of freedom.
        multipliers: of the rows of all loops and mimic joints, of least norm where they are not determined (torques over the
            size of the robot), shape (m,) (N, N m).
        reactions: by loop, spring and bushing: force (N) and torque (N m) on its second body, in the frame on the first, shape (6,).
        torques: by joint that keeps the guess: the load that keeps it in place, besides springs with a rest (N m, N).
        residual: largest unbalanced force relative to the largest force.
        loop_error: largest opening of a loop (m, rad).
        notices: notices on redundant rows, and on parts of the description that were left out.
    """

    robot: RobotModel
    configuration: np.ndarray
    multipliers: np.ndarray
    torques: dict[str, float]
    residual: float
    loop_error: float
    notices: tuple[Notice, ...]
    balance: Balance = field(repr=False)
    independent_rows: tuple[int, ...] = ()

    @property
    def joints(self) -> dict[str, float | tuple[float, ...]]:
        """Values by joint."""
        return self.robot.tangent.values(self.configuration)

    @property
    def loops(self) -> tuple[Attached, ...]:
        """The loops with their frames."""
        return self.balance.load.loops

    @property
    def reactions(self) -> dict[str, np.ndarray]:
        """Force and torque of each loop, spring and bushing."""
        loops = {item.connection.name: G.T @ self.multipliers[places] for item, _, G, places in self.balance.loops}
        springs = zip(self.balance.load.springs, self.balance.elastic)
        return loops | {item.connection.name: own.wrench for item, own in springs}

    @property
    def ground_reactions(self) -> dict[str, np.ndarray]:
        """Reactions in the directions of the ground, about the same point, shape (6,) (N, N m)."""
        items = {item.connection.name: item for item in (*self.loops, *self.balance.load.springs)}
        return {name: items[name].pose(self.balance.kinematics).directions @ own for name, own in self.reactions.items()}

    def __getitem__(self, joint: str):
        if joint not in self.joints:
            raise InputError(f'posture: there is no joint "{joint}"{nearest(str(joint), self.joints)}')
        return self.joints[joint]

    def _summary(self) -> str:
        values = ", ".join(f"{name}: {value:.6g}" for name, value in self.joints.items() if isinstance(value, float))
        return f"{values}; residual {self.residual:.1e}, loops open by {self.loop_error:.1e}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((name, ", ".join(f"{part:.6g}" for part in np.atleast_1d(value))) for name, value in self.joints.items())
        return TextTable("Joints", ("joint", "value (rad, m)"), tuple(rows)), notice_table(self.notices)


#: Rounding of an entry that is computed through a chain of joints, a rotation at each, relative to the largest of its kind.
COMPUTED = 16 * EPS


def stiffness_parts(posture: Posture) -> list[tuple[str, np.ndarray]]:
    """The contributions to K: springs of joints, springs between bodies, gravity and forces."""
    robot, balance = posture.robot, posture.balance
    gravity, joints, *others = balance.stiffnesses
    first, last = len(balance.elastic), len(others) - len(balance.tendons)
    springs, applied, tendons = others[:first], others[first:last], others[last:]
    sizes = balance.entry_sizes
    rest = np.sum([cleaned(part, sizes) for part in (gravity, *applied)], axis=0)
    rest = rest - sum(cleaned(part, sizes) for part in balance.geometric(posture.multipliers)) + _of_loads(posture)
    parts = [(f"spring of {name}", np.diag(row)) for name, row, k in zip(robot.coordinates, joints, robot.joint_stiffness) if k]
    gains = zip(robot.coordinates, np.diag(robot.position_gains), robot.position_gains)
    parts += [(f"control of {name}", np.diag(row)) for name, row, k in gains if k]
    parts += [(item.connection.name, cleaned(part, sizes)) for item, part in zip(balance.load.springs, springs)]
    parts += [(item.tendon.name, cleaned(part, sizes)) for item, part in zip(balance.load.tendons, tendons)]
    return [*parts, ("gravity and forces", rest)]


def _of_loads(posture: Posture) -> np.ndarray:
    """Stiffness of the loads that keep joints with several degrees of freedom in place, with potential -F . p - T . theta.

    A force F keeps its direction while the body turns, and T belongs to the rotation vector theta from the posture (semitangential):
    along the axes of the body they change by F x theta and T x theta / 2.
    """
    robot, K = posture.robot, np.zeros((len(posture.robot.coordinates),) * 2)
    for joint in robot.joints:
        own = robot.tangent.coordinates_of(joint)
        if len(own) == 1:
            continue
        places = [robot.coordinates.index(name) for name in own]
        axes = [AXES.index(name.removeprefix(f"{joint} ")) for name in own]
        wrench, change = np.zeros(6), np.zeros((6, 6))
        wrench[axes] = [posture.torques.get(name, 0.0) for name in own]
        change[:3, 3:], change[3:, 3:] = cross_matrix(wrench[:3]), cross_matrix(wrench[3:]) / 2
        K[np.ix_(places, places)] = -change[np.ix_(axes, axes)]
    return K


def stiffness_rounding(posture: Posture) -> np.ndarray:
    """Rounding errors of K, from each contribution; for loops from the largest multiplier, since one equation gives all of them."""
    balance, load = posture.balance, posture.balance.load
    sizes = balance.entry_sizes
    largest = np.abs(posture.multipliers * load.row_lengths).max(initial=0.0) / load.row_lengths
    return sum(
        (rounding_errors(part, sizes) for part in (*balance.stiffnesses, *balance.geometric(largest))), np.zeros(sizes.shape)
    )


def symmetric_stiffness(posture: Posture, K: np.ndarray) -> tuple[np.ndarray, tuple[Notice, ...]]:
    """K made symmetric where the forces have a potential.

    At an equilibrium the derivative of a conservative force is symmetric; the skew part lies across the motion.
    """
    balance, lengths = posture.balance, posture.balance.load.lengths
    N = rows_of(balance.scaled_jacobian[list(posture.independent_rows)]).motions
    scaled = K * np.outer(lengths, lengths)
    along = N.T @ scaled @ N
    skew = np.abs(along - along.T).max(initial=0.0)
    if skew <= SYMMETRIC_STIFFNESS * np.abs(scaled).max(initial=0.0):
        return (K + K.T) / 2, ()
    text = f"the stiffness matrix is not symmetric (by {skew / np.abs(along).max():.1e} of its largest entry along the motion)"
    return K, (Notice(NoticeKind.UNSYMMETRIC, f"{text}: a torque that keeps its direction has no potential"),)


def instability(posture: Posture) -> tuple[Notice, ...]:
    """A notice where the energy decreases along a motion that the loops allow: without damping the equilibrium is unstable.

    Flexible joints count as their spring in series with the position gain of their motor.
    """
    robot, lengths = posture.robot, posture.balance.load.lengths
    K = np.sum([part for _, part in stiffness_parts(posture)], axis=0)
    for name, joint in robot.flexible_joints.items():
        place, both = robot.coordinates.index(name), joint.stiffness + joint.proportional_gain
        K[place, place] += joint.stiffness * joint.proportional_gain / both if both else 0.0
    N = rows_of(posture.balance.scaled_jacobian[list(posture.independent_rows)]).motions
    scale = np.outer(lengths, lengths)
    along, noise = (N.T @ (part + part.T) @ N / 2 for part in (K * scale, stiffness_rounding(posture) * scale))
    if not along.size:
        return ()
    stiffness, directions = np.linalg.eigh(along)
    if stiffness[0] >= -max(NOISE_SAFETY * np.abs(noise).sum(axis=1).max(), SYMMETRIC_STIFFNESS * np.abs(K * scale).max()):
        return ()
    most = robot.coordinates[int(np.abs(N @ directions[:, 0]).argmax())]
    text = f"the equilibrium is unstable: along a motion, most of all of {most}, the forces increase the deviation"
    return (Notice(NoticeKind.UNSTABLE, text),)


def lost_springs(parts: Sequence[tuple[str, np.ndarray]], noise: np.ndarray) -> tuple[Notice, ...]:
    """A notice on springs that are smaller than the rounding errors of others."""
    lost = [name for name, part in parts if part.any() and (np.abs(part) <= noise).all()]
    if not lost:
        return ()
    text = f"smaller than the rounding errors of the stiffest springs, so that they are lost: {listed(lost)}"
    return (Notice(NoticeKind.ACCURACY, f"{text}; give less stiff springs, or loops instead", doubtful=True),)


def cleaned(part: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The matrix without rounding errors of its largest entry: a zero stiffness must be zero, or a free motion oscillates."""
    scaled = np.abs(part / sizes)
    return np.where(scaled > noise_of(scaled.max(initial=0.0), len(part)), part, 0.0)


def rounding_errors(part: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The rounding errors of the entries: that of the largest, since entries are sums."""
    largest = np.abs(part / sizes).max(initial=0.0)
    return np.where(cleaned(part, sizes) != 0, COMPUTED * largest * sizes, 0.0)


def cleaned_rows(J: np.ndarray, sizes: np.ndarray, units: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Rows of loops without rounding errors of the largest entry of the same unit, and their rounding errors."""
    clean, doubt = np.zeros_like(J), np.zeros_like(J)
    for unit in set(units):
        rows = np.array(units) == unit
        clean[rows], doubt[rows] = cleaned(J[rows], sizes), rounding_errors(J[rows], sizes)
    return clean, doubt
