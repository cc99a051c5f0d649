"""Which peer is the rival, what counts as met, fits, tables and the picture, from figures that are given."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.analyses.timing import Timing
from tests.benchmarks.speed.command import BEGIN, END, Report, _Refusal, is_asked, rows_of, with_tables
from tests.benchmarks.speed.growth import Grown, exponent
from tests.benchmarks.speed.measure import Measured, ours
from tests.benchmarks.speed.picture import picture_of
from tests.benchmarks.speed.report import Row, growth_sentence, growth_table, markdown, ratio_table
from tests.benchmarks.speed.setup import SetUp
from tests.benchmarks.speed.workloads import WORKLOADS, Target, Workload


def method(name: str, error: float, one_run: float, further: float | None = None) -> Measured:
    """Half of a run is set-up."""
    half, later = Timing((one_run / 2,) * 3), Timing((one_run if further is None else further,) * 3)
    return Measured(name, error, half, half, later, later)


NOTHING_WANTED = Target()


def row(*methods: Measured, target: Target = NOTHING_WANTED, states: int = 20) -> Row:
    return Row(Workload("W0", "a chain", 10, states, lambda: None, target), methods)


US = method("mbconstrained", 1e-14, 2.0, 0.1)


def test_the_rival_is_the_fastest_that_is_as_right():
    found = row(US, method("slow", 1e-15, 9.0), method("fast", 5e-14, 4.0), method("wrong", 1e-3, 1.0))
    assert found.rival("one_run").name == found.rival("further").name == "fast"
    assert found.ratio("one_run") == 0.5 and found.ratio("further") == 0.025


def test_the_rival_of_a_run_may_be_another_than_of_further_evaluations():
    found = row(US, method("steps", 1e-14, 1.0), method("pairs", 1e-14, 3.0, 0.2))
    assert (found.rival("one_run").name, found.rival("further").name) == ("steps", "pairs")


def test_without_a_right_peer_there_is_no_ratio():
    found = row(US, method("wrong", 0.5, 1.0), Measured("broken", failure="lost"), target=Target(1.0, 1.0))
    assert found.ratio("one_run") is None and found.is_met("one_run") is None


def test_an_error_that_is_wanted_lets_peers_in_that_reach_it():
    peers = method("DOP853 3e-14", 2e-12, 100.0), method("steps", 1e-14, 1.0)
    found = row(US, *peers, target=Target(0.1, 0.1, 1e-11, "DOP853"))
    assert found.rival("one_run").name == "DOP853 3e-14" and found.is_met("one_run") and found.is_right


def test_named_peers_are_shown_beside_all_of_them():
    methods = US, method("DOP853", 1e-14, 100.0), method("steps", 1e-14, 1.0)
    named, whole = rows_of(row(target=Target(0.1, 0.1, 1e-11, "DOP853")).workload, methods)
    assert (named.ratio("one_run"), whole.ratio("one_run")) == (0.02, 2.0)
    assert (named.is_met("one_run"), whole.is_met("one_run")) == (True, None)
    assert not named.is_whole and whole.is_whole


@pytest.mark.parametrize(("error", "right"), [(1e-15, True), (3e-14, False)])
def test_without_a_wanted_error_ours_is_to_be_no_larger_than_that_of_lsim(error, right):
    assert row(method("mbconstrained", error, 1.0), method("lsim", 2e-14, 1.0)).is_right is right


def test_what_is_wanted_is_told_beside_the_fastest_peer_and_beside_lsim():
    found = row(US, method("lsim", 1e-14, 5.0), method("blocks", 1e-14, 1.0), target=Target(0.5, 0.05))
    assert (found.is_met("one_run"), found.is_met("one_run", "lsim")) == (False, True)
    assert (found.is_met("further"), found.is_met("further", "lsim")) == (False, True)
    assert "| ≤ 0.5 ✗ ✓ |" in ratio_table([found]) and found.as_json()["ratios"]["further"]["ratio_to_lsim"] == 0.02


def test_what_was_wanted_and_did_not_run_is_not_met():
    found = row(Measured("mbconstrained", failure="over 60 s"), method("lsim", 1e-14, 1.0), target=Target(1.0, 1.0))
    assert found.is_met("one_run") is False and "over 60 s" in ratio_table([found])


@given(st.floats(0.0, 4.0), st.floats(1e-9, 1e9))
def test_the_exponent_of_a_power_is_that_power(power, factor):
    sizes = np.array([10, 30, 100, 300, 1000])
    assert abs(exponent(sizes, factor * sizes**power) - power) < 1e-9


def test_the_exponent_is_that_of_the_largest_sizes():
    sizes = np.array([1, 10, 100, 1000, 10000])
    assert abs(exponent(sizes, np.maximum(1e5, sizes**2.0)) - exponent(sizes[2:], [1e5, 1e6, 1e8])) < 1e-9
    assert exponent([10], [1.0]) is None and exponent([10, 100], [0.0, 1.0]) is None


def test_memory_is_told_beyond_the_answer():
    one = Grown(100, 100, 200, 1.0, 0.1, memory=8e5 + 3 * 8 * 200**2)
    assert one.answer == 8e5 and one.matrices == 3
    assert Grown(100, 100, 200, 1.0, 0.1, memory=1e3).matrices == 0


def test_exponents_are_told_of_what_ran():
    sizes = [Grown(n, n, 2 * n, 1e-9 * n**3, 1e-6 * n**2, 1e3 * n) for n in (10, 100, 1000)]
    found = [*sizes, Grown(3000, 3000, 6000, failure="over 60 s")]
    assert "one run 3.0, further evaluation 2.0, memory 1.0" in growth_sentence(found) and "over 60 s" in growth_table(found)


def test_methods_that_were_slow_are_not_tried_where_they_would_be_far_slower():
    def workload(states: int, family: str) -> Workload:
        return Workload("W0", f"{states} states", 10, states, lambda: None, family=family)

    known: dict = {}
    _Refusal(workload(100, "a"), known, 60.0).remember([method("mbconstrained", 0.0, 2.0)])
    assert _Refusal(workload(1000, "a"), known, 60.0)(ours()) and not _Refusal(workload(300, "a"), known, 60.0)(ours())
    assert not _Refusal(workload(1000, ""), known, 60.0)(ours())


def test_what_took_no_time_is_tried_at_any_size():
    small, large = (Workload("W0", "a chain", 10, states, lambda: None, family="a") for states in (10, 10000))
    known: dict = {}
    _Refusal(small, known, 60.0).remember([method("mbconstrained", 0.0, 0.2)])
    assert not _Refusal(large, known, 60.0)(ours())


def test_the_time_of_lsim_is_told_where_it_is_right():
    assert row(US, method("lsim", 1e-13, 4.0)).beside("lsim", "one_run") == 0.5
    assert row(US, method("lsim", 0.5, 4.0)).beside("lsim", "one_run") is None


@pytest.mark.parametrize(
    ("only", "names"),
    [
        (["W1"], {"example 5.1", "example 5.2"}),
        (["damped chain, n = 10"], {"damped chain, n = 10"}),
        (["undamped chain", "growth"], {"undamped chain, n = 500"}),
        (["set-up"], set()),
        ([], {workload.name for workload in WORKLOADS}),
    ],
)
def test_what_is_asked_for(only, names):
    assert {workload.name for workload in WORKLOADS if is_asked(workload, only)} == names


def test_a_table_takes_the_place_of_what_stood_between_the_marks():
    text = f"a\n{BEGIN}\nold\n{END}\nb\n"
    assert with_tables(with_tables(text, "one"), "two") == f"a\n{BEGIN}\n\ntwo\n\n{END}\nb\n"
    with pytest.raises(ValueError, match="found 0 parts"):
        with_tables("no marks", "new")


def test_tables_have_as_many_cells_in_every_line():
    rows = [row(US, method("lsim", 1e-13, 1.0)), row(Measured("mbconstrained", failure="lost")), row(US)]
    timing = Timing((1.0, 2.0))
    report = Report(
        rows, [SetUp("a", 2, timing, timing, timing, timing), SetUp("b", 2, failure="lost")], [Grown(1, 1, 2, 1.0, 1.0, 1.0)]
    )
    blocks = [block.splitlines() for block in report.text.split("\n\n") if block.startswith("|")]
    assert len(blocks) == 7
    assert all(len({line.count("|") for line in block}) == 1 for block in blocks)
    assert markdown(["a"], []) == "| a |\n|---|"
    json.dumps(report.as_json(), allow_nan=False)


def test_the_picture_shows_every_ratio(tmp_path):
    rows = [row(US, method("lsim", 1e-13, 1.0), target=Target(0.5, 0.05)), row(US)]
    picture = picture_of(rows)
    assert ">2<" in picture.svg and ">0.1<" in picture.svg and "a chain 2 and 0.1" in picture.description
    Report(rows, [], []).write(tmp_path)
    assert (tmp_path / "speed.png").read_bytes()[1:4] == b"PNG" and "a chain" in (tmp_path / "speed.md").read_text()
    assert "nothing was measured" in picture_of([]).description
