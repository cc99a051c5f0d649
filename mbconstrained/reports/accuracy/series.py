"""What a work-precision diagram is drawn from."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

#: Errors below the first, such as 0, are drawn at it with an open marker; those above the second at it with an arrow.
LOWEST, HIGHEST = 1e-17, 1e2


@dataclass(frozen=True)
class MeasuredPoint:
    """What one setting of a method costs and gives.

    Attributes:
        label: the setting, such as "rtol 1e-06", or an empty string.
        error: relative error; NaN or infinite where the method diverged.
        one_run: set-up and one evaluation, in s.
        evaluation: one more evaluation, in s.
        low, high: the spread of one_run, in s.
    """

    label: str
    error: float
    one_run: float
    evaluation: float
    low: float
    high: float

    @property
    def has_times(self) -> bool:
        """Whether there is a place for it on a logarithmic axis of times."""
        return all(0 < time < math.inf for time in (self.one_run, self.evaluation))

    @property
    def is_beyond(self) -> bool:
        """Whether the error is too large to be drawn, or none."""
        return not self.error <= HIGHEST

    @property
    def is_below(self) -> bool:
        """Whether the error is too small to be drawn."""
        return self.error < LOWEST

    @property
    def height(self) -> float:
        """The error, kept within what is drawn."""
        return HIGHEST if self.is_beyond else max(self.error, LOWEST)

    @property
    def quartiles(self) -> tuple[float, float]:
        """The spread of one_run, or one_run itself where they cannot be drawn."""
        fine = 0 < self.low <= self.high < math.inf
        return (self.low, self.high) if fine else (self.one_run, self.one_run)

    def time(self, further: bool) -> float:
        """Of each further evaluation, or of one run."""
        return self.evaluation if further else self.one_run


@dataclass(frozen=True)
class Series:
    """One method.

    Attributes:
        name: for the legend.
        points: from coarse to fine.
        is_ours: drawn with stars and on top.
    """

    name: str
    points: tuple[MeasuredPoint, ...]
    is_ours: bool = False


def drawable(series: tuple[Series, ...]) -> tuple[Series, ...]:
    """The methods that have points with times, with these points only."""
    timed = [replace(one, points=tuple(point for point in one.points if point.has_times)) for one in series]
    return tuple(one for one in timed if one.points)
