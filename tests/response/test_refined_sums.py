"""Sums of refined modes at many radians: their values at even and uneven times, and the exponentials that quantities have in common."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.tolerances import EPS, PROVED_ACCURACY
from mbconstrained.response.methods.proved import MANY_RADIANS

TIMES = np.linspace(0.0, 300.0, 201)[1:]  # at 0 velocities are zero


def chain(count: int, damping: float) -> mb.MechanicalSystem:
    """Masses between two walls, with dampers that the modes do not decouple."""
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    C = damping * (K + np.diag(np.arange(count)))
    return mb.MechanicalSystem(np.diag(1 + 0.2 * np.cos(1.7 * np.arange(count))), C, K)


def own_errors(motion: mb.Motion, times: np.ndarray, order: int) -> np.ndarray:
    """Errors relative to the largest coordinate at each time, against the exact engine."""
    function = motion.derivative(order) if order else motion.function
    exact, _ = function.proved(times)
    return np.abs(function(times) - exact).max(axis=0) / np.abs(exact).max(axis=0)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("damping", [0.0, 1e-3, 0.05])
def test_values_are_right_relative_to_their_own_size(damping, order):
    motion = chain(4, damping).solve(np.eye(4)[1])
    assert motion.method.flow.modal_rate * TIMES[-1] > MANY_RADIANS
    assert own_errors(motion, TIMES, order).max() <= PROVED_ACCURACY


def test_even_times_may_be_rounded_in_any_way():
    """Phases belong to the times as they are, not to the even ones that they are near."""
    motion = chain(3, 1e-3).solve(np.eye(3)[0])
    moved = TIMES * (1 + EPS * np.random.default_rng(1).integers(-1, 2, len(TIMES)))
    assert (moved != TIMES).any() and own_errors(motion, moved, 0).max() <= PROVED_ACCURACY
    assert not np.array_equal(motion(moved), motion(TIMES))


def test_forces_and_uneven_times():
    force = mb.harmonic([0.0, 1.0, 0.0], angular_frequency=0.7) + mb.step([1.0, 0.0, 0.0])
    motion = chain(3, 1e-2).solve(force=force)
    assert own_errors(motion, np.sort(np.random.default_rng(2).uniform(1.0, 300.0, 150)), 0).max() <= PROVED_ACCURACY


def test_values_do_not_depend_on_what_was_evaluated_before():
    alone = [getattr(chain(3, 1e-3).solve(np.eye(3)[0]), name)(TIMES) for name in ("displacement", "velocity", "acceleration")]
    motion = chain(3, 1e-3).solve(np.eye(3)[0])
    motion.velocity(0.9 * TIMES)
    again = [getattr(motion, name)(TIMES) for name in ("acceleration", "displacement", "velocity", "acceleration")][1:]
    assert all(np.array_equal(one, other) for one, other in zip(alone, again))


def test_pairs_that_do_not_separate_leave_the_values_to_another_method():
    """Combinations of pairs next to a rate of 1e10 / s once gave poles on the other side of the real axis; values by the exact engine."""
    model = mb.LumpedModel()
    model.mass("a", 1.1060656003856389e4)
    model.mass("b", 2.5e-6)
    model.mass("c", 3.8772246485002379e3)
    model.damper("ground", "b", 1.9e5)
    model.damper("b", "c", 1.7e-5)
    for number, stiffness in enumerate([16.9, 5.6, 13998.0]):
        model.spring("b", "c", stiffness, name=f"spring {number}")
    model.spring("a", "c", 0.027)
    motion, times = model.assemble().solve([0.0, 0.0, 1.0]), np.array([1.0, 30.0])
    assert np.abs(motion(times) - motion.enclose(times).middle).max() <= PROVED_ACCURACY


def test_a_velocity_at_the_start_follows_the_force_where_there_is_no_mass():
    """4 x' + 2 x = -0.5 starts with x' = -0.125 at x = 0, next to a free mass and one of many radians, which start at rest."""
    system = mb.MechanicalSystem(np.diag([0.0, 1.0, 1.0]), np.diag([4.0, 0.0, 1.0]), np.diag([2.0, 16.0, 0.0]))
    motion = system.solve(force=mb.step([-0.5, 1.0, 1.0]))
    assert motion.velocity([0.0, 1.0, 40.0])[:, 0].tolist() == [-0.125, 0.0, 0.0]
    assert motion([0.0, 1.0, 40.0])[:, 0].tolist() == [0.0, 0.0, 0.0]
