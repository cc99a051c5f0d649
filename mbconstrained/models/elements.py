"""The elements of a lumped model; "ground" is the fixed body.

An element is one class: its fields with units, ranges and descriptions, its equations, and its symbol in the drawing. The method of
``LumpedModel``, the table of a scene with its JSON Schema, the parameters of sensitivities and the reference follow from it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from fractions import Fraction
from itertools import count
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self, get_args, get_type_hints

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import ReadOnly, real_number
from ..ground.errors import InputError, named, shown
from ..ground.quantities import Dimension, Expressed, any_quantity, dimension, quantity, unit_of
from ..ground.units import GROUND, rate_unit
from ..mechanics.constraints import LEVELS, Level, checked_level
from ..signals.impulsive import ImpulsiveSmooth

# Annotations of fields.

if TYPE_CHECKING:
    Real = Any  # what is set: a number in SI or a text with a unit; what is read: a float
else:
    Real = float

Range = Literal["positive", "whole", "nonzero", "nonnegative", "real"]


class Numeric(NamedTuple):
    """A number, or numbers, of a field."""

    unit: str | None  # in SI; None for that of the coordinates at the ends of the element
    text: str  # description for users
    range: Range = "real"  # of the number; None is accepted where it is the default
    varied: bool = True  # whether it is a parameter: an equation of every speed and time depends on it


class Joins(NamedTuple):
    """The name of a body that an element joins, or of a point of a rotor."""

    text: str  # description for users
    unit: str | None = ""  # of the coordinate that it must have, "m" or "rad"; an empty text for that of the class, None for either


class Entry(NamedTuple):
    """A field of an element."""

    type: Any
    about: Any  # its annotation, Numeric, Joins or a text
    default: Any  # MISSING where there is none, or a function makes it
    is_required: bool
    is_number: bool  # whether it is one number


class _Fields(NamedTuple):
    """The fields of a class of elements by name; those with one number, the positive ones first; those with a body, and its unit."""

    entries: dict[str, Entry]
    numbers: dict[str, Numeric]
    joins: tuple[tuple[str, str | None], ...]


_FIELDS: dict[type, _Fields] = {}


def fields_of(kind: type[Element]) -> _Fields:
    if kind in _FIELDS:
        return _FIELDS[kind]
    hints, entries = get_type_hints(kind, include_extras=True), {}
    for each in fields(kind):
        own, about, *_ = get_args(hints[each.name])
        is_required = each.default is MISSING and each.default_factory is MISSING
        entries[each.name] = Entry(own, about, each.default, is_required, own is Real and isinstance(about, Numeric))
    numbers = {name: entry.about for name, entry in entries.items() if entry.is_number}
    ordered = dict(sorted(numbers.items(), key=lambda item: get_args(Range).index(item[1].range)))
    joins = ((name, entry.about.unit) for name, entry in entries.items() if isinstance(entry.about, Joins))
    return _FIELDS.setdefault(
        kind, _Fields(entries, ordered, tuple((name, kind.axis if unit == "" else unit) for name, unit in joins))
    )


# Common to all elements.


@dataclass(frozen=True)
class Element(Public):
    """Base of all elements."""

    name: Annotated[str, "A name for messages and the drawing; by default of kind and ends."] = field(default="", kw_only=True)

    kind: ClassVar[str]  # in words, e.g. torsion spring.
    axis: ClassVar[str | None] = "m"  # unit of the coordinates of the bodies that it joins, "m" or "rad"; None for either
    end_count: ClassVar[int] = 0  # how many different bodies it joins, at least
    symbol: ClassVar[Any] = None  # in the drawing, a kind of link or "gear"; None where it has none
    has_coordinates: ClassVar[bool] = False  # whether it is a body, or has some
    parts: ClassVar[tuple[Element, ...]] = ()  # the elements that are added with it
    weighing: ClassVar[Mapping[str, float]] = {}  # the masses (kg) that gravity acts on, by the coordinate along it
    # further keys of its table in scenes, each with the fields that it gives
    spellings: ClassVar[Mapping[str, tuple[str, ...]]] = {}

    def __init_subclass__(cls):
        if "kind" not in vars(cls):
            cls.kind = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in cls.__name__).strip()

    def __post_init__(self):
        entries, numbers, *_ = fields_of(type(self))
        for name, about in numbers.items():
            value = getattr(self, name)
            is_right = type(value) is float and 0.0 < value < math.inf and about.range != "whole"  # mostly
            if not is_right and value is not entries[name].default:
                object.__setattr__(self, name, self._number(value, name.replace("_", " "), about))  # a frozen dataclass

    def _number(self, value, field: str, about: Numeric) -> float | str:
        """A number in SI; expressions of parameters as such, and texts whose unit depends on the model unchanged."""
        if isinstance(value, str) and about.unit is None:
            return value
        what = _Labelled(self, field)
        if isinstance(value, str):
            with named(what):
                value = quantity(value, about.unit)
        minimum = 0.0 if about.range == "nonnegative" else None
        number = real_number(value, what, positive=about.range in ("positive", "whole"), minimum=minimum)
        if not number and about.range == "nonzero":
            raise InputError(f"{what}: found 0; expected a length that is not zero")
        if about.range == "whole" and number != int(number):
            raise InputError(f"{what}: found {number:g}; expected a whole number")
        return value if isinstance(value, Expressed) else number

    def _numbers(self, field: str, what: str) -> ReadOnly:
        """The numbers of a field by name, each named in messages."""
        about, values = fields_of(type(self)).entries[field].about, getattr(self, field)
        return ReadOnly({name: self._number(value, what.format(name), about) for name, value in values.items()})

    def settled(self, units: Mapping[str, str]) -> Self:
        """The element with its texts in SI where their units depend on those of the coordinates, in a model with these."""
        return self

    @property
    def label(self) -> str:
        """The element in a message: its kind and its name."""
        return f'{self.kind} "{self.name or next(self.default_names)}"'

    @property
    def ends(self) -> dict[str, str | None]:
        """The bodies that it joins, each with the unit that its coordinate must have, None for both."""
        return {getattr(self, name): unit for name, unit in fields_of(type(self)).joins}

    @property
    def default_names(self) -> Iterator[str]:
        """Names for an element without one, the first that is not in use to be chosen."""
        base = f"{self.kind} {'-'.join([str(getattr(self, name)) for name, _ in fields_of(type(self)).joins[:2]])}"
        return (f"{base} {number}" if number > 1 else base for number in count(1))


class _Labelled:
    """A field of an element in messages, whose text is made when there is one."""

    def __init__(self, element: Element, field: str):
        self.element, self.field = element, field

    def __str__(self) -> str:
        return f"{self.element.label}: {self.field}"


def unchecked(kind: type, **values) -> Element:
    """An element without validation of its constants, which another element has checked; in formulas they are expressions."""
    element = object.__new__(kind)
    for each in fields(kind):
        object.__setattr__(element, each.name, values.get(each.name, each.default))
    return element


def with_parts(elements: Iterable[Element]) -> tuple[Element, ...]:
    """The elements, each followed by its parts."""
    result: list[Element] = []
    for element in elements:
        result += (element, *element.parts)
    return tuple(result)


# Bodies: the elements that have a coordinate, named as they are.


@dataclass(frozen=True)
class Body(Element):
    """A position along the common axis in m, or an angle in rad."""

    name: Annotated[str, "The name of the body and of its coordinate."] = field()

    has_coordinates = True
    unit: ClassVar[str] = "m"

    @property
    def constant(self) -> float:
        """The mass (kg) or moment of inertia (kg m^2), 0 of a node."""
        return getattr(self, self.kind, 0.0)

    def __post_init__(self):
        constant = self.constant
        if isinstance(constant, (int, float)) and constant == 0 and not isinstance(self, Node):
            node = "rotational node" if self.unit == "rad" else "node"
            raise InputError(f"{self.label}: found no {self.kind}; a point without {self.kind} is a {node}")
        super().__post_init__()


@dataclass(frozen=True)
class Mass(Body):
    """A body that moves along the axis, m x'' = sum of forces."""

    mass: Annotated[Real, Numeric("kg", "Its mass.", "positive")]
    position: Annotated[Real, Numeric("m", "Where it is drawn; the motion does not depend on it.", varied=False)] = None

    weighing = property(lambda self: {self.name: self.mass})


@dataclass(frozen=True)
class Node(Body):
    """A joint without mass, 0 = sum of forces."""

    rotational: Annotated[bool, "true: its coordinate is an angle in rad; false: a position in m."] = False

    unit = property(lambda self: "rad" if self.rotational else "m")


@dataclass(frozen=True)
class Inertia(Body):
    """A body that turns, J q'' = sum of torques."""

    inertia: Annotated[Real, Numeric("kg*m^2", "Its moment of inertia about the axis it turns about.", "positive")]

    unit = "rad"


POINTS = "Points with their distances from the centre of mass along the bar; each is a coordinate, tied to the bar."


@dataclass(frozen=True)
class RigidBar(Mass):
    """A rigid bar that is displaced across its length and turns by a small angle, m x'' = sum of forces, J q'' = sum of moments.

    Its coordinates are the displacement of its centre of mass, named as the bar, its angle, "NAME angle", and the displacement
    of each of its points, named as the point, which springs, dampers and ties are attached to. For each point there is a
    constraint row x_point - x - distance q = 0; its multiplier is the force on the point.

    Example:
        Bounce and pitch of a vehicle on two equal springs at equal distances are independent: w^2 = 2 k/m and 2 k d^2/J.

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.rigid_bar("body", 2.0, inertia=1.0, points={"rear": -1.0, "front": 1.0})
        >>> _ = model.spring("ground", "front", 4.0), model.spring("ground", "rear", 4.0)
        >>> model.assemble().modes().natural_frequencies.round(9).tolist()
        [2.0, 2.828427125]
    """

    name: Annotated[str, 'The name of the bar and of the displacement of its centre of mass; its angle is "NAME angle".'] = field()
    inertia: Annotated[Real, Numeric("kg*m^2", "Its moment of inertia about the centre of mass.", "positive")] = field(kw_only=True)
    points: Annotated[Mapping[str, Real], Numeric("m", POINTS)] = field(kw_only=True)

    constant = property(lambda self: self.mass)

    def __post_init__(self):
        if not isinstance(self.points, Mapping) or not self.points:
            raise InputError(f'{self.label}: points: expected distances by name, such as {{"rear": -1.5, "front": 1.2}}')
        for point in self.points:
            if not isinstance(point, str) or not point.strip():
                raise InputError(f"{self.label}: points: found the name {point!r}; expected a text")
        object.__setattr__(self, "points", self._numbers("points", 'distance of "{}"'))
        Element.__post_init__(self)

    @property
    def angle(self) -> str:
        """Name of the coordinate of its angle."""
        return f"{self.name} angle"

    @property
    def parts(self) -> tuple[Element, ...]:  # type: ignore[override]  # constant in other classes
        """The inertia of its angle, a node for each point, and the rows of the points."""
        rows = (
            unchecked(Relation, name=f"{point} on {self.name}", coefficients={point: 1.0, self.name: -1.0, self.angle: -distance})
            for point, distance in self.points.items()
        )
        nodes = (unchecked(Node, name=point) for point in self.points)
        return (unchecked(Inertia, name=self.angle, inertia=self.inertia), *nodes, *rows)


# Links: springs and dampers, which resist an elongation, and gears with elastic teeth.

LOSS_FACTOR = "eta of structural damping, k (1 + i eta): for frequency responses and steady states, not for motion in time."


@dataclass(frozen=True)
class TwoEnded(Element):
    """An element between two bodies; its row is that of the displacement of its end relative to its start, by coordinate."""

    start: Annotated[str, Joins('The body at its start; "ground" does not move.')]
    end: Annotated[str, Joins("The body at its end.")]

    end_count = 2
    spellings: ClassVar = {"between": ("start", "end")}
    row = property(lambda self: {self.start: -1, self.end: 1})


@dataclass(frozen=True)
class Link(TwoEnded):
    """An element with the force -stiffness (e - rest) - damping e' along its elongation e, the sum of row times coordinate.

    Attributes:
        unit: of its elongation.
        rest: its elongation without force.
        row: the factors of the coordinates; that of the ground is ignored.
    """

    unit = property(lambda self: self.axis)
    rest = property(lambda self: 0.0)


@dataclass(frozen=True)
class Spring(Link):
    """A linear spring along the axis: force -stiffness (x_end - x_start - rest_length) on the end, its opposite on the start."""

    stiffness: Annotated[Real, Numeric("N/m", "Force by elongation.", "positive")]
    rest_length: Annotated[Real, Numeric("m", "x_end - x_start at which the spring is without force.")] = 0.0
    loss_factor: Annotated[Real, Numeric("1", LOSS_FACTOR, "nonnegative", varied=False)] = 0.0

    symbol = "spring"
    rest = property(lambda self: self.rest_length)


@dataclass(frozen=True)
class Damper(Link):
    """A linear damper along the axis: force -damping (x_end' - x_start') on the end, its opposite on the start."""

    damping: Annotated[Real, Numeric("N*s/m", "Force by velocity.", "nonnegative")]

    symbol = "damper"


@dataclass(frozen=True)
class TorsionSpring(Link):
    """A linear torsion spring: torque -stiffness (q_end - q_start - rest_angle) on the end, its opposite on the start."""

    stiffness: Annotated[Real, Numeric("N*m/rad", "Torque by angle.", "positive")]
    rest_angle: Annotated[Real, Numeric("rad", "q_end - q_start at which the spring is without torque.")] = 0.0
    loss_factor: Annotated[Real, Numeric("1", LOSS_FACTOR, "nonnegative", varied=False)] = 0.0

    axis, symbol = "rad", "torsion spring"
    rest = property(lambda self: self.rest_angle)


@dataclass(frozen=True)
class TorsionDamper(Link):
    """A linear torsion damper: torque -damping (q_end' - q_start') on the end, its opposite on the start."""

    damping: Annotated[Real, Numeric("N*m*s/rad", "Torque by angular velocity.", "nonnegative")]

    axis, symbol = "rad", "torsion damper"


#: The pressure angle of standard involute gears, rad.
PRESSURE_ANGLE = math.radians(20)


@dataclass(frozen=True)
class GearMesh(Link):
    """Two gears with elastic teeth: force -stiffness e - damping e' along the line of action, e = r_start q_start + r_end q_end.

    The radii r are those of the base circles, module * teeth * cos(pressure_angle) / 2; that of the end is negative for an internal
    gear. The torques are r times the force. The teeth remain in contact, without backlash. A transmission error e_0(t) is a load:
    the torques r (stiffness e_0 + damping e_0').

    Example:
        Both gears oscillate against each other with w^2 = k (r_start^2 / J_start + r_end^2 / J_end).

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.inertia("pinion", "0.02 kg*m^2"), model.inertia("wheel", "0.08 kg*m^2")
        >>> _ = model.gear_mesh("pinion", "wheel", "100 N/mm", start_radius="40 mm", end_radius="80 mm")
        >>> model.assemble().modes().natural_frequencies.round(9).tolist()
        [126.491106407]
    """

    stiffness: Annotated[Real, Numeric("N/m", "Force along the line of action by approach of the teeth.", "positive")]
    damping: Annotated[Real, Numeric("N*s/m", "Force along the line of action by velocity.", "nonnegative")] = 0.0
    start_radius: Annotated[Real, Numeric("m", "Radius of the base circle at the start; give these or the teeth.", "positive")] = (
        None
    )
    end_radius: Annotated[Real, Numeric("m", "Radius of the base circle at the end.", "positive")] = None
    start_teeth: Annotated[Real, Numeric("1", "Number of teeth at the start.", "whole", varied=False)] = None
    end_teeth: Annotated[Real, Numeric("1", "Number of teeth at the end.", "whole", varied=False)] = None
    module: Annotated[Real, Numeric("m", "Pitch diameter by number of teeth.", "positive")] = None
    pressure_angle: Annotated[Real, Numeric("rad", "Pressure angle of the teeth; 20 degrees when left out.")] = None
    internal: Annotated[bool, "true where one gear runs inside the other."] = False

    axis, unit, symbol = "rad", "m", "gear"
    spellings: ClassVar = {**TwoEnded.spellings, "radii": ("start_radius", "end_radius"), "teeth": ("start_teeth", "end_teeth")}

    def __post_init__(self):
        super().__post_init__()
        radii, teeth = (self.start_radius, self.end_radius), (self.start_teeth, self.end_teeth, self.module)
        by_radii = None not in radii and (*teeth, self.pressure_angle) == (None,) * 4
        if not (by_radii or (None not in teeth and radii == (None, None))):
            raise InputError(f"{self.label}: expected both radii of the base circles, or both numbers of teeth and the module")

    @property
    def sizes(self) -> tuple[float, float]:
        """Radii, or numbers of teeth, which are proportional to them."""
        return (self.start_teeth, self.end_teeth) if self.module is not None else (self.start_radius, self.end_radius)

    @property
    def row(self) -> dict[str, float]:
        angle = PRESSURE_ANGLE if self.pressure_angle is None else self.pressure_angle
        factor = 1 if self.module is None else self.module * _cosine(angle, self.label) / 2
        start, end = (factor * size for size in self.sizes)
        return {self.start: start, self.end: -end if self.internal else end}


def _cosine(angle, label: str):
    """The cosine of a float or complex number, or of an exact one as a decimal."""
    if isinstance(angle, (float, complex)):
        return np.cos(angle)
    try:
        return Fraction(repr(math.cos(angle)))
    except TypeError:
        raise InputError(f"{label}: there is no formula with a symbol for the pressure angle; give it as a number") from None


# Feedback with dead time: forces that follow what was measured a delay before.

MEASURED = "Where what is measured starts, of displacement and velocity of its end relative to it; its own {} when left out."


@dataclass(frozen=True)
class DelayedFeedback(TwoEnded):
    """Feedback with dead time: force -(displacement_gain e + velocity_gain e')(t - delay) on the end, its opposite on the start.

    e = x_end - x_start of the element itself, or of the bodies that are measured. Negative gains are a positive feedback. Before t = 0
    nothing was measured.

    Example:
        Regenerative cutting: the thickness of the chip is that of this revolution less that of the one before, k_c (x - x(t - delay)).

        >>> from mbconstrained import LumpedModel
        >>> lathe = LumpedModel()
        >>> _ = lathe.mass("tool", 1.0), lathe.spring("ground", "tool", 100.0), lathe.damper("ground", "tool", 2.0)
        >>> _ = lathe.spring("ground", "tool", 40.0, name="cutting")
        >>> _ = lathe.delayed_feedback("ground", "tool", delay=0.5, displacement_gain=-40.0)
        >>> round(lathe.assemble().characteristic_roots(1).stability_margin, 6)  # chatter: it grows
        -0.242152
    """

    delay: Annotated[Real, Numeric("s", "Dead time between the measurement and the force.", "positive", varied=False)]
    displacement_gain: Annotated[Real, Numeric("N/m", "Force by displacement.", varied=False)] = 0.0
    velocity_gain: Annotated[Real, Numeric("N*s/m", "Force by velocity.", varied=False)] = 0.0
    measured_start: Annotated[str, Joins(MEASURED.format("start"))] = None
    measured_end: Annotated[str, Joins("The body that is measured; its own end when left out.")] = None

    symbol = "strut"
    unit = property(lambda self: self.axis)

    def __post_init__(self):
        super().__post_init__()
        if not self.displacement_gain and not self.velocity_gain:
            raise InputError(f"{self.label}: found no gain; give displacement_gain, velocity_gain or both")
        measured = self.measured_start or self.start, self.measured_end or self.end
        if measured[0] == measured[1]:
            raise InputError(f'{self.label}: it measures "{measured[0]}" relative to itself; give different bodies')

    @property
    def ends(self) -> dict[str, str | None]:
        return {name: unit for name, unit in super().ends.items() if name is not None}

    @property
    def measured_row(self) -> dict[str, float]:
        """The factors of the coordinates in what is measured."""
        return {self.measured_start or self.start: -1.0, self.measured_end or self.end: 1.0}


@dataclass(frozen=True)
class DelayedTorsionFeedback(DelayedFeedback):
    """Feedback with dead time of a shaft: torque -(displacement_gain e + velocity_gain e')(t - delay) on the end, its opposite on the start.

    e = q_end - q_start of the element itself, or of the bodies that are measured.
    """

    displacement_gain: Annotated[Real, Numeric("N*m/rad", "Torque by angle.", varied=False)] = 0.0
    velocity_gain: Annotated[Real, Numeric("N*m*s/rad", "Torque by angular velocity.", varied=False)] = 0.0

    axis = "rad"


# Ties: elements that are one constraint row each. The multiplier is the force or torque that each names.


class Tie(Element):
    """The row: the sum of coefficient times coordinate, in the derivative of its level, equals the row's value.

    Attributes:
        row: the coefficients by coordinate; that of the ground is ignored.
        row_value: the right-hand side.
    """

    level: Level = "position"  # of the row
    end_count = 2
    row = property(lambda self: {})
    row_value = property(lambda self: 0.0)


@dataclass(frozen=True)
class TwoEndedTie(TwoEnded, Tie):
    """A tie of two bodies."""


@dataclass(frozen=True)
class RigidTie(TwoEndedTie):
    """A rigid link: x_end - x_start = distance; the multiplier is the force, or torque, on the end."""

    distance: Annotated[Real, Numeric(None, "x_end - x_start; a length, or an angle between bodies that turn.")] = 0.0

    axis, symbol = None, "rod"
    row_value = property(lambda self: self.distance)

    def settled(self, units: Mapping[str, str]) -> Self:
        if not isinstance(self.distance, (str, Expressed)):
            return self
        with named(f"{self.label}: distance"):
            return replace(self, distance=quantity(self.distance, next((units[name] for name in self.ends if name in units), "m")))


@dataclass(frozen=True)
class Lever(TwoEndedTie):
    """A massless lever on a fixed pivot: x_start / start_arm + x_end / end_arm = 0; the multiplier is the force on the start."""

    start_arm: Annotated[Real, Numeric("m", "The arm from the pivot to the start.", "nonzero")]
    end_arm: Annotated[Real, Numeric("m", "The arm to the end; negative where it lies on the same side as the other.", "nonzero")]

    symbol = "rod"
    spellings: ClassVar = {**TwoEnded.spellings, "arms": ("start_arm", "end_arm")}
    row = property(lambda self: {self.start: 1.0, self.end: self.start_arm / self.end_arm})


@dataclass(frozen=True)
class Gear(TwoEndedTie):
    """Two gear wheels in mesh: start_radius q_start + end_radius q_end = 0; the multiplier is the torque on the start."""

    start_radius: Annotated[
        Real, Numeric("m", "Radius of the one wheel, or its number of teeth: their ratio counts.", "positive")
    ] = None
    end_radius: Annotated[Real, Numeric("m", "Radius of the other wheel, or its number of teeth.", "positive")] = None
    internal: Annotated[bool, "true where one wheel runs inside the other; both then turn in the same direction."] = False
    ratio: Annotated[Real, Numeric("1", "In place of radii: turns of the start for one turn of the end.", "positive")] = None

    axis, symbol = "rad", "gear"
    spellings: ClassVar = {**TwoEnded.spellings, "radii": ("start_radius", "end_radius"), "teeth": ("start_radius", "end_radius")}

    def __post_init__(self):
        super().__post_init__()
        if [self.start_radius is None, self.end_radius is None] != [self.ratio is not None] * 2:
            raise InputError(f"{self.label}: expected both radii, both numbers of teeth, or the ratio of their speeds")

    @property
    def sizes(self) -> tuple[float, float]:
        """Radii, or numbers that are proportional to them."""
        return (self.start_radius, self.end_radius) if self.ratio is None else (1.0, self.ratio)

    @property
    def row(self) -> dict[str, float]:
        ratio = self.end_radius / self.start_radius if self.ratio is None else self.ratio
        return {self.start: 1.0, self.end: -ratio if self.internal else ratio}


@dataclass(frozen=True)
class Rack(Tie):
    """A rack and pinion, x_rack = radius q_gear; the multiplier is the force on the rack."""

    gear: Annotated[str, Joins("The pinion, a coordinate in rad.", "rad")]
    rack: Annotated[str, Joins("The rack, a coordinate in m.", "m")]
    radius: Annotated[Real, Numeric("m", "The pitch radius of the pinion; negative where it turns the other way.", "nonzero")]

    symbol = "rack"
    spellings: ClassVar = {"between": ("gear", "rack")}
    row = property(lambda self: {self.rack: 1.0, self.gear: -self.radius})

    def settled(self, units: Mapping[str, str]) -> Self:
        if units.get(self.gear) == "m" and units.get(self.rack) == "rad":
            raise InputError(f'gear is what turns, here "{self.rack}", and rack what moves, "{self.gear}"; they are swapped')
        return self


@dataclass(frozen=True)
class Pulley(TwoEndedTie):
    """An inextensible rope whose ends hang below a pulley on both sides, x_start + x_end - 2 x_over = -length, positions upwards.

    The length is negative where the ends lie above the pulley. Without one the coordinates are displacements from a state in which the rope is taut, and the right-hand side is 0. The
    multiplier is the tension (minus the tension where the ends lie above). The row acts in both directions: a real rope goes slack
    where its tension would be negative.
    """

    over: Annotated[str, Joins("The body that carries the pulley.")] = GROUND
    length: Annotated[Real, Numeric("m", "The length of rope on both sides; left out: just taut at the start.", "nonzero")] = None

    end_count = 3
    symbol = "belt"
    row = property(lambda self: {self.start: 1.0, self.end: 1.0, self.over: -2.0})
    row_value = property(lambda self: 0.0 if self.length is None else -self.length)


COEFFICIENTS = 'Coordinates with their factors, e.g. { x1 = 1, q1 = -1 } or { heave = 1, pitch = "1.01 m" }.'


@dataclass(frozen=True)
class Relation(Tie):
    """One constraint row: the sum of coefficient times coordinate, or its first or second derivative, equals the value."""

    coefficients: Annotated[Mapping[str, Real], Numeric(None, COEFFICIENTS)]
    value: Annotated[Real, Numeric(None, "The right-hand side, constant in time.")] = 0.0
    level: Annotated[Level, "What the row holds for: positions, velocities or accelerations."] = "position"

    kind = "constraint"
    end_count = 1
    spellings: ClassVar = {"rows": ("coefficients",)}

    def __post_init__(self):
        if not isinstance(self.coefficients, Mapping) or not self.coefficients:
            raise InputError(f'{self.label}: expected factors by coordinate, such as {{"cart": 1, "hook": -1}}')
        object.__setattr__(self, "coefficients", self._numbers("coefficients", "factor of {}"))
        super().__post_init__()
        checked_level(self.level, self.label)

    def settled(self, units: Mapping[str, str]) -> Self:
        if not any(isinstance(each, (str, Expressed)) for each in (*self.coefficients.values(), self.value)):
            return self
        with named(self.label):
            factors, value, _ = row_in_si(self.coefficients, self.value, self.level, units)
        return replace(self, coefficients=factors, value=value)

    default_names = property(lambda self: (f"constraint {number}" for number in count(1)))
    ends = property(lambda self: dict.fromkeys(self.coefficients))
    row = property(lambda self: dict(self.coefficients))
    row_value = property(lambda self: self.value)


def row_in_si(coefficients: Mapping[str, Any], value, level: Level, units: Mapping[str, str]) -> tuple[dict, Any, str | None]:
    """The factors and the right-hand side of a constraint row in SI, perhaps expressions, between coordinates of these units; and the unit
    of the sum of factor times coordinate, "m", "rad" or "1", None where its terms have several.

    A factor with a unit must make the unit of the terms without one of its coordinate's, as in { heave = 1, pitch = "1.01 m" };
    where all factors have units, all terms must be of one kind. A unit of the value is understood where the terms have one.
    """
    measured = {name: any_quantity(factor) for name, factor in coefficients.items()}
    bare = sorted({units[name] for name, (_, kind) in measured.items() if kind is None})
    unit = bare[0] if len(bare) == 1 else None
    if any(kind is not None for _, kind in measured.values()):  # otherwise no unit is looked at
        common = _common_kinds(coefficients, {name: kind for name, (_, kind) in measured.items()}, units)
        if not bare:
            unit = next((unit for unit in ("m", "rad") if dimension(unit).units == common[0].units), None)
    power = LEVELS.index(level)
    if isinstance(value, str) and unit is None:
        mixed = " and ".join(rate_unit(each, power) for each in bare) or "units other than m and rad"
        raise InputError(f"value: found {shown(value)}; this row mixes {mixed}: give a plain number")
    with named("value"):
        number = quantity(value, rate_unit(unit, power) if unit else "1")
    return {name: factor for name, (factor, _) in measured.items()}, number, unit


def _common_kinds(rows: Mapping[str, Any], kinds: Mapping[str, Dimension | None], own: Mapping[str, str]) -> list[Dimension]:
    """The common dimensions of the terms of a row."""
    common = [dimension(own[name]) for name, kind in kinds.items() if kind is None]
    for name, kind in kinds.items():
        if kind is None:
            continue
        term = kind.times(dimension(own[name]))
        common = common or [term]
        if all(term.units != other.units for other in common):
            wanted = " or ".join(dict.fromkeys(unit_of(other.times(dimension(own[name]), -1)) for other in common))
            raise InputError(
                f"{name}: found {shown(rows[name])}; expected a factor in {wanted}, so that all terms of the row have the same unit"
            )
    return common


@dataclass(frozen=True)
class PrescribedMotion(Tie):
    """A prescribed motion of a body: its displacement, velocity or acceleration is factor times a signal b(t) (base excitation).

    The multiplier is the force that the support must supply.
    """

    body: Annotated[str, Joins("The body whose coordinate is prescribed.")]
    signal: Annotated[ImpulsiveSmooth, "b in SI with one row, e.g. mb.harmonic([0.01], frequency_hz=2) or a record, mb.sampled."]
    factor: Annotated[Real, Numeric("1", "Factor of the signal, where several supports move by multiples of one signal.")] = 1.0
    level: Annotated[Level, '"position" for a displacement, "velocity", or "acceleration".'] = "position"

    axis = None
    end_count = 1
    kind = "motion"

    def __post_init__(self):
        super().__post_init__()
        if not isinstance(self.signal, ImpulsiveSmooth) or self.signal.size != 1:
            raise InputError(f"{self.label}: expected a signal with one row, such as mb.step([0.1])")
        if self.body == GROUND:
            raise InputError(f'{self.label}: "ground" does not move; prescribe the motion of a body or a node')
        checked_level(self.level, self.label)

    default_names = property(lambda self: (f"motion of {self.body}{f' {number}' if number > 1 else ''}" for number in count(1)))
    row = property(lambda self: {self.body: 1.0})
    row_value = property(lambda self: self.factor * self.signal)
