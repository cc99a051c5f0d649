"""The identities between A(s), its exact pairs and H_i (Moysis et al., section 2, corrected), with == throughout."""

from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb
from tests.exact.rational.products import MATRICES, identity, known, power, rank, same, zeros
from tests.oracles import exact

everywhere = pytest.mark.parametrize("name", MATRICES)


@everywhere
def test_laurent_coefficients_are_those_of_long_division(name):
    x = known(name)
    expected = exact.laurent(x.A.tolist(), -x.q - 3)
    for index in range(-x.q - 3, x.highest + 3):
        assert same(x.H(index), np.array(expected.get(index, zeros(x.r, x.r)), dtype=object))


@everywhere
def test_laurent_coefficients_convolve_with_a_to_the_identity(name):
    """sum_j H_(k-j) A_j = sum_j A_j H_(k-j) = delta_k I."""
    x = known(name)
    for k in range(-x.q - 1, x.highest + x.q + 2):
        expected = identity(x.r) if k == 0 else zeros(x.r, x.r)
        assert same(sum(x.H(k - j) @ x.A[j] for j in range(x.q + 1)), expected)
        assert same(sum(x.A[j] @ x.H(k - j) for j in range(x.q + 1)), expected)


@everywhere
def test_laurent_coefficients_end_at_the_highest_impulse(name):
    x = known(name)
    assert not x.H(x.highest + 1).any()
    assert not x.highest or x.H(x.highest).any()


@everywhere
def test_both_pairs_give_the_laurent_coefficients(name):
    """C_inf J_inf^i B_inf = H_i for i >= 0, C J^(i-1) B = H_-i for i >= 1 (Eq. 27)."""
    x = known(name)
    finite, infinite = x.pairs.finite, x.pairs.infinite
    for index in range(x.highest + 2):
        assert same(x.H(index), infinite.C @ power(infinite.J, index) @ infinite.B + zeros(x.r, x.r))
    for index in range(1, 2 * x.q + 2):
        assert same(x.H(-index), finite.C @ power(finite.J, index - 1) @ finite.B + zeros(x.r, x.r))


@everywhere
def test_finite_pair_is_a_pair_of_a(name):
    """sum A_j C J^j = 0, sum J^j B A_j = 0, and C, J is minimal."""
    x = known(name)
    C, J, B = x.pairs.finite.C, x.pairs.finite.J, x.pairs.finite.B
    assert same(sum(x.A[j] @ C @ power(J, j) for j in range(x.q + 1)) + zeros(x.r, x.n), zeros(x.r, x.n))
    assert same(sum(power(J, j) @ B @ x.A[j] for j in range(x.q + 1)) + zeros(x.n, x.r), zeros(x.n, x.r))
    assert rank(x.observed) == x.n


@everywhere
def test_finite_pair_is_normalized(name):
    """[J^(q-1) B ... B] M1 col(C ... C J^(q-1)) = I_n."""
    x = known(name)
    assert same(x.steered @ x.M1 @ x.observed + zeros(x.n, x.n), identity(x.n))


@everywhere
def test_jump_projector(name):
    """P = col(C ..) [..] M1 is a projector of rank n, and P + [H_(c-k)] M0 = I (Eq. 61, corrected)."""
    x = known(name)
    P = x.observed @ x.steered @ x.M1 + zeros(x.r * x.q, x.r * x.q)
    assert same(P @ P + 0 * P, P)
    assert rank(P) == x.n
    toeplitz = x.blocks(lambda k, c: x.H(c - k), x.q, x.q)
    assert same(P + toeplitz @ x.M0, identity(x.r * x.q))


@everywhere
def test_laurent_coefficients_solve_the_block_equations(name):
    """(29), row by row: [H_(p-q+1) ... H_p] M1 = -[H_(p+1) ... H_(p+q)] M0 for p = q + qh - 1 ... 0."""
    x = known(name)
    for p in range(x.q + x.highest):
        past = np.hstack([zeros(x.r, 0), *(x.H(p - x.q + 1 + k) for k in range(x.q))])
        ahead = np.hstack([zeros(x.r, 0), *(x.H(p + 1 + k) for k in range(x.q))])
        assert same(past @ x.M1 + zeros(x.r, x.r * x.q), -(ahead @ x.M0) + zeros(x.r, x.r * x.q))


@everywhere
def test_impulse_map(name):
    """The impulses of values at 0- are -[H_(p+1) ... H_(p+q)] M0 X0; their number is the sum of the orders of infinite zeros."""
    x = known(name)
    maps = [np.hstack([zeros(x.r, 0), *(x.H(p + 1 + k) for k in range(x.q))]) @ x.M0 for p in range(x.highest)]
    assert rank(x.stacked(maps, (0, x.r * x.q))) == sum(max(0, -order) for order in x.structure.at_infinity)
    initial = np.array([[Fraction(3 * i + k * k + 1) for k in range(x.r)] for i in range(x.q)], dtype=object).reshape(x.q, x.r)
    transform = exact.transform(x.A.tolist(), initial.tolist(), [], [], 0)
    for p in range(x.highest):
        assert same(-(maps[p] @ initial.reshape(-1)), np.array(transform[p], dtype=object))


@everywhere
def test_infinite_pair_is_made_of_chains_of_the_dual(name):
    """A_q v_i + A_(q-1) v_(i-1) + ... = 0 along each chain; the leading vectors are independent."""
    x = known(name)
    C, place, leading = x.pairs.infinite.C, 0, []
    for length in x.structure.infinite_chains:
        chain = C[:, place : place + length]
        for i in range(length if x.q else 0):
            total = sum(x.A[x.q - j] @ chain[:, i - j] for j in range(min(i, x.q) + 1))
            assert not total.any()
        leading.append(chain[:, 0])
        place += length
    assert not leading or rank(np.array(leading, dtype=object)) == len(leading)
    assert same(x.pairs.infinite.J, _nilpotent(x.structure.infinite_chains))


@everywhere
def test_finite_and_whole_infinite_pair_fill_the_space(name):
    """[C J^k, C_b J_b^(q-1-k)], k < q, is square and regular; sum A_j C_b J_b^(q-j) = 0 (the pair of the dual at 0)."""
    x = known(name)
    blocks = [block for block in mb.exact.jordan_pairs(x.matrix.dual).finite.blocks if block.polynomial == (0, 1)]
    sizes = [block.length for block in blocks]
    assert sizes == [degree for degree in x.structure.infinite_divisors if degree]
    C = np.hstack([zeros(x.r, 0), *(block.C for block in blocks)])
    J = _nilpotent(sizes)
    assert not sum(x.A[j] @ C @ power(J, x.q - j) for j in range(x.q + 1)).any()
    whole = x.stacked(
        [np.hstack([x.pairs.finite.C @ power(x.pairs.finite.J, k), C @ power(J, x.q - 1 - k)]) for k in range(x.q)], (0, x.r * x.q)
    )
    assert rank(whole) == x.r * x.q == x.n + len(J)


def _nilpotent(sizes) -> np.ndarray:
    J, place = zeros(sum(sizes), sum(sizes)), 0
    for size in sizes:
        for i in range(place, place + size - 1):
            J[i, i + 1] = Fraction(1)
        place += size
    return J
