"""Forces of loops of a robot during the motion along the axes of the ground: pinocchio's placements of the links, Newton's law, feet."""

import re
from functools import cache
from shutil import copy

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from mbconstrained.robot.linearized import connection_forces
from mbconstrained.robot.statics import Balance
from mbconstrained.scene.run.scene import read_scene
from tests.robot.test_wrenches import spatial_arm
from tests.scene.robots import ROBOTS
from tests.scene.scenes import EXAMPLES, scene_of


def rotation(posture, loop) -> np.ndarray:
    """Of the frame on the first body at rest, by pinocchio alone."""
    if loop.body1 == "ground":
        return pin.rpy.rpyToMatrix(*loop.rotation1)
    model = posture.robot.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, posture.configuration)
    return data.oMf[model.getFrameId(loop.body1)].rotation @ pin.rpy.rpyToMatrix(*loop.rotation1)


@pytest.mark.parametrize("name", ["four_bar", "delta", "quadruped"])
def test_the_forces_of_points_are_turned_as_their_bodies_are_at_rest(name):
    """A row "LOOP x" is a force along x of the frame; rows that were redundant have none."""
    result = read_scene(EXAMPLES / f"{name}.toml", {"output.reactions": True}).run()
    posture = result.scene.equations.posture
    own, ground = result.curves("reaction"), result.curves("ground_reaction")
    by_row = dict(zip(own.names, own.values))
    by_component = dict(zip(ground.names, ground.values))
    turned = 0.0
    for loop in posture.robot.loops:
        assert loop.kind == "point"
        in_frame = np.array([by_row.get(f"{loop.name} {axis}", np.zeros(len(result.times))) for axis in "xyz"])
        names = [f"{loop.name} {axis}" for axis in "xyz"]
        in_ground = np.array([by_component[name] for name in names])
        forces = result.system.connection_forces
        own_rows = forces.places[loop.name]
        change = forces.displacement[own_rows] @ result.curves("displacement").values  # the load at rest turns with the first body
        at_rest = posture.ground_reactions[loop.name][:3, None]
        size = max(np.abs(own.values).max(), np.abs(at_rest).max())
        assert in_ground - at_rest - change == pytest.approx(rotation(posture, loop) @ in_frame, abs=1e-12 * size)
        turned = max(turned, np.abs(in_ground - in_frame).max())
    assert len(ground.names) == 3 * len(posture.robot.loops) and set(ground.units) == {"N"}
    assert turned > 0.01 * np.abs(own.values).max() or name == "quadruped"


def test_torques_are_turned_too():
    """A hinge in a turned frame; six components."""
    hinge = mb.Loop("ground", (0.3, -0.02, -0.5), "lower", (0, 0, -0.3), "hinge", axis=(0, 1, 0), rotation1=(0, 0.4, 0), name="pin")
    robot = mb.Robot("robots/double_pendulum/double_pendulum.urdf", loops=[hinge])
    posture = robot.equilibrium({"shoulder": -0.2, "elbow": 1.0}, {"elbow": 1.0})
    load, (gradient,) = posture.balance.load, [gradient for _, _, gradient, _ in posture.balance.loops]
    forces = connection_forces(posture, 2, load.row_names)
    multipliers = np.arange(1.0, 1.0 + len(load.row_names))
    turn, wrench = rotation(posture, hinge), gradient.T @ multipliers
    assert forces.multipliers @ multipliers == pytest.approx(np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]), abs=1e-12)
    assert forces.units == ("N",) * 3 + ("N m",) * 3 and forces.names[3] == "pin x"


FEET = """title = "Quadruped on soft ground"
urdf = "quadruped.urdf"
base = "free"
[joint_stiffness]
JOINTS
BUSHINGS
[posture]
guess.base = [0, 0, 0.337, 0, 0, 0]
GUESS
"""
RUN = """
[model]
kind = "robot"
robot = "soft"
[[model.input]]
name = "push"
body = "trunk"
along = [0, 0, 1]
[[force]]
coordinate = "push"
kind = "pulse"
value = "SIZE N"
duration = "0.1 s"
[time]
end = "0.5 s"
points = 101
[output]
plots = ["ground_reaction"]
"""
LEGS = [f"{end} {side}" for end in ("front", "rear") for side in ("left", "right")]


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    """The run of a quadruped on four springy feet under a vertical pulse, of each size, friction and number of times once."""
    return cache(lambda *given: run_of(tmp_path_factory.mktemp("soft"), *given))


