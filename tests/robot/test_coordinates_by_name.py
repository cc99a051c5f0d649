"""Joints with several degrees of freedom by the names of their coordinates, as messages print them; points as channels."""

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from mbconstrained.robot.connections import AXES
from mbconstrained.scene.build.robot_model import _place
from tests.robot.linkages import GROUND, bar, joint, link, urdf

PLANAR = urdf(GROUND, bar("plate", 0.5, 0.2), joint("slide", "frame", "plate", kind="planar"))
PENDULUM = "robots/pendulum/pendulum.urdf"


def test_a_guess_by_coordinate_is_that_by_joint():
    robot = mb.Robot(PLANAR, gravity=0)
    for own, whole in (({"slide x": 0.1, "slide rz": 0.3}, (0.1, 0.0, 0.3)), ({"slide y": -0.2}, (0.0, -0.2, 0.0))):
        postures = [robot.equilibrium(guess, hold=["slide"]) for guess in (own, {"slide": whole})]
        assert np.array_equal(*(posture.configuration for posture in postures))
    free = mb.Robot(PENDULUM, base="free")
    postures = [
        free.equilibrium(guess, hold=["base", "pivot"])
        for guess in ({"base z": 1.0, "base rx": 0.2}, {"base": (0, 0, 1.0, 0.2, 0, 0)})
    ]
    assert np.array_equal(*(posture.configuration for posture in postures))
    assert set(postures[0].torques) == set(free.coordinates)


@pytest.mark.parametrize(
    ("guess", "message"),
    [
        ({"slide x": 0.1, "slide": (0, 0, 0)}, 'guess: found "slide x" and "slide"; give one of them'),
        ({"slide x": float("nan")}, "guess of slide x: found nan"),
        ({"slide w": 1.0}, 'there is no joint "slide w" that moves; did you mean "slide"'),
    ],
)
def test_wrong_coordinates(guess, message):
    with pytest.raises(mb.InputError, match=message):
        mb.Robot(PLANAR).equilibrium(guess)


def test_the_table_of_a_posture_has_the_loads_of_joints_with_several(tmp_path):
    """The weight of a body on springs, and its moment about the origin."""
    body = urdf(GROUND, link("table", 20.0, (0.1, 0, 0.2), (0.5, 0.6, 0.9)), joint("mount", "frame", "table", kind="floating"))
    (tmp_path / "table.urdf").write_text(body)
    springs = "".join(f'"mount {axis}" = 1e4\n' for axis in AXES)
    (tmp_path / "robot.toml").write_text(f'urdf = "table.urdf"\n[joint_stiffness]\n{springs}')
    scene = '[model]\nkind = "robot"\nrobot = "."\n[initial.displacement]\n"mount z" = 0.001\n[time]\nend = 1\n'
    (tmp_path / "scene.toml").write_text(scene)
    text = " ".join(mb.read_scene(tmp_path / "scene.toml").run().summary().split())
    assert f"z {20 * 9.81:.6g} N, ry {-20 * 9.81 * 0.1:.6g} N m" in text


@pytest.mark.parametrize(
    ("name", "level", "states"),
    [("seven_joint_arm", "position", 28)]
    + [("quadruped", level, 12 + 12 * drift) for drift, level in enumerate(("position", "velocity", "acceleration"))],
)
def test_a_state_space_of_a_robot_goes_to_control_and_back(name, level, states):
    """Seven joints with motors; a robot on four feet, two states for each motion that their rows leave, and those of their drift."""
    control = pytest.importorskip("control")
    robot, data = mb.read_robot(f"robots/{name}")
    system = robot.linearize(robot.equilibrium(**data.posture), level=level)
    body = robot.bodies[-1]
    point = mb.PointMotion(body, (0.2, 0.0, 0.08), along=(0, 0, 1))
    inputs, outputs = {"push": point, "knee": robot.joints[-1]}, {"rise": point, "turn": mb.PointMotion(body, turn=True)}
    other = system.to_state_space(inputs, outputs).to_control()
    assert isinstance(other, control.StateSpace) and other.input_labels == ["force on push", "force on knee"]
    assert other.nstates == states
    w = np.array([1.0, 20.0, 200.0])
    H = system.frequency_response(w / (2 * np.pi), inputs, outputs).values
    for space in (other, mb.StateSpace.from_control(other)):
        values = np.array([space(1j * rate) for rate in w]).transpose(1, 2, 0)
        assert values == pytest.approx(H, rel=1e-9, abs=1e-11 * np.abs(H).max())
    poles, own = np.linalg.eigvals(other.A), system.modes().eigenvalues
    own = own[np.abs(own) > 1e-6 * np.abs(own).max()]
    assert np.abs(own[:, None] - poles).min(axis=1) == pytest.approx(np.zeros(len(own)), abs=1e-7 * np.abs(own).max())


