"""Bodies, links, paths and rotations: what they accept, and where they put a body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbconstrained.ground.errors import InputError
from mbconstrained.page.animation import Animation, body_poses, key_frames
from mbconstrained.page.drawing import Drawing, DrawnBody, Path, after, matrix_of, quaternions_of, rotated, vector_of
from tests.page.contents import positions


def test_positions_are_linear_in_the_coordinates():
    body = DrawnBody("b", rest=(1, 2, 3), moves={"x": (1, 0, 0), "y": (0, 0, 2)})
    drawing = Drawing((body,), scale=10)
    assert positions(drawing, body, ("x", "y"), [[0.0, 1.0], [0.0, 0.5]]).tolist() == [[1, 11], [2, 2], [3, 13]]


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: DrawnBody("b", size=(1, 0, 1)), "size: found 0; expected numbers greater than zero"),
        (lambda: Drawing((DrawnBody("b"), DrawnBody("b"))), 'two bodies are named "b"'),
    ],
)
def test_what_cannot_be_drawn_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


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


AXES = np.random.default_rng(3).standard_normal((20, 3))
ANGLES = (0.0, 1e-9, 0.5, 2.5, 2.8, 3.1, np.pi - 1e-9)


@pytest.mark.parametrize("angle", ANGLES)
def test_vectors_and_matrices_are_those_of_scipy(angle):
    for vector in angle * AXES / np.linalg.norm(AXES, axis=1)[:, None]:
        assert matrix_of(vector) == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-14)
        assert vector_of(matrix_of(vector)) == pytest.approx(vector, abs=1e-12)


def test_one_rotation_after_another():
    first, second = (Rotation.from_rotvec(axes) for axes in (AXES[:10], AXES[10:]))
    found = after(*(quaternions_of(each.as_rotvec().T) for each in (second, first)))
    assert np.abs((found.T * (second * first).as_quat()).sum(axis=1)) == pytest.approx(1.0)  # q and -q are one orientation
