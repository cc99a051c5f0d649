"""Impacts: the complementarity problem against enumeration in exact fractions, and the law of restitution in chains of balls."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import NotUnique
from mbconstrained.mechanics.switched.phase import complementary

EPS = np.finfo(float).eps
ONE = Fraction(1)


def solved(A, b):
    """The solution of A x = b in fractions; None where it is not unique."""
    rows, n = [[*row, right] for row, right in zip(A, b)], len(b)
    for i in range(n):
        pivot = next((k for k in range(i, n) if rows[k][i]), None)
        if pivot is None:
            return None
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [own / rows[i][i] for own in rows[i]]
        for k in range(n):
            if k != i:
                rows[k] = [own - rows[k][i] * other for own, other in zip(rows[k], rows[i])]
    return [row[-1] for row in rows]


def enumerated(W, q):
    """All z >= 0 with W z + q >= 0 and complementary, by all active sets."""
    k, found = len(q), []
    for active in product((False, True), repeat=k):
        own = [i for i in range(k) if active[i]]
        part = solved([[W[i][j] for j in own] for i in own], [-q[i] for i in own])
        if part is None:
            continue
        z = [Fraction(0)] * k
        for i, value in zip(own, part):
            z[i] = value
        w = [sum(W[i][j] * z[j] for j in range(k)) + q[i] for i in range(k)]
        if min(z, default=0) >= 0 and min(w, default=0) >= 0 and z not in found:
            found.append(z)
    return found


def test_lemke_finds_the_solution_of_all_active_sets():
    r = np.random.default_rng(3)
    for _ in range(300):
        k, n = r.integers(1, 6), 6
        A = r.integers(-3, 4, (k, n))
        m = r.integers(1, 9, n)
        W = [[sum(ONE * int(A[i, c]) * int(A[j, c]) / int(m[c]) for c in range(n)) for j in range(k)] for i in range(k)]
        v = r.integers(-4, 5, n)
        q = [Fraction(int(own)) for own in A @ v]  # consistent: velocities of one motion
        exact = enumerated(W, q)
        z = complementary(np.array(W, float), np.array(q, float))
        # the velocities after it are unique, the impulses are where the contacts are independent
        velocity = [[sum(W[i][j] * one[j] for j in range(k)) for i in range(k)] for one in exact]
        size = max(1.0, float(max(map(abs, (own for one in exact for own in one)), default=1.0))) * 20
        assert exact and all(one == velocity[0] for one in velocity)
        assert np.allclose(np.array(W, float) @ z, np.array(velocity[0], float), rtol=0, atol=2000 * EPS * size)
        if len(exact) == 1:
            assert np.allclose(z, np.array(exact[0], float), rtol=0, atol=2e5 * EPS * size)


def test_contradictory_contacts_have_no_solution():
    with pytest.raises(NotUnique, match="press against each other"):
        complementary(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.array([1.0, -2.0]))


def balls(masses, gaps, restitution, velocity, gravity=0.0, end=2.0):
    model = mb.LumpedModel()
    for i, mass in enumerate(masses):
        model.mass(f"b{i}", mass)
    for i, gap in enumerate(gaps):
        model.contact(f"b{i}", f"b{i + 1}", gap=gap, restitution=restitution)
    if gravity:
        model.gravity(gravity)
    return model.assemble().solve(velocity=velocity, end=end)


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_cradle_of_touching_balls(e):
    # w = u+ + e u- of the contacts is zero: v1 - v0 = e v, v2 = v1, momentum m v
    v0 = np.array([1.0, 0.0, 0.0])
    x = balls([1.0] * 3, [0.25, 0.0], e, v0)
    after = x.velocity(1.0)
    assert len(x.events) == 1 and np.allclose(after, [1 / 3 - 2 * e / 3, (1 + e) / 3, (1 + e) / 3], rtol=0, atol=8 * EPS)
    event = x.events[0]
    assert np.isclose(event.time, 0.25, rtol=0, atol=4 * EPS)
    assert np.isclose(event.impulses["contact b0-b1"], 2 * (1 + e) / 3, rtol=16 * EPS)
    assert np.isclose(event.impulses["contact b1-b2"], (1 + e) / 3, rtol=16 * EPS)
    assert np.isclose(event.energy_lost, 0.5 - after @ after / 2, rtol=0, atol=8 * EPS) and event.momentum_residual < 16 * EPS


def test_cradle_of_balls_with_gaps():
    # one after the other: the last ball leaves with the velocity of the first
    x = balls([1.0] * 10, [0.01] * 9, 1.0, np.eye(10)[0])
    assert len(x.events) == 9 and np.allclose(x.velocity(1.0), np.eye(10)[9], rtol=0, atol=32 * EPS)
    assert np.allclose([event.time for event in x.events], 0.01 * np.arange(1, 10), rtol=32 * EPS)


def test_chain_of_ten_touching_balls_without_rebound():
    x = balls([1.0] * 10, [0.5] + [0.0] * 8, 0.0, np.eye(10)[0])
    assert np.allclose(x.velocity(1.0), 0.1, rtol=0, atol=16 * EPS)
    assert np.allclose([x.events[0].impulses[f"contact b{i}-b{i + 1}"] for i in range(9)], 0.1 * np.arange(9, 0, -1), rtol=64 * EPS)


def test_dependent_contacts_are_reported():
    model = mb.LumpedModel()
    model.mass("a", 2.0)
    model.gravity(-10.0)
    model.contact("ground", "a", name="left", restitution=0.5)
    model.contact("ground", "a", name="right", restitution=0.5)
    x = model.assemble().solve({"a": 5.0}, end=1.2)
    assert np.isclose(sum(x.events[0].impulses.values()), 2.0 * 1.5 * 10.0, rtol=16 * EPS)
    assert any("depend on each other" in notice.text for notice in x.notices)


def test_friction_passes_on_no_impulse():
    # the struck block has all the momentum, though it stuck; then it slides to rest after v^2 / (2 mu g)
    model = mb.LumpedModel()
    model.mass("a", 1.0), model.mass("b", 1.0), model.mass("c", 1.0)
    model.contact("a", "b", gap=0.5, restitution=1.0)
    model.contact("b", "c", gap=9.0)
    for name in "bc":
        model.dry_friction("ground", name, normal_force=1.0, coefficient=0.5)
    x = model.assemble().solve(velocity={"a": 1.0}, end=5.0)
    strike, rest = x.events
    assert strike.impulses == pytest.approx({"contact a-b": 1.0}, rel=16 * EPS)
    assert np.isclose(rest.time, 0.5 + 2.0, rtol=16 * EPS) and np.allclose(x(5.0), [0.5, 1.0, 0.0], rtol=0, atol=16 * EPS)


def test_zero_play_on_both_sides_comes_to_rest():
    for other in (0.5, 0.2):
        model = mb.LumpedModel()
        model.mass("a", 1.0)
        model.contact("ground", "a", name="low", restitution=0.5)
        model.contact("a", "ground", name="high", restitution=other)
        x = model.assemble().solve(velocity={"a": 1.0}, force=mb.harmonic([3.0], angular_frequency=5.0), end=2.0)
        assert not x(np.linspace(0.0, 2.0, 50)).any() and x.events[0].time == 0
        assert np.isclose(x.events[0].impulses.get("low", 0.0) - x.events[0].impulses["high"], -1.0, rtol=8 * EPS)
        assert any("without rebound" in notice.text for notice in x.notices)
