"""The exact structure against minors, published values and cases whose multiplicities are known."""

from fractions import Fraction
from itertools import combinations

import flint
import numpy as np
import pytest
import sympy

import mbconstrained as mb
from tests.exact.rational.products import MATRICES, known, larger_product
from tests.oracles import exact
from tests.oracles.models import massless_joints, two_masses
from tests.oracles.referee import NAMES, case
from tests.oracles.smith import partial_multiplicities

everywhere = pytest.mark.parametrize("name", MATRICES)

#: Cases whose answer belongs to the entries as they are; the others were rotated, and belong to entries before rounding.
AS_GIVEN = [name for name in NAMES if not name.startswith("rot_")]


def fractions(*numbers) -> tuple[Fraction, ...]:
    return tuple(Fraction(number) for number in numbers)


def polynomial(coefficients) -> flint.fmpq_poly:
    return flint.fmpq_poly([flint.fmpq(c.numerator, c.denominator) for c in coefficients])


@everywhere
def test_determinant_is_that_of_gauss_and_newton(name):
    assert list(known(name).structure.determinant) == exact.determinant(known(name).A.tolist())


@everywhere
def test_laurent_coefficients_are_those_of_long_division(name):
    x = known(name)
    expected = exact.laurent(x.A.tolist(), -x.q - 3)
    for index in range(-x.q - 3, max(expected) + 1):
        assert x.pairs.laurent(index).tolist() == expected[index]


@everywhere
def test_smith_form_has_the_greatest_common_divisors_of_minors(name):
    x, r = known(name), known(name).r
    below = flint.fmpq_poly([1])
    for size, invariant in enumerate(x.structure.invariant_polynomials, start=1):
        choices = list(combinations(range(r), size))
        minors = [polynomial(exact.minor(x.A.tolist(), rows, columns)) for rows in choices for columns in choices]
        divisor = flint.fmpq_poly([0])
        for minor in minors:
            divisor = divisor.gcd(minor)
        assert polynomial(invariant) == divisor / below / (divisor / below).leading_coefficient()
        below = divisor


@everywhere
def test_elementary_divisors_are_irreducible_and_distinct(name):
    divisors = [polynomial(divisor.polynomial) for divisor in known(name).structure.elementary_divisors]
    assert all(p.leading_coefficient() == 1 and len(p.factor()[1]) == 1 and p.factor()[1][0][1] == 1 for p in divisors)
    assert len({str(p) for p in divisors}) == len(divisors)


@everywhere
def test_orders_at_infinity_are_those_of_minors(name):
    x = known(name)
    assert list(x.structure.at_infinity) == exact.orders_at_infinity(x.A.tolist())
    assert x.structure.at_infinity[0] == x.q or not x.A[x.q].any()


@everywhere
def test_partial_multiplicities_of_gaussian_zeros(name):
    x = known(name)
    for zero in x.structure.finite_zeros:
        if zero.multiplicity > 1 and (2 * zero.value.real).is_integer() and (2 * zero.value.imag).is_integer():
            assert partial_multiplicities(x.A.tolist(), zero.value, zero.multiplicity) == list(zero.partial_multiplicities)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 6))])
def test_elementary_divisors_of_a_larger_product(seed):
    """U and V hide the diagonal, whose factors and exponents are known."""
    A, exponents = larger_product(seed)
    structure = mb.exact.structure(mb.PolynomialMatrix(A))
    assert {divisor.polynomial: divisor.exponents for divisor in structure.elementary_divisors} == exponents


@pytest.mark.parametrize("name", AS_GIVEN)
def test_structure_of_the_cases_of_the_referee(name):
    """Zeros agree to the last bit: both sides are the nearest float64 numbers."""
    record = case(name).record
    structure = mb.exact.structure(mb.PolynomialMatrix(case(name).coefficients))
    assert structure.finite_count == record["n"]
    assert sorted(d for d in structure.infinite_divisors if d) == sorted(record["infinite_divisors"])
    known_zeros = {(complex(float(z["re"]), float(z["im"])), z["mult"]) for z in record["eigenvalues"] if float(z["im"]) >= 0}
    assert {(zero.value, zero.multiplicity) for zero in structure.finite_zeros} == known_zeros
    partial = {complex(z["re"], z["im"]): tuple(z["partial"]) for z in record["partial_multiplicities"] if z["im"] >= 0}
    multiple = {zero.value: zero.partial_multiplicities for zero in structure.finite_zeros if zero.multiplicity > 1}
    assert multiple == partial


