"""Rigid-body modes from the elements: coordinates that no spring, damper or constraint row restrains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, noise_of
from ...mechanics.element_matrix import ElementMatrix

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem

#: Beyond this ratio of its entries a matrix may have lost a soft spring, so that nothing is said of what it holds.
WIDEST = EPS**-0.5
MOST_NAMES = 8
LARGEST = 200  # coordinates: larger models show rigid-body modes in their eigenvalues, which a run computes


def free_motion_notices(system: MechanicalSystem) -> tuple[Notice, ...]:
    """Notices on unconstrained groups of coordinates that move together: the rigid-body modes visible in the elements.

    None for large models, and none where a matrix may have lost digits.

    >>> from mbconstrained import LumpedModel
    >>> model = LumpedModel()
    >>> _ = model.mass("cart", 3.0), model.mass("load", 1.0), model.spring("cart", "load", 1.0)
    >>> print(free_motion_notices(model.assemble())[0].text)
    cart and load: unconstrained; they can move freely together, a rigid-body mode
    """
    if system.size > LARGEST:
        return ()
    stiffness, damping, _ = system.given
    rows_of_elements = [_directions(stiffness), _directions(damping), system.constraint_matrix]
    if any(rows is None for rows in rows_of_elements):
        return ()
    free = _null_projection(np.vstack(rows_of_elements))
    groups = ((group, round(float(free[group, group].sum()))) for group in _groups(free))  # the trace of a projection is its rank
    return tuple(_notice([system.names[i] for i in group], count) for group, count in groups)


def _directions(given: np.ndarray | ElementMatrix) -> np.ndarray | None:
    """Directions of elements or matrix rows, each of unit size; None where digits are lost."""
    if isinstance(given, ElementMatrix):
        rows = given.directions[given.constants != 0]
    else:
        sizes = np.abs(given[given != 0])
        if sizes.size and sizes.max() > WIDEST * sizes.min():
            return None
        rows = given
    lengths = np.abs(rows).max(axis=1, initial=0.0)
    return rows[lengths > 0] / lengths[lengths > 0, None]


def _null_projection(rows: np.ndarray) -> np.ndarray:
    """The orthogonal projection onto the null space of the rows."""
    _, sizes, right = np.linalg.svd(rows, full_matrices=True)
    rank = int((sizes > noise_of(sizes.max(initial=0.0), max(rows.shape))).sum())
    return right[rank:].T @ right[rank:]


def _groups(free: np.ndarray) -> list[np.ndarray]:
    """Coordinates that move together."""
    from scipy.sparse.csgraph import connected_components

    moving = np.abs(free) > EPS**0.5
    _, labels = connected_components(moving, directed=False)
    groups = [np.flatnonzero(labels == label) for label in dict.fromkeys(labels)]
    return [group for group in groups if moving[group[0], group[0]]]


def _notice(names: list[str], count: int) -> Notice:
    shown = names if len(names) <= MOST_NAMES else [*names[: MOST_NAMES - 1], f"{len(names) - MOST_NAMES + 1} more"]
    listed = " and ".join(filter(None, [", ".join(shown[:-1]), shown[-1]]))
    who = "it can move freely" if len(names) == 1 else "they can move freely together"
    what = "a rigid-body mode" if count == 1 else counted(count, "rigid-body mode")
    return Notice(NoticeKind.RIGID_BODY, f"{listed}: unconstrained; {who}, {what}")
