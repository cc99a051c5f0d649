"""The summary of a response in addition to a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from textwrap import wrap

from ....ground.display import WIDTH, TextTable
from ....ground.notices import Notice


def response_blocks(
    heads: Iterable[str],
    facts: Iterable[tuple[str, str]],
    tables: Iterable[TextTable | None],
    notices: Iterable[Notice],
    files: Sequence[Path],
) -> list[str | TextTable]:
    """The parts of the summary of a response in addition to a run, on lines of a terminal."""
    head = "\n".join(line for text in heads for line in wrap(text, WIDTH))
    about = "\n".join(line for label, text in facts for line in wrap(f"{label}: {text}", WIDTH, subsequent_indent="  "))
    reported = [line for notice in notices for line in wrap(f"  {notice}", WIDTH, subsequent_indent="    ")]
    lists = [("Notices", reported), ("Written", [f"  {path}" for path in files])]
    listed = ["\n".join([title, *lines]) for title, lines in lists if lines]
    return [head, about, *(table for table in tables if table is not None), *listed]


def notices_json(notices: Iterable[Notice]) -> list[dict]:
    """Notices as plain data."""
    return [{"kind": notice.kind, "text": notice.text, "doubtful": notice.doubtful} for notice in notices]
