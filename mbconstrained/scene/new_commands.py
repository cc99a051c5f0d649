"""The commands new and schema: a scene to begin with, and what editors need to know of scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .answering import COMMAND_WRONG, leave


def add_to(app: typer.Typer) -> None:
    """Give the command line the two commands."""
    app.command(short_help="Write a scene to begin with, a comment on every line.")(new)
    app.command(short_help="Print what may stand in a scene, for editors (JSON Schema).")(schema)


def new(
    file: Annotated[str, typer.Argument(metavar="FILE", help="The scene to write, a .toml; never one that is there.")] = "",
    template: Annotated[
        str, typer.Option("--template", metavar="NAME", help="Which; left out: the one that FILE is named after, or two-masses.")
    ] = "",
    listed: Annotated[bool, typer.Option("--list", help="List the templates.")] = False,
) -> None:
    """Write a scene from a template, in which a comment says of every line what it is.

    A file that is there is never overwritten. Change the values, and ask mbconstrained check whether all is right."""
    from .printing import show_text
    from .templates import template_table, write_template

    if not (listed or file):
        raise typer.BadParameter("give the name of the scene to write, e.g. two-masses.toml, or --list", param_hint="FILE")

    def work() -> int | None:
        if listed:
            return show_text(template_table())
        try:
            written = write_template(Path(file), template)
        except FileExistsError as problem:
            typer.echo(f"{problem.filename}: there is such a file already, and it is left as it is; give another name", err=True)
            return COMMAND_WRONG
        return show_text(written)

    leave(file, False, work)


def schema(
    out: Annotated[str, typer.Option("--out", metavar="FILE", help="Write into a file instead of printing.")] = "",
    robot: Annotated[bool, typer.Option("--robot", help="That of a robot.toml instead of that of a scene.")] = False,
) -> None:
    """Print the JSON Schema of scenes, or of a robot.toml: every key with description and unit, for completion and checks."""
    from .editors import EDITORS, schema_text
    from .printing import show_text

    def work() -> None:
        if not out:
            return show_text(schema_text(robot=robot))
        from ..replacing import replacing

        with replacing(Path(out)) as beside:
            beside.write_text(schema_text(robot=robot) + "\n", encoding="utf-8")
        show_text(EDITORS.format(file=Path(out).as_posix(), name=Path(out).name, what="robot.toml" if robot else "scene"))

    leave(Path(out).name or "schema", False, work)
