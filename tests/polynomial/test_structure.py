"""Zeros and structure at infinity of matrices whose Smith forms can be read off."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.polynomial.test_singular import coefficients


def zeros(A) -> dict[complex, int]:
    """The zeros to eight digits, with multiplicities."""
    structure = mb.PolynomialMatrix(A).structure()
    return {complex(np.round(zero.value, 8)): zero.multiplicity for zero in structure.finite_zeros}


def test_a_diagonal_shows_everything():
    """diag(s (s + 1)^2, 1, s^2 + 4): q_i = degrees, descending."""
    A = coefficients([(0, 1, 2, 1), (0,), (0,)], [(0,), (1,), (0,)], [(0,), (0,), (4, 0, 1)])
    structure = mb.PolynomialMatrix(A).structure()
    assert structure.at_infinity == (3, 2, 0)
    assert structure.infinite_divisors == (0, 1, 3)
    assert structure.finite_count == 5
    assert structure.highest_impulse == 0
    assert structure.infinite_chains == (1,)
    assert zeros(A) == {0: 1, -1: 2, 2j: 1}


def test_zeros_are_sorted_by_modulus_and_pairs_listed_once():
    A = coefficients([(25, 6, 1), (0,), (0,)], [(0,), (0.5, 1), (0,)], [(0,), (0,), (-2, 1)])
    structure = mb.PolynomialMatrix(A).structure()
    assert np.allclose([zero.value for zero in structure.finite_zeros], [-0.5, 2, -3 + 4j], rtol=1e-14)
    assert [zero.count for zero in structure.finite_zeros] == [1, 1, 2]


@pytest.mark.parametrize("order", range(1, 5))
def test_a_chain_of_differentiators_is_an_infinite_zero_of_that_order(order):
    """I - s N with N nilpotent: the inverse I + s N + ... has the single infinite pole of order k."""
    size = order + 1
    structure = mb.PolynomialMatrix([np.eye(size), -np.eye(size, k=1)]).structure()
    assert structure.at_infinity == (1,) * order + (-order,)
    assert structure.highest_impulse == order
    assert structure.finite_zeros == ()
    assert structure.infinite_chains == (order + 1,)


@pytest.mark.parametrize("multiplicity", range(1, 7))
def test_a_defective_zero_keeps_its_multiplicity(multiplicity):
    """(s + 1)^m as a scalar, and as a chain of first-order equations."""
    polynomial = np.poly(-np.ones(multiplicity))[::-1]
    assert zeros(polynomial[:, None, None]) == {-1: multiplicity}
    chain = np.array([np.eye(multiplicity) - np.eye(multiplicity, k=1), np.eye(multiplicity)])
    assert zeros(chain) == {-1: multiplicity}


def test_equal_zeros_of_independent_parts_are_one_zero():
    A = coefficients([(1, 0, 1), (0,), (0,)], [(0,), (1, 0, 1), (0,)], [(0,), (0,), (3, 1)])
    assert zeros(A) == {1j: 2, -3: 1}


def test_close_but_different_zeros_stay_apart():
    A = coefficients([(1.0, 1), (0,)], [(0,), (1.001, 1)])
    assert zeros(A) == {-1: 1, -1.001: 1}
    coupled = coefficients([(1.0, 1), (1,)], [(0,), (1.001, 1)])
    assert zeros(coupled) == {-1: 1, -1.001: 1}


def test_a_zero_at_the_origin_is_exactly_zero():
    """A free chain of three masses: s^2 (s^2 + k/m) (s^2 + 3 k/m), k/m = 0.1 without an exact binary form."""
    K = 0.1 * np.array([[1.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    found = mb.PolynomialMatrix([K, np.zeros((3, 3)), np.eye(3)]).structure().finite_zeros
    assert found[0] == mb.polynomial.structure.FiniteZero(0j, 2)
    assert np.allclose([zero.value for zero in found[1:]], [0.1**0.5 * 1j, 0.3**0.5 * 1j], rtol=1e-14)


def test_byers_he_mehrmann_mobile_manipulator():
    """A robot linearized with two constraint rows, degree 2, size 5 (Byers, He and Mehrmann, LAA 285, 1998).

    Their printed matrices; the two finite zeros and the two infinite chains of length 4 follow from them.
    """
    M0 = np.array([[18.7532, -7.94493, 7.94494], [-7.94493, 31.8182, -26.8182], [7.94494, -26.8182, 26.8182]])
    D0 = np.array([[-1.52143, -1.55168, 1.55168], [3.22064, 3.28467, -3.28467], [-3.22064, -3.28467, 3.28467]])
    K0 = np.array([[67.4894, 69.2393, -69.2393], [69.8124, 1.68624, -1.68617], [-69.8123, -1.68617, -68.2707]])
    F0 = np.array([[1.0, 0, 0], [0, 0, 1]])
    A = np.zeros((3, 5, 5))
    A[0, :3, :3], A[0, :3, 3:], A[0, 3:, :3] = K0, -F0.T, F0
    A[1, :3, :3], A[2, :3, :3] = D0, M0
    structure = mb.PolynomialMatrix(A).structure()
    (zero,) = structure.finite_zeros
    assert abs(zero.value - (-0.05161621 + 0.22434761j)) < 1e-8
    assert [d for d in structure.infinite_divisors if d] == [4, 4]
    assert structure.finite_count == 2
