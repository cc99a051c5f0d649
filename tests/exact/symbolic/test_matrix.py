"""SymbolicPolynomialMatrix: shapes, names, values, determinants and numerators."""

import numpy as np
import pytest
import sympy

import mbconstrained as mb
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.gallery import MODELS, s
from tests.exact.symbolic.models import MASSLESS_JOINTS, OSCILLATOR, TWO_MASSES, k, m

every = pytest.mark.parametrize("A", MODELS.values(), ids=MODELS)


@pytest.mark.parametrize(
    "coefficients, message",
    [
        ([], "at least one coefficient"),
        (5, "found 5; expected a list"),
        ("ab", "found 'ab'; expected a list"),
        (sympy.eye(2), "expected a list of square matrices"),
        ([[]], "A_0: found no rows"),
        ([[1]], "A_0: found 1 row of 0 entries"),
        ([[[1, 2]]], "A_0: found 1 row of 2 entries"),
        ([[[1, 2], [3]]], "A_0: found 2 rows of 1 or 2 entries"),
        (["ab"], "A_0: found 'ab'"),
        ([["ab", "cd"]], "A_0: found 2 rows"),
        ([[[1]], [[1, 0], [0, 1]]], "A_1 has 2 rows, but A_0 has 1"),
    ],
)
def test_other_shapes_are_refused(coefficients, message):
    with pytest.raises(mb.InputError, match=message):
        SymbolicPolynomialMatrix(coefficients)


def test_matrices_may_be_given_in_every_usual_form():
    forms = ([[k, 0], [0, 1]], sympy.diag(k, 1), sympy.diag(k, 1).as_immutable(), np.array([[k, 0], [0, 1]]), ((k, 0), (0, 1)))
    assert {SymbolicPolynomialMatrix([form]).coefficients for form in forms} == {(sympy.diag(k, 1).as_immutable(),)}


@every
def test_determinant_is_that_of_the_values(A):
    """Against elimination-free cofactor expansion of A(s) as expressions."""
    assert sympy.cancel(A.determinant.as_expr() - A(s).det(method="laplace"), extension=True) == 0


@every
def test_the_adjugate_times_the_matrix_is_the_determinant(A):
    r = range(A.size)
    total = [[sum((A.polynomials[i][l] * A.adjugate[l][j] for l in r), 0 * A.determinant) for j in r] for i in r]
    assert all((total[i][j] - int(i == j) * A.determinant).is_zero for i in r for j in r)


@pytest.mark.parametrize(
    "entries", [[[0, 1], [1, 0]], [[0, 0], [0, 0]], [[0, 1, 0], [0, 0, 1], [k, 0, 0]], [[1, 1], [1, -1]]], ids=str
)
def test_adjugates_where_the_characteristic_polynomial_has_gaps(entries):
    A = SymbolicPolynomialMatrix([entries])
    assert sympy.Matrix([[p.as_expr() for p in row] for row in A.adjugate]) == sympy.Matrix(entries).adjugate()


def test_a_singular_matrix_names_equations_and_coordinates():
    """Rows 1 and 3 are multiples of each other, and only x2 + x3 is determined."""
    A = SymbolicPolynomialMatrix(
        [[[0, k, k], [1, 0, 0], [0, 1, 1]], [[0, 0, 0], [k, 0, 0], [0, 0, 0]]], coordinates=["x", "y", "z"]
    )
    with pytest.raises(mb.SingularPolynomialMatrix, match='"equation 1", "equation 3" are dependent .* "y", "z" can move') as found:
        A.structure()
    assert found.value.equations == (0, 2)
    assert found.value.coordinates == (1, 2)
    for ask in (
        lambda: A.determinant,
        A.smith_form,
        A.smith_form_at_infinity,
        lambda: A.jordan_pairs().finite,
        lambda: A.jordan_pairs().laurent,
    ):
        with pytest.raises(mb.SingularPolynomialMatrix):
            ask()


def test_what_is_singular_for_one_value_of_a_symbol_only_is_regular():
    A = SymbolicPolynomialMatrix([[[1, 1], [1, k]], [[0, 0], [0, 0]]])
    assert A.determinant.as_expr() == k - 1
    assert A.assumptions == (k - 1,)


def test_numbers_of_a_numerical_matrix_are_the_rationals_they_are():
    A = SymbolicPolynomialMatrix.of(mb.PolynomialMatrix([[[0.1]], [[2.0]]], coordinates=["x"]))
    assert A.coefficients[0][0, 0] == sympy.Rational(*(0.1).as_integer_ratio())
    assert A.coordinates == ("x",)
    assert A.symbols == ()
    assert A.field == sympy.QQ


@pytest.mark.parametrize(
    "given, name",
    [
        ([[1]], "list"),
        (mb.MechanicalSystem(mass=[[1.0]], stiffness=[[2.0]]), "MechanicalSystem"),
        (OSCILLATOR, "SymbolicPolynomialMatrix"),
    ],
)
def test_only_numerical_matrices_are_taken_as_such(given, name):
    with pytest.raises(mb.InputError, match=f"A: found an object of type {name}; expected a PolynomialMatrix"):
        SymbolicPolynomialMatrix.of(given)


@pytest.mark.parametrize("index", [1.0, True, "1", None])
def test_laurent_takes_whole_numbers(index):
    with pytest.raises(mb.InputError, match="expected a whole number"):
        MASSLESS_JOINTS.jordan_pairs().laurent(index)


def test_local_smith_forms():
    A = TWO_MASSES
    assert A.local_smith_form(0).exponents == (0, 0, 2)
    assert A.local_smith_form(0).matrix == sympy.diag(1, 1, s**2)
    assert A.local_smith_form(k / m).exponents == (0, 0, 0)
    zero = A.structure().finite_zeros[1].value
    assert A.local_smith_form(zero).exponents == (0, 0, 1)
    assert A.local_smith_form(zero).matrix[2, 2] == s - zero


@pytest.mark.parametrize(
    "zero, message", [("0", "found '0'"), (sympy.Symbol("other"), "found other"), (sympy.I, "found I"), (sympy.sqrt(k), "sqrt")]
)
def test_local_smith_forms_are_refused_elsewhere(zero, message):
    with pytest.raises(mb.InputError, match=message):
        TWO_MASSES.local_smith_form(zero)
