"""robot.toml: what is read, and what is said about entries that are wrong."""

import math
import re

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.build.robot_file import read_robot
from tests.scene.robots import ROBOTS, TOML, URDF, press


def test_quantities_arrive_in_si_by_the_kind_of_their_joint(tmp_path):
    robot, data = read_robot(press(tmp_path))
    assert (data.title, data.source, data.licence, data.name) == ("Press", "tests", "MIT", "press")
    assert data.posture == {"guess": {"pivot": pytest.approx(math.radians(5)), "slide": 0.02}, "forces": {}, "hold": ()}
    numbers = dict(zip(robot.coordinates, robot.joint_stiffness))
    assert numbers == {"pivot": 40.0, "slide": 3000.0} and robot.joint_damping.tolist() == [0.1, 4.0]
    (tie,) = robot.springs
    assert (tie.point1, tie.stiffness, tie.preload, tie.rest_length) == ((0.2, 0.0, 0.0), 1000.0, 5.0, None)


def test_the_posture_of_the_file_is_one(tmp_path):
    robot, data = read_robot(press(tmp_path))
    posture = robot.equilibrium(**data.posture)
    assert posture.residual < 1e-12 and set(posture.joints) == {"pivot", "slide"}


def test_a_locked_joint_is_gone_from_springs_and_posture(tmp_path):
    robot, data = read_robot(press(tmp_path), locked={"pivot": 0.1})
    assert robot.coordinates == ("slide",) and list(data.posture["guess"]) == ["slide"]
    assert robot.equilibrium(**data.posture).residual < 1e-12
    file = TOML.replace("[[spring]]", 'locked = { pivot = "10 deg" }\n[[spring]]')
    held = read_robot(press(tmp_path, file))[1]
    assert held.locked == {"pivot": pytest.approx(math.radians(10))}


def test_forces_and_held_joints_belong_to_the_posture(tmp_path):
    more = (
        'forces = { pivot = "2 N*m" }\nhold = ["slide"]\n[[posture.body_force]]\nbody = "ram"\nalong = [0, 0, 2]\nvalue = "3 N"\n'
    )
    robot, data = read_robot(press(tmp_path, TOML + more))
    assert data.posture["hold"] == ("slide",) and sorted(data.posture["forces"].values()) == [2.0, 3.0]
    held = robot.equilibrium(**data.posture)
    free = robot.equilibrium(**{**data.posture, "forces": {"pivot": 2.0}})
    assert free.torques["slide"] - held.torques["slide"] == pytest.approx(3.0, abs=1e-9)  # without the 3 N upwards
    assert held["slide"] == 0.02


def test_every_robot_stands_in_the_index_with_its_licence():
    index = (ROBOTS / "README.md").read_text("utf-8")
    rows = {row[1]: row[0] for row in re.finditer(r"\| \[(\w+)\]\(\1\) .*", index)}
    folders = {path.parent.name for path in ROBOTS.glob("*/robot.toml")}
    assert set(rows) == folders and len(folders) >= 9
    for name in folders:
        robot, data = read_robot(ROBOTS / name)
        assert data.title and data.source and rows[name].rstrip(" |").endswith(data.licence)
        assert not robot.mesh_notices()


@pytest.mark.parametrize("name", sorted(path.parent.name for path in ROBOTS.glob("*/robot.toml")))
def test_the_robots_have_the_inertia_of_their_shapes_and_rest(name):
    robot, data = read_robot(ROBOTS / name)
    posture = robot.equilibrium(**data.posture)
    assert posture.residual < 1e-10 and posture.loop_error < 1e-10
    K = robot.linearize(posture).stiffness
    assert np.abs(K - K.T).max() <= 1e-10 * np.abs(K).max()
    assert "<collision" not in data.names.path.read_text("utf-8")


