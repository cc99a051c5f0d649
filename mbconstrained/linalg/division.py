"""Solutions of linear equations, products and quotients with twice the digits; symmetry, sign and condition to rounding errors."""

from __future__ import annotations

import math
from functools import reduce
from itertools import pairwise, product

import numpy as np
import scipy

from ..ground.tolerances import CANCELLED, EPS, GOOD_CONDITION, noise_of
from .arrays import Matrix, entries, entry_count, full, is_diagonal, lapack, of_like_kind
from .scaling import equilibration


def solved(matrix: Matrix, right: Matrix) -> Matrix:
    """matrix^-1 @ right, of the kind of the right side; where the matrix is diagonal by division."""
    if is_diagonal(matrix):
        divisors = matrix.diagonal()[:, None]
        return right / divisors if isinstance(right, np.ndarray) else scipy.sparse.csr_array(right.multiply(1 / divisors))
    return of_like_kind(solution(full(matrix), full(right)), right)


def solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """matrix^-1 @ right for a real matrix; for small ones four times faster than ``numpy.linalg.solve``."""
    if not right.size:
        return np.zeros(right.shape)
    result, info = (lapack.zgesv if right.dtype.kind == "c" else lapack.dgesv)(matrix, right)[2:]
    if info:
        raise np.linalg.LinAlgError("singular matrix")
    return result


def without_noise(matrix: Matrix, size: Matrix) -> Matrix:
    """The matrix without entries that are rounding errors of terms of this size, which would couple separate parts."""
    if isinstance(matrix, np.ndarray):
        result = matrix.copy()
        result[~(np.abs(matrix) > noise_of(size))] = 0.0
        return result
    result = matrix.tocoo()
    if not result.nnz:
        return result.tocsr()
    kept = np.abs(result.data) > noise_of(np.asarray(scipy.sparse.csr_array(size)[result.row, result.col]).reshape(-1))
    return scipy.sparse.csr_array((result.data[kept], (result.row[kept], result.col[kept])), shape=result.shape)


def is_symmetric(matrix: Matrix) -> bool:
    """Whether a matrix is symmetric to rounding errors, each entry relative to its row and column, in any units.

    What couples rows that no other entry couples is no rounding error of anything, however small it is.
    """
    if isinstance(matrix, np.ndarray) and not np.count_nonzero(matrix != matrix.T):
        return True
    asymmetry = abs(matrix - matrix.T)
    if not entry_count(asymmetry):
        return True
    size = np.sqrt(full(abs(matrix).max(axis=1)).reshape(-1))
    row, column, difference = entries(asymmetry)
    noise = noise_of(size[row] * size[column])
    if not (difference <= noise).all():
        return False
    if isinstance(matrix, np.ndarray) and (np.maximum(np.abs(matrix), np.abs(matrix.T))[row, column] > noise).all():
        return True  # coupled by these entries themselves
    i, j, values = entries(abs(matrix))
    clear = values > noise_of(size[i] * size[j])
    joined = scipy.sparse.csr_array((values[clear], (i[clear], j[clear])), shape=matrix.shape)
    part = scipy.sparse.csgraph.connected_components(joined, directed=False)[1]
    return bool((part[row] == part[column]).all())


def is_semidefinite(matrix: Matrix) -> bool:
    """Whether a symmetric matrix has no negative eigenvalue beyond rounding, its diagonal brought to 1 where it is not 0."""
    diagonal = matrix.diagonal()
    if (diagonal < 0).any():
        return False
    root = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = matrix * (1 / root[:, None]) * (1 / root)
    size, noise = np.asarray(abs(scaled).sum(axis=1)).reshape(-1), noise_of(1.0, len(root))
    dominated = (2 * scaled.diagonal() - size >= -noise).all()  # then it has none, at no cost
    return bool(dominated) or float(np.linalg.eigvalsh(full(scaled))[0]) >= -noise


def condition(matrix: Matrix, enough: float = GOOD_CONDITION) -> float:
    """The condition (1-norm, estimated where it has many rows) of a square matrix, its rows and columns brought to one size where it is more than
    enough.
    """
    if not matrix.shape[0] or is_diagonal(matrix):
        return 1.0
    matrix = full(matrix)
    result = _condition(matrix)
    if result <= enough:
        return result
    rows, columns = equilibration(np.abs(matrix))
    return _condition(rows[:, None] * matrix * columns)


