"""Partial multiplicities of a Gaussian rational zero in exact arithmetic, from the Taylor coefficients of A(s) there.

The block Toeplitz matrix of A(z), A'(z), A''(z)/2, ... with k block rows has the nullity sum of min(k, degree) over
the elementary divisors of z. Numbers are pairs (Re, Im) of Fractions, a complex matrix is [[Re, -Im], [Im, Re]].
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import comb


def partial_multiplicities(A, zero: complex, multiplicity: int) -> list[int]:
    """Ascending degrees of the elementary divisors of the zero, whose real and imaginary part are exact floats."""
    z = Fraction(float(zero.real)), Fraction(float(zero.imag))
    taylor = [_taylor(A, z, order) for order in range(multiplicity)]
    nullities = [0] + [_nullity(_toeplitz(taylor[:k])) for k in range(1, multiplicity + 1)]
    longer = [after - before for before, after in pairwise(nullities)] + [0]
    return [k + 1 for k in range(multiplicity) for _ in range(longer[k] - longer[k + 1])]


def _taylor(A, z, order):
    """A^(order)(z) / order! as (real part, imaginary part)."""
    r, power, weights = len(A[0]), (Fraction(1), Fraction(0)), []
    for _ in range(order, len(A)):
        weights.append(power)
        power = power[0] * z[0] - power[1] * z[1], power[0] * z[1] + power[1] * z[0]
    return tuple(
        [
            [
                sum((comb(order + k, order) * w[part] * A[order + k][i][j] for k, w in enumerate(weights)), Fraction(0))
                for j in range(r)
            ]
            for i in range(r)
        ]
        for part in (0, 1)
    )


def _toeplitz(taylor):
    """The block lower triangular Toeplitz matrix of the complex coefficients, as a real one of twice the size."""
    count, r = len(taylor), len(taylor[0][0])
    size = count * r
    M = [[Fraction(0)] * (2 * size) for _ in range(2 * size)]
    for row in range(count):
        for column in range(row + 1):
            real, imaginary = taylor[row - column]
            for i in range(r):
                for j in range(r):
                    at, to = row * r + i, column * r + j
                    M[at][to] = M[size + at][size + to] = real[i][j]
                    M[at][size + to], M[size + at][to] = -imaginary[i][j], imaginary[i][j]
    return M


def _nullity(M) -> int:
    """Of the complex matrix: half that of the real one, whose rank Gauss's elimination gives."""
    M, rank, columns = [row[:] for row in M], 0, len(M[0])
    for column in range(columns):
        pivot = next((i for i in range(rank, len(M)) if M[i][column]), None)
        if pivot is None:
            continue
        M[rank], M[pivot] = M[pivot], M[rank]
        for i in range(rank + 1, len(M)):
            if M[i][column]:
                factor = M[i][column] / M[rank][column]
                M[i] = [a - factor * b for a, b in zip(M[i], M[rank])]
        rank += 1
    return (columns - rank) // 2