CASES = [  # what is replaced, by what, message
    ("joint_stiffness", "joint_stifness", 'the file: unknown key "joint_stifness"; did you mean "joint_stiffness"?'),
    ('"40 N*m/rad"', '"40 N/m"', 'joint_stiffness: pivot: found "40 N/m", a stiffness; expected a torsional stiffness'),
    ('"3 N/mm"', '"3 N*m/rad"', 'joint_stiffness: slide: found "3 N*m/rad", '),
    ('pivot = "0.1', 'pivott = "0.1', 'joint_damping: there is no joint "pivott"; did you mean "pivot"?; the joints are pivot,'),
    ('"5 deg"', '"5 m"', 'posture: guess: pivot: found "5 m", a length; expected an angle'),
    ('slide = "2 cm" }', 'slide = "2 deg" }', 'posture: guess: slide: found "2 deg", an angle; expected a length'),
    ('slide = "2 cm" }', "slide = [1, 2] }", "posture: guess: slide: found an array of 2; expected a length"),
    ("[posture]", '[posture]\nforces = { slide = "1 N*m" }', 'posture: forces: slide: found "1 N*m", a torque; expected a force'),
    ("[posture]", '[posture]\nhold = ["slid"]', 'posture: hold: there is no joint "slid"; did you mean "slide"'),
    ("[posture]", '[posture]\nhold = "al"', 'posture.hold: found "al"; expected "all" or names'),
    ('body2 = "ram"', 'body2 = "rum"', 'spring[1] (of "tie"): body2: there is no body "rum"; did you mean "ram"?; the bodies are'),
    ('body2 = "ram"', 'body2 = "crank"', 'both ends are on "crank"'),
    ('preload = "5 N"', 'preload = "5 N"\nrest_length = 1', "both rest_length and preload"),
    ('preload = "5 N"', 'preload = "5 m"', 'spring[1].preload (of "tie"): found "5 m", a length; expected a force'),
    ('"1 N/mm"', "-5", "stiffness: found -5"),
    ('["20 cm", 0, 0]', '["20 cm", 0]', 'spring[1].point1 (of "tie"): found an array of 2; expected at least 3'),
    (
        "[[spring]]",
        '[[loop]]\nbody1 = "crank"\npoint1 = [0, 0, 0]\nbody2 = "ram"\nkind = "ball"\n[[spring]]',
        "loop[1].kind: found",
    ),
    ("[[spring]]", 'gravity = "9 m"\n[[spring]]', 'gravity: found "9 m", a length; expected an acceleration'),
    ("[[spring]]", "gravity = [0, 1]\n[[spring]]", "gravity: found an array of 2; expected one number"),
    ("[[spring]]", 'base = "fre"\n[[spring]]', 'base: found "fre"; '),
    ("[[spring]]", 'locked = { pivot = "1 N" }\n[[spring]]', 'locked: pivot: found "1 N", a force; expected an angle'),
    ("[[spring]]", "[flexible_joints.pivit]\nstiffness = 1\nmotor_inertia = 1\n[[spring]]", "flexible_joints.pivit: there is no"),
    ("[[spring]]", '[flexible_joints.slide]\nstiffness = "1 N*m/rad"\nmotor_inertia = 1\n[[spring]]', "flexible_joints.slide:"),
    ('slide = "2 cm" }', 'slide = "2 cm" }\n[[posture.body_force]]\nbody = "rim"\nvalue = 1', "posture: body_force[1]: there is"),
]


@pytest.mark.parametrize(("old", "new", "message"), CASES, ids=[f"{new[:40]!r}" for _, new, _ in CASES])
def test_message(tmp_path, old, new, message):
    assert old in TOML
    with pytest.raises(SceneError, match=re.escape(message)) as caught:
        read_robot(press(tmp_path, TOML.replace(old, new, 1)))
    assert str(caught.value).startswith("press/robot.toml: ")


MORE = """
masses = { crank = "3 kg" }
inertias = { ram = [1, "2 g*m^2", 3] }
[motors.pivot]
armature = "20 g*m^2"
rotor_inertia = "1e-6 kg*m^2"
gear_ratio = 100
position_gain = "30 N*m/rad"
velocity_gain = "2 N*m*s/rad"
[motors.slide]
armature = "500 g"
[[payload]]
body = "ram"
mass = "250 g"
centre = ["1 cm", 0, 0]
[[gear]]
joint = "slide"
leader = "pivot"
ratio = "20 mm/rad"
offset = "1 cm"
[[loop]]
body1 = "crank"
point1 = ["20 cm", 0, 0]
body2 = "ram"
point2 = [0, 0, 0]
kind = "rod"
length = "150 mm"
"""


