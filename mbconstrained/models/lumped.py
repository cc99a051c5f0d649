"""A model of bodies along one axis, or of shafts, assembled element by element."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from typing import Concatenate, ParamSpec, TypeVar

import numpy as np

from ..ground.checks import OF_FUNCTION, counted, nearest, real_number
from ..ground.coordinate_units import GROUND
from ..ground.display import Displayed, TextTable
from ..ground.errors import InputError
from ..mechanics.constraints import Constraint
from ..mechanics.element_matrix import ElementMatrix
from ..mechanics.energy import EnergyParts
from ..mechanics.equations import ElementForce
from ..mechanics.system import MechanicalSystem
from ..signals.inputs import ImpulsiveSmooth, zero
from .element_parameters import element_parameters
from .elements import (
    Body,
    Damper,
    Element,
    Gear,
    Inertia,
    Lever,
    Link,
    Mass,
    Node,
    PrescribedMotion,
    Pulley,
    Rack,
    Relation,
    RigidTie,
    Spring,
    Tie,
    TorsionDamper,
    TorsionSpring,
)
from .rigid_bar import RigidBar, with_parts
from .rotor import Bearing, Rotor, Unbalance, rotor_terms

STATES = {"m": "moves along the axis (m)", "rad": "turns (rad)"}


Fields = ParamSpec("Fields")
Added = TypeVar("Added", bound=Element)


def _adds(kind: Callable[Fields, Added]) -> Callable[Concatenate[LumpedModel, Fields], Added]:
    """The method of a model that adds an element of a class, with the arguments and the description of the class."""

    def add(self, *args, **kwargs):
        return self._add(kind(*args, **kwargs))

    parameters = inspect.signature(kind).parameters.values()
    own = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    add.__doc__, add.__dict__["__signature__"] = kind.__doc__, inspect.Signature([own, *parameters])
    return add


class LumpedModel(Displayed):
    """Masses, inertias, rigid bars and massless nodes; springs and dampers between them; rigid ties, levers, gears, ropes; rotors.

    Each body has one coordinate, named as the body: its absolute position along one axis in m (a displacement
    where no rest lengths are given), or its angle in rad; a rigid bar has one of each, and one for each of its points; a rotor is a bar in
    two planes (``Rotor``). "ground" is the fixed body. Elements between bodies are
    added after them; every method takes the arguments of the element's class and returns the element. It raises an
    ``InputError`` for a name in use, an unknown body, one that moves where it should turn, a number out of range.

    >>> model = LumpedModel()
    >>> _ = model.mass("cart", 10.0)
    >>> _ = model.spring("ground", "cart", stiffness=2.0, rest_length=0.2)
    >>> model.assemble().stiffness.tolist()
    [[2.0]]
    """

    def __init__(self):
        self._elements: dict[str, Element] = {}
        self._parts: dict[str, Element] = {}
        self._units: dict[str, str] = {}
        self._forces: dict[str, ImpulsiveSmooth] = {}
        self.gravity_along = 0.0  # acceleration along the axis (m/s^2)

    def _summary(self) -> str:
        kinds = [element.kind for element in self.elements]
        return ", ".join(
            counted(kinds.count(kind), *([kind] if kind != "inertia" else [kind, "inertias"])) for kind in dict.fromkeys(kinds)
        )

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((name, element.kind, ", ".join(element.ends)) for name, element in self._elements.items())
        return (TextTable("Elements", ("name", "kind", "ends"), tuple(rows)),)

    @property
    def elements(self) -> tuple[Element, ...]:
        """All elements in the order of their creation."""
        return tuple(self._elements.values())

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the bodies in the order of creation."""
        return tuple(self._units)

    @property
    def units(self) -> dict[str, str]:
        """The unit of every coordinate, "m" or "rad"."""
        return dict(self._units)

    mass = _adds(Mass)
    rigid_bar = _adds(RigidBar)
    inertia = _adds(Inertia)
    node = _adds(Node)
    spring = _adds(Spring)
    damper = _adds(Damper)
    torsion_spring = _adds(TorsionSpring)
    torsion_damper = _adds(TorsionDamper)
    rigid_tie = _adds(RigidTie)
    lever = _adds(Lever)
    gear = _adds(Gear)
    rack = _adds(Rack)
    pulley = _adds(Pulley)
    rotor = _adds(Rotor)
    bearing = _adds(Bearing)
    unbalance = _adds(Unbalance)
    constrain = _adds(Relation)
    prescribe = _adds(PrescribedMotion)

    def gravity(self, acceleration: float) -> None:
        """A force m g along the axis on every mass, on a rotor along z; negative where the axis points upwards (m/s^2)."""
        self.gravity_along = real_number(acceleration, "gravity")

    def force(self, name: str, signal: ImpulsiveSmooth) -> None:
        """A force on a body from t = 0 on, in addition to earlier ones.

        Args:
            name: name of the body.
            signal: with one row, in N, or N m on a body that turns; such as ``mb.step([2.0])``.

        Raises:
            InputError: an unknown body or the ground, a signal with several rows.
        """
        self._check_body("force", name)
        if name == GROUND:
            raise InputError('force: found "ground", which does not move; name a body')
        if not isinstance(signal, ImpulsiveSmooth) or signal.size != 1:
            advice = OF_FUNCTION if callable(signal) and not isinstance(signal, ImpulsiveSmooth) else ""
            raise InputError(f"force on {name}: expected a signal with one row, such as mb.step([1.0]){advice}")
        self._forces[name] = self._forces[name] + signal if name in self._forces else signal

    def incidence(self) -> Incidence:
        """The factors K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m)."""
        return incidence_of(self.elements)

    def assemble(self) -> MechanicalSystem:
        """M x'' + C x' + K x = f of all elements: rest lengths and weights are its static force, ties its constraint rows.

        Raises:
            InputError: the model has no body.
            ContradictoryConstraints: ties with contradictory values.
        """
        units, names = self.units, self.coordinates
        if not units:
            raise InputError("the model has no body; add a mass, an inertia or a node")
        factors, ties = self.incidence(), [element for element in with_parts(self.elements) if isinstance(element, Tie)]
        weights = {name: self.gravity_along * mass for element in self.elements for name, mass in element.weighing.items()}
        signals = [signal.mapped(coordinate_row({name: 1.0}, names)[:, None]) for name, signal in self._forces.items()]
        turning = rotor_terms(self.elements, names)
        system = MechanicalSystem(
            mass=ElementMatrix(np.eye(len(names)), factors.masses),
            damping=turning.added_to(factors.dampers.matrix, "damping") if turning else factors.dampers.matrix,
            stiffness=turning.added_to(factors.springs.matrix, "stiffness") if turning else factors.springs.matrix,
            constraints=[
                Constraint(coordinate_row(tie.row, names), level=tie.level, value=tie.row_value, names=tie.name) for tie in ties
            ],
            names=names,
            force=sum(signals, zero(len(names))) if signals else None,
            static_force=factors.springs.rest_force() + coordinate_row(weights, names),
            units=units,
            energy_parts=None if turning and turning.stiffness.any() else _energy_parts(factors, names),
            gyroscopic=turning and turning.gyroscopic,
        )
        if turning:
            system.speed_tables, system.unbalance, system.whirl_matrix = turning.tables, turning.unbalance, turning.whirl
        springs = (element for element in with_parts(self.elements) if isinstance(element, (Spring, TorsionSpring)))
        system.loss_factors = {spring.name: spring.loss_factor for spring in springs if spring.loss_factor}
        system.elements = element_forces(self.elements, names)
        system.origin = copy(self)
        system.origin._elements, system.origin._units = dict(self._elements), units  # what is added later is not in the system
        system.parameter_source = partial(element_parameters, system.origin)
        return system

    def _add(self, element):
        name = element.name
        if not name:
            element = replace(
                element, name=next(free for free in element.default_names if free not in self._elements and free not in self._parts)
            )
        elif not isinstance(name, str) or not name.strip():
            raise InputError(f"{element.kind}: found the name {name!r}; expected a text")
        for one in (element, *element.parts):
            self._check_name(element, one.name)
        for name, unit in element.ends.items():
            self._check_body(element.label, name)
            if unit and name != GROUND and self._units[name] != unit:
                raise InputError(
                    f'{element.label}: "{name}" {STATES[self._units[name]]}, but a {element.kind} needs a body that {STATES[unit]}'
                )
        if len(element.ends) < element.end_count:
            raise InputError(f"{element.label}: two of its ends are on the same body; give different ones")
        if isinstance(element, RigidTie) and len({self._units[name] for name in element.ends if name != GROUND}) > 1:
            raise InputError(f"{element.label}: one end moves along the axis (m), the other turns (rad); use a rack")
        self._elements[element.name] = element
        self._units |= {body.name: body.unit for body in with_parts((element,)) if isinstance(body, Body)}
        self._parts |= {part.name: part for part in element.parts}
        return element

    def _check_name(self, element: Element, name: str) -> None:
        """Raise an InputError where the name of an element, or of a part of it, is in use."""
        own = [part.name for part in element.parts]
        if name == GROUND:
            raise InputError(f'{element.kind}: the name "ground" is that of the fixed body; choose another')
        if (element.name, *own).count(name) > 1:
            raise InputError(f'{element.label}: its name and those of its points must differ; found "{name}" twice')
        known = self._elements.get(name) or self._parts.get(name)
        if known:
            raise InputError(f'{element.kind}: the name "{name}" is already in use ({known.kind}); names must differ')

    def _check_body(self, label: str, name) -> None:
        if name != GROUND and name not in self._units:
            known = (GROUND, *self.coordinates)
            raise InputError(
                f'{label}: there is no body "{name}"{nearest(name, known)}; bodies are added before the elements between them'
            )


