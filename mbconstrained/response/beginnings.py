"""Where a force begins after t = 0: the first moments after it, in which a motion has not come apart from the deflection that follows.

A mass on a soft spring moves by far less than a force would deflect it at rest, and the difference of the two deflections has
none of its digits. So a short pulse, and the first moments of a lasting force, are followed from where the motion is instead.
What begins with t = 0 and lasts is left out: there the Taylor series serves.
"""

from __future__ import annotations

import numpy as np

from ..linalg.blocks import block_slices
from ..signals.bohl import BohlFunction

#: A force begins where it was zero before, or so many times smaller.
MUCH_SMALLER = 8.0


def first_moments(force: BohlFunction, knots: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Knots, with those added at which the first moments end, and which of the pieces that begin there belong to them.

    Args:
        force: what acts, of any size.
        knots: its K knots, ascending from 0.
        reach: how long the first moments are at most, in s; a power of two is taken: times are as exact after it as before.

    Returns:
        Knots of shape (K + more,) and as many truth values.
    """
    nothing = knots, np.zeros(len(knots), dtype=bool)
    if len(knots) == 1 or not 0 < reach < np.inf:
        return nothing
    reach = 2.0 ** np.floor(np.log2(reach))
    states = np.abs(force.with_knots(knots).restarts.states)
    places = [_beginnings(states[at].max(axis=0)) for at in block_slices(force.blocks)]
    begins = knots[np.unique(np.concatenate([np.zeros(0, dtype=int), *places]))]
    begins = begins[(begins > 0) | (knots[1] < reach)]
    if not len(begins):
        return nothing
    ends = begins + reach
    more = np.union1d(knots, ends[ends > begins])
    last = np.searchsorted(begins, more, side="right") - 1
    return more, (last >= 0) & (more < ends[last])


def _beginnings(sizes: np.ndarray) -> np.ndarray:
    """The places at which something begins.

    >>> _beginnings(np.array([0.0, 1.0, 2.0, 0.5, 40.0, 0.0, 0.0, 1e-3])).tolist()
    [1, 4, 7]
    """
    found, largest = [], 0.0
    for place, size in enumerate(sizes.tolist()):
        if size > MUCH_SMALLER * largest:
            found.append(place)
        largest = max(largest, size) if size else 0.0
    return np.array(found, dtype=int)
