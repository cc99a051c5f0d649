"""Scenes of kind "robot": inputs, outputs, postures, what is told of them, what is left out."""

import json
import math
import re

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.run.scene import read_scene
from tests.scene.robots import SCENE, TOML, URDF, press
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of

LOOP = TOML.replace("[[spring]]", '[[loop]]\nname = "pin"\nbody1 = "crank"\npoint1 = [0.2, 0, 0]\nbody2 = "ground"\n[[spring]]')


def stages(scene):
    return {stage.name: (stage.needed, stage.reason) for stage in scene.plan().stages}


def test_coordinates_are_the_joints(tmp_path):
    press(tmp_path)
    scene = scene_of(tmp_path, SCENE)
    assert scene.equations.coordinates.names == ("pivot", "slide") and scene.equations.coordinates.units == ("rad", "m")
    assert scene.equations.robot is scene.equations.posture.robot
    assert scene.equations.initial[0] == pytest.approx([math.radians(1), 0])
    result = scene.run()
    assert result.is_trusted and result.motion(0.0)[0] == pytest.approx(math.radians(1))


def test_inputs_push_points_and_outputs_see_them(tmp_path):
    press(tmp_path)
    spots = "".join(
        f'[[model.{key}]]\nname = "tip"\nbody = "crank"\npoint = [0.2, 0, 0]\nalong = [0, 0, 5]\n'
        f'[[model.{key}]]\nname = "bend"\nbody = "crank"\nalong = [0, -1, 0]\nturn = true\n'
        f'[[model.{key}]]\nname = "lift"\njoint = "slide"\n'
        for key in ("input", "output")
    )
    force = '[[force]]\ncoordinate = "tip"\nkind = "step"\nvalue = "3 N"\n[[force]]\ncoordinate = "bend"\nkind = "step"\nvalue = "2 N*m"\n'
    scene = scene_of(tmp_path, SCENE.replace("[initial]", spots + force + "[initial]") + '[output]\nplots = ["output"]\n')
    arm = 0.2 * math.cos(scene.equations.posture["pivot"])  # height of the tip by angle
    assert scene.equations.robot_scene.system.output_matrix == pytest.approx(np.array([[arm, 0], [1, 0], [0, 1]]), abs=1e-14)
    assert scene.equations.force(1.0) == pytest.approx([3 * arm + 2, 0])
    result = scene.run()
    outputs = result.curves("output")
    assert (outputs.names, outputs.units) == (("tip", "bend", "lift"), ("m", "rad", "m"))
    assert outputs.values == pytest.approx(scene.equations.robot_scene.system.output_matrix @ result.values)
    head = result.write_csv(tmp_path / "a.csv").read_text().splitlines()[0]
    assert "tip output (m)" in head
    with np.load(result.write_npz(tmp_path / "a.npz")) as data:
        assert data["outputs"].tolist() == ["tip", "bend", "lift"] and data["output"].shape == (3, 21)


def test_a_scene_may_have_another_posture(tmp_path):
    press(tmp_path)

    def posture(model):
        return scene_of(tmp_path, SCENE.replace("[initial]", f"{model}\n[initial]")).equations.posture

    assert posture('guess = { slide = "30 mm" }\nhold = ["slide"]')["slide"] == 0.03
    usual = posture("")
    assert posture('forces = { pivot = "1 N*m" }')["pivot"] > usual["pivot"]
    lifted = posture('[[model.body_force]]\nbody = "ram"\nalong = [0, 0, 1]\nvalue = "5 N"')
    assert lifted["slide"] > usual["slide"]


LIFT = '[[KEY.body_force]]\nbody = "ram"\nalong = [0, 0, 1]\nvalue = VALUE\n'


def test_a_scene_is_merged_with_the_posture_of_the_file(tmp_path):
    def lift(key, value):
        return LIFT.replace("KEY", key).replace("VALUE", str(value))

    press(tmp_path, TOML + 'forces = { pivot = "1 N*m", slide = "2 N" }\nhold = ["pivot"]\n' + lift("posture", 5))

    def posture(model):
        return scene_of(tmp_path, SCENE.replace("[initial]", f"{model}\n[initial]")).equations.posture

    usual = posture("")
    assert set(usual.torques) == {"pivot"} and usual["pivot"] == pytest.approx(math.radians(5))
    moved = posture('guess = { pivot = "7 deg" }')  # joint by joint: that of the slide is kept, on which the tie's length depends
    assert moved["pivot"] == pytest.approx(math.radians(7)) and set(moved.torques) == {"pivot"}
    assert posture("hold = []").torques == {}
    assert (
        posture("forces = { slide = 0 }")["slide"]
        < usual["slide"]
        < posture("forces = { pivot = 0 }\n" + lift("model", 9))["slide"]
    )
    without = posture(lift("model", 0))
    assert without["slide"] == pytest.approx(posture('forces = { slide = "-3 N" }')["slide"], abs=1e-12)  # 5 N less
    both = posture(lift("model", 5).replace("[0, 0, 1]", "[0, 0, 1]\npoint = [0.1, 0, 0]"))
    assert both["slide"] == pytest.approx(posture('forces = { slide = "7 N" }')["slide"], abs=1e-12)  # 5 N more


