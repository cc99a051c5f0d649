"""Common parts of all commands: options, reading of the scene, exit codes; printing of texts, tables, JSON and progress."""

from __future__ import annotations

import os
import re
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from html import unescape
from json import dumps, loads
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..ground.display import TextTable
    from ..scene.run.plan import Stage
    from ..scene.run.scene import Scene

ScenePath = Annotated[str, typer.Argument(metavar="SCENE", help="The scene file, a .toml.")]
Json = Annotated[bool, typer.Option("--json", help="Print plain data (JSON) instead of text.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Override a parameter or a key of the scene; may be repeated."),
]
DataFolders = Annotated[
    list[str] | None,
    typer.Option("--data-folder", metavar="DIR", help="Allow data files in this folder, too; may be repeated."),
]
SharedViewer = Annotated[
    bool, typer.Option("--shared-viewer", help="Write the 3-D viewer once next to the pages of a folder, not into each.")
]
Compress = Annotated[bool, typer.Option("--compress", help="Compress the scripts in the page; needs a recent browser.")]
Verbose = Annotated[bool, typer.Option("--verbose", help="Print all tables and rows, and the machine.")]
Out = Annotated[str, typer.Option("--out", metavar="DIR", help="Folder to write into; results/NAME_OF_SCENE by default.")]

_NUMBER = re.compile(r"[-+]?\.?\d")

#: Where results are written, and the file there that notes of which scene each folder is.
RESULTS, OWNERS = Path("results"), ".scenes.json"

FINE, SCENE_WRONG, COMMAND_WRONG, NOT_TRUSTED = 0, 1, 2, 3

#: Exit code of shells for a process that SIGINT ended.
INTERRUPTED = 130


def answer(
    path: str,
    json: bool,
    work: Callable[[Scene], int | None],
    settings: Sequence[str] | None = None,
    data_folders: Sequence[str] | None = None,
) -> None:
    """Read the scene, changed by NAME=VALUE of each --set, do the work, and leave with its exit code, None for 0."""
    values: dict[str, Any] = {}
    for text in settings or ():
        name, value = setting(text)
        if len(several_values(text)) > 1 and all(map(_NUMBER.match, several_values(text))):
            raise typer.BadParameter(
                f'found several values in "{text}"; expected one. To run each of them: mbconstrained compare {path} --set "{text}"',
                param_hint="--set",
            )
        if name in values:
            raise typer.BadParameter(f'"{name}" is set twice; give it one value', param_hint="--set")
        values[name] = value
    leave(Path(path).name, json, lambda: work(read(path, values, data_folders or ())))


class Results:
    """The folder of the results of a scene or record: that of --out, results/NAME, or with a number where that has those of another file."""

    def __init__(self, source: Path | None, out: str):
        self.source, self.out = source and source.absolute(), out

    @cached_property
    def folder(self) -> Path:
        if self.out:
            return Path(self.out)
        name, owners, number = self.source.stem if self.source else "gallery", _owners(), 1
        while (
            self.source
            and (owner := Path(owners.get(own := _numbered(name, number), self.source))) != self.source
            and owner.exists()
        ):
            number += 1
        if number > 1:
            typer.echo(f"results/{name} has the results of {owners[name]}; these are in results/{own}", err=True)
        return RESULTS / _numbered(name, number)

    @contextmanager
    def replacing(self) -> Iterator[list[Path]]:
        """A list for the files that are written inside; pages of other titles that they replace in a folder of --out are named."""
        titles = {page: _page_title(page) for page in self.folder.glob("*.html")} if self.out else {}
        files: list[Path] = []
        yield files
        if files and not self.out:
            self._claim(files[0].parent)
        for page in files:
            if (title := titles.get(page)) and title != _page_title(page):
                typer.echo(f'{page}: replaces the page of "{title}"', err=True)

    def _claim(self, folder: Path) -> None:
        """Note whose results a folder has."""
        from ..ground.files import replacing

        if self.source and (owners := _owners()).get(folder.name) != str(self.source):
            with replacing(RESULTS / OWNERS) as temporary:
                temporary.write_text(dumps({**owners, folder.name: str(self.source)}, indent=2) + "\n", encoding="utf-8")


def _page_title(page: Path) -> str:
    with page.open(encoding="utf-8", errors="replace") as file:
        title = re.search("<title>(.*?)</title>", file.read(4096), re.DOTALL)
    return unescape(title[1]) if title else ""


