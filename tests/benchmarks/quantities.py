"""What modes and the quantities of a motion cost: modes relative to LAPACK, quantities relative to the displacement.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/quantities.py [size ...]

Chains of random masses, springs and dampers, in one process, in turns, the least time of several repeats. Modes: from the matrices,
with shapes, shares of energy and residuals, to ``numpy.linalg.eig`` of the same first-order matrix (damped) and to
``scipy.linalg.eigh`` (undamped); and the same without shares. Quantities: of a chain with one constraint row, at 1000 times, first
evaluation of a new motion and further ones.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import scipy.linalg

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import mbconstrained as mb

SIZES = (2, 20, 50, 100, 200)
TIMES = np.linspace(0.0, 100.0, 1000)
QUANTITIES = ("displacement", "velocity", "acceleration", "reaction", "energy")


def chain(n: int, damped: bool) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """M, C, K of n masses between two walls."""
    random = np.random.default_rng(n)
    springs, dampers = random.uniform(0.5, 2.0, n + 1), random.uniform(0.0, 0.05, n + 1)
    K, C = (np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1) for k in (springs, dampers))
    return np.diag(random.uniform(0.5, 2.0, n)), C if damped else None, K


def least(*work, repeats: int = 5) -> list[float]:
    """The least time of each function, by turns, in s."""
    times = [[] for _ in work]
    for _ in range(repeats):
        for own, function in zip(times, work):
            begin = time.perf_counter()
            function()
            own.append(time.perf_counter() - begin)
    return [min(own) for own in times]


def modes(n: int, damped: bool) -> str:
    """Times of the reference, of modes with shapes and evidence, and of these with shares of energy."""
    M, C, K = chain(n, damped)

    def reference():
        if not damped:
            return scipy.linalg.eigh(K, M)
        return np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]]))

    def found(shares: bool):
        result = mb.MechanicalSystem(M, C, K).modes()
        return result.shapes, result.residuals, shares and result.shares

    lapack, shapes, whole = least(reference, lambda: found(False), lambda: found(True))
    kind = "damped" if damped else "undamped"
    return f"{n:5d} {kind:9s} {lapack * 1e3:9.2f} ms {shapes * 1e3:9.2f} ms ({shapes / lapack:5.1f}) {whole * 1e3:9.2f} ms ({whole / lapack:5.1f})"


def quantities(n: int) -> str:
    """Ratios to the displacement, of the first and of further evaluations."""
    M, C, K = chain(n, True)
    row, load = np.zeros(n), np.eye(n)[0]
    row[0], row[n // 2] = 1.0, -1.0
    system = mb.MechanicalSystem(M, C, K, constraints=[mb.Constraint(row)])
    start = np.random.default_rng(0).normal(size=n)
    start[n // 2] = start[0]
    first = least(*(lambda name=name: getattr(system.solve(start, force=load), name)(TIMES) for name in QUANTITIES))
    motion = system.solve(start, force=load)
    further = least(*(lambda name=name: getattr(motion, name)(TIMES) for name in QUANTITIES))
    ratios = (f"{name} {a / first[0]:.1f}/{b / further[0]:.1f}" for name, a, b in zip(QUANTITIES[1:], first[1:], further[1:]))
    return f"{n:5d} displacement {first[0] * 1e3:.2f}/{further[0] * 1e3:.2f} ms; {', '.join(ratios)}"


def main() -> None:
    """Print both tables."""
    sizes = tuple(map(int, sys.argv[1:])) or SIZES
    print("modes: LAPACK, shapes and residuals, with shares (ratios)")
    for n in sizes:
        for damped in (True, False):
            print(modes(n, damped), flush=True)
    print("quantities, first/further evaluation: ratios to the displacement")
    for n in sizes:
        print(quantities(n), flush=True)


if __name__ == "__main__":
    main()
