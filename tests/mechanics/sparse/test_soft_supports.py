"""Free structures of sparse matrices on springs and dampers down to rounding errors, against exponentials in ball arithmetic."""

import numpy as np
import pytest
import scipy.sparse as sp

import mbconstrained as mb
from tests.oracles.ball_exponential import motion

TIMES = (1.0, 1e3, 1e5)


def chain(n, seed, dampers):
    """Unlike masses, springs and dampers between them, none to the ground."""
    random = np.random.default_rng(seed)
    B = np.diff(np.eye(n), axis=0)
    parts = [B.T @ np.diag(size * random.uniform(0.5, 2.0, n - 1)) @ B for size in (dampers, 1.0)]
    return np.diag(random.uniform(0.5, 2.0, n)), *parts


def compared(M, C, K, displacement, velocity):
    """The true error at each time relative to the answer, and its estimate."""
    x = mb.MechanicalSystem(sp.csc_array(M), sp.csc_array(C), sp.csc_array(K)).solve(displacement, velocity)
    for time in TIMES:
        exact = np.array([float(value) for value in motion([K, C, M], np.array([displacement, velocity]), time)])
        yield np.abs(x(time) - exact).max() / np.abs(exact).max(), x.error_estimate(time)


@pytest.mark.parametrize("support", [0.0, 1e-13, 1e-11, 1e-8, 1e-5])
@pytest.mark.parametrize("what", ["springs", "springs of a damped chain", "dampers"])
def test_the_estimate_is_the_error_whatever_supports_the_chain(what, support):
    M, C, K = chain(8, seed=5, dampers=0.0 if what == "springs" else 0.1)
    (C if what == "dampers" else K)[3, 3] += support
    random = np.random.default_rng(1)
    start = (np.ones(8), 0.01 * random.normal(size=8)) if what == "dampers" else (1 + 0.1 * random.normal(size=8), np.zeros(8))
    for error, estimate in compared(M, C, K, *start):
        assert error / 10 - 1e-14 <= estimate <= max(1e3 * error, 1e-9)


@pytest.mark.parametrize("damper", [1e-12, 1e-8, 1e-4, 1e-2])
def test_a_damper_slows_a_free_chain_down(damper):
    """No mode is lost, and the slow one is that of all masses together: s = -c / m to first order."""
    M, C, K = chain(40, seed=1, dampers=0.1)
    C[3, 3] += damper
    modes = mb.MechanicalSystem(sp.csc_array(M), sp.csc_array(C), sp.csc_array(K)).modes()
    values = modes.eigenvalues
    real = values[(values.imag == 0) & (values != 0)].real
    assert len(modes) >= 41 and np.abs(real / -(damper / np.trace(M)) - 1).min() < 1e-2


def test_what_springs_of_a_free_chain_leave_is_reported():
    """Sums of rounded entries are no support, or a tiny one: from when on that makes a difference."""
    M, _, K = chain(40, seed=1, dampers=0.0)
    assert K.astype(np.longdouble).sum() != 0
    x = mb.MechanicalSystem(sp.csc_array(M), None, sp.csc_array(K)).solve(np.ones(40))
    (notice,) = [one for one in x.notices if one.kind == "rank"]
    assert "cancel up to rounding errors" in notice.text and not notice.doubtful
