"""Frequency responses and characteristic roots of equations with delays, against direct inverses, python-control and Lambert's function."""

import control
import numpy as np
import pytest
from scipy.special import lambertw

import mbconstrained as mb

MASS, STIFFNESS, DAMPING = np.diag([1.0, 2.0]), np.array([[5.0, -2.0], [-2.0, 3.0]]), 0.3 * np.eye(2)
BACK, RATE = np.array([[0.0, 0.4], [0.0, 0.0]]), np.array([[0.3, 0.0], [0.1, -0.2]])
DELAYED = {0.7: [BACK, RATE], 0.31: BACK.T}
OSCILLATORS = mb.PolynomialMatrix([STIFFNESS, DAMPING, MASS])
FIRST_ORDER = mb.PolynomialMatrix([[[0.0]], [[1.0]]])


def inverse(f):
    s = 2j * np.pi * f
    delayed = np.exp(-0.7 * s) * (BACK + s * RATE) + np.exp(-0.31 * s) * BACK.T
    return np.linalg.inv(STIFFNESS + s * DAMPING + s * s * MASS + delayed)


def test_values_at_placed_lines_are_the_inverse_and_have_errors():
    H = mb.frequency_response(OSCILLATORS, "auto", delayed=DELAYED)
    expected = np.array([inverse(f) for f in H.frequencies_hz]).transpose(1, 2, 0)
    assert abs(H.values / expected - 1).max() < 1e-12 and H.error_estimate.max() < 1e-12
    box = H.enclose(0.3, 25)
    assert abs(box.middle.reshape(2, 2, 2)[0] - inverse(0.3).real).max() < 1e-15


def test_peaks_are_maxima():
    H = mb.frequency_response(OSCILLATORS, "auto", delayed=DELAYED)
    for peak in (one for one in H.peaks if one.frequency_hz < 1):
        entry = H.outputs.index(peak.output), H.inputs.index(peak.input)
        around = abs(H(peak.frequency_hz * np.array([1 - 1e-4, 1.0, 1 + 1e-4])).values[entry])
        assert around[1] == pytest.approx(peak.amplitude) and around[1] == around.max()


def test_loop_with_dead_time_against_python_control():
    f = np.geomspace(0.01, 3, 50)
    plant, loop = control.tf([1], [1, 0.2, 4]), np.exp(-0.4j * 2 * np.pi * f)
    lag = control.frd(1.5 * loop, 2 * np.pi * f)
    closed = control.feedback(control.frd(plant, 2 * np.pi * f), lag)
    H = mb.frequency_response(mb.PolynomialMatrix([[[4.0]], [[0.2]], [[1.0]]]), f, delayed={0.4: [[1.5]]})
    np.testing.assert_allclose(H.values[0, 0], np.squeeze(closed.frdata), rtol=1e-12)


def test_poles_and_antiresonances_are_refused_by_name():
    H = mb.frequency_response(OSCILLATORS, [0.1], delayed=DELAYED)
    for attribute in ("poles", "residues", "antiresonances"):
        with pytest.raises(mb.InputError, match="delays"):
            getattr(H, attribute)


@pytest.mark.parametrize("gain, delay", [(1.0, 1.0), (np.pi / 2, 1.0), (0.3, 2.0), (5.0, 0.1)])
def test_roots_of_the_first_order_are_branches_of_lambert(gain, delay):
    roots = mb.characteristic_roots(FIRST_ORDER, {delay: [[gain]]}, 6)
    branches = np.array([lambertw(-gain * delay + 0j, k) / delay for k in range(-12, 12)])
    branches = branches[branches.imag >= 0]
    expected = branches[np.argsort(-branches.real)][:6]
    np.testing.assert_allclose(roots.eigenvalues, expected, atol=1e-12)
    assert roots.is_complete and roots.residuals.max() < 1e-13


def test_roots_satisfy_the_equations_with_their_shapes_and_decide_on_growth():
    roots = mb.characteristic_roots(OSCILLATORS, DELAYED, 6)
    for s, shape in zip(roots.eigenvalues, roots.shapes.T):
        delayed = np.exp(-0.7 * s) * (BACK + s * RATE) + np.exp(-0.31 * s) * BACK.T
        assert abs((STIFFNESS + s * DAMPING + s * s * MASS + delayed) @ shape).max() < 1e-11
    delayed = {0.7: [BACK, RATE]}
    first, second = mb.characteristic_roots(OSCILLATORS, delayed, 2).eigenvalues
    assert second.real < first.real - 0.05
    x, turns = mb.solve(OSCILLATORS, [[1.0, 0.0], [0.0, 0.0]], delayed=delayed), 32 * np.pi / first.imag
    np.testing.assert_allclose(x(200.0 + turns), np.exp(first.real * turns) * x(200.0), rtol=1e-6)


def test_roots_of_a_loop_with_a_controller():
    loop = mb.PolynomialMatrix([[[1.0, 0.0], [1.5, 0.0]], [[1.0, 0.0], [2.0, 1.0]]])
    roots = mb.characteristic_roots(loop, {0.3: [[0.0, -1.0], [0.0, 0.0]]}, 3)
    s = roots.eigenvalues
    assert abs((s + 1) * s + (2 * s + 1.5) * np.exp(-0.3 * s)).max() < 1e-11 and roots.is_complete


def test_growing_roots_are_reported_and_none_is_refused():
    roots = mb.characteristic_roots(FIRST_ORDER, {1.0: [[2.0]]}, 3)
    assert roots.stability_margin < 0 and "right half plane" in roots.notices[0].text and roots.is_complete
    with pytest.raises(mb.InputError, match="no delays"):
        mb.characteristic_roots(FIRST_ORDER, {})
    with pytest.raises(mb.InputError, match="neutral"):
        mb.characteristic_roots(FIRST_ORDER, {1.0: [[[0.0]], [[0.5]]]})