def test_motors_masses_payloads_and_gears_are_read_with_their_units(tmp_path):
    robot, _ = read_robot(press(tmp_path, TOML.replace("[[spring]]", MORE + "[[spring]]")))
    assert robot.motors["pivot"].reflected_inertia == pytest.approx(0.03) and robot.motors["slide"].armature == 0.5
    assert robot.position_gains.tolist() == [30.0, 0.0] and robot.joint_damping.tolist() == pytest.approx([2.1, 4.0])
    assert robot.model.inertias[1].mass == 3.0 and robot.model.inertias[2].mass == 2.25
    (row,) = robot.mimic_rows
    assert (row.name, row.multiplier, row.offset) == ("slide follows pivot", pytest.approx(0.02), pytest.approx(0.01))
    assert robot.loops[0].length == pytest.approx(0.15)


def test_coordinates_of_a_free_base_stand_in_the_file_by_name(tmp_path):
    toml = TOML.replace("joint_stiffness = {", 'base = "free"\njoint_stiffness = { "base z" = "5 N/mm", "base rx" = "7 N*m/rad",')
    robot, _ = read_robot(press(tmp_path, toml))
    assert robot.joint_stiffness.tolist()[:6] == [0, 0, 5000, 7, 0, 0]


def test_a_urdf_that_is_not_there_is_told_with_the_nearest_name(tmp_path):
    with pytest.raises(SceneError, match=r'press/pres\.urdf: there is no file "pres\.urdf"; did you mean "press\.urdf"'):
        read_robot(press(tmp_path, TOML.replace('urdf = "press', 'urdf = "pres')))


def test_messages_about_the_urdf_name_it(tmp_path):
    with pytest.raises(SceneError, match=r'press/press\.urdf: urdf.*"continous".*did you mean "continuous"'):
        read_robot(press(tmp_path, urdf=URDF.replace('type="continuous"', 'type="continous"')))


HOPPER = """<mujoco model="hopper"><compiler angle="radian"/>
<worldbody><body name="trunk" pos="0 0 0.5"><freejoint name="root"/><geom type="box" size="0.1 0.1 0.05" density="1000"/>
<body name="leg" pos="0 0 -0.05"><joint name="knee" type="slide" axis="0 0 1" stiffness="2000"/>
<geom type="sphere" size="0.02" density="1000"/></body></body></worldbody>
<keyframe><key name="stand" qpos="0 0 0.47 1 0 0 0 0.02"/></keyframe></mujoco>"""


@pytest.mark.parametrize("base", ["", 'base = "free"\n'])
def test_key_frames_of_an_mjcf_are_states(tmp_path, base):
    """The trunk of 4 kg sinks onto its leg, which is fixed to the ground where the key frame has it: m g / k."""
    (tmp_path / "hopper.xml").write_text(HOPPER)
    foot = '[[loop]]\nkind = "rigid"\nbody1 = "ground"\nbody2 = "leg"\npoint2 = [0, 0, 0]\n[posture]\nstate = "stand"\n'
    (tmp_path / "robot.toml").write_text(f'{base}urdf = "hopper.xml"\n{foot}')
    robot, data = read_robot(tmp_path)
    posture = robot.equilibrium(**data.posture)
    knee = 4 * 9.81 / 2000
    assert posture["knee"] == pytest.approx(knee, rel=1e-12)
    assert posture["base"][:3] == pytest.approx((0, 0, 0.47 + 0.02 - knee), abs=1e-12)
    (tmp_path / "robot.toml").write_text(f'{base}urdf = "hopper.xml"\n{foot.replace("stand", "sit")}')
    with pytest.raises(SceneError, match='there is no "sit".*there are .*stand'):
        read_robot(tmp_path)
