"""Large problems whose parts nothing couples, or only rounding would: each moves as if it were alone."""

import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from mbconstrained.linalg.arrays import full
from mbconstrained.response.methods.reduced_solution import ReducedSolution

from .plain_models import difference, fitting_start, general, plain_system

EVEN, UNEVEN = np.linspace(0.0, 400.0, 300), np.random.default_rng(0).uniform(0.0, 400.0, 40)


def beside_a_growing_one(damping: str) -> tuple[mb.MechanicalSystem, mb.MechanicalSystem]:
    """A chain alone, and beside another one that falls over, e^{2 t}."""
    calm, size = plain_system("chain", damping=damping), 36
    falling = (calm.mass, calm.damping, calm.stiffness - 4.5 * np.eye(size))
    return calm, mb.MechanicalSystem(*(block_diag(a, b) for a, b in zip((calm.mass, calm.damping, calm.stiffness), falling)))


@pytest.mark.parametrize("damping", ["none", "proportional", "some"])
@pytest.mark.parametrize("times", [EVEN, UNEVEN], ids=["even", "uneven"])
def test_what_rests_in_one_part_does_not_enter_another(damping, times):
    calm, both = beside_a_growing_one(damping)
    x0, v0 = fitting_start(calm)
    start = np.pad(x0, (0, 36)), np.pad(v0, (0, 36))
    x, expected = both.solve(*start), calm.solve(x0, v0)(times)
    assert isinstance(x.solution, ReducedSolution)
    assert difference(x(times)[:36], expected) <= 2e-12
    assert not x(times)[36:].any()
    family = both.solve(np.array([start[0], 2 * start[0]]), np.array([start[1], 2 * start[1]]))
    assert difference(family(times)[1, :36], 2 * expected) <= 2e-12


@pytest.mark.parametrize("stiffness", [1e-4, 1.0, 1e4])
def test_massless_joints_with_damping_in_proportion(stiffness):
    """C = 0.05 K: a joint with s = -20/s hangs on the masses but does not pull at them; rounding of K - 0.05 * 20 K would."""
    base = plain_system("tree", static=3)
    K = stiffness * base.stiffness
    system = mb.MechanicalSystem(base.mass, 0.05 * K, K)
    x = system.solve(*fitting_start(system), force=mb.ramp(stiffness * np.ones(36)))
    times = np.array([0.3, 4.7, 14.2]) / stiffness**0.5
    reduction = x.polynomial_matrix.reduction
    assert isinstance(x.solution, ReducedSolution)
    assert np.count_nonzero(full(reduction.generator)[:, 2 * len(reduction.second) :]) == len(reduction.first)
    assert difference(x(times), general(x)(times)) <= 2e-12
    assert difference(x.velocity(times), general(x).derivative(1)(times)) <= 5e-11


@pytest.mark.parametrize("drive", [1.0, 1e-3])
@pytest.mark.parametrize("times", [np.linspace(0.0, 40.0, 81), np.array([0.3, 1.7, 10.0, 33.0, 200.0])], ids=["even", "uneven"])
def test_of_two_like_chains_one_drives_the_other(drive, times):
    """x1 = V cos(W t) V^T a and, in resonance with every mode, x2 = drive V t sin(W t) / (2 W) V^T a: all zeros are double."""
    count = 30
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    own = np.kron(np.eye(2), K) - drive * np.kron(np.eye(2, k=-1), np.eye(count))
    start = np.zeros(2 * count)
    start[[3, 7]] = 1.0, -0.3
    x = mb.solve(mb.PolynomialMatrix([own, np.zeros_like(own), np.eye(2 * count)]), [start, 0 * start])
    k = np.arange(1, count + 1)
    w, V = 2 * np.sin(np.pi * k / (2 * (count + 1))), np.sqrt(2 / (count + 1)) * np.sin(np.pi * np.outer(k, k) / (count + 1))
    phase, parts = np.outer(w, times), (V.T @ start[:count])[:, None]
    first, second = V @ (parts * np.cos(phase)), drive * V @ (parts * times * np.sin(phase) / (2 * w)[:, None])
    assert isinstance(x.solution, ReducedSolution)
    assert difference(x(times)[:count], first) <= 5e-11
    assert difference(x(times)[count:], second) <= 5e-11
