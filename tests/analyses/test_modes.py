"""The modes of a scene: one line a shape, in 80 characters, as numbers, and as pictures that move sensibly."""

import json
import re

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.modes import ModalAnalysis
from mbconstrained.ground.display import WIDTH, TextTable, table_text
from mbconstrained.ground.errors import SceneError
from mbconstrained.page.animation import cycle
from mbconstrained.page.layout import WIDEST_ANGLE
from mbconstrained.scene.run.drawing import ShapeDrawing
from mbconstrained.scene.run.scene import read_scene
from tests.page.contents import positions
from tests.scene.scenes import COEFFICIENTS, EXAMPLES, MATRICES, OSCILLATOR, scene_of

ALL = sorted(path.name for path in EXAMPLES.glob("*.toml"))
ROBOTS = [name for name in ALL if 'kind = "robot"' in (EXAMPLES / name).read_text("utf-8")]
OF_COEFFICIENTS = [
    name
    for name in ALL
    if re.search(r"^(coefficients|numerator|descriptor) = ", (EXAMPLES / name).read_text("utf-8"), re.MULTILINE)
]

RACK = """
[model]
kind = "lumped"
inertia = [{ name = "pinion", inertia = "0.01 kg*m^2" }]
mass = [{ name = "rack", mass = "1 kg" }, { name = "far", mass = "1 kg" }]
rack = [{ gear = "pinion", rack = "rack", radius = "20 mm" }]
spring = [{ between = ["ground", "rack"], stiffness = "4 N/mm", rest_length = "3 m" }, { between = ["rack", "far"], stiffness = "9 N/mm" }]
damper = [{ between = ["ground", "far"], damping = "20 N*s/m" }]
[time]
end = 1
"""


def modes_of(folder, text):
    return ModalAnalysis(scene_of(folder, text))


def as_json(modes):
    return ModalAnalysis.solve(modes.scene).to_dict()


def written(modes, folder):
    (path,) = ModalAnalysis.solve(modes.scene).write(folder, ["page"])
    return path


def printed(modes):
    return "\n\n".join(
        table_text(block) if isinstance(block, TextTable) else block for block in ModalAnalysis.solve(modes.scene).blocks()
    )


def test_an_oscillator_by_hand(tmp_path):
    expected = """scene

Modes
  no.  Hz       damping  kind         eigenvalue (1/s)  rad/s  times
  1    0.31831  0        oscillation  ± 2 i             2      1
  damping: damping ratio; times: multiplicity of the eigenvalue

Mode 1: oscillation at 0.31831 Hz, undamped
  kinetic energy cart 100.0 %
  strain energy  spring ground-cart 100.0 %
  shape          cart 1 m

The largest entry of a shape is 1; its amplitude is free."""
    assert printed(modes_of(tmp_path, OSCILLATOR)) == expected


@pytest.mark.parametrize("example", ALL)
def test_every_example_is_readable_in_80_columns_and_as_data_and_its_modes_are_seen_without_collisions(example):
    modes = ModalAnalysis(mb.read_scene(EXAMPLES / example))
    text = printed(modes)
    assert max(map(len, text.splitlines())) <= WIDTH
    assert not re.search(r"\b(nan|inf)\b", text)
    data = as_json(modes)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert [line["number"] for line in data["modes"]] == list(range(1, len(data["modes"]) + 1))
    for line in data["modes"]:
        for shares in filter(None, (line["kinetic_shares"], line["strain_shares"])):
            assert sum(shares.values()) == pytest.approx(1.0, abs=1e-13)
    for move, change, turn in drawn(modes)[1] if example not in ROBOTS + OF_COEFFICIENTS else ():
        assert move <= 2.4 + 1e-9 and change <= 0.8 + 1e-9 and turn <= WIDEST_ANGLE + 1e-9
        assert move > 0.3 or turn > 0.3


