"""Atomic output: files replace their targets only when all of them are complete."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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

    def temporary(self, path: Path) -> Path:
        """The temporary path of a file that replaces the target at the end.

        Raises:
            IsADirectoryError: the target is a directory.
        """
        if path.is_dir():  # checked here, before the first files are replaced
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        temporary = path.with_name(f".{path.name}.{os.getpid()}")
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
                    os.replace(temporary, path)
        finally:
            for temporary in self._places:
                temporary.unlink(missing_ok=True)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path whose file replaces the target at the end, unless an exception occurs."""
    with Replacements() as files:
        yield files.temporary(path)