def definite_condition(matrix: np.ndarray) -> float:
    """The condition (1-norm, estimated) of a symmetric matrix with its diagonal brought to 1; infinite unless it is positive definite."""
    diagonal = matrix.diagonal()
    if not (diagonal > 0).all():
        return np.inf
    if is_diagonal(matrix):
        return 1.0
    root = np.sqrt(diagonal)
    scaled = matrix / root / root[:, None]
    factor, failed = lapack.dpotrf(scaled, clean=0)
    reciprocal = 0.0 if failed else lapack.dpocon(factor, lapack.dlange("1", scaled))[0]
    return 1 / reciprocal if reciprocal > 0 else np.inf


#: Up to so many rows the condition is that of the inverse: scenes of few coordinates are checked without SciPy, which takes longer to import.
FEW_ROWS = 10


def _condition(matrix: np.ndarray) -> float:
    if len(matrix) <= FEW_ROWS:
        try:
            result = math.prod(max(map(sum, np.abs(one).T.tolist())) for one in (matrix, np.linalg.inv(matrix)))
        except np.linalg.LinAlgError:
            return np.inf
        return result if result > 0 else np.inf  # not a number where the entries are none
    factors, _, info = lapack.dgetrf(matrix)
    reciprocal = lapack.dgecon(factors, lapack.dlange("1", matrix))[0] if info == 0 else 0.0
    return 1 / reciprocal if reciprocal > 0 else np.inf


# Sums, products and quotients of float64 matrices in double the precision, for differences of nearly equal terms.
# A product of matrices is a sum of products of slices of its factors, each exact in float64 (Ozaki, Ogita, Oishi and Rump 2012), and
# their sum has an error term of its own (Knuth). A quotient is refined once by its residual (Wilkinson): what cancels in it to a
# rounding error of its terms is then known to as many digits as were left out.

#: Slices of a factor: three hold all 53 bits, and 16 more of entries smaller than the largest of their row.
SLICES = 3

#: Rounding error of each term of a product, relative to the largest entries of its row and its column.
PRODUCT_ERROR = 64 * EPS**2

#: Veltkamp's factor: times it a number splits into two halves of 26 bits, whose products are exact.
HALVES = 2.0**27 + 1


def accurate_product(left: np.ndarray, right: np.ndarray, slices: int = SLICES) -> tuple[np.ndarray, np.ndarray]:
    """left @ right as its rounded value and the rounding error; more slices keep entries that are smaller in their row or column."""
    return _product(_slices(left, 1, slices), _slices(right, 0, slices))


def accurately_solved(matrix: Matrix, right: Matrix) -> Matrix:
    """matrix^-1 @ right, accurate also in entries that cancel; those that cancel to double precision of float64 are zero.

    Without refinement they would be rounding errors, which couple what nothing couples, or would have to count as zero, whatever
    they are (Skeel 1979).
    """
    if is_diagonal(matrix) or not right.shape[1]:
        return solved(matrix, right)
    like, matrix, right = right, full(matrix), full(right)
    result = solution(matrix, right)
    inverse = np.abs(solution(matrix, np.eye(len(matrix))))
    size = inverse @ (np.abs(matrix) @ (inverse @ np.abs(right)))
    if not ((np.abs(result) <= CANCELLED * size) & (result != 0)).any():
        return of_like_kind(result, like)
    rows, columns = equilibration(np.abs(matrix))
    matrix, result, right = rows[:, None] * matrix * columns, result / columns[:, None], rows[:, None] * right
    size, inverse = size / columns[:, None], inverse / columns[:, None] / rows
    high, low = accurate_product(matrix, result)
    result = result + solution(matrix, (right - high) - low)
    largest = np.multiply.outer(np.abs(matrix).max(axis=1), np.abs(result).max(axis=0))
    noise = noise_of(inverse @ (np.abs(matrix) @ noise_of(size))) + PRODUCT_ERROR * len(matrix) * (inverse @ largest)
    return of_like_kind(np.where(np.abs(result) > noise, result, 0.0) * columns[:, None], like)


