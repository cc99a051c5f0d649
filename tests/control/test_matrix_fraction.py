"""Systems with several inputs and outputs, D(s)^-1 N(s): entry by entry, through common factors, at infinity."""

import numpy as np
import pytest

import mbconstrained as mb

TIMES = np.array([0.05, 0.7, 3.0])


def test_a_diagonal_fraction_is_its_scalar_fractions():
    D = [np.diag([2.0, 5.0]), np.diag([3.0, 2.0]), np.eye(2)]
    N = [[[1.0, 0.0], [2.0, 1.0]], [[0.0, 3.0], [1.0, 0.0]]]
    y = mb.matrix_fraction_response(N, D, mb.step([1.0, 0.0]) + mb.ramp([0.0, 1.0]))
    entries = [[([1], 1), ([3, 0], 2)], [([1, 2], 1), ([1], 2)]]
    for row, (a, inputs) in enumerate(zip(([1, 3, 2], [1, 2, 5]), entries)):
        total = sum(mb.transfer_function_response(b, a, gamma)(TIMES)[0] for b, gamma in inputs)
        assert y(TIMES)[row] == pytest.approx(total, rel=1e-12)


def test_a_coupled_fraction_against_its_determinant():
    """D = [[s + 1, 1], [-2, s]], D^-1 = [[s, -1], [2, s + 1]] / (s^2 + s + 2)."""
    D, N = [[[1.0, 1.0], [-2.0, 0.0]], np.eye(2)], [[[1.0], [0.0]], [[0.0], [3.0]]]  # N = (1, 3 s)
    a = [1, 1, 2]
    for gamma in (-1, 0, 1, 3):
        y = mb.matrix_fraction_response(N, D, mb.power([1.0], gamma))
        first = mb.transfer_function_response([-2, 0], a, gamma)  # s - 3 s
        second = mb.transfer_function_response([3, 3, 2], a, gamma)
        assert y(TIMES)[0] == pytest.approx(first(TIMES)[0], rel=1e-11) and y(TIMES)[1] == pytest.approx(
            second(TIMES)[0], rel=1e-11
        )
        for k in range(max(len(first.impulses), len(second.impulses), len(y.impulses))):
            expected = [x.impulses[k][0] if k < len(x.impulses) else 0.0 for x in (first, second)]
            assert y.impulses[k] == pytest.approx(expected, rel=1e-13, abs=1e-14)


def test_a_common_left_factor_leaves_the_response():
    L = [np.array([[1.0, 1.0], [0.0, 2.0]]), np.array([[1.0, 0.0], [1.0, 1.0]])]  # L_0 + L_1 s
    D, N = [np.array([[1.0, 1.0], [-2.0, 0.5]]), np.eye(2)], [np.array([[1.0], [2.0]]), np.array([[0.0], [1.0]])]
    u = mb.step([1.0]) + mb.harmonic([2.0], angular_frequency=3.0)
    y = mb.matrix_fraction_response(N, D, u)
    z = mb.matrix_fraction_response(_product(L, N), _product(L, D), u)
    assert z(TIMES) == pytest.approx(y(TIMES), rel=1e-11)


def test_a_singular_highest_coefficient_is_a_pole_at_infinity():
    """D = [[1, s], [0, 1]], N = (0, 1): y = (-u', u), a Dirac impulse for a step."""
    y = mb.matrix_fraction_response([[[0.0], [1.0]]], [np.eye(2), [[0.0, 1.0], [0.0, 0.0]]], mb.step([2.0]))
    assert [c.tolist() for c in y.impulses] == [[-2.0, 0.0]] and y(1.0).tolist() == [0.0, 2.0]


def test_a_constant_denominator():
    y = mb.matrix_fraction_response([np.eye(2), np.eye(2)], [np.diag([2.0, 4.0])], mb.ramp([1.0, 1.0]))
    assert y(3.0).tolist() == [2.0, 1.0]


def test_no_output():
    y = mb.matrix_fraction_response([np.zeros((2, 3))], [np.eye(2), np.eye(2)], mb.step([1.0, 2.0, 3.0]))
    assert not y(TIMES).any() and y.impulses == ()


@pytest.mark.parametrize(
    "denominator, numerator, u, words",
    [
        ([np.eye(2)], [], mb.step([1.0]), "numerator: it needs at least one coefficient"),
        ([np.eye(2)], 3.0, mb.step([1.0]), "numerator: found 3.0"),
        ([np.eye(2)], [np.eye(3)], mb.step([1.0]), "N_0: expected shape 2 x any, found 3 x 3"),
        ([np.eye(2)], [np.eye(2), np.ones((2, 1))], mb.step([1.0, 1.0]), "N_1 has shape (2, 1), but N_0 has (2, 2)"),
        ([np.eye(2)], [np.eye(2)], mb.step([1.0]), "input: it has 1 row; expected 2"),
        ([np.eye(2)], [np.eye(2)], 1, "input: found int"),
        ([np.eye(2)], [np.full((2, 2), np.nan)], mb.step([1.0, 1.0]), "N_0: the entry at (0, 0) is nan"),
    ],
)
def test_what_does_not_fit_is_told(denominator, numerator, u, words):
    with pytest.raises(mb.InputError) as error:
        mb.matrix_fraction_response(numerator, denominator, u)
    assert words in str(error.value)


def test_a_singular_denominator_is_an_error():
    with pytest.raises(mb.SingularPolynomialMatrix):
        mb.matrix_fraction_response([np.eye(2)], [np.ones((2, 2)), np.ones((2, 2))], mb.step([1.0, 1.0]))


def _product(one, two):
    total = [np.zeros((one[0].shape[0], two[0].shape[1])) for _ in range(len(one) + len(two) - 1)]
    for i, a in enumerate(one):
        for j, b in enumerate(two):
            total[i + j] = total[i + j] + a @ b
    return total
