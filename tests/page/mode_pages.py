"""Pages of mode shapes that several tests look at."""

from dataclasses import replace

import numpy as np

from mbconstrained.ground.display import TextTable
from mbconstrained.ground.notices import Notice
from mbconstrained.page.animation import ModePicture, Shapes, cycle
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink, Path
from tests.page.contents import HOSTILE
from tests.page.robots import four_bar

NAMES = ("x", "y")
SHAPES = {"together": np.array([1.0, 1.0]), "apart": np.array([1.0, -1.0])}


def two_bodies() -> Drawing:
    """Two boxes with a spring between them."""
    bodies = (DrawnBody("a", moves={"x": (1, 0, 0)}), DrawnBody("b", rest=(3, 0, 0), moves={"y": (1, 0, 0)}))
    return Drawing(bodies, (DrawnLink("k", "spring", "a", "b"),), scale=0.5)


def two_modes() -> PageContent:
    """Both shapes of two equal masses, and a drift that does not move."""
    modes = [
        ModePicture(
            name,
            (("frequency (Hz)", f"{i + 1}"), ("meaning", "oscillation")),
            (("a", 0.5, None), ("b", 0.5, None), ("k", None, float(i))),
            cycle(shape),
            period=1 / (i + 1),
            scale=1.2,
        )
        for i, (name, shape) in enumerate(SHAPES.items())
    ]
    modes.append(ModePicture("drift", (("meaning", "drift"),), note="It does not move: a row drifts."))
    shapes = Shapes(two_bodies(), NAMES, tuple(modes))
    return PageContent("Two", "made up", shapes, notices=(Notice("rank", "a notice"),), facts=(("Coordinates", "2"),))


def robot_modes() -> PageContent:
    """A mode of a four-bar by paths, and one that rests."""
    swing = four_bar(np.linspace(0, 2 * np.pi / 1.3, 33))
    paths = {body.name: body.path for body in swing.drawing.bodies if body.path is not None}
    rest = four_bar([0.0]).drawing
    modes = (ModePicture("swing", paths=paths, period=0.01, scale=0.05), ModePicture("rest", note="nothing moves"))
    return PageContent("Four-bar", "", Shapes(rest, (), modes))


def many_modes(count: int) -> PageContent:
    """As many as asked for."""
    phase = np.exp(1j * np.arange(count))
    modes = tuple(ModePicture(f"mode {i + 1}", (("Hz", f"{i}"),), values=cycle([1, p]), period=1.0) for i, p in enumerate(phase))
    return PageContent("Many", "", Shapes(two_bodies(), NAMES, modes))


def variants(count: int) -> PageContent:
    """Listed as variants, with a slider."""
    content = many_modes(count)
    modes = tuple(replace(mode, name=f"sample {10 * (i + 1)}") for i, mode in enumerate(content.animation.modes))
    return replace(content, animation=replace(content.animation, modes=modes, word="variant"))


def hostile_modes() -> PageContent:
    """Texts that try to be more than texts, or are very long, in every place that takes one."""
    long = "W" * 10_000
    drawing = Drawing((DrawnBody(HOSTILE, moves={HOSTILE: (1, 0, 0)}), DrawnBody(long, rest=(2, 0, 0))), note=HOSTILE)
    modes = tuple(
        ModePicture(text, ((text, text),), ((text, 0.5, -0.5),), cycle([1.0]), period=1.0, note=text) for text in (HOSTILE, long)
    )
    tables = tuple(TextTable(text, (text,), ((text,),), text, folded) for text, folded in ((HOSTILE, False), (long, True)))
    notices, facts = (Notice("rank", HOSTILE),), ((HOSTILE, long),)
    return PageContent(HOSTILE + long, HOSTILE, Shapes(drawing, (HOSTILE,), modes), tables=tables, notices=notices, facts=facts)


def resting_path() -> Path:
    """One pose."""
    return Path(np.zeros((3, 1)), [[0], [0], [0], [1]])
