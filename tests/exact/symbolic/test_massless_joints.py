"""Moysis et al., section 5.2: (93)-(99), and with m, k1, k2, c1, c2 all free."""

import sympy
from sympy import sqrt

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.gallery import s
from tests.exact.symbolic.models import MASSLESS_JOINTS, c1, c2, k1, k2, m

PAPER = SymbolicPolynomialMatrix([matrix.subs({k1: 2 * k2, c1: 2 * c2}) for matrix in MASSLESS_JOINTS.coefficients])
NUMBERS = SymbolicPolynomialMatrix([matrix.subs({k2: 3, c2: 4, m: 10}) for matrix in PAPER.coefficients])
ROOT = sqrt(c2**2 - 6 * k2 * m)

#: (94)-(96).
C = sympy.Matrix([[0, 1, 1], [-2 * k2 / m, 1, 1], [0, 3, 3]]) / 3
J = sympy.diag(0, (-c2 - ROOT) / (3 * m), (-c2 + ROOT) / (3 * m))
B = sympy.Matrix(
    [
        [0, -m / (2 * c2 * k2), 0],
        [-1 / (2 * ROOT), -1 / (2 * ROOT), -3 / (2 * ROOT)],
        [1 / (2 * ROOT), 1 / (2 * ROOT), 3 / (2 * ROOT)],
    ]
)


def test_smith_forms():
    """(93)."""
    assert sympy.cancel(PAPER.smith_form()[2, 2] - s * (2 * k2 + 2 * c2 * s + 3 * m * s**2) / (3 * m)) == 0
    assert PAPER.smith_form()[:2, :2] == sympy.eye(2)
    assert PAPER.smith_form_at_infinity() == sympy.diag(s**2, s, 1)
    assert PAPER.structure().infinite_divisors == (0, 1, 2)


def test_pair_is_that_of_the_paper_up_to_the_length_of_chains():
    pair = PAPER.jordan_pairs().finite
    assert sympy.expand(pair.J - J) == sympy.zeros(3)
    X = sympy.diag(*(C[row, j] / pair.C[row, j] for j, row in enumerate((1, 0, 0))))
    assert (pair.C * X - C).expand() == sympy.zeros(3)
    assert (X.inv() * pair.B - B).applyfunc(sympy.simplify) == sympy.zeros(3)


def test_infinite_pair():
    """(97): no infinite zeros, but H_0 is not zero, so that mu = 1 and not 0 as (23) would have it."""
    for A, value in ((PAPER, 1 / (3 * k2)), (NUMBERS, sympy.Rational(1, 9)), (MASSLESS_JOINTS, 1 / (k1 + k2))):
        pair = A.jordan_pairs().infinite
        assert pair.C == sympy.Matrix([value, 0, 0])
        assert pair.J == sympy.zeros(1)
        assert pair.B == sympy.Matrix([[1, 0, 0]])
        assert A.jordan_pairs().laurent(0) == sympy.diag(value, 0, 0)
        assert A.jordan_pairs().laurent(1) == sympy.zeros(3)


def test_jump_projector_with_everything_free():
    """u1(0+) = k2/(k1 + k2) u3(0-), u2 and u3 go on, u1' = k2/(k1 + k2) u3'(0-), u2' = c2/(c1 + c2) u3'(0-)."""
    P = MASSLESS_JOINTS.jordan_pairs().jump_projector
    spring, damper = k2 / (k1 + k2), c2 / (c1 + c2)
    expected = sympy.diag(
        sympy.Matrix([[0, 0, spring], [0, 1, 0], [0, 0, 1]]), sympy.Matrix([[0, 0, spring], [0, 0, damper], [0, 0, 1]])
    )
    assert P == expected


def test_jump_projector_from_the_pair_of_the_paper():
    """col(C, C J) [J B, B] M1 (98), of which the square root cancels; (99) is the kernel of I - P."""
    _, A1, A2 = PAPER.coefficients
    M1 = sympy.Matrix(sympy.BlockMatrix([[A2, sympy.zeros(3)], [A1, A2]]).as_explicit())
    P = (sympy.Matrix.vstack(C, C * J) * sympy.Matrix.hstack(J * B, B) * M1).applyfunc(sympy.simplify)
    assert P == PAPER.jordan_pairs().jump_projector
    u = sympy.Matrix(sympy.symbols("u1 u2 u3 v1 v2 v3"))
    u1, _, u3, v1, v2, v3 = u
    assert sympy.solve(list(u - P * u), [u1, v1, v3]) == {u1: u3 / 3, v1: v2, v3: 3 * v2}
