"""Measurement of methods on a problem: errors against exact arithmetic, or a stated cross-check, run times in turns, failures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from importlib import import_module
from io import StringIO
from warnings import catch_warnings

import numpy as np

from ...ground.errors import MbconstrainedError, NotUnique, Overflow
from ...response.response import Response
from ...scene.run.plan import OutOfTime, time_limit
from ..study_problem import StudyProblem, SwitchedProblem, chosen_places, fractions_of, values_of
from ..timing import (
    Clock,
    Progress,
    Timing,
    duration,
    no_progress,
    small_heap,
    suitable_clock,
    suitable_threads,
    timed,
    without_garbage_collection,
)
from .first_order import reduced
from .methods import STEPS, ComparedMethod, Failure, MethodSetting, by_events

#: Repeats of each setting, and their total time (s) after which there are no more, but at least one repeat. The first run
#: is not counted: it includes what a library does once, and a processor that is not yet at full speed.
REPEATS, REPEATED_SECONDS = 9, 0.5

#: Evaluations that take less are repeated after each set-up: later ones may reuse results of the first, s.
SHORT = 0.25

#: Time limit of a single run, s.
SECONDS = 5.0

#: Beginning of the reason where a run exceeded the time limit.
TIME_EXCEEDED = "takes more than"

#: A relative error of this size is a failure.
LARGEST_ERROR = 1.0

#: Most times that are compared, evenly chosen with the first and the last.
MOST_TIMES = 101

#: Digits of the exact values, kept as sums of two float64 numbers.
REFERENCE_DIGITS = 25

#: The tolerance of the integration with which motions with events are compared.
FINEST = 1e-13

#: Most states for exact arithmetic, which takes minutes with more, and its time limit, s.
MOST_STATES, EXACT_SECONDS = 240, 60.0


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """The solution at some of the times of a problem."""

    places: np.ndarray  # indices of the compared times, shape (K,)
    values: np.ndarray  # values, rest: the solution as the sum of two float64 numbers, shape (r, K)
    rest: np.ndarray
    error_bound: float  # smaller errors are not resolved; 0 for an exact solution
    source: str  # method of computation, as a phrase

    @property
    def scale(self) -> float:
        """max |x| at the compared times."""
        return float(np.abs(self.values).max(initial=0.0))

    def error(self, values: np.ndarray) -> float:
        """max |error| / max |x| of values (r, T) at the times of the problem; the absolute error where x is zero."""
        compared = np.asarray(values)[:, self.places]
        if not np.isfinite(compared).all():
            return np.inf
        error = float(np.abs((compared - self.values) - self.rest).max(initial=0.0))
        return max(error / (self.scale or 1.0), self.error_bound)


def states_of(problem: StudyProblem) -> int:
    """Upper bound of the number of states: coordinates times the degree of A(s), at least 1."""
    return problem.polynomial_matrix.size * max(problem.polynomial_matrix.degree, 1)


def reference_solution(problem: StudyProblem, seconds: float = EXACT_SECONDS) -> ReferenceSolution:
    """The reference solution by exact arithmetic for the given numbers; by a cross-check where that takes too long."""
    places = chosen_places(len(problem.times), MOST_TIMES)
    if isinstance(problem, SwitchedProblem):
        return _switched_reference(problem, places)
    states = states_of(problem)
    if states > MOST_STATES:
        return _cross_checked(problem, places, f"exact arithmetic with {states} states takes too long")
    try:
        with time_limit(seconds):
            return exact_solution(problem.solve(), problem.times, places)
    except OutOfTime:
        return _cross_checked(problem, places, f"exact arithmetic took more than {seconds:g} s")
    except Overflow as reason:
        return _cross_checked(problem, places, f"exact arithmetic failed: {reason}")


def exact_solution(response: Response, times: np.ndarray, places: np.ndarray) -> ReferenceSolution:
    """The solution at some of the times by exact rational and ball arithmetic."""
    exact = values_of(response.enclose(times[places], digits=REFERENCE_DIGITS))
    values = exact.astype(float)
    rest = (exact - fractions_of(values)).astype(float)
    count = f"{len(places)} of {len(times)} times" if len(places) < len(times) else f"all {len(times)} times"
    return ReferenceSolution(places, values, rest, 0.0, f"exact rational and ball arithmetic at {count} for the given numbers")


def _cross_checked(problem: StudyProblem, places: np.ndarray, why: str) -> ReferenceSolution:
    """The closed form, verified to the accuracy with which steps by e^(S dt) on the reduced equations agree."""
    values, other = problem.solve()(problem.times), STEPS.prepare(problem, None)()
    scale = np.abs(values).max(initial=0.0) or 1.0
    error_bound = float(np.abs(values - other).max(initial=0.0) / scale)
    source = f"{why}: the closed form itself, with which {STEPS.name} agrees to {error_bound:.1e}; smaller errors are not resolved"
    values = values[:, places]
    return ReferenceSolution(places, values, np.zeros_like(values), error_bound, source)


def _switched_reference(problem: SwitchedProblem, places: np.ndarray) -> ReferenceSolution:
    """The closed form, verified to the accuracy with which solve_ivp with events agrees at its least tolerance."""
    motion = problem.solve()
    values = motion(problem.times[places])
    scale = float(np.abs(values).max(initial=0.0)) or 1.0
    count = len(motion.events)
    try:
        other = by_events("DOP853", problem, FINEST)()[:, places]
        bound = float(np.abs(values - other).max(initial=0.0)) / scale
        source = (
            f"the closed form itself through its {count} events, with which solve_ivp DOP853 with events at rtol {FINEST:.0e} "
            f"agrees to {bound:.1e}; smaller errors are not resolved"
        )
    except NotUnique as problem_of_steps:
        bound, source = np.inf, f"the closed form itself; solve_ivp with events fails ({problem_of_steps})"
    return ReferenceSolution(places, values, np.zeros_like(values), bound, source)


@dataclass(frozen=True)
class Measurement:
    """The result of one method with one setting."""

    method: ComparedMethod  # method, setting: the run
    setting: MethodSetting
    error: float | None = None  # max |error| / max |x|; None where it failed
    set_up: Timing | None = None  # set_up, evaluation: run times; None where it failed
    evaluation: Timing | None = None
    further: Timing | None = None  # run time of each further evaluation
    failure: str = ""  # the reason where there is no answer; else empty

    @property
    def one_run(self) -> Timing:
        """Set-up and evaluation."""
        return self.set_up + self.evaluation

    @property
    def is_broken_off(self) -> bool:
        """Whether it exceeded the time limit."""
        return self.failure.startswith(TIME_EXCEEDED)

    @property
    def label(self) -> str:
        return ", ".join(filter(None, (self.method.name, self.setting.label)))


@dataclass
class _Trial:
    """The runs of one setting."""

    method: ComparedMethod
    setting: MethodSetting
    clock: Clock
    values: np.ndarray | None = None
    failure: str = ""
    set_ups: list[float] = field(default_factory=list)
    evaluations: list[float] = field(default_factory=list)
    further: list[float] = field(default_factory=list)

    @property
    def label(self) -> str:
        return Measurement(self.method, self.setting).label

    @property
    def is_done(self) -> bool:
        repeated = sum(map(sum, (self.set_ups[1:], self.evaluations[1:], self.further[1:])))
        return bool(self.failure) or len(self.evaluations) > REPEATS or repeated > REPEATED_SECONDS

    def run(self, problem: StudyProblem, seconds: float | None = None) -> None:
        """Run once more, for at most a number of seconds."""
        try:
            with without_garbage_collection(), time_limit(seconds) if seconds else nullcontext():
                evaluate, set_up = timed(lambda: self.method.prepare(problem, self.setting.value), self.clock.read)
                values, evaluation = timed(evaluate, self.clock.read)
                further = timed(evaluate, self.clock.read)[1] if evaluation < SHORT else evaluation
        except OutOfTime:
            self.failure = f"{TIME_EXCEEDED} {duration(seconds)}"
            return
        self.values = values if self.values is None else self.values
        self.set_ups.append(set_up)
        self.evaluations.append(evaluation)
        self.further.append(further)

    def measured(self, reference: ReferenceSolution) -> Measurement:
        error = np.inf if self.values is None else reference.error(self.values)
        if not self.failure and not error < LARGEST_ERROR:
            self.failure = "gives no numbers" if error == np.inf else f"has an error of {error:.1g} times the motion"
        if self.failure:
            return Measurement(self.method, self.setting, failure=self.failure)
        counted = (Timing(tuple(seconds[1:])) for seconds in (self.set_ups, self.evaluations, self.further))
        return Measurement(self.method, self.setting, error, *counted)


def measure(
    problem: StudyProblem,
    reference: ReferenceSolution,
    methods: Sequence[ComparedMethod],
    seconds: float = SECONDS,
    progress: Progress = no_progress,
) -> tuple[Measurement, ...]:
    """Run every setting of every method that applies.

    The settings run in turns, so that other work of the machine affects all of them. Of a method that exceeds the time limit
    finer settings are not run. Methods that are not meant for such a problem are left out.
    """
    concerned = [method for method in methods if method.concerns(problem)]
    clock = suitable_clock(states_of(problem))
    trials = [_Trial(method, setting, clock) for method in concerned for setting in method.settings_for(problem)]
    with suitable_threads(states_of(problem)), small_heap():
        for number, trial in enumerate(trials):
            _first(trial, trials[:number], problem, seconds, progress)
        for round_number in range(1, REPEATS + 1):
            for trial in [trial for trial in trials if not trial.is_done][:: -1 if round_number % 2 else 1]:
                progress(f"repeat {round_number} of {REPEATS}: {trial.label}")
                with _quiet():
                    trial.run(problem)
    return tuple(trial.measured(reference) for trial in trials)


def reduction_time(problem: StudyProblem) -> Timing | None:
    """Run time of the reduced equations; None where the problem has no solution."""
    clock, seconds = suitable_clock(states_of(problem)), []
    try:
        with suitable_threads(states_of(problem)), without_garbage_collection():
            while len(seconds) <= REPEATS and sum(seconds[1:]) <= REPEATED_SECONDS:
                seconds.append(timed(lambda: reduced.__wrapped__(problem), clock.read)[1])
    except MbconstrainedError:
        return None
    return Timing(tuple(seconds[1:]))


def _first(trial: _Trial, before: Sequence[_Trial], problem: StudyProblem, seconds: float, progress: Progress) -> None:
    """The first run, which gives the values or fails."""
    method = trial.method
    progress(trial.label)
    slow = [earlier for earlier in before if earlier.method is method and earlier.failure.startswith(TIME_EXCEEDED)]
    trial.failure = method.refusal(problem) or ("not run: a coarser setting exceeds the time limit" if slow else "")
    if trial.failure:
        return
    try:
        with _quiet():
            if method.library:  # so that no run time includes it
                import_module(method.library)
            trial.run(problem, seconds)
    except (Failure, MbconstrainedError) as failure:
        trial.failure = str(failure)
    except Exception as failure:  # other packages raise exceptions of any kind
        trial.failure = ": ".join(filter(None, (type(failure).__name__, *str(failure).strip().splitlines()[:1])))


@contextmanager
def _quiet() -> Iterator[None]:
    """A context without warnings and prints of the methods, whose errors are reported."""
    silent = StringIO()
    with catch_warnings(action="ignore"), np.errstate(all="ignore"), redirect_stdout(silent), redirect_stderr(silent):
        yield
