"""Run times beside what a user would take instead, with errors and losses; writes the tables of README and documentation.

    python tests/benchmarks/tables.py                  # measure all and write the tables: about a quarter of an hour
    python tests/benchmarks/tables.py --only chain     # rows whose name contains a word, printed only

Both sides run in one process, by turns, with one thread, each as often as a time limit allows; the least processor time of each counts.
One run is model, solution and values at all times; a further evaluation is at other times of the same motion. Other methods are given
the reduced equations for nothing, and count where their error is at most 1e-12, or ten times that of this package. "lsim" is SciPy's; "expm blocks"
is its best form, many columns at once with denormal numbers flushed to zero. Errors are against ball arithmetic or long doubles.
"""

from __future__ import annotations

import argparse
import datetime
import os
import re
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # before NumPy is loaded

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [] if str(ROOT) in sys.path else [str(ROOT)]

import numpy as np

from mbconstrained.analyses.timing import duration, machine, without_garbage_collection
from mbconstrained.ground.files import replacing
from tests.benchmarks.speed.motions import INTEGRATORS, MOTIONS, PEERS, Motion, Problem
from tests.benchmarks.speed.questions import QUESTIONS, Question, child_seconds

README, PAGE = ROOT / "README.md", ROOT / "mbconstrained" / "docs" / "explanation" / "accuracy_and_speed.md"

#: Between these marks a file has its tables.
BEGIN, END = "<!-- tables: begin -->", "<!-- tables: end -->"

#: Time for the turns of a row, s, and the most and fewest of them.
SECONDS, MOST, FEWEST = 4.0, 200, 2

#: A method counts as right with at most so many times our error, rounding alone moves errors by a few, or with at most this error.
EQUAL, RIGHT = 10.0, 1e-12

NOTHING = "–"


@dataclass(frozen=True)
class Measured:
    """A method on a motion: its error, and least times of one run and of a further evaluation, s."""

    name: str
    error: float
    one_run: float
    further: float


def least(works: dict[str, Callable[[], tuple[float, ...]]]) -> dict[str, list[float]]:
    """The least of each time that works give, run by turns; those that fail are left out."""
    best, begin = {}, child_seconds()
    with without_garbage_collection(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # singular eigenvectors of other methods: their errors show it
        for turn in range(MOST):
            if turn >= FEWEST and child_seconds() - begin > SECONDS:
                break
            for name, work in works.items():
                times = work()
                best[name] = [min(pair) for pair in zip(times, best.get(name, times))]
    return best


def timed(work: Callable[[], object]) -> tuple[object, float]:
    """A result and its processor time, that of ended child processes included."""
    begin = child_seconds()
    return work(), child_seconds() - begin


def measured(motion: Motion) -> list[Measured]:
    """The package, then the methods that suit."""
    problem = motion.make()
    truth = problem.truth()
    methods = {method.name: method for method in (*PEERS, *(INTEGRATORS if motion.is_integrated else ())) if method.suits(problem)}
    prepare = {"mbconstrained": problem.solve, **{name: lambda m=method: m.prepare(problem) for name, method in methods.items()}}
    errors: dict[str, float] = {}
    for name, make in list(prepare.items()):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            errors[name] = relative_error(make()(problem.times), truth)
        if not errors[name] <= max(1e-6, EQUAL * errors["mbconstrained"]):
            del prepare[name]  # as long as it takes, it is not an answer
    keeps = {"mbconstrained", *(name for name, method in methods.items() if method.keeps)}
    best = least({name: lambda n=name, make=make: turn_of(make, problem, n in keeps) for name, make in prepare.items()})
    return [Measured(name, errors[name], *best[name]) for name in best]


def turn_of(make: Callable[[], Callable], problem: Problem, keeps: bool) -> tuple[float, float]:
    """Times of one run and of a further evaluation at other times, the second of two."""
    motion, set_up = timed(make)
    _, first = timed(lambda: motion(problem.times))
    if not keeps:
        return set_up + first, set_up + first
    motion(0.97 * problem.times)
    return set_up + first, timed(lambda: motion(0.96 * problem.times))[1]


def relative_error(found: np.ndarray, truth: np.ndarray) -> float:
    """max |found - truth| / max |truth|; infinite where something is not finite."""
    error = np.abs(found - truth).max() / np.abs(truth).max()
    return float(error) if np.isfinite(error) else float("inf")


def motion_rows(chosen: list[Motion]) -> Iterator[list[str]]:
    """A row for each motion: our times, those of the fastest method that is as right, and what is wanted."""
    for motion in chosen:
        ours, *others = measured(motion)
        right = [other for other in others if other.error <= max(EQUAL * ours.error, RIGHT)]
        row = [motion.name, str(motion.states), f"{ours.error:.0e}"]
        for place, part in enumerate(("one_run", "further")):
            own = getattr(ours, part)
            lsim = next((getattr(other, part) for other in right if other.name == "lsim"), None)
            rival = min(right, key=lambda other: getattr(other, part), default=None)
            row += [duration(own), fastest(rival, part, own), NOTHING if lsim is None else f"{own / lsim:.2g}"]
            ratio = getattr(motion, part)
            if motion.seconds:
                row.append(wanted(duration(motion.seconds[place]), own <= motion.seconds[place]))
            else:
                compared = lsim or (rival and getattr(rival, part))
                row.append(NOTHING if ratio is None or not compared else wanted(f"{ratio:g} ×", own <= ratio * compared))
        yield row


def fastest(rival: Measured | None, part: str, own: float) -> str:
    """The fastest other method with its time, bold where it is faster."""
    if rival is None:
        return "no correct digit"
    text = f"{duration(getattr(rival, part))} ({rival.name})"
    return f"**{text}**" if getattr(rival, part) < own else text


def wanted(text: str, met: bool) -> str:
    """A target with its sign."""
    return f"≤ {text} {'✓' if met else '✗'}"


def question_rows(chosen: list[Question]) -> Iterator[list[str]]:
    """A row for each question."""
    for question in chosen:
        ours, peer = question.make()
        works = {"ours": ours, **({"peer": peer} if peer else {})}
        for work in works.values():
            work()  # the first call of a library is not counted
        best = least({name: lambda work=work: (timed(work)[1],) for name, work in works.items()})
        own, other = best["ours"][0] / question.parts, best["peer"][0] / question.parts if peer else None
        compared = NOTHING if other is None else f"{duration(other)} ({question.peer})"
        compared = f"**{compared}**" if other is not None and other < own else compared
        target = wanted(f"{question.ratio:g} ×", own <= question.ratio * (other or 0)) if question.ratio else NOTHING
        target = wanted(duration(question.seconds), own <= question.seconds) if question.seconds else target
        yield [question.name, duration(own), compared, NOTHING if other is None else f"{own / other:.2g}", target]


def markdown(head: list[str], rows: list[list[str]]) -> str:
    """A table."""
    return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows])


