"""An animation: a drawing, the motion of its coordinates with forces, jumps and impulses, its key frames, and shapes that swing. Pure data.

The page interpolates them by cubic Hermite polynomials and computes the positions of bodies and links from them, so
this is all that it stores of the motion. What does not move has no key frames. Long motions are stored as tracks: 16-bit
codes with their lowest value and a step, where the picture shows no difference.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..ground.checks import real_array
from ..ground.errors import InputError
from .drawing import Drawing, Path, Vector, after, quaternions_of

#: Larger numbers cannot be drawn: the arithmetic of axes and of interpolation would overflow.
LARGEST = 1e290


@dataclass(frozen=True)
class Arrow:
    """A force, a moment or an impulse of either on a body; a moment is an arrow around an axis."""

    body: str  # name of the body
    # of a positive force, or the axis about which a positive moment turns counter-clockwise; any length but zero. None for a vector
    # given by its components along the axes of the body's frame, with which it turns
    direction: Vector | None
    unit: str  # such as "N" or "N m s"
    turns: bool = False  # whether it is a moment
    point: Vector = (0.0, 0.0, 0.0)  # start of the arrow in the frame of the body

    @property
    def unit_direction(self) -> np.ndarray | None:
        """The direction with length 1, shape (3,)."""
        return None if self.direction is None else np.array(self.direction) / np.linalg.norm(self.direction)


@dataclass(frozen=True, eq=False)
class ForceArrows:
    """Arrows of one force over time."""

    name: str
    # at the times of the animation, shape (T,), or (3, T) where its arrows have no direction of their own
    values: np.ndarray
    rates: np.ndarray
    arrows: tuple[tuple[Arrow, float], ...]  # each with its factor: 1 on one body and -1 on the other that exerts the force

    @property
    def names(self) -> tuple[str, ...]:
        """One name for each row of the values."""
        name = f"force: {self.name}"
        return (name,) if self.values.ndim == 1 else tuple(f"{name} {axis}" for axis in "xyz")


class ImpulseArrow(NamedTuple):
    """An impulsive load: its arrow, its size (three components where the arrow has no direction) and its label."""

    arrow: Arrow
    size: float | np.ndarray
    label: str


@dataclass(frozen=True, eq=False)
class DrawnEvent:
    """Jumps and impulses at one time."""

    time: float  # in s
    lines: tuple[str, ...]  # sentences without a full stop, shown with the picture
    # the coordinates just before and just after, each (r,)
    before: np.ndarray
    after: np.ndarray
    impulses: tuple[ImpulseArrow, ...] = ()  # the impulsive loads
    # by body name, of bodies that have paths, the poses just before and just after
    paths: Mapping[str, Path] = field(default_factory=dict)


@dataclass(frozen=True)
class Overlay:
    """Overlay of an animation."""

    events: tuple[DrawnEvent, ...] = ()  # jumps and impulses, in the order of time
    forces: tuple[ForceArrows, ...] = ()  # forces shown at all times
    description: str = "reactions"  # description of the forces, for the line over the picture
    slow: bool = False  # whether the motion is shown slower around the events at first

    def __bool__(self) -> bool:
        return bool(self.events or self.forces)


@dataclass(frozen=True, eq=False)
class Animation:
    """A drawing and the motion of its coordinates."""

    drawing: Drawing  # bodies and links
    names: tuple[str, ...]  # r coordinate names; the page also lists those that the drawing does not use
    times: np.ndarray  # shape (T,), ascending, in s
    values: np.ndarray  # shape (r, T), in the units of the coordinates
    # their time derivatives, shape (r, T); estimated from the values when None. With them the motion between the times is exact to
    # fourth order in their spacing
    rates: np.ndarray | None = None
    overlay: Overlay = Overlay()  # forces, jumps and impulses that are drawn over the model

    def __post_init__(self):
        times = ascending_times(self.times, "animation, times")
        values = drawable(self.values, "animation, values", (len(self.names), len(times)))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)
        if self.rates is not None:
            object.__setattr__(self, "rates", drawable(self.rates, "animation, rates", values.shape))


def arrow_at(drawing: Drawing, coordinate: str, unit: str) -> Arrow | None:
    """The arrow of a force along a coordinate.

    >>> from mbconstrained.page.drawing import DrawnBody
    >>> arrow_at(Drawing((DrawnBody("cart", moves={"x": (1, 0, 0)}),)), "x", "N")
    Arrow(body='cart', direction=(1.0, 0.0, 0.0), unit='N', turns=False, point=(0.0, 0.0, 0.0))
    """
    moved = [body for body in drawing.bodies if any(map(any, (body.moves.get(coordinate, ()), body.turns.get(coordinate, ()))))]
    if not moved:
        return None
    body = min(moved, key=lambda body: len({*body.moves, *body.turns}))
    turns = not any(body.moves.get(coordinate, ()))
    return Arrow(body.name, (body.turns if turns else body.moves)[coordinate], unit, turns)


def drawable(value, what: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """An array of numbers small enough that their differences are finite."""
    array = real_array(value, what, shape=shape)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise InputError(f"{what}: found {np.abs(array).max():.3g}, which is too large to draw; give an earlier end")
    return array


def ascending_times(value, what: str) -> np.ndarray:
    """Times, each after the one before."""
    times = drawable(value, what, (None,))
    if len(times) == 0:
        raise InputError(f"{what}: no times found; give at least one")
    if (np.diff(times) <= 0).any():
        place = int(np.argmax(np.diff(times) <= 0))
        raise InputError(f"{what}: {times[place]:g} s is followed by {times[place + 1]:g} s; times must ascend")
    return times


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


#: Two times nearer to each other than this share of the mean spacing are the two sides of a jump.
ONE_TIME = 1e-9


def slopes(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Derivatives at the given times of the quartics through each five neighbouring values on the same side of jumps.

    Fourth order in the spacing for smooth values, so that cubic interpolation with them loses nothing; with fewer
    than five times, of the polynomial through all.

    >>> slopes(np.array([0.0, 1.0, 3.0]), np.array([[0.0, 1.0, 9.0]])).round(9)
    array([[0., 2., 6.]])
    """
    sides = np.flatnonzero(np.diff(times) < ONE_TIME * np.ptp(times) / max(1, len(times) - 1)) + 1
    parts = zip(np.split(times, sides), np.split(np.asarray(values, dtype=float), sides, axis=1))
    return np.hstack([_slopes(*part) for part in parts])


