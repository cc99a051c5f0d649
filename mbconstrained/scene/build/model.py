"""The model of a scene: one interface for lumped models, matrices, robots, transfer functions, state spaces and rotors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, get_args

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.display import TextTable
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.quantities import Dimension, dimension, unit_of
from ...ground.units import GROUND
from ...mechanics.channels import MOTIONS, Output, OutputNames
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...polynomial.reduced_equations import Reduction
from ...response.events import start_of
from ...response.response import Response
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import zero
from ..coordinates import Coordinates, beyond_noise
from ..file import shown
from ..schema.scene_schema import QuantityKind
from .forces import SceneForce

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem
    from ...models.lumped import LumpedModel
    from ...response.solvability import Solvability
    from ...robot.linear_range import LinearRange
    from ...robot.robot import Robot
    from ...robot.statics import Posture
    from .switched import Switching

Decision = tuple[bool, str]  # whether a stage runs, and the reason


class ModelTables(NamedTuple):
    """Tables before those of the motion, on forces, for a closer look, and rows of the table of evidence: name, value, meaning."""

    first: Sequence[TextTable] = ()
    forces: Sequence[TextTable] = ()
    details: Sequence[TextTable] = ()
    evidence: Sequence[tuple[str, str, str]] = ()


class End:
    """End of a motion as given in a scene: the interface of reports."""

    key: ClassVar[str]  # its name in scenes and in JSON
    title: ClassVar[str]  # heading of its table
    duration: float = 0.0  # T in s; 0 where there is none
    notices: tuple[Notice, ...] = ()  # what is undetermined, ill-conditioned or inaccurate
    unproved: ClassVar[str] = ""  # the reason why no error is bounded; empty where one is
    uncertified: str = ""  # the reason why exact arithmetic proves no digits; empty where it does

    def table(self, coordinates: Coordinates) -> TextTable:
        """The given values, with evidence."""
        raise NotImplementedError

    def to_dict(self) -> Any:
        """The end as plain data, in SI."""
        raise NotImplementedError


def no_modes(what: str) -> str:
    """Why equations that are no regular system have no answer of this kind."""
    return (
        f"{what}: the equations are no regular system: eigenvalues and responses would be those of the choices. Write what moves a free "
        "coordinate, and leave redundant rows out, in the coefficients; a run has the motion"
    )


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of a scene, their start and force, names and units, and what reports say about a model of its kind.

    This class serves lumped models, rotors, matrices and coefficients; robots and control systems override what differs.
    """

    coordinates: Coordinates  # names and units
    polynomial_matrix: PolynomialMatrix  # A(s), for a mechanical system that of its constrained form, without delayed terms
    initial: np.ndarray  # x^(i)(0-) as row i, shape (q, r)
    force: ImpulsiveSmooth | None  # on [0, inf), or None
    system: MechanicalSystem | None = None  # mass, damping, stiffness and constraint rows; None where A(s) was given itself
    model: LumpedModel | None = None  # the lumped model behind the system, or None
    robot_scene: Any = None  # the robot behind the system with its posture, inputs and outputs, or None
    control: Any = None  # the transfer function or state space behind the equations with its inputs and outputs, or None
    # the forces of the [[force]] tables and of unbalance, one by one, but for inputs of a transfer function or state space
    loads: tuple[SceneForce, ...] = ()
    rotor: MechanicalSystem | None = None  # the rotor at rest whose speed the system has, or None
    response: Response | None = None  # the motion, where it is already known
    ends: tuple[End, ...] = ()  # what brings the motion to its end: boundary values, an input of least energy, input shapers
    # conditions and free coordinates of equations that are no regular system by themselves; the polynomial matrix is that of the
    # completed system. None where they are one
    solvability: Solvability | None = None
    switching: Switching | None = (
        None  # the switched system behind the motion, the system being that of one phase; None without switches
    )

    # The problem, and its solution.

    @cached_property
    def right_hand_side(self) -> ImpulsiveSmooth:
        """The right-hand side of A(d/dt) x: forces, static offsets and constraint values."""
        if self.response is not None:
            return self.response.problem.force
        force = zero(len(self.coordinates.names)) if self.force is None else self.force
        return force if self.system is None else self.system.undelayed_form().force(self.system.force + force)

    @property
    def are_bare(self) -> bool:
        """Whether A(s) was given itself, without a mechanical system, transfer function or state space."""
        return self.system is None and self.control is None

    @property
    def is_free(self) -> bool:
        """Whether the right-hand side is zero."""
        return self.right_hand_side.is_zero

    @property
    def has_regular_leading_coefficient(self) -> bool:
        """Whether A_q is surely nonsingular: there is no infinite part, and any values at 0- are admissible."""
        A = self.polynomial_matrix
        return isinstance(A.reduction, Reduction) and A.reduction.state_count == A.degree * A.size

    @property
    def start_fits(self) -> bool:
        """Whether the values at 0- continue without a jump or an impulse."""
        if self.has_regular_leading_coefficient and not self.right_hand_side.impulses:
            return True
        start = start_of(self.polynomial_matrix.jordan_pairs().form, self.initial, self.right_hand_side)
        jumps = any(beyond_noise(jump, old, jump + old).size for jump, old in zip(start.jump, self.initial))
        return not (jumps or any(impulse.any() for impulse in start.impulses))

    def solve(self) -> Response:
        """The answer: a Motion where there is a mechanical system, else a Response."""
        if self.response is not None:
            return self.response
        if self.switching is not None:
            return self.switching.solve(self.initial, self.force)
        if self.system is not None:
            return self.system.solve(*self.initial, force=self.force)
        from ...response.solve import solve

        return solve(self.polynomial_matrix, initial=self.initial, force=self.force)

    robot: ClassVar[Robot | None] = None  # the robot behind the system
    posture: ClassVar[Posture | None] = None  # the equilibrium about which it moves

    # Names, outputs and forces besides those of the coordinates.

    @property
    def has_reactions(self) -> bool:
        """Whether there are constraint rows, in whatever phase."""
        if self.switching is not None:
            return self.switching.has_rows
        if self.system is None or self.system.is_sparse:
            return False
        return bool(getattr(self.response, "_reaction_rows", self.system.rows))

    @property
    def has_forces(self) -> bool:
        """Whether something acts that could be plotted."""
        return bool(self.loads)

    coordinates_called = "coordinates"  # in reports
    has_outputs_among_coordinates = False  # outputs are solved for like coordinates
    has_connections = False  # a robot has loops, springs or bushings
    form_notices: ClassVar[tuple[Notice, ...]] = ()  # on a doubtful mechanical normal form
    facts: ClassVar[tuple[tuple[str, str], ...]] = ()  # pairs of a label and a text, for the page
    original: ClassVar[Any] = None  # the state space whose mechanical normal form is solved, a ControlScene

    @property
    def root_name(self) -> str:
        """Name of a root of det A(s)."""
        return "eigenvalue" if self.system else "zero"

    @property
    def outputs(self) -> Coordinates | None:
        """Names and units of the outputs, or None."""
        return None

    def output_values(self, times: np.ndarray, coordinates: np.ndarray) -> np.ndarray:
        """The outputs, shape (q, T), at times (T,) at which the coordinates have these values (r, T)."""
        raise NotImplementedError

    def output_closed_form(self, motion: Any) -> BohlFunction:
        raise NotImplementedError

    def output_error_estimate(self, times: np.ndarray) -> float | None:
        """Estimate of the relative error of the outputs; None where it is that of the coordinates."""
        return None

    def linear_range(self, motion: Any, times: np.ndarray) -> LinearRange | None:
        """The range in which the equations of a robot hold; None for other models."""
        return None

    # What reports say about the model; a result is a ``Result``.

    mesh_notices: ClassVar[tuple[Notice, ...]] = ()  # on meshes of a robot that cannot be drawn

    def notices(self, result: Any) -> tuple[Notice, ...]:
        """Notices on the motion that only a model of this kind has."""
        return ()

    def tables(self, result: Any) -> ModelTables:
        """Tables on the model, next to those of the motion."""
        return ModelTables()

    def to_dict(self, result: Any) -> dict:
        return {}

    # Decisions on stages and requests.

    unit_texts = 0  # quantities with units in other files than the scene

    def size_decision(self) -> Decision:
        """The equations of every scene."""
        if self.model is not None:
            return True, f"{counted(len(self.model.elements), 'element')}, {counted(len(self.coordinates.names), 'coordinate')}"
        return True, f"{counted(len(self.coordinates.names), 'coordinate')}, degree {self.polynomial_matrix.degree}"

    def rows_decision(self, removed: int | None = None, none: str = "no constraint rows") -> Decision:
        """Redundant constraint rows are searched for where there are rows."""
        if self.system is None:
            return False, "A_0, A_1, … are given: constraints are equations among the others"
        if removed is None:
            removed = sum(notice.kind == NoticeKind.REDUNDANT for notice in self.system.notices)
        rows = len(self.system.rows) + removed
        return (True, f"{counted(rows, 'row')}, {removed} of them dependent") if rows else (False, none)

    def outputs_decision(self, plots: Sequence[str]) -> Decision:
        """Outputs of a robot or a state space."""
        return False, "no outputs are named"

    def connections_decision(self, requested: bool) -> Decision:
        """Forces of loops, springs and bushings of a robot in the directions of the ground."""
        return False, "no loops, springs or bushings"

    def unproved(self, reason: str, plots: Sequence[str]) -> str:
        """The reason why an output is not proved, in addition to that of the coordinates."""
        if self.switching is not None:
            return "phases that follow each other: errors are estimated"
        return reason or next((end.unproved for end in self.ends if end.unproved), "")

    def without_formula(self, modal_damping: bool) -> str:
        """The reason why there are no formulas with symbols; empty where there are."""
        if self.rotor is not None:
            return "a rotor"
        if self.ends:
            return f"a motion with {self.ends[-1].title.lower()}"
        if self.system is not None and self.system.delayed:
            return "delays"
        return "modal damping" if modal_damping else ""

    @property
    def without_energy(self) -> str:
        """The reason why there is no energy; empty where there is."""
        known = "energy is known only where mass, damping and stiffness are given, not for coefficients"
        return known if self.system is None else ""