def run_of(folder, size: float, friction: float = 0.7, points: int = 101):
    joints = "\n".join(f'"{leg} {part}" = 120' for leg in LEGS for part in ("spread", "swing", "knee"))
    feet = "\n".join(
        f'[[bushing]]\nname = "{leg} foot"\nbody1 = "ground"\nbody2 = "{leg} shin"\npoint2 = [0, 0, -0.22]\n'
        f"stiffness = [3e4, 3e4, 9e4]\ndamping = [50, 50, 90]\nfriction = {friction}"
        for leg in LEGS
    )
    guess = "\n".join(f'guess."{leg} {part}" = {value}' for leg in LEGS for part, value in (("swing", 0.7), ("knee", -1.4)))
    (folder / "soft").mkdir()
    copy(ROBOTS / "quadruped" / "quadruped.urdf", folder / "soft")
    text = FEET.replace("JOINTS", joints).replace("BUSHINGS", feet).replace("GUESS", guess)
    (folder / "soft" / "robot.toml").write_text(text, encoding="utf-8")
    path = folder / "soft.toml"
    path.write_text(RUN.replace("SIZE", str(size)).replace("points = 101", f"points = {points}"), encoding="utf-8")
    return read_scene(path).run()


def test_the_ground_carries_weight_and_acceleration(soft):
    """Newton's law for the whole robot: forces of the feet + push + m g = m a of the centre of mass, by pinocchio's Jacobian."""
    result = soft(20.0)
    posture, times = result.scene.equations.posture, result.times
    model = posture.robot.model
    data = model.createData()
    J = pin.jacobianCenterOfMass(model, data, posture.configuration)
    mass = pin.computeTotalMass(model)
    curves = result.curves("ground_reaction")
    feet = curves.values.reshape(len(LEGS), 3, -1).sum(axis=0)
    push = np.outer([0, 0, 20.0], times < 0.1)
    push[2, times == 0.1] = 0.0
    expected = mass * (J @ result.motion.derivative(2)(times)) - push + np.array([[0], [0], [9.81 * mass]])
    assert feet == pytest.approx(expected, abs=1e-9 * 9.81 * mass)
    assert np.ptp(feet[2]) > 5.0  # the sum moves


@pytest.mark.parametrize("size", [20.0, 400.0])
def test_feet_that_lift_off_during_the_motion_are_counted_with_the_worst(soft, size):
    """Against the extremes and the curves of the same run."""
    result = soft(size)
    found = [notice.text for notice in result.notices if "the ground would have to pull" in notice.text]
    least = {leg: result.to_dict()["forces"][f"{leg} foot"]["normal"][0] for leg in LEGS}
    pulling = [leg for leg in LEGS if least[leg] < 0]
    assert len(pulling) == (4 if size == 400.0 else 0) and len(found) == bool(pulling)
    if pulling:
        times = np.linspace(0.0, 0.5, 50_001)
        curves = result.functions("ground_reaction")(times)
        normal = np.array([curves[result.system.connection_forces.places[f"{leg} foot"]][2] for leg in LEGS])
        first, worst = times[(normal < 0).any(axis=0)][0], times[normal.min(axis=0).argmin()]
        assert found[0].startswith("4 feet lift off, first at ") and "; most of all bushing " in found[0]
        numbers = [float(one) for one in re.findall(r"(?:first at|at t =|pull by) ([0-9.]+)", found[0])]
        assert numbers == pytest.approx([first, worst, -normal.min()], rel=1e-3)
        assert -min(least.values()) == pytest.approx(-normal.min(), rel=1e-6)
    assert "Forces during the motion" in result.summary()


def test_feet_that_leave_the_ground_between_the_times_of_the_table_are_noticed(soft):
    results = soft(400.0, 0.7, 3), soft(400.0)
    texts = [[one.text for one in result.notices if "the equations keep feet in place" in one.text] for result in results]
    assert texts[0] == texts[1] and texts[0]


