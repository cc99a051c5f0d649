"""Realizations of transfer functions as state spaces: E, A, B, C, D with C (s E - A)^-1 B + D = G(s).

A proper b(s)/a(s) becomes the controllable canonical form, with the states w, w', ..., w^(n-1) of a(d/dt) w = u and
y = b(d/dt) w. An improper one (or a constant) keeps its coefficients in a descriptor form: w, ..., w^(N) with
N = max(m, n), N equations (w^(i))' = w^(i+1), and 0 = a(d/dt) w - u among the highest of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np
from scipy.linalg import block_diag

from ..ground.checks import real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import CONJUGATE_ROOTS

Matrices = tuple[np.ndarray | None, np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # E (None: identity), A, B, C, D


def rational_realization(numerator, denominator) -> Matrices:
    """Realization of b(s)/a(s), or of a matrix of them, numerator[output][input] and denominator[output][input].

    Every entry of a matrix is realized separately, so that common poles occur more than once.

    >>> E, A, B, C, D = rational_realization([1.0, 3.0], [1.0, 2.0])  # 1 + 1/(s + 2)
    >>> E, A.tolist(), C.tolist(), D.tolist()
    (None, [[-2.0]], [[1.0]], [[1.0]])
    """
    if not _is_matrix(numerator) and not _is_matrix(denominator):
        return _single(_coefficients(numerator, "numerator"), _coefficients(denominator, "denominator"))
    rows = _entries(numerator, denominator)
    return _block_realization(
        [[_single(_coefficients(b, "numerator"), _coefficients(a, "denominator")) for b, a in row] for row in rows]
    )


def _coefficients(value, what: str) -> np.ndarray:
    """Coefficients with the highest power first, without leading zeros, at least one; a denominator is not zero."""
    polynomial = real_array([value] if np.ndim(value) == 0 else value, what, shape=(None,))
    if not len(polynomial):
        raise InputError(f"{what}: found no coefficients; expected numbers, the highest power of s first")
    if polynomial.any():
        return polynomial[int((polynomial != 0).argmax()) :]
    if what == "denominator":
        raise InputError("denominator: found zero; expected a polynomial that is not zero")
    return np.zeros(1)


def _single(b: np.ndarray, a: np.ndarray) -> Matrices:
    n, m = len(a) - 1, len(b) - 1
    return _canonical(b[::-1], a[::-1]) if 1 <= n >= m else _descriptor(b[::-1], a[::-1], max(n, m))


def _canonical(b, a) -> Matrices:
    """Canonical realization; ascending powers, m <= n."""
    n = len(a) - 1
    b = np.pad(b, (0, n + 1 - len(b))) / a[-1]
    a = a / a[-1]
    A = np.diag(np.ones(n - 1), 1)
    A[-1] = -a[:n]
    return None, A, np.eye(n)[:, -1:], (b[:n] - b[n] * a[:n])[None, :], b[n:, None]


def _descriptor(b, a, highest: int) -> Matrices:
    """Descriptor realization; ascending powers, of any degree of the numerator."""
    size = highest + 1
    E, A = np.eye(size), np.diag(np.ones(highest), 1)
    E[-1, -1] = 0.0
    A[-1, : len(a)] = a
    return E, A, -np.eye(size)[:, -1:], np.pad(b, (0, size - len(b)))[None, :], np.zeros((1, 1))


def _is_matrix(value) -> bool:
    return _is_list(value) and len(value) > 0 and _is_list(value[0])


def _is_list(value) -> bool:
    return isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str) and getattr(value, "ndim", 1) > 0


def _entries(numerator, denominator) -> list[list[tuple]]:
    if not _is_matrix(numerator):
        raise InputError("numerator: found coefficients with a matrix of denominators; give numerator[output][input]")
    for table, what in ((numerator, "numerator"), (denominator, "denominator")):
        if _is_matrix(table) and any(_is_list(row) and not len(row) for row in table):
            raise InputError(f"{what}: found an empty list; expected a polynomial, or {what}[output][input]")
    if not _is_list(numerator[0][0]):  # one input, several outputs, as scipy.signal writes it
        numerator = [[row] for row in numerator]
    if not _is_matrix(denominator):
        denominator = [[denominator] * len(row) for row in numerator]
    sizes = [[len(row) if _is_list(row) else 0 for row in table] for table in (numerator, denominator)]
    if sizes[0] != sizes[1] or len(set(sizes[0])) != 1:
        raise InputError("numerator and denominator: expected a polynomial for every output and input in both; the sizes differ")
    return [list(zip(*rows)) for rows in zip(numerator, denominator)]


def _block_realization(table: list[list[Matrices]]) -> Matrices:
    """The realizations of all entries as one block diagonal system."""
    q, p = len(table), len(table[0])
    entries = [(i, j, *entry) for i, row in enumerate(table) for j, entry in enumerate(row)]
    E = block_diag(*(np.eye(len(A)) if own is None else own for _, _, own, A, *_ in entries))
    A = block_diag(*(A for _, _, _, A, *_ in entries))
    B = np.vstack([B @ np.eye(p)[[j]] for _, j, _, _, B, *_ in entries])
    C = np.hstack([np.eye(q)[:, [i]] @ C for i, *_, C, _ in entries])
    return (None if (E == np.eye(len(A))).all() else E), A, B, C, np.block([[entry[-1] for entry in row] for row in table])


def factored_realization(zeros, poles, gain) -> Matrices:
    """Realization of gain prod(s - zeros)/prod(s - poles) as a series of sections of at most second order, not multiplied out."""
    above, below = _quadratics(zeros, "zeros"), _quadratics(poles, "poles")
    gain = real_number(gain, "gain")
    if len(above) > len(below) or not below or sum(map(len, above)) - len(above) > sum(map(len, below)) - len(below):
        return _single(gain * _product(above), _product(below))
    above += [np.ones(1)] * (len(below) - len(above))
    above[0] = gain * above[0]
    chain = _single(above[0], below[0])
    for b, a in zip(above[1:], below[1:]):
        chain = _series(chain, _single(b, a))
    return chain


def _product(factors) -> np.ndarray:
    return reduce(np.convolve, factors, np.ones(1))


def _quadratics(roots, what: str) -> list[np.ndarray]:
    """Real factors of second order, and one of first order at the end where the degree is odd."""
    roots = _complex_numbers(roots, what)
    upper, lower = (sorted(roots[sign * roots.imag > 0], key=lambda z: (z.real, abs(z.imag))) for sign in (1, -1))
    if len(upper) != len(lower) or not np.allclose(upper, np.conj(lower), rtol=CONJUGATE_ROOTS, atol=0):
        raise InputError(f"{what}: found complex numbers without their conjugates; a real system has them in pairs")
    real = sorted(roots[roots.imag == 0].real, key=abs)
    factors = [np.array([1.0, -2 * z.real, abs(z) ** 2]) for z in upper]
    factors += [np.array([1.0, -(a + b), a * b]) for a, b in zip(real[::2], real[1::2])]
    return factors + ([np.array([1.0, -real[-1]])] if len(real) % 2 else [])


def _complex_numbers(roots, what: str) -> np.ndarray:
    try:
        numbers = np.atleast_1d(np.asarray(roots, dtype=complex))
        fits = np.asarray(roots).dtype.kind not in "US" and numbers.ndim == 1 and np.isfinite(numbers).all()
    except (TypeError, ValueError, OverflowError):  # other objects, uneven lists, numbers out of range
        fits = False
    if not fits:
        raise InputError(f"{what}: expected a list of finite numbers, real or complex")
    return numbers


def _series(first: Matrices, second: Matrices) -> Matrices:
    """Series connection: the output of the first is the input of the second; both without descriptor."""
    _, A1, B1, C1, D1 = first
    _, A2, B2, C2, D2 = second
    A = np.block([[A1, np.zeros((len(A1), len(A2)))], [B2 @ C1, A2]])
    return None, A, np.vstack([B1, B2 @ D1]), np.hstack([D2 @ C1, C2]), D2 @ D1
