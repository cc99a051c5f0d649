"""The points of the curves of a plot as they are drawn, in whole cells, and when a script takes them to be reached."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .readings import path_error

#: A picture has so many cells across and as many up.
CELLS = 10_000

#: A curve of more points than the picture has pixels is drawn by the lowest and highest value of each pixel column.
MOST_POINTS = 2400


@dataclass(frozen=True)
class PlottedPoints:
    """One curve.

    Attributes:
        cells: whole cells across and down, shape (2, k).
        moments: when they are reached as the script has it, in cells of the time, shape (k,).
        errors: by how many cells a reading across and one up may be off; of a whole curve at its points, between them the
            script sees how it bends.
        is_whole: whether all points of a curve over time are drawn.
    """

    cells: np.ndarray
    moments: np.ndarray
    errors: tuple[float, float]
    is_whole: bool


def plotted(times: np.ndarray, x: np.ndarray, y: np.ndarray, *, phase: bool) -> PlottedPoints:
    """The points of a curve in cells x, y (T,) at times (T,), at least two; of a phase plane evenly many of them."""
    kept = sparse(times) if phase else _kept(x, y)
    cells = np.rint(np.array([x[kept], y[kept]])).astype(int)
    if evenly(times):
        moments = np.linspace(0, CELLS, len(kept))
    else:
        moments = np.cumsum(moment_steps(times)) if phase else cells[0]
    share = CELLS * (times - times[0]) / (times[-1] - times[0])
    is_whole = not phase and len(kept) == len(times)
    across, up = (path_error(share, exact, moments, read, between=not is_whole) for exact, read in zip((x, y), cells))
    return PlottedPoints(cells, moments, (across, up), is_whole)


def evenly(times: np.ndarray) -> bool:
    """Whether the script may count points instead of looking at their times: all are drawn, and evenly spaced."""
    return len(times) <= MOST_POINTS and bool(
        np.abs(times - np.linspace(times[0], times[-1], len(times))).max() * CELLS <= 0.1 * (times[-1] - times[0])
    )


def moment_steps(times: np.ndarray) -> np.ndarray:
    """When each point of a phase curve is reached, in cells from point to point."""
    shares = (times[sparse(times)] - times[0]) / ((times[-1] - times[0]) or 1.0)
    return np.diff(np.rint(CELLS * shares).astype(int), prepend=0)


def sparse(times: np.ndarray) -> np.ndarray:
    """Which points of a phase curve are drawn: at most ``MOST_POINTS``, evenly."""
    return np.linspace(0, len(times) - 1, min(len(times), MOST_POINTS)).round().astype(int)


def _kept(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    if len(x) <= MOST_POINTS:
        return np.arange(len(x))
    edges = np.linspace(0, len(x), MOST_POINTS // 2 + 1).astype(int)
    extremes = [(a + y[a:b].argmin(), a + y[a:b].argmax()) for a, b in pairwise(edges)]
    return np.unique(np.concatenate([[0, len(x) - 1], np.ravel(extremes)]))
