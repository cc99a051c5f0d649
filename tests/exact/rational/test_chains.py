"""True Jordan chains: for rational zeros, and for all roots of an irreducible polynomial at once."""

from fractions import Fraction

import flint
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.exact.engine import hypercompanion
from mbconstrained.exact.rational import RATIONALS
from tests.exact.rational.products import MATRICES, known
from tests.oracles.models import massless_joints, two_masses

everywhere = pytest.mark.parametrize("name", MATRICES)


@everywhere
def test_leading_vectors_are_independent_at_every_root(name):
    """Modulo p they have a minor that p does not divide, found at one of its roots in numbers."""
    for divisor in known(name).structure.elementary_divisors:
        chains = [chain for chain in known(name).pairs.chains if chain.polynomial == divisor.polynomial]
        for answers in zip(*(chain.at(20) for chain in chains)):
            leading = np.array([vectors[0].astype(complex) for _, vectors in answers])
            assert np.linalg.matrix_rank(leading) == len(chains)


@everywhere
def test_numbers_of_a_chain_are_balls_around_true_values(name):
    """A(z) v_0 is a ball that holds 0, and a small one."""
    x = known(name)
    for chain in x.pairs.chains:
        for root, vectors in chain.at(30):
            with flint.ctx.workprec(200):
                values = [[flint.acb_poly(a)(root) for a in row] for row in x.pairs.matrix.entries]
                residual = [sum((a * v for a, v in zip(row, vectors[0])), flint.acb(0)) for row in values]
            size = max(abs(complex(entry)) for entry in vectors[0]) * max(1, abs(complex(root))) ** x.q * float(np.abs(x.A).max())
            assert all(entry.contains(0) and float(entry.rad()) < 1e-20 * size for entry in residual)


@everywhere
def test_columns_of_c_are_the_chain_of_a_rational_zero(name):
    for block, chain in zip(known(name).pairs.finite.blocks, known(name).pairs.chains):
        if block.degree == 1:
            assert np.array_equal(block.C, np.hstack(chain.vectors))


@everywhere
def test_entries_of_c_are_whole_numbers_without_a_common_divisor(name):
    for block in known(name).pairs.finite.blocks:
        assert all(entry.denominator == 1 for entry in block.C.flat)
        assert np.gcd.reduce([abs(entry.numerator) for entry in block.C.flat]) == 1


def test_hypercompanion_matrix():
    """Ones above the diagonal, -p in the last rows; Jacobson's form of (s^2 + 2 s + 5)^2."""
    expected = [[0, 1, 0, 0], [-5, -2, 1, 0], [0, 0, 0, 1], [0, 0, -5, -2]]
    assert hypercompanion(RATIONALS, flint.fmpq_poly([5, 2, 1]), 2).tolist() == expected
    assert hypercompanion(RATIONALS, flint.fmpq_poly([flint.fmpq(1, 2), 0, 1]), 1).tolist() == [[0, 1], [Fraction(-1, 2), 0]]


def test_laurent_coefficients_of_the_two_masses():
    pairs = mb.exact.jordan_pairs(mb.PolynomialMatrix(two_masses(2)))
    tenth = Fraction(1, 10)
    assert pairs.laurent(-2).tolist() == [[-tenth, tenth, 0], [-tenth, tenth, -1], [2 * tenth, -tenth, 1]]
    assert not pairs.laurent(-3).any()
    expected = [["3/50", "-1/25", "1/5"], ["3/50", "-1/25", "1/5"], ["-1/10", "3/50", "-2/5"]]
    assert pairs.laurent(-4).tolist() == [[Fraction(entry) for entry in row] for row in expected]
    position = mb.exact.jordan_pairs(mb.PolynomialMatrix(two_masses(0)))
    assert position.laurent(0).tolist() == [[0, 0, 0], [0, 0, -1], [0, 0, 1]]


def test_pairs_of_the_massless_joints():
    """Section 5.2: C_inf = e_1 / 9, B_inf = e_1^T up to how 1/9 is shared; modes e_2 and (1, 1, 3)."""
    pairs = mb.exact.jordan_pairs(mb.PolynomialMatrix(massless_joints()))
    assert (pairs.infinite.C @ pairs.infinite.B).tolist() == [[Fraction(1, 9), 0, 0], [0, 0, 0], [0, 0, 0]]
    drift, swing = pairs.finite.blocks
    assert (drift.C.tolist(), drift.B.tolist()) == ([[0], [1], [0]], [[0, Fraction(1, 12), 0]])
    assert swing.J.tolist() == [[0, 1], [Fraction(-1, 5), Fraction(-4, 15)]]
    assert swing.C.tolist() == [[1, 0], [1, 0], [3, 0]]


def test_exact_pairs_agree_with_the_numeric_ones():
    random = np.random.default_rng(3)
    A = mb.PolynomialMatrix(random.normal(size=(3, 5, 5)))
    exact, numeric = mb.exact.jordan_pairs(A), A.jordan_pairs()
    assert np.allclose(
        [z.value for z in exact.structure.finite_zeros], [z.value for z in numeric.structure.finite_zeros], rtol=1e-10
    )
    for index in range(-6, 1):
        assert np.allclose(exact.laurent(index).astype(float), numeric.laurent(index), rtol=1e-8, atol=1e-10)
