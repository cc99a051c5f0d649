"""An independent solver in rational arithmetic: determinants by interpolation, Laurent series at infinity, Taylor sums.

Nothing here is shared with the package: no pencil, no eigenvalue, no rank decision. A polynomial matrix is a list
of r x r lists of Fractions, A_0 first; a polynomial is a list of Fractions, lowest power first.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations, pairwise
from math import factorial


def rational(matrices) -> list:
    """Nested lists of Fractions with exactly the values of the floats or integers given."""
    return [[[Fraction(float(entry)) for entry in row] for row in matrix] for matrix in matrices]


def evaluate(A, s):
    """A(s) by Horner's rule."""
    r = len(A[0])
    value = [[Fraction(0)] * r for _ in range(r)]
    for matrix in reversed(A):
        value = [[value[i][j] * s + matrix[i][j] for j in range(r)] for i in range(r)]
    return value


def determinant_of_numbers(M):
    """Gaussian elimination with exact pivots."""
    M, value = [row[:] for row in M], Fraction(1)
    for k in range(len(M)):
        pivot = next((i for i in range(k, len(M)) if M[i][k]), None)
        if pivot is None:
            return Fraction(0)
        if pivot != k:
            M[k], M[pivot], value = M[pivot], M[k], -value
        value *= M[k][k]
        for i in range(k + 1, len(M)):
            factor = M[i][k] / M[k][k]
            M[i] = [M[i][j] - factor * M[k][j] for j in range(len(M))]
    return value


def interpolate(values):
    """The polynomial that takes these values at 0, 1, 2, ... (Newton's divided differences, then expanded)."""
    differences = list(values)
    for level in range(1, len(values)):
        for i in range(len(values) - 1, level - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / level
    polynomial = [Fraction(0)]
    for i in reversed(range(len(values))):
        polynomial = [Fraction(0)] + polynomial
        for j in range(len(polynomial) - 1):
            polynomial[j] -= i * polynomial[j + 1]
        polynomial[0] += differences[i]
    return trimmed(polynomial)


def trimmed(polynomial):
    """Without leading zeros; the zero polynomial is the empty list."""
    polynomial = list(polynomial)
    while polynomial and not polynomial[-1]:
        polynomial.pop()
    return polynomial


def minor(A, rows, columns):
    """The determinant of a square part of A(s), a polynomial."""
    degree = len(rows) * (len(A) - 1)
    values = []
    for s in range(degree + 1):
        value = evaluate(A, Fraction(s))
        values.append(determinant_of_numbers([[value[i][j] for j in columns] for i in rows]))
    return interpolate(values)


def determinant(A):
    """det A(s)."""
    everything = range(len(A[0]))
    return minor(A, everything, everything)


def adjugate(A):
    """adj A(s), polynomials."""
    r = len(A[0])
    others = [[k for k in range(r) if k != i] for i in range(r)]
    return [[[(-1) ** (i + j) * c for c in minor(A, others[j], others[i])] for j in range(r)] for i in range(r)]


def orders_at_infinity(A):
    """q_1 >= ... >= q_r of the Smith form at infinity, from the highest degrees of the minors of each size."""
    r = len(A[0])
    highest = [0]
    for size in range(1, r + 1):
        choices = list(combinations(range(r), size))
        highest.append(max(len(minor(A, rows, columns)) - 1 for rows in choices for columns in choices))
    return [after - before for before, after in pairwise(highest)]


def laurent(A, lowest: int) -> dict:
    """{i: H_i} for every i >= lowest with A(s)^-1 = sum of H_i s^i near infinity, by long division of adj A by det A."""
    r, below, above = len(A[0]), determinant(A), adjugate(A)
    n = len(below) - 1
    highest = max((len(p) - 1 for row in above for p in row), default=0) - n
    H = {i: [[Fraction(0)] * r for _ in range(r)] for i in range(lowest, max(highest, lowest) + 1)}
    for i in range(r):
        for j in range(r):
            rest = dict(enumerate(above[i][j]))
            for power in range(highest, lowest - 1, -1):
                factor = rest.get(power + n, Fraction(0)) / below[-1]
                H[power][i][j] = factor
                for k, c in enumerate(below):
                    rest[power + k] = rest.get(power + k, Fraction(0)) - factor * c
    return H


def force_derivatives(terms, r: int, count: int):
    """f^(k)(0+), k < count, of the sum of v t^p e^{a t} cos(w t) or sin(w t) in (v, p, a, w, kind), by Taylor products."""
    total = [[Fraction(0)] * r for _ in range(count)]
    for vector, power, rate, frequency, kind in terms:
        series = [Fraction(0)] * count
        for i in range(count):
            for j in range(count - i):
                if i + j + power < count and j % 2 == (kind == "sin"):
                    series[i + j + power] += rate**i * frequency**j * (-1) ** (j // 2) / factorial(i) / factorial(j)
        for k in range(count):
            for i in range(r):
                total[k][i] += vector[i] * series[k] * factorial(k)
    return total


def transform(A, initial, force, impulses, lowest: int) -> dict:
    """{m: vector} of the Laurent coefficients of X(s) = A(s)^-1 (X_in(s) + F(s)) near infinity, m >= lowest.

    force is the list of f^(k)(0+), which are the coefficients of s^(-1-k) of F; impulses those of s^k.
    """
    r, q = len(A[0]), len(A) - 1
    right = {-1 - k: list(vector) for k, vector in enumerate(force)}
    for k, vector in enumerate(impulses):
        right[k] = list(vector)
    for i in range(1, q + 1):
        for j in range(i):
            place = right.setdefault(i - 1 - j, [Fraction(0)] * r)
            for row in range(r):
                place[row] += sum(A[i][row][column] * initial[j][column] for column in range(r))
    if not right:
        return {m: [Fraction(0)] * r for m in range(lowest, 1)}
    H = laurent(A, lowest - max(right))
    X = {m: [Fraction(0)] * r for m in range(lowest, max(H) + max(right) + 1)}
    for k, vector in right.items():
        for i, matrix in H.items():
            if i + k >= lowest:
                for row in range(r):
                    X[i + k][row] += sum(matrix[row][column] * vector[column] for column in range(r))
    return X


class ExactResponse:
    """Impulses, values at 0+ and the Taylor sum of x, all from the Laurent coefficients of X(s).

    Attributes:
        impulses: lists (r,) of Fractions, the k-th for the k-th derivative of Dirac's delta, without zeros at the end.
        derivatives: x^(k)(0+) for k = 0 .. count - 1.
    """

    def __init__(self, A, initial, terms=(), impulses=(), count: int = 40):
        r = len(A[0])
        force = force_derivatives(terms, r, count + 3 * r * len(A)) if terms else []
        X = transform(A, initial, force, impulses, -count)
        self.impulses = [X[p] for p in range(max(X) + 1)]
        while self.impulses and not any(self.impulses[-1]):
            self.impulses.pop()
        self.derivatives = [X.get(-1 - k, [Fraction(0)] * r) for k in range(count)]

    def __call__(self, t) -> list[float]:
        """x(t) by its Taylor series, for t small enough that the terms have died out at the end of the series."""
        t = Fraction(t)
        r = len(self.derivatives[0])
        terms = [[d[i] * t**k / factorial(k) for i in range(r)] for k, d in enumerate(self.derivatives)]
        last = max((abs(c) for row in terms[-3:] for c in row), default=0)
        if last > Fraction(1, 10**17) * max((abs(c) for row in terms for c in row), default=0):
            raise ArithmeticError("the Taylor series has not converged: take a smaller t or more terms")
        return [float(sum(row[i] for row in terms)) for i in range(r)]
