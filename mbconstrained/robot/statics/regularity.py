"""The rank of the rows of loops, and whether it is constant along the motion.

Rows are dependent in many good mechanisms: a planar loop closed in space, a parallelogram with a third crank.
Multipliers are then not unique, but motions are, as long as the rank stays the same along the motion. If m^T J = 0 for
a combination m of the rows, differentiating m(q)^T J(q) = 0 along the motion N z gives

    N^T (d(J^T m)/dq) N = 0,     N a basis of null(J),

so a posture where this matrix is not zero is singular: the loops can take another branch there, or cannot follow the
motion that the linear equations allow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from copy import copy, deepcopy
from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np
import scipy.linalg

from ...ground.checks import counted
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import LEFT_OPEN, LOOP_RANK, LOOP_RANK_DOUBTFUL, LOOP_RANK_EXACT, LOOP_RANK_TILTED, SINGULAR_POSTURE
from ..description.urdf import skeleton
from ..kinematics import Tree, built_model
from ..mechanism import LinkFrames
from ..robot_model import RobotModel
from .balance import Balance
from .equilibrium import Rows, rows_of


@dataclass(frozen=True)
class LoopRows:
    """Independent rows of the loops.

    Attributes:
        kept: indices of the independent rows, ascending.
        notices: notices on dependent rows, and on rows that are independent by a narrow margin.
    """

    kept: tuple[int, ...]
    notices: tuple[Notice, ...]


def loop_rows(balance: Balance, nearest: Balance, rounded: str, with_all_digits: Callable[[], Balance]) -> LoopRows:
    """The rank of J in a closed configuration, in comparable units."""
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
    return LoopRows(kept, (*notices, *_narrow(rows, open_by, rounded, with_all_digits)))


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

#: Rounded angles that a message names; of the others it gives the number.
MOST_NAMED_ANGLES = 3


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
    angles = [*_of_joints(robot.description), *_of_loops(robot)]
    if not angles:
        return ""
    more = f" and {len(angles) - MOST_NAMED_ANGLES} more" if len(angles) > MOST_NAMED_ANGLES else ""
    one = len(angles) == 1
    text = f"{', '.join(angles[:MOST_NAMED_ANGLES])}{more} {'is' if one else 'are'} rounded"
    return f"{text}, which tilts axes that may be meant to be parallel: write {'it' if one else 'them'} with all digits (pi/2 is {math.pi / 2!r})"


def with_all_digits(robot: RobotModel) -> RobotModel:
    """The robot with the rounded angles of its joints and loops as multiples of pi/4 to all digits; payloads are left out."""
    twin, description = copy(robot), deepcopy(robot.description)
    for origin in description.iterfind("joint/origin[@rpy]"):
        origin.set("rpy", " ".join(repr(_all_digits(text)) for text in origin.get("rpy", "").split()))
    base, gravity = robot.base != "fixed", robot.model.gravity.linear
    twin.tree = Tree(built_model(skeleton(description), base, robot.locked, gravity))
    twin.link_frames = LinkFrames(twin.model, {})
    twin.loops = tuple(
        replace(
            loop,
            rotation1=[_all_digits(repr(angle)) for angle in loop.rotation1],
            rotation2=[_all_digits(repr(angle)) for angle in loop.rotation2],
        )
        for loop in robot.loops
    )
    return twin


def _all_digits(text: str) -> float:
    eighths = rounded_to(text)
    return float(text) if eighths is None else eighths * math.pi / 4


def _of_joints(description: ElementTree.Element) -> Iterator[str]:
    for joint in description.findall("joint"):
        origin = joint.find("origin")
        texts = [] if origin is None else origin.get("rpy", "").split()
        if worst := next(filter(rounded_to, texts), None):
            yield f'the rpy {worst} of joint "{joint.get("name")}"'


def _of_loops(robot: RobotModel) -> Iterator[str]:
    for loop in robot.loops:
        for key in ("rotation1", "rotation2"):
            if worst := next(filter(rounded_to, map(repr, getattr(loop, key))), None):
                yield f"the {key} {worst} of {loop.label}"
