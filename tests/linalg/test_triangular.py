"""A regular pencil as s I - T: an equivalence with standardized real Schur form, accurate for slow zeros beside fast ones."""

from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.control.rational import scalar_matrix
from mbconstrained.linalg.blocks import eigenvalues
from mbconstrained.linalg.rank import Noisy
from mbconstrained.linalg.triangular import TriangularForm, triangular_form
from tests.oracles.transfer import factors, multiplied, residues


def form_of(E, F) -> TriangularForm:
    """The form of s E - F, entries known to a unit in the last place."""
    return triangular_form(Noisy.rounded(E), Noisy.rounded(F))


@pytest.mark.parametrize("size", [1, 2, 3, 6, 9])
@pytest.mark.parametrize("seed", range(4))
def test_it_is_an_equivalence(size, seed):
    """left (s E - F) right = s I - T at any s, T quasi-triangular with equal diagonals in its 2 x 2 blocks."""
    random = np.random.default_rng(seed)
    E, F = random.normal(size=(2, size, size))
    form = form_of(E, F)
    for s in (0.0, 1.5, -0.3 + 2j):
        found = form.left @ (s * E - F) @ form.right
        weight = np.abs(form.left) @ (abs(s) * np.abs(E) + np.abs(F)) @ np.abs(form.right)
        assert np.abs(found - (s * np.eye(size) - form.T)).max() <= 1e-13 * weight.max()
    below = np.diag(form.T, -1)
    assert not np.tril(form.T, -2).any()
    assert not (below[:-1] * below[1:]).any()
    for at in np.flatnonzero(below):
        assert form.T[at, at] == form.T[at + 1, at + 1]
        assert form.T[at, at + 1] * below[at] < 0


def test_nothing_is_a_pencil_too():
    form = form_of(np.zeros((0, 0)), np.zeros((0, 0)))
    assert form.left.shape == form.right.shape == form.T.shape == (0, 0)


@pytest.mark.parametrize("ratio", [1e6, 1e10, 1e14])
def test_a_slow_zero_survives_beside_a_fast_one(ratio):
    """E = diag(1, 1/ratio) mixed by rotations: zeros -1 and -ratio, both to about eps times the ratio's square root."""
    c, s = np.cos(0.7), np.sin(0.7)
    Q = np.array([[c, -s], [s, c]])
    E, F = Q @ np.diag([1.0, 1 / ratio]) @ Q, -np.eye(2) @ Q @ Q
    zeros = np.sort(eigenvalues(form_of(np.diag([1.0, 1 / ratio]), -np.eye(2)).T).real)
    assert np.allclose(zeros, [-ratio, -1.0], rtol=1e-14)
    mixed = np.sort(eigenvalues(form_of(E, F).T).real)
    assert mixed[1] == pytest.approx(-1.0, rel=1e-13)


@pytest.mark.parametrize("stiff", [1.0, 1e8])
def test_a_zero_at_the_origin_is_nilpotent_to_the_last_bit(stiff):
    """A free body beside an oscillator, mixed: s^2 and s^2 + stiff; T ends in an exact [[0, 1], [0, 0]]."""
    E = np.eye(4)
    F = np.zeros((4, 4))
    F[:2, 2:], F[2:, :2] = np.eye(2), -0.5 * stiff * np.array([[1.0, -1.0], [-1.0, 1.0]])
    form = form_of(E, F)
    assert form.nonzero_count == 2
    assert not np.diag(form.T)[2:].any() and not form.T[2:, :2].any()
    assert form.T[2, 3] != 0 and form.T[3, 2] == 0
    assert np.allclose(np.sort(np.abs(eigenvalues(form.T))), [0, 0, stiff**0.5, stiff**0.5], rtol=1e-14)


@pytest.mark.parametrize("time", [10.0, 20.0, 40.0])
def test_rows_that_stay_coupled_to_zeros_at_zero_see_those_that_do_not(time):
    poles = [Fraction(0)] * 4 + [Fraction(1, 4)] * 3 + [Fraction(-2)] * 3
    x = mb.solve(scalar_matrix(tuple(multiplied(*factors(poles))), False), force=mb.impulse([1.0]))
    known = float(residues([Fraction(1)], poles, 0, time))
    assert x(time)[0] == pytest.approx(known, rel=1e-12)
