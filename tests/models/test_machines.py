"""Small machines whose motion and reactions follow by hand."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.models.lumped import LumpedModel
from tests.mechanics.systems import assert_same

G = 9.81
TIMES = np.array([0.0, 0.4, 1.0, 3.0])


def test_atwood():
    # a = g (m2 - m1)/(m1 + m2) for the lighter mass upwards, tension 2 m1 m2 g/(m1 + m2)
    m1, m2, length = 2.0, 3.0, 1.5
    model = LumpedModel()
    model.mass("light", m1)
    model.mass("heavy", m2)
    model.pulley("light", "heavy", length=length)
    model.gravity(-G)
    motion = model.assemble().solve({"light": -1.0, "heavy": -0.5})
    rise = G * (m2 - m1) / (m1 + m2) * TIMES**2 / 2
    assert np.allclose(motion(TIMES), [-1.0 + rise, -0.5 - rise])
    assert np.allclose(motion.reaction(TIMES), 2 * m1 * m2 * G / (m1 + m2))
    assert not motion.jump.any()


def test_atwood_pulled_taut():
    # the heavy mass falls at 2 m/s when the rope goes taut
    m1, m2 = 1.0, 3.0
    model = LumpedModel()
    model.mass("light", m1)
    model.mass("heavy", m2)
    model.pulley("light", "heavy")
    motion = model.assemble().solve(None, {"heavy": -2.0})
    # momentum along the rope: both go on with m2 v/(m1 + m2) = 1.5 m/s, the rope takes m1 1.5 N s
    assert np.allclose(motion.start[1], [1.5, -1.5])
    assert_same(motion.constraint_impulses, [[1.5]])


def test_a_moving_pulley_halves_the_force():
    # a rope from the ceiling around the block and up to a hand: the hand at rest holds half the weight of the block
    model = LumpedModel()
    model.mass("block", 8.0)
    model.node("hand")
    model.pulley("ground", "hand", over="block", name="rope")
    model.constrain({"hand": 1.0}, name="grip")
    model.gravity(-G)
    system = model.assemble()
    motion = system.solve()
    tension = dict(zip((row.name for row in system.rows), motion.reaction(1.0)))
    # the ends are above the pulley: the multiplier is minus the tension
    assert tension["rope"] == pytest.approx(-8.0 * G / 2)
    assert tension["grip"] == pytest.approx(8.0 * G / 2)
    assert np.allclose(motion(TIMES), 0.0)


def test_gear_train():
    # motor torque T on the first of three shafts: ratios n1 = q1'/q2' and n2 = q2'/q3', reduced inertia of the motor
    # J1 + J2/n1^2 + J3/(n1 n2)^2, gears turn against each other
    J1, J2, J3, torque = 0.2, 1.0, 30.0, 5.0
    n1, n2 = 40 / 20, 60 / 15
    model = LumpedModel()
    for name, inertia in (("motor", J1), ("middle", J2), ("drum", J3)):
        model.inertia(name, inertia)
    model.gear("motor", "middle", start_radius=20, end_radius=40, name="first stage")
    model.gear("middle", "drum", start_radius=15, end_radius=60, name="second stage")
    model.force("motor", mb.step([torque]))
    motion = model.assemble().solve()
    alpha = torque / (J1 + J2 / n1**2 + J3 / (n1 * n2) ** 2)
    turn = alpha * TIMES**2 / 2
    assert np.allclose(motion(TIMES), [turn, -turn / n1, turn / n1 / n2])
    # torque on the first shaft of each stage: J1 alpha = T + lambda1, and n2 lambda2 = J3 alpha/(n1 n2) drives the drum
    assert np.allclose(motion.reaction(1.0), [J1 * alpha - torque, J3 * alpha / (n1 * n2) / n2])


def test_rack_and_pinion():
    # m x'' = F - J x''/r^2 at the rim
    m, J, r, force = 4.0, 0.5, 0.25, 36.0
    model = LumpedModel()
    model.inertia("pinion", J)
    model.mass("rack", m)
    model.rack("pinion", "rack", radius=r)
    motion = model.assemble().solve(force={"rack": force})
    a = force / (m + J / r**2)
    assert np.allclose(motion.acceleration(1.0), [a / r, a])
    assert np.allclose(motion.reaction(1.0), m * a - force)  # force on the rack


def test_lever_balances():
    # arms 1 : 3, weights 3 : 1 are in balance; the pivot force on the start is its weight
    model = LumpedModel()
    model.mass("short", 3.0)
    model.mass("long", 1.0)
    model.lever("short", "long", start_arm=1.0, end_arm=3.0)
    model.gravity(-G)
    motion = model.assemble().solve()
    assert np.allclose(motion(TIMES), 0.0, atol=1e-12)
    assert np.allclose(motion.reaction(TIMES), 3.0 * G)


def test_a_stiff_spring_approaches_the_tie():
    # theorem: the motion with a spring of stiffness k tends to that with the tie as 1/k
    def pair(join):
        model = LumpedModel()
        model.mass("a", 1.0)
        model.mass("b", 2.0)
        model.spring("ground", "a", stiffness=3.0)
        join(model)
        return model.assemble().solve([1.0, 1.0])(TIMES)

    tied = pair(lambda model: model.rigid_tie("a", "b"))
    gaps = [np.abs(pair(lambda model: model.spring("a", "b", stiffness=k)) - tied).max() for k in (1e4, 1e6)]
    assert 50 < gaps[0] / gaps[1] < 200
