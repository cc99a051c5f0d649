"""The motion of a lumped model by mpmath with 80 digits, from its elements; nothing is assembled in float64.

Coordinates without mass and constraint rows are not covered: those models are compared with the same model written without.
"""

from __future__ import annotations

import mpmath
import numpy as np


def motion(model, displacement, times):
    """x(t), shape (n, T), of a model of masses, springs and dampers from rest; one float64 rounding at the end."""
    with mpmath.workdps(80):
        factors = model.incidence()
        n = len(factors.masses)
        stiffness, damping = (_assembled(branches, n) for branches in (factors.springs, factors.dampers))
        A = mpmath.zeros(2 * n)
        for i, mass in enumerate(factors.masses):
            A[i, n + i] = 1
            for j in range(n):
                A[n + i, j] = -stiffness[i, j] / mpmath.mpf(float(mass))
                A[n + i, n + j] = -damping[i, j] / mpmath.mpf(float(mass))
        values, vectors = mpmath.eig(A)
        start = mpmath.matrix([mpmath.mpf(float(x)) for x in displacement] + [0] * n)
        amplitudes = mpmath.lu_solve(vectors, start)
        columns = []
        for t in times:
            weights = [mpmath.e ** (value * mpmath.mpf(float(t))) * a for value, a in zip(values, amplitudes)]
            columns.append([float(mpmath.re(sum(vectors[i, k] * weights[k] for k in range(2 * n)))) for i in range(n)])
        moduli = sorted(float(abs(value)) for value in values)
    return np.array(columns).T, moduli


def _assembled(branches, n):
    total = mpmath.zeros(n)
    for row, constant in zip(branches.incidence, branches.constants):
        at = [int(i) for i in np.flatnonzero(row)]
        for i in at:
            for j in at:
                total[i, j] += mpmath.mpf(float(constant)) * int(row[i]) * int(row[j])
    return total
