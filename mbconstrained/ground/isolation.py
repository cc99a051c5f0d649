"""Readers that may crash, never end or exhaust memory on damaged files, run in a separate Python process with limits."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from .errors import InputError

#: Limits of a reader: seconds, and bytes of address space.
LONGEST_READING, READING_MEMORY = 60, 8 << 30

#: The program of the process. It is given the source of a function, so that it imports no more than the function itself does.
_PROGRAM = """
import json, sys, warnings
given = json.load(sys.stdin.buffer)
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (given["memory"], given["memory"]))
except (ImportError, ValueError, OSError):  # a system without this limit
    pass
warnings.simplefilter("ignore")
scope = {}
exec("from __future__ import annotations\\n" + given["source"], scope)
try:
    scope[given["name"]](**given["arguments"])
except Exception as problem:  # packages raise errors of any class for damaged files, and only the text goes back
    with open("problem.txt", "w", encoding="utf-8", errors="replace") as file:
        file.write(str(problem) or type(problem).__name__)
"""


@dataclass(frozen=True)
class Outcome:
    """Result of a process.

    Attributes:
        folder: working folder, with the files that it wrote.
        problem: the text of its exception; an empty text where there was none.
        code: exit code, negative for a signal; None where it took too long.
    """

    folder: Path
    problem: str
    code: int | None


@contextmanager
def isolated(function: Callable[..., None], seconds: float, memory: int, **arguments) -> Iterator[Outcome]:
    """Call a function in a separate process, in an empty folder; its output is discarded.

    >>> from mbconstrained.ground.checks import nearest
    >>> with isolated(nearest, 60, 8 << 30, word="a", known=[]) as outcome:  # imports nothing itself
    ...     outcome.problem
    "name 'difflib' is not defined"
    """
    given = {"source": inspect.getsource(function), "name": function.__name__, "memory": memory, "arguments": arguments}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder, code = Path(name), None
        with suppress(subprocess.TimeoutExpired):
            code = subprocess.run(
                [sys.executable, "-c", _PROGRAM],
                input=json.dumps(given).encode(),
                cwd=folder,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                timeout=seconds,
            ).returncode
        problem = folder / "problem.txt"
        yield Outcome(folder, problem.read_text("utf-8", errors="replace") if problem.is_file() else "", code)


@contextmanager
def read_isolated(function: Callable[..., None], path: Path, failure: str, **arguments) -> Iterator[Path]:
    """Read a file by a function of its path in a separate process."""
    with isolated(function, LONGEST_READING, READING_MEMORY, path=str(path.resolve()), **arguments) as outcome:
        if outcome.code is None:
            raise InputError(f"{path.name}: {failure} (it cannot be read within {LONGEST_READING} s: it is damaged)")
        if outcome.problem:
            raise InputError(f"{path.name}: {failure} ({outcome.problem.splitlines()[0][:120]})")
        yield outcome.folder


def damaged(path: Path, failure: str) -> InputError:
    """The error about a file whose reader crashed."""
    return InputError(f"{path.name}: {failure} (its reader ends without a result: it is damaged)")
