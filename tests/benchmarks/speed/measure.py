"""Run times of all methods of a workload in turns, their errors, and how many threads suit each of them.

Times are those on the wall. The package runs as a user finds it; a peer gets one thread or all, whichever is faster.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from math import isfinite
from time import perf_counter
from warnings import catch_warnings, simplefilter

import numpy as np
from threadpoolctl import threadpool_limits

from mbconstrained.analyses.timing import SMALL, Timing, small_heap, timed, without_garbage_collection
from mbconstrained.scene.run.plan import OutOfTime, time_limit
from tests.benchmarks.speed.peers import Method
from tests.benchmarks.speed.workloads import Problem

#: The times of further evaluations are shorter by this factor and a little more each time, so that their step is always new.
SHORTER, LESS = 0.97, 0.001

#: After so many evaluations at other times what is worth keeping has been found; the one after them is measured.
WARMING = 3

#: A first run that took less, in s, is not counted: it wakes the processor, and what libraries do when first called is in it.
SHORT = 0.25

#: Numbers of threads are compared by the better of two runs, by a single one where it took longer, in s.
LONG = 3.0


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        repeats, least: most and fewest runs of a method.
        seconds: after so many of its own no further one is begun, above the fewest.
        patience: after so many no further one is begun, above the first.
        limit: a single run that takes longer is broken off.
    """

    repeats: int = 9
    least: int = 3
    seconds: float = 3.0
    patience: float = 40.0
    limit: float = 60.0


@dataclass(frozen=True)
class Measured:
    """One method on one workload.

    Attributes:
        name: of the method.
        error: max |x - truth| / max |truth|, of one run and of a further evaluation at the same times, whichever is larger.
        set_up, evaluation: of one run.
        warming: the first evaluations at other times together, in which we may find what later ones use.
        further: one after them.
        threads: of the linear algebra, where that was chosen; 0 for the method's own choice.
        failure: why there is no answer.
    """

    name: str
    error: float | None = None
    set_up: Timing | None = None
    evaluation: Timing | None = None
    warming: Timing | None = None
    further: Timing | None = None
    threads: int = 0
    failure: str = ""

    @property
    def one_run(self) -> Timing:
        """Set-up and evaluation."""
        return self.set_up + self.evaluation

    def as_json(self) -> dict:
        """As plain data."""
        if self.failure:
            return {"name": self.name, "failure": self.failure}
        parts = ("set_up", "evaluation", "one_run", "warming", "further")
        return {"name": self.name, "error": self.error if isfinite(self.error) else None, "threads": self.threads} | {
            part: getattr(self, part).to_dict() for part in parts
        }


@dataclass
class Running:
    """A method while it is measured."""

    method: Method
    ours: bool
    threads: int = 0
    error: float = 0.0
    failure: str = ""
    spent: float = 0.0
    is_over: bool = False
    seconds: dict[str, list[float]] = field(default_factory=lambda: {"set_up": [], "evaluation": [], "warming": [], "further": []})

    def measured(self) -> Measured:
        """What was found."""
        if self.failure:
            return Measured(self.method.name, failure=self.failure)
        found = {name: Timing(tuple(seconds)) for name, seconds in self.seconds.items()}
        return Measured(self.method.name, self.error, threads=self.threads, **found)


def ours() -> Method:
    """The package: model and solution are the set-up, once for one run and once for further evaluations."""
    once, many = (lambda problem, evaluations=evaluations: problem.solve(evaluations) for evaluations in ("once", "many"))
    return Method("mbconstrained", once, keeps=True, prepare_many=many)


def measured(
    problem: Problem, states: int, peers: tuple[Method, ...], effort: Effort, refusal: Callable[[Method], str] = lambda method: ""
) -> list[Measured]:
    """All methods in turns, ours first.

    Args:
        problem: what is asked.
        states: of small models, whose peers are fastest with one thread.
        peers: those that suit are tried.
        effort: how often.
        refusal: why a method is not tried, or an empty text.
    """
    truth = problem.truth()
    methods = [Running(method, ours=not place) for place, method in enumerate((ours(), *peers)) if method.suits(problem)]
    for running in methods:
        running.failure = refusal(running.method)
    with catch_warnings(), without_garbage_collection(), small_heap():
        simplefilter("ignore")  # singular eigenvectors of peers: their error tells it
        for running in methods:
            _try(running, partial(_first, running, problem, truth, states, effort))
        for turn in range(effort.repeats):
            for running in methods:
                if not running.failure and _is_wanted(running, effort):
                    _try(running, partial(_turn, running, problem, turn, effort))
    return [running.measured() for running in methods]


def relative_error(found: np.ndarray, truth: np.ndarray) -> float:
    """max |found - truth| / max |truth|; infinite where something is not finite."""
    error = np.abs(found - truth).max() / np.abs(truth).max()
    return float(error) if np.isfinite(error) else float("inf")


def _try(running: Running, work: Callable[[], object]) -> None:
    if running.failure:
        return
    try:
        work()
    except OutOfTime:
        running.is_over = True
        running.failure = "" if running.seconds["further"] else "not run to its end: it took longer than the limit"
    except Exception as problem:
        running.failure = f"{type(problem).__name__}: {str(problem)[:200]}"


def _is_wanted(running: Running, effort: Effort) -> bool:
    done = len(running.seconds["further"])
    if running.method.once or running.is_over:
        return not (done or running.is_over)
    seconds = effort.patience if done < effort.least else effort.seconds
    return not done or (running.spent < seconds and done < effort.repeats)


def _first(running: Running, problem: Problem, truth, states: int, effort: Effort) -> None:
    """Finds the error and the threads; counted where it took long."""
    choices = (0,) if running.ours else (1,) if states <= SMALL or running.method.once else (1, os.cpu_count() or 1)
    found = {}
    for running.threads in choices:
        running.seconds = {name: [] for name in running.seconds}
        total = _turn(running, problem, 0, effort, truth)
        if total < LONG and len(choices) > 1:
            total = min(total, _turn(running, problem, 1, effort))
        found[running.threads] = total, running.seconds
    running.threads = min(found, key=lambda threads: found[threads][0])
    total, seconds = found[running.threads]
    running.seconds = seconds if total > SHORT or running.method.once else {name: [] for name in seconds}


def _turn(running: Running, problem: Problem, turn: int, effort: Effort, truth=None) -> float:
    """One run and further evaluations; gives the time of the run."""
    others = [problem.times * (SHORTER - LESS * ((WARMING + 1) * turn + place)) for place in range(WARMING + 1)]
    with time_limit(effort.limit), _threads(running.threads):
        begun = perf_counter()
        evaluate, set_up = timed(partial(running.method.prepare, problem))
        x, evaluation = timed(partial(evaluate, problem.times))
        preparation = 0.0
        if running.method.prepare_many:
            evaluate, preparation = timed(partial(running.method.prepare_many, problem))
        further = [timed(partial(evaluate, times))[1] for times in others] if running.method.keeps else [evaluation] * len(others)
        further[0] += preparation
        running.spent += perf_counter() - begun
        if truth is not None:
            again = evaluate(problem.times) if running.method.keeps else x
            running.error = max(running.error, relative_error(x, truth), relative_error(again, truth))
    for name, seconds in zip(running.seconds, (set_up, evaluation, sum(further[:-1]), further[-1])):
        running.seconds[name].append(seconds)
    return set_up + evaluation


@contextmanager
def _threads(count: int) -> Iterator[None]:
    if not count:
        yield
        return
    with threadpool_limits(count):
        yield
