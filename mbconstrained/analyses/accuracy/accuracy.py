"""Error against run time of every method that applies to a problem: measured, compared in tables, and drawn as a work-precision diagram."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from ...ground.checks import counted
from ...ground.display import TextTable
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, TRUST_LIMIT
from ...page.content import Curve, Guide, Marks, Plot, curve_with_gaps, shortened
from ...scene.schema.entry_types import Table
from ..base import Analysis, Answer
from ..study_problem import StudyProblem, SwitchedProblem, problem_of
from ..timing import Progress, Timing, duration, machine, no_progress, suitable_clock
from . import methods as catalogue
from .measure import SECONDS, Measurement, ReferenceSolution, measure, reduction_time, reference_solution, states_of
from .methods import ComparedMethod

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: The errors for which the fastest method is reported.
ERRORS = (1e-3, 1e-6, 1e-9, 1e-12)

#: Run times with a smaller ratio are called equal: other work of the machine changes them by as much.
EQUAL = 1.5


class AccuracySettings(Table):
    """Limits of the measurement."""

    seconds: float = Field(SECONDS, ge=0.1, le=3600.0, description="Time limit of a single run, s.")


class Accuracy(Analysis):
    """Measure error against run time: the methods of this package and those of other tools.

    The other tools are scipy's solve_ivp (DOP853, LSODA, Radau, BDF), odeint, steps with e^(S dt), scipy.signal.lsim and, where
    they are installed, python-control and IDA of scikit-sundae, each over its tolerances. Errors are measured with exact arithmetic. Motions
    with events are compared with solve_ivp with events and with Moreau's time stepping, to the digits in which integration at rtol 1e-13
    agrees. Writes NAME.accuracy.html, .png and .json."""

    name = "accuracy"
    handles_choices = True
    switches = "all"
    settings = AccuracySettings
    formats = ("page", "images", "json")
    progress = "steps"

    @classmethod
    def solve(cls, scene: Scene, settings: AccuracySettings | None, progress: Progress = no_progress) -> Answer:
        seconds = (settings or AccuracySettings()).seconds
        return accuracy_report(problem_of(scene), seconds=seconds, progress=progress).answer(scene.name, scene.table.source)


@dataclass(frozen=True)
class AccuracyReport:
    """Errors and run times of methods on one problem."""

    problem: StudyProblem
    reference: ReferenceSolution
    runs: tuple[Measurement, ...]  # every setting of every method, the closed form first, with those that failed or do not apply
    machine: dict[str, str]  # processor, system and packages
    reduction: Timing | None = None  # run time of the reduced equations that stepping methods get; None without them

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
    def fastest(self) -> tuple[tuple[float, str, str], ...]:
        """For each of ``ERRORS``: the error, the fastest method for one run, and for each further evaluation."""
        ours = [run for run in self.answers if run.method.is_ours]
        others = [run for run in self.answers if not run.method.is_ours]
        return tuple((error, *(_comparison(ours, others, error, time) for time in (one_run, further))) for error in ERRORS)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """Problem, closed form and reference solution."""
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
        if isinstance(self.problem, SwitchedProblem):
            return f"{suitable_clock(states_of(self.problem)).name}. Not included: the phases by their Jordan pairs, which solve_ivp gets."
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

    def answer(self, name: str, source: str = "") -> Answer:
        """Tables, the work-precision diagram and data; not trusted where the closed form is not accurate within the time limit."""
        ours, title = self.closed_form, f"Error against run time: {self.problem.title}"
        doubts: tuple[Notice, ...] = ()
        if ours.failure and not ours.is_broken_off:
            doubts = (Notice(NoticeKind.ACCURACY, f"the closed form has no answer: {ours.failure}", doubtful=True),)
        elif not ours.failure and ours.error > TRUST_LIMIT:
            doubts = (Notice(NoticeKind.ACCURACY, f"the closed form has an error of {ours.error:.1e}", doubtful=True),)
        failed = [run.method.name if run.method.refusal(self.problem) else run.label for run in self.failures]
        diagram = partial(work_precision, self.answers, self.reference.error_bound, tuple(dict.fromkeys(failed)))
        tables = (fastest_table(self), _time_table(self), *((failure_table(self),) if self.failures else ()), run_table(self))
        data = {
            "title": self.problem.title,
            "size": self.problem.polynomial_matrix.size,
            "times": len(self.problem.times),
            "closed_form_method": self.closed_form_method,
            "reference": self.reference.source,
            "reference_error": self.reference.error_bound,
            "machine": self.machine,
            "clock": suitable_clock(states_of(self.problem)).name,
            "reduction": self.reduction and self.reduction.to_dict(),
            "fastest": [{"error": error, "one_run": one, "further_evaluation": more} for error, one, more in self.fastest],
            "runs": [self._run_to_dict(run) for run in self.runs],
        }
        return Answer(
            kind="accuracy",
            name=name,
            title=title,
            source=source,
            facts=self.facts,
            machine=self.machine,
            tables=tables,
            notices=doubts,
            data=data,
            plots=diagram,
        )

    def _run_to_dict(self, run: Measurement) -> dict:
        head = {"method": run.method.name, "setting": run.setting.label, "is_ours": run.method.is_ours}
        if run.failure:
            return {**head, "failure": run.failure}
        times = {"set_up": run.set_up, "evaluation": run.evaluation, "further_evaluation": run.further}
        return {**head, "error": run.error, **{name: time.to_dict() for name, time in times.items()}, **self.ratios(run)}


def accuracy_report(
    problem: StudyProblem, methods: Sequence[ComparedMethod] = (), seconds: float = SECONDS, progress: Progress = no_progress
) -> AccuracyReport:
    switches = isinstance(problem, SwitchedProblem)
    methods = methods or (catalogue.SWITCHED_METHODS if switches else catalogue.METHODS)
    progress("the reference solution")
    reference = reference_solution(problem)
    runs = measure(problem, reference, methods, seconds, progress)
    return AccuracyReport(problem, reference, runs, machine(), None if switches else reduction_time(problem))


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


# --- the work-precision diagram

#: Smaller errors, such as 0, are drawn here.
LOWEST = 1e-17

PANELS = (("one run, set-up and evaluation", "one_run"), ("each further evaluation", "further"))


def work_precision(runs: Sequence[Measurement], floor: float = 0.0, failed: Sequence[str] = ()) -> Iterator[Plot]:
    """Relative error over run time, both logarithmic, with a curve for each method: of one run, and of each further evaluation."""
    methods = [tuple(mine) for _, mine in groupby(runs, key=lambda run: run.method)]
    notes = [f"An error of 0 or below {LOWEST:g} is drawn there."] if any(run.error < LOWEST for run in runs) else []
    notes += [f"Not in the picture: {'; '.join(map(shortened, failed))}."] if failed else []
    count = max(map(len, methods), default=0)
    for text, kind in PANELS if methods else ():
        curves, marks = [], []
        for number, mine in enumerate(methods):
            points = np.array([[getattr(run, kind).median, max(run.error, LOWEST)] for run in mine])
            x, y = np.pad(points, ((0, count - len(mine)), (0, 0)), constant_values=np.nan).T
            curves.append(curve_with_gaps(mine[0].method.name, y, along=x))
            texts = tuple(f"{run.label}: {run.error:.1e} in {duration(getattr(run, kind).median)}" for run in mine)
            marks.append(Marks("", points, texts, curve=number))
        times = np.concatenate([mark.points[:, 0] for mark in marks])
        levels = [(EPS, "rounding error of a double"), (floor, "accuracy of the reference solution")]
        yield Plot(
            f"error against run time, {text}",
            "",
            np.arange(float(count)),
            tuple(curves),
            Curve("run time", curves[0].along),
            quantity="relative error",
            variable="setting",
            scales=("log", "log"),
            guides=tuple(Guide(name, (times.min() / 2, level), (2 * times.max(), level)) for level, name in levels if level > 0),
            marks=tuple(marks),
            note=" ".join(notes),
            includes=(EPS,),
            shown=len(curves),
            is_large=True,
        )
