"""The three formulas for e^{J t} with numbers, against the exponential in fifty digits and the engine."""

import mpmath
import numpy as np
import pytest
import sympy

from mbconstrained.linalg.exponential import block_states
from tests.oracles.papers.matrix_exponentials import (
    exponential_by_blocks,
    exponential_by_interpolation,
    exponential_of_jordan_block,
    exponential_of_real_jordan_block,
)

# (zero, sizes of its Jordan blocks) of each; derogatory: more than one block for a zero
STRUCTURES = [
    [(0, (1, 3)), (-2, (2, 2))],
    [(-1 + 2 * sympy.I, (2,)), (-1 - 2 * sympy.I, (2,))],
    [(0, (2,)), (3 * sympy.I, (1, 2)), (-3 * sympy.I, (1, 2)), (-1, (1, 1, 1))],
]


def jordan_block(zero, size):
    return zero * sympy.eye(size) + sympy.Matrix(size, size, lambda i, j: int(j == i + 1))


def known(J, t) -> np.ndarray:
    """e^{J t} by mpmath, independent of the package."""
    with mpmath.workdps(50):
        value = mpmath.expm(mpmath.matrix(np.array(J).tolist()) * mpmath.mpf(t), method="taylor")
    return np.array([[complex(value[i, j]) for j in range(len(J))] for i in range(len(J))])


def numbers(matrix) -> np.ndarray:
    return np.array(matrix.evalf(30)).astype(complex)


@pytest.mark.parametrize("structure", STRUCTURES)
def test_each_is_the_exponential(structure):
    blocks = [sympy.diag(*[jordan_block(zero, size) for size in sizes]) for zero, sizes in structure]
    zeros, longest = [zero for zero, _ in structure], [max(sizes) for _, sizes in structure]
    J, t = sympy.diag(*blocks), sympy.Symbol("t")
    forms = (
        sympy.diag(*[exponential_of_jordan_block(zero, size, t) for zero, sizes in structure for size in sizes]),
        exponential_by_interpolation(J, dict(zip(zeros, longest)), t),
        exponential_by_blocks(blocks, zeros, longest, t),
    )
    for form in forms:
        for time in (sympy.S.Zero, sympy.Rational(17, 10)):
            np.testing.assert_allclose(numbers(form.xreplace({t: time})), known(numbers(J), float(time)), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("a", "b", "size"), [(-1.0, 2.0, 1), (-1.0, 2.0, 3), (0.5, 1.0, 4)])
def test_a_real_block_of_a_pair_is_that_of_the_engine(a, b, size):
    J = np.kron(np.eye(size), [[a, b], [-b, a]]) + np.kron(np.eye(size, k=1), np.eye(2))
    block = numbers(exponential_of_real_jordan_block(a, b, size, 1.7))
    np.testing.assert_allclose(block, known(J, 1.7), rtol=0, atol=1e-13)
    engine = np.stack([block_states([J], column, np.array([1.7]))[:, 0] for column in np.eye(2 * size)], axis=1)
    np.testing.assert_allclose(engine, block.real, rtol=0, atol=1e-13)


def test_close_zeros_do_not_matter_to_the_engine():
    J = np.diag([-1.0, -1.0 - 1e-7, -1.0 - 2e-7]) + np.eye(3, k=1)
    engine = np.stack([block_states([J], column, np.array([1.0]))[:, 0] for column in np.eye(3)], axis=1)
    assert np.abs(engine - known(J, 1.0)).max() < 1e-14
