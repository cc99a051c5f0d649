"""From a guess to a posture: which joints may move, what acts, loops closed, then the balance of forces."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks import real_number
from ...errors import InputError
from ...notices import Notice
from .balance import Load
from .equilibrium import CLOSED, LARGEST_STEP, Equilibrium, Search, closed, equilibrium
from .kinematics import Kinematics
from .mechanism import untwisted, with_rest_length
from .point_motion import PointMotion
from .posture import Posture
from .regularity import loop_rows
from .rounded import rounded_advice

if TYPE_CHECKING:
    from .robot import Robot

#: A joint may be this far beyond its limits (rad, m): rounding of a guess at the limit.
AT_LIMIT = 1e-9


def find_posture(robot: Robot, guess, forces: Mapping, hold: Sequence[str] | str) -> Posture:
    """See ``Robot.equilibrium``."""
    start = _following(robot, guess)
    free = ~_held(robot, hold)
    load = _untwisted(_load(robot, start, forces), robot, start)
    nearest = closed(Search(robot.tree, load, free), start)
    load = replace(load, springs=tuple(with_rest_length(item, nearest.kinematics) for item in load.springs))
    rounded = rounded_advice(robot) if robot.loops else ""
    found = equilibrium(Search(robot.tree, load, free, rounded), nearest.configuration)
    if (here := _untwisted(load, robot, found.balance.configuration)) is not load:
        found = equilibrium(Search(robot.tree, here, free, rounded), found.balance.configuration)
    if outside := robot.tangent.outside_limits(found.balance.configuration, AT_LIMIT):
        raise InputError(f"equilibrium: {outside}; give another guess, or other limits in the URDF")
    return _posture(robot, found, free, start, rounded)


def _following(robot: Robot, guess) -> np.ndarray:
    """The guess as a configuration, in which joints that it does not name follow their leaders."""
    start = robot.tangent.configuration(guess)
    named = robot.joints if not isinstance(guess, Mapping) else guess
    step = np.zeros(robot.model.nv)
    for item in robot.couplings:
        if robot.joints[item.follower - 1] not in named:
            step[robot.model.joints[item.follower].idx_v] = -item.gap(robot.model, start)
    return robot.tree.moved(start, step)


def _held(robot: Robot, hold) -> np.ndarray:
    """Which coordinates keep the guess."""
    if isinstance(hold, str) and hold != "all":
        hold = (hold,)
    if not isinstance(hold, Iterable):
        raise InputError(f'hold: found {hold!r}; expected names of joints, or "all"')
    followers = [robot.joints[item.follower - 1] for item in robot.couplings]
    single = [name for name in robot.joints if name in robot.coordinates and name not in followers]
    held = np.zeros(len(robot.coordinates), bool)
    for name in (*(single if hold == "all" else hold), *robot.flexible_joints):
        held[robot.tangent.place(name, "hold")] = True
    return held


def _load(robot: Robot, start: np.ndarray, forces) -> Load:
    """What acts, the frames of loops and springs found at the guess."""
    if not isinstance(forces, Mapping):
        raise InputError(f'forces: found {type(forces).__name__}; expected numbers by joint, such as {{"j1": 2.0}}')
    at_guess, bodies = Kinematics(robot.tree, start), robot.link_frames
    points = {key: value for key, value in forces.items() if isinstance(key, PointMotion)}
    loops = tuple(bodies.attached(loop, at_guess) for loop in robot.loops)
    springs = tuple(bodies.attached(spring, at_guess) for spring in robot.springs)
    return Load(
        loops=loops,
        springs=springs,
        couplings=robot.couplings,
        joint_stiffness=robot.joint_stiffness,
        joint_rest=robot.joint_rest,
        joint_force=robot.tangent.vector({key: value for key, value in forces.items() if key not in points}, "forces"),
        point_forces={
            key: (bodies.point(key, "forces"), real_number(value, f"forces: on {key.body}")) for key, value in points.items()
        },
        units=robot.units,
        size=_size(robot, (*loops, *springs)),
    )


def _untwisted(load: Load, robot: Robot, q: np.ndarray) -> Load:
    """The load with its hinges, if there are any, at angle 0 in a configuration."""
    if not any(item.connection.kind == "hinge" for item in load.loops):
        return load
    at = Kinematics(robot.tree, q)
    loops = tuple(untwisted(item, at) for item in load.loops)
    return replace(load, loops=loops)


def _size(robot: Robot, connections) -> float:
    """A length that is typical for the robot (m), wherever it stands."""
    model = robot.model
    anchors = [anchor for item in connections for anchor in (item.first, item.second)]
    places = [(int(model.parents[joint]), np.array(model.jointPlacements[joint].translation)) for joint in range(1, model.njoints)]
    places += [(anchor.joint, anchor.point) for anchor in anchors]
    on_ground = [place for joint, place in places if not joint]
    centre = np.mean(on_ground, axis=0) if on_ground else np.zeros(3)
    lengths = [np.linalg.norm(place if joint else place - centre) for joint, place in places]
    lengths += [np.linalg.norm(inertia.lever) for inertia in list(model.inertias)[1:]]
    return float(max(lengths, default=0.0)) or 1.0


def _posture(robot: Robot, found: Equilibrium, free: np.ndarray, guess: np.ndarray, rounded: str) -> Posture:
    balance = found.balance
    rows = loop_rows(balance, rounded)
    left = balance.force - balance.jacobian.T @ found.multipliers
    shared = found.rows.rank < len(rows.kept)
    return Posture(
        robot=robot,
        configuration=balance.configuration,
        multipliers=found.multipliers,
        torques={robot.coordinates[i]: float(left[i]) for i in np.flatnonzero(~free)},
        residual=found.residual,
        loop_error=float(np.abs(balance.gaps).max(initial=0.0)),
        notices=(*_far(robot, found, guess), *_misfit(found), *rows.notices, *(_SHARED if shared else ()), *_left_out(robot)),
        balance=balance,
        independent_rows=rows.kept,
    )


_SHARED = (
    Notice(
        "redundant",
        "held joints and loops share their load in a way that statics does not determine: the loops take the least norm, the "
        "joints the rest; with other shares the stiffness would differ",
    ),
)


def _far(robot: Robot, found: Equilibrium, guess: np.ndarray) -> tuple[Notice, ...]:
    """A posture that is no longer near the guess."""
    load = found.balance.load
    way = robot.tree.way(guess, found.balance.configuration)
    furthest = int(np.abs(way / load.lengths).argmax())
    if abs(way[furthest]) <= LARGEST_STEP * load.lengths[furthest]:
        return ()
    text = (
        f"the posture found is not near the guess: {robot.coordinates[furthest]} is {abs(way[furthest]):.3g} {load.units[furthest]} "
        "from it, perhaps by way of another assembly; see whether it is the one that is meant"
    )
    return (Notice("far", text),)


def _misfit(found: Equilibrium) -> tuple[Notice, ...]:
    """Loops that the joints keep open by no more than the rounding of a URDF."""
    if found.misfit <= CLOSED:
        return ()
    row, gap, unit = found.balance.widest_gap
    text = f"the joints keep the loop row {row} open by {gap:.2g} {unit}, as where axes in the URDF are rounded; it stays so"
    return (Notice("rank", text),)


def _left_out(robot: Robot) -> tuple[Notice, ...]:
    """What the URDF says and no linear model can have."""
    dry = [name for name, friction in zip(robot.coordinates, robot.model.friction) if friction]
    named = ", ".join(dry[:3]) + (f" and {len(dry) - 3} more joints" if len(dry) > 3 else "")
    return (Notice("left out", f"dry friction of {named} is left out: it is not linear"),) if dry else ()
