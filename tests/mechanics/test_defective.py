"""Exactly defective eigenvalues: exponents and coefficients of the Puiseux series against roots of polynomials with 250 digits."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

#: The change of the parameter; leading terms differ from the roots by its root of the order of the multiplicity.
CHANGE = mpmath.mpf(10) ** -80

A, B = 2, 3


def polynomial(*entries):
    """M, C, K from entries (K, C, M) row by row."""
    size = round(len(entries) ** 0.5)
    return np.array(entries, dtype=float).reshape(size, size, 3).transpose(2, 0, 1)[::-1]


ZERO, DOUBLE = (0, 0, 0), (A * A, 2 * A, 1)
BASES = {
    "critical damping": polynomial(DOUBLE),
    "two shapes": polynomial(DOUBLE, ZERO, ZERO, DOUBLE),
    "chain of three": polynomial(DOUBLE, (-1, 0, 0), ZERO, (A * B, A + B, 1)),
    "chain of four": polynomial(DOUBLE, (-1, 0, 0), ZERO, DOUBLE),
    "flutter": polynomial((4, 0, 1), (-1, 0, 0), ZERO, (4, 0, 1)),
    "damped flutter": polynomial((5, 2, 1), (-1, 0, 0), ZERO, (5, 2, 1)),
    "chains of two and one": polynomial(DOUBLE, ZERO, ZERO, (A * B, A + B, 1)),
    "free body": polynomial((1, 0, 1), (-1, 0, 0), (-1, 0, 0), (1, 0, 1)),
}
CASES = [(name, seed) for name in BASES for seed in (0, 1, 2, 6)]  # of M, C, K; 6 moves all masses


def slope_of(name, seed):
    """A change of K, C or M by whole numbers."""
    random, size = np.random.default_rng(seed), len(BASES[name][0])
    slope = np.zeros((3, size, size))
    slope[seed % 3 if seed < 6 else 0] = random.integers(-3, 4, (size, size)) + 5 * np.eye(size) * (seed < 6)
    if seed == 6:
        slope[2] = np.eye(size)
    return slope  # of M, C, K


def mixed(matrices, size, seed):
    """P A Q with unimodular P and Q: the same eigenvalues with other shapes."""
    random = np.random.default_rng(100 + seed)
    P = np.eye(size) + np.tril(random.integers(-2, 3, (size, size)), -1)
    Q = np.eye(size) + np.triu(random.integers(-2, 3, (size, size)), 1)
    return np.array([P @ matrix @ Q for matrix in matrices])


def determinant(matrices):
    """det(M s^2 + C s + K), coefficients of descending powers, for 1 or 2 coordinates of mpmath numbers."""
    M, C, K = matrices
    entries = [[[M[i][j], C[i][j], K[i][j]] for j in range(len(M))] for i in range(len(M))]
    if len(M) == 1:
        return entries[0][0]

    def times(a, b):
        result = [mpmath.mpf(0)] * 5
        for i, x in enumerate(a):
            for j, y in enumerate(b):
                result[i + j] += x * y
        return result

    return [x - y for x, y in zip(times(entries[0][0], entries[1][1]), times(entries[0][1], entries[1][0]))]


def roots_of_changed(base, slope):
    """The eigenvalues for p + e with 250 digits."""
    with mpmath.workdps(250):
        matrices = [
            [[mpmath.mpf(float(a)) + CHANGE * mpmath.mpf(float(b)) for a, b in zip(*rows)] for rows in zip(one, other)]
            for one, other in zip(base, slope)
        ]
        return mpmath.polyroots(determinant(matrices), maxsteps=20000, extraprec=1000)


@pytest.mark.parametrize(("name", "seed"), CASES)
def test_exponents_and_coefficients(name, seed):
    """Every branch s + c e^r is a root of det A(s; p + e) to the next order of e."""
    base, slope = BASES[name], slope_of(name, seed)
    if len(base[0]) > 1:
        base, slope = mixed(base, 2, seed), mixed(slope, 2, seed)
    system = mb.MechanicalSystem(*base)
    parameter = mb.Parameter("p", 1.0, mass=slope[0], damping=slope[1], stiffness=slope[2])
    d = system.sensitivities([parameter])
    (number,) = [i for i, each in enumerate(d.of_modes) if each.mode.multiplicity > 1]
    each = d.of_modes[number]
    assert all(one.is_exact for one in each.splittings.values())
    moving = [branch for branch in each.branches[0] if branch.coefficient]
    assert {one.mode for one in d.defective} == ({number} if any(branch.exponent < 1 for branch in moving) else set())
    with mpmath.workdps(250):
        center = mpmath.mpc(*(round(part) for part in (each.mode.eigenvalue.real, each.mode.eigenvalue.imag)))
        offsets = [root - center for root in roots_of_changed(base, slope)]
        left = [offset for offset in offsets if abs(offset) < 1e-10]
        assert len(left) == len(each.branches[0])
        for branch in moving:
            expected = mpmath.mpc(branch.coefficient) * CHANGE ** (
                mpmath.mpf(branch.exponent.numerator) / branch.exponent.denominator
            )
            best = min(left, key=lambda offset: abs(offset - expected))
            assert abs(best - expected) < 1e-10 * abs(expected)
            assert abs(best - expected) * abs(branch.coefficient) <= 10 * each.errors[0] * abs(expected)
            left.remove(best)
        assert all(abs(offset) < 1e-10 * CHANGE for offset in left)  # what stays


def test_critical_damping_of_an_oscillator():
    """s = -c / (2 m) +- sqrt((c / (2 m))^2 - k / m): with k + e it is +- i sqrt(e / m), with c + e +- sqrt(c e / (2 m^2))."""
    d = mb.MechanicalSystem([[4.0]], [[16.0]], [[16.0]]).sensitivities()
    found = {one.parameter: [branch.coefficient for branch in one.splitting.branches] for one in d.defective}
    np.testing.assert_allclose(found["stiffness[x1, x1]"], [0.5j, -0.5j], atol=1e-14)
    np.testing.assert_allclose(sorted(c.real for c in found["damping[x1, x1]"]), [-(0.5**0.5), 0.5**0.5], rtol=1e-14)
    assert np.isinf(d.eigenvalues).all()


def test_critical_damping_to_rounding_errors():
    """c = 2 sqrt(2) has no exact float64: reported, with the coefficient of the exact case."""
    d = mb.MechanicalSystem([[1.0]], [[2 * 2**0.5]], [[2.0]]).sensitivities(["stiffness[x1, x1]"])
    (one,) = d.defective
    assert not one.splitting.is_exact
    np.testing.assert_allclose([branch.coefficient for branch in one.splitting.branches], [1j, -1j], atol=1e-8)
    assert max(abs(abs(branch.coefficient) - 1) for branch in one.splitting.branches) <= 10 * d.error_estimate


def test_a_free_body_stays_free():
    """Masses and springs between free bodies leave the eigenvalue 0 where it is; a spring to the ground does not: s^2 = -e / M."""
    system = mb.MechanicalSystem(np.diag([1.0, 3.0]), stiffness=[[2.0, -2.0], [-2.0, 2.0]])
    between = mb.Parameter("spring", 2.0, stiffness=np.array([[1.0, -1.0], [-1.0, 1.0]]))
    ground = mb.Parameter("mount", 0.0, stiffness=np.diag([1.0, 0.0]))
    d = system.sensitivities([between, ground])
    (one,) = d.defective
    assert one.parameter == "mount"
    np.testing.assert_allclose([branch.coefficient for branch in one.splitting.branches], [0.5j, -0.5j], atol=1e-14)
    assert not d.eigenvalues[0][system.modes().eigenvalues == 0].any()
