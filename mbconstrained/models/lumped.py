"""A model of bodies along one axis (or shafts that turn), put together element by element."""

from __future__ import annotations

from collections.abc import Mapping

from ..checks import nearest, real_number
from ..errors import InputError
from ..mechanics.constraint import Level
from ..mechanics.system import MechanicalSystem
from ..signals.inputs import ImpulsiveSmooth
from .assembly import assembled
from .elements import (
    GROUND,
    Body,
    Damper,
    Element,
    Gear,
    Inertia,
    Lever,
    Mass,
    Node,
    Pulley,
    Rack,
    Relation,
    RigidTie,
    Spring,
    TorsionDamper,
    TorsionSpring,
)
from .incidence import Incidence, incidence_of

STATES = {"m": "moves along the axis (m)", "rad": "turns (rad)"}


class LumpedModel:
    """Masses, inertias and massless nodes; springs and dampers between them; rigid ties, levers, gears, ropes.

    Each body has one coordinate, named as the body: its absolute position along one axis in m (a displacement
    where no rest lengths are given), or its angle in rad. "ground" is the body that stays at 0. What joins bodies is
    added after them; every method returns the element that it added.

    >>> model = LumpedModel()
    >>> _ = model.mass("cart", 10.0)
    >>> _ = model.spring("ground", "cart", stiffness=2.0, rest_length=0.2)
    >>> model.assemble().stiffness.tolist()
    [[2.0]]
    """

    def __init__(self):
        self._elements: dict[str, Element] = {}
        self._forces: dict[str, ImpulsiveSmooth] = {}
        self._gravity = 0.0

    @property
    def elements(self) -> tuple[Element, ...]:
        """All elements in the order of creation."""
        return tuple(self._elements.values())

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the bodies in the order of creation."""
        return tuple(self.units)

    @property
    def units(self) -> dict[str, str]:
        """The unit of every coordinate, "m" or "rad"."""
        return {element.name: element.unit for element in self.elements if isinstance(element, Body)}

    def mass(self, name: str, mass: float, position: float | None = None) -> Mass:
        """A body of this mass (kg) that moves along the axis; position (m) is for the drawing only."""
        return self._add(Mass(self._new(name, "mass"), mass, position))

    def inertia(self, name: str, inertia: float) -> Inertia:
        """A body of this moment of inertia (kg m^2) that turns."""
        return self._add(Inertia(self._new(name, "inertia"), inertia))

    def node(self, name: str, rotational: bool = False) -> Node:
        """A joint without mass."""
        return self._add(Node(self._new(name, "node"), bool(rotational)))

    def spring(self, start: str, end: str, stiffness: float, rest_length: float = 0.0, name: str | None = None) -> Spring:
        """A spring of this stiffness (N/m), without force at x_end - x_start = rest_length (m)."""
        return self._add(Spring(self._named("spring", name, start, end), start, end, stiffness, rest_length))

    def damper(self, start: str, end: str, damping: float, name: str | None = None) -> Damper:
        """A viscous damper (N s/m)."""
        return self._add(Damper(self._named("damper", name, start, end), start, end, damping))

    def torsion_spring(
        self, start: str, end: str, stiffness: float, rest_angle: float = 0.0, name: str | None = None
    ) -> TorsionSpring:
        """A torsion spring (N m/rad), without torque at q_end - q_start = rest_angle (rad)."""
        return self._add(TorsionSpring(self._named("torsion spring", name, start, end), start, end, stiffness, rest_angle))

    def torsion_damper(self, start: str, end: str, damping: float, name: str | None = None) -> TorsionDamper:
        """A viscous torsion damper (N m s/rad)."""
        return self._add(TorsionDamper(self._named("torsion damper", name, start, end), start, end, damping))

    def rigid_tie(self, start: str, end: str, distance: float = 0.0, name: str | None = None) -> RigidTie:
        """A rigid link: x_end - x_start = distance (m, or rad between bodies that turn)."""
        return self._add(RigidTie(self._named("rigid tie", name, start, end), start, end, distance))

    def lever(self, start: str, end: str, start_arm: float, end_arm: float, name: str | None = None) -> Lever:
        """A massless lever on a fixed pivot, arms on opposite sides (m): x_start / start_arm + x_end / end_arm = 0."""
        return self._add(Lever(self._named("lever", name, start, end), start, end, start_arm, end_arm))

    def gear(
        self, start: str, end: str, start_radius: float, end_radius: float, internal: bool = False, name: str | None = None
    ) -> Gear:
        """Two wheels in mesh, by radii or numbers of teeth: start_radius q_start + end_radius q_end = 0 (minus: internal)."""
        name = self._named("gear", name, start, end)
        return self._add(Gear(name, start, end, start_radius, end_radius, bool(internal)))

    def rack(self, gear: str, rack: str, radius: float, name: str | None = None) -> Rack:
        """A pinion of this radius (m) and its rack: x_rack = radius q_gear."""
        return self._add(Rack(self._named("rack", name, gear, rack), gear, rack, radius))

    def pulley(
        self, start: str, end: str, over: str = GROUND, length: float | None = None, name: str | None = None
    ) -> Pulley:
        """A rope over a pulley carried by a body: x_start + x_end - 2 x_over = -length (m), positions upwards, see ``Pulley``."""
        return self._add(Pulley(self._named("pulley", name, start, end), start, end, over, length))

    def constrain(
        self, coefficients: Mapping[str, float], value: float = 0.0, level: Level = "position", name: str | None = None
    ) -> Relation:
        """Any other constraint row: the sum of factor times coordinate, or of its derivatives, equals the value."""
        return self._add(Relation(self._named("constraint", name), coefficients, value, level))

    def gravity(self, acceleration: float) -> None:
        """A force m g along the axis on every mass; negative where the axis points upwards (m/s^2)."""
        self._gravity = real_number(acceleration, "gravity")

    def force(self, name: str, signal: ImpulsiveSmooth) -> None:
        """A force (N) or torque (N m) on a body from t = 0 on, in addition to those given before; a signal with one row."""
        self._check_body("force", name)
        if name == GROUND:
            raise InputError('force: found "ground", which does not move; name a body')
        if not isinstance(signal, ImpulsiveSmooth) or signal.size != 1:
            raise InputError(f"force on {name}: expected a signal with one row, such as mb.step([1.0])")
        self._forces[name] = self._forces[name] + signal if name in self._forces else signal

    def incidence(self) -> Incidence:
        """The factors K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m)."""
        return incidence_of(self.elements)

    def assemble(self) -> MechanicalSystem:
        """The system of all elements: rest lengths and weights are its static force, ties its constraint rows.

        Raises:
            InputError: the model has no body.
            ContradictoryConstraints: ties that ask for different values.
        """
        return assembled(self.elements, self._gravity, self._forces)

    def _new(self, name, kind: str) -> str:
        if not isinstance(name, str) or not name.strip():
            raise InputError(f"{kind}: found the name {name!r}; expected a text")
        if name == GROUND:
            raise InputError(f'{kind}: the name "ground" is that of the body that stays at 0; choose another')
        if name in self._elements:
            raise InputError(f'{kind}: the name "{name}" is already in use ({self._elements[name].kind}); names must differ')
        return name

    def _named(self, kind: str, name, *ends: str) -> str:
        """The name given, or one made from the kind and the ends."""
        if name is not None:
            return self._new(name, kind)
        plain = f"{kind} {'-'.join(map(str, ends))}" if ends else f"{kind} {1 + self._count(Relation)}"
        names = (plain, *(f"{plain} {number}" for number in range(2, len(self._elements) + 2)))
        return next(candidate for candidate in names if candidate not in self._elements)

    def _count(self, kind: type) -> int:
        return sum(isinstance(element, kind) for element in self.elements)

    def _add(self, element):
        for name, unit in element.ends.items():
            self._check_body(element.label, name)
            if unit and name != GROUND and self.units[name] != unit:
                raise InputError(
                    f'{element.label}: "{name}" {STATES[self.units[name]]}, but a {element.kind} needs a body that {STATES[unit]}'
                )
        if len(element.ends) < element.end_count:
            raise InputError(f"{element.label}: two of its ends are on the same body; give different ones")
        if isinstance(element, RigidTie) and len({self.units[name] for name in element.ends if name != GROUND}) > 1:
            raise InputError(f"{element.label}: one end moves along the axis (m), the other turns (rad); use a rack")
        self._elements[element.name] = element
        return element

    def _check_body(self, label: str, name) -> None:
        if name != GROUND and name not in self.units:
            known = (GROUND, *self.coordinates)
            raise InputError(f'{label}: there is no body "{name}"{nearest(name, known)}; bodies are added before what joins them')
