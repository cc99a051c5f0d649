"""M x'' + C x' + K x = f + A^T lambda with constraint rows A x^(level) = b: what every model becomes and every analysis reads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import scipy.sparse

from ..exchange.exported import ExportedSystem
from ..ground.checks import constant_zeros, counted, is_table, names_of, nearest, real_array, real_number, whole_number
from ..ground.coordinate_units import coordinate_units
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.threads import short_work
from ..ground.tolerances import noise_of
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.choose import Evaluations, Request
from ..signals.inputs import ImpulsiveSmooth, step, zero
from .constrained_form import ConstrainedForm, constrained_form, explicit_acceleration
from .constraints import LEVELS, Constraint, ConstraintRow, IndependentRows, checked_constraints, constraint_rows, independent_rows
from .element_matrix import DampedSystem, ElementMatrix
from .energy import EnergyParts, checked_parts, coordinate_parts
from .mode_computation import modes_of
from .modes import Modes
from .motion import Motion
from .vibration.harmonic_equations import frequency_response
from .vibration.questions import SystemQuestions
from .vibration.steady_state import steady_state

if TYPE_CHECKING:
    from .sparse.pencil import ReducedPencil

#: The number of modes of a system of sparse matrices that are computed where none is given.
DEFAULT_MODE_COUNT = 50


class MechanicalSystem(ExportedSystem, SystemQuestions, Displayed, DampedSystem):
    """M x'' + C x' + K x = f + A^T lambda with the constraint rows A x^(level) = b, in SI units, for t in s.

    The matrices are all arrays, or some of them ``scipy.sparse``. Arrays have all their modes, and motions in closed form in all of
    them. Sparse matrices are kept sparse, whatever their size: they have their modes of lowest frequency, and the motion in these
    with a bound on the rest; M and K must be symmetric then, and rows are at position level.

    Args:
        mass: M, shape (n, n), possibly singular (kg, kg m^2). This one and the next two may be given as ``ElementMatrix``,
            which keeps the digits of elements that differ by many orders of magnitude.
        damping: C, shape (n, n) (N s/m); zero by default.
        stiffness: K, shape (n, n) (N/m); zero by default.
        constraints: ``Constraint`` objects, or sparse matrices of rows that are zero at position level. Dependent rows are left
            out and reported in ``notices``.
        names: of the n coordinates; x1, x2, ... by default.
        force: f from t = 0 on: a constant vector (n,), a mapping from names, or an ImpulsiveSmooth with n rows (N, N m).
        static_force: constant vector (n,) of rest lengths and weights, in addition to the force. Its potential counts in the
            energy, as that of a constant force does.
        units: of each coordinate, "m" or "rad", by name or in order; "m" by default.
        energy_parts: M and K as sums of named parts, for the energy shares of modes; by coordinate by default. Arrays only.
        uncertainty: bounds of the errors of "mass", "damping", "stiffness", arrays (n, n) by these names, for matrices that are
            measured or computed; rounding errors by default. Arrays only.
        gyroscopic, circulatory: G and N of a rotor, shape (n, n): C + W G (kg m^2) and K + W N (N s/m) at W in rad/s; the system
            itself is the rotor at rest (``at_speed``, ``campbell``, ``critical_speeds``). Arrays only.

    Raises:
        InputError: shapes that do not match, entries that are not finite, repeated names, an argument for arrays only.
        ContradictoryConstraints: dependent rows with different values.

    Attributes:
        is_sparse: whether one of the matrices is ``scipy.sparse``; all are compressed by columns (csc) then.
        pencil: the matrices on the free coordinates of a system of sparse matrices; None for arrays.
        given: K, C, M as they were given, each a matrix or its elements.
        static_force: the constant part of the force, shape (n,).
        excitation: the part of the force that varies in time; None if there is none.
        origin: the lumped model that it was assembled from, which has its drawing; None if there is none.

    >>> pair = MechanicalSystem(np.diag([1.0, 3.0]), constraints=[Constraint([1, -1])], names=["a", "b"])
    >>> pair.acceleration([0, 0], [0, 0], [8.0, 0.0])
    array([2., 2.])

    A chain of 1000 unit masses between two walls, natural frequencies 2 sin(i pi / (2 (n + 1))):

    >>> K = scipy.sparse.diags_array([-np.ones(999), 2 * np.ones(1000), -np.ones(999)], offsets=[-1, 0, 1])
    >>> modes = MechanicalSystem(scipy.sparse.eye_array(1000), stiffness=K).modes(count=10)
    >>> bool(np.allclose(modes.natural_frequencies, 2 * np.sin(np.arange(1, 11) * np.pi / 2002), rtol=1e-9)), modes.none_missed
    (True, True)
    """

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
    ):
        self.is_sparse = any(map(scipy.sparse.issparse, (mass, damping, stiffness)))
        self.mass = self._matrix(mass, "mass", None)
        self.damping = self._matrix(damping, "damping", self.size)
        self.stiffness = self._matrix(stiffness, "stiffness", self.size)
        given = zip((stiffness, damping, mass), (self.stiffness, self.damping, self.mass))
        self.given = tuple(value if isinstance(value, ElementMatrix) else matrix for value, matrix in given)
        self.names = names_of(names, self.size, "coordinates", "x")
        self.units = coordinate_units(units, self.names)
        self.gyroscopic = None if gyroscopic is None else self._matrix(gyroscopic, "gyroscopic", self.size)
        self.circulatory = None if circulatory is None else self._matrix(circulatory, "circulatory", self.size)
        self.constraints = checked_constraints(constraints, self.names)
        if self.is_sparse:
            of_arrays = {
                "energy_parts": energy_parts,
                "uncertainty": uncertainty,
                "gyroscopic": gyroscopic,
                "circulatory": circulatory,
            }
            for name in (name for name, value in of_arrays.items() if value is not None):
                self._refuse_sparse(name)
            self.pencil: ReducedPencil | None = self._reduced_pencil()
        else:
            self.pencil = None
            self._named_parts = None if energy_parts is None else checked_parts(energy_parts, self.size)
            self.uncertainty = self._uncertainty(uncertainty or {})
            self._independent = self._independent_rows()
        self._forms: dict[tuple[int, ...], ConstrainedForm] = {}
        self.origin: Any = None
        varies = isinstance(force, ImpulsiveSmooth)
        self.excitation = self._signal(force) if varies else None
        self.static_force = self._vector(static_force, "static_force") + self._vector(None if varies else force, "force")
        self.static_force.flags.writeable = False

    def with_constraints(self, *constraints: Constraint) -> Self:
        """The same system with further constraint rows.

        Args:
            constraints: rows for its n coordinates.

        Returns:
            A system of the same class.

        Raises:
            InputError: rows of another length, names in use.
            ContradictoryConstraints: dependent rows with different values.

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
        with short_work(2 * self.size):
            return independent_rows(constraint_rows(self.constraints, self.units), self.size)

    @property
    def size(self) -> int:
        """The number n of coordinates."""
        return self.mass.shape[0]

    @cached_property
    def energy_parts(self) -> EnergyParts:
        """M and K as sums of named parts; by default one part per coordinate."""
        self._refuse_sparse("energy_parts")
        stiffness, _, mass = self.given
        return self._named_parts or coordinate_parts(self.names, mass, stiffness)

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
        """An unsymmetric mass matrix, and each constraint row that others imply, or that is kept by a narrow margin."""
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
                NoticeKind.UNSYMMETRIC, f"the {name} matrix is not symmetric: {entries}; no elastic or inertial force is so"
            )

    def damping_notices(self, moving: bool | None = None) -> tuple[Notice, ...]:
        """Which velocity mass-proportional damping acts on, where supports move; by default those with a prescribed motion."""
        moving = not self.is_sparse and any(row.signal is not None for row in self.rows) if moving is None else moving
        if self.mass_damping is None or not moving:
            return ()
        text = {
            "absolute": "absolute velocities: it resists the motion of the supports, too; relative = true makes it act on the relative ones",
            "relative": "velocities relative to the static response to the motion of the supports",
        }[self.mass_damping]
        return (Notice(NoticeKind.DAMPING, f"the mass-proportional part of the Rayleigh damping acts on {text}"),)

    def range_notices(self, motion: Motion) -> tuple[Notice, ...]:
        """A notice on a motion beyond the range in which linear equations represent the model; none of a linear model."""
        return ()

    def constrained_form(self) -> ConstrainedForm:
        """[V^T (M s^2 + C s + K); A s^level] with every row at its level.

        Raises:
            InputError: the matrices are sparse.
        """
        self._refuse_sparse("constrained_form")
        return self._form(*(row.order for row in self.rows))

    def position_form(self) -> ConstrainedForm:
        """[V^T (M s^2 + C s + K); A], every row at position level: the same motions without the drift."""
        return self._form(*(0 for _ in self.rows))

    def _form(self, *orders: int) -> ConstrainedForm:
        """With rows of these derivatives, computed once."""
        if orders not in self._forms:
            with short_work(2 * self.size):
                self._forms[orders] = constrained_form(self.given, self.uncertainty, self._independent, self.names, orders)
        return self._forms[orders]

    def polynomial_matrix(self) -> PolynomialMatrix:
        """A(s) of the constrained form, degree 2, size n."""
        return self.constrained_form().polynomial_matrix

    def solve(
        self,
        displacement=None,
        velocity=None,
        force=None,
        rank_tolerance: float | None = None,
        count: int | None = None,
        *,
        evaluations: Evaluations = "once",
    ) -> Motion | Any:
        """The motion from any values at 0-, in closed form.

        Inconsistent values are not repaired: the motion reports the jumps and impulses that they cause. Of sparse matrices

            x = sum of modes + X_f e^{J t} v + rest,

        where the second part follows the force and is exact, and the rest, free motion of the other modes, is bounded for all
        times by its energy at the start.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,), or a mapping from names to numbers, zero for the others. Of
                shape (S, n): S motions at once; what is given only once is common to them.
            force: f in addition to the system's own, as an ImpulsiveSmooth with n rows or a constant vector; or S of them.
            rank_tolerance: see ``mbconstrained.solve``. Arrays only.
            count: the number of modes of lowest frequency in the motion, 50 by default. Sparse matrices only.
            evaluations: see ``mbconstrained.solve``; the motion of sparse matrices is always evaluated by its modes.

        Returns:
            A ``Motion``; ``Motions`` of S initial values or forces; a ``SparseMotion`` of sparse matrices.

        Raises:
            InputError: unknown names, shapes that do not match; of sparse matrices values at 0- that violate constraints,
                Dirac impulses, several motions.
            SingularPolynomialMatrix: the motion is not determined; the text names equations and coordinates.

        >>> spring = MechanicalSystem([[1.0]], stiffness=[[4.0]])
        >>> bool(np.isclose(spring.solve([1.0])(0.5)[0], np.cos(1.0)))
        True
        """
        self._refuse_loss_factors()
        request = Request(evaluations)
        several_forces = is_table(force) or (
            isinstance(force, (list, tuple)) and any(isinstance(f, ImpulsiveSmooth) for f in force)
        )
        several = several_forces or is_table(displacement) or is_table(velocity)
        if self.is_sparse:
            from .sparse.sparse_motion import sparse_motion

            if several or rank_tolerance is not None:
                self._refuse_sparse("several motions" if several else "rank_tolerance")
            return sparse_motion(self, self._start(displacement, velocity), self._applied(force), _mode_count(count))
        if count is not None:
            raise InputError("count: the motion of a system given by arrays has all its modes; leave count out")
        if several:
            from .motions import motions_of

            forces = list(force) if several_forces else [force]
            applied = {id(one): self._applied(one) for one in forces}
            forces = [applied[id(one)] for one in forces]
            return motions_of(self, displacement, velocity, forces, rank_tolerance, request)
        return Motion.started(self, self._start(displacement, velocity), self._applied(force), rank_tolerance, request)

    def modes(self, count: int | None = None, damped: bool = True) -> Modes:
        """The finite eigenvalues of A(s) with their shapes and meaning: oscillation, decay, rigid body, drift, ...

        Of arrays all of them from the Jordan pairs of A(s). Of sparse matrices those of lowest frequency, by shift-invert Lanczos
        and Sylvester's law of inertia, which counts them; damped ones by Newton's method from these (``mechanics.sparse``).

        Args:
            count: the number of modes of lowest frequency; a complex pair counts once. By default all, of sparse matrices 50.
            damped: False for the modes without the damping C.

        Returns:
            The modes, ascending by modulus, after those of eigenvalue 0.

        Raises:
            InputError: a count below one; negative stiffness of a massless coordinate of sparse matrices.
            SingularPolynomialMatrix: the motion is not determined, coordinates have neither mass nor stiffness.

        >>> chain = MechanicalSystem(np.eye(2), 0.1 * np.eye(2), [[2.0, -1.0], [-1.0, 2.0]])
        >>> chain.modes().natural_frequencies.round(6), chain.modes(count=1).damping_ratios.round(6)
        (array([1.      , 1.732051]), array([0.05]))
        """
        if self.is_sparse:
            from .sparse.sparse_modes import sparse_modes

            return sparse_modes(self.pencil, _mode_count(count), damped and bool(self.damping.nnz))
        undamped = None if damped else MechanicalSystem(self.given[2], None, self.given[0], self.constraints, self.names)
        modes = replace(modes_of(undamped or self), system=undamped or self)
        return modes if count is None else modes.lowest(count)

    frequency_response = frequency_response
    steady_state = steady_state

    def acceleration(self, displacement, velocity, force=None, time: float = 0.0) -> np.ndarray:
        """x'' at a given state, shape (n,), by the explicit formula of Udwadia and Phohomsiri (``mechanics.constrained_form``).

        Args:
            displacement, velocity: x and x', shape (n,) or by name. Rows at position and velocity level enter by their
                derivative, A x'' = 0 where b is constant, also where the state violates them.
            force: f in addition to the system's own at that time, a constant vector (n,) or by name.
            time: of the system's own force and prescribed motions (s).

        Returns:
            Shape (n,), in m/s^2 or rad/s^2.

        Raises:
            InputError: the matrices are sparse; shapes that do not match.
            NotUnique: rank [M; A] < n, masses and constraints alone do not determine the acceleration.
        """
        self._refuse_sparse("acceleration")
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
            from .sparse.sparse_matrices import square_sparse

            return square_sparse(value.matrix if isinstance(value, ElementMatrix) else value, what, size)
        matrix = np.zeros((size, size)) if value is None else value.matrix if isinstance(value, ElementMatrix) else value
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
        applied = self.force(real_number(time, "time", minimum=0.0)) + self._vector(force, "force")
        x, v = self._start(displacement, velocity)
        return self.damping @ v + self.stiffness @ x - applied

    def _applied(self, force) -> ImpulsiveSmooth:
        """The system's own force and another, as a function of time or a constant vector."""
        if force is None:
            return self.force
        return self.force + self._signal(force if isinstance(force, ImpulsiveSmooth) else step(self._vector(force, "force")))

    def _signal(self, signal: ImpulsiveSmooth) -> ImpulsiveSmooth:
        if signal.size != self.size:
            raise InputError(f"force: it has {signal.size} rows; expected one for each of the {self.size} coordinates")
        return signal

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
        """Of K, C and M."""
        known, shape = ("stiffness", "damping", "mass"), (self.size, self.size)
        for name in given:
            if name not in known:
                raise InputError(f"uncertainty: found {name!r}{nearest(str(name), known)}; expected {', '.join(known)}")
        bounds = {name: np.abs(real_array(value, f"uncertainty of the {name}", shape=shape)) for name, value in given.items()}
        return tuple(bounds.get(name, constant_zeros(shape)) for name in known)


MechanicalSystem.base_class = MechanicalSystem


def _mode_count(count) -> int:
    return DEFAULT_MODE_COUNT if count is None else whole_number(count, "count", minimum=1)
