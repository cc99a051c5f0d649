"""Set-up beside one decomposition of the same size, evaluation beside the bare product and exponentials that it needs.

Times are uneven, so that the answer goes through a decomposition. What our set-up takes is a first run at such times less a
further evaluation at others.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import scipy.linalg
from threadpoolctl import threadpool_limits

from mbconstrained.analyses.timing import Timing, small_heap, timed, without_garbage_collection
from mbconstrained.scene.run.plan import OutOfTime, time_limit
from tests.benchmarks.speed.measure import WARMING, Effort
from tests.benchmarks.speed.models import chain, forty_periods
from tests.benchmarks.speed.reductions import reduced_chain
from tests.benchmarks.speed.workloads import chain_system

#: Numbers of masses, without dampers and with.
SIZES, DAMPED_SIZES = (100, 300, 500, 1000), (100, 300, 500, 1000)

#: Our set-up and evaluation are to take at most so many times the bare ones.
WANTED = 2.0

TIMES = 1000


@dataclass(frozen=True)
class SetUp:
    """One size.

    Attributes:
        name, states: of the model.
        set_up, decomposition: ours, and that of scipy.linalg.eigh or eig at its better number of threads.
        further, bare: evaluation at 1000 uneven times, ours and the product with the exponentials.
        failure: why there is no answer.
    """

    name: str
    states: int
    set_up: Timing | None = None
    decomposition: Timing | None = None
    further: Timing | None = None
    bare: Timing | None = None
    failure: str = ""

    def as_json(self) -> dict:
        """As plain data."""
        plain = {"name": self.name, "states": self.states}
        if self.failure:
            return plain | {"failure": self.failure}
        parts = ("set_up", "decomposition", "further", "bare")
        return plain | {part: getattr(self, part).to_dict() for part in parts}


def set_ups(effort: Effort, largest: int) -> list[Callable[[], SetUp]]:
    """Each size as a task, ascending."""
    sizes = [(count, False) for count in SIZES] + [(count, True) for count in DAMPED_SIZES]
    return [
        lambda count=count, damped=damped: set_up(count, damped, effort)
        for count, damped in sorted(sizes, key=lambda size: size[0] * (1 + size[1]))
        if count <= largest
    ]


def set_up(count: int, damped: bool, effort: Effort) -> SetUp:
    """Ours, the decomposition and the bare evaluation in turns."""
    given = chain(count, damped, damped_joints=damped)
    name = f"{'damped' if damped else 'undamped'} chain, n = {count}"
    random = np.random.default_rng(count)
    grids = [np.sort(random.uniform(0.0, forty_periods(count), TIMES)) for _ in range(WARMING + 2)]
    decompose, evaluate = _bare(given, damped)
    found: dict[tuple[str, int], list[float]] = {}
    spent = 0.0
    try:
        with without_garbage_collection(), small_heap():
            for turn in range(effort.repeats + 1):
                if spent > (effort.seconds if turn > effort.least else effort.patience):
                    break
                begun = perf_counter()
                for key, seconds in _turn(given, decompose, evaluate, grids, effort.limit):
                    found.setdefault(key, []).append(seconds)
                spent += perf_counter() - begun
    except OutOfTime:
        return SetUp(name, given.states, failure=f"not run to its end: over {effort.limit:g} s")
    return SetUp(name, given.states, *(_best(found, part) for part in ("set_up", "decomposition", "further", "bare")))


def _turn(given, decompose, evaluate, grids, limit: float):
    with time_limit(limit):
        motion, first = timed(lambda: chain_system(given).solve(given.start))
        first += timed(lambda: motion(grids[0]))[1]
        for grid in grids[1:-1]:
            motion(grid)
        further = timed(lambda: motion(grids[-1]))[1]
    yield ("set_up", 0), max(first - further, 0.0)
    yield ("further", 0), further
    for threads in {1, os.cpu_count() or 1}:
        with threadpool_limits(threads), time_limit(limit):
            yield ("decomposition", threads), timed(decompose)[1]
            yield ("bare", threads), timed(lambda: evaluate(grids[0]))[1]


def _best(found: dict, part: str) -> Timing:
    """At the better number of threads, the first turn not counted."""
    timings = [Timing(tuple(seconds[1:] or seconds)) for (name, _), seconds in found.items() if name == part]
    return min(timings, key=lambda timing: timing.median)


def _bare(given, damped: bool):
    """The decomposition of the reduced equations, and product and exponentials of as many pairs and coordinates."""
    equations = reduced_chain(given)
    if not damped:
        roots = np.sqrt(np.diag(equations.mass))
        symmetric = equations.stiffness / np.outer(roots, roots)
        frequencies = np.sqrt(np.maximum(np.linalg.eigvalsh(symmetric), 0.0))
        coefficients = equations.E[:, : given.count] @ np.eye(given.count)
        return lambda: scipy.linalg.eigh(symmetric), lambda times: coefficients @ np.cos(np.outer(frequencies, times))
    values = scipy.linalg.eigvals(equations.S)
    half = values[values.imag >= 0]
    coefficients = np.random.default_rng(0).standard_normal((given.size, 2 * len(half)))

    def evaluate(times):
        waves = np.exp(np.outer(half, times))
        return coefficients @ np.concatenate([waves.real, waves.imag])

    return lambda: scipy.linalg.eig(equations.S), evaluate
