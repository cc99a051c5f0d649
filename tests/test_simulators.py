"""The table of Hauksdottir and Sigurdsson: what is exact, what is of second order, and what is told when a tool is missing."""

import json
import runpy
from fractions import Fraction
from pathlib import Path

import pytest

import mbconstrained as mb
from examples import simulators
from examples.simulators import PRINTED, REFERENCE, simulator_report

ORACLES = Path(__file__).parent / "oracles"


@pytest.fixture(scope="module")
def report():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulators, "REPEATS", 1)
        return simulator_report(gammas=(1, 2, 3), steps=(1.0, 1e-2))


def runs(report, simulator, gamma):
    return [run for run in report.runs if run.simulator == simulator and run.gamma == gamma]


def test_the_reference_is_the_published_one():
    published = json.loads((ORACLES / "hauksdottir.json").read_text())
    for gamma, values in REFERENCE.items():
        assert list(values) == [published[f"I{gamma}({time})"] for time in (10, 100)]


def test_the_closed_form_has_all_digits(report):
    for gamma in (1, 2, 3):
        (run,) = runs(report, "mbconstrained", gamma)
        assert max(map(abs, run.errors)) < 1e-13 and run.step is None and run.seconds > 0


@pytest.mark.parametrize("simulator", ["scipy.signal.lsim", "control.forced_response"])
def test_simulators_with_a_step(report, simulator):
    """Steps and ramps exactly, the parabola to dt^2/12 y_1/y_3, as printed for MATLAB's lsim."""
    pytest.importorskip("scipy" if "scipy" in simulator else "control")
    for gamma in (1, 2):
        assert all(abs(error) < 1e-12 for run in runs(report, simulator, gamma) for error in run.errors)
    for run, printed in zip(runs(report, simulator, 3), PRINTED[3]):
        predicted = [run.step**2 / 12 * float(Fraction(a) / Fraction(b)) for a, b in zip(REFERENCE[1], REFERENCE[3])]
        assert run.errors == pytest.approx(predicted, rel=2e-3)
        assert run.errors == pytest.approx(printed, rel=0.05)


def test_without_control_its_rows_are_left_out_and_told(monkeypatch):
    monkeypatch.setattr(simulators, "_has_control", lambda: False)
    told = []
    report = simulator_report(gammas=(3,), steps=(1.0,), progress=told.append)
    assert [run.simulator for run in report.runs] == ["mbconstrained", "scipy.signal.lsim"]
    assert str(report).endswith("control is not installed: it is left out")
    assert told == ["I_3: mbconstrained", "I_3: scipy.signal.lsim, step 1 s"]


def test_inputs_that_have_no_samples_are_refused():
    with pytest.raises(mb.InputError, match="gammas: found 0"):
        simulator_report(gammas=(0, 1))


@pytest.mark.long
def test_the_example_prints_the_table(monkeypatch, capsys):
    monkeypatch.setattr(simulators, "STEPS", (1.0,))
    monkeypatch.setattr(simulators.simulator_report, "__defaults__", ((2, 3), (1.0,), lambda text: None))
    runpy.run_path(str(Path(__file__).parents[1] / "examples" / "simulators.py"), run_name="__main__")
    assert "mbconstrained" in capsys.readouterr().out
