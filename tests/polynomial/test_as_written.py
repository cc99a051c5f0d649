"""What counted as zero at s = 0, taken as it is written."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.polynomial import jordan_pairs as module

LAPLACIAN = np.array([[1.0, -1.0], [-1.0, 1.0]])


def stiff(spring: float, mass, ground=(3.0, 2.0)) -> mb.PolynomialMatrix:
    """Two bodies on soft springs, joined by a stiff one, assembled."""
    K = spring * LAPLACIAN + np.diag(ground)
    return mb.PolynomialMatrix([K, 0 * K, np.diag(mass)])


def in_turned_coordinates(stiffness: float, size: int) -> mb.PolynomialMatrix:
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(size, size)))[0]
    K = turn @ np.diag([0.0, *np.linspace(1, 2, size - 1)]) @ turn.T * stiffness
    return mb.PolynomialMatrix([(K + K.T) / 2, 0 * K, np.eye(size)])


def slowest(pairs) -> complex:
    return pairs.finite.zeros[0].value


@pytest.mark.parametrize("spring", [1.0, 1e10])
def test_nothing_was_lost_where_nothing_counted_as_zero(spring):
    assert stiff(spring, [1.0, 0.0]).jordan_pairs().as_written is None


@pytest.mark.parametrize("spring", [1.0, 1e15, 1e16])
def test_nothing_was_lost_of_a_free_body(spring):
    """The matrix is singular as it is written, and float64 did not round."""
    pairs = stiff(spring, [1.0, 1.0], ground=(0.0, 0.0)).jordan_pairs()
    assert slowest(pairs) == 0 and pairs.as_written is None


@pytest.mark.parametrize("spring", [1e15, 4e15])
def test_springs_beside_much_stiffer_ones_are_not_lost(spring):
    """3 and 2 N/m are whole beside 4e15: x1 + x2 = 2 x1 moves with (3 + 2) / m."""
    pairs = stiff(spring, [1.0, 0.0]).jordan_pairs()
    assert slowest(pairs) == 0
    assert abs(slowest(pairs.as_written) - 1j * 5**0.5) < 1e-12


@pytest.mark.parametrize("limit", [24, 0])
def test_a_free_body_in_turned_coordinates_is_held_by_rounding(limit, monkeypatch):
    monkeypatch.setattr(module, "AS_WRITTEN_STATES", limit)
    pairs = in_turned_coordinates(1.0, 4).jordan_pairs()
    assert slowest(pairs) == 0
    assert 0 < abs(slowest(pairs.as_written)) < 1e-7


def test_who_gives_a_tolerance_decides():
    assert stiff(1e15, [1.0, 0.0]).jordan_pairs(1e-12).as_written is None
    assert stiff(1e15, [1.0, 0.0]).jordan_pairs(0.0).as_written is None


def test_what_is_known_by_its_elements_is_exact():
    model = mb.LumpedModel()
    model.mass("one", 1.0)
    model.mass("two", 1.0)
    model.spring("one", "two", stiffness=1e16)
    assert model.assemble().polynomial_matrix().jordan_pairs().as_written is None
