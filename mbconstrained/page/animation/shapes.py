"""Shapes that swing: mode shapes one by one, and operating deflection shapes over the frequency."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..drawing.bodies import Drawing
from ..drawing.paths import Path
from .animation import Animation
from .keyframes import KeyFrames, key_frames

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
    """Picture of one mode.

    Attributes:
        name: name, such as "mode 3".
        facts: pairs of a label and a text, such as ("frequency (Hz)", "1.52"); the labels of all modes are the columns of
            the page's table.
        shares: for each element its name, its share of the kinetic and of the strain energy; None where it has none.
        values: the coordinates over one cycle at F equally spaced phases, shape (r, F), the last as the first; None for a
            mode in which no coordinate moves.
        paths: by body name the poses over the same cycle (or one pose), of bodies that move on paths.
        period: period of one cycle in s; None where it does not oscillate.
        scale: magnification of the values, in addition to that of the drawing; paths are already magnified.
        note: a sentence, such as the reason why a mode does not move.
        shape: for each coordinate that moves its name and its amplitude, with its phase where it has one; texts.
    """

    name: str
    facts: tuple[tuple[str, str], ...] = ()
    shares: tuple[Share, ...] = ()
    values: np.ndarray | None = None
    paths: Mapping[str, Path] = field(default_factory=dict)
    period: float | None = None
    scale: float = 1.0
    note: str = ""
    shape: tuple[tuple[str, str], ...] = ()

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
    """Mode shapes in a list, of which the selected one moves.

    Attributes:
        drawing: bodies and links; a body without a path in a mode moves on its own path or with the coordinates.
        names: r coordinate names.
        modes: in the order in which they are listed.
        word: the kind of the entries, "mode"; others, such as "variant", have a slider too.
    """

    drawing: Drawing
    names: tuple[str, ...]
    modes: tuple[ModePicture, ...] = ()
    word: str = MODE


@dataclass(frozen=True, eq=False)
class Deflections:
    """Operating deflection shapes: the steady motion Re(u e^{i w t}) under a unit of one input at a time.

    Attributes:
        drawing: bodies that move with the coordinates, at rest.
        names: names of the n coordinates.
        inputs: texts of m inputs with a unit of each, such as "1 N on cart".
        axis: unit of the frequencies on the axis of the plots.
        frequencies: frequencies of F lines, ascending, in this unit.
        periods: periods of a cycle at each line, s.
        shapes: complex, shape (m, F, n), as large as the drawing allows.
        factors: by which each is magnified, besides the drawing, shape (m, F).
        peaks: frequency in this unit and number of the input of each row of the first table of the page, from which a peak is selected.
    """

    drawing: Drawing
    names: tuple[str, ...]
    inputs: tuple[str, ...]
    axis: str
    frequencies: np.ndarray
    periods: np.ndarray
    shapes: np.ndarray
    factors: np.ndarray
    peaks: tuple[tuple[float, int], ...] = ()

    def nearest(self, frequency: float) -> int:
        """The index of the line nearest to a frequency in the unit of the axis."""
        return int(np.abs(np.log(self.frequencies / frequency)).argmin())
