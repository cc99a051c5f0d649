"""A(s) of degree two or less reduced to first-order equations w' = S w + ... by its structure alone, without a pencil.

Rows without a power of s constrain coordinates to others: x = V x_f + Y g, g their right sides (a constraint at position level, a
massless joint without damper). Of the rest, rows with s^2 make accelerations of as many coordinates x_m, those without make
velocities of the others, x_d; the states are w = (x_m, x_m', x_d). Which row is of which kind is read off entries that are
exactly zero, and each part that is divided by must be well conditioned: where that does not hold, the staircase algorithm
(``linalg.staircase``) decides. For large models this takes milliseconds where that takes minutes, for small ones a part of a
millisecond. Zeros at s = 0 are those of rows without stiffness, or of sums of rows without
(``polynomial.reduced_equations``), or there are none.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np
import scipy

from ..ground.tolerances import CLEAR_KEPT, DIVISOR_CONDITION, REFINED_CONDITION, STIFFNESS_CONDITION
from ..linalg.arrays import Matrix, entries, entry_count, filled, full, kept, matrix_of, others
from ..linalg.division import condition, definite_condition, is_symmetric, solution, without_noise
from ..linalg.rank import Noisy, reduce_in_order
from ..linalg.scaling import equilibration
from ..linalg.symmetric import may_be_wide, modes_of_elements
from .coefficients import PolynomialCoefficients
from .reduced_equations import FEW_STATES, Conserved, Freed, NotReducible, Reduction, conserved, freed, lowest

_SINGULAR_MASS = "the mass matrix of the reduced equations is singular"
_SINGULAR_STIFFNESS = "the stiffness matrix is near-singular: rank decisions have to settle whether a body is free"


def reduction_of(
    A: PolynomialCoefficients, like: Reduction | None = None, *, by_elements: bool = False
) -> Reduction | NotReducible:
    """The reduction of A(s), or the violated condition; matrices given by their elements are refused unless their modes are."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is not regular
            return _reduction_of(A, like, by_elements)
    except NotReducible as condition:
        return NotReducible(str(condition))  # without its traceback, as it is kept


def _reduction_of(A: PolynomialCoefficients, like: Reduction | None, by_elements: bool) -> Reduction:
    if not 1 <= A.degree <= 2:
        raise NotReducible(f"A(s) has degree {A.degree}")
    if any(A.factors) and not by_elements:
        raise NotReducible("stiffness is assembled from factors, whose differences float64 would round")
    if A.is_uncertain:
        raise NotReducible("entries of A(s) are uncertain")
    A0, A1, A2 = given = [kept(matrix) for matrix in A.coefficients] + [kept(np.zeros((A.size, A.size)))] * (2 - A.degree)
    rows, columns = A.coefficients[1:].any(axis=2), A.coefficients[1:].any(axis=1)
    slow, heavy = rows[0], rows[1] if A.degree == 2 else np.zeros(A.size, dtype=bool)
    algebraic, second, first = (kind.nonzero()[0] for kind in (~(slow | heavy), heavy, slow & ~heavy))
    moving = columns.any(axis=0)
    V, Y, free, own = eliminated(A.coefficients[0][algebraic], static=~moving, like=A0)
    if len(second) + len(first) != V.shape[1]:
        raise NotReducible("equations with masses and dampers and coordinates with them differ in number")
    M = product(A2[second], V)
    m, columns = len(second), filled(M, 0)
    if np.count_nonzero(columns) != m:
        raise NotReducible(_SINGULAR_MASS)
    if not columns[:m].all():  # coordinates with mass first
        order = np.argsort(~columns, kind="stable")
        V, free, M = V[:, order], free[order], M[:, order]
    matching = matching_rows(M[:, :m])
    if matching is None:
        raise NotReducible(_SINGULAR_MASS)
    second, M = second[matching], M[matching][:, :m]
    rest = np.concatenate([second, first])
    K, C = product(A0[rest], V), product(A1[rest], V)
    largest = max(own, condition(M), condition(C[m:, m:]) if len(first) else 1.0)
    if not largest <= DIVISOR_CONDITION:  # a row may be left without anything
        raise NotReducible(f"masses, dampers or algebraic equations are near-singular (condition {largest:.0e})")
    floor, powers = lowest(M, C, K)
    if len(algebraic) and (filled(A0[rest] @ V, 1)[powers > 0].any() or filled(A1[rest] @ V, 1)[powers > 1].any()):
        raise NotReducible("the stiffness or damping of a row is zero to rounding only")
    equations, unconstrained = (M, C, K), None
    if by_elements:
        modes = None if len(algebraic) or len(first) or powers.any() else _modes_of_elements(A, M, C, free)
        if modes is None:
            raise NotReducible("stiffness is assembled from factors, and they are not springs between masses")
        return Reduction(given, algebraic, second, first, free, V, Y, M, C, K, moving, None, None, largest, by_elements=modes)
    if like.freed is not None if like is not None else not (_is_regular(floor) or _has_refined_modes(M, K)):
        alike = None if like is None else (like.freed, like.C, like.K)
        unconstrained = freed(M, C, K, alike) if 2 * m + len(first) > FEW_STATES else None
        if unconstrained is None:
            raise NotReducible(_SINGULAR_STIFFNESS)
        equations = unconstrained.M, unconstrained.C, unconstrained.K
        floor, powers = lowest(*equations)
        if not _is_regular(floor):
            raise NotReducible(_SINGULAR_STIFFNESS)
    momenta = _conserved(equations, full(floor), powers, unconstrained) if powers.any() else None
    return Reduction(given, algebraic, second, first, free, V, Y, M, C, K, moving, momenta, unconstrained, largest)


