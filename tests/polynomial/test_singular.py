"""det A(s) = 0 for every s is an error that names the equations that depend on each other and the free coordinates."""

import numpy as np
import pytest

import mbconstrained as mb


def coefficients(*rows) -> np.ndarray:
    """A(s) from rows of polynomials, each a tuple of its coefficients in ascending powers."""
    r = len(rows)
    A = np.zeros((1 + max(len(p) - 1 for row in rows for p in row), r, r))
    for i, row in enumerate(rows):
        for j, polynomial in enumerate(row):
            A[: len(polynomial), i, j] = polynomial
    return A


O, ONE, S = (0,), (1,), (0, 1)  # 0, 1 and s

SINGULAR = {
    "the 1 x 1 zero": (coefficients([O]), (0,), (0,)),
    "zeros of any declared degree": (np.zeros((3, 2, 2)), (0, 1), (0, 1)),
    "an empty row": (coefficients([(1, 1), O, ONE], [O, O, O], [ONE, S, (2,)]), (1,), (0, 1, 2)),
    "an empty column": (coefficients([(1, 1), O, S], [ONE, O, S], [(2, 0, 1), O, (3,)]), (0, 1, 2), (1,)),
    "equal rows": (coefficients([ONE, S, O], [O, O, (1, 1)], [ONE, S, O]), (0, 2), (0, 1)),
    "one row s + 1 times another": (coefficients([ONE, (2,), O], [(1, 1), (2, 2), O], [O, O, (0, 0, 1)]), (0, 1), (0, 1)),
    "rows that depend through s only": (coefficients([S, (0, 0, 1), O], [ONE, S, O], [O, O, ONE]), (0, 1), (0, 1)),
    "a free coordinate in a product": (coefficients([S, (0, 0, 1)], [(2,), (0, 2)]), (0, 1), (0, 1)),
    "a sum of two rows is the third": (coefficients([ONE, S, O], [O, ONE, (1, 1)], [ONE, (1, 1), (1, 1)]), (0, 1, 2), (0, 1, 2)),
    "two independent faults": (coefficients([O, O, O], [O, ONE, ONE], [O, ONE, ONE]), (0, 1, 2), (0, 1, 2)),
    "a constraint stated twice": (
        np.array([[[2.0, 0, 1, 1], [0, 3, -1, -1], [1, -1, 0, 0], [1, -1, 0, 0]], np.diag([0.0] * 4), np.diag([1.0, 1, 0, 0])]),
        (2, 3),
        (2, 3),
    ),
}


@pytest.mark.parametrize("name", SINGULAR)
def test_singular_matrices_name_equations_and_coordinates(name):
    A, equations, coordinates = SINGULAR[name]
    matrix = mb.PolynomialMatrix(A)
    assert not matrix.is_regular
    with pytest.raises(mb.SingularPolynomialMatrix, match=r"det A\(s\) is zero for every s") as caught:
        matrix.jordan_pairs()
    assert caught.value.equations == equations
    assert caught.value.coordinates == coordinates


@pytest.mark.parametrize("name", SINGULAR)
@pytest.mark.parametrize("seed", range(3))
def test_scattered_units_do_not_hide_a_singular_matrix(name, seed):
    """Rows, columns and time in powers of two between 2^-20 and 2^20."""
    A, equations, coordinates = SINGULAR[name]
    random = np.random.default_rng(seed)
    rows, columns = np.exp2(random.integers(-20, 21, (2, len(A[0]))))
    times = np.exp2(random.integers(-20, 21)) ** np.arange(len(A))
    with pytest.raises(mb.SingularPolynomialMatrix) as caught:
        mb.PolynomialMatrix(rows[:, None] * A * columns * times[:, None, None]).jordan_pairs()
    assert (caught.value.equations, caught.value.coordinates) == (equations, coordinates)


@pytest.mark.parametrize("name", SINGULAR)
@pytest.mark.parametrize("seed", range(3))
def test_rotation_and_rounding_do_not_hide_a_singular_matrix(name, seed):
    """Q A(s) Z with orthogonal Q, Z, every entry rounded: singular no more in exact arithmetic, but to within its data."""
    A = SINGULAR[name][0]
    random = np.random.default_rng(seed)
    Q, Z = (np.linalg.qr(random.normal(size=A[0].shape))[0] for _ in range(2))
    assert not mb.PolynomialMatrix(Q @ A @ Z).is_regular


@pytest.mark.parametrize("smallest", [1e-14, 1e-100, 1e-300])
def test_a_small_entry_is_not_a_zero(smallest):
    """diag(1, 1e-14) is regular: its units are unusual, nothing more. diag(1, 0) is singular."""
    assert mb.PolynomialMatrix([np.diag([1.0, smallest])]).is_regular
    assert not mb.PolynomialMatrix([np.diag([1.0, 0.0])]).is_regular


def test_nearly_parallel_rows_are_independent():
    """[1, 1; 1, 1 + 1e-9] is regular, [1, 1; 1, 1] is not."""
    assert mb.PolynomialMatrix([[[1.0, 1.0], [1.0, 1.0 + 1e-9]]]).is_regular
    assert not mb.PolynomialMatrix([[[1.0, 1.0], [1.0, 1.0]]]).is_regular


def test_a_determinant_that_vanishes_only_at_points_is_regular():
    assert mb.PolynomialMatrix([np.diag([1.0, 0.0]), np.diag([0.0, 1.0])]).is_regular
