"""A command from the declaration of an analysis: each entry of its settings is an option, and every answer is written alike."""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from itertools import product
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer.core import TyperGroup

from ..analyses import ANALYSES, load
from .answer import (
    FINE,
    NOT_TRUSTED,
    Compress,
    DataFolders,
    Json,
    Out,
    Results,
    ScenePath,
    Settings,
    SharedViewer,
    Verbose,
    answer,
    bar_progress,
    leave,
    read,
    setting,
    several_values,
    show,
    show_text,
    step_progress,
    viewer_of,
)

if TYPE_CHECKING:
    from ..analyses.base import Analysis, Answer
    from ..scene.run.scene import Scene
    from ..scene.schema.scene_schema import OutputTable

Plots = Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")]
File = Annotated[str, typer.Option("--out", metavar="FILE", help="Write into a file instead of printing.")]
Source = Annotated[str, typer.Argument(metavar="SCENE|RECORD", help="A scene, a .toml; or a file with an acceleration over time.")]
OptionalScene = Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml; left out: the gallery.")]

#: Formats of an analysis that prints a text of its own instead of writing files.
TEXT = ("text",)

#: Options of a record, by argument: the unit, the column and the step of the samples.
RECORD = {
    "unit": ("--unit", "UNIT", 'Of a record, e.g. g or "mm/s^2"; by default that in its header.'),
    "column": ("--column", "NAME", "Of a record, by number or name; 2 by default."),
    "step": ("--step", "TIME", "Between samples of a record without times."),
    "array": ("--sheet", "NAME", "Of a record in .xlsx with several sheets, or in a file of arrays."),
    "baseline": ("--baseline", "DEGREE", "Remove a polynomial of time: constant, linear, quadratic or cubic."),
}


class Commands(TyperGroup):
    """The commands of the application and those of the analyses, each made when it is called: a command loads its analysis only."""

    def list_commands(self, ctx) -> list[str]:
        """Names of all commands, with the analyses after the run."""
        names = super().list_commands(ctx)
        place = names.index("run")
        return [*names[:place], *ANALYSES, *names[place + 1 :]]

    def format_commands(self, ctx, formatter) -> None:
        """List the commands with a sentence each; no analysis is loaded."""
        with formatter.section("Commands"):
            rows = [
                (name, ANALYSES[name][1] if name in ANALYSES else self.commands[name].short_help)
                for name in self.list_commands(ctx)
            ]
            formatter.write_dl(rows)

    def get_command(self, ctx, cmd_name: str):
        """The command of this name, or None."""
        if cmd_name in self.commands or cmd_name not in ANALYSES:
            return super().get_command(ctx, cmd_name)
        analysis = load(cmd_name)
        alone = typer.Typer(add_completion=False, rich_markup_mode=None, context_settings=dict(self.context_settings))
        function_of = comparison if hasattr(analysis, "of_runs") else command
        alone.command(analysis.name, short_help=ANALYSES[cmd_name][1])(function_of(analysis))
        return typer.main.get_command(alone)


