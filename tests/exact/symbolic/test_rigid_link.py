"""Two unit masses, a spring and a rigid link with its multiplier: an infinite zero of order 2, worked out in rational arithmetic."""

import sympy

from tests.exact.symbolic.gallery import s
from tests.exact.symbolic.models import RIGID_LINK

HALF = sympy.Rational(1, 2)


def test_structure():
    structure = RIGID_LINK.structure()
    assert RIGID_LINK.determinant.as_expr() == 2 * s**2 + 1
    assert structure.at_infinity == (2, 2, -2)
    assert RIGID_LINK.smith_form_at_infinity() == sympy.diag(s**2, s**2, s**-2)
    assert structure.infinite_divisors == (0, 0, 4)
    assert structure.highest_impulse == 2
    assert structure.infinite_chains == (3,)
    assert [zero.value for zero in structure.finite_zeros] == [sympy.sqrt(2) * sympy.I / 2]


def test_laurent_coefficients():
    H = RIGID_LINK.jordan_pairs().laurent
    assert H(3) == H(1) == H(-1) == sympy.zeros(3)
    assert H(2) == sympy.diag(0, 0, HALF)
    assert 4 * H(0) == sympy.Matrix([[0, 0, 2], [0, 0, -2], [-2, 2, 1]])
    assert 8 * H(-2) == sympy.Matrix([[4, 4, -2], [4, 4, -2], [2, 2, -1]])


def test_infinite_pair_is_one_chain():
    pair = RIGID_LINK.jordan_pairs().infinite
    assert pair.J == sympy.Matrix([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
    assert pair.C * pair.J**2 * pair.B == sympy.diag(0, 0, HALF)


def test_values_after_an_inconsistent_start():
    """q(0-) = (1, 0) at rest goes on from (1/2, 1/2, 1/4, 0, 0, 0); q'(0-) = (1, 0) from (0, 0, 0, 1/2, 1/2, 1/4)."""
    P = RIGID_LINK.jordan_pairs().jump_projector
    assert list(P[:, 0]) == [HALF, HALF, HALF / 2, 0, 0, 0]
    assert list(P[:, 3]) == [0, 0, 0, HALF, HALF, HALF / 2]
