"""Pages that several tests look at."""

from dataclasses import replace

import numpy as np

from mbconstrained.ground.display import TextTable
from mbconstrained.ground.notices import Notice
from mbconstrained.page.animation import Animation, KeyFrames, body_poses
from mbconstrained.page.content import Curve, PageContent, Plot
from mbconstrained.page.drawing import Drawing, DrawnBody, DrawnLink

TIMES = np.linspace(0, 50, 401)
HOSTILE = """</script><script>alert(1)</script><img src=x onerror=alert(2)>&amp;"'\u2028]]>-->"""


def two_masses(times=TIMES) -> np.ndarray:
    """x1, q1, q2 of Moysis et al., section 5.1, from its closed form (m = 10, k = 2)."""
    fast, slow = (5 + 5**0.5) / 10, (5 - 5**0.5) / 10
    a, b = 9 / 5 - 23 * 5**0.5 / 25, 9 / 5 + 23 * 5**0.5 / 25
    square = (3 + 5**0.5) / 2
    x1 = a * square * np.cos(fast * times) + b / square * np.cos(slow * times)
    q2 = -(2 + 5**0.5) * a * np.cos(fast * times) + (5**0.5 - 2) * b * np.cos(slow * times)
    return np.array([x1, x1 + 0.4, q2])


def positions(drawing: Drawing, body: DrawnBody, names, values) -> np.ndarray:
    """The positions of a body for values (r, T) of the coordinates, shape (3, T)."""
    values = np.asarray(values, dtype=float)
    frames = KeyFrames(tuple(names), np.arange(values.shape[1]), values, 0 * values, paths=(None,) * len(drawing.bodies))
    return body_poses(drawing, frames)[body.name].positions


def two_masses_drawing() -> Drawing:
    """A wall, two masses, springs and dampers between them; the second mass moves with two coordinates."""
    across = (1.0, 0.0, 0.0)
    bodies = (
        DrawnBody("wall", "ground"),
        DrawnBody("first", rest=(2, 0, 0), moves={"x1": across}),
        DrawnBody("second", rest=(4.4, 0, 0), moves={"q1": across, "q2": across}),
    )
    links = [
        DrawnLink(f"{kind} of {end}", kind, start, end, offset=(0, 0, z))
        for start, end in (("wall", "first"), ("first", "second"))
        for kind, z in (("spring", 0.2), ("damper", -0.2))
    ]
    return Drawing(bodies, tuple(links), scale=0.3)


def two_masses_content() -> PageContent:
    """Everything a page can have."""
    names, values = ("x1", "q1", "q2"), two_masses()
    return PageContent(
        title="Two masses",
        source="Moysis et al., section 5.1",
        animation=Animation(two_masses_drawing(), names, TIMES, values),
        plots=(Plot("displacement", "m", TIMES, tuple(Curve(name, row) for name, row in zip(names, values))),),
        tables=(TextTable("Finite zeros", ("kind", "rad/s"), (("oscillation", "0.7236"), ("drift", "0")), "note below"),),
        notices=(Notice("drift", "a row drifts"), Notice("rank", "a doubtful decision", doubtful=True)),
        facts=(("Coordinates", "3"),),
    )


def phase_plane(title, name, times, displacement, velocity, units=("m", "m/s")) -> Plot:
    """The velocity of a coordinate over its displacement."""
    across, curves = Curve("displacement", displacement), (Curve(name, velocity),)
    return Plot(title, units[1], times, curves, across=across, across_unit=units[0], quantity="velocity")


def plotted_content() -> PageContent:
    """The same with a phase plane of x1 and a plot of ten curves, and a table that is wide."""
    content, x1 = two_masses_content(), two_masses()[0]
    plane = phase_plane("phase plane of x1", "x1", TIMES, x1, np.gradient(x1, TIMES))
    many = Plot("many", "N", TIMES, tuple(Curve(f"f{i}", np.sin(0.1 * (i + 1) * TIMES)) for i in range(10)))
    row = (*"1234567", "A sentence that says what all of these numbers mean.")
    wide = TextTable("Wide", tuple(f"column {i}" for i in range(8)), (row,) * 3)
    tables = (*content.tables, wide, replace(wide, title="Folded", folded=True))
    return replace(content, plots=(*content.plots, plane, many), tables=tables)


def hostile_content() -> PageContent:
    """Texts that try to be more than texts, or are very long, in every place that takes one."""
    long = "W" * 10_000
    drawing = Drawing((DrawnBody(HOSTILE, moves={HOSTILE: (1, 0, 0)}), DrawnBody(long, rest=(2, 0, 0))), note=HOSTILE)
    values = np.array([[0.0, 1.0]])
    plots = tuple(Plot(text, text, [0, 1], (Curve(text, [0, 1]),)) for text in (HOSTILE, long))
    tables = tuple(TextTable(text, (text,), ((text,),), text) for text in (HOSTILE, long))
    notices = tuple(Notice("rank", text) for text in (HOSTILE, long))
    animation = Animation(drawing, (HOSTILE,), [0, 1], values)
    return PageContent(HOSTILE + long, HOSTILE + long, animation, plots, tables, notices, ((HOSTILE, HOSTILE), (long, long)))


def many(count=30, length=2001, fastest=40.0):
    """Bodies that swing faster and faster, the fastest 20 key frames a period or more, and their motion with rates."""
    times = np.linspace(0.0, 2 * np.pi * (length - 1) / (20 * fastest), length)
    frequencies = np.linspace(1.0, fastest, count)[:, None]
    names = tuple(f"x{i}" for i in range(count))
    bodies = tuple(DrawnBody(name, rest=(2.0 * i, 0, 0), moves={name: (1, 0, 0)}) for i, name in enumerate(names))
    values, rates = 5 + np.sin(frequencies * times), frequencies * np.cos(frequencies * times)
    return Drawing(bodies), names, frequencies, times, values, rates


def hermite(frames, time: float) -> np.ndarray:
    """Cubic interpolation with both values and rates, as the page's script does it."""
    k = int(np.clip(np.searchsorted(frames.times, time, side="right") - 1, 0, len(frames.times) - 2))
    (a, b), (p, q), (v, w) = frames.times[k : k + 2], frames.values[:, k : k + 2].T, frames.rates[:, k : k + 2].T
    s, h = (time - a) / (b - a), b - a
    return (1 - s) ** 2 * (1 + 2 * s) * p + s**2 * (3 - 2 * s) * q + h * s * (1 - s) * ((1 - s) * v - s * w)
