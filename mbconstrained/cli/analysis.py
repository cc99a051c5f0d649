"""A command from the declaration of an analysis: each entry of its settings is an option, and every answer is written alike."""

from __future__ import annotations

import inspect
import typing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ..analyses import ANALYSES, load
from .answer import (
    FINE,
    NOT_TRUSTED,
    Compress,
    Json,
    Out,
    ScenePath,
    Settings,
    SharedViewer,
    answer,
    leave,
    several_values,
    viewer_of,
)

if TYPE_CHECKING:
    from ..analyses.base import Analysis, Answer
    from ..scene.schema.scene_schema import OutputTable

Plots = Annotated[bool, typer.Option("--plots", help="Write the plots as SVG and PNG too.")]
Source = Annotated[str, typer.Argument(metavar="SCENE|RECORD", help="A scene, a .toml; or a file with an acceleration over time.")]

#: Options of a record, by argument: the unit, the column and the step of the samples.
RECORD = {
    "unit": ("--unit", "UNIT", 'Of a record, e.g. g or "mm/s^2"; by default that in its header.'),
    "column": ("--column", "NAME", "Of a record, by number or name; 2 by default."),
    "step": ("--step", "TIME", "Between samples of a record without times."),
}


class Commands(TyperGroup):
    """The commands of the application and those of the analyses, each made when it is called: a command loads its analysis only."""

    def list_commands(self, ctx) -> list[str]:
        """Names of all commands, with the analyses after the run."""
        names = super().list_commands(ctx)
        place = names.index("run") + 1
        return [*names[:place], *ANALYSES, *names[place:]]

    def get_command(self, ctx, cmd_name: str):
        """The command of this name, or None."""
        if cmd_name not in ANALYSES:
            return super().get_command(ctx, cmd_name)
        analysis, alone = (
            load(cmd_name),
            typer.Typer(add_completion=False, rich_markup_mode=None, context_settings=dict(self.context_settings)),
        )
        alone.command(analysis.name, short_help=analysis.help)(command(analysis))
        return typer.main.get_command(alone)


def command(analysis: type[Analysis]):
    """The function that typer makes a command of: its signature and help follow from the declaration."""
    reads_records, entries = hasattr(analysis, "of_record"), dict(_entries(analysis))
    options = {f"{name}_": _option(*entry) for name, entry in entries.items()}  # "from" is a word of Python's grammar
    options |= {name: _option(flag, kind, text) for name, (flag, kind, text) in RECORD.items()} if reads_records else {}
    page_option = _option("--page", "", f"Write NAME.{analysis.name}.html too.")
    common: dict[str, tuple[Any, Any]] = {} if analysis.writes else {"page": page_option}
    common |= {"out": (Out, "")} | ({"plots": (Plots, False)} if analysis.writes else {})
    common |= {
        "shared_viewer": (SharedViewer, False),
        "compress": (Compress, False),
        "settings": (Settings, None),
        "json": (Json, False),
    }

    def run(source: str, out: str, shared_viewer: bool, compress: bool, settings, json: bool, **given) -> None:
        page, plots = given.pop("page", None), given.pop("plots", False)
        if out and page is False:
            raise typer.BadParameter("only the page is written; give --page too", param_hint="--out")
        reading = {key: given.pop(key) or None for key in RECORD} if reads_records else {}
        chosen = {key: _value(given[f"{key}_"]) for key in entries if given[f"{key}_"]}
        viewer: Any = viewer_of(shared_viewer, compress)

        def write(one: Answer, output: OutputTable) -> int:
            from ..analyses.base import formats_of
            from .printing import show

            formats = {*formats_of(output), *(["pictures"] if plots else [])} if page is None else {"page"} if page else set()
            files = one.write(Path(out or Path("results") / one.name), formats, viewer or output.viewer) if formats else []
            show(json, lambda: one.to_dict(files), lambda: one.blocks(files))
            return FINE if one.is_trusted else NOT_TRUSTED

        if not reads_records or Path(source).suffix.lower() == ".toml":
            if used := [key for key, value in reading.items() if value is not None]:
                raise typer.BadParameter("it belongs to a record; a scene has its units in its tables", param_hint=f"--{used[0]}")
            answer(source, json, lambda scene: write(analysis.answer(scene, **chosen), scene.table.output), settings)
        if settings:
            raise typer.BadParameter("values are set in a scene; this is a record", param_hint="--set")
        leave(Path(source).name, json, lambda: write(*_of_record(analysis, Path(source), chosen, reading)))

    parameters = [("source", Source if reads_records else ScenePath, inspect.Parameter.empty)]
    parameters += [(name, kind, default) for name, (kind, default) in {**options, **common}.items()]
    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
            for name, kind, default in parameters
        ]
    )
    run.__doc__, run.__name__ = inspect.getdoc(analysis), analysis.name
    return run


def _entries(analysis: type[Analysis]):
    """Option, metavariable and help of each setting, except tables and lists that have no option of their own."""
    for name, field in analysis.settings.model_fields.items() if analysis.settings else ():
        key, kinds = field.alias or name, (field.annotation, *typing.get_args(field.annotation))
        origins = {typing.get_origin(kind) for kind in kinds}
        if Any in kinds or dict in origins or (list in origins and key not in analysis.options):
            continue
        flag = analysis.options.get(key, f"--{key.replace('_', '-')}")
        if flag is not None:
            value = "NAME,…" if list in origins else "" if field.annotation is bool else "VALUE"
            yield key, (flag, value, field.description or "")


def _option(flag: str, value: str, text: str):
    if not value:
        return Annotated[bool, typer.Option(flag, help=text)], False
    if value.endswith("…"):
        return Annotated[list[str] | None, typer.Option(flag, metavar=value, help=f"{text} May be repeated.")], None
    return Annotated[str, typer.Option(flag, metavar=value, help=text)], ""


def _value(given):
    """The value of an option as it could stand in the file; each text of a list may have several names with commas."""
    from ..scene.quantities.settings import value_of

    if isinstance(given, list):
        return [name for text in given for name in several_values(f"={text}")]
    return value_of(given) if isinstance(given, str) else given


def _of_record(analysis, path: Path, chosen: dict, reading: dict):
    from ..ground.quantities import quantity
    from ..scene.schema.scene_schema import OutputTable

    column, step = reading["column"], reading["step"]
    own = {**reading, "step": quantity(step, "s") if step else None, "column": int(column) if (column or "").isdigit() else column}
    return analysis.of_record(path, analysis.changed(None, chosen, path.name), **own), OutputTable()
