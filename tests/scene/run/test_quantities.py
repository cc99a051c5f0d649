"""[[output.quantity]]: forces and elongations of elements and relative motions, against their definitions."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.robots import SCENE, press
from tests.scene.scenes import scene_of

CAR = """
[model]
kind = "lumped"

[[model.mass]]
name = "wheel"
mass = 40

[[model.mass]]
name = "body"
mass = 400

[[model.spring]]
name = "tyre"
between = ["ground", "wheel"]
stiffness = 2e5

[[model.spring]]
name = "suspension"
between = ["wheel", "body"]
stiffness = 2e4
rest_length = 0.3

[[model.damper]]
name = "shock absorber"
between = ["wheel", "body"]
damping = 1500

[initial]
displacement = { wheel = 0.01, body = 0.35 }

[time]
end = 1
points = 11
"""
PLACES = """
[output]
page = false

[[output.quantity]]
of = "suspension"

[[output.quantity]]
of = "suspension"
quantity = "elongation"
name = "stretch"

[[output.quantity]]
of = "shock absorber"

[[output.quantity]]
between = ["wheel", "body"]
quantity = "acceleration"
"""


def test_forces_elongations_and_relative_motions_of_a_lumped_model(tmp_path):
    result = scene_of(tmp_path, CAR + PLACES).run()
    curves, x, v, a = (result.curves(kind) for kind in ("quantity", "displacement", "velocity", "acceleration"))
    stroke = x.values[1] - x.values[0]
    wanted = [2e4 * (stroke - 0.3), stroke - 0.3, 1500 * (v.values[1] - v.values[0]), a.values[1] - a.values[0]]
    assert curves.names == ("suspension", "stretch", "shock absorber", "body relative to wheel")
    assert curves.units == ("N", "m", "N", "m/s^2")
    assert curves.values == pytest.approx(np.array(wanted), rel=1e-9, abs=1e-9)


def test_they_stand_in_csv_and_npz_and_on_the_page(tmp_path):
    scene_of(tmp_path, CAR + PLACES.replace("page = false", "animation = false")).run(tmp_path)
    head = (tmp_path / "scene.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "suspension force (N)" in head and "body relative to wheel relative acceleration (m/s^2)" in head
    with np.load(tmp_path / "scene.npz") as arrays:
        assert arrays["quantity"].shape == (4, 11) and arrays["quantities"][1] == "stretch"
    assert "shock absorber" in (tmp_path / "scene.html").read_text(encoding="utf-8")


def test_the_tension_of_a_spring_between_bodies_of_a_robot_is_that_of_its_ends(tmp_path):
    """Linear in a small motion, with the tension of the posture: compared with the distance between the ends at other joint values."""
    press(tmp_path)
    extra = '\n[output]\npage = false\n\n[[output.quantity]]\nof = "tie"\n\n[[output.quantity]]\nof = "pivot"\nquantity = "elongation"\n'
    scene = scene_of(tmp_path, SCENE.replace('"1 deg"', '"0.001 deg"') + extra)
    curves, x = scene.run().curves("quantity"), scene.equations.solve()(scene.times)
    pivot, slide = scene.equations.posture.joints["pivot"] + x[0], scene.equations.posture.joints["slide"] + x[1]
    tip = np.array([0.2 * np.cos(pivot), 0.2 * np.sin(pivot)])
    length = np.hypot(tip[0] - 0.3, tip[1] - slide)
    guess = np.hypot(0.2 * np.cos(np.radians(5)) - 0.3, 0.2 * np.sin(np.radians(5)) - 0.02)
    assert curves.values[0] == pytest.approx(1000 * (length - guess) + 5, abs=1e-5)
    assert curves.values[1] == pytest.approx(pivot, abs=1e-12)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('of = "suspensio"', 'of: there is no "suspensio"; did you mean "suspension"'),
        ('of = "tyre"\nquantity = "velocity"', 'quantity: found "velocity"; expected force, elongation or rate'),
        (
            'between = ["wheel", "body"]\nquantity = "force"',
            'quantity: found "force"; between two coordinates expected displacement',
        ),
        ('between = ["wheel", "wheel"]', "expected two coordinates of one unit"),
        ('name = "a"', "give either of, the name of a spring or damper, or between"),
    ],
)
def test_what_is_no_quantity_is_refused(tmp_path, table, message):
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, CAR + "\n[[output.quantity]]\n" + table + "\n")
