"""Switched motions against time stepping: Moreau's with impacts, rest and friction, and scipy's with located events at rtol 1e-12."""

import numpy as np
import pytest
import scipy

from tests.mechanics.switched.stepping import Machine, random_machine

EPS = np.finfo(float).eps


@pytest.mark.parametrize("seed", [2, 10, 17, 26])
def test_moreau_stepping_converges_to_the_motion(seed):
    machine, x0, v0 = random_machine(seed)
    x = machine.solve(x0, v0, 2.0)
    fastest = np.abs(x.velocity(np.linspace(0.0, 2.0, 400))).max()
    for count in (250, 2500):  # of first order: events are late by up to a step
        assert np.abs(machine.step(x0, v0, 2.0, count) - x(2.0)).max() <= 4 * fastest * 2.0 / count


@pytest.mark.parametrize("seed", range(20))
def test_laws_hold_through_all_events(seed):
    # no penetration, momentum balanced, no energy from nothing, stops that push only, friction within its bounds
    machine, x0, v0 = random_machine(1000 + seed)
    x = machine.solve(x0, v0, 1.5)
    t = np.linspace(0.0, 1.5, 1501)
    X, forces = x(t), x.reaction(t)
    size = np.abs(X).max()
    assert all((row @ X + gap).min() >= -200 * EPS * (size + gap) for row, gap, _ in machine.contacts)
    names = [row.name for row in x._reaction_rows]
    for name, force in zip(names, forces):
        scale = np.abs(forces).max() + 1
        if name.startswith("contact"):
            assert force.min() >= -1e-11 * scale
        else:
            limit = next(limit for row, limit in machine.frictions if name == f"dry friction ground-m{np.argmax(row)}")
            assert np.abs(force).max() <= limit + 1e-11 * scale
    for event in x.events:
        assert event.momentum_residual <= 1e-11
        assert event.energy_lost >= -1e-11 * (abs(event.energy_before) + abs(event.energy_after) + 1)
        assert all(impulse >= 0 for name, impulse in event.impulses.items())


def integrated(machine: Machine, x0, v0, end):
    """Times of impacts and the last state by scipy's integrator with events."""
    M, C, K = machine.matrices()
    n, first = len(M), np.eye(len(M))[0] * machine.force[0]
    inverse, weight = np.linalg.inv(M), -machine.gravity * np.diag(M)

    def rate(t, z):
        load = weight + first * np.cos(machine.force[1] * t) - C @ z[n:] - K @ z[:n]
        return np.r_[z[n:], inverse @ load]

    guards = []
    for row, gap, _ in machine.contacts:

        def guard(t, z, row=row, gap=gap):
            return row @ z[:n] + gap

        guard.terminal, guard.direction = True, -1.0
        guards.append(guard)
    t, z, times = 0.0, np.r_[x0, v0], []
    while t < end:
        result = scipy.integrate.solve_ivp(rate, (t, end), z, "DOP853", events=guards, rtol=1e-12, atol=1e-14, max_step=0.02)
        t, z = result.t[-1], result.y[:, -1].copy()
        for (row, _, e), found in zip(machine.contacts, result.t_events):
            if len(found):
                times.append(t)
                z[n:] -= inverse @ row * (1 + e) * (row @ z[n:]) / (row @ inverse @ row)
    return np.array(times), z[:n]


@pytest.mark.parametrize("seed", range(4))
def test_impacts_against_scipy_events(seed):
    r = np.random.default_rng(seed)
    n = int(r.integers(1, 5))
    eye = np.eye(n)
    machine = Machine(list(r.uniform(0.5, 3.0, n)), force=(float(r.uniform(0, 10)), float(r.uniform(1, 8))))
    machine.springs = [(i, i - 1 if i else None, float(r.uniform(20, 80)), 0.1) for i in range(n)]
    machine.contacts = [(row, float(r.uniform(0.1, 0.3)), 0.9) for row in (eye[0], -eye[n - 1])]
    x0, v0 = np.zeros(n), 2 * r.normal(size=n)
    x = machine.solve(x0, v0, 2.0)
    times, last = integrated(machine, x0, v0, 2.0)
    own = np.array([event.time for event in x.events])
    assert len(own) == len(times) and len(own) >= 1
    assert np.allclose(own, times, rtol=0, atol=1e-9) and np.allclose(x(2.0), last, rtol=0, atol=1e-8)