def _slopes(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    width = min(5, len(times))
    first = np.clip(np.arange(len(times)) - width // 2, 0, len(times) - width)
    window = first[:, None] + np.arange(width)
    unit = (times[-1] - times[0]) / max(1, len(times) - 1)  # so that no product of spacings over- or underflows
    nodes, at = times[window] / (unit or 1.0), times / (unit or 1.0)
    rates = np.zeros_like(values)
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
    count, places = len(frames.times), {name: place for place, name in enumerate(frames.names)}
    poses = {}
    for body, path in zip(drawing.bodies, frames.paths):
        if path is not None:
            still = [0] * count
            poses[body.name] = path if path.count == count else Path(path.positions[:, still], path.quaternions[:, still])
            continue
        positions, rotation = np.array(body.rest)[:, None] + np.zeros((3, count)), np.zeros((3, count))
        for motion, scale, vectors in ((positions, drawing.scale, body.moves), (rotation, drawing.turn_scale, body.turns)):
            for place in sorted(places[name] for name in vectors if name in places):
                motion += scale * np.outer(vectors[frames.names[place]], frames.values[place])
        at_rest = quaternions_of(np.array(body.rest_turn)[:, None]) + np.zeros((4, count))
        poses[body.name] = Path(positions, after(quaternions_of(rotation), at_rest) if body.turns else at_rest)
    return poses


#: Times of one cycle, both ends included: the error of cubic interpolation is less than 2e-6 of the amplitude.
PHASES = 49

#: The usual word for what is listed.
MODE = "mode"

Share = tuple[str, float | None, float | None]


def cycle(shape, phases: int = PHASES) -> np.ndarray:
    """A shape over one cycle: Re(u e^{2 pi i s}) at equally spaced s from 0 to 1.

    >>> cycle([1.0, 1j], 5).round(12) + 0.0
    array([[ 1.,  0., -1.,  0.,  1.],
           [ 0., -1.,  0.,  1.,  0.]])
    """
    turns = np.exp(2j * np.pi * np.arange(phases) / (phases - 1))
    turns[-1] = turns[0]
    return np.outer(np.asarray(shape), turns).real


@dataclass(frozen=True, eq=False)
class ModePicture:
    """Picture of one mode."""

    name: str  # such as "mode 3"
    # pairs of a label and a text, such as ("frequency (Hz)", "1.52"); the labels of all modes are the columns of the page's table
    facts: tuple[tuple[str, str], ...] = ()
    shares: tuple[Share, ...] = ()  # for each element its name, its share of the kinetic and of the strain energy, or None
    # over one cycle at F equally spaced phases, shape (r, F), the last as the first; None where no coordinate moves
    values: np.ndarray | None = None
    paths: Mapping[str, Path] = field(default_factory=dict)  # by body name its poses over the same cycle, or one pose
    period: float | None = None  # of one cycle in s; None where it does not oscillate
    scale: float = 1.0  # magnification of the values, in addition to that of the drawing; paths are already magnified
    note: str = ""  # a sentence, such as the reason why a mode does not move
    shape: tuple[tuple[str, str], ...] = ()  # name and amplitude of each coordinate that moves, with its phase where it has one
    is_zero: bool = False  # whether its eigenvalue is zero, a rigid-body motion or a drift: the page folds these

    def frames(self, drawing: Drawing, names: tuple[str, ...]) -> KeyFrames:
        """One cycle of the mode as key frames."""
        bodies = tuple(replace(body, path=self.paths.get(body.name, body.path)) for body in drawing.bodies)
        values = np.zeros((len(names), 1)) if self.values is None else self.scale * self.values
        count = max([values.shape[1], *(body.path.count for body in bodies if body.path)])
        if values.shape[1] == 1:
            values = values + np.zeros((1, count))
        if not ((values != values[:, :1]).any() or any(body.path and body.path.moves for body in bodies)):
            values, count = values[:, :1], 1
            bodies = tuple(replace(body, path=body.path and body.path.thinned([0])) for body in bodies)
        return key_frames(Animation(replace(drawing, bodies=bodies), names, np.linspace(0.0, 1.0, count), values))


@dataclass(frozen=True, eq=False)
class Shapes:
    """Mode shapes in a list, of which the selected one moves."""

    drawing: Drawing  # bodies and links; a body without a path in a mode moves on its own path or with the coordinates
    names: tuple[str, ...]  # r coordinate names
    modes: tuple[ModePicture, ...] = ()  # in the order in which they are listed
    word: str = MODE  # the kind of the entries, "mode"; others, such as "variant", have a slider too


@dataclass(frozen=True, eq=False)
class Deflections:
    """Operating deflection shapes: the steady motion Re(u e^{i w t}) under a unit of one input at a time."""

    drawing: Drawing  # bodies that move with the coordinates, at rest
    names: tuple[str, ...]  # names of the n coordinates
    inputs: tuple[str, ...]  # texts of m inputs with a unit of each, such as "1 N on cart"
    axis: str  # unit of the frequencies on the axis of the plots
    frequencies: np.ndarray  # frequencies of F lines, ascending, in this unit
    periods: np.ndarray  # periods of a cycle at each line, s
    shapes: np.ndarray  # complex, shape (m, F, n), as large as the drawing allows
    factors: np.ndarray  # by which each is magnified, besides the drawing, shape (m, F)
    # frequency in this unit and number of the input of each row of the first table of the page, from which a peak is selected
    peaks: tuple[tuple[float, int], ...] = ()

    def nearest(self, frequency: float) -> int:
        """The index of the line nearest to a frequency in the unit of the axis."""
        return int(np.abs(np.log(self.frequencies / frequency)).argmin())
