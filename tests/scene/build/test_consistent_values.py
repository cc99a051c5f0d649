"""initial.follow: what is not given comes from the constraint rows, and what is given stays."""

import re

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import EXAMPLES, scene_of

THREE = """
[model]
kind = "matrices"
coordinates = ["a", "b", "c", "d"]
mass = [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]
stiffness = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
ROWS
[initial]
follow = true
START
[time]
end = 1
points = 5
"""


def row(rows, level="position", value=0):
    return f'[[model.constraint]]\nrows = {{ {rows} }}\nlevel = "{level}"\nvalue = {value}\n'


def start(folder, rows, text):
    return scene_of(folder, THREE.replace("ROWS", rows).replace("START", text)).equations.initial


CHAIN = row("a = 1, b = -2") + row("b = 1, c = 1", value=5)  # a = 2 b, c = 5 - b


def test_what_is_left_out_follows_and_what_is_in_no_row_stays_at_0(tmp_path):
    found = start(tmp_path, CHAIN, "displacement = { a = 6 }\nvelocity = { c = -1 }")
    assert found == pytest.approx(np.array([[6, 3, 2, 0], [2, 1, -1, 0]]))


def test_nothing_given_is_the_state_that_the_rows_demand(tmp_path):
    assert start(tmp_path, row("a = 2", value=6), "")[0] == pytest.approx([3, 0, 0, 0])


def test_rows_of_velocity_level_are_followed_by_velocities_alone(tmp_path):
    found = start(tmp_path, row("a = 1, b = -1", "velocity", 4), "displacement = { a = 1 }\nvelocity = { b = 1 }")
    assert found == pytest.approx(np.array([[1, 0, 0, 0], [5, 1, 0, 0]]))


def test_rows_of_acceleration_level_hold_for_no_start(tmp_path):
    found = start(tmp_path, row("a = 1, b = -1", "acceleration", 4), "displacement = { a = 1 }")
    assert found == pytest.approx(np.array([[1, 0, 0, 0], [0, 0, 0, 0]]))


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_units_do_not_matter(tmp_path, scale):
    found = start(tmp_path, row(f"a = 1, b = {-scale}") + row(f"b = {scale}, c = 1"), "displacement = { a = 2 }")
    assert found[0] == pytest.approx([2, 2 / scale, -2, 0], rel=1e-12)


@pytest.mark.parametrize(
    ("rows", "text", "message"),
    [
        (CHAIN, "displacement = { d = 1 }", 'initial.displacement: the constraint rows leave "a", "b", "c" open; give one of them'),
        (row("a = 1, b = 1, c = 1", value=1), "", 'leave "a", "b", "c" open; give 2 of them a value'),
        (CHAIN, "displacement = { a = 6, b = 1 }", 'initial.displacement: the given values contradict the constraint row "'),
        (CHAIN, "displacement = { a = 1 }\nvelocity = { a = 1, b = 1 }", "initial.velocity: the given values contradict"),
        ("", "displacement = { a = 1 }", "initial.follow: there are no constraint rows"),
        (CHAIN, "displacement = [1, 1, 1, 1]", "initial: follow needs values by name"),
    ],
)
def test_message(tmp_path, rows, text, message):
    with pytest.raises(SceneError, match=re.escape(message)):
        scene_of(tmp_path, THREE.replace("ROWS", rows).replace("START", text))


LINKAGE = """
[model]
kind = "robot"
robot = "robots/NAME"

[initial]
displacement = { GIVEN }
follow = true

[time]
end = 1
points = 5
"""


@pytest.mark.parametrize("name", ["four_bar", "trapezoid", "slider_crank", "delta"])
def test_a_linkage_starts_closed_when_one_joint_is_given(tmp_path, name):
    (tmp_path / "robots").symlink_to(EXAMPLES.parent / "robots")
    joints = {"trapezoid": ["left pivot"], "delta": [f"arm {arm} drive" for arm in "ABC"]}.get(name, ["crank pivot"])
    given = ", ".join(f'"{joint}" = 0.01' for joint in joints)
    result = scene_of(tmp_path, LINKAGE.replace("NAME", name).replace("GIVEN", given)).run()
    motion = result.motion
    assert not np.abs(motion.jump).max() > 1e-14 and not any(impulse.any() for impulse in motion.impulses)
    assert [motion(0.0)[result.system.names.index(joint)] for joint in joints] == pytest.approx([0.01] * len(joints))
    assert np.abs(result.system.constraint_matrix @ result.scene.equations.initial[0]).max() < 1e-15
