"""Families of systems next to a loop over NumPy that a user would write: ratios in one run, one thread.

    python tests/benchmarks/families.py [COUNT]

Chains of 10 masses with scattered data (20 states), damped: modes, a frequency response of 200 lines, a motion at 200 even times. The
loop takes numpy.linalg.eig of the first-order matrix and sums over its eigenvectors; errors are against single systems. Memory is the
highest that NumPy holds in another run, besides the answer, for each system: chunks add little, poles and equations are kept.
"""

import sys
import time
import tracemalloc

import numpy as np
from threadpoolctl import threadpool_limits

import mbconstrained as mb

SIZE, LINES, TIMES = 10, np.linspace(0.1, 10.0, 200), np.linspace(0.0, 10.0, 200)

#: So many systems are solved in the loop, and by single systems.
LOOPED, COMPARED = 300, 10


def chains(count):
    """M, C, K of grounded chains, data scattered by 5 %."""
    random, i = np.random.default_rng(0), np.arange(SIZE)
    m, c, k = (value * (1 + 0.05 * random.normal(size=(count, SIZE))) for value in (2.0, 1.0, 1000.0))

    def assembled(values):
        matrix = np.zeros((count, SIZE, SIZE))
        matrix[:, i, i] += values
        matrix[:, i[:-1], i[:-1]] += values[:, 1:]
        matrix[:, i[1:], i[:-1]] -= values[:, 1:]
        matrix[:, i[:-1], i[1:]] -= values[:, 1:]
        return matrix

    return m[:, :, None] * np.eye(SIZE), assembled(c), assembled(k)


def decomposed(M, C, K):
    """Eigenvalues and eigenvectors of one system, as a user would compute them."""
    A = np.block([[np.zeros((SIZE, SIZE)), np.eye(SIZE)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    return np.linalg.eig(A)


def response(M, C, K):
    """x10 by a force on x1."""
    values, vectors = decomposed(M, C, K)
    force = np.concatenate([np.zeros(SIZE), np.linalg.inv(M)[:, 0]])
    residues = vectors[SIZE - 1] * np.linalg.solve(vectors, force)
    return (residues / (2j * np.pi * LINES[:, None] - values)).sum(axis=1)


def motion(M, C, K, start):
    """x from displacements."""
    values, vectors = decomposed(M, C, K)
    amplitudes = np.linalg.solve(vectors, np.concatenate([start, np.zeros(SIZE)]))
    return ((vectors[:SIZE] * amplitudes) @ np.exp(values[:, None] * TIMES)).real


def timed(function):
    """Seconds and the result."""
    begin = time.perf_counter()
    result = function()
    return time.perf_counter() - begin, result


def memory(function):
    """Bytes at the highest, besides the result."""
    tracemalloc.start()
    result = function()
    highest = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return highest - result.nbytes


def main(count: int) -> None:
    M, C, K = chains(count)
    start = np.eye(SIZE)[-1]
    questions = {
        "modes": (
            lambda systems: systems.modes().eigenvalues,
            lambda *one: decomposed(*one)[0],
            lambda one: one.modes().eigenvalues,
        ),
        "frequency response": (
            lambda systems: systems.frequency_response(LINES, "x1", "x10").values[:, 0, 0],
            response,
            lambda one: one.frequency_response(LINES, "x1", "x10").values[0, 0],
        ),
        "motion": (
            lambda systems: systems.solve(start)(TIMES),
            lambda *one: motion(*one, start),
            lambda one: one.solve(start)(TIMES),
        ),
    }
    print(f"{count} systems of {2 * SIZE} states; the family with its error estimates\n")
    print("| question | family (s) | loop (s) | family / loop | largest difference from single systems | memory (kB/system) |")
    print("|---|---|---|---|---|---|")
    for name, (together, alone, single) in questions.items():
        systems = mb.family(M, C, K)
        own, values = timed(lambda systems=systems, together=together: together(systems))
        each = timed(lambda alone=alone: [alone(M[i], C[i], K[i]) for i in range(min(LOOPED, count))])[0]
        loop, error = each * count / min(LOOPED, count), 0.0
        for place in range(0, count, max(1, count // COMPARED)):
            exact = single(systems[place])
            error = max(error, float(np.abs(values[place] - exact).max() / np.abs(exact).max()))
        again = mb.family(M, C, K)
        kilobytes = memory(lambda again=again, together=together: together(again)) / count / 1e3
        print(f"| {name} | {own:.2f} | {loop:.2f} | {own / loop:.2f} | {error:.1e} | {kilobytes:.1f} |")


if __name__ == "__main__":
    with threadpool_limits(1):
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