def command(analysis: type[Analysis]):
    """The function that typer makes a command of: its signature and help follow from the declaration."""
    reads_records, entries = hasattr(analysis, "of_record"), dict(_entries(analysis))

    def run(
        source: str,
        out: str,
        settings,
        data_folder,
        json: bool,
        shared_viewer=False,
        compress=False,
        page=None,
        plots=False,
        verbose=False,
        **given,
    ) -> None:
        if out and page is False:
            raise typer.BadParameter("only the page is written; give --page too", param_hint="--out")
        reading = {key: given[key] or None for key in RECORD} if reads_records else {}
        chosen = {key: _value(given[f"{key}_"], *entry[:2]) for key, entry in entries.items() if _is_given(given[f"{key}_"])}
        json = json or (analysis.formats == TEXT and "json" in chosen.values())
        writing = _Writing(analysis, out, json, viewer_of(shared_viewer, compress), page, plots, verbose)

        def work(scene) -> int:
            results = Results(scene and scene.path, out)
            if analysis.progress and analysis.formats != TEXT:
                _check_writable(results.folder)  # before hours of computation
            with _progress(analysis.progress) as progress:
                answer_of = partial(analysis.answer, scene) if scene else analysis.answer_without_scene
                one = answer_of(progress, **chosen)
            return (
                writing.text(one, scene) if analysis.formats == TEXT else writing.files(one, results, scene and scene.table.output)
            )

        if not source:
            if settings:
                raise typer.BadParameter("values are set in a scene; name one", param_hint="--set")
            leave("gallery", json, lambda: work(None))
        if used := [key for key in analysis.without_scene if key in chosen]:
            raise typer.BadParameter(f"give a scene or {used[0]}, not both", param_hint=entries[used[0]][0])
        if not reads_records or Path(source).suffix.lower() == ".toml":
            if used := [key for key, value in reading.items() if value is not None]:
                raise typer.BadParameter("it belongs to a record; a scene has its units in its tables", param_hint=f"--{used[0]}")
            answer(source, json, work, settings, data_folder)
        if settings:
            raise typer.BadParameter("values are set in a scene; this is a record", param_hint="--set")
        leave(Path(source).name, json, lambda: writing.files(*_of_record(analysis, Path(source), chosen, reading, out)))

    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]  # functions have it only once it is set
        [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
            for name, (kind, default) in _parameters(analysis, entries).items()
        ]
    )
    run.__doc__, run.__name__ = inspect.getdoc(analysis), analysis.name
    return run


@dataclass(frozen=True)
class _Writing:
    """Where and how the answer of a command is written and printed; each method returns the exit code."""

    analysis: type[Analysis]
    out: str
    json: bool
    viewer: str
    page: bool | None  # None for analyses that write without being asked
    plots: bool
    verbose: bool

    def files(self, one: Answer, results: Results, output: OutputTable | None) -> int:
        from ..analyses.base import formats_of

        usual = {*(self.analysis.formats or formats_of(output)), *(["pictures"] if self.plots else [])}
        formats = usual if self.page is None else {"page"} if self.page else set()
        viewer: Any = self.viewer or (output.viewer if output else "inside")
        files: list[Path] = []
        if formats:
            with results.replacing() as files:
                files += one.write(results.folder, formats, viewer)
        show(self.json, lambda: one.to_dict(files), lambda: one.blocks(files, verbose=self.verbose))
        return FINE if one.is_trusted else NOT_TRUSTED

    def text(self, one: Answer, scene) -> int:

        text = dumps(one.to_dict(), indent=2, allow_nan=False, ensure_ascii=False) if self.json else one.text
        if self.out:
            _write(Path(self.out), text + "\n", scene.path)
        else:
            show_text(text)
        return FINE


def _parameters(analysis: type[Analysis], entries: dict) -> dict[str, tuple[Any, Any]]:
    """The parameters of a command by name: annotations for typer, and defaults."""
    place: tuple[Any, Any] = (Source if hasattr(analysis, "of_record") else ScenePath, inspect.Parameter.empty)
    result = {"source": (OptionalScene, "") if analysis.without_scene else place}
    result |= {f"{name}_": _option(*entry) for name, entry in entries.items()}  # "from" is a word of Python's grammar
    if hasattr(analysis, "of_record"):
        result |= {name: _option(flag, kind, text) for name, (flag, kind, text) in RECORD.items()}
    if analysis.formats == TEXT:
        return result | {"out": (File, ""), "settings": (Settings, None), "data_folder": (DataFolders, None), "json": (Json, False)}
    if not analysis.writes:
        result["page"] = _option("--page", bool, f"Write NAME.{analysis.name}.html too.")
    result["out"] = (Out, "")
    if analysis.writes:
        result["plots"] = (Plots, False)
    result |= {"shared_viewer": (SharedViewer, False), "compress": (Compress, False)}
    return result | {
        "verbose": (Verbose, False),
        "settings": (Settings, None),
        "data_folder": (DataFolders, None),
        "json": (Json, False),
    }


