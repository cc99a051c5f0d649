"""A system of the gallery: a problem that is hard in one way, which its parameter makes as hard as one likes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ...problem import Problem

if TYPE_CHECKING:
    from ..point import Point


@dataclass(frozen=True)
class Varied:
    """What is varied.

    Attributes:
        name, unit: of the parameter; the unit is "" for a number.
        values: from harmless to extreme, most of them over decades; 0 stands for the limit itself.
    """

    name: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class System:
    """A family of problems, in the manner of NLEVP (Betcke, Higham, Mehrmann, Schroeder and Tisseur 2013).

    Attributes:
        name: short, for the command line.
        title: one line.
        hard: what is hard about it, in one sentence.
        source: a section of a paper, a referee case, or "made for this gallery".
        varied: what is varied.
        build: the problem for a value of the parameter.
        declared: what is known of it beforehand, by the names of ``properties``: a value, or a function of the parameter.
        theme: the chapter of the gallery.
    """

    name: str
    title: str
    hard: str
    source: str
    varied: Varied
    build: Callable[[float], Problem] = field(repr=False)
    declared: Mapping[str, object] = field(repr=False)
    theme: str = ""

    @property
    def parameter(self) -> str:
        """What is varied, with its unit."""
        return f"{self.varied.name} in {self.varied.unit}" if self.varied.unit else self.varied.name

    @property
    def values(self) -> tuple[float, ...]:
        """The values of the parameter."""
        return self.varied.values

    def point(self, parameter: float, variations: int | None = None) -> Point:
        """Build the problem and hold its answer against exact arithmetic (``point_of``)."""
        from ....errors import MbconstrainedError
        from ..point import point_of, refused_point

        try:
            problem = self.build(parameter)
        except MbconstrainedError as refusal:
            return refused_point(parameter, str(refusal))
        return point_of(problem, parameter, variations)

    def declared_at(self, parameter: float) -> dict[str, object]:
        """The properties for a value of the parameter."""
        return {name: value(parameter) if callable(value) else value for name, value in self.declared.items()}


def decades(first: int, last: int, step: int = 1) -> tuple[float, ...]:
    """Powers of ten from 10^first to 10^last.

    >>> decades(-4, 0, 2), decades(0, -2)
    ((0.0001, 0.01, 1.0), (1.0, 0.1, 0.01))
    """
    step = step if last >= first else -step
    return tuple(float(f"1e{power}") for power in range(first, last + (1 if step > 0 else -1), step))
