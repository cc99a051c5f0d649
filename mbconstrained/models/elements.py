"""The elements of a lumped model, each with its equation; "ground" is the fixed body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from itertools import count
from typing import ClassVar

from ..ground.checks import ReadOnly, real_number
from ..ground.coordinate_units import GROUND
from ..ground.errors import InputError
from ..mechanics.constraints import Level, checked_level
from ..signals.impulsive import ImpulsiveSmooth

# Common to all elements: a name, a label for messages, the bodies that they join, their numbers.


@dataclass(frozen=True)
class Element:
    """Base of all elements; a class is a table of its fields.

    Attributes:
        name: its name, for a body also that of its coordinate; empty for one that the model makes of kind and ends.
        moving, turning, either: fields that name a body that it joins, which moves along the axis (m), turns (rad), or does either.
        positive, nonzero, nonnegative, real: fields of numbers, in this range; None is accepted where it is the default.
        end_count: least number of different bodies that it connects.
    """

    name: str = field(default="", kw_only=True)

    moving: ClassVar[tuple[str, ...]] = ()
    turning: ClassVar[tuple[str, ...]] = ()
    either: ClassVar[tuple[str, ...]] = ()
    positive: ClassVar[tuple[str, ...]] = ()
    nonzero: ClassVar[tuple[str, ...]] = ()
    nonnegative: ClassVar[tuple[str, ...]] = ()
    real: ClassVar[tuple[str, ...]] = ()
    end_count: ClassVar[int] = 0

    def __post_init__(self):
        for name in (*self.positive, *self.nonzero, *self.nonnegative, *self.real):
            value, what = getattr(self, name), f"{self.label}: {name.replace('_', ' ')}"
            if value is None and getattr(type(self), name, 0.0) is None:
                continue
            minimum = 0.0 if name in self.nonnegative else None
            number = real_number(value, what, positive=name in self.positive, minimum=minimum)
            if not number and name in self.nonzero:
                raise InputError(f"{what}: found 0; expected a length that is not zero")
            object.__setattr__(self, name, number)  # a frozen dataclass

    @property
    def label(self) -> str:
        """Label of the element in messages: its kind and name."""
        return f'{self.kind} "{self.name or next(self.default_names)}"'

    @property
    def kind(self) -> str:
        """Kind of the element as text, e.g. torsion spring."""
        letters = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in type(self).__name__)
        return letters.strip()

    @property
    def ends(self) -> dict[str, str | None]:
        """The bodies that it connects, each with the required unit of its coordinate, or None."""
        return dict(self._joined)

    @property
    def _joined(self) -> list[tuple[str, str | None]]:
        units = dict.fromkeys(self.moving, "m") | dict.fromkeys(self.turning, "rad") | dict.fromkeys(self.either)
        return [(getattr(self, one.name), units[one.name]) for one in fields(self) if one.name in units]

    @property
    def parts(self) -> tuple[Element, ...]:
        """The elements that belong to it."""
        return ()

    @property
    def weighing(self) -> dict[str, float]:
        """The masses (kg) subject to gravity, by the coordinate along it."""
        return {}

    @property
    def default_names(self) -> Iterator[str]:
        """Default names of an element, in order of preference."""
        base = f"{self.kind} {'-'.join(str(body) for body, _ in self._joined[:2])}"
        return (f"{base} {number}" if number > 1 else base for number in count(1))


# Bodies: the elements that have a coordinate, named as they are.


@dataclass(frozen=True)
class Body(Element):
    """A position along the common axis in m, or an angle in rad."""

    name: str = field()

    unit = property(lambda self: "m")

    @property
    def constant(self) -> float:
        """Mass (kg) or moment of inertia (kg m^2), 0 for a node."""
        return getattr(self, self.kind, 0.0)

    def __post_init__(self):
        if self.positive and isinstance(self.constant, (int, float)) and self.constant == 0:
            node = "rotational node" if self.unit == "rad" else "node"
            raise InputError(f"{self.label}: found no {self.kind}; a point without {self.kind} is a {node}")
        super().__post_init__()


@dataclass(frozen=True)
class Mass(Body):
    """A body that moves along the axis, m x'' = sum of forces.

    Args:
        mass: m > 0, in kg.
        position: position of the body at x = 0 in the drawing, in m; the motion does not depend on it.
    """

    mass: float
    position: float | None = None

    positive: ClassVar[tuple[str, ...]] = ("mass",)
    real = ("position",)

    weighing = property(lambda self: {self.name: self.mass})


@dataclass(frozen=True)
class Node(Body):
    """A massless joint, 0 = sum of forces; without inertia, and with an angle as coordinate, where it is rotational."""

    rotational: bool = False

    unit = property(lambda self: "rad" if self.rotational else "m")


@dataclass(frozen=True)
class Inertia(Body):
    """A rotating body, J q'' = sum of torques; inertia J > 0 in kg m^2, q in rad."""

    inertia: float

    positive = ("inertia",)
    unit = property(lambda self: "rad")


# Links: springs and dampers, which resist the relative motion of two bodies.


@dataclass(frozen=True)
class Link(Element):
    """An element between two bodies, or a body and "ground", whose coordinates have its unit.

    Attributes:
        start, end: names of the bodies.
        rest: its elongation without force.
    """

    start: str
    end: str

    moving = ("start", "end")
    end_count = 2
    rest = property(lambda self: 0.0)

    @property
    def constant(self) -> float:
        """Stiffness or damping coefficient."""
        return getattr(self, self.positive[0])


@dataclass(frozen=True)
class Spring(Link):
    """A spring with the force -k (x_end - x_start - rest_length) on the end, its opposite on the start.

    Args:
        stiffness: k > 0, in N/m.
        rest_length: elongation without force, in m.
        loss_factor: eta >= 0 of structural damping, k (1 + i eta): for frequency responses and steady states, not for motion in time.
    """

    stiffness: float
    rest_length: float = 0.0
    loss_factor: float = 0.0

    positive = ("stiffness",)
    nonnegative = ("loss_factor",)
    real = ("rest_length",)
    rest = property(lambda self: self.rest_length)


@dataclass(frozen=True)
class Damper(Link):
    """A viscous damper with the force -c (x_end' - x_start') on the end, its opposite on the start; damping c > 0 in N s/m."""

    damping: float

    positive = ("damping",)


@dataclass(frozen=True)
class TorsionSpring(Link):
    """A spring with the torque -k (q_end - q_start - rest_angle) on the end, its opposite on the start.

    Args:
        stiffness: k > 0, in N m/rad.
        rest_angle: angle without torque, in rad.
        loss_factor: eta >= 0 of structural damping, k (1 + i eta): for frequency responses and steady states, not for motion in time.
    """

    stiffness: float
    rest_angle: float = 0.0
    loss_factor: float = 0.0

    turning = ("start", "end")
    positive = ("stiffness",)
    nonnegative = ("loss_factor",)
    real = ("rest_angle",)
    rest = property(lambda self: self.rest_angle)


@dataclass(frozen=True)
class TorsionDamper(Link):
    """A viscous damper with the torque -c (q_end' - q_start') on the end, its opposite on the start; c > 0 in N m s/rad."""

    damping: float

    turning = ("start", "end")
    positive = ("damping",)


# Ties: elements that are one constraint row each. The multiplier is the force or torque that each names.


class Tie(Element):
    """The row: the sum of coefficient times coordinate, in the derivative of its level, equals the row's value.

    Attributes:
        row: the coefficients by coordinate; that of the ground is ignored.
        row_value: the right-hand side.
        level: level of the row.
    """

    level: Level = "position"
    end_count = 2
    row = property(lambda self: {})
    row_value = property(lambda self: 0.0)


@dataclass(frozen=True)
class RigidTie(Tie):
    """A rigid link, x_end - x_start = distance (m, or rad between bodies that turn); the multiplier is the force on the end."""

    start: str
    end: str
    distance: float = 0.0

    either = ("start", "end")
    real = ("distance",)
    row = property(lambda self: {self.start: -1.0, self.end: 1.0})
    row_value = property(lambda self: self.distance)


@dataclass(frozen=True)
class Lever(Tie):
    """x_start / start_arm + x_end / end_arm = 0: a massless lever on a fixed pivot, its arms on opposite sides.

    Arms in m; a negative one lies on the same side as the other. The multiplier is the force on the start.
    """

    start: str
    end: str
    start_arm: float
    end_arm: float

    moving = ("start", "end")
    nonzero = ("start_arm", "end_arm")
    row = property(lambda self: {self.start: 1.0, self.end: self.start_arm / self.end_arm})


@dataclass(frozen=True)
class Gear(Tie):
    """Two wheels in mesh: start_radius q_start + end_radius q_end = 0; the multiplier is the torque on the start.

    Args:
        start_radius, end_radius: radii in m, or numbers of teeth: only their ratio counts.
        internal: whether one wheel has its teeth inside, which is a minus sign.
    """

    start: str
    end: str
    start_radius: float
    end_radius: float
    internal: bool = False

    turning = ("start", "end")
    positive = ("start_radius", "end_radius")
    row = property(lambda self: {self.start: 1.0, self.end: (-1 if self.internal else 1) * self.end_radius / self.start_radius})


@dataclass(frozen=True)
class Rack(Tie):
    """A pinion and its rack, x_rack = radius q_gear, radius in m, negative where the pinion turns the other way.

    The multiplier is the force on the rack.
    """

    gear: str
    rack: str
    radius: float

    moving = ("rack",)
    turning = ("gear",)
    nonzero = ("radius",)
    row = property(lambda self: {self.rack: 1.0, self.gear: -self.radius})


@dataclass(frozen=True)
class Pulley(Tie):
    """x_start + x_end - 2 x_over = -length: a rope whose ends hang below a pulley on both sides, positions upwards.

    The length in m is that of the rope, both sides together; negative where the ends lie above the pulley, as those
    of a hoist's moving block do. Without one the coordinates are displacements from a state in which the rope is taut,
    and the right-hand side is 0. The multiplier is the tension (minus the tension where the ends lie above). The row
    acts in both directions: a real rope goes slack where its tension would be negative.
    """

    start: str
    end: str
    over: str = GROUND
    length: float | None = None

    moving = ("start", "end", "over")
    nonzero = ("length",)
    end_count = 3
    row = property(lambda self: {self.start: 1.0, self.end: 1.0, self.over: -2.0})
    row_value = property(lambda self: 0.0 if self.length is None else -self.length)


@dataclass(frozen=True)
class Relation(Tie):
    """Any other constraint row: sum of coefficient times coordinate (or its first or second derivative) = value.

    Args:
        coefficients: by name of a coordinate.
        value: value of the sum, in the unit of its terms.
        level: level of the row, see ``Constraint``.
    """

    coefficients: Mapping[str, float]
    value: float = 0.0
    level: Level = "position"

    real = ("value",)
    kind = "constraint"
    end_count = 1

    def __post_init__(self):
        if not isinstance(self.coefficients, Mapping) or not self.coefficients:
            raise InputError(f'{self.label}: expected factors by coordinate, such as {{"cart": 1, "hook": -1}}')
        factors = {name: real_number(factor, f"{self.label}: factor of {name}") for name, factor in self.coefficients.items()}
        object.__setattr__(self, "coefficients", ReadOnly(factors))
        super().__post_init__()
        checked_level(self.level, self.label)

    default_names = property(lambda self: (f"constraint {number}" for number in count(1)))
    ends = property(lambda self: dict.fromkeys(self.coefficients))
    row = property(lambda self: dict(self.coefficients))
    row_value = property(lambda self: self.value)


@dataclass(frozen=True)
class PrescribedMotion(Tie):
    """A prescribed motion of a body: its displacement, velocity or acceleration is a signal b(t) (base excitation).

    Args:
        body: whose coordinate is prescribed.
        signal: b with one row, such as ``mb.harmonic([0.01], frequency_hz=2)`` or a record, ``mb.sampled``; in m or rad, by s or
            s^2 at velocity and acceleration level.
        factor: factor of the signal, where several supports move by multiples of one signal.
        level: "position" for a displacement, "velocity", or "acceleration".

    The multiplier is the force that the support must supply.
    """

    body: str
    signal: ImpulsiveSmooth
    factor: float = 1.0
    level: Level = "position"

    either = ("body",)
    real = ("factor",)
    end_count = 1

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.signal, ImpulsiveSmooth) or self.signal.size != 1:
            raise InputError(f"{self.label}: expected a signal with one row, such as mb.step([0.1])")
        if self.body == GROUND:
            raise InputError(f'{self.label}: "ground" does not move; prescribe the motion of a body or a node')
        checked_level(self.level, self.label)

    kind = "motion"
    default_names = property(lambda self: (f"motion of {self.body}{f' {number}' if number > 1 else ''}" for number in count(1)))
    row = property(lambda self: {self.body: 1.0})
    row_value = property(lambda self: self.factor * self.signal)
