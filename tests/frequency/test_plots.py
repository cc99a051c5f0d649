"""Frequency responses drawn by matplotlib."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import InputError


def response(**options):
    system = mb.MechanicalSystem(np.diag([1.0, 2.0]), 0.1 * np.eye(2), [[5.0, -4.0], [-4.0, 4.0]], names=["a", "b"])
    return system.frequency_response("auto", **options)


def test_a_matrix_of_bode_plots_with_marked_peaks_in_the_units_that_are_chosen():
    H = response()
    figure = H.plot(amplitude="dB", axis="rpm", unwrapped=False)
    axes = np.array(figure.axes).reshape(4, 2)
    size, phase = axes[0, 1], axes[1, 1]
    assert (size.get_title(), size.get_ylabel(), phase.get_xlabel()) == ("a / b", "receptance (dB re 1 m/N)", "frequency (rpm)")
    x, y = size.lines[0].get_data()
    assert np.allclose(x, 60 * H.frequencies_hz) and np.allclose(y, 20 * np.log10(np.abs(H.values[0, 1])))
    assert np.abs(phase.lines[0].get_ydata()).max() <= 180
    peaks = [peak for peak in H.peaks if (peak.output, peak.input) == ("a", "b")]
    assert sorted(text.get_text() for text in size.texts) == sorted(f"{60 * peak.frequency_hz:.4g} rpm" for peak in peaks)


def test_transmissibility_has_a_line_at_one():
    row = mb.Constraint([1.0, 0.0], names="base")
    system = mb.MechanicalSystem(np.diag([0.0, 1.0]), None, [[4.0, -4.0], [-4.0, 4.0]], [row])
    size, _ = system.frequency_response([0.1, 1.0], "base", "x2", quantity="transmissibility").plot().axes
    assert list(size.lines[1].get_ydata()) == [1.0, 1.0] and size.get_ylabel() == "transmissibility"


@pytest.mark.parametrize("wrong", [{"kind": "bodé"}, {"axis": "kHz"}, {"amplitude": "db"}])
def test_unknown_kinds_axes_and_amplitudes_are_refused(wrong):
    with pytest.raises(InputError, match=f"{next(iter(wrong))}: found"):
        response().plot(**wrong)
