"""What is drawn over the model of a scene: jumps, impulses and reactions, with the values of the answer."""

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.page.animation import Arrow
from mbconstrained.scene.run.scene import read_scene
from tests.scene.robots import SCENE, press
from tests.scene.scenes import EXAMPLES, MATRICES, OSCILLATOR, scene_of

ARROWS = '[output]\narrows = ["reaction"]\n'
IMPULSE = OSCILLATOR.replace("[time]", '[[force]]\ncoordinate = "cart"\nkind = "impulse"\nvalue = "-3 N*s"\ndelay = "2 s"\n[time]')
HELD = MATRICES.replace(
    "[time]", '[[model.constraint]]\nname = "tie"\nrows = { a = 1, b = -2 }\n[initial]\nvelocity = { a = 1 }\n[time]'
)


def overlay_of(scene):
    return scene.run().animation.overlay


def test_a_run_in_which_nothing_happens_has_none(tmp_path):
    assert not overlay_of(scene_of(tmp_path, OSCILLATOR))


def test_jumps_at_the_start_are_told_and_drawn_from_before_to_after():
    (event,) = overlay_of(read_scene(EXAMPLES / "inconsistent_start.toml")).events
    assert event.lines[0] == "at t = 0 s (faint: just before)"
    assert event.lines[1:] == ("u1 jumps from 1 m to 0.666667 m", "velocity of u2 jumps from 1 m/s to 0 m/s")
    assert (event.time, event.before.tolist(), event.impulses) == (0.0, [1, 1, 2], ())
    assert event.after == pytest.approx([2 / 3, 1, 2])


def test_an_impulse_of_a_force_is_an_arrow_at_its_body_when_it_impulse_arrows(tmp_path):
    (event,) = overlay_of(scene_of(tmp_path, IMPULSE)).events
    assert (event.time, event.impulses) == (2.0, ((Arrow("cart", (1.0, 0.0, 0.0), "N s"), -3.0, "3 N s"),))
    assert event.before.tolist() == event.after.tolist()
    assert event.lines[1].startswith("velocity of cart jumps from ") and event.lines[2] == "δ of -3 N s: force on cart"


def test_an_impulse_of_a_constraint_acts_on_the_bodies_of_its_row(tmp_path):
    (event,) = overlay_of(scene_of(tmp_path, HELD)).events
    sizes = {arrow.body: size for arrow, size, _ in event.impulses}
    assert sizes == pytest.approx({"a": -0.2, "b": 0.4})  # a' from 1 to 4/5, b' from 0 to 2/5
    assert any("force of tie" in line for line in event.lines)


def test_reactions_are_arrows_with_the_values_of_the_answer(tmp_path):
    scene = scene_of(tmp_path, HELD + ARROWS)
    result = scene.run()
    animation = result.animation
    (force,) = animation.overlay.forces
    assert [(arrow.body, arrow.unit, factor) for arrow, factor in force.arrows] == [("a", "N", 1.0), ("b", "N", -2.0)]
    assert force.values == pytest.approx(result.motion.reaction(animation.times)[0])
    assert force.rates == pytest.approx(np.gradient(force.values, animation.times, edge_order=2), abs=0.2)
    assert next(stage for stage in scene.plan().stages if stage.name == "reactions").reason == "arrows in the animation show them"


@pytest.mark.parametrize("scene", [OSCILLATOR, SCENE])
def test_arrows_that_cannot_be_are_refused(tmp_path, scene):
    press(tmp_path)
    with pytest.raises(SceneError, match=r"output\.arrows: found reaction.*there are no constraint rows"):
        scene_of(tmp_path, scene + ARROWS)


def test_a_robot_that_is_scene_tells_what_jumps(tmp_path):
    press(tmp_path)
    scene = SCENE.replace("[time]", '[[force]]\ncoordinate = "j1"\nkind = "impulse"\nvalue = "0.01 N*m*s"\n[time]')
    coordinate = scene_of(tmp_path, SCENE).equations.coordinates.names[0]
    (event,) = overlay_of(scene_of(tmp_path, scene.replace('"j1"', f'"{coordinate}"'))).events
    assert any(line.startswith("angular velocity of") for line in event.lines) and not event.paths
