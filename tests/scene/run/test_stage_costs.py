"""What a stage takes: nothing is lost, how memory is measured is reported, totals are sums, and a limit of time is kept."""

import ast
import hashlib
import os
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
    Plan,
    Stage,
    memory_note,
    time_limit,
)
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of

SIZE = 64_000_000
SLACK = SIZE // 8  # pages that come and go beside what is measured

resets = pytest.mark.skipif(not stage_costs._set_back(), reason="the highest resident memory cannot be set back here")


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
    assert again.peak == stage_costs._highest()


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


PLAN = Plan(
    (
        Stage("first", True, "always", Cost(0.25, 3_000_000, 103_000_000)),
        Stage("inside", True, "because", part_of="first"),
        Stage("second", True, "asked for", Cost(0.75, 5_000_000, 107_000_000)),
        Stage("third", False, "not asked for"),
    )
)


def test_totals_are_those_of_the_stages():
    assert (PLAN.total.seconds, PLAN.total.peak) == (1.0, 107_000_000)
    assert PLAN.total.memory == 7_000_000  # the first began at 100 MB
    assert PLAN.totals() == "3 stages in 1 s, 7.0 MB of memory; 1 left out"
    assert PLAN.totals_to_dict() == {"taken": 3, "left_out": 1, "seconds": 1.0, "memory": 7_000_000, "peak": 107_000_000}


@pytest.mark.parametrize("name", ["two_masses", "pendulum", "descriptor"])
def test_every_stage_that_ran_has_its_cost_or_that_of_another(tmp_path, name):
    plan = read_scene(EXAMPLES / f"{name}.toml").run(tmp_path).plan
    for stage in plan.needed:
        assert (stage.cost is None) == bool(stage.part_of)
        assert not stage.part_of or stage.part_of in plan.costs
    assert all(stage.cost is None for stage in plan.left_out)
    assert plan.total.seconds == pytest.approx(sum(stage.seconds or 0 for stage in plan.needed))


def test_a_run_tells_totals_in_one_line_and_as_data(tmp_path):
    result = scene_of(tmp_path, OSCILLATOR).run(tmp_path)
    assert result.summary().splitlines()[-1] == f"Plan: {result.plan.totals()}"
    data = result.to_dict()
    assert data["totals"] == result.plan.totals_to_dict()
    assert all({"seconds", "memory"} <= set(stage) for stage in data["plan"])
    assert result.plan.page_table().rows


@pytest.mark.parametrize("name", ["two_masses", "four_bar"])
def test_pages_of_the_same_scene_have_the_same_bytes(tmp_path, name):
    """In processes whose sets have different orders, whatever time their stages took."""
    script = f"import mbconstrained as mb; mb.read_scene({str(EXAMPLES / name)!r} + '.toml').run({{!r}})"
    digests = set()
    for seed in "12":
        folder = tmp_path / seed
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", script.format(str(folder))], env=environment, check=True, capture_output=True)
        digests.add(hashlib.sha256((folder / f"{name}.html").read_bytes()).hexdigest())
    assert len(digests) == 1
