"""What a report says is what its points are, in its pictures too: what is wrong is marked, what was claimed can be compared with what is right."""

import json
import math

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.gallery import GALLERY, system
from mbconstrained.analyses.stability import (
    Point,
    ScalingSweep,
    StabilityReport,
    digit_plots,
    digit_table,
    gallery_report,
    gallery_table,
    overview_plot,
    points_of,
    reason_tables,
    scene_report,
)
from mbconstrained.analyses.study_problem import mechanical_problem
from mbconstrained.ground.errors import InputError
from mbconstrained.ground.tolerances import EPS
from mbconstrained.page.plots import plot_image
from mbconstrained.scene.run.scene import read_scene


def point(parameter, right=15.0, expected=15.5, claimed=14.0, **more) -> Point:
    """A point whose errors give these digits."""
    error, condition, estimate = (None if digits is None else 10.0**-digits for digits in (right, expected, claimed))
    return Point(parameter, error, estimate, condition and condition / EPS, **more)


def sweep(title: str, *points: Point, name: str = "", parameter: str = "stiffness ratio") -> ScalingSweep:
    return ScalingSweep(name or title, title, "stiffness", "it is stiff", "made for this gallery", parameter, points)


def spring(*points: Point) -> ScalingSweep:
    return sweep("The spring", *points, name="spring", parameter="stiffness in N/m")


def report(*sweeps: ScalingSweep, of_scene=False) -> StabilityReport:
    return StabilityReport("Title", sweeps, {"cores": "2"}, of_scene)


CALM = report(spring(point(1.0), point(10.0, right=12.0, expected=12.3, claimed=12.0)))
WRONG = report(
    spring(
        point(1.0),
        point(1e2, right=3.0, claimed=12.0),
        point(1e4, claimed=1.0, warnings=("a rank decision has no clear gap: 3 times", "the estimate")),
        Point(1e6, refused="beyond float64"),
        Point(1e8, estimate=1e-3, unknown="took more than 30 s"),
    )
)


def test_what_is_wrong_without_a_warning_is_not_trusted_and_nothing_else_is():
    assert CALM.is_trusted and not WRONG.is_trusted
    assert report(spring(WRONG.sweeps[0].points[2], WRONG.sweeps[0].points[3])).is_trusted


def test_fewer_digits_than_the_data_allow_are_told():
    found = report(
        spring(point(1.0, right=9.0, expected=15.0, claimed=8.0), point(2.0, right=8.0, expected=8.1, claimed=8.0)), of_scene=True
    )
    assert "Furthest below what the data determine: 9.0 right" in found.sentences[-1]


def test_tables_count_and_name():
    (row,) = digit_table(WRONG).rows
    assert row == ("stiffness", "spring", "1 … 1e+08", "5", "1", "1", "1", "1", "3.0", "15.5", "12.0")
    titles = {table.title: table.rows for table in reason_tables(WRONG)}
    assert titles["Wrong without a warning"] == (
        ("spring", "100", "only 3.0 digits are right, the estimate claims 12.0, without a warning"),
    )
    assert titles["Warnings"] == (("spring", "1e+04", "a rank decision has no clear gap"),)
    assert titles["Refused"] == (("spring", "1e+06", "beyond float64"),)
    assert titles["Not judged"] == (("spring", "1e+08", "took more than 30 s"),)
    assert reason_tables(CALM) == []
    assert gallery_table(CALM).rows == (("spring", "The spring", "stiffness in N/m", "it is stiff", "made for this gallery"),)


def test_nothing_answered_at_all():
    found = report(spring(Point(1.0, refused="no")))
    assert digit_table(found).rows[0][-3:] == ("–", "–", "–") and len(found.sentences) == 3
    assert found.sentences[0].startswith("No answer was compared with exact arithmetic")
    assert not list(found.answer("title").plots())


@pytest.mark.parametrize("found", [CALM, WRONG], ids=["calm", "wrong"])
def test_the_report_is_plain_data_and_a_page(found):
    answer = found.answer("title")
    data = json.loads(json.dumps(answer.to_dict(), allow_nan=False))
    assert data["counts"]["wrong"] == found.count("wrong") and len(data["sweeps"][0]["points"]) == len(found.sweeps[0].points)
    content = answer.page()
    assert content.notices[0].doubtful == (not found.is_trusted) and len(content.plots) == 1
    assert any("stiff" in str(block) for block in answer.blocks())


