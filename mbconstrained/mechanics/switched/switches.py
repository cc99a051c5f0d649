"""Switches: parts of a model that have several states, each with constraint rows, forces and guards of its own.

A guard is a linear function of displacements, velocities and multipliers that is positive while the state lasts. A state ends at the
first time at which one of its guards falls to zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from ...ground.by_name import Public, answering
from ...ground.checks import nearest, real_number
from ...ground.errors import InputError
from ..constraints import Constraint, Level

Output = Literal["displacement", "velocity", "reaction"]


#: An output up to a factor: the kind of its leading part, and its entries by the first that is not zero.
Functional = tuple[str, bytes]


def functional(
    displacement: np.ndarray, velocity: np.ndarray, value: float, reactions: Mapping[str, float] | None = None
) -> Functional:
    """d x + c x' + multipliers - value without regard to a factor."""
    kind = "reaction" if reactions else "velocity" if velocity.any() else "displacement"
    entries = np.concatenate([displacement, velocity, list((reactions or {}).values()), [value]])
    first = entries[np.argmax(entries != 0)]
    names = " ".join(reactions or {})
    return kind, (entries / first + 0.0).tobytes() + names.encode()  # no negative zeros


@dataclass(frozen=True, eq=False)
class Guard:
    """g = d x + c x' + sum of factor times multiplier - value, positive while the state lasts."""

    target: str  # the state that follows where it falls to zero
    displacement: np.ndarray  # d, shape (n,)
    velocity: np.ndarray  # c, shape (n,)
    value: float = 0.0
    reactions: Mapping[str, float] = field(default_factory=dict)  # factors of the multipliers of constraint rows by name
    beyond: str | None = None  # the state that follows where it is negative at once, not zero first; None for the same
    restitution: float | None = None  # of an impact along d; None for a guard that is none
    dwell: float = 0.0  # so long, in s, it must stay negative before the state ends
    text: str = ""  # for reports
    is_opposite: bool = False  # whether it ends a dwell

    @cached_property
    def functional(self) -> Functional:
        """The output that vanishes with the guard."""
        return functional(self.displacement, self.velocity, self.value, self.reactions)

    def zeros(self, x: np.ndarray, v: np.ndarray, size: tuple[np.ndarray, np.ndarray], noise: float) -> int:
        """The number of derivatives, the value among them, that are zero by x and x' alone, within a part of their sizes."""
        if self.reactions:
            return 0
        d, c, (x_size, v_size) = self.displacement, self.velocity, size
        if abs(d @ x + c @ v - self.value) > noise * (np.abs(d) @ x_size + np.abs(c) @ v_size + abs(self.value)):
            return 0
        return 2 if not c.any() and abs(d @ v) <= noise * (np.abs(d) @ v_size) else 1

    @property
    def opposite(self) -> Guard:
        """The guard with the opposite sign."""
        factors = {name: -factor for name, factor in self.reactions.items()}
        return replace(
            self, displacement=-self.displacement, velocity=-self.velocity, value=-self.value, reactions=factors, is_opposite=True
        )


@dataclass(frozen=True, eq=False)
class ForceBranch:
    """A force -(stiffness (a x - rest) + damping a x') along a, and a constant one; both on the coordinates by a^T."""

    direction: np.ndarray
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    constant: float = 0.0
    stored: float | None = (
        0.0  # the energy of the spring at a x = rest, J; None where the constant force is none of a spring, as friction
    )

    @property
    def load(self) -> np.ndarray:
        """The force at x = 0, shape (n,)."""
        return self.direction * (self.constant + self.stiffness * self.rest)

    @property
    def potential(self) -> tuple[np.ndarray, float]:
        """The part of that force that has an energy, and the energy at x = 0, J."""
        if self.stored is None:
            return self.direction * (self.stiffness * self.rest), self.stiffness * self.rest**2 / 2
        return self.load, self.stored + self.rest * (self.constant + self.stiffness * self.rest / 2)


@dataclass(frozen=True, eq=False)
class SwitchState:
    """The rows, forces and guards of a switch while it is in a state."""

    rows: tuple[Constraint, ...] = ()
    branches: tuple[ForceBranch, ...] = ()
    guards: tuple[Guard, ...] = ()  # by which the state ends
    slips: str | None = None  # where its force is bounded, so that it passes on no impulse: the state that it takes during impacts


