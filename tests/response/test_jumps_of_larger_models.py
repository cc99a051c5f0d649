"""Larger models from values at 0- that do not satisfy their constraints: jumps in the reduced equations against the exact engine."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.properties.test_larger_models import beams, chain, stiff_links, weakly_coupled_chains

EPS = np.finfo(float).eps


def errors(motion, times) -> list[tuple[float, float]]:
    """(error, estimate) at each time, relative to the largest value; the errors are proved."""
    result = []
    for time in times:
        values = motion(time)
        box = motion.enclose(time)
        result.append((float(np.max(box.error_bounds(values))) / np.abs(values).max(), motion.error_estimate(time)))
    return result


@pytest.mark.parametrize("family", [weakly_coupled_chains, stiff_links, beams])
def test_estimates_after_a_jump_are_near_the_errors(family):
    (M, C, K), displacement, _, time = family(np.random.default_rng(3))
    n = len(M)
    row = np.eye(n)[1] - np.eye(n)[n - 4]
    system = mb.MechanicalSystem(mass=M, damping=C, stiffness=K, constraints=[mb.Constraint([row], level="position")])
    motion = system.solve(displacement=displacement + np.eye(n)[1], velocity=np.eye(n)[2] - 0.5 * np.eye(n)[1])
    assert "modes" in motion.solution.method.name
    assert motion.jump[:, [1, n - 4]].all()
    for error, estimate in errors(motion, [time / 100, time]):
        assert max(error, 8 * EPS) <= 10 * estimate
        assert estimate <= 1e3 * max(error, 8 * EPS)


def test_positions_and_velocities_jump_as_momentum_demands():
    """M weights the projection on x_1 = x_2: the momentum of both bodies is kept, damping between them acts during the jump."""
    n = 26
    M, K = np.diag(np.arange(1.0, n + 1)), chain(n)
    row = np.eye(n)[0] - np.eye(n)[1]
    system = mb.MechanicalSystem(
        mass=M, stiffness=K, damping=0.1 * np.diag(np.ones(n)), constraints=[mb.Constraint([row], level="position")]
    )
    x0, v0 = np.eye(n)[0], 3.0 * np.eye(n)[1]
    motion = system.solve(displacement=x0, velocity=v0)
    x, v = x0 + motion.jump[0], v0 + motion.jump[1]
    assert x[:2] == pytest.approx(1 / 3, rel=4 * EPS)  # (1 * 1 + 2 * 0) / (1 + 2)
    momentum = M @ v + 0.1 * x
    assert v[0] == pytest.approx(v[1])
    assert momentum[0] + momentum[1] == pytest.approx((M @ v0 + 0.1 * x0)[:2].sum())
    jump, _ = motion.exact.event(0.0)
    assert np.allclose(motion.jump, jump, rtol=1e-14, atol=1e-15)
