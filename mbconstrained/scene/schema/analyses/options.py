"""Tables of a scene with other values, for the commands campbell and path."""

from __future__ import annotations

from typing import Literal

from ..entry_types import Table
from ..validation import validated
from .campbell_table import CampbellTable
from .path_table import PathTable


def with_options(own: Table | None, kind: Literal["campbell", "path"], options: dict, file_name: str):
    """The table [campbell] or [path] of a scene with other values."""
    base = own.model_dump(exclude_unset=True, by_alias=True) if own else {}
    return getattr(validated({kind: {**base, **options}}, file_name, _Options), kind)


class _Options(Table):
    campbell: CampbellTable | None = None
    path: PathTable | None = None
