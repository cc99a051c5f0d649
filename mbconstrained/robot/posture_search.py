"""The search for a posture, from a guess: it closes the loops, then balances the forces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..ground.checks import real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import JOINT_LIMIT, LOOPS_CLOSED, LOOPS_CLOSED_AS_ROUNDED
from .connections import BodySpring, PointMotion
from .kinematics import Kinematics
from .linearization.stiffness import instability
from .mechanism import TURNING, untwisted, with_rest_length
from .posture import Posture
from .robot_model import RobotModel
from .statics.balance import Balance, Load
from .statics.contacts import contact_notices
from .statics.equilibrium import LARGEST_STEP, Equilibrium, Search, closed, equilibrium
from .statics.regularity import loop_rows, rounded_advice, with_all_digits

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


def _assumed_lengths(balance: Balance, robot: RobotModel, guess: np.ndarray) -> Iterator[Notice]:
    """A notice for each spring without a rest length, with the gap that the guess leaves in the loops there."""
    for item in balance.load.springs:
        spring = item.connection
        if isinstance(spring, BodySpring) and spring.stiffness and spring.rest_length is None and spring.preload is None:
            gap = float(np.abs(Balance(robot.tree, balance.load, guess).gaps).max(initial=0.0))
            closed_first = (
                f", after its loops, open by up to {gap:.2g} (m, rad), were closed" if gap > LOOPS_CLOSED_AS_ROUNDED else ""
            )
            text = f"it has no rest_length; its length at the guess, {item.rest_length:.6g} m, is taken{closed_first}"
            yield Notice(NoticeKind.OMITTED, f"{spring.label}: {text}")


def _balance_with_all_digits(robot: RobotModel, q: np.ndarray, guess: np.ndarray) -> Balance:
    """The balance of a robot with its rounded angles replaced by exact ones, in the configuration with closed loops next to q."""
    twin = with_all_digits(robot)
    load = _untwisted(attached_load(twin, guess, {}), twin, q)
    return closed(Search(twin.tree, load, np.ones(len(twin.coordinates), bool)), q)


def _posture(robot: RobotModel, state: Equilibrium, free: np.ndarray, guess: np.ndarray, nearest: Balance, rounded: str) -> Posture:
    balance = state.balance
    rows = loop_rows(balance, nearest, rounded, lambda: _balance_with_all_digits(robot, balance.configuration, guess))
    left = balance.force - balance.jacobian.T @ state.multipliers
    shared = state.rows.rank < len(rows.kept)
    posture = Posture(
        robot=robot,
        configuration=balance.configuration,
        multipliers=state.multipliers,
        torques={robot.coordinates[i]: float(left[i]) for i in np.flatnonzero(~free)},
        residual=state.residual,
        loop_error=float(np.abs(balance.gaps).max(initial=0.0)),
        notices=(
            *_far(robot, state, guess),
            *_misfit(state),
            *rows.notices,
            *(_SHARED if shared else ()),
            *_beyond_limits(robot, balance.configuration),
            *contact_notices(state, free),
            *_left_out(robot),
            *_assumed_lengths(balance, robot, guess),
            *_without_stiffness(robot, free),
        ),
        balance=balance,
        independent_rows=rows.kept,
    )
    return replace(posture, notices=(*posture.notices, *instability(posture)))


_SHARED = (
    Notice(
        NoticeKind.REDUNDANT,
        "statics does not determine how fixed joints and loops share the load: the loop forces have the least norm and the "
        "joints carry the rest; with other shares the stiffness would differ",
    ),
)


def _far(robot: RobotModel, state: Equilibrium, guess: np.ndarray) -> tuple[Notice, ...]:
    """A notice on a posture far from the guess."""
    load = state.balance.load
    step = robot.tree.difference(guess, state.balance.configuration)
    furthest = int(np.abs(step / load.lengths).argmax())
    if abs(step[furthest]) <= LARGEST_STEP * load.lengths[furthest]:
        return ()
    text = (
        f"the posture is far from the guess: {robot.coordinates[furthest]} is {abs(step[furthest]):.3g} {load.units[furthest]} "
        "from it, perhaps in another assembly; check that it is the intended one"
    )
    return (Notice(NoticeKind.DISTANT_POSTURE, text),)


def _misfit(state: Equilibrium) -> tuple[Notice, ...]:
    """A notice on loops that the joints keep open within the rounding errors of a URDF."""
    if state.misfit <= LOOPS_CLOSED:
        return ()
    row, gap, unit = state.balance.widest_gap
    text = f"the joints keep the loop row {row} open by {gap:.2g} {unit}, as where axes in the URDF are rounded; the motion keeps this gap"
    return (Notice(NoticeKind.RANK, text),)


def _beyond_limits(robot: RobotModel, q: np.ndarray) -> tuple[Notice, ...]:
    """A notice on joints beyond their limits, which the equations ignore."""
    outside = robot.tangent.outside_limits(robot.tangent.values(q), JOINT_LIMIT)
    return (Notice(NoticeKind.OMITTED, f"{outside}; the equations have no limits"),) if outside else ()


def _without_stiffness(robot: RobotModel, free: np.ndarray) -> tuple[Notice, ...]:
    """A notice on joints that a constant load without stiffness keeps in place."""
    stiff = (robot.joint_stiffness > 0) | (robot.position_gains > 0)
    soft = [name for name in np.array(robot.coordinates)[~free & ~stiff].tolist() if name not in robot.flexible_joints]
    if not soft:
        return ()
    named = ", ".join(soft[:MOST_NAMES]) + (f" and {len(soft) - MOST_NAMES} more" if len(soft) > MOST_NAMES else "")
    text = (
        f"a constant load keeps {named} in place and adds no stiffness: {'they move' if len(soft) > 1 else 'it moves'} under any other "
        "force; locked joints do not move, and joint_stiffness or a position gain holds them elastically"
    )
    return (Notice(NoticeKind.STATIC_LOAD, text),)


def _left_out(robot: RobotModel) -> tuple[Notice, ...]:
    """Notices of the description, and one on its parts that a linear model cannot contain."""
    dry = [name for name, friction in zip(robot.coordinates, robot.model.friction) if friction]
    named = ", ".join(dry[:3]) + (f" and {len(dry) - 3} more joints" if len(dry) > 3 else "")
    friction = (Notice(NoticeKind.OMITTED, f"dry friction of {named} is left out: it is not linear"),) if dry else ()
    return (*robot.description_notices, *friction)
