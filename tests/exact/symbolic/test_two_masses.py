"""Moysis et al., section 5.1 with m and k as symbols: (84)-(88), (88) corrected, at all three levels of the constraint."""

import pytest
import sympy
from sympy import Rational, sqrt

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.gallery import s, two_masses, with_multiplier
from tests.exact.symbolic.models import TWO_MASSES, k, m

FINITE = s**4 + 3 * k / m * s**2 + k**2 / m**2
NUMBERS = SymbolicPolynomialMatrix([matrix.subs({m: 10, k: 2}) for matrix in TWO_MASSES.coefficients])
SQUARE = (3 + sqrt(5)) / 2  # of the golden ratio

#: (86) and (87); the paper's frequencies in another form, sqrt((3 +- sqrt(5)) k/m) / sqrt(2).
C = sympy.Matrix([[0, 0, SQUARE, 0, 1 / SQUARE, 0], [1, 0, SQUARE, 0, 1 / SQUARE, 0], [0, 0, -2 - sqrt(5), 0, -2 + sqrt(5), 0]])
FREQUENCIES = [sqrt(3 * k / m + way * sqrt(5) * k / m) / sqrt(2) for way in (1, -1)]

#: (88) with entry (6, 3) corrected: without the factor m.
B = sympy.Matrix(
    [
        [0, 0, 0],
        [0, 0, -1],
        [0, 0, 0],
        [
            -sqrt(2 / (5 * (3 + sqrt(5)))) * sqrt(k / m) / k,
            -(-5 + sqrt(5)) * sqrt(k / (6 * m + 2 * sqrt(5) * m)) / (5 * k),
            (5 - 3 * sqrt(5)) / (5 * sqrt(2 * (3 + sqrt(5))) * sqrt(k / m)),
        ],
        [0, 0, 0],
        [
            sqrt(Rational(2, 5)) / (sqrt(-(-3 + sqrt(5)) * k / m) * m),
            (5 + sqrt(5)) / (5 * sqrt(2) * sqrt(-(-3 + sqrt(5)) * k / m) * m),
            (5 + 3 * sqrt(5)) / (5 * sqrt(2) * sqrt(-(-3 + sqrt(5)) * k / m)),
        ],
    ]
)

#: The rows of B_F for m = 10, k = 2, worked out in rational arithmetic from the papers' C and J.
EXACT_B = {
    1: [0, 0, -1],
    3: [Rational(1, 20) - sqrt(5) / 20, Rational(3, 20) - sqrt(5) / 20, 2 - sqrt(5)],
    5: [Rational(1, 20) + sqrt(5) / 20, Rational(3, 20) + sqrt(5) / 20, 2 + sqrt(5)],
}


def is_zero(matrix) -> bool:
    """Of numbers in Q(sqrt(5)) times roots of k and m."""
    return all(sympy.expand(sympy.radsimp(sympy.sqrtdenest(entry))) == 0 for entry in matrix)


def test_smith_form():
    """(85)."""
    assert sympy.cancel(TWO_MASSES.smith_form()[2, 2] - s**2 * FINITE) == 0
    assert TWO_MASSES.smith_form()[:2, :2] == sympy.eye(2)
    assert TWO_MASSES.smith_form_at_infinity() == s**2 * sympy.eye(3)


def test_structure():
    structure = TWO_MASSES.structure()
    assert [(d.polynomial.degree(), d.exponents) for d in structure.elementary_divisors] == [(1, (2,)), (4, (1,))]
    assert structure.infinite_divisors == (0, 0, 0)
    assert structure.infinite_chains == ()
    assert structure.assumptions == ()
    origin, fast, slow = structure.finite_zeros
    assert (origin.value, origin.multiplicity, origin.partial_multiplicities) == (0, 2, (2,))
    for zero, way in ((fast, 1), (slow, -1)):
        assert is_zero([zero.value / sympy.I - sqrt(k / m) * (sqrt(5) + way) / 2])
        assert (zero.is_pair, zero.multiplicity, zero.count) == (True, 1, 2)


def test_jordan_form():
    """(87): the double zero, then two real blocks."""
    J = TWO_MASSES.jordan_pairs().finite.J
    assert J[:2, :2] == sympy.Matrix([[0, 1], [0, 0]])
    assert sum(entry != 0 for entry in J) == 5


def test_pair_is_that_of_the_paper_up_to_the_length_of_chains():
    """(86) and (88), corrected: C X and X^-1 B with X = diag(1, 1, g, g, 1/g, 1/g), which commutes with J, g = (3 + sqrt(5))/2."""
    pair = TWO_MASSES.jordan_pairs().finite
    X = sympy.diag(1, 1, SQUARE, SQUARE, 1 / SQUARE, 1 / SQUARE)
    assert is_zero(pair.C * X - C)
    difference = X.inv() * pair.B - B
    for values in ({m: 10, k: 2}, {m: 3, k: 7}):
        assert all(abs(sympy.N(entry.subs(values), 40)) < sympy.Float("1e-38", 40) for entry in difference)


def test_exact_values_of_b():
    pair = NUMBERS.jordan_pairs().finite
    X = sympy.diag(1, 1, SQUARE, SQUARE, 1 / SQUARE, 1 / SQUARE)
    expected = sympy.Matrix([EXACT_B.get(row, [0, 0, 0]) for row in range(6)])
    assert is_zero(X.inv() * pair.B - expected)
    assert [pair.J[2, 3], pair.J[4, 5]] == [sqrt(5) / 10 + Rational(1, 2), Rational(1, 2) - sqrt(5) / 10]


def test_position_level():
    A = two_masses(0)
    structure, pairs = A.structure(), A.jordan_pairs()
    assert structure.at_infinity == (2, 2, 0)
    assert structure.infinite_divisors == (0, 0, 2)
    assert sympy.cancel(A.smith_form()[2, 2] - FINITE) == 0
    N = sympy.Matrix([[1, 0, 0], [1, 0, 0], [-1, 1, 1]])
    assert pairs.jump_projector == sympy.diag(N, N)
    assert pairs.laurent(0) == sympy.Matrix([[0, 0, 0], [0, 0, -1], [0, 0, 1]])
    assert pairs.infinite.J == sympy.zeros(1)
    ten = {m: 10, k: 2}
    assert 10 * pairs.laurent(-2).subs(ten) == sympy.Matrix([[-1, 1, 2], [-1, 1, 2], [2, -1, -4]])


def test_velocity_level():
    A = two_masses(1)
    assert A.smith_form_at_infinity() == sympy.diag(s**2, s**2, s)
    assert A.structure().infinite_divisors == (0, 0, 1)
    assert sympy.cancel(A.smith_form()[2, 2] - s * FINITE) == 0


@pytest.mark.parametrize("level, orders", [(0, (2, 2, 0, 0)), (1, (2, 2, 1, 0)), (2, (2, 2, 2, 0))])
def test_with_a_multiplier_there_are_no_infinite_zeros(level, orders):
    """M is singular: not the index 3 of nonsingular mass matrices."""
    structure = with_multiplier(level).structure()
    assert structure.at_infinity == orders
    assert structure.highest_impulse == 0
