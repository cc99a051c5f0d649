"""Motions and modes that were computed in Python have pages, plots and views of their own."""

import re

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.python_models import result_of


def machine() -> mb.MechanicalSystem:
    model = mb.LumpedModel()
    model.mass("cart", 2.0)
    model.mass("load", 1.0)
    model.spring("ground", "cart", stiffness=50.0)
    model.spring("cart", "load", stiffness=20.0)
    model.damper("cart", "load", damping=0.3)
    return model.assemble()


def test_the_page_of_a_motion_has_its_title_escaped_its_curves_and_the_drawing_of_its_model(tmp_path):
    motion = machine().solve([0.1, 0.0])
    path = motion.write_page(tmp_path / "new" / "motion.html", title="Cart & <load>", end=3.0)
    page = path.read_text(encoding="utf-8")
    assert "Cart &amp; &lt;load&gt;" in page and "<load>" not in page
    drawing = result_of(motion).animation.drawing
    assert sorted(link.kind for link in drawing.links) == ["damper", "spring", "spring"]


def test_the_values_of_the_page_are_those_of_the_motion_with_its_own_forces():
    system = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]], force=[2.0])
    x = system.solve([1.0], force=mb.step([1.0]))
    result = result_of(x, end=2.0, points=5)
    assert (result.values == x(np.linspace(0.0, 2.0, 5))).all()
    assert result.error_estimates["displacement"] <= 1e-12


@pytest.mark.parametrize(
    "matrix, initial, end",
    [
        ([[[4.0]], [[0.0]], [[1.0]]], [[1.0], [0.0]], 8 * np.pi),  # eight periods of 2 rad/s
        ([[[0.5]], [[1.0]]], [[1.0]], 10.0),  # five time constants of 2 s
        ([[[0.0]], [[1.0]]], [[1.0]], 1.0),  # no scale of time at all
    ],
)
def test_the_last_time_follows_from_the_slowest_motion(matrix, initial, end):
    result = result_of(mb.solve(mb.PolynomialMatrix(matrix), initial))
    assert result.times[-1] == pytest.approx(end, rel=0.05)


def test_a_frame_for_notebooks_holds_the_page_as_text():
    text = machine().solve([0.1, 0.0]).view(height=500, end=1.0)._repr_html_()
    assert text.startswith('<iframe srcdoc="') and 'height="500"' in text
    assert "<script" not in text, "all of the page is escaped inside of the attribute"


def test_notebooks_show_a_motion_with_its_plot():
    text = machine().solve([0.1, 0.0])._repr_html_()
    assert text.count("<img") == 1 and "2 coordinates" in text


@pytest.mark.parametrize("quantity, count, label", [("displacement", 2, "displacement (m)"), ("energy", 4, "energy (J)")])
def test_curves_in_axes_of_matplotlib_are_the_motion(quantity, count, label):
    from matplotlib.figure import Figure

    figure = Figure()
    motion = machine().solve([0.1, 0.0])
    axes = motion.plot(figure.add_subplot(), quantity, end=2.0, points=9)
    assert len(axes.lines) == count and axes.get_ylabel() == label
    if quantity == "displacement":
        assert (np.array([line.get_ydata() for line in axes.lines]) == motion(np.linspace(0.0, 2.0, 9))).all()


