"""Exact peaks of motions and combinations of modes."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import EXAMPLES


def building(signal=None, level="acceleration", damping=0.0):
    """Three storeys of 1000 kg on 1 MN/m each, on a moving ground."""
    M, K = np.diag([1000.0, 1000.0, 1000.0, 0.0]), np.zeros((4, 4))
    for i, j in ((3, 0), (0, 1), (1, 2)):
        a = np.eye(4)[i] - np.eye(4)[j]
        K += 1e6 * np.outer(a, a)
    ground = mb.Constraint([0, 0, 0, 1], names="ground", level=level, value=0.0 if signal is None else signal)
    return mb.MechanicalSystem(M, damping * K, K, [ground], names=["first", "second", "third", "ground floor"])


def shock():
    wave = mb.harmonic([5.0], angular_frequency=np.pi / 0.1, phase=-np.pi / 2)
    return wave + wave.delayed(0.1)


@pytest.mark.parametrize("of", ["displacement", "velocity", "acceleration", "reaction"])
def test_peaks_under_a_base_shock(of):
    """No dense sample is beyond the peak, and the nearest one is as near as the curvature allows."""
    motion = building(shock(), damping=1e-3).solve()
    peaks = motion.peaks(1.0, of)
    t = np.linspace(0, 1.0, 20001)
    values = getattr(motion, of)(t)
    size = np.abs(values).max()
    assert (peaks.maximum >= values.max(axis=1) - 1e-12 * size).all()
    assert (peaks.minimum <= values.min(axis=1) + 1e-12 * size).all()
    assert np.allclose(peaks.maximum, values.max(axis=1), atol=1e-4 * size)
    at = np.array([getattr(motion, of)(time)[i] for i, time in enumerate(peaks.extrema.maximum_time)])
    assert np.allclose(at, peaks.maximum, atol=1e-9 * size)


@pytest.mark.long
def test_peaks_of_elongations():
    """A combination has the peak of the difference, not the difference of the peaks."""
    motion = building(shock()).solve()
    drift = motion.peaks(1.0, combinations=[[-1, 1, 0, 0]], names=["drift"])
    t = np.linspace(0, 1.0, 20001)
    x = motion.displacement(t)
    assert np.isclose(drift.largest[0], np.abs(x[1] - x[0]).max(), rtol=1e-6)
    assert drift.names == ("drift",)


def test_effective_masses_sum_to_the_total():
    """Chopra, Dynamics of Structures, section 13.2.5; the peak of one mode is its spectral displacement times its participation."""
    result = building().modal_combination(lambda f: 3.0, base="ground")
    assert np.isclose(result.effective_masses.sum(), 3000.0, rtol=1e-12)
    assert np.isclose(result.total_mass, 3000.0, rtol=1e-12)
    w = 2 * np.sqrt(1e3) * np.sin(np.pi * np.array([1, 3, 5]) / 14)  # chain fixed at one end
    assert np.allclose(result.frequencies_hz, w / (2 * np.pi), rtol=1e-12)
    single = mb.MechanicalSystem(np.diag([2.0, 0.0]), None, [[8.0, -8.0], [-8.0, 8.0]], [mb.Constraint([0, 1])])
    assert np.isclose(single.modal_combination(([0.1, 1.0], [3.0, 3.0])).displacement[0], 3.0 / 4.0)


def test_combination_rules():
    """SRSS is the root of the sum of squares; CQC tends to it for separated modes and to the sum for equal frequencies."""
    srss = building().modal_combination(lambda f: 3.0, combination="SRSS")
    assert np.allclose(srss.displacement, np.sqrt((srss.modal_displacements**2).sum(axis=1)))
    light = building().modal_combination(lambda f: 3.0, damping_ratio=1e-6)
    assert np.allclose(light.displacement, srss.displacement, rtol=1e-6)
    spectrum = mb.shock_response_spectrum(shock(), [0.5, 2.2398628, 6.2759503, 9.0690147, 20.0], quantity="pseudo-acceleration")
    assert (building().modal_combination(spectrum).displacement[:3] > 0).all()
    with pytest.raises(mb.InputError, match="covers"):
        building().modal_combination(([5.0, 6.0], [1.0, 1.0]))
    with pytest.raises(mb.InputError, match="ground"):
        building().modal_combination(lambda f: 1.0, base="grund")
    with pytest.raises(mb.InputError, match="no constraint rows"):
        mb.MechanicalSystem([[1.0]], None, [[1.0]]).modal_combination(lambda f: 1.0)


def test_elongations_of_springs():
    """A spring let go at its elongation of 0.1 m with a mass 0.4 m away from rest: e = 0.1 cos(w t), its length at rest apart."""
    model = mb.LumpedModel()
    model.node("wall")
    model.mass("body", 2.0)
    model.spring("wall", "body", 50.0, name="spring", rest_length=0.3)
    model.constrain({"wall": 1.0}, name="hold")
    system = model.assemble()
    start = [0.4 if name == "body" else 0.0 for name in system.names]
    peaks = system.solve(start).peaks(3.0, "elongation")
    assert peaks.names == ("spring",) and peaks.units == ("m",)
    assert np.isclose(peaks.maximum[0], 0.1, rtol=1e-12)
    assert np.isclose(peaks.minimum[0], -0.1, rtol=1e-12)


def test_rounding_errors_are_no_peaks():
    """After a half sine the acceleration of the ground is 0, and so is its smallest value."""
    peaks = building(shock()).solve().peaks(0.3, "acceleration")
    assert peaks.minimum[3] == 0.0
    assert np.isclose(peaks.maximum[3], 5.0, rtol=1e-12)


def test_reactions_whose_terms_cancel():
    """A parallel robot: reactions in redundant directions are sums of terms that cancel, and have fewer states than the motion."""
    motion, times = mb.read_scene(EXAMPLES / "delta.toml").run().motion, np.linspace(0.0, 1.0, 2001)
    for of in ("displacement", "velocity", "acceleration", "reaction"):
        values, maximum = getattr(motion, of)(times), motion.peaks(1.0, of).maximum
        assert np.all(maximum >= values.max(axis=1) - 1e-12 * np.abs(values).max()), of
        assert np.all(maximum <= values.max(axis=1) + 1e-3 * np.abs(values).max()), of