def test_what_the_posture_tells_is_in_every_form(tmp_path):
    press(tmp_path, LOOP + 'hold = ["slide"]\n')
    result = scene_of(tmp_path, SCENE.replace('displacement = { pivot = "1 deg" }', "")).run()
    summary, page = result.summary(), result.write_page(tmp_path / "a.html").read_text("utf-8")
    for text in ("Posture", "Forces of loops and springs at rest", "equilibrium: residual", "equilibrium: loops", "with load"):
        assert text in summary and text in page
    data = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    assert data["robot"] == {"name": "press", "title": "Press", "source": "tests", "licence": "MIT"}
    posture = data["posture"]
    assert set(posture) == {"joints", "torques", "reactions", "ground_reactions", "residual", "loop_error"}
    assert set(posture["torques"]) == {"slide"} and len(posture["reactions"]["pin"]) == 6 and posture["residual"] < 1e-9
    assert "robot" not in scene_of(tmp_path, OSCILLATOR).run().to_dict()
    assert "Press; tests; licence MIT" in page


def test_meshes_are_read_only_where_they_are_drawn():
    scene = read_scene(EXAMPLES / "seven_joint_arm.toml")
    assert stages(scene)["robot meshes"] == (True, "1 mesh to draw")


INPUT, OUTPUT, FORCE = '[[model.input]]\nname = "p"', '[[model.output]]\nname = "p"', '[[force]]\nkind = "step"'


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (INPUT, "give either joint, or body"),
        (f'{INPUT}\njoint = "pivit"', 'no joint "pivit"; did you mean "pivot"'),
        (f'{OUTPUT}\nbody = "crnk"', 'no body "crnk"; did you mean "crank"'),
        (f'{OUTPUT}\nbody = "crank"\nalong = [0, 0, 0]', "expected a direction"),
        (f'{INPUT}\njoint = "pivot"\nturn = true', "turn belongs to a body"),
        ('[[model.input]]\nname = "slide"\njoint = "pivot"', 'model: input "slide": this is the name of a coordinate'),
        (f'{INPUT}\njoint = "pivot"\n{INPUT}\njoint = "slide"', 'model.input[2] (of "p"): this name is used twice'),
        (f'{FORCE}\ncoordinate = "pivto"\nvalue = 1', 'force[1]: there is no coordinate "pivto"; did you'),
        (f'{FORCE}\ncoordinate = "slide"\nvalue = "1 N*m"', 'force[1]: value: found "1 N*m", a torque; expected a force'),
        ('[output]\nplots = ["output"]', "output.plots: found output, but no outputs are named"),
        ('[[drawing.body]]\nname = "b"\nshape = "box"', "drawing: a robot is drawn from its URDF"),
        ("guess = { pivto = 1 }", 'model: guess: there is no joint "pivto"'),
        ('level = "positon"', 'model.level: found "positon"; '),
    ],
)
def test_message(tmp_path, entry, message):
    press(tmp_path)
    with pytest.raises(SceneError, match=rf"^scene\.toml: .*{re.escape(message)}"):
        scene_of(tmp_path, SCENE.replace("[initial]", f"{entry}\n[initial]"))


def test_a_robot_without_an_equilibrium_is_told(tmp_path):
    alone = TOML[: TOML.index("[[spring]]")] + TOML[TOML.index("[posture]") :]  # nothing supports the slide
    press(tmp_path, alone.replace(', slide = "3 N/mm"', "").replace(", slide = 0", ""))
    text = SCENE.replace("[initial]", 'forces = { slide = "5 kN" }\n[initial]')
    with pytest.raises(SceneError, match=r"scene\.toml: model: equilibrium: "):
        scene_of(tmp_path, text)


@pytest.mark.parametrize(("beyond", "noted"), [(2e-3, True), (5e-4, False)])
def test_joints_that_pass_their_limits_are_one_note(tmp_path, beyond, noted):
    """The upper limit lies below the largest displacement, and above the posture, by this share of a range of 1 cm."""
    folder = press(tmp_path)
    free = scene_of(tmp_path, SCENE).run()
    assert not [notice for notice in free.notices if "limits" in notice.text]
    highest = (
        free.scene.equations.posture["slide"] + free.motion(np.linspace(0, 1, 20001))[1].max()
    )  # the samples are farther apart
    upper = highest - 0.01 * beyond
    limits = f'lower="{upper - 0.01:.17g}" upper="{upper:.17g}"'
    (folder / "press.urdf").write_text((folder / "press.urdf").read_text().replace('lower="-1" upper="1"', limits))
    found = [notice.text for notice in scene_of(tmp_path, SCENE).run().notices if "limits" in notice.text]
    assert len(found) == noted
    if noted:
        assert found[0].startswith(f'during the motion 1 joint is beyond its limits: "slide" at {highest:.6g} m (limits ')
    limits = f'lower="{upper - 1:.17g}" upper="{upper - 0.5:.17g}"'
    press(tmp_path, urdf=URDF.replace('lower="-1" upper="1"', limits))
    (text,) = [notice.text for notice in scene_of(tmp_path, SCENE).run().notices if "limits" in notice.text]
    assert text.startswith('1 joint is beyond its limits: "slide" at ')  # at rest already: once is enough