def test_the_response_is_not_solved_for(tmp_path, monkeypatch):
    monkeypatch.setattr("mbconstrained.scene.build.equations.Equations.solve", lambda *_: pytest.fail("solved"))
    for text in (OSCILLATOR, MATRICES, COEFFICIENTS):
        modes = modes_of(tmp_path, text)
        assert printed(modes) and as_json(modes)["trusted"]


def test_a_zero_with_several_shapes_has_a_line_for_each(tmp_path):
    modes = modes_of(tmp_path, MATRICES.replace("[0, 4]]", "[0, 1]]"))
    first, second = modes.lines
    assert (first.number, second.number) == (1, 2) and first.multiplicity == second.multiplicity == 2
    assert "Mode 2 (shape 2 of 2): oscillation at 0.159155 Hz" in printed(modes)
    assert np.linalg.matrix_rank(np.array([first.shape, second.shape])) == 2
    assert [line["shape_of_zero"] for line in as_json(modes)["modes"]] == [1, 2]


def test_shares_of_plain_matrices_are_by_coordinate_and_say_so(tmp_path):
    text = printed(modes_of(tmp_path, MATRICES))
    assert "kinetic energy b 100.0 %" in text and "Shares of energy are by coordinate" in text
    assert "by coordinate" not in printed(modes_of(tmp_path, OSCILLATOR))


def test_of_coefficients_the_zeros_are_listed_and_no_more(tmp_path):
    modes = modes_of(tmp_path, COEFFICIENTS)
    text = printed(modes)
    assert "  1    0.31831  0        oscillation  ± 2 i             2      1" in text
    assert "only the coefficients of A(s)" in text and "kinetic energy " not in text and "shape  " not in text
    (line,) = as_json(modes)["modes"]
    assert (line["imaginary"], line["kinetic_shares"], line["shape"]) == (2.0, None, None)
    with pytest.raises(SceneError, match="scene.toml: model.coefficients: a page of modes needs mass, damping and stiffness"):
        written(modes, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_scene_without_zeros_says_so(tmp_path):
    static = MATRICES.replace("mass = [[1, 0], [0, 1]]", "mass = [[0, 0], [0, 0]]")
    assert "none: the model is static, without dynamic modes" in printed(modes_of(tmp_path, static))
    assert as_json(modes_of(tmp_path, static))["modes"] == []


def test_damped_shapes_have_phases_in_degrees(tmp_path):
    modes = modes_of(tmp_path, RACK)
    text = printed(modes)
    assert re.search(r"\d°", text) and "averages over a" in text
    line = next(line for line in as_json(modes)["modes"] if line["imaginary"])
    shape = np.array(line["shape"]["real"]) + 1j * np.array(line["shape"]["imaginary"])
    assert shape[0] == pytest.approx(1.0)  # 1 rad of the pinion, 0.02 m of the rack
    assert shape[1] == pytest.approx(0.02)
    assert set(line["kinetic_shares"]) == {"pinion", "rack", "far"}
    assert line["damping_ratio"] == pytest.approx(-line["real"] / line["angular_frequency"])
    assert line["frequency_hz"] == pytest.approx(line["angular_frequency"] / (2 * np.pi))


def test_doubt_is_told_and_makes_the_modes_untrusted(tmp_path, monkeypatch):
    assert ModalAnalysis.solve(scene_of(tmp_path, OSCILLATOR)).is_trusted
    doubt = mb.Notice("rank", "no clear gap between " + "very " * 40 + "small numbers", doubtful=True)
    monkeypatch.setattr("mbconstrained.analyses.modes.pair_notices", lambda pairs: (doubt,))
    modes = modes_of(tmp_path, OSCILLATOR)
    assert not as_json(modes)["trusted"]
    assert "Notices\n  warning (rank): no clear gap" in printed(modes)
    assert max(map(len, printed(modes).splitlines())) <= WIDTH


def drawn(modes):
    """The drawing, and for each shape (largest move, largest change between linked bodies, largest turn) as they are drawn."""
    scene, names = modes.scene, modes.system.names
    shapes = [line.shape for line in modes.lines if line.shape is not None]
    swinging = ShapeDrawing(scene, shapes)
    drawing = swinging.drawing
    found = []
    for shape in shapes:
        values = cycle(swinging.amplitude(shape) * shape)
        places = {body.name: positions(drawing, body, names, values) - np.array(body.rest)[:, None] for body in drawing.bodies}
        turns = [
            drawing.turn_scale * sum(np.outer(turn, values[names.index(name)]) for name, turn in body.turns.items())
            for body in drawing.bodies
            if body.turns
        ]
        move = max(np.abs(place).max() for place in places.values())
        linked = [link for link in drawing.links if link.kind != "shaft"]  # a shaft bends
        change = max((np.abs(places[link.end] - places[link.start]).max() for link in linked), default=0.0)
        found.append((move, change, max((np.abs(turn).max() for turn in turns), default=0.0)))
    return drawing, found


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e6])
def test_rack_and_pinion_are_both_seen_whatever_the_units_of_the_shape(tmp_path, size):
    modes = modes_of(tmp_path, RACK.replace("20 mm", f"{0.02 * size:g} m").replace("3 m", f"{3 * size:g} m"))
    (slow_move, _, slow_turn), (fast_move, *_) = drawn(modes)[1]
    assert slow_move > 0.3 and slow_turn > 0.3 and fast_move > 0.3


