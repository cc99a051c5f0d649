"""Infinite zeros of high order, defective chains, clusters of zeros."""

from __future__ import annotations

from math import comb

import numpy as np

from ....signals.inputs import harmonic, term
from ...study_problem import StudyProblem
from .entry import decades, declares, equations, family, spaced

#: Referee case nilpotent5: a nilpotent block of size 5 and a zero at -1, mixed by matrices of whole numbers with determinant 1.
NILPOTENT_5 = [
    [
        [1, 0, -1, 0, 0, 0],
        [0, 1, -1, 0, 4, -2],
        [0, 0, 1, 0, 0, 0],
        [-1, -1, 1, 1, -3, 1],
        [1, 1, -1, -1, 4, -1],
        [1, 1, 0, -1, 2, 0],
    ],
    [[0, 1, 0, 0, 3, -1], [0, 0, 0, 0, 1, -1], [0, 0, 0, 1, 0, 0], [0, -1, -1, 0, -2, 1], [0, 1, 1, 0, 2, -1], [0, 1, 2, 0, 1, 0]],
]


@family("structure", "order of the infinite zero", (1.0, 2.0, 3.0, 4.0, 5.0))
@declares(
    finite_zeros=1,
    infinite_order=lambda order: int(order),
    impulses=lambda order: int(order),
    infinite_divisors=lambda order: (int(order) + 1,),
    jumps=True,
)
def infinite_order(order: float) -> StudyProblem:
    """Infinite zeros of order 1 to 5, with as many impulses.

    The answer holds delta, delta', ... up to one less than the order; a rank decided wrong adds or loses one.
    """
    # s N - I with N nilpotent of size order + 1, and a zero at -1, mixed; the start fits nothing.
    size = int(order) + 2
    first, last = np.eye(size), np.eye(size, k=1)
    last[-2, -1], last[-1, -1] = 0.0, 1.0
    lower = np.tril(np.ones((size, size)))
    upper = lower.T + np.triu(np.ones((size, size)), 2)
    coefficients = [lower @ matrix @ upper for matrix in (first, last)]
    start = np.arange(1.0, size + 1) * (-1.0) ** np.arange(size)
    return equations(coefficients, [start], spaced(0.05, 12.0), harmonic(np.ones(size), angular_frequency=2.0))


@family("structure", "frequency of the force", (0.0, 0.1, 2.0, 10.0, *decades(2, 8)), "rad/s")
@declares(finite_zeros=1, infinite_order=4, infinite_divisors=(5,), impulses=4, jumps=True)
def differentiated_force(frequency: float) -> StudyProblem:
    """A force differentiated four times.

    A chain of length 5 at infinity differentiates: at high frequencies the answer is w^4 times the force.

    Source: referee case nilpotent5.
    """
    vector, start = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0], [[0.0, -0.25, 1.5, 1.5, -1.75, -1.25]]
    force = term(vector, rate=-0.5, angular_frequency=frequency, phase=-np.pi / 2)
    return equations(NILPOTENT_5, start, spaced(0.05, 12.0), force)


@family("structure", "length of the chain", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0))
@declares(finite_zeros=lambda n: int(n), longest_chain=lambda n: int(n), growing_zeros=0)
def chain_length(length: float) -> StudyProblem:
    """A Jordan chain of increasing length, with a force at its zero.

    Rounding parts n equal zeros by eps^(1/n), a percent at n = 8; their sum must not show it.

    Source: referee case jordan3_scalar.
    """
    # (s + 3/2)^length with a force at the same zero.
    n = int(length)
    coefficients = [[[comb(n, power) * 1.5 ** (n - power)]] for power in range(n + 1)]
    start = [[1.0], [0.0], [-2.0], *[[0.0]] * n][:n]
    return equations(coefficients, start, spaced(0.02, 15.0), term([2.0], power=1, rate=-1.5))


@family("structure", "width of the cluster", (0.25, *decades(-1, -12)), "1/s")
@declares(finite_zeros=4, growing_zeros=0, infinite_divisors=())
def cluster_of_zeros(width: float) -> StudyProblem:
    """A cluster of four zeros.

    At a width of 1e-4 they are four and look like one: neither their eigenvectors nor one chain describe them.
    """
    # (s + 1) (s + 1 + d) (s + 1 - d) (s + 1 + 2 d), multiplied out and rounded.
    polynomial = np.poly(-1.0 - width * np.array([0.0, 1.0, -1.0, 2.0]))
    return equations([[[value]] for value in polynomial[::-1]], [[1.0], [0.0], [-1.0], [2.0]], spaced(0.02, 20.0))


@family("structure", "coupling", decades(-2, 4), "1/s")
@declares(finite_zeros=10, growing_zeros=0, longest_chain=1)
def transient_growth(coupling: float) -> StudyProblem:
    """Ten decays in series, each exciting the next.

    All motions decay, but not before they have grown: the eigenvectors are nearly parallel.

    Source: made for this gallery, after Trefethen and Embree, Spectra and Pseudospectra (2005).
    """
    # x_i' = -(1 + i / 10) x_i + c x_(i+1): before it decays, what begins in the last grows by powers of c.
    size = 10
    rates = np.diag(1 + np.arange(size) / 10) - coupling * np.eye(size, k=1)
    return equations([rates, np.eye(size)], np.eye(size)[-1], spaced(0.01, 50.0))


@family("structure", "number of zeros", (2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0))
@declares(finite_zeros=lambda n: int(n), growing_zeros=0, zeros_at_0=0)
def wilkinson(count: float) -> StudyProblem:
    """The zeros -1, -2, ..., -n.

    At n = 20 the last digit of a coefficient moves zeros by more than their distance; the motion moves by less.

    Source: Wilkinson, Rounding Errors in Algebraic Processes (1963).
    """
    # (s + 1) (s + 2) ... (s + n) x = 0: the polynomial whose zeros Wilkinson found to hang on its last digits.
    coefficients = np.poly(-np.arange(1.0, count + 1))[::-1]
    start = np.eye(int(count))[-1]
    return equations([[[c]] for c in coefficients], start, spaced(0.05, 20.0))
