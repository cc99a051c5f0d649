"""Infinite zeros of high order, defective chains, clusters of zeros."""

from __future__ import annotations

from math import comb

import numpy as np

from ....signals import harmonic, term
from ...problem import Problem
from .building import equations, spaced
from .system import System, Varied, decades

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


def infinite_order(order: float) -> Problem:
    """s N - I with N nilpotent of size order + 1, and a zero at -1, mixed; the start fits nothing."""
    size = int(order) + 2
    first, last = np.eye(size), np.eye(size, k=1)
    last[-2, -1], last[-1, -1] = 0.0, 1.0
    lower = np.tril(np.ones((size, size)))
    upper = lower.T + np.triu(np.ones((size, size)), 2)
    coefficients = [lower @ matrix @ upper for matrix in (first, last)]
    start = np.arange(1.0, size + 1) * (-1.0) ** np.arange(size)
    return equations("An infinite zero", coefficients, [start], spaced(0.05, 12.0), harmonic(np.ones(size), angular_frequency=2.0))


def differentiated_force(frequency: float) -> Problem:
    """Four derivatives of a sine are in the answer."""
    vector, start = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0], [[0.0, -0.25, 1.5, 1.5, -1.75, -1.25]]
    force = term(vector, rate=-0.5, angular_frequency=frequency, phase=-np.pi / 2)
    return equations("A force differentiated four times", NILPOTENT_5, start, spaced(0.05, 12.0), force)


def chain_length(length: float) -> Problem:
    """(s + 3/2)^length with a force at the same zero."""
    n = int(length)
    coefficients = [[[comb(n, power) * 1.5 ** (n - power)]] for power in range(n + 1)]
    start = [[1.0], [0.0], [-2.0], *[[0.0]] * n][:n]
    return equations("One chain", coefficients, start, spaced(0.02, 15.0), term([2.0], power=1, rate=-1.5))


def cluster_of_zeros(width: float) -> Problem:
    """(s + 1) (s + 1 + d) (s + 1 - d) (s + 1 + 2 d), multiplied out and rounded."""
    polynomial = np.poly(-1.0 - width * np.array([0.0, 1.0, -1.0, 2.0]))
    return equations(
        "A cluster of zeros", [[[value]] for value in polynomial[::-1]], [[1.0], [0.0], [-1.0], [2.0]], spaced(0.02, 20.0)
    )


def transient_growth(coupling: float) -> Problem:
    """x_i' = -(1 + i / 10) x_i + c x_(i+1): before it decays, what begins in the last grows by powers of c."""
    size = 10
    rates = np.diag(1 + np.arange(size) / 10) - coupling * np.eye(size, k=1)
    return equations("Transient growth", [rates, np.eye(size)], np.eye(size)[-1], spaced(0.01, 50.0))


def wilkinson(count: float) -> Problem:
    """(s + 1) (s + 2) ... (s + n) x = 0: the polynomial whose zeros Wilkinson found to hang on its last digits."""
    coefficients = np.poly(-np.arange(1.0, count + 1))[::-1]
    start = np.eye(int(count))[-1]
    return equations("Wilkinson", [[[c]] for c in coefficients], start, spaced(0.05, 20.0))


SYSTEMS = (
    System(
        "infinite_order",
        "Infinite zeros of order 1 to 5, with as many impulses",
        "The answer holds delta, delta', ... up to one less than the order; a rank decided wrong adds or loses one.",
        "made for this gallery",
        Varied("order of the infinite zero", "", (1.0, 2.0, 3.0, 4.0, 5.0)),
        infinite_order,
        {
            "finite_zeros": 1,
            "infinite_order": lambda order: int(order),
            "impulses": lambda order: int(order),
            "infinite_divisors": lambda order: (int(order) + 1,),
            "jumps": True,
        },
    ),
    System(
        "differentiated_force",
        "A force differentiated four times",
        "A chain of length 5 at infinity differentiates: at high frequencies the answer is w^4 times the force.",
        "referee case nilpotent5",
        Varied("frequency of the force", "rad/s", (0.0, 0.1, 2.0, 10.0, *decades(2, 8))),
        differentiated_force,
        {"finite_zeros": 1, "infinite_order": 4, "infinite_divisors": (5,), "impulses": 4, "jumps": True},
    ),
    System(
        "chain_length",
        "One chain, longer and longer, and a force at its zero",
        "Rounding parts n equal zeros by eps^(1/n), a percent at n = 8; their sum must not show it.",
        "referee case jordan3_scalar",
        Varied("length of the chain", "", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)),
        chain_length,
        {"finite_zeros": lambda n: int(n), "longest_chain": lambda n: int(n), "growing_zeros": 0},
    ),
    System(
        "cluster_of_zeros",
        "Four zeros that come together",
        "At a width of 1e-4 they are four and look like one: neither their eigenvectors nor one chain describe them.",
        "made for this gallery",
        Varied("width of the cluster", "1/s", (0.25, *decades(-1, -12))),
        cluster_of_zeros,
        {"finite_zeros": 4, "growing_zeros": 0, "infinite_divisors": ()},
    ),
    System(
        "transient_growth",
        "Ten decays, each driving the next",
        "All motions decay, but not before they have grown: the eigenvectors are nearly parallel.",
        "made for this gallery, after Trefethen and Embree, Spectra and Pseudospectra (2005)",
        Varied("coupling", "1/s", decades(-2, 4)),
        transient_growth,
        {"finite_zeros": 10, "growing_zeros": 0, "longest_chain": 1},
    ),
    System(
        "wilkinson",
        "The zeros -1, -2, ..., -n",
        "At n = 20 the last digit of a coefficient moves zeros by more than their distance; the motion moves by less.",
        "Wilkinson, Rounding Errors in Algebraic Processes (1963)",
        Varied("number of zeros", "", (2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0)),
        wilkinson,
        {"finite_zeros": lambda n: int(n), "growing_zeros": 0, "zeros_at_0": 0},
    ),
)
