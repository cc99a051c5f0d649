"""The gallery: every system is what it declares to be, and no answer is wrong without a warning but those that are known."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses import gallery
from mbconstrained.analyses.gallery import GALLERY, System, broken_promises, system
from mbconstrained.analyses.stability import points_of

#: Wrong without a warning, and why. Empty is the goal.
KNOWN_WRONG: dict[tuple[str, float], str] = {}

#: Refused though there is an answer, and why; or because there is none.
KNOWN_REFUSED = {
    ("unstable_growth", 250.0): "e^780 is no float",
}

#: Values of the parameter at which systems are tried here, beside the first, the middle and the last.
MORE = {
    *KNOWN_WRONG,
    *KNOWN_REFUSED,
    *((name, ratio) for name in ("stiff_chain_assembled", "penalty_link", "penalty_joint") for ratio in (1e12, 1e15, 1e16, 1e17)),
    ("weak_coupling", 1e-14),
    ("near_critical", 1e-14),
}

LONG = 20  # bodies that take seconds

names = [one.name for one in GALLERY]


def chosen(one: System) -> list[float]:
    values = [value for value in one.values if one.name != "chain_of_masses" or value <= LONG]
    wanted = {values[0], values[len(values) // 2], values[-1], *(value for name, value in MORE if name == one.name)}
    return [value for value in values if value in wanted]


everywhere = pytest.mark.parametrize("name", names)


@cache
def points(name: str):
    """By parameter, without the condition."""
    values = chosen(system(name))
    return dict(zip(values, points_of(system(name).build, values, variations=0)))


# --- promises


@pytest.mark.long
@everywhere
def test_declared_properties_hold_in_exact_arithmetic(name):
    one = system(name)
    assert [broken for value in chosen(one) for broken in broken_promises(one, value)] == []


def test_a_broken_promise_is_told():
    liar = replace(system("damping_ratio"), declared={"finite_zeros": 3, "undamped": True, "decades": 0}, declared_by_value={})
    assert broken_promises(liar, 1.0) == (
        "damping_ratio at 1: finite_zeros is 2, declared 3",
        "damping_ratio at 1: undamped is False, declared True",
    )
    ratios = replace(system("light_tip"), declared={"mass_ratio": 1.0 + 1e-9}, declared_by_value={})
    assert broken_promises(ratios, 1.0) and not broken_promises(replace(ratios, declared={"mass_ratio": 1.0}), 1.0)


def test_a_problem_without_an_answer_keeps_no_promise_and_stops_nothing(monkeypatch):
    def damping_ratio(parameter):
        raise mb.InputError("nothing to build")

    monkeypatch.setattr(gallery, "damping_ratio", damping_ratio)
    assert broken_promises(system("damping_ratio"), 1.0) == ("damping_ratio at 1: there is no problem (nothing to build)",)


# --- answers


@pytest.mark.long
@everywhere
def test_no_answer_is_wrong_without_a_warning_but_those_known(name):
    wrong = {(name, value) for value, point in points(name).items() if point.verdict == "wrong"}
    assert wrong == {known for known in KNOWN_WRONG if known[0] == name}


@pytest.mark.long
@everywhere
def test_no_problem_is_refused_but_those_known(name):
    refused = {(name, value) for value, point in points(name).items() if point.verdict == "refused"}
    assert refused == {known for known in KNOWN_REFUSED if known[0] == name}
    assert not [point.unknown for point in points(name).values() if point.unknown]


def test_stiff_chains_are_right_for_the_data_as_given():
    """Assembled or not: what a sum of stiffnesses has lost is shown by the condition, not by the error of the answer."""
    for name in ("stiff_chain", "stiff_chain_assembled"):
        assert all(point.right > 13 and point.estimate < 1e-12 for point in points(name).values())
    assert all(point.verdict == "right" for point in points("stiff_chain").values())


# --- units


@pytest.mark.parametrize("name", ["small_to_huge", "unit_of_time"])
def test_powers_of_two_change_no_digit(name):
    """Values divided by the unit of length are the same floats, error and estimate too."""
    one, found = system(name), []
    for value in one.values:
        problem = one.build(value)
        values = problem.solve()(problem.times)
        found.append(values / problem.initial[0, 0])
    assert all(np.array_equal(values, found[0]) for values in found)
    estimates = {point.estimate for point in points(name).values()}
    assert len(estimates) == 1 and len({point.error for point in points(name).values()}) == 1


def test_decimal_units_change_no_more_than_the_condition():
    one, found = system("unit_of_force"), []
    for value in one.values:
        problem = one.build(value)
        found.append(problem.solve()(problem.times))
    for values in found:
        assert np.abs(values - found[4]).max() <= 2 * 2e4 * 2**-52 * np.abs(found[4]).max()  # condition 2e4, both rounded


def test_scattered_scales_change_no_digit_of_the_true_values():
    one = system("scattered_scales")
    claims = [point.claimed for point in points(one.name).values()]
    assert max(claims) - min(claims) < 1
