"""The equations M x'' + C x' + K x = f + A^T lambda with their constraint rows, which all analyses read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from functools import cached_property, partial, reduce
from operator import add
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import constant_zeros, counted, is_sparse, names_of, nearest, real_array, real_number
from ..ground.display import Pictured, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.threads import short_work
from ..ground.tolerances import noise_of
from ..ground.units import coordinate_units
from ..polynomial.delayed_terms import DelayedTerm, delayed_terms
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth, named_rows, step, zero
from .constraints import (
    LEVELS,
    ConstrainedForm,
    Constraint,
    ConstraintRow,
    IndependentRows,
    checked_constraints,
    constrained_form,
    constraint_rows,
    explicit_acceleration,
    independent_rows,
)
from .element_matrix import ElementMatrix, SpeedTable, modal_damping, relative_mass
from .energy import CoordinateParts, EnergyParts, checked_parts
from .parameter import Parameter, entry_parameters

if TYPE_CHECKING:
    from ..frequency.harmonic import Harmonic
    from .sparse.pencil import ReducedPencil

Side = Literal["inputs", "outputs"]


class ElementForce(NamedTuple):
    """The force of a spring or damper, stiffness e + damping e', positive in tension.

    Attributes:
        elongation: a of e = a x + rest, shape (n,).
        rest: the elongation at x = 0.
        stiffness, damping: in SI.
        unit: unit of the elongation, "m" or "rad".
    """

    elongation: np.ndarray
    rest: float
    stiffness: float
    damping: float
    unit: str


@answering
class EquationsOfMotion(Pictured):
    """Data of a ``MechanicalSystem``, without the answers to questions about it.

    Attributes:
        base_class: ``MechanicalSystem``, for systems that are derived from others.
        modes, solve: as of ``MechanicalSystem``.
        elements: the forces of springs and dampers by name, where they are known.
        quantities: further outputs of the kind ``channels.Output`` by name, such as the stress of a bar.
        has_one_axis: whether coordinates of one unit move along one axis, so that their forces add up.
        load_patterns: by name the generalized forces of a unit of a load that acts at several places, shape (n,), and the unit of the
            displacement along which it works: each is one input.
        loss_factors: eta of structural damping by the name of a spring, for harmonic motion only.
        mass_damping: whether mass-proportional damping acts on the "absolute" velocity or on that "relative" to moving supports; None without.
        part_source: the energy parts of a model that knows them; None for given ones, or those of coordinates.
        parameter_source: the parameters of a model that knows them; None for entries of the matrices.
        speed_tables: bearings whose coefficients change with the speed.
        whirl_matrix: S of ``Campbell.whirl``, shape (n, n); None for that of the gyroscopic moments.
        delayed: the terms with dead time, ascending by it; none without.
        last_harmonic: the matrices of the last frequency response, with what they have computed for the next one alike.
        unbalance: u of the force W^2 Re(u e^{i W t}) of the unbalance, complex, in kg m, shape (n,); None if there is none.
    """

    base_class: ClassVar[Callable[..., Any]]
    modes: Callable[..., Any]
    solve: Callable[..., Any]
    elements: Mapping[str, ElementForce] = MappingProxyType({})
    quantities: Mapping[str, Any] = MappingProxyType({})
    has_one_axis: bool = True
    load_patterns: Mapping[str, tuple[np.ndarray, str]] = MappingProxyType({})
    loss_factors: Mapping[str, float] = MappingProxyType({})
    mass_damping: Literal["absolute", "relative"] | None = None
    part_source: Callable[[], EnergyParts] | None = None
    parameter_source: Callable[[], Iterable[Parameter]] | None = None
    speed_tables: tuple[SpeedTable, ...] = ()
    whirl_matrix: np.ndarray | None = None
    unbalance: np.ndarray | None = None
    delayed: tuple[DelayedTerm, ...] = ()
    last_harmonic: Harmonic | None = None

    def __init__(
        self,
        mass,
        damping=None,
        stiffness=None,
        constraints: Sequence[Constraint] = (),
        names: Sequence[str] | None = None,
        force=None,
        static_force=None,
        units=None,
        energy_parts: EnergyParts | None = None,
        uncertainty: Mapping | None = None,
        gyroscopic=None,
        circulatory=None,
        delayed: Mapping | Sequence[DelayedTerm] | None = None,
    ):
        self.is_sparse = any(map(is_sparse, (mass, damping, stiffness)))
        self.mass = self._matrix(mass, "mass", None)
        self.damping = self._matrix(damping, "damping", self.size)
        self.stiffness = self._matrix(stiffness, "stiffness", self.size)
        given = zip((stiffness, damping, mass), (self.stiffness, self.damping, self.mass))
        self.given = tuple(value if isinstance(value, ElementMatrix) else matrix for value, matrix in given)
        self.names = names_of(names, self.size, "coordinates", "x")
        self.delayed = delayed_terms(delayed, self.size) if delayed else ()
        self.units = coordinate_units(units, self.names)
        self.gyroscopic = None if gyroscopic is None else self._matrix(gyroscopic, "gyroscopic", self.size)
        self.circulatory = None if circulatory is None else self._matrix(circulatory, "circulatory", self.size)
        self.constraints = checked_constraints(constraints, self.names)
        if self.is_sparse:
            of_arrays = dict(energy_parts=energy_parts, uncertainty=uncertainty, gyroscopic=gyroscopic, circulatory=circulatory)
            of_arrays |= dict(delayed=delayed)
            for name in (name for name, value in of_arrays.items() if value is not None):
                self._refuse_sparse(name)
            self.pencil: ReducedPencil | None = self._reduced_pencil()
        else:
            self.pencil = None
            self._named_parts = None if energy_parts is None else checked_parts(energy_parts, self.size)
            self.uncertainty = self._uncertainty(uncertainty or {})
            self._independent = self._independent_rows()
        self._forms: dict[tuple[int, ...] | None, ConstrainedForm] = {}  # None: of all rows at their levels
        self.origin: Any = None
        varies = force is not None and _varies(force)
        self.excitation = self._signal(force) if varies else None
        self.static_force = self._vector(static_force, "static_force") + self._vector(None if varies else force, "force")
        self.static_force.flags.writeable = False

    @property
    def turns(self) -> bool:
        """Whether the system is a rotor: it has gyroscopic terms or speed-dependent bearings."""
        return bool(self.speed_tables) or any(one is not None for one in (self.gyroscopic, self.circulatory, self.unbalance))

    def named_directions(self, side: Side) -> Mapping[str, tuple[np.ndarray, str]]:
        """Directions over the coordinates, shape (n,), with their units, by name."""
        return self.load_patterns if side == "inputs" else {}

    def ground_direction(self, unit: str, what: str) -> np.ndarray:
        """1 at the coordinates of a unit, which move along one axis; an InputError where they do not, shape (n,)."""
        own = np.array([float(one == unit) for one in self.units.values()])
        if not own.any():
            raise InputError(f"{what}: no coordinate is in {unit}")
        if not self.has_one_axis:
            raise InputError(f"{what}: the coordinates move along several axes; name springs, dampers or constraint rows instead")
        if unit == "rad" and not own.all():
            raise InputError(f"{what}: it needs the arms of all forces, which are not known; expected a model of rotations alone")
        if any((own @ part).any() for term in self.delayed for part in term.coefficients):
            raise InputError(
                f"{what}: not available with delayed feedback that acts on the ground; name springs and dampers instead"
            )
        return own

    def with_constraints(self, *constraints: Constraint) -> Self:
        """Return the system with further constraint rows.

        Args:
            constraints: rows for its n coordinates.

        Returns:
            A system of the same class.

        Raises:
            InputError: rows of another length, names in use.
            ContradictoryConstraints: dependent rows with different values.

        >>> from mbconstrained import Constraint, MechanicalSystem
        >>> pair = MechanicalSystem(np.diag([1.0, 3.0])).with_constraints(Constraint([1, -1]))
        >>> pair.acceleration([0, 0], [0, 0], [8.0, 0.0])
        array([2., 2.])
        """
        system = copy(self)
        system.constraints = (*self.constraints, *checked_constraints(constraints, self.names))
        system._forms = {}
        if self.is_sparse:
            system.pencil = system._reduced_pencil()
        else:
            system._independent = system._independent_rows()
        return system

    def _independent_rows(self) -> IndependentRows:
        rows = constraint_rows(self.constraints, self.units) if self.constraints else ()
        with short_work(2 * self.size):
            return independent_rows(rows, self.size)

    @property
    def size(self) -> int:
        """Number n of coordinates."""
        return self.mass.shape[0]

    @cached_property
    def energy_parts(self) -> EnergyParts:
        """M and K as sums of named parts; by default one part per coordinate."""
        self._refuse_sparse("energy_parts")
        stiffness, _, mass = self.given
        if self.part_source is not None:
            return self.part_source()
        return self._named_parts or CoordinateParts(self.names, mass, stiffness)

    @property
    def force(self) -> ImpulsiveSmooth:
        """f from t = 0 on: the static force as a step, and the excitation; n rows."""
        static = step(self.static_force) if self.static_force.any() else zero(self.size)
        return static if self.excitation is None else static + self.excitation

    @property
    def rows(self) -> tuple[ConstraintRow, ...]:
        """The independent constraint rows, strongest level first, in the order of the multipliers."""
        self._refuse_sparse("rows")
        return self._independent.rows

    @property
    def constraint_matrix(self) -> np.ndarray:
        """A, the coefficients of the independent rows, shape (k, n); of sparse matrices those of all rows, sparse."""
        return self.pencil.constraints.matrix if self.is_sparse else self._independent.matrix

    @property
    def multiplier_map(self) -> np.ndarray:
        """G with G A^T = I, shape (k, n): the multipliers of a constraint force A^T lambda."""
        self._refuse_sparse("multiplier_map")
        return self._independent.left_inverse

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on an unsymmetric mass matrix, and on redundant constraint rows or rows independent by a narrow margin."""
        rows = self.pencil.notices if self.is_sparse else self._independent.notices
        return rows if self.is_sparse else (*self.unsymmetric("mass"), *rows)  # sparse matrices are symmetric

    def unsymmetric(self, name: str) -> Iterator[Notice]:
        """A notice where M or K differs from its transpose by more than rounding errors."""
        matrix = getattr(self, name)
        skew = abs(matrix - matrix.T)
        if skew.max() > noise_of(abs(matrix).max(), self.size):
            i, j = np.unravel_index(int(skew.argmax()), skew.shape)
            entries = f"entry [{i + 1}][{j + 1}] is {matrix[i, j]:g}, entry [{j + 1}][{i + 1}] is {matrix[j, i]:g}"
            yield Notice(
                NoticeKind.UNSYMMETRIC, f"the {name} matrix is not symmetric: {entries}; those of a passive structure are symmetric"
            )

    def damping_notices(self, moving: bool | None = None) -> tuple[Notice, ...]:
        """Notices on the velocities on which mass-proportional damping acts where supports move, by default prescribed ones."""
        moving = not self.is_sparse and any(row.signal is not None for row in self.rows) if moving is None else moving
        if self.mass_damping is None or not moving:
            return ()
        text = {
            "absolute": "absolute velocities: it resists the motion of the supports, too; relative = true makes it act on the relative ones",
            "relative": "velocities relative to the static response to the motion of the supports",
        }[self.mass_damping]
        return (Notice(NoticeKind.DAMPING, f"the mass-proportional part of the Rayleigh damping acts on {text}"),)

    def range_notices(self, motion: Any) -> tuple[Notice, ...]:
        """Notice on a motion beyond the range in which linear equations represent the model; none for a linear model."""
        return ()

    def constrained_form(self) -> ConstrainedForm:
        """Return the constrained form [V^T (M s^2 + C s + K); A s^level] with every row at its level.

        Raises:
            InputError: the matrices are sparse, or there are delays.
        """
        self._refuse_sparse("constrained_form")
        self._refuse_delays()
        return self.undelayed_form()

    def undelayed_form(self) -> ConstrainedForm:
        """The constrained form without the delayed terms, on the whole form of a system without delays."""
        if None not in self._forms:
            self._forms[None] = self._form(*(row.order for row in self.rows))
        return self._forms[None]

    def delayed_equations(self) -> tuple[DelayedTerm, ...]:
        """The delayed terms in the equations of the constrained form, V^T (C_j s + K_j)."""
        form = self.undelayed_form()
        left = np.vstack([form.null_space.T, np.zeros((len(form.rows), self.size))])
        return tuple(term.mapped(left) for term in self.delayed)

    def position_form(self) -> ConstrainedForm:
        """Return the form [V^T (M s^2 + C s + K); A], every row at position level: the same motions without drift."""
        self._refuse_delays()
        return self._form(*(0 for _ in self.rows))

    def _form(self, *orders: int) -> ConstrainedForm:
        """The constrained form with rows of these derivatives, computed once."""
        if orders not in self._forms:
            with short_work(2 * self.size):
                self._forms[orders] = constrained_form(self.given, self.uncertainty, self._independent, self.names, orders)
        return self._forms[orders]

    def polynomial_matrix(self) -> PolynomialMatrix:
        """A(s) of the constrained form, degree 2, size n."""
        return self.constrained_form().polynomial_matrix

    def acceleration(self, displacement, velocity, force=None, time: float = 0.0) -> np.ndarray:
        """x'' at a given state, shape (n,), by the explicit formula of Udwadia and Phohomsiri (``mechanics.constrained_form``).

        Args:
            displacement, velocity: x and x', shape (n,) or by name. Rows at position and velocity level enter by their
                derivative, A x'' = 0 where b is constant, also where the state violates them.
            force: f in addition to the system's own at that time, as in ``MechanicalSystem.solve``.
            time: of the system's own force and prescribed motions (s).

        Returns:
            Shape (n,), in m/s^2 or rad/s^2.

        Raises:
            InputError: the matrices are sparse; shapes that do not match.
            NotUnique: rank [M; A] < n, masses and constraints alone do not determine the acceleration.
        """
        self._refuse_sparse("acceleration")
        self._refuse_delays("acceleration")
        load = -self._resistance(displacement, velocity, force, time)
        values = np.array([row.right_side(2)(time)[0] for row in self.rows])
        return explicit_acceleration(self.mass, self._independent, load, values, self.names)

    def constraint_force(self, displacement, velocity, force=None, time: float = 0.0) -> np.ndarray:
        """f_c = M x'' + C x' + K x - f = A^T lambda at a given state, shape (n,); arguments as in ``acceleration``.

        Args:
            displacement, velocity, force, time: as in ``acceleration``.

        Returns:
            Shape (n,), in N or N m.
        """
        acceleration = self.acceleration(displacement, velocity, force, time)
        return self.mass @ acceleration + self._resistance(displacement, velocity, force, time)

    def parameters(self) -> tuple[Parameter, ...]:
        """The numbers of the system with the derivatives of its equations: of a lumped model by element, otherwise the entries of M, C, K."""
        return tuple(entry_parameters(self) if self.parameter_source is None else self.parameter_source())

    def _refuse_loss_factors(self) -> None:
        """Raise an InputError for structural damping, whose response in time would precede the load."""
        if self.loss_factors:
            name = next(iter(self.loss_factors))
            raise InputError(
                f'solve: the spring "{name}" has a loss factor, which exists for harmonic motion only (in time its force would come '
                "before the motion that causes it); use frequency_response or steady_state, or give it a damper or modal damping"
            )

    def _refuse_delays(self, what: str = "modes and all that follows from them") -> None:
        """Raise an InputError for questions that are answered for equations without delays only."""
        if self.delayed:
            delays = ", ".join(f"{term.delay:g} s" for term in self.delayed)
            raise InputError(
                f"{what}: not available with delays ({delays}), which make infinitely many eigenvalues; available are solve, "
                "frequency_response, steady_state for harmonic loads, random_response to spectra with a highest frequency, and "
                "characteristic_roots for stability"
            )

    def with_rayleigh_damping(self, mass: float = 0.0, stiffness: float = 0.0, relative: bool = False) -> Self:
        """Return the system with proportional (Rayleigh) damping C + a M + b K: each mode has zeta = a / (2 w) + b w / 2.

        The part a M acts on absolute velocities, as dampers between every mass and the ground at rest would: where a support
        moves it resists the motion of the whole system with it. With ``relative`` it acts on the velocities relative to the static
        response R b to the motion b of the supports, as seismic codes have it:

            C + a (I - R A)^T M (I - R A) + b K,  K R + A^T L = 0,  A R = I

        which agrees with the former where no support moves. Source: Clough and Penzien, Dynamics of Structures (2003), section 26.

        Args:
            mass: a, at least 0, in 1/s.
            stiffness: b, at least 0, in s.
            relative: whether the part a M acts on velocities relative to moving supports; not available for sparse matrices.

        Returns:
            A new system.

        >>> import mbconstrained as mb
        >>> mb.MechanicalSystem(np.eye(1), stiffness=[[4.0]]).with_rayleigh_damping(0.2, 0.1).modes().damping_ratios.round(12)
        array([0.15])
        """
        factors = (real_number(stiffness, "stiffness", minimum=0.0), real_number(mass, "mass", minimum=0.0))
        parts = [factor * self.given[place] for factor, place in zip(factors, (0, 2)) if factor]
        if relative and factors[1]:
            self._refuse_sparse("relative damping")
            parts[-1] = factors[1] * relative_mass(self.given[2], self.stiffness, self.constraint_matrix)
        system = self._with_damping(parts, factors)
        if factors[1]:
            system.mass_damping = "relative" if relative else "absolute"
            if relative:
                reason = "relative damping follows the static response to moving supports, which"
                system.parameter_source = partial(_refuse_parameters, reason)
        return system

    def with_modal_damping(self, ratios) -> Self:
        """Return the system with the damping ratios zeta of its undamped modes added to C.

            C + sum of 2 zeta_i w_i (M u_i)(M u_i)^T,  u_i^T M u_j = delta_ij

        Args:
            ratios: one number for all oscillating modes, or one for each of the lowest, ascending by frequency; higher modes keep their damping.

        Returns:
            A new system.

        Raises:
            InputError: sparse matrices, unsymmetric M or K, negative ratios, or more ratios than oscillating modes.

        >>> import mbconstrained as mb
        >>> mb.MechanicalSystem(np.eye(2), stiffness=np.diag([4.0, 9.0])).with_modal_damping([0.02, 0.05]).modes().damping_ratios.round(12)
        array([0.02, 0.05])
        """
        self._refuse_sparse("modal damping")
        modes = self.modes(damped=False)
        part = modal_damping(self.mass, self.stiffness, self.constraint_matrix, modes.natural_frequencies, modes.shapes, ratios)
        system = self._with_damping([part])
        if any(mode.kind in ("rigid body", "offset") for mode in modes):  # which rounding errors of M u would damp
            K, C, M = system.uncertainty
            system.uncertainty = (K, C + _rounding(part), M)
        system.parameter_source = partial(_refuse_parameters, "modal damping follows the modes, which")
        return system

    def _with_damping(self, parts: Sequence, factors: tuple[float, float] = (0.0, 0.0)) -> Self:
        """The system with further damping matrices, whose entries have the errors of K and M times factors."""
        stiffness, own, mass = self.given
        elements = all(isinstance(part, ElementMatrix) for part in (own, *parts))
        matrices = [part if elements or not isinstance(part, ElementMatrix) else part.matrix for part in (own, *parts)]
        system: Any = copy(self)
        total = reduce(add, matrices)
        system.damping = system._matrix(total, "damping", self.mass.shape[0])
        system.given = (stiffness, total if elements else system.damping, mass)
        system._forms = {}
        if self.is_sparse:
            system.pencil = system._reduced_pencil()
        else:
            K, C, M = self.uncertainty
            system.uncertainty = (K, C + factors[0] * K + factors[1] * M, M)
            b, a = factors
            system.parameter_source = partial(_damped_parameters, self, a, b)
        return system

    def _summary(self) -> str:
        levels = ["position"] * self.constraint_matrix.shape[0] if self.is_sparse else [row.level for row in self.rows]
        parts = [counted(self.size, "coordinate"), *(["sparse"] if self.is_sparse else [])]
        parts += [f"{counted(levels.count(level), 'constraint row')} at {level} level" for level in LEVELS if level in levels]
        return ", ".join(parts)

    def _tables(self) -> tuple[TextTable, ...]:
        rows = () if self.is_sparse else self.rows
        cells = ((row.name, row.level, row.right_side_text) for row in rows)
        return TextTable("Constraint rows", ("row", "level", "value"), tuple(cells)), notice_table(self.notices)

    # the arguments of users as arrays and signals

    def _matrix(self, value, what: str, size: int | None):
        if value is None and size is None:
            raise InputError("mass: a mechanical system needs a mass matrix (zeros for massless coordinates)")
        if self.is_sparse:
            from .sparse.pencil import square_sparse

            return square_sparse(value.matrix if isinstance(value, ElementMatrix) else value, what, size)
        matrix = np.zeros((size, size)) if value is None else value.matrix if isinstance(value, ElementMatrix) else value
        if isinstance(matrix, (int, float)):
            raise InputError(f"{what}: found {matrix!r}; expected a matrix, of one coordinate [[{matrix!r}]]")
        matrix = real_array(matrix, what, shape=(size, size))
        if len(matrix) != matrix.shape[1]:
            raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
        if not len(matrix):
            raise InputError(f"{what}: found no entries; a mechanical system needs at least one coordinate")
        matrix.flags.writeable = False
        return matrix

    def _reduced_pencil(self) -> ReducedPencil:
        from .sparse.pencil import reduced_pencil

        return reduced_pencil(self.mass, self.damping, self.stiffness, self.constraints, self.names)

    def _refuse_sparse(self, what: str) -> None:
        if self.is_sparse:
            raise InputError(
                f"{what}: not available for sparse matrices, which have their modes of lowest frequency and the motion in them; "
                "give arrays, as mass.toarray()"
            )

    def _start(self, displacement, velocity) -> np.ndarray:
        """x and x' at 0-, shape (2, n)."""
        return np.array([self._vector(displacement, "displacement"), self._vector(velocity, "velocity")])

    def _resistance(self, displacement, velocity, force, time) -> np.ndarray:
        """C x' + K x - f."""
        time = real_number(time, "time", minimum=0.0)
        applied = self.force(time) + (self._signal(force)(time) if _varies(force) else self._vector(force, "force"))
        x, v = self._start(displacement, velocity)
        return self.damping @ v + self.stiffness @ x - applied

    def _applied(self, force) -> ImpulsiveSmooth:
        """The system's own force and another, as a function of time or a constant vector."""
        return self.force if force is None else self.force + self._signal(force)

    def _signal(self, force) -> ImpulsiveSmooth:
        """A force in order or by name, a function of time or constant, as a function of time with n rows."""
        if isinstance(force, Mapping) and _varies(force):
            return named_rows(force, {name: place for place, name in enumerate(self.names)}, self.size, "force")
        if not isinstance(force, ImpulsiveSmooth):
            return step(self._vector(force, "force"))
        if force.size != self.size:
            hint = f', such as {{"{self.names[0]}": mb.step(5.0)}}'
            rows = f"found {counted(force.size, 'row')}; expected one for each of the {counted(self.size, 'coordinate')}"
            raise InputError(f"force: {rows}, or signals by name{hint}")
        return force

    def _vector(self, value, what: str) -> np.ndarray:
        """A vector (n,) that is given in order or by name."""
        if value is None:
            return np.zeros(self.size)
        if not isinstance(value, Mapping):
            return real_array(value, what, shape=(self.size,))
        vector, places = np.zeros(self.size), {name: place for place, name in enumerate(self.names)}
        for name, number in value.items():
            if name not in places:
                raise InputError(f'{what}: there is no coordinate "{name}"{nearest(name, self.names)}')
            vector[places[name]] = real_number(number, f"{what} of {name}")
        return vector

    def _uncertainty(self, given: Mapping) -> tuple[np.ndarray, ...]:
        shape = (self.size, self.size)
        bounds = dict.fromkeys(("stiffness", "damping", "mass"), constant_zeros(shape))
        for name, value in given.items():
            if name not in bounds:
                raise InputError(f"uncertainty: found {name!r}{nearest(str(name), bounds)}; expected {', '.join(bounds)}")
            bounds[name] = np.abs(real_array(value, f"uncertainty of the {name}", shape=shape))
        return tuple(bounds.values())


def _varies(force) -> bool:
    """Whether a force, or a part of one given by name, is a function of time."""
    return any(isinstance(one, ImpulsiveSmooth) for one in (force.values() if isinstance(force, Mapping) else (force,)))


def _rounding(part: ElementMatrix) -> np.ndarray:
    """Bounds of what rounding errors of computed directions change in the entries, shape (n, n)."""
    size = np.abs(part.directions)
    error = noise_of(size.max(axis=1, initial=0.0), part.size)[:, None] * size.any(axis=0)
    bound = (size.T * part.constants) @ error
    return bound + bound.T


def _damped_parameters(system, mass: float, stiffness: float) -> Iterable[Parameter]:
    return (one.with_damping(mass, stiffness) for one in system.parameters())


def _refuse_parameters(reason: str) -> Iterable[Parameter]:
    raise InputError(
        f"sensitivities: {reason} change with every parameter; give the parameters as "
        "Parameter.of_function(name, value, build), which assembles the system for each value"
    )
