"""Any A(s), m x n, over the rationals: kernels, elementary divisors, Smith form, and whether A(d/dt) x = f can be solved, and how.

A vector v(s) of degree d in the kernel of A(s) is a vector in the null space of the block Toeplitz matrix that multiplies its
coefficients; of those of the least degrees, each that is no combination of multiples s^k of the ones before belongs to a minimal basis
(Forney 1975). The product of the invariant polynomials is the greatest common divisor of all minors of the size of the rank; those of
random combinations of rows and of columns are multiples of it (Cauchy and Binet), and the exponents of each of their irreducible
factors come from an elimination of A(s) itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, islice
from math import gcd, lcm, prod

import flint
import numpy as np

from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import PolynomialVector
from .engine import ElementaryDivisor, ExactStructure, local_exponents
from .rational import POINTS, RATIONALS, RationalMatrix, X, fraction, known_matrix, pivots, rational_matrix

#: Minors from which the greatest common divisor is taken, and the largest weight of a row or column in them.
MINORS, LARGEST_WEIGHT = 2, 99


def kernel_structure(A: PolynomialMatrix) -> ExactStructure:
    """The structure of any A(s), as ``exact.structure``."""
    matrix, (m, n), q = known_matrix(A), A.shape, A.degree
    right, left = minimal_basis(matrix), minimal_basis(matrix.transposed)
    divisors = []
    for p, multiplicity in RATIONALS.factors(_minor_divisor(matrix)):
        exponents = tuple(filter(None, local_exponents(RATIONALS, matrix.entries, p, multiplicity + 1)))
        if exponents:
            divisors.append((p, sum(exponents), exponents))
    reversed_entries = RationalMatrix(matrix.coefficients[::-1]).entries
    return ExactStructure(
        shape=A.shape,
        degree=q,
        finite_zeros=RATIONALS.finite_zeros(divisors),
        infinite_divisors=local_exponents(RATIONALS, reversed_entries, X, q * matrix.rank + 1),
        right_kernel=tuple(PolynomialVector.of(vector, A.coordinates) for vector in right),
        left_kernel=tuple(PolynomialVector.of(vector, A.equations) for vector in left),
        determinant=() if m == n else None,
        elementary_divisors=tuple(ElementaryDivisor(RATIONALS, p, exponents) for p, _, exponents in divisors),
        ring=RATIONALS,
    )


def minimal_basis(matrix: RationalMatrix) -> list[np.ndarray]:
    """A minimal basis of the kernel of A(s): Fractions of shape (degree + 1, n), ascending degrees."""
    n, basis, degree = matrix.coefficients[0].ncols(), [], 0
    while len(basis) < n - matrix.rank:
        null, nullity = _toeplitz(matrix.whole, degree).nullspace()
        shifts = [
            [0] * (k * n) + vector + [0] * ((degree + 1 - k) * n - len(vector))
            for vector in basis
            for k in range(degree + 2 - len(vector) // n)
        ]
        if nullity > len(shifts):
            candidates = shifts + null.transpose().tolist()[:nullity]
            reduced, _, rank = flint.fmpz_mat(candidates).transpose().rref()
            basis += [candidates[j] for j in pivots(reduced, rank) if j >= len(shifts)]
        degree += 1
    return [_fractions(vector).reshape(-1, n) for vector in basis]


def _toeplitz(coefficients: list[flint.fmpz_mat], degree: int) -> flint.fmpz_mat:
    """The matrix of the coefficients of A(s) v(s) as functions of those of a v(s) of this degree."""
    m, n, count = coefficients[0].nrows(), coefficients[0].ncols(), degree + 1
    total = np.zeros(((len(coefficients) + degree) * m, count * n), dtype=object)
    for power, matrix in enumerate(coefficients):
        for k in range(count if total.size else 0):
            total[(power + k) * m : (power + k + 1) * m, k * n : (k + 1) * n] = matrix.tolist()
    return flint.fmpz_mat(*total.shape, total.ravel().tolist())


def _minor_divisor(matrix: RationalMatrix) -> flint.fmpq_poly:
    """A multiple of the product of the invariant polynomials, without factors beyond it but for a coincidence."""
    random, divisor, drawn = np.random.default_rng(0), flint.fmpq_poly([]), 0
    first, rank = matrix.coefficients[0], matrix.rank
    while drawn < MINORS:
        rows, columns = (
            flint.fmpq_mat(shape[0], shape[1], random.integers(1, LARGEST_WEIGHT, shape[0] * shape[1]).tolist())
            for shape in ((rank, first.nrows()), (first.ncols(), rank))
        )
        minor = RationalMatrix([rows * each * columns for each in matrix.coefficients]).determinant
        if minor:
            divisor, drawn = divisor.gcd(minor), drawn + 1
    return divisor


# Rank and completion: what decides whether A(d/dt) x = f can be solved.

#: So many sets of rows are tried before the one with the fewest additional zeros is taken.
MOST_SETS = 400


def whole_basis(matrix: RationalMatrix) -> list[np.ndarray]:
    """A minimal basis of the right kernel: vectors of whole numbers without a common divisor, shape (degree + 1, n)."""
    return [whole(vector) for vector in minimal_basis(matrix)]


def _null_space(matrix: np.ndarray) -> list[np.ndarray]:
    """A basis of the null space, vectors of whole numbers without a common divisor."""
    null, nullity = rational_matrix(matrix).numer_denom()[0].nullspace()
    return [whole(_fractions(vector)) for vector in null.transpose().tolist()[:nullity]]


def _fractions(vector: Sequence[flint.fmpz]) -> np.ndarray:
    return np.array([Fraction(int(c)) for c in vector], dtype=object)


def whole(vector: np.ndarray) -> np.ndarray:
    """The multiple of a vector of Fractions that has whole numbers without a common divisor, the first one positive."""
    entries = [entry for entry in vector.ravel().tolist() if entry]
    if not entries:
        return vector
    factor = Fraction(lcm(*(entry.denominator for entry in entries)), gcd(*(entry.numerator for entry in entries)))
    return vector * (factor if entries[0] > 0 else -factor)


def floats(vector: np.ndarray) -> np.ndarray:
    """A vector in float64: itself, or where its whole numbers have more digits, its multiple with the largest entry 1."""
    largest = max(map(abs, vector.ravel().tolist()), default=0)
    return (vector / largest if largest > 2**53 else vector).astype(float)


# Which rows make a square minor with the fewest zeros.


def minor_zeros(vectors: Sequence[np.ndarray], rows: Sequence[int], noise: float = 0.0) -> np.ndarray | None:
    """The coefficients of the determinant of some rows of polynomial columns, lowest first, the largest 1 or -1; None where it is zero.

    With vectors known to a relative error ``noise`` coefficients below this part of what the rows allow are zero.
    """
    minor = stacked(vectors)[:, list(rows)]
    determinant = [fraction(c) for c in RationalMatrix(minor).determinant.coeffs()]
    least = Fraction(noise) * prod(np.abs(minor).max(axis=(0, 1)).tolist())
    while determinant and abs(determinant[-1]) <= least:
        determinant.pop()
    largest = max(map(abs, determinant), default=None)
    return None if largest is None else np.array([float(c / largest) for c in determinant])


def stacked(vectors: Sequence[np.ndarray]) -> np.ndarray:
    """Polynomial vectors as columns of one polynomial matrix, shape (degree + 1, n, count)."""
    degree = max(len(vector) for vector in vectors)
    matrix = np.full((degree, vectors[0].shape[1], len(vectors)), Fraction(0), dtype=object)
    for column, vector in enumerate(vectors):
        matrix[: len(vector), :, column] = vector
    return matrix


def best_rows(
    vectors: Sequence[np.ndarray], required: Sequence[int] = (), most: bool = False, noise: float = 0.0
) -> tuple[tuple[int, ...], np.ndarray]:
    """As many rows of polynomial columns as there are columns, whose minor has the fewest zeros, or the most, and its coefficients, lowest first.

    The last rows come first; of rows with as many zeros those are preferred whose zeros are in the left half plane. Free coordinates
    chosen with ``most`` zeros are inputs of which the others are proper functions, so that they need no derivatives of them (Willems
    1991, section VIII). The minors of ``required`` rows must not all vanish; no minor has more zeros than the sum of the degrees of the
    columns of a minimal basis, which have a relative error ``noise``.
    """
    used = np.flatnonzero(np.any([(vector != 0).any(axis=0) for vector in vectors], axis=0)).tolist()
    others, best = [row for row in reversed(used) if row not in required], None
    wanted = sum(len(vector) - 1 for vector in vectors) if most else 0
    for more in islice(combinations(others, len(vectors) - len(required)), MOST_SETS):
        rows = tuple(sorted((*required, *more)))
        determinant = minor_zeros(vectors, rows, noise)
        if determinant is not None:
            growth = float(np.roots(determinant[::-1]).real.max(initial=-np.inf))
            rank = (abs(wanted - len(determinant) + 1), growth)
            if best is None or rank < best[0]:
                best = rank, rows, determinant
            if rank[0] == 0 and growth <= 0:
                break
    if best is None:
        rows = _any_rows(vectors, required)
        return rows, minor_zeros(vectors, rows)
    return best[1], best[2]


def _any_rows(vectors: Sequence[np.ndarray], required: Sequence[int]) -> tuple[int, ...]:
    """Rows with a minor that is not zero, found by elimination at a point."""
    matrix = stacked(vectors)
    value = sum(part * Fraction(POINTS[0]) ** power for power, part in enumerate(matrix))
    order = [*required, *(row for row in range(len(value)) if row not in required)]
    reduced, rank = rational_matrix(value[order].T).rref()
    return tuple(sorted(order[pivot] for pivot in pivots(reduced, rank)))


def independent_rows(vectors: Sequence[np.ndarray], rows: Sequence[int]) -> int:
    """The rank of some rows of polynomial columns."""
    return RationalMatrix(stacked(vectors)[:, list(rows)]).rank if rows and vectors else 0


def combinations_without_zeros(vectors: Sequence[np.ndarray]) -> np.ndarray | None:
    """Combinations T of equations, whole numbers, shape (r, m), so that T A(s) has the finite zeros of A(s) alone; None where there are none.

    With a constant B that the coefficients of s, s^2, ... of the left kernel N(s) annihilate and N_0 B regular, N(s) B is constant, and T
    is the left null space of B. Pencils always have such a B.
    """
    matrix = stacked(vectors)  # (degree + 1, m, count)
    higher = matrix[1:].transpose(0, 2, 1).reshape(-1, matrix.shape[1])
    space = np.array(_null_space(higher) if len(higher) else np.eye(matrix.shape[1], dtype=int) + Fraction(0), dtype=object)
    if len(space) < len(vectors):
        return None
    reduced, rank = rational_matrix(matrix[0].T @ space.T).rref()
    if rank < len(vectors):
        return None
    return np.array(_null_space(space[pivots(reduced, rank)]), dtype=object)
