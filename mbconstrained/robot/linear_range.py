"""Range of validity of the linear motion of a robot, and comparison of its matrices with those of MuJoCo.

The range is measured by the residual force of the motion in the nonlinear equations:

    r(t) = N(q)^T [M(q) a + c(q, v) + g(q) + D(q) v + tau(q) - f(t)],    q = q0 (+) (d + e),  J(q) N(q) = 0,

where e closes the loops again, and v and a follow from q(t). Its part that is linear in d is 0, so that its size relative to the
forces of the linear motion is the relative error of these. Both are measured in the energy norm of the stiffness and of the
inertia at the frequency of the motion, in which one coordinate counts by its force and several by the energy they move.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import null_space

from ..ground.checks import listed
from ..ground.display import Displayed
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    DIFFERENCED,
    EPS,
    LOOP_RANK_EXACT,
    LOOPS_CLOSED_AS_ROUNDED,
    MUJOCO_RATE,
    MUJOCO_STEP,
    NOISE_SAFETY,
    SAME_AS_MUJOCO,
)
from ..mechanics.switched import is_switched
from .description.mjcf import MOST_NAMED, quaternion_places, quiet, read_mjcf
from .posture_search import attached_load
from .robot_model import RobotModel
from .statics import Balance, Posture, rows_of
from .switching import Grip, grip_notices

if TYPE_CHECKING:
    from ..mechanics.equations import EquationsOfMotion
    from ..mechanics.motion import Motion

#: The relative error of the forces from which a motion is said to leave the linear range.
LARGEST_DEVIATION = 0.1

#: The share of the motion at which that is reached is sought in steps of this factor, so many at most, then to this relative error.
DECADE, MOST_DECADES, SHARE_ERROR = 10.0, 12, 0.005

#: No motion is enlarged beyond this angle (rad), or this multiple of the size of the robot.
FURTHEST = 1.5

#: The worst time of a smaller motion is that of the same motion with this amplitude, where the residual is more than rounding errors.
VISIBLE = 0.1

#: The times at which the residual is computed; for other amplitudes it is the worst one of them.
MOST_TIMES = 12

#: Phases beyond the linear range that are named, the worst first.
MOST_PHASES = 3

#: Step of the differences that give v and a, in times of the fastest motion, and the share of the motion that counts as linear.
DIFFERENCE, LINEAR_SHARE = 0.03, 0.01

#: Newton steps that close the loops: the gaps of a linear motion are of second order, and each step squares them.
CLOSING_STEPS = 3

#: Gaps that are rounding errors, in rad or relative to the size of the robot.
CLOSED = 4 * EPS

#: The horizon of a motion without times, in periods or time constants of the slowest eigenvalue, with so many times.
SLOWEST_PERIODS, HORIZON_TIMES = 2.0, 400


@dataclass(frozen=True, repr=False)
class LinearRange(Displayed):
    """Range of validity of a linear motion of a robot.

    Attributes:
        deviation: largest residual force of the nonlinear equations relative to the largest force of the linear motion; 0 for a
            motion that satisfies them, 1 or more for one unrelated to theirs. An estimate: the error accumulates where a
            motion is long, and resonance enlarges it.
        time: time of the largest residual (s).
        coordinate, unit, amplitude: coordinate of the largest displacement, and this (m, rad).
        limit: the amplitude at which the same motion, made smaller or larger, has a deviation of 10 %; infinite where it has none up
            to 1.5 rad or 1.5 times the size of the robot.
        phase: of a switched robot, the one in which that is.
    """

    deviation: float
    time: float
    coordinate: str
    unit: str
    amplitude: float
    limit: float
    phase: str = ""

    @property
    def text(self) -> str:
        """Text of the deviation and of the amplitude up to which it is small."""
        goes = f"{self.coordinate} goes {self.amplitude:.3g} {self.unit} from the posture"
        deviation = f"{100 * self.deviation:.2g} %" if self.deviation < 1 else "100 % or more"
        reached = f"; {self.limit_text}" if self.limit_text else ""
        goes = f"while {self.phase}, {goes}" if self.phase else goes
        return f"{goes}: the forces of the nonlinear robot differ from the linear ones by {deviation} (at t = {self.time:.3g} s){reached}"

    @property
    def limit_text(self) -> str:
        """The amplitude at which the deviation is 10 %; empty where that is not reached."""
        return f"10 % are reached at {self.limit:.2g} {self.unit}" if np.isfinite(self.limit) else ""

    @property
    def notices(self) -> tuple[Notice, ...]:
        """A notice where the deviation is above 10 %."""
        return (Notice(NoticeKind.LARGE_MOTION, self.text),) if self.deviation > LARGEST_DEVIATION else ()

    def _summary(self) -> str:
        return self.text


def linear_range(motion: Motion, posture: Posture, times=None) -> LinearRange:
    """The deviation of the linear motion of a robot at these times; without times, over the periods of its slowest eigenvalue."""
    return _deviations(motion, posture, times)[0].linear_range()


def range_notices(motion: Motion, posture: Posture, grips: Sequence[Grip]) -> tuple[Notice, ...]:
    """Notices on a motion beyond the linear range; of a switched robot, also how far it is from that, and feet that slip."""
    ranges = [one.linear_range() for one in _deviations(motion, posture, None)[:MOST_PHASES]]
    notices = tuple(notice for one in ranges for notice in one.notices)
    if not is_switched(motion):
        return notices
    text = f"all contacts keep their directions, as motions are small about the posture; {ranges[0].text}"
    return (*(notices or (Notice(NoticeKind.SWITCH, text),)), *grip_notices(grips, motion))


def _deviations(motion: Motion, posture: Posture, times) -> list[_Deviation]:
    """The deviation in each phase, the largest first; one of a motion without phases."""
    if not is_switched(motion):
        times = _horizon(motion) if times is None else np.atleast_1d(np.asarray(times, dtype=float))
        return [_Deviation(motion, posture, times, motion.system, 0.0)]
    if times is None:
        times = np.union1d(np.linspace(0.0, motion.solution.sequence.end, HORIZON_TIMES), [time for time, _ in motion.phases])
    times = np.atleast_1d(np.asarray(times, dtype=float))
    phases = [
        _Deviation(motion, posture, times[places], phase.system, phase.constant, phase.name)
        for phase, places in motion._by_phase(times)
    ]
    return sorted(phases, key=lambda one: -one.worst[1])


def _horizon(motion: Motion) -> np.ndarray:
    """Times from 0 to some of the slowest periods or time constants, beyond the last event of the forces."""
    rates = np.abs(motion.system.modes().eigenvalues)
    slow = rates[rates > EPS**0.5 * rates.max(initial=0.0)].min(initial=np.inf)
    end = SLOWEST_PERIODS * 2 * np.pi / slow if np.isfinite(slow) else 1.0
    return np.linspace(0.0, end + max((event.time for event in motion.events), default=0.0), HORIZON_TIMES)


class _Deviation:
    """The residual of one motion at a few times, as a function of its amplitude."""

    def __init__(
        self,
        motion: Motion,
        posture: Posture,
        times: np.ndarray,
        system: EquationsOfMotion,
        constant: np.ndarray | float,
        phase: str = "",
    ):
        self.system, self.posture, self.phase = system, posture, phase
        self._switched = getattr(motion.system, "switched_loops", ())
        self._links = len(self.posture.robot.coordinates)
        everywhere = np.array([view(times) for view in (motion, motion.derivative(1))])
        self.furthest = np.abs(everywhere[0, : self._links]).max(axis=1)
        self.relative = self.furthest / self.posture.balance.load.lengths
        self._largest = float(self.relative.max())
        self.times = times[_worth_looking_at(everywhere)]
        self.motion = np.array([view(self.times) for view in (motion, motion.derivative(1), motion.derivative(2))])
        self.force = (motion.applied.smooth(self.times).T + constant).T
        self._N = null_space(self.system.constraint_matrix) if self.system.rows else None
        self._norm, self.scale, fastest = self._measures()
        self._step = DIFFERENCE / fastest if fastest else 0.0
        self._moves = self.scale > 0 and self._step > 0 and bool(np.isfinite(self.scale))
        self._beyond = self._other_forces()
        self._linear: dict[int, np.ndarray] = {}

    @cached_property
    def worst(self) -> tuple[int, float]:
        """The place of the time with the largest deviation, and the deviation."""
        if not self._moves:
            return 0, 0.0
        visible = max(1.0, VISIBLE / self._largest) if self._largest else 1.0
        place = int(np.argmax([self._deviation(place, visible) for place in range(len(self.times))]))
        return place, self._deviation(place, 1.0)

    def linear_range(self) -> LinearRange:
        """The result, with the amplitude at which the deviation is 10 %."""
        robot, most, (place, deviation) = self.posture.robot, int(self.relative.argmax()), self.worst
        amplitude, limit = float(self.furthest[most]), np.inf
        if self._moves:
            largest = FURTHEST / self._largest if self._largest else np.inf
            limit = _share(partial(self._deviation, place), deviation, largest) * amplitude
        time, name, unit = float(self.times[place]), robot.coordinates[most], robot.units[most]
        return LinearRange(deviation, time, name, unit, amplitude, limit, self.phase)

    def _measures(self) -> tuple[Callable[[np.ndarray], float], float, float]:
        """The norm of forces along N, the largest force of the linear motion in it, and the rate of the motion (1/s)."""
        N = np.eye(self.system.size) if self._N is None else self._N
        M, K = (N.T @ (part + part.T) @ N / 2 for part in (self.system.mass, self.system.stiffness))
        d, v, a = (np.linalg.lstsq(N, part, rcond=None)[0] for part in self.motion)
        sizes = [np.sqrt(np.abs(np.einsum("it,ij,jt->t", part, M, part)).max(initial=0.0)) for part in (d, v, a)]
        if not sizes[0]:
            return (lambda force: 0.0), 0.0, 0.0
        fastest = max(sizes[1] / sizes[0], np.sqrt(sizes[2] / sizes[0]))
        metric = _energy_metric(M * fastest**2, K)

        def norm(force: np.ndarray) -> float:
            return float(np.linalg.norm(metric @ force))

        forces = [N.T @ self.system.stiffness @ self.motion[0], N.T @ self.system.mass @ self.motion[2], M * fastest**2 @ d]
        return norm, max(norm(force[:, place]) for force in forces for place in range(len(self.times))), fastest

    def _other_forces(self) -> np.ndarray:
        """Forces that are linear in the motion: those of motors and their gears, controls, and dampers of joints, shape (n, T)."""
        at_rest, system, motors = self.posture.balance, self.system, self.system.size - self._links
        own = (at_rest.stiffness(self.posture.multipliers), _damping(at_rest), at_rest.mass)
        every = zip((system.stiffness, system.damping, system.mass), own, self.motion)
        return sum((whole - np.pad(links, (0, motors))) @ x for whole, links, x in every)

    def _deviation(self, place: int, share: float) -> float:
        """Norm of the nonlinear residual of this share of the motion, relative to the forces of that share."""
        if place not in self._linear:
            small = LINEAR_SHARE / max(1.0, self._largest)
            self._linear[place] = self._residual(place, small) / small
        return self._norm(self._residual(place, share) - share * self._linear[place]) / (share * self.scale)

    def _residual(self, place: int, share: float) -> np.ndarray:
        """Residual force N^T r, shape (n - m,)."""
        posture, motors = self.posture, self.system.size - self._links
        load, tree = posture.balance.load, posture.robot.tree
        d, v, a = share * self.motion[:, : self._links, place]
        before, here, after = (self._closed(d + step * v + step**2 / 2 * a) for step in (-self._step, 0.0, self._step))
        rate, second = (
            (after.moved - before.moved) / (2 * self._step),
            (after.moved - 2 * here.moved + before.moved) / self._step**2,
        )
        turning = (after.turned - before.turned) / (2 * self._step)
        velocity, acceleration = here.turned @ rate, here.turned @ second + turning @ rate
        balance = here.balance
        force = tree.inverse_dynamics(balance.configuration, velocity, acceleration) - balance.gravity + balance.force
        force = force + _damping(balance) @ velocity + sum((tendon.inertia @ acceleration for tendon in balance.tendons), 0.0)
        force = here.turned.T @ force - np.array([posture.torques.get(name, 0.0) for name in posture.robot.coordinates])
        whole = np.append(force, np.zeros(motors)) + share * (self._beyond[:, place] - self.force[:, place])
        whole = whole + self.system.static_force  # of loops that are open in some phases: no small part of the motion
        if self._N is None:
            return whole
        closed, others = self._rows
        rows = (balance.jacobian @ here.turned / load.row_lengths[:, None])[closed]
        rows = np.vstack([np.pad(rows, ((0, 0), (0, motors))), *others])
        independent = rows_of(rows).right
        return self._N.T @ (whole - independent.T @ (independent @ whole))

    @cached_property
    def _rows(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """The places of the rows of closed loops among those of the posture, and the other rows, which do not turn."""
        rows, load = {row.name for row in self.system.rows}, self.posture.balance.load
        loops = [item.connection for item in load.loops]
        still = [not rows.isdisjoint((one.name, *one.row_names)) or one.name not in self._switched for one in loops]
        closed = np.repeat(
            [*still, *(True for _ in load.mimic_rows)], [*(len(one.row_names) for one in loops), *(1 for _ in load.mimic_rows)]
        )
        own = {*load.row_names, *(one.name for one in loops)}
        return np.flatnonzero(closed), [row.coefficients for row in self.system.rows if row.name not in own]

    def _closed(self, step: np.ndarray) -> _Place:
        """The configuration near q0 (+) step that closes loops as the posture does, or follows the motion of a moving base."""
        at_rest = self.posture.balance
        place = _Place.at(at_rest, step)
        if not at_rest.load.has_rows:
            return place
        wanted = at_rest.scaled_gaps + at_rest.scaled_jacobian @ (step / at_rest.load.lengths)
        for _ in range(CLOSING_STEPS):
            gap = place.balance.scaled_gaps - wanted
            if np.abs(gap).max() <= CLOSED:
                break
            rows = rows_of(place.balance.jacobian @ place.turned * at_rest.load.lengths / at_rest.load.row_lengths[:, None])
            place = _Place.at(at_rest, place.moved - rows.shortest(gap) * at_rest.load.lengths)
        return place


@dataclass(frozen=True, eq=False)
class _Place:
    """The configuration q0 (+) d, the balance of forces there, and T with v = T d'."""

    moved: np.ndarray
    balance: Balance
    turned: np.ndarray

    @classmethod
    def at(cls, at_rest: Balance, moved: np.ndarray) -> _Place:
        """The state at a step from the posture."""
        tree, q = at_rest.tree, at_rest.configuration
        return cls(moved, Balance(tree, at_rest.load, tree.moved(q, moved)), tree.moved_derivative(q, moved))


