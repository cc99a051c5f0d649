"""The work-precision diagram: error against run time, one curve for each method."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..figures import Picture, nothing_to_show, shown
from ..timing import duration
from .diagram import columns, draw_diagram
from .series import HIGHEST, LOWEST, MeasuredPoint, Series, drawable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Height of the panels, and of one line of the legend, in inches.
PANELS_HIGH, LINE_HIGH = 4.1, 0.2


def work_precision(title: str, series: tuple[Series, ...], floor: float = 0.0, failed: tuple[tuple[str, str], ...] = ()) -> Picture:
    """The diagram of some methods: relative error upwards, run time to the right, both logarithmic.

    The left panel has the time of one run, the right one that of each further evaluation of what one run has set up.

    Args:
        title: of the picture.
        series: the methods; points without a time, and methods without points, are not drawn.
        floor: errors below it cannot be told; a line is drawn there if it is above 0.
        failed: names and reasons of what gave nothing; the note below the picture names them.

    Example:
        >>> point = MeasuredPoint("rtol 1e-06", 2e-7, 3e-3, 2e-3, 2.9e-3, 3.2e-3)
        >>> work_precision("Two masses", (Series("solve_ivp DOP853", (point,)),)).description
        'Relative error against run time. solve_ivp DOP853: 2e-07 in 3 ms (rtol 1e-06).'
    """
    kept = drawable(series)
    if not kept:
        return nothing_to_show(title, "Relative error against run time", _note((), failed))

    def draw(figure: Figure) -> None:
        draw_diagram(figure, kept, floor)

    height = PANELS_HIGH + LINE_HIGH * math.ceil(len(kept) / columns(kept))
    return Picture(title, " ".join(["Relative error against run time.", *map(_sentence, kept)]), height, draw, _note(kept, failed))


def _sentence(one: Series) -> str:
    """A method in words: its coarsest and its finest setting."""
    ends = dict.fromkeys((one.points[0], one.points[-1]))
    return f"{shown(one.name)}: {', '.join(map(_result, ends))}."


def _result(point: MeasuredPoint) -> str:
    error = f"{point.error:.1g}" if math.isfinite(point.error) else "no finite answer"
    label = f" ({shown(point.label)})" if point.label else ""
    return f"{error} in {duration(point.one_run)}{label}"


def _note(series: tuple[Series, ...], failed: tuple[tuple[str, str], ...]) -> str:
    """What the marks mean that not every picture has, and who is missing."""
    points = [point for one in series for point in one.points]
    sentences = (
        (
            "Thin bars: the middle half of the repeated runs.",
            any(point.quartiles[0] < point.quartiles[1] for point in points),
        ),
        (f"Open markers at the bottom: the error is 0 or below {LOWEST:g}.", any(point.is_below for point in points)),
        (
            f"Open triangles at the top: off by more than {HIGHEST:g} times the motion, or not finite.",
            any(point.is_beyond for point in points),
        ),
        (f"Not in the picture: {'; '.join(shown(name) for name, _ in failed)}.", bool(failed)),
    )
    return " ".join(text for text, applies in sentences if applies)
