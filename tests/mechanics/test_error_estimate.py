"""Estimated errors of derivatives against true ones: never less than a tenth of them, and no alarm where the digits are right."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

from .test_sensitivities import STEP, precise_mode

EPS = np.finfo(float).eps


def constrained(seed):
    """Matrices with a row and their changes, random; units of very different sizes in every third."""
    random = np.random.default_rng(seed)
    n = 3 + seed % 2
    units = 10 ** random.uniform(-3, 3, n) if seed % 3 == 0 else np.ones(n)

    def definite():
        root = random.standard_normal((n, n))
        return root @ root.T * np.outer(units, units)

    M, C, K = definite(), 0.1 * definite() * (seed % 4 > 0), 10 ** random.uniform(0, 6) * definite()
    if seed % 5 == 0:
        K = K + random.standard_normal((n, n))
    given = M, C, K, random.standard_normal((1, n))
    slopes = (*random.standard_normal((3, n, n)), random.standard_normal((1, n)) * (seed % 2))
    return given, slopes


@pytest.mark.parametrize("seed", range(10))
def test_simple_eigenvalues(seed):
    """Of constrained systems, differences with 80 digits of the given numbers."""
    given, slopes = constrained(seed)
    system = mb.MechanicalSystem(*given[:3], [mb.Constraint(given[3][0], names="row")])
    parameter = mb.Parameter("p", 1.0, slopes[2], slopes[1], slopes[0], rows={"row": (slopes[3][0], 0.0)})
    d = system.sensitivities([parameter])
    assert EPS <= d.error_estimate < 1e-12
    with mpmath.workdps(80):

        def changed(sign):
            exact = np.vectorize(mpmath.mpf, otypes=[object])
            return [exact(matrix) + sign * STEP * exact(slope) for matrix, slope in zip(given, slopes)]

        places = np.cumsum([0] + [mode.multiplicity for mode in d.modes])
        for place, mode in zip(places, d.modes):
            if mode.multiplicity > 1:
                continue
            u = mode.shapes[:, 0]
            above, below = (precise_mode(changed(sign), mode.eigenvalue, u, int(np.abs(u).argmax()))[0] for sign in (1, -1))
            slope = complex((above - below) / (2 * STEP))
            error = abs(d.eigenvalues[0, place] - slope)
            assert error <= min(10 * d.errors[0, place], 1e-10 * abs(slope))


@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-8, 1e-11, 1e-13])
def test_nearly_defective_eigenvalues(gap):
    """[4, 1; gap, 4]: w^2 = 4 +- sqrt(gap), dw/dgap = +- 1 / (4 w sqrt(gap)); or a splitting near the multiple eigenvalue."""
    system = mb.MechanicalSystem(np.eye(2), stiffness=[[4.0, 1.0], [gap, 4.0]])
    d = system.sensitivities([mb.Parameter("gap", gap, stiffness=np.array([[0.0, 0.0], [1.0, 0.0]]))])
    if d.defective:
        assert gap < 1e-10
        assert not d.defective[0].splitting.is_exact
        return
    with mpmath.workdps(60):
        root = mpmath.sqrt(mpmath.mpf(gap))
        for number, sign in enumerate((-1, 1)):
            slope = float(sign / (4 * mpmath.sqrt(4 + sign * root) * root))
            place = int(np.argmin(np.abs(d.modes.eigenvalues - 1j * float(mpmath.sqrt(4 + sign * root)))))
            error = abs(d.natural_frequencies[0, number] - slope)
            assert error <= 10 * d.errors[0, place]
            assert error <= 1e-10 * abs(slope)


@pytest.mark.parametrize("seed", range(6))
def test_semisimple_eigenvalues(seed):
    """T diag T^-1 with a unimodular T of whole numbers: the derivatives are those of the diagonal, over 2 s."""
    random = np.random.default_rng(seed)
    T = np.eye(4) + np.tril(random.integers(-3, 4, (4, 4)), -1)
    K, change = (T @ np.diag(values) @ np.round(np.linalg.inv(T)) for values in ([4.0, 4.0, 4.0, 9.0], [1.0, -2.0, 5.0, 3.0]))
    d = mb.MechanicalSystem(np.eye(4), stiffness=K).sensitivities([mb.Parameter("p", 1.0, stiffness=change)])
    found, expected = np.sort(d.natural_frequencies[0]), np.sort([1 / 4, -2 / 4, 5 / 4, 3 / 6])
    assert np.abs(found - expected).max() <= 10 * d.errors.max()
    assert d.error_estimate < 1e-10


def test_undamped_modes_stay_undamped():
    """The derivatives of several shapes of an undamped eigenvalue are imaginary, to the last digit."""
    random = np.random.default_rng(3)
    change = random.standard_normal((3, 3))
    d = mb.MechanicalSystem(np.eye(3), stiffness=4 * np.eye(3)).sensitivities([mb.Parameter("p", 1.0, stiffness=change + change.T)])
    assert not d.eigenvalues.real.any()
    np.testing.assert_allclose(d.natural_frequencies[0], np.linalg.eigvalsh(change + change.T) / 4, rtol=1e-13)


@pytest.mark.parametrize("noise", [0.0, 1e-13, 1e-9, 1e-6])
@pytest.mark.parametrize("rate", [0.1, 1.0, 3.0, 10.0])
def test_functions(rate, noise):
    """k = e^(rate p) at p = 1, computed to a relative noise, as by an iteration: w = e^(rate p / 2), dw/dp = rate w / 2."""

    def build(p):
        error = np.sin(1e9 * p) if noise else 0.0  # of another sign at each step
        return mb.MechanicalSystem([[1.0]], stiffness=[[np.exp(rate * p) * (1 + noise * error)]])

    system = mb.MechanicalSystem([[1.0]], stiffness=[[np.exp(rate)]])
    d = system.sensitivities([mb.Parameter.of_function("p", 1.0, build)])
    slope = rate * np.exp(rate / 2) / 2
    error = abs(d.natural_frequencies[0, 0] / slope - 1)
    assert error <= 10 * d.error_estimate
    assert d.error_estimate <= 1e4 * noise + 5e-11 * max(1.0, rate**6)
    assert d.errors.all()


def test_functions_with_rayleigh_damping():
    """C = a M + b K has the errors of both."""
    p = mb.Parameter.of_function("p", 1.0, lambda p: mb.MechanicalSystem([[p]], stiffness=[[np.exp(p)]]))
    damped = p.with_damping(2.0, 3.0)
    np.testing.assert_allclose(damped.error.damping, 2.0 * p.error.mass + 3.0 * p.error.stiffness)
    assert mb.Parameter("q", 1.0).with_damping(1.0, 1.0).error is None


def test_what_moves_nothing():
    """A rest length has no derivative, and does not spoil the estimate of others."""
    model = mb.LumpedModel()
    model.mass("cart", 2.0)
    model.spring("ground", "cart", 8.0, name="mount")
    d = model.assemble().sensitivities()
    assert not d.errors[d.names.index("mount.rest_length")].any()
    assert d.error_estimate < 10 * EPS