MOTION_HEAD = [
    "motion",
    "states",
    "error",
    "one run",
    "fastest other",
    "of lsim",
    "wanted",
    "further",
    "fastest other",
    "of lsim",
    "wanted",
]
QUESTION_HEAD = ["question", "time", "other method", "ratio", "wanted"]

#: Columns of README: no targets.
SHORT = (0, 1, 2, 3, 4, 7, 8)


def stamp() -> str:
    """Commit, date, processor and packages of the measurement."""
    git = ["git", "-C", str(ROOT)]
    commit = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()
    changed = subprocess.run([*git, "status", "--porcelain", "mbconstrained"], check=True, capture_output=True, text=True).stdout
    if changed:
        raise SystemExit("the package differs from its last commit; commit first, so that the tables name what they measure")
    found = machine()
    return f"Commit {commit}, {datetime.date.today()}, one thread of {found['processor']}, {found['system']}, {found['packages']}."


def with_tables(text: str, tables: str) -> str:
    """A text whose part between the marks is the tables.

    Raises:
        ValueError: it has no such part, or several.

    >>> with_tables(f"before {BEGIN} old {END} after", "new").splitlines()
    ['before <!-- tables: begin -->', '', 'new', '', '<!-- tables: end --> after']
    """
    found, count = re.subn(f"{BEGIN}.*?{END}", lambda _: f"{BEGIN}\n\n{tables}\n\n{END}", text, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"found {count} parts between {BEGIN} and {END}; expected one")
    return found


def collect(rows: Iterator[list[str]]) -> list[list[str]]:
    """All rows, each printed when it is measured."""
    found = []
    for row in rows:
        print(" | ".join(row), flush=True)
        found.append(row)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], help="parts of names of rows; nothing is written")
    words = parser.parse_args().only
    named = lambda rows: [row for row in rows if not words or any(word in row.name for word in words)]  # noqa: E731
    source = "" if words else stamp()
    motions, questions = collect(motion_rows(named(MOTIONS))), collect(question_rows(named(QUESTIONS)))
    if words:
        return
    short = [[row[place] for place in SHORT] for row in motions]
    tables = {
        README: markdown([MOTION_HEAD[place] for place in SHORT], short),
        PAGE: f"{markdown(MOTION_HEAD, motions)}\n\n{markdown(QUESTION_HEAD, questions)}",
    }
    for path, table in tables.items():
        text = with_tables(path.read_text(encoding="utf-8"), f"{table}\n\n{source}")
        with replacing(path) as beside:
            beside.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