def _worth_looking_at(motion: np.ndarray) -> list[int]:
    """Times of the largest displacements and velocities of each coordinate, and some between, at most ``MOST_TIMES``."""
    count = motion.shape[2]
    flat = np.abs(motion).reshape(-1, count)
    relative = flat / np.maximum(flat.max(axis=1, keepdims=True), np.finfo(float).tiny)
    sums = (relative**2).sum(axis=0)
    largest = [*np.argsort(-sums)[: MOST_TIMES // 3].tolist(), *flat.argmax(axis=1).tolist()][: 2 * MOST_TIMES // 3]
    spread = np.linspace(0, count - 1, min(count, MOST_TIMES // 3)).astype(int).tolist()
    return sorted({*largest, *spread})


def _damping(balance: Balance) -> np.ndarray:
    """D of springs, bushings and tendons between bodies, shape (nv, nv); that of joints is constant."""
    return sum(balance.dampings, np.zeros((balance.tree.model.nv,) * 2))


def _energy_metric(inertia: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """W with W A W^T = I, where A is in each direction the larger of |K| and M w^2."""
    units = np.sqrt(np.abs(np.diag(inertia)) + np.abs(np.diag(stiffness)))
    units = np.where(units > 0, units, 1.0)
    values, vectors = np.linalg.eigh(stiffness / np.outer(units, units))
    both = inertia / np.outer(units, units) + (vectors * np.abs(values)) @ vectors.T
    size, basis = np.linalg.eigh(both)
    kept = size > EPS * len(size) * size.max(initial=0.0)
    W = (basis[:, kept] / np.sqrt(size[kept])).T  # of the sum, in whose eigenvectors both parts are diagonal
    shares, turn = np.linalg.eigh(W @ (inertia / np.outer(units, units)) @ W.T)
    larger = np.maximum(shares, 1 - shares)
    return (turn.T @ W) / np.sqrt(larger)[:, None] / units


def _share(deviation: Callable[[float], float], whole: float, largest: float) -> float:
    """The share of the motion with a deviation of 10 %, by bisection in logarithms; infinite where there is none up to the largest."""
    step, above = np.log(DECADE), whole > LARGEST_DEVIATION
    start = end = 0.0
    for _ in range(MOST_DECADES):
        start, end = end, end - step if above else min(end + step, float(np.log(largest)))
        if start == end:
            return np.inf
        if (deviation(np.exp(end)) > LARGEST_DEVIATION) != above:
            break
    else:
        return np.inf
    while abs(end - start) > SHARE_ERROR:
        middle = (start + end) / 2
        start, end = (middle, end) if (deviation(np.exp(middle)) > LARGEST_DEVIATION) == above else (start, middle)
    return float(np.exp((start + end) / 2))


def compared_with_mujoco(robot: RobotModel, posture: Posture) -> tuple[Notice, ...]:
    """Compare the robot of the file, without additions, with MuJoCo at the joint values of a posture."""
    source = read_mjcf(robot.source.path, False, robot.package_dirs)
    if source.compiled is None or not source.model.nv:
        return ()
    bare = type(robot)(source)
    values = {**posture.joints, **robot.locked}
    q = bare.tangent.configuration({name: values[name] for name in bare.joints if name in values})
    ours = Balance(bare.tree, attached_load(bare, q, {}), q)
    twin = _Twin(bare, q)
    scale = EPS * max(float(np.abs(part).max(initial=0.0)) for part in ours.forces)
    own_stiffness = np.sum(ours.stiffnesses, axis=0) + np.diag(bare.position_gains)
    branches = bare.tree.moves_axis | bare.tree.moves_axis.T  # elsewhere MuJoCo has no masses, also not of tendons
    damping = np.diag(bare.joint_damping) + _damping(ours)
    for what, own, other, tolerance, noise in (
        ("mass", ours.mass * branches, twin.mass() * branches, SAME_AS_MUJOCO, 0.0),
        ("force", ours.force[:, None], twin.force(q)[:, None], SAME_AS_MUJOCO, scale + EPS * np.abs(own_stiffness).max()),
        ("stiffness", own_stiffness, twin.stiffness(), DIFFERENCED, scale / MUJOCO_STEP),
        ("damping", damping, twin.damping(), DIFFERENCED, scale / MUJOCO_RATE),
    ):
        _agree(what, own, other, bare.coordinates, tolerance, NOISE_SAFETY * noise)
    twin.compare_loops(ours)
    return twin.contacts()


def _agree(what: str, ours: np.ndarray, theirs: np.ndarray, names: Sequence[str], tolerance: float, noise: float) -> None:
    """Raise an error where an entry differs by more than the tolerance times the scale of its row and column."""
    size = np.maximum(np.abs(ours), np.abs(theirs))
    excess = np.abs(ours - theirs) - tolerance * np.sqrt(np.outer(size.max(axis=1), size.max(axis=0))) - noise
    if excess.max(initial=0.0) > 0:
        i, j = np.unravel_index(excess.argmax(), excess.shape)
        of = f'"{names[i]}"' + (f' by "{names[j]}"' if i != j and len(ours) == len(ours.T) else "")
        raise InputError(f"mjcf: the {what} of {of} is {ours[i, j]:.9g} here and {theirs[i, j]:.9g} in MuJoCo{_ADVICE}")


_ADVICE = ": something in the file is not read as MuJoCo reads it; please report it with the file"


class _Twin:
    """The compiled model in the coordinates of a robot, without contacts, limits, dry friction and clamped forces."""

    def __init__(self, robot: RobotModel, q: np.ndarray):
        import mujoco

        self.robot, self.q, self._mujoco = robot, q, mujoco
        self.model = copy.copy(robot.source.compiled)
        flags, self._touching = mujoco.mjtDisableBit, int(self.model.opt.disableflags)
        self.model.opt.disableflags |= int(flags.mjDSBL_CONTACT | flags.mjDSBL_LIMIT | flags.mjDSBL_FRICTIONLOSS)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        for name in ("actuator_forcelimited", "jnt_actfrclimited", "tendon_actfrclimited"):
            getattr(self.model, name, np.zeros(0))[:] = 0
        self.data = mujoco.MjData(self.model)
        self._places = quaternion_places(self.model)
        self._move(q)
        self.model.actuator_biasprm[:, 0] -= np.array(self.data.actuator_force)[: len(self.model.actuator_biasprm)]  # none at rest

    def _move(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """Set configuration and rates, and compute all forces.

        Returns the map from the rates of the robot to those of MuJoCo, whose free joints move along the axes of the ground.
        """
        import pinocchio

        qpos, rates = np.empty(self.model.nq), np.eye(self.model.nv)
        qpos[self._places] = q
        for joint in list(self.robot.model.joints)[1:]:
            if joint.nv == 6:
                turn = pinocchio.Quaternion(q[joint.idx_q + 3 : joint.idx_q + 7]).toRotationMatrix()
                rates[joint.idx_v : joint.idx_v + 3, joint.idx_v : joint.idx_v + 3] = turn
        self.data.qpos[:], self.data.qvel[:] = qpos, 0.0 if v is None else rates @ v
        with quiet():
            for stage in (self._mujoco.mj_fwdPosition, self._mujoco.mj_fwdVelocity, self._mujoco.mj_fwdActuation):
                stage(self.model, self.data)
        return rates

    def mass(self) -> np.ndarray:
        """M, shape (nv, nv)."""
        rates, M = self._move(self.q), np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(M, np.eye(self.model.nv)):
            self._mujoco.mj_mulM(self.model, self.data, column, unit)
        return rates.T @ M @ rates

    def force(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """The forces on the left of the equations, shape (nv,)."""
        return self._move(q, v).T @ (self.data.qfrc_bias - self.data.qfrc_passive - self.data.qfrc_actuator)

    def stiffness(self) -> np.ndarray:
        """K, shape (nv, nv)."""
        return self._differenced(lambda step: self.force(self.robot.tree.moved(self.q, step)), MUJOCO_STEP)

    def damping(self) -> np.ndarray:
        """C, shape (nv, nv); the part c v |v| of polynomials is odd, its slope of first order in the step."""
        coarse, fine = (self._differenced(lambda rate: self.force(self.q, rate), step) for step in (MUJOCO_RATE, MUJOCO_RATE / 2))
        return 2 * fine - coarse

    def _differenced(self, force: Callable[[np.ndarray], np.ndarray], h: float) -> np.ndarray:
        """The derivative by central differences of fourth order, column by column."""
        units = np.eye(self.model.nv) * h
        columns = [(8 * (force(u) - force(-u)) - (force(2 * u) - force(-2 * u))) / (12 * h) for u in units]
        return np.array(columns).T

    def compare_loops(self, ours: Balance) -> None:
        """Raise an error where the equality rows of MuJoCo and the loops of the robot span different spaces, or are open."""
        rates, lengths = self._move(self.q), ours.load.lengths
        theirs = self.data.efc_J.reshape(-1, self.model.nv)[: self.data.ne] @ rates * lengths
        for what, rows, others in (("here", theirs, ours.scaled_jacobian), ("in MuJoCo", ours.scaled_jacobian, theirs)):
            left = rows - rows @ np.linalg.pinv(others, rcond=LOOP_RANK_EXACT) @ others if len(others) else rows
            if np.abs(left).max(initial=0.0) > DIFFERENCED * max(np.abs(rows).max(initial=0.0), DIFFERENCED * ours.load.size):
                name = self.robot.coordinates[int(np.unravel_index(np.abs(left).argmax(), left.shape)[1])]
                raise InputError(f'mjcf: equalities leave another motion of "{name}" {what}{_ADVICE}')
        gap, own = np.abs(self.data.efc_pos[: self.data.ne]).max(initial=0.0), np.abs(ours.gaps).max(initial=0.0)
        if gap > 10 * own + LOOPS_CLOSED_AS_ROUNDED * max(1.0, ours.load.size):
            raise InputError(f"mjcf: equalities are open by {gap:.3g} in MuJoCo and by {own:.3g} (m, rad) here{_ADVICE}")

    def contacts(self) -> tuple[Notice, ...]:
        """A note on contacts between bodies, which the equations do not contain."""
        self.model.opt.disableflags = self._touching
        self._move(self.q)
        links, geoms = self.robot.source.links, self.model.geom_bodyid
        touching = (contact.geom for contact in self.data.contact[: self.data.ncon] if contact.dist < 0)
        pairs = dict.fromkeys(" and ".join(links[geoms[geom]] for geom in pair) for pair in touching if min(pair) >= 0)
        if not pairs:
            return ()
        text = f"at the posture {listed(list(pairs), MOST_NAMED, ' pairs')} touch; give feet as loops or bushings"
        return (Notice(NoticeKind.OMITTED, f"mjcf: contacts are not in the equations: {text}"),)
