"""Error against run time of the examples: their diagrams, and a table of run times beside those of other methods.

    python tests/benchmarks/accuracy_of_examples.py [FOLDER [EXAMPLE ...]]

Measures each example as ``mbconstrained accuracy`` does, writes EXAMPLE.accuracy.html, .png and .json into the folder
(results/accuracy when not given), and prints a table for the documentation: what the closed form takes, and of each kind of other method
the fastest with an error of 1e-9 or less, its time over that of the closed form, one run and each further evaluation.
"""

import sys
from pathlib import Path

from mbconstrained.analyses.accuracy.accuracy import Accuracy, AccuracyReport, accuracy_report, fastest, further, one_run, ratio
from mbconstrained.analyses.study_problem import problem_of
from mbconstrained.analyses.timing import duration
from mbconstrained.scene.run.scene import read_scene

EXAMPLES = Path(__file__).parents[2] / "examples"

#: What is asked of all methods.
ERROR = 1e-9

#: Kinds of other methods, by the beginnings of their names.
KINDS = {
    "e^{S Δ} steps": ("expm, steps",),
    "lsim": ("scipy.signal", "control"),
    "solve_ivp, odeint": ("solve_ivp", "odeint"),
    "IDA": ("IDA",),
}


def main(folder: Path, names: list[str]) -> None:
    rows = []
    for path in [EXAMPLES / f"{name}.toml" for name in names] or sorted(EXAMPLES.glob("*.toml")):
        report = accuracy_report(problem_of(read_scene(path)), progress=lambda text, path=path: say(f"{path.stem}: {text}"))
        report.answer(path.stem).write(folder, Accuracy.formats)
        rows.append(row(path.stem, report))
    say("")
    print(f"| example | states | error | one run | further | reduction | {' | '.join(KINDS)} |")
    print("|---" * (6 + len(KINDS)) + "|")
    print("\n".join(rows))
    print("\n" + ", ".join(report.machine.values()))


def row(name: str, report: AccuracyReport) -> str:
    """One line: what the closed form takes, and how many times as long others take."""
    states, ours = len(report.problem.solve().pairs.finite.J), report.closed_form
    cells = [
        f"[{name}](examples/accuracy/{name}.accuracy.png)",
        str(states),
        f"{ours.error:.0e}",
        duration(one_run(ours)),
        duration(further(ours)),
    ]
    cells.append(duration(report.reduction.median))
    for beginnings in KINDS.values():
        runs = [run for run in report.answers if run.method.name.startswith(beginnings)]
        best = [fastest(runs, ERROR, time) for time in (one_run, further)]
        cells.append(
            "–" if None in best else f"{ratio(one_run(best[0]) / one_run(ours))}, {ratio(further(best[1]) / further(ours))}"
        )
    return f"| {' | '.join(cells)} |"


def say(text: str) -> None:
    """What runs, in a terminal."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    arguments = sys.argv[1:] or ["results/accuracy"]
    main(Path(arguments[0]), arguments[1:])
