"""MJCF files against MuJoCo, which reads the same file: masses, weights, springs, dampers, loops and gears."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot.linkages import null_space

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install 'mbconstrained[mjcf]')")

MJCF = """<mujoco model="four-bar with a gear"><option gravity="0.3 0 -5"/>
<default><joint damping="0.3"/><default class="soft"><joint stiffness="20" springref="10"/></default></default>
<worldbody><body name="frame"><geom type="box" size="0.3 0.02 0.02" mass="1"/>
<body name="crank"><joint name="j1" class="soft" axis="0 1 0" armature="0.01"/>
 <geom type="capsule" size="0.02" fromto="0 0 0 0.1 0 0.2" mass="0.5"/>
 <body name="coupler" pos="0.1 0 0.2"><joint name="j2" axis="0 1 0"/><geom type="box" size="0.2 0.02 0.02" pos="0.2 0 0" mass="0.7"/></body>
</body>
<body name="rocker" pos="0.5 0 0"><joint name="j3" axis="0 1 0"/><geom type="ellipsoid" size="0.02 0.03 0.1" pos="0 0 0.1" mass="0.4"/></body>
<body name="wheel" pos="-0.3 0 0"><joint name="j4" axis="0 1 0" stiffness="3"/><geom type="cylinder" size="0.1 0.02" pos="0.05 0 0" mass="0.2"/></body>
</body></worldbody>
<equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.4 0 0"/>
<joint name="mesh" joint1="j4" joint2="j1" polycoef="0.1 -2 0 0 0"/></equality>
<keyframe><key name="leaning" qpos="0.2 -0.1 0.15 -0.3"/></keyframe></mujoco>"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "linkage.xml").write_text(MJCF)
    return tmp_path / "linkage.xml"


