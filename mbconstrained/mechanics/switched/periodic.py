"""Periodic motions of switched systems by shooting, with their Floquet multipliers.

The unknown is z = (x, x') at the start of a period, and the period where nothing prescribes it. P(z), the state one period later, is
computed phase by phase in closed form; its derivative is the product of the transitions of the phases and the saltation matrices of the
events (``switched_motion.transition_matrix``), so that Newton's method converges to rounding errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from ...frequency.extrema import extrema
from ...ground.checks import counted, nearest, real_array, real_number
from ...ground.display import Displayed, TextTable, number_text
from ...ground.errors import InputError, MbconstrainedError, NotUnique, within_float64
from ...ground.tolerances import CLOSED_ORBIT, EPS, SAME_FREQUENCY, STABILITY_MARGIN, UNDETERMINED
from ...linalg.exponential import block_states
from ...signals.bohl import FreeRestarts
from ...signals.inputs import term
from ..harmonic_sums import common_rate
from ..peaks import Peaks, peaks
from .phase import STILL, Phase, Source
from .sequence import MOST_EVENTS, Key, PhaseSequence, _replaced
from .switched_motion import SwitchedMotion, SwitchEvent, transition_matrix

#: Steps of Newton's method, and halvings of one that does not bring the state nearer.
STEPS, HALVINGS = 40, 10

#: Periods that are passed through before the first step, unless the state repeats to this earlier.
TRANSIENT, SETTLED = 200, 1e-3

#: Where the state after these periods does not lead to a closed orbit, so many others do: those that are nearest to one.
TRIED = 12

#: Motions that grow by this factor in these periods are unstable: the search begins at their start.
GROWN = 1e6

#: Periods of a motion that repeats after several periods of the force, for the message.
MOST_PERIODS = 8

#: Times in a phase and in all at which a motion is sampled for its range and for its return.
SAMPLES, RETURN_SAMPLES = 8, 4000

#: A free motion returns where its distance, relative to its range, has its first minimum below this.
RETURNED = 0.1

#: Least part of the period between its start and an event, if there is a choice.
CLEARANCE = 0.05


@dataclass(frozen=True, repr=False, eq=False)
class PeriodicMotion(Displayed):
    """A motion that repeats after a period: x(t + T) = x(t), for bodies that move on, x(t + T) = x(t) + drift.

    ``x(t)`` is the displacement at any time, positive or negative.

    Attributes:
        motion: the motion over one period, from t = 0 on, a ``SwitchedMotion``.
        period: T in s.
        multipliers: Floquet multipliers, the eigenvalues of the derivative of (x, x') after a period with respect to those at its start,
            complex, shape (2 n,), the largest first; zero in directions that constraints take away.
        residual: largest difference of (x, x') before and after a period, relative to the range of each.
        drift: by how much the coordinates move on in a period, shape (n,); zero but for bodies without restoring force.

    A block on a belt that moves at v = 0.5 m/s sticks for 2 D / v and slips for 2 (pi - atan(D w / v)) / w, D the difference of both friction
    forces divided by the stiffness:

    >>> import mbconstrained as mb
    >>> model = mb.LumpedModel()
    >>> _ = model.mass("block", 1.0), model.spring("ground", "block", stiffness=4.0), model.mass("belt", 1.0)
    >>> _ = model.prescribe("belt", mb.ramp([0.5]))
    >>> _ = model.dry_friction("belt", "block", normal_force=10.0, coefficient=0.2, static_coefficient=0.4)
    >>> x = model.assemble().periodic()
    >>> x, abs(x.multipliers).round(6).tolist()
    (PeriodicMotion(period 4.03444 s, 2 events, stable), [1.0, 0.0, 0.0, 0.0])
    """

    motion: SwitchedMotion
    period: float
    multipliers: np.ndarray
    residual: float
    drift: np.ndarray
    _shifts: int = field(default=0, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates."""
        return self.motion.names

    @property
    def frequency_hz(self) -> float:
        """1 / T."""
        return 1 / self.period

    @property
    def events(self) -> tuple[SwitchEvent, ...]:
        """The switches and impacts within one period."""
        return self.motion.events

    @property
    def is_stable(self) -> bool:
        """Whether small disturbances decay: all multipliers but those of shifts in time and of free bodies are within the unit circle."""
        return bool((np.abs(self._other_multipliers) < 1 - STABILITY_MARGIN).all())

    @property
    def _other_multipliers(self) -> np.ndarray:
        """The multipliers without those that are 1 by shifts of time and of free bodies."""
        return np.delete(self.multipliers, np.argsort(np.abs(self.multipliers - 1), kind="stable")[: self._shifts])

    # Values.

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (n,)) or at times (T,) (-> (n, T)), in m or rad."""
        return self.displacement(times)

    def displacement(self, times) -> np.ndarray:
        """Return x at any time by periodic continuation.

        Args:
            times: in s, a number or shape (T,).

        Returns:
            Shape (n,) or (n, T).
        """
        turns, since = self._folded(times)
        return self.motion.displacement(since) + np.multiply.outer(self.drift, turns)

    def velocity(self, times) -> np.ndarray:
        """Return x' at any time.

        Args:
            times: in s, a number or shape (T,).

        Returns:
            Shape (n,) or (n, T).
        """
        return self.motion.velocity(self._folded(times)[1])

    def acceleration(self, times) -> np.ndarray:
        """Return x'' at any time.

        Args:
            times: in s, a number or shape (T,).

        Returns:
            Shape (n,) or (n, T).
        """
        return self.motion.acceleration(self._folded(times)[1])

    def reaction(self, times) -> np.ndarray:
        """Return the multipliers of the constraint rows of all phases at any time, zero while a row is not part of the equations.

        Args:
            times: in s, a number or shape (T,).

        Returns:
            Shape (k,) or (k, T).
        """
        return self.motion.reaction(self._folded(times)[1])

    def _folded(self, times) -> tuple[np.ndarray, np.ndarray]:
        """The number of the period of each time, and the time since its start."""
        times = real_array(times, "times")
        turns = np.floor(times / self.period)
        return turns, np.clip(times - turns * self.period, 0.0, self.period)

    def peaks(self, of: str = "displacement") -> Peaks:
        """Return the exact extrema over a period.

        Args:
            of: the quantity, as of ``Motion.peaks``.

        Returns:
            A ``Peaks``.
        """
        return peaks(self.motion, self.period, of)

    def amplitude(self, name: str) -> float:
        """Return half the difference between the largest and the smallest displacement, without the drift.

        Args:
            name: of the coordinate.

        Returns:
            In m or rad.

        Raises:
            InputError: an unknown name.
        """
        if name not in self.names:
            raise InputError(f'amplitude: there is no coordinate "{name}"{nearest(name, self.names)}')
        return float(self._amplitudes[self.names.index(name)])

    @cached_property
    def _amplitudes(self) -> np.ndarray:
        function = self.motion.function
        if self.drift.any():
            function = function + term(-self.drift / self.period, power=1).smooth
        extremes = extrema(function, 0.0, self.period)
        return (extremes.maximum - extremes.minimum) / 2

    # Display.

    def _summary(self) -> str:
        stability = "stable" if self.is_stable else "not asymptotically stable"
        return f"period {number_text(self.period)} s, {counted(len(self.events), 'event')}, {stability}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = tuple((number_text(one.real), number_text(one.imag), number_text(abs(one))) for one in self.multipliers)
        table = TextTable("Floquet multipliers", ("real part", "imaginary part", "modulus"), rows)
        return table, self.motion.event_table()

    def to_dict(self) -> dict:
        """The period, the multipliers as pairs of real and imaginary parts, amplitudes and times of events as plain data, in SI.

        Returns:
            A dictionary for JSON.
        """
        return {
            "period": self.period,
            "frequency_hz": self.frequency_hz,
            "is_stable": self.is_stable,
            "multipliers": [[one.real, one.imag] for one in self.multipliers.tolist()],
            "residual": self.residual,
            "amplitudes": dict(zip(self.names, self._amplitudes.tolist())),
            "drift": dict(zip(self.names, self.drift.tolist())),
            "displacement": dict(zip(self.names, self.motion.initial[0].tolist())),
            "velocity": dict(zip(self.names, self.motion.initial[1].tolist())),
            "events": [{"time": e.time, "text": e.text, "before": e.before, "after": e.after} for e in self.events],
        }


class PeriodMap:
    """z after a period T, None where it is not prescribed, from z at its start, which may be at any time of that of the force."""

    def __init__(self, system, force, period: float | None):
        self.system, self.force, self.period = system, force, period
        self.source = system._source(force)
        self.size = system.system.size
        self.changes = [(change, place) for place, switch in enumerate(system.switches) for change in switch.times]
        self.shifts = _Shifts(system, self.source)
        self.phases: dict[Key, Phase] = {}
        self._longest = 0.0

    @cached_property
    def is_smooth(self) -> bool:
        """Whether the force, and what changes at given times, has no time at which a period would have to start."""
        return not (len(self.source.knots) > 1 or any(map(len, self.source.loads.values())) or self.changes)

    def rates_of_force(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the force and the signals at a time, shape (rows, m), those of signals from the first on; and their sizes.

        They vanish from an order up to the second on, at all times, where as many as there are states do so after it.
        """
        source = self.source
        G, w, listed, sizes = source.generator, source.at(time), [], []
        for _ in range(len(w) + 2):
            listed.append(source.coefficients @ w)
            sizes.append(np.abs(source.coefficients).max(axis=1) * np.abs(w).max())
            w = G @ w
        rates = np.array(listed).T
        rates[[source.place(signal).start for signal in self.shifts.signals], 0] = 0.0
        return rates, np.array(sizes).T

    @cached_property
    def is_autonomous(self) -> bool:
        """Whether no time is distinguished from others."""
        rates = self.rates_of_force(0.0)[0]
        moving = [self.source.place(signal).start for signal in self.shifts.signals]
        later = rates[:, 1:].copy()
        later[moving, :1] = 0.0
        return self.is_smooth and not later.any()

    def force_period(self) -> float:
        """The common period of harmonic forces, or an InputError."""
        rates = np.linalg.eigvals(self.source.generator)
        if self.is_smooth and not rates.real.any() and (base := common_rate(np.abs(rates.imag))):
            return 2 * np.pi / base
        raise InputError("period: found none; the force does not tell it: give the period in s after which it repeats")

    def check_force(self) -> None:
        """Raise an InputError where the force does not repeat after the period."""
        T = self.period
        late = [change.time for change, _ in self.changes if change.time > T * (1 + SAME_FREQUENCY)]
        knots = self.source.knots
        if knots[-1] > T * (1 + SAME_FREQUENCY) or late:
            latest = max(float(knots[-1]), *late, 0.0)
            raise InputError(
                f"period: the force or a transition changes at {latest:g} s; expected that within the period of {T:g} s"
            )
        if len(knots) == 1 and not any(map(len, self.source.loads.values())):
            (before, size), (after, _) = self.rates_of_force(0.0), self.rates_of_force(T)
            if (np.abs(before - after) > np.sqrt(EPS) * size).any():
                raise InputError(f"period: the force does not repeat after {T:g} s; give a multiple of its period")
            if self.shifts.between(self.source.at(0.0), self.source.at(T)) is None:
                raise InputError(
                    "period: a prescribed displacement does not repeat, and what it is connected with cannot move on with it"
                )

    def run(self, key: Key, z: np.ndarray, period: float, offset: float = 0.0) -> PhaseSequence:
        """The phases over a time, begun at another time of the force."""
        source = self.source
        if offset:
            source = copy(source)
            source.restarts = FreeRestarts(np.zeros(1), self.source.at(offset)[:, None], 0.0, source.blocks)
        if not self._longest / 2 <= period <= 2 * self._longest:  # phases search their guards by panels of a width up to this
            self._longest, self.phases = period, {}
        sequence = PhaseSequence(self.system.machine, source, period, MOST_EVENTS)
        sequence.phases = self.phases
        sequence.run(key, z[: self.size], z[self.size :], True)
        return sequence

    def orbit(self, key: Key, z: np.ndarray, period: float, offset: float = 0.0) -> Orbit:
        """One period."""
        return Orbit(self, key, z, period, offset, self.run(key, z, period, offset))


class _Shifts:
    """Displacements d that change no force and no condition of the system: of free bodies, and of bodies with a prescribed motion."""

    def __init__(self, system, source: Source):
        n = system.system.size
        rows = [row for one in system._systems for row in one.rows if row.order == 0]
        states = [state for switch in system.switches for state in switch.states.values()]
        fixed = [one.stiffness for one in system._systems] + [row.coefficients[None] for row in rows if row.signal is None]
        fixed += [guard.displacement[None] for state in states for guard in state.guards]
        fixed += [branch.direction[None] for state in states for branch in state.branches if branch.stiffness]
        fixed += [row.rows for state in states for row in state.rows if row.level == "position"]
        moving = {row.name: row for row in rows if row.signal is not None}.values()
        self.signals = [row.signal for row in moving]  # which may move on
        self._rows = source.coefficients[[source.place(signal).start for signal in self.signals]]
        N = _null_space(np.vstack([np.zeros((1, n)), *fixed]))
        A = np.array([row.coefficients for row in moving]).reshape(-1, n) @ N
        self._matrix, self._inverse = A, np.linalg.pinv(A)
        self._solved = N @ self._inverse
        self.free = N @ _null_space(A)  # a basis of the shifts without those of prescribed motions, shape (n, f)

    def between(self, first: np.ndarray, last: np.ndarray) -> np.ndarray | None:
        """The shift by a change of the states of the force, shape (n,); None where there is none."""
        moved = self._rows @ (last - first)
        size = np.abs(self._rows).max(axis=1, initial=0.0) * np.abs([first, last]).max(initial=0.0)
        moved[np.abs(moved) <= np.sqrt(EPS) * size] = 0.0
        rest = moved - self._matrix @ (self._inverse @ moved)
        fits = (np.abs(rest) <= np.sqrt(EPS) * np.abs(moved).max(initial=0.0)).all()
        return self._solved @ moved if fits else None


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the null space, rows brought to one size."""
    size = np.abs(matrix).max(axis=1, initial=0.0)
    return scipy.linalg.null_space(matrix[size > 0] / size[size > 0, None]) if size.any() else np.eye(matrix.shape[1])


class Orbit:
    """One period from a state, and how far it is from its start."""

    def __init__(self, map: PeriodMap, key: Key, z: np.ndarray, period: float, offset: float, sequence: PhaseSequence):
        self.map, self.key, self.z, self.period, self.offset, self.sequence = map, key, z, period, offset, sequence
        n, last = map.size, sequence.segments[-1]
        self.last, y = last.phase, last.phase.flow.states(last.state, last.duration)
        self.end = np.concatenate([self.last.C @ y, self.last.V @ y])
        self.rate = np.concatenate([self.last.V @ y, self.last.V @ (self.last.J @ y)])
        self.end_key = sequence.key
        for change, place in map.changes:
            if abs(change.time - period) <= SAME_FREQUENCY * period and (
                not change.sources or self.end_key[place] in change.sources
            ):
                self.end_key = _replaced(self.end_key, place, change.target)
        source = map.source
        shift = map.shifts.between(source.at(offset), source.at(offset + period)) if map.is_smooth else None
        self.moved = np.zeros(2 * n)
        if shift is not None:
            self.moved[:n] = shift
            drift_rate = map.shifts.between(np.zeros(len(source.at(offset))), source.generator @ source.at(offset))
            if drift_rate is not None:
                self.rate[:n] -= drift_rate
        difference = self.end - z - self.moved
        free = map.shifts.free
        self.moved[:n] += free @ (free.T @ difference[:n])
        self.difference = self.end - z - self.moved

    @cached_property
    def matrix(self) -> np.ndarray:
        """The derivative of the state after a period with respect to z."""
        return transition_matrix(self.sequence)

    @cached_property
    def samples(self) -> np.ndarray:
        """z at some times of each phase, shape (2 n, N)."""
        return states_over(self.sequence, SAMPLES)[1]

    @cached_property
    def sizes(self) -> np.ndarray:
        """The range of each coordinate and velocity, that of others where it is at rest, shape (2 n,)."""
        n, size = self.map.size, np.ptp(np.column_stack([self.samples, self.z]), axis=1)
        for part in (slice(0, n), slice(n, 2 * n)):
            own = size[part]
            own[own <= np.sqrt(EPS) * own.max()] = own.max() or 1.0
        return size

    def residual(self, sizes: np.ndarray) -> float:
        """The largest difference after a period, relative to sizes."""
        worst = float(np.abs(self.difference / sizes).max())
        return worst if np.isfinite(worst) else np.inf

    def jacobian(self) -> np.ndarray:
        """The derivative of the difference with respect to z."""
        result, n, free = self.matrix - np.eye(2 * self.map.size), self.map.size, self.map.shifts.free
        result[:n] -= free @ (free.T @ result[:n])
        return result

    def multipliers(self) -> tuple[np.ndarray, int]:
        """The Floquet multipliers, the largest first, and the number of those that are 1 by shifts."""
        n, free, phase = self.map.size, self.map.shifts.free, self.last
        size = self.sizes
        M = self.matrix * size / size[:, None]
        project = phase.entry_map() * size / size[:, None]
        kept = round(float(np.trace(project)))
        shifts = [np.vstack([free, np.zeros_like(free)])]
        if self.map.is_autonomous:
            shifts.append(self.rate[:, None])
        S = np.hstack(shifts) / size[:, None]
        S = S[:, np.linalg.norm(S, axis=0) > 0]
        S = S[:, np.linalg.norm(M @ S - S, axis=0) <= np.sqrt(EPS) * np.linalg.norm(S, axis=0)]
        Q, R = np.linalg.qr(S) if S.size else (S, S)
        Q = Q[:, np.abs(np.diag(R)) > UNDETERMINED] if S.size else S
        basis = np.linalg.svd(project)[0][:, :kept]
        rest = np.linalg.svd(basis - Q @ (Q.T @ basis))[0][:, : kept - Q.shape[1]]
        own = np.linalg.eigvals(rest.T @ M @ rest)
        values = np.concatenate([np.ones(Q.shape[1]), own, np.zeros(2 * n - kept)]).astype(complex)
        return values[np.argsort(-np.abs(values), kind="stable")], Q.shape[1]

    def periodic_motion(self) -> PeriodicMotion:
        """The motion over the period of the force from its start, once the orbit is closed."""
        multipliers, shifts = self.multipliers()
        own, key, z = self, self.key, self.z
        if self.offset:
            since = self.period - self.offset
            key, z = along(self.map, self.sequence, since, self.offset, 0.0)
            own = self.map.orbit(key, z, self.period)
            own = own if own.end_key == own.key else self.map.orbit(own.end_key, z, self.period)
        if own.sequence.deadlines:
            raise InputError(
                "periodic: the dwell of a transition runs at the start of the period, from where the motion cannot be continued; give "
                "the force another phase"
            )
        n = self.map.size
        z = np.where(np.abs(z) <= STILL * self.sizes, 0.0, z)  # what is stuck or touches is so exactly
        motion = self.map.system._motion(own.sequence, z.reshape(2, n), self.map.force)
        drift = np.where(np.abs(own.moved[:n]) <= CLOSED_ORBIT * self.sizes[:n], 0.0, own.moved[:n])
        return PeriodicMotion(motion, self.period, multipliers, own.residual(self.sizes), drift, shifts)


def states_over(sequence: PhaseSequence, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Times and z there, ``count`` in each phase."""
    times, states = [], []
    for segment in sequence.lasting:
        since = np.linspace(0.0, segment.duration, count)
        y = block_states(segment.phase.blocks, np.tile(segment.state[:, None], count), since)
        times.append(segment.time + since)
        states.append(np.vstack([segment.phase.C @ y, segment.phase.V @ y]))
    return np.concatenate(times), np.hstack(states)


def along(map: PeriodMap, sequence: PhaseSequence, time: float, offset: float = 0.0, turned: float = 0.0) -> tuple[Key, np.ndarray]:
    """The phase and z just after a time of a sequence that began at an offset, for a start at another, with prescribed displacements there."""
    segment = [one for one in sequence.lasting if one.time <= time][-1]
    y = segment.phase.flow.states(segment.state, time - segment.time)
    z = np.concatenate([segment.phase.C @ y, segment.phase.V @ y])
    shift = map.shifts.between(map.source.at(turned), map.source.at(offset + time))
    if shift is not None:
        z[: map.size] -= shift
    return segment.phase.key, z


# The search.


def find_periodic(system, period, guess, force, begin: np.ndarray | None = None) -> PeriodicMotion:
    """The periodic motion near a guess, or near the motion after some periods that begins with these values, by default zeros."""
    T = None if period is None else real_number(period, "period", positive=True)
    start = None if guess is None else start_of(system, guess)
    with within_float64():
        map = PeriodMap(system, force, T)
        begin = np.zeros(2 * map.size) if begin is None else begin
        if map.is_autonomous:
            return _free(map, T, start, begin).periodic_motion()
        map.period = T = map.force_period() if T is None else T
        map.check_force()
        return forced_orbit(map, start, begin).periodic_motion()


def start_of(system, guess) -> np.ndarray:
    """z from the forms of a guess."""
    own, n = system.system, system.system.size
    if isinstance(guess, PeriodicMotion):
        return guess.motion.initial[:2].ravel()
    if isinstance(guess, Mapping):
        if set(guess) <= {"displacement", "velocity"}:
            return own._start(guess.get("displacement"), guess.get("velocity")).ravel()
        return own._start(guess, None).ravel()
    if (
        isinstance(guess, (tuple, list))
        and len(guess) == 2
        and not all(np.ndim(one) == 0 and not isinstance(one, Mapping) for one in guess)
    ):
        return own._start(*guess).ravel()
    values = real_array(guess, "guess")
    if values.size not in (n, 2 * n):
        raise InputError(f"guess: found shape {values.shape}; expected displacement and velocity, shape (2, {n})")
    return np.concatenate([values.ravel(), np.zeros(2 * n - values.size)])


def forced_orbit(map: PeriodMap, start: np.ndarray | None, begin: np.ndarray) -> Orbit:
    """The closed orbit with a given period, near a start if there is one, or else near the motion after some periods."""
    T, z = map.period, begin if start is None else start
    key = map.system._first_key(z[: map.size], z[map.size :])
    if start is not None:
        try:
            return newton(map.orbit(key, z, T))
        except NotUnique:
            start = None  # the state after some periods may be nearer
    orbits = [map.orbit(key, z, T)]
    for _ in range(TRANSIENT):
        last = orbits[-1]
        orbits.append(map.orbit(last.end_key, last.end - last.moved, T))
        if orbits[-1].residual(orbits[-1].sizes) <= SETTLED and orbits[-1].end_key == orbits[-1].key:
            break
        if (orbits[-1].sizes > GROWN * orbits[0].sizes.max()).any():
            orbits = orbits[:1]
            break
    try:
        return newton(cleared(orbits[-1]) if map.is_smooth else orbits[-1])
    except NotUnique as problem:
        for orbit in sorted(orbits[:-1], key=lambda one: one.residual(one.sizes))[:TRIED]:
            try:
                return newton(cleared(orbit) if map.is_smooth else orbit)
            except NotUnique:
                continue
        for count in range(2, min(MOST_PERIODS + 1, len(orbits))):
            if np.abs((orbits[-1].z - orbits[-1 - count].z) / orbits[-1].sizes).max() <= SETTLED:
                raise NotUnique(f"{problem}; after {count} periods the motion repeats: try period={count * T:.12g}") from None
        raise


def cleared(orbit: Orbit) -> Orbit:
    """The orbit begun in the middle of the longest time between events, if one is near its start."""
    T = orbit.period
    times = np.array([record.time for record in orbit.sequence.records if record.time > 0])
    if not len(times) or min(times[0], T - times[-1]) >= CLEARANCE * T:
        return orbit
    gaps = np.diff([*times, times[0] + T])
    place = int(gaps.argmax())
    since = (times[place] + gaps[place] / 2) % T
    turned = (orbit.offset + since) % T
    key, z = along(orbit.map, orbit.sequence, since, orbit.offset, turned)
    return orbit.map.orbit(key, z, T, turned)


def newton(orbit: Orbit, free_period: bool = False) -> Orbit:
    """The closed orbit near an orbit, by Newton's method in the least-squares sense, or a NotUnique with the residual."""
    map, settled = orbit.map, False
    for _ in range(STEPS):
        sizes = orbit.sizes
        residual = orbit.residual(sizes)
        if (settled or residual <= 4 * EPS) and orbit.end_key == orbit.key:
            break
        J = orbit.jacobian() * sizes / sizes[:, None]
        if free_period:
            J = np.column_stack([J, orbit.rate / sizes * orbit.period])
        if not np.isfinite(J).all():
            break
        step = np.linalg.lstsq(J, -orbit.difference / sizes, rcond=UNDETERMINED)[0]
        better = _shorter_step(orbit, step, sizes, residual)
        if better is None:
            break
        settled = better.residual(sizes) > residual / 2 and residual <= CLOSED_ORBIT
        orbit = better
    residual = orbit.residual(orbit.sizes)
    if residual > CLOSED_ORBIT:
        raise NotUnique(
            f"no periodic motion found: the last residual is {residual:.3g} relative to the range of the motion, at a period of "
            f"{orbit.period:.9g} s with {counted(len(orbit.sequence.records), 'event')}; give a guess nearer to it, or another period"
        )
    for _ in range(2):
        if orbit.end_key == orbit.key:
            return orbit
        orbit = map.orbit(orbit.end_key, orbit.z, orbit.period, orbit.offset)
    machine = map.system.machine
    raise NotUnique(
        f"the state repeats after {orbit.period:.9g} s (residual {residual:.3g}), the phase does not: {machine.label(orbit.key)} at the "
        f"start, {machine.label(orbit.end_key)} after a period; try twice the period"
    )


def _shorter_step(orbit: Orbit, step: np.ndarray, sizes: np.ndarray, residual: float) -> Orbit | None:
    """The orbit after a step, halved until the residual is less; None where it does not become less."""
    n2 = len(sizes)
    for halving in range(HALVINGS):
        part = step / 2**halving
        period = orbit.period * float(np.exp(np.clip(part[n2], -0.5, 0.5))) if len(part) > n2 else orbit.period
        try:
            tried = orbit.map.orbit(orbit.end_key, orbit.z + part[:n2] * sizes, period, orbit.offset)
        except MbconstrainedError:
            continue
        if tried.residual(sizes) < residual or (
            residual <= CLOSED_ORBIT and halving == 0 and tried.residual(sizes) <= CLOSED_ORBIT
        ):
            return tried
    return None


def _free(map: PeriodMap, period: float | None, start: np.ndarray | None, begin: np.ndarray) -> Orbit:
    """The closed orbit of a motion without a prescribed period."""
    n, z = map.size, begin if start is None else start
    key = map.system._first_key(z[:n], z[n:])
    if start is not None and period is not None:
        return _moving(newton(map.orbit(key, z, period), free_period=True))
    longest = period or _slowest(map, key)
    if start is None:
        sequence = map.run(key, z, TRANSIENT / 2 * longest)
        time = sequence.end - 4 * longest
        key, z = along(map, sequence, _middle(sequence, time))
    sequence = map.run(key, z, 8 * longest)
    orbit = map.orbit(key, z, period or _return_time(map, sequence, z))
    return _moving(newton(orbit, free_period=True))


def _middle(sequence: PhaseSequence, time: float) -> float:
    """The middle of the longest phase after a time."""
    late = [segment for segment in sequence.segments if segment.time + segment.duration > time]
    longest = max(late, key=lambda segment: segment.duration - max(time - segment.time, 0.0))
    begin = max(longest.time, time)
    return begin + (longest.time + longest.duration - begin) / 2


def _slowest(map: PeriodMap, key: Key) -> float:
    """The period of the slowest oscillation of the given systems and of the first phase."""
    systems = [*map.system._systems, map.system.machine.system_of(key)[0]]
    rates = np.concatenate([one.modes().natural_frequencies for one in systems])
    if not len(rates):
        raise InputError("period: found none, and no oscillation of a phase to estimate it from; give an approximation")
    return 2 * np.pi / float(rates.min())


def _return_time(map: PeriodMap, sequence: PhaseSequence, z: np.ndarray) -> float:
    """The time at which a motion first comes back near its start."""
    count = max(SAMPLES, RETURN_SAMPLES // max(len(sequence.segments), 1))
    times, states = states_over(sequence, count)
    n = map.size
    moved = np.array(
        [shift if (shift := map.shifts.between(map.source.at(0.0), map.source.at(t))) is not None else np.zeros(n) for t in times]
    )
    away = states - z[:, None]
    away[:n] -= moved.T
    away[:n] -= map.shifts.free @ (map.shifts.free.T @ away[:n])
    size = np.ptp(states, axis=1)
    size[:n] = np.ptp(away[:n], axis=1)
    size[size <= np.sqrt(EPS) * size.max()] = np.inf
    distance = np.abs(away / size[:, None]).max(axis=0)
    left = int(np.argmax(distance > distance.max() / 2))
    near = [i for i in range(max(left, 1), len(times) - 1) if distance[i - 1] >= distance[i] <= distance[i + 1]]
    first = next((i for i in near if distance[i] <= RETURNED), None)
    if first is None:
        first = min(near, key=lambda i: distance[i], default=None)
    if first is None or times[first] <= 0:
        raise NotUnique("no periodic motion found: the motion does not return to its start; give a guess and an approximate period")
    return float(times[first])


def _moving(orbit: Orbit) -> Orbit:
    """The orbit, or a NotUnique where it is a state of rest."""
    n, ranges = orbit.map.size, np.ptp(orbit.samples, axis=1)
    is_slow = np.linalg.norm(orbit.rate) <= CLOSED_ORBIT * np.linalg.norm(orbit.sizes[n:]) and ranges.max() <= CLOSED_ORBIT
    noise = EPS**0.75 * np.abs(orbit.samples[:n]).max()  # about a position of rest, as under a weight
    if is_slow or ((ranges[:n] <= noise).all() and (ranges[n:] * orbit.period <= noise).all()):
        raise NotUnique("no periodic motion found: the search ended in a state of rest; give a guess of the motion")
    return orbit
