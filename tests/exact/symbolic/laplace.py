"""Oracle: x(t) from X(s) = A(s)^-1 (X_in(s) + F(s)) by mpmath's numerical inversion in many digits; no factor, no root, no expression."""

from __future__ import annotations

import mpmath
import sympy

#: Of the working precision; Talbot's contour loses some.
DIGITS = 60


def inverted(coefficients, values, initial, transform, times) -> list[list]:
    """x(t) at times > 0, in mpmath numbers.

    Args:
        coefficients: A_0 ... A_q, nested lists or matrices of expressions.
        values: {symbol: number} for every symbol in them, in the initial values and in the transform.
        initial: x^(i)(0-) as rows.
        transform: F(s) as a function of an mpmath number that gives r of them.
        times: numbers; x must have no impulses (subtract them before).
    """
    with mpmath.workdps(DIGITS):
        A = [_numbers(matrix, values) for matrix in coefficients]
        X0 = _numbers(initial, values) if len(A) > 1 else None
        r = A[0].rows

        def X(s, row):
            matrix, right = mpmath.zeros(r, r), mpmath.matrix(transform(s))
            for i, coefficient in enumerate(A):
                matrix += coefficient * s**i
                for j in range(i):
                    right += coefficient * X0[j, :].T * s ** (i - 1 - j)
            return mpmath.lu_solve(matrix, right)[row]

        return [
            [mpmath.invertlaplace(lambda s, row=row: X(s, row), mpmath.mpf(t), method="talbot") for row in range(r)] for t in times
        ]


def _numbers(matrix, values) -> mpmath.matrix:
    rows = sympy.Matrix(matrix).subs(values).tolist()
    return mpmath.matrix([[mpmath.mpmathify(sympy.N(entry, DIGITS)) for entry in row] for row in rows])