@pytest.mark.parametrize(
    "level, smith, infinite",
    [
        (0, fractions("1/25", 0, "3/5", 0, 1), (0, 0, 2)),
        (1, fractions(0, "1/25", 0, "3/5", 0, 1), (0, 0, 1)),
        (2, fractions(0, 0, "1/25", 0, "3/5", 0, 1), (0, 0, 0)),
    ],
)
def test_two_masses(level, smith, infinite):
    """Moysis et al., section 5.1, the constraint at each level."""
    structure = mb.exact.structure(mb.PolynomialMatrix(two_masses(level)))
    assert structure.invariant_polynomials == ((1,), (1,), smith)
    assert structure.infinite_divisors == infinite
    frequencies = [zero.value for zero in structure.finite_zeros if zero.value]
    assert frequencies == [0.27639320225002103036j, 0.72360679774997896964j]  # (5 -+ sqrt 5) / 10


def test_massless_joints():
    """Moysis et al., section 5.2."""
    structure = mb.exact.structure(mb.PolynomialMatrix(massless_joints()))
    assert structure.determinant == fractions(0, 216, 288, 1080)
    assert structure.invariant_polynomials == ((1,), (1,), fractions(0, "1/5", "4/15", 1))
    assert (structure.at_infinity, structure.infinite_divisors, structure.infinite_chains) == ((2, 1, 0), (0, 1, 2), (1,))


@pytest.mark.parametrize(
    "A", [[[[1, 2], [2, 4]]], [[[0, 0], [0, 0]], [[1, 0], [0, 0]]], [[[0.1, 0.3], [0.1, 0.3]], [[0.7, 0], [0.7, 0]]]]
)
def test_an_exact_determinant_of_zero_is_singular(A):
    with pytest.raises(mb.SingularPolynomialMatrix, match="det A\\(s\\) is zero for every s"):
        mb.exact.jordan_pairs(mb.PolynomialMatrix(A))
    with pytest.raises(mb.SingularPolynomialMatrix, match="equation 2"):
        mb.exact.jordan_pairs(mb.PolynomialMatrix(A))
    structure = mb.exact.structure(mb.PolynomialMatrix(A))
    assert (structure.determinant, structure.rank, len(structure.redundant_equations)) == ((), 1, 1)


def test_a_determinant_of_1e_300_is_regular():
    structure = mb.exact.structure(mb.PolynomialMatrix([[[1e-150, 0], [0, 1e-150]]]))
    assert structure.determinant == (Fraction(1e-150) ** 2,)
    nearly = mb.exact.structure(mb.PolynomialMatrix([[[1, 1], [1, np.nextafter(1, 2)]], [[0, 0], [0, 0]], [[0, 0], [1, 1]]]))
    assert nearly.determinant == (Fraction(2) ** -52,)
    assert nearly.infinite_divisors == (0, 4)


def test_elements_are_exact():
    """1e16 + 1 is 1e16 as a float64 number, as a sum of its elements it is not."""
    B = [[1.0, 0.0], [1.0, -1.0]]
    K = mb.ElementMatrix(B, [1.0, 1e16])
    assert mb.exact.structure(mb.PolynomialMatrix([K])).determinant == (10**16,)


def test_only_polynomial_matrices_have_an_exact_structure():
    with pytest.raises(mb.InputError, match="A: found an object of type list; expected a PolynomialMatrix"):
        mb.exact.structure([[[1.0]], [[1.0]]])


def test_a_symbolic_matrix_has_one_too():
    m, k = sympy.symbols("m k", positive=True)
    A = mb.SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]])
    assert mb.exact.structure(A) == A.structure() and mb.exact.jordan_pairs(A) is A.jordan_pairs()


def test_a_matrix_without_rows():
    structure = mb.exact.structure(mb.PolynomialMatrix(np.zeros((1, 0, 0))))
    assert (structure.determinant, structure.invariant_polynomials, structure.infinite_divisors) == ((1,), (), ())


def test_what_is_shown_is_short():
    """However long the numbers are: the determinant of random floats has thousands of digits."""
    random = np.random.default_rng(0)
    A = mb.PolynomialMatrix(random.standard_normal((3, 8, 8)))
    structure = mb.exact.structure(A)
    assert repr(structure.elementary_divisors[0]) == "ElementaryDivisor(degree 16, exponents (1,))" and len(repr(structure)) < 200
    one = mb.exact.structure(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[2.0]]]))
    assert repr(one.elementary_divisors[0]) == "ElementaryDivisor(s^2 + 0.5, exponents (1,))"
