"""M x'' + C x' + K x = f + A^T lambda with A x = b for large sparse matrices, which never become dense ones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy.sparse

from ...checks import counted, names_of, nearest, whole_number
from ...errors import InputError
from ...notices import Notice
from ..loads import Loaded
from .finding import found_modes
from .matrices import sparse_matrix, symmetric
from .modes import SparseModes
from .motion import SparseMotion, sparse_motion
from .pencil import ReducedPencil, reduced_pencil
from .rows import held_rows
from .undamped import UndampedModes, undamped_modes


class SparseSystem(Loaded):
    """M x'' + C x' + K x = f + A^T lambda with A x = b, its matrices sparse and as large as memory for them allows.

    The words are those of ``MechanicalSystem``, which makes one of these when it is given a ``scipy.sparse`` matrix. All
    zeros of a system with 1e5 coordinates are out of reach: what can be had are the modes of lowest frequency, and the motion
    in them with a bound on what the others carry.

    Args:
        mass: M, sparse (n, n), symmetric, possibly singular: coordinates without mass (kg, kg m^2).
        damping: C, sparse (n, n); zero when not given (N s/m).
        stiffness: K, sparse (n, n), symmetric; zero when not given (N/m).
        constraints: a sparse matrix A of rows that are held at zero, shape (k, n), or a list of such and of
            ``Constraint`` at position level, whose rows may be sparse. Dependent rows are taken out and told.
        names: of the n coordinates, x1, x2, ... when not given.
        force: what acts from t = 0 on: a constant vector (n,), a mapping from names, or an ImpulsiveSmooth with n rows (N).
        static_force: constant vector (n,), in addition to the force.

    Raises:
        InputError: shapes that do not fit, entries that are not finite, rows at another level, names used twice.
        ContradictoryConstraints: dependent rows that ask for different values.

    >>> import scipy.sparse
    >>> n = 1000
    >>> K = scipy.sparse.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    >>> chain = SparseSystem(scipy.sparse.eye_array(n), stiffness=K)
    >>> modes = chain.modes(count=10)  # of a chain between two walls: 2 sin(i pi / (2 (n + 1)))
    >>> modes, bool(np.allclose(modes.angular_frequencies, 2 * np.sin(np.arange(1, 11) * np.pi / 2002), rtol=1e-9))
    (SparseModes(10 modes of 1000 coordinates, none missed), True)
    """

    def __init__(
        self,
        mass,
        damping=None,
        stiffness=None,
        constraints=(),
        names: Sequence[str] | None = None,
        force=None,
        static_force=None,
        **others,
    ):
        if given := [name for name, value in others.items() if value is not None]:
            known = ("mass", "damping", "stiffness", "constraints", "names", "force", "static_force")
            hint = nearest(given[0], known)
            raise InputError(f"{given[0]}: not known to a large sparse system{hint}; give arrays for it, or leave it out")
        self.mass = sparse_matrix(mass, "mass")
        self.damping = sparse_matrix(damping, "damping", self.size)
        self.stiffness = sparse_matrix(stiffness, "stiffness", self.size)
        self._given_names = None if names is None else names_of(names, self.size, "coordinates", "x")
        self._held = held_rows(constraints, self.size)
        self._pencil = reduced_pencil(
            symmetric(self.mass, "mass", self), self.damping, symmetric(self.stiffness, "stiffness", self), self._held, self.name
        )
        self._load(force, static_force)
        self._undamped: UndampedModes | None = None

    @property
    def size(self) -> int:
        """The number n of coordinates."""
        return self.mass.shape[0]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the coordinates."""
        return self._given_names or names_of(None, self.size, "coordinates", "x")

    def name(self, place: int) -> str:
        """Of one coordinate."""
        return self._given_names[place] if self._given_names else f"x{place + 1}"

    __getitem__ = name

    @property
    def pencil(self) -> ReducedPencil:
        """The matrices on the coordinates that the constraints leave free."""
        return self._pencil

    @property
    def constraint_matrix(self) -> scipy.sparse.csr_array:
        """A, all rows as given, shape (k, n)."""
        return self._held.matrix

    @property
    def constraint_values(self) -> np.ndarray:
        """b, shape (k,)."""
        return self._held.values

    @property
    def constraint_names(self) -> tuple[str, ...]:
        """One for each row."""
        return self._held.names

    @property
    def notices(self) -> tuple[Notice, ...]:
        """One for each constraint row that was left out because others imply it."""
        return self._pencil.notices

    def modes(self, count: int = 50, damped: bool | None = None) -> SparseModes:
        """The modes of lowest frequency, or all there are if these are fewer.

        Undamped ones by shift-invert Lanczos, counted by Sylvester's law of inertia; damped ones from these.
        Time and memory grow as the factors of K - s M do, in proportion to n for what is long rather than compact, and memory
        by some 4 ``count`` vectors of n numbers.

        Args:
            count: how many; of a complex pair the one above the real axis counts.
            damped: whether the zeros of s^2 M + s C + K are meant; with False those of s^2 M + K. As damping is given
                when not said.

        Raises:
            InputError: a count below one, negative stiffness of something massless.
            SingularPolynomialMatrix: neither mass nor stiffness holds some coordinates; the text names them.
        """
        damped = bool(self.damping.nnz) if damped is None else damped
        return found_modes(self, self.undamped(count), whole_number(count, "count", minimum=1), damped)

    def undamped(self, count: int) -> UndampedModes:
        """The undamped modes on the free coordinates, kept for the next question."""
        count = whole_number(count, "count", minimum=1)
        kept = self._undamped
        if kept is None or (len(kept.values) != count and not (kept.complete and len(kept.values) < count)):
            self._undamped = undamped_modes(self._pencil, count)
        return self._undamped

    def solve(self, displacement=None, velocity=None, force=None, count: int = 50) -> SparseMotion:
        """The motion from values at 0- in the ``count`` modes of lowest frequency, with the forced part of all others.

        x = sum of modes + X_f e^{J t} v + what is left out, where the second part moves with the force alone and is exact, and the
        third is free motion of the other modes: what it carries is bounded for all times by its energy when it begins.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,), or a mapping from names to numbers, zero for the others.
            force: f in addition to the system's own, as an ImpulsiveSmooth with n rows or a constant vector.
            count: how many modes.

        Raises:
            InputError: unknown names, shapes that do not fit, Dirac impulses, values that break the constraints.

        >>> import scipy.sparse
        >>> spring = SparseSystem(scipy.sparse.eye_array(1), stiffness=scipy.sparse.csr_array([[4.0]]))
        >>> motion = spring.solve([1.0])
        >>> bool(np.isclose(motion(0.5)[0], np.cos(1.0))), motion.truncation
        (True, 0.0)
        """
        start = np.array([self._vector(displacement, "displacement"), self._vector(velocity, "velocity")])
        return sparse_motion(self, start, self._applied(force), whole_number(count, "count", minimum=1))

    def __repr__(self) -> str:
        rows = self._held.matrix.shape[0]
        held = f", {counted(rows, 'row')} held" if rows else ""
        return f"SparseSystem({counted(self.size, 'coordinate')}{held})"

    def place(self, name, what: str) -> int:
        """The number of a coordinate given by name."""
        if self._given_names is None:
            number = str(name)[1:]
            if str(name)[:1] == "x" and number.isdecimal() and 1 <= int(number) <= self.size and str(int(number)) == number:
                return int(number) - 1
        elif name in self._places:
            return self._places[name]
        raise InputError(f'{what}: there is no coordinate "{name}"{nearest(name, self.names)}')

    @cached_property
    def _places(self) -> dict[str, int]:
        return {name: place for place, name in enumerate(self.names)}
