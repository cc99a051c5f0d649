"""The command mbconstrained; see ``mbconstrained --help``.

Read ``answer`` (options, exit codes), ``commands``, then ``printing``. The room may import all others, when a command needs them.
"""

from __future__ import annotations

import sys


def main() -> None:
    """Run the command line and leave with its exit code: 0 fine, 1 scene wrong, 2 command line wrong, 3 not to be trusted."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal without Greek letters gets question marks
    try:
        from . import campbell, compare, frequency, new, sensitivity, studies, variation, vibration
        from .commands import app

        compare.add_to(app)
        frequency.add_to(app)
        vibration.add_to(app)
        sensitivity.add_to(app)
        campbell.add_to(app)
        variation.add_to(app)
        studies.add_to(app)
        new.add_to(app)
        app(prog_name="mbconstrained")
    except KeyboardInterrupt:  # during an import
        sys.exit(130)