@dataclass(frozen=True, eq=False)
class UnilateralContact:
    """A rigid contact a x + gap >= 0 among the states of a switch."""

    row: np.ndarray  # a
    gap: float  # at x = 0
    restitution: float  # e of a x' after an impact = -e a x' before it
    open: str  # the states
    closed: str
    # of a contact that sticks by further rows, that without these, which follows where it can neither stick nor separate
    sliding: str | None = None

    @cached_property
    def functional(self) -> Functional:
        """The gap."""
        return functional(self.row, np.zeros(len(self.row)), -self.gap)

    def touches(self, x: np.ndarray, noise: float) -> bool:
        """Whether the gap is zero up to a part of its terms."""
        return abs(float(self.row @ x) + self.gap) <= noise * (float(np.abs(self.row) @ np.abs(x)) + abs(self.gap))


class Switch:
    """A named part with several states, the first one at the start."""

    def __init__(
        self,
        name: str,
        states: Mapping[str, SwitchState],
        times: Sequence[TimedChange] = (),  # ascending
        unit: str = "m",  # of its displacement
        contact: UnilateralContact | None = None,  # where it is a rigid one
    ):
        self.name, self.states, self.times, self.unit, self.contact = name, dict(states), tuple(times), unit, contact

    def start(self, x: np.ndarray, v: np.ndarray) -> str:
        """The state at the start."""
        return next(iter(self.states))


@dataclass(frozen=True)
class TimedChange:
    """A change of state at a time."""

    time: float  # in s
    target: str  # the state that follows
    sources: tuple[str, ...] = ()  # the states in which it takes place; empty for all
    text: str = ""  # for reports


class StartSwitch(Switch):
    """A switch whose state at the start is that of the first ascending limit above the displacement, or velocity, along a row."""

    def __init__(self, name, states, row, limits, order: int = 0, times: Sequence[TimedChange] = (), unit: str = "m"):
        super().__init__(name, states, times, unit)
        self.row, self.limits, self.order = row, limits, order

    def start(self, x: np.ndarray, v: np.ndarray) -> str:
        value = float(self.row @ (v if self.order else x))
        return next(state for limit, state in self.limits if value < limit or limit == np.inf)


# The switches of models, by rows over their coordinates.


def rigid_contact(name: str, row: np.ndarray, gap: float, restitution: float, unit: str = "m") -> Switch:
    """a x + gap >= 0 without deformation: impacts by Newton's law of restitution, rest at zero, lift-off where the force would pull."""
    none = np.zeros(len(row))
    states = {
        "open": SwitchState(guards=(Guard("closed", row, none, -gap, restitution=restitution, text="closes"),)),
        "closed": SwitchState(
            rows=(Constraint(row, value=-gap, names=name, unit=unit),),
            guards=(Guard("open", none, none, reactions={name: 1.0}, text="opens"),),
        ),
    }
    return Switch(name, states, unit=unit, contact=UnilateralContact(row, gap, restitution, "open", "closed"))


def elastic_contact(name: str, row: np.ndarray, gap: float, stiffness: float, damping: float = 0.0, unit: str = "m") -> Switch:
    """A force -(k e + c e') for e = a x + gap < 0 that never pulls: where damping would make it pull, the contact separates."""
    none, rest = np.zeros(len(row)), -gap
    branch = ForceBranch(row, stiffness, rest, damping)
    opens = Guard("open", -row, none, gap, text="opens")
    closes = Guard("closed", row, none, rest, text="closes")
    states = {"open": SwitchState(guards=(closes,)), "closed": SwitchState(branches=(branch,), guards=(opens,))}
    if damping:
        separates = Guard("separating", -stiffness * row, -damping * row, -stiffness * rest, text="separates")
        returns = Guard("closed", stiffness * row, damping * row, stiffness * rest, text="closes")
        states["closed"] = SwitchState(branches=(branch,), guards=(opens, separates))
        states["separating"] = SwitchState(guards=(opens, returns))
    return StartSwitch(name, states, row, [(rest, "closed"), (np.inf, "open")], unit=unit)