def test_what_is_not_drawn_makes_nothing_else_move(tmp_path):
    text = MATRICES.replace('"b"]', '"b"]\nunits = { a = "1" }').replace("[[1, 0], [0, 4]]", "[[1, 1e-18], [1e-18, 4]]")
    assert max(move for move, _, _ in drawn(modes_of(tmp_path, text))[1][:1]) < 1e-9


def test_the_page_has_every_line_and_tells_drift_without_motion():
    modes = ModalAnalysis(mb.read_scene(EXAMPLES / "two_masses.toml"))
    drift, slow, fast = modes.shapes().modes
    assert (drift.name, drift.values, drift.shares) == ("drift", None, ()) and "no motion of the bodies" in drift.note
    assert slow.period == pytest.approx(2 * np.pi / modes.lines[1].value.imag)
    assert [row[0] for row in slow.shares] == ["x1", "q1", "q2"]  # 72 % of the strain, 45 % of the kinetic energy, 28 %
    assert (slow.values[:, 0] == slow.values[:, -1]).all() and slow.values.max() == 1.0
    assert dict(fast.facts)["frequency (Hz)"] == "0.115166"


@pytest.mark.parametrize("example", ["pendulum.toml", "four_bar.toml", "satellite.toml"])
def test_robots_swing_visibly_along_their_modes(example):
    modes = ModalAnalysis(mb.read_scene(EXAMPLES / example))
    content = modes.shapes()
    robot, posture = modes.scene.equations.robot, modes.scene.equations.posture
    units = np.array(modes.scene.equations.coordinates.units)
    for picture, line in zip(content.modes, modes.lines):
        assert set(picture.paths) == set(robot.bodies)
        turn = picture.scale * np.abs(line.shape[units == "rad"]).max()
        assert turn <= 0.25 + 1e-12
        poses = robot.poses(posture, picture.scale * picture.values)
        for name, path in picture.paths.items():
            assert np.allclose(path.positions, poses[name].positions, atol=1e-12)
            assert np.allclose(path.positions[:, 0], path.positions[:, -1], atol=1e-12)
        assert turn > 0.02 or max(np.ptp(path.positions, axis=1).max() for path in picture.paths.values()) > 1e-3


@pytest.mark.long
def test_the_page_of_a_robot_lists_its_effective_masses_as_they_are_printed():
    modes = ModalAnalysis(read_scene(EXAMPLES / "seven_joint_arm.toml"))
    printed = modes.effective_masses.table()
    assert ModalAnalysis.solve(modes.scene).page().tables[0] == printed
    assert printed in ModalAnalysis.solve(modes.scene).blocks()
    assert not any(table.title == printed.title for table in ModalAnalysis.solve(read_scene(EXAMPLES / "rotor.toml")).page().tables)
