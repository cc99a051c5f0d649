"""Inverse kinematics of a point of a robot, and its modes along a path of that point.

A place that the point should reach is a loop between the ground and the body: the Gauss-Newton steps that close loops solve it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..ground.checks import listed, real_array
from ..ground.display import Displayed, TextTable, notice_table, number_text
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import JOINT_LIMIT, LOOPS_CLOSED_AS_ROUNDED
from ..ground.units import GROUND
from .connections import Loop, LoopKind
from .kinematics import Kinematics
from .linearized import LinearizedRobot, linearized_robot
from .posture_search import attached_load, find_posture, guess_with_followers
from .robot_model import RobotModel
from .statics import Posture, Search, closed

if TYPE_CHECKING:
    from ..mechanics.modes import Modes
    from .statics import Load

#: Starts of the search: the guess, then places near it, since an arm that is stretched cannot bend to first order; then as many near the
#: middle of the limits.
STARTS = 8

#: Distance of the starts from the guess, in rad or relative to the robot's size.
AWAY = 0.3

#: Steps towards a target.
STAGES = 10

#: Modes of neighbouring points whose shapes agree by less are reported.
TRACKED = 0.5

#: Frequencies in the columns of the table, which is as wide as a terminal.
MOST_COLUMNS = 5


@dataclass(frozen=True, eq=False)
class Target:
    """Target of an inverse kinematics problem."""

    body: str  # a link
    point: np.ndarray  # point of the link, in its frame (m), shape (3,)
    place: np.ndarray  # target position of the point (m), shape (3,)
    orientation: np.ndarray | None  # roll, pitch, yaw (rad) of the body, shape (3,); None for any

    @property
    def loop(self) -> Loop:
        """The loop that is closed at the target."""
        kind: LoopKind = "point" if self.orientation is None else "rigid"
        turned = np.zeros(3) if self.orientation is None else self.orientation
        place, point, rotation = (tuple(vector.tolist()) for vector in (self.place, self.point, turned))
        return Loop(GROUND, place, self.body, point, kind, rotation1=rotation, name="target")

    def stages(self, robot: RobotModel, start: np.ndarray) -> list[Target]:
        """Targets from the pose of the body at a start to this one, on a straight line and about one axis."""
        import pinocchio

        R, place = Kinematics(robot.tree, start).frame(robot.link_frames.anchor(self.body, "body", self.point.tolist()))
        turn = np.zeros(3) if self.orientation is None else pinocchio.log3(R.T @ pinocchio.rpy.rpyToMatrix(*self.orientation))
        targets = []
        for share in np.linspace(0, 1, STAGES + 1)[1:-1]:
            turned = None if self.orientation is None else pinocchio.rpy.matrixToRpy(R @ pinocchio.exp3(share * turn))
            targets.append(replace(self, place=place + share * (self.place - place), orientation=turned))
        return [*targets, self]

    def reached(self, robot: RobotModel, load: Load, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
        """The configuration nearest to a start that reaches the target with closed loops."""
        item = robot.link_frames.attached(self.loop, Kinematics(robot.tree, start))
        load = replace(load, loops=(*load.loops, item))
        best = closed(Search(robot.tree, load, np.ones(len(robot.coordinates), bool)), start)
        left = -item.pose(best.kinematics).value[:3]
        return best.configuration, left, bool(np.abs(best.scaled_gaps).max() <= LOOPS_CLOSED_AS_ROUNDED)


def inverse_kinematics(robot: RobotModel, goal: Target, guess) -> np.ndarray:
    """The configuration near a guess that reaches a target, within the limits of the joints if the search finds one there."""
    robot.link_frames.check(goal.body, "inverse kinematics")
    start = guess_with_followers(robot, guess)
    load, nearest, beyond = attached_load(robot, start, {}), np.full(3, np.inf), None
    for q in _starts(robot, start, load.lengths):
        for stage in goal.stages(robot, q):
            q, left, arrived = stage.reached(robot, load, q)
        if arrived and not robot.tangent.outside_limits(robot.tangent.values(q), JOINT_LIMIT):
            return q
        beyond = q if arrived and beyond is None else beyond
        nearest = min(nearest, left, key=np.linalg.norm)
    if beyond is not None:
        return beyond
    place, nearest_place = (", ".join(number_text(float(x)) for x in at) for at in (goal.place, goal.place - nearest))
    what = "" if goal.orientation is None else " with this orientation"
    raise InputError(
        f"inverse kinematics: {goal.body} does not reach ({place}) m{what} near the guess; it comes to ({nearest_place}) m, "
        f"{np.linalg.norm(nearest):.3g} m from it: give another guess, or a place within its reach"
    )


def _starts(robot: RobotModel, guess: np.ndarray, lengths: np.ndarray) -> Iterator[np.ndarray]:
    """The guess and configurations near it; then both with all limited joints in the middle of their limits."""
    rng, angles, to_middle = np.random.default_rng(0), robot.tangent.angles(guess), np.zeros(len(lengths))
    for name, limits in robot.limits.items():
        if np.isfinite(limits).all():
            place = robot.coordinates.index(name)
            to_middle[place] = np.mean(limits) - angles[place]
    for centre in (guess, robot.tree.moved(guess, to_middle))[: 1 + to_middle.any()]:
        yield centre
        for _ in range(STARTS - 1):
            yield robot.tree.moved(centre, AWAY * lengths * rng.uniform(-1, 1, len(lengths)))


@dataclass(frozen=True, repr=False, eq=False)
class PathModes(Displayed):
    """The modes of a robot along a path of one of its points.

    Attributes:
        places: of the point (m), shape (P, 3).
        lengths: lengths of the path up to each place (m), shape (P,).
        postures: at each place; None where it is not reached.
        distances: to each place from where the point is, or of places that are not reached from the nearest place of the search (m),
            shape (P,).
        systems: linearized about the postures.
        natural_frequencies: of the modes without damping, each followed from place to place by its shape, ascending at the first place,
            shape (P, m) (rad/s); NaN where there is none.
        assurance: modal assurance criterion of each mode with its shape at the last position, weighted with the mass, from 0 to 1,
            shape (P, m).
    """

    places: np.ndarray
    lengths: np.ndarray
    postures: tuple[Posture | None, ...]
    distances: np.ndarray
    systems: tuple[LinearizedRobot | None, ...]
    natural_frequencies: np.ndarray
    assurance: np.ndarray

    @property
    def frequencies_hz(self) -> np.ndarray:
        """Natural frequencies in Hz."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def unreachable(self) -> tuple[int, ...]:
        """Indices of the positions that are not reached."""
        return tuple(i for i, posture in enumerate(self.postures) if posture is None)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on positions that are not reached, modes of uncertain continuation, and joints beyond their limits."""
        return tuple(self._notices())

    def _notices(self) -> Iterator[Notice]:
        if missed := self.unreachable:
            named = listed([f"{i + 1} ({self.distances[i]:.2g} m remain)" for i in missed], 4)
            yield Notice(NoticeKind.OMITTED, f"{len(missed)} of {len(self.places)} places are not reached: {named}")
        doubtful = np.argwhere(self.assurance < TRACKED)
        if len(doubtful):
            place, mode = doubtful[0]
            text = f"{len(doubtful)} steps of modes are doubtful, the first of mode {mode + 1} at place {place + 1}: its shape agrees by"
            yield Notice(
                NoticeKind.OMITTED, f"{text} {self.assurance[place, mode]:.2f} only; give more places, or modes cross there"
            )
        beyond = [
            i
            for i, posture in enumerate(self.postures)
            if posture and posture.robot.tangent.outside_limits(posture.joints, JOINT_LIMIT)
        ]
        if beyond:
            yield Notice(
                NoticeKind.OMITTED, f"joints are beyond their limits at {len(beyond)} places, the first of them {beyond[0] + 1}"
            )

    def _summary(self) -> str:
        return f"{len(self.places)} places, {self.natural_frequencies.shape[1]} modes"

    @property
    def table(self) -> TextTable:
        """The positions with the frequencies of the first modes (Hz)."""
        shown = self.frequencies_hz[:, :MOST_COLUMNS]
        titles = ("place", "x (m)", "y (m)", "z (m)", *(f"mode {k + 1}" for k in range(shown.shape[1])))
        rows = [
            (str(i + 1), *(f"{x:.4g}" for x in place), *("" if np.isnan(f) else f"{f:.4g}" for f in row))
            for i, (place, row) in enumerate(zip(self.places, shown))
        ]
        count = self.frequencies_hz.shape[1]
        note = f"The first {MOST_COLUMNS} of {count} modes." if count > MOST_COLUMNS else ""
        return TextTable("Frequencies along the path in Hz", titles, tuple(rows), note)

    def _tables(self) -> tuple[TextTable, ...]:
        return self.table, notice_table(self.notices)


def modes_along(robot: RobotModel, goal: Target, places, guess, hold, forces: Mapping) -> PathModes:
    """The modes along a path; the arguments are those of ``Robot.modes_along``."""
    places = real_array(places, "places", shape=(None, 3))
    if not len(places):
        raise InputError("places: found none; expected an array of shape (P, 3)")
    goals = [replace(goal, place=place) for place in places]
    q, postures, distances = inverse_kinematics(robot, goals[0], guess), [], []
    load = attached_load(robot, q, {})
    for goal in goals:
        configuration, left, arrived = goal.reached(robot, load, q)
        q = configuration if arrived else q
        postures.append(find_posture(robot, q, forces, hold) if arrived else None)
        distances.append(_distance(postures[-1], goal) if arrived else float(np.linalg.norm(left)))
    systems = [None if posture is None else linearized_robot(posture) for posture in postures]
    modes = [None if system is None else system.modes(damped=False) for system in systems]
    frequencies, assurance = followed([None if system is None else system.mass for system in systems], modes)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])
    return PathModes(places, lengths, tuple(postures), np.array(distances), tuple(systems), frequencies, assurance)


def target(body: str, point, place, orientation) -> Target:
    """A validated target."""
    turned = None if orientation is None else real_array(orientation, "orientation", shape=(3,))
    return Target(body, real_array(point, "point", shape=(3,)), real_array(place, "place", shape=(3,)), turned)


def _distance(posture: Posture, target: Target) -> float:
    """Distance from the target at rest, where only the constrained joints keep the guess."""
    kinematics = posture.balance.kinematics
    return float(np.linalg.norm(posture.robot.link_frames.attached(target.loop, kinematics).pose(kinematics).value[:3]))


def followed(masses: list[np.ndarray | None], modes: list[Modes | None]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies in columns, one for each mode continued by its shape.

        MAC = (u^T M v)^2 / ((u^T M u) (v^T M v))

    The pairs of neighbouring points have the largest sum of it (Allemang, Sound and Vibration 37, 2003; linear assignment).
    """
    from scipy.optimize import linear_sum_assignment

    shapes: list[np.ndarray] = []
    rows: list[dict[int, tuple[float, float]]] = []
    for M, here in zip(masses, modes):
        rows.append({})
        if M is None or here is None:
            continue
        U = here.shapes.real / np.sqrt(np.einsum("im,ij,jm->m", here.shapes.real, M, here.shapes.real))
        V = np.array(shapes).reshape(-1, len(M)).T
        V = V / np.sqrt(np.einsum("im,ij,jm->m", V, M, V))
        agreement = (V.T @ M @ U) ** 2
        pairs = dict(zip(*linear_sum_assignment(-agreement.T)))
        for mode, frequency in enumerate(here.natural_frequencies):
            column = int(pairs.get(mode, len(shapes)))
            if mode not in pairs:
                shapes.append(U[:, mode])
            rows[-1][column] = float(frequency), float(agreement[column, mode]) if mode in pairs else np.nan
            shapes[column] = U[:, mode]
    table = np.full((2, len(rows), len(shapes)), np.nan)
    for i, row in enumerate(rows):
        for column, values in row.items():
            table[:, i, column] = values
    return table[0], table[1]
