"""The report of a robot along a path of one of its points: frequencies at each position, positions out of reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..analyses.figures import Picture, power_of_ten
from ..analyses.timing import machine
from ..ground.checks import counted
from ..ground.display import TextTable, finite_or_none, number_text
from ..ground.errors import InputError
from ..ground.notices import Notice, distinct
from ..page.animation.figure import PALETTE
from ..page.plots.images import RED
from ..scene.run.report.summary import notices_json
from ..scene.schema.analyses.options import with_options
from .study_report import StudyReport

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: Frequencies that differ by more than this factor have a logarithmic axis.
WIDE = 30.0


class PathReport(StudyReport):
    """The modes of the robot of a scene along its [path].

    Attributes:
        scene: of the robot.
        path: the table.
        along: the modes.
    """

    def __init__(self, scene: Scene, points: int = 0):
        robot_scene = scene.equations.robot_scene
        if robot_scene is None:
            raise InputError('a path needs a model of kind = "robot"')
        if scene.table.path is None:
            text = 'body = "tool", corners = [[0.1, 0, 1], [0.3, 0, 1]]'
            raise InputError(f"there is no path; add the table [path] with a body and the corners of its way, e.g. {text}")
        self.path = with_options(scene.table.path, "path", {"points": points} if points else {}, scene.file_name)
        self.scene, self.machine = scene, machine()
        self.along = robot_scene.robot.modes_along(
            self.path.body,
            self.path.places,
            self.path.point,
            self.path.orientation,
            robot_scene.posture.configuration,
            forces=robot_scene.forces,
        )

    @property
    def heading(self) -> str:
        """Title of the scene and the body."""
        return f"{self.scene.heading}: along the path of {self.path.body}"

    @property
    def sentences(self) -> tuple[str, ...]:
        """The length of the path, positions that are not reached, and the range of the lowest frequency."""
        along, frequencies = self.along, self.along.frequencies_hz
        missed = f", {len(along.unreachable)} of them out of reach" if along.unreachable else ""
        text = f"{counted(len(along.places), 'place')} on {number_text(float(along.lengths[-1]))} m{missed}"
        if not frequencies.shape[1]:
            return (f"{text}; nothing oscillates.",)
        lowest = np.min(frequencies, axis=1, where=np.isfinite(frequencies), initial=np.inf)
        lowest[np.isinf(lowest)] = np.nan
        least, most = int(np.nanargmin(lowest)), int(np.nanargmax(lowest))
        ends = " and ".join(f"{lowest[i]:.4g} Hz (at {number_text(float(along.lengths[i]))} m)" for i in (least, most))
        return (f"{text}; the lowest frequency is between {ends}.",)

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """Frequencies by position, and the positions out of reach."""
        along = self.along
        rows = tuple(
            (str(i + 1), *map(number_text, along.places[i].tolist()), f"{along.distances[i]:.3g} m from it")
            for i in along.unreachable
        )
        missed = TextTable("Places out of reach", ("place", "x (m)", "y (m)", "z (m)", "the point comes to"), rows)
        return (along.table, *([missed] if rows else []))

    def pictures(self) -> list[Picture]:
        """The frequencies over the length of the path."""
        if not self.along.frequencies_hz.shape[1]:
            return []
        note = "A mode keeps its colour, followed by its shape." + " Red: out of reach." * bool(self.along.unreachable)
        return [Picture("Frequencies along the path", "Natural frequencies over the length of the path", 4.2, self._draw, note)]

    def _draw(self, figure) -> None:
        axes, along = figure.add_subplot(), self.along
        for number, column in enumerate(along.frequencies_hz.T):
            dashes = "-" if number < len(PALETTE) else "--"
            color = PALETTE[number % len(PALETTE)]
            axes.plot(along.lengths, column, dashes, marker=".", markersize=3.5, color=color, label=f"mode {number + 1}")
        between = (along.lengths[1:] + along.lengths[:-1]) / 2
        edges = np.concatenate([along.lengths[:1], between, along.lengths[-1:]])
        for i in along.unreachable:
            axes.axvspan(edges[i], edges[i + 1], color=RED, alpha=0.12, linewidth=0)
        if np.nanmax(along.frequencies_hz) > WIDE * max(np.nanmin(along.frequencies_hz), 0.0) > 0:
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter(lambda value, place: power_of_ten(value))
        else:
            axes.set_ylim(bottom=0.0)
        axes.set(xlabel="length of the path in m", ylabel="natural frequency in Hz", xlim=along.lengths[[0, -1]])
        figure.legend(loc="outside lower left", ncols=7)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the scene, of the path, and doubts about the models at its positions."""
        systems = (system for system in self.along.systems if system is not None)
        doubts = (notice for system in systems for notice in system.notices if notice.doubtful)
        return distinct(self.scene.notices, self.along.notices, doubts)

    @property
    def is_trusted(self) -> bool:
        """Whether no model at a position is doubtful."""
        return not any(notice.doubtful for notice in self.notices)

    @property
    def blocks(self) -> list[str | TextTable]:
        """Blocks for the terminal, with the notices of the path."""
        *first, last = super().blocks
        return [*first, *(["\n".join(["Notices", *(f"  {notice}" for notice in self.notices)])] if self.notices else []), last]

    def as_json(self) -> dict:
        along = self.along
        return {
            "title": self.scene.heading,
            "body": self.path.body,
            "point": self.path.point,
            "places": along.places.tolist(),
            "lengths": along.lengths.tolist(),
            "frequencies_hz": _with_null(along.frequencies_hz),
            "assurance": _with_null(along.assurance),
            "joints": [posture and {name: _listed(value) for name, value in posture.joints.items()} for posture in along.postures],
            "unreachable": [{"place": i + 1, "distance": float(along.distances[i])} for i in along.unreachable],
            "notices": notices_json(self.notices),
        }


def _listed(value) -> float | list[float]:
    return list(value) if isinstance(value, tuple) else value


def _with_null(values: np.ndarray) -> list[list[float | None]]:
    return [list(map(finite_or_none, row)) for row in values.tolist()]