def test_a_foot_at_the_edge_of_its_cone_is_no_alarm(soft):
    """The friction that the motion needs, less or more by a thousandth."""
    result = soft(20.0)
    forces, curves = result.system.connection_forces, result.curves("ground_reaction").values
    feet = [curves[forces.places[f"{leg} foot"]][:3] for leg in LEGS]
    needed = max((np.hypot(*force[:2]) / force[2]).max() for force in feet)
    for change in (1.001, 0.999):
        notices = soft(20.0, change * needed).notices
        assert any("slip" in notice.text for notice in notices) == (change < 1)


MAST = """<robot name="mast"><link name="table"><inertial><mass value="4"/><origin xyz="0.02 0 0.3"/>
<inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="bob"><inertial><mass value="1"/><origin xyz="0 0 0.2"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="mast" type="continuous"><parent link="table"/><child link="bob"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/></joint></robot>"""


@pytest.mark.parametrize("feet", [3, 4])
def test_the_table_says_where_the_share_of_changes_is_open(tmp_path, feet):
    """Nine rows or twelve of six motions of a table: three or six are implied by the others, whichever are left out."""
    (tmp_path / "table").mkdir()
    (tmp_path / "table" / "mast.urdf").write_text(MAST)
    loops = "".join(
        f'[[loop]]\nname = "foot {n}"\nbody1 = "ground"\nbody2 = "table"\npoint2 = [{x}, {y}, 0]\nfriction = 0.9\n'
        for n, (x, y) in enumerate([(-0.2, -0.1), (0.2, -0.1), (0.0, 0.1), (0.2, 0.1)][:feet])
    )
    joints = 'urdf = "mast.urdf"\nbase = "free"\njoint_stiffness = { mast = 50 }\njoint_damping = { mast = 0.3 }\n'
    (tmp_path / "table" / "robot.toml").write_text(joints + loops)
    scene = '[model]\nkind = "robot"\nrobot = "table"\n[initial.displacement]\nmast = 0.01\n[time]\nend = 1\n'
    text = scene_of(tmp_path, scene + '[output]\nplots = ["ground_reaction"]\n').run().summary()
    table = " ".join(text.split("Forces during the motion")[1].split("Posture")[0].split())
    assert "It is open how connections share the changes of forces: here foot " in table
    assert ("and 3 more have no part in them" if feet == 4 else " have no part in them") in table
    assert "e-" not in table  # rounding errors of forces are zero
    quadruped = read_scene(EXAMPLES / "quadruped.toml").run()
    assert "Forces during" in quadruped.summary() and "It is open how" not in quadruped.summary()


def difference(posture, direction, h=1e-4):
    """Central difference of the nonlinear forces of springs along a direction, by the poses of the moved robot alone."""
    balance, tree = posture.balance, posture.robot.tree

    def at(step):
        there = Balance(tree, balance.load, tree.moved(posture.configuration, step * direction))
        return np.concatenate([one.pose.directions @ one.wrench for one in there.elastic])

    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)


def test_springs_follow_differences_of_their_nonlinear_forces():
    """Between bodies and to the ground, turned against each other by up to 1 rad and loaded."""
    rng = np.random.default_rng(4)
    text = spatial_arm(rng)
    springs = [
        mb.Bushing(
            "body 0", (0.1, 0, 0.2), "body 3", (0, 0.1, 0), stiffness=(900, 400, 700), turning_stiffness=(30, 20, 10),
            rotation1=(0.3, 0.2, -0.4), rotation2=(0.1, 0.5, 0.2), name="mount",
        ),
        mb.Bushing("ground", (0.3, 0.1, 0.2), "body 3", (0, 0, 0.1), stiffness=(300, 500, 200), turning_stiffness=(5, 6, 7), name="foot"),
        mb.BodySpring("body 1", (0.1, 0, 0), "ground", (0.5, 0.2, 0.9), stiffness=300.0, rest_length=0.2, name="tie"),
    ]  # fmt: skip
    robot = mb.Robot(text, springs=springs)
    posture = robot.equilibrium(dict(zip(robot.joints, (0.3, -0.7, 0.2, 0.9))), hold="all")
    forces = robot.linearize(posture).connection_forces
    rows = [i for part in (range(12), range(12, 18)) for i in part]
    for direction in np.eye(4):
        expected = difference(posture, direction)[rows][: len(forces.rest)]
        assert forces.displacement @ direction == pytest.approx(expected, abs=1e-8 * np.abs(forces.displacement).max())
    assert forces.rest == pytest.approx(np.concatenate([*posture.ground_reactions.values()])[: len(forces.rest)], rel=1e-12)
