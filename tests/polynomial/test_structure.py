"""Zeros with their partial multiplicities and the structure at infinity: known by construction, read off Smith forms, of the referee's cases."""

import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from tests.oracles.referee import NAMES, answer, case
from tests.polynomial.test_singular import coefficients


def partial(A, digits: int = 6) -> dict[complex, tuple[int, ...]]:
    """Each zero, rounded, with its partial multiplicities; every decision has to be clear."""
    structure = mb.PolynomialMatrix(A).structure()
    assert structure.notices == ()
    return {complex(np.round(zero.value, digits)): zero.partial_multiplicities for zero in structure.finite_zeros}


@pytest.mark.parametrize("multiplicity", range(1, 7))
@pytest.mark.parametrize("zero", [0.0, -1.5])
def test_a_scalar_has_one_chain(multiplicity, zero):
    polynomial = np.poly(np.full(multiplicity, zero))[::-1]
    assert partial(polynomial[:, None, None]) == {zero: (multiplicity,)}


@pytest.mark.parametrize("zero", [0.0, -2.0])
@pytest.mark.parametrize("chains", [(1, 1), (1, 3), (2, 2), (1, 1, 2), (2, 3), (1, 2, 3)])
def test_chains_of_a_turned_jordan_matrix_are_counted(chains, zero):
    """s I - J in a basis of integers with determinant one."""
    n = sum(chains)
    J = zero * np.eye(n) + np.diag(np.concatenate([[1.0] * (k - 1) + [0.0] for k in chains])[:-1], 1)
    turn = np.tril(np.ones((n, n))) @ np.triu(np.ones((n, n)))
    back = np.round(np.linalg.inv(turn))
    assert np.array_equal(turn @ back, np.eye(n))
    assert partial([-turn @ J @ back, np.eye(n)]) == {zero: chains}


def test_uncoupled_twins_have_two_divisors_and_critical_damping_one_of_degree_two():
    twins = coefficients([(4, 0, 1), (0,)], [(0,), (4, 0, 1)])
    assert partial(twins) == {2j: (1, 1)}
    coupled = coefficients([(4, 0, 1), (1,)], [(0,), (4, 0, 1)])
    assert partial(coupled) == {2j: (2,)}
    assert partial(np.array([4.0, 4, 1])[:, None, None]) == {-2: (2,)}


@pytest.mark.parametrize("detuning", [1e-9, 1e-6])
def test_detuned_critical_damping_is_two_zeros(detuning):
    """s^2 + 2 (1 + d) s + 1: zeros at -1 +- sqrt(2 d), far apart beside the rounding of the data."""
    fast, slow = mb.PolynomialMatrix(np.array([1.0, 2 * (1 + detuning), 1.0])[:, None, None]).structure().finite_zeros[::-1]
    assert (fast.multiplicity, slow.multiplicity) == (1, 1)
    assert abs(fast.value - slow.value) == pytest.approx(2 * (2 * detuning) ** 0.5, rel=1e-3)


def test_a_detuning_near_the_rounding_of_the_data_is_in_doubt():
    """At d = 3e-14 the zeros count as one by their distance, but the data say otherwise: one zero, told to be in doubt."""
    structure = mb.PolynomialMatrix(np.array([1.0, 2 * (1 + 3e-14), 1.0])[:, None, None]).structure()
    (zero,) = structure.finite_zeros
    assert (zero.multiplicity, zero.partial_multiplicities, zero.clear) == (2, (2,), False)
    (notice,) = structure.notices
    assert notice.doubtful and "-1" in notice.text


def test_close_zeros_stay_two_by_the_strength_of_their_coupling():
    A = coefficients([(1.0, 1), (0,)], [(0,), (1 + 1e-9, 1)])
    assert sorted(partial(A, 12).values()) == [(1,), (1,)]
    coupled = coefficients([(1.0, 1), (1,)], [(0,), (1.001, 1)])
    assert partial(coupled) == {-1: (1,), -1.001: (1,)}


@pytest.mark.parametrize("ratio", [1e3, 1e5])
def test_slow_defective_zeros_are_told_beside_fast_ones(ratio):
    """In mixed coordinates the rounding of the fast part moves the slow zeros further than that of their own size would."""
    structure = [(-ratio, (2,)), (-1.0, (1, 3)), (-1 / ratio, (1, 1, 2))]
    J = block_diag(*[zero * np.eye(k) + abs(zero) * np.eye(k, k=1) for zero, sizes in structure for k in sizes])
    turn = np.tril(np.ones((10, 10))) @ np.triu(np.ones((10, 10)))
    found = mb.PolynomialMatrix([-turn @ J @ np.round(np.linalg.inv(turn)), np.eye(10)]).structure().finite_zeros
    assert [zero.partial_multiplicities for zero in found] == [(1, 1, 2), (1, 3), (2,)]
    assert all(abs(zero.value / value - 1) <= 1e-6 for zero, (value, _) in zip(found[::-1], structure, strict=True))


def test_a_cloud_of_different_zeros_is_not_one():
    """Forty zeros between -1 and -1.04, in mixed coordinates."""
    values = -1 - 1e-3 * np.arange(40)
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(40, 40)))[0]
    zeros = mb.PolynomialMatrix([-turn @ np.diag(values) @ turn.T, np.eye(40)]).structure().finite_zeros
    assert np.allclose([zero.value for zero in zeros], values, rtol=1e-12)


def test_the_order_of_zeros_of_equal_modulus_does_not_hang_on_rounding():
    """Zeros on the circle |s| = 5, in coordinates that move each by a few units in the last place."""
    parts = [(5, 1), (25, 6, 1), (25, 8, 1), (25, 0, 1), (25, -6, 1)]
    A = coefficients(*[[polynomial if i == j else (0,) for j in range(5)] for i, polynomial in enumerate(parts)])
    expected = [-5, -4 + 3j, -3 + 4j, 5j, 3 + 4j]
    random = np.random.default_rng(1)
    for _ in range(20):
        left, right = random.normal(size=(2, 5, 5))
        zeros = mb.PolynomialMatrix(left @ A @ right).structure().finite_zeros
        assert np.allclose([zero.value for zero in zeros], expected, rtol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_cases_of_the_referee(name):
    known = [zero for zero in case(name).record["partial_multiplicities"] if zero["mult"] > 1 and zero["im"] >= 0]
    zeros = answer(name).pairs.structure.finite_zeros
    for zero in zeros:
        assert sum(zero.partial_multiplicities) == zero.multiplicity
        assert case(name).is_void or zero.clear
    for record in known:
        nearest = min(zeros, key=lambda zero: abs(zero.value - complex(record["re"], record["im"])))
        assert list(nearest.partial_multiplicities) == record["partial"]


# Structure at infinity.


def test_a_diagonal_shows_everything():
    """diag(s (s + 1)^2, 1, s^2 + 4): q_i = degrees, descending."""
    A = coefficients([(0, 1, 2, 1), (0,), (0,)], [(0,), (1,), (0,)], [(0,), (0,), (4, 0, 1)])
    structure = mb.PolynomialMatrix(A).structure()
    assert structure.at_infinity == (3, 2, 0)
    assert structure.infinite_divisors == (0, 1, 3)
    assert structure.finite_count == 5
    assert structure.highest_impulse == 0
    assert structure.infinite_chains == (1,)
    assert partial(A) == {0: (1,), -1: (2,), 2j: (1,)}


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
