"""The pairs in the user's units: shapes, block form, and what is exact in them."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.polynomial.test_singular import coefficients

S_PLUS_1, ZERO, ONE = (1, 1), (0,), (1,)


def test_separate_zeros_have_separate_blocks_and_clusters_share_one():
    """(s+1)(s+2)(s+3): three blocks of one; (s+1)^3 (s+9): blocks of three and one."""
    apart = mb.PolynomialMatrix(np.poly([-1.0, -2, -3])[::-1][:, None, None]).jordan_pairs().finite
    assert sorted(len(block) for block in apart.blocks) == [1, 1, 1]
    cluster = mb.PolynomialMatrix(np.poly([-1.0, -1, -1, -9])[::-1][:, None, None]).jordan_pairs().finite
    assert sorted(len(block) for block in cluster.blocks) == [1, 3]


def test_decoupling_entries_are_bounded_and_told():
    """Zeros 1e-5 apart with a coupling of one would need a transformation with entries of 1e5: they share a block."""
    A = coefficients([(1, 1), ONE], [ZERO, (1.00001, 1)])
    pairs = mb.PolynomialMatrix(A).jordan_pairs()
    assert [len(block) for block in pairs.finite.blocks] == [2]
    known = {item.name: item for item in pairs.evidence}
    assert known["decoupling"].value == pairs.finite.coupling <= 1e3
    assert all(item.text for item in pairs.evidence)


@pytest.mark.parametrize("size", [0, 1, 3])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_a_matrix_without_finite_zeros_has_an_empty_finite_pair(size, degree):
    A = mb.PolynomialMatrix([2 * np.eye(size)] + [np.zeros((size, size))] * degree)
    pairs = A.jordan_pairs()
    assert (pairs.finite.C.shape, pairs.finite.J.shape, pairs.finite.B.shape) == ((size, 0), (0, 0), (0, size))
    assert pairs.finite.zeros == ()
    assert np.array_equal(pairs.laurent(0), np.eye(size) / 2)
    assert not pairs.laurent(-1).any()
    assert pairs.infinite.J.shape == (size, size)
    assert pairs.structure.infinite_divisors == (degree,) * size


def test_small_entries_of_independent_parts_keep_their_digits():
    """H_-20 of diag(s + 10, s + 1/10) is diag((-10)^19, (-1/10)^19)."""
    H = mb.PolynomialMatrix([np.diag([10.0, 0.1]), np.eye(2)]).jordan_pairs().laurent(-20)
    assert np.allclose(H, np.diag([-1e19, -1e-19]), rtol=1e-13, atol=0)


def test_laurent_beyond_float64_is_an_overflow():
    pairs = mb.PolynomialMatrix([[[10.0]], [[1.0]]]).jordan_pairs()
    assert pairs.laurent(-301)[0, 0] == pytest.approx(1e300, rel=1e-12)
    with pytest.raises(mb.Overflow, match="H_-500 has entries beyond the range of float64"):
        pairs.laurent(-500)


def test_laurent_indices_are_whole():
    with pytest.raises(mb.InputError, match="index: found 1.5; expected a whole number"):
        mb.PolynomialMatrix([[[1.0]]]).jordan_pairs().laurent(1.5)


def test_units_of_rows_columns_and_time_appear_in_c_b_and_j():
    """k x' + c x = f with x in km and t in ms: C J^i B has the unit of H_(-1-i)."""
    A = mb.PolynomialMatrix([[[3e-12]], [[2e6]]])
    finite = A.jordan_pairs().finite
    assert (finite.C @ finite.B)[0, 0] == pytest.approx(1 / 2e6, rel=1e-15)
    assert finite.J[0, 0] == pytest.approx(-3e-12 / 2e6, rel=1e-15)
