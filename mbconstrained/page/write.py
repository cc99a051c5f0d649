"""Writing the page: beside its place first, then into it in one step."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from ..replacing import replacing
from .content import PageContent
from .html import page_html


def write_page(path, content: PageContent) -> Path:
    """Write the page; a file that was there before stays as it was unless the new one is complete.

    Returns:
        The path written.

    Raises:
        InputError: the content cannot be drawn, or the place cannot be written.
    """
    path = Path(path)
    text = page_html(content)
    try:
        with replacing(path) as beside:
            beside.write_bytes(text.encode("utf-8", errors="replace"))
    except OSError as error:
        raise InputError(f'the page "{path}" cannot be written: {error.strerror or error}; give another place') from None
    return path