def congruence(shapes: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """X^T A X in double the precision, rounded once."""
    columns = _slices(shapes, 0)
    high, low = _product(_slices(matrix, 1), columns)
    rows = [part.T for part in columns]
    return sum(_product(rows, _slices(high, 0))) + shapes.T @ low


def _slices(matrix: np.ndarray, axis: int, count: int = SLICES) -> list[np.ndarray]:
    """Slices that add up to the matrix, of so few bits relative to the largest entry along an axis that their products are exact."""
    bits, result, rest = math.ceil((53 + math.log2(max(matrix.shape[axis], 2))) / 2), [], matrix
    while rest.any() and len(result) < count - 1:
        size = np.abs(rest).max(axis=axis, keepdims=True, initial=0.0)
        shift = np.ldexp(1.0, np.frexp(size)[1] + bits)
        result.append((rest + shift) - shift)
        rest = rest - result[-1]
    return [*result, rest]


def _product(left: list[np.ndarray], right: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The sum of the products of slices, as a matrix and its rounding error."""
    pairs = sorted(product(range(len(left)), range(len(right))), key=sum)  # the largest terms first

    def add(sums, pair):
        total, error = sum_with_error(sums[0], left[pair[0]] @ right[pair[1]])
        return total, sums[1] + error

    zero = np.zeros((left[0].shape[0], right[0].shape[1]))
    return reduce(add, pairs, (zero, zero))


def sum_with_error(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a + b rounded, and the rounding error (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def product_with_error(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """a * b rounded, entry by entry, and the rounding error (Dekker 1971)."""
    total = a * b
    (large, small), (other, rest) = split(a), split(b)
    return total, ((large * other - total) + large * rest + small * other) + small * rest


def exact_product(row: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """row @ A rounded once: products and their rounding errors (Dekker 1971) are summed exactly (Shewchuk 1997).

    >>> exact_product(np.array([1.0, 1.0, -1.0]), np.array([[1.0], [2.0**-60], [1.0]])) * 2.0**60
    array([1.])
    """
    result = np.zeros(matrix.shape[1])
    for column in np.flatnonzero((row != 0) @ (matrix != 0)):
        used = np.flatnonzero((row != 0) & (matrix[:, column] != 0))
        (left, unit), (right, other) = _scaled(row[used]), _scaled(matrix[used, column])
        terms, errors = product_with_error(left, right)
        total = math.fsum([*terms, *errors])
        result[column] = math.ldexp(total, unit + other)
    return result


def vanish_exactly(left: np.ndarray, right: np.ndarray, product: np.ndarray) -> bool:
    """Whether entries of left @ right that are zero in a rounded product are zero for the factors taken as exact numbers.

    >>> vanish_exactly(np.array([[0.1, 0.2, -0.3]]), np.ones((3, 1)), np.zeros((1, 1)))
    False
    """
    doubtful = (product == 0) & (np.abs(left) @ np.abs(right) > 0)
    return not any(exact_product(left[row], right[:, doubtful[row]]).any() for row in np.flatnonzero(doubtful.any(axis=1)))


def exact_row_sums(matrix: Matrix) -> np.ndarray:
    """The sum of the entries of each row, rounded once.

    >>> exact_row_sums(np.array([[1.0, 2.0**-60, -1.0]])) * 2.0**60
    array([1.])
    """
    row, _, values = entries(matrix)
    order = np.argsort(row, kind="stable")
    ends = np.searchsorted(row[order], np.arange(matrix.shape[0] + 1)).tolist()
    values = values[order].tolist()
    return np.array([math.fsum(values[begin:end]) for begin, end in pairwise(ends)])


def _scaled(values: np.ndarray) -> tuple[np.ndarray, int]:
    """The values scaled by a power of two to a largest one near 1, and the exponent."""
    power = math.frexp(np.abs(values).max())[1]
    return np.ldexp(values, -power), power


def split(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two halves of 26 bits that add up to the values (Veltkamp)."""
    high = HALVES * values
    high -= high - values
    return high, values - high
