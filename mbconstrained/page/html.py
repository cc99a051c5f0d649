"""The page of a run: heading, notices, still pictures, the moving picture, plots, tables and facts as one static HTML file."""

from __future__ import annotations

import numpy as np

from .content import Animation, PageContent
from .document import Delivery, document, page_scripts
from .figure import figure_data, unseen_errors
from .keyframes import KeyFrames, key_frames
from .marks_data import marks_data, moment_frames
from .marks_reach import with_arrows
from .readings import Coordinates
from .sections import footer, formula_section, header, notice_section, plot_figures, still_figure, table_section
from .stage import decimals, stage_section


def page_html(content: PageContent, viewer: Delivery = "inside") -> str:
    """The whole page as text.

    An animation brings the viewer, its controls and one script, plots bring a script; without both there is no script in
    the page at all.

    Args:
        content: what is shown.
        viewer: where the script of the 3-D viewer is: "inside" the page; "beside" it, in a file that many pages share
            (``mbconstrained.page.viewer``); or "compressed" inside it.

    Raises:
        InputError: the drawing names a coordinate that the animation does not have.
        MbconstrainedError: there is an animation, but meshcat is not installed.

    >>> "<script" in page_html(PageContent("Nothing moves"))
    False
    """
    frames = None if content.animation is None else _frames(content.animation)
    moves, plots = frames is not None, any(plot.curves and len(plot.times) > 1 for plot in content.plots)
    figure = _figure(content.animation, frames) if moves else None
    unseen = unseen_errors(content.animation.drawing, frames.names, figure) if moves else None
    parts = [
        header(content, with_theme=moves or plots),
        "<main>",
        notice_section(content.notices),
        *(still_figure(figure) for figure in content.figures),
        stage_section(content.animation, frames) if moves else "",
        plot_figures(content.plots, Coordinates(content.animation, frames, unseen[0]) if moves else None),
        formula_section(content.formulas),
        *(table_section(table) for table in content.tables),
        "</main>",
        footer(content.facts, with_viewer=moves),
    ]
    data = _data(figure, frames, unseen) if moves else None
    scripts = page_scripts("run.js" if moves else "", data, plots=plots, delivery=viewer)
    return document(content.title, "\n".join(filter(None, parts)), scripts)


def _frames(animation: Animation) -> KeyFrames:
    return key_frames(animation.drawing, *animation.with_forces)


def _data(figure: dict, frames: KeyFrames, unseen: tuple[np.ndarray, tuple[float, float]]) -> dict:
    return {
        "figure": figure,
        "frames": frames.as_data(*unseen),
        "decimals": decimals(frames),
        "unit": "s",
    }


def _figure(animation: Animation, frames: KeyFrames) -> dict:
    drawing, marks = animation.drawing, animation.marks
    if not marks:
        return figure_data(drawing, frames)
    before = (moment_frames(drawing, frames, moment) for moment in marks.moments)
    figure = figure_data(drawing, frames, *before)
    drawn = {"marks": marks_data(marks, drawing, frames, figure["unit"])}
    return {**figure, **drawn, "bounds": with_arrows(figure["bounds"], marks, drawing, frames, figure["unit"])}
