"""Writing the page: beside its place first, then into it in one step."""

from __future__ import annotations

from pathlib import Path

from ..errors import InputError
from ..replacing import Replacements
from .content import PageContent
from .document import Delivery
from .html import page_html
from .viewer import write_viewer


def write_page(path, content: PageContent, viewer: Delivery = "inside") -> Path:
    """Write the page; a file that was there before stays as it was unless the new one is complete.

    Args:
        path: of the page.
        content: what it shows.
        viewer: where the script of the 3-D viewer is, as in ``page_html``; "beside" writes it too.

    Returns:
        The path written.

    Raises:
        InputError: the content cannot be drawn, or the place cannot be written.
    """
    path = Path(path)
    text = page_html(content, viewer)
    try:
        with Replacements() as files:
            files.beside(path).write_bytes(text.encode("utf-8", errors="replace"))
            if viewer == "beside" and content.animation is not None:
                write_viewer(path.parent, files)
    except OSError as error:
        raise InputError(f'the page "{path}" cannot be written: {error.strerror or error}; give another place') from None
    return path
