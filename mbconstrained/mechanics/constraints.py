"""Constraint rows A x^(level) = b(t): a combination of coordinates or of their derivatives has a given value, a constant or a signal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from typing import Literal

import numpy as np
import scipy

from ..ground.by_name import Public, answering
from ..ground.checks import is_sparse, names_of, nearest, real_array
from ..ground.errors import ContradictoryConstraints, InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import CLEAR_KEPT, DOUBTFUL_SUM, EPS, NOISE_SAFETY, NULL_SPACE_LIMIT, noise_of
from ..ground.units import check_unit, rate_unit
from ..linalg.arrays import full, others
from ..linalg.division import solution
from ..linalg.rank import Noisy, reduce_in_order
from ..linalg.scaling import equilibration
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import step

Level = Literal["position", "velocity", "acceleration"]

#: The accepted forms of constraints, for messages.
EXPECTED = "mb.Constraint(rows, ...), a sparse matrix of rows that are zero, or a list of these"

#: Number of coordinates listed in a message.
MOST_NAMES = 12

#: The levels, strongest first; the place of a level is the order of its derivative.
LEVELS: tuple[Level, ...] = ("position", "velocity", "acceleration")


@answering
class Constraint(Public):
    """The rows A x^(level) = b(t) of one constraint, b a constant or a signal for t > 0 (a prescribed motion).

    Args:
        rows: A, shape (k, n), or (n,) for a single row; kept sparse where it is ``scipy.sparse``.
        level: the constrained derivative: "position" A x = b, "velocity" A x' = b, or "acceleration" A x'' = b
            (the form of Udwadia and Phohomsiri 2006). The stronger level implies the weaker one with the derivative of b; a
            weaker level keeps an initial violation of the stronger one, and adds drift eigenvalues.
        value: b, a number or shape (k,), or a signal such as ``mb.harmonic`` and ``mb.sampled`` with k rows, or one for all.
            A step in b at position level is a jump of the state with impulses in the reactions.
        names: one name per row; "constraint 1", ... by default.
        unit: unit of A x, "m" or "rad" ("1" for none), from which multipliers have theirs. By default that of the
            coordinates in the row, metres where both kinds meet (a radius turns angles into lengths).
        uncertainty: bounds of the errors of A, shape of the rows; rounding errors by default.

    Raises:
        InputError: rows that are no matrix of finite real numbers, an unknown level, values of another number.

    >>> Constraint([1, -1, 0], level="velocity", value=0.5)
    Constraint(1 row at velocity level)

    A support that moves as 0.1 sin(3 t), in m:

    >>> from mbconstrained import harmonic
    >>> Constraint([1, 0], value=harmonic([0.1], angular_frequency=3.0, phase=-np.pi / 2), names="base")
    Constraint(1 row at position level)
    """

    def __init__(
        self,
        rows,
        level: Level = "position",
        value=0.0,
        names: Sequence[str] | str | None = None,
        unit: str | None = None,
        uncertainty=None,
    ):
        if isinstance(rows, Mapping):
            by_name = 'by name a row is added to a lumped model: model.constrain({"cart": 1, "hook": -1})'
            raise InputError(
                f"constraint rows: found {rows!r}; expected the factors of all coordinates, such as [1, -1]; {by_name}"
            )
        matrix = _sparse_rows(rows) if is_sparse(rows) else real_array(rows, "constraint rows")
        if matrix.ndim not in (1, 2):
            raise InputError(f"constraint rows: expected one row or a matrix, found an array of shape {matrix.shape}")
        self.rows = matrix if is_sparse(matrix) else np.atleast_2d(matrix)
        self.level = checked_level(level, "constraint")
        self.signal = value if isinstance(value, ImpulsiveSmooth) else None
        if self.signal is not None and self.signal.size not in (1, self.rows.shape[0]):
            raise InputError(
                f"constraint value: found a signal with {self.signal.size} rows; expected one row, or one for each of the "
                f"{self.rows.shape[0]} rows"
            )
        values = real_array(0.0 if self.signal is not None else value, "constraint value")
        if values.ndim > 1 or (values.ndim == 1 and len(values) != self.rows.shape[0]):
            raise InputError(
                f"constraint value: found shape {values.shape}; expected a number, or one for each of the {self.rows.shape[0]} rows"
            )
        self.values = values + np.zeros(self.rows.shape[0])
        if isinstance(names, str):
            names = (names,)
        self.names = None if names is None else names_of(names, self.rows.shape[0], "constraint rows", "")
        self.unit = unit if unit is None else check_unit(unit, "unit of the constraint")
        if uncertainty is None:
            self.uncertainty = abs(0.0 * self.rows)
        else:
            self.uncertainty = np.abs(np.atleast_2d(real_array(uncertainty, "constraint uncertainty", shape=matrix.shape)))
        self.values.flags.writeable = False
        if not is_sparse(self.rows):
            self.rows.flags.writeable = False

    def __repr__(self) -> str:
        count = self.rows.shape[0]
        return f"Constraint({count} row{'s' if count != 1 else ''} at {self.level} level)"


@dataclass(frozen=True, eq=False)
class ConstraintRow(Public):
    """One row a x^(level) = value + signal(t) of a system."""

    name: str  # its name
    coefficients: np.ndarray = field(repr=False)  # a, shape (n,)
    level: Level  # "position", "velocity" or "acceleration"
    value: float  # the constant part of the right-hand side b
    unit: str  # unit of a x, "m", "rad" or "1"
    # bounds of the errors of a beyond rounding, shape (n,) or one number
    uncertainty: np.ndarray | float = field(default=0.0, repr=False)
    # the part of b that varies in time, one row; None where b is constant
    signal: ImpulsiveSmooth | None = field(default=None, repr=False)

    def right_side(self, order: int) -> BohlFunction:
        """The right-hand side for a x^(order), t > 0, the order at least that of the row: a derivative of b."""
        constant = step([self.value if order == self.order else 0.0]).smooth
        return constant if self.signal is None else constant + self.signal.derivative(order - self.order)

    def constraint(self) -> Constraint:
        doubt = np.atleast_2d(self.uncertainty + np.zeros(len(self.coefficients)))
        value = self.value if self.signal is None else self.signal
        return Constraint(np.atleast_2d(self.coefficients), self.level, value, self.name, self.unit, doubt)

    @property
    def order(self) -> int:
        """Order of the constrained derivative: 0, 1 or 2."""
        return LEVELS.index(self.level)

    @property
    def right_side_text(self) -> str:
        """b with its unit; "prescribed, in m" where it varies in time."""
        unit = rate_unit(self.unit, self.order)
        return f"{self.value:.6g} {unit}" if self.signal is None else f"prescribed, in {unit}"


def checked_level(level, what: str) -> Level:
    """A known level, or an InputError with the nearest one."""
    if level not in LEVELS:
        raise InputError(f"{what}: found the level {level!r}; expected one of {', '.join(LEVELS)}{nearest(level, LEVELS)}")
    return level


def checked_constraints(given, names: Sequence[str]) -> tuple[Constraint, ...]:
    """The constraints of a system with these coordinates; a sparse matrix stands for rows that are zero at position level."""
    if given is None or isinstance(given, Constraint) or is_sparse(given):
        given = () if given is None else (given,)
    if isinstance(given, (str, bytes, np.ndarray)) or not isinstance(given, Sequence):
        raise InputError(f"constraints: found {type(given).__name__}; expected {EXPECTED}")
    constraints = tuple(Constraint(item) if is_sparse(item) else item for item in given)
    for constraint in constraints:
        if not isinstance(constraint, Constraint):
            raise InputError(f"constraints: found {type(constraint).__name__}; expected {EXPECTED}")
        if constraint.rows.shape[1] != len(names):
            listed = f" ({', '.join(names)})" if len(names) <= MOST_NAMES else ""
            raise InputError(
                f"constraint rows: found {constraint.rows.shape[1]} entries in a row; expected one for each of the "
                f"{len(names)} coordinates{listed}"
            )
    return constraints


def row_names(constraints: Sequence[Constraint]) -> tuple[str, ...]:
    """A name for each row of the constraints, "constraint 1" and so on by default."""
    names: list[str] = []
    for constraint in constraints:
        count = constraint.rows.shape[0]
        names += constraint.names or [f"constraint {len(names) + i + 1}" for i in range(count)]
    return names_of(names, len(names), "constraint rows", "")


def constraint_rows(constraints: Sequence[Constraint], units: dict[str, str]) -> tuple[ConstraintRow, ...]:
    """All rows of the constraints of a system whose coordinates have these units."""
    rows: list[ConstraintRow] = []
    names, each = row_names(constraints), tuple(units.values())
    for constraint in constraints:
        given = zip(full(constraint.rows), constraint.values, full(constraint.uncertainty))
        for place, (coefficients, value, uncertainty) in enumerate(given):
            unit, name = constraint.unit or _unit(coefficients, each), names[len(rows)]
            signal = constraint.signal
            if signal is not None and signal.size != 1:
                signal = signal.mapped(np.eye(1, signal.size, place))
            rows.append(ConstraintRow(name, coefficients, constraint.level, float(value), unit, uncertainty, signal))
    return tuple(rows)


def right_sides(rows: Sequence[ConstraintRow]) -> ImpulsiveSmooth | None:
    """The parts of b that vary in time, one row for each of the k rows; None where b is constant."""
    varying = [row.signal.mapped(np.eye(len(rows), 1, -place)) for place, row in enumerate(rows) if row.signal is not None]
    return sum(varying[1:], varying[0]) if varying else None


def with_right_sides(force: ImpulsiveSmooth, rows: Sequence[ConstraintRow]) -> ImpulsiveSmooth:
    """[f; b]: the force, n rows, and the right-hand sides of the k rows."""
    n, k = force.size, len(rows)
    result, values = force.mapped(np.eye(n + k)[:, :n]), np.array([row.value for row in rows])
    if values.any():
        result = result + step(np.append(np.zeros(n), values))
    varying = right_sides(rows)
    return result if varying is None else result + varying.mapped(np.eye(n + k)[:, n:])


def with_multipliers(matrices: Sequence[np.ndarray], rows: np.ndarray, orders: Sequence[int], sign: int = -1) -> list[np.ndarray]:
    """[M s^2 + C s + K, sign A^T; A s^order, 0] from K, C, M: each row in the matrix of its order, the forces of the rows next to K."""
    k, n = rows.shape
    stacked = [np.pad(matrix, (0, k)) for matrix in matrices]
    stacked[0][:n, n:] = sign * rows.T
    for place, order in enumerate(orders, n):
        stacked[order][place, :n] = rows[place - n]
    return stacked


def _unit(coefficients, units) -> str:
    present = {units[place] for place in coefficients.nonzero()[0]}
    if len(present) == 1:
        return present.pop()
    return "m" if "m" in present else "1"


def _sparse_rows(rows) -> scipy.sparse.csr_array:
    """Sparse rows of finite real numbers, as a matrix."""
    matrix = scipy.sparse.csr_array(rows if rows.ndim == 2 else rows.reshape((1, -1)))
    entries = real_array(matrix.data, "constraint rows")
    return scipy.sparse.csr_array((entries, matrix.indices, matrix.indptr), shape=matrix.shape)


# Independent rows. The rows are reduced strongest level first, so that of rows that coincide the strongest is kept. A row at
# position level implies that the derivatives of a x are zero: only kept rows of its own level contribute to the value that is
# implied for a dependent row.


@dataclass(frozen=True, eq=False)
class IndependentRows:
    """The independent constraint rows of a system with n coordinates, and what they leave free."""

    rows: tuple[ConstraintRow, ...]  # the k independent rows, strongest level first
    matrix: np.ndarray  # A, their coefficients, shape (k, n)
    uncertainty: np.ndarray  # bounds of their errors beyond rounding, shape (k, n)
    null_space: np.ndarray  # V, a basis of null(A), shape (n, n - k)
    motions: tuple[int | None, ...]  # the coordinate that each column of V moves, None where it mixes several
    pivots: tuple[int, ...]  # columns in which A is regular, shape (k,)
    notices: tuple[Notice, ...]  # one for each dependent row, and for each that is kept by a narrow margin

    @cached_property
    def left_inverse(self) -> np.ndarray:
        """G with G A^T = I, shape (k, n): turns a constraint force A^T lambda into lambda."""
        inverse, pivots = np.zeros(self.matrix.shape), list(self.pivots)
        inverse[:, pivots] = solution(self.matrix[:, pivots], np.eye(len(pivots))).T
        return inverse


def independent_rows(rows: Sequence[ConstraintRow], size: int) -> IndependentRows:
    """The rows without dependent ones, and the null space of their matrix."""
    if not rows:
        none = np.zeros((0, size))
        return IndependentRows((), none, none, np.eye(size), tuple(range(size)), (), ())
    rows = sorted(rows, key=lambda row: row.order)
    matrix = np.array([row.coefficients for row in rows])
    uncertainty = np.array([row.uncertainty + np.zeros(size) for row in rows])
    scale = equilibration(np.abs(matrix))[1]
    noise = np.maximum(EPS * np.abs(matrix), uncertainty) * scale
    attached = Noisy.exact(np.zeros((len(rows), len(LEVELS) + len(rows))))  # the value of each level, and the factors of the rows
    for place, row in enumerate(rows):
        attached.data[place, row.order], attached.noise[place, row.order] = row.value, EPS * abs(row.value)
        attached.data[place, len(LEVELS) + place] = 1.0
    reduced = Noisy(np.hstack([matrix * scale, attached.data]), np.hstack([noise, attached.noise]))
    kept, pivots = reduce_in_order(reduced, size)
    own = reduced[kept]
    margins = own.size[range(len(kept)), pivots] / (NOISE_SAFETY * own.noise[range(len(kept)), pivots])
    notices = [_redundant(rows, place, reduced.data[place, size:]) for place in range(len(rows)) if place not in kept]
    for place, margin in zip(kept, margins):
        if margin < CLEAR_KEPT:
            text = (
                f'constraint "{rows[place].name}" ({rows[place].level} level) is almost a combination of other rows: the rest of it is only '
                f"{margin:.3g} times its rounding error; it was kept"
            )
            notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    null_space, motions = _null_space(own.data[:, :size], pivots, scale)
    independent = tuple(rows[place] for place in kept)
    return IndependentRows(independent, matrix[kept], uncertainty[kept], null_space, motions, tuple(pivots), tuple(notices))


def _null_space(reduced: np.ndarray, pivots: list[int], scale: np.ndarray) -> tuple[np.ndarray, tuple[int | None, ...]]:
    """V, shape (n, n - k), and the coordinate that each column moves, None where it mixes several.

    Rows of 0, 1, -1 and ratios of small whole numbers keep their exact zeros in the elimination, and so does [-X; I], X the reduced
    rows in scaled columns solved for the pivot coordinates.
    """
    size, free = len(scale), others(len(scale), pivots)
    solved = reduced[:, free]
    if solved.size:
        solved = np.linalg.solve(reduced[:, pivots], solved)  # of NumPy: a system is assembled without SciPy
    if np.abs(solved).max(initial=0.0) > NULL_SPACE_LIMIT:
        orthogonal = np.linalg.qr(reduced.T, mode="complete")[0]
        return scale[:, None] * orthogonal[:, len(pivots) :], (None,) * len(free)
    basis = np.zeros((size, len(free)))
    basis[pivots] = 0.0 - solved  # not -solved: no negative zeros
    basis[free, range(len(free))] = 1.0
    return scale[:, None] * basis / scale[free], tuple(free.tolist())


def _redundant(rows, place, rest) -> Notice:
    """The notice of a row that the rows before it imply, or the error where they imply another value."""
    row, levels = rows[place], len(LEVELS)
    others = [f'"{rows[i].name}" ({rows[i].level} level)' for i in np.flatnonzero(rest[levels:]) if i != place]
    reason = f"it follows from {' and '.join(others)}" if others else "all its coefficients are zero"
    difference = _difference(rows, place, rest[levels:])
    if difference is not None:
        raise ContradictoryConstraints(
            f'constraint "{row.name}" ({row.level} level) prescribes another motion than {" and ".join(others) or "none"}, '
            f"from which its left-hand side follows: {difference}; make the motions agree or take one of the rows out"
        )
    left_over = rest[row.order]
    if left_over:
        unit = rate_unit(row.unit, row.order)
        raise ContradictoryConstraints(
            f'constraint "{row.name}" ({row.level} level) has the value {row.value:.6g} {unit}, but {reason}, '
            f"with the value {row.value - left_over:.6g} {unit}; make the values agree or take one of the rows out"
        )
    nearly = _is_nearly_dependent(rows, rest[levels:])
    to_rounding = " to a rounding error, which is not zero" if nearly else ""
    return Notice(
        NoticeKind.REDUNDANT,
        f'constraint "{row.name}" ({row.level} level) is redundant and was left out: {reason}{to_rounding}; '
        "the multipliers are those of the independent rows",
        doubtful=nearly,
    )


def _difference(rows, place: int, factors: np.ndarray) -> str | None:
    """The first time at which the signal of a dependent row differs from that combination of the other signals; None without one.

    A Bohl function of s states is zero if its first s derivatives vanish at its start, and at each of its knots.
    """
    order = rows[place].order
    terms = [(factor, each) for factor, each in zip(factors, rows) if factor and each.order <= order and each.signal is not None]
    if not terms:
        return None
    knots = reduce(np.union1d, (each.signal.knots for _, each in terms))
    count = sum(each.signal.smooth.state_count for _, each in terms)
    for derivative in range(count):
        values = np.array([factor * each.signal.derivative(order - each.order + derivative)(knots)[0] for factor, each in terms])
        sizes = np.abs(values).sum(axis=0)
        wrong = np.abs(values.sum(axis=0)) > noise_of(sizes.max(), count)
        if wrong.any():
            time = knots[wrong.argmax()]
            what = "value" if not derivative else f"derivative of order {derivative}"
            value = rows[place].right_side(order + derivative)(time)[0]
            return f"at t = {time:.6g} s its {what} is {value:.6g} instead of {value - values.sum(axis=0)[wrong.argmax()]:.6g}"
    return None


def _is_nearly_dependent(rows, factors: np.ndarray) -> bool:
    """Whether a combination of rows with whole factors, which counts as zero, is more than the rounding errors of its terms."""
    whole = np.round(factors)
    if (np.abs(factors - whole) > CLEAR_KEPT * EPS).any() or any(np.any(row.uncertainty) for row in rows):
        return False
    terms = whole[:, None] * np.array([row.coefficients for row in rows], dtype=np.longdouble)
    return bool((np.abs(terms.sum(axis=0)) > DOUBTFUL_SUM[0] * EPS * np.abs(terms).sum(axis=0)).any())
