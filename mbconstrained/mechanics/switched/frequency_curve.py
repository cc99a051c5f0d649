"""Periodic motions of a switched system over the frequency of a harmonic force, by continuation along the arc of the branch.

The unknowns are z = (x, x') at one angle of the force and the logarithm of the frequency. Steps go along the tangent of the branch and are
corrected at right angles to it, so that a branch is followed around its folds (Keller 1977; Nayfeh and Balachandran, Applied Nonlinear
Dynamics, 1995, section 6.1). The multipliers of every point tell its stability and where it changes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np

from ...frequency.plots import draw_branch
from ...ground.checks import counted, real_array, whole_number
from ...ground.display import Displayed, TextTable, number_text
from ...ground.errors import InputError, MbconstrainedError, NotUnique, within_float64
from ...ground.tolerances import CLOSED_ORBIT, EPS, FREQUENCY_DIFFERENCE, LOCATED_CHANGE, SHORTEST_STEP, UNDETERMINED
from ...ground.units import rate_unit
from ...signals.inputs import harmonic
from ..harmonic_sums import complex_amplitudes
from .periodic import Orbit, PeriodicMotion, PeriodMap, cleared, forced_orbit, newton, start_of

#: Steps along the branch, in ranges of the motion and in this part of the logarithm of the range of frequencies.
FIRST_STEP, LONGEST_STEP, FREQUENCY_PART = 0.02, 0.1, 0.25

#: Shorter steps end the branch where an event is as slow as this part of the range of its velocity, and a multiplier as large.
SHORT_STEP, GENTLE, SENSITIVE = 5e-3, 0.1, 30.0

#: Where the frequency changes by more than this part of a step, points are corrected at fixed frequency, which needs fewer phases.
STEEP = 0.3

#: Steps of the corrector, and how many make the next step longer or shorter.
CORRECTIONS, FEW, MANY = 10, 4, 6

#: Least cosine between the tangents of neighbours.
STRAIGHT = 0.9

#: At a jump of a test function this part of it remains.
JUMPED = 1e-3

Kind = Literal["fold", "flip", "torus", "branch point", "grazing"]

#: What happens at each kind of bifurcation.
MEANINGS: Mapping[str, str] = {
    "fold": "the branch turns: a multiplier is 1",
    "flip": "period doubling: a multiplier is -1",
    "torus": "a second frequency appears: a pair of multipliers on the unit circle",
    "branch point": "another branch crosses: a multiplier is 1, the branch does not turn",
    "grazing": "the number of events changes: a guard only touches zero",
}


@dataclass(frozen=True, repr=False, eq=False)
class Bifurcation(Displayed):
    """A point of a branch at which its stability or its events change.

    Attributes:
        kind: "fold" (a multiplier +1, the branch turns), "flip" (-1, the period doubles), "torus" (a complex pair on the unit circle), "branch
            point" (+1 without turning) or "grazing" (the number of events changes).
        motion: the periodic motion there, or just before it where events change.
        text: a sentence with the frequency.
    """

    kind: Kind
    motion: PeriodicMotion
    text: str

    def _summary(self) -> str:
        return self.text


@dataclass(frozen=True, repr=False, eq=False)
class FrequencyCurve(Displayed):
    """A branch of periodic motions over the frequency of a harmonic force, stable and unstable.

    Attributes:
        points: the periodic motions, in their order along the branch.
        bifurcations: where the stability or the number of events changes.
        periods: periods of the force in one of the motion.
        end_text: why the branch ends.
    """

    points: tuple[PeriodicMotion, ...]
    bifurcations: tuple[Bifurcation, ...]
    periods: int
    end_text: str

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates."""
        return self.points[0].names

    @cached_property
    def frequencies_hz(self) -> np.ndarray:
        """Frequencies of the force in Hz, shape (P,)."""
        return np.array([self.periods / point.period for point in self.points])

    @cached_property
    def unstable(self) -> np.ndarray:
        """Whether each motion is unstable or at the limit of stability, shape (P,)."""
        return np.array([not point.is_stable for point in self.points])

    def amplitudes(self, name: str) -> np.ndarray:
        """Return half the difference between the largest and the smallest displacement at each point.

        Args:
            name: of the coordinate.

        Returns:
            In m or rad, shape (P,).

        Raises:
            InputError: an unknown name.
        """
        return np.array([point.amplitude(name) for point in self.points])

    def at(self, frequency_hz: float) -> tuple[PeriodicMotion, ...]:
        """Return the points at one of the frequencies that the branch was asked for; more than one where it turns.

        Args:
            frequency_hz: in Hz.

        Returns:
            The periodic motions, in their order along the branch; empty where there is none.
        """
        near = np.abs(self.frequencies_hz - frequency_hz) <= CLOSED_ORBIT * abs(frequency_hz)
        return tuple(self.points[i] for i in np.flatnonzero(near))

    def table(self) -> TextTable:
        """The points with their amplitudes, the largest multiplier and the number of events.

        Returns:
            A ``TextTable``.
        """
        units = self.points[0].motion.system.units
        rows = []
        for f, point, unstable in zip(self.frequencies_hz, self.points, self.unstable):
            amplitudes = [number_text(point.amplitude(name)) for name in self.names]
            largest = number_text(float(np.abs(point.multipliers).max(initial=0.0)))
            rows.append((f"{f:.9g}", *amplitudes, largest, "unstable" if unstable else "stable", str(len(point.events))))
        columns = (f"{name} ({rate_unit(units[name], 0)})" for name in self.names)
        return TextTable(
            "Frequency curve", ("f (Hz)", *columns, "largest multiplier", "stability", "events"), tuple(rows), self.end_text
        )

    def plot(self, name: str | None = None, axes=None):
        """Draw the amplitude of a coordinate over the frequency with Matplotlib, unstable parts dashed, bifurcations as dots.

        Args:
            name: of the coordinate; the first by default.
            axes: axes of Matplotlib; new ones by default.

        Returns:
            The axes.

        Raises:
            InputError: an unknown name.
        """
        name = self.names[0] if name is None else name
        marks: dict[str, list[tuple[float, float]]] = {
            kind: [(self.periods / one.motion.period, one.motion.amplitude(name)) for one in self.bifurcations if one.kind == kind]
            for kind in dict.fromkeys(one.kind for one in self.bifurcations)
        }
        label = f"amplitude of {name} ({rate_unit(self.points[0].motion.system.units[name], 0)})"
        return draw_branch(self.frequencies_hz, self.amplitudes(name), self.unstable, marks, label, axes)

    def to_dict(self) -> dict:
        """The points and bifurcations as plain data, in SI.

        Returns:
            A dictionary for JSON.
        """
        return {
            "periods": self.periods,
            "points": [{"force_hz": f, **point.to_dict()} for f, point in zip(self.frequencies_hz.tolist(), self.points)],
            "bifurcations": [
                {"kind": one.kind, "force_hz": self.periods / one.motion.period, "text": one.text} for one in self.bifurcations
            ],
            "end": self.end_text,
        }

    def _summary(self) -> str:
        low, high = self.frequencies_hz.min(), self.frequencies_hz.max()
        kinds = ", ".join(f"{one.kind} at {self.periods / one.motion.period:.6g} Hz" for one in self.bifurcations)
        return f"{counted(len(self.points), 'point')}, {low:.6g} to {high:.6g} Hz{'; ' * bool(kinds)}{kinds}"

    def _tables(self) -> tuple[TextTable, ...]:
        changes = TextTable("Bifurcations", ("kind", "where"), tuple((one.kind, one.text) for one in self.bifurcations))
        return self.table(), changes


