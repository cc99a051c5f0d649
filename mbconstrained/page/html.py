"""The page of a run: heading, notices, still pictures, the moving picture, plots, tables and facts as one static HTML file."""

from __future__ import annotations

from .content import Animation, PageContent
from .document import document, motion_data, motion_scripts
from .figure import figure_data
from .keyframes import KeyFrames, key_frames
from .sections import footer, formula_section, header, notice_section, plot_figures, still_figure, table_section
from .stage import decimals, stage_section


def page_html(content: PageContent) -> str:
    """The whole page as text.

    An animation brings the viewer, its controls and one script; without one there is no script in the page at all.

    Raises:
        InputError: the drawing names a coordinate that the animation does not have.
        MbconstrainedError: there is an animation, but meshcat is not installed.

    >>> "<script" in page_html(PageContent("Nothing moves"))
    False
    """
    frames = None if content.animation is None else _frames(content.animation)
    parts = [
        header(content),
        "<main>",
        notice_section(content.notices),
        *(still_figure(figure) for figure in content.figures),
        "" if frames is None else stage_section(content.animation, frames),
        plot_figures(content.plots),
        formula_section(content.formulas),
        *(table_section(table) for table in content.tables),
        "</main>",
        footer(content.facts, with_viewer=frames is not None),
        "" if frames is None else _data(content.animation, frames),
    ]
    scripts = () if frames is None else motion_scripts("run.js")
    return document(content.title, "\n".join(filter(None, parts)), scripts)


def _frames(animation: Animation) -> KeyFrames:
    return key_frames(animation.drawing, animation.names, animation.times, animation.values, animation.rates)


def _data(animation: Animation, frames: KeyFrames) -> str:
    return motion_data(
        {
            "figure": figure_data(animation.drawing, frames),
            "frames": frames.as_data(),
            "decimals": decimals(frames),
            "unit": "s",
        }
    )
