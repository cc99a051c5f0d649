"""What happens at t = 0: notices with units that say what the tables say, and the page's one sentence about them."""

import re

from mbconstrained.ground.notices import Notice
from mbconstrained.scene.run.result import folded
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, OSCILLATOR, scene_of

LINK = EXAMPLES / "rigid_link.toml"


def texts(result, kind):
    return [notice.text for notice in result.notices if notice.kind == kind]


def test_notices_and_tables_give_the_same_numbers():
    result = read_scene(LINK).run()
    summary = result.summary()
    for notice in result.notices:
        if notice.kind in ("jump", "impulse"):
            for value in re.findall(r"-?[\d.]+ (?:m|N s\^2)(?![\w])", notice.text):
                assert re.search(rf" {re.escape(value)}(?:  |\n)", summary), value


def test_the_page_keeps_why_a_mechanical_start_is_changed(tmp_path):
    text = (EXAMPLES / "two_masses_position.toml").read_text("utf-8")
    result = scene_of(tmp_path, text.replace("[initial]\n", "[initial]\n#", 1).replace("points = 1001", "points = 5")).run()
    page = [notice.text for notice in result.page().notices]
    assert any("is violated at 0-" in text for text in page)
    assert any(text.startswith("At t = 0 there ") for text in page)
    assert not any("its displacement jumps" in text for text in page) and len(texts(result, "jump")) > 1


def test_nothing_is_said_where_nothing_happens():
    drift = Notice("drift", "moves on")
    assert folded((drift,), 0, 0) == (drift,)
    assert [notice.text for notice in folded((), 1, 0)] == ["At t = 0 there is 1 jump; the tables give the sizes"]
    assert [notice.kind for notice in folded((), 0, 2)] == ["impulse"]


def test_a_forgotten_start_is_told(tmp_path):
    forgotten = OSCILLATOR.replace("cart = 0.1", "cart = 0")
    assert [str(notice) for notice in scene_of(tmp_path, forgotten).run().notices] == [
        "note (at rest): nothing moves: zero initial conditions and no excitation"
    ]
    assert scene_of(tmp_path, OSCILLATOR).run().notices == ()
