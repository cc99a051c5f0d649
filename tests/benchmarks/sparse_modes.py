"""What modes of large sparse systems cost, beside one shift-invert run of ARPACK on the same constrained pencil.

    python tests/benchmarks/sparse_modes.py [size ...]

Chains with ties and massless joints: n masses, 1.2 n coordinates, n / 10 rows, 50 modes. In one process for each size our time
and ARPACK's (scipy.sparse.linalg.eigsh on [[K, A^T], [A, 0]], [[M, 0], [0, 0]]) take turns; medians and their ratio are told.
Memory is the peak of a child process that does nothing else, above what it had before. The exponents are those of the
straight lines through the logarithms.
"""

import json
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from mbconstrained.mechanics.sparse.undamped_modes import undamped_modes

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

SIZES = (1000, 3000, 10_000, 30_000, 100_000)
COUNT, REPETITIONS = 50, 3
TASKS = ("undamped", "arpack", "damped", "motion")


def tasks(n: int) -> dict:
    """For each name a function that does it from the start."""
    import scipy.sparse as sp
    from scipy.sparse.linalg import eigsh

    import mbconstrained as mb
    from tests.mechanics.sparse.models import tied_chain

    M, C, K, rows = tied_chain(n, damped=True)
    whole = sp.csc_array(sp.block_array([[K, rows.T], [rows, None]]))
    inertia = sp.csc_array(sp.block_diag([M, sp.csc_array((rows.shape[0],) * 2)]))
    shape = np.sin(np.pi * np.arange(1, M.shape[0] + 1) / (M.shape[0] + 1))
    shape[n : n + rows.shape[0]] = shape[5:n:10][: rows.shape[0]]
    known = mb.MechanicalSystem(M, None, K, rows)

    def motion():
        answer = known.solve(shape, count=COUNT)
        return answer.of(*range(0, n, n // 100))(np.linspace(0, 1e3 * n, 1000))

    return {
        "undamped": lambda: mb.MechanicalSystem(M, None, K, rows).modes(count=COUNT),
        "arpack": lambda: eigsh(whole, COUNT, inertia, sigma=0.0),
        "damped": lambda: mb.MechanicalSystem(M, C, K, rows).modes(count=COUNT),
        "motion": lambda: (undamped_modes(known.pencil, COUNT), motion())[1],
    }


def seconds(n: int) -> dict[str, float]:
    """Medians of repeats, all tasks by turns; the modes of the motion are found before."""
    work, found = tasks(n), {name: [] for name in TASKS}
    work["motion"]()
    for _ in range(REPETITIONS):
        for name in TASKS:
            begin = time.perf_counter()
            work[name]()
            found[name].append(time.perf_counter() - begin)
    return {name: statistics.median(times) for name, times in found.items()}


def mebibytes(n: int, name: str) -> float:
    """Peak memory of one task in this process."""
    work = tasks(n)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    work[name]()
    return (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024


def in_a_child(*words) -> dict:
    done = subprocess.run([sys.executable, __file__, "--child", *map(str, words)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def exponent(sizes, values) -> float:
    return float(np.polyfit(np.log(sizes), np.log(np.maximum(values, 1e-3)), 1)[0])


def main(sizes) -> None:
    print(f"{COUNT} modes of chains with ties and massless joints, medians of {REPETITIONS}")
    print(f"{'masses':>8} {'undamped s':>11} {'ARPACK s':>9} {'ratio':>6} {'damped s':>9} {'motion ms':>10}", end=" ")
    print(f"{'MiB':>7} {'ARPACK MiB':>11} {'damped MiB':>11}")
    table = []
    for n in sizes:
        times = in_a_child("seconds", n)
        memory = {name: in_a_child("memory", n, name)["memory"] for name in ("undamped", "arpack", "damped")}
        table.append((times["undamped"], times["arpack"], times["damped"], *memory.values()))
        print(
            f"{n:8d} {times['undamped']:11.3f} {times['arpack']:9.3f} {times['undamped'] / times['arpack']:6.2f} "
            f"{times['damped']:9.2f} {1e3 * times['motion']:10.1f} {memory['undamped']:7.0f} {memory['arpack']:11.0f} {memory['damped']:11.0f}",
            flush=True,
        )
    if len(sizes) > 1:
        names = ("time undamped", "time ARPACK", "time damped", "memory undamped", "memory ARPACK", "memory damped")
        fitted = (f"{name} {exponent(sizes, column):.2f}" for name, column in zip(names, zip(*table)))
        print("exponents: " + ", ".join(fitted))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        n = int(sys.argv[3])
        print(json.dumps(seconds(n) if sys.argv[2] == "seconds" else {"memory": mebibytes(n, sys.argv[4])}))
    else:
        main([int(float(word)) for word in sys.argv[1:]] or list(SIZES))
