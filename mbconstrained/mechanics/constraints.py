"""Constraint rows A x^(level) = b(t), b a constant or a signal, and the constrained form [V^T (M s^2 + C s + K); A s^level] x = [V^T f; b].

V is a basis of null(A): multiplied by V^T the equations of motion lose the constraint forces A^T lambda, and
the constraint rows take the freed places (Antoniou et al. 2016; Moysis et al., Eqs. 79-82). M may be singular.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from typing import Literal

import numpy as np
import scipy

from ..ground.by_name import Public, answering
from ..ground.checks import counted, is_sparse, names_of, nearest, real_array
from ..ground.display import Displayed
from ..ground.errors import ContradictoryConstraints, IllConditioned, InputError, NotUnique
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    ASSEMBLED_SPREAD,
    CLEAR_KEPT,
    DOUBTFUL_SUM,
    EPS,
    LARGEST_SPREAD,
    NOISE_SAFETY,
    NULL_SPACE_LIMIT,
    noise_of,
)
from ..ground.units import check_unit, rate_unit
from ..linalg.arrays import block_diag, full, kept, others
from ..linalg.division import solution
from ..linalg.precise import is_worthwhile
from ..linalg.rank import Noisy, null_columns, reduce_in_order
from ..linalg.scaling import equilibration
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import step
from .element_matrix import ElementMatrix

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


# The constrained form: as many equations as coordinates.


@dataclass(frozen=True, repr=False, eq=False)
class ConstrainedForm(Displayed):
    """The constrained equations of a system with n coordinates and k independent constraint rows.

    Attributes:
        null_space: V, shape (n, n - k).
        rows: A, shape (k, n).
        values: the constant part of b, shape (k,).
        polynomial_matrix: [V^T (M s^2 + C s + K); A s^level], always of degree 2.
        notices: sums of entries of M, C, K that cancel almost.
        excitation: the part of b that varies in time, k rows; None where b is constant.
    """

    null_space: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    polynomial_matrix: PolynomialMatrix
    notices: tuple[Notice, ...] = ()
    excitation: ImpulsiveSmooth | None = None

    def _summary(self) -> str:
        return f"{counted(len(self.null_space), 'coordinate')}, {counted(len(self.values), 'constraint row')}"

    def force(self, applied: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """The right-hand side [V^T f; b] for t > 0 from f with n rows; a constant b is a step."""
        if not len(self.values):
            return applied
        padding = np.zeros((len(self.values), self.null_space.shape[0]))
        values = np.concatenate([np.zeros(self.null_space.shape[1]), self.values])
        is_zero = applied.is_zero and not applied.exact_inputs
        projected = applied if is_zero else applied.mapped(np.vstack([self.null_space.T, padding]))
        projected = projected + step(values) if values.any() else projected
        if self.excitation is None:
            return projected
        size = len(values)
        return projected + self.excitation.mapped(np.eye(size)[:, size - len(self.values) :])


def constrained_form(
    motion: Sequence[np.ndarray | ElementMatrix],
    uncertainty: Sequence[np.ndarray],
    independent: IndependentRows,
    names: Sequence[str],
    orders: Sequence[int],
) -> ConstrainedForm:
    """Stack the projected equations of motion and the constraint rows."""
    V, A = independent.null_space, independent.matrix
    spread = max((matrix.spread for matrix in motion[:2] if isinstance(matrix, ElementMatrix)), default=1.0)
    if spread > LARGEST_SPREAD:
        raise IllConditioned(
            f"the stiffest spring or damper is {spread:.3g} times the softest; a ratio above {LARGEST_SPREAD:g} cannot be solved: "
            "look for a wrong unit, or make the stiffest ones rigid ties"
        )
    # assembled, the softest element loses as many digits; where that is unavoidable, the evidence of the answer reports it
    by_elements = is_worthwhile(spread, 2 * len(names)) or spread > ASSEMBLED_SPREAD
    orders = np.array(orders, dtype=int)
    selected = [orders == power for power in range(len(motion))]
    doubts = np.zeros((V.shape[1], 0))
    if by_elements or not len(A):
        given = motion if by_elements else map(_assembled, motion)
        coefficients = [_stacked(matrix, V, A, rows) for matrix, rows in zip(given, selected)]
    else:
        projected, doubts = _projected(V, np.hstack([_assembled(matrix) for matrix in motion]))
        parts = [projected[:, begin : begin + len(V)] for begin in range(0, projected.shape[1], len(V))]
        coefficients = [np.vstack([part, A * rows[:, None]]) for part, rows in zip(parts, selected)]
    doubt = None
    if any(extra.any() for extra in (independent.uncertainty, *uncertainty)):
        doubt = [
            _stacked_uncertainty(matrix, extra, independent, rows) for matrix, extra, rows in zip(motion, uncertainty, selected)
        ]
    equations = [f"motion {i + 1}" if free is None else f"motion of {names[free]}" for i, free in enumerate(independent.motions)]
    equations += [f"constraint {row.name}" for row in independent.rows]
    values = np.array([row.value for row in independent.rows])
    matrix = PolynomialMatrix(coefficients, names, equations, doubt)
    are_doubtful = doubt is None and ((doubts >= DOUBTFUL_SUM[0]) & (doubts < DOUBTFUL_SUM[1])).any()
    notices = tuple(_cancelled(coefficients, doubts, equations, names)) if are_doubtful else ()
    return ConstrainedForm(V, A, values, matrix, notices, right_sides(independent.rows))


def _assembled(matrix: np.ndarray | ElementMatrix) -> np.ndarray:
    return matrix.matrix if isinstance(matrix, ElementMatrix) else matrix


def _stacked(matrix: np.ndarray | ElementMatrix, V, A, selected) -> np.ndarray | ElementMatrix | Factors:
    """[V^T matrix; the selected rows of A], as factors of a matrix given by its elements; the matrix itself without rows."""
    if not len(A):
        return matrix
    rows = A * selected[:, None]
    if not isinstance(matrix, ElementMatrix):
        return np.vstack([_projected(V, matrix)[0], rows])
    left = block_diag(_projected(V, matrix.directions.T)[0], np.eye(len(rows)))
    return Factors(left, np.concatenate([matrix.constants, np.ones(len(rows))]), np.vstack([matrix.directions, rows]))


def _stacked_uncertainty(matrix, uncertainty: np.ndarray, independent: IndependentRows, selected) -> np.ndarray:
    """The error bounds of the stacked matrix: V is as uncertain as the rows, dV = -G^T dA V with A G^T = I."""
    V, rows = np.abs(independent.null_space), independent.uncertainty
    bound = V.T @ uncertainty
    if rows.any():
        bound += (np.abs(independent.left_inverse).T @ rows @ V).T @ np.abs(_assembled(matrix))
    return np.vstack([bound, rows * selected[:, None]])


def _projected(V, matrix) -> tuple[np.ndarray, np.ndarray]:
    """V^T times the matrix; and its sums relative to the rounding errors of their terms where these decide, 0 elsewhere.

    Sums that cancel leave an exact zero, not rounding errors of their terms. Whole numbers in V are exact, and so are the entries of
    the matrix: where V has no others, what is left of a sum counts as long as it is more than the rounding errors of its terms. The
    equations of coordinates in no constraint row stay as they are.
    """
    alone = ((V != 0).sum(axis=0) == 1) & (V.max(axis=0, initial=0.0) == 1.0)
    whole = ~alone & (V == np.round(V)).all(axis=0)
    product, ratio = np.empty((V.shape[1], matrix.shape[1])), np.zeros((V.shape[1], matrix.shape[1]))
    product[alone] = matrix[V[:, alone].argmax(axis=0)]
    if (mixed := ~(alone | whole)).any():
        used = V[:, mixed].any(axis=1)
        product[mixed] = (Noisy.rounded(V[used][:, mixed].T) @ Noisy.rounded(matrix[used])).cleaned()
    if whole.any():
        rows, right = kept(V[:, whole].T), kept(matrix)
        sums = full(rows.astype(np.longdouble) @ right.astype(np.longdouble))
        share = np.abs(sums) / np.maximum(EPS * full(abs(rows) @ abs(right)), np.finfo(float).tiny)
        product[whole], ratio[whole] = np.where(share > 1.0, sums, 0.0), share
    return product, ratio


def _cancelled(coefficients, ratio, equations, names) -> Iterator[Notice]:
    """Notices on sums of entries of [K, C, M] that are left of their terms by little more, or hardly less, than their rounding."""
    for i, place in np.argwhere((ratio >= DOUBTFUL_SUM[0]) & (ratio < DOUBTFUL_SUM[1])):
        power, j = divmod(place, len(names))
        what = ("stiffness", "damping", "mass")[power]
        left = coefficients[power][i, j]
        outcome = f"{left:.3g} is kept" if left else "it counts as zero"
        text = (
            f"{what}: the constraints leave of the entries of {names[j]} in the equation {equations[i]} a sum that is "
            f"{ratio[i, place]:.2g} times the rounding errors of its terms; {outcome}; give the {what} as elements (ElementMatrix) if it is not"
        )
        yield Notice(NoticeKind.RANK, text, doubtful=True)


# The acceleration of a constrained system at a given state, and the test whether there is only one.


def explicit_acceleration(
    mass: np.ndarray, independent: IndependentRows, load: np.ndarray, values: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """x'' = [(I - A^+ A) M; A]^+ [Q; b], M possibly singular (Udwadia and Phohomsiri 2006).

    The columns of V span the range of I - A^+ A, so that the equations that the pseudo-inverse solves are those of
    [V^T M; A] x'' = [V^T Q; b]: n equations for n unknowns, whose rows and columns may be scaled freely. M alone and
    A alone decide whether there is one solution: rank [M; A] = n.
    """
    V, A = independent.null_space, independent.matrix
    stacked = np.vstack([(Noisy.rounded(V.T) @ Noisy.rounded(mass)).cleaned(), A])
    _check_unique(stacked, names)
    row_scale, column_scale = equilibration(np.abs(stacked))
    right = row_scale * np.concatenate([V.T @ load, values])
    return column_scale * np.linalg.solve(row_scale[:, None] * stacked * column_scale, right)


def _check_unique(stacked: np.ndarray, names: Sequence[str]) -> None:
    """The test rank [M; A] = n on [V^T M; A], which is equivalent for every positive semidefinite M."""
    columns, size = null_columns(Noisy.rounded(stacked)), len(names)
    rank = columns.decision.rank
    if rank == size:
        return
    left_open = columns.null.data.any(axis=0)
    free = ", ".join(f'"{name}"' for name, is_open in zip(names, left_open) if is_open)
    raise NotUnique(
        f"the acceleration of {free} is not determined: rank [M; A] = {rank}, with {size} coordinates; "
        "give them mass or constrain them, or use solve(), which computes the motion of massless "
        "coordinates from springs and dampers"
    )
