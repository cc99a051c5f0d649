"""Ties: elements that are one constraint row each. The multiplier is the force or torque that each names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..checks import real_number
from ..errors import InputError
from ..mechanics.constraint import Level, checked_level
from .element import GROUND, Element


class Tie(Element):
    """The row: the sum of coefficient times coordinate, in the derivative of its level, equals the row's value."""

    level: Level = "position"
    row_value: float = 0.0
    end_count = 2

    @property
    def row(self) -> dict[str, float]:
        """The coefficients by coordinate; that of the ground counts for nothing."""
        raise NotImplementedError

    @property
    def ends(self) -> dict[str, str | None]:
        """The bodies in the row."""
        return dict.fromkeys(self.row)


@dataclass(frozen=True)
class RigidTie(Tie):
    """x_end - x_start = distance, for two positions or two angles; the multiplier is the force on the end."""

    name: str
    start: str
    end: str
    distance: float = 0.0

    def __post_init__(self):
        self._number("distance")

    @property
    def row(self) -> dict[str, float]:
        """x_end - x_start."""
        return {self.start: -1.0, self.end: 1.0}

    @property
    def row_value(self) -> float:
        """The distance."""
        return self.distance


@dataclass(frozen=True)
class Lever(Tie):
    """x_start / start_arm + x_end / end_arm = 0: a massless lever on a fixed pivot, its arms on opposite sides.

    Arms in m; a negative one lies on the same side as the other. The multiplier is the force on the start.
    """

    name: str
    start: str
    end: str
    start_arm: float
    end_arm: float

    def __post_init__(self):
        self._length("start_arm")
        self._length("end_arm")

    @property
    def row(self) -> dict[str, float]:
        """x_start + (start_arm / end_arm) x_end."""
        return {self.start: 1.0, self.end: self.start_arm / self.end_arm}

    @property
    def ends(self) -> dict[str, str | None]:
        """Both ends move along the axis."""
        return {self.start: "m", self.end: "m"}


@dataclass(frozen=True)
class Gear(Tie):
    """start_radius q_start + end_radius q_end = 0, or minus where one wheel is internal.

    Only the ratio counts: numbers of teeth do as well as radii. The multiplier is the torque on the start.
    """

    name: str
    start: str
    end: str
    start_radius: float
    end_radius: float
    internal: bool = False

    def __post_init__(self):
        self._number("start_radius", positive=True)
        self._number("end_radius", positive=True)

    @property
    def row(self) -> dict[str, float]:
        """q_start +- (end_radius / start_radius) q_end."""
        ratio = self.end_radius / self.start_radius
        return {self.start: 1.0, self.end: -ratio if self.internal else ratio}

    @property
    def ends(self) -> dict[str, str | None]:
        """Both wheels turn."""
        return {self.start: "rad", self.end: "rad"}


@dataclass(frozen=True)
class Rack(Tie):
    """x_rack = radius q_gear, radius in m, negative where the pinion turns the other way.

    The multiplier is the force on the rack.
    """

    name: str
    gear: str
    rack: str
    radius: float

    def __post_init__(self):
        self._length("radius")

    @property
    def row(self) -> dict[str, float]:
        """x_rack - radius q_gear."""
        return {self.rack: 1.0, self.gear: -self.radius}

    @property
    def ends(self) -> dict[str, str | None]:
        """A pinion that turns, a rack that moves along the axis."""
        return {self.gear: "rad", self.rack: "m"}


@dataclass(frozen=True)
class Pulley(Tie):
    """x_start + x_end - 2 x_over = -length: a rope whose ends hang below a pulley on both sides, positions upwards.

    The length in m is that of the rope, both sides together; negative where the ends lie above the pulley, as those
    of a hoist's moving block do. Without one the coordinates are displacements from a state in which the rope is taut,
    and the right-hand side is 0. The multiplier is the tension (minus the tension where the ends lie above). The row
    holds both ways: where it finds the rope pushing, a real one would go slack.
    """

    name: str
    start: str
    end: str
    over: str = GROUND
    length: float | None = None
    end_count = 3

    def __post_init__(self):
        if self.length is not None:
            self._length("length")

    @property
    def row(self) -> dict[str, float]:
        """x_start + x_end - 2 x_over."""
        return {self.start: 1.0, self.end: 1.0, self.over: -2.0}

    @property
    def row_value(self) -> float:
        """Minus the length of the rope."""
        return 0.0 if self.length is None else -self.length

    @property
    def ends(self) -> dict[str, str | None]:
        """All move along the axis."""
        return {self.start: "m", self.end: "m", self.over: "m"}


@dataclass(frozen=True)
class Relation(Tie):
    """sum of coefficient times coordinate (or its first or second derivative) = value."""

    name: str
    coefficients: Mapping[str, float]
    value: float = 0.0
    level: Level = "position"
    kind = "constraint"
    end_count = 1

    def __post_init__(self):
        if not isinstance(self.coefficients, Mapping) or not self.coefficients:
            raise InputError(f'{self.label}: expected factors by coordinate, such as {{"cart": 1, "hook": -1}}')
        factors = {name: real_number(factor, f"{self.label}: factor of {name}") for name, factor in self.coefficients.items()}
        object.__setattr__(self, "coefficients", MappingProxyType(factors))
        self._number("value")
        checked_level(self.level, self.label)

    @property
    def row(self) -> dict[str, float]:
        """The coefficients."""
        return dict(self.coefficients)

    @property
    def row_value(self) -> float:
        """The value."""
        return self.value
