"""The drawing of a robot: links, plates, loops, springs."""

import numpy as np
import pytest

from mbconstrained.page.animation import Animation, key_frames
from mbconstrained.page.drawing import Path
from mbconstrained.page.figure import figure_data
from mbconstrained.scene.run.drawing import MOST_TRIANGLES, PAD, robot_drawing, simplified, solids_of
from tests.page.robots import Seen, Tie, four_bar, turned

TIMES = np.linspace(0, 6, 121)
REST = Path(np.zeros((3, 1)), [[0], [0], [0], [1]])


def figure(animation):
    return figure_data(
        animation.drawing, [key_frames(Animation(animation.drawing, animation.names, animation.times, animation.values))]
    )


def test_a_closed_loop_has_no_gap_and_a_spring_its_length():
    animation = four_bar(TIMES)
    loop, spring, bushing = figure(animation)["links"]
    assert (loop["kind"], loop["longest"]) == ("loop", pytest.approx(0, abs=1e-13))
    assert (bushing["kind"], bushing["longest"]) == ("bushing", pytest.approx(0, abs=1e-13))
    angles = np.array(next(body.path for body in animation.drawing.bodies if body.name == "coupler").quaternions)
    assert spring["kind"] == "spring" and 0 < spring["shortest"] < spring["mean"] < spring["longest"]
    assert angles.shape == (4, 121)


def test_an_open_loop_shows_its_gap():
    poses = {"a": REST, "b": Path([[0.5], [0], [0]], [[0], [0], [0], [1]])}
    seen = [Seen("a", "box", (1, 1, 1)), Seen("b", "box", (1, 1, 1))]
    drawing = robot_drawing(solids_of(seen), poses, [Tie("l", "loop", "a", (0, 0, 0), "b", (0, 0, 0.25))], fixed=False)
    data = figure_data(drawing, [key_frames(Animation(drawing, (), [0.0], np.zeros((0, 1))))])
    assert data["links"][0]["mean"] * data["unit"] == pytest.approx(np.hypot(0.5, 0.25))


@pytest.mark.parametrize("size", [1e-3, 0.1, 3.0, 1e3])
def test_the_picture_is_the_same_for_every_size_but_for_the_unit(size):
    one, other = figure(four_bar(TIMES)), figure(four_bar(TIMES, size))
    assert other["unit"] == pytest.approx(size * one["unit"])
    for side in ("low", "high"):
        assert other["bounds"][side] == pytest.approx(one["bounds"][side], rel=1e-9, abs=1e-9)
    assert [link["mean"] for link in other["links"]] == pytest.approx([link["mean"] for link in one["links"]], abs=1e-9)
    assert other["view"] == one["view"]


def test_bounds_hold_every_part_over_the_whole_motion():
    # a bar of length 1 that turns once about y through its end: a circle of radius 1 with half its thickness around it
    times = np.linspace(0, 1, 401)
    poses = {"bar": Path(np.zeros((3, 401)), turned((0, -1, 0), 2 * np.pi * times))}
    placement = np.eye(4)
    placement[0, 3] = 0.5
    drawing = robot_drawing(solids_of([Seen("bar", "box", (1, 0.2, 0.2), placement)]), poses, fixed=False)
    data = figure_data(drawing, [key_frames(Animation(drawing, (), times, np.zeros((0, 401))))])
    radius = np.hypot(1, 0.1)
    high = data["unit"] * np.array(data["bounds"]["high"])
    assert high == pytest.approx([radius, 0.1, radius], rel=1e-4)


def test_a_spring_and_a_damper_between_the_same_points_are_a_strut():
    ties = [Tie(kind, kind, "a", (0, 0, 0), "ground", (1, 0, 0)) for kind in ("spring", "damper")]
    ties.append(Tie("other", "damper", "a", (0, 0, 0), "ground", (2, 0, 0)))
    drawing = robot_drawing({}, {"a": REST}, ties)
    assert [link.kind for link in drawing.links] == ["strut", "damper"]


def test_no_links_at_all_is_a_drawing():
    drawing = robot_drawing({}, {})
    data = figure_data(drawing, [key_frames(Animation(drawing, (), [0.0], np.zeros((0, 1))))])
    assert data["unit"] > 0


@pytest.mark.parametrize(("height", "side"), [(0.5, -1), (-0.5, 1)])
def test_the_foot_of_a_mount_on_the_ground_is_outside_of_the_body(height, side):
    """The body is a box above the mount, or one that hangs from it: drawn at the point itself, half of the mount was inside."""
    placement = np.eye(4)
    placement[2, 3] = height
    seen = Seen("block", "box", (1.0, 1.0, 0.2), placement)
    point = (0.25, 0.2, 0.0)
    drawing = robot_drawing(
        solids_of([seen]), {"block": REST}, [Tie("mount", "bushing", "block", point, "ground", point)], fixed=False
    )
    (link,) = drawing.links
    assert link.start_point == point and link.end_point[:2] == point[:2]
    assert link.end_point[2] * side > 0
    pad = next(body for body in drawing.bodies if body.name.startswith(PAD))
    assert pad.rest[2] + pad.size[2] / 2 == pytest.approx(link.end_point[2])


def sphere(rings: int, radius: float = 1.0):
    """Vertices and faces of a closed sphere, the poles as rings of coinciding points."""
    up, around = np.meshgrid(np.linspace(0, np.pi, rings), np.arange(2 * rings) * np.pi / rings, indexing="ij")
    places = radius * np.stack([np.sin(up) * np.cos(around), np.sin(up) * np.sin(around), np.cos(up)], axis=-1).reshape(-1, 3)
    corner = np.arange(2 * rings * rings).reshape(rings, 2 * rings)
    a, b = corner[:-1], corner[1:]
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    return places, np.concatenate([np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, b, c), (c, b, d))])


def volume(vertices, faces):
    return np.linalg.det(vertices[faces]).sum() / 6


@pytest.mark.parametrize("shift", [0.0, 50.0])
def test_a_large_mesh_keeps_its_shape_with_few_triangles(shift):
    vertices, faces = sphere(180)
    places, kept, chosen = simplified(vertices + shift, faces)
    assert np.count_nonzero(chosen) == len(kept)
    assert MOST_TRIANGLES / 4 < len(kept) <= MOST_TRIANGLES < len(faces)
    assert np.abs(np.linalg.norm(places - shift, axis=1) - 1).max() < 0.02
    assert volume(places - shift, kept) == pytest.approx(4 / 3 * np.pi, rel=0.01)
    edges = np.sort(np.concatenate([kept[:, [0, 1]], kept[:, [1, 2]], kept[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all()  # closed


def test_large_meshes_are_whole_on_request_and_small_ones_always():
    (large, many), (small, few) = sphere(180), sphere(10)
    seen = [
        Seen(name, "mesh", (), vertices=v, faces=f) for name, v, f in (("a", large, many), ("b", large, many), ("c", small, few))
    ]
    counts = {full: [len(solids_of(seen, full=full)[name][0].faces) for name in "abc"] for full in (True, False)}
    assert counts[True][0] > MOST_TRIANGLES >= counts[False][0] == counts[False][1]
    assert counts[True][2] == counts[False][2]
