"""A Campbell diagram next to a loop over NumPy that a user would write: ratio in one run, one thread.

    python tests/benchmarks/campbell.py [DISCS] [SPEEDS]

Discs on a shaft with different stiffness in both planes, undamped and damped. The loop takes numpy.linalg.eigvals of the first-order matrix at
each speed and sorts the frequencies; it has no shapes, no direction of whirl, and swaps modes where they cross.
"""

from __future__ import annotations

import sys
import time

import numpy as np
from threadpoolctl import threadpool_limits

import mbconstrained as mb


def rotor(discs, damping):
    """M, C, K, G of discs on a shaft."""
    random = np.random.default_rng(0)
    chain = 2 * np.eye(discs) - np.eye(discs, k=1) - np.eye(discs, k=-1)
    K = np.kron(chain, np.diag([1.0, 1.2]))
    M = np.diag(np.repeat(random.uniform(0.5, 2.0, discs), 2))
    G = np.kron(np.diag(random.uniform(0.1, 0.4, discs)), [[0.0, 1.0], [-1.0, 0.0]])
    return M, damping * K, K, G


def looped(M, C, K, G, speeds):
    """Sorted frequencies at each speed."""
    n, frequencies = len(M), []
    for speed in speeds:
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C + speed * G)]])
        values = np.linalg.eigvals(A)
        frequencies.append(np.sort(values.imag[values.imag > 0]))
    return np.array(frequencies)


def fastest(work, repeats=5):
    """The shortest time in s, and the result."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - begin)
    return min(times), result


def main(discs=21, count=101):
    """Print both times, their ratio and the largest difference of sorted frequencies."""
    speeds = np.linspace(0.0, 3.0, count)
    for label, damping in (("undamped", 0.0), ("damped", 0.01)):
        M, C, K, G = rotor(discs, damping)
        system = mb.MechanicalSystem(M, C, K, gyroscopic=G)
        with threadpool_limits(1):
            loop, expected = fastest(lambda: looped(M, C, K, G, speeds))
            own, diagram = fastest(lambda: system.campbell(speeds))
            critical, _ = fastest(system.critical_speeds)
        difference = np.abs(np.sort(diagram.damped_frequencies, axis=1) - expected).max()
        print(
            f"{label}, {2 * discs} coordinates, {count} speeds: loop {loop:.3f} s, campbell {own:.3f} s, ratio {own / loop:.2f}, "
            f"{diagram.evaluations} spectra, difference {difference:.1e}; critical speeds {critical:.4f} s"
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
