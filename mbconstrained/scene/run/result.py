"""The motion of a scene: trajectories with names and units, extrema, jumps and impulses, aliasing, errors; computed at the first use."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial, reduce
from operator import add, methodcaller
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...exchange.trajectories import Curves
from ...frequency.extrema import (
    Extrema,
    RootMeanSquares,
    extrema,
    fastest_rate,
    positive_times,
    root_mean_squares,
    sampled_extrema,
)
from ...ground.display import number_text
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import NOT_DRAWN
from ...ground.units import derivative_name, force_unit, impulse_unit, rate_unit
from ...linalg.blocks import block_slices, zeros_of
from ...mechanics.boundary import BoundaryResponse
from ...mechanics.channels import Output, OutputNames, closed_form
from ...mechanics.modes import Conservation, Mode, Modes, cleaned, kind_of
from ...mechanics.motion import DELTAS
from ...mechanics.switched import is_switched
from ...polynomial.reduced_equations import Reduction
from ...response.estimate import error_estimate
from ...response.events import Event
from ...response.response_notices import later_notices, sides, without_kinks
from ..build.model import named_quantities, output_names
from ..build.switched import final_notices
from ..coordinates import Coordinates, OutputUnits, beyond_noise
from .scene_data import SceneData
from .stages import connection_forces

if TYPE_CHECKING:
    from ...mechanics.constraints import ConstraintRow
    from ...mechanics.motion import Motion
    from ...mechanics.system import MechanicalSystem
    from ...page.content import RecordResponse, TimeFunctions
    from ...polynomial.jordan_pairs import FinitePair, InfinitePair, JordanPairs
    from ...response.response import Response
    from ...robot.linear_range import LinearRange
    from ...signals.bohl import BohlFunction
    from ...signals.impulsive import ImpulsiveLoad
    from ..build.model import Equations


@dataclass(frozen=True)
class ReportedJump:
    """A jump of a coordinate or a derivative of it at a time; values are texts with units."""

    name: str
    what: str
    before: str
    after: str
    size: str


@dataclass(frozen=True)
class ReportedImpulse:
    """A multiple of the derivative of this order of Dirac's delta; the size is a text with a unit."""

    name: str
    order: int
    size: str

    @property
    def delta(self) -> str:
        """The distribution that it multiplies, as text."""
        return DELTAS[self.order] if self.order < len(DELTAS) else f"the derivative of order {self.order} of a Dirac impulse"


def jumps_of(
    motion: Response, coordinates: Coordinates, event: Event | None = None, known: np.ndarray | None = None
) -> list[ReportedJump]:
    """The jumps of the coordinates and their derivatives; the values just after an event, by order, may be known."""
    jumps = []
    for order, row in enumerate((event or motion).jump):
        if event is None:
            before, after = motion.initial[order], motion.start[order]
            places = beyond_noise(row, before, after)
        elif places := row.nonzero()[0].tolist():
            before, after = sides(motion, event, order) if known is None else (known[order] - row, known[order])
        for i in places:
            unit = rate_unit(coordinates.units[i], order)
            texts = (coordinates.text(value, unit, i) for value in (before[i], after[i], row[i]))
            jumps.append(ReportedJump(coordinates.names[i], derivative_name(coordinates.units[i], order), *texts))
    return jumps


def impulses_of(impulses: Sequence, coordinates: Coordinates) -> list[ReportedImpulse]:
    """The impulses that are not zero."""
    return [
        ReportedImpulse(coordinates.names[i], order, coordinates.text(row[i], impulse_unit(coordinates.units[i], order), i))
        for order, row in enumerate(impulses)
        for i in row.nonzero()[0]
    ]


def forces_of_rows(rows: Sequence[ConstraintRow], name: str = "force of {}", shown: OutputUnits = OutputUnits()) -> Coordinates:
    return Coordinates(tuple(name.format(row.name) for row in rows), tuple(force_unit(row.unit) for row in rows), shown)


def with_units(response: Response, coordinates: Coordinates) -> tuple[Notice, ...]:
    """The notices of a response without units of its coordinates, with these units."""
    own = (NoticeKind.JUMP, NoticeKind.IMPULSE, NoticeKind.KINK)
    others = [notice for notice in response.notices if notice.kind not in own]
    later = later_notices(response, partial(_sentences, response, coordinates), partial(_kink_text, coordinates))
    return (*_sentences(response, coordinates), *later, *others)


