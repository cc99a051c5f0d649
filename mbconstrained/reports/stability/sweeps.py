"""One thing turned over many decades, a point at each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...errors import MbconstrainedError
from ..problem import Problem
from .point import Point, point_of, refused_point


@dataclass(frozen=True)
class Sweep:
    """What was turned and what was found.

    Attributes:
        name: what is turned, or the name of a system of the gallery.
        title: for headings.
        theme: the heading under which it stands.
        hard: what is hard about it, in a sentence; empty for what a user turns.
        source: where it is from; empty for what a user turns.
        parameter: what is turned, with its unit if it has one.
        points: in the order of the parameter.
        broken: what a system of the gallery declares of itself, and exact arithmetic does not find.
    """

    name: str
    title: str
    theme: str
    hard: str
    source: str
    parameter: str
    points: tuple[Point, ...]
    broken: tuple[str, ...] = ()

    def count(self, verdict: str) -> int:
        """How many points have a verdict: right, told, refused, not judged or wrong."""
        return sum(point.verdict == verdict for point in self.points)

    @property
    def answers(self) -> tuple[Point, ...]:
        """The points with an answer that exact arithmetic could judge."""
        return tuple(point for point in self.points if point.right is not None)

    def told_parameter(self, point: Point) -> str:
        """What was turned, with the value of a point."""
        return f"{self.parameter} = {point.parameter:.3g}"

    def as_json(self) -> dict:
        """As plain data."""
        return {
            "name": self.name,
            "title": self.title,
            "theme": self.theme,
            "hard": self.hard,
            "source": self.source,
            "parameter": self.parameter,
            "broken": list(self.broken),
            "points": [point.as_json() for point in self.points],
        }


def points_of(build: Callable[[float], Problem], parameters: Sequence[float], tell: Callable[[str], None]) -> tuple[Point, ...]:
    """A point for each parameter; where there are no equations to solve, the reason."""
    found = []
    for parameter in parameters:
        tell(f"{parameter:.3g}")
        try:
            problem = build(parameter)
        except MbconstrainedError as reason:
            found.append(refused_point(parameter, str(reason)))
        else:
            found.append(point_of(problem, parameter))
    return tuple(found)
