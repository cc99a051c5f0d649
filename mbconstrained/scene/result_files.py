"""The files of a result: page, data, plots and picture, each written beside its place and put there when all are complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import MbconstrainedError
from ..replacing import Replacements

if TYPE_CHECKING:
    from ..page.content import Animation
    from .scene import Scene


class ResultFiles:
    """What a result writes.

    Attributes:
        scene: the scene that was run.
        folder: into which its files go, or None.
        files: what was written, in this order.
        still_problem: why no still picture was taken, or an empty string.
    """

    scene: Scene
    animation: Animation

    def __init__(self, folder: Path | None):
        self.folder = folder
        self.files: list[Path] = []
        self.still_problem = ""
        self._together: Replacements | None = None

    def write_page(self, path: str | Path | None = None) -> Path:
        """Write the page; without a path into the folder of the run, named after the scene; beside it the viewer's script,
        where [output] viewer asks for that."""
        from ..page import page_html
        from ..page.viewer import write_viewer
        from .report import page_content

        content, viewer = page_content(self), self.scene.table.output.viewer
        with self.writing_together() as files:
            page = self._written("html", path, lambda path: path.write_bytes(page_html(content, viewer).encode("utf-8")))
            if viewer == "beside" and content.animation is not None:
                self.files.append(write_viewer(page.parent, files))
        return page

    def write_csv(self, path: str | Path | None = None) -> Path:
        """Write the curves as CSV, one line for each time."""
        from .output import write_csv

        return self._written("csv", path, lambda path: write_csv(path, self))

    def write_npz(self, path: str | Path | None = None) -> Path:
        """Write curves, jumps, impulses and the Jordan pairs as NumPy arrays."""
        from .output import write_npz

        return self._written("npz", path, lambda path: write_npz(path, self))

    def write_plots(self, folder: str | Path | None = None) -> list[Path]:
        """Write each plot of the page as SVG and PNG, named after scene and plot; without a folder into that of the run."""
        from ..page.plot_images import plot_images
        from .plots import plots_of

        folder = Path(folder) if folder is not None else self.folder or Path()
        with self.writing_together():
            return [
                self._written(kind, folder / f"{self.scene.name}.{image.name}.{kind}", _of_bytes(image.rendered(kind)))
                for image in plot_images(plots_of(self))
                for kind in ("svg", "png")
            ]

    def write_still(self, path: str | Path | None = None, time: float | None = None) -> Path:
        """Write a picture of the model at a time as PNG, taken by an installed Chromium or Chrome.

        Args:
            path: of the picture; None for the folder of the run, named after the scene.
            time: in s; None for the one in [output] still, or 0.

        Raises:
            InputError: a time that is not within the run.
            MbconstrainedError: no browser is installed, or it takes no picture.
        """
        from ..page.photograph import photograph

        time = time if time is not None else self.scene.table.output.still or 0.0
        return self._written("still.png", path, _of_bytes(photograph(self.animation, time)))

    def try_still(self) -> None:
        """Write the still picture; a notice says why where the browser takes none, so that all else is written."""
        try:
            self.write_still()
        except MbconstrainedError as problem:
            self.still_problem = str(problem)

    def _written(self, ending: str, path, write) -> Path:
        path = Path(path) if path is not None else (self.folder or Path()) / f"{self.scene.name}.{ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        with self.writing_together() as files:
            write(files.beside(path))
        self.files.append(path)
        return path

    @contextmanager
    def writing_together(self) -> Iterator[Replacements]:
        """What is written inside takes its place at the end of the outermost block, all of it or nothing."""
        if self._together is not None:
            yield self._together
            return
        try:
            with Replacements() as self._together:
                yield self._together
        finally:
            self._together = None


def _of_bytes(content: bytes):
    return lambda path: path.write_bytes(content)
