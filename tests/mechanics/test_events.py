"""Forces that begin, end or have impulses later on a mechanical system: velocities, reactions, energy, notices, by momentum and by hand."""

import numpy as np
import pytest

import mbconstrained as mb

#: Two masses, 1 kg and 3 kg, on one rod.
ROD = mb.MechanicalSystem(
    np.diag([1.0, 3.0]), constraints=[mb.Constraint([1, -1], level="position", names="rod")], names=["a", "b"]
)
IMPULSE = mb.impulse([4.0, 0.0]).delayed(1.0)


def test_a_later_impulse_on_a_rod_is_shared():
    """4 N s on 4 kg: both get 1 m/s, and the rod carries 3 N s, on the second body."""
    motion = ROD.solve(force=IMPULSE)
    (event,) = motion.events
    assert event.jump == pytest.approx(np.array([[0, 0], [1, 1]]), abs=1e-15)
    (load,) = motion.later_constraint_impulses
    assert load.time == 1.0 and load.impulses[0] == pytest.approx([-3.0])
    assert motion.velocity([0.5, 1.0, 2.0]) == pytest.approx(np.array([[0, 1, 1]] * 2))
    assert motion.energy([0.5, 1.5]).total == pytest.approx([0.0, 2.0])
    assert motion.constraint_impulses == () and not motion.jump.any()


def test_the_reaction_follows_a_pulse():
    """1 N on the first body for a while: 1/4 m/s^2, and 3/4 N through the rod."""
    motion = ROD.solve(force=mb.pulse([1.0, 0.0], start=2.0, duration=1.0))
    assert motion.reaction([1.0, 2.0, 2.5, 3.0, 9.0])[0] == pytest.approx([0, -0.75, -0.75, 0, 0], abs=1e-15)
    assert motion.acceleration([1.0, 2.5, 3.0])[0] == pytest.approx([0, 0.25, 0], abs=1e-15)
    assert motion.events == () and motion.later_constraint_impulses == ()


def test_reaction_and_motion_obey_newton_everywhere():
    """M x'' + C x' + K x = f + A^T lambda, held at acceleration level with a record and harmonics that begin later."""
    random = np.random.default_rng(0)
    K = np.array([[5.0, -1, 0], [-1, 4, -2], [0, -2, 3]])
    system = mb.MechanicalSystem(np.diag([1.0, 2, 3]), 0.1 * K, K, [mb.Constraint([1, 1, -1], level="velocity")])
    record = mb.sampled([0.5, 1.0, 1.0, 2.5], random.normal(size=(3, 4)))
    force = record + mb.harmonic([1.0, 0, 2], angular_frequency=3.0).delayed(0.75)
    motion, t = system.solve([1.0, 0, 1], force=force), np.linspace(0, 4, 41)
    held = system.mass @ motion.acceleration(t) + system.damping @ motion.velocity(t) + system.stiffness @ motion(t)
    assert held == pytest.approx(force(t) + system.constraint_matrix.T @ motion.reaction(t), abs=1e-12)
    assert (system.constraint_matrix @ motion.velocity(t))[0] == pytest.approx(0 * t, abs=1e-13)


def test_momentum_is_what_the_force_has_given():
    system = mb.MechanicalSystem(np.diag([1.0, 2.0]), stiffness=[[50.0, -50], [-50, 50]])
    motion = system.solve(force=mb.sampled([1.0, 2.0, 4.0], [[0.0, 6.0, 0.0], [0.0] * 3]) + mb.impulse([0.0, 5.0]).delayed(3.0))
    momentum = np.array([1.0, 2.0]) @ motion.velocity([0.5, 2.0, 3.0, 4.0, 100.0])
    assert momentum == pytest.approx([0.0, 3.0, 3.0 + 4.5 + 5.0, 14.0, 14.0], rel=1e-11, abs=1e-12)  # areas of the record


def test_notices_have_names_units_and_times():
    texts = [notice.text for notice in ROD.solve(force=IMPULSE).notices]
    assert "a: its velocity jumps at t = 1 s by 1 m/s, from 0 m/s to 1 m/s" in texts
    assert 'constraint "rod": its force contains a Dirac impulse of -3 N s at t = 1 s' in texts


@pytest.mark.long
def test_thousands_of_events_are_a_few_lines():
    loads = sum(mb.impulse([1.0, 1.0]).delayed(0.5 * k) for k in range(1, 1001))
    motion = ROD.solve(force=loads)
    later = [notice.text for notice in motion.notices]
    assert len(motion.events) == len(motion.later_constraint_impulses) == 1000
    assert len(later) < 10
    assert "after t = 0 there are 2000 jumps and 1000 impulses in all, at 1000 times from t = 0.5 s to t = 500 s" in later
    assert motion.velocity(1e3) == pytest.approx([500.0, 500.0], rel=1e-12)
