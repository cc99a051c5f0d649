"""Key frames: the values of the coordinates and their rates at the times of the animation.

The page interpolates them by cubic polynomials (Hermite) and computes the places of bodies and links from them, so
this is all that it stores of the motion. What does not move has no key frames.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..checks import nearest
from ..errors import InputError
from .content import Animation
from .drawing import Drawing
from .packing import packed
from .path import Path
from .tracks import SWAY, read_back, track

#: More numbers than this are packed with 4 bytes each.
MOST_DOUBLES = 50_000

#: Times that are this share of all the time away from even spacing are evenly spaced but for rounding.
EVEN = 1e-14

#: More key frames than this make a page of tens of megabytes; then only every second, third ... time is kept.
MOST_FRAMES = 4001

#: More poses than this, of all bodies with paths together, do the same.
MOST_POSES = 80_000


@dataclass(frozen=True)
class KeyFrames:
    """Values (r, T) and rates (r, T) of named coordinates at times (T,); ``stride`` of the given times make one.

    ``paths`` has one path for each body of the drawing, with T poses or one, and None for a body without.
    """

    names: tuple[str, ...]
    times: np.ndarray
    values: np.ndarray
    rates: np.ndarray
    stride: int = 1
    paths: tuple[Path | None, ...] = ()

    def as_data(self, errors: np.ndarray | None = None, path_errors: tuple[float, float] = (0.0, 0.0)) -> dict:
        """Plain data for the page, numbers as packed bytes; a coordinate that never changes is one number with rate 0.

        Of many numbers each has 4 bytes, of which a picture shows no difference, if that is within their range; or 2 where
        that is within the error, and no rates where those that the page estimates do.

        Args:
            errors: by how much each coordinate may be off, shape (r,); None: not at all.
            path_errors: by how much a place on a path, and an orientation (rad), may be off.
        """
        size = max(np.abs(rows).max(initial=0.0) for rows in (self.values, self.rates))
        kind = "<f4" if self.values.size > MOST_DOUBLES and size < np.finfo(np.float32).max else "<f8"
        errors = np.zeros(len(self.names)) if errors is None or self.values.size <= MOST_DOUBLES else errors
        values, rates = zip(*(self._row(i, kind, error) for i, error in enumerate(errors))) if self.names else ((), ())
        shared = self._shared(path_errors)
        return {"names": list(self.names), "bytes": int(kind[-1]), "values": list(values), "rates": list(rates), **shared}

    def _row(self, number: int, kind: str, error: float) -> tuple:
        """Values and rates of a coordinate; no rates where the page shall estimate them from the values."""
        row, rates = self.values[number : number + 1], self.rates[number : number + 1]
        if not _moves(row[0]):
            return float(row[0, 0]), 0
        coarse = track(row, np.array([error / 2]))
        if coarse is None:
            return packed(row, kind), packed(rates, kind)
        rate_error = error / (4 * SWAY * np.diff(self.times).max())
        if np.abs(slopes(self.times, read_back(row)) - rates).max() <= rate_error:
            return coarse, None
        return coarse, track(rates, np.array([rate_error])) or packed(rates, kind)

    def as_packed(self) -> dict:
        """The same in seven digits and without rates, which the page then estimates as ``slopes`` does."""
        return {"bytes": 4, "values": self._values("<f4"), **self._shared()}

    def _values(self, kind: str) -> list[str | float]:
        return [packed(row, kind) if _moves(row) else float(row[0]) for row in self.values]

    def _shared(self, path_errors: tuple[float, float] = (0.0, 0.0)) -> dict:
        many = 7 * sum(path.count for path in self.paths if path) > MOST_DOUBLES
        paths = [None if path is None else _path_data(path, path_errors if many else (0.0, 0.0)) for path in self.paths]
        return {"times": _times_data(self.times), "paths": paths}


def key_frames(drawing: Drawing, names, times, values, rates=None) -> KeyFrames:
    """The key frames of a drawing's motion.

    Args:
        drawing: its bodies name coordinates; each must be among the names.
        names: r coordinate names.
        times: shape (T,), ascending, in s.
        values: shape (r, T).
        rates: shape (r, T), or None to estimate them from the values.

    Raises:
        InputError: unknown coordinate in the drawing, shapes that do not match, NaN or infinity.

    >>> frames = key_frames(Drawing(()), ["x"], [0, 1, 2], [[0, 1, 4]])
    >>> frames.rates
    array([[0., 2., 4.]])
    """
    motion = Animation(drawing, names, times, values, rates)
    for name in sorted(drawing.coordinates - set(motion.names)):
        raise InputError(f'drawing: "{name}" moves a body but is no coordinate{nearest(name, motion.names)}')
    rates = slopes(motion.times, motion.values) if rates is None else motion.rates
    paths = [body.path for body in drawing.bodies]
    last = len(motion.times) - 1
    stride = max(1, math.ceil(last / (_most_frames(paths) - 1)))
    kept = np.unique([*range(0, last, stride), last])
    thinned = tuple(None if path is None else path.thinned(kept) for path in paths)
    return KeyFrames(motion.names, motion.times[kept], motion.values[:, kept], rates[:, kept], stride, thinned)


def _most_frames(paths: list[Path | None]) -> int:
    moving = sum(path is not None and path.moves for path in paths)
    return min(MOST_FRAMES, max(2, MOST_POSES // max(1, moving)))


def slopes(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Derivatives at the given times of the quartics through each five neighbouring values, shape (r, T).

    Fourth order in the spacing for smooth values, so that cubic interpolation with them loses nothing; with fewer
    than five times, of the polynomial through all. Times (T,) of any spacing, values (r, T).

    >>> slopes(np.array([0.0, 1.0, 3.0]), np.array([[0.0, 1.0, 9.0]])).round(9)
    array([[0., 2., 6.]])
    """
    width = min(5, len(times))
    first = np.clip(np.arange(len(times)) - width // 2, 0, len(times) - width)
    window = first[:, None] + np.arange(width)
    unit = (times[-1] - times[0]) / max(1, len(times) - 1)  # so that no product of spacings over- or underflows
    weights = _derivative_weights(times[window] / (unit or 1.0), times / (unit or 1.0))
    return sum(weight * values[:, window[:, k]] for k, weight in enumerate(weights)) / (unit or 1.0)


def _derivative_weights(nodes: np.ndarray, at: np.ndarray) -> list[np.ndarray]:
    """Derivatives of the Lagrange polynomials of nodes (T, w) at times (T,), one (T,) for each of the w nodes."""
    width = nodes.shape[1]
    weights = []
    for k in range(width):
        others = [j for j in range(width) if j != k]
        scale = np.prod([nodes[:, k] - nodes[:, j] for j in others], axis=0)
        terms = [np.prod([at - nodes[:, i] for i in others if i != j], axis=0) for j in others]
        weights.append(sum(terms, np.zeros_like(at)) / scale)
    return weights


def _path_data(path: Path, errors: tuple[float, float]) -> str | dict:
    """Positions, then quaternions, seven numbers to a pose."""
    rows = np.vstack([path.positions, path.quaternions])
    place, turn = errors[0] / np.sqrt(3), errors[1] / (2 * np.sqrt(4))  # of one number; a body turns by twice its quaternion
    return (track(rows, np.array([place] * 3 + [turn] * 4)) if path.count > 1 else None) or packed(rows.T)


def _moves(row: np.ndarray) -> bool:
    return bool((row != row[0]).any())


def _times_data(times: np.ndarray) -> dict | str:
    """The ends and the number of evenly spaced times; any others one by one."""
    start, end, count = float(times[0]), float(times[-1]), len(times)
    even = np.abs(times - np.linspace(start, end, count)).max() <= EVEN * (end - start)
    return {"start": start, "end": end, "count": count} if even else packed(times, "<f8")
