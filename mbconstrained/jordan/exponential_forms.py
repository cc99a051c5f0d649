"""The formulas for e^{J t} of Moysis et al., section 2.2, as printed there and corrected: views for study and comparison.

The engine uses none of them as they stand (``linalg.exponential``). For a single block of size one, or a pair a +- i b, its
closed formulas are (32) and (40). For clusters the formulas here need the exact zeros and the exact exponents of the
minimal polynomial, which rounded data do not have: (35) is a confluent Vandermonde system whose condition grows without
bound as zeros come close, and the sums (34) and (37) cancel where |lambda t| is large. The engine takes a Taylor
polynomial about the mean of a cluster instead, which is accurate however close the zeros are, equal or not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import comb, factorial

import numpy as np
import scipy.linalg

from ..errors import InputError


def exponential_of_jordan_block(zero: complex, size: int, t: float) -> np.ndarray:
    """G(t) = e^{J t}, g_kj = e^{zero t} t^(j-k) / (j-k)!, shape (size, size), of one Jordan block (Lemma 2.11, Eqs. 30-33).

    The lemma holds for ONE block; the n_i x n_i matrix of a zero with several blocks is their direct sum.

    Args:
        zero: real or complex, in 1/s.
        size: n, at least 1.
        t: in s.

    >>> exponential_of_jordan_block(0.0, 2, 3.0).tolist()
    [[1.0, 3.0], [0.0, 1.0]]
    """
    return np.exp(zero * t) * _shifts(size, t)


def exponential_of_real_jordan_block(real: float, imaginary: float, size: int, t: float) -> np.ndarray:
    """e^{J t}, shape (2 size, 2 size), of one real block of the pair real +- i imaginary (Eqs. 38-41).

    J has D = [[a, b], [-b, a]] on its diagonal and I_2 beside it. Corrected: M in (40) is the rotation of (41) alone, which is
    e^{D t} without its factor e^{a t}; the pair has multiplicity m_i in a block of size 2 m_i.

    >>> exponential_of_real_jordan_block(0.0, 1.0, 1, 0.0).tolist()
    [[1.0, 0.0], [-0.0, 1.0]]
    """
    c, s = np.cos(imaginary * t), np.sin(imaginary * t)
    return np.exp(real * t) * np.kron(_shifts(size, t), np.array([[c, s], [-s, c]]))


def exponential_by_interpolation(J: np.ndarray, exponents: Mapping[complex, int], t: float) -> np.ndarray:
    """e^{J t} = sum of J^k f_k(t), k < m, with the f_k from the confluent Vandermonde system (Lemma 2.12, Eqs. 34-35).

    Args:
        J: shape (n, n), real or complex; it need not be in Jordan form.
        exponents: the distinct zeros of J with their exponents m_j in the minimal polynomial, conjugates included; the
            degree m is their sum. With larger exponents (the multiplicities) the formula holds as well.
        t: in s.

    Raises:
        InputError: exponents below 1, or none.

    >>> exponential_by_interpolation(np.zeros((2, 2)), {0.0: 1}, 3.0).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    _check(exponents)
    m, rows, right = sum(exponents.values()), [], []
    for zero, exponent in exponents.items():
        for i in range(exponent):
            rows.append([comb(k, i) * zero ** max(k - i, 0) for k in range(m)])
            right.append(t**i / factorial(i) * np.exp(zero * t))
    f = np.linalg.solve(np.array(rows), np.array(right))
    value = _polynomial(f, J)
    return value if np.iscomplexobj(J) else value.real


def exponential_by_blocks(blocks: Sequence[np.ndarray], zeros: Sequence[complex], exponents: Sequence[int], t: float) -> np.ndarray:
    """e^{J t} as the direct sum of sum of f_ij(t) J_i^j, j < m_i, one term for each zero (Lemma 2.13, Eqs. 36-37).

    Corrected: (37) is meant for i = 1 ... l and j = 0 ... m_i - 1, J_i collects ALL blocks of the zero i, and 0^0 = 1.

    Args:
        blocks: J_i, square, with no other zero than zeros[i].
        zeros: distinct, one for each block.
        exponents: m_i of the minimal polynomial, the size of the largest Jordan block of the zero.
        t: in s.

    Raises:
        InputError: not one zero and exponent for each block, a zero twice, exponents below 1.

    >>> exponential_by_blocks([np.array([[0.0, 1.0], [0.0, 0.0]])], [0.0], [2], 3.0).tolist()
    [[1.0, 3.0], [0.0, 1.0]]
    """
    if not len(blocks) == len(zeros) == len(exponents) == len(set(zeros)):
        raise InputError(f"expected one zero and one exponent for each of {len(blocks)} blocks, each zero once")
    _check(dict(zip(zeros, exponents, strict=True)))
    parts = []
    for block, zero, m in zip(blocks, zeros, exponents, strict=True):
        f = [
            np.exp(zero * t) / factorial(j) * sum((-1) ** (k - j) / factorial(k - j) * zero ** (k - j) * t**k for k in range(j, m))
            for j in range(m)
        ]
        parts.append(_polynomial(f, np.asarray(block)))
    return scipy.linalg.block_diag(*parts)


def _shifts(size, t) -> np.ndarray:
    """The upper triangular Toeplitz matrix of t^k / k!."""
    return np.triu(scipy.linalg.toeplitz([t**k / factorial(k) for k in range(size)]))


def _polynomial(factors, J) -> np.ndarray:
    """The sum of factors[k] J^k by Horner's rule."""
    value = np.zeros(J.shape, dtype=np.result_type(J, *factors))
    for factor in reversed(factors):
        value = J @ value + factor * np.eye(len(J))
    return value


def _check(exponents: Mapping[complex, int]) -> None:
    if not exponents or min(exponents.values()) < 1:
        raise InputError(f"exponents: found {dict(exponents)}; expected at least one zero, each with an exponent of at least 1")
