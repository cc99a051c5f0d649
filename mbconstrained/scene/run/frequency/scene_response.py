"""Responses of a scene in addition to its run, with their page and files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from ....exchange.trajectories import write_arrays
from ....ground.files import Replacements
from ...schema.analyses.campbell_table import CampbellTable
from ...schema.analyses.frequency_table import FrequencyTable
from ...schema.analyses.path_table import PathTable
from ...schema.entry_types import Table
from ...schema.scene_schema import OutputTable
from ...schema.validation import validated

if TYPE_CHECKING:
    from ....ground.notices import Notice
    from ....page.content import PageContent
    from ....page.frequency_page import FrequencyContent

IMAGES: tuple[Literal["svg", "png"], ...] = ("svg", "png")


class SceneResponse(ABC):
    """A response with a page, CSV, npz and plots of its own, NAME.KIND and an ending.

    Attributes:
        kind: the name of its command and of its table.
        name: name of the scene or record.
        output: which files are requested.
        files: written files.
    """

    kind: ClassVar[str]

    def __init__(self, name: str, output: OutputTable):
        self.name, self.output = name, output
        self.files: list[Path] = []

    @property
    @abstractmethod
    def content(self) -> PageContent | FrequencyContent:
        """The content of the page."""

    @property
    @abstractmethod
    def csv(self) -> dict[str, str]:
        """The texts of the CSV files, by what stands before their ending, such as "" or ".peaks"."""

    @property
    @abstractmethod
    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays by name, in SI, for the npz file."""

    @property
    @abstractmethod
    def notices(self) -> tuple[Notice, ...]:
        """Notices on the response, and doubts about it."""

    @property
    def is_trusted(self) -> bool:
        """False where a notice warns that values may be wrong."""
        return not any(notice.doubtful for notice in self.notices)

    def write(self, folder: Path, *, images: bool = False, files: Replacements | None = None) -> list[Path]:
        """Write NAME.KIND.html, .csv and .npz, as far as [output] requests them, and the plots as SVG and PNG.

        Args:
            folder: is created if it does not exist.
            images: whether the plots are written, too.
            files: take their places together with others; None for these alone.

        Returns:
            The paths.

        Raises:
            OSError: they cannot be written.
        """
        if files is None:
            with Replacements() as files:
                return self.write(folder, images=images, files=files)
        from ....page.html import write_page
        from ....page.plots.images import plot_image, plot_images

        output, stem, before = self.output, f"{self.name}.{self.kind}", len(files.paths)
        folder.mkdir(parents=True, exist_ok=True)
        content = self.content if output.page or images else None
        for part, text in self.csv.items() if output.csv else ():
            files.temporary(folder / f"{stem}{part}.csv").write_text(text, encoding="utf-8")
        if output.npz:
            write_arrays(files.temporary(folder / f"{stem}.npz"), self.arrays, ".npz")
        for name, plot in plot_images(content.plots).items() if content and images else ():
            for kind in IMAGES:
                files.temporary(folder / f"{stem}.{name}.{kind}").write_bytes(plot_image(plot, kind))
        if content and output.page:
            write_page(folder / f"{stem}.html", content, output.viewer, files)
        written = files.paths[before:]
        self.files += written
        return written


def with_options(own: Table | None, kind: Literal["frequency", "campbell", "path"], options: dict, file_name: str):
    """The table [frequency], [campbell] or [path] of a scene with other values."""
    base = own.model_dump(exclude_unset=True, by_alias=True) if own else {}
    if {"from", "to"} & options.keys():
        base.pop("frequencies", None)
    return getattr(validated({kind: {**base, **options}}, file_name, _Options), kind)


class _Options(Table):
    frequency: FrequencyTable | None = None
    campbell: CampbellTable | None = None
    path: PathTable | None = None
