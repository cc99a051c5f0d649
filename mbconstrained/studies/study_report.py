"""The report of a study: sentences, tables, figures and data, for the terminal, as a page and as files."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryFile

from ..analyses.figures import Picture
from ..ground.display import TextTable
from ..ground.files import Replacements
from ..ground.notices import Notice
from ..page.content import PageContent
from ..page.html import write_page

#: Called with the name of what is being computed.
Progress = Callable[[str], None]


def no_progress(text: str) -> None:
    """Ignore progress."""


class StudyReport(ABC):
    """Base of the reports of all studies; each defines its contents.

    Attributes:
        machine: processor, system and packages, by label.
    """

    machine: dict[str, str]

    @property
    @abstractmethod
    def heading(self) -> str:
        """The title of the page."""

    @property
    @abstractmethod
    def sentences(self) -> tuple[str, ...]:
        """The result as sentences, for the terminal."""

    @property
    @abstractmethod
    def tables(self) -> tuple[TextTable, ...]:
        """Tables for the terminal and the page."""

    @abstractmethod
    def pictures(self) -> list[Picture]:
        """The figures, not yet drawn."""

    @abstractmethod
    def as_json(self) -> dict:
        """All results as plain data."""

    @property
    @abstractmethod
    def is_trusted(self) -> bool:
        """Whether the answers of this package are correct, or have a warning."""

    @property
    def page_tables(self) -> tuple[TextTable, ...]:
        """Further tables for the page."""
        return ()

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices for the page."""
        return ()

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """Labels and texts for the end of the page."""
        return tuple(self.machine.items())

    @property
    def blocks(self) -> list[str | TextTable]:
        """Blocks for the terminal: heading, sentences, tables, machine."""
        machine = "\n".join(f"{label}: {text}" for label, text in self.machine.items())
        return [self.heading, "\n".join(self.sentences), *self.tables, machine]

    def page_content(self, pictures: Sequence[Picture] | None = None) -> PageContent:
        """The report as a page."""
        pictures = self.pictures() if pictures is None else pictures
        return PageContent(
            title=self.heading,
            notices=self.notices,
            figures=tuple(picture.on_page() for picture in pictures),
            tables=(*self.tables, *self.page_tables),
            facts=self.facts,
        )

    def write(self, folder: Path, name: str) -> list[Path]:
        """Write NAME.html, NAME.png (NAME-2.png …) and NAME.json, all or none."""
        pictures = self.pictures()
        with Replacements() as files:
            write_page(folder / f"{name}.html", self.page_content(pictures), files=files)
            for number, picture in enumerate(pictures, 1):
                files.temporary(folder / f"{name}{f'-{number}' if number > 1 else ''}.png").write_bytes(picture.png())
            data = json.dumps(self.as_json(), indent=2, allow_nan=False) + "\n"
            files.temporary(folder / f"{name}.json").write_text(data, encoding="utf-8")
        return files.paths


def writable(folder: Path) -> Path:
    """The folder, created if missing, and checked before hours of computation."""
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryFile(dir=folder):
        return folder
