"""A matrix decoupled by its eigenvectors: identities, mpmath's eigenvalues, defective matrices."""

import mpmath
import numpy as np
import pytest

from mbconstrained.ground.tolerances import DECOUPLING_LIMIT, EPS
from mbconstrained.linalg.blocks import block_matrix, decoupled


def stiff_chain(masses: int, ratio: float) -> np.ndarray:
    """Masses between two walls, every other spring ``ratio`` times as stiff, damped unevenly."""
    springs = np.where(np.arange(masses + 1) % 2, ratio, 1.0)
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    C = np.diag(np.linspace(0.0, 0.2, masses))
    return np.block([[np.zeros((masses, masses)), np.eye(masses)], [-K, -C]])


def zeros(blocks) -> np.ndarray:
    return np.concatenate([np.linalg.eigvals(block) for block in blocks])


def check(S: np.ndarray, tolerance: float = 1e-12) -> None:
    found = decoupled(S)
    assert np.allclose(found.inverse @ found.basis, np.eye(len(S)), rtol=0, atol=tolerance)
    residual = S @ found.basis - found.basis @ block_matrix(found.blocks)
    assert np.abs(residual).max(initial=0.0) <= tolerance * np.abs(S).max(initial=0.0) * np.abs(found.basis).max(initial=0.0)


@pytest.mark.parametrize("size", [0, 1, 2, 3, 8, 31])
def test_any_matrix_is_decoupled(size):
    check(np.random.default_rng(size).normal(size=(size, size)))


@pytest.mark.parametrize(
    "S",
    [np.eye(4, k=1), np.array([[0.0, 1.0], [-1.0, -2.0]]), np.kron(np.eye(2), [[0.0, 1.0], [-4.0, 0.0]]) + np.eye(4, k=2)],
    ids=["nilpotent", "critically damped", "a defective pair"],
)
def test_a_defective_matrix_falls_back_to_clusters(S):
    found = decoupled(S)
    assert max(len(block) for block in found.blocks) >= len(S) // 2
    assert found.coupling <= DECOUPLING_LIMIT
    check(S)


def test_quotients_are_nearer_to_the_zeros_than_what_the_qr_algorithm_gives():
    S = stiff_chain(6, 1e8)
    assert max(len(block) for block in decoupled(S).blocks) == 2
    with mpmath.workdps(50):
        exact = np.array([complex(z) for z in mpmath.eig(mpmath.matrix(S.tolist()), left=False, right=False)])

    def error(found) -> float:
        apart = np.abs(found[:, None] - exact).min(axis=0)
        return float((apart / np.abs(exact)).max())

    own, plain = error(zeros(decoupled(S).blocks)), error(np.linalg.eigvals(S))
    assert plain > 100 * EPS
    assert own <= plain


@pytest.mark.parametrize("unit", [1e-12, 1e-6, 1e9])
def test_other_units_give_the_same_blocks(unit):
    S = stiff_chain(8, 3.0)
    units = np.repeat([1.0, unit], 8)
    found, other = decoupled(S), decoupled(S * units / units[:, None])
    assert len(other.blocks) == len(found.blocks)
    assert other.coupling <= DECOUPLING_LIMIT
    order, others = np.sort_complex(zeros(found.blocks)), np.sort_complex(zeros(other.blocks))
    assert np.abs(np.sort(order.imag) - np.sort(others.imag)).max() <= 1e-12
