"""The command mbconstrained; see ``mbconstrained --help``.

Read ``answer`` (options, exit codes, printing), then ``commands``. The room may import all others, when a command needs them.
"""

from __future__ import annotations

import atexit
import gc
import os
import sys
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import typer


def main() -> None:
    """Run the command line and leave with its exit code: 0 fine, 1 scene wrong, 2 command line wrong, 3 not to be trusted."""
    gc.set_threshold(500_000)  # the many objects of imports stay: to look through them again and again is a tenth of a short run
    atexit.register(gc.freeze)  # nor at the end, which would be a fifth
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # they are searched for in the metadata of all installed packages
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters gets question marks
    try:
        if sys.argv[1:2] == ["--version"]:  # the commands take longer to import
            from importlib.metadata import version

            print(f"mbconstrained {version('mbconstrained')}")
            sys.exit(0)
        application()(prog_name="mbconstrained")
    except KeyboardInterrupt:  # during an import
        sys.exit(130)


@cache
def application() -> typer.Typer:
    """The application with all commands, in the order of the help."""
    from .commands import app

    return app
