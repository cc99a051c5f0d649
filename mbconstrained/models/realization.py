"""State spaces of given transfer functions: E, A, B, C, D with C (s E - A)^-1 B + D = G(s).

A proper b(s)/a(s) becomes the controllable canonical form, with the states w, w', ..., w^(n-1) of a(d/dt) w = u and
y = b(d/dt) w. An improper one (or a constant) keeps its coefficients as they are in a descriptor form: w, ..., w^(N) with
N = max(m, n), N equations (w^(i))' = w^(i+1), and 0 = a(d/dt) w - u among the highest of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks import real_array, real_number
from ..errors import InputError

#: Roots this near to being conjugate, relative to their size, are taken as a pair: packages write them with rounding errors.
CONJUGATE = 1e-10

Matrices = tuple[np.ndarray | None, np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # E (None: identity), A, B, C, D


def rational_realization(numerator, denominator) -> Matrices:
    """Of b(s)/a(s), or of a matrix of them, numerator[output][input] and denominator[output][input].

    Every entry of a matrix is realized for itself, so that poles that they share are there more than once.

    Raises:
        InputError: not numbers, a denominator that is zero, lists of different sizes.

    >>> E, A, B, C, D = rational_realization([1.0, 3.0], [1.0, 2.0])  # 1 + 1/(s + 2)
    >>> E, A.tolist(), C.tolist(), D.tolist()
    (None, [[-2.0]], [[1.0]], [[1.0]])
    """
    if not _is_matrix(numerator) and not _is_matrix(denominator):
        return _single(coefficients(numerator, "numerator"), denominator_of(denominator))
    rows = _entries(numerator, denominator)
    return _beside([[_single(coefficients(b, "numerator"), denominator_of(a)) for b, a in row] for row in rows])


def coefficients(value, what: str) -> np.ndarray:
    """Coefficients with the highest power first, without leading zeros, at least one."""
    found = real_array([value] if np.ndim(value) == 0 else value, what, shape=(None,))
    if not len(found):
        raise InputError(f"{what}: found no coefficients; expected numbers, the highest power of s first")
    return found[min(int((found != 0).argmax()), len(found) - 1) :] if found.any() else np.zeros(1)


def denominator_of(value) -> np.ndarray:
    """The same, not zero."""
    found = coefficients(value, "denominator")
    if not found.any():
        raise InputError("denominator: found zero; expected a polynomial that is not zero")
    return found


def _single(b: np.ndarray, a: np.ndarray) -> Matrices:
    n, m = len(a) - 1, len(b) - 1
    return _canonical(b[::-1], a[::-1]) if 1 <= n >= m else _descriptor(b[::-1], a[::-1], max(n, m))


def _canonical(b, a) -> Matrices:
    """Ascending powers, m <= n."""
    n = len(a) - 1
    b = np.pad(b, (0, n + 1 - len(b))) / a[-1]
    a = a / a[-1]
    A = np.diag(np.ones(n - 1), 1)
    A[-1] = -a[:n]
    return None, A, np.eye(n)[:, -1:], (b[:n] - b[n] * a[:n])[None, :], b[n:, None]


def _descriptor(b, a, highest: int) -> Matrices:
    """Ascending powers, of any degrees up to the highest one."""
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
        raise InputError("numerator: found coefficients beside a matrix of denominators; give numerator[output][input]")
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


def _beside(table: list[list[Matrices]]) -> Matrices:
    """One below the other, each from its input to its output."""
    sizes = [[len(entry[1]) for entry in row] for row in table]
    n, q, p = sum(map(sum, sizes)), len(table), len(table[0])
    E, A, B, C, D = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, p)), np.zeros((q, n)), np.zeros((q, p))
    first = 0
    for i, row in enumerate(table):
        for j, (own, a, b, c, d) in enumerate(row):
            at = slice(first, first + len(a))
            E[at, at], A[at, at], B[at, j], C[i, at], D[i, j] = np.eye(len(a)) if own is None else own, a, b[:, 0], c[0], d[0, 0]
            first = at.stop
    return (None if (E == np.eye(n)).all() else E), A, B, C, D


def factored_realization(zeros, poles, gain) -> Matrices:
    """Of gain prod(s - zeros)/prod(s - poles): sections of at most second order, one after the other, no product multiplied out.

    Raises:
        InputError: complex numbers without their conjugates.
    """
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
    product = np.ones(1)
    for factor in factors:
        product = np.convolve(product, factor)
    return product


def _quadratics(roots, what: str) -> list[np.ndarray]:
    """Real factors of second order, and one of first order at the end where their number is odd."""
    roots = _complex_numbers(roots, what)
    upper, lower = (sorted(roots[sign * roots.imag > 0], key=lambda z: (z.real, abs(z.imag))) for sign in (1, -1))
    if len(upper) != len(lower) or not np.allclose(upper, np.conj(lower), rtol=CONJUGATE, atol=0):
        raise InputError(f"{what}: found complex numbers without their conjugates; a real system has them in pairs")
    real = sorted(roots[roots.imag == 0].real, key=abs)
    found = [np.array([1.0, -2 * z.real, abs(z) ** 2]) for z in upper]
    found += [np.array([1.0, -(a + b), a * b]) for a, b in zip(real[::2], real[1::2])]
    return found + ([np.array([1.0, -real[-1]])] if len(real) % 2 else [])


def _complex_numbers(roots, what: str) -> np.ndarray:
    try:
        found = np.atleast_1d(np.asarray(roots, dtype=complex))
        fits = np.asarray(roots).dtype.kind not in "US" and found.ndim == 1 and np.isfinite(found).all()
    except (TypeError, ValueError, OverflowError):  # what numpy says of other things, uneven lists and numbers out of range
        fits = False
    if not fits:
        raise InputError(f"{what}: expected a list of finite numbers, real or complex")
    return found


def _series(first: Matrices, second: Matrices) -> Matrices:
    """The output of the first drives the second; both without descriptor."""
    _, A1, B1, C1, D1 = first
    _, A2, B2, C2, D2 = second
    A = np.block([[A1, np.zeros((len(A1), len(A2)))], [B2 @ C1, A2]])
    return None, A, np.vstack([B1, B2 @ D1]), np.hstack([D2 @ C1, C2]), D2 @ D1
