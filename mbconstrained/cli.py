"""The command mbconstrained; see ``mbconstrained --help``."""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line and leave with its exit code: 0 fine, 1 scene wrong, 2 command line wrong, 3 not to be trusted."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters gets question marks
    try:
        from .reports.commands import add_to
        from .scene.commands import app
        from .scene.new_commands import add_to as add_new

        add_to(app)
        add_new(app)
        app(prog_name="mbconstrained")
    except KeyboardInterrupt:  # while something is still being imported
        sys.exit(130)


if __name__ == "__main__":
    main()
