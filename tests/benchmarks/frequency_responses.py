"""Frequency responses next to python-control's own evaluation, pyyeti and one sparse factorization for each line: ratios in one run.

    python tests/benchmarks/frequency_responses.py            # full and sparse models, chains of 100 and 500 masses

Peers are evaluated at fewer lines where they take long, and their times multiplied; decompositions are included. Errors are against
50 digits (mpmath, a tridiagonal elimination) at some lines, the stop band among them.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [] if str(ROOT) in sys.path else [str(ROOT)]

import mbconstrained as mb  # noqa: E402
from tests.frequency.references import chain_solved, relative_error  # noqa: E402


def chain(n):
    """Unit masses and springs between two walls, light damping that modes do not separate."""
    K = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return np.eye(n), 1e-3 * K + 0.01 * np.diag(np.arange(n) / n), K


def timed(function, repeats=3):
    """The best time of some runs, and the result."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        result = function()
        best = min(best, time.perf_counter() - begin)
    return best, result


def own(matrices, frequencies, names):
    """This package, the system built anew."""
    M, C, K = matrices
    return mb.MechanicalSystem(M, C, K).frequency_response(frequencies, names, names)


def by_control(matrices, frequencies, places):
    """python-control's own evaluation (slycot is not installed)."""
    import control

    M, C, K = matrices
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    B, D = np.vstack([np.zeros((n, 2)), np.linalg.inv(M)[:, places]]), np.zeros((2, 2))
    return control.ss(A, B, np.eye(2 * n)[places], D)(2j * np.pi * frequencies)


def by_pyyeti(matrices, frequencies, places):
    """pyyeti's complex modes."""
    from pyyeti import ode

    M, C, K = matrices
    solver, result = ode.SolveUnc(M, C, K), []
    for place in places:
        force = np.zeros((len(M), len(frequencies)))
        force[place] = 1.0
        result.append(solver.fsolve(force, frequencies, incrb="dva").d[places])
    return np.array(result)


def by_splu(matrices, frequencies, places):
    """One sparse factorization for each line."""
    M, C, K = map(scipy.sparse.csc_array, matrices)
    B = np.zeros((M.shape[0], len(places)), dtype=complex)
    B[places, range(len(places))] = 1.0
    return [splu(K + 1j * w * C - w * w * M).solve(B)[places] for w in 2 * np.pi * frequencies]


def compare(n, lines, peers):
    """One table."""
    matrices, places = chain(n), [0, n // 2]
    names = [f"x{place + 1}" for place in places]
    frequencies = np.geomspace(1e-3, 3.0 if n < 200 else 0.6, lines)
    seconds, H = timed(lambda: own(matrices, frequencies, names))
    M, C, K = matrices
    worst, covered = 0.0, True
    for line in [*range(0, lines, lines // 12), lines - 1]:
        exact = [chain_solved((K, C, M), frequencies[line], place) for place in places]
        for i, place in enumerate(places):
            for j in range(2):
                error = relative_error(H.values[i, j, line], exact[j][place])
                worst, covered = max(worst, error), covered and error <= max(H.error_estimate[i, j, line], 2e-16)
    print(f"n = {n}, {lines} lines, 2 x 2: {seconds:.3f} s, error {worst:.1e}, covered by the estimate: {covered}")
    print(
        f"  largest estimate {H.error_estimate.max():.1e}; lines above 1e-10: {(H.error_estimate.max(axis=(0, 1)) > 1e-10).sum()}"
    )
    for name, peer, part in peers:
        other, _ = timed(lambda: peer(matrices, frequencies[::part], places), 1)
        print(f"  {name}: {other * part:.3f} s, ratio {seconds / (other * part):.3f}")


def full(n=500, lines=1_000):
    """A full symmetric model with damping that modes do not separate, next to one factorization for each line."""
    random = np.random.default_rng(0)
    Q, G = np.linalg.qr(random.standard_normal((n, n)))[0], random.standard_normal((n, n))
    K = Q * np.geomspace(1.0, 1e4, n) @ Q.T
    matrices = np.eye(n), 0.002 * (K + K.T) / 2 + 4e-4 * G @ G.T / n, (K + K.T) / 2
    frequencies = np.geomspace(0.05, 20.0, lines)
    seconds, H = timed(lambda: own(matrices, frequencies, ["x1", "x2"]), 1)
    other, _ = timed(lambda: by_splu(matrices, frequencies[:: lines // 5], [0, 1]), 1)
    M, C, K = matrices
    dense, _ = timed(
        lambda: [np.linalg.solve(K + 1j * w * C - w * w * M, np.eye(n)[:, :2]) for w in 6.28 * frequencies[:: lines // 5]], 1
    )
    print(f"full, n = {n}, {lines} lines: {seconds:.2f} s, largest estimate {H.error_estimate.max():.1e}")
    print(f"  splu: ratio {seconds / (other * lines / 5):.3f}; LAPACK for each line: ratio {seconds / (dense * lines / 5):.3f}")


def sparse(side=316, lines=200, count=20):
    """A membrane of 1e5 coordinates by 20 modes, next to one factorization of one line."""
    line = scipy.sparse.diags_array([-np.ones(side - 1), 2 * np.ones(side), -np.ones(side - 1)], offsets=[-1, 0, 1])
    eye = scipy.sparse.eye_array(side)
    K = scipy.sparse.csc_array(scipy.sparse.kron(line, eye) + scipy.sparse.kron(eye, line))
    M = scipy.sparse.csc_array(scipy.sparse.eye_array(side**2))
    system = mb.MechanicalSystem(M, 1e-3 * K, K)
    modes, found = timed(lambda: system.modes(count=count), 1)
    names, frequencies = [f"x{side**2 // 3}", f"x{side**2 // 2}"], np.linspace(0.1, 0.8, lines) * found.frequencies_hz[-1]
    seconds, H = timed(lambda: system.frequency_response(frequencies, names, names, count=count), 1)
    one, _ = timed(lambda: by_splu((M, 1e-3 * K, K), frequencies[:1], [0]), 1)
    print(
        f"sparse, n = {side**2}: modes {modes:.1f} s, {lines} lines {seconds:.2f} s, largest bound {H.error_estimate.max():.1e}; splu {one:.2f} s a line"
    )


if __name__ == "__main__":
    full()
    sparse()
    compare(
        100, 10_000, [("python-control", by_control, 500), ("pyyeti SolveUnc", by_pyyeti, 1), ("splu for each line", by_splu, 20)]
    )
    compare(500, 1_000, [("splu for each line", by_splu, 5)])
