"""J in Jordan form with zeros in radicals: the same C J^i B as by long division, in 40 digits at some values of the symbols."""

import mpmath
import pytest
import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.gallery import MODELS, PRODUCTS, s
from tests.exact.symbolic.models import MASSLESS_JOINTS, TWO_MASSES, k, m

DIGITS = 40
VALUES = {"k": sympy.Rational(7, 5), "m": sympy.Rational(3, 11), "k1": 2, "k2": 3, "c1": sympy.Rational(1, 7), "c2": 5}
WITH_ZEROS = {name: A for name, A in MODELS.items() if A.determinant.degree() > 0}


def numbers(matrix, symbols, offset) -> mpmath.matrix:
    rows = matrix.xreplace({symbol: sympy.S(VALUES[symbol.name] + offset) for symbol in symbols}).tolist()
    return mpmath.matrix([[mpmath.mpmathify(sympy.N(entry, DIGITS + 20)) for entry in row] for row in rows])


@pytest.mark.parametrize("offset", [0, 2])
@pytest.mark.parametrize("A", WITH_ZEROS.values(), ids=WITH_ZEROS)
def test_jordan_pair_gives_the_laurent_coefficients(A, offset):
    pair, laurent = A.jordan_pairs().finite, A.jordan_pairs().laurent
    with mpmath.workdps(DIGITS + 20):
        C, J, B = (numbers(matrix, A.symbols, offset) for matrix in (pair.C, pair.J, pair.B))
        for i in range(5):
            H = numbers(laurent(-1 - i), A.symbols, offset)
            assert mpmath.norm(C * B - H, mpmath.inf) <= mpmath.mpf(10) ** -DIGITS * (1 + mpmath.norm(H, mpmath.inf))
            C = C * J


def kinds(A):
    return [(block.kind, block.length, block.J.rows) for block in A.jordan_pairs().finite.blocks]


def test_kinds_of_blocks():
    assert kinds(PRODUCTS["rational, derogatory"]) == [("jordan", 1, 1), ("jordan", 3, 3)]
    assert kinds(PRODUCTS["complex pair, twice"]) == [("real jordan", 1, 2), ("real jordan", 2, 4)]
    assert kinds(PRODUCTS["quartic in squares"]) == [("real jordan", 2, 4), ("real jordan", 2, 4)]
    assert kinds(PRODUCTS["cubic"]) == [("hypercompanion", 1, 3), ("hypercompanion", 2, 6)]
    assert kinds(PRODUCTS["no zeros"]) == []


def test_overdamped_or_underdamped_is_left_to_the_symbols():
    """m s^2 + 2 s + k: -1/m +- sqrt(1 - k m)/m, of both kinds."""
    A = PRODUCTS["damped pair"]
    assert kinds(A) == [("jordan", 2, 2), ("jordan", 2, 2)]
    assert A.assumptions == (k * m - 1,)
    assert {zero.value for zero in A.structure().finite_zeros} == {
        -1 / m - sympy.sqrt(1 - k * m) / m,
        -1 / m + sympy.sqrt(1 - k * m) / m,
    }


def test_real_block_of_a_double_pair():
    """[[D, I], [0, D]] with D = [[a, b], [-b, a]] (38)."""
    J = PRODUCTS["complex pair, twice"].jordan_pairs().finite.J[2:, 2:]
    w = sympy.sqrt(k) / sympy.sqrt(m)
    assert J == sympy.Matrix([[0, w, 1, 0], [-w, 0, 0, 1], [0, 0, 0, w], [0, 0, -w, 0]])


def test_one_factor_without_a_closed_form_has_the_state_matrix():
    """[0 I; -A_2^-1 A_0, -A_2^-1 A_1]; its characteristic polynomial is the determinant."""
    A = MODELS["one factor"]
    (block,) = A.jordan_pairs().finite.blocks
    assert (block.kind, block.zero) == ("companion", None)
    assert block.J == sympy.Matrix([[0, 0, 1, 0], [0, 0, 0, 1], [-2 * k / m, k / m, -1 / m, 0], [k, -k, 0, 0]])
    assert sympy.cancel(block.J.charpoly(s).as_expr() - A.determinant.monic().as_expr()) == 0


@pytest.mark.long
def test_three_masses_with_every_parameter_free():
    """Nine springs and dampers: no closed form of the zeros, and still a pair."""
    masses, springs, dampers = (sympy.symbols(f"{name}1:4", positive=True) for name in "mkc")
    rows = [sympy.Matrix(3, 3, lambda i, j, v=v: _tridiagonal(v, i, j)) for v in (springs, dampers)]
    pairs = SymbolicPolynomialMatrix([*rows, sympy.diag(*masses)]).jordan_pairs()
    assert [block.kind for block in pairs.finite.blocks] == ["companion"]
    assert pairs.structure.infinite_divisors == (0, 0, 0)
    assert pairs.assumptions == ()
    C, J, B = pairs.finite.C, pairs.finite.J, pairs.finite.B
    for i in range(4):
        assert (C * J**i * B - pairs.laurent(-1 - i)).applyfunc(sympy.cancel) == sympy.zeros(3)


def _tridiagonal(values, i, j):
    if i == j:
        return values[i] + (values[i + 1] if i + 1 < len(values) else 0)
    return -values[max(i, j)] if abs(i - j) == 1 else 0


def test_symbols_are_positive_whether_declared_so_or_not():
    plain = {symbol: sympy.Symbol(symbol.name) for symbol in (k, m)}
    pair, known = (
        A.jordan_pairs().finite
        for A in (SymbolicPolynomialMatrix([M.xreplace(plain) for M in TWO_MASSES.coefficients]), TWO_MASSES)
    )
    back = {symbol: positive for positive, symbol in plain.items()}
    for name in ("C", "J", "B"):
        difference = getattr(pair, name).subs(back) - getattr(known, name)
        assert difference.applyfunc(sympy.simplify) == sympy.zeros(*difference.shape)
    assert pair.J.free_symbols == set(back)


@pytest.mark.parametrize("A", [TWO_MASSES, MASSLESS_JOINTS], ids=["two masses", "massless joints"])
def test_assumptions_of_the_pairs_hold_those_of_the_structure(A):
    assert set(A.assumptions) <= set(A.jordan_pairs().assumptions)
