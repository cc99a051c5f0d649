"""One still picture of the moving model, taken by an installed Chromium or Chrome from a page of its own.

The browser runs without a window, on a file in a temporary folder that is its home as well: no server is started, nothing
is fetched, and nobody's profile is read or written.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

from ..checks import real_number, whole_number
from ..errors import InputError, MbconstrainedError
from .content import Animation, PageContent
from .html import page_html

#: Names under which a Chromium is installed, and where it stands on a Macintosh.
BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)
NONE_INSTALLED = "no Chromium or Chrome is installed, which would take it"

WIDTH, HEIGHT = 1200, 600

#: A picture takes some seconds; after so many it is given up.
SECONDS = 120

#: Of the page's own clock, in ms, which runs as fast as the machine can: time enough to load and draw.
_LOADED = 8000

_FLAGS = (
    "--headless --disable-gpu --disable-quic --no-first-run --no-default-browser-check --disable-extensions --disable-sync "
    "--disable-background-networking --disable-component-update --disable-crash-reporter --hide-scrollbars "
    "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader"
).split()

#: The stage fills the window, and nothing else is seen.
_ALONE = """<style>
header, footer, .controls {{ display: none !important; }}
main {{ max-width: none; padding: 0; }}
section {{ border: 0; border-radius: 0; margin: 0; display: flex; flex-direction: column; height: 100vh; }}
#stage {{ flex: 1; min-height: 0; }}
.moment:not(.shown) {{ display: none; }}
#stage .magnification {{ left: 120px; }}
#stage::after {{ content: "t = {time:.6g} s"; position: absolute; left: 14px; top: 10px; font-size: 12.5px; color: var(--muted); }}
</style>
</head>"""


def browser() -> str | None:
    """The program that can take pictures; None where none is installed."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def photograph(animation: Animation, time: float, width: int = WIDTH, height: int = HEIGHT) -> bytes:
    """The picture of the model at a time, as PNG.

    Args:
        animation: bodies and motion.
        time: in s, within the animation.
        width, height: in pixels.

    Raises:
        InputError: a time outside the animation, a size that is no picture's.
        MbconstrainedError: no browser is installed, or it takes no picture.
    """
    start, end = float(animation.times[0]), float(animation.times[-1])
    time = real_number(time, "still picture, time")
    if not start <= time <= end:
        raise InputError(f"still picture, time: found {time:g} s; expected a time from {start:g} to {end:g} s")
    sizes = [whole_number(size, f"still picture, {what}", minimum=16) for size, what in ((width, "width"), (height, "height"))]
    page = page_html(PageContent("still picture", animation=animation)).replace("</head>", _ALONE.format(time=time), 1)
    return _taken(page, f"#t={time!r}", *sizes)


def _taken(page: str, fragment: str, width: int, height: int) -> bytes:
    program = browser()
    if program is None:
        raise MbconstrainedError(f"still picture: {NONE_INSTALLED}; install one, or take a picture of the page by hand")
    with tempfile.TemporaryDirectory(prefix="mbconstrained-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "page.html").write_text(page, encoding="utf-8")
        picture = folder / "picture.png"
        address = (folder / "page.html").as_uri() + fragment
        root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []  # there is none for root
        told = _run(
            [
                *(program, *_FLAGS, *root, f"--user-data-dir={folder / 'profile'}", f"--window-size={width},{height}"),
                *(f"--virtual-time-budget={_LOADED}", f"--screenshot={picture}", address),
            ],
            folder,
        )
        if not picture.is_file():
            raise MbconstrainedError(f"still picture: {Path(program).name} took none; it says: {told or 'nothing'}")
        return picture.read_bytes()


def _run(command: list[str], folder: Path) -> str:
    """Run it to its end, or to the end of its time, with all that it has started; its last words."""
    homes = {name: str(folder) for name in ("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")}
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
    with (folder / "words.txt").open("wb") as words:
        process = subprocess.Popen(command, stderr=words, start_new_session=True, env={**os.environ, **homes}, **quiet)
        try:
            process.wait(SECONDS)
        except subprocess.TimeoutExpired:
            raise MbconstrainedError(f"still picture: {Path(command[0]).name} took none within {SECONDS} s") from None
        finally:
            _end(process)
    lines = (folder / "words.txt").read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1][:200] if lines else ""


def _end(process: subprocess.Popen) -> None:
    """End the process, and what it has started, where they still run."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except (AttributeError, ProcessLookupError, PermissionError):  # no groups on this system, or nothing left
        process.kill()
    process.wait()
