"""Zeros refined by their equations against the same in forty digits (mpmath)."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.linalg.arrays import full
from mbconstrained.linalg.blocks import decoupled
from mbconstrained.polynomial.direct_reduction import reduction_of
from mbconstrained.polynomial.reduced_equations import refined


def chain(count: int, joints: int = 0) -> mb.PolynomialMatrix:
    """Masses between two walls, some of the springs with a damper; massless joints held by springs and a damper at the end."""
    n = count + joints
    M, C, K = np.diag([1.0 + 0.25 * (i % 3) for i in range(count)] + [0.0] * joints), np.zeros((n, n)), np.zeros((n, n))
    for i in range(n - 1):
        pull = np.outer(*2 * [np.eye(n)[i] - np.eye(n)[i + 1]])
        K += (1000.0 + 7 * i) * pull
        C += (0.3 if i % 2 or i >= count - 1 else 0.0) * pull
    for end in (0, n - 1):
        K[end, end] += 1000.0
    return mb.PolynomialMatrix([K, C, M])


def exact_zeros(A: mb.PolynomialMatrix) -> np.ndarray:
    """From S of the reduced equations, made in forty digits from the given numbers."""
    with mpmath.workdps(40):
        K, C, M = (mpmath.matrix(matrix.tolist()) for matrix in A.coefficients)
        n, m = A.size, int(np.count_nonzero(np.diag(A.coefficients[2])))
        first = C[m:, m:] ** -1 if m < n else mpmath.matrix(0, 0)
        rates = -first * mpmath.matrix([[*K[m + i, :], *C[m + i, :m]] for i in range(n - m)]) if m < n else None
        S = mpmath.zeros(m + n)
        for i in range(m):
            S[i, n + i] = 1
            for j in range(n):
                S[n + i, j] = -K[i, j] / M[i, i]
            for j in range(m):
                S[n + i, n + j] = -C[i, j] / M[i, i]
        for row in range(n - m):
            for j in range(n + m):
                S[m + row, j] = rates[row, j]
                for i in range(m):
                    S[n + i, j] -= C[i, m + row] / M[i, i] * rates[row, j]
        return np.array([complex(value) for value in mpmath.eig(S, left=False, right=False)])


def zeros_of(parts) -> np.ndarray:
    return np.array([complex(block[0, 0], abs(block[0, -1]) if len(block) == 2 else 0.0) for block in parts.blocks])


def largest_error(found, exact) -> float:
    """Relative to each zero."""
    upper = exact[exact.imag >= -1e-12]
    return max(float(np.abs(upper - zero).min() / abs(zero)) for zero in found)


@pytest.mark.parametrize(("count", "joints"), [(9, 0), (7, 2), (1, 1)])
def test_slow_zeros_have_the_digits_that_the_equations_give(count, joints):
    A = chain(count, joints)
    reduction = reduction_of(A)
    before = decoupled(full(reduction.generator))
    exact, after = exact_zeros(A), refined(reduction, before)
    assert len(exact) == reduction.state_count
    assert largest_error(zeros_of(after), exact) <= max(1e-15, 1.05 * largest_error(zeros_of(before), exact))
    assert largest_error(zeros_of(after), exact) < 4e-15


def test_blocks_of_other_forms_stay_as_they_are():
    reduction = reduction_of(chain(3))
    parts = decoupled(full(reduction.generator))
    odd = tuple(np.array([[0.0, 2.0], [-3.0, -1.0]]) for _ in parts.blocks)
    same = refined(reduction, type(parts)(parts.basis, parts.inverse, odd, parts.coupling))
    assert all(np.array_equal(one, two) for one, two in zip(same.blocks, odd))
