"""Texts beside points, written where they cover nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Half the size of a marker, and the distance of a text from the middle of its point, in points of 1/72 inch.
MARKER, DISTANCE = 5.0, 7.0

#: Room kept around a text, in the same points: letters are not exactly as wide in every file.
AIR = 1.5

#: Lines drawn below this one are part of the background.
CURVES = 2

#: Where a text may stand, seen from its point: right, left, above, below, and in between.
_SIDES = (
    *((1, 0, "left", "center"), (-1, 0, "right", "center"), (0, 1, "center", "bottom"), (0, -1, "center", "top")),
    *((0.7, 0.7, "left", "bottom"), (-0.7, -0.7, "right", "top"), (-0.7, 0.7, "right", "bottom"), (0.7, -0.7, "left", "top")),
)

_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}


@dataclass(frozen=True)
class Label:
    """A text beside a point; without a text the point only keeps its place free."""

    x: float
    y: float
    text: str
    color: str
    is_bold: bool = False


def place_labels(figure: Figure, panels: list[tuple[Axes, list[Label]]]) -> None:
    """Write every text that has room beside its point; the first come first, the others are left out."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # everything stays where it stands now
    for axes, labels in panels:
        taken = [_around(axes, label) for label in labels]
        taken += [text.get_window_extent() for text in axes.texts]
        for label in labels:
            if label.text:
                _place(axes, label, taken)


def _place(axes: Axes, label: Label, taken: list) -> None:
    for side in _SIDES:
        text = _written(axes, label, *side)
        box = text.get_window_extent().padded(AIR * axes.figure.dpi / 72)
        if _within(box, axes.bbox) and not box.count_overlaps(taken) and not _crossed(axes, box):
            taken.append(box)
            return
        text.remove()


def _written(axes: Axes, label: Label, right: float, up: float, across: str, upright: str):
    text = axes.annotate(
        label.text,
        (label.x, label.y),
        (DISTANCE * right, DISTANCE * up),
        textcoords="offset points",
        ha=across,
        va=upright,
        color=label.color,
        fontsize=7.5 if label.is_bold else 7,
        fontweight="bold" if label.is_bold else "normal",
        zorder=6,
        bbox=_BACKGROUND if label.is_bold else None,
    )
    text.set_in_layout(False)
    return text


def _around(axes: Axes, label: Label):
    from matplotlib.transforms import Bbox

    x, y = axes.transData.transform((label.x, label.y))
    half = MARKER * axes.figure.dpi / 72
    return Bbox.from_extents(x - half, y - half, x + half, y + half)


def _within(box, room) -> bool:
    return room.x0 <= box.x0 and box.x1 <= room.x1 and room.y0 <= box.y0 and box.y1 <= room.y1


def _crossed(axes: Axes, box) -> bool:
    """Whether a curve runs through the box; lines behind the curves do not count."""
    curves = [line for line in axes.lines if line.get_zorder() >= CURVES]
    return any(line.get_transform().transform_path(line.get_path()).intersects_bbox(box, filled=False) for line in curves)