def _entries(analysis: type[Analysis]):
    """Option, kind, help and bounds of each setting; tables and lists where the analysis names an option for them.

    Entries of a table of the scene have no bounds here: what is wrong with them is wrong in the scene.
    """
    from ..scene.schema.scene_schema import SceneFile

    for name, field in analysis.settings.model_fields.items() if analysis.settings else ():
        key, kinds = field.alias or name, set(typing.get_args(field.annotation)) - {type(None)} or {field.annotation}
        origins = {typing.get_origin(kind) for kind in (*kinds, field.annotation)}
        several = next((one for one in (dict, list) if one in origins), None)
        flag = analysis.options.get(key, None if several or Any in kinds else f"--{key.replace('_', '-')}")
        if flag is not None:
            bounds = {end: getattr(one, name) for one in field.metadata for name, end in _BOUNDS.items() if hasattr(one, name)}
            bounds = {end: bound for end, bound in bounds.items() if bound <= LARGEST_BOUND}
            is_number = all(any(hasattr(one, name) for name in _BOUNDS) for one in field.metadata)  # others are texts with units
            items = (typing.get_args(one)[0] for one in (*kinds, field.annotation) if typing.get_origin(one) is list)
            names = tuple if any(str in (item, *typing.get_args(item)) for item in items) else None
            choice = field.annotation if typing.get_origin(field.annotation) is Literal else None
            kind = names or several or choice or next((one for one in (bool, int, float) if kinds == {one} and is_number), str)
            checked = bounds if kind in (int, float) and analysis.name not in SceneFile.model_fields else {}
            yield key, (flag, kind, _with_default(field), checked)


def _with_default(field) -> str:
    """The help of an option, with the value that it has where nothing gives it unless the text has that."""
    text, default = field.description or "", field.default
    states_it = re.search(r"\bdefault|left out\b", text)
    if states_it or isinstance(default, bool) or not isinstance(default, (int, float, str)) or default == "":
        return text
    unit = next((f" {schema['unit']}" for one in field.metadata if "unit" in (schema := getattr(one, "json_schema", {}))), "")
    return f"{text.removesuffix('.')}; {f'{default:g}' if isinstance(default, float) else default}{unit.removesuffix(' 1')} by default."


#: Largest bound that stands in a help text; larger ones are those of the numbers of a computer.
LARGEST_BOUND = 10**9

#: Bounds of numbers, as pydantic and typer name them.
_BOUNDS = {"ge": "min", "le": "max"}


def _option(flag: str, kind, text: str, bounds=None):
    if kind is bool:
        return Annotated[bool, typer.Option(flag, help=text)], False
    if kind in _SEVERAL:
        return Annotated[list[str] | None, typer.Option(flag, metavar=_SEVERAL[kind], help=f"{text} May be repeated.")], None
    if typing.get_origin(kind) is Literal:
        return Annotated[kind | None, typer.Option(flag, help=text)], None
    if kind in (int, float):
        return Annotated[kind | None, typer.Option(flag, metavar="N", help=text, **bounds)], None
    return Annotated[str, typer.Option(flag, metavar=kind if isinstance(kind, str) else "VALUE", help=text)], ""


#: Metavariables of options that may be repeated: tables, lists, and lists of names, several of which may stand in one text.
_SEVERAL = {dict: "NAME=VALUE", list: "VALUE", tuple: "NAME,…"}


def _is_given(value) -> bool:
    return value not in (None, "", []) and value is not False


def _value(given, flag: str, kind):
    """The value of an option as it could stand in the scene; NAME=VALUE of each option of a table, each name once."""
    from ..scene.file import value_of

    if kind is tuple:
        return [name for text in given for name in several_values(f"={text}")]
    if kind is list:
        return [value_of(text) for text in given]
    if kind is not dict:
        return value_of(given) if isinstance(given, str) else given
    pairs: dict[str, Any] = {}
    for name, value in (setting(text, flag) for text in given):
        if name in pairs:
            raise typer.BadParameter(f'"{name}" is given twice; give it once', param_hint=flag)
        pairs[name] = value
    return pairs


