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
from numbers import Number

import numpy as np
import scipy.linalg

from ..checks import real_number, whole_number
from ..errors import IllConditioned, InputError, Overflow


def exponential_of_jordan_block(zero: complex, size: int, t: float) -> np.ndarray:
    """G(t) = e^{J t}, g_kj = e^{zero t} t^(j-k) / (j-k)!, shape (size, size), of one Jordan block (Lemma 2.11, Eqs. 30-33).

    The lemma holds for ONE block; the n_i x n_i matrix of a zero with several blocks is their direct sum.

    Args:
        zero: real or complex, in 1/s.
        size: n, at least 1.
        t: in s.

    Raises:
        InputError: a zero that is no finite number, a size below 1.
        Overflow: an entry is beyond the range of float64.

    >>> exponential_of_jordan_block(0.0, 2, 3.0).tolist()
    [[1.0, 3.0], [0.0, 1.0]]
    """
    zero, size, t = _number(zero, "zero"), whole_number(size, "size", minimum=1), real_number(t, "t")
    with np.errstate(all="ignore"):  # told by _in_range
        return _in_range(np.exp(zero * t) * _shifts(size, t), t)


def exponential_of_real_jordan_block(real: float, imaginary: float, size: int, t: float) -> np.ndarray:
    """e^{J t}, shape (2 size, 2 size), of one real block of the pair real +- i imaginary (Eqs. 38-41).

    J has D = [[a, b], [-b, a]] on its diagonal and I_2 beside it. Corrected: M in (40) is the rotation of (41) alone, which is
    e^{D t} without its factor e^{a t}; the pair has multiplicity m_i in a block of size 2 m_i.

    Raises:
        InputError, Overflow: as ``exponential_of_jordan_block``.

    >>> exponential_of_real_jordan_block(0.0, 1.0, 1, 0.0).tolist()
    [[1.0, 0.0], [-0.0, 1.0]]
    """
    real, imaginary, t = real_number(real, "real"), real_number(imaginary, "imaginary"), real_number(t, "t")
    size = whole_number(size, "size", minimum=1)
    with np.errstate(all="ignore"):
        c, s = np.cos(imaginary * t), np.sin(imaginary * t)
        return _in_range(np.exp(real * t) * np.kron(_shifts(size, t), np.array([[c, s], [-s, c]])), t)


def exponential_by_interpolation(J: np.ndarray, exponents: Mapping[complex, int], t: float) -> np.ndarray:
    """e^{J t} = sum of J^k f_k(t), k < m, with the f_k from the confluent Vandermonde system (Lemma 2.12, Eqs. 34-35).

    Args:
        J: shape (n, n), real or complex; it need not be in Jordan form.
        exponents: the distinct zeros of J with their exponents m_j in the minimal polynomial, conjugates included; the
            degree m is their sum. With larger exponents (the multiplicities) the formula holds as well.
        t: in s.

    Raises:
        InputError: J that is not square; zeros that are no finite numbers; exponents that are no whole numbers of at least 1.
        IllConditioned: zeros so close, or so large, that float64 finds the system singular.
        Overflow: an entry is beyond the range of float64.

    >>> exponential_by_interpolation(np.zeros((2, 2)), {0.0: 1}, 3.0).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    J, exponents, t = _square(J, "J"), _checked(exponents), real_number(t, "t")
    with np.errstate(all="ignore"):
        value = _in_range(_polynomial(_factors(exponents, t), J), t)
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
        InputError: not one zero and exponent for each block, a zero twice; else as ``exponential_by_interpolation``.
        Overflow: an entry is beyond the range of float64.

    >>> exponential_by_blocks([np.array([[0.0, 1.0], [0.0, 0.0]])], [0.0], [2], 3.0).tolist()
    [[1.0, 3.0], [0.0, 1.0]]
    """
    if not all(isinstance(given, Sequence | np.ndarray) for given in (blocks, zeros, exponents)):
        raise InputError("blocks, zeros, exponents: expected three lists, one entry of each for each zero")
    zeros, t = [_number(zero, "zeros") for zero in zeros], real_number(t, "t")
    if not len(blocks) == len(zeros) == len(exponents) == len(set(zeros)):
        raise InputError(f"expected one zero and one exponent for each of {len(blocks)} blocks, each zero once")
    found, parts = _checked(dict(zip(zeros, exponents, strict=True))), []
    with np.errstate(all="ignore"):
        for block, (zero, m) in zip(blocks, found.items(), strict=True):
            power = _powers(zero, m) * (-1.0) ** np.arange(m) / _factorials(m)  # (-zero)^k / k!
            f = [np.exp(zero * t) / factorial(j) * (power[: m - j] @ _powers(t, m)[j:]) for j in range(m)]
            parts.append(_polynomial(f, _square(block, "blocks")))
        return _in_range(scipy.linalg.block_diag(*parts), t)


def _factors(exponents, t) -> np.ndarray:
    """The f_k(t) of (35)."""
    m, rows, right = sum(exponents.values()), [], []
    for zero, exponent in exponents.items():
        powers = _powers(zero, m)
        rows += [[comb(k, i) * powers[max(k - i, 0)] for k in range(m)] for i in range(exponent)]
        right += list(np.exp(zero * t) * _powers(t, exponent) / _factorials(exponent))
    rows, right = _in_range(np.array(rows), t), _in_range(np.array(right), t)
    try:
        return np.linalg.solve(rows, right)
    except np.linalg.LinAlgError:
        raise IllConditioned("the system (35) of these zeros is singular in float64; use exponential_by_blocks, or mb.solve") from None


def _powers(number, count) -> np.ndarray:
    return np.cumprod(np.append(1.0, np.full(count - 1, number)))


def _factorials(count) -> np.ndarray:
    return np.cumprod(np.append(1.0, np.arange(1.0, count)))


def _shifts(size, t) -> np.ndarray:
    """The upper triangular Toeplitz matrix of t^k / k!."""
    return np.triu(scipy.linalg.toeplitz(np.cumprod(np.append(1.0, t / np.arange(1.0, size)))))


def _polynomial(factors, J) -> np.ndarray:
    """The sum of factors[k] J^k by Horner's rule."""
    value = np.zeros(J.shape, dtype=np.result_type(J, *factors))
    for factor in reversed(factors):
        value = J @ value + factor * np.eye(len(J))
    return value


def _in_range(value, t) -> np.ndarray:
    if not np.isfinite(value).all():
        raise Overflow(f"e^(J t) at t = {t:g} s, or what it is made of, is beyond the range of float64; ask for an earlier time")
    return value


def _number(value, what: str) -> complex:
    """A finite number, real or complex."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Number) or not np.isfinite(value):
        raise InputError(f"{what}: found {value!r}; expected a finite number, real or complex")
    return value


def _square(value, what: str) -> np.ndarray:
    """A square array of finite numbers, real or complex."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{what}: the rows have different lengths; expected a square array") from None
    if array.dtype.kind not in "iufc" or array.ndim != 2 or array.shape[0] != array.shape[1] or not np.isfinite(array).all():
        raise InputError(f"{what}: found an array of {array.dtype}, shape {array.shape}; expected square, of finite numbers")
    return array


def _checked(exponents) -> dict[complex, int]:
    if not isinstance(exponents, Mapping) or not exponents:
        raise InputError(f"exponents: found {exponents!r}; expected at least one zero, each with an exponent of at least 1")
    return {_number(zero, "zero"): whole_number(m, f"exponent of {zero!r}", minimum=1) for zero, m in exponents.items()}
