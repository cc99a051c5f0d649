"""How many files and functions of the package a command executes, and where most of them are.

    python tests/benchmarks/functions_touched.py [run examples/two_masses.toml]

Counted from the import of the package on: functions and methods that are called at least once. Bodies of modules and classes,
lambdas and comprehensions do not count.
"""

from __future__ import annotations

import inspect
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "mbconstrained"
MOST = 25  # files listed


def functions_touched(arguments: list[str]) -> set[tuple[str, str]]:
    """(file, function) of every function that the command line with these arguments calls."""
    touched = set()

    def profile(frame, event, _) -> None:
        code = frame.f_code
        is_function = code.co_flags & inspect.CO_OPTIMIZED and not code.co_name.startswith("<")
        if event == "call" and is_function and code.co_filename.startswith(str(PACKAGE)):
            touched.add((code.co_filename.removeprefix(f"{PACKAGE}/"), code.co_qualname))

    sys.path.insert(0, str(ROOT))
    sys.argv = ["mbconstrained", *arguments]
    sys.setprofile(profile)
    try:
        from mbconstrained.cli import main

        main()
    except SystemExit:
        pass
    finally:
        sys.setprofile(None)
    return touched


def main() -> None:
    """Print both counts and the largest contributors."""
    arguments = sys.argv[1:] or ["run", str(ROOT / "examples" / "two_masses.toml")]
    with tempfile.TemporaryDirectory() as folder:
        if arguments[0] == "run":
            arguments += ["--out", folder]
        touched = functions_touched(arguments)
    rooms = Counter(file.split("/")[0] for file, _ in touched)
    files = Counter(file for file, _ in touched)
    print(f"\n{len(files)} files, {len(touched)} functions")
    print("rooms:", ", ".join(f"{room} {count}" for room, count in rooms.most_common()))
    for file, count in files.most_common(MOST):
        print(f"{count:5d}  {file}")


if __name__ == "__main__":
    main()
