"""The commands sweep and optimise: many samples of a scene's parameters, and the best values of some."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .answer import Json, Out, ScenePath, Settings, answer, setting
from .studies import printed

if TYPE_CHECKING:
    from ..scene.run.scene import Scene
    from ..studies.study_report import StudyReport

Vary = Annotated[
    list[str] | None,
    typer.Option("--vary", metavar="NAME=VALUES", help='Such as "k=1..3 N/mm:50", "m=normal(10 kg, 2 %)"; repeat it for others.'),
]


def add_to(app: typer.Typer) -> None:
    """Give the command line the two commands."""
    app.command("sweep", short_help="Vary parameters: grids, Monte Carlo, statistics, Sobol indices.")(_sweep)
    app.command("optimise", short_help="Find the values of parameters that make a figure least or largest.")(_optimise)


def _sweep(
    scene: ScenePath,
    vary: Vary = None,
    keep: Annotated[
        list[str] | None,
        typer.Option(
            "--keep", metavar="WHAT", help='Kept quantity of a sample, such as "frequencies", "largest x", "x at 2 s"; repeat it.'
        ),
    ] = None,
    limit: Annotated[
        list[str] | None,
        typer.Option("--limit", metavar="WHAT=VALUE", help='Estimate the probability of exceeding it, e.g. "largest x=5 mm".'),
    ] = None,
    method: Annotated[
        str,
        typer.Option("--method", metavar="NAME", help="random, latin hypercube, sobol, saltelli (Sobol indices) or one at a time."),
    ] = "",
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Number of samples; 1000 by default.")] = 0,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the random numbers; 0 by default.")] = -1,
    correlation: Annotated[
        list[str] | None, typer.Option("--correlation", metavar="A,B=R", help="Correlation of normal scores; repeat it.")
    ] = None,
    store: Annotated[
        str, typer.Option("--store", metavar="PATH", help="Keep the samples in this Zarr store, and go on from there.")
    ] = "",
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Compute in N processes.")] = 0,
    dask: Annotated[str, typer.Option("--dask", metavar="ADDRESS", help="Compute on the Dask cluster with this scheduler.")] = "",
    sample_timeout: Annotated[
        float,
        typer.Option("--sample-timeout", metavar="SECONDS", help="Give up a sample that takes longer; it has no answer then."),
    ] = 0.0,
    strict: Annotated[bool, typer.Option("--strict", help="Leave with 3 if a sample has no answer.")] = False,
    out: Out = "",
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Compute many samples of the parameters of a scene, those of its table [vary] and of --vary.

    Ranges with a number of values and lists are combined in a grid; distributions (normal, lognormal, uniform, or a range without a number)
    are sampled at each point of it. With --store an interrupted study goes on where it was, and with --workers or --dask others compute:
    the results have the same bits. Writes NAME.sweep.html, .png, .json and .csv."""
    given = {"method": method, "samples": samples, "keep": keep, "chunk": None}
    options: dict[str, Any] = {key: value for key, value in given.items() if value}
    options |= {"seed": seed} if seed >= 0 else {}
    options |= {"limits": _pairs(limit, "--limit")} if limit else {}
    options |= {"correlation": [_correlation(text) for text in correlation]} if correlation else {}
    running: dict[str, Any] = {
        "store": store or None,
        "workers": workers or None,
        "dask": dask or None,
        "sample_timeout": sample_timeout or None,
    }
    if workers < 0:
        raise typer.BadParameter(f"found {workers}; expected at least 1", param_hint="--workers")

    def work(loaded: Scene) -> int:
        from ..ground.files import Replacements
        from ..studies.study_report import writable
        from ..studies.sweep.sweep import StudyInterrupted, sweep
        from ..studies.sweep.sweep_report import SweepReport
        from .printing import bar_progress, show_error, show_message

        study = sweep(loaded, _pairs(vary or (), "--vary"), **options)
        folder = writable(Path(out or Path("results") / loaded.name))
        try:
            with bar_progress("chunks of samples") as progress:
                result = study.run(**running, progress=progress, message=show_message)
        except StudyInterrupted as problem:
            return show_error(str(problem), json, INTERRUPTED)
        report = SweepReport(result, strict)
        files = report.write(folder, f"{loaded.name}.sweep")
        with Replacements() as more:
            more.temporary(folder / f"{loaded.name}.sweep.csv").write_text(result.csv(), encoding="utf-8")
        return _printed(report, [*files, *more.paths], json)

    answer(scene, json, work, settings)


def _optimise(
    scene: ScenePath,
    vary: Vary = None,
    minimise: Annotated[
        str, typer.Option("--minimise", metavar="WHAT", help='The figure, such as "response peak", "random RMS x", "largest x".')
    ] = "",
    maximise: Annotated[str, typer.Option("--maximise", metavar="WHAT", help="Quantity to maximise, instead of --minimise.")] = "",
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the random numbers; 0 by default.")] = -1,
    out: Out = "",
    settings: Settings = None,
    json: Json = False,
) -> None:
    """Find the values of parameters within ranges, those of the table [vary] and of --vary, that make a figure of the scene least.

    A population of samples finds the region, a simplex refines the best of them. Writes NAME.optimise.html, .png and .json."""

    def work(loaded: Scene) -> int:
        from ..studies.study_report import writable
        from ..studies.sweep.optimisation import OptimumReport, optimise
        from .printing import bar_progress

        folder = writable(Path(out or Path("results") / loaded.name))
        figures = minimise or None, maximise or None
        with bar_progress("generations") as progress:
            optimum = optimise(loaded, _pairs(vary or (), "--vary"), *figures, None if seed < 0 else seed, progress)
        report = OptimumReport(optimum)
        return _printed(report, report.write(folder, f"{loaded.name}.optimise"), json)

    answer(scene, json, work, settings)


#: As shells report a process that ended by SIGINT.
INTERRUPTED = 130


def _printed(report: StudyReport, files: Sequence[Path], json: bool) -> int:
    """Print a report and its files, with the names of the files in the data; return the exit code."""
    return printed(report, files, json, lambda: {**report.as_json(), "files": [str(path) for path in files]})


def _pairs(texts: Sequence[str], option: str) -> dict[str, Any]:
    """Names and values of NAME=VALUE, each name once; values are read like those of --set."""
    pairs: dict[str, Any] = {}
    for text in texts:
        name, value = setting(text, option)
        if name in pairs:
            raise typer.BadParameter(f'"{name}" is given twice; give it once', param_hint=option)
        pairs[name] = value
    return pairs


def _correlation(text: str) -> list:
    names, _, value = text.partition("=")
    one, _, other = (part.strip() for part in names.partition(","))
    try:
        rho = float(value)
    except ValueError:
        rho = None
    if rho is None or not (one and other):
        raise typer.BadParameter(f'found "{text}"; expected A,B=R, e.g. k,m=0.5', param_hint="--correlation")
    return [one, other, rho]
