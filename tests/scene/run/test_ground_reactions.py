"""Forces of the loops of a robot during the motion along the axes of the ground, against pinocchio's placements of the links."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import mbconstrained as mb
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of


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
        in_ground = np.array([by_component[f"{loop.name} on {loop.body2} force {axis}"] for axis in "xyz"])
        assert in_ground == pytest.approx(rotation(posture, loop) @ in_frame, abs=1e-12 * np.abs(own.values).max())
        turned = max(turned, np.abs(in_ground - in_frame).max())
    assert len(ground.names) == 3 * len(posture.robot.loops) and set(ground.units) == {"N"}
    assert turned > 0.01 * np.abs(own.values).max() or name == "quadruped"


@pytest.mark.parametrize("name", ["four_bar", "delta"])
def test_with_the_multipliers_at_rest_they_are_the_reactions_at_rest(name):
    posture = read_scene(EXAMPLES / f"{name}.toml").equations.posture
    names, _, matrix = posture.ground_directions(posture.balance.load.row_names)
    forces = np.concatenate([posture.ground_reactions[loop.name][:3] for loop in posture.robot.loops])
    assert matrix @ posture.multipliers == pytest.approx(forces, rel=1e-12) and len(names) == len(forces)


def test_torques_are_turned_too():
    """A hinge in a turned frame; six components, whose rows at rest are those of the posture."""
    hinge = mb.Loop("ground", (0.3, -0.02, -0.5), "lower", (0, 0, -0.3), "hinge", axis=(0, 1, 0), rotation1=(0, 0.4, 0), name="pin")
    robot = mb.Robot("robots/double_pendulum/double_pendulum.urdf", loops=[hinge])
    posture = robot.equilibrium({"shoulder": -0.2, "elbow": 1.0}, {"elbow": 1.0})
    names, units, matrix = posture.ground_directions(posture.balance.load.row_names)
    multipliers = np.arange(1.0, 1.0 + matrix.shape[1])
    (gradient,) = posture.balance.gradients
    turn, wrench = rotation(posture, hinge), gradient.T @ multipliers
    assert matrix @ multipliers == pytest.approx(np.concatenate([turn @ wrench[:3], turn @ wrench[3:]]), abs=1e-12)
    assert units == ("N",) * 3 + ("N m",) * 3 and names[3] == "pin on lower torque x"


def test_files_have_both(tmp_path):
    result = read_scene(EXAMPLES / "four_bar.toml", {"output.reactions": True}).run()
    head = result.write(tmp_path / "bar.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "coupler pin x reaction (N)" in head and "coupler pin on rocker force x in ground axes (N)" in head
    with np.load(result.write(tmp_path / "bar.npz")) as arrays:
        assert arrays["ground_reaction"].shape == (3, len(result.times))


def test_models_without_loops_have_none(tmp_path):
    assert "ground_reaction" not in scene_of(tmp_path, OSCILLATOR + "[output]\nreactions = true\n").run().kinds
