"""Bodies: the elements that have a coordinate, named as they are."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InputError
from .element import Element


class Body(Element):
    """A position along the common axis in m, or an angle in rad."""

    unit = "m"


@dataclass(frozen=True)
class Mass(Body):
    """m x'' = sum of forces; mass in kg, position in m (where it is drawn at x = 0; the motion does not depend on it)."""

    name: str
    mass: float
    position: float | None = None

    def __post_init__(self):
        if isinstance(self.mass, (int, float)) and self.mass == 0:
            raise InputError(f"{self.label}: found no mass; a point without mass is a node")
        self._number("mass", positive=True)
        if self.position is not None:
            self._number("position")


@dataclass(frozen=True)
class Node(Body):
    """0 = sum of forces: a joint without mass, or without inertia where it is rotational."""

    name: str
    rotational: bool = False

    @property
    def unit(self) -> str:
        """ "rad" for a rotational node, else "m"."""
        return "rad" if self.rotational else "m"


@dataclass(frozen=True)
class Inertia(Body):
    """J q'' = sum of torques; inertia in kg m^2, q in rad."""

    name: str
    inertia: float
    unit = "rad"

    def __post_init__(self):
        if isinstance(self.inertia, (int, float)) and self.inertia == 0:
            raise InputError(f"{self.label}: found no inertia; a point without inertia is a rotational node")
        self._number("inertia", positive=True)
