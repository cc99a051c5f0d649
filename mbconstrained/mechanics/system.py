"""M x'' + C x' + K x = f with constraint rows: the box between models and mathematics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

from ..checks import constant_zeros, counted, names_of, nearest, real_array, real_number
from ..errors import InputError
from ..linalg.threads import short_work
from ..notices import Notice
from ..polynomial.matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth
from .acceleration import explicit_acceleration
from .constrained_form import ConstrainedForm, constrained_form
from .constraint import Constraint, ConstraintRow, constraint_rows
from .element_matrix import ElementMatrix
from .energy_parts import EnergyParts, coordinate_parts
from .independence import independent_rows
from .loads import Loaded
from .modes import Modes, modes_of
from .motion import Motion, motion_of
from .units import coordinate_units

if TYPE_CHECKING:
    from .motions import Motions


class MechanicalSystem(Loaded):
    """M x'' + C x' + K x = f + A^T lambda with the constraint rows A x^(level) = b (SI units, t in s).

    Where a matrix is given as ``scipy.sparse``, a ``SparseSystem`` is made instead: the same words, for what is large.

    Args:
        mass: M, shape (n, n), possibly singular (kg, kg m^2). This one and the next two may be given as ``ElementMatrix``:
            where their elements differ by many orders of magnitude, none is lost.
        damping: C, shape (n, n) (N s/m); zero when not given.
        stiffness: K, shape (n, n) (N/m); zero when not given.
        constraints: any number of ``Constraint``; dependent rows are taken out and reported in ``notices``.
        names: of the n coordinates, x1, x2, ... when not given.
        force: what acts from t = 0 on: a constant vector (n,) or an ImpulsiveSmooth with n rows (N, N m).
        static_force: constant vector (n,) of rest lengths and weights, in addition to the force. It has a
            potential, which is counted in the energy, as that of a constant force is.
        units: unit of each coordinate, "m" or "rad", by name or in order; "m" when not given.
        energy_parts: M and K as sums of named parts, by which the energy of modes is shared out; coordinate by coordinate
            when not given.
        uncertainty: by how much entries of "mass", "damping", "stiffness" may be wrong, arrays (n, n) by these names, where
            that is more than rounding: what is measured or computed is not known to the last digit.

    Raises:
        InputError: shapes that do not fit, entries that are not finite, names used twice.
        ContradictoryConstraints: dependent rows that ask for different values.

    Attributes:
        given: K, C, M as they were given, each a matrix or its elements.

    >>> pair = MechanicalSystem(np.diag([1.0, 3.0]), constraints=[Constraint([1, -1])], names=["a", "b"])
    >>> pair.acceleration([0, 0], [0, 0], [8.0, 0.0])
    array([2., 2.])
    """

    def __new__(cls, mass=None, damping=None, stiffness=None, *args, **options):
        """A SparseSystem where one of the matrices is sparse."""
        if cls is MechanicalSystem and any(map(scipy.sparse.issparse, (mass, damping, stiffness))):
            from .sparse import SparseSystem

            return SparseSystem(mass, damping, stiffness, *args, **options)
        return super().__new__(cls)

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
    ):
        self.mass = _square(mass, "mass", None)
        self.damping = _square(damping, "damping", self.size)
        self.stiffness = _square(stiffness, "stiffness", self.size)
        given = zip((stiffness, damping, mass), (self.stiffness, self.damping, self.mass))
        self.given = tuple(value if isinstance(value, ElementMatrix) else matrix for value, matrix in given)
        self.names = names_of(names, self.size, "coordinates", "x")
        self.units = coordinate_units(units, self.names)
        self._named_parts = None if energy_parts is None else self._checked_parts(energy_parts)
        self.uncertainty = self._uncertainty(uncertainty or {})
        self.constraints = (constraints,) if isinstance(constraints, Constraint) else tuple(constraints or ())
        with short_work(2 * self.size):
            self._independent = independent_rows(constraint_rows(self.constraints, self.units), self.size)
        self._load(force, static_force)

    @property
    def size(self) -> int:
        """The number n of coordinates."""
        return len(self.mass)

    @cached_property
    def energy_parts(self) -> EnergyParts:
        """M and K as sums of named parts, those of the coordinates when not given."""
        stiffness, _, mass = self.given
        return self._named_parts or coordinate_parts(self.names, mass, stiffness)

    @property
    def rows(self) -> tuple[ConstraintRow, ...]:
        """The independent constraint rows, strongest level first; multipliers come in this order."""
        return self._independent.rows

    @property
    def constraint_matrix(self) -> np.ndarray:
        """A, the coefficients of the independent rows, shape (k, n)."""
        return self._independent.matrix

    @property
    def multiplier_map(self) -> np.ndarray:
        """G with G A^T = I, shape (k, n): the multipliers of a constraint force A^T lambda."""
        return self._independent.left_inverse

    @property
    def notices(self) -> tuple[Notice, ...]:
        """One notice for each constraint row that was left out because others imply it, or kept by a narrow margin."""
        return self._independent.notices

    def constrained_form(self) -> ConstrainedForm:
        """[V^T (M s^2 + C s + K); A s^level] with every row at its level."""
        return self._constrained_form

    @cached_property
    def _constrained_form(self) -> ConstrainedForm:
        return self._form([row.order for row in self.rows])

    def position_form(self) -> ConstrainedForm:
        """[V^T (M s^2 + C s + K); A], every row at position level: the same motions without the drift."""
        return self._position_form

    @cached_property
    def _position_form(self) -> ConstrainedForm:
        held = any(row.order for row in self.rows)
        return self._form([0] * len(self.rows)) if held else self._constrained_form

    def _form(self, orders) -> ConstrainedForm:
        with short_work(2 * self.size):
            return constrained_form(self.given, self.uncertainty, self._independent, self.names, orders)

    def polynomial_matrix(self) -> PolynomialMatrix:
        """A(s) of the constrained form, degree 2, size n."""
        return self.constrained_form().polynomial_matrix

    def solve(self, displacement=None, velocity=None, force=None, rank_tolerance: float | None = None) -> Motion | Motions:
        """The motion from any values at 0-, in closed form.

        Values that do not fit are not repaired: the motion tells the jumps and impulses that they cause.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,), or a mapping from names to numbers, zero for the others. Of
                shape (S, n): S motions at once; what is given only once is common to them.
            force: f in addition to the system's own, as an ImpulsiveSmooth with n rows or a constant vector; or S of them.
            rank_tolerance: see ``mbconstrained.solve``.

        Returns:
            A ``Motion``; of S starts or forces ``Motions``, which are evaluated together.

        Raises:
            InputError: unknown names, shapes that do not fit.
            SingularPolynomialMatrix: the motion is not determined; the text names equations and coordinates.

        >>> spring = MechanicalSystem([[1.0]], stiffness=[[4.0]])
        >>> bool(np.isclose(spring.solve([1.0])(0.5)[0], np.cos(1.0)))
        True
        """
        several_forces = _is_table(force) or (isinstance(force, (list, tuple)) and any(isinstance(f, ImpulsiveSmooth) for f in force))
        if several_forces or _is_table(displacement) or _is_table(velocity):
            from .motions import motions_of

            given = list(force) if several_forces else [force]
            applied = {id(one): self._applied(one) for one in given}
            forces = [applied[id(one)] for one in given]
            return motions_of(self, displacement, velocity, forces, rank_tolerance)
        start = np.array([self._vector(displacement, "displacement"), self._vector(velocity, "velocity")])
        return motion_of(self, start, self._applied(force), rank_tolerance)

    def modes(self, count: int | None = None) -> Modes:
        """The finite zeros of A(s), each with what it means: oscillation, decay, rigid body, drift ...; or the ``count`` lowest."""
        return modes_of(self) if count is None else modes_of(self).lowest(count)

    def acceleration(self, displacement, velocity, force=None, time: float = 0.0) -> np.ndarray:
        """x'' at a given state, shape (n,), by the explicit formula of Udwadia and Phohomsiri (``mechanics.acceleration``).

        Args:
            displacement, velocity: x and x', shape (n,) or by name. Rows at position and velocity level enter as
                A x'' = 0, whether or not the state obeys them.
            force: f in addition to the system's own at that time, a constant vector (n,) or by name.
            time: when, for the system's own force (s).

        Raises:
            NotUnique: rank [M; A] < n, the acceleration is not determined by the masses and constraints alone.
        """
        load = -self._resistance(displacement, velocity, force, time)
        values = np.array([row.value if row.level == "acceleration" else 0.0 for row in self.rows])
        return explicit_acceleration(self.mass, self._independent, load, values, self.names)

    def constraint_force(self, displacement, velocity, force=None, time: float = 0.0) -> np.ndarray:
        """f_c = M x'' + C x' + K x - f = A^T lambda at a given state, shape (n,); arguments as in ``acceleration``."""
        acceleration = self.acceleration(displacement, velocity, force, time)
        return self.mass @ acceleration + self._resistance(displacement, velocity, force, time)

    def __repr__(self) -> str:
        held = ", ".join(f"{row.name}: {row.level}" for row in self.rows)
        count = f"{self.size} coordinate{'s' if self.size != 1 else ''}"
        return f"MechanicalSystem({count}{', rows held: ' + held if held else ''})"

    def _resistance(self, displacement, velocity, force, time) -> np.ndarray:
        """C x' + K x - f."""
        applied = self.force(real_number(time, "time", minimum=0.0)) + self._vector(force, "force")
        held = self.damping @ self._vector(velocity, "velocity") + self.stiffness @ self._vector(displacement, "displacement")
        return held - applied

    def _checked_parts(self, parts: EnergyParts) -> EnergyParts:
        if not isinstance(parts, EnergyParts) or parts.size not in (self.size, None):
            found = f"parts of {parts.size} coordinates" if isinstance(parts, EnergyParts) else f"a {type(parts).__name__}"
            raise InputError(f"energy_parts: found {found}; expected EnergyParts of {counted(self.size, 'coordinate')}")
        return parts

    def _uncertainty(self, given: Mapping) -> tuple[np.ndarray, ...]:
        """Of K, C and M."""
        known, shape = ("stiffness", "damping", "mass"), (self.size, self.size)
        for name in given:
            if name not in known:
                raise InputError(f"uncertainty: found {name!r}{nearest(str(name), known)}; expected {', '.join(known)}")
        found = {name: real_array(value, f"uncertainty of the {name}", shape=shape) for name, value in given.items()}
        nothing = constant_zeros(shape)
        return tuple(np.abs(found[name]) if name in found else nothing for name in known)


def _is_table(value) -> bool:
    """Whether it has a leading axis for several motions."""
    try:
        return np.ndim(value) == 2
    except ValueError:  # rows of different lengths, which is told later
        return False


def _square(value, what: str, size: int | None) -> np.ndarray:
    if value is None:
        if size is None:
            raise InputError("mass: a mechanical system needs a mass matrix (zeros for massless coordinates)")
        value = np.zeros((size, size))
    if isinstance(value, ElementMatrix):
        value = value.matrix
    matrix = real_array(value, what, shape=(size, size))
    if len(matrix) != matrix.shape[1]:
        raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    if not len(matrix):
        raise InputError(f"{what}: found no entries; a mechanical system needs at least one coordinate")
    matrix.flags.writeable = False
    return matrix