def _owners() -> dict[str, str]:
    """The files whose results are in the folders of results, by the names of the folders."""
    try:
        owners = loads((RESULTS / OWNERS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {name: path for name, path in owners.items() if isinstance(path, str)} if isinstance(owners, dict) else {}


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name}-{number}"


def setting(text: str, option: str = "--set") -> tuple[str, Any]:
    """Name and value of a --set, or of another option of this form, the value as it could stand in the file.

    >>> setting("k=3 N/mm")
    ('k', '3 N/mm')
    """
    from ..scene.file import value_of

    name, equals, value = (part.strip() for part in text.partition("="))
    if not (name and equals and value):
        raise typer.BadParameter(f'found "{text}"; expected NAME=VALUE, e.g. k="3 N/mm" or time.end=20', param_hint=option)
    return name, value_of(value)


def several_values(text: str) -> list[str]:
    """The texts of the values of a --set, separated by commas outside brackets and quotes.

    >>> several_values("k=1 N/m, 2 N/m"), several_values("times=[0, 1]")
    (['1 N/m', '2 N/m'], ['[0, 1]'])
    """
    value = text.partition("=")[2]
    parts: list[str] = re.findall(r"""(?:\[[^\]]*\]|"[^"]*"|[^,\[\]"])+""", value) or [value]
    return [part.strip() for part in parts]


def leave(name: str, json: bool, work: Callable[[], int | None]) -> None:
    """Do the work on a thing of this name, and leave with its exit code, None for 0, or that of its error."""
    from ..ground.errors import MbconstrainedError, SceneError

    try:
        code = work() or FINE
    except MbconstrainedError as problem:
        is_named = isinstance(problem, SceneError) or str(problem).startswith((f"{name}: ", f"{name}, line "))
        named = str(problem) if is_named else f"{name}: {problem}"
        code = show_error(named, json, SCENE_WRONG)
    except OSError as problem:
        code = show_error(f"the results cannot be written: {_cause(problem)}", json, COMMAND_WRONG)
    except KeyboardInterrupt as problem:
        if not problem.args:
            raise
        code = show_error(str(problem), json, INTERRUPTED)
    except MemoryError:
        code = show_error(f"{name}: this needs more memory than there is; ask for fewer points", json, SCENE_WRONG)
    raise typer.Exit(code)


def _cause(problem: OSError) -> str:
    """The file and the message of the system about it."""
    return f"{problem.filename}: {problem.strerror}" if problem.filename and problem.strerror else str(problem)


def read(path: str, settings: Mapping[str, Any], data_folders: Sequence[str] = ()) -> Scene:
    """The scene; errors of the system while it is read are about the scene, not about the results."""
    from ..ground.errors import SceneError
    from ..scene.run.scene import read_scene

    try:
        return read_scene(path, settings, data_folders)
    except OSError as problem:
        raise SceneError(f"{Path(path).name}: the scene or a file of it cannot be read: {_cause(problem)}") from None


def viewer_of(shared: bool, compressed: bool) -> str:
    """The value of [output] viewer, or an empty string for that in the scene."""
    if shared and compressed:
        raise typer.BadParameter("a viewer in a separate file is not compressed; leave out one of the two", param_hint="--compress")
    return "separate" if shared else "compressed" if compressed else ""


# --- printing

#: Narrower terminals are printed on as if they had this width.
LEAST_WIDTH = 40

#: Seconds between lines of progress where there is no terminal.
LINE_AFTER = 30.0


def show(json: bool, data: Callable[[], dict], blocks: Callable[[], Sequence[str | TextTable]]) -> None:
    """Print an answer, as plain data or as texts and tables one below the other; nothing else is printed."""
    if json:
        show_text(dumps(data(), indent=2, allow_nan=False))
    else:
        from ..ground.display import TextTable, table_text, wrapped

        width = line_width()
        show_text(
            "\n\n".join(table_text(each, width) if isinstance(each, TextTable) else wrapped(each, width) for each in blocks())
        )


def line_width() -> int:
    """Letters on a line: of the terminal, where that is what is printed on, else 80."""
    from ..ground.display import WIDTH

    return max(shutil.get_terminal_size((WIDTH, 24)).columns, LEAST_WIDTH) if sys.stdout.isatty() else WIDTH


def show_error(message: str, json: bool, code: int) -> int:
    """Print a message, the only thing that is printed, and return the exit code."""
    if json:
        show(json, lambda: {"error": message, "exit_code": code}, list)
    else:
        print(message, file=sys.stderr)
    return code


def show_text(text: str) -> None:
    """Print a text as it is; where the reader has gone (a closed pipe), be silent from then on."""
    try:
        print(text)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def stage_progress() -> Iterator[Callable[[Stage], None] | None]:
    """A line that names the running stage, in a terminal only."""
    with step_progress() as report_step:
        yield report_step and (lambda stage: report_step(stage.name))


@contextmanager
def step_progress() -> Iterator[Callable[[str], None] | None]:
    """A line that names the step being done, in a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as status:
        yield status.update


@contextmanager
def bar_progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar with the remaining time, called with the numbers done and in all; outside a terminal a line every ``LINE_AFTER`` seconds."""
    if not sys.stderr.isatty():
        yield _line_progress(what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(what, total=None)
        yield lambda done, total: progress.update(task, completed=done, total=total)


def _line_progress(what: str) -> Callable[[int, int], None]:
    start, first, last = time.monotonic(), None, time.monotonic()

    def report(done: int, total: int) -> None:
        nonlocal first, last
        first, now = done if first is None else first, time.monotonic()
        if now - last < LINE_AFTER:
            return
        last = now
        rate = (done - first) / (now - start)
        left = f", about {(total - done) / rate / 60:.2g} min left" if rate else ""
        print(f"{what}: {done:,} of {total:,}{left}", file=sys.stderr, flush=True)

    return report
