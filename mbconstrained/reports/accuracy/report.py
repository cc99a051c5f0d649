"""Error against run time of a scene, by every method that applies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...checks import counted
from ...tolerances import TRUST_LIMIT
from ..machine import machine
from ..problem import Problem
from ..timing import Timing, duration, suitable_clock
from ..truth import Truth, states_of, truth_of
from .measure import SECONDS, Measured, measure, reduction_time
from .method import Method

#: The errors for which the fastest method is told.
ERRORS = (1e-3, 1e-6, 1e-9, 1e-12)

#: Run times that differ by less are called equal: a machine that does other things moves them by as much.
EQUAL = 1.5


@dataclass(frozen=True)
class AccuracyReport:
    """What was measured.

    Attributes:
        problem: what was solved.
        truth: what the answers were compared with.
        runs: every setting of every method, those that failed and those that do not apply too.
        machine: on what it was made.
        reduction: how long this package takes to find the reduced equations that stepping methods are given; None where none was.
    """

    problem: Problem
    truth: Truth
    runs: tuple[Measured, ...]
    machine: dict[str, str]
    reduction: Timing | None = None

    @property
    def answers(self) -> tuple[Measured, ...]:
        """The runs that gave values."""
        return tuple(run for run in self.runs if not run.failure)

    @property
    def failures(self) -> tuple[Measured, ...]:
        """The others."""
        return tuple(run for run in self.runs if run.failure)

    @property
    def closed_form(self) -> Measured:
        """What everybody gets who asks for nothing else."""
        return self.runs[0]

    @property
    def size(self) -> str:
        """How large the problem is, in words."""
        times, A = self.problem.times, self.problem.polynomial_matrix
        states, changes = len(A.jordan_pairs().finite.J), len(self.problem.force.knots) - 1
        force = (
            "no force"
            if self.problem.force.is_zero
            else "a force" + (f" that changes {counted(changes, 'time')}" if changes else "")
        )
        held = f"{counted(A.size, 'equation')} of order {A.degree}, {counted(states, 'state')}, {force}"
        return f"{held}, {len(times)} times from {times[0]:g} s to {times[-1]:g} s"

    @property
    def clock(self) -> str:
        """What the times were taken with."""
        return suitable_clock(states_of(self.problem)).name

    @property
    def is_trusted(self) -> bool:
        """Whether the closed form has an answer that is right, or was broken off before it had one."""
        ours = self.closed_form
        return ours.is_broken_off if ours.failure else ours.error <= TRUST_LIMIT

    @property
    def fastest(self) -> tuple[tuple[float, str, str], ...]:
        """For each of some errors: the error, who gets there fastest in one run, and who in each further evaluation."""
        ours = [run for run in self.answers if run.method.is_ours]
        others = [run for run in self.answers if not run.method.is_ours]
        return tuple((error, *(_comparison(ours, others, error, time) for time in (one_run, further))) for error in ERRORS)

    def as_json(self) -> dict:
        """Everything as plain data; times in s."""
        return {
            "title": self.problem.title,
            "size": self.problem.polynomial_matrix.size,
            "times": len(self.problem.times),
            "truth": self.truth.how,
            "truth_floor": self.truth.floor,
            "machine": self.machine,
            "clock": self.clock,
            "reduction": self.reduction and self.reduction.as_json(),
            "fastest": [{"error": error, "one_run": one, "further_evaluation": more} for error, one, more in self.fastest],
            "runs": [_as_json(run, self.closed_form) for run in self.runs],
        }


def accuracy_report(
    problem: Problem, methods: Sequence[Method] = (), seconds: float = SECONDS, tell: Callable[[str], None] = lambda text: None
) -> AccuracyReport:
    """Measure every method on a problem.

    Args:
        problem: see ``problem_of`` for that of a scene.
        methods: ours first; all that there are when not given.
        seconds: limit of a single run of one setting.
        tell: is told what is being done.

    Raises:
        MbconstrainedError: the problem has no answer.
    """
    if not methods:
        from .methods import METHODS as methods
    tell("the true values")
    truth = truth_of(problem)
    runs = measure(problem, truth, methods, seconds, tell)
    return AccuracyReport(problem, truth, runs, machine(), reduction_time(problem))


def fastest(runs: Sequence[Measured], error: float, time: Callable[[Measured], float]) -> Measured | None:
    """Of the runs with at most this error the one that takes least time."""
    return min((run for run in runs if run.error <= error), key=time, default=None)


def one_run(run: Measured) -> float:
    """Set-up and evaluation, in s."""
    return run.one_run.median


def further(run: Measured) -> float:
    """One more evaluation when one has been made, in s."""
    return run.further.median


def _comparison(ours, others, error: float, time) -> str:
    mine, other = fastest(ours, error, time), fastest(others, error, time)
    if mine is None and other is None:
        return "nobody gets there"
    if other is None:
        return f"only {_told(mine, time)}"
    if mine is None:
        return f"{_told(other, time)}; no closed form gets there"
    ratio = time(other) / time(mine)
    if 1 / EQUAL < ratio < EQUAL:
        return f"{_told(mine, time)} and {_told(other, time)} are equally fast"
    first, second, times = (mine, other, ratio) if ratio > 1 else (other, mine, 1 / ratio)
    return f"{_told(first, time)} is {float(f'{times:.2g}'):g} times as fast as {_told(second, time)}"


def _told(run: Measured, time) -> str:
    return f"{run.label} ({duration(time(run))})"


def _as_json(run: Measured, closed_form: Measured) -> dict:
    head = {"method": run.method.name, "setting": run.setting.label, "is_ours": run.method.is_ours}
    if run.failure:
        return {**head, "failure": run.failure}
    ratios = {}
    if not closed_form.failure:
        ratios = {
            "one_run_over_closed_form": one_run(run) / one_run(closed_form),
            "further_evaluation_over_closed_form": further(run) / further(closed_form),
        }
    times = {"set_up": run.set_up, "evaluation": run.evaluation, "further_evaluation": run.further}
    return {**head, "error": run.error, **{name: timing.as_json() for name, timing in times.items()}, **ratios}