# The factors of the matrices of a lumped model: K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m).


@dataclass(frozen=True, eq=False)
class BranchRows:
    """The springs or the dampers of a model with n coordinates, one a row.

    Attributes:
        incidence: B, -1 at the start, 1 at the end, nothing for the ground, shape (p, n).
        constants: stiffness or damping, all positive, shape (p,).
        rest: elongation without force, shape (p,); zero for dampers.
        names: names of the elements.
    """

    incidence: np.ndarray
    constants: np.ndarray
    rest: np.ndarray
    names: tuple[str, ...]

    @property
    def matrix(self) -> ElementMatrix:
        """B^T diag(constants) B, shape (n, n)."""
        return ElementMatrix(self.incidence, self.constants)

    def rest_force(self) -> np.ndarray:
        """B^T diag(constants) rest: the force of the rest lengths at x = 0, shape (n,)."""
        return self.incidence.T @ (self.constants * self.rest)


@dataclass(frozen=True, eq=False)
class Incidence:
    """Incidence matrices and constants of a model.

    Attributes:
        springs, dampers: the branches of K and of C.
        masses: masses and inertias by coordinate, zero for nodes, shape (n,).
    """

    springs: BranchRows
    dampers: BranchRows
    masses: np.ndarray


def incidence_of(elements: Sequence[Element]) -> Incidence:
    """The factors of the bodies, springs and dampers among these elements and their parts."""
    elements = with_parts(elements)
    bodies = [element for element in elements if isinstance(element, Body)]
    names = [body.name for body in bodies]
    springs = [element for element in elements if isinstance(element, (Spring, TorsionSpring))]
    dampers = [element for element in elements if isinstance(element, (Damper, TorsionDamper))]
    return Incidence(_branches(springs, names), _branches(dampers, names), np.array([body.constant for body in bodies]))


