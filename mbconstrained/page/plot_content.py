"""What the plots of a page show: curves over time, and phase planes; and which numbers can be drawn at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..checks import real_array, whole_number
from ..errors import InputError

#: Numbers beyond this cannot be drawn: the arithmetic of axes and of interpolation would overflow.
LARGEST = 1e290


@dataclass(frozen=True)
class Curve:
    """One line of a plot.

    Attributes:
        name: for the legend.
        values: shape (T,), at the plot's times.
        color: number of its colour and dashes; for a coordinate its place among the animation's names, so that the curve
            has the colour of the body that it moves. None for the place in the plot.
    """

    name: str
    values: np.ndarray
    color: int | None = None


@dataclass(frozen=True)
class Plot:
    """Curves over time.

    Attributes:
        title: what is plotted, such as "displacement".
        unit: its unit, such as "m"; an empty string for a pure number.
        times: shape (T,), ascending, in s.
        curves: their values have the shape of the times.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    title: str
    unit: str
    times: np.ndarray
    curves: tuple[Curve, ...]

    def __post_init__(self):
        times = ascending_times(self.times, f'plot "{self.title}", times')
        curves = tuple(self._checked(curve, place, times.shape) for place, curve in enumerate(self.curves))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "curves", curves)

    def _checked(self, curve: Curve, place: int, shape: tuple[int, ...]) -> Curve:
        where = f'plot "{self.title}", curve "{curve.name}"'
        color = place if curve.color is None else whole_number(curve.color, f"{where}, color", minimum=0)
        return replace(curve, name=str(curve.name), values=drawable(curve.values, where, shape), color=color)


@dataclass(frozen=True)
class PhasePlot:
    """A phase plane: the velocity of one coordinate over its displacement.

    Attributes:
        title: heading.
        name: of the coordinate.
        titles, units: what is across and what is up, such as ("angle", "angular velocity") in ("rad", "rad/s").
        times: shape (T,), ascending, in s.
        displacement, velocity: at the times, shape (T,).
        color: number of the colour of the curve, as in ``Curve``.

    Raises:
        InputError: shapes that do not match, NaN, infinity or numbers beyond 1e290, times that do not ascend.
    """

    title: str
    name: str
    titles: tuple[str, str]
    units: tuple[str, str]
    times: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    color: int = 0

    def __post_init__(self):
        where = f'phase plane "{self.title[:60]}"'
        times = ascending_times(self.times, f"{where}, times")
        object.__setattr__(self, "times", times)
        for name in ("displacement", "velocity"):
            object.__setattr__(self, name, drawable(getattr(self, name), f"{where}, {name}", times.shape))
        whole_number(self.color, f"{where}, color", minimum=0)

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The one curve."""
        return (Curve(self.name, self.velocity, self.color),)


def drawable(value, what: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """An array of finite numbers small enough that differences of them are finite too."""
    array = real_array(value, what, shape=shape)
    if np.abs(array).max(initial=0.0) > LARGEST:
        raise InputError(f"{what}: found {np.abs(array).max():.3g}, which is too large to draw; ask for earlier times")
    return array


def ascending_times(value, what: str) -> np.ndarray:
    """Times in s, at least one, each after the one before."""
    times = drawable(value, what, (None,))
    if len(times) == 0:
        raise InputError(f"{what}: no times found; give at least one")
    if (np.diff(times) <= 0).any():
        place = int(np.argmax(np.diff(times) <= 0))
        raise InputError(f"{what}: {times[place]:g} s is followed by {times[place + 1]:g} s; times must ascend")
    return times
