"""[[output.quantity]]: forces and elongations of elements and relative motions, against their definitions."""

import re

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import SceneError
from tests.scene.robots import SCENE, press
from tests.scene.scenes import scene_of

CAR = """
[model]
kind = "lumped"
mass = [{ name = "wheel", mass = 40 }, { name = "body", mass = 400 }]
spring = [
  { name = "tyre", between = ["ground", "wheel"], stiffness = 2e5 },
  { name = "suspension", between = ["wheel", "body"], stiffness = 2e4, rest_length = 0.3 },
]
damper = [{ name = "shock absorber", between = ["wheel", "body"], damping = 1500 }]
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
        ('of = "tyre"\nquantity = "velocity"', 'quantity: found "velocity" of "tyre"; expected force, elongation, rate'),
        ('between = ["wheel", "body"]\nquantity = "force"', 'quantity: found "force"; between two coordinates expected'),
        ('between = ["wheel", "wheel"]', "expected two coordinates of one unit"),
        ('name = "a"', "give either of, the name of a spring or damper, or between"),
    ],
)
def test_what_is_no_quantity_is_refused(tmp_path, table, message):
    with pytest.raises(SceneError, match=re.escape(message)):
        scene_of(tmp_path, CAR + "\n[[output.quantity]]\n" + table + "\n")


STRESS = """
[[output.quantity]]
name = "stress"
of = "suspension"
divided_by = "40 mm^2"

[[output.quantity]]
name = "bending"
of = "force on ground"
factor = "0.2 m"
divided_by = "500 mm^3"
"""


def test_stresses_are_forces_by_areas_and_moments_by_section_moduli(tmp_path):
    """In a run, over frequency, under random loads, as peaks of a shock and in sweeps, whose samples are solved one by one here."""
    scene = scene_of(tmp_path, CAR + STRESS)
    curves, x = (scene.run().curves(kind) for kind in ("quantity", "displacement"))
    force = 2e4 * (x.values[1] - x.values[0] - 0.3)
    wanted = [force / 40e-6, 2e5 * x.values[0] * 0.2 / 500e-9]
    assert (curves.units, curves.titles) == (("Pa", "Pa"), ("stress", "stress"))
    np.testing.assert_allclose(curves.values, wanted, rtol=1e-9, atol=1e-6)
    load = scene.system.names[1]
    H = scene.system.frequency_response([2.0], [load], ["stress", "suspension", "bending", "force on ground"]).values[:, 0, 0]
    np.testing.assert_allclose(H[[0, 2]], [H[1] / 40e-6, H[3] * 0.2 / 500e-9], rtol=1e-12)
    rms = scene.system.random_response({load: mb.psd([0.5, 20.0], [1.0, 1.0])}, ["stress", "suspension"]).rms
    assert rms[0] == pytest.approx(rms[1] / 40e-6, rel=1e-12)
    peaks = scene.shock().data["peaks"]
    own = {row["of"]: row["maximum"] for row in peaks if row["quantity"] == "stress"}
    dense = scene.run().motion.peaks(1.0, ["force of suspension", "force on ground"])
    np.testing.assert_allclose([own["stress"], own["bending"]], dense.maximum * [1 / 40e-6, 0.2 / 500e-9], rtol=1e-12)
    sweep = scene.sweep(
        {"model.mass.body.mass": "300..400 kg:2"}, keep=["largest stress", "RMS force on ground", "force of suspension at 0.5 s"]
    )
    result = sweep.run()
    for place, mass in enumerate((300.0, 400.0)):
        other = mb.read_scene(scene.path, {"model.mass.body.mass": mass})
        motion = other.run().motion
        names = other.system.quantities
        assert result.values("largest stress")[place].item() == pytest.approx(motion.peaks(1.0, "stress").largest[0], rel=1e-9)
        times = np.linspace(0.0, 1.0, 20_001)
        squares = (names["bending"].values(motion, times) / 0.2 * 500e-9) ** 2
        assert result.values("RMS force on ground")[place].item() == pytest.approx(np.sqrt(np.trapezoid(squares, times)), rel=1e-6)
        assert result.values("force of suspension at 0.5 s")[place].item() == pytest.approx(
            names["stress"].values(motion, np.array([0.5]))[0] * 40e-6
        )


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (['of = "tyre"', 'of = "tyre"'], 'name: "tyre" is the name of two'),
        (['name = "force on ground"\nof = "suspension"'], '"force on ground" is already the name of something else'),
        (['name = "body"\nof = "tyre"'], '"body" is already the name of something else'),
        (['of = "tyre"\ndivided_by = "40 mm^2"'], "name: missing; a quantity with a factor"),
        (['name = "s"\nof = "tyre"\ndivided_by = "0 mm^2"'], "divided_by: found 0"),
        (['of = "velocity of body"\nquantity = "acceleration"'], 'found "acceleration" of "velocity of body"; leave it out'),
        (['of = "torque of tyre"'], '"tyre" has no torque: it is a spring or damper with force, elongation and rate'),
        (['name = "a"\nof = "tyre"', 'name = "b"\nof = "a"'], 'there is no "a"'),
    ],
)
def test_names_of_quantities_are_distinct_and_of_their_kind(tmp_path, tables, message):
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, CAR + "".join(f"\n[[output.quantity]]\n{table}\n" for table in tables))


def test_a_spring_has_several_quantities_under_its_name_in_a_run_and_distinct_names_elsewhere(tmp_path):
    tables = '\n[[output.quantity]]\nof = "tyre"\nquantity = "elongation"\n\n[[output.quantity]]\nof = "tyre"\n'
    scene = scene_of(tmp_path, CAR + tables)
    assert scene.run().curves("quantity").names == ("tyre", "tyre")
    assert list(scene.system.quantities) == ["elongation of tyre", "tyre"]
