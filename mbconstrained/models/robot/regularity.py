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

from ...errors import InputError
from ...notices import Notice
from .balance import Balance
from .equilibrium import RANK

#: Between this and RANK (relative singular values) a row is kept, and told to be almost dependent.
DOUBTFUL_RANK = 1e-6

#: The second derivative along the motion, relative to its largest entry before it is projected, above which a posture is
#: singular. Rounding leaves 1e-14; where rows are dependent only to RANK it leaves that.
SINGULAR = 1e-6


@dataclass(frozen=True)
class LoopRows:
    """Which rows of the loops are independent.

    Attributes:
        kept: their places among all rows, ascending.
        notices: on dependent rows, and on those that are kept by a narrow margin.
    """

    kept: tuple[int, ...]
    notices: tuple[Notice, ...]


def loop_rows(balance: Balance) -> LoopRows:
    """The rank of J in a closed configuration, columns over sqrt(M_ii), rows in m and rad each over their largest.

    Raises:
        InputError: the posture is singular.
    """
    weights, names = _row_weights(balance), balance.load.row_names
    J = weights[:, None] * balance.jacobian / balance.sizes
    left, values, right = np.linalg.svd(J)
    rank = int((values > RANK * values[0]).sum()) if values.size and values[0] else 0
    _check_regular(balance, (left[:, rank:] * weights[:, None]).T, right[rank:].T)
    order = scipy.linalg.qr(J.T, mode="economic", pivoting=True)[2] if J.size else np.arange(len(J))
    kept = tuple(sorted(order[:rank].tolist()))
    empty = np.abs(J).max(axis=1, initial=0.0) <= RANK
    notices = _redundant({names[row]: bool(empty[row]) for row in range(len(J)) if row not in kept})
    if rank and values[rank - 1] < DOUBTFUL_RANK * values[0]:
        text = (
            f"the rows of the loops are almost dependent (relative singular value {values[rank - 1] / values[0]:.1e}): "
            "the posture is near a singular one; small forces may move the robot far"
        )
        notices.append(Notice("rank", text, doubtful=True))
    return LoopRows(kept, tuple(notices))


def _row_weights(balance: Balance) -> np.ndarray:
    """One over the largest entry of all rows of the same unit, the columns of J over sqrt(M_ii); shape (m,)."""
    J = np.abs(balance.jacobian / balance.sizes)
    units = np.array(balance.load.row_units)
    return np.array([1.0 / (J[units == unit].max(initial=0.0) or 1.0) for unit in units])


def _check_regular(balance: Balance, combinations: np.ndarray, motions: np.ndarray) -> None:
    """N^T (d(J^T m)/dq) N = 0 for every combination m of rows that is zero, shape (c, m)."""
    if not combinations.size or not motions.size:
        return
    usual = max(np.abs(_second(balance, row)).max() for row in np.diag(_row_weights(balance)))
    for combination in combinations:
        if np.abs(motions.T @ _second(balance, combination) @ motions).max() > SINGULAR * usual:
            rows = [name for name, part in zip(balance.load.row_names, combination) if abs(part) > 0.1 * np.abs(combination).max()]
            raise InputError(
                f"equilibrium: the posture is singular: a combination of the rows {', '.join(rows)} holds nothing here but does "
                "in the neighbourhood, so that linear equations do not tell how the robot can move; choose a posture away from it"
            )


def _second(balance: Balance, combination: np.ndarray) -> np.ndarray:
    """d(J^T m)/dq, rows and columns over sqrt(M_ii), shape (nv, nv)."""
    return np.sum(balance.geometric(combination), axis=0) / np.outer(balance.sizes, balance.sizes)


def _redundant(rows: dict[str, bool]) -> list[Notice]:
    """What to say of rows that are left out, by name; those that no coordinate enters (True) are kept by the joints alone."""
    reasons = {
        True: "the joints keep {it} by themselves",
        False: "other rows imply {it}; multipliers of a motion are those of the rows that are left, those at rest have the least norm",
    }
    found = []
    for empty, reason in reasons.items():
        names = [name for name, is_empty in rows.items() if is_empty == empty]
        if names:
            one = len(names) == 1
            told = f"loop row{'' if one else 's'} {', '.join(names)} say{'s' if one else ''} nothing new and {'was' if one else 'were'} left out"
            found.append(Notice("redundant", f"{told}: {reason.format(it='it' if one else 'them')}"))
    return found
