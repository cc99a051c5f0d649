"""Forces that begin after t = 0 on motions that are slow beside them: every digit of a small difference of large deflections."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

EPS = np.finfo(float).eps
TIMES = np.array([0.3125, 0.75, 1.375, 2.0, 5.0, 30.0])

KINDS = {
    "constant": (mb.step([1.0]), lambda s: 1 / s),
    "ramp": (mb.ramp([1.0]), lambda s: 1 / s**2),
    "sine": (mb.term([1.0], angular_frequency=2.0, phase=-np.pi / 2), lambda s: 2 / (s**2 + 4)),
    "decay": (mb.term([1.0], rate=-0.5), lambda s: 1 / (s + mpmath.mpf(0.5))),
}


def known(transform, mass: float, stiffness: float, times) -> np.ndarray:
    """The response of one mass to what has this Laplace transform, inverted by Talbot's contour in 60 digits."""
    with mpmath.workdps(60):
        w = mpmath.sqrt(mpmath.mpf(stiffness) / mpmath.mpf(mass))
        values = [
            mpmath.invertlaplace(lambda s: transform(s) / (mass * (s**2 + w**2)), t, method="talbot") if t > 0 else 0 for t in times
        ]
        return np.array([float(value) for value in values])


@pytest.mark.parametrize("turned", [1e-8, 1e-2, 3.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_late_force_on_a_mass_held_softly(kind, turned):
    """From its first moments on, relative to the largest value until then."""
    force, transform = KINDS[kind]
    A = mb.PolynomialMatrix([[[4000.0 * turned**2]], [[0.0]], [[4000.0]]])
    x = mb.solve(A, force=force.delayed(0.25))
    times = TIMES[:4]
    expected = known(transform, 4000.0, 4000.0 * turned**2, times - 0.25)
    assert np.abs(x(times)[0] / expected - 1).max() <= 40 * EPS


@pytest.mark.parametrize("turned", [1e-8, 1e-5, 1e-2, 0.3])
def test_overlapping_pulses_on_a_mass_held_softly(turned):
    """x = sum of (1 - cos w (t - t_j)) / K: its versine 2 sin^2(w (t - t_j) / 2) does not cancel."""
    stiffness = 4000.0 * turned**2
    force = mb.pulse([1.0], start=0.0, duration=1.0) + mb.pulse([-3.0], start=0.5, duration=1.0)
    x = mb.solve(mb.PolynomialMatrix([[[stiffness]], [[0.0]], [[4000.0]]]), force=force)
    with mpmath.workdps(60):
        w = mpmath.sqrt(mpmath.mpf(stiffness) / 4000)
        steps = {0.0: 1, 1.0: -1, 0.5: -3, 1.5: 3}
        sums = [sum(c * (1 - mpmath.cos(w * max(t - s, 0))) for s, c in steps.items()) / mpmath.mpf(stiffness) for t in TIMES]
        expected = np.array([float(value) for value in sums])
    found = x(TIMES)[0]
    for last in range(1, len(TIMES) + 1):  # whichever times are asked for
        error = np.abs(found - expected)[:last].max() / np.abs(expected[:last]).max()
        assert error <= 20 * EPS + 4 * EPS * turned * TIMES[last - 1]


def test_pulses_keep_their_durations():
    """In float64 0.251 - 0.25 and 3.001 - 3 differ from 0.001, in different digits."""
    starts = (0.25, 3.0)
    x = mb.solve(
        mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]]), force=sum(mb.pulse([1.0], start=s, duration=1e-3) for s in starts)
    )
    assert np.isclose(x.derivative(1)(5.0)[0], 2e-3, rtol=8 * EPS, atol=0)


@pytest.mark.parametrize("small", [1e-9, 1e-15, 1e-30, 1e-200])
@pytest.mark.parametrize("stiffness", [-1.0, 9.0])
def test_a_small_force_next_to_a_large_one_is_not_lost(small, stiffness):
    """Two masses that nothing couples: the second one moves as it does alone."""
    pair = mb.PolynomialMatrix([np.diag([4.0, stiffness]), np.diag([1.0, 0.5]), np.eye(2)])
    alone = mb.PolynomialMatrix([[[stiffness]], [[0.5]], [[1.0]]])
    for pattern in (mb.step, lambda v: mb.step(v).delayed(1.0), lambda v: mb.impulse(v), lambda v: mb.pulse(v, duration=2.0)):
        x, y = mb.solve(pair, force=pattern([1.0, small])), mb.solve(alone, force=pattern([small]))
        assert np.allclose(x(TIMES)[1], y(TIMES)[0], rtol=1e-12, atol=0.0)


def test_what_cancels_among_modes_is_told():
    """A nearly free body with a weak damper: until its two zeros have come apart, a late force is followed with fewer digits."""
    damping = 1e-4
    x = mb.solve(mb.PolynomialMatrix([[[0.0]], [[damping]], [[1.0]]]), force=mb.ramp([1.0]).delayed(0.5))
    for time in (0.6, 1.0, 3.0):
        with mpmath.workdps(60):
            t, c = mpmath.mpf(time) - mpmath.mpf(0.5), mpmath.mpf(damping)
            exact = (t**2 / 2 - (t - (1 - mpmath.exp(-c * t)) / c) / c) / c
        error = abs(x(time)[0] / float(exact) - 1)
        assert error <= 10 * x.error_estimate(time)


@pytest.mark.parametrize("masses", [2, 7])
@pytest.mark.parametrize("moving", [0.0, 1.0])
def test_values_after_a_late_pulse_are_proved_from_its_first_moments_on(masses, moving):
    """Next to intervals that contain the exact values, relative to the largest of each time."""
    K = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    system = mb.MechanicalSystem(np.eye(masses), 0.02 * K, K)
    x = system.solve(moving * np.eye(masses)[0], force=mb.pulse(np.eye(masses)[-1], start=2.0, duration=0.5))
    times = np.array([0.5, 2.0 + 2.0**-40, 2.0 + 2.0**-20, 2.01, 2.3, 2.5, 2.5 + 2.0**-20, 3.0, 40.0])
    found, box = x(times), x.enclose(times, digits=20)
    assert (box.error_bounds(found).max(axis=0) <= 1e-12 * np.abs(found).max(axis=0)).all()
