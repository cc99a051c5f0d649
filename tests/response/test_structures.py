"""Finite element beams: rigid motions stay exact beside stiff modes; clamping by multipliers; hammers of any order."""

import numpy as np
import pytest

import mbconstrained as mb

BENDING, LINE_MASS = 175.0, 0.785  # EI in N m^2, rho A in kg/m, for a length of 1 m


def beam(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of a free beam of length 1 in Hermite elements, coordinates deflection and slope by turns."""
    length, size = 1.0 / elements, 2 * elements + 2
    a, b = 6 * length, length**2
    k = BENDING / length**3 * np.array([[12, a, -12, a], [a, 4 * b, -a, 2 * b], [-12, -a, 12, -a], [a, 2 * b, -a, 4 * b]])
    c, d = 22 * length, 13 * length
    m = LINE_MASS * length / 420 * np.array([[156, c, 54, -d], [c, 4 * b, d, -3 * b], [54, d, 156, -c], [-d, -3 * b, -c, 4 * b]])
    M, K = np.zeros((2, size, size))
    for element in range(elements):
        part = slice(2 * element, 2 * element + 4)
        M[part, part] += m
        K[part, part] += k
    return M, K


def free(elements: int) -> mb.PolynomialMatrix:
    M, K = beam(elements)
    return mb.PolynomialMatrix([K, np.zeros_like(K), M])


@pytest.mark.parametrize("elements", [1, 2, 5, 10, 20])
def test_a_free_beam_has_exactly_its_rigid_motions(elements):
    """Translation and rotation: the zero at 0 has multiplicity four; then come the bending modes, (4.73004/L)^2 sqrt(EI/rho A)."""
    origin, first, *_ = free(elements).structure().finite_zeros
    assert (origin.value, origin.multiplicity) == (0, 4)
    known = 4.730040744862704**2 * (BENDING / LINE_MASS) ** 0.5
    assert abs(first.value) == pytest.approx(known, rel=0.25 / elements**3)
    assert first.multiplicity == 1


@pytest.mark.parametrize("elements", [2, 10])
def test_a_free_beam_set_down_at_rest_stays_there(elements):
    start = np.zeros((2, 2 * elements + 2))
    start[0, ::2] = 1.0
    values = mb.solve(free(elements), start)([0.0, 1.0, 1e3])
    assert np.abs(values[::2] - 1).max() < 1e-9
    assert np.abs(values[1::2]).max() < 1e-9


@pytest.mark.parametrize("elements", [2, 10])
def test_the_centre_of_mass_of_a_pushed_beam_moves_like_a_particle(elements):
    """Force 1 N at one end: m s'' = 1."""
    M, _ = beam(elements)
    push = np.eye(len(M))[0]
    x = mb.solve(free(elements), force=mb.step(push))
    times = np.array([1e-3, 0.1, 10.0])
    momentum = np.tile([1.0, 0.0], elements + 1) @ M
    assert np.allclose(momentum @ x(times), times**2 / 2, rtol=1e-11)
    assert x.notices == ()


def test_a_beam_clamped_by_multipliers_is_a_cantilever():
    """Deflection and slope held at one end: 20 of 22 degrees of freedom left, first mode (1.87510/L)^2 sqrt(EI/rho A)."""
    M, K = beam(10)
    size = len(M)
    A = np.zeros((3, size + 2, size + 2))
    A[0, :size, :size], A[2, :size, :size] = K, M
    A[0, size:, :2], A[0, :2, size:] = np.eye(2), -np.eye(2)
    structure = mb.PolynomialMatrix(A).structure()
    assert structure.at_infinity == (2,) * size + (-2, -2)
    assert structure.finite_count == 2 * (size - 2)
    known = 1.875104068711961**2 * (BENDING / LINE_MASS) ** 0.5
    assert abs(structure.finite_zeros[0].value) == pytest.approx(known, rel=1e-5)


@pytest.mark.parametrize("order", [0, 1, 2, 3, 8, 20])
def test_hammers_of_any_order(order):
    """(s + 1)(s + 2) x = s^k: 1/((s+1)(s+2)) = sum (-1)^j (2^(j+1) - 1) s^(-2-j), shifted by k."""
    x = mb.solve(mb.PolynomialMatrix([[[2.0]], [[3.0]], [[1.0]]]), force=mb.impulse([1.0], order=order))
    coefficient = [(-1) ** j * (2.0 ** (j + 1) - 1) for j in range(order + 2)]
    assert np.allclose(np.ravel(x.impulses), coefficient[: max(order - 1, 0)][::-1], rtol=1e-12)
    after = [coefficient[order - 1] if order else 0.0, coefficient[order]]
    assert np.allclose(x.start.ravel(), after, rtol=1e-12)
    assert np.allclose(x(1.0), after[0] * (2 * np.exp(-1) - np.exp(-2)) + after[1] * (np.exp(-1) - np.exp(-2)), rtol=1e-9)


def test_an_impulse_on_an_algebraic_row_moves_nothing_else():
    """x1 = delta and (s^3 + 2 s^2 + 2 s)(x1 + x2) = 0: x2 = -x1 and no jump is left behind."""
    A = mb.PolynomialMatrix([[[1, 0], [0, 0]], [[0, 0], [2, 2]], [[0, 0], [2, 2]], [[0, 0], [1, 1]]])
    x = mb.solve(A, force=mb.impulse([1.0, 0.0]))
    assert not x.jump.any()
    assert len(x.impulses) == 1 and np.allclose(x.impulses[0], [1.0, -1.0], rtol=1e-14, atol=0)
