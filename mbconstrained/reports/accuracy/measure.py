"""Running the methods on a problem: errors against the truth, run times in turns, failures as failures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from warnings import catch_warnings

import numpy as np

from ...errors import MbconstrainedError
from ...scene.time_limit import OutOfTime, time_limit
from ..problem import Problem
from ..timing import Clock, Timing, duration, small_heap, suitable_clock, suitable_threads, timed, without_garbage_collection
from ..truth import Truth, states_of
from .method import Failure, Method, Setting
from .reduced import reduced

#: Each setting runs once more than so often, or until its repeats have taken so many seconds together, but twice at least.
#: The first run is never counted: it wakes the processor, and what a library does when it is first called is in it.
REPEATS, REPEATED_SECONDS = 9, 0.5

#: What takes less, in s, is evaluated a second time after each set-up: the first evaluation may make what later ones use again.
SHORT = 0.25

#: A single run that takes longer is broken off.
SECONDS = 5.0

#: How it is told that a run was broken off.
BROKEN_OFF = "takes more than"

#: A method that is off by as much as the motion itself has not found it.
LOST = 1.0

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Measured:
    """One method with one setting.

    Attributes:
        method, setting: what ran.
        error: max |error| / max |x|; None where it failed.
        set_up, evaluation: run times; None where it failed.
        further: that of each further evaluation.
        failure: why there is no answer, in words; an empty text where there is one.
    """

    method: Method
    setting: Setting
    error: float | None = None
    set_up: Timing | None = None
    evaluation: Timing | None = None
    further: Timing | None = None
    failure: str = ""

    @property
    def one_run(self) -> Timing:
        """Set-up and evaluation."""
        return self.set_up + self.evaluation

    @property
    def is_broken_off(self) -> bool:
        """Whether it took too long."""
        return self.failure.startswith(BROKEN_OFF)

    @property
    def label(self) -> str:
        """Method and setting."""
        return _label(self)


def _label(run) -> str:
    return ", ".join(filter(None, (run.method.name, run.setting.label)))


@dataclass
class _Trial:
    """What has been found about one setting so far."""

    method: Method
    setting: Setting
    clock: Clock
    values: np.ndarray | None = None
    failure: str = ""
    set_ups: list[float] = field(default_factory=list)
    evaluations: list[float] = field(default_factory=list)
    further: list[float] = field(default_factory=list)

    label = property(_label)

    @property
    def is_done(self) -> bool:
        return bool(self.failure) or len(self.evaluations) > REPEATS or self._repeated > REPEATED_SECONDS

    @property
    def _repeated(self) -> float:
        return sum(self.set_ups[1:]) + sum(self.evaluations[1:]) + sum(self.further[1:])

    def run(self, problem: Problem, seconds: float | None = None) -> None:
        """Once more; or for the first time, and for so many seconds at most."""
        try:
            with without_garbage_collection(), time_limit(seconds) if seconds else nullcontext():
                evaluate, set_up = timed(lambda: self.method.prepare(problem, self.setting.value), self.clock.read)
                values, evaluation = timed(evaluate, self.clock.read)
                further = timed(evaluate, self.clock.read)[1] if evaluation < SHORT else evaluation
        except OutOfTime:
            self.failure = f"{BROKEN_OFF} {duration(seconds)}"
            return
        self.values = values if self.values is None else self.values
        self.set_ups.append(set_up)
        self.evaluations.append(evaluation)
        self.further.append(further)

    def measured(self, truth: Truth) -> Measured:
        """The result."""
        error = np.inf if self.values is None else truth.error(self.values)
        if not self.failure and not error < LOST:
            self.failure = "gives no numbers" if error == np.inf else f"is off by {error:.1g} times the motion"
        if self.failure:
            return Measured(self.method, self.setting, failure=self.failure)
        counted = (Timing(tuple(seconds[1:])) for seconds in (self.set_ups, self.evaluations, self.further))
        return Measured(self.method, self.setting, error, *counted)


def measure(
    problem: Problem, truth: Truth, methods: Sequence[Method], seconds: float = SECONDS, tell: Tell = lambda text: None
) -> tuple[Measured, ...]:
    """Run every setting of every method that applies.

    The settings run in turns, so that whatever else the machine does falls on all of them. Of a method that takes longer than
    the limit, finer settings are not tried. Methods that are not meant for such a problem are left out without a word.

    Args:
        seconds: limit of a single run.
        tell: is told what runs.
    """
    concerned = [method for method in methods if method.concerns(problem)]
    clock = suitable_clock(states_of(problem))
    trials = [_Trial(method, setting, clock) for method in concerned for setting in method.settings_for(problem)]
    with suitable_threads(states_of(problem)), small_heap():
        for number, trial in enumerate(trials):
            _first(trial, trials[:number], problem, seconds, tell)
        for round_number in range(1, REPEATS + 1):
            _repeat([trial for trial in trials if not trial.is_done], round_number, problem, tell)
    return tuple(trial.measured(truth) for trial in trials)


def reduction_time(problem: Problem) -> Timing | None:
    """How long it takes to find the reduced equations anew; None where the problem has no answer."""
    clock, seconds = suitable_clock(states_of(problem)), []
    try:
        with suitable_threads(states_of(problem)), without_garbage_collection():
            while len(seconds) <= REPEATS and sum(seconds[1:]) <= REPEATED_SECONDS:
                seconds.append(timed(lambda: reduced.__wrapped__(problem), clock.read)[1])
    except MbconstrainedError:
        return None
    return Timing(tuple(seconds[1:]))


def _repeat(trials: Sequence[_Trial], round_number: int, problem: Problem, tell: Tell) -> None:
    """All of them once more, forwards and backwards by turns."""
    for trial in trials[:: -1 if round_number % 2 else 1]:
        tell(f"repeat {round_number} of {REPEATS}: {trial.label}")
        with _quiet():
            trial.run(problem)


def _first(trial: _Trial, before: Sequence[_Trial], problem: Problem, seconds: float, tell: Tell) -> None:
    """The run from which the values are taken, and which shows whether there are any."""
    method = trial.method
    tell(trial.label)
    slow = [earlier for earlier in before if earlier.method is method and earlier.failure.startswith(BROKEN_OFF)]
    trial.failure = method.refusal(problem) or ("not tried: a coarser setting takes too long" if slow else "")
    if trial.failure:
        return
    try:
        with _quiet():
            method.load()
            trial.run(problem, seconds)
    except (Failure, MbconstrainedError) as failure:
        trial.failure = str(failure)
    except Exception as failure:  # of whatever kind: other packages raise what they like
        trial.failure = ": ".join(filter(None, (type(failure).__name__, *str(failure).strip().splitlines()[:1])))


@contextmanager
def _quiet() -> Iterator[None]:
    """Warnings and prints of the methods are no part of the report: what they mean shows in the errors."""
    silent = StringIO()
    with catch_warnings(action="ignore"), np.errstate(all="ignore"), redirect_stdout(silent), redirect_stderr(silent):
        yield