def _kink_text(coordinates: Coordinates, number: int, order: int, size: float) -> str:
    unit = coordinates.units[number]
    size_text = coordinates.text(size, rate_unit(unit, order), number)
    return f"{derivative_name(unit, order)} of {coordinates.names[number]} by {size_text}"


def _sentences(motion: Response, coordinates: Coordinates, event: Event | None = None) -> list[Notice]:
    """A notice for each jump and each impulse in the coordinates, at an event or at t = 0."""
    when = f"t = {number_text(event.time)} s" if event else "t = 0"
    quantities = {name: derivative_name(unit, 0) for name, unit in zip(coordinates.names, coordinates.units)}
    notices = [
        Notice(NoticeKind.JUMP, f"{jump.name}: its {jump.what} jumps at {when} by {jump.size}, from {jump.before} to {jump.after}")
        for jump in jumps_of(motion, coordinates, event)
    ]
    return notices + [
        Notice(
            NoticeKind.IMPULSE,
            f"{impulse.name}: its {quantities[impulse.name]} contains {impulse.delta} of {impulse.size} at {when}",
        )
        for impulse in impulses_of((event or motion).impulses, coordinates)
    ]


def folded(notices: Sequence[Notice], jumps: int, impulses: int, later: tuple[int, int] = (0, 0)) -> tuple[Notice, ...]:
    """One sentence in place of the notices on each jump and impulse, which are in tables."""
    jump, impulse = NoticeKind.JUMP, NoticeKind.IMPULSE  # a jump of a constraint row is a cause, which no table has
    counts_of_events = []
    for when, number, others in (("At t = 0", jumps, impulses), ("After t = 0", *later)):
        if counts := [f"{count} {one}{'s' if count > 1 else ''}" for count, one in ((number, jump), (others, impulse)) if count]:
            text = f"{when} there {'is' if number + others == 1 else 'are'} {' and '.join(counts)}; the tables give the sizes"
            counts_of_events.append(Notice(jump if number else impulse, text))
    in_tables = (
        one.kind in (impulse, NoticeKind.SWITCH) or (one.kind == jump and not one.text.startswith("constraint ")) for one in notices
    )
    return (*counts_of_events, *(notice for notice, is_listed in zip(notices, in_tables) if not is_listed))


MOST_NOTICES = 12


def start_notices(equations: Equations) -> tuple[Notice, ...]:
    """Notices on the start: causes first, then the jumps and impulses; none where the start is consistent."""
    if equations.switching is not None:
        kinds = (NoticeKind.JUMP, NoticeKind.IMPULSE)
        at_start = tuple(notice for notice in equations.switching.begin.notices if notice.kind in kinds)
        return (*at_start, *final_notices(equations.switching))
    if equations.start_fits:
        return ()
    motion: Any = equations.solve()  # a Motion where there is a system
    coordinates = equations.coordinates
    notices = [*_causes(equations, motion), *_sentences(motion, coordinates)]
    if equations.system is not None:
        forces = forces_of_rows(equations.system.rows, 'constraint "{}"')
        notices += [
            Notice(NoticeKind.IMPULSE, f"{impulse.name}: its force contains {impulse.delta} of {impulse.size} at t = 0")
            for impulse in impulses_of(motion.constraint_impulses, forces)
        ]
    return tuple(notices[:MOST_NOTICES]) + (
        (Notice(NoticeKind.JUMP, f"and {len(notices) - MOST_NOTICES} more"),) if len(notices) > MOST_NOTICES else ()
    )


def _causes(equations: Equations, motion: Response) -> Iterator[Notice]:
    """Violated constraint rows, or else the violated equations."""
    rows = [notice for notice in motion.notices if notice.kind == NoticeKind.JUMP and notice.text.startswith("constraint ")]
    yield from rows
    if not rows:
        from ...response.admissible import admissible

        admissibility = admissible(equations.polynomial_matrix, initial=equations.initial, force=equations.right_hand_side)
        for violation in admissibility.violations:
            _, _, text = violation.text.partition(": ")
            if equations.has_outputs_among_coordinates and text.startswith('"output '):
                continue  # an output follows its input at once
            yield Notice(NoticeKind.JUMP, f"the start does not fit: {text}")


#: Fewer times in a period than the first cannot represent it; the second show it smoothly.
FEWEST, SMOOTH = 3, 20

