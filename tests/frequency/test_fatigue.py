"""Fatigue: cycles against the standard and pyyeti, damage of closed-form motions by hand, damage spectra against a dense simulation."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lsim

import mbconstrained as mb
from mbconstrained.frequency.fatigue import turning_points
from mbconstrained.ground.errors import InputError

with np.printoptions():  # its import changes those of the whole process
    from pyyeti import cyclecount


def test_the_example_of_the_standard():
    """ASTM E1049-85 (2017), figure 6: half cycles of the ranges 3, 4, 8, 9, 8 and 6, and a whole one of 4."""
    cycles = mb.rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2])
    assert list(zip(cycles.ranges, cycles.counts)) == [(3, 0.5), (4, 0.5), (4, 1.0), (8, 0.5), (9, 0.5), (8, 0.5), (6, 0.5)]
    assert cycles.means.tolist() == [-0.5, -1.0, 1.0, 1.0, 0.5, 0.0, 1.0]
    assert cycles.exceedance(np.array([0, 3, 4.5, 9, 9.1])).tolist() == [4.0, 4.0, 2.0, 0.5, 0.0]
    assert cycles.damage(2.0, strength=3.0) == pytest.approx(
        (0.5 * 1.5**2 + 1.5 * 2**2 + 1.0 * 4**2 + 0.5 * 4.5**2 + 0.5 * 3**2) / 9, rel=1e-15
    )


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(-9, 9).map(float), min_size=2, max_size=60))
def test_cycles_are_those_of_pyyeti(values):
    """pyyeti.cyclecount.rainflow, its own implementation of the standard; plateaus and repeated values included."""
    points = turning_points(np.array(values))
    cycles = mb.rainflow(values)
    if len(points) < 2:
        assert cycles.total == 0
        return
    expected = cyclecount.rainflow(points, use_pandas=False)
    assert np.column_stack([cycles.ranges / 2, cycles.means, cycles.counts]) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("values", [[], [1.0], [2.0, 2.0, 2.0]])
def test_nothing_changes_in_no_cycle(values):
    cycles = mb.rainflow(values)
    assert (cycles.total, cycles.damage(3.0), cycles.equivalent_amplitude(3.0)) == (0.0, 0.0, 0.0)
    assert cycles.exceedance(np.array([1.0])).tolist() == [0.0]


def test_cycles_of_a_decaying_vibration():
    """x'' + 2 z w x' + w^2 x = 0 from rest at 1: extremes (-e^{-pi z / sqrt(1 - z^2)})^k, all half cycles, by hand; times unlike any grid."""
    w, z = 7.3, 0.02
    system = mb.MechanicalSystem([[1.0]], [[2 * z * w]], [[w**2]])
    cycles = mb.cycles(system.solve(displacement=[1.0]), 4.0, "displacement")["x1"]
    q, count = math.exp(-math.pi * z / math.sqrt(1 - z**2)), int(4.0 * w * math.sqrt(1 - z**2) / math.pi)
    expected = [q**k * (1 + q) for k in range(count)]
    assert cycles.counts.tolist() == [0.5] * (count + 1)  # and the last, unfinished range
    assert cycles.ranges[:count] == pytest.approx(expected, rel=1e-10)


def test_cycles_of_the_force_of_a_named_spring():
    model = mb.LumpedModel()
    model.mass("cart", 2.0)
    model.spring("ground", "cart", stiffness=8.0, name="spring", rest_length=0.1)
    (name, cycles), *_ = mb.cycles(
        model.assemble().solve(displacement={"cart": 0.3}), np.pi
    ).items()  # 0.1 + 0.2 cos 2 t, one period
    assert (name, cycles.total, cycles.unit) == ("spring", 1.0, "N")
    assert cycles.ranges == pytest.approx([3.2, 3.2], rel=1e-12)  # N, 2 k a
    assert cycles.means == pytest.approx([0.0, 0.0], abs=1e-12)
    assert cycles.damage(5.0, strength=160.0) == pytest.approx(0.01**5, rel=1e-11)


RNG = np.random.default_rng(36)
STEP = 0.002
TIMES = STEP * np.arange(1000)
ACCELERATION = RNG.normal(size=1000) * np.sin(np.pi * TIMES / TIMES[-1]) ** 2