def of_mujoco(path, robot, posture):
    """M, the forces at rest and the Jacobian of the equality constraints at a posture, in the order of the robot's coordinates."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for name, value in posture.joints.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    places = [model.joint(name).dofadr[0] for name in robot.coordinates]
    M = np.zeros((model.nv, model.nv))
    for column, unit in zip(M, np.eye(model.nv)):
        mujoco.mj_mulM(model, data, column, unit)
    J = data.efc_J.reshape(-1, model.nv)[: data.ne]
    return M[np.ix_(places, places)], (data.qfrc_bias - data.qfrc_spring)[places], J[:, places], model.dof_damping[places]


def test_masses_forces_and_loops_are_those_of_mujoco(path):
    robot = mb.Robot(path)
    assert [loop.kind for loop in robot.loops] == ["point"] and [row.name for row in robot.mimic_rows] == ["j4 follows j1"]
    posture = robot.equilibrium("leaning")
    system = robot.linearize(posture)
    M, force, J, damping = of_mujoco(path, robot, posture)
    assert np.abs(system.mass - M).max() <= 1e-12 * np.abs(M).max()
    assert np.array_equal(np.diag(system.damping), damping)
    N = null_space(J)
    assert N.shape == (4, 1) and np.abs(system.constraint_matrix @ N).max() < 1e-12
    assert np.abs(N.T @ force).max() < 1e-10 * np.abs(force).max()  # in equilibrium by the forces of MuJoCo, too


def test_stiffness_is_the_derivative_of_the_forces_of_mujoco_along_the_loops(path):
    robot = mb.Robot(path)
    posture = robot.equilibrium("leaning")
    system, h = robot.linearize(posture), 1e-4
    N = null_space(system.constraint_matrix)

    def force(step):  # along the closed loops, by the joint j1
        moved = robot.equilibrium({**posture.joints, "j1": posture["j1"] + step}, hold=["j1"])
        _, force, J, _ = of_mujoco(path, robot, moved)
        n = null_space(J)[:, 0]
        return float(n @ force / n[robot.coordinates.index("j1")])

    expected = (8 * (force(h) - force(-h)) - (force(2 * h) - force(-2 * h))) / (12 * h)
    n = N[:, 0] / N[robot.coordinates.index("j1"), 0]
    assert n @ system.stiffness @ n == pytest.approx(expected, rel=1e-8)


def test_shapes_and_states(path):
    robot = mb.Robot(path)
    assert robot.states["leaning"] == pytest.approx({"j1": 0.2, "j2": -0.1, "j3": 0.15, "j4": -0.3})
    shapes = {visual.link: visual for visual in robot.visuals()}
    assert {name: visual.kind for name, visual in shapes.items()} == {
        "frame": "box",
        "crank": "cylinder",
        "coupler": "box",
        "rocker": "mesh",
        "wheel": "cylinder",
    }
    assert shapes["coupler"].placement[:3, 3] == pytest.approx([0.2, 0, 0]) and shapes["coupler"].size == (0.4, 0.04, 0.04)
    assert np.ptp(shapes["rocker"].vertices, axis=0) == pytest.approx([0.04, 0.06, 0.2])
    collision = {shape.link: shape for shape in robot.visuals(collision=True)}  # MJCF uses the same geoms for both
    assert collision.keys() == shapes.keys() and all(shapes[name].has_shape_of(collision[name]) for name in shapes)


def test_a_robot_file_names_it(path):
    (path.parent / "robot.toml").write_text(
        'urdf = "linkage.xml"\n[joint_damping]\nj2 = "1 N*m*s/rad"\n[posture]\nguess = { j1 = "10 deg" }'
    )
    robot, _ = mb.read_robot(path.parent)
    assert robot.joint_damping.tolist() == pytest.approx([0.3, 1.3, 0.3, 0.3])
    (path.parent / "scene.toml").write_text('[model]\nkind = "robot"\nrobot = "."\n[time]\nend = 1')
    result = mb.read_scene(path.parent / "scene.toml").run()
    result.write_page(path.parent / "page.html")
    assert "coupler" in (path.parent / "page.html").read_text()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '<body name="frame">',
            '<body name="other"><joint/></body><body name="frame">',
            "mass and inertia of moving bodies must be",
        ),
        ("<mujoco", "<!DOCTYPE x><mujoco", "mjcf: found a document type"),
        ("</mujoco>", "", "mjcf: not XML"),
        ("<equality>", '<asset><mesh name="m" file="../../m.stl"/></asset><equality>', "lies outside of the folder of the MJCF"),
        ("<equality>", '<include file="nothing.xml"/><equality>', "there is no such MJCF file"),
        ("<equality>", '<include file="linkage.xml"/><equality>', "include each other more than 5 deep"),
        (
            'stiffness="3"',
            'stiffness="soft"',
            r"cannot read it \(XML Error: bad format in attribute 'stiffness' .* at <joint name=\"j4\"",
        ),
        ('axis="0 1 0" stiffness', 'type="wheel" stiffness', "cannot read it .*invalid keyword: 'wheel'"),
    ],
)
def test_what_cannot_be_read_is_named(path, old, new, message):
    path.write_text(MJCF.replace(old, new, 1))
    with pytest.raises(mb.InputError, match=message):
        mb.Robot(path)


def test_what_is_left_out_is_reported(path):
    path.write_text(
        MJCF.replace("0.1 -2 0 0 0", "0.1 -2 0.5 0 0").replace("</equality>", "</equality><actuator><motor joint='j1'/></actuator>")
    )
    coupling, actuator = [notice for notice in mb.Robot(path).description_notices if "mjcf" in notice.text]
    assert coupling.doubtful and 'not read: the coupling of the joint "j4", which is not linear' in coupling.text
    assert not actuator.doubtful and "actuators without feedback exert no force: actuator 0" in actuator.text


def test_sdf_and_xacro_get_advice(tmp_path):
    (tmp_path / "robot.sdf").write_text("<sdf version='1.7'><model name='m'/></sdf>")
    with pytest.raises(mb.InputError, match="sdf: found no <link>; a robot needs at least one"):
        mb.Robot(tmp_path / "robot.sdf")
    with pytest.raises(mb.InputError, match="this is MJCF; give the path of the file"):
        mb.Robot(MJCF)
