"""The structure over the rationals of an A(s) that is not regular: both kernels, elementary divisors, Smith form.

A vector v(s) of degree d in the kernel of A(s) is a vector in the null space of the block Toeplitz matrix that multiplies its
coefficients; of those of the least degrees, each that is no combination of multiples s^k of the ones before belongs to a minimal basis
(Forney 1975). The product of the invariant polynomials is the greatest common divisor of all minors of the size of the rank; those of
random combinations of rows and of columns are multiples of it (Cauchy and Binet), and the exponents of each of their irreducible
factors come from an elimination of A(s) itself.
"""

from __future__ import annotations

from fractions import Fraction

import flint
import numpy as np

from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import PolynomialVector
from .engine import ElementaryDivisor, ExactStructure, local_exponents
from .rational import RATIONALS, RationalMatrix, X, known_matrix, pivots

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
        elementary_divisors=tuple(
            ElementaryDivisor(RATIONALS.exported(p), exponents, RATIONALS, p) for p, _, exponents in divisors
        ),
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
    return [np.array([Fraction(int(c)) for c in vector], dtype=object).reshape(-1, n) for vector in basis]


def _toeplitz(coefficients: list[flint.fmpz_mat], degree: int) -> flint.fmpz_mat:
    """The matrix of the coefficients of A(s) v(s) as functions of those of a v(s) of this degree."""
    (m, n), q = (coefficients[0].nrows(), coefficients[0].ncols()), len(coefficients) - 1
    rows: list[list] = [[0] * ((degree + 1) * n) for _ in range((q + degree + 1) * m)]
    for power, matrix in enumerate(coefficients):
        for k in range(degree + 1):
            for i, row in enumerate(matrix.tolist()):
                rows[(power + k) * m + i][k * n : (k + 1) * n] = row
    return flint.fmpz_mat(len(rows), (degree + 1) * n, [entry for row in rows for entry in row])


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