def output_names(equations: Equations) -> OutputNames:
    """The names of outputs of a model; of one that switches the rows are those of all phases."""
    coordinates, switching = equations.coordinates, equations.switching
    units = dict(zip(coordinates.names, coordinates.units))
    if switching is None:
        return OutputNames(units, equations.system)
    return OutputNames(units, equations.system, switching.rows, switching.machine.machine.systems is None)


def named_quantities(tables, names: OutputNames) -> Iterator[Output]:
    """The outputs of the tables [[output.quantity]], one by one: none refers to another."""
    names = names.without_own
    for table in tables:
        one = _between(table, names) if table.between else _of_one(table, names)
        yield reduce(_multiplied, table.multipliers, one)


def quantities_by_name(tables, names: OutputNames) -> dict[str, Output]:
    """The outputs of the tables by distinct names; an elongation with the name of its spring is "elongation of spring"."""
    result: dict[str, Output] = {}
    for table, one in zip(tables, named_quantities(tables, names)):
        if _is_another(one, names.without_own):
            if table.name not in (None, table.of) or list(table.multipliers):
                raise InputError(f"name: {shown(one.name)} is already the name of something else; give another name")
            one = replace(one, name=f"{table.quantity} of {one.name}")
        if one.name in result:
            raise InputError(f"name: {shown(one.name)} is the name of two [[output.quantity]]; give one of them another name")
        result[one.name] = one
    return result


