"""The pictures of the documentation, made by the commands that stand before them.

    python -m mbconstrained.docs.pictures [PAGE ...]

A page has a picture by the lines ``<!-- picture: COMMAND -->`` and ``![TEXT](../pictures/FILE)``: FILE is what ``mbconstrained COMMAND --plots``
writes, or of the command ``python`` the blocks of Python of the page. NAME.still.png shows the model, by ``--still``, and NAME.page.png the first
screen of NAME.html; both need Chromium.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import chdir, redirect_stderr, redirect_stdout
from doctest import DocTestParser, DocTestRunner
from pathlib import Path
from unittest.mock import patch

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parents[1]
FOLDER = DOCS / "pictures"

#: Size of a screen, width of a picture of it or of a model, px, the number of its colours, and what stays empty below, px.
SCREEN, WIDTH, COLORS, MARGIN = (1000, 860), 720, 200, 20


def pictures(page: Path) -> Iterator[tuple[str, str]]:
    """(command, file) of the pictures of a page."""
    yield from re.findall(
        r"^<!-- picture: (.+) -->\n+!\[[^\]]+\]\((?:\S*/)?pictures/(\S+)\)$", page.read_text(encoding="utf-8"), re.M
    )


def drawn(page: Path, made: Mapping[str, Path] | None = None) -> Iterator[tuple[str, bytes]]:
    """(file, content) of the pictures of a page, made by its commands; each runs once, unless the folder of its files is known."""
    wanted: dict[str, list[str]] = {}
    for command, file in pictures(page):
        wanted.setdefault(command, []).append(file)
    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        for name in ("examples", "robots"):
            Path(name).symlink_to(ROOT / name)
        for title, scene in re.findall(r"^```toml\n# (\w+\.toml)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S):
            Path(title).write_text(scene, encoding="utf-8")
        for number, (command, files) in enumerate(wanted.items()):
            out = (made or {}).get(command)
            if out is None and command == "python":
                out = Path()
                _execute(page.read_text(encoding="utf-8"))
            elif out is None:
                out = Path(f"out{number}")
                _run([*shlex.split(command), *["--plots"] * any(file.endswith(".svg") for file in files), "--out", str(out)])
            for file in files:
                yield file, _picture(out / file, _anchor(command))


def _anchor(command: str) -> str:
    """The time of a screen, that of the option --still."""
    return "".join(f"#t={time}" for time in re.findall(r"--still ([\d.]+)s", command))


def _picture(file: Path, anchor: str) -> bytes:
    if file.name.endswith(".page.png"):
        from ..page.photograph import screenshot

        page = file.with_name(file.name.replace(".page.png", ".html")).read_text(encoding="utf-8")
        return _small(screenshot(page, anchor, *SCREEN))
    if file.suffix == ".png":
        return _small(file.read_bytes())
    return re.sub(rb' d="[^"]*"', _in_hundredths, file.read_bytes())


def _in_hundredths(path: re.Match[bytes]) -> bytes:
    """A path of an SVG in hundredths of a point, which are enough."""
    return re.sub(rb"(\.\d\d)\d+", rb"\1", path[0])


def _run(arguments: list[str]) -> None:
    from ..cli import main

    printed = io.StringIO()
    with patch.object(sys, "argv", ["mbconstrained", *arguments]), redirect_stdout(printed), redirect_stderr(printed):
        try:
            main()
        except SystemExit as end:
            if end.code:
                raise RuntimeError(f"mbconstrained {shlex.join(arguments)}: {printed.getvalue()}") from None


def _execute(text: str) -> None:
    """Run the blocks of Python of a page; the same plot is the same file at any time."""
    from ..page.plots import page_style

    examples = DocTestParser().get_doctest(text, {}, "page", None, 0)
    style: dict[str, object] = {"figure.figsize": (7.0, 3.0), "figure.constrained_layout.use": True, "text.parse_math": True}
    undated = patch.dict(os.environ, SOURCE_DATE_EPOCH="0")
    with page_style(**style), undated, redirect_stdout(io.StringIO()):
        _PageRunner().run(examples)


class _PageRunner(DocTestRunner):
    """Runs the code of a page; what it prints is compared by the tests of the documentation."""

    def report_failure(self, *_) -> None:
        """Nothing."""

    def report_unexpected_exception(self, out, test, example, exc_info) -> None:
        """Raise the exception."""
        raise exc_info[1]


def _small(content: bytes) -> bytes:
    """A PNG of a page's width with few colours, without what is empty below."""
    from PIL import Image, ImageChops

    picture, file = Image.open(io.BytesIO(content)).convert("RGB"), io.BytesIO()
    empty = Image.new("RGB", picture.size, picture.getpixel((0, picture.height - 1)))
    _, _, _, last = ImageChops.difference(picture, empty).getbbox() or (0, 0, 0, 0)
    picture = picture.crop((0, 0, picture.width, min(last + MARGIN, picture.height)))
    picture.thumbnail((WIDTH, 2 * WIDTH), Image.Resampling.LANCZOS)
    picture.quantize(COLORS, kmeans=3).save(file, format="png", optimize=True)
    return file.getvalue()


#: The pages that may have pictures.
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]


def write(say: Callable[[str], None], pages: list[Path]) -> None:
    """Write the pictures of pages; of all pages, remove those that no page shows."""
    FOLDER.mkdir(exist_ok=True)
    for page in pages:
        for file, content in drawn(page):
            (FOLDER / file).write_bytes(content)
            say(f"{page.name}: {file}, {len(content) / 1000:.0f} kB")
    used = {file for page in PAGES for _, file in pictures(page)}
    for path in FOLDER.iterdir():
        if path.name not in used:
            path.unlink()


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    named = [Path(word).resolve() for word in sys.argv[1:]]
    write(print, named or PAGES)
