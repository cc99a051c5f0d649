"""What discrete time costs relative to scipy.signal: responses to given samples, and discretization.

    python tests/benchmarks/discrete_time.py [repetitions]

Prints medians in milliseconds of both in the same process, and their ratio.
"""

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np
import scipy.signal

import mbconstrained as mb


def main(repetitions: int) -> None:
    print(f"{'question':34s} {'own (ms)':>10s} {'scipy (ms)':>11s} {'ratio':>8s}")
    for name, own, reference in questions():
        times = [median(work, repetitions) for work in (own, reference)]
        print(f"{name:34s} {times[0]:10.2f} {times[1]:11.2f} {times[0] / times[1]:8.2f}")


def median(work: Callable[[], object], repetitions: int) -> float:
    """Milliseconds."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(times)


def questions():
    random = np.random.default_rng(0)
    for n, count in ((4, 50), (40, 50), (40, 1000), (4, 100_000)):
        A, B, C = random.standard_normal((n, n)), random.standard_normal((n, 1)), random.standard_normal((1, n))
        A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
        u, D = random.standard_normal((count, 1)), np.zeros((1, 1))
        system, reference = mb.DiscreteStateSpace(A, B, C), scipy.signal.StateSpace(A, B, C, D, dt=1.0)
        yield (
            f"{n} states, {count} samples",
            lambda system=system, u=u: system.solve(input=u).output(np.arange(len(u))),
            lambda reference=reference, u=u: scipy.signal.dlsim(reference, u),
        )
    for n in (4, 40):
        A, B, C = random.standard_normal((n, n)), random.standard_normal((n, 1)), random.standard_normal((1, n))
        for hold, name in enumerate(("zoh", "foh")):
            yield (
                f"{n} states, discretized, hold={hold}",
                lambda A=A, B=B, C=C, hold=hold: mb.StateSpace(A, B, C).discretize(0.1, hold),
                lambda A=A, B=B, C=C, name=name: scipy.signal.cont2discrete((A, B, C, np.zeros((1, 1))), 0.1, name),
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
