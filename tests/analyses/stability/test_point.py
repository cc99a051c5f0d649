"""Verdicts: on problems whose answers are known, on answers that lie, on none; and what counts as a warning."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.gallery import bodies, equations, moving
from mbconstrained.analyses.stability import MOST_EXPECTED, Point, point_of
from mbconstrained.analyses.study_problem import StudyProblem, problem_of
from mbconstrained.ground.tolerances import EPS, TRUST_LIMIT
from tests.oracles.referee import case

DECAY = equations([[[1.0]], [[1.0]]], [[1.0]], [0.5, 1.0, 2.0])


class Told:
    """A response that says something else than it knows."""

    def __init__(self, real, **lies):
        self._real, self._lies = real, lies

    def __call__(self, times):
        return self._lies.get("values", self._real(times))

    def error_estimate(self, times):
        return self._lies.get("estimate", self._real.error_estimate(times))

    def __getattr__(self, name):
        return self._lies[name] if name in self._lies else getattr(self._real, name)


@dataclass(frozen=True)
class Faked(StudyProblem):
    answer: object = None

    def solve(self):
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


def faked(answer, problem=DECAY):
    return Faked(problem.title, problem.polynomial_matrix, problem.initial, problem.force, problem.times, answer=answer)


def told(**lies):
    return point_of(faked(Told(DECAY.solve(), **lies)), 3.0, 1)


# --- verdicts


@pytest.mark.parametrize(
    ("error", "estimate", "warnings", "verdict"),
    [
        (1e-13, 1e-13, (), "right"),
        (0.9e-12, 1e-13, (), "right"),
        (1.1e-12, 1e-13, (), "wrong"),
        (0.0, 1e-15, (), "right"),
        (79 * EPS, 0.0, (), "right"),  # claims below eight roundings count as eight
        (81 * EPS, 0.0, (), "wrong"),
        (1.0, 0.5, ("a warning",), "warned"),
        (1.0, 1e-15, ("a warning",), "warned"),
        (math.inf, 1e-15, (), "wrong"),
        (math.nan, 1e-15, (), "wrong"),
        (None, 1e-15, (), "not judged"),
        (None, 1e-15, ("a warning",), "warned"),
    ],
)
def test_verdicts(error, estimate, warnings, verdict):
    assert Point(1.0, error, estimate, warnings=warnings).verdict == verdict


def test_an_answer_that_is_right():
    point = point_of(DECAY, 2.0)
    assert point.verdict == "right" and point.parameter == 2.0 and not point.warnings and not point.refused and not point.unknown
    assert point.right > 15 and 14 < point.expected <= MOST_EXPECTED and 14 < point.claimed < 15
    assert point.right == (min(-math.log10(point.error), 16) if point.error else 16)


def test_a_lie_that_is_told_is_told():
    values = DECAY.solve()(DECAY.times)
    notice = mb.Notice("rank", "a rank decision has no clear gap", doubtful=True)
    assert told(values=values * 1.5, notices=(notice,)).verdict == "warned"
    assert told(values=values * 1.5, notices=(notice,)).warnings == (notice.text,)
    honest = told(values=values * 1.5, estimate=0.4)
    assert honest.verdict == "warned" and "0.4" in honest.warnings[0]


def test_a_notice_that_is_no_doubt_is_no_warning():
    notice = mb.Notice("jump", "x1: its value jumps")
    point = told(values=DECAY.solve()(DECAY.times) * 2, notices=(notice,))
    assert point.verdict == "wrong" and point.warnings == () and point.notices == (notice.text,)


def test_estimates_at_the_limit():
    assert told(estimate=TRUST_LIMIT).warnings == ()
    assert len(told(estimate=np.nextafter(TRUST_LIMIT, 1)).warnings) == 1
    assert len(told(estimate=math.nan).warnings) == 1 and told(estimate=math.nan).claimed == 0


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_is_wrong(value):
    values = DECAY.solve()(DECAY.times)
    values[0, 1] = value
    assert told(values=values).verdict == "wrong" and told(values=values).right == 0


def test_zero_answers():
    rest = equations([[[1.0]], [[1.0]]], [[0.0]], [1.0])
    assert point_of(rest).verdict == "right" and point_of(rest).right == 16 and point_of(rest).expected == MOST_EXPECTED
    gone = equations([[[1.0]], [[1.0]]], [[1.0]], [1000.0])
    assert point_of(gone).verdict == "right"  # e^-1000 is no float: nothing to be right about
    loud = Told(rest.solve(), values=np.array([[1e-9]]))
    assert point_of(faked(loud, rest)).verdict == "wrong"


# --- refused, unknown


def test_problems_without_an_answer_are_refused_in_words():
    singular = equations([[[1.0, 1.0], [1.0, 1.0]], np.zeros((2, 2))], [[0.0, 0.0]], [1.0])
    point = point_of(singular, 7.0)
    assert point.verdict == "refused" and point.refused and point.parameter == 7.0
    assert point.right is None and point.claimed is None and math.isnan(point.expected) and point.reason == point.refused
    growing = point_of(equations([[[-1.0]], [[1.0]]], [[1.0]], [1000.0]))
    assert growing.verdict == "refused" and "beyond the range of float64" in growing.refused


def test_an_answer_where_exact_arithmetic_finds_none_is_wrong():
    class Singular(Told):
        @property
        def exact(self):
            raise mb.SingularPolynomialMatrix("det A(s) is zero for every s")

    point = point_of(faked(Singular(DECAY.solve())))
    assert point.verdict == "wrong" and point.right == 0 and "det A(s)" in point.unknown


def test_the_time_is_limited():
    slow = moving(bodies([1.0] * 12, [(i, i + 1, 1.0 + i) for i in range(12)]), [1.0, 9.0], (np.ones(12), np.zeros(12)))
    point = point_of(slow, seconds=1e-4)
    assert point.verdict == "not judged" and point.right is None and "0.0001 s" in point.unknown


@pytest.mark.parametrize("name", ["rot_ak3", "rot_two_mass_pos_incons"])
def test_data_that_were_rounded_out_of_their_structure_have_no_truth_here(name):
    """The answer is that of the problem that was meant; exact arithmetic knows the one that was written."""
    one = case(name)
    point = point_of(StudyProblem(name, mb.PolynomialMatrix(one.coefficients), one.initial, one.force, one.times))
    assert point.verdict == "not judged" and point.right is None and "finite zeros" in point.unknown


# --- as data


def test_a_point_is_plain_data_with_a_reason():
    points = [
        point_of(DECAY),
        told(values=DECAY.solve()(DECAY.times) * 2),
        told(estimate=math.nan),
        Point(1.0, refused="no motion"),
    ]
    assert [point.verdict for point in points] == ["right", "wrong", "warned", "refused"]
    for point in points:
        assert json.loads(json.dumps(point.to_dict(), allow_nan=False))["verdict"] == point.verdict
    assert points[0].reason == "" and points[3].reason == "no motion" and points[2].reason == points[2].warnings[0]
    assert points[1].reason.startswith("only 0.0 digits are right, the estimate claims 14.")


# --- warnings are those of mbconstrained run


SCENE = """
title = "pair"
[model]
kind = "matrices"
coordinates = ["a", "b"]
mass = {mass}
stiffness = [[{stiff} , -{stiff}], [-{stiff}, {sum}]]
[initial]
displacement = {{ a = "1 m" }}
[time]
end = "5 s"
points = 11
[output]
page = false
csv = false
npz = false
plots = ["displacement"]
"""


@pytest.mark.parametrize("stiff", [1e2, 1e13, 1e14])
@pytest.mark.parametrize("mass, doubtful", [([[1, 0], [0, 1]], False), ([[1, 1 / 3], [3, 1 + 3e-15]], True)])
def test_a_scene_is_trusted_where_its_point_has_no_warning(tmp_path, stiff, mass, doubtful):
    path = tmp_path / "pair.toml"
    path.write_text(SCENE.format(mass=mass, stiff=stiff, sum=stiff + 3))
    scene = mb.read_scene(path)
    doubts = {notice.text for notice in scene.run().notices if notice.doubtful}
    warnings = point_of(problem_of(scene), variations=0).warnings
    assert bool(doubts) == bool(warnings) == doubtful
    assert len(doubts) == len(warnings)
