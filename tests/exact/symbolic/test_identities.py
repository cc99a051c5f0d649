"""The identities between A(s), its pairs and H_i hold exactly, for every value of the symbols (Moysis et al., sections 2 and 3)."""

from itertools import pairwise

import pytest
import sympy

from mbconstrained.exact.engine import HypercompanionBlock
from tests.exact.symbolic.gallery import MODELS, coefficients_of, identity, over_field, powers, s, same, stacked

every = pytest.mark.parametrize("A", MODELS.values(), ids=MODELS)
of_some_degree = pytest.mark.parametrize(
    "A", [A for A in MODELS.values() if A.degree], ids=[name for name, A in MODELS.items() if A.degree]
)


def zero(A, *shape):
    return over_field(A, sympy.zeros(*shape))


def sums(A, terms, size=None):
    return sum(terms, zero(A, *(size or (A.size, A.size))))


def finite(A):
    pair = A.jordan_pairs().rational
    return tuple(over_field(A, matrix) for matrix in (pair.C, pair.J, pair.B))


def laurent(A):
    """i -> H_i over the field."""
    return lambda index: over_field(A, A.jordan_pairs().laurent(index))


def first_matrix(A):
    """M1 with the block A_(q-a+c) at (a, c), a >= c."""
    coefficients, q = coefficients_of(A), A.degree
    return stacked(A, [[coefficients[q - a + c] if a >= c else zero(A, A.size, A.size) for c in range(q)] for a in range(q)])


def second_matrix(A):
    """M0 with the block A_(c-a) at (a, c), c >= a."""
    coefficients, q = coefficients_of(A), A.degree
    return stacked(A, [[coefficients[c - a] if c >= a else zero(A, A.size, A.size) for c in range(q)] for a in range(q)])


@every
def test_adjugate_and_determinant(A):
    total = [
        [sum((A.polynomials[i][l] * A.adjugate[l][j] for l in range(A.size)), 0 * A.determinant) for j in range(A.size)]
        for i in range(A.size)
    ]
    assert all((total[i][j] - int(i == j) * A.determinant).is_zero for i in range(A.size) for j in range(A.size))


@every
def test_index_sum(A):
    structure = A.structure()
    assert structure.finite_count == A.determinant.degree()
    assert structure.finite_count + sum(structure.infinite_divisors) == A.size * A.degree
    assert sum(d.polynomial.degree() * d.multiplicity for d in structure.elementary_divisors) == structure.finite_count


@every
def test_invariant_polynomials_divide_each_other_and_multiply_to_the_determinant(A):
    found = A.structure().invariant_polynomials
    assert len(found) == A.size
    assert all(after.rem(before).is_zero for before, after in pairwise(found))
    assert (sympy.prod(found) - A.determinant.monic()).is_zero  # fractions over Q(sqrt(2)) are equal without looking so


@every
def test_laurent_coefficients_are_those_of_the_inverse(A):
    """sum of H_(k-j) A_j = sum of A_j H_(k-j) = delta_k I, and H_i = 0 above the highest zero at infinity (28)."""
    H, coefficients, top = laurent(A), coefficients_of(A), A.structure().highest_impulse
    for index in range(-2, top + A.degree + 1):
        expected = identity(A, A.size) if index == 0 else zero(A, A.size, A.size)
        assert same(sums(A, (H(index - j) * matrix for j, matrix in enumerate(coefficients))), expected)
        assert same(sums(A, (matrix * H(index - j) for j, matrix in enumerate(coefficients))), expected)
    assert same(H(top + 1), zero(A, A.size, A.size))
    assert top == 0 or not same(H(top), zero(A, A.size, A.size))


@every
def test_finite_pair_gives_the_laurent_coefficients_below(A):
    """C J^(i-1) B = H_-i (27b)."""
    C, J, B = finite(A)
    assert J.shape[0] == A.structure().finite_count
    for i, power in enumerate(powers(J, 4)):
        assert same(C * power * B, laurent(A)(-1 - i))


@every
def test_infinite_pair_gives_the_laurent_coefficients_above(A):
    """C J^i B = H_i (27a), J nilpotent, the sizes of its blocks are |q_i| + 1 for q_i <= 0 (23-24, corrected)."""
    pair, structure = A.jordan_pairs().infinite, A.structure()
    assert sorted(pair.lengths) == sorted(structure.infinite_chains)
    assert pair.J.rows == sum(structure.infinite_chains)
    C, J, B = (over_field(A, matrix) for matrix in (pair.C, pair.J, pair.B))
    *known, last = powers(J, structure.highest_impulse + 2)
    for i, power in enumerate(known):
        assert same(C * power * B, laurent(A)(i))
    assert same(last, zero(A, *J.shape))


