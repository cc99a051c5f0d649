"""Kinks and jumps of a function known by its values.

Intervals on which a polynomial does not follow are halved; one that is still not followed when it is very short has an
edge in it (Pachon, Platte and Trefethen, Piecewise-smooth chebfuns, 2010). A jump is found by halving on, to rounding;
for a kink, also of a derivative, the polynomials on both sides are made to meet.
"""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from ..tolerances import EPS

#: The first pieces are end / 2^this long, so that no feature longer than a hundredth of the whole is missed.
FIRST_HALVINGS = 4

#: Pieces are at least end / 2^this long: shorter intervals that are not followed have an edge in them.
MOST_HALVINGS = 14

#: Edges are looked for down to intervals of this many units in the last place of the end.
EDGE_UNITS = 8

#: More places than this where the function is not followed are not edges: it is rough everywhere.
MOST_EDGES = 1000

REMEDY = "ask for a larger tolerance, a shorter time, or give a smoother function"


def edges_of(values, end: float) -> np.ndarray:
    """Where the function jumps or has a kink, between 0 and end.

    Args:
        values: the function, with its ``fit``, ``tolerance`` and ``largest`` value (``approximated``).

    Raises:
        InputError: it is rough everywhere.
    """
    length = end / 2**FIRST_HALVINGS
    begins, leaves = length * np.arange(2**FIRST_HALVINGS), []
    while len(begins):
        fit = values.fit(begins, np.full(len(begins), length))
        last = length < EDGE_UNITS * EPS * end
        done = fit.follows | last
        leaves += [(begin, length, fit.at(k)) for k, begin in enumerate(begins) if done[k]]
        if length * 2**MOST_HALVINGS < end and len(begins) > MOST_EDGES:
            raise InputError(
                f"function: it is too rough to be followed to {values.tolerance:g} near t = {begins[0]:.6g} s; {REMEDY}"
            )
        length, begins = length / 2, np.sort(np.concatenate([begins[~done], begins[~done] + length / 2]))
    return _edges_between(sorted(leaves, key=lambda leaf: leaf[0]), values, end)


def _edges_between(leaves, values, end) -> np.ndarray:
    """Edges: one where neighbouring intervals are very short, and the joints of longer ones that do not fit."""
    shortest, edges, first, error = end / 2**MOST_HALVINGS, [], None, values.tolerance * values.largest
    for k, (before, after) in enumerate(zip(leaves, [*leaves[1:], None])):
        last_narrow = before[1] < shortest and (after is None or after[1] >= shortest)
        if before[1] < shortest and first is None:
            first = k
        if last_narrow:
            edges.append(_edge_among(leaves[max(first - 1, 0) : k + 2]))
            first = None
        elif (
            first is None and after is not None and after[1] >= shortest and before[2].breaks(after[2], before[1] / after[1], error)
        ):
            edges.append(after[0])
    return np.array([edge for edge in edges if 0 < edge < end])


def _edge_among(narrow) -> float:
    """Where the edge is in very short intervals and the two beside them.

    A jump ends the interval that was never followed; a kink is where the polynomials about the shortest meet.
    """
    begin, length, fit = min(narrow, key=lambda leaf: (leaf[2].follows[0], leaf[1]))
    if not fit.follows[0]:
        return begin + length
    joints = [k for k, pair in enumerate(zip(narrow, narrow[1:])) if length in (pair[0][1], pair[1][1])]
    if not joints:
        return begin + length
    bend = max(joints, key=lambda k: narrow[k][2].bend(narrow[k + 1][2], length / narrow[k][1], length / narrow[k + 1][1]))
    left, right = narrow[max(bend - 1, 0)], narrow[min(bend + 2, len(narrow) - 1)]
    end, place = left[0] + left[1], narrow[bend + 1][0]
    meetings = [end + since for since in left[2].meetings(right[2], left[1], right[1], right[0] - end)]
    return min([m for m in meetings if left[0] < m < right[0] + right[1]], key=lambda m: abs(m - place), default=place)
