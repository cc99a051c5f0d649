"""Key frames: the coordinates and their rates at the times of the animation, as the page stores them, and the poses there.

The page interpolates them by cubic Hermite polynomials and computes the positions of bodies and links from them, so
this is all that it stores of the motion. What does not move has no key frames. Long motions are stored as tracks: 16-bit
codes with their lowest value and a step, where the picture shows no difference.
"""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass

import numpy as np

from ..drawing.bodies import Drawing
from ..drawing.paths import Path, after, quaternions_of
from .animation import Animation

#: More numbers than this are packed with 4 bytes each.
MOST_DOUBLES = 50_000

#: Times within this share of the duration of even spacing are stored by their ends and their number.
EVEN_SPACING = 1e-14

#: More key frames than this make a page of tens of megabytes; then only every second, third ... time is kept.
MOST_FRAMES = 4001

#: More poses than this, of all bodies with paths together, do the same.
MOST_POSES = 80_000

#: The largest code of a track.
LARGEST_CODE = 2**16 - 1

#: The largest value of s² (1 - s), the share of an error in a rate by which a cubic between its ends is off, for either end.
RATE_INFLUENCE = 4 / 27

#: Poses at key frames by body name, in the order of the drawing.
BodyPoses = dict[str, Path]


@dataclass(frozen=True, eq=False)
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

        Up to ``MOST_DOUBLES`` numbers have 8 bytes each. Of more each has 4 bytes, or 2 where the picture shows no difference;
        rates are left out where those that the page estimates are as good.
        """
        size = max(np.abs(rows).max(initial=0.0) for rows in (self.values, self.rates))
        kind = "<f4" if self.values.size > MOST_DOUBLES and size < np.finfo(np.float32).max else "<f8"
        errors = np.zeros(len(self.names)) if errors is None or self.values.size <= MOST_DOUBLES else errors
        rows = [self._row(i, kind, error) for i, error in enumerate(errors)]
        names, values, rates = list(self.names), [row[0] for row in rows], [row[1] for row in rows]
        return {"names": names, "bytes": int(kind[-1]), "values": values, "rates": rates, **self._shared(path_errors)}

    def _row(self, number: int, kind: str, error: float) -> tuple:
        """Values and rates of a coordinate; no rates where the page shall estimate them from the values."""
        row, rates = self.values[number : number + 1], self.rates[number : number + 1]
        if (row == row[:, :1]).all():
            return float(row[0, 0]), 0
        coarse = track(row, np.array([error / 2]))
        if coarse is None:
            return packed(row, kind), packed(rates, kind)
        rate_error = error / (4 * RATE_INFLUENCE * np.diff(self.times).max())
        low, step, codes = _codes(row)
        if np.abs(slopes(self.times, low + step * codes) - rates).max() <= rate_error:
            return coarse, None
        return coarse, track(rates, np.array([rate_error])) or packed(rates, kind)

    def as_packed(self) -> dict:
        """Plain data in seven digits and without rates, which the page estimates as ``slopes`` does."""
        values = [float(row[0]) if (row == row[0]).all() else packed(row) for row in self.values]
        return {"bytes": 4, "values": values, **self._shared()}

    def _shared(self, path_errors: tuple[float, float] = (0.0, 0.0)) -> dict:
        """Times, by their ends and number where they are evenly spaced, and paths: positions, then quaternions, of each pose."""
        start, end, count = float(self.times[0]), float(self.times[-1]), len(self.times)
        even = np.abs(self.times - np.linspace(start, end, count)).max() <= EVEN_SPACING * (end - start)
        times = {"start": start, "end": end, "count": count} if even else packed(self.times, "<f8")
        many = 7 * sum(path.count for path in self.paths if path) > MOST_DOUBLES
        place, turn = path_errors if many else (0.0, 0.0)
        errors = np.repeat([place / np.sqrt(3), turn / 4], [3, 4])  # of one number; a body turns by twice its quaternion
        rows = [None if path is None else np.vstack([path.positions, path.quaternions]) for path in self.paths]
        paths = [None if row is None else (row.shape[1] > 1 and track(row, errors)) or packed(row.T) for row in rows]
        return {"times": times, "paths": paths}


def key_frames(animation: Animation) -> KeyFrames:
    """The key frames of an animation; the forces of its overlay are stored as further coordinates.

    >>> key_frames(Animation(Drawing(()), ["x"], [0, 1, 2], [[0, 1, 4]])).rates
    array([[0., 2., 4.]])
    """
    forces, times = animation.overlay.forces, animation.times
    names = (*animation.names, *(name for force in forces for name in force.names))
    values = np.vstack([animation.values, *(force.values for force in forces)])
    if animation.rates is None:
        rates = slopes(times, values)
    else:
        rates = np.vstack([animation.rates, *(force.rates for force in forces)])
    paths = [body.path for body in animation.drawing.bodies]
    moving = sum(path is not None and path.moves for path in paths)
    most = min(MOST_FRAMES, max(2, MOST_POSES // max(1, moving)))
    last = len(times) - 1
    stride = max(1, math.ceil(last / (most - 1)))
    kept = np.unique([*range(0, last, stride), last])
    thinned = tuple(None if path is None else path.thinned(kept) for path in paths)
    return KeyFrames(names, times[kept], values[:, kept], rates[:, kept], stride, thinned)


def slopes(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Derivatives at the given times of the quartics through each five neighbouring values.

    Fourth order in the spacing for smooth values, so that cubic interpolation with them loses nothing; with fewer
    than five times, of the polynomial through all.

    >>> slopes(np.array([0.0, 1.0, 3.0]), np.array([[0.0, 1.0, 9.0]])).round(9)
    array([[0., 2., 6.]])
    """
    width = min(5, len(times))
    first = np.clip(np.arange(len(times)) - width // 2, 0, len(times) - width)
    window = first[:, None] + np.arange(width)
    unit = (times[-1] - times[0]) / max(1, len(times) - 1)  # so that no product of spacings over- or underflows
    nodes, at = times[window] / (unit or 1.0), times / (unit or 1.0)
    rates = np.zeros_like(values, dtype=float)
    for k in range(width):  # derivatives of the Lagrange polynomials
        others = [j for j in range(width) if j != k]
        scale = np.prod([nodes[:, k] - nodes[:, j] for j in others], axis=0)
        terms = [np.prod([at - nodes[:, i] for i in others if i != j], axis=0) for j in others]
        rates += sum(terms, np.zeros_like(at)) / scale * values[:, window[:, k]]
    return rates / (unit or 1.0)


def track(rows: np.ndarray, errors: np.ndarray) -> dict | None:
    """Rows as 16-bit codes.

    >>> data = track(np.array([[1.0, 2.0, 4.0]]), np.array([1e-4]))
    >>> data["low"], data["codes"] == packed(np.array([0, 21845, 65535]), "<u2")
    ([1.0], True)
    """
    low, step, codes = _codes(rows)
    if not (step[:, 0] / 2 <= errors).all():
        return None
    return {"low": low[:, 0].tolist(), "step": step[:, 0].tolist(), "codes": packed(codes.T, "<u2")}


def _codes(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lowest values, steps and codes, of which the page reads the rows as low + step codes."""
    low, step = rows.min(axis=1, keepdims=True), np.ptp(rows, axis=1, keepdims=True) / LARGEST_CODE
    return low, step, np.round((rows - low) / np.where(step > 0, step, 1.0))


def packed(array: np.ndarray, kind: str = "<f4") -> str:
    """The numbers of an array, row by row, as base64.

    >>> packed(np.array([[1.0, -2.0]]))
    'AACAPwAAAMA='
    """
    return base64.b64encode(np.ascontiguousarray(array, dtype=np.dtype(kind)).tobytes()).decode("ascii")


def body_poses(drawing: Drawing, frames: KeyFrames) -> BodyPoses:
    """The poses of all bodies at key frames."""
    count = len(frames.times)
    poses = {}
    for body, path in zip(drawing.bodies, frames.paths):
        if path is not None:
            still = [0] * count
            poses[body.name] = path if path.count == count else Path(path.positions[:, still], path.quaternions[:, still])
            continue
        positions, rotation = np.array(body.rest)[:, None] + np.zeros((3, count)), np.zeros((3, count))
        for name, row in zip(frames.names, frames.values):
            if name in body.moves:
                positions += drawing.scale * np.outer(body.moves[name], row)
            if name in body.turns:
                rotation += drawing.turn_scale * np.outer(body.turns[name], row)
        at_rest = quaternions_of(np.array(body.rest_turn)[:, None])
        poses[body.name] = Path(positions, after(quaternions_of(rotation), at_rest + np.zeros((4, count))))
    return poses
