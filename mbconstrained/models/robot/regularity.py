"""The rank of the rows of loops, and whether it is the same wherever the mechanism can move to.

Rows depend on each other in many good mechanisms: a planar loop closed in space, a parallelogram with a third crank.
Multipliers are then not unique, but motions are, as long as the rank stays the same along the motion. If m^T J = 0 for
a combination m of the rows, differentiating m(q)^T J(q) = 0 along the motion N z gives

    N^T (d(J^T m)/dq) N = 0,     N a basis of null(J),

so a posture where this matrix is not zero is singular: the loops can take another branch there, or cannot follow the
motion that the linear equations allow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...checks import counted
from ...errors import InputError
from ...notices import Notice
from .balance import Balance
from .equilibrium import DOUBTFUL_RANK, EXACT_RANK, RANK, Rows, rows_of

#: The second derivative along the motion, relative to that of single rows, above which a posture is singular. Rounded axes
#: leave RANK.
SINGULAR = 1e-4

#: Rows that are independent by less than this may be so because of angles that were written with two digits.
TILTED_RANK = 5e-3


@dataclass(frozen=True)
class LoopRows:
    """Which rows of the loops are independent.

    Attributes:
        kept: their places among all rows, ascending.
        notices: on dependent rows, and on those that are kept by a narrow margin.
    """

    kept: tuple[int, ...]
    notices: tuple[Notice, ...]


def loop_rows(balance: Balance, rounded: str = "") -> LoopRows:
    """The rank of J in a closed configuration, in coordinates and rows that compare.

    Args:
        rounded: what to say of rounded angles of the robot, or an empty string.

    Raises:
        InputError: the posture is singular.
    """
    load = balance.load
    J = balance.scaled_jacobian
    rows = rows_of(J)
    _check_regular(balance, rows.combinations.T / load.row_lengths, rows.motions)
    order = scipy.linalg.qr(J.T, mode="economic", pivoting=True)[2] if J.size else np.arange(len(J))
    kept = tuple(sorted(order[: rows.rank].tolist()))
    empty = np.abs(J).max(axis=1, initial=0.0) <= RANK
    notices = _redundant({load.row_names[row]: bool(empty[row]) for row in range(len(J)) if row not in kept})
    return LoopRows(kept, (*notices, *_narrow(rows, rounded)))


def _narrow(rows: Rows, rounded: str) -> list[Notice]:
    """What to say where the rank is not clear."""
    found, values, rank = [], rows.relative, rows.rank
    if rank < len(values) and values[rank] > EXACT_RANK:
        text = (
            f"rows of the loops that were left out are dependent to {values[rank]:.1e} only, as where axes in the URDF are "
            "rounded; if this is meant, the robot is near a singular posture: choose another"
        )
        found.append(Notice("rank", text))
    if rank and values[rank - 1] < DOUBTFUL_RANK:
        text = (
            f"the rows of the loops are almost dependent (relative singular value {values[rank - 1]:.1e}): the posture is near a "
            "singular one, and small forces move the robot far"
        )
        found.append(Notice("rank", text, doubtful=True))
    elif rounded and rank and values[rank - 1] < TILTED_RANK:
        left = rows.motions.shape[1]
        text = (
            f"the loops leave {counted(left, 'motion')}, and one more is held by little (relative singular value "
            f"{values[rank - 1]:.1e}): {rounded}"
        )
        found.append(Notice("rank", text, doubtful=True))
    return found


def _check_regular(balance: Balance, combinations: np.ndarray, motions: np.ndarray) -> None:
    """N^T (d(J^T m)/dq) N = 0 for every combination m of rows that is zero, shape (c, m)."""
    if not combinations.size or not motions.size:
        return
    usual = max(np.abs(_second(balance, row)).max() for row in np.diag(1 / balance.load.row_lengths))
    for combination in combinations:
        if np.abs(motions.T @ _second(balance, combination) @ motions).max() > SINGULAR * usual:
            least = 0.1 * np.abs(combination).max()
            rows = [name for name, part in zip(balance.load.row_names, combination) if abs(part) > least]
            raise InputError(
                f"equilibrium: the posture is singular: a combination of the rows {', '.join(rows)} holds nothing here but does "
                "in the neighbourhood, so that linear equations do not tell how the robot can move; choose a posture away from it"
            )


def _second(balance: Balance, combination: np.ndarray) -> np.ndarray:
    """d(J^T m)/dq in coordinates that compare, shape (nv, nv)."""
    lengths = balance.load.lengths
    return np.sum(balance.geometric(combination), axis=0) * np.outer(lengths, lengths)


def _redundant(rows: dict[str, bool]) -> list[Notice]:
    """What to say of rows that are left out, by name; those that no coordinate enters (True) are kept by the joints alone."""
    reasons = {
        True: "the joints keep {it} by themselves",
        False: "other rows imply {it}; multipliers of a motion are those of the rows left, those at rest have the least norm",
    }
    found = []
    for empty, reason in reasons.items():
        names = [name for name, is_empty in rows.items() if is_empty == empty]
        if names:
            one = len(names) == 1
            word, say, was = ("row", "says", "was") if one else ("rows", "say", "were")
            told = f"loop {word} {', '.join(names)} {say} nothing new and {was} left out"
            found.append(Notice("redundant", f"{told}: {reason.format(it='it' if one else 'them')}"))
    return found
