"""PolynomialMatrix: what it accepts, what it evaluates to, what it refuses."""

import numpy as np
import pytest

import mbconstrained as mb

A0, A1, A2 = np.array([[1, 2], [3, 4]]), np.eye(2), np.diag([5.0, 0.0])


def test_evaluation_is_horners_sum_at_real_and_complex_points():
    A = mb.PolynomialMatrix([A0, A1, A2])
    for s in (0, 2.0, -1.5, 1j, 0.5 - 2j):
        assert np.allclose(A(s), A0 + A1 * s + A2 * s**2, rtol=1e-15)
    assert np.isrealobj(A(2.0))


def test_degree_is_declared_not_found():
    A = mb.PolynomialMatrix([A0, A1, np.zeros((2, 2))])
    assert (A.degree, A.size) == (2, 2)
    assert repr(A) == "PolynomialMatrix(degree=2, size=2)"


def test_integers_are_converted_and_the_data_is_copied_and_locked():
    mine = np.array([[[1, 2], [3, 4]]])
    A = mb.PolynomialMatrix(mine)
    mine[0, 0, 0] = 99
    assert A.coefficients.dtype == float
    assert A.coefficients[0, 0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        A.coefficients[0, 0, 0] = 2.0


def test_dual_reverses_the_coefficients():
    A = mb.PolynomialMatrix([A0, A1, A2], coordinates=["a", "b"])
    assert np.array_equal(A.dual.coefficients, A.coefficients[::-1])
    assert A.dual.coordinates == ("a", "b")
    assert np.allclose(A.dual(0.5), 0.25 * A(2.0))


@pytest.mark.parametrize(
    "coefficients, text",
    [
        ([], "a polynomial matrix needs at least one coefficient, A_0; none was given"),
        ([[1.0, 2.0]], r"A_0: expected a matrix, found shape \(2,\)"),
        ([np.eye(2), np.eye(3)], r"A_1 has shape \(3, 3\), but A_0 has \(2, 2\); all must agree"),
        ([np.eye(2), [[1, 2], [3]]], "A_1: the rows have different lengths"),
        ([np.eye(2) * 1j], "A_0: complex numbers found; only real data is accepted"),
        ([np.eye(2), np.diag([1.0, np.nan])], r"A_1: the entry at \(1, 1\) is nan; every entry must be a finite number"),
        ([[["k"]]], "A_0: found .*'k'.*; expected numbers"),
        (5, "coefficients|polynomial matrix"),
    ],
)
def test_what_is_no_polynomial_matrix_is_refused(coefficients, text):
    with pytest.raises(mb.InputError, match=text):
        mb.PolynomialMatrix(coefficients)


@pytest.mark.parametrize(
    "names, text",
    [
        ({"coordinates": ["a"]}, "coordinates: 1 names given for 2; give one each"),
        ({"equations": ["a", "a"]}, 'equations: the name "a" is used twice; names must differ'),
    ],
)
def test_names_must_fit(names, text):
    with pytest.raises(mb.InputError, match=text):
        mb.PolynomialMatrix([A0], **names)


WIDE, TALL = np.ones((3, 2, 3)), np.ones((3, 3, 2))


def test_equations_and_coordinates_may_differ_in_number():
    A = mb.PolynomialMatrix(WIDE, coordinates=["a", "b", "c"], equations=["first", "second"])
    assert (A.shape, A.degree, A.is_square, A.is_regular) == ((2, 3), 2, False, False)
    assert repr(A) == "PolynomialMatrix(degree=2, shape=(2, 3))"
    assert np.array_equal(A(2.0), np.full((2, 3), 7.0))
    assert A.dual.coordinates == ("a", "b", "c")
    with pytest.raises(mb.InputError, match="coordinates: 2 names given for 3"):
        mb.PolynomialMatrix(WIDE, coordinates=["a", "b"])


NEEDS_A_MOTION = {
    "size": lambda A: A.size,
    "jordan_pairs": lambda A: A.jordan_pairs(),
    "check_regular": lambda A: A.check_regular(),
    "eigenvalues": lambda A: A.eigenvalues,
    "eigenvalue_count": lambda A: A.eigenvalue_count,
    "reduction": lambda A: A.reduction,
    "exact.jordan_pairs": mb.exact.jordan_pairs,
    "frequency_response": lambda A: mb.frequency_response(A, [1.0]),
    "admissible": mb.admissible,
    "boundary_solve": lambda A: mb.boundary_solve(A, start={}, end={}, duration=1.0),
    "characteristic_roots": lambda A: mb.characteristic_roots(A, {1.0: [np.eye(2)]}),
    "solve_discrete": mb.solve_discrete,
    "matrix_fraction_response": lambda A: mb.matrix_fraction_response([np.eye(2)], A, mb.step([1.0, 0.0])),
}


@pytest.mark.parametrize("name", NEEDS_A_MOTION)
@pytest.mark.parametrize("coefficients, text", [(WIDE, "2 equations for 3 coordinates"), (TALL, "3 equations for 2 coordinates")])
def test_what_needs_a_regular_matrix_refuses_another(name, coefficients, text):
    with pytest.raises(mb.SingularPolynomialMatrix, match=text):
        NEEDS_A_MOTION[name](mb.PolynomialMatrix(coefficients))
