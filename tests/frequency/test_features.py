"""Peaks, antiresonances and automatic frequencies against closed forms of one and two masses."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import mbconstrained as mb


def oscillator(zeta):
    """Unit mass, natural frequency 2 rad/s."""
    return mb.MechanicalSystem([[1.0]], [[4.0 * zeta]], [[4.0]])


@pytest.mark.parametrize("zeta", [0.2, 1e-2, 1e-5, 1e-8])
def test_the_peak_of_an_oscillator_has_its_closed_form(zeta):
    """|H| is largest at w^2 = wn^2 (1 - 2 zeta^2), 1 / (2 k zeta sqrt(1 - zeta^2)), and half its square between two w^2."""
    (peak,) = oscillator(zeta).frequency_response("auto").peaks
    np.testing.assert_allclose(2 * np.pi * peak.frequency_hz, 2 * np.sqrt(1 - 2 * zeta**2), rtol=1e-12)
    np.testing.assert_allclose(peak.amplitude, 1 / (8 * zeta * np.sqrt(1 - zeta**2)), rtol=1e-15 / zeta + 1e-13)
    if zeta < 0.1:
        root = 2 * zeta * np.sqrt(1 - zeta**2)
        ends = 2 * np.sqrt(1 - 2 * zeta**2 + np.array([-root, root]))
        np.testing.assert_allclose(2 * np.pi * peak.bandwidth_hz, ends[1] - ends[0], rtol=1e-14 / zeta + 1e-12)
    expected = np.angle(1 / (4 - 4 * (1 - 2 * zeta**2) + 8j * zeta * np.sqrt(1 - 2 * zeta**2)))
    np.testing.assert_allclose(peak.phase, expected, atol=1e-15 / zeta + 1e-12)


def test_automatic_frequencies_show_the_height_of_a_sharp_peak():
    system = oscillator(1e-5)
    H = system.frequency_response("auto")
    np.testing.assert_allclose(np.abs(H.values).max(), 1 / (8e-5 * np.sqrt(1 - 1e-10)), rtol=1e-6)
    assert len(H.frequencies_hz) < 500 and (np.diff(H.frequencies_hz) > 0).all()


def test_peaks_without_damping_are_infinite_and_no_line_is_at_one():
    H = mb.MechanicalSystem([[1.0]], None, [[4.0]]).frequency_response("auto")
    assert [peak.amplitude for peak in H.peaks] == [np.inf]
    assert np.isfinite(H.values).all() and not H.poles_on_lines


def test_antiresonances_are_the_frequencies_with_the_driven_mass_fixed():
    """The zeros of H_11 are the eigenvalues of the rest with x1 = 0; a chain has none from end to end."""
    K = np.array([[3.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 5.0]])
    system = mb.MechanicalSystem(np.diag([1.0, 2.0, 1.0]), None, K)
    H = system.frequency_response([0.1], ["x1"], ["x1", "x3"])
    rest = mb.MechanicalSystem(np.diag([2.0, 1.0]), None, K[1:, 1:]).modes().frequencies_hz
    found = [(one.output, one.frequency_hz) for one in H.antiresonances]
    assert [name for name, _ in found] == ["x1", "x1"]
    np.testing.assert_allclose([frequency for _, frequency in found], rest, rtol=1e-13)


def test_eigenvalues_that_an_entry_does_not_contain_are_no_antiresonances():
    apart = mb.MechanicalSystem(np.eye(2), None, np.diag([1.0, 4.0]), names=["a", "b"])
    assert not apart.frequency_response([0.1], ["a"], ["a"]).antiresonances
    assert not apart.frequency_response([0.1], ["a"], ["b"]).antiresonances


def test_every_peak_is_a_maximum():
    T = 2 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    H = mb.MechanicalSystem(np.eye(6), 0.01 * T, T).frequency_response([0.1], ["x1"], ["x1", "x4"])
    for peak in H.peaks:
        size = lambda f, peak=peak: -abs(H([f]).values[H.outputs.index(peak.output), 0, 0])  # noqa: E731
        near = minimize_scalar(size, bounds=(0.999 * peak.frequency_hz, 1.001 * peak.frequency_hz), method="bounded")
        assert -near.fun <= peak.amplitude * (1 + 1e-13)


@pytest.mark.parametrize("stiffness", [1.0, 1000.0])
def test_rounding_errors_in_the_stop_band_of_a_chain_are_no_peaks(stiffness):
    """Above the highest natural frequency the terms of 50 masses cancel: |H| falls there without a maximum, and below it has one for
    each lightly damped mode."""
    K = stiffness * (2 * np.eye(50) - np.eye(50, k=1) - np.eye(50, k=-1))
    system = mb.MechanicalSystem(np.eye(50), 1e-3 * K, K)
    highest = np.sqrt(np.linalg.eigvalsh(K).max()) / (2 * np.pi)
    H = system.frequency_response([], ["x1"], ["x1", "x25", "x50"])
    for output in H.outputs:
        peaks = [peak for peak in H.peaks if peak.output == output]
        assert len(peaks) > 5 and max(peak.frequency_hz for peak in peaks) < highest
        for peak in peaks[:5]:
            near = np.abs(H(peak.frequency_hz * np.array([1 - 1e-6, 1, 1 + 1e-6]))[output])
            np.testing.assert_allclose(near[1], peak.amplitude, rtol=1e-9)
            assert near.argmax() == 1
