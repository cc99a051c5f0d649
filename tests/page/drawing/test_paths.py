"""Paths and poses: unit quaternions of continuous sign, points that turn with their body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbconstrained.page.animation import Animation, body_poses, key_frames
from mbconstrained.page.drawing import Drawing, DrawnBody, Path, quaternions_of, rotated


def test_signs_are_chosen_so_that_neighbours_are_near():
    rotations = Rotation.from_rotvec(np.outer(np.linspace(0, 20, 60), [0.6, 0, 0.8]))
    signs = np.where(np.arange(60) % 7 < 3, -1, 1)
    path = Path(np.zeros((3, 60)), rotations.as_quat().T * signs)
    assert (np.linalg.norm(np.diff(path.quaternions), axis=0) < 0.2).all()
    same = np.abs((path.quaternions * rotations.as_quat().T).sum(axis=0))
    assert np.allclose(same, 1, atol=1e-14)


def test_a_path_that_rests_does_not_move_though_its_signs_change():
    assert not Path(np.ones((3, 3)), np.outer([0, 0, 0, 1], [1, -1, 1])).moves
    assert Path([[0, 1e-9], [0, 0], [0, 0]], np.ones((4, 2))).moves


def test_points_turn_with_their_body():
    rng = np.random.default_rng(3)
    rotations, points = Rotation.random(8, random_state=4), rng.normal(size=(3, 5))
    known = np.stack([rotation.apply(points.T).T for rotation in rotations], axis=2)
    assert np.allclose(rotated(rotations.as_quat().T, points), known, atol=1e-14)


@pytest.mark.parametrize("size", [0.0, 1e-12, 0.3, np.pi, 9.0])
def test_quaternions_of_rotation_vectors(size):
    turn = size * np.array([2, -1, 2]) / 3
    assert np.allclose(quaternions_of(turn[:, None])[:, 0], Rotation.from_rotvec(turn).as_quat(canonical=False), atol=1e-15)


def test_a_body_is_where_its_path_or_the_coordinates_put_it():
    path = Path([[0, 1], [0, 0], [0, 5]], [[0, 1], [0, 0], [0, 0], [1, 0]])
    still = Path([[7], [8], [9]], [[0], [0], [0], [1]])
    bodies = (
        DrawnBody("a", "solids", path=path),
        DrawnBody("b", "solids", path=still),
        DrawnBody("c", rest=(1, 0, 0), turns={"x": (0, 0, 1)}),
    )
    drawing = Drawing(bodies, turn_scale=2)
    frames = key_frames(Animation(drawing, ("x",), [0, 1], [[0, np.pi / 2]]))
    poses = body_poses(drawing, frames)
    a, b, c = (poses[name] for name in "abc")
    assert a.positions.tolist() == [[0, 1], [0, 0], [0, 5]]
    assert b.positions.tolist() == [[7, 7], [8, 8], [9, 9]]
    assert np.allclose(c.quaternions, [[0, 0], [0, 0], [0, 1], [1, 0]], atol=1e-15)
