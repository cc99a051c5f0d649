"""A model of bodies along one axis, or of shafts, assembled element by element, and the constants of its elements as parameters.

Every entry of the equations is a rational function of the numbers of the elements. Its derivative is taken by a complex step,
Im g(p + i h) / h with h = 1e-40 p, which is exact to rounding errors: nothing cancels (Squire and Trapp 1998).
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Concatenate, ParamSpec, TypeVar

import numpy as np
import scipy

from ..ground.by_name import answering, wrong_call
from ..ground.checks import counted, nearest, real_number
from ..ground.display import Displayed, TextTable
from ..ground.errors import InputError, named
from ..ground.quantities import quantity
from ..ground.tolerances import COMPLEX_STEP
from ..ground.units import GROUND
from ..mechanics.constraints import Constraint
from ..mechanics.element_matrix import ElementMatrix
from ..mechanics.energy import EnergyParts
from ..mechanics.equations import ElementForce
from ..mechanics.parameter import Parameter
from ..mechanics.system import MechanicalSystem
from ..signals.inputs import ImpulsiveSmooth, named_rows, zero
from . import elements as catalogue
from . import switching
from .elements import (
    Body,
    DelayedFeedback,
    Element,
    Link,
    Numeric,
    PrescribedMotion,
    RigidTie,
    Tie,
    fields_of,
    with_parts,
)
from .rotor import Bearing, Rotor, Unbalance, rotor_terms
from .switching import Release, SwitchingElement

if TYPE_CHECKING:
    from ..mechanics.switched.switched_system import SwitchedSystem
    from ..mechanics.switched.switches import Switch

STATES = {"m": "moves along the axis (m)", "rad": "turns (rad)"}


Fields = ParamSpec("Fields")
Added = TypeVar("Added", bound=Element)


def _adds(kind: Callable[Fields, Added]) -> Callable[Concatenate[LumpedModel, Fields], Added]:
    """The method of a model that adds an element of a class, with the arguments and the description of the class."""

    def add(self, *args, **kwargs):
        try:
            element = kind(*args, **kwargs)
        except TypeError as problem:
            if problem.__traceback__.tb_next is not None:  # from within the class
                raise
            raise wrong_call(kind, args, kwargs, kind.kind) from None
        return self._add(element)

    entries = fields_of(kind).entries  # type: ignore[arg-type]
    parameters, lines = [], []
    for parameter in inspect.signature(kind).parameters.values():
        about = entries[parameter.name].about
        unit = f", in {about.unit}" if isinstance(about, Numeric) and about.unit not in (None, "1") else ""
        lines.append(f"    {parameter.name}: {getattr(about, 'text', about).removesuffix('.')}{unit}.")
        parameters.append(parameter.replace(annotation=float | str if entries[parameter.name].is_number else parameter.empty))
    text, example, further = inspect.cleandoc(kind.__doc__).partition("\n\nExample:")
    add.__doc__ = "\n".join([f"{text}\n\nArgs:", *lines]) + example + further
    own = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    add.__dict__ |= {"__signature__": inspect.Signature([own, *parameters]), "kind": kind}
    return add


class LumpedModel(Displayed):
    """Masses, inertias, rigid bars and massless nodes; springs and dampers between them; rigid ties, levers, gears, ropes; rotors.

    Each body has one coordinate, named as the body: its absolute position along one axis in m (a displacement
    where no rest lengths are given), or its angle in rad; a rigid bar has one of each, and one for each of its points; a rotor is a bar in
    two planes (``Rotor``). "ground" is the fixed body. Elements between bodies are
    added after them; every method takes the arguments of the element's class, numbers in SI or texts with a unit such as "3 N/mm",
    and returns the element. It raises an ``InputError`` for a name in use, an unknown body, one that moves where it should turn,
    a number out of range, a wrong unit.

    >>> model = LumpedModel()
    >>> _ = model.mass("cart", "10 kg")
    >>> _ = model.spring("ground", "cart", stiffness="3 N/mm", rest_length=0.2)
    >>> model.assemble().stiffness.tolist()
    [[3000.0]]
    """

    _instead: ClassVar = {
        "add_constraint": "constrain",
        **{f"add_{name}": name for name in ("mass", "spring", "damper", "force")},
        "build": "assemble",
        "frequency_response": "assemble().frequency_response",
        **dict.fromkeys(("fix", "ground"), 'fixed are springs and constraints to "ground", a body that exists in every model'),
        "modes": "assemble().modes",
        "shaft": "torsion_spring",
        "solve": "assemble().solve",
        "system": "assemble()",
    }

    @answering
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

    mass = _adds(catalogue.Mass)
    inertia = _adds(catalogue.Inertia)
    node = _adds(catalogue.Node)
    rigid_bar = _adds(catalogue.RigidBar)
    spring = _adds(catalogue.Spring)
    damper = _adds(catalogue.Damper)
    torsion_spring = _adds(catalogue.TorsionSpring)
    torsion_damper = _adds(catalogue.TorsionDamper)
    delayed_feedback = _adds(catalogue.DelayedFeedback)
    delayed_torsion_feedback = _adds(catalogue.DelayedTorsionFeedback)
    rigid_tie = _adds(catalogue.RigidTie)
    lever = _adds(catalogue.Lever)
    gear = _adds(catalogue.Gear)
    gear_mesh = _adds(catalogue.GearMesh)
    rack = _adds(catalogue.Rack)
    pulley = _adds(catalogue.Pulley)
    contact = _adds(switching.Contact)
    backlash = _adds(switching.Backlash)
    one_sided_spring = _adds(switching.OneSidedSpring)
    cable = _adds(switching.Cable)
    piecewise_spring = _adds(switching.PiecewiseSpring)
    dry_friction = _adds(switching.DryFriction)
    clutch = _adds(switching.Clutch)
    brake = _adds(switching.Brake)
    latch = _adds(switching.Latch)
    release = _adds(Release)
    rotor = _adds(Rotor)
    bearing = _adds(Bearing)
    unbalance = _adds(Unbalance)
    constrain = _adds(catalogue.Relation)
    prescribe = _adds(catalogue.PrescribedMotion)

    @answering
    def gravity(self, acceleration: float | str) -> None:
        """A force m g along the axis on every mass, on a rotor along z; negative where the axis points upwards (m/s^2)."""
        with named("gravity"):
            acceleration = quantity(acceleration, "m/s^2") if isinstance(acceleration, str) else acceleration
        self.gravity_along = real_number(acceleration, "gravity")

    @answering
    def force(self, name: str, signal: ImpulsiveSmooth | float) -> None:
        """A force on a body from t = 0 on, in addition to earlier ones.

        Args:
            name: name of the body.
            signal: with one row, in N, or N m on a body that turns, such as ``mb.step(2.0)``; a number is constant.

        Raises:
            InputError: an unknown body or the ground, a signal with several rows.
        """
        self._check_body("force", name)
        if name == GROUND:
            raise InputError('force: found "ground", which does not move; name a body')
        signal = named_rows({name: signal}, {name: 0}, 1, "force")
        self._forces[name] = self._forces[name] + signal if name in self._forces else signal

    def incidence(self) -> Incidence:
        """The factors K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m)."""
        return incidence_of(self.elements, self.coordinates)

    @answering
    def assemble(self, sparse: bool = False) -> MechanicalSystem | SwitchedSystem:
        """M x'' + C x' + K x = f of all elements: rest lengths and weights are its static force, ties its constraint rows.

        With contacts, friction, clutches, latches and the like it is a ``SwitchedSystem``, whose phases have these equations in common.

        Args:
            sparse: matrices as ``scipy.sparse``, for models of thousands of bodies: their memory is proportional to the number of
                elements, ``modes`` are those of lowest frequency, 50 by default, and ``solve`` gives the motion in these with a bound
                on the rest. Arrays, which have all modes, by default.

        Raises:
            InputError: the model has no body; a rotor, or rows above position level, where it is sparse.
            ContradictoryConstraints: ties with contradictory values.

        >>> model = LumpedModel()
        >>> _ = [model.mass(f"m{i}", 1.0) for i in range(1000)], model.spring("ground", "m0", 1e4)
        >>> _ = [model.spring(f"m{i}", f"m{i + 1}", 1e4) for i in range(999)]
        >>> model.assemble(sparse=True).modes(count=2).natural_frequencies.round(6)  # 200 sin((2 i - 1) pi / 4002), i = 1, 2
        array([0.157001, 0.471003])
        """
        if not self.has_switches:
            return self._assembled(self.elements, sparse)
        if sparse:
            raise InputError("assemble: a model with contacts, friction or other switches has no sparse matrices; leave sparse out")
        from ..mechanics.switched.switched_system import SwitchedSystem

        return SwitchedSystem.of_switches(self.common_system(), self.switches())

    @property
    def has_switches(self) -> bool:
        """Whether elements of the model have several states."""
        return any(isinstance(element, (SwitchingElement, Release)) for element in self.elements)

    def common_system(self) -> MechanicalSystem:
        """The equations of all elements without switches, which all phases have in common."""
        released = {element.target for element in self.elements if isinstance(element, Release)}
        return self._assembled([element for element in self.elements if element.name not in released], False)

    def switches(self) -> tuple[Switch, ...]:
        """The parts with several states, in the order of the elements."""
        names, result = self.coordinates, []
        releases = {element.target: element for element in self.elements if isinstance(element, Release)}
        for element in self.elements:
            if not isinstance(element, SwitchingElement) and element.name not in releases:
                continue
            row = coordinate_row(element.row, names)  # type: ignore[attr-defined]
            unit = next((self._units[name] for name in element.ends if name in self._units), "m")
            release = releases.get(element.name)
            if not isinstance(element, SwitchingElement):
                result.append(switching.released(element, release, row, unit))  # type: ignore[arg-type]
                continue
            own = element.switches(row, unit)
            result += own if release is None else switching.with_release(own, release, row)
        return tuple(result)

    def _assembled(self, elements: Sequence[Element], sparse: bool) -> MechanicalSystem:
        units, names = self.units, self.coordinates
        if not units:
            raise InputError("the model has no body; add a mass, an inertia or a node")
        factors = incidence_of(elements, names, sparse=sparse)
        signals = [signal.mapped(coordinate_row({name: 1.0}, names)[:, None]) for name, signal in self._forces.items()]
        turning = rotor_terms(elements, names)
        if sparse and turning:
            raise InputError("assemble: a model with rotors has no sparse matrices; leave sparse out")
        springs: Any = factors.springs.product if sparse else factors.springs.matrix
        dampers: Any = factors.dampers.product if sparse else factors.dampers.matrix
        system = MechanicalSystem(
            mass=scipy.sparse.diags_array(factors.masses) if sparse else ElementMatrix(np.eye(len(names)), factors.masses),
            damping=turning.added_to(dampers, "damping") if turning else dampers,
            stiffness=turning.added_to(springs, "stiffness") if turning else springs,
            constraints=[
                Constraint(_rows([tie.row], names, sparse=sparse), level=tie.level, value=tie.row_value, names=tie.name)
                for tie in factors.ties
            ],
            names=names,
            force=sum(signals, zero(len(names))) if signals else None,
            static_force=factors.static_force(self.gravity_along),
            units=units,
            gyroscopic=turning and turning.gyroscopic,
            delayed=self._delayed_matrices(names) or None,
        )
        if turning:
            system.has_one_axis = False
            system.speed_tables, system.unbalance, system.whirl_matrix = turning.tables, turning.unbalance, turning.whirl
        system.loss_factors = {one.name: eta for one in with_parts(elements) if (eta := vars(one).get("loss_factor"))}
        system.elements = ElementForces(elements, names)
        if not sparse and not (turning and turning.stiffness.any()):
            system.part_source = partial(_energy_parts, factors, names)
        system.origin = copy(self)
        system.origin._elements, system.origin._units = dict(self._elements), units  # what is added later is not in the system
        system.parameter_source = partial(element_parameters, system.origin)
        return system

    def _delayed_matrices(self, names: Sequence[str]) -> dict[float, np.ndarray]:
        """The sums of K_j and C_j of the feedback with each delay, shape (2, n, n)."""
        total: dict[float, np.ndarray] = {}
        for element in self.elements:
            if isinstance(element, DelayedFeedback):
                pattern = np.outer(coordinate_row(element.row, names), coordinate_row(element.measured_row, names))
                own = np.array([element.displacement_gain * pattern, element.velocity_gain * pattern])
                total[element.delay] = total.get(element.delay, 0.0) + own
        return total

    def _add(self, element):
        name = element.name
        if not name:
            name = next(free for free in element.default_names if free not in self._elements and free not in self._parts)
            object.__setattr__(element, "name", name)  # it was just created, and its numbers are checked
        elif not isinstance(name, str) or not name.strip():
            raise InputError(f"{element.kind}: found the name {name!r}; expected a text")
        parts, ends = element.parts, element.ends
        self._check_names(element, [element.name, *[part.name for part in parts]])
        for name in ends:
            if name not in self._units:
                self._check_body(element, name)
        if (settled := element.settled(self._units)) is not element:
            element, parts, ends = settled, settled.parts, settled.ends
        for name, unit in ends.items():
            if unit and name != GROUND and self._units[name] != unit:
                of_angles = f"torsion_{element.kind}" if f"torsion_{element.kind}" in ELEMENTS else ""
                raise InputError(
                    f'{element.label}: "{name}" {STATES[self._units[name]]}, but a {element.kind} needs a body that {STATES[unit]}'
                    + (f"; for bodies that turn there is {of_angles}" if of_angles else "")
                )
        if len(ends) < element.end_count:
            raise InputError(f"{element.label}: two of its ends are on the same body; give different ones")
        joins_one_kind = isinstance(element, (RigidTie, SwitchingElement))
        if joins_one_kind and len({self._units[name] for name in ends if name != GROUND}) > 1:
            raise InputError(f"{element.label}: one end moves along the axis (m), the other turns (rad); use a rack")
        if isinstance(element, Release):
            self._check_release(element)
        self._elements[element.name] = element
        for part in parts:
            self._parts[part.name] = part
        for body in (element, *parts):
            if isinstance(body, Body):
                self._units[body.name] = body.unit
        return element

    def _check_release(self, release: Release) -> None:
        """Raise an InputError where nothing of this name can be released, or it is already."""
        target = self._elements.get(release.target)
        if not isinstance(target, (Link, Tie, SwitchingElement)):
            known = [name for name, one in self._elements.items() if isinstance(one, (Link, Tie, SwitchingElement))]
            what = f"is a {target.kind}, which cannot be released" if target else "does not exist"
            raise InputError(
                f'{release.label}: "{release.target}" {what}{nearest(release.target, known)}; expected the name of a spring, '
                "damper, tie, contact, latch …, added before its release"
            )
        if any(isinstance(one, Release) and one.target == release.target for one in self.elements):
            raise InputError(f'{release.label}: "{release.target}" has a release already; give one')
        if isinstance(target, PrescribedMotion):
            raise InputError(
                f'{release.label}: "{release.target}" is a prescribed motion; expected a spring, damper, tie, contact or latch'
            )
        if isinstance(target, switching.Latch) and target.at is not None and target.at == release.at:
            raise InputError(
                f'{release.label}: the latch "{release.target}" is closed and released at once, at {release.at:g} s; give different times'
            )

    def _check_names(self, element: Element, names: list[str]) -> None:
        """Raise an InputError where the name of an element, or of a part of it, is in use."""
        for name in names:
            if name == GROUND:
                raise InputError(f'{element.kind}: the name "ground" is that of the fixed body; choose another')
            if names.count(name) > 1:
                raise InputError(f'{element.label}: its name and those of its points must differ; found "{name}" twice')
            if known := self._elements.get(name) or self._parts.get(name):
                raise InputError(f'{element.kind}: the name "{name}" is already in use ({known.kind}); names must differ')

    def _check_body(self, what: Element | str, name) -> None:
        if name != GROUND and name not in self._units:
            known, label = (GROUND, *self.coordinates), what if isinstance(what, str) else what.label
            raise InputError(
                f'{label}: there is no body "{name}"{nearest(name, known)}; bodies are added before the elements between them'
            )


# The factors of the matrices of a lumped model: K = B^T diag(k) B, C = B^T diag(c) B, M = diag(m). Their numbers are floats, complex
# numbers for derivatives, or expressions for formulas.


@dataclass(frozen=True, eq=False)
class BranchRows:
    """The springs or the dampers of a model with n coordinates, one a row."""

    #: B, -1 at the start, 1 at the end, nothing for the ground, or the radii of gears, shape (p, n).
    incidence: np.ndarray | scipy.sparse.csr_array
    constants: np.ndarray  # stiffness or damping, all positive, shape (p,)
    rest: np.ndarray  # elongation without force, shape (p,); zero for dampers
    names: tuple[str, ...]  # names of the elements

    @property
    def matrix(self) -> ElementMatrix:
        """B^T diag(constants) B, shape (n, n)."""
        return ElementMatrix(self.incidence, self.constants)

    @property
    def product(self) -> np.ndarray:
        """B^T diag(constants) B as an array of its numbers, shape (n, n)."""
        return self.incidence.T @ (self.constants[:, None] * self.incidence)


@dataclass(frozen=True, eq=False)
class Incidence:
    """Incidence matrices and constants of a model."""

    springs: BranchRows  # the branches of K and of C
    dampers: BranchRows
    masses: np.ndarray  # masses and inertias by coordinate, zero for nodes, shape (n,)
    weighing: np.ndarray  # the masses that gravity acts on, shape (n,)
    ties: tuple[Tie, ...]  # the elements that are a constraint row

    def static_force(self, gravity) -> np.ndarray:
        """The force of rest lengths and weights, shape (n,)."""
        return self.springs.incidence.T @ (self.springs.constants * self.springs.rest) + gravity * self.weighing


def incidence_of(elements: Sequence[Element], names: Sequence[str], dtype: type = float, *, sparse: bool = False) -> Incidence:
    """The factors of the bodies, springs and dampers among these elements and their parts."""
    weighing = {name: mass for element in elements for name, mass in element.weighing.items()}
    elements = with_parts(elements)
    links = [element for element in elements if isinstance(element, Link)]
    return Incidence(
        _branches(links, "stiffness", names, dtype, sparse),
        _branches(links, "damping", names, dtype, sparse),
        coordinate_row({element.name: element.constant for element in elements if isinstance(element, Body)}, names, dtype),
        coordinate_row(weighing, names, dtype),
        tuple(element for element in elements if isinstance(element, Tie)),
    )


def _branches(links: Sequence[Link], field: str, names: Sequence[str], dtype: type, sparse: bool) -> BranchRows:
    links = [link for link in links if vars(link).get(field, 0.0)]
    rest = [link.rest if field == "stiffness" else 0.0 for link in links]
    return BranchRows(
        incidence=_rows([link.row for link in links], names, dtype, sparse),
        constants=np.array([getattr(link, field) for link in links], dtype),
        rest=np.array(rest, dtype),
        names=tuple(link.name for link in links),
    )


def coordinate_row(coefficients: Mapping[str, Any], names: Sequence[str], dtype: type = float) -> np.ndarray:
    """Coefficients by name as a row."""
    return _rows([coefficients], names, dtype)[0]


def _rows(coefficients: Sequence[Mapping[str, Any]], names: Sequence[str], dtype: type = float, sparse: bool = False):
    """Coefficients by name as rows, an array or sparse; those of other names, as of the ground, are ignored."""
    place = {name: i for i, name in enumerate(names)}
    known = [(i, place[name], factor) for i, row in enumerate(coefficients) for name, factor in row.items() if name in place]
    i, j, values = zip(*known) if known else ((), (), ())
    shape = (len(coefficients), len(names))
    if sparse:
        return scipy.sparse.csr_array((np.array(values, dtype), (i, j)), shape=shape)
    rows = np.zeros(shape, dtype)
    rows[i, j] = values
    return rows


class ElementForces(Mapping):
    """The forces of springs and dampers by name, each with its row over the coordinates made on demand."""

    def __init__(self, elements: Sequence[Element], names: Sequence[str]):
        self._links = {element.name: element for element in elements if isinstance(element, Link)}
        self._names = names

    def __getitem__(self, name: str) -> ElementForce:
        link = self._links[name]
        row = coordinate_row(link.row, self._names)
        return ElementForce(row, -link.rest, vars(link).get("stiffness", 0.0), vars(link).get("damping", 0.0), link.unit)

    def __iter__(self) -> Iterator[str]:
        return iter(self._links)

    def __len__(self) -> int:
        return len(self._links)


def _energy_parts(factors: Incidence, names: Sequence[str]) -> EnergyParts:
    """Every mass and spring by name; massless joints have no part."""
    unit_rows, springs = np.eye(len(names)), factors.springs
    masses = {name: ElementMatrix(row[None], [mass]) for name, row, mass in zip(names, unit_rows, factors.masses) if mass}
    by_spring = zip(springs.names, springs.incidence, springs.constants)
    return EnergyParts(masses, {name: ElementMatrix(row[None], [constant]) for name, row, constant in by_spring})


# The numbers of the elements as parameters.


def element_parameters(model: LumpedModel) -> Iterator[Parameter]:
    """One parameter for each constant of an element: named as a body or link itself, "gear 1.start_radius" for others."""
    for element in model.elements:
        if isinstance(element, PrescribedMotion):
            continue
        numbers = fields_of(type(element)).numbers
        for field, about in numbers.items():
            value = getattr(element, field)
            if value is not None and about.varied:
                main = isinstance(element, (Body, Link)) and field == next(iter(numbers))
                yield _parameter(model, element, field, element.name if main else f"{element.name}.{field}", float(value))
        for field in ("points", "coefficients"):
            for key, value in getattr(element, field, {}).items():
                yield _parameter(model, element, field, f"{element.name}.{key}", float(value), key)


def _parameter(model: LumpedModel, element: Element, field: str, name: str, value: float, key: str | None = None) -> Parameter:
    step = COMPLEX_STEP * (abs(value) or 1.0)
    number: Any = complex(value, step)
    twin = copy(element)
    object.__setattr__(twin, field, number if key is None else {**getattr(element, field), key: number})
    unit = (fields_of(type(element)).entries[field].about.unit or "m").replace("*", " ")
    return complex_parameter(name, value, [twin], model.coordinates, step, unit, model.gravity_along)


def exact_elements(elements: Iterable[Element], number: Callable[[Any], Any]) -> list[Element]:
    """Copies of elements whose numbers are converted to other ones, or to expressions."""
    twins = []
    for element in elements:
        twin = copy(element)
        for name in fields_of(type(element)).entries:
            value = getattr(element, name)
            if isinstance(value, Mapping):
                object.__setattr__(twin, name, {key: number(each) for key, each in value.items()})
            elif isinstance(value, float):
                object.__setattr__(twin, name, number(value))
        twins.append(twin)
    return twins


def complex_parameter(
    name: str, value: float, elements: Sequence[Element], names: Sequence[str], step: float, unit: str, gravity: complex
) -> Parameter:
    """The derivatives from elements whose constants are those of p + i h."""
    factors = incidence_of(elements, names, complex)
    K, C, M, force = (
        part.imag / step if part.imag.any() else 0.0
        for part in (factors.springs.product, factors.dampers.product, np.diag(factors.masses), factors.static_force(gravity))
    )
    rows = {}
    for tie in factors.ties:
        if not isinstance(tie, PrescribedMotion):
            row, right = coordinate_row(tie.row, names, complex).imag / step, complex(tie.row_value).imag / step
            if row.any() or right:
                rows[tie.name] = (row, right)
    return Parameter(name, value, K, C, M, force, rows, unit)


#: The classes of elements by the keys of their tables in scenes, in the order of these.
ELEMENTS: dict[str, type[Element]] = {
    "constraint" if name == "constrain" else name: method.kind
    for name, method in vars(LumpedModel).items()
    if name != "prescribe" and hasattr(method, "kind")
}
