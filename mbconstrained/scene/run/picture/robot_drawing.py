"""The drawing of a robot: its links, read once, along the paths of the motion, magnified to be visible."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....ground.checks import counted
from ....ground.tolerances import NOT_DRAWN
from ....page.drawing.bodies import Drawing, SliderPosing, Solid
from ....page.drawing.layout import two_digits
from ....page.drawing.paths import Path
from ....page.drawing.robot_layout import MOST_TRIANGLES, link_points, robot_drawing, robot_size, solids_of
from ...file.messages import at
from .scene_drawing import view_of

if TYPE_CHECKING:
    from ....page.animation.animation import DrawnEvent
    from ....robot.description.visuals import Visual
    from ....robot.visualization import Poses
    from ...build.robot_model import RobotScene
    from ...schema.drawing_tables import DrawingTable

NOTE = "small motions about the equilibrium"


def event_with_poses(event: DrawnEvent, picture: RobotPicture, scale: float) -> DrawnEvent:
    """The event with the poses of the links just before and just after it, where they differ."""
    values = np.column_stack([event.before, event.after])
    if np.ptp(values, axis=1).max(initial=0.0) <= NOT_DRAWN * np.abs(values).max(initial=0.0):
        return event
    poses = picture.poses(values, scale)
    return replace(event, paths={name: Path(pose.positions, pose.quaternions) for name, pose in poses.items()})


def drawing_of_robot(picture: RobotPicture, values: np.ndarray, table=None) -> Drawing:
    """A drawing of the robot with the paths of its links."""
    scale = table.scale if table and "scale" in table.model_fields_set else _visible_scale(picture, values)
    drawing = picture.drawing(picture.poses(values, scale), scale, (table.note if table else "") or NOTE)
    return replace(drawing, view=view_of(table), posing=picture.posing())


def _visible_scale(picture: RobotPicture, values: np.ndarray) -> float:
    """Magnification of the motion, at least 1, that makes the point of largest displacement visibly move."""
    extremes = values[:, np.unique(np.abs(values).argmax(axis=1))]
    return max(1.0, picture.room(extremes))


#: Largest drawn displacement of a point of the robot, as a share of the robot's size.
VISIBLE = 0.15

#: Largest drawn angle of a joint, rad: seen well, and loops can still be closed.
TURN = 0.25

#: Largest entry of a motion so small that it is straight.
SMALL = 1e-4


class RobotPicture:
    """A robot in its posture, to be drawn.

    Attributes:
        scene: the robot with its posture and system.
        solids: of its links, by name: their collision shapes where a robot has no others.
        note: on these, on meshes that are drawn with fewer triangles, and on textures that are not, or an empty string.

    Raises:
        SceneError: a shape or a mesh file that cannot be drawn; names the URDF.
    """

    def __init__(self, scene: RobotScene, table: DrawingTable | None = None):
        self.scene = scene
        self._full = full = table is not None and table.full_meshes
        with at(scene.data.urdf_place):
            own = scene.robot.visuals()
            self._visuals = visuals = own or scene.robot.visuals(collision=True)
        large = {id(item.vertices) for item in visuals if item.triangles > MOST_TRIANGLES}
        missing = dict.fromkeys(item.note for item in visuals if item.note)
        notes = ["links drawn as their collision geometry"] * bool(visuals and not own)
        notes += [f"{counted(len(large), 'mesh', 'meshes')} drawn with fewer triangles"] * bool(large and not full)
        notes += [f"textures not drawn: {', '.join(missing)}"] * bool(missing)
        self.note = ", ".join(notes)
        with at(scene.data.urdf_place):
            self.solids = solids_of(visuals, full=full)

    def poses(self, values: np.ndarray, scale: float = 1.0) -> dict[str, Poses]:
        """The poses of all links."""
        return self.scene.robot.poses(self.scene.posture, values, scale)

    def drawing(self, poses: dict[str, Poses], scale: float = 1.0, note: str = "") -> Drawing:
        """The robot along its paths."""
        points = self.scene.robot.connection_points(self.scene.posture)
        fixed = self.scene.data.table.base == "fixed"
        note = "\n".join(filter(None, (note, self.note)))
        ellipsoids = self.scene.robot.inertia_ellipsoids()
        collision = self._collision
        return robot_drawing(
            self.solids, poses, points, scale=scale, fixed=fixed, note=note, ellipsoids=ellipsoids, collision=collision
        )

    @cached_property
    def _collision(self) -> dict[str, list[Solid]]:
        """The collision shapes of the links that differ from all visual ones."""
        drawn: dict[str, list[Visual]] = {}
        for item in self._visuals:
            drawn.setdefault(item.link, []).append(item)
        shapes = self.scene.robot.visuals(collision=True)
        return solids_of([item for item in shapes if not any(map(item.has_shape_of, drawn.get(item.link, ())))], full=self._full)

    @cached_property
    def at_rest(self) -> dict[str, Poses]:
        """The poses of the posture."""
        return self.poses(np.zeros((len(self.scene.robot.coordinates), 1)))

    @cached_property
    def _points(self) -> np.ndarray:
        """All points at rest, shape (3, k, 1)."""
        return self._of(self.at_rest)

    @property
    def points_of_links(self) -> dict[str, np.ndarray]:
        """The origin of each link and the corners of its solids, relative to the origin and turned as at rest, shape (3, k) each."""
        return {name: points[:, :, 0] - points[:, :1, 0] for name, points in link_points(self.solids, self.at_rest).items()}

    @property
    def size(self) -> float:
        """Diagonal of a box around all links (m)."""
        return robot_size({"all": self._points})

    def room(self, values: np.ndarray) -> float:
        """The largest magnification of a motion at which no joint turns, and no point moves, too far for the drawing.

        The number has two digits; it is 1 where nothing moves. Motors are not drawn and do not count.
        """
        room = self._rooms(values).min(initial=np.inf)
        return two_digits(room) if np.isfinite(room) else 1.0

    def _rooms(self, values: np.ndarray) -> np.ndarray:
        """The largest magnification of each column, without rounding; infinite where nothing moves."""
        links = values[: len(self.scene.robot.coordinates)]
        turning = np.array([unit == "rad" for unit in self.scene.robot.units], dtype=bool)
        angles = np.abs(links[turning]).max(axis=0, initial=0.0)
        with np.errstate(divide="ignore"):
            return np.minimum(VISIBLE * self.size / self._reach(links), TURN / angles)

    def _reach(self, links: np.ndarray) -> np.ndarray:
        """The largest displacement of any point in each column (m)."""
        largest = np.abs(links).max(axis=0, initial=0.0)
        steps = self._of(self.poses(links / np.where(largest, largest, 1.0), SMALL)) - self._points
        return np.linalg.norm(steps, axis=0).max(axis=0) / SMALL * largest

    def posing(self) -> SliderPosing:
        """Sliders for the independent motions, each over the range of ``room`` for it alone."""
        from ....robot.visualization import joint_motions

        motions = joint_motions(self.scene.posture)
        rooms = self._rooms(motions.columns)
        shown = np.flatnonzero(np.isfinite(rooms))
        return SliderPosing(
            tuple(motions.names[k] for k in shown),
            tuple(motions.units[k] for k in shown),
            tuple(two_digits(rooms[k]) for k in shown),
            motions.columns[:, shown],
            motions.twists,
            motions.moving,
            {name: Path(pose.positions, pose.quaternions) for name, pose in self.at_rest.items()},
        )

    def _of(self, poses: dict[str, Poses]) -> np.ndarray:
        return np.hstack(list(link_points(self.solids, poses).values()))