def coordinate_row(coefficients: Mapping[str, float], names: Sequence[str]) -> np.ndarray:
    """Coefficients by name as a row."""
    return np.array([coefficients.get(name, 0.0) for name in names])


def element_forces(elements: Sequence[Element], names: Sequence[str]) -> dict[str, ElementForce]:
    """The forces of springs and dampers by name."""
    forces = {}
    for link in elements:
        if isinstance(link, Link):
            row = np.array([(name == link.end) - float(name == link.start) for name in names])
            stiffness, damping = (0.0, link.constant) if isinstance(link, (Damper, TorsionDamper)) else (link.constant, 0.0)
            forces[link.name] = ElementForce(row, -link.rest, stiffness, damping, "rad" if link.turning else "m")
    return forces


def _branches(links: Sequence[Link], names: Sequence[str]) -> BranchRows:
    incidence, column = np.zeros((len(links), len(names))), {name: at for at, name in enumerate(names)}
    for row, link in zip(incidence, links):
        for end, sign in ((link.start, -1.0), (link.end, 1.0)):
            if end in column:
                row[column[end]] = sign
    return BranchRows(
        incidence=incidence,
        constants=np.array([link.constant for link in links]),
        rest=np.array([link.rest for link in links]),
        names=tuple(link.name for link in links),
    )


def _energy_parts(factors: Incidence, names: Sequence[str]) -> EnergyParts:
    """Every mass and spring by name; massless joints have no part."""
    unit_rows, springs = np.eye(len(names)), factors.springs
    masses = {name: ElementMatrix(row[None], [mass]) for name, row, mass in zip(names, unit_rows, factors.masses) if mass}
    by_spring = zip(springs.names, springs.incidence, springs.constants)
    return EnergyParts(masses, {name: ElementMatrix(row[None], [constant]) for name, row, constant in by_spring})
