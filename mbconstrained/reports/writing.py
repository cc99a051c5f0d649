"""A report as files: a page, its picture, its data; all of them or none."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile

from ..page import page_html
from ..page.content import PageContent
from ..replacing import Replacements
from .figures import Picture


def writable(folder: Path) -> Path:
    """The folder, made if there is none: found out before hours of measuring, not after.

    Raises:
        OSError: nothing can be written there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryFile(dir=folder):
        return folder


def write_report(folder: Path, name: str, content: PageContent, pictures: Sequence[Picture], data: dict) -> list[Path]:
    """Write NAME.html, NAME.png (NAME-2.png …) and NAME.json.

    Raises:
        OSError: they cannot be written; what was there before is still there.
    """
    files = {folder / f"{name}.html": page_html(content).encode("utf-8")}
    for number, picture in enumerate(pictures, 1):
        files[folder / f"{name}{f'-{number}' if number > 1 else ''}.png"] = picture.png()
    files[folder / f"{name}.json"] = (json.dumps(data, indent=2, allow_nan=False) + "\n").encode("utf-8")
    with Replacements() as places:
        for path, text in files.items():
            places.beside(path).write_bytes(text)
    return list(files)


def written_lines(files: Sequence[Path]) -> str:
    """What was written, for the terminal."""
    return "\n".join(f"wrote {path}" for path in files)
