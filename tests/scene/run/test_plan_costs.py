"""What stages took, as tables, as plain data, and on the page."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys

import pytest

from mbconstrained.scene.run.plan import Cost, Plan, Stage
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of

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


def test_shares_are_of_the_whole():
    rows = {row[0]: row[1:] for row in PLAN.cost_tables()[0].rows}
    assert rows["first"] == ("250.0", "25.0 %", "3.0", "always")
    assert rows["inside"] == ("–", "–", "–", "because (in: first)")
    assert rows["second"] == ("750.0", "75.0 %", "5.0", "asked for")
    assert rows["all"][:3] == ("1000.0", "100 %", "7.0")
    assert PLAN.cost_tables()[1].rows == (("third", "not asked for"),)


def test_a_plan_that_has_not_run_has_no_costs(tmp_path):
    plan = Plan((Stage("first", True, "always"),))
    assert plan.total == Cost(0)
    reading = {"read the scene", "units", "assemble the model", "scaling and staircase"}
    assert set(scene_of(tmp_path, OSCILLATOR).plan().costs) == reading


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


def test_pages_of_the_same_scene_have_the_same_bytes(tmp_path):
    """In processes whose sets have different orders, whatever time their stages took."""
    script = (
        f"import mbconstrained as mb; mb.read_scene({str(EXAMPLES / 'four_bar.toml')!r}, {{{{'time.points': 21}}}}).run({{!r}})"
    )
    digests = set()
    for seed in "12":
        folder = tmp_path / seed
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", script.format(str(folder))], env=environment, check=True, capture_output=True)
        digests.add(hashlib.sha256((folder / "four_bar.time.points=21.html").read_bytes()).hexdigest())
    assert len(digests) == 1
