"""Files that take their places only when they are complete, several of them together."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Replacements:
    """Files written beside their places, put into them together at the end, or not at all.

    Example:
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     place = Path(folder, "answer.txt")
        ...     with Replacements() as files:
        ...         _ = files.beside(place).write_text("42")
        ...         early = place.exists()
        ...     early, place.read_text()
        (False, '42')
    """

    def __init__(self):
        self._places: dict[Path, Path] = {}

    def beside(self, path: Path) -> Path:
        """Where to write what shall stand at the path in the end.

        Raises:
            IsADirectoryError: a directory of that name is in the way.
        """
        if path.is_dir():  # found out here and not at the end, when the first files have been replaced
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        beside = path.with_name(f".{path.name}.{os.getpid()}")
        self._places[beside] = path
        return beside

    def __enter__(self) -> Replacements:
        return self

    def __exit__(self, problem, *_) -> None:
        try:
            if problem is None:
                for beside, path in self._places.items():
                    os.replace(beside, path)
        finally:
            for beside in self._places:
                beside.unlink(missing_ok=True)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A path beside the given one that takes its place at the end, unless something goes wrong."""
    with Replacements() as files:
        yield files.beside(path)
