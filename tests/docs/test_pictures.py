"""The pictures of the documentation are small, shown, and those that the commands in the pages draw today."""

from __future__ import annotations

import re
import shutil

import matplotlib
import numpy as np
import pytest

from mbconstrained.docs.pictures import DOCS, FOLDER, PAGES, drawn, pictures

#: Bytes of a picture, and of all.
LARGEST, ALL = 90_000, 1_300_000

#: Difference of two drawings of one curve, pt: a rounding of the last printed digit and what a processor adds to it.
NEAR = 0.05

SHOWN = {file: page for page in PAGES for _, file in pictures(page)}


def texts(svg: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


def curves(svg: str) -> list[np.ndarray]:
    """Numbers of all paths and places."""
    return [
        np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", data), dtype=float)
        for data in re.findall(r'(?:\bd|transform|[xy])="([^"]*)"', svg)
    ]


def version(svg: str) -> str:
    return "".join(re.findall(r"Matplotlib v([\w.]+)", svg))


def test_every_picture_is_shown_once_and_small():
    files = {path.name: path.stat().st_size for path in FOLDER.iterdir()}
    assert set(files) == set(SHOWN), "write them by: python -m mbconstrained.docs.pictures"
    assert max(files.values()) < LARGEST and sum(files.values()) < ALL
    assert len(SHOWN) == sum(len(list(pictures(page))) for page in PAGES), "two pages show one file, which each would write"


def test_every_tutorial_and_guide_has_a_picture():
    guides = [page for room in ("tutorials", "howto") for page in (DOCS / room).glob("*.md") if page.stem != "index"]
    assert [page.name for page in guides if page not in SHOWN.values()] == []


def check_pictures(page, made=None) -> None:
    """The pictures of a page are those that its commands draw, or have drawn into known folders."""
    if not shutil.which("chromium") and any(file.endswith(".png") for _, file in pictures(page)):
        pytest.skip("pictures of models need Chromium")
    for file, content in drawn(page, made):
        if file.endswith(".svg"):
            now, before = content.decode(), (FOLDER / file).read_text(encoding="utf-8")
            assert texts(now) == texts(before), f"{file}: python -m mbconstrained.docs.pictures"
            if version(before) == matplotlib.__version__:  # another version lays out the axes otherwise
                assert [a.shape for a in curves(now)] == [b.shape for b in curves(before)]
                assert max(np.abs(a - b).max(initial=0.0) for a, b in zip(curves(now), curves(before))) < NEAR, file


@pytest.mark.long
def test_pictures_of_the_first_page_are_current():
    """Those of the others are compared where their commands run, in test_pages.py."""
    check_pictures(PAGES[0])
