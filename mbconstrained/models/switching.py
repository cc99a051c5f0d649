"""Elements with several states: contacts, backlash, ropes, springs with a knee, dry friction, clutches, brakes, latches, and releases.

A model with one of them is assembled to a ``SwitchedSystem``. Each class makes its switch (``mechanics.switched.switches``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np

from ..ground.checks import real_number
from ..ground.errors import InputError, named
from ..ground.quantities import Expressed, quantity
from ..mechanics.constraints import Constraint
from ..mechanics.switched.switches import (
    ForceBranch,
    Guard,
    Switch,
    SwitchState,
    TimedChange,
    checked_restitution,
    elastic_contact,
    friction,
    latch,
    piecewise_spring,
    releasable,
    rigid_contact,
)
from .elements import Element, Link, Numeric, Tie, TwoEnded

if TYPE_CHECKING:
    Real = Any
else:
    Real = float

Row = np.ndarray


@dataclass(frozen=True)
class SwitchingElement(TwoEnded):
    """An element between two bodies that has several states."""

    axis: ClassVar[str | None] = None
    symbol: ClassVar[Any] = "stop"
    #: Units of fields without one, between bodies that move and that turn.
    own_units: ClassVar[Mapping[str, tuple[str, str]]] = {}

    def settled(self, units: Mapping[str, str]) -> Self:
        unit = next((units[name] for name in self.ends if name in units), "m")
        changed: dict[str, Any] = {}
        for field, both in self.own_units.items():
            value = getattr(self, field)
            if isinstance(value, (str, Expressed)):
                with named(f"{self.label}: {field.replace('_', ' ')}"):
                    changed[field] = quantity(value, both[unit == "rad"])
        return replace(self, **changed) if changed else self

    @property
    def limits(self) -> tuple[float | None, float | None]:
        """The displacements of its end relative to its start at which it closes from above and from below."""
        return None, None

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        """The switches of the element, for its row over the coordinates of a model."""
        raise NotImplementedError


LENGTH, SPRING, DAMPER, FORCE = ("m", "rad"), ("N/m", "N*m/rad"), ("N*s/m", "N*m*s/rad"), ("N", "N*m")


@dataclass(frozen=True)
class Contact(SwitchingElement):
    """A stop: the end comes no nearer to the start than by the gap, x_end - x_start + gap >= 0.

    Without stiffness it is rigid: impacts by Newton's law of restitution, velocity after = -restitution times velocity before; rest without
    rebound; it opens where it would have to pull. With stiffness it is an elastic, perhaps damped stop that never pulls. The multiplier
    of a rigid contact is its force, positive in compression.

    Example:
        A ball dropped from 1 m onto the ground hits it after sqrt(2 h / g).

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.mass("ball", 1.0), model.gravity(-9.81), model.contact("ground", "ball", gap=1.0, restitution=0.5)
        >>> x = model.assemble().solve(end=1.0)
        >>> round(x.events[0].time, 9), round(x.events[0].energy_lost, 9)  # (1 - e^2) m g h
        (0.451523641, 7.3575)
    """

    gap: Annotated[Real, Numeric(None, "How far the end may come nearer to the start; 0 when left out.", varied=False)] = 0.0
    restitution: Annotated[Real, Numeric("1", "Velocity after an impact by that before it, 0 to 1.", varied=False)] = 0.0
    stiffness: Annotated[Real, Numeric(None, "Of an elastic stop; rigid when left out.", varied=False)] = None
    damping: Annotated[Real, Numeric(None, "Of an elastic stop.", varied=False)] = 0.0
    two_sided: Annotated[bool, "true: the end moves away from the start by no more than the gap, too."] = False

    own_units: ClassVar = {"gap": LENGTH, "stiffness": SPRING, "damping": DAMPER}

    def __post_init__(self):
        super().__post_init__()
        checked_restitution(self.restitution, self.label)
        for name in ("gap", "damping", "stiffness"):
            value = getattr(self, name)
            if isinstance(value, float) and (value < 0 or (name == "stiffness" and value == 0)):
                more = "a start in penetration is given by the values at the start" if name == "gap" else "it resists motion"
                raise InputError(f"{self.label}: {name}: found {value:g}; expected a positive number: {more}")
        if self.stiffness is not None and self.restitution:
            raise InputError(
                f"{self.label}: found stiffness and restitution; a rigid contact has restitution, an elastic one damping"
            )
        if self.stiffness is None and self.damping:
            raise InputError(f"{self.label}: found damping without stiffness; give both, or restitution of a rigid contact")

    @property
    def limits(self) -> tuple[float | None, float | None]:
        return -self.gap, self.gap if self.two_sided else None

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        sides = ((self.name, row), (f"{self.name} far side", -row)) if self.two_sided else ((self.name, row),)
        if self.stiffness is None:
            return tuple(rigid_contact(name, own, self.gap, self.restitution, unit) for name, own in sides)
        return tuple(elastic_contact(name, own, self.gap, self.stiffness, self.damping, unit) for name, own in sides)


@dataclass(frozen=True)
class Backlash(SwitchingElement):
    """Play between two bodies: no force while |x_end - x_start| < gap / 2, then a spring, with damping that never pulls.

    The gap is the whole play, half of it on each side of x_end = x_start.
    """

    gap: Annotated[Real, Numeric(None, "The whole play, from one side to the other.", "positive", varied=False)]
    stiffness: Annotated[Real, Numeric(None, "Beyond the play.", "positive", varied=False)]
    damping: Annotated[Real, Numeric(None, "Beyond the play.", "nonnegative", varied=False)] = 0.0

    own_units: ClassVar = {"gap": LENGTH, "stiffness": SPRING, "damping": DAMPER}

    symbol = "slot"

    @property
    def limits(self) -> tuple[float | None, float | None]:
        return -self.gap / 2, self.gap / 2

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        names = (f"{self.name} backward", row), (f"{self.name} forward", -row)
        return tuple(elastic_contact(name, own, self.gap / 2, self.stiffness, self.damping, unit) for name, own in names)


@dataclass(frozen=True)
class OneSidedSpring(SwitchingElement):
    """A spring in compression only: force -stiffness (x_end - x_start - rest_length) while that is positive; or in tension only."""

    stiffness: Annotated[Real, Numeric(None, "While it acts.", "positive", varied=False)]
    rest_length: Annotated[Real, Numeric(None, "x_end - x_start at which it begins to act.", varied=False)] = 0.0
    damping: Annotated[Real, Numeric(None, "While it acts.", "nonnegative", varied=False)] = 0.0
    pulls: Annotated[bool, "true: it acts in tension; false: in compression."] = False

    own_units: ClassVar = {"rest_length": LENGTH, "stiffness": SPRING, "damping": DAMPER}

    @property
    def limits(self) -> tuple[float | None, float | None]:
        return (None, self.rest_length) if self.pulls else (self.rest_length, None)

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        sign = -1.0 if self.pulls else 1.0
        return (elastic_contact(self.name, sign * row, -sign * self.rest_length, self.stiffness, self.damping, unit),)


@dataclass(frozen=True)
class Cable(SwitchingElement):
    """A cable, which only pulls: it is taut at x_end - x_start = length, and slack before.

    A negative length is that of a cable whose end lies below its start. Without stiffness it does not stretch; it becomes taut without
    rebound, and the multiplier is its tension.
    """

    length: Annotated[Real, Numeric(None, "x_end - x_start at which it is taut.", "nonzero", varied=False)]
    stiffness: Annotated[Real, Numeric(None, "Tension by stretch; it does not stretch when left out.", varied=False)] = None
    damping: Annotated[Real, Numeric(None, "While it is taut.", "nonnegative", varied=False)] = 0.0

    symbol = "cable"
    own_units: ClassVar = {"length": LENGTH, "stiffness": SPRING, "damping": DAMPER}

    @property
    def limits(self) -> tuple[float | None, float | None]:
        return (None, self.length) if self.length > 0 else (self.length, None)

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        own = -math.copysign(1.0, self.length) * row
        if self.stiffness is None:
            return (rigid_contact(self.name, own, abs(self.length), 0.0, unit),)
        return (elastic_contact(self.name, own, abs(self.length), self.stiffness, self.damping, unit),)


@dataclass(frozen=True)
class PiecewiseSpring(SwitchingElement):
    """A spring with knees: its force is a continuous, piecewise linear function of x_end - x_start - rest_length, zero at 0."""

    breakpoints: Annotated[Sequence[Real], Numeric("m", "Elongations at which the stiffness changes, ascending.", varied=False)]
    stiffnesses: Annotated[Sequence[Real], Numeric("N/m", "One more than breakpoints, from below.", varied=False)]
    rest_length: Annotated[Real, Numeric("m", "x_end - x_start at which it is without force.", varied=False)] = 0.0

    axis, symbol = "m", "spring"

    def __post_init__(self):
        super().__post_init__()
        for field, unit in (("breakpoints", "m"), ("stiffnesses", "N/m")):
            values = getattr(self, field)
            if isinstance(values, (str, bytes)) or not isinstance(values, Sequence):
                raise InputError(f"{self.label}: {field}: expected a list of numbers")
            with named(f"{self.label}: {field}"):
                numbers = tuple(real_number(quantity(one, unit) if isinstance(one, str) else one, field) for one in values)
            object.__setattr__(self, field, numbers)
        if len(self.stiffnesses) != len(self.breakpoints) + 1 or not self.breakpoints:
            raise InputError(
                f"{self.label}: found {len(self.breakpoints)} breakpoints and {len(self.stiffnesses)} stiffnesses; expected one stiffness more"
            )
        if any(a >= b for a, b in zip(self.breakpoints, self.breakpoints[1:])):
            raise InputError(f"{self.label}: breakpoints: expected ascending numbers")

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        return (piecewise_spring(self.name, row, self.breakpoints, self.stiffnesses, self.rest_length),)


@dataclass(frozen=True)
class DryFriction(SwitchingElement):
    """Coulomb friction between two bodies: a force coefficient times normal_force against their relative velocity.

    At relative rest it takes whatever force keeps them together, up to static_coefficient times normal_force: that state is exact, a
    constraint row whose multiplier is the friction force.
    """

    normal_force: Annotated[
        Real, Numeric("N", "Constant; between bodies that turn, with the radius included.", "positive", varied=False)
    ]
    coefficient: Annotated[Real, Numeric("1", "Of kinetic friction.", "positive", varied=False)]
    static_coefficient: Annotated[
        Real, Numeric("1", "Of static friction; that of kinetic friction when left out.", varied=False)
    ] = None

    symbol = "friction"

    def __post_init__(self):
        super().__post_init__()
        if self.static_coefficient is not None and self.static_coefficient < self.coefficient:
            raise InputError(
                f"{self.label}: static coefficient: found {self.static_coefficient:g}; expected at least the kinetic one, {self.coefficient:g}"
            )

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        static = self.coefficient if self.static_coefficient is None else self.static_coefficient
        return (friction(self.name, row, self.coefficient * self.normal_force, static * self.normal_force, unit),)


@dataclass(frozen=True)
class Clutch(SwitchingElement):
    """A clutch or brake: from a time on two speeds become one; it slips where more than its torque would be needed.

    Without a torque it is rigid: the speeds jump to the common one at once, and the impulse is reported.
    """

    torque: Annotated[Real, Numeric(None, "The largest torque, or force; rigid when left out.", "positive", varied=False)] = None
    static_torque: Annotated[Real, Numeric(None, "At relative rest; as torque when left out.", "positive", varied=False)] = None
    engaged: Annotated[Real, Numeric("s", "From this time on.", "nonnegative", varied=False)] = 0.0
    released: Annotated[Real, Numeric("s", "Until this time; for ever when left out.", "positive", varied=False)] = None

    symbol = "friction"
    own_units: ClassVar = {"torque": FORCE, "static_torque": FORCE}

    def __post_init__(self):
        super().__post_init__()
        if self.released is not None and self.released <= self.engaged:
            raise InputError(
                f"{self.label}: it is released at {self.released:g} s and engaged at {self.engaged:g} s; expected a later release"
            )

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        torque = math.inf if self.torque is None else self.torque
        static = torque if self.static_torque is None else self.static_torque
        until = math.inf if self.released is None else self.released
        return (friction(self.name, row, torque, static, unit, self.engaged, until),)


@dataclass(frozen=True)
class Brake(Clutch):
    """A brake between a body and the ground, or another one, as a clutch: from a time on, with a largest torque or force."""


@dataclass(frozen=True)
class Latch(SwitchingElement):
    """Two bodies that are joined for good where x_end - x_start reaches a distance, or from a time on; without rebound."""

    distance: Annotated[Real, Numeric(None, "x_end - x_start at which it closes.", varied=False)] = None
    at: Annotated[Real, Numeric("s", "The time at which it closes, at whatever distance.", "positive", varied=False)] = None

    symbol = "latch"
    own_units: ClassVar = {"distance": LENGTH}

    @property
    def limits(self) -> tuple[float | None, float | None]:
        return self.distance, self.distance

    def __post_init__(self):
        super().__post_init__()
        if (self.distance is None) == (self.at is None):
            raise InputError(
                f"{self.label}: expected a distance, or a time at; found {'both' if self.at is not None else 'neither'}"
            )

    def switches(self, row: Row, unit: str) -> tuple[Switch, ...]:
        return (latch(self.name, row, unit, self.distance, self.at),)


@dataclass(frozen=True)
class Release(Element):
    """The end of an element: from a time on, or from where its force or its elongation reaches a value, it is gone.

    The target is a spring, a damper, a tie, or an element with several states such as a latch.
    """

    target: Annotated[str, "The name of the element that is released."]
    at: Annotated[Real, Numeric("s", "The time.", "positive", varied=False)] = None
    force: Annotated[Real, Numeric("N", "The force or torque of the target, of either sign.", "positive", varied=False)] = None
    above: Annotated[Real, Numeric("m", "The elongation of the target above which it is released.", varied=False)] = None
    below: Annotated[Real, Numeric("m", "The elongation of the target below which it is released.", varied=False)] = None

    axis: ClassVar[str | None] = None

    def __post_init__(self):
        super().__post_init__()
        given = [name for name in ("at", "force", "above", "below") if getattr(self, name) is not None]
        if len(given) != 1:
            raise InputError(f"{self.label}: expected one of at, force, above, below; found {', '.join(given) or 'none'}")

    @property
    def default_names(self):
        base = f"release of {self.target}"
        return iter((base, *(f"{base} {number}" for number in range(2, 1000))))

    def guards(self, row: Row, name: str, branch: ForceBranch | None) -> tuple[Guard, ...]:
        """The guards of the target while it acts."""
        none, text = np.zeros(len(row)), "is released"
        if self.above is not None:
            return (Guard("released", -row, none, -self.above, text=text),)
        if self.below is not None:
            return (Guard("released", row, none, self.below, text=text),)
        if self.force is None:
            return ()
        if branch is None:
            return tuple(Guard("released", none, none, -self.force, {name: sign}, text=text) for sign in (1.0, -1.0))
        k, c = branch.stiffness * row, branch.damping * row
        rest = branch.stiffness * branch.rest
        return (Guard("released", k, c, rest - self.force, text=text), Guard("released", -k, -c, -rest - self.force, text=text))


def released(element: Link | Tie, release: Release, row: Row, unit: str) -> Switch:
    """The switch of a spring, damper or tie that is released."""
    if isinstance(element, Link):
        branch = ForceBranch(row, vars(element).get("stiffness", 0.0), element.rest, vars(element).get("damping", 0.0))
        return releasable(element.name, (), (branch,), release.at, release.guards(row, element.name, branch), unit)
    tie = Constraint(row, level=element.level, value=element.row_value, names=element.name)
    return releasable(element.name, (tie,), (), release.at, release.guards(row, element.name, None), unit)


def with_release(switches: Sequence[Switch], release: Release, row: Row) -> tuple[Switch, ...]:
    """Switches of one element with a state in which it is released."""
    result = []
    for switch in switches:
        states = {
            name: replace(
                state, guards=(*state.guards, *(release.guards(row, switch.name, None) if state.rows or not release.force else ()))
            )
            for name, state in switch.states.items()
        }
        switch.states = {**states, "released": SwitchState()}
        if release.at is not None:
            change = TimedChange(release.at, "released", text="is released")
            if any(one.time == release.at and one.target != "released" for one in switch.times):
                raise InputError(f'"{switch.name}" is closed and released at once, at {release.at:g} s; give different times')
            switch.times = tuple(sorted((*switch.times, change), key=lambda one: one.time))
        result.append(switch)
    return tuple(result)
