"""Rigid feet of a block that is shaken sideways: by weight and moment balance it tips at a = g b / h and slips at a = mu g."""

import re

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.robot.linearized import foot_notices
from tests.robot.linkages import link, urdf

MASS, HEIGHT, G = 4.0, 0.3, 9.81
HALF = {"x": 0.1, "y": 0.05}

#: d'Alembert's force on the centre of mass grows by this acceleration in a second.
RATE = 2.0
TIMES = np.linspace(0.0, 5.0, 501)


def shaken(loops, axis: str) -> list[str]:
    """The texts of the notices on a block whose acceleration to the side grows as RATE t."""
    box = mb.Robot(urdf(link("box", MASS, (0, 0, HEIGHT), (0.1, 0.2, 0.3))), base="free", loops=loops)
    posture = box.equilibrium()
    along = (1, 0, 0) if axis == "x" else (0, 1, 0)
    system = box.linearize(posture, inputs={"inertia": mb.PointMotion("box", (0, 0, HEIGHT), along=along)})
    motion = system.solve(force=system.input_force({"inertia": mb.ramp([MASS * RATE])}))
    reactions, forces = motion.reaction(TIMES), system.connection_forces
    values = forces.values(motion.displacement(TIMES), motion.velocity(TIMES), reactions)
    by_row = dict(zip((row.name for row in system.rows), reactions))
    return [notice.text for notice in foot_notices(posture, forces, TIMES, values, by_row, motion.error_estimate(TIMES))]


def first(text: str) -> float:
    return float(re.search(r"first at ([0-9.]+) s", text)[1])


def following(acceleration: float) -> float:
    """The first of the times at which the block is accelerated more."""
    return TIMES[TIMES > acceleration / RATE][0]


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize(("turned", "mu"), [((0.0, 0.0, 0.0), 0.6), ((np.pi, 0.0, 0.0), 0.6), ((0.0, 0.0, 0.0), 0.15)])
def test_a_block_on_a_sole_tips_and_slips_whichever_is_first(axis, turned, mu):
    """Weight and moment: tan of the apparent weight is a / g, b / h at the edge and mu at the cone."""
    patch = tuple(2 * HALF[key] for key in "xy")
    options = {"kind": "rigid", "friction": mu, "patch": patch, "rotation1": turned}
    slips, tips = shaken([mb.Loop("ground", None, "box", (0, 0, 0), name="sole", **options)], axis)
    assert "the foot slips" in slips and first(slips) == pytest.approx(following(mu * G))
    assert "the foot tips over" in tips and first(tips) == pytest.approx(following(G * HALF[axis] / HEIGHT))
    assert f"m along {axis} from its point" in tips and f"the sole ends at {HALF[axis]:.3g} m" in tips
    assert f"{MASS * RATE * TIMES[-1]:.4g} N along the ground at a normal force of {MASS * G:.4g} N" in slips


def test_a_block_in_place_is_no_alarm():
    limit = RATE * TIMES[-1]
    patch = (2.002 * HEIGHT * limit / G, 0.1)
    sole = mb.Loop("ground", None, "box", (0, 0, 0), kind="rigid", friction=1.001 * limit / G, patch=patch)
    assert shaken([sole], "x") == []


def four_points(friction: float) -> list[mb.Loop]:
    """Twelve rows for six motions: how the feet share the load is not determined."""
    return [
        mb.Loop("ground", None, "box", (x, y, 0), friction=friction, name=f"foot {x} {y}")
        for x in (-HALF["x"], HALF["x"])
        for y in (-HALF["y"], HALF["y"])
    ]


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.2, 0.25])
def test_a_block_on_four_feet_slips_where_no_share_of_the_load_keeps_it(friction):
    """Whatever the rows that were left out: all friction together is mu m g; the pyramid in the cone lacks 0.2 % of it."""
    (slips,) = [text for text in shaken(four_points(friction), "x") if "slip" in text]
    assert following(0.998 * friction * G) <= first(slips) <= following(friction * G)
    at = float(re.search(r"at t = ([0-9.]+) s", slips)[1])
    lacking = (RATE * at - friction * G) * MASS / 4
    assert float(re.search(r"lacks ([0-9.]+) N", slips)[1]) == pytest.approx(lacking, abs=2e-3 * friction * MASS * G)


@pytest.mark.long
def test_a_block_on_four_feet_lifts_off_where_it_would_tip():
    texts = shaken(four_points(5.0), "x")
    (lifts,) = [text for text in texts if "lift" in text]
    assert first(lifts) == pytest.approx(following(G * HALF["x"] / HEIGHT))
    pull = MASS * (RATE * TIMES[-1] * HEIGHT - G * HALF["x"]) / (4 * HALF["x"])  # of each of two feet
    assert f"pull at one of them by {pull:.4g} N at least" in lifts
