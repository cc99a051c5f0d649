"""What a page of mode shapes shows: a drawing and, for each mode, one cycle of its motion, facts and energy shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..checks import counted, names_of, nearest, real_number
from ..errors import InputError
from ..notices import Notice
from .content import drawable
from .drawing import Drawing
from .keyframes import KeyFrames, key_frames
from .path import Path

#: Times of one cycle, both ends included: between them cubic interpolation errs by less than 2e-6 of the amplitude.
PHASES = 49

Share = tuple[str, float | None, float | None]


@dataclass(frozen=True, eq=False)
class ModePicture:
    """One mode.

    Attributes:
        name: such as "mode 3".
        facts: pairs of a label and a text, such as ("frequency (Hz)", "1.52"); the labels of all modes are the columns of
            the page's table.
        shares: for each part its name, its share of the kinetic and of the strain energy; None where there is none.
        values: the coordinates over one cycle at F equally spaced phases, shape (r, F), the last as the first; None for a
            mode in which no coordinate moves.
        paths: by body name the poses over the same cycle (or one pose), where that is how the body moves.
        period: s of one cycle, so that the page can tell how much it is slowed down; None where it does not oscillate.
        scale: how much larger than the values the motion is drawn, besides the drawing's own magnification; paths are
            that large already, and the page tells it.
        note: a sentence such as why a mode does not move.
        shape: for each coordinate that moves its name and how far, with its phase where it has one; texts.

    Raises:
        InputError: NaN, infinity or numbers beyond 1e290, a period that is not positive, paths of another length.
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

    def __post_init__(self):
        where = f'mode "{self.name[:60]}"'
        object.__setattr__(self, "facts", tuple((str(label), str(text)) for label, text in self.facts))
        object.__setattr__(self, "shares", tuple(_share(row, where) for row in self.shares))
        object.__setattr__(self, "scale", real_number(self.scale, f"{where}, scale"))
        if self.values is not None:
            object.__setattr__(self, "values", drawable(self.values, f"{where}, values", (None, None)))
        if self.period is not None:
            object.__setattr__(self, "period", real_number(self.period, f"{where}, period", positive=True))

    def frames(self, drawing: Drawing, names: tuple[str, ...]) -> KeyFrames:
        """Its cycle as key frames over the phases from 0 to 1; a single one where nothing moves."""
        bodies = tuple(replace(body, path=self.paths.get(body.name, body.path)) for body in drawing.bodies)
        values = np.zeros((len(names), 1)) if self.values is None else self.scale * self.values
        lengths = {body.path.count for body in bodies if body.path is not None and body.path.count > 1}
        count = max({values.shape[1], *lengths})
        if values.shape[1] == 1:
            values = values + np.zeros((1, count))
        if not ((values != values[:, :1]).any() or any(body.path and body.path.moves for body in bodies)):
            values, count = values[:, :1], 1
            bodies = tuple(replace(body, path=body.path and body.path.thinned([0])) for body in bodies)
        return key_frames(replace(drawing, bodies=bodies), names, np.linspace(0.0, 1.0, count), values)


@dataclass(frozen=True, eq=False)
class ModesContent:
    """Everything on a page of mode shapes.

    Attributes:
        title, source: heading of the page and the line under it.
        drawing: bodies and links; a body that a mode gives no path is drawn by its own, or by the coordinates.
        names: r coordinate names.
        modes: in the order in which they are listed.
        notices, facts: as on the page of a run.

    Raises:
        InputError: values of another number of coordinates, a path for a body that is not drawn.
    """

    title: str
    source: str
    drawing: Drawing
    names: tuple[str, ...]
    modes: tuple[ModePicture, ...] = ()
    notices: tuple[Notice, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()

    def __post_init__(self):
        object.__setattr__(self, "names", names_of(self.names, len(self.names), "modes, names", "x"))
        object.__setattr__(self, "modes", tuple(self.modes))
        known = [body.name for body in self.drawing.bodies]
        for mode in self.modes:
            where = f'mode "{mode.name[:60]}"'
            rows = len(self.names) if mode.values is None else len(mode.values)
            if rows != len(self.names):
                raise InputError(f"{where}, values: found {counted(rows, 'row')} for {counted(len(self.names), 'coordinate')}")
            for name in mode.paths:
                if name not in known:
                    raise InputError(f'{where}, paths: "{name[:60]}" is no body of the drawing{nearest(name, known)}')


def cycle(shape, phases: int = PHASES) -> np.ndarray:
    """A shape over one cycle: Re(u e^{2 pi i s}) at equally spaced s from 0 to 1, shape (r, phases).

    Args:
        shape: u, shape (r,), real or complex.

    >>> cycle([1.0, 1j], 5).round(12) + 0.0
    array([[ 1.,  0., -1.,  0.,  1.],
           [ 0., -1.,  0.,  1.,  0.]])
    """
    turns = np.exp(2j * np.pi * np.arange(phases) / (phases - 1))
    turns[-1] = turns[0]
    return np.outer(np.asarray(shape), turns).real


def _share(row: Share, where: str) -> Share:
    name, kinetic, strain = row
    what = f'{where}, share of "{str(name)[:60]}"'
    return (str(name), *(None if share is None else real_number(share, what) for share in (kinetic, strain)))
