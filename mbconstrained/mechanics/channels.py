"""Inputs and outputs of a mechanical system by name.

An input is a force on a coordinate or along a direction that has a name of its own, or the motion that a constraint row prescribes. An
output is a quantity that is linear in the motion, with one grammar of names for all analyses:

    constant + rows[0] x + rows[1] x' + rows[2] x'' + reactions lambda
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from ..ground.checks import nearest
from ..ground.errors import InputError
from ..ground.units import GROUND, derivative_name, force_unit, rate_unit
from .constraints import ConstraintRow
from .element_matrix import ElementMatrix
from .equations import ElementForce, EquationsOfMotion, Side

if TYPE_CHECKING:
    from ..signals.bohl import BohlFunction

#: Number of names listed in a message.
LISTED = 8


class Channel(NamedTuple):
    """A linear combination of coordinates; or a constraint row."""

    name: str  # its name
    direction: np.ndarray  # the combination a of a x, shape (n,); of a constraint row its coefficients
    unit: str  # unit of a x, "m", "rad" or "1"
    row: int | None = None  # the place of the constraint row; None of other channels

    def unknowns(self, system: EquationsOfMotion) -> np.ndarray:
        """Position among the coordinates and the multipliers of all rows, as a unit vector or direction, shape (n + k,)."""
        if self.row is None:
            return np.concatenate([self.direction, np.zeros(len(system.rows))])
        return np.eye(1, system.size + len(system.rows), system.size + self.row)[0]


Known = TypeVar("Known")


def reference(system: EquationsOfMotion, name: str) -> Channel:
    """The motion relative to which others are given."""
    known = {GROUND: Channel(GROUND, np.zeros(system.size), "m")} | channels(system, "outputs")
    return chosen_by_name("relative_to", name, known, ())[0]


def channels(system: EquationsOfMotion, side: Side) -> dict[str, Channel | None]:
    """All channels by name: coordinates, constraint rows, and the named inputs or outputs of the system."""
    own = system.named_directions(side)
    known: dict[str, Channel | None] = {channel.name: channel for channel in coordinate_channels(system)}
    known |= {name: Channel(name, direction, unit) for name, (direction, unit) in own.items()}
    for channel in row_channels(system):
        known[channel.name] = None if channel.name in known else channel
    return known


def coordinate_channels(system: EquationsOfMotion) -> list[Channel]:
    return [Channel(name, row, unit) for (name, unit), row in zip(system.units.items(), np.eye(system.size))]


def row_channels(system: EquationsOfMotion) -> list[Channel]:
    return [Channel(row.name, row.coefficients, row.unit, place) for place, row in enumerate(system.rows)]


def support_of(channel: Channel, rows: Iterable[Channel]) -> Channel:
    """The first of some constraint rows that is on the motion of a channel, by the name of the channel; the channel itself where none is."""
    if channel.row is not None:
        return channel
    return next((row._replace(name=channel.name) for row in rows if (row.direction == channel.direction).all()), channel)


def names_given(what: str, chosen, known: Sequence[str]) -> list[str]:
    """A name or a list of distinct names that a user gives."""
    names = [chosen] if isinstance(chosen, str) else list(chosen) if isinstance(chosen, (Sequence, np.ndarray)) else None
    if names is None:
        raise InputError(f"{what}: found {chosen!r}; expected a list of names, such as {_listed(known)}")
    if not names:
        raise InputError(f"{what}: none was named; known are, among others, {_listed(known)}")
    if len(set(map(str, names))) < len(names):
        raise InputError(f'{what}: the name "{next(name for name in names if names.count(name) > 1)}" is used twice')
    return [str(name) for name in names]


def _listed(known: Sequence[str]) -> str:
    return ", ".join(f'"{name}"' for name in known[-LISTED:])


def chosen_by_name(what: str, chosen, known: Mapping[str, Known | None], default: Sequence[Known]) -> list[Known]:
    """Entries that a user selects by name."""
    if chosen is None:
        return list(default)
    result = []
    for name in names_given(what, chosen, list(known)):
        if name not in known:
            raise InputError(f'{what}: there is no "{name}"{nearest(name, known)}; known are, among others, {_listed(list(known))}')
        one = known[name]
        if one is None:
            raise InputError(f'{what}: the name "{name}" is that of a coordinate and of a constraint row; rename one of them')
        result.append(one)
    return result


# Outputs.

#: The words before "of" in the name of an output, with the order of the derivative of motions.
MOTIONS = {
    "displacement": 0, "velocity": 1, "acceleration": 2, "angle": 0, "angular velocity": 1, "angular acceleration": 2
}  # fmt: skip
#: Of these words those of rotations alone.
ANGLES = ("angle", "angular velocity", "angular acceleration")
FORCES, ELONGATIONS = ("force", "torque", "moment"), {"elongation": 0, "rate": 1, "elongation rate": 1}
REACTION = "reaction"
KINDS = (*MOTIONS, *FORCES, *ELONGATIONS, REACTION)

#: The sum of what elements and constraint rows pass to the fixed body, by the unit of the coordinates that are summed.
ON_GROUND = {"m": "force on ground", "rad": "torque on ground"}

FORMS = (
    '"velocity of x" or "acceleration of x" of a coordinate, "b - a" or "velocity of b - a" for the motion of b relative to a, "force of", '
    '"elongation of" or "rate of" a spring or damper, "reaction of" a constraint row, "force on ground"'
)


@dataclass(frozen=True, eq=False)
class Output:
    """A quantity constant + sum over i of rows[i] x^(i) + sum of reactions lambda, in SI."""

    name: str
    quantity: str  # such as "velocity", "torque" or "reaction"
    unit: str
    rows: np.ndarray  # of x, x' and x'', shape (3, n)
    reactions: Mapping[str, float]  # factors of the reactions of constraint rows, by name
    constant: float = 0.0
    elements: Mapping[str, float] = field(default_factory=dict)  # factors of the springs whose force it has, for structural damping
    balance: np.ndarray | None = None  # w of w^T (K x + C x' - A^T lambda), to which further damping adds; None of others

    def scaled(self, factor: float, name: str | None = None, unit: str | None = None, quantity: str | None = None) -> Output:
        """The quantity times a factor, such as the inverse of an area."""
        return replace(
            self,
            name=name or self.name,
            quantity=quantity or self.quantity,
            unit=unit or self.unit,
            rows=factor * self.rows,
            reactions={name: factor * own for name, own in self.reactions.items()},
            constant=factor * self.constant,
            elements={element: factor * own for element, own in self.elements.items()},
            balance=None if self.balance is None else factor * self.balance,
        )

    def relative(self, other: Channel) -> Output:
        """A motion minus that of another point, where both have one unit; other quantities as they are."""
        orders = [order for order in range(3) if self.rows[order].any()]
        if self.quantity not in MOTIONS or len(orders) != 1 or self.unit != rate_unit(other.unit, orders[0]):
            return self
        rows = self.rows.copy()
        rows[orders[0]] -= other.direction
        return replace(self, rows=rows)

    @property
    def is_zero(self) -> bool:
        """Whether it is zero whatever moves, as the motion of a point relative to itself."""
        return not (self.rows.any() or self.reactions)

    @property
    def order(self) -> int | None:
        """The order of derivative of a plain motion, 0 of plain reactions; None of sums of several and of forces of elements."""
        parts = [order for order in range(3) if self.rows[order].any()]
        parts += [0] * bool(self.reactions)
        return None if self.elements or self.balance is not None or len(parts) > 1 else parts[0] if parts else 0

    def multipliers(self, rows: Sequence[ConstraintRow]) -> np.ndarray:
        """The factors of the reactions of these rows, shape (k,); of others, such as those of open contacts, there is none."""
        return np.array([self.reactions.get(row.name, 0.0) for row in rows])

    def values(self, motion, times: np.ndarray) -> np.ndarray:
        """Over times (T,), of a motion."""
        orders = [order for order, row in enumerate(self.rows) if row.any()]
        parts = [self.rows[order] @ (motion.derivative(order)(times) if order else motion(times)) for order in orders]
        parts += [self.multipliers(motion._reaction_rows) @ motion.reaction(times)] if self.reactions else []
        return self.constant + sum(parts, np.zeros(np.shape(times)))


def closed_form(outputs: Sequence[Output], motion) -> BohlFunction:
    """The functions of time of outputs without their constants."""
    rows = np.array([one.rows for one in outputs]).transpose(1, 0, 2)
    function = motion.function.differential(*rows)
    if not any(one.reactions for one in outputs):
        return function
    return function + motion.reaction_function.mapped(np.array([one.multipliers(motion._reaction_rows) for one in outputs]))


class OutputNames:
    """The names of outputs that are listed in messages, and the grammar of all others."""

    def __init__(
        self,
        units: Mapping[str, str],
        system: EquationsOfMotion | None = None,
        rows: Sequence[ConstraintRow] | None = None,
        has_common_equations: bool = True,
    ):
        """Coordinates with their units; elements, named directions and quantities are those of a system, rows too or those of all phases."""
        self.has_common_equations = has_common_equations
        self.system, self.units, self.directions = system, units, dict(units)  # units of coordinates, and of named directions too
        self.elements: Mapping[str, ElementForce] = {}
        self.rows: dict[str, ConstraintRow] = {}
        self.own: Mapping[str, Output] = {}
        if system is not None:
            self.directions |= {name: unit for name, (_, unit) in system.named_directions("outputs").items()}
            self.elements, self.own = system.elements, system.quantities
            given = rows if rows is not None else () if system.is_sparse else system.rows
            self.rows = {row.name: row for row in given}

    @classmethod
    def of(cls, system: EquationsOfMotion) -> OutputNames:
        """The names of a system."""
        return cls(system.units, system)

    @classmethod
    def of_motion(cls, motion) -> OutputNames:
        """The names of a motion, whose rows are those of all its phases."""
        return cls(motion.system.units, motion.system, motion._reaction_rows, motion._has_common_equations)

    @property
    def without_own(self) -> OutputNames:
        """The names without those of further quantities."""
        names = copy(self)
        names.own = {}
        return names

    def __iter__(self):
        return iter(dict.fromkeys((*self.directions, *self.rows, *self.elements, *self.own)))

    def chosen(self, what: str, names, kind: str, default: Sequence[str]) -> list[Output]:
        """The outputs that a user names; plain names are of the kind."""
        texts = default if names is None else names_given(what, names, list(self))
        return [self.output(text, kind, what) for text in texts]

    def output(self, text: str, kind: str = "displacement", what: str = "outputs") -> Output:
        """The output of this name."""
        if (one := self._of_name(text, kind, what)) is not None:
            return one
        word, of, rest = text.partition(" of ")
        if of and word in KINDS and (one := self._of_kind(word, rest, text, what)) is not None:
            return one
        if (direction := self._difference(text)) is not None:
            return self._motion(text, kind if kind in MOTIONS else "displacement", *direction, is_relative=True)
        for unit, name in ON_GROUND.items():
            if text == name:
                return self._on_ground(text, unit, what)
        known = list(self)
        if of and word in KINDS and rest in known:
            raise InputError(f'{what}: "{rest}" has no {word}: it is {self._nature(rest)}')
        forms = [f"{one} of {name}" for one, names in self.kinds.items() for name in names] if of else []
        hint = nearest(text, [*known, *forms, *ON_GROUND.values()])
        others = hint or f"; known are, among others, {_listed(known)}; or {FORMS}"
        raise InputError(f'{what}: there is no "{text}"{others}')

    def _nature(self, name: str) -> str:
        if name in self.own:
            return "a quantity of its own; name it alone"
        if name in self.directions:
            unit = self.directions[name]
            return f"a coordinate in {unit} with {', '.join(derivative_name(unit, order) for order in range(3))}"
        if name in self.elements:
            return f"a spring or damper with {'force' if self.elements[name].unit == 'm' else 'torque'}, elongation and rate"
        return "a constraint row with reaction"

    @property
    def kinds(self) -> dict[str, Sequence[str]]:
        """The names that each kind of quantity has."""
        moving, elements, rows = list(self.directions), list(self.elements), list(self.rows)
        groups = ((MOTIONS, moving), (FORCES, [*elements, *rows]), (ELONGATIONS, elements), ((REACTION,), rows))
        return {kind: known for kinds, known in groups for kind in kinds}

    def _of_name(self, name: str, kind: str, what: str) -> Output | None:
        """A name alone: of a quantity, a coordinate with its motion, an element with its force, a row with its reaction."""
        if name in self.own and name not in self.elements:
            return self.own[name]
        if name in self.elements and (kind in (*FORCES, *ELONGATIONS) or name not in self.directions):
            return self._of_element(name, name, kind if kind in ELONGATIONS else "force")
        if name in self.rows and (kind not in MOTIONS or name not in self.directions):
            return self._reaction(name, name)
        if name not in self.directions:
            return None
        if kind not in MOTIONS:
            expected = "constraint rows" if kind == REACTION else "springs, dampers or constraint rows"
            raise InputError(f'{what}: "{name}" is a coordinate and has no {kind}; expected {expected}, or "velocity of {name}" …')
        return self._motion(name, kind, self._direction(name), self.directions[name])

    def _of_kind(self, word: str, rest: str, text: str, what: str) -> Output | None:
        """A quantity with its kind; None where there is none of this kind, as of a torque along a line."""
        if word in MOTIONS:
            one = (self._direction(rest), self.directions[rest]) if rest in self.directions else self._difference(rest)
            if one is None or (word in ANGLES and one[1] != "rad"):
                return None
            return self._motion(text, word, *one, is_relative=rest not in self.directions)
        parts: Mapping[str, Any] = self.elements if rest in self.elements else self.rows
        if rest not in parts or (word in FORCES[1:] and parts[rest].unit != "rad"):
            return None
        if rest in self.elements and word != REACTION:
            return self._of_element(text, rest, word)
        return self._reaction(text, rest) if word in (*FORCES, REACTION) and rest in self.rows else None

    def _difference(self, text: str) -> tuple[np.ndarray, str] | None:
        """The direction of "b - a", or of "b relative to a"; None of other texts."""
        known = {**self.directions, GROUND: ""}
        for sign in (" relative to ", "-"):
            parts = text.split(sign)
            for place in range(1, len(parts)):
                b, a = sign.join(parts[:place]).strip(), sign.join(parts[place:]).strip()
                if b in known and a in known and b != a:
                    unit, other = known[b], known[a]
                    if unit and other and unit != other:
                        raise InputError(f'"{text}": {b} is in {unit} and {a} in {other}; expected two coordinates of one unit')
                    return self._direction(b) - self._direction(a), unit or other
        return None

    def _direction(self, name: str) -> np.ndarray:
        """The combination of coordinates; zero of the ground."""
        if self.system is not None and name in (named := self.system.named_directions("outputs")):
            return named[name][0]
        row = np.zeros(len(self.units))
        if name != GROUND:
            row[self._places[name]] = 1.0
        return row

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.units)}

    def _motion(self, text: str, kind: str, direction: np.ndarray, unit: str, is_relative: bool = False) -> Output:
        order, rows = MOTIONS[kind], np.zeros((3, len(direction)))
        rows[order] = direction
        quantity = f"relative {kind}" if is_relative else derivative_name(unit, order)
        return Output(text, quantity, rate_unit(unit, order), rows, {})

    def _of_element(self, text: str, name: str, kind: str) -> Output:
        one = self.elements[name]
        rows = np.zeros((3, len(one.elongation)))
        if kind in ELONGATIONS:
            order = ELONGATIONS[kind]
            rows[order] = one.elongation
            quantity, constant = ("elongation rate", 0.0) if order else ("elongation", one.rest)
            return Output(text, quantity, rate_unit(one.unit, order), rows, {}, constant)
        rows[0], rows[1] = one.stiffness * one.elongation, one.damping * one.elongation
        quantity = "force" if one.unit == "m" else "torque"
        return Output(text, quantity, force_unit(one.unit), rows, {}, one.stiffness * one.rest, {name: 1.0})

    def _reaction(self, text: str, name: str) -> Output:
        row = self.rows[name]
        return Output(text, REACTION, force_unit(row.unit), np.zeros((3, len(row.coefficients))), {name: 1.0})

    def _on_ground(self, text: str, unit: str, what: str) -> Output:
        """w^T (K x + C x' - A^T lambda), w of ones at the coordinates in the direction of the ground's force."""
        if self.system is None or self.system.is_sparse:
            raise InputError(
                f"{what}: {text} is available for models with mass, damping and stiffness as arrays; name springs instead"
            )
        if not self.has_common_equations:
            raise InputError(f"{what}: {text} is not available for phases with equations of their own; name springs instead")
        w = self.system.ground_direction(unit, f"{what}: {text}")
        rows = np.zeros((3, len(w)))
        stiffness, damping, _ = self.system.given
        rows[0], rows[1] = along(w, stiffness, self.system.stiffness), along(w, damping, self.system.damping)
        reactions = {name: -float(size) for name, row in self.rows.items() if (size := row.coefficients @ w)}
        constant = sum(one.stiffness * one.rest * float(one.elongation @ w) for one in self.elements.values())
        return Output(text, text.partition(" ")[0], force_unit(unit), rows, reactions, constant, balance=w)


def along(direction: np.ndarray, given, matrix: np.ndarray) -> np.ndarray:
    """w^T K, by elements where they are known: those between bodies cancel exactly."""
    if not isinstance(given, ElementMatrix):
        return direction @ matrix
    return (given.constants * (given.directions @ direction)) @ given.directions
