"""The command path: frequencies of a robot along a path as tables, page, picture and data."""

import json
import shutil

import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import eigh

ROBOT = "robots/double_pendulum"
SPRINGS = {"shoulder": 900.0, "elbow": 300.0}
FORCE = 40.0
SCENE = f"""
[model]
kind = "robot"
robot = "double_pendulum"
hold = "all"
guess = {{ shoulder = -0.5, elbow = 0.8 }}
body_force = [{{ body = "lower", point = [0, 0, -0.3], along = [0, 0, -1], value = {FORCE} }}]
[robot]
joint_stiffness = {{ shoulder = 900, elbow = 300 }}
[initial.velocity]
elbow = "1 rad/s"
[time]
end = 1
[path]
body = "lower"
point = [0, 0, "-300 mm"]
corners = [[0.2, -0.02, -0.5], [0.3, -0.02, -0.5], [0.3, -0.02, -0.45]]
points = 4
"""


@pytest.fixture
def path(command, tmp_path, request):
    """The command on a scene of a text: exit code, output, output of errors as one line."""
    shutil.copytree(request.config.rootpath / ROBOT, tmp_path / "double_pendulum")

    def run(text, *options):
        (tmp_path / "arm.toml").write_text(text, encoding="utf-8")
        code, output, errors = command("path", "arm.toml", "--out", "out", *options)
        return code, output, " ".join(errors.split())

    return run


def frequencies(folder, place) -> np.ndarray:
    """By the law of cosines, pinocchio's mass matrix, and differences of its torques under gravity and the force on the tip (Hz)."""
    model = pin.buildModelFromUrdf(str(folder / "double_pendulum.urdf"))
    (x, z), (a, b) = np.array(place)[[0, 2]], (0.4, 0.3)
    tip = model.addFrame(pin.Frame("tip", 2, 0, pin.SE3(np.eye(3), np.array([0, 0, -0.3])), pin.FrameType.OP_FRAME))
    data = model.createData()
    elbow = np.arccos((x**2 + z**2 - a**2 - b**2) / (2 * a * b))
    shoulder = np.arctan2(x, -z) - np.arctan2(b * np.sin(elbow), a + b * np.cos(elbow))

    def at(turn):
        return pin.integrate(model, pin.neutral(model), np.array([shoulder, elbow]) + turn)

    def load(turn):
        q = at(turn)
        J = pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL_WORLD_ALIGNED)
        return pin.computeGeneralizedGravity(model, data, q) - J[:3].T @ [0, 0, -FORCE]

    h = 1e-5
    K = np.array([(load(h * e) - load(-h * e)) / (2 * h) for e in np.eye(2)]).T + np.diag(list(SPRINGS.values()))
    M = pin.crba(model, data, at(0.0))
    pin.framesForwardKinematics(model, data, at(0.0))
    assert data.oMf[tip].translation == pytest.approx(place, abs=1e-12)
    return np.sqrt(eigh(K, M, eigvals_only=True)) / (2 * np.pi)


@pytest.mark.long
def test_frequencies_are_those_of_the_postures(path, tmp_path):
    """Places equally far apart over the corner, under the force of the posture."""
    code, output, _ = path(SCENE, "--json")
    data = json.loads(output)
    assert code == 0 and data["unreachable"] == [] and data["lengths"] == pytest.approx([0, 0.05, 0.1, 0.15])
    expected = [(0.2, -0.02, -0.5), (0.25, -0.02, -0.5), (0.3, -0.02, -0.5), (0.3, -0.02, -0.45)]
    assert np.array(data["places"]) == pytest.approx(np.array(expected))
    own = [frequencies(tmp_path / "double_pendulum", place) for place in expected]
    assert np.array(data["frequencies_hz"]) == pytest.approx(np.array(own), rel=1e-7)
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"arm.path.html", "arm.path.png", "arm.path.json"}


@pytest.mark.long
def test_the_text_fits_80_columns_and_lists_places_out_of_reach(path, tmp_path):
    code, output, _ = path(SCENE.replace("-0.45]", "-0.9]"), "--points", "6")
    assert code == 0 and max(map(len, output.splitlines())) <= 80
    text = " ".join(output.split())
    assert "6 places on 0.5 m, 3 of them out of reach" in text and "3 of 6 places are not reached: 4" in text
    assert "Places out of reach" in (tmp_path / "out" / "arm.path.html").read_text(encoding="utf-8")
    data = json.loads((tmp_path / "out" / "arm.path.json").read_text())
    assert [each["place"] for each in data["unreachable"]] == [4, 5, 6] and data["frequencies_hz"][4] == [None, None]
    assert data["joints"][4] is None and data["unreachable"][2]["distance"] == pytest.approx(np.hypot(0.3, 0.9) - 0.7, rel=0.2)


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ('[model]\nkind = "matrices"\nmass = [[1]]\nstiffness = [[1]]\n[time]\nend = 1\n', [], 'a model of kind = "robot"'),
        (SCENE[: SCENE.index("[path]")], [], "there is no path; add the table [path]"),
        (SCENE.replace('body = "lower"\npoint', 'body = "lowr"\npoint'), [], 'did you mean "lower"'),
        (SCENE.replace("[[0.2, -0.02, -0.5]", "[[2, -0.02, -0.5]"), [], "lower does not reach (2, -0.02, -0.5) m"),
        (SCENE.replace("[[0.2, -0.02, -0.5]", "[[0.3, -0.02, -0.5]"), [], "found the same place twice in succession"),
        (SCENE.replace("-300 mm", "-300 mg"), [], "path.point"),
        (SCENE.replace("points = 4", "point = 4"), [], "point"),
        (SCENE.replace("points = 4", "pionts = 4"), [], 'did you mean "points"'),
        (SCENE, ["--points", "1"], "path.points"),
    ],
)
def test_errors_are_those_of_the_scene(path, tmp_path, text, options, message):
    code, _, errors = path(text, *options)
    assert code == 1 and message in errors
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())
