"""The animation of a motion: a drawing, key frames, and the overlay of jumps, impulses and reactions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.display import number_text, with_unit
from ...ground.tolerances import NOT_DRAWN
from ...ground.units import force_unit, impulse_unit
from ...page.animation import MOST_FRAMES, Animation, Arrow, DrawnEvent, ForceArrows, ImpulseArrow, Overlay, arrow_at
from ...page.drawing import Drawing, DrawnLink
from ...response.events import Event
from ...response.response_notices import sides, without_kinks
from .drawing import drawing_of
from .result import ReportedJump, Result, forces_of_rows, impulses_of, jumps_of, visible

if TYPE_CHECKING:
    from ...robot.visualization import Wrench

#: Most poses of a robot: each closes its loops, and the page interpolates between poses by cubic polynomials.
MOST_POSES = 1_000

#: Key frames in a period of the fastest visible motion.
FRAMES = 20

#: Relative error of cubic interpolation of a cosine between so many key frames, which is invisible.
ERROR = (2 * np.pi / FRAMES) ** 4 / 384

#: Intervals between key frames that are checked, and the share of them that may be wrong: those next to a jump or a kink always are.
CHECKED, KINKS = 128, 0.05

#: Most numbers in the key frames of a page.
MOST_NUMBERS = 400_000

#: Jumps below this share of the largest value of a coordinate or velocity are not reported in the picture.
NOISE = 1e-12

#: Most events in an animation, and most switches; the first are shown.
MOST_EVENTS, MOST_SWITCHES = 100, 1_000

#: Lines of one event in the picture; the tables have all.
MOST_LINES = 6

#: Of these the name of the coordinate alone stands in the picture.
POSITIONS = ("displacement", "angle", "value")

#: For more bodies than these only the number is given over the picture.
MOST_NAMED = 3


def animation_of(result: Result) -> Animation:
    moving = _RobotPicture if result.scene.equations.robot_scene is not None else _Picture
    return moving(result).animation()


def frames_of(result: Result, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Key frames: those of the scene, or more where cubic polynomials between these deviate from the motion."""
    times, values = result.times, result.values
    rates = result.curves("velocity").values
    most = min(most, MOST_NUMBERS // max(1, len(values)))
    if result.is_switched:
        return _frames_with_events(result, most)
    scale = visible(values, result.scene.equations.coordinates.units)
    at, rate = result.motion, result.motion.derivative(1)
    while len(times) < most and _misses(times, values, rates, at, scale):
        times = np.linspace(times[0], times[-1], min(2 * len(times) - 1, most))
        values, rates = at(times), rate(times)
    return times, values, rates


def _frames_with_events(result: Result, most: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Key frames with the values just before and just after each event, as many as half of the frames allow."""
    motion, rate, start, end = result.motion, result.motion.derivative(1), *result.times[[0, -1]]
    scale = visible(result.values, result.scene.equations.coordinates.units)
    events = np.unique([event.time for event in motion._later_events if start < event.time <= end][: most // 4])
    sides = np.concatenate([np.nextafter(events, start), events])
    count = min(len(result.times), most - len(sides))
    while True:
        times = np.unique([*np.linspace(start, end, count), *sides])
        values, rates = motion(times), rate(times)
        if count >= most - len(sides) or not _misses(times, values, rates, motion, scale):
            return times, values, rates
        count = min(2 * count - 1, most - len(sides))


def _misses(times, values, rates, at, scale: np.ndarray) -> bool:
    """Whether cubic polynomials between the key frames deviate from the motion halfway between them."""
    left = np.unique(np.linspace(0, len(times) - 2, CHECKED).round().astype(int))
    right, length = left + 1, np.diff(times)[left]
    middle = (values[:, left] + values[:, right]) / 2 + length * (rates[:, left] - rates[:, right]) / 8
    wrong = np.abs(at(times[left] + length / 2) - middle) > ERROR * scale
    return np.mean(wrong.any(axis=0)) > KINKS


class _Picture:
    """The moving picture of a model whose coordinates are positions in a drawing."""

    def __init__(self, result: Result):
        self.result, self.motion, self.system = result, result.motion, result.system
        self.equations, self.table = result.scene.equations, result.scene.table.drawing
        self.coordinates = self.equations.coordinates

    def animation(self) -> Animation:
        scales = {
            key: getattr(self.table, key) for key in ("scale", "turn_scale") if self.table and key in self.table.model_fields_set
        }
        drawing, frames = drawing_of(self.result.scene, self.result.values, **scales), frames_of(self.result, MOST_FRAMES)
        if self.result.is_switched:
            drawing = replace(drawing, links=tuple(_with_states(link, self.motion.engagements) for link in drawing.links))
        return Animation(drawing, self.coordinates.names, *frames, self.overlay(drawing, frames[0]))

    def overlay(self, drawing: Drawing, times: np.ndarray) -> Overlay:
        """Jumps, impulses and reactions to be drawn; empty without any of them and without [output] arrows."""
        result, applied = self.result, self.motion.applied if self.system else None
        has_events = (
            result.is_switched
            or result.jumps
            or result.impulses
            or result.later
            or (applied and (applied.impulses or applied.later))
        )
        events = tuple(self._events(drawing)) if has_events else ()
        output = result.scene.table.output
        overlay = Overlay(events, *(self.reactions(drawing, times) if "reaction" in output.arrows else ()))
        return replace(overlay, slow=output.slow_events)

    def reactions(self, drawing: Drawing, times: np.ndarray) -> tuple:
        """Forces of the constraint rows, each on the bodies of all coordinates in its row; rows without a body are omitted."""
        values, rates = self.motion.reaction(times), self.motion.reaction_function.derivative(1)(times)
        forces = []
        for i, row in enumerate(self.result.rows):
            arrows = tuple(self._row_arrows(drawing, row.coefficients, 0))
            if arrows:
                forces.append(ForceArrows(row.name, values[i], rates[i], arrows))
        return (tuple(forces),)

    def _row_arrows(self, drawing: Drawing, row: np.ndarray, order: int) -> Iterator[tuple[Arrow, Any]]:
        """Arrows with the row's factors: of forces for order 0, of their impulses for order 1."""
        for i in np.flatnonzero(row):
            unit = force_unit(self.coordinates.units[i])
            arrow = arrow_at(drawing, self.coordinates.names[i], impulse_unit(unit) if order else unit)
            if arrow:
                yield arrow, float(row[i])

    def _events(self, drawing: Drawing) -> Iterator[DrawnEvent]:
        motion, coordinates = self.motion, self.coordinates
        if self.result.is_switched:
            yield from self._switches(drawing)
            return
        if lines := _lines(0.0, self.result.jumps, self._impulses(motion.impulses, 0.0)):
            yield DrawnEvent(0.0, lines, motion.initial[0], motion.start[0], self.impulse_arrows(drawing, 0.0))
        events: dict[float, Event] = {event.time: event for event in without_kinks(motion)}
        impulse_times = {load.time for loads in self._later_loads() for load in loads}
        end = float(self.result.times[-1])
        for time in sorted({*events, *impulse_times})[:MOST_EVENTS]:
            if time <= end:
                event = events.get(time)
                before, after = sides(motion, event, 0) if event else (motion(time), motion(time))
                jumps = jumps_of(motion, coordinates, event) if event else []
                lines = _lines(time, jumps, self._impulses(event.impulses if event else (), time))
                yield DrawnEvent(time, lines, before, after, self.impulse_arrows(drawing, time))

    def _switches(self, drawing: Drawing) -> Iterator[DrawnEvent]:
        """The switches and impacts of a switched motion."""
        motion, rows, end = self.motion, self.motion.impulse_rows, float(self.result.times[-1])
        curves = [self.result.curves(kind).values for kind in ("displacement", "velocity")]
        least = NOISE * np.array([np.abs(values).max(axis=1) for values in curves])
        shown = [event for event in motion.events[:MOST_SWITCHES] if event.time <= end]
        times = np.array([event.time for event in shown])
        for event, *after in zip(shown, motion(times).T, motion.derivative(1)(times).T):
            jumps = Event(event.time, np.where(np.abs(event.jump) > least, event.jump, 0.0), ())
            text, lost = self.coordinates.shown.text, motion.lost_energy(event)
            sizes = [f"impulse of {one}" for one in motion.impulse_texts(event, text)]
            sizes += [f"energy lost: {text(lost, 'J')}"] if lost else []
            lines = _lines(event.time, jumps_of(motion, self.coordinates, jumps, np.array(after)), sizes, f": {event.text}")
            arrows = [
                ImpulseArrow(arrow, factor * size, with_unit(float(np.linalg.norm(factor * size)), arrow.unit))
                for name, size in event.impulses.items()
                if name in rows
                for arrow, factor in self._row_arrows(drawing, rows[name], 1)
            ]
            yield DrawnEvent(event.time, lines, after[0] - jumps.jump[0], after[0], tuple(arrows))

    def _impulses(self, impulses, time: float) -> Iterator[str]:
        """Impulses of coordinates, of constraint forces and of forces, at a time."""
        for impulse in impulses_of(impulses, self.coordinates):
            yield f"{impulse.name} contains {_delta(impulse.order)} of {impulse.size}"
        for name, unit, values in self._force_impulses(time):
            for order, value in enumerate(values):
                if value:
                    yield f"{_delta(order)} of {with_unit(value, impulse_unit(unit, order))}: {name}"

    def impulse_arrows(self, drawing: Drawing, time: float) -> tuple[ImpulseArrow, ...]:
        """Arrows of the impulses of constraint forces and forces at a time, without derivatives of impulses."""
        drawn_arrows: list[ImpulseArrow] = []
        by_name = {f"force of {row.name}": row for row in self.result.rows}
        for name, unit, values in self._force_impulses(time):
            if not values or not values[0]:
                continue
            row = by_name.get(name)
            arrow = arrow_at(drawing, name.removeprefix("force on "), impulse_unit(unit))
            arrows = self._row_arrows(drawing, row.coefficients, 1) if row else [(arrow, 1.0)] * bool(arrow)
            for drawn, factor in arrows:
                size = factor * values[0]
                drawn_arrows.append(ImpulseArrow(drawn, size, with_unit(abs(size), drawn.unit)))
        return tuple(drawn_arrows)

    def _force_impulses(self, time: float) -> Iterator[tuple[str, str, list[float]]]:
        """Name, unit and impulses by order of each force that has any at a time: of constraint rows, then on coordinates."""
        if self.system is None:
            return
        of_rows, applied = self.impulses_at(time)
        forces = forces_of_rows(self.result.rows)
        for i, (name, unit) in enumerate(zip(forces.names, forces.units)):
            values = [float(impulse[i]) for impulse in of_rows]
            if any(values):
                yield name, unit, values
        for name, unit, values in self.applied_impulses(applied, time):
            if any(values):
                yield f"force on {name}", force_unit(unit), values

    def applied_impulses(self, applied, time: float) -> Iterable[tuple[str, str, list[float]]]:
        """Coordinates under an impulsive load, for a robot also inputs, with their impulses by order."""
        rows = zip(self.coordinates.names, self.coordinates.units)
        return [(name, unit, [float(impulse[i]) for impulse in applied]) for i, (name, unit) in enumerate(rows)]

    def impulses_at(self, time: float):
        """Impulses of the constraint rows and of the forces at a time, by order."""
        if time == 0.0:
            return self.motion.constraint_impulses if self.result.rows else (), self.motion.applied.impulses
        return tuple(next((load.impulses for load in loads if load.time == time), ()) for loads in self._later_loads())

    def _later_loads(self):
        """Impulsive loads after t = 0: of the constraint rows, and of the forces."""
        return (self.motion.later_constraint_impulses, self.motion.applied.later) if self.system is not None else ((), ())


class _RobotPicture(_Picture):
    """The moving picture of a robot: reactions and impulses are arrows at the frames of its loops, at its joints, at loaded points.

    Reactions are the whole load: the multipliers at rest plus their changes, which the plots show alone.
    """

    def animation(self) -> Animation:
        from .drawing import RobotPicture, drawing_of_robot, event_with_poses

        times, values, rates = frames_of(self.result, MOST_POSES)
        kept = np.unique(np.linspace(0, len(times) - 1, min(len(times), MOST_POSES)).round().astype(int))
        frames = times[kept], values[:, kept], rates[:, kept]
        picture = RobotPicture(self.equations.robot_scene, self.table)
        drawing = drawing_of_robot(picture, frames[1], self.table)
        overlay = self.overlay(drawing, frames[0])
        overlay = replace(overlay, events=tuple(event_with_poses(event, picture, drawing.scale) for event in overlay.events))
        return Animation(drawing, self.coordinates.names, *frames, overlay)

    @property
    def _row_places(self) -> tuple[list[int], list[int]]:
        """The places of rows of loops among the multipliers of the posture, and among the reactions of the motion."""
        names = self.equations.posture.balance.load.row_names
        own = [place for place, row in enumerate(self.result.rows) if row.name in names]
        return [names.index(self.result.rows[place].name) for place in own], own

    @property
    def _switched(self) -> np.ndarray:
        """Whether the row of a loop is part of some phases only, with its whole force as reaction."""
        switched, loops = (
            self.equations.robot_scene.system.switched_loops,
            (item.connection for item in self.equations.posture.loops),
        )
        names = {name for loop in loops if loop.name in switched for name in loop.row_names}
        return np.isin(self.equations.posture.balance.load.row_names, list(names))

    def reactions(self, drawing: Drawing, times: np.ndarray) -> tuple:
        """The reactions of the loops and couplings, and a sentence on them."""
        from ...robot.visualization import row_wrenches

        posture, function, (places, own) = self.equations.posture, self.motion.reaction_function, self._row_places
        multipliers = np.tile(np.where(self._switched, 0.0, posture.multipliers)[:, None], len(times))
        rates = np.zeros_like(multipliers)
        multipliers[places] += function(times)[own]
        rates[places] = function.derivative(1)(times)[own]
        wrenches = row_wrenches(posture)
        drawn = [(wrench, arrow, part) for wrench in wrenches for arrow, part in _arrows(wrench, 0)]
        forces = tuple(
            ForceArrows(_name(wrench, arrow), part @ multipliers, part @ rates, ((arrow, 1.0),)) for wrench, arrow, part in drawn
        )
        return forces, f"reactions on {_listed([wrench.on for wrench, *_ in drawn])}, the load at rest included"

    def _row_arrows(self, drawing: Drawing, row: np.ndarray, order: int) -> Iterator[tuple[Arrow, Any]]:
        """The arrows of a row on one joint, such as a stop; none of others, whose point the row does not say."""
        from ...robot.visualization import coordinate_wrench

        places = np.flatnonzero(row)
        if len(places) == 1 and places[0] < len(self.equations.robot_scene.robot.coordinates):
            wrench = coordinate_wrench(self.equations.robot_scene.posture, int(places[0]))
            yield from ((arrow, row[places[0]] * part[:, 0]) for arrow, part in _arrows(wrench, order))

    def impulse_arrows(self, drawing: Drawing, time: float) -> tuple[ImpulseArrow, ...]:
        from ...robot.visualization import row_wrenches

        posture, arrows, of_rows = self.equations.posture, [], self.impulses_at(time)[0]
        if of_rows:
            multipliers = np.zeros(len(posture.multipliers))
            places, own = self._row_places
            multipliers[places] = of_rows[0][own]
            arrows += [
                _impulse_arrow(arrow, part @ multipliers) for wrench in row_wrenches(posture) for arrow, part in _arrows(wrench, 1)
            ]
        for name, unit, values in self.applied_impulses((), time):
            if values and values[0]:
                arrows += [_impulse_arrow(arrow, part * values[0]) for arrow, part in self._load_arrows(name, unit)]
        largest: dict[str, float] = {}
        for arrow, size, _ in arrows:
            largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
        return tuple(impulse for impulse in arrows if np.linalg.norm(impulse[1]) > NOT_DRAWN * largest[impulse[0].unit])

    def applied_impulses(self, applied, time: float) -> Iterator[tuple[str, str, list[float]]]:
        """The impulsive loads at a time."""
        totals: dict[str, tuple[str, list[float]]] = {}
        for load in self.equations.loads:
            impulses = {0.0: load.signal.impulses, **{later.time: later.impulses for later in load.signal.later}}.get(time, ())
            values = [float(impulse[0]) for impulse in impulses]
            _, before = totals.get(load.name, (load.unit, []))
            totals[load.name] = load.unit, [a + b for a, b in zip_longest(values, before, fillvalue=0.0)]
        return ((name, unit, values) for name, (unit, values) in totals.items() if any(values))

    def _load_arrows(self, name: str, unit: str) -> Iterator[tuple[Arrow, np.ndarray | float]]:
        """The arrow of a unit impulse on an input or coordinate."""
        from ...robot.connections import PointMotion
        from ...robot.visualization import coordinate_wrench

        robot_scene = self.equations.robot_scene
        motion = robot_scene.inputs.get(name, name)
        if isinstance(motion, PointMotion):
            at: Any = motion  # whose point and direction are given as any sequence
            arrow = Arrow(at.body, at.along, impulse_unit(force_unit(unit)), at.turn, at.point)
            return iter([(arrow, 1.0)])
        joints = robot_scene.robot.coordinates
        place = joints.index(motion.removesuffix(" motor") if motion not in joints else motion)
        return ((arrow, part[:, 0]) for arrow, part in _arrows(coordinate_wrench(robot_scene.posture, place), 1))


#: Further words in the names of the two switches of one element.
PAIRS = (" backward", " forward")


def _with_states(link: DrawnLink, engagements: Mapping[str, Sequence[tuple[float, int]]]) -> DrawnLink:
    """The link with the engagements of the switches of its element; without where these never change what acts."""
    names = [link.name] if link.name in engagements else [f"{link.name}{word}" for word in PAIRS]
    own = [engagements[name] for name in names if name in engagements]
    if not own:
        return link
    times = sorted({time for states in own for time, _ in states})
    levels = [max(next(level for begin, level in reversed(states) if begin <= time) for states in own) for time in times]
    states = tuple(pair for i, pair in enumerate(zip(times, levels)) if not i or levels[i - 1] != pair[1])
    return link if link.kind == "spring" and len(states) == 1 else replace(link, states=states)


def _lines(time: float, jumps: Sequence[ReportedJump], impulses: Iterable[str], what: str = "") -> tuple[str, ...]:
    """A heading and the events, or nothing."""
    lines = [
        f"{jump.name if jump.what in POSITIONS else f'{jump.what} of {jump.name}'} jumps from {jump.before} to {jump.after}"
        for jump in jumps
    ] + list(impulses)
    more = len(lines) - MOST_LINES
    kept = lines if more <= 0 else [*lines[:MOST_LINES], f"and {more} more, see the tables"]
    faint = " (faint: just before)" if any(jump.what in ("displacement", "angle") for jump in jumps) else ""
    return (f"at t = {number_text(time)} s{what}{faint}", *kept) if lines or what else ()


def _delta(order: int) -> str:
    return "δ" + "′" * order if order < 4 else f"δ^({order})"


def _name(wrench: Wrench, arrow: Arrow) -> str:
    return f"{wrench.name} on {wrench.on}{', moment' if arrow.turns else ''}"


def _listed(names: Sequence[str]) -> str:
    names = list(dict.fromkeys(names))
    if len(names) > MOST_NAMED:
        names[MOST_NAMED - 1 :] = [f"{len(names) - MOST_NAMED + 1} more bodies"]
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _arrows(wrench: Wrench, order: int) -> Iterator[tuple[Arrow, np.ndarray]]:
    """The force and the moment with their contributions, shape (3, m), where they can act; impulses for order 1."""
    for unit, turns, part in (("m", False, wrench.force), ("rad", True, wrench.moment)):
        if part.any():
            force = force_unit(unit)
            yield Arrow(wrench.body, None, impulse_unit(force) if order else force, turns, tuple(wrench.point.tolist())), part


def _impulse_arrow(arrow: Arrow, size: np.ndarray | float) -> ImpulseArrow:
    return ImpulseArrow(arrow, size, f"{np.linalg.norm(size):.3g} {arrow.unit}")
