"""What counts as zero can be overridden, and where it is not clear the answer says so with its singular values."""

import numpy as np
import pytest

import mbconstrained as mb

#: Two rows that differ by 1e-9, as from measured data: with them a slow zero near -1e-9, without it one at 0.
NEARLY = mb.PolynomialMatrix([[[1, 1], [1, 1 + 1e-9]], [[1, 0], [0, 0]]])


def zeros(A, rank_tolerance=None):
    return [zero.value for zero in A.structure(rank_tolerance).finite_zeros]


def test_a_tolerance_above_the_difference_makes_it_zero():
    assert zeros(NEARLY) == [pytest.approx(-1e-9, rel=1e-6)]
    assert zeros(NEARLY, 1e-12) == [pytest.approx(-1e-9, rel=1e-6)]
    assert zeros(NEARLY, 1e-6) == [0]


def test_the_answer_follows():
    """x1' = -(x1 + x2), x1 + (1 + 1e-9) x2 = 0: over 1e9 s it decays to 1/e, or stays where the rows count as equal."""
    kept, dropped = (mb.solve(NEARLY, [[1.0, -1.0]], rank_tolerance=tolerance) for tolerance in (None, 1e-6))
    assert abs(kept(1e9)[0] - np.exp(-1)) < 1e-6
    assert abs(dropped(1e9)[0] - 1) < 1e-6
    assert dropped.pairs.rank_tolerance == 1e-6


def test_a_tolerance_may_make_the_equations_dependent():
    A = mb.PolynomialMatrix([[[1, 1], [1, 1 + 1e-9]], [[1, 1], [1, 1]]])
    assert zeros(A) == [pytest.approx(-1)]
    with pytest.raises(mb.SingularPolynomialMatrix, match="equation 1"):
        A.jordan_pairs(1e-6)


@pytest.mark.parametrize("parts", [1, 26])
def test_exact_data_can_be_declared(parts):
    """A difference of 2^-46 is in doubt as rounded data, and none as exact data, as which a small model is solved anyway."""
    blocks = [np.kron(np.eye(parts), part) for part in ([[1, 1], [1, 1 + 2.0**-46]], [[1, 0], [0, 0]])]
    A = mb.PolynomialMatrix(blocks)
    rounded, exact = mb.solve(A), mb.solve(A, rank_tolerance=0.0)
    notices = [notice for notice in rounded.notices if notice.kind == "rank"]
    assert bool(notices) == (parts > 1)
    assert all(notice.doubtful and "singular value" in notice.text and "rank_tolerance" in notice.text for notice in notices)
    assert not [notice for notice in exact.notices if notice.kind == "rank"]


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, "small"])
def test_tolerances_that_are_none(tolerance):
    with pytest.raises(mb.InputError, match="rank_tolerance"):
        mb.solve(NEARLY, rank_tolerance=tolerance)


def test_a_soft_spring_at_the_edge_of_float64_is_kept():
    """1e15 + 1 still has its 1, but no rounding less."""
    stiffness = np.array([[1e15 + 1, -1e15], [-1e15, 1e15]])
    motion = mb.MechanicalSystem(mass=np.eye(2), stiffness=stiffness).solve(displacement=[1.0, 1.0])
    assert motion.error_estimate(1.0) <= 1e-12 and np.allclose(motion(1.0), np.cos(0.5**0.5), rtol=1e-12)


@pytest.mark.parametrize("direction", [[0.1, 0.7], [0.1, 0.7, 0.3]])
def test_a_singular_system_that_trusts_every_bit_is_refused_in_words(direction):
    """Elements of rank one: with rank_tolerance=0 the rounding of a scaled copy is kept as if it were data."""
    M = mb.ElementMatrix([direction], [3.0])
    with pytest.raises((mb.IllConditioned, mb.SingularPolynomialMatrix)):
        mb.MechanicalSystem(M, stiffness=M).solve(np.ones(len(direction)), rank_tolerance=0.0)
