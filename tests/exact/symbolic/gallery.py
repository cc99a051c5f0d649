"""Polynomial matrices with symbols whose structure is known beforehand: the papers' examples, and products U(s) diag(d_i(s)) V(s)."""

import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.models import MASSLESS_JOINTS, RIGID_LINK, STEP_OF_A_DERIVATIVE, TWO_MASSES, k, m

s = sympy.Symbol("s")

#: Unimodular: polynomial with a polynomial inverse.
LEFT = sympy.Matrix([[1, 0, 0], [s, 1, 0], [2, s - 1, 1]])
RIGHT = sympy.Matrix([[1, 1, s], [0, 1, 1], [0, 0, 1]])


def from_polynomials(matrix: sympy.Matrix, degree: int | None = None) -> SymbolicPolynomialMatrix:
    """A(s) from its entries."""
    polynomials = [[sympy.Poly(entry, s) for entry in row] for row in matrix.tolist()]
    highest = max(p.degree() for row in polynomials for p in row) if degree is None else degree
    return SymbolicPolynomialMatrix([[[p.coeff_monomial(s**i) for p in row] for row in polynomials] for i in range(highest + 1)])


def product(*divisors) -> SymbolicPolynomialMatrix:
    """U(s) diag(d_1, d_2, d_3) V(s)."""
    return from_polynomials(LEFT * sympy.diag(*divisors) * RIGHT)


def two_masses(level: int) -> SymbolicPolynomialMatrix:
    """Section 5.1 with the constraint row at A_level."""
    coefficients = [
        sympy.Matrix([[0, 0, k], [k, 0, 0], [0, 0, 0]]),
        sympy.zeros(3),
        sympy.Matrix([[0, m, m], [m, m, m], [0, 0, 0]]),
    ]
    coefficients[level][2, :] = sympy.Matrix([[1, -1, 0]])
    return SymbolicPolynomialMatrix(coefficients)


def with_multiplier(level: int) -> SymbolicPolynomialMatrix:
    """[M s^2 - K, -A^T; A s^level, 0] of section 5.1."""
    row = sympy.Matrix([[1, -1, 0]])
    M, K = sympy.Matrix([[m, 0, 0], [0, m, m], [0, m, m]]), sympy.diag(k, 0, k)
    return from_polynomials(
        sympy.Matrix(sympy.BlockMatrix([[M * s**2 + K, -row.T], [row * s**level, sympy.zeros(1)]]).as_explicit())
    )


#: (A, invariant polynomials other than 1 as lists of factors with powers), for every kind of elementary divisor.
PRODUCTS = {
    "rational, derogatory": product(1, (s - k), (s - k) ** 3),
    "zero and a ratio": product(s, s * (s + k / m), s**2 * (s + k / m) ** 2),
    "complex pair, twice": product(1, s**2 + k / m, (s**2 + k / m) ** 2),
    "damped pair": product(1, 1, (m * s**2 + 2 * s + k) ** 2),
    "quartic in squares": product(1, 1, (m**2 * s**4 + 3 * k * m * s**2 + k**2) ** 2),
    "cubic": product(1, s**3 - k, (s**3 - k) ** 2),
    "numbers": product(1, s**2 - 2, (s**2 - 2) * (s**2 + s + 1) ** 2),
    "no zeros": product(1, 1, m),
}

#: Every shape that the identities are tried on.
MODELS = {
    "two masses": TWO_MASSES,
    "position": two_masses(0),
    "velocity": two_masses(1),
    "multiplier, position": with_multiplier(0),
    "multiplier, acceleration": with_multiplier(2),
    "massless joints": MASSLESS_JOINTS,
    "rigid link": RIGID_LINK,
    "derivative": STEP_OF_A_DERIVATIVE,
    "scalar": SymbolicPolynomialMatrix([[[k]]]),
    "first order": SymbolicPolynomialMatrix([[[k]], [[m]]]),
    "declared too high": SymbolicPolynomialMatrix([[[k]], [[m]], [[0]], [[0]]]),
    "denominators": SymbolicPolynomialMatrix([[[1 / k, 0], [m / (k + m), 1]], [[1, k], [0, 0.1]]]),
    "square roots": SymbolicPolynomialMatrix([[[sympy.sqrt(2) * k, 1], [1, 0]], [[1, 0], [0, sympy.sqrt(2)]]]),
    "one factor": from_polynomials(sympy.Matrix([[m * s**2 + s + 2 * k, -k], [-k, s**2 + k]])),
    **PRODUCTS,
}
