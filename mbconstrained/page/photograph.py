"""A picture of the model at one time, taken by an installed Chromium or Chrome from a separate page.

The browser runs without a window, on a file in a temporary folder that is also its home: it starts no server, fetches
nothing, and reads and writes no user profile.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

from ..ground.checks import real_number, whole_number
from ..ground.errors import InputError, MbconstrainedError
from .animation import Animation
from .content import PageContent
from .html import page_html

#: Programs that can take pictures: names on the path, and the usual place on macOS.
BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)
NONE_INSTALLED = "no Chromium or Chrome is installed"

#: Size of a picture, px.
WIDTH, HEIGHT = 1200, 600

#: Time limit of a picture, which takes some seconds, s.
TIME_LIMIT = 120

#: Time to load and draw, by the page's own clock, which runs as fast as the machine can, ms.
_VIRTUAL_TIME = 8000

_FLAGS = (
    "--headless --disable-gpu --disable-quic --no-first-run --no-default-browser-check --disable-extensions --disable-sync "
    "--disable-background-networking --disable-component-update --disable-crash-reporter --hide-scrollbars "
    "--use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader"
).split()

#: The stage fills the window, without the rest of the page.
_STAGE_ONLY = """<style>
header, footer, .controls, details {{ display: none !important; }}
main {{ max-width: none; padding: 0; }}
section {{ border: 0; border-radius: 0; margin: 0; display: flex; flex-direction: column; height: 100vh; }}
#stage {{ flex: 1; min-height: 0; max-height: none; }}
.event:not(.shown) {{ display: none; }}
#stage .magnification {{ left: 120px; }}
#stage::after {{ content: "t = {time:.6g} s"; position: absolute; left: 14px; top: 10px; font-size: 12.5px; color: var(--muted); }}
</style>
</head>"""


def browser() -> str | None:
    """The program that can take pictures; None where none is installed."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def photograph(animation: Animation, time: float, width: int = WIDTH, height: int = HEIGHT) -> bytes:
    """The picture of the model at a time."""
    start, end = float(animation.times[0]), float(animation.times[-1])
    time = real_number(time, "still picture, time")
    if not start <= time <= end:
        raise InputError(f"still picture, time: found {time:g} s; expected a time from {start:g} to {end:g} s")
    sizes = [whole_number(size, f"still picture, {what}", minimum=16) for size, what in ((width, "width"), (height, "height"))]
    page = page_html(PageContent("still picture", animation=animation)).replace("</head>", _STAGE_ONLY.format(time=time), 1)
    return screenshot(page, f"#t={time!r}", sizes[0], sizes[1])


def screenshot(page: str, anchor: str, width: int, height: int) -> bytes:
    """The first screen of a page, at an anchor such as "#t=0.5", as PNG."""
    program = browser()
    if program is None:
        raise MbconstrainedError(f"still picture: {NONE_INSTALLED}; install one, or take a screenshot of the page")
    with tempfile.TemporaryDirectory(prefix="mbconstrained-", ignore_cleanup_errors=True) as name:
        folder, picture = Path(name), Path(name, "picture.png")
        (folder / "page.html").write_text(page, encoding="utf-8")
        root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []  # root has no sandbox
        options = [*_FLAGS, *root, f"--user-data-dir={folder / 'profile'}", f"--screenshot={picture}"]
        options += [f"--window-size={width},{height}", f"--virtual-time-budget={_VIRTUAL_TIME}"]
        last_line = _run([program, *options, (folder / "page.html").as_uri() + anchor], folder)
        if not picture.is_file():
            raise MbconstrainedError(f"still picture: {Path(program).name} failed: {last_line or 'no message'}")
        return picture.read_bytes()


def _run(command: list[str], folder: Path) -> str:
    """Run a command within the time limit, then end its children; returns the last line of its messages."""
    homes = {name: str(folder) for name in ("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME")}
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
    with (folder / "messages.txt").open("wb") as messages:
        process = subprocess.Popen(command, stderr=messages, start_new_session=True, env={**os.environ, **homes}, **quiet)
        try:
            process.wait(TIME_LIMIT)
        except subprocess.TimeoutExpired:
            raise MbconstrainedError(f"still picture: {Path(command[0]).name} took longer than {TIME_LIMIT} s") from None
        finally:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except (AttributeError, ProcessLookupError, PermissionError):  # no groups on this system, or nothing left
                process.kill()
            process.wait()
    lines = (folder / "messages.txt").read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1][:200] if lines else ""
