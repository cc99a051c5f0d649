"""Dirac impulses on large models: velocities of masses and places of dampers jump, against exponentials and closed forms."""

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.response.choose import MODES, PAIRS
from mbconstrained.response.methods.reduced_solution import ReducedSolution

from .chains import chain, first_order
from .plain_models import plain_system

COUNT = 30


@pytest.mark.parametrize("steady", [False, True], ids=["impulses alone", "with a step and a late ramp"])
def test_impulses_make_velocities_jump(steady):
    """Between two impulses the motion is that of the exponential of [[S, b], [0, 0]], from the velocities after the jump."""
    random, A = np.random.default_rng(0), chain()
    start, first, second, load = random.normal(size=(2, COUNT)), *random.normal(size=(3, COUNT))
    force, mass = mb.impulse(first) + mb.impulse(second).delayed(1.5), A.coefficients[2].diagonal()
    x = mb.solve(A, start, force + mb.step(load) + mb.ramp(load).delayed(1.5) if steady else force)
    assert isinstance(x.solution, ReducedSolution) and x.impulses == ()
    G = np.zeros((2 * COUNT + 2, 2 * COUNT + 2))
    G[: 2 * COUNT, : 2 * COUNT], G[COUNT : 2 * COUNT, 2 * COUNT], G[2 * COUNT, -1] = first_order(A), load / mass, 1.0
    state = np.concatenate([start[0], start[1] + first / mass, [float(steady), 0.0]])
    before = scipy.linalg.expm(1.5 * G) @ state
    after = before + np.concatenate([np.zeros(COUNT), second / mass, [0.0, float(steady)]])
    expected = np.array([scipy.linalg.expm(0.7 * G) @ state, before, after, scipy.linalg.expm(2.5 * G) @ after])
    size = np.abs(expected[:, : 2 * COUNT]).max()
    times = [0.7, 1.5, 4.0]
    assert x(times).T == pytest.approx(expected[[0, 1, 3], :COUNT], abs=1e-13 * size)
    assert x.derivative()(times).T == pytest.approx(expected[[0, 2, 3], COUNT : 2 * COUNT], abs=1e-13 * size)
    assert x.jump[1] == pytest.approx(first / mass, rel=1e-14, abs=1e-14)
    (event,) = x.events
    assert event.time == 1.5 and event.jump[1] == pytest.approx(second / mass, rel=1e-13, abs=1e-13)
    assert not x.jump[0].any() and not event.jump[0].any()


@pytest.mark.parametrize("kind", ["chain", "tree", "grid"])
def test_massless_and_damped_nodes_move_as_by_the_pairs(kind):
    """Impulses on masses and dampers; equal jumps and values by the Jordan pairs, which another decomposition gives."""
    A = plain_system(kind, seed=4, damped=6, static=4, damping="some").polynomial_matrix()
    loaded = abs(A.coefficients[1]).sum(axis=0) + abs(A.coefficients[2]).sum(axis=0) > 0
    random = np.random.default_rng(1)
    force = mb.impulse(loaded * random.normal(size=A.size)) + mb.impulse(loaded * random.normal(size=A.size)).delayed(0.75)
    x, y = mb.solve(A, force=force), mb.solve(A, force=force, rank_tolerance=1e-13)
    assert (x.method.name, y.method.name) == (MODES, PAIRS)
    times = np.array([0.0, 0.3, 0.75, 2.0, 9.0])
    for order in (0, 1):
        values, others = x.derivative(order)(times), y.derivative(order)(times)
        assert values == pytest.approx(others, abs=2e-12 * np.abs(others).max())
    for event, other in zip((x, *x.events), (y, *y.events), strict=True):
        assert event.jump == pytest.approx(other.jump, abs=1e-12 * np.abs(other.jump).max())
    assert all(x.error_estimate(time) < 1e-11 for time in times[1:])


@pytest.mark.parametrize("support", [2.0**-47, 2.0**-51])
def test_an_impulse_moves_a_softly_supported_chain_as_a_whole(support):
    """x = sin(w t) / w, w^2 the support of each mass: the springs between the masses stay as long as they are."""
    K = np.diag(np.r_[1.0, 2 * np.ones(COUNT - 2), 1.0]) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1) + support * np.eye(COUNT)
    system = mb.MechanicalSystem(mass=np.eye(COUNT), stiffness=K)
    x, times = system.solve(force=mb.impulse(np.ones(COUNT))), np.array([1.0, 1e3, 1e6, 1e7])
    exact = np.sin(support**0.5 * times) / support**0.5
    assert np.abs(x(times) / exact - 1).max() < 1e-12


def test_derivatives_of_impulses_and_those_on_springs_take_the_pairs():
    """They make coordinates jump, or give them impulses."""
    A = plain_system("chain", static=4, damping="some").polynomial_matrix()
    springs = (abs(A.coefficients[1]).sum(axis=0) + abs(A.coefficients[2]).sum(axis=0) == 0).astype(float)
    first, second = mb.solve(A, force=mb.impulse(springs)), mb.solve(A, force=mb.impulse(1 - springs, order=1))
    assert "Dirac impulses on algebraic equations" in first.method.reason and first.impulses[0].any()
    assert "derivatives of Dirac impulses" in second.method.reason and second.jump[0].any()
