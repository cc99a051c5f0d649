"""The motion of a mechanical system: a response that knows its coordinates, units, reactions and energy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial, reduce
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..exchange.trajectories import RATES, Curves
from ..ground.checks import counted, nearest, real_array, whole_number
from ..ground.errors import InputError, within_float64
from ..ground.named_arrays import named_array
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, noise_of
from ..ground.units import force_unit, impulse_unit, rate_unit
from ..linalg.rank import Noisy
from ..response.choose import Request
from ..response.estimate import error_estimate
from ..response.events import Event, without_zeros
from ..response.methods.proved import ProvedFunction, proved_event
from ..response.problem import Problem
from ..response.response import Response
from ..response.response_notices import later_notices, remaining_notices, sides
from ..signals.bohl import BohlFunction, BohlSum
from ..signals.impulsive import ExactTerm, ImpulsiveLoad, ImpulsiveSmooth
from ..signals.inputs import zero
from .channels import reference
from .energy import Energy, energy_of
from .equations import EquationsOfMotion

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse
    from ..exact.enclosure.intervals import Enclosure
    from ..response.methods.defect import Rounding
    from .constraints import ConstraintRow
    from .peaks import Peaks


# Constraint forces of a motion: the regular multipliers as a function of time, and their impulses at t = 0 and later.
#
# The force that the constraints exert is L = M x'' + C x' + K x - f = A^T lambda, and lambda = G L with G A^T = I.
# As a distribution on [0, inf), its transform taken from 0-, x' has in addition to its regular part the jump of x times
# delta, x'' the jump of x' times delta and the jump of x times delta', and every impulse c_k delta^(k) of x itself
# is differentiated along: for delta^(p)
#
#     L_p = M (jump of x' if p = 0; jump of x if p = 1; c_(p-2)) + C (jump of x if p = 0; c_(p-1)) + K c_p - f_p.
#
# The same holds at the time of an event. All events are computed at once, each a column of the arrays.


class FunctionSum(BohlSum):
    """A sum of functions, each evaluated by its own method."""

    state_count = property(lambda self: max(term.state_count for term in self.terms))
    summed_from = property(lambda self: np.min([term.summed_from for term in self.terms], axis=0))

    def _values(self, times) -> np.ndarray:
        return sum((term._values(times) for term in self.terms[1:]), self.terms[0]._values(times))

    def derivative(self, order: int = 1) -> BohlFunction:
        return FunctionSum(tuple(term.derivative(order) for term in self.terms))

    def mapped(self, matrix) -> BohlFunction:
        return FunctionSum(tuple(term.mapped(matrix) for term in self.terms))

    def rows(self, indices) -> BohlFunction:
        return FunctionSum(tuple(term.rows(indices) for term in self.terms))

    def __mul__(self, factor: float) -> BohlFunction:
        return FunctionSum(tuple(term * factor for term in self.terms))

    __rmul__ = __mul__


def reaction_function(system: EquationsOfMotion, response: Response, applied: ImpulsiveSmooth) -> BohlFunction:
    """The regular part of lambda = G (K x + C x' + M x'' - f) for t > 0."""
    G = system.multiplier_map
    inertial = response.function.differential(*(G @ matrix for matrix in (system.stiffness, system.damping, system.mass)))
    if system.delayed:
        from ..response.methods.method_of_steps import past_force, with_delayed

        inertial = with_delayed(inertial, response.function, [term.mapped(G) for term in system.delayed])
        applied = _with_delayed_loads(system, response, applied + past_force(system.delayed, response.problem.past, system.size))
    return inertial if applied.smooth.is_zero else FunctionSum((inertial, applied.smooth.mapped(-G)))


def reaction_impulses(system: EquationsOfMotion, response: Response, applied: ImpulsiveSmooth) -> tuple[ImpulsiveLoad, ...]:
    """The impulses of lambda at t = 0 and later, by ascending time; none at times without one."""
    n, none = system.size, Event(0.0, np.zeros_like(response.jump), ())
    applied = _with_delayed_loads(system, response, applied)
    events = {0.0: Event(0.0, response.jump, response.impulses), **{event.time: event for event in response.events}}
    loads = {0.0: applied.impulses, **{load.time: load.impulses for load in applied.later}}
    times = sorted({*events, *loads})
    each = [events.get(time, none) for time in times]
    if not any(event.jump.any() or event.impulses for event in each) and not any(loads.values()):
        return ()
    # a jump at t = 0 is as inaccurate as the values that it is the difference of, a later one as the largest of its event
    sizes = np.array([np.abs(event.jump).max(axis=1, keepdims=True) + 0 * event.jump for event in each])
    sizes[0] = np.abs(response.initial) + np.abs(response.start)
    jumps = np.array([event.jump for event in each])
    noise = EPS * np.where(jumps != 0, sizes, 0.0)
    x = [Noisy(jumps[:, order].T, noise[:, order].T) for order in (0, 1)]
    own, force = (_by_order(impulses, n) for impulses in ([e.impulses for e in each], [loads.get(time, ()) for time in times]))
    parts = [(system.mass, [x[1], x[0], *own]), (system.damping, [x[0], *own]), (system.stiffness, own), (-np.eye(n), force)]
    total = []
    for order in range(max(len(factors) for _, factors in parts)):
        terms = [Noisy.rounded(matrix) @ factors[order] for matrix, factors in parts if order < len(factors)]
        total.append((Noisy.rounded(system.multiplier_map) @ reduce(Noisy.__add__, terms)).cleaned())
    impulses = [without_zeros([impulse[:, k] for impulse in total]) for k in range(len(times))]
    return tuple(ImpulsiveLoad(time, own) for time, own in zip(times, impulses) if own)


def _with_delayed_loads(system: EquationsOfMotion, response: Response, applied: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """The forces with the impulses of delayed terms, one delay after jumps and impulses of x."""
    if not system.delayed:
        return applied
    from ..response.methods.method_of_steps import delayed_impulses

    later = []
    for event in (Event(0.0, response.jump, response.impulses), *response.events):
        for term in system.delayed:
            impulses = delayed_impulses(term, event.jump, event.impulses)
            if any(impulse.any() for impulse in impulses):
                later.append(ImpulsiveLoad(float(Fraction(repr(event.time)) + term.decimal), tuple(impulses)))
    return applied + ImpulsiveSmooth(zero(system.size).smooth, (), tuple(later)) if later else applied


def _by_order(impulses, size) -> list[Noisy]:
    """Arrays (n, K) of the impulses of K events, one for each order of derivative."""
    count = max(map(len, impulses), default=0)
    none = np.zeros(size)
    return [Noisy.rounded(np.array([own[k] if k < len(own) else none for own in impulses]).T) for k in range(count)]


Quantity = Literal["displacement", "velocity", "acceleration", "reaction"]


class SystemMotion:
    """Quantities common to one motion and several motions of a system; t = 0 means 0+."""

    system: EquationsOfMotion

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates, in the order of the rows of x."""
        return self.system.names

    def displacement(self, times, relative_to: str | None = None) -> np.ndarray:
        """x(t), equal to a call of the motion.

        Args:
            times: in s, a number or shape (T,), t >= 0; t = 0 means 0+.
            relative_to: a coordinate or a constraint row, such as a prescribed motion: its value a x is subtracted from the
                coordinates of its unit; "ground" for none.

        Returns:
            Shape (n,) or (n, T), in m or rad; of S motions (S, n) or (S, n, T).

        Raises:
            InputError: times that are negative or not finite; an unknown coordinate or row.
            Overflow: a value leaves the range of float64.

        >>> from mbconstrained import MechanicalSystem
        >>> oscillator = MechanicalSystem([[1.0]], stiffness=[[4.0]])
        >>> bool(np.isclose(oscillator.solve([1.0]).displacement(0.5)[0], np.cos(1.0)))
        True
        """
        return self._relative(self._rate(0, times), relative_to)

    def velocity(self, times, relative_to: str | None = None) -> np.ndarray:
        """x'(t).

        Args:
            times, relative_to: as ``displacement``.

        Returns:
            In m/s or rad/s, of the shape of ``displacement``.
        """
        return self._relative(self._rate(1, times), relative_to)

    def acceleration(self, times, relative_to: str | None = None) -> np.ndarray:
        """x''(t).

        Args:
            times, relative_to: as ``displacement``.

        Returns:
            In m/s^2 or rad/s^2, of the shape of ``displacement``.
        """
        return self._relative(self._rate(2, times), relative_to)

    def _relative(self, values: np.ndarray, relative_to: str | None) -> np.ndarray:
        if relative_to is None:
            return self._named(values)
        system, other = self.system, reference(self.system, relative_to)  # I - e a, e the coordinates of the unit of a x
        matrix = np.eye(system.size) - np.outer([own == other.unit for own in system.units.values()], other.direction)
        along = np.moveaxis(values, self._coordinate_axis, 0)
        return self._named(np.moveaxis(np.tensordot(matrix, along, 1), 0, self._coordinate_axis))

    def _named(self, values: np.ndarray) -> np.ndarray:
        return named_array(values, *[()] * self._coordinate_axis, self.names)

    def energy(self, times) -> Energy:
        """Kinetic, strain and static energy at a time or at times (T,), in J; of S motions of shape (S,) or (S, T)."""
        displacement, velocity = (np.moveaxis(x, self._coordinate_axis, 0) for x in self._states(times))
        return energy_of(self.system.given, self.system.static_force, displacement, velocity)

    _coordinate_axis = 0

    def _states(self, times) -> tuple[np.ndarray, np.ndarray]:
        """x and x'."""
        return self._rate(0, times), self._rate(1, times)

    def _rate(self, order: int, times) -> np.ndarray:
        return self.derivative(order)(times) if order else self(times)  # type: ignore[attr-defined]


@dataclass(frozen=True, repr=False, eq=False)
class Motion(SystemMotion, Response):
    """x(t) of a mechanical system, a ``Response`` of the constrained form; t = 0 means 0+, the time of an event its right limit.

    Attributes:
        system: the system that moves.
        applied: all forces f on its n coordinates, its own included.
    """

    system: EquationsOfMotion
    applied: ImpulsiveSmooth

    _kinds = (*RATES, "reaction")

    def trajectories(self, times, kinds: Sequence[str] = RATES[:1]) -> tuple[Curves, ...]:
        """Curves of the motion at given times, reactions (multipliers of the constraint rows) included.

        Args:
            times: in s, a list of numbers.
            kinds: "displacement", "velocity", "acceleration", "reaction".

        Returns:
            Values of each kind.

        >>> from mbconstrained import MechanicalSystem
        >>> oscillator = MechanicalSystem([[1.0]], stiffness=[[4.0]], names=["cart"])
        >>> oscillator.solve([1.0]).trajectories([0.0], ["velocity"])[0].heads
        ['cart velocity (m/s)']
        """
        chosen = [kinds] if isinstance(kinds, str) else list(kinds)
        rates = super().trajectories(times, [kind for kind in chosen if kind != "reaction"])
        if "reaction" not in chosen:
            return rates
        rows = self._reaction_rows
        names, units = tuple(row.name for row in rows), tuple(force_unit(row.unit) for row in rows)
        values = self.reaction(real_array(times, "times", shape=(None,)))
        return (*rates, Curves("reaction", names, ("reaction",) * len(rows), units, values))

    _has_common_equations = True  # K and C are those of all phases

    @property
    def _reaction_rows(self) -> tuple[ConstraintRow, ...]:
        """The constraint rows in the order of the multipliers."""
        return self.system.rows

    def reaction(self, times) -> np.ndarray:
        """The multipliers lambda(t) of the constraint rows.

        M x'' + C x' + K x = f + A^T lambda: lambda_i is the force along the i-th row, in N for a row in metres and
        in N m for a row in radians. Impulses at t = 0 are in ``constraint_impulses``, later ones in
        ``later_constraint_impulses``.

        Args:
            times: in s, a number or shape (T,), t >= 0.

        Returns:
            Shape (k,) or (k, T), one row per row of ``system.rows``.

        Raises:
            InputError: times that are negative or not finite.

        >>> from mbconstrained import Constraint, MechanicalSystem
        >>> weight = MechanicalSystem([[2.0]], constraints=[Constraint([1.0])], force=[-9.81 * 2.0])  # a mass on a fixed support
        >>> weight.solve().reaction(1.0).round(6)
        array([19.62])
        """
        return named_array(self.reaction_function(times), tuple(row.name for row in self._reaction_rows))

    @cached_property
    def reaction_function(self) -> BohlFunction:
        """lambda for t > 0 in closed form, k rows."""
        return self._reaction_of(self)

    def _reaction_of(self, response: Response) -> BohlFunction:
        """Return the reaction function of another response of the system to the same forces."""
        function = reaction_function(self.system, response, self.applied)
        if response is not self or not self._is_decided_exactly:
            return function
        return ProvedFunction(function, partial(getattr, self, "_exact_reaction"), self.solution.finite_count, None)

    @cached_property
    def _constraint_loads(self) -> tuple[ImpulsiveLoad, ...]:
        loads = reaction_impulses(self.system, self, self.applied)
        if not self._is_decided_exactly:
            return loads
        none = np.zeros((len(self.initial), len(self.system.rows)))
        events = [proved_event(self._exact_reaction, Event(load.time, none, load.impulses), none) for load in loads]
        return tuple(ImpulsiveLoad(event.time, event.impulses) for event in events)

    @property
    def constraint_impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (k,); the p-th multiplies the p-th derivative of Dirac's delta in lambda (N s for p = 0, N s^2, ...)."""
        return next((load.impulses for load in self._constraint_loads if not load.time), ())

    @property
    def later_constraint_impulses(self) -> tuple[ImpulsiveLoad, ...]:
        """Return the impulses of constraint forces after t = 0: an ``ImpulsiveLoad`` with k rows for each time with impulses."""
        return tuple(load for load in self._constraint_loads if load.time)

    @cached_property
    def _with_velocity(self) -> BohlFunction:
        n = self.system.size
        return self.function.differential(np.eye(2 * n, n), np.eye(2 * n, n, -n))

    def _states(self, times) -> tuple[np.ndarray, np.ndarray]:
        n = self.system.size
        if n**2 <= np.size(times) < 4 * n**2:  # twice the rows would be evaluated by a table of all oscillations
            return super()._states(times)
        values = self._with_velocity(times)
        return values[:n], values[n:]

    def _rounding(self) -> Rounding | None:
        from .exact_motion import FormRounding

        return FormRounding.of(self.system, self.applied)

    @cached_property
    def exact(self) -> ExactResponse:
        """The exact motion of the given system, n rows, in multiplier form, without a rounded null space."""
        from .exact_motion import exact_motion

        applied = self.applied
        if self.problem.past is not None:
            from ..response.methods.method_of_steps import past_force

            applied = applied + past_force(self.system.delayed, self.problem.past, self.system.size)
        return exact_motion(self.system, self.initial, applied)

    @cached_property
    def _exact_reaction(self) -> ExactResponse:
        """The exact multipliers lambda, one per row of ``system.rows``; without values at 0-, and so without jumps."""
        n = self.system.size
        return self.exact.with_rows(range(n, n + len(self.system.rows)))

    def enclose(self, times, digits: int = 15, *, of: Quantity = "displacement", order: int = 0) -> Enclosure:
        """Return intervals that are guaranteed to contain a quantity of the motion, as ``Response.enclose``.

        Args:
            times: in s, a number or shape (T,).
            digits: significant digits of each value.
            of: displacement, velocity, acceleration or reaction.
            order: order of a derivative of it, if any.

        Returns:
            Lower and upper ends as decimal strings, shape (n,) or (n, T), of reactions (k,) or (k, T), in SI units.

        Raises:
            InputError, SingularPolynomialMatrix, Overflow: as ``Response.enclose``; an unknown quantity.
        """
        order, own = whole_number(order, "order"), _order_of(of)
        if own is None:
            return self._exact_reaction.enclose(times, digits, order=order)
        return super().enclose(times, digits, order=own + order)

    def peaks(self, end: float, of: str | Sequence[str] = "displacement", combinations=None, names=None) -> Peaks:
        """Exact extrema on [0, end] with their times.

        Args:
            end: in s.
            of: "displacement", "velocity", "acceleration", "reaction", or "elongation" or "force" of springs and dampers by name; or a
                name or names of quantities, such as ["b - a", "force of spring", "velocity of x"].
            combinations: a matrix (p, r) of what is combined, such as the elongation of a spring.
            names: names of the combinations.

        Returns:
            ``Peaks``: ``maximum``, ``minimum``, ``largest``, and a table with the times.

        >>> from mbconstrained import MechanicalSystem
        >>> MechanicalSystem([[1.0]], None, [[4.0]]).solve(velocity=[3.0]).peaks(1.0).maximum.round(12)
        array([1.5])
        """
        from .peaks import peaks

        return peaks(self, end, of, combinations, names)

    def error_estimate(self, times, of: Quantity = "displacement", *, order: int = 0) -> float:
        """Return an estimate of max |error| / max |value| over the times, for displacement, velocity, acceleration or reaction.

        Args:
            times: in s, a number or shape (T,).
            of: the quantity.
            order: order of a derivative of it, if any.

        Returns:
            A number without unit; infinite where the error may be as large as the answer.

        Raises:
            InputError: an unknown quantity; times that are negative or not finite; an order that is no whole number of at least 0.
        """
        order, own = whole_number(order, "order"), _order_of(of)

        def view(x: Response) -> BohlFunction:
            total = order + (own or 0)
            function = x.function if own is not None else self._reaction_of(x)
            return function.derivative(total) if total else function

        estimate = error_estimate(self, times, view)
        return estimate if own is not None else max(estimate, self._cancelled_in_reactions(real_array(times, "time"), order))

    def _cancelled_in_reactions(self, times: np.ndarray, order: int) -> float:
        """Rounding errors of the terms of G (K x + C x' + M x'' - f) relative to their largest sum, at most 1."""
        values = np.abs(self.reaction_function.derivative(order)(times)).max(initial=0.0)
        if self._is_decided_exactly or not values:
            return 0.0
        rates = (np.abs(self.derivative(order + k)(times)) for k in range(3))
        sizes = sum(np.abs(A) @ x for A, x in zip((self.system.stiffness, self.system.damping, self.system.mass), rates))
        sizes = sizes + np.abs(self.applied.smooth.derivative(order)(times))
        return min(EPS * float((np.abs(self.system.multiplier_map) @ sizes).max() / values), 1.0)

    @cached_property
    @within_float64()
    def notices(self) -> tuple[Notice, ...]:
        """Violated rows, jumps, impulses, drift and doubtful decisions, with names and units; of a robot also a motion that is too
        large for linear equations."""
        return (*self._equation_notices, *self.system.range_notices(self))

    @cached_property
    @within_float64()
    def _equation_notices(self) -> tuple[Notice, ...]:
        """Notices on the equations, except on the range in which they represent the model."""
        at_start = (Event(0.0, self.jump, self.impulses), ImpulsiveLoad(0.0, self.constraint_impulses))
        return (
            *self._notices_of_system,
            *_violated_rows(self),
            *(notice for event in at_start for notice in _sentences(self, event)),
            *later_notices(self, partial(_sentences, self), partial(_kink_text, self.system), self.later_constraint_impulses),
            *self.system.damping_notices(),
            *self.force.notices,
            *_drift(self),
            *_static_offsets(self.system),
            *remaining_notices(self),
        )

    @property
    def _notices_of_system(self) -> tuple[Notice, ...]:
        """Notices on the rows and the constrained form, without doubts about ranks that the exact engine confirms.

        Rows that were left out and entries that cancel to their rounding errors remain.
        """
        own, of_form = self.system.notices, self.system.undelayed_form().notices
        ranks = [notice for notice in own if notice.doubtful and notice.kind == NoticeKind.RANK]
        if ranks and self.is_proved:
            own = tuple(replace(notice, doubtful=False) if notice in ranks else notice for notice in own)
        return (*own, *of_form)


def motion_of(
    system: EquationsOfMotion, start: np.ndarray, applied: ImpulsiveSmooth, rank_tolerance, request: Request, history=None
) -> Motion:
    """The motion from x(0-), x'(0-) in the rows of start, shape (2, n), under all forces, n rows."""
    form, delayed = system.undelayed_form(), system.delayed_equations() if system.delayed else ()
    problem = Problem.checked(form.polynomial_matrix, start, form.force(applied), rank_tolerance, delayed, history)
    x = Response._solved(problem, request)
    return Motion(x.problem, x.solution, system, applied)


def _order_of(quantity) -> int | None:
    """The order of the derivative of x that a quantity is; None for a reaction."""
    kinds = Motion._kinds
    if not isinstance(quantity, str) or quantity not in kinds:
        raise InputError(f"of: found {quantity!r}{nearest(str(quantity), kinds)}; expected one of {', '.join(kinds)}")
    return None if quantity == "reaction" else kinds.index(quantity)


# The notices of a motion, in sentences with names and units.

STATE_NAMES = ("displacement", "velocity")
DELTAS = ("a Dirac impulse", *(f"the {order} derivative of a Dirac impulse" for order in ("first", "second", "third")))


def _violated_rows(motion: Motion) -> Iterator[Notice]:
    """Rows that the values at 0- violate by more than half of the digits of the largest, in the constrained derivative or the next."""
    violated, largest = [], {}
    for row in motion.system.rows:
        for order in range(row.order, 2):
            value = float(row.right_side(order)(0.0)[0])
            actual, noise = _row_value(row, motion.initial[order])
            if abs(actual - value) > noise + noise_of(abs(value)):
                unit = rate_unit(row.unit, order)
                violated.append((row, order, actual, value, unit))
                largest[unit] = max(largest.get(unit, 0.0), abs(actual - value))
    for row, order, actual, value, unit in violated:
        if abs(actual - value) <= EPS**0.5 * largest[unit]:
            continue
        if row.signal is None:
            text = (
                f'constraint "{row.name}" ({row.level} level) is violated at 0-: its {STATE_NAMES[order]} is '
                f"{actual:.6g} {unit} instead of {value:.6g} {unit}, off by {actual - value:.6g} {unit}; it is enforced at t = 0"
            )
        else:
            text = (
                f'prescribed motion "{row.name}" ({row.level} level) starts with the {STATE_NAMES[order]} {value:.6g} {unit}, '
                f"which is {actual:.6g} {unit} at 0-: it jumps at t = 0"
            )
        yield Notice(NoticeKind.JUMP, text)


def _sentences(motion: Motion, event: Event | ImpulsiveLoad) -> Iterator[Notice]:
    """The jumps of coordinates at an event and their impulses, or the impulses of constraint forces."""
    when = f"t = {event.time:.6g} s" if event.time else "t = 0"
    if isinstance(event, Event):
        subjects = [(f"{name}: its", "displacement", unit) for name, unit in motion.system.units.items()]
        for order in np.flatnonzero(event.jump.any(axis=1)):
            before, after = sides(motion, event, order) if event.time else (motion.initial[order], motion.start[order])
            for i in np.flatnonzero(event.jump[order]):
                subject, _, unit = subjects[i]
                text = (
                    f"{subject} {STATE_NAMES[order]} jumps at {when} by {event.jump[order, i]:.6g} {rate_unit(unit, order)}, "
                    f"from {before[i]:.6g} {rate_unit(unit, order)} to {after[i]:.6g} {rate_unit(unit, order)}"
                )
                yield Notice(NoticeKind.JUMP, text)
    else:
        subjects = [(f'constraint "{row.name}": its', "force", force_unit(row.unit)) for row in motion.system.rows]
    for order, sizes in enumerate(event.impulses):
        delta = DELTAS[order] if order < len(DELTAS) else f"the derivative of order {order} of a Dirac impulse"
        for i in np.flatnonzero(sizes):
            subject, what, unit = subjects[i]
            size = f"{sizes[i]:.6g} {impulse_unit(unit, order)}"
            yield Notice(NoticeKind.IMPULSE, f"{subject} {what} contains {delta} of {size} at {when}")


def _kink_text(system: EquationsOfMotion, number: int, order: int, size: float) -> str:
    name, unit = list(system.units.items())[number]
    return f"{STATE_NAMES[order]} of {name} by {size:.6g} {rate_unit(unit, order)}"


def _drift(motion: Motion) -> Iterator[Notice]:
    """Rows at velocity and acceleration level: the position value at the start, and its rate; of records, both at the end."""
    for row in motion.system.rows:
        if row.order == 0:
            continue
        if row.signal is not None:
            yield from _drift_of_record(motion, row)
            continue
        place, _ = _row_value(row, motion.start[0])
        rate, noise = _row_value(row, motion.start[1])
        moving = f" and drifts at {rate:.6g} {row.unit}/s" if abs(rate) > noise else ""
        yield Notice(
            NoticeKind.DRIFT,
            f'constraint "{row.name}" is at {row.level} level ({counted(row.order, "drift eigenvalue")}): '
            f"its position value starts at {place + 0.0:.6g} {row.unit}{moving}; no equation corrects it",
        )


def _drift_of_record(motion: Motion, row: ConstraintRow) -> Iterator[Notice]:
    """Notice on what remains after a prescribed velocity or acceleration: of records a displacement, of all inputs a velocity.

    A displacement after an input in closed form, such as the move of a crane by a pulse of its velocity, is the one intended."""
    end = row.signal.knots[-1] if row.signal is not None else 0.0
    if not end or row.signal is None or row.signal(end).any():
        return
    place, _ = _row_value(row, motion(end))
    rate, noise = _row_value(row, motion.derivative(1)(end))
    times = np.union1d(row.signal.knots, np.linspace(0.0, end, 33))
    size = np.abs(row.coefficients) @ np.abs(motion.derivative(1)(times)).max(axis=1)
    moves = abs(rate) > max(noise, noise_of(size, len(row.signal.knots)))
    moving = f" and moves on at {rate:.6g} {rate_unit(row.unit)}" if moves else ""
    is_record = any(not isinstance(part.data, ExactTerm) for part in row.signal.exact_parts)
    if not is_record and not moves:
        return
    what, remedy = ("record", "; a baseline correction changes this") if is_record else ("input", "")
    yield Notice(
        NoticeKind.DRIFT,
        f'prescribed motion "{row.name}" ({row.level} level): at the end of the {what}, t = {end:.6g} s, the support is at {place + 0.0:.6g} '
        f"{row.unit}{moving}{remedy}",
    )


def _static_offsets(system: EquationsOfMotion) -> Iterator[Notice]:
    loads = [
        f"{name} {load:.6g} {force_unit(unit)}" for (name, unit), load in zip(system.units.items(), system.static_force) if load
    ]
    if loads:
        yield Notice(NoticeKind.STATIC_LOAD, f"constant forces from rest lengths and weights act from t = 0 on: {', '.join(loads)}")


def _row_value(row: ConstraintRow, state: np.ndarray) -> tuple[float, float]:
    """a x with its rounding noise."""
    size = np.abs(row.coefficients) @ np.abs(state)
    value = float(row.coefficients @ state)
    noise = noise_of(float(size), len(state))
    return (value if abs(value) > noise else 0.0), noise