#: Rounding errors of a number of points.
COUNT_NOISE = 1e-12

#: Points in a period of times that follow the motion, and the most of these times.
FOLLOWED, MOST_TIMES = 12, 20_001

#: Components below this share of the motion are invisible in a plot.
VISIBLE = 0.01

#: Places where persistent motion is sampled, as shares of the whole time.
ALIASING_PLACES = (0.25, 0.5, 0.75)

#: Spacings of times after the start and after changes of the force: motion decayed by then has only few points in a curve.
LASTS = 5

#: Most changes of the force that are sampled: those followed by the longest times without another.
MOST_CHANGES = 16

#: Each sampling covers so many periods twice, at least the second number, with so many times.
PERIODS, LEAST_PERIODS, LOOKS = 4, 2, 256

#: Components slower than this share of a frequency count as a parabola; frequencies within this factor count as one.
SLOWER, NEAR = 0.01, 1.1

#: Components that the samples cannot separate, relative to the largest singular value.
ALIKE = 1e-3


def following_times(scene: SceneData, motion: Motion) -> np.ndarray:
    """Equidistant times that resolve the fastest visible motion, from the default number to ``MOST_TIMES``."""
    time = scene.table.time
    fastest = _fastest_visible(scene, motion, 2 * math.pi / (FOLLOWED * time.spacing))
    if fastest is None:
        return time.times
    points = math.ceil((1 - COUNT_NOISE) * (time.end - time.start) * FOLLOWED * fastest[0] / (2 * math.pi)) + 1
    return np.linspace(time.start, time.end, min(points, MOST_TIMES))


def aliasing_notices(scene: SceneData, motion: Motion, count: int) -> tuple[Notice, ...]:
    """A notice where this number of times is too coarse for the fastest visible motion, with the entry to write instead."""
    time = scene.table.time
    spacing = (time.end - time.start) / (count - 1)
    fastest = _fastest_visible(scene, motion, 2 * math.pi / (FEWEST * spacing))
    if fastest is None:
        return ()
    angular, name, amplitude = fastest
    period = 2 * math.pi / angular
    points = math.ceil((time.end - time.start) * SMOOTH / period) + 1
    end = f'end = "{time.start + period * (count - 1) / SMOOTH:.2g} s"'  # which shows only the first of the motion
    few = f"points = {points}" if time.step is None else f'step = "{period / SMOOTH:.2g} s"'
    instead = few if points <= time.MOST_POINTS else end
    text = (
        f"the times are {spacing:.3g} s apart, but the fastest visible motion has a period of {period:.3g} s ({1 / period:.4g} Hz, with "
        f"{amplitude} in {name}): a table of these times, and lines between its values, show a slower motion that does not exist "
        "(aliasing), while the values at the times are right and the plots of page and images follow the motion; "
        f"for a table that shows it, write {instead} below [time]"
    )
    return (Notice(NoticeKind.ALIASING, text),)


def _fastest_visible(scene: SceneData, motion: Motion, slowest: float) -> tuple[float, str, str] | None:
    """The highest angular frequency above ``slowest`` of a visible component that does not decay at once, a coordinate, its amplitude."""
    frequencies, last = _angular_frequencies(scene, motion), math.inf
    for highest in frequencies:
        if not slowest < highest <= last / 2:  # the highest of each octave
            continue
        last = highest
        frequency = _visible_frequency(scene, motion, [each for each in frequencies if SLOWER * highest <= each <= highest])
        if frequency and frequency[0] > slowest:
            return frequency
    return None


def _angular_frequencies(scene: SceneData, motion: Motion) -> list[float]:
    """Angular frequencies of the eigenvalues and the forces, in descending order."""
    if is_switched(motion):
        return sorted({abs(value.imag) for value in zeros_of(motion.function.blocks)}, reverse=True)
    A = scene.equations.polynomial_matrix
    zeros = {abs(value.imag) for value in (A.reduction if isinstance(A.reduction, Reduction) else A).eigenvalues}
    smooth = motion.force.smooth  # prescribed motions, too
    used = [np.abs(smooth.coefficients[:, at]).any() for at in block_slices(smooth.blocks)]
    forces = {abs(value.imag) for value in zeros_of([block for block, one in zip(smooth.blocks, used) if one])}
    return sorted(zeros | forces, reverse=True)


