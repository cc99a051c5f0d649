"""Operating deflection shapes of scenes: the responses of all coordinates, drawn as large as there is room for."""

import numpy as np
import pytest

from mbconstrained.analyses.frequency import Frequency
from mbconstrained.scene.run.drawing import LinearRobot, RobotPicture
from mbconstrained.scene.run.scene import read_scene
from tests.analyses.test_frequency import ISOLATED, frequency_of, transmissibility
from tests.scene.scenes import COEFFICIENTS, EXAMPLES


def test_a_shape_is_the_response_of_all_coordinates_the_support_included(tmp_path):
    shapes = frequency_of(tmp_path, ISOLATED, quantity="transmissibility", axis="rad/s").deflections()
    assert shapes.inputs == ("1 m of motion of floor",) and shapes.names == ("machine", "floor")
    T = transmissibility(shapes.frequencies / (2 * np.pi))
    expected = np.column_stack([T, np.ones_like(T)])
    assert np.allclose(shapes.shapes[0], expected * shapes.factors[0, :, None], rtol=1e-10)
    reach = np.abs(shapes.shapes[0]).max(axis=1)
    assert reach.max() < 10 * reach.min()  # of amplitudes that differ by a factor of 1000


def test_a_force_by_its_unit_and_impedances_by_their_motions(tmp_path):
    shapes = frequency_of(tmp_path, ISOLATED, quantity="impedance", inputs=["machine"], outputs=["machine"]).deflections()
    assert shapes.inputs == ("1 N on machine",)
    H = shapes.shapes[0] / shapes.factors[0, :, None]
    K, zeta, w = 2 * (2 * np.pi * 50) ** 2, 0.05, 2 * np.pi * shapes.frequencies
    assert np.allclose(H[:, 0], 1 / (K + 1j * w * 2 * zeta * np.sqrt(2 * K) - 2 * w**2), rtol=1e-9) and not H[:, 1].any()


def test_models_without_places_have_no_shapes(tmp_path):
    assert frequency_of(tmp_path, COEFFICIENTS).deflections() is None
    assert frequency_of(tmp_path, ISOLATED + "[output]\nanimation = false").deflections() is None


@pytest.mark.parametrize("name", ["four_bar", "seven_joint_arm"])
def test_links_of_a_robot_move_linearly_as_they_do_in_small_motion(name):
    scene = read_scene(EXAMPLES / f"{name}.toml")
    frequency = Frequency(scene)
    u = np.real(frequency.coordinate_response()([2.0]).values[:, 0, 0])  # at rest of the loops: an admissible motion
    robot, picture = LinearRobot(scene.equations.robot_scene), RobotPicture(scene.equations.robot_scene)
    small = 2e-3 / np.abs(u).max()
    there, back = (picture.poses(sign * small * u[:, None]) for sign in (1, -1))
    bodies, names = {body.name: body for body in robot.drawing.bodies}, scene.equations.coordinates.names
    for link, pose in there.items():
        moved = sum((u[names.index(key)] * np.array(way) for key, way in bodies[link].moves.items()), np.zeros(3))
        expected = (pose.positions - back[link].positions)[:, 0] / (2 * small)
        assert np.allclose(moved, expected, atol=0.01 * np.abs(u).max() * picture.size)
