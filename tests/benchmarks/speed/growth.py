"""How time and memory grow with the size of dense models, each size in a process of its own."""

import json
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from mbconstrained.scene.run.plan import Costs
from tests.benchmarks.speed.measure import LESS, SHORTER, WARMING
from tests.benchmarks.speed.models import chain, even_times, forty_periods
from tests.benchmarks.speed.workloads import chain_system

SCRIPT = Path(__file__).resolve().parents[1] / "speed.py"

SIZES = (10, 30, 100, 300, 1000)

#: The exponent is fitted to so many of the largest sizes: below, what does not grow outweighs what does.
FITTED = 3

#: Times of the answer.
TIMES = 1000


@dataclass(frozen=True)
class Grown:
    """One size, the damped chain at 1000 even times.

    Attributes:
        count, coordinates, states: of the model.
        seconds: of one run.
        further: of a further evaluation at other even times, s.
        memory: highest resident memory of one run and some further evaluations above that before, bytes.
        failure: why there is no answer.
    """

    count: int
    coordinates: int
    states: int
    seconds: float = 0.0
    further: float = 0.0
    memory: float = 0.0
    failure: str = ""

    @property
    def answer(self) -> float:
        """Bytes of the answer itself."""
        return 8.0 * self.coordinates * TIMES

    @property
    def matrices(self) -> float:
        """Memory beyond the answer, in matrices of the finite size squared."""
        return max(self.memory - self.answer, 0.0) / (8.0 * self.states**2)

    def as_json(self) -> dict:
        """As plain data."""
        return asdict(self)


def grown(count: int, limit: float) -> Grown:
    """One size in a new process."""
    sizes = chain(count)
    plain = (count, sizes.size, sizes.states)
    command = [sys.executable, str(SCRIPT), "--grow", str(count)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return Grown(*plain, failure=f"not run to its end: over {limit:g} s")
    if done.returncode:
        return Grown(*plain, failure=(done.stderr.strip().splitlines() or ["no reason given"])[-1][:200])
    return Grown(*plain, **json.loads(done.stdout))


def grow(count: int) -> None:
    """In the other process: prints what it took, after everything has been called once with a small model."""
    for size in (10, 60):
        chain_system(chain(size)).solve(chain(size).start)(even_times(forty_periods(size), TIMES))
    given, times = chain(count), even_times(forty_periods(count), TIMES)
    costs = Costs()
    begun = perf_counter()
    motion = chain_system(given).solve(given.start)
    motion(times)
    seconds = perf_counter() - begun
    for place in range(WARMING):
        motion((SHORTER - LESS * place) * times)
    begun = perf_counter()
    motion((SHORTER - LESS * WARMING) * times)
    further = perf_counter() - begun
    print(json.dumps({"seconds": seconds, "further": further, "memory": costs.lap("").memory or 0}))


def exponent(sizes, values) -> float | None:
    """p with values about c sizes^p, by least squares of logarithms over the largest sizes; None without two of them.

    >>> round(exponent([10, 100, 1000], [3e2, 3e4, 3e6]), 3)
    2.0
    """
    pairs = [(size, value) for size, value in zip(sizes, values) if value > 0][-FITTED:]
    if len(pairs) < 2:
        return None
    return float(np.polyfit(*np.log(np.array(pairs, dtype=float)).T, 1)[0])
