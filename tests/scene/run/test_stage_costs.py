"""What a stage takes: nothing is lost, nothing fails, how memory is measured is reported, and a limit of time is kept."""

import ast
import subprocess
import sys
import time

import pytest

from mbconstrained.scene.run import plan as module
from mbconstrained.scene.run import plan as stage_costs
from mbconstrained.scene.run.plan import (
    GROWTH,
    NOT_MEASURED,
    OWN_PEAK,
    Cost,
    Costs,
    OutOfTime,
    memory_note,
    time_limit,
)

SIZE = 64_000_000
SLACK = SIZE // 8  # pages that come and go beside what is measured

resets = pytest.mark.skipif(stage_costs._resident()[1] is None, reason="the highest resident memory cannot be set back here")


def touch() -> None:
    """Use memory and give it back."""
    assert len(bytearray(b"x") * SIZE) == SIZE


#: In a process of its own: of one that has run many tests the kernel may take pages back while a lap is measured.
LAPS = f"""
from mbconstrained.scene.run.plan import Costs
meter = Costs()
def touch(): assert len(bytearray(b"x") * {SIZE}) == {SIZE}
touch()
large, small = meter.lap(""), meter.lap("")
touch()
again = meter.lap("")
print(*((cost.memory, cost.peak) for cost in (large, small, again)), sep="\\n")
"""


@resets
def test_each_lap_has_a_highest_memory_of_its_own():
    assert memory_note() == OWN_PEAK
    found = subprocess.run([sys.executable, "-c", LAPS], capture_output=True, text=True, check=True).stdout
    large, small, again = (Cost(0.0, *ast.literal_eval(line)) for line in found.splitlines())
    for cost in (large, again):
        assert abs(cost.memory - SIZE) < SLACK and cost.peak >= cost.memory
    assert small.memory < SLACK and small.peak < large.peak - SIZE + 2 * SLACK


def test_without_a_highest_of_its_own_the_growth_is_told(monkeypatch):
    pytest.importorskip("resource")
    monkeypatch.setattr(stage_costs, "_CLEAR", "/nowhere/clear_refs")
    monkeypatch.setattr(stage_costs, "_STATUS", "/nowhere/status")
    assert memory_note() == GROWTH
    meter = Costs()
    touch()
    meter.lap("")
    touch()
    again = meter.lap("")
    assert 0 <= again.memory < SLACK  # what was needed before is no growth
    assert again.peak == stage_costs._resident()[0]


def test_without_any_measure_none_is_told_and_nothing_fails(monkeypatch):
    monkeypatch.setattr(stage_costs, "_CLEAR", "/nowhere/clear_refs")
    monkeypatch.setattr(stage_costs, "_STATUS", "/nowhere/status")
    monkeypatch.setitem(sys.modules, "resource", None)
    assert memory_note() == NOT_MEASURED
    cost = Costs().lap("")
    assert (cost.memory, cost.peak) == (None, None) and cost.seconds >= 0


class Slow:
    """Takes its time when it goes."""

    def __del__(self):
        time.sleep(0.2)


def test_what_takes_longer_is_broken_off():
    with pytest.raises(OutOfTime), time_limit(0.05):
        time.sleep(30.0)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it is lost there: that is what is tested
def test_an_alarm_that_is_lost_in_a_finalizer_is_rung_again(monkeypatch):
    monkeypatch.setattr(module, "AGAIN", 0.1)
    with pytest.raises(OutOfTime), time_limit(0.05):
        Slow()
        time.sleep(30.0)