@pytest.mark.parametrize(
    ("even", "quantity", "weights"),
    [(True, "pseudo-velocity", lambda w, z: (w, 0)), (False, "absolute acceleration", lambda w, z: (w**2, 2 * z * w))],
)
def test_damage_spectra_of_records(even, quantity, weights):
    """scipy.signal.lsim, exact for linear pieces, at some hundred times of each period, until the vibration has decayed; cycles by pyyeti."""
    times = TIMES if even else np.delete(TIMES, [100, 700])
    values = ACCELERATION if even else np.delete(ACCELERATION, [100, 700])
    frequencies, z, k = [2.0, 21.0, 90.0], 0.05, 4.0
    S = mb.fatigue_damage_spectrum(mb.sampled(times, [values]), frequencies, k, z, quantity)
    for f, found in zip(frequencies, S.damage):
        w = 2 * np.pi * f
        step = STEP / np.ceil(600 * f * STEP)
        t = step * np.arange(int((times[-1] + 6 / f / z / 2) / step))
        y = lsim(([[0, 1], [-(w**2), -2 * z * w]], [[0], [1]], [weights(w, z)], [[0]]), np.interp(t, times, values, right=0.0), t)[
            1
        ]
        expected = cyclecount.rainflow(turning_points(y), use_pandas=False)
        assert found == pytest.approx(expected[:, 2] @ expected[:, 0] ** k, rel=2e-4)  # (pi / 600)^2 / 2 * k of the dense times


def test_a_record_has_the_damage_of_the_same_closed_form():
    """A half sine as a function, and as a record of many samples, whose chords differ from it by the square of the step."""
    half = mb.harmonic([1.0], angular_frequency=np.pi, phase=-np.pi / 2)
    t = np.linspace(0, 1, 4001)
    f = [0.4, 0.8, 3.0]
    own, record = (
        mb.fatigue_damage_spectrum(signal, f, 5.0, 0.02).damage
        for signal in (half + half.delayed(1.0), mb.sampled(t, [np.sin(np.pi * t)]))
    )
    assert record == pytest.approx(own, rel=1e-6)


def test_damage_of_white_noise_is_that_of_rayleigh_amplitudes():
    """Narrow band: D = f T (sqrt(2) sigma)^k Gamma(1 + k/2), with the pseudo-velocity sigma = w sqrt(G / (8 z w^3)), by hand (Miles)."""
    G, f, z, k, T = 0.3, np.array([5.0, 40.0]), 0.05, 6.0, 100.0
    spectrum = mb.white_noise(G, of="acceleration")
    S = mb.fatigue_damage_spectrum(spectrum, f, k, z, duration=T, method="narrow-band")
    w = 2 * np.pi * f
    sigma = np.sqrt(G / (8 * z * w))
    assert S.damage == pytest.approx(f * T * (np.sqrt(2) * sigma) ** k * math.gamma(1 + k / 2), rel=1e-10)
    velocity = mb.fatigue_damage_spectrum(mb.psd([1.0, 1e3], [G, G], of="velocity"), [40.0], k, z, duration=T)
    acceleration = mb.fatigue_damage_spectrum(
        mb.psd([1.0, 1e3], [G * (2 * np.pi) ** 2, G * (2e3 * np.pi) ** 2], of="acceleration"), [40.0], k, z, duration=T
    )
    assert velocity.damage == pytest.approx(acceleration.damage, rel=1e-9)  # the same motion


def test_a_path_of_a_random_motion_has_the_damage_of_its_spectrum():
    """Rainflow cycles of 150 s of a sample path of an oscillator: Dirlik's formula within its scatter."""
    system = mb.MechanicalSystem([[1.0]], [[2 * 0.3 * 10]], [[100.0]])
    R = system.random_response({"x1": mb.psd([0.2, 4.0], [1.0, 1.0])})
    path = R.sample(np.arange(0, 150, 0.05), seed=3)[0]
    assert mb.rainflow(path).damage(3.0) / 150 == pytest.approx(R.damage_rate(3.0)[0], rel=0.25)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"exponent": 0}, "exponent: found 0; expected a number greater than zero"),
        ({"damping_ratio": 0.0}, "undamped oscillators vibrate without end"),
        ({"quantity": "velocity"}, "quantity: found 'velocity'; expected one of"),
        ({"frequencies_hz": [0.0]}, "frequencies_hz: expected a list of positive natural frequencies"),
        ({"strength": -1.0}, "strength: found -1"),
        ({"duration": 3.0}, "duration: a signal has its own end"),
        ({"excitation": mb.psd([1, 2], [1, 1], of="acceleration")}, "duration: a random excitation does damage as long as it acts"),
        (
            {"excitation": mb.psd([1, 2], [1, 1]), "duration": 1.0},
            "found a spectrum of a force; expected that of a motion of the base",
        ),
        ({"excitation": mb.step([1.0])}, "signal: it does not end"),
        ({"excitation": [1.0]}, "signal: found an object of type list"),
    ],
)
def test_mistakes_are_reported(arguments, message):
    given = {"excitation": mb.sampled([0, 1], [[1, 1]]), "frequencies_hz": [1.0], "exponent": 3.0, **arguments}
    with pytest.raises(InputError, match=message):
        mb.fatigue_damage_spectrum(**given)
