"""Small models with symbols: the examples of Moysis et al. and others."""

import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix

m, k, c, k1, k2, c1, c2 = sympy.symbols("m k c k1 k2 c1 c2", positive=True)
ZERO = sympy.zeros(3, 3)

#: Section 5.1, Eq. (84): coordinates x1bar, q1, q2bar.
TWO_MASSES = SymbolicPolynomialMatrix(
    [[[0, 0, k], [k, 0, 0], [0, 0, 0]], ZERO, [[0, m, m], [m, m, m], [1, -1, 0]]], coordinates=["x1", "q1", "q2"]
)

#: Section 5.2, Eq. (92), all five parameters free.
MASSLESS_JOINTS = SymbolicPolynomialMatrix(
    [
        [[k1 + k2, 0, -k2], [0, 0, 0], [-k2, 0, k2]],
        [[0, 0, 0], [0, c1 + c2, -c2], [0, -c2, c2]],
        sympy.diag(0, 0, m),
    ],
    coordinates=["u1", "u2", "u3"],
)

#: Two masses and a rigid link with its multiplier.
RIGID_LINK = SymbolicPolynomialMatrix(
    [[[1, 0, -1], [0, 0, 1], [1, -1, 0]], ZERO, sympy.diag(1, 1, 0)], coordinates=["a", "b", "force"]
)

OSCILLATOR = SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]])
DAMPED = SymbolicPolynomialMatrix([[[k]], [[c]], [[m]]])

#: The counter-examples to (58) with f(0-), and to (60) as printed.
STEP_OF_A_DERIVATIVE = SymbolicPolynomialMatrix([[[1, 0], [0, 1]], [[0, -1], [0, 0]]])
FREE_AND_DECAYING = SymbolicPolynomialMatrix([[[0, 0], [0, 1]], [[0, 0], [0, 1]], [[1, 0], [0, 0]]])
