"""The steady state is the limit of the motion, and the harmonics of a record are its Fourier coefficients."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

import mbconstrained as mb
from mbconstrained.mechanics.harmonic_response import fourier_coefficient


def pair():
    """Two masses with a massless point between them on a constraint row; the damping is strong."""
    K = np.array([[5.0, -3.0, 0.0], [-3.0, 4.0, -1.0], [0.0, -1.0, 1.5]])
    return mb.MechanicalSystem(
        np.diag([1.0, 2.0, 0.0]), 0.4 * K, K, [mb.Constraint([1, 0, -1], value=0.2, names="tie")], names=["a", "b", "c"]
    )


def test_the_motion_ends_in_the_steady_state():
    force = mb.harmonic([1.0, 0.0, 2.0], angular_frequency=1.3, phase=0.4) + mb.step([0.0, 1.0, 0.0])
    force = force + mb.harmonic([0.0, 0.5, 0.0], angular_frequency=4.0).delayed(0.7)
    system = pair()
    steady, motion = system.steady_state(force), system.solve(force=force)
    times = np.linspace(290.0, 295.0, 7)
    np.testing.assert_allclose(steady.displacement(times), motion.displacement(times), atol=1e-11)
    np.testing.assert_allclose(steady.velocity(times), motion.velocity(times), atol=1e-11)
    np.testing.assert_allclose(steady.reaction(times), motion.reaction(times), atol=1e-10)
    np.testing.assert_allclose(steady.frequencies_hz, np.array([0.0, 1.3, 4.0]) / (2 * np.pi), rtol=1e-15)
    assert steady.error_estimate.max() < 1e-10


@pytest.mark.parametrize("order", [0, 1, 7, 60])
def test_fourier_coefficients_of_a_record_are_the_integrals(order):
    times, values = np.array([0.1, 0.4, 0.5, 1.3]), np.array([[0.0, 2.0, -1.0, 0.5]])
    T, w = 1.5, 2 * np.pi * order / 1.5
    expected = 0j
    for a, b in pairwise(times):
        line = lambda t: np.interp(t, times, values[0])  # noqa: E731
        expected += quad(lambda t: line(t) * np.cos(w * t), a, b)[0] - 1j * quad(lambda t: line(t) * np.sin(w * t), a, b)[0]
    expected *= (1 if order == 0 else 2) / T
    np.testing.assert_allclose(fourier_coefficient(times, values, T, order), [expected], atol=1e-13)


def test_a_periodic_record_repeats_itself():
    """A record that is repeated many times comes to the motion in closed form, whatever the number of harmonics."""
    T, samples = 2.0, np.array([[0.0, 1.0, -1.0, 0.0]])
    times = np.array([0.0, 0.5, 1.5, 2.0])
    system = mb.MechanicalSystem([[1.0]], [[1.5]], [[4.0]])
    steady = system.steady_state(mb.sampled(times, samples), period=T, harmonics=3)
    many = np.concatenate([times[:-1] + k * T for k in range(20)] + [[20 * T]])
    repeated = mb.sampled(many, np.concatenate([samples[:, :-1]] * 20 + [samples[:, -1:]], axis=1))
    motion, t = system.solve(force=repeated), np.linspace(38.0, 39.9, 9)
    np.testing.assert_allclose(steady.displacement(t), motion.displacement(t), atol=1e-9)


def test_values_in_time_are_in_closed_form_and_not_a_sum_of_harmonics():
    """A square wave of the force on an overdamped mass, whose motion between the jumps is known.

    x'' + 5 x' + 4 x = +-1 with half periods of 1 s: on each half x = s/4 + a e^{-t} + b e^{-4 t}, and x(1) = -x(0), x'(1) = -x'(0).
    """
    system = mb.MechanicalSystem([[1.0]], [[5.0]], [[4.0]])
    square = 2 * mb.sampled([0.0, 1.0], [[1.0, 1.0]]) + mb.step([-1.0])
    steady = system.steady_state(square, period=2.0)
    e1, e4 = np.exp(-1), np.exp(-4)
    a, b = np.linalg.solve([[1 + e1, 1 + e4], [1 + e1, 4 * (1 + e4)]], [-0.5, 0.0])
    t = np.array([0.0, 0.3, 0.999, 1.0, 1.6, 7.3])
    half, sign = np.mod(t, 1.0), np.where(np.mod(t, 2.0) < 1.0, 1.0, -1.0)
    np.testing.assert_allclose(steady.displacement(t)[0], sign * (0.25 + a * np.exp(-half) + b * np.exp(-4 * half)), atol=1e-13)
    np.testing.assert_allclose(steady.velocity(t)[0], sign * (-a * np.exp(-half) - 4 * b * np.exp(-4 * half)), atol=1e-13)


@pytest.mark.long
def test_a_support_that_jumps_at_the_end_of_each_period():
    """A saw-tooth of a support behind a damper: at each end the support jumps back, and the momentum of the mass changes."""
    system = mb.MechanicalSystem(
        np.diag([0.0, 1.0]),
        [[0.5, -0.5], [-0.5, 0.5]],
        [[4.0, -4.0], [-4.0, 4.0]],
        [mb.Constraint([1, 0], value=mb.sampled([0.0, 2.0], [[0.0, 1.0]]), names="base")],
        ["support", "mass"],
    )
    steady = system.steady_state(period=2.0, harmonics=1000)
    t = np.linspace(0.2, 1.8, 5)
    series = np.real(steady.displacement_amplitudes @ np.exp(2j * np.pi * np.outer(steady.frequencies_hz, t)))
    np.testing.assert_allclose(steady.displacement(t)[1], series[1], atol=2e-6)
    np.testing.assert_allclose(steady.displacement(t)[0], t / 2, atol=1e-13)
    before, after = steady.velocity(np.array([2.0 - 1e-9, 0.0]))[1]
    np.testing.assert_allclose(after - before, -0.5, atol=1e-7)  # c times the jump of the support by the mass


def test_deflection_shapes_at_the_frequencies_of_the_loads():
    system = pair()
    steady = system.steady_state(mb.harmonic([1.0, 0.0, 0.0], frequency_hz=0.2) + mb.step([1.0, 0.0, 0.0]))
    H = system.frequency_response([0.2], ["a"])
    np.testing.assert_allclose(steady.deflection_shape(0.2), H.values[:, 0, 0], rtol=1e-12)
    with pytest.raises(mb.InputError, match="no load has 0.3 Hz; expected one of 0, 0.2"):
        steady.deflection_shape(0.3)


def test_what_has_no_steady_state_is_refused():
    spring = mb.MechanicalSystem([[1.0]], None, [[4.0]])
    with pytest.raises(mb.InputError, match="grows"):
        spring.steady_state(mb.harmonic([1.0], angular_frequency=2.0))
    with pytest.raises(mb.InputError, match="period"):
        spring.steady_state(mb.sampled([0.0, 1.0], [[0.0, 1.0]]))
    with pytest.raises(mb.InputError, match="constant and harmonic"):
        spring.steady_state(mb.ramp([1.0]))
    with pytest.raises(mb.InputError, match="reach"):
        spring.steady_state(mb.sampled([0.0, 1.0], [[0.0, 1.0]]), period=0.5)


@pytest.mark.parametrize("seed", range(2))
def test_free_bodies_under_a_record_have_a_bounded_cycle(seed):
    """A driveline that turns freely is somewhere: without a mean torque it oscillates about 0, and differences are those of its harmonics."""
    random = np.random.default_rng(seed)
    J, k, c = random.uniform(1, 3, 2), random.uniform(50, 500), random.uniform(1, 5)
    twist = np.array([[1.0, -1.0], [-1.0, 1.0]])
    record = mb.sampled([0, 0.1, 0.2, 0.3, 0.4], [[0, 1, 0, -1, 0], [0] * 5])
    steady = mb.MechanicalSystem(np.diag(J), c * twist, k * twist).steady_state(record, period=0.4, harmonics=60)
    times = np.linspace(0, 0.4, 41)
    order = np.arange(1, 61)
    w, F = 2 * np.pi * order / 0.4, 8 / np.pi**2 * np.sin(np.pi * order / 2) / order**2  # of a triangular wave
    drive = F * np.exp(-0.5j * np.pi) / J[0] / (-(w**2) + (k + 1j * w * c) * (1 / J[0] + 1 / J[1]))
    twists = np.real(drive @ np.exp(1j * np.outer(w, times)))
    values = steady.displacement(times)
    np.testing.assert_allclose(values[0] - values[1], twists, atol=1e-6 * np.abs(twists).max())
    assert np.abs(values).max() < 1.0
