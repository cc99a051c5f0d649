"""Combinations of coordinates that float64 does not resolve, such as the forces of springs that are much stiffer than others."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.frequency.extrema import extrema
from mbconstrained.response.methods.proved import ProvedCombination


def stiff_stack(stiffness: float) -> mb.Motion:
    """1, 2 and 1 kg on a spring of 4 N/m, joined by two stiff springs, released 1 cm above equilibrium."""
    model = mb.LumpedModel()
    for name, mass in (("plate", 1.0), ("sensor", 2.0), ("lid", 1.0)):
        model.mass(name, mass)
    model.spring("ground", "plate", 4.0, name="soft")
    model.spring("plate", "sensor", stiffness, name="lower")
    model.spring("sensor", "lid", stiffness, name="upper")
    return model.assemble().solve([0.01, 0.01, 0.01])


def true_elongations(stiffness: float, times: np.ndarray) -> np.ndarray:
    """By the eigenvectors of M^-1/2 K M^-1/2 with 60 digits (mpmath), rows lower and upper."""
    with mpmath.workdps(60):
        k, roots = mpmath.mpf(stiffness), [mpmath.mpf(1), mpmath.sqrt(2), mpmath.mpf(1)]
        K = mpmath.matrix([[4 + k, -k, 0], [-k, 2 * k, -k], [0, -k, k]])
        values, Q = mpmath.eigsy(
            mpmath.matrix(3, 3) + mpmath.matrix([[K[i, j] / roots[i] / roots[j] for j in range(3)] for i in range(3)])
        )
        start = Q.T * mpmath.matrix([root * mpmath.mpf(0.01) for root in roots])
        result = []
        for time in times.tolist():
            q = [start[i] * mpmath.cos(mpmath.sqrt(values[i]) * mpmath.mpf(time)) for i in range(3)]
            x = [sum(Q[i, j] * q[j] for j in range(3)) / roots[i] for i in range(3)]
            result.append([float(x[1] - x[0]), float(x[2] - x[1])])
    return np.array(result).T


@pytest.mark.parametrize("stiffness", [1e9, 1e12, 1e16])
def test_forces_of_stiff_springs_are_right(stiffness):
    motion, times = stiff_stack(stiffness), np.array([0.0, 1e-7, 0.3, 3.0, 9.7])
    difference = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
    true = true_elongations(stiffness, times)
    found = motion.function.differential(difference)(times)
    assert np.abs(found - true).max() <= 1e-9 * np.abs(true).max()


def test_peaks_that_may_be_exceeded_say_so():
    """Of two fast modes with incommensurable frequencies the force of the lower spring comes near 0.06 N: 0.03 N of the slow motion, 0.02 and
    0.01 N of the fast ones, from the mass times the acceleration above it and the start without elongation."""
    peaks = stiff_stack(1e16).peaks(20.0, ["force of lower"])
    own = peaks.extrema
    assert own.is_open.all() and own.largest[0] <= 0.06 * (1 + 1e-9)
    assert "≥" in peaks.table(lambda unit, name: (unit, 1.0)).rows[0][1]


def test_rows_that_vanish_by_symmetry_are_zero_and_others_are_not():
    system = mb.MechanicalSystem(np.eye(3), stiffness=3 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))
    ends, times = np.array([[1.0, 0.0, -1.0]]), np.linspace(0.0, 20.0, 1001)
    alike = system.solve([0.0, 1.0, 0.0]).function.differential(ends)
    assert isinstance(alike, ProvedCombination) and not alike(times).any()
    assert not extrema(alike, 0.0, 20.0).is_open.any()
    late = mb.step([1.0, 0.0, 0.0]).delayed(19.9)
    unlike = system.solve([0.0, 1.0, 0.0], force=late).function.differential(ends)(times)
    assert np.abs(unlike[0, times < 19.9]).max() < 1e-14 and np.isclose(unlike[0, -1], 0.1**2 / 2, rtol=0.01)