def _modes_of_elements(A: PolynomialCoefficients, M: Matrix, C: Matrix, chosen: np.ndarray):
    stiffness = A.factors[0]
    if stiffness is None or not np.array_equal(stiffness.left, stiffness.right.T):
        return None
    return modes_of_elements(full(M), full(C), stiffness.right[:, chosen], stiffness.values)


def _is_regular(floor: Matrix) -> bool:
    return condition(floor, STIFFNESS_CONDITION) <= STIFFNESS_CONDITION


def _has_refined_modes(M: Matrix, K: Matrix) -> bool:
    """Whether K is positive definite beyond rounding errors and modes are refined for any spread, so that no body is free."""
    if 2 * len(M.diagonal()) <= FEW_STATES or K.shape != M.shape or not all(is_symmetric(matrix) for matrix in (M, K)):
        return False
    return may_be_wide(M, K) and definite_condition(full(K)) <= REFINED_CONDITION


def _conserved(equations, floor: np.ndarray, powers: np.ndarray, freed: Freed | None) -> Conserved:
    """Conserved quantities of rows without stiffness, in the place of coordinates on which nothing depends where they exist."""
    M, C, K = equations
    rows = np.argsort(-powers, kind="stable")[: np.count_nonzero(powers)]  # rows of s^2 first: x_d is in none of them
    ignorable = ~filled(K, 0) & ~(filled(C, 0) & (powers.max() > 1))
    return conserved(M, C, rows, powers[rows], pivots_of(floor[rows], ignorable, equilibration(np.abs(floor))[1]), freed)


# The elimination of coordinates by algebraic rows, and which equation belongs to which coordinate.

#: So few rows are matched by trying all: 3 rows take 20 us. The matching of sparse matrices takes 200 us, and scipy.optimize a fifth of a
#: second to import.
FEW_ROWS = 3


def eliminated(rows: np.ndarray, static: np.ndarray, like: Matrix) -> tuple[Matrix, Matrix, np.ndarray, float]:
    """V, Y with x = V x_f + Y g where rows x = g, the coordinates x_f, and the condition number of the part of the others."""
    size = len(static)
    if not len(rows):
        return matrix_of((size, size), like, (0, 0, np.ones(size))), matrix_of((size, 0), like), np.arange(size), 1.0
    pivots = pivots_of(rows, static)
    own = np.inf if pivots is None else condition(rows[:, pivots])
    if own > DIVISOR_CONDITION:
        raise NotReducible("the algebraic equations are dependent, or nearly so")
    free = others(size, pivots)
    V, Y = np.zeros((size, len(free))), np.zeros((size, len(rows)))
    V[free, range(len(free))], V[pivots] = 1.0, -solution(rows[:, pivots], rows[:, free])
    Y[pivots] = solution(rows[:, pivots], np.eye(len(rows)))
    return kept(V), kept(Y), free, own


def product(left: Matrix, V: Matrix) -> Matrix:
    """left @ V with rounding errors of its terms set to zero: absent masses, dampers or springs."""
    entire = left @ V
    if V.shape[0] == V.shape[1] or entry_count(V) == V.shape[1]:
        return entire
    terms = abs(left) @ abs(V)
    cleaned = without_noise(entire, terms)
    if entry_count(cleaned) != entry_count(without_noise(entire, CLEAR_KEPT * terms)):
        raise NotReducible("the elimination of coordinates leaves differences near the rounding error of their terms")
    return cleaned


def matching_rows(M: Matrix) -> np.ndarray | None:
    """An order of rows with large entries on the diagonal: equations may be named after other coordinates."""
    if is_symmetric(M):
        return np.arange(M.shape[0])
    if M.shape[0] <= FEW_ROWS:
        size, columns = np.abs(full(M)), np.arange(len(M))
        orders = np.array(list(permutations(range(len(M)))))
        with np.errstate(divide="ignore"):
            costs = np.log(size.max() / size)[orders, columns].sum(axis=1)
        best = costs.argmin()
        return orders[best] if costs[best] < np.inf else None
    row, column, values = entries(abs(M))
    weights = scipy.sparse.csr_array((1 + np.log(values.max(initial=1.0) / values), (row, column)), shape=M.shape)
    try:
        rows, columns = scipy.sparse.csgraph.min_weight_full_bipartite_matching(weights)
    except ValueError:  # no matching: it is singular
        return None
    return rows[np.argsort(columns)]


def pivots_of(rows: np.ndarray, static: np.ndarray, units: np.ndarray | None = None) -> np.ndarray | None:
    """A pivot column for each row by elimination, static coordinates before others; None where rows depend on each other."""
    units = equilibration(np.abs(rows))[1] if units is None else units
    if len(rows) == 1:  # the largest entry of one row serves
        size = np.abs(rows[0]) * units
        return (np.where(static, size, 0.0) if size[static].any() else size).argmax(keepdims=True) if size.any() else None
    work = Noisy.rounded(rows * units)
    kept, pivots = reduce_in_order(work, rows.shape[1], static, DIVISOR_CONDITION)
    return np.array(pivots, dtype=int) if len(kept) == len(rows) else None
