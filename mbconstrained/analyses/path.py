"""A robot along a path of one of its points: frequencies at each place, places out of reach."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..ground.checks import counted
from ..ground.display import TextTable, number_text
from ..ground.errors import InputError
from ..ground.notices import distinct
from ..page.content import Plot, curve_with_gaps
from ..scene.schema.analysis_tables import PathTable
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..robot.cartesian_path import PathModes
    from ..scene.run.scene import Scene

#: Frequencies that differ by more than this factor have a logarithmic axis.
WIDE = 30.0


class RobotPath(Analysis):
    """Natural frequencies of a robot along the table [path], its joints kept where the path needs them, each mode followed by its shape.

    Places out of reach are listed. Writes NAME.path.html, .png and .json.
    """

    name = "path"
    settings = PathTable
    options: ClassVar = {"body": None}
    formats = ("page", "images", "json")

    @classmethod
    def solve(cls, scene: Scene, settings: PathTable | None) -> Answer:
        robot_scene = scene.equations.robot_scene
        if robot_scene is None:
            raise InputError('a path needs a model of kind = "robot"')
        if settings is None:
            text = 'body = "tool", corners = [[0.1, 0, 1], [0.3, 0, 1]]'
            raise InputError(f"there is no path; add the table [path] with a body and the corners of its way, e.g. {text}")
        posture, robot = robot_scene.posture.configuration, robot_scene.robot
        where = settings.body, settings.places, settings.point, settings.orientation
        along = robot.modes_along(*where, posture, forces=robot_scene.forces)
        missed = tuple(
            (str(i + 1), *map(number_text, along.places[i].tolist()), f"{along.distances[i]:.3g} m from it")
            for i in along.unreachable
        )
        table = TextTable("Places out of reach", ("place", "x (m)", "y (m)", "z (m)", "the point comes to"), missed)
        doubts = (notice for system in along.systems if system is not None for notice in system.notices if notice.doubtful)
        data = {
            "title": scene.heading,
            "body": settings.body,
            "point": settings.point,
            "places": along.places,
            "lengths": along.lengths,
            "frequencies_hz": along.frequencies_hz,
            "assurance": along.assurance,
            "joints": [posture and posture.joints for posture in along.postures],
            "unreachable": [{"place": i + 1, "distance": float(along.distances[i])} for i in along.unreachable],
        }
        return cls.of(
            scene,
            title=f"{scene.heading}: along the path of {settings.body}",
            facts=(("path", _summary(along)),),
            tables=(along.table, *([table] if missed else [])),
            notices=distinct(scene.notices, along.notices, doubts),
            data=data,
            plots=lambda: (_plot(along),) if along.frequencies_hz.shape[1] else (),
            most_rows=None,
            keys=("notices",),
        )


def _summary(along: PathModes) -> str:
    """The length of the path, places that are not reached, and the range of the lowest frequency."""
    missed = f", {len(along.unreachable)} of them out of reach" if along.unreachable else ""
    text = f"{counted(len(along.places), 'place')} on {number_text(float(along.lengths[-1]))} m{missed}"
    if not along.frequencies_hz.shape[1]:
        return f"{text}; nothing oscillates"
    lowest = np.min(along.frequencies_hz, axis=1, where=np.isfinite(along.frequencies_hz), initial=np.inf)
    lowest[np.isinf(lowest)] = np.nan
    least, most = int(np.nanargmin(lowest)), int(np.nanargmax(lowest))
    ends = " and ".join(f"{lowest[i]:.4g} Hz (at {number_text(float(along.lengths[i]))} m)" for i in (least, most))
    return f"{text}; the lowest frequency is between {ends}"


def _plot(along: PathModes) -> Plot:
    """The frequencies over the length of the path, places out of reach as bands."""
    lengths, f = along.lengths, along.frequencies_hz
    edges = np.concatenate([lengths[:1], (lengths[1:] + lengths[:-1]) / 2, lengths[-1:]])
    is_wide = np.nanmax(f) > WIDE * max(np.nanmin(f), 0.0) > 0
    return Plot(
        "Frequencies along the path",
        "Hz",
        lengths,
        tuple(curve_with_gaps(f"mode {number}", column) for number, column in enumerate(f.T, 1)),
        across_unit="m",
        quantity="natural frequency",
        variable="length of the path",
        scales=("linear", "log" if is_wide else "linear"),
        note="A mode keeps its colour, followed by its shape." + " Red: out of reach." * bool(along.unreachable),
        includes=() if is_wide else (0.0,),
        shown=f.shape[1],
        bands=tuple((float(edges[i]), float(edges[i + 1])) for i in along.unreachable),
        is_large=True,
    )
