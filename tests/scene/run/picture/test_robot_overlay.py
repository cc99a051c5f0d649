"""Arrows of a robot: reactions and impulses where they act, against forces that pinocchio computes by itself."""

import numpy as np
import pinocchio
import pytest

from mbconstrained.page.animation import Arrow
from mbconstrained.page.content import PageContent
from mbconstrained.page.html import page_html
from mbconstrained.scene.run.scene import read_scene
from tests.scene.build.test_robot_mimic import MIMIC, PLAIN, POSTURE
from tests.scene.robots import ROBOTS, SCENE, press
from tests.scene.scenes import EXAMPLES, scene_of

ARROWS = '[output]\narrows = ["reaction"]\n'


@pytest.fixture(scope="module")
def four_bar():
    """The linkage of the example under an impulsive load at t = 0, and its marks."""
    result = read_scene(EXAMPLES / "four_bar.toml").run()
    return result, result.animation


class Pin:
    """The pin between coupler and rocker at rest, as pinocchio has it: Jacobians of its point on both, and its directions."""

    def __init__(self, configuration):
        self.model = pinocchio.buildModelFromUrdf(str(ROBOTS / "four_bar" / "four_bar.urdf"))
        data = self.model.createData()
        pinocchio.computeJointJacobians(self.model, data, configuration)
        pinocchio.updateFramePlacements(self.model, data)
        self.gravity = pinocchio.computeGeneralizedGravity(self.model, data, configuration)
        self.directions = data.oMf[self.model.getFrameId("coupler")].rotation
        on_rocker, on_coupler = (self._point(data, *end) for end in (("rocker", 0.35), ("coupler", 0.5)))
        self.jacobian = on_rocker - on_coupler

    def _point(self, data, body, along):
        number = self.model.getFrameId(body)
        J = pinocchio.getFrameJacobian(self.model, data, number, pinocchio.ReferenceFrame.LOCAL)
        return data.oMf[number].rotation @ (J[:3] - pinocchio.skew(np.array([along, 0, 0])) @ J[3:])


def test_the_arrow_at_a_loop_is_the_force_that_moves_the_links_and_carries_them_at_rest(four_bar):
    result, animation = four_bar
    (force,) = animation.overlay.forces
    ((arrow, factor),) = force.arrows
    assert (arrow.body, arrow.direction, arrow.point, arrow.unit, factor) == ("coupler", None, (0.5, 0.0, 0.0), "N", 1.0)
    system, motion, times = result.system, result.motion, animation.times
    posture = result.scene.equations.posture
    pin = Pin(posture.configuration)
    at_rest = posture.reactions["coupler pin"][:3]
    change = pin.jacobian.T @ pin.directions @ (force.values - at_rest[:, None])
    moved = system.mass @ motion.acceleration(times) + system.damping @ motion.velocity(times) + system.stiffness @ motion(times)
    assert change == pytest.approx(moved, abs=1e-11 * np.abs(moved).max())  # the impulsive load is over
    spring = np.array([20 * (posture["crank pivot"] - np.radians(75)), 0, 0])
    assert pin.jacobian.T @ pin.directions @ at_rest == pytest.approx(pin.gravity + spring, abs=1e-9 * np.abs(spring).max())
    slopes = np.gradient(force.values, times, axis=1, edge_order=2)
    assert force.rates[:, 50:-50] == pytest.approx(slopes[:, 50:-50], abs=0.02 * np.abs(slopes).max())


def test_an_impulse_and_the_one_of_the_loop_change_all_momenta(four_bar):
    result, animation = four_bar
    (event,) = animation.overlay.events
    (pin_arrow, impulse, told), (load, size, told_load) = event.impulses
    pin = Pin(result.scene.equations.posture.configuration)
    moved = result.system.mass @ (result.motion.start[1] - result.motion.initial[1])
    assert pin.jacobian.T @ pin.directions @ impulse + [0.02, 0, 0] == pytest.approx(moved, abs=1e-12)
    assert (pin_arrow.body, told) == ("coupler", f"{np.linalg.norm(impulse):.3g} N s")
    assert (load.body, load.turns, load.point, told_load) == ("crank", True, (0, 0, 0), "0.02 N m s")
    assert size == pytest.approx([0, -0.02, 0])  # in the crank's frame, whose joint turns about -y


def test_the_legend_says_what_is_drawn(four_bar):
    animation = four_bar[1]
    assert animation.overlay.description == "reactions on rocker, the load at rest included"
    assert f"arrows: {animation.overlay.description}, longest arrow 4.12 N" in page_html(PageContent("t", animation=animation))


def test_an_impulse_on_a_point_is_an_arrow_there_in_its_own_direction():
    (event,) = read_scene(EXAMPLES / "seven_joint_arm.toml").run().animation.overlay.events
    assert event.impulses == ((Arrow("tool", (0.0, 1.0, 0.0), "N s", False, (0.0, 0.0, 0.08)), 0.5, "0.5 N s"),)


def test_later_impulsive_loads_on_one_input_count_together(tmp_path):
    press(tmp_path)
    load = '[[force]]\ncoordinate = "slide"\nkind = "impulse"\nvalue = "{} N*s"\ndelay = "0.5 s"\n'.format
    scene = SCENE.replace("[time]", f"{load(2)}{load(-5)}[time]")
    (event,) = scene_of(tmp_path, scene).run().animation.overlay.events
    ((arrow, size, told),) = event.impulses
    assert (event.time, arrow.body, arrow.turns, told) == (0.5, "ram", False, "3 N s")
    assert size == pytest.approx([0, 0, -3]) and "δ of -3 N s: force on slide" in event.lines


def test_a_joint_that_follows_has_a_force_and_the_joint_it_follows_a_moment(tmp_path):
    press(tmp_path, PLAIN + POSTURE, MIMIC)
    scene = scene_of(tmp_path, SCENE.replace("displacement", "follow = true\ndisplacement") + ARROWS)
    result = scene.run()
    forces = {force.name: force for force in result.animation.overlay.forces}
    assert list(forces) == ["slide follows pivot on ram", "slide follows pivot on crank, moment"]
    whole = result.scene.equations.posture.multipliers[0] + result.motion.reaction(result.animation.times)[0]
    push, turn = forces.values()
    assert push.values == pytest.approx(np.outer([0, 0, 1], whole)) and push.arrows[0][0].unit == "N"
    assert turn.values == pytest.approx(np.outer([0, 0.1, 0], whole)) and turn.arrows[0][0].unit == "N m"  # -0.1 about -y