def piecewise_spring(
    name: str, row: np.ndarray, breakpoints: Sequence[float], stiffness: Sequence[float], rest: float = 0.0
) -> Switch:
    """A continuous force of elongation e = a x - rest with one stiffness more than breakpoints; it is zero at e = 0.

    F(e) = integral from 0 to e of k: in each range F_i + k_i (e - e_i).
    """
    none, edges = np.zeros(len(row)), [-np.inf, *breakpoints, np.inf]

    def force_and_energy(e: float) -> tuple[float, float]:
        force = energy = 0.0
        sign = 1.0 if e >= 0 else -1.0
        for k, low, high in sorted(zip(stiffness, edges, edges[1:]), key=lambda part: sign * part[1]):
            begin, end = (min(max(one, low), high) for one in (0.0, e))
            energy += (end - begin) * (force + k * (end - begin) / 2)
            force += k * (end - begin)
        return force, energy

    names = [f"range {i + 1}" for i in range(len(stiffness))]
    states = {}
    for i, k in enumerate(stiffness):
        low, high = edges[i], edges[i + 1]
        anchor = min(max(0.0, low), high)
        force, energy = force_and_energy(anchor)
        branch = ForceBranch(row, k, rest + anchor, constant=-force, stored=energy)
        guards = []
        if np.isfinite(low):
            guards.append(Guard(names[i - 1], row, none, rest + low, text=f"enters {names[i - 1]}"))
        if np.isfinite(high):
            guards.append(Guard(names[i + 1], -row, none, -rest - high, text=f"enters {names[i + 1]}"))
        states[names[i]] = SwitchState(branches=(branch,), guards=tuple(guards))
    limits = [(rest + edge if np.isfinite(edge) else edge, state) for edge, state in zip(edges[1:], names)]
    return StartSwitch(name, states, row, limits)


def friction(
    name: str,
    row: np.ndarray,
    kinetic: float,
    static: float,
    unit: str = "m",
    engaged: float = 0.0,
    until: float = np.inf,
) -> Switch:
    """Coulomb friction along a: a force of the kinetic size against a x', exactly at rest as long as that takes no more than the static one.

    Infinite limits are those of a rigid connection. It acts between the times engaged and until, in s.
    """
    none = np.zeros(len(row))
    stuck = Constraint(row, level="velocity", names=name, unit=unit)
    if np.isinf(static):
        states = {"locked": SwitchState(rows=(stuck,))}
    else:
        upper = Guard("backward", none, none, -static, {name: -1.0}, text="slips")
        lower = Guard("forward", none, none, -static, {name: 1.0}, text="slips")
        states = {
            "forward": SwitchState(
                branches=(ForceBranch(row, constant=-kinetic, stored=None),),
                guards=(Guard("stuck", none, row, beyond="backward", text="sticks"),),
            ),
            "stuck": SwitchState(rows=(stuck,), guards=(upper, lower), slips="forward"),
            "backward": SwitchState(
                branches=(ForceBranch(row, constant=kinetic, stored=None),),
                guards=(Guard("stuck", none, -row, beyond="forward", text="sticks"),),
            ),
        }
    acting, times, off = tuple(states), [], {"open": SwitchState()}
    if np.isfinite(until):
        states, times = {**states, **off}, [TimedChange(until, "open", acting, "is released")]
    if engaged > 0:
        engages = "locked" if np.isinf(static) else "stuck"
        states, times = {**off, **states}, [TimedChange(engaged, engages, ("open",), "engages"), *times]
    if engaged > 0 or np.isinf(static):
        return Switch(name, states, times, unit)
    limits = [(0.0, "backward"), (np.nextafter(0, 1), "stuck"), (np.inf, "forward")]
    return StartSwitch(name, states, row, limits, 1, times, unit)


def releasable(
    name: str,
    rows: Sequence[Constraint],
    branches: Sequence[ForceBranch],
    at: float | None,
    guards: Sequence[Guard],
    unit: str,
) -> Switch:
    """Rows and forces that act until a time or until a guard falls to zero."""
    times = [] if at is None else [TimedChange(at, "released", ("attached",), "is released")]
    states = {"attached": SwitchState(tuple(rows), tuple(branches), tuple(guards)), "released": SwitchState()}
    return Switch(name, states, times, unit)


def latch(
    name: str,
    row: np.ndarray,
    unit: str,
    distance: float | None,
    at: float | None,
) -> Switch:
    """Two bodies that are joined for good once a x has reached a distance, or from a time on."""
    none = np.zeros(len(row))
    position = distance is not None and at is None
    level: Level = "position" if position else "velocity"
    joined = Constraint(row, level=level, value=distance if position else 0.0, names=name, unit=unit)
    closed = SwitchState(rows=(joined,))
    if not position:
        times = [TimedChange(at, "closed", ("open",), "closes")] if at is not None else []
        return Switch(name, {"open": SwitchState(), "closed": closed}, times, unit)
    above = Guard("closed", row, none, distance, text="closes")
    below = Guard("closed", -row, none, -distance, text="closes")
    states = {"open above": SwitchState(guards=(above,)), "open below": SwitchState(guards=(below,)), "closed": closed}
    return StartSwitch(name, states, row, [(distance, "open below"), (np.inf, "open above")], unit=unit)


