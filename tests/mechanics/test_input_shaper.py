"""Input shapers: no vibration after the last impulse, against formulas of the literature and motions in closed form."""

import math

import numpy as np
import pytest

import mbconstrained as mb


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.3])
def test_residual_at_the_design_frequency(damping):
    zv, zvd, ei = (mb.input_shaper((1.5, damping), kind=kind) for kind in ("ZV", "ZVD", "EI"))
    for shaper in (zv, zvd, ei):
        assert math.isclose(shaper.amplitudes.sum(), 1.0, rel_tol=1e-14)
        assert (shaper.amplitudes > 0).all() and shaper.times[0] == 0.0
    assert zv.residual(1.5, damping) < 1e-14
    assert zvd.residual(1.5, damping) < 1e-14
    assert math.isclose(ei.residual(1.5, damping), 0.05, rel_tol=1e-12)


def test_derivative_of_zvd_is_zero_and_that_of_zv_is_not():
    h = 1e-4
    assert mb.input_shaper((1.0, 0.1), kind="ZVD").residual(1.0 + h, 0.1) < 10 * h**2
    assert mb.input_shaper((1.0, 0.1), kind="ZV").residual(1.0 + h, 0.1) > h


def test_ei_without_damping_is_that_of_the_literature():
    shaper = mb.input_shaper((0.5, 0.0), kind="EI", vibration_limit=0.1)
    assert np.allclose(shaper.times, [0.0, 1.0, 2.0], rtol=1e-15)
    assert np.allclose(shaper.amplitudes, [1.1 / 4, 0.9 / 2, 1.1 / 4], rtol=1e-15)


def test_ei_with_damping_is_near_the_published_fit():
    """Singhose, Seering and Singer fitted A_1 and A_3 of numerically optimized shapers for V = 0.05."""
    V, z = 0.05, 0.1
    first = 0.24968 + 0.24961 * V + 0.80008 * z + 1.23328 * V * z + 0.49599 * z**2 + 3.17316 * V * z**2
    last = 0.25149 + 0.21474 * V - 0.83249 * z + 1.41498 * V * z + 0.85181 * z**2 - 4.90094 * V * z**2
    assert np.allclose(mb.input_shaper((1.0, z), kind="EI").amplitudes[[0, 2]], [first, last], atol=5e-3)


def test_two_modes_are_at_rest_after_a_shaped_step():
    system = mb.MechanicalSystem(np.diag([1.0, 2.0]), [[0.3, -0.1], [-0.1, 0.1]], [[30.0, -10.0], [-10.0, 10.0]], names=["a", "b"])
    shaper = mb.input_shaper(system.modes(), kind="ZVD")
    assert len(shaper.times) == 9 and len(shaper.modes) == 2
    motion = system.solve(force={"a": shaper.shape(mb.step(1.0))})
    after = shaper.duration + np.array([1e-3, 0.5, 3.0])
    assert np.abs(motion.displacement(after) - np.linalg.solve([[30.0, -10.0], [-10.0, 10.0]], [1.0, 0.0])[:, None]).max() < 1e-13
    assert np.abs(motion.velocity(after)).max() < 1e-13


def test_undamped_modes_and_single_modes():
    system = mb.MechanicalSystem([[1.0]], stiffness=[[4 * np.pi**2]])
    modes = system.modes()
    for given in (modes, modes[0], [modes[0]], [(1.0, 0.0)], (1.0, 0.0), np.array([[1.0, 0.0]])):
        assert np.allclose(mb.input_shaper(given, kind="ZV").times, [0.0, 0.5], rtol=1e-13)


@pytest.mark.parametrize(
    "modes, options, message",
    [
        ((1.0, 0.0), {"kind": "ZVDD"}, "expected one of"),
        ((1.0, 0.0), {"kind": "ZV", "vibration_limit": 0.1}, "no limit"),
        ((1.0, 0.0), {"kind": "EI", "vibration_limit": 1.0}, "below 1"),
        ((1.0, 0.8), {"kind": "EI"}, "smaller one"),
        ((1.0, 1.0), {}, "does not oscillate"),
        ((-1.0, 0.1), {}, "frequency_hz"),
        ((math.nan, 0.1), {}, "frequency_hz"),
        ([], {}, "none of them"),
        ("first", {}, "expected system.modes"),
        ([(1.0, 0.1, 2.0)], {}, "pairs"),
        (mb.MechanicalSystem([[1.0]], stiffness=[[-1.0]]).modes(), {}, "none of them"),
        (mb.MechanicalSystem([[1.0]], [[-0.1]], [[1.0]]).modes(), {}, "grows"),
    ],
)
def test_bad_input(modes, options, message):
    with pytest.raises(mb.InputError, match=message):
        mb.input_shaper(modes, **options)


def test_residual_and_shape_refuse_what_they_cannot_read():
    shaper = mb.input_shaper((1.0, 0.0))
    for call in (lambda: shaper.residual(-1.0), lambda: shaper.residual(1.0, 1.5), lambda: shaper.shape(3.0)):
        with pytest.raises(mb.InputError):
            call()