def _visible_frequency(scene: SceneData, motion: Motion, descending: list[float]) -> tuple[float, str, str] | None:
    """The highest of these angular frequencies, or of the octave below the first, that is visible in the motion."""
    kept = list(_distinct(descending))
    coordinates = scene.equations.coordinates
    some = motion(scene.times)
    for begin, length in _stretches(scene, motion, 2 * math.pi / kept[0]):
        local = np.linspace(0.0, length, LOOKS)
        both = [motion(begin + local), motion(begin + length + local)]
        scale = visible(np.hstack([some, *both]), coordinates.units)
        parts = _parts(np.array(kept), local / length, length)
        amplitudes = np.minimum(*(_amplitudes(parts, values) for values in both))  # a jump or a kink is in one of the two
        visible_parts = (amplitudes > VISIBLE * scale.T).any(axis=1)
        if visible_parts.any():
            fastest = int(np.argmax(visible_parts))
            place = int(np.argmax(amplitudes[fastest] / scale[:, 0]))
            text = coordinates.text(float(f"{amplitudes[fastest, place]:.3g}"), coordinates.units[place], place)
            return kept[fastest], coordinates.names[place], text
    return None


def _amplitudes(parts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Amplitudes of the oscillations in the coordinates, by frequency and coordinate."""
    factors = np.linalg.lstsq(parts, values.T, rcond=ALIKE)[0][3:]
    return np.hypot(*factors.reshape(2, -1, len(values)))


def _stretches(scene: SceneData, motion: Motion, period: float) -> Iterator[tuple[float, float]]:
    """Stretches of time to search for oscillations of this period: beginnings and lengths, in s, each followed by an equal one."""
    time, force = scene.table.time, scene.equations.force
    whole = time.end - time.start
    length = min(PERIODS * period, whole / 2)
    changes = np.array([0.0]) if force is None else force.knots[force.knots < time.end]
    if not is_switched(motion):
        yield from ((time.start + min(place * whole, whole - 2 * length), length) for place in ALIASING_PLACES)
    else:  # nothing oscillates on through an event
        changes = np.unique([*changes, *(event.time for event in motion.events if event.time < time.end)])
    begins = np.maximum(changes + LASTS * time.spacing, time.start)
    left = np.append(changes[1:], time.end) - begins
    for k in np.argsort(-left, kind="stable")[:MOST_CHANGES]:
        if left[k] >= 2 * LEAST_PERIODS * period:
            yield float(begins[k]), min(length, float(left[k]) / 2)


def _distinct(descending: Iterable[float]) -> Iterator[float]:
    last = math.inf
    for each in descending:
        if each * NEAR <= last:
            last = each
            yield each


def _parts(angular: np.ndarray, share: np.ndarray, length: float) -> np.ndarray:
    """A parabola, cosines and sines, one column each, at fractions of a stretch of time."""
    phases = np.outer(length * share, angular)
    return np.hstack([np.vander(share, 3), np.cos(phases), np.sin(phases)])


def visible(values: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """Range of the coordinates by unit, which decides what is visible."""
    reach = np.ptp(values, axis=1)
    furthest = {unit: reach[[other == unit for other in units]].max() for unit in dict.fromkeys(units)}
    return np.array([max(furthest[unit] / 2, NOT_DRAWN * np.abs(values).max()) for unit in units])[:, None]


ORDERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
PARTS = {  # curves that are made of others
    "energy": ("displacement", "velocity"),
    "output": ("displacement",),
    "phase": ("displacement", "velocity"),
    "quantity": ("displacement", "velocity"),
    "ground_reaction": ("displacement", "velocity", "reaction"),
    "force": (),
}

#: Errors of trajectories, relative to the largest value of a kind, that are assumed at least and at most.
LEAST_NOISE, MOST_NOISE = 1e-13, 0.1

#: Curves of each kind whose largest values are listed.
MOST_LARGEST = 40

ENERGIES = ("kinetic", "strain", "static", "total")


@dataclass(frozen=True)
class Largest:
    """The largest modulus of a curve between the first and the last time, of the closed form."""

    # name, title and unit of the curve, in SI
    name: str
    title: str
    unit: str
    value: float  # with its sign
    time: float  # in s
    margin: float  # bound of the excess of the maximum over this value; 0 except for motions of very many periods


class KindOfCurves(NamedTuple):
    """Curves of a kind: names, units, the function of time, and what has a closed form without constants."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: Callable[[np.ndarray], np.ndarray]
    linear: Callable[[], BohlFunction] | None = None  # None of energies
    constants: np.ndarray | None = None
    titles: tuple[str, ...] = ()  # by default the kind


class Result:
    """The motion of a scene.

    Attributes:
        scene: the scene.
        system: mass, damping, stiffness and constraint rows; None where A(s) was given itself.
        times: times of the scene, shape (T,), in s.
    """

    def __init__(self, scene: SceneData):
        self.scene = scene
        self.system: MechanicalSystem | None = scene.equations.system
        self._curves: dict[str, Curves] = {}
        self._extrema: dict[tuple[str, tuple[int, ...] | None], Extrema] = {}
        self._functions: dict[str, TimeFunctions] = {}

    @cached_property
    def rows(self) -> tuple[ConstraintRow, ...]:
        """The constraint rows whose forces the motion has; of a switched system those of all phases."""
        return () if self.system is None else getattr(self.motion, "_reaction_rows", self.system.rows)

    @property
    def is_switched(self) -> bool:
        """Whether the motion has phases with equations of their own."""
        return is_switched(self.motion)

    def jordan_pairs(self) -> JordanPairs:
        """The pairs (C, J, B) of the finite zeros and of those at infinity."""
        return self.scene.equations.polynomial_matrix.jordan_pairs()

    @property
    def finite_pair(self) -> FinitePair:
        """(C, J, B) of the finite zeros."""
        return self.jordan_pairs().finite

    @property
    def infinite_pair(self) -> InfinitePair:
        """(C, J, B) of the zeros at infinity."""
        return self.jordan_pairs().infinite

    @cached_property
    def times(self) -> np.ndarray:
        """Times of the scene; without a given number, enough for the fastest visible motion."""
        time = self.scene.table.time
        is_given = "points" in time.model_fields_set or "step" in time.model_fields_set
        return time.times if is_given else following_times(self.scene, self.motion)

    @cached_property
    def motion(self) -> Any:
        """x as a function of time, with jumps and impulses; a Motion where there is a mechanical system."""
        return self.scene.equations.solve()

    @property
    def values(self) -> np.ndarray:
        """The coordinates at the times, shape (r, T)."""
        return self.curves("displacement").values

    # Trajectories.

    @cached_property
    def kinds(self) -> list[str]:
        """The kinds of curves that the scene requests, the coordinates first."""
        output, equations = self.scene.table.output, self.scene.equations
        plots = [part for kind in output.plots for part in (PARTS[kind] if kind == "phase" else (kind,))]
        reactions = ["reaction", "ground_reaction"] if output.reactions else []
        requested = ["displacement", *plots, *reactions, *(["quantity"] if output.quantity else [])]
        return [
            kind
            for kind in dict.fromkeys(requested)
            if (kind != "reaction" or self.rows)
            and (kind != "ground_reaction" or equations.has_connections)
            and (kind != "output" or not equations.has_outputs_among_coordinates)
            and (kind != "force" or equations.has_forces)
        ]

    def curves(self, kind: str) -> Curves:
        """Trajectories of a kind: displacement, velocity, acceleration, reaction, energy or output; or of a quantity by its name."""
        if kind not in self._curves:
            own = self._kind(kind)
            self._curves[kind] = Curves(kind, own.names, own.titles or (kind,) * len(own.names), own.units, own.values(self.times))
        return self._curves[kind]

    def shown_curves(self, kind: str) -> Curves:
        """Curves in the units of [output], for page and CSV."""
        return in_units(self.curves(kind), self.scene.equations.coordinates.shown)

    def functions(self, kind: str) -> Callable[[np.ndarray], np.ndarray]:
        """Trajectories of a kind as functions of time."""
        return self._kind(kind).values

    def _kind(self, kind: str) -> KindOfCurves:
        """Names, units and functions of the curves of a kind."""
        equations, motion, coordinates = self.scene.equations, self.motion, self.scene.equations.coordinates
        if kind in ORDERS:
            order = ORDERS[kind]
            titles, units = (tuple(name(unit, order) for unit in coordinates.units) for name in (derivative_name, rate_unit))
            values = motion.derivative(order) if order else motion
            return KindOfCurves(coordinates.names, units, values, lambda: values if order else motion.function, None, titles)
        if kind == "reaction":
            names, units = zip(*((row.name, force_unit(row.unit)) for row in self.rows))
            return KindOfCurves(names, units, motion.reaction, lambda: motion.reaction_function)
        if kind == "output":
            of_outputs = lambda times: equations.output_values(times, motion(times))  # noqa: E731
            return KindOfCurves(
                equations.outputs.names, equations.outputs.units, of_outputs, lambda: equations.output_closed_form(motion)
            )
        if kind == "quantity":
            return self._linear(list(named_quantities(self.scene.table.output.quantity, self.output_names)))
        if kind == "ground_reaction":
            return self._connection_forces()
        if kind == "force":
            return _forces(equations)
        if kind != "energy":
            return self._linear([self.output_names.output(kind, what="curves")])
        energies = lambda times: np.array([getattr(motion.energy(times), name) for name in ENERGIES])  # noqa: E731
        return KindOfCurves(ENERGIES, ("J",) * len(ENERGIES), energies)

    @cached_property
    def output_names(self) -> OutputNames:
        """The names of all quantities that are linear in the motion."""
        return output_names(self.scene.equations)

    def _linear(self, outputs: Sequence[Output]) -> KindOfCurves:
        """Curves of quantities that are linear in the motion."""
        names, titles, units = zip(*((each.name, each.quantity, each.unit) for each in outputs))
        values = lambda times: np.array([each.values(self.motion, times) for each in outputs])  # noqa: E731
        constants = np.array([each.constant for each in outputs])
        return KindOfCurves(names, units, values, lambda: closed_form(outputs, self.motion), constants, titles)

    def _connection_forces(self) -> KindOfCurves:
        """Forces of loops, springs and bushings of a robot."""
        forces, motion, rows = self.scene.equations.robot_scene.system.connection_forces, self.motion, self.rows
        rate = motion.derivative(1)
        titles = tuple(f"{'force' if unit == 'N' else 'torque'} in ground axes" for unit in forces.units)

        def values(times: np.ndarray) -> np.ndarray:
            return forces.values(motion(times), rate(times), motion.reaction(times) if rows else np.zeros((0, len(times))))

        def linear() -> BohlFunction:
            function = motion.function.differential(forces.displacement, forces.velocity)
            return function + motion.reaction_function.mapped(forces.multipliers) if rows else function

        return KindOfCurves(forces.names, forces.units, values, linear, forces.rest, titles)

    def drawn_functions(self, kind: str) -> Callable[[np.ndarray], np.ndarray]:
        """The functions without proof of their values, which takes long, where no visible difference results at the times of the scene."""
        own = self._kind(kind)
        if own.linear is None:
            return own.values
        linear, proved = own.linear(), self.curves(kind).values
        rough, added = getattr(linear, "rough", linear), 0.0 if own.constants is None else own.constants[:, None]
        near = np.abs(rough(self.times) + added - proved).max(axis=1) <= NOT_DRAWN * np.abs(proved).max(axis=1)
        return (lambda times: rough(times) + added) if near.all() else own.values

    def time_functions(self, kind: str) -> TimeFunctions:
        """Trajectories as stored in the page: in the units of [output], with the times of possible jumps and kinks, and their estimated
        error.
        """
        if kind not in self._functions:
            from ...page.content import TimeFunctions

            estimates = [self.error_estimates.get(part, 0.0) for part in (kind, *PARTS.get(kind, (kind,)))]
            noise = min(max(LEAST_NOISE, *estimates), MOST_NOISE)
            values, curves, shown = self.drawn_functions(kind), self.curves(kind), self.scene.equations.coordinates.shown
            factors = np.array([[shown.of(unit, name)[1]] for unit, name in zip(curves.units, curves.names)])
            self._functions[kind] = TimeFunctions(lambda times: factors * values(times), self._breaks, noise, self.record_response)
        return self._functions[kind]

    @cached_property
    def record_response(self) -> RecordResponse | None:
        """The motion from which the curves are computed, where a force restarts; at its knots all values up to the degree of A(s)."""
        from ...page.content import RecordResponse

        if self.is_switched or (
            self.system is not None and self.system.delayed
        ):  # the coordinates do not follow from their values at the knots of the force
            return None
        restarts, degree = self.motion.force.smooth.restarts, self.scene.equations.polynomial_matrix.degree
        views = [self.motion, *(self.motion.derivative(order) for order in range(1, degree))]
        states = lambda times: np.vstack([view(times) for view in views])  # noqa: E731
        return RecordResponse(restarts.knots, restarts.states, states) if len(restarts.knots) > 1 else None

    @property
    def _breaks(self) -> np.ndarray:
        """Times at which the motion or a derivative of it may jump."""
        times = [*self.motion.force.knots, *(event.time for event in self.motion._later_events)]
        if self.system is not None and self.system.delayed:
            times += self.motion.solution.steps.kinks(float(self.times[-1]))
        return np.unique(times)

    # Extrema and means, of the closed form.

    def extrema(self, kind: str, rows: Sequence[int] | None = None) -> Extrema:
        """The largest and the smallest values of a kind of curves, or of some, with their times, also between the times of the scene."""
        key = kind, None if rows is None else tuple(rows)
        if key not in self._extrema:
            own = self._kind(kind)
            chosen = list(range(len(own.names)) if rows is None else rows)
            at = lambda times: np.asarray(own.values(times))[chosen]  # noqa: E731
            if own.linear is None:
                extremes = self.sampled_extrema(at)
            else:
                extremes = extrema(own.linear().rows(chosen), *self.times[[0, -1]].tolist())
                if own.constants is None:
                    extremes = extremes.with_values(at)
                else:
                    extremes = extremes.shifted(own.constants[chosen])
            self._extrema[key] = extremes
        return self._extrema[key]

    def sampled_extrema(self, at: Callable[[np.ndarray], np.ndarray]) -> Extrema:
        """Extrema of functions with squares of the motion, such as energies, by ``sampled_extrema``."""
        return sampled_extrema(at, self._breaks, 2 * fastest_rate(self.motion.function), *self.times[[0, -1]].tolist())

    def positive_times(self, at: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Times at which functions with squares or ratios of the motion are largest, and first positive, by ``positive_times``."""
        return positive_times(at, self._breaks, 2 * fastest_rate(self.motion.function), *self.times[[0, -1]].tolist())

    def rms(self, kind: str, rows: Sequence[int]) -> RootMeanSquares:
        """The RMS values of some curves of a kind from the first to the last time, by integrals of the closed form."""
        own, chosen = self._kind(kind), list(rows)
        added = None if own.constants is None else own.constants[chosen]
        start, end = self.times[[0, -1]].tolist()
        return root_mean_squares(own.linear().rows(rows), start, end, added, lambda times: own.values(times)[chosen])

    @cached_property
    def largest(self) -> list[Largest]:
        """The largest moduli of the requested curves, of each kind the first ``MOST_LARGEST``."""
        values: list[Largest] = []
        wanted = self.scene.table.output.coordinates
        for kind in (kind for kind in self.kinds if kind != "phase"):
            own = self.curves(kind)
            rows = [i for i, name in enumerate(own.names) if kind not in ORDERS or wanted is None or name in wanted][:MOST_LARGEST]
            extremes = self.extrema(kind, rows if len(rows) < len(own.names) else None)
            signs = np.where(extremes.maximum >= -extremes.minimum, 1.0, -1.0)
            for row, *ends in zip(rows, signs * extremes.largest, extremes.largest_time, extremes.margin):
                values.append(Largest(own.names[row], own.titles[row], own.units[row], *map(float, ends)))
        return values

    # Jumps and impulses.

    @cached_property
    def jumps(self) -> list[ReportedJump]:
        """The jumps of the coordinates at t = 0."""
        return jumps_of(self.motion, self.scene.equations.coordinates)

    @cached_property
    def impulses(self) -> list[ReportedImpulse]:
        """The impulses at t = 0 in the coordinates, then in the constraint forces."""
        coordinates = self.scene.equations.coordinates
        impulses = impulses_of(self.motion.impulses, coordinates)
        own = (
            () if self.is_switched or not self.rows else self.motion.constraint_impulses
        )  # the table of events has those of contacts
        if own:
            impulses += impulses_of(own, forces_of_rows(self.rows, shown=coordinates.shown))
        return impulses

    @cached_property
    def later(self) -> list[Event | ImpulsiveLoad]:
        """The events of the motion, except kinks, and the impulses of its constraint forces after t = 0, by time."""
        of_rows = () if self.is_switched else getattr(self.motion, "later_constraint_impulses", ())  # the table of events has them
        events = [*without_kinks(self.motion), *of_rows]
        return sorted(events, key=lambda event: event.time)

    # Modes and evidence.

    @cached_property
    def modes(self) -> Modes:
        """The finite zeros of the mechanical system with their meaning."""
        return self.system.modes()

    @cached_property
    def eigenvalue_rows(self) -> list[dict[str, str]]:
        """The rows of the table of eigenvalues, texts by column as in ``Modes.table``; zeros of a bare A(s) have no mechanical meaning."""
        if self.system:
            return self.modes.table()
        names = self.scene.equations.coordinates.names
        modes, known = [], Conservation(passive=False, lossless=False)
        for zero in self.finite_pair.zeros:
            value = cleaned(complex(zero.value), zero.multiplicity, known)
            modes.append(Mode(kind_of(value), value, zero.multiplicity, np.zeros((len(names), 0))))
        return [
            {**row, "kind": mode.kind if mode.eigenvalue else "at 0", "meaning": _meaning_of(mode.eigenvalue, mode.multiplicity)}
            for mode, row in zip(modes, Modes(tuple(modes), names).table())
        ]

    @property
    def error_estimate(self) -> float:
        """Estimate of max |error| / max |x| over the times."""
        return self.error_estimates["displacement"]

    @cached_property
    def error_estimates(self) -> dict[str, float]:
        """Error estimates of each requested kind of curve; energies depend on x and x', outputs of a robot on x."""
        watched = ["ground_reaction"] if self.scene.equations.has_connections and self.watches_connections else []
        parts = (part for kind in (*self.kinds, *watched) for part in PARTS.get(kind, (kind,)))
        kinds = [kind for kind in dict.fromkeys(parts) if kind != "reaction" or self.rows]
        if self.is_switched or isinstance(self.motion, BoundaryResponse):  # which is no motion of its start alone
            return {kind: self.motion.error_estimate(self.times, **_of_kind(kind, self.system)) for kind in kinds}
        views = {kind: methodcaller("derivative", order) for kind, order in ORDERS.items()}
        views["reaction"] = getattr(self.motion, "_reaction_of", None)
        estimates = {kind: error_estimate(self.motion, self.times, views[kind]) for kind in kinds}
        of_output = self.scene.equations.output_error_estimate(self.times) if "output" in self.kinds else None
        return estimates if of_output is None else {**estimates, "output": of_output}

    @property
    def watches_connections(self) -> bool:
        """Whether the forces of loops, springs and bushings of a robot are computed."""
        return connection_forces(self.scene)[0]

    @cached_property
    def linear_range(self) -> LinearRange | None:
        """Linear range of the motion of a robot; None for other models."""
        return self.scene.equations.linear_range(self.motion, self.times)


def _of_kind(kind: str, system: MechanicalSystem | None) -> dict:
    """The arguments of a motion's own error estimate for a kind of curves."""
    return {"order": ORDERS.get(kind, 0)} if system is None else {"of": kind if kind in (*ORDERS, "reaction") else "displacement"}


def _forces(equations: Equations) -> KindOfCurves:
    """The loads by name, or the inputs of a transfer function or state space; impulses are left out."""
    control = equations.control
    if control is not None:
        inputs, signal = control.inputs, control.input
        return KindOfCurves(inputs.names, inputs.units, signal, lambda: signal.smooth, None, ("input",) * len(inputs.names))
    names = tuple(dict.fromkeys(load.name for load in equations.loads))
    units = tuple(force_unit(next(load.unit for load in equations.loads if load.name == name)) for name in names)
    rows = np.eye(len(names))
    parts = (load.signal.mapped(rows[:, [names.index(load.name)]]) for load in equations.loads)
    total = reduce(add, parts)
    titles = tuple("torque" if unit == "N m" else "force" for unit in units)
    return KindOfCurves(names, units, total, lambda: total.smooth, None, titles)


def in_units(curves: Curves, units: OutputUnits) -> Curves:
    if units == OutputUnits():
        return curves
    own, factors = zip(*map(units.of, curves.units, curves.names))
    return replace(curves, units=own, values=np.array(factors)[:, None] * curves.values)


def _meaning_of(value: complex, multiplicity: int) -> str:
    if value == 0:
        return "constant" if multiplicity == 1 else "constant or growing with a power of t"
    if value.imag:
        return "undamped" if not value.real else ""
    return f"time constant {number_text(1 / abs(value.real))} s"