# Transitions between phases that are given as whole systems.


@answering
@dataclass(frozen=True)
class Transition(Public):
    """The end of a phase of a ``SwitchedSystem`` and the one that follows.

    It takes place at a time, or where a linear combination of displacements, velocities or multipliers rises above or falls below a
    limit. With a restitution e > 0 the velocity of the combination is reversed, -e times that before, and the phase goes on; it ends
    where the velocity after an impact is nothing.

    Args:
        source, target: names of the phases before and after.
        when: factors by the names of coordinates, or of constraint rows of the source for multipliers.
        above, below: the limit in SI; one of both.
        at: a time in s, in place of ``when``.
        quantity: "displacement", "velocity" or "reaction" of ``when``; by default reactions where the names are those of rows.
        restitution: e of an impact, 0 ... 1.
        dwell: so long the limit must be exceeded, in s.

    Raises:
        InputError: no condition or several, a restitution outside 0 ... 1.

    >>> Transition("open", "closed", when={"x1": 1.0}, above=0.02)
    Transition(source='open', target='closed', when={'x1': 1.0}, above=0.02, below=None, at=None, quantity=None, restitution=0.0, dwell=0.0)
    """

    source: str
    target: str
    when: Mapping[str, float] | None = None
    above: float | None = None
    below: float | None = None
    at: float | None = None
    quantity: Output | None = None
    restitution: float = 0.0
    dwell: float = 0.0

    SIDES: ClassVar = ("above", "below")
    _label: str = field(default="", init=False, repr=False, compare=False)

    def __post_init__(self):
        label = f'transition from "{self.source}" to "{self.target}"'
        object.__setattr__(self, "_label", label)
        sides = [side for side in self.SIDES if getattr(self, side) is not None]
        if (self.when is None) == (self.at is None) or len(sides) != (self.when is not None):
            raise InputError(f"{label}: expected when={{...}} with above= or below=, or a time at=")
        for name in (*sides, *(["at"] if self.at is not None else [])):
            object.__setattr__(self, name, real_number(getattr(self, name), f"{label}: {name}"))
        if self.at is not None and self.at <= 0:
            raise InputError(f"{label}: found at = {self.at:g} s; expected a time after 0")
        object.__setattr__(self, "restitution", checked_restitution(self.restitution, label))
        object.__setattr__(self, "dwell", real_number(self.dwell, f"{label}: dwell", minimum=0.0))
        if self.source == self.target and not self.restitution:
            raise InputError(f"{label}: expected two different phases")

    def guard(self, system) -> Guard:
        """The guard for the phase that it ends."""
        rows, names = [row.name for row in system.rows], list(system.names)
        given = dict(self.when or {})
        if not given:
            raise InputError(f'{self._label}: when: expected factors by name, such as {{"{names[0]}": 1.0}}')
        own = [name for name in given if name in rows and name not in names]
        quantity = self.quantity or ("reaction" if len(own) == len(given) else "displacement")
        known = rows if quantity == "reaction" else names
        for name in given:
            if name not in known:
                what = "constraint row" if quantity == "reaction" else "coordinate"
                raise InputError(f'{self._label}: when: the phase "{self.source}" has no {what} "{name}"{nearest(name, known)}')
        sign = -1.0 if self.above is not None else 1.0
        value = sign * (self.above if self.above is not None else self.below)
        factors = {name: sign * real_number(factor, f"{self._label}: factor of {name}") for name, factor in given.items()}
        none, row = np.zeros(system.size), np.array([factors.get(name, 0.0) for name in names])
        text = f"to {self.target}"
        if quantity == "reaction":
            return Guard(self.target, none, none, value, factors, dwell=self.dwell, text=text)
        if quantity == "velocity":
            return Guard(self.target, none, row, value, dwell=self.dwell, text=text)
        if quantity != "displacement":
            raise InputError(f'{self._label}: quantity: found {quantity!r}; expected "displacement", "velocity" or "reaction"')
        return Guard(self.target, row, none, value, restitution=self.restitution or None, dwell=self.dwell, text=text)


def checked_restitution(value, label: str) -> float:
    """A coefficient of restitution, or an InputError."""
    number = real_number(value, f"{label}: restitution")
    if not 0 <= number <= 1:
        raise InputError(f"{label}: restitution: found {number:g}; expected a number from 0 (no rebound) to 1 (no loss)")
    return number
