"""The error estimate of random systems against their proved errors.

    python tests/benchmarks/estimate_against_enclosure.py [systems]

For each the ratio estimate / true error, errors below eight roundings counted as eight: below 0.1 the estimate is too low,
above 1000 it frightens. Prints, by kind of system, how many lie outside, the extremes, the digits that the answers have and
what exact arithmetic takes beside the numeric answer.
"""

import sys
import time
from collections import defaultdict

import numpy as np

from tests.exact.enclosure.random_systems import random_problem

EPS = np.finfo(float).eps


def main(count: int) -> None:
    found = defaultdict(list)
    for seed in range(count):
        begun = time.perf_counter()
        x, times, kind = random_problem(seed)
        values = x(times)
        solved = time.perf_counter()
        box = x.enclose(times)
        enclosed = time.perf_counter()
        largest = np.abs(values).max()
        error = max(box.error_bounds(values).max() / largest, 8 * EPS)
        estimate = max(x.error_estimate(times), 8 * EPS)
        found[kind].append((estimate / error, error, enclosed - solved, solved - begun, bool(box.notices), seed))
    print(
        f"{'kind':18s} {'systems':>7s} {'low':>4s} {'high':>5s} {'least':>8s} {'most':>8s} {'median digits':>13s} {'least digits':>12s} {'exact/numeric time':>19s}"
    )
    for kind, rows in [*found.items(), ("all", [row for cases in found.values() for row in cases])]:
        ratio, error, exact, numeric, _, seeds = map(np.array, zip(*rows))
        low, high = np.count_nonzero(ratio < 0.1), np.count_nonzero(ratio > 1e3)
        digits = -np.log10(error)
        print(
            f"{kind:18s} {len(rows):7d} {low:4d} {high:5d} {ratio.min():8.2g} {ratio.max():8.2g} {np.median(digits):13.1f} "
            f"{digits.min():12.1f} {np.median(exact / numeric):19.2f}"
        )
        if kind != "all":
            print(
                "".join(
                    f"    seed {s}: estimate / error {r:.2g}, error {e:.2g}\n" for r, e, s in zip(ratio, error, seeds) if r < 0.1
                ),
                end="",
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