def follow(system, force_pattern, frequencies_hz, start, periods: int, most_points: int) -> FrequencyCurve:
    """The branch of periodic motions from the first of the frequencies to the last."""
    frequencies = real_array(frequencies_hz, "frequencies_hz", shape=(None,))
    if len(frequencies) < 2 or (frequencies <= 0).any() or frequencies[0] == frequencies[-1]:
        raise InputError(
            "frequencies_hz: expected at least two different positive numbers, the first and the last of the branch, in Hz"
        )
    periods = whole_number(periods, "periods", minimum=1)
    most = whole_number(most_points, "most_points", minimum=2)
    z = None if start is None else start_of(system, start)
    with within_float64():
        return _Branch(system, complex_amplitudes(system.system, force_pattern, "force_pattern"), frequencies, periods).followed(
            z, most
        )


@dataclass(frozen=True, eq=False)
class _Point:
    """A point of the branch: the closed orbit, the tangent (of z and of the logarithm of the frequency), and how many steps it took."""

    orbit: Orbit
    tangent: np.ndarray
    corrections: int = 0

    @property
    def angular_frequency(self) -> float:
        return 2 * np.pi / self.orbit.period

    @property
    def unknowns(self) -> np.ndarray:
        return np.append(self.orbit.z, np.log(self.angular_frequency))

    @cached_property
    def multipliers(self) -> np.ndarray:
        """The multipliers without those that are 1 by shifts."""
        values, shifts = self.orbit.multipliers()
        return np.delete(values, np.argsort(np.abs(values - 1), kind="stable")[:shifts])

    @property
    def slowest_event(self) -> float:
        """The smallest rate at which a displacement reaches its guard, relative to the range of its velocity; 1 without events."""
        sequence, ranges, slowest = self.orbit.sequence, self.orbit.sizes[self.orbit.map.size :], 1.0
        for before, segment in pairwise(sequence.segments):
            guard = None if segment.event is None or segment.event.grazing else segment.event.guard
            if guard is not None and guard.displacement.any():
                v = before.phase.V @ before.phase.flow.states(before.state, before.duration)
                slowest = min(slowest, abs(float(guard.displacement @ v)) / float(np.abs(guard.displacement) @ ranges))
        return slowest

    @property
    def count(self) -> int:
        """The number of events."""
        return sum(record.time > 0 and not record.grazing for record in self.orbit.sequence.records)


