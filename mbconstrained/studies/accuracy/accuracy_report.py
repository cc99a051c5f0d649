"""The report of the accuracy study: error against run time of every method that applies to a problem."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

from ...ground.checks import counted
from ...ground.display import TextTable
from ...ground.tolerances import TRUST_LIMIT
from ..figures import Picture
from ..reference_solution import ReferenceSolution, reference_solution, states_of
from ..study_problem import StudyProblem
from ..study_report import Progress, StudyReport, no_progress
from ..timing import Timing, duration, machine, suitable_clock
from .diagram import work_precision
from .measure import SECONDS, Measurement, measure, reduction_time
from .method import ComparedMethod

#: The errors for which the fastest method is reported.
ERRORS = (1e-3, 1e-6, 1e-9, 1e-12)

#: Run times with a smaller ratio are called equal: other work of the machine changes them by as much.
EQUAL = 1.5


@dataclass(frozen=True)
class AccuracyReport(StudyReport):
    """Errors and run times of methods on one problem.

    Attributes:
        problem: the problem.
        reference: the reference solution.
        runs: every setting of every method, the closed form first, with those that failed or do not apply.
        machine: processor, system and packages.
        reduction: run time of the reduced equations that stepping methods get; None without them.
    """

    problem: StudyProblem
    reference: ReferenceSolution
    runs: tuple[Measurement, ...]
    machine: dict[str, str]
    reduction: Timing | None = None

    @property
    def answers(self) -> tuple[Measurement, ...]:
        """The runs with values."""
        return tuple(run for run in self.runs if not run.failure)

    @property
    def failures(self) -> tuple[Measurement, ...]:
        """The runs without values."""
        return tuple(run for run in self.runs if run.failure)

    @property
    def closed_form(self) -> Measurement:
        """The default method."""
        return self.runs[0]

    @property
    def closed_form_method(self) -> str:
        """The method that this package selects for the problem, and the reason."""
        method = self.problem.solve().method
        return f"{method.name}, {method.reason}"

    @property
    def is_trusted(self) -> bool:
        """Whether the closed form is accurate, or exceeded the time limit."""
        ours = self.closed_form
        return ours.is_broken_off if ours.failure else ours.error <= TRUST_LIMIT

    @property
    def fastest(self) -> tuple[tuple[float, str, str], ...]:
        """For each of ``ERRORS``: the error, the fastest method for one run, and for each further evaluation."""
        ours = [run for run in self.answers if run.method.is_ours]
        others = [run for run in self.answers if not run.method.is_ours]
        return tuple((error, *(_comparison(ours, others, error, time) for time in (one_run, further))) for error in ERRORS)

    @property
    def heading(self) -> str:
        """The title of the page."""
        return f"Error against run time: {self.problem.title}"

    @property
    def sentences(self) -> tuple[str, ...]:
        """Problem, closed form and reference solution."""
        return tuple(f"{label.capitalize()}: {text}." for label, text in self._problem_facts)

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """The fastest methods, run times, and failures."""
        return fastest_table(self), _time_table(self), *((failure_table(self),) if self.failures else ())

    @property
    def page_tables(self) -> tuple[TextTable, ...]:
        """Table of all settings."""
        return (run_table(self),)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """Problem, closed form, reference solution and machine."""
        return *self._problem_facts, *self.machine.items()

    @property
    def _problem_facts(self) -> tuple[tuple[str, str], ...]:
        times, A, force = self.problem.times, self.problem.polynomial_matrix, self.problem.force
        states, changes = len(A.jordan_pairs().finite.J), len(force.knots) - 1
        changing = f"a force that changes {counted(changes, 'time')}" if changes else "a force"
        size = f"{counted(A.size, 'equation')} of order {A.degree}, {counted(states, 'state')}, {'no force' if force.is_zero else changing}"
        return (
            ("problem", f"{size}, {len(times)} times from {times[0]:g} s to {times[-1]:g} s"),
            ("closed form", self.closed_form_method),
            ("reference solution", self.reference.source),
        )

    @property
    def timing_note(self) -> str:
        """The clock, and the data that stepping methods get outside their run time."""
        time = f" (computed by this package in {duration(self.reduction.median)})" if self.reduction else ""
        return (
            f"{suitable_clock(states_of(self.problem)).name}. Not included: the reduced equations of stepping methods{time}, their "
            "values at 0+ where the start jumps, and formulas of the force."
        )

    def ratios(self, run: Measurement) -> dict[str, float]:
        """The times of a run over those of the closed form, by name; empty where that failed."""
        if self.closed_form.failure:
            return {}
        kinds = (("one_run_over_closed_form", one_run), ("further_evaluation_over_closed_form", further))
        return {name: time(run) / time(self.closed_form) for name, time in kinds}

    def pictures(self) -> list[Picture]:
        """The work-precision diagram."""
        failed = [run.method.name if run.method.refusal(self.problem) else run.label for run in self.failures]
        return [work_precision(self.heading, self.answers, self.reference.error_bound, tuple(dict.fromkeys(failed)))]

    def as_json(self) -> dict:
        return {
            "title": self.problem.title,
            "size": self.problem.polynomial_matrix.size,
            "times": len(self.problem.times),
            "closed_form_method": self.closed_form_method,
            "reference": self.reference.source,
            "reference_error": self.reference.error_bound,
            "machine": self.machine,
            "clock": suitable_clock(states_of(self.problem)).name,
            "reduction": self.reduction and self.reduction.as_json(),
            "fastest": [{"error": error, "one_run": one, "further_evaluation": more} for error, one, more in self.fastest],
            "runs": [self._run_as_json(run) for run in self.runs],
        }

    def _run_as_json(self, run: Measurement) -> dict:
        head = {"method": run.method.name, "setting": run.setting.label, "is_ours": run.method.is_ours}
        if run.failure:
            return {**head, "failure": run.failure}
        times = {"set_up": run.set_up, "evaluation": run.evaluation, "further_evaluation": run.further}
        return {**head, "error": run.error, **{name: time.as_json() for name, time in times.items()}, **self.ratios(run)}


def accuracy_report(
    problem: StudyProblem, methods: Sequence[ComparedMethod] = (), seconds: float = SECONDS, progress: Progress = no_progress
) -> AccuracyReport:
    """Measure every method on a problem."""
    if not methods:
        from .methods import METHODS as methods
    progress("the reference solution")
    reference = reference_solution(problem)
    runs = measure(problem, reference, methods, seconds, progress)
    return AccuracyReport(problem, reference, runs, machine(), reduction_time(problem))


def fastest(runs: Sequence[Measurement], error: float, time: Callable[[Measurement], float]) -> Measurement | None:
    """The fastest of the runs with at most this error."""
    return min((run for run in runs if run.error <= error), key=time, default=None)


def one_run(run: Measurement) -> float:
    """Set-up and evaluation, in s."""
    return run.one_run.median


def further(run: Measurement) -> float:
    """Run time of each further evaluation in s."""
    return run.further.median


def _comparison(ours, others, error: float, time) -> str:
    mine, other = fastest(ours, error, time), fastest(others, error, time)
    if mine is None and other is None:
        return "no method reaches it"
    if other is None:
        return f"only {_named(mine, time)}"
    if mine is None:
        return f"{_named(other, time)}; no closed form reaches it"
    slower = time(other) / time(mine)
    if 1 / EQUAL < slower < EQUAL:
        return f"{_named(mine, time)} and {_named(other, time)} are equally fast"
    first, second, times = (mine, other, slower) if slower > 1 else (other, mine, 1 / slower)
    return f"{_named(first, time)} is {ratio(times)} times as fast as {_named(second, time)}"


def _named(run: Measurement, time) -> str:
    return f"{run.label} ({duration(time(run))})"


def fastest_table(report: AccuracyReport) -> TextTable:
    """The fastest methods by error."""
    rows = []
    for methods, group in groupby(report.fastest, key=lambda row: row[1:]):
        errors = [f"{error:.0e}" for error, *_ in group]
        rows.append((" to ".join(dict.fromkeys((errors[0], errors[-1]))), *methods))
    return TextTable("Fastest", ("error at most", "one run", "each further evaluation"), tuple(rows))


def _time_table(report: AccuracyReport) -> TextTable:
    """The run time of each method for each of ``ERRORS``."""
    rows = []
    for name, group in groupby(report.answers, key=lambda run: run.method.name):
        runs = tuple(group)
        best = [fastest(runs, error, one_run) for error in ERRORS]
        times = ("–" if run is None else f"{duration(one_run(run))} ({duration(further(run))})" for run in best)
        rows.append((name, f"{min(run.error for run in runs):.0e}", *times))
    note = (
        "Run time for an error of at most this size: set-up and one evaluation, in parentheses each further evaluation. "
        f"Times are medians of repeats, {report.timing_note}"
    )
    return TextTable("Run times", ("method", "least error", *(f"{error:.0e}" for error in ERRORS)), tuple(rows), note)


def run_table(report: AccuracyReport) -> TextTable:
    """One row for each setting with a result."""
    columns = "method, setting, error, set-up, evaluation, quartiles of one run, further evaluation".split(", ")
    note = f"error: max |error| / max |x|. Times are medians of repeats that ran in turns, {report.timing_note}"
    rows = tuple(
        (
            run.method.name,
            run.setting.label,
            f"{run.error:.1e}",
            duration(run.set_up.median),
            duration(run.evaluation.median),
            " … ".join(map(duration, run.one_run.quartiles)),
            duration(further(run)),
            *(map(ratio, report.ratios(run).values()) if report.ratios(run) else ("", "")),
        )
        for run in report.answers
    )
    return TextTable("All settings", (*columns, "one run / closed form", "further / closed form"), rows, note, folded=True)


def failure_table(report: AccuracyReport) -> TextTable:
    """Methods without a result; settings with the same reason share a row."""
    settings_of: dict[tuple[str, str], list[str]] = {}
    for run in report.failures:
        setting = "" if run.method.refusal(report.problem) else run.setting.label
        settings_of.setdefault((run.method.name, run.failure), []).append(setting)
    rows = tuple((name, ", ".join(filter(None, settings)), failure) for (name, failure), settings in settings_of.items())
    return TextTable("No answer", ("method", "settings", "reason"), rows)


def ratio(value: float) -> str:
    """A ratio to two digits.

    >>> ratio(0.01234), ratio(123.4)
    ('0.012', '120')
    """
    return f"{float(f'{value:.2g}'):g}"