def test_where_there_are_no_equations_the_reason_stands():
    """Rows that contradict each other at a factor are refused when the system is made, before anything is solved."""

    def build(factor):
        rows = [mb.Constraint([1.0], value=1.0), mb.Constraint([1.0], value=factor)]
        return mechanical_problem("held twice", mb.MechanicalSystem([[1.0]], constraints=rows), [0.0, 1.0], [1.0])

    fine, refused = points_of(build, (1.0, 2.0), lambda text: None)
    assert fine.verdict == "right" and refused.verdict == "refused" and "constraint" in refused.refused


def test_some_systems_of_the_gallery():
    told = []
    found = gallery_report([system("damping_ratio")], told.append)
    assert [one.name for one in found.sweeps] == ["damping_ratio"] and found.is_trusted
    assert len(told) == len(found.sweeps[0].points) > 5
    with pytest.raises(InputError, match="damping_ratio"):
        system("damping_rato")
    assert len({one.name for one in GALLERY}) == len(GALLERY) >= 20


@pytest.mark.long
def test_a_scene_is_turned_by_all_that_it_has():
    found = scene_report(read_scene("examples/critically_damped.toml"), decades=2, step=2)
    assert [one.title for one in found.sweeps][-1] == "horizon"
    assert [p.parameter for p in found.sweeps[0].points] == [0.01, 1.0, 100.0]
    assert found.is_trusted and found.of_scene
    uneven = scene_report(read_scene("examples/critically_damped.toml"), decades=2, step=3)
    assert [p.parameter for p in uneven.sweeps[0].points] == [0.01, 1.0, 100.0]  # its ends and the scene itself, whatever the step
    answer = found.answer("title")
    together, *plots = answer.plots()
    assert [curve.name for curve in together.curves] == [plot.title for plot in plots] and plots[-1].title == "horizon"


# --- pictures

FACTORS = 10.0 ** np.arange(-8, 9, 2)
STEADY = sweep("calm", *map(point, FACTORS))
MIXED = sweep(
    "mixed",
    point(1e-2, 12.0, 13.0, 11.0),
    point(1e0, 8.0, 9.0, 8.5),
    point(1e2, 5.0, 8.0, 4.0, warnings=("a warning",)),
    point(1e4, 1.0, 8.0, 7.0),
    Point(1e6, refused="no"),
    Point(1e8, estimate=1.0, unknown="not known"),
)


def test_the_three_curves_have_the_digits():
    (plot,) = digit_plots([STEADY])
    assert {curve.name: curve.values.tolist() for curve in plot.curves} == {
        f"digits {key}": pytest.approx([digits] * len(FACTORS))
        for key, digits in (("right", 15.0), ("claimed", 14.0), ("expected", 15.5))
    }
    assert plot.times.tolist() == FACTORS.tolist() and plot.scales == ("log", "linear") and not plot.marks
    assert plot.axes[1].low <= 0 and plot.axes[1].high >= 16


@pytest.mark.long
@pytest.mark.parametrize(
    "points",
    [
        (point(1.0),),
        (point(3.7e5),),
        (Point(1.0, refused="no"),),
        (point(0.0), point(1.0)),
        (point(-1.0), point(1.0)),
        (Point(1.0, 1e-99, math.nan), Point(10.0, math.inf, 0.0, math.inf)),
        tuple(point(10.0**power) for power in range(-300, 300, 50)),
    ],
)
def test_odd_sweeps_are_drawn(points):
    for plot in digit_plots([sweep("odd", *points)]):
        assert plot_image(plot, "png")[1:4] == b"PNG"


def test_all_sweeps_together_have_their_digits_and_marks():
    (plot,) = overview_plot([STEADY, MIXED])
    factors = sorted({point.parameter for sweep in (STEADY, MIXED) for point in sweep.points})
    assert plot.times.tolist() == factors and plot.shown == 2
    for curve, one in zip(plot.curves, (STEADY, MIXED)):
        right = {point.parameter: point.right for point in one.points if point.right is not None}
        assert curve.name == one.title
        assert dict(zip(plot.times[curve.drawn], curve.values[curve.drawn])) == pytest.approx(right)
    assert {marks.curve for marks in plot.marks} == {1} and len(plot.marks) == 4
