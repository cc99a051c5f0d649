"""Links: springs and dampers, which resist the relative motion of two bodies."""

from __future__ import annotations

from dataclasses import dataclass

from .element import Element


class Link(Element):
    """An element between two bodies whose coordinates have its unit."""

    start: str
    end: str
    unit = "m"
    end_count = 2

    @property
    def ends(self) -> dict[str, str | None]:
        """Start and end."""
        return {self.start: self.unit, self.end: self.unit}


@dataclass(frozen=True)
class Spring(Link):
    """Force -k (x_end - x_start - rest_length) on the end, its opposite on the start; k in N/m."""

    name: str
    start: str
    end: str
    stiffness: float
    rest_length: float = 0.0

    def __post_init__(self):
        self._number("stiffness", positive=True)
        self._number("rest_length")


@dataclass(frozen=True)
class Damper(Link):
    """Force -c (x_end' - x_start') on the end, its opposite on the start; c in N s/m."""

    name: str
    start: str
    end: str
    damping: float

    def __post_init__(self):
        self._number("damping", positive=True)


@dataclass(frozen=True)
class TorsionSpring(Link):
    """Torque -k (q_end - q_start - rest_angle) on the end, its opposite on the start; k in N m/rad."""

    name: str
    start: str
    end: str
    stiffness: float
    rest_angle: float = 0.0
    unit = "rad"

    def __post_init__(self):
        self._number("stiffness", positive=True)
        self._number("rest_angle")


@dataclass(frozen=True)
class TorsionDamper(Link):
    """Torque -c (q_end' - q_start') on the end, its opposite on the start; c in N m s/rad."""

    name: str
    start: str
    end: str
    damping: float
    unit = "rad"

    def __post_init__(self):
        self._number("damping", positive=True)
