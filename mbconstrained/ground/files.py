"""Files of users: checked before they are read, and atomic output, which replaces its targets only when all of it is complete."""

from __future__ import annotations

import errno
import inspect
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from .checks import nearest
from .errors import InputError

LARGEST_FILE = 200_000_000  # bytes, also of one unpacked array


@contextmanager
def readable_as(path: Path, failure: str) -> Iterator[None]:
    """Read a file by another package: its errors, of many classes for damaged files, are wrong input here."""
    try:
        yield
    except (InputError, OSError):
        raise
    except Exception as problem:
        text = (str(problem).splitlines() or [type(problem).__name__])[0][:120]
        if "pickle" in text:  # NumPy advises to load it nevertheless
            text = "it is damaged, or holds Python objects, which are never loaded"
        raise InputError(f"{path.name}: {failure} ({text})") from None


def path_of(value, what: str = "path") -> Path:
    """A path, or an InputError for what is none.

    >>> path_of("two_masses.toml").suffix
    '.toml'
    """
    try:
        return Path(value)
    except TypeError:
        raise InputError(f'{what}: found {value!r}; expected a path as text, such as "examples/two_masses.toml"') from None


def checked_file(path: str | Path) -> Path:
    """The path of a file that can be read."""
    path = path_of(path)
    try:
        if not path.exists():
            others = [other.name for other in path.parent.glob("*") if other.is_file()] if path.parent.is_dir() else []
            raise InputError(f"{path.name}: there is no such file in the folder{nearest(path.name, others)}")
        if not path.is_file():
            raise InputError(f"{path.name}: expected a file, found another object of that name")
        size = path.stat().st_size
        with open(path, "rb"):  # not every reader reports a missing permission itself
            pass
    except OSError as problem:
        raise InputError(f"{path.name}: the file cannot be read ({problem.strerror or problem})") from None
    if size > LARGEST_FILE:
        raise InputError(f"{path.name}: the file has {size:,} bytes; at most {LARGEST_FILE:,} are read")
    if size == 0:
        raise InputError(f"{path.name}: the file is empty")
    return path


class Replacements:
    """Files written under temporary names in the folders of their targets, which they replace together at the end or not at all.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     place = Path(folder, "answer.txt")
        ...     with Replacements() as files:
        ...         _ = files.temporary(place).write_text("42")
        ...         early = place.exists()
        ...     early, place.read_text()
        (False, '42')
    """

    def __init__(self):
        self._places: dict[Path, Path] = {}

    def temporary(self, path: Path, mark: str = "") -> Path:
        """The temporary path of a file that replaces the target at the end."""
        if path.is_dir() and not (mark and (path / mark).exists()):  # checked here, before the first files are replaced
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        temporary = path.with_name(f".{path.name}.{threading.get_ident()}.{os.getpid()}")  # threads may write the same files
        self._places[temporary] = path
        return temporary

    @property
    def paths(self) -> list[Path]:
        """The paths at which files will stand in the end, in the order in which they were written."""
        return list(self._places.values())

    def __enter__(self) -> Replacements:
        return self

    def __exit__(self, problem, *_) -> None:
        try:
            if problem is None:
                for temporary, path in self._places.items():
                    if path.is_dir():
                        shutil.rmtree(path)
                    os.replace(temporary, path)
        finally:
            for temporary in self._places:
                if temporary.is_dir():
                    shutil.rmtree(temporary, ignore_errors=True)
                temporary.unlink(missing_ok=True)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path whose file replaces the target at the end, unless an exception occurs."""
    with Replacements() as files:
        yield files.temporary(path)


# Readers that may crash, never end or exhaust memory on damaged files, run in a separate Python process with limits.

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
    """Result of a process."""

    folder: Path  # working folder, with the files that it wrote
    problem: str  # the text of its exception; an empty text where there was none
    code: int | None  # exit code, negative for a signal; None where it took too long


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
