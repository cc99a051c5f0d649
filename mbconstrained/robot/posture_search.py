"""The search for a posture: it closes the loops, then balances the forces; the rank of the loops and the limits of feet on the ground.

Where statics leaves open how feet share the load, it is only reported that a foot slips if no share keeps all of them in place.

Rows are dependent in many good mechanisms: a planar loop closed in space, a parallelogram with a third crank.
Multipliers are then not unique, but motions are, as long as the rank stays the same along the motion. If m^T J = 0 for
a combination m of the rows, differentiating m(q)^T J(q) = 0 along the motion N z gives

    N^T (d(J^T m)/dq) N = 0,     N a basis of null(J),

so a posture where this matrix is not zero is singular: the loops can take another branch there, or cannot follow the
motion that the linear equations allow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy, deepcopy
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from ..ground.checks import counted, listed, real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    CONE_TOLERANCE,
    JOINT_LIMIT,
    LEFT_OPEN,
    LOOP_RANK,
    LOOP_RANK_DOUBTFUL,
    LOOP_RANK_EXACT,
    LOOP_RANK_TILTED,
    LOOPS_CLOSED,
    LOOPS_CLOSED_AS_ROUNDED,
    SINGULAR_POSTURE,
)
from .connections import TURNING, Attached, BodySpring, LinkFrames, PointMotion, Support, untwisted, with_rest_length
from .kinematics import Kinematics, Tree, directions_across
from .robot_model import RobotModel
from .statics import LARGEST_STEP, Balance, Equilibrium, Load, Posture, Rows, Search, closed, equilibrium, instability, rows_of

#: Sides of the pyramid inside a friction cone: it lacks 0.1 % of the friction.
SIDES = 64

#: Most times at which all shares of the load are tried.
MOST_TRIED = 400

#: Text for a foot that exceeds a limit.
LIFTS, SLIPS, TIPS = "lifts off", "slips", "tips over"
PLURALS = {LIFTS: "lift off", SLIPS: "slip", TIPS: "tip over"}


@dataclass(frozen=True, eq=False)
class PostureContact:
    """A foot at rest."""

    support: Support  # a loop or bushing with friction
    places: slice | None  # of its multipliers among all; none of a bushing, whose force the posture determines
    # force in the directions of the ground and torque along x, y, z of the frame on body1, on the foot, for units of its
    # multipliers, shape (6, k); of a bushing the force and torque at rest, shape (6, 1)
    wrench: np.ndarray
    frame: np.ndarray  # directions of the frame on body1, shape (3, 3)

    def at_rest(self, multipliers: np.ndarray) -> np.ndarray:
        """The force in the directions of the ground and the torque in those of the frame, shape (6, 1)."""
        return self.wrench if self.places is None else (self.wrench @ multipliers[self.places])[:, None]

    def of(self, wrench: np.ndarray) -> np.ndarray:
        """Contact force from a wrench on body2 in the directions of the ground, both of shape (6, T)."""
        on_foot = self.support.on_foot(wrench)
        return np.vstack([on_foot[:3], self.frame.T @ on_foot[3:]])

    def rows(self) -> dict[str, np.ndarray]:
        """Nonnegative quantities by limit, per unit of the multipliers: normal force (N), distances from the sides of the pyramid
        inside the cone (N), moments about the edges of the sole (N m).
        """
        normal = self.support.unit_normal
        angles = np.arange(SIDES) * 2 * np.pi / SIDES
        sides = np.column_stack([np.cos(angles), np.sin(angles)]) @ directions_across(normal)
        friction = (self.support.friction or 0.0) * np.cos(np.pi / SIDES)
        force, edges = self.wrench[:3], [np.zeros((0, self.wrench.shape[1]))]
        for extent, moment in zip(self.support.patch or (), (self.wrench[4], self.wrench[3])):
            half = extent / 2 * (normal @ force)
            edges.append(np.vstack([half + moment, half - moment]))
        return {LIFTS: (normal @ force)[None], SLIPS: (friction * normal - sides) @ force, TIPS: np.vstack(edges)}


@dataclass(frozen=True, eq=False)
class Exceeded:
    """Feet that exceed one of their limits."""

    # one foot; several where it is open how they share the load, of which some are outside with every share
    contacts: tuple[PostureContact, ...]
    limit: str  # LIFTS, SLIPS or TIPS
    # places of the worst time and of the first one
    worst: int
    first: int
    excess: float  # excess over the limit, comparable between feet
    text: str  # the worst value


def contact_notices(state: Equilibrium, free: np.ndarray) -> Iterator[Notice]:
    """Notices on feet whose force at rest is tensile or leaves the friction cone, or whose centre of pressure leaves the sole."""
    feet = [(contact, contact.at_rest(state.multipliers)) for contact in _contacts(state.balance)]
    exceeded = _exceeded(state.balance, free, state.multipliers[:, None], feet, CONE_TOLERANCE)
    yield from (Notice(NoticeKind.STATIC_LOAD, text) for text in _sentences(exceeded))


def limit_values(balance: Balance, wrenches: Mapping[str, np.ndarray], sizes: Mapping[str, float], tolerance: float) -> np.ndarray:
    """Excess of feet over their limits beyond a tolerance, positive outside; by foot, the limits in their order."""
    rows = []
    for contact in _contacts(balance):
        name = contact.support.name
        limits = _limits(contact, contact.of(wrenches[name]), tolerance, sizes[name])
        rows += [limit.excess - limit.least for limit in limits]
    return np.array(rows).reshape(len(rows), -1)


def moving_contact_notices(
    balance: Balance, free: np.ndarray, multipliers: np.ndarray, times: np.ndarray, wrenches: Mapping[str, np.ndarray], error: float
) -> Iterator[Notice]:
    """Notices on feet during a small motion, with the times of the worst value and of the first, except feet that exceed their
    limits at rest.
    """
    rest, motion = slice(0, 1), slice(1, None)
    feet = [(contact, contact.of(wrenches[contact.support.name])) for contact in _contacts(balance)]
    at_rest = _exceeded(balance, free, multipliers[:, rest], [(foot, w[:, rest]) for foot, w in feet], CONE_TOLERANCE)
    wrong = {contact for one in at_rest for contact in one.contacts}
    moving = [(foot, w[:, motion]) for foot, w in feet if foot not in wrong]
    for text in _sentences(_exceeded(balance, free, multipliers[:, motion], moving, max(error, CONE_TOLERANCE)), times):
        yield Notice(NoticeKind.LARGE_MOTION, f"{text}; the equations keep feet in place")


def _contacts(balance: Balance) -> Iterator[PostureContact]:
    for item, _, G, places in balance.loops:
        if item.connection.friction is not None:
            yield _contact(balance, item, places, G.T)
    for item, spring in zip(balance.load.springs, balance.elastic):
        if isinstance(item.connection, Support) and item.connection.friction is not None:
            yield _contact(balance, item, None, spring.wrench[:, None])


def _contact(balance: Balance, item: Attached, places: slice | None, wrench: np.ndarray) -> PostureContact:
    """The contact of a wrench on body2 in the frame on body1."""
    frame = balance.kinematics.frame(item.first)[0]
    on_foot = item.connection.on_foot(wrench)
    return PostureContact(item.connection, places, np.vstack([frame @ on_foot[:3], on_foot[3:]]), frame)


def _exceeded(
    balance: Balance, free: np.ndarray, multipliers: np.ndarray, feet: Sequence[tuple[PostureContact, np.ndarray]], tolerance: float
) -> list[Exceeded]:
    """Feet that exceed their limits; where the load sharing of loops is undetermined, only if every share exceeds them."""
    J = balance.scaled_jacobian[:, free].T
    is_open = rows_of(J.T).rank < len(multipliers)
    exceeded, together = [], []
    for contact, wrench in feet:
        limits = _limits(contact, wrench, tolerance)
        if is_open and contact.places is not None:
            together.append((contact, limits))
        else:
            exceeded += _outside(contact, limits)
    outside = np.any([limit.outside for _, limits in together for limit in limits], axis=0)
    places = np.flatnonzero(outside).tolist() if together else []
    if len(places) > MOST_TRIED:  # with the first and the worst of each limit
        ends = [int(np.where(one.outside, one.excess, -np.inf).argmax()) for _, own in together for one in own if one.outside.any()]
        places = sorted({places[0], *ends, *places[:: len(places) // MOST_TRIED]})
    return exceeded + _of_every_share(balance, J, multipliers, tuple(contact for contact, _ in together), places, tolerance)


def _outside(contact: PostureContact, limits: Sequence[Limit]) -> Iterator[Exceeded]:
    """Events in which a foot lifts off, or before that slips, or tips over: either may be first, and both may occur."""
    before = len(limits[0].excess)
    for limit in limits:
        outside = limit.outside & (np.arange(len(limit.outside)) < before)
        if outside.any():
            worst, first = int(np.where(outside, limit.excess, -np.inf).argmax()), int(outside.argmax())
            yield Exceeded((contact,), limit.name, worst, first, float(limit.excess[worst]), limit.text(worst))
            before = first if limit.name == LIFTS else before


@dataclass(frozen=True, eq=False)
class Limit:
    """Excess of a foot over a limit as a function of time, with the threshold and a sentence on the value at an index."""

    name: str
    excess: np.ndarray
    least: float
    text: Callable[[int], str]

    @property
    def outside(self) -> np.ndarray:
        """Which times exceed the limit, shape (T,)."""
        return self.excess > self.least


def _limits(contact: PostureContact, wrench: np.ndarray, tolerance: float, size: float | None = None) -> list[Limit]:
    """Tensile normal force (N), tangential force beyond friction (N), position of the centre of pressure relative to the sole.

    The tolerance is relative to the size, by default the largest force.
    """
    foot, force = contact.support, wrench[:3]
    along, across = foot.parts(force)
    least = float(np.linalg.norm(force, axis=0).max() if size is None else size) * tolerance
    excess, pressed = across - foot.friction * np.maximum(along, 0.0), along > least
    arms = np.where(pressed, np.abs(wrench[[4, 3]]) / np.where(pressed, along, 1.0), 0.0)
    halves = np.array(foot.patch if foot.patch is not None else (np.inf, np.inf)) / 2
    shares = arms / halves[:, None]

    def friction(place: int) -> str:
        needed = f", a coefficient of friction of {across[place] / along[place]:.3g}" if pressed[place] else ""
        sizes = f"{across[place]:.4g} N along the ground at a normal force of {along[place]:.4g} N"
        return f"it needs {sizes}{needed}; found {foot.friction:g}"

    def pressure(place: int) -> str:
        axis = int(shares[:, place].argmax())
        at = f"{arms[axis, place]:.3g} m along {'xy'[axis]} from its point"
        return f"the centre of pressure would be {at}, and the sole ends at {halves[axis]:.3g} m"

    return [
        Limit(LIFTS, -along, least, lambda place: f"the ground would have to pull by {-along[place]:.4g} N"),
        Limit(SLIPS, excess, least, friction),
        Limit(TIPS, shares.max(axis=0), 1 + tolerance, pressure),
    ]


def _sentences(exceeded: Sequence[Exceeded], times: np.ndarray | None = None) -> Iterator[str]:
    """One sentence for each limit: the foot with the largest excess, and the number of others; with times in s for a motion."""
    for limit in (LIFTS, SLIPS, TIPS):
        outside = [one for one in exceeded if one.limit == limit]
        if not outside:
            continue
        worst, first = max(outside, key=lambda one: one.excess), min(one.first for one in outside)
        since = f", first at {times[first]:.4g} s" if times is not None and first < worst.worst else ""
        label = worst.contacts[0].support.label
        if len(worst.contacts) > 1:
            what = f"whatever share of the load they take, feet {PLURALS[limit]}{since}"
        elif len(outside) > 1:
            what = f"{len(outside)} feet {PLURALS[limit]}{since}; most of all {label}"
        else:
            what = f"{label}: the foot {limit}{since}"
        when = "" if times is None else f"at t = {times[worst.worst]:.4g} s "
        yield f"{what}: {when}{worst.text}"


#: The least excess with every share, as text by limit.
_LACKING = {
    LIFTS: "the ground would have to pull at one of them by {:.4g} N at least",
    SLIPS: "one of them lacks {:.4g} N of friction at least",
    TIPS: "one of them lacks {:.4g} N m at the edge of its sole at least",
}


def _of_every_share(
    balance: Balance,
    J: np.ndarray,
    multipliers: np.ndarray,
    contacts: tuple[PostureContact, ...],
    places: Sequence[int],
    tolerance: float,
) -> list[Exceeded]:
    """Limits that feet exceed for all multipliers with the same load on the free coordinates, J^T lambda = force.

    A linear program for each limit: least z >= 0 with rows @ lambda + z >= 0, those of the limits before it that are kept without z. None
    is of use after one in which feet lift off.
    """
    if not len(places):
        return []
    from scipy.optimize import linprog

    count, lengths = len(multipliers), balance.load.row_lengths
    rows = [contact.rows() for contact in contacts]
    kept = {
        limit: np.vstack([own[limit] @ np.eye(count)[contact.places] / lengths for own, contact in zip(rows, contacts)])
        for limit in (LIFTS, SLIPS, TIPS)
    }
    least, lacking = np.append(np.zeros(count), 1.0), {}
    for place in places:
        force = J @ (multipliers[:, place] * lengths)
        size = np.abs(force).max(initial=0.0) or 1.0
        hard = np.zeros((0, count + 1))
        for limit, own in kept.items():
            slack = np.vstack([hard, np.column_stack([-own, -np.ones(len(own))])])
            bounds = [(None, None)] * count + [(0, None)]
            answer = linprog(least, slack, np.zeros(len(slack)), np.column_stack([J, np.zeros(len(J))]), force / size, bounds)
            if answer.status == 0 and answer.fun > tolerance:
                lacking.setdefault(limit, {})[int(place)] = answer.fun * size
                if limit == LIFTS:
                    break
                continue
            hard = np.vstack([hard, np.column_stack([-own, np.zeros(len(own))])])
    return [
        Exceeded(contacts, limit, worst, min(own), own[worst], _LACKING[limit].format(own[worst]))
        for limit, own in lacking.items()
        for worst in [max(own, key=own.__getitem__)]
    ]


def loop_rows(
    balance: Balance, nearest: Balance, rounded: str, with_all_digits: Callable[[], Balance]
) -> tuple[tuple[int, ...], tuple[Notice, ...]]:
    """Ascending indices of the independent rows of J in a closed configuration, and notices on others and on a narrow margin."""
    load = balance.load
    J = balance.scaled_jacobian
    rows = rows_of(J)
    _check_regular(balance, rows.combinations.T / load.row_lengths, rows.motions)
    order = scipy.linalg.qr(J.T, mode="economic", pivoting=True)[2] if J.size else np.arange(len(J))
    kept = tuple(sorted(order[: rows.rank].tolist()))
    empty = _empty(balance)
    notices = _redundant({load.row_names[row]: bool(empty[row]) for row in range(len(J)) if row not in kept})
    here = np.abs(rows.combinations.T @ balance.scaled_gaps).max(initial=0.0)
    open_by = float(min(here, np.abs(nearest.scaled_gaps).max(initial=0.0)))
    return kept, (*notices, *_narrow(rows, open_by, rounded, with_all_digits))


def implied_rows(balance: Balance, kept: Sequence[int]) -> tuple[str, ...]:
    """The names of the redundant rows, for which the sharing of forces is undetermined."""
    empty, names = _empty(balance), balance.load.row_names
    return tuple(name for row, name in enumerate(names) if row not in kept and not empty[row])


def _empty(balance: Balance) -> np.ndarray:
    """Which rows have no coordinates, shape (m,)."""
    return np.abs(balance.scaled_jacobian).max(axis=1, initial=0.0) <= LOOP_RANK


def _narrow(rows: Rows, open_by: float, rounded: str, with_all_digits: Callable[[], Balance]) -> list[Notice]:
    """Notices on an unclear rank, with rounded data among the reasons.

    They leave loops open by as much as rows are independent, or make them independent where angles with all digits do not.
    """
    notices, values, rank = [], rows.relative, rows.rank
    if rank < len(values) and values[rank] > LOOP_RANK_EXACT:
        text = f"rows of the loops that were left out are dependent to {values[rank]:.1e} only"
        explained = open_by > LEFT_OPEN * values[rank]
        if rounded and not explained:
            explained = bool(rows_of(with_all_digits().scaled_jacobian).relative[rank] <= LEFT_OPEN * values[rank])
        if explained:
            text += (
                ", as where axes in the URDF are rounded; if this is meant, the robot is near a singular posture: choose another"
            )
            notices.append(Notice(NoticeKind.RANK, text))
        else:
            fewer = counted(int((values[rank:] > LOOP_RANK_EXACT).sum()), "motion")
            text += (
                f", and no rounded number explains it: with these rows the robot has {fewer} less; remove the redundant loop, or "
                "make its dimensions agree with the others"
            )
            notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    if rank and values[rank - 1] < LOOP_RANK_DOUBTFUL:
        text = (
            f"the rows of the loops are almost dependent (relative singular value {values[rank - 1]:.1e}): the posture is near a "
            "singular one, and small forces move the robot far"
        )
        notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    elif rounded and rank and values[rank - 1] < LOOP_RANK_TILTED:
        left = rows.motions.shape[1]
        text = (
            f"the loops leave {counted(left, 'motion')}, and one more is only weakly constrained (relative singular value "
            f"{values[rank - 1]:.1e}): {rounded}"
        )
        notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    return notices


def _check_regular(balance: Balance, combinations: np.ndarray, motions: np.ndarray) -> None:
    """N^T (d(J^T m)/dq) N = 0 for every combination m of rows that is zero, shape (c, m)."""
    if not combinations.size or not motions.size:
        return
    usual = max(np.abs(_second(balance, row)).max() for row in np.diag(1 / balance.load.row_lengths))
    for combination in combinations:
        if np.abs(motions.T @ _second(balance, combination) @ motions).max() > SINGULAR_POSTURE * usual:
            least = 0.1 * np.abs(combination).max()
            rows = [name for name, part in zip(balance.load.row_names, combination) if abs(part) > least]
            raise InputError(
                f"equilibrium: the posture is singular: a combination of the rows {', '.join(rows)} constrains nothing here but does "
                "in the neighbourhood, so that linear equations do not describe the motion of the robot; choose a posture away from it"
            )


def _second(balance: Balance, combination: np.ndarray) -> np.ndarray:
    """d(J^T m)/dq in comparable units, shape (nv, nv)."""
    lengths = balance.load.lengths
    return np.sum(balance.geometric(combination), axis=0) * np.outer(lengths, lengths)


def _redundant(rows: dict[str, bool]) -> list[Notice]:
    """Notices on the dependent rows, by name; True marks a row without coordinates, which the joints alone satisfy."""
    reasons = {
        True: "the joints satisfy {it} by themselves",
        False: "other rows imply {it}; multipliers of a motion are those of the remaining rows, those at rest have the least norm",
    }
    notices = []
    for empty, reason in reasons.items():
        names = [name for name, is_empty in rows.items() if is_empty == empty]
        if names:
            one = len(names) == 1
            word, be, was = ("row", "is", "was") if one else ("rows", "are", "were")
            text = f"loop {word} {', '.join(names)} {be} redundant and {was} left out"
            notices.append(Notice(NoticeKind.REDUNDANT, f"{text}: {reason.format(it='it' if one else 'them')}"))
    return notices


#: An angle with this number of digits after the point may stand for a multiple of pi/4 and still leave loops open.
FEWEST, MOST = 2, 9


def rounded_to(text: str) -> int | None:
    """The n for which this number is n pi/4 rounded to its digits, or None.

    >>> rounded_to("1.57"), rounded_to("-3.1416"), rounded_to("0.79"), rounded_to("1.5"), rounded_to("1.5707963267948966")
    (2, -4, 1, None, None)
    """
    digits = len(text.strip().partition(".")[2])
    n = round(float(text) / (math.pi / 4))
    meant = n and FEWEST <= digits <= MOST and abs(float(text) - n * math.pi / 4) < 10.0**-digits
    return n if meant else None


def rounded_advice(robot: RobotModel) -> str:
    """The rounded angles of the robot with advice, or an empty string.

    The search covers the places of joints in the URDF and the directions of the frames of loops.
    """
    origins = ((joint, joint.find("origin")) for joint in robot.description.findall("joint"))
    places = [
        ("rpy", f'joint "{joint.get("name")}"', origin.get("rpy", "").split()) for joint, origin in origins if origin is not None
    ]
    for loop in robot.loops:
        places += [(key, loop.label, [*map(repr, getattr(loop, key))]) for key in ("rotation1", "rotation2")]
    worst = ((key, of, next(filter(rounded_to, texts), None)) for key, of, texts in places)
    angles = [f"the {key} {text} of {of}" for key, of, text in worst if text]
    if not angles:
        return ""
    one = len(angles) == 1
    text = f"{listed(angles)} {'is' if one else 'are'} rounded"
    return f"{text}, which tilts axes that may be meant to be parallel: write {'it' if one else 'them'} with all digits (pi/2 is {math.pi / 2!r})"


def _all_digits(text: str) -> float:
    eighths = rounded_to(text)
    return float(text) if eighths is None else eighths * math.pi / 4


#: Number of joints that are named; the others are counted.
MOST_NAMES = 4


def find_posture(robot: RobotModel, guess, forces: Mapping, hold: Sequence[str] | str) -> Posture:
    """The posture near a guess, as ``Robot.equilibrium``: closes the loops, then balances the forces."""
    start = guess_with_followers(robot, guess)
    free = ~_fixed_coordinates(robot, hold)
    load = _untwisted(attached_load(robot, start, forces), robot, start)
    nearest = closed(Search(robot.tree, load, free), start)
    load = replace(load, springs=tuple(with_rest_length(item, nearest.kinematics) for item in load.springs))
    rounded = rounded_advice(robot) if robot.loops else ""
    state = equilibrium(Search(robot.tree, load, free, rounded, robot.coordinates), nearest.configuration)
    if (here := _untwisted(load, robot, state.balance.configuration)) is not load:
        state = equilibrium(Search(robot.tree, here, free, rounded, robot.coordinates), state.balance.configuration)
    return _posture(robot, state, free, start, nearest, rounded)


def guess_with_followers(robot: RobotModel, guess) -> np.ndarray:
    """The guess as a configuration, in which joints that it does not name follow their leaders."""
    start = robot.tangent.configuration(guess)
    named = robot.joints if not isinstance(guess, Mapping) else guess
    step = np.zeros(robot.model.nv)
    for item in robot.mimic_rows:
        if robot.joints[item.follower - 1] not in named:
            step[robot.model.joints[item.follower].idx_v] = -item.gap(robot.model, start)
    return robot.tree.moved(start, step)


def _fixed_coordinates(robot: RobotModel, hold) -> np.ndarray:
    """Whether each coordinate is fixed at the guess."""
    if isinstance(hold, str) and hold != "all":
        hold = (hold,)
    if not isinstance(hold, Iterable):
        raise InputError(f'hold: found {hold!r}; expected names of joints, or "all"')
    followers = [robot.joints[item.follower - 1] for item in robot.mimic_rows]
    single = [name for name in robot.joints if name in robot.coordinates and name not in followers]
    fixed = np.zeros(len(robot.coordinates), bool)
    for name in (*(single if hold == "all" else hold), *robot.flexible_joints):
        for coordinate in robot.tangent.coordinates_of(name) if name in robot.joints else (name,):
            fixed[robot.tangent.place(coordinate, "hold")] = True
    follows = np.isin(robot.coordinates, followers)
    return fixed | ((robot.rests_at_guess | (robot.position_gains > 0)) & ~follows)


def attached_load(robot: RobotModel, start: np.ndarray, forces) -> Load:
    """The loads, with the frames of loops and springs at the guess."""
    if not isinstance(forces, Mapping):
        raise InputError(f'forces: found {type(forces).__name__}; expected numbers by joint, such as {{"j1": 2.0}}')
    forces = {**robot.lift, **forces}
    at_guess, bodies = Kinematics(robot.tree, start), robot.link_frames
    points = {key: value for key, value in forces.items() if isinstance(key, PointMotion)}
    loops = tuple(with_rest_length(bodies.attached(loop, at_guess), at_guess) for loop in robot.loops)
    springs = tuple(bodies.attached(spring, at_guess) for spring in robot.springs)
    return Load(
        loops=loops,
        springs=springs,
        mimic_rows=robot.mimic_rows,
        joint_stiffness=robot.joint_stiffness,
        joint_rest=np.where(robot.rests_at_guess, robot.tangent.angles(start), robot.joint_rest),
        joint_force=robot.tangent.vector({key: value for key, value in forces.items() if key not in points}, "forces"),
        point_forces={
            key: (bodies.point(key, "forces"), real_number(value, f"forces: on {key.body}")) for key, value in points.items()
        },
        units=robot.units,
        size=_size(robot, (*loops, *springs)),
        tendons=tuple(tendon.attached(robot.tangent, bodies, robot.locked, at_guess) for tendon in robot.source.tendons),
    )


def _untwisted(load: Load, robot: RobotModel, q: np.ndarray) -> Load:
    """The load with its hinges, if there are any, at angle 0 in a configuration."""
    if not any(item.connection.kind in TURNING for item in load.loops):
        return load
    at = Kinematics(robot.tree, q)
    loops = tuple(untwisted(item, at) for item in load.loops)
    return replace(load, loops=loops)


def _size(robot: RobotModel, connections) -> float:
    """A characteristic length of the robot (m), independent of its place."""
    model = robot.model
    anchors = [anchor for item in connections for anchor in (item.first, item.second)]
    places = [(int(model.parents[joint]), np.array(model.jointPlacements[joint].translation)) for joint in range(1, model.njoints)]
    places += [(anchor.joint, anchor.point) for anchor in anchors]
    on_ground = [place for joint, place in places if not joint]
    centre = np.mean(on_ground, axis=0) if on_ground else np.zeros(3)
    lengths = [np.linalg.norm(place if joint else place - centre) for joint, place in places]
    lengths += [np.linalg.norm(inertia.lever) for inertia in list(model.inertias)[1:]]
    return float(max(lengths, default=0.0)) or 1.0


def _balance_with_all_digits(robot: RobotModel, q: np.ndarray, guess: np.ndarray) -> Balance:
    """The balance in the configuration with closed loops next to q, of the robot with the rounded angles of its joints and loops as
    multiples of pi/4 to all digits; payloads are left out.
    """
    twin, description = copy(robot), deepcopy(robot.description)
    for origin in description.iterfind("joint/origin[@rpy]"):
        origin.set("rpy", " ".join(repr(_all_digits(text)) for text in origin.get("rpy", "").split()))
    twin.tree = Tree(robot.model_of(description))
    twin.link_frames = LinkFrames(twin.model, {})

    def exact(angles: Sequence[float]) -> list[float]:
        return [_all_digits(repr(angle)) for angle in angles]

    twin.loops = tuple(replace(loop, rotation1=exact(loop.rotation1), rotation2=exact(loop.rotation2)) for loop in robot.loops)
    load = _untwisted(attached_load(twin, guess, {}), twin, q)
    return closed(Search(twin.tree, load, np.ones(len(twin.coordinates), bool)), q)


def _posture(robot: RobotModel, state: Equilibrium, free: np.ndarray, guess: np.ndarray, nearest: Balance, rounded: str) -> Posture:
    balance = state.balance
    kept, notices = loop_rows(balance, nearest, rounded, lambda: _balance_with_all_digits(robot, balance.configuration, guess))
    left = balance.force - balance.jacobian.T @ state.multipliers
    posture = Posture(
        robot=robot,
        configuration=balance.configuration,
        multipliers=state.multipliers,
        torques={robot.coordinates[i]: float(left[i]) for i in np.flatnonzero(~free)},
        residual=state.residual,
        loop_error=float(np.abs(balance.gaps).max(initial=0.0)),
        notices=(
            *_distance_notices(robot, state, guess),
            *notices,
            *_load_notices(robot, state, len(kept)),
            *contact_notices(state, free),
            *robot.description_notices,
            *_assumption_notices(robot, state, free, guess),
        ),
        balance=balance,
        independent_rows=kept,
    )
    return replace(posture, notices=(*posture.notices, *instability(posture)))


def _distance_notices(robot: RobotModel, state: Equilibrium, guess: np.ndarray) -> Iterator[Notice]:
    """Notices on a posture far from the guess, and on loops that the joints keep open within the rounding errors of a URDF."""
    load = state.balance.load
    step = robot.tree.difference(guess, state.balance.configuration)
    furthest = int(np.abs(step / load.lengths).argmax())
    if abs(step[furthest]) > LARGEST_STEP * load.lengths[furthest]:
        text = (
            f"the posture is far from the guess: {robot.coordinates[furthest]} is {abs(step[furthest]):.3g} {load.units[furthest]} "
            "from it, perhaps in another assembly; check that it is the intended one"
        )
        yield Notice(NoticeKind.DISTANT_POSTURE, text)
    if state.misfit > LOOPS_CLOSED:
        row, gap, unit = state.balance.widest_gap
        text = f"the joints keep the loop row {row} open by {gap:.2g} {unit}, as where axes in the URDF are rounded"
        yield Notice(NoticeKind.RANK, f"{text}; the motion keeps this gap")


def _load_notices(robot: RobotModel, state: Equilibrium, independent: int) -> Iterator[Notice]:
    """Notices on a load that statics does not share among joints and loops, and on joints beyond their limits, which the equations ignore."""
    if state.rows.rank < independent:
        text = (
            "statics does not determine how fixed joints and loops share the load: the loop forces have the least norm and the "
            "joints carry the rest; with other shares the stiffness would differ"
        )
        yield Notice(NoticeKind.REDUNDANT, text)
    if outside := robot.tangent.outside_limits(robot.tangent.values(state.balance.configuration), JOINT_LIMIT):
        yield Notice(NoticeKind.OMITTED, f"{outside}; the equations have no limits")


def _assumption_notices(robot: RobotModel, state: Equilibrium, free: np.ndarray, guess: np.ndarray) -> Iterator[Notice]:
    """Notices on dry friction, on springs without a rest length, with the gap that the guess leaves in the loops there, and on joints
    that a constant load without stiffness keeps in place.
    """
    balance = state.balance
    if dry := [name for name, friction in zip(robot.coordinates, robot.model.friction) if friction]:
        yield Notice(NoticeKind.OMITTED, f"dry friction of {listed(dry, what=' joints')} is left out: it is not linear")
    for item in balance.load.springs:
        spring = item.connection
        if isinstance(spring, BodySpring) and spring.stiffness and spring.rest_length is None and spring.preload is None:
            gap = float(np.abs(Balance(robot.tree, balance.load, guess).gaps).max(initial=0.0))
            opened = f", after its loops, open by up to {gap:.2g} (m, rad), were closed" if gap > LOOPS_CLOSED_AS_ROUNDED else ""
            text = f"it has no rest_length; its length at the guess, {item.rest_length:.6g} m, is taken{opened}"
            yield Notice(NoticeKind.OMITTED, f"{spring.label}: {text}")
    stiff = (robot.joint_stiffness > 0) | (robot.position_gains > 0)
    soft = [name for name in np.array(robot.coordinates)[~free & ~stiff].tolist() if name not in robot.flexible_joints]
    if soft:
        text = (
            f"a constant load keeps {listed(soft, MOST_NAMES)} in place and adds no stiffness: "
            f"{'they move' if len(soft) > 1 else 'it moves'} under any other force; locked joints do not move, and joint_stiffness or a "
            "position gain holds them elastically"
        )
        yield Notice(NoticeKind.STATIC_LOAD, text)