class _Branch:
    """The continuation of one branch."""

    def __init__(self, system, F: np.ndarray, frequencies: np.ndarray, periods: int):
        self.system, self.F, self.periods, self.frequencies = system, F, periods, frequencies
        self.low, self.high = float(frequencies.min()), float(frequencies.max())
        self.scale = FREQUENCY_PART * min(1.0, np.log(self.high / self.low))

    # Orbits.

    def map(self, angular_frequency: float) -> PeriodMap:
        """The map of one period of the motion, with this angular frequency of the motion."""
        w, F = self.periods * angular_frequency, self.F
        force = harmonic(F.real, angular_frequency=w)
        if F.imag.any():
            force = force + harmonic(F.imag, angular_frequency=w, phase=np.pi / 2)
        return PeriodMap(self.system, force, 2 * np.pi / angular_frequency)

    def orbit(self, u: np.ndarray, like: Orbit) -> Orbit:
        """One period from z at the frequency, both in u, begun at the same angle of the force."""
        T = 2 * np.pi / float(np.exp(u[-1]))
        map = like.map if like.period == T else self.map(2 * np.pi / T)
        return map.orbit(like.end_key, u[:-1], T, like.offset / like.period * T)

    def _by_frequency(self, orbit: Orbit) -> np.ndarray:
        """The derivative of the difference after a period with respect to the logarithm of the frequency."""
        u = np.append(orbit.z, np.log(2 * np.pi / orbit.period) + FREQUENCY_DIFFERENCE)
        return (self.orbit(u, orbit).difference - orbit.difference) / FREQUENCY_DIFFERENCE

    def scales(self, orbit: Orbit) -> np.ndarray:
        """Units of the unknowns."""
        return np.append(orbit.sizes, self.scale)

    def point(self, predicted: np.ndarray, from_: _Point, by_frequency: bool) -> _Point:
        """The point of the branch near a prediction: at its frequency, or in the plane at right angles to the tangent of another point."""
        scales = self.scales(from_.orbit)
        t = from_.tangent / scales
        t = t / np.linalg.norm(t)
        plane = np.eye(len(t))[-1] if by_frequency else t
        orbit, column, u = self.orbit(predicted, from_.orbit), None, predicted
        for number in range(CORRECTIONS):
            residual = orbit.residual(scales[:-1])
            if residual <= CLOSED_ORBIT / 100 and (number or residual <= 4 * EPS):
                if orbit.end_key != orbit.key:
                    break
                return _Point(orbit, self._tangent(orbit, scales, t), number)
            if column is None and not by_frequency:
                column = self._by_frequency(orbit)
            J = self._scaled(orbit, np.zeros(len(t) - 1) if column is None else column, scales, plane)
            if not np.isfinite(J).all():
                break
            right = np.append(-orbit.difference / scales[:-1], -plane @ ((u - predicted) / scales))
            step = np.clip(np.linalg.lstsq(J, right, rcond=UNDETERMINED)[0], -1.0, 1.0) * scales
            u = u + (np.append(step[:-1], 0.0) if by_frequency else step)
            orbit = self.orbit(u, orbit)
        raise NotUnique(f"no periodic motion found near {self.periods / orbit.period:.9g} Hz; the last residual is {residual:.3g}")

    def _scaled(self, orbit: Orbit, column: np.ndarray, scales: np.ndarray, row: np.ndarray) -> np.ndarray:
        """The derivative of the difference with respect to all unknowns, in their units, and a row below it."""
        return np.vstack([np.column_stack([orbit.jacobian(), column]) * scales / scales[:-1, None], row])

    def _tangent(self, orbit: Orbit, scales: np.ndarray, along: np.ndarray) -> np.ndarray:
        """The tangent of the branch, in the direction of another."""
        J = self._scaled(orbit, self._by_frequency(orbit), scales, along)
        tangent = np.linalg.lstsq(J, np.eye(len(J))[-1], rcond=UNDETERMINED)[0]
        return tangent / np.linalg.norm(tangent) * scales

    def at_frequency(self, between: np.ndarray, frequency_hz: float, like: Orbit) -> Orbit:
        """The closed orbit at a frequency, near u."""
        u = np.append(between[:-1], np.log(2 * np.pi * frequency_hz / self.periods))
        return newton(self.orbit(u, like))

    # The course.

    def first(self, z: np.ndarray | None) -> _Point:
        """The point at the first frequency, with the tangent towards the others."""
        w = 2 * np.pi * self.frequencies[0] / self.periods
        map = self.map(w)
        map.check_force()
        orbit = cleared(forced_orbit(map, z, np.zeros(2 * map.size)))
        direction = np.append(np.zeros(len(orbit.z)), np.sign(self.frequencies[-1] - self.frequencies[0]))
        return _Point(orbit, self._tangent(orbit, self.scales(orbit), direction))

    def followed(self, z: np.ndarray | None, most: int) -> FrequencyCurve:
        """The whole branch."""
        last = self.first(z)
        orbits, changes, step, was_rejected, end_text = [last.orbit], [], FIRST_STEP, False, ""
        while not end_text:
            try:
                following = self.point(last.unknowns + step * last.tangent, last, not was_rejected and self._is_steep(last))
                turned = self._cosine(last, following)
            except MbconstrainedError:
                following, turned = None, 0.0
            if following is None or turned < STRAIGHT:
                step, was_rejected = step / 2, True
                if step < SHORT_STEP:
                    is_last = step < SHORTEST_STEP
                    is_grazing = self._is_grazing(last, 2 * step if is_last else 0.0)
                    if is_grazing or is_last:
                        end_text, last_changes = self._end(last, is_grazing)
                        changes += last_changes
                continue
            orbits += self._between(last, following)
            changes += self._changes(last, following)
            f = self.periods / following.orbit.period
            if not self.low <= f <= self.high:
                end_text = f"the branch reaches {self.high if f > self.high else self.low:.9g} Hz"
                changes = [one for one in changes if self.low <= self.periods / one.motion.period <= self.high]
                break
            orbits.append(following.orbit)
            if len(orbits) >= most:
                end_text = f"the branch goes on after {most} points at {f:.9g} Hz; give a larger most_points"
            turned_orbit = cleared(following.orbit)
            if turned_orbit is not following.orbit:
                following = self._turned(following, turned_orbit)
            if following.corrections <= FEW:
                step = min(step * 1.5, LONGEST_STEP)
            elif following.corrections >= MANY:
                step /= 1.5
            last, was_rejected = following, False
        return FrequencyCurve(tuple(one.periodic_motion() for one in orbits), tuple(changes), self.periods, end_text)

    def _is_steep(self, *points: _Point) -> bool:
        """Whether the frequency changes along the branch so much that it determines the points."""
        parts = [point.tangent[-1] / self.scale / np.linalg.norm(point.tangent / self.scales(point.orbit)) for point in points]
        return min(parts) > STEEP or max(parts) < -STEEP

    def _cosine(self, one: _Point, other: _Point) -> float:
        scales = self.scales(one.orbit)
        a, b = one.tangent / scales, other.tangent / scales
        return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))

    def _turned(self, point: _Point, orbit: Orbit) -> _Point:
        """A point with its orbit begun at another time: the frequency along the branch changes as before."""
        orbit, direction = newton(orbit), np.append(np.zeros(len(orbit.z)), np.sign(point.tangent[-1]))
        return _Point(orbit, self._tangent(orbit, self.scales(orbit), direction), point.corrections)

    def _is_grazing(self, last: _Point, step: float) -> bool:
        """Whether an event with a jump only just takes place, or appears or disappears within a step."""
        if last.slowest_event < GENTLE and np.abs(last.multipliers).max(initial=0.0) > SENSITIVE:
            return True
        if not step:
            return False
        try:
            count = _Point(self.orbit(last.unknowns + step * last.tangent, last.orbit), last.tangent).count
        except MbconstrainedError:
            return False
        return count != last.count

    def _end(self, last: _Point, is_grazing: bool) -> tuple[str, list[Bifurcation]]:
        """Why the branch ends at a point, and the bifurcation there."""
        where = f"{self.periods / last.orbit.period:.6g} Hz"
        if is_grazing:
            text = f"near {where} an event becomes grazing: the motion changes with the square root of the frequency there"
            return f"the branch ends; {text}", [Bifurcation("grazing", last.orbit.periodic_motion(), text)]
        return f"the branch ends near {where}: no periodic motion of its kind is found beyond", []

    def _between(self, last: _Point, following: _Point) -> list[Orbit]:
        """Closed orbits at the given frequencies between two points."""
        a, b = last.unknowns, following.unknowns
        orbits = []
        for f in np.unique(self.frequencies):
            share = (np.log(2 * np.pi * f / self.periods) - a[-1]) / (b[-1] - a[-1]) if b[-1] != a[-1] else 0.0
            if 0 < share <= 1:
                try:
                    orbits.append((share, self.at_frequency(a + share * (b - a), f, following.orbit)))
                except MbconstrainedError:
                    continue  # too near to a fold
        return [orbit for _, orbit in sorted(orbits, key=lambda one: one[0])]

    # Changes along the branch.

    def _changes(self, a: _Point, b: _Point) -> list[Bifurcation]:
        """Bifurcations between two points."""
        changes: list[tuple[float, Bifurcation]] = []
        if a.count != b.count:
            share, point = self._count_change(a, b)
            f = self.periods / point.orbit.period
            text = f"at {f:.9g} Hz the number of events in a period changes from {a.count} to {b.count}"
            changes.append((share, Bifurcation("grazing", point.orbit.periodic_motion(), text)))
        for kind, test in TESTS.items():
            found = {one.kind for _, one in changes}
            if (kind == "branch point" and "fold" in found) or (
                kind == "torus" and (found - {"grazing"} or _outside(a) == _outside(b))
            ):
                continue
            own = self._located(a, b, test)
            if own is not None:
                share, point = own
                text = f"at {self.periods / point.orbit.period:.9g} Hz: {MEANINGS[kind]}"
                changes.append((share, Bifurcation(kind, point.orbit.periodic_motion(), text)))
        return [one for _, one in sorted(changes, key=lambda pair: pair[0])]

    def _at(self, known: dict[float, _Point], share: float) -> _Point:
        """The point at a share of a step, from the nearest known ones around it."""
        if share not in known:
            low = max(one for one in known if one < share)
            high = min(one for one in known if one > share)
            a, b = known[low].unknowns, known[high].unknowns
            by_frequency = self._is_steep(known[low], known[high])
            known[share] = self.point(a + (share - low) / (high - low) * (b - a), known[0.0], by_frequency)
        return known[share]

    def _located(self, a: _Point, b: _Point, test) -> tuple[float, _Point] | None:
        """The point between two at which a function vanishes; None where it has one sign, or jumps."""
        values = test(a), test(b)
        if values[0] * values[1] >= 0:
            return None
        from scipy.optimize import brentq

        known: dict[float, _Point] = {0.0: a, 1.0: b}
        try:
            share = brentq(lambda share: test(self._at(known, share)), 0.0, 1.0, xtol=LOCATED_CHANGE, rtol=4 * EPS)
        except MbconstrainedError:
            return None
        point = self._at(known, share)
        if abs(test(point)) > JUMPED * max(map(abs, values)):
            return None  # it jumps where the events change
        return share, point

    def _count_change(self, a: _Point, b: _Point) -> tuple[float, _Point]:
        """The last point with as many events as the first of two."""
        known, low, high = {0.0: a, 1.0: b}, 0.0, 1.0
        while high - low > SHORTEST_STEP:
            middle = (low + high) / 2
            try:
                point = self._at(known, middle)
            except MbconstrainedError:
                break
            low, high = (middle, high) if point.count == a.count else (low, middle)
        return low, known[low]


#: Functions that vanish at a point of each kind: the change of the frequency along the tangent, and products over the multipliers.
TESTS: Mapping[Kind, Callable[[_Point], float]] = {
    "fold": lambda point: float(point.tangent[-1]),
    "flip": lambda point: float(np.prod(1 + point.multipliers).real),
    "branch point": lambda point: float(np.prod(1 - point.multipliers).real),
    "torus": lambda point: float(np.abs(point.multipliers).max(initial=0.0)) - 1,
}


def _outside(point: _Point) -> int:
    return int((np.abs(point.multipliers) > 1).sum())
