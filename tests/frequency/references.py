"""Frequency responses with 50 digits (mpmath), the data taken as the exact numbers that they are."""

import mpmath as mp
import numpy as np

DIGITS = 50


def angular(frequency_hz: float):
    """2 pi f."""
    return 2 * mp.pi * mp.mpf(float(frequency_hz))


def solved(coefficients, frequency_hz: float, inputs) -> np.ndarray:
    """A(2 pi f i)^-1 B, shape (r, m), as complex numbers of mpmath."""
    with mp.workdps(DIGITS):
        s = mp.mpc(0, angular(frequency_hz))
        A = mp.zeros(len(coefficients[0]))
        for power, matrix in enumerate(coefficients):
            A += mp.matrix(np.asarray(matrix).tolist()) * s**power
        columns = [mp.lu_solve(A, mp.matrix(column.tolist())) for column in np.asarray(inputs, dtype=float).T]
        return np.array([[column[i] for column in columns] for i in range(A.rows)])


def chain_solved(coefficients, frequency_hz: float, place: int) -> list:
    """The same for a tridiagonal A(s) and a unit load at one place."""
    with mp.workdps(DIGITS):
        s, n = mp.mpc(0, angular(frequency_hz)), len(coefficients[0])
        entry = lambda i, j: sum(mp.mpf(matrix[i, j]) * s**k for k, matrix in enumerate(coefficients))  # noqa: E731
        d, o, x = [entry(i, i) for i in range(n)], [entry(i, i + 1) for i in range(n - 1)], [mp.mpc(0)] * n
        x[place] = mp.mpc(1)
        for i in range(n - 1):
            factor = o[i] / d[i]
            d[i + 1], x[i + 1] = d[i + 1] - factor * o[i], x[i + 1] - factor * x[i]
        x[n - 1] /= d[n - 1]
        for i in range(n - 2, -1, -1):
            x[i] = (x[i] - o[i] * x[i + 1]) / d[i]
        return x


def relative_error(value: complex, exact) -> float:
    """|value - exact| / |exact|."""
    with mp.workdps(DIGITS):
        return float(abs(mp.mpc(complex(value)) - exact) / abs(exact))