def several(kind: str) -> tuple[mb.Robot, dict]:
    """A heavy body on a joint with several degrees of freedom, whose springs carry it where the guess has it, and the guess."""
    model, inertia = pin.Model(), pin.Inertia(2.0, np.array([0.1, 0.05, -0.3]), np.diag([0.03, 0.04, 0.02]))
    number = model.addJoint(0, getattr(pin, f"JointModel{kind}")(), pin.SE3.Identity(), "mount")
    model.appendBodyToJoint(number, inertia, pin.SE3.Identity())
    model.addFrame(pin.Frame("body", number, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    model.gravity.linear = np.array([1.0, -2.0, -9.0])
    name = "base" if kind == "FreeFlyer" else "mount"
    guess = {"FreeFlyer": (0.1, 0.2, 0.3, 0.4, -0.5, 0.6), "Planar": (0.1, 0.2, 0.7), "Spherical": (0.4, -0.5, 0.6)}[kind]
    axes = {"FreeFlyer": AXES, "Planar": ("x", "y", "rz"), "Spherical": AXES[3:]}[kind]
    stiffness = {f"{name} {axis}": 40.0 + 9.0 * AXES.index(axis) for axis in axes}
    return mb.Robot(model, joint_stiffness=stiffness), {name: guess}


@pytest.mark.parametrize("kind", ["FreeFlyer", "Planar", "Spherical"])
def test_springs_that_carry_a_load_have_the_stiffness_of_their_potential(kind):
    """Differences of k x^2 / 2 - F x of each coordinate, the displacement along axes at rest or the rotation vector, and of the weight."""
    robot, guess = several(kind)
    posture = robot.equilibrium(guess)
    system = robot.linearize(posture)
    model, q0 = robot.model, posture.configuration
    data, axes = model.createData(), [AXES.index(name.split()[1]) for name in robot.coordinates]
    loads = np.array([posture.torques[name] for name in robot.coordinates])
    pin.forwardKinematics(model, data, q0)
    rest = data.oMi[1].copy()

    def energy(step):
        weight = pin.computePotentialEnergy(model, data, pin.integrate(model, q0, step))
        pose = rest.actInv(data.oMi[1])
        x = np.concatenate([pose.translation, pin.log3(pose.rotation)])[axes]
        return weight + (robot.joint_stiffness * x**2).sum() / 2 - loads @ x

    h, n = 1e-3, len(loads)
    steps = h * np.eye(n)
    expected = np.array([[sum(a * b * energy(a * e + b * f) for a in (1, -1) for b in (1, -1)) for f in steps] for e in steps])
    assert np.abs(loads).max() > 1.0
    assert system.stiffness == pytest.approx(expected / (4 * h * h), abs=1e-4 * np.abs(system.stiffness).max())
    assert np.array_equal(system.stiffness, system.stiffness.T) and not system.notices


def swinging(joint, name="j"):
    """A rod on one joint, as a pinocchio model."""
    model = pin.Model()
    number = model.addJoint(0, joint, pin.SE3.Identity(), name)
    model.appendBodyToJoint(number, pin.Inertia(1.0, np.array([0, 0, -0.5]), np.diag([0.01, 0.02, 0.03])), pin.SE3.Identity())
    model.addBodyFrame("rod", number, pin.SE3.Identity(), 0)
    return model


@pytest.mark.parametrize(
    ("joint", "texts"),
    [
        (pin.JointModelRY(), ["0 rad"]),
        (pin.JointModelPX(), ["0 m"]),
        (pin.JointModelSpherical(), ["roll, pitch, yaw (0, 0, 0) rad"]),
        (pin.JointModelTranslation(), ["(0, 0, 0) m"]),
        (pin.JointModelPlanar(), ["(0, 0) m", "0 rad"]),
        (pin.JointModelFreeFlyer(), ["(0, 0, 0) m", "roll, pitch, yaw (0, 0, 0) rad"]),
    ],
)
def test_places_are_written_by_their_units(joint, texts):
    robot = mb.Robot(swinging(joint))
    units = dict(zip(robot.coordinates, robot.units))
    (name,) = robot.tangent.joints
    value = robot.tangent.values(pin.neutral(robot.model))[name]
    text = _place(value, [units[one] for one in robot.tangent.coordinates_of(name)])
    assert all(one in text for one in texts), text


def test_a_quarter_turn_of_a_ball_is_its_yaw():
    half = np.sqrt(0.5)
    assert _place((0.0, 0.0, half, half), ["rad"] * 3) == "roll, pitch, yaw (0, 0, 1.5708) rad"


@pytest.mark.parametrize("limits", [None, (-np.inf, np.inf), (-np.inf, 1.0), (-1.0, np.inf)])
def test_joints_without_limits_are_not_beyond_them(limits):
    """Pinocchio has the largest float64 number where there is no limit."""
    model = swinging(pin.JointModelRY())
    if limits:
        model.lowerPositionLimit[:], model.upperPositionLimit[:] = limits
    robot = mb.Robot(model)
    assert not [notice for notice in robot.equilibrium().notices if "limits" in notice.text]
    assert (robot.limits == {}) == (limits in (None, (-np.inf, np.inf)))
    assert robot.tangent.outside_limits({"j": 2.0}, 1e-9, 0.1) == (
        "" if limits != (-np.inf, 1.0) else robot.tangent.outside_limits({"j": 2.0}, 0.0)
    )