@every
def test_chains_solve_both_equations(A):
    """sum of A_j C J^j = 0 and sum of J^j B A_j = 0."""
    C, J, B = finite(A)
    known = powers(J, A.degree + 1)
    assert same(sums(A, (M * C * p for M, p in zip(coefficients_of(A), known)), C.shape), zero(A, *C.shape))
    assert same(sums(A, (p * B * M for M, p in zip(coefficients_of(A), known)), B.shape), zero(A, *B.shape))


@of_some_degree
def test_states_are_told_from_the_initial_values(A):
    """[J^(q-1) B ... B] M1 col(C ... C J^(q-1)) = I_n."""
    C, J, B = finite(A)
    known = powers(J, A.degree)
    left, right = stacked(A, [[p * B for p in reversed(known)]]), stacked(A, [[C * p] for p in known])
    assert same(left * first_matrix(A) * right, identity(A, J.shape[0]))


@of_some_degree
def test_jump_projector(A):
    """P = col(C ...) [...] M1 is the projector given, of rank n, and P + [H_(c-k)] M0 = I ((61) corrected)."""
    C, J, B = finite(A)
    known, q = powers(J, A.degree), A.degree
    P = over_field(A, A.jordan_pairs().jump_projector)
    built = stacked(A, [[C * p] for p in known]) * stacked(A, [[p * B for p in reversed(known)]]) * first_matrix(A)
    assert same(P, built)
    assert same(P * P, P)
    assert P.rank() == J.shape[0]
    toeplitz = stacked(A, [[laurent(A)(c - a) for c in range(q)] for a in range(q)])
    assert same(P + toeplitz * second_matrix(A), identity(A, q * A.size))


@of_some_degree
def test_impulses_of_initial_values_row_by_row(A):
    """[H_(p-q+1) ... H_p] M1 = -[H_(p+1) ... H_(p+q)] M0 for p >= 0 (29), and the rank of all of them is the sum of the zero orders."""
    H, q, top = laurent(A), A.degree, A.structure().highest_impulse
    rows = []
    for p in range(q + top):
        left = stacked(A, [[H(p - q + 1 + c) for c in range(q)]]) * first_matrix(A)
        rows.append([stacked(A, [[H(p + 1 + c) for c in range(q)]]) * second_matrix(A)])
        assert same(left, -rows[-1][0])
    assert stacked(A, rows).rank() == sum(max(0, -order) for order in A.structure().at_infinity)


@of_some_degree
def test_infinite_jordan_pair(A):
    """Chains of the dual at 0: sum of A_j Cb Jb^(q-j) = 0, and with the finite pair they span everything."""
    q, n = A.degree, A.structure().finite_count
    blocks = [HypercompanionBlock(term) for term in A.dual.local_smith_form(0).terms]
    size = sum(block.J.rows for block in blocks)
    Cb = over_field(A, sympy.Matrix.hstack(sympy.zeros(A.size, 0), *(block.C for block in blocks)))
    Jb = over_field(A, sympy.diag(*(block.J for block in blocks)))
    known = powers(Jb, q + 1)
    assert same(sums(A, (M * Cb * known[q - j] for j, M in enumerate(coefficients_of(A))), Cb.shape), zero(A, *Cb.shape))
    C, J, _ = finite(A)
    both = stacked(A, [[C * power, Cb * known[q - 1 - i]] for i, power in enumerate(powers(J, q))])
    assert n + size == q * A.size
    assert both.rank() == q * A.size


@every
def test_jordan_chains_are_chains(A):
    """A(s) (v_0 + v_1 (s - x) + ...) = O((s - x)^k) at every zero x of p, as polynomials in x modulo p."""
    for chain in A.jordan_pairs().chains:
        p, rows = chain.polynomial, A.polynomials
        for order in range(chain.length):
            for row in rows:
                terms = (_derivative(row[l], i) * chain.right[order - i][l] for i in range(order + 1) for l in range(A.size))
                assert sum(terms, 0 * p).rem(p).is_zero
        assert any(not entry.is_zero for entry in chain.right[0])


def _derivative(p, order):
    for step in range(order):
        p = p.diff() * sympy.Poly.from_list([p.domain.one / p.domain.convert(step + 1)], s, domain=p.domain)
    return p
