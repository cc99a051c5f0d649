"""Tables of texts, as the terminal and the page set them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..page.content import Table


@dataclass(frozen=True)
class TextTable:
    """A table of texts.

    Attributes:
        title: its heading.
        columns: headings.
        rows: texts, one for each column.
        note: a sentence below, or an empty string.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def on_page(self, folded: bool = False) -> Table:
        """The same on a page."""
        from ..page.content import Table

        return Table(self.title, self.columns, self.rows, self.note, folded)