def test_show_opens_the_page_in_a_browser(monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    path = mb.show(machine().solve([0.1, 0.0]), end=1.0)
    assert opened == [path.as_uri()] and path.is_file()


@pytest.mark.parametrize(
    "options, text",
    [
        ({"plots": ["speed"]}, "plots: found 'speed'; expected one of displacement"),
        ({"plots": ["reaction"]}, "found reaction, but there are no constraint rows"),
        ({"end": -1}, "end: found -1"),
        ({"points": 1}, "points: found 1; expected a whole number of at least 2"),
        ({"drawing": {"veiw": "top"}}, 'write_page: drawing: unknown key "veiw"; did you mean "view"?'),
        ({"drawing": ["top"]}, "write_page: drawing: found"),
        ({"drawing": {"body": [{"name": "cart", "moves": {"card": [1, 0, 0]}}]}}, 'there is no coordinate "card"'),
    ],
)
def test_what_is_wrong_is_reported_and_an_earlier_page_stays(tmp_path, options, text):
    path = tmp_path / "x.html"
    path.write_text("before", encoding="utf-8")
    with pytest.raises(mb.InputError, match=re.escape(text)):
        machine().solve([0.1, 0.0]).write_page(path, **options)
    assert path.read_text(encoding="utf-8") == "before"


def test_modes_of_sparse_matrices_have_no_page():
    import scipy.sparse

    modes = mb.MechanicalSystem(scipy.sparse.eye_array(3), stiffness=scipy.sparse.eye_array(3)).modes(count=1)
    with pytest.raises(mb.InputError, match="these modes belong to no system of arrays"):
        modes.write_page("x.html")


def test_a_robot_is_drawn_as_a_scene_draws_it(tmp_path):
    robot, data = mb.read_robot("robots/four_bar")
    system = robot.linearize(robot.equilibrium(**data.posture))
    force = mb.step([0.02, 0.0, 0.0])
    page = system.solve(force=force).write_page(tmp_path / "x.html", end=1.2).read_text(encoding="utf-8")
    scene = result_of(system.solve(force=force), end=1.2)
    bodies = [body.name for body in scene.animation.drawing.bodies]
    assert {"crank", "coupler", "rocker"} < set(bodies) and "<h2>Posture</h2>" in page
    modes = system.modes().write_page(tmp_path / "modes.html").read_text(encoding="utf-8")
    assert "coupler" in modes


def test_entries_of_a_drawing_change_the_pages_of_a_motion_and_of_modes(tmp_path):
    system, options = (
        machine(),
        {"view": "top", "note": "seen < from above", "scale": 3, "body": [{"name": "cart", "color": "#123456"}]},
    )
    drawing = result_of(system.solve([0.1, 0.0]), drawing=options).animation.drawing
    assert (drawing.view.pitch, drawing.scale, drawing.note) == (pytest.approx(np.pi / 2), 3.0, "seen < from above")
    assert [body.color for body in drawing.bodies if body.name == "cart"] == ["#123456"]
    for answer in (system.solve([0.1, 0.0]), system.modes()):
        page = answer.write_page(tmp_path / "x.html", drawing=options).read_text(encoding="utf-8")
        assert "seen &lt; from above" in page and "#123456" in page


def test_a_motion_through_phases_has_the_reactions_of_all_and_its_own_end():
    free = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]])
    held = free.with_constraints(mb.Constraint([1.0], value=0.5, names="stop"))
    machine = mb.SwitchedSystem({"free": free, "held": held}, [mb.Transition("free", "held", when={"x1": 1.0}, above=0.5)])
    motion = machine.solve(velocity=[2.0], end=3.0)
    result = result_of(motion, plots=["reaction"], points=7)
    assert result.times[-1] == motion.end == 3.0
    assert result.curves("reaction").values[0] == pytest.approx([0.0, *[2.0] * 6], rel=1e-12)
    (arrow,) = result.animation.overlay.events[0].impulses
    assert arrow.size == pytest.approx(-np.sqrt(3.0), rel=1e-12), "(1/2) 2^2 = (1/2) v^2 + 2 0.5^2"


def test_the_page_of_a_switched_motion_without_events_has_one_phase(tmp_path):
    model = mb.LumpedModel()
    model.mass("a", 1.0), model.spring("ground", "a", 9.0), model.contact("ground", "a", gap=1.0)
    motion = model.assemble().solve({"a": 0.1}, end=3.0)
    page = motion.write_page(tmp_path / "page.html").read_text(encoding="utf-8")
    assert motion.events == () and "<h2>Events</h2>" not in page and page.count('class="of-phase"') == 1