def _is_another(one: Output, names: OutputNames) -> bool:
    """Whether the name of a quantity already means something else."""
    try:
        known = names.output(one.name)
    except InputError:
        return False
    return not np.array_equal(one.rows, known.rows) or one.reactions != known.reactions


def _between(table, names: OutputNames) -> Output:
    """The motion of the second coordinate relative to the first."""
    first, second = table.between
    kind = table.quantity or "displacement"
    if kind not in MOTIONS:
        raise InputError(f"quantity: found {shown(kind)}; between two coordinates expected displacement, velocity, acceleration")
    for name in table.between:
        if name != GROUND and name not in names.directions:
            known = ", ".join(names.directions)
            hint = nearest(name, (*names.directions, GROUND))
            raise InputError(f"between: there is no coordinate {shown(name)}{hint}; the coordinates are {known}")
    units = {names.directions[name] for name in table.between if name != GROUND}
    if first == second or len(units) != 1:
        raise InputError(f"between: found {shown(first)} and {shown(second)}; expected two coordinates of one unit")
    one = names.output(f"{kind} of {second} - {first}", what="between")
    return replace(one, name=table.name or f"{second} relative to {first}")


def _of_one(table, names: OutputNames) -> Output:
    """A quantity by its name; of a spring or damper that is named alone its force, or another quantity of it."""
    kinds = [kind for kind in get_args(QuantityKind) if table.of in names.kinds[kind]]
    if table.quantity not in (None, *kinds):
        expected = f"expected {', '.join(kinds)}" if kinds else "leave it out"
        raise InputError(f"quantity: found {shown(table.quantity)} of {shown(table.of)}; {expected}")
    one = names.output(table.of, table.quantity or ("force" if table.of in names.elements else "displacement"), "of")
    return replace(one, name=table.name or one.name)


#: Quantities of products by their unit; others keep the name of the quantity.
PRODUCTS = {"Pa": "stress", "N": "force", "N m": "moment", "m": "displacement", "J": "energy"}


def _multiplied(one: Output, multiplier: tuple[float, Dimension | None]) -> Output:
    """A quantity times a number with its kind: a stress is a force by an area, or a moment by a section modulus."""
    factor, kind = multiplier
    if kind is None:
        return one.scaled(factor)
    product = dimension(one.unit.replace(" ", "*")).times(kind)
    unit = "Pa" if product.units == dimension("Pa").units else unit_of(product).replace("*", " ")
    return one.scaled(factor, unit=unit, quantity=PRODUCTS.get(unit, one.name))
