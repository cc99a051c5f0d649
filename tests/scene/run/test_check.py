"""What is told before anything is run: bodies that nothing holds, starts that break a constraint."""

import json

import pytest

from mbconstrained.scene.run.result import start_notices
from tests.scene.scenes import COEFFICIENTS, EXAMPLES, MATRICES, OSCILLATOR, scene_of

LOAD = '[[model.mass]]\nname = "load"\nmass = 1\n'
TIE = '[[model.rigid_tie]]\nname = "rod"\nbetween = ["cart", "load"]\ndistance = "0.3 m"\n'
SPRING = '[[model.spring]]\nbetween = ["cart", "load"]\nstiffness = 1\n'


def with_parts(*parts: str) -> str:
    return OSCILLATOR.replace("[initial]", "".join(parts) + "[initial]")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (OSCILLATOR, []),
        (with_parts(LOAD, SPRING), []),
        (with_parts(LOAD), ["load: unconstrained; it can move freely, a rigid-body mode"]),
        (
            with_parts(LOAD, SPRING).replace('"ground", "cart"', '"load", "cart"'),
            ["cart and load: unconstrained; they can move freely together, a rigid-body mode"],
        ),
        (MATRICES.replace("[[1, 0], [0, 4]]", "[[4, -4], [-4, 4]]"), ["a and b: unconstrained; they can move freely together, a rigid-body mode"]),
        (MATRICES.replace("[[1, 0], [0, 4]]", "[[1e16, -1e16], [-1e16, 1e16]]"), ["a and b: unconstrained; they can move freely together, a rigid-body mode"]),
        (MATRICES.replace("[[1, 0], [0, 4]]", "[[1e16, 0], [0, 4]]"), []),
        (COEFFICIENTS, []),
    ],
)  # fmt: skip
def test_what_nothing_holds_is_a_rigid_body_mode_and_no_error(tmp_path, text, told):
    scene = scene_of(tmp_path, text)
    assert [notice.text for notice in scene.notices if notice.kind == "rigid body"] == told
    if told:
        assert told[0] in [notice.text for notice in scene.run().notices]
        assert any(mode.kind == "rigid body" for mode in scene.equations.system.modes())


def test_a_start_that_breaks_a_constraint_tells_which_by_how_much_and_what_happens(tmp_path):
    told = [notice.text for notice in start_notices(scene_of(tmp_path, with_parts(LOAD, TIE)).equations)]
    assert told[0] == (
        'constraint "rod" (position level) is violated at 0-: its displacement is -0.1 m instead of 0.3 m, '
        "off by -0.4 m; it is enforced at t = 0"
    )
    assert told[1] == "cart: its displacement jumps at t = 0 by -0.133333 m, from 0.1 m to -0.0333333 m"
    assert told[2].startswith("load: its displacement jumps at t = 0 by 0.266667 m")
    assert told[3].startswith('constraint "rod": its force contains the first derivative of a Dirac impulse of ')


def test_equations_that_the_start_breaks_are_told_as_well(tmp_path):
    from mbconstrained.scene.run.scene import read_scene

    told = [notice.text for notice in start_notices(read_scene(EXAMPLES / "rigid_link.toml").equations)]
    assert told[0].startswith(
        'the start does not fit: "equation 3", on the value of "q1" and the value of "q2", does not hold at 0-'
    )
    assert "lambda: its value contains the first derivative of a Dirac impulse of -0.5 N s^2 at t = 0" in told
    assert start_notices(read_scene(EXAMPLES / "two_masses.toml").equations) == ()


def test_check_prints_them(command, tmp_path):
    scene_of(tmp_path, with_parts(LOAD, TIE).replace('"ground", "cart"', '"load", "cart"'))
    code, out, _ = command("check", "scene.toml")
    assert code == 0 and "note (rigid body): cart and load: unconstrained" in out and 'note (jump): constraint "rod"' in out
    assert len(json.loads(command("check", "scene.toml", "--json")[1])["notices"]) >= 3


def test_springs_without_rest_length_are_reported_next_to_some_with_one(tmp_path):
    other = SPRING.replace("stiffness = 1", 'stiffness = 1\nrest_length = "30 cm"')
    scene = scene_of(tmp_path, with_parts(LOAD, other))
    assert [notice.text for notice in scene.notices if notice.kind == "omitted"] == [
        "spring[1]: no rest_length is given, while others have one: 0 m is taken"
    ]
    for text in (
        with_parts(LOAD, SPRING),
        with_parts(LOAD, other).replace('stiffness = "8 N/m"', 'stiffness = "8 N/m"\nrest_length = 0'),
    ):
        assert not [notice for notice in scene_of(tmp_path, text).notices if notice.kind == "omitted"]