def _progress(counted: str):
    """Context of a function that reports progress: of steps by name, else a bar of what is counted."""

    return step_progress() if counted == "steps" else bar_progress(counted) if counted else nullcontext()


def _check_writable(folder: Path) -> None:
    from tempfile import TemporaryFile

    with TemporaryFile(dir=next(one for one in (folder, *folder.absolute().parents) if one.exists())):
        pass


def _of_record(analysis, path: Path, chosen: dict, reading: dict, out: str):
    from ..ground.quantities import quantity
    from ..scene.schema.scene_schema import OutputTable

    column, step = reading["column"], reading["step"]
    own = {**reading, "step": quantity(step, "s") if step else None, "column": int(column) if (column or "").isdigit() else column}
    return analysis.of_record(path, analysis.changed(None, chosen, path.name), **own), Results(path, out), OutputTable()


def _write(path: Path, text: str, scene: Path) -> None:
    from ..ground.errors import InputError
    from ..ground.files import replacing

    path = path.resolve()  # a link stays, the file that it leads to is replaced
    if path.exists() and path.samefile(scene):
        raise InputError(f"--out: {path.name} is the scene itself; give another file")
    if path.exists() and not path.is_file():  # a terminal or another device is written to
        path.write_text(text, encoding="utf-8")
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


# The command compare: several scenes, or one with several values, run and drawn in common plots.

#: More runs than these are too many for one plot.
MOST_RUNS = 12

Scenes = Annotated[list[str], typer.Argument(metavar="SCENE...", help="Scene files, .toml; or one, with several values by --set.")]
Values = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=A,B,...", help="Run each scene with each of these values of a parameter or place."),
]
Folder = Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write into; results/compare by default.")]


def comparison(analysis):
    def run(scenes: Scenes, out: Folder = "", settings: Values = None, data_folder: DataFolders = None, json: Json = False) -> None:
        def work() -> int:

            folder = Path(out or Path("results") / analysis.name)
            one, files = analysis.of_runs(dict(_runs(scenes, settings or (), data_folder or ())), folder)
            files += one.write(folder, analysis.formats)
            show(json, lambda: one.to_dict(files), lambda: one.blocks(files))
            return FINE if one.is_trusted else NOT_TRUSTED

        leave(", ".join(Path(path).name for path in scenes), json, work)

    run.__doc__, run.__name__ = inspect.getdoc(analysis), analysis.name
    return run


def _runs(paths: Sequence[str], settings: Sequence[str], data_folders: Sequence[str]) -> Iterator[tuple[str, Scene]]:
    """Every scene with every combination of values, by the name of its folder."""
    from ..ground.errors import InputError

    choices = [(setting(text)[0], several_values(text)) for text in settings]
    if len({name for name, _ in choices}) < len(choices):
        raise typer.BadParameter("a name is set twice; give all its values in one, e.g. k=1,2", param_hint="--set")
    combinations = list(product(*([(name, value) for value in values] for name, values in choices)))
    count = len(paths) * len(combinations)
    if not 2 <= count <= MOST_RUNS:
        raise InputError(
            f"found {count} run{'s' if count > 1 else ''}; expected 2 to {MOST_RUNS}: scenes, or values as in --set k=1,2"
        )
    labels: dict[str, int] = {}
    for path, combination in product(paths, combinations):
        chosen = [f"{name}={text}" for name, text in combination if len(combinations) > 1]
        label = re.sub(r"[^\w.=+-]+", "_", " ".join([*([Path(path).stem] if len(paths) > 1 or not chosen else []), *chosen]))
        labels[label] = labels.get(label, 0) + 1
        own = label if labels[label] == 1 else f"{label}_{labels[label]}"
        yield own, read(path, dict(setting(f"{name}={text}") for name, text in combination), data_folders)
