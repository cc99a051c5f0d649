"""Oracle: x(t) from X(s) = A(s)^-1 (X_in(s) + F(s)) by mpmath's numerical inversion in many digits; no factor, no root, no expression.

Impulses and values at 0+ are the coefficients of X at infinity, from a circle around all poles.
"""

import mpmath
import sympy

#: Of the working precision; Talbot's contour loses some.
DIGITS = 60

#: Of the circle: far outside the poles of every model of the tests, so that the trapezoidal rule leaves (pole/RADIUS)^POINTS.
RADIUS, POINTS = 512, 64


def inverted(coefficients, values, initial, transform, times) -> list[list]:
    """x(t) at times > 0, in mpmath numbers.

    Args:
        coefficients: A_0 ... A_q, nested lists or matrices of expressions.
        values: {symbol: number} for every symbol in them, in the initial values and in the transform.
        initial: x^(i)(0-) as rows.
        transform: F(s) as a function of an mpmath number that gives r of them.
        times: numbers; x must have no impulses.
    """
    with mpmath.workdps(DIGITS):
        X = _transformed(coefficients, values, initial, transform)
        rows = range(len(X(mpmath.mpf(1))))
        return [[mpmath.invertlaplace(lambda s, row=row: X(s)[row], mpmath.mpf(t), method="talbot") for row in rows] for t in times]


def at_infinity(coefficients, values, initial, transform, power: int) -> list:
    """The factors of s^power in X(s) near infinity: of delta^(power) in x, or x^(-1-power)(0+). Arguments as of ``inverted``."""
    with mpmath.workdps(DIGITS):
        X = _transformed(coefficients, values, initial, transform)
        places = [RADIUS * mpmath.expjpi(mpmath.mpf(2 * i + 1) / POINTS) for i in range(POINTS)]
        parts = [X(s) / s**power for s in places]
        return [mpmath.fsum(part[row] for part in parts) / POINTS for row in range(len(parts[0]))]


def _transformed(coefficients, values, initial, transform):
    A = [_numbers(matrix, values) for matrix in coefficients]
    X0 = _numbers(initial, values) if len(A) > 1 else None
    r = A[0].rows

    def X(s):
        matrix, right = mpmath.zeros(r, r), mpmath.matrix(transform(s))
        for i, coefficient in enumerate(A):
            matrix += coefficient * s**i
            for j in range(i):
                right += coefficient * X0[j, :].T * s ** (i - 1 - j)
        return mpmath.lu_solve(matrix, right)

    return X


def _numbers(matrix, values) -> mpmath.matrix:
    rows = sympy.Matrix(matrix).subs(values).tolist()
    return mpmath.matrix([[mpmath.mpmathify(sympy.N(entry, DIGITS)) for entry in row] for row in rows])
