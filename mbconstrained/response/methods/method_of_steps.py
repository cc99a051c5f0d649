"""Responses with delays: A(d/dt) x + sum of A_j(d/dt) x(t - delay_j) = f, exact between knots (the method of steps).

With the delayed terms on the right, u = f - sum of A_j(d/dt) x(t - delay_j), the Jordan pairs of A(s) give

    w' = J w + B u,    x = C w + sum over k of H_k u^(k),    A_j(d/dt) x = C_j w + D_j v

with the states v of f, v' = J_f v. So z = (w, v) satisfies z' = G z + sum of G_j z(t - delay_j), and between two knots the chain
z(t), z(t - delay_j), z(t - delay_i - delay_j), ... is one Bohl function: its generator has G on the diagonal and G_j next to it. From
knot to knot the chain restarts with values that are known by then: nothing cancels, however many delays have passed. A member of the
chain acts on z(t) by the integral of as many products of G_j as delays separate them, over no more than the gap between knots: of
order m it is at most (|G_j| h)^m / m!, so that a finite chain is exact to rounding errors.

Sources: Bellman and Cooke, Differential-Difference Equations (1963), chapter 3; Asl and Ulsoy, J. Dyn. Sys. Meas. Control 125 (2003).
"""

from __future__ import annotations

import heapq
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import ceil, factorial

import numpy as np
import scipy

from ...ground.errors import InputError, within_float64
from ...ground.notices import Evidence, Notice
from ...ground.tolerances import EPS, noise_of
from ...linalg.exponential import block_states
from ...linalg.scaling import balanced
from ...polynomial.delayed_terms import DelayedTerm, check_retarded, feedthrough, measured_states
from ...polynomial.jordan_pairs import JordanPairs
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.bohl import BohlFunction, Restarts, restarts_at
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import zero
from ..choose import Method
from ..events import Event, start_of, without_zeros
from ..problem import Problem, states_before
from ..response_notices import pair_notices

#: |G_j| times the longest gap between knots: of one delay, and of several, whose chain has a member for each sum of delays.
REACH, REACH_OF_SEVERAL = 1.0, 0.125

#: The part of a rounding error that a chain leaves out.
LEFT_OUT = EPS / 16

#: Most states of a chain, most numbers in the states at all knots, and most matrices from knot to knot that are stored.
MOST_STATES, MOST_NUMBERS, MOST_MATRICES = 1200, 1 << 24, 64


# The equations of one interval.


@dataclass(frozen=True, eq=False)
class _DelayedEquations:
    """The driven finite part and what the delayed terms measure; w in units that balance G and the G_j.

    Attributes:
        generator: G, shape (m, m).
        inputs: B in the rows of w, shape (n, r).
        measured: C_j and D_j of each term side by side, shape (r, m).
        output: x by z without delayed terms, shape (r, m).
        infinite: H_0, H_1, ..., each of shape (r, r).
        units: of the states w.
    """

    generator: np.ndarray
    inputs: np.ndarray
    measured: tuple[np.ndarray, ...]
    output: np.ndarray
    infinite: tuple[np.ndarray, ...]
    units: np.ndarray

    @classmethod
    def of(cls, pairs: JordanPairs, terms: Sequence[DelayedTerm], force: BohlFunction) -> _DelayedEquations:
        """The equations of given pairs and the states of the force."""
        finite, highest = pairs.finite, pairs.form.highest_impulse
        C, J, B = (np.asarray(matrix, dtype=float) for matrix in (finite.C, finite.J, finite.B))
        infinite = tuple(pairs.laurent(k) for k in range(highest + 1))
        longest = max(len(term.coefficients) for term in terms)
        by_states = measured_states(pairs, terms)
        pattern = np.abs(J) + sum(np.abs(B) @ np.abs(C_j) for C_j in by_states)
        units = balanced(pattern)[1]
        J, B, C = J * units / units[:, None], B / units[:, None], C * units
        loads = [force.coefficients]
        for _ in range(highest + longest):
            loads.append(loads[-1] @ force.generator)
        through = sum(H @ load for H, load in zip(infinite, loads))
        measured = []
        for term, C_j in zip(terms, by_states):
            D = sum(feedthrough(pairs, term, k) @ load for k, load in enumerate(loads[: highest + len(term.coefficients)]))
            measured.append(np.hstack([C_j * units, D]))
        n, m = len(J), force.state_count
        G = np.block([[J, B @ loads[0]], [np.zeros((m, n)), force.generator]])
        return cls(G, B, tuple(measured), np.hstack([C, through]), infinite, units)


@dataclass(frozen=True, eq=False)
class _DelayChain:
    """z(t - s) for all sums s of delays up to a number of them.

    Attributes:
        shifts: the sums s, ascending, the first is 0.
        generator: of all members, shape (S, S).
        first_left_out: a bound of what the members of the next order would contribute, relative to the states.
    """

    shifts: tuple[Fraction, ...]
    generator: np.ndarray
    first_left_out: float

    @classmethod
    def of(cls, equations: _DelayedEquations, delays: Sequence[Fraction], reach: float) -> _DelayChain:
        """The chain for gaps between knots in which |G_j| h is at most the reach."""
        order = 1
        while reach ** (order + 1) / factorial(order + 1) > LEFT_OUT:
            order += 1
        orders = {Fraction(0): 0}
        level = [Fraction(0)]
        for number in range(1, order + 1):
            level = [s for s in {one + delay for one in level for delay in delays} if orders.setdefault(s, number) == number]
        shifts = tuple(sorted(orders))
        m, n = len(equations.generator), len(equations.inputs)
        if m * len(shifts) > MOST_STATES:
            raise InputError(
                f"delayed: {len(delays)} delays and {m} states of equations and force make a chain of {m * len(shifts)} states, more "
                f"than {MOST_STATES}; use fewer coordinates, or delays that are multiples of one"
            )
        place = {s: k for k, s in enumerate(shifts)}
        generator = np.kron(np.eye(len(shifts)), equations.generator)
        for s, own in place.items():
            for delay, measured in zip(delays, equations.measured):
                other = place.get(s + delay)
                if other is not None:
                    generator[own * m : own * m + n, other * m : (other + 1) * m] -= equations.inputs @ measured
        return cls(shifts, generator, reach ** (order + 1) / factorial(order + 1))


# From knot to knot.


class Steps:
    """The chain at its knots, computed as far as values are requested; the knots and states depend on the data alone."""

    def __init__(self, problem: Problem, pairs: JordanPairs):
        terms = problem.delayed
        check_retarded(pairs, terms)
        self.terms, self.pairs = terms, pairs
        self.force = problem.force + past_force(terms, problem.past, problem.polynomial_matrix.size)
        self.equations = equations = _DelayedEquations.of(pairs, terms, self.force.smooth)
        self.delays = tuple(term.decimal for term in terms)
        gains = [equations.inputs @ measured[:, : len(equations.inputs)] for measured in equations.measured]
        size = sum(float(np.linalg.norm(one, 2)) for one in gains if one.size)
        reach = REACH if len(terms) == 1 else REACH_OF_SEVERAL
        count = max(1, ceil(size * float(self.delays[0]) / reach)) + problem.subdivisions
        self.gap = self.delays[0] / count  # the longest between two knots
        self.chain = _DelayChain.of(equations, self.delays, min(reach, size * float(self.gap)))
        self.blocks = (self.chain.generator,)
        self._place = {s: k for k, s in enumerate(self.chain.shifts)}
        self.start = start_of(pairs.form, problem.initial, self.force)
        self._initial = problem.initial
        restarts = self.force.smooth.restarts
        remainders = np.broadcast_to(restarts.remainders, restarts.knots.shape)
        exact = [_decimal(t) + Fraction(float(rest)) for t, rest in zip(restarts.knots.tolist(), remainders.tolist())]
        self._loads = dict(zip(exact, range(len(exact))))  # the knots of the force
        self._begins = sorted({*exact, *(_decimal(load.time) for load in self.force.later)})
        self._matrices: dict[Fraction, np.ndarray | None] = {}
        self.events, self._pushed = self._all_events()
        self._knots: list[Fraction] = []
        self._index: dict[Fraction, int] = {}
        self._states: list[np.ndarray] = []
        self._members: list[np.ndarray] = []
        self._jumps: list[np.ndarray] = []
        self._known: Restarts | None = None
        self._reached = Fraction(0)
        self._append(Fraction(0), np.zeros(len(equations.generator)))

    @property
    def size(self) -> int:
        """The number of states z."""
        return len(self.equations.generator)

    def row_of(self, rows: np.ndarray, shift: Fraction = Fraction(0)) -> np.ndarray:
        """rows @ z(t - shift) as rows over the chain."""
        own = np.zeros((len(rows), len(self.chain.generator)))
        at = self._place[shift] * self.size
        own[:, at : at + self.size] = rows
        return own

    @cached_property
    def function(self) -> StepsFunction:
        """x for t > 0."""
        total = self.row_of(self.equations.output)
        for delay, measured in zip(self.delays, self.equations.measured):
            rows = self.row_of(measured, delay)
            for H in self.equations.infinite:
                if H.any():
                    total = total - H @ rows
                rows = rows @ self.chain.generator
        return StepsFunction(total, self)

    @property
    def restarts(self) -> Restarts:
        """The chain at the knots so far."""
        if self._known is None or len(self._known.knots) != len(self._knots):
            knots = np.array([float(t) for t in self._knots])
            rest = np.array([float(t - Fraction(knot)) for t, knot in zip(self._knots, knots.tolist())])
            self._known = restarts_at(knots + 1j * rest, np.array(self._members).T, np.array(self._jumps).T)
        return self._known

    def reach(self, end: float) -> None:
        """Compute the knots up to a time, and beyond the next one."""
        while self._reached <= end:
            target = max(2 * self._reached, Fraction(end) + self.gap, 4 * self.delays[-1])
            knots = len(self._knots) + float((target - self._reached) / self.gap) + len(self._begins) * len(self.chain.shifts)
            count = knots * len(self.chain.generator)
            if count > MOST_NUMBERS:
                raise InputError(
                    f"times: {end:g} s lie {float(Fraction(end) / self.gap):.3g} intervals of {float(self.gap):.3g} s after the start, each "
                    f"with {len(self.chain.generator)} states, more than memory is used for; ask for earlier times"
                )
            with within_float64():
                for time in self._between(self._reached, target):
                    z = self._advanced(len(self._knots) - 1, time)
                    self._append(time, z)
            self._reached = target

    def kinks(self, end: float) -> list[float]:
        """The times up to an end at which a derivative of x may jump, one of no order beyond that of the chain."""
        return sorted({float(own + s) for own in self._begins for s in self.chain.shifts if own + s <= end})

    def _between(self, begin: Fraction, end: Fraction) -> list[Fraction]:
        """The knots after a time up to another one."""
        first, last = begin // self.gap + 1, end // self.gap
        times = {number * self.gap for number in range(int(first), int(last) + 1)}
        for own in self._begins:
            times |= {own + s for s in self.chain.shifts if begin < own + s <= end}
        return sorted(times)

    def _append(self, time: Fraction, before: np.ndarray) -> None:
        """Add a knot with z just before it."""
        n, z = len(self.equations.inputs), before.copy()
        if time in self._loads:
            z[n:] = self.force.smooth.restarts.states[:, self._loads[time]]
        pushed = self._pushed.get(time)
        if pushed is not None:
            z[:n] += pushed
        jump = np.zeros(self.size)
        if time in self._loads:
            jump[n:] = self.force.smooth.restarts.jumps[:, self._loads[time]]
        if pushed is not None:
            jump[:n] = pushed
        self._index[time] = len(self._knots)
        self._knots.append(time)
        self._states.append(z)
        members, jumps = [z], [jump]
        for s in self.chain.shifts[1:]:
            known = self._index.get(time - s)
            if known is not None:
                members.append(self._states[known])
                jumps.append(self._jumps[known][: self.size])
            else:
                members.append(np.zeros(self.size) if s > time else self._advanced(self._piece(time - s), time - s))
                jumps.append(np.zeros(self.size))
        self._members.append(np.concatenate(members))
        self._jumps.append(np.concatenate(jumps))

    def _piece(self, time: Fraction) -> int:
        return bisect_right(self._knots, time) - 1

    def _advanced(self, piece: int, time: Fraction) -> np.ndarray:
        """z at a time in a piece, from the chain at its beginning."""
        gap, members = time - self._knots[piece], self._members[piece]
        if gap not in self._matrices and len(self._matrices) < MOST_MATRICES:
            self._matrices[gap] = None
        elif self._matrices.get(gap) is None and gap in self._matrices:
            self._matrices[gap] = scipy.linalg.expm(self.chain.generator * float(gap))[: self.size]
        matrix = self._matrices.get(gap)
        if matrix is not None:
            return matrix @ members
        return block_states(self.blocks, members, np.array([float(gap)]))[: self.size, 0]

    # Jumps and impulses. At one time, impulses g_l delta^(l) of u and jumps of u^(k) give
    #     jump of x^(i) = sum of H_(-i-l-1) g_l + sum of H_(k-i) jump of u^(k),
    #     impulses c_p  = sum of H_(p-l) g_l + sum of H_(p+1+k) jump of u^(k),
    # the coefficients of s^(-i-1) and s^p of A(s)^-1 (sum of g_l s^l + sum of s^(-k-1) jump of u^(k)). What x does so, the delayed
    # terms repeat one delay later, in a higher derivative: after a few delays no event is left.

    def _all_events(self) -> tuple[tuple[Event, ...], dict[Fraction, np.ndarray]]:
        """The events after t = 0, and the jumps of w by impulses, those at t = 0 included."""
        A, pairs = self.pairs.polynomial_matrix, self.pairs
        q, r = A.degree, A.size
        longest = max(len(term.coefficients) for term in self.terms)
        orders = q + pairs.form.highest_impulse + longest
        jumps: dict[Fraction, np.ndarray] = defaultdict(lambda: np.zeros((2, orders, r)))  # of u^(k), and sizes of their terms
        impulses: dict[Fraction, list[np.ndarray]] = defaultdict(list)
        smooth = self.force.smooth
        for time, place in self._loads.items():
            if time and smooth.restarts.jumps[:, place].any():
                jumps[time] += _taylor(smooth.coefficients, smooth.generator, smooth.restarts.jumps[:, place], orders)
        for load in self.force.later:
            _add_impulses(impulses[_decimal(load.time)], load.impulses, r)
        pushed = {Fraction(0): self._started()}
        # at t = 0 all of x begins for the delayed terms, whose impulses are those of jumps from the values at 0-
        z = np.concatenate([pushed[Fraction(0)], smooth.restarts.states[:, 0]])
        values = _taylor(self.equations.output, self.equations.generator, z, orders + longest)
        self._delay(Fraction(0), values, self.start.jump, self.start.impulses, jumps, impulses)
        events, queue, begun = [], sorted({*jumps, *impulses}), set()
        heapq.heapify(queue)
        while queue:
            time = heapq.heappop(queue)
            if time in begun:
                continue
            begun.add(time)
            change, loads = _cleaned(jumps.pop(time, np.zeros((2, orders, r)))), impulses.pop(time, [])
            if not change.any() and not any(g.any() for g in loads):
                continue
            jump, own = self._effect(change, loads, orders + longest)
            if loads:
                pushed[time] = self._pushed_by(loads)
            if jump[:q].any() or own:
                events.append(Event(float(time), jump[:q], own))
            later = self._delay(time, np.array([jump, np.abs(jump)]), jump[:q], own, jumps, impulses)
            for one in later:
                heapq.heappush(queue, one)
        return tuple(events), pushed

    def _started(self) -> np.ndarray:
        """w at 0+: by the values at 0- and impulses of the force at t = 0."""
        A = self.pairs.polynomial_matrix
        loads: list[np.ndarray] = []
        for power, matrix in enumerate(A.coefficients):
            for order in range(power):
                _add_impulses(loads, [*[np.zeros(A.size)] * (power - 1 - order), matrix @ self._initial[order]], A.size)
        _add_impulses(loads, self.force.impulses, A.size)
        return self._pushed_by(loads)

    def _pushed_by(self, loads: Sequence[np.ndarray]) -> np.ndarray:
        """The jump of w by impulses of u, sum of J^l B g_l."""
        B = self.equations.inputs
        J, total = self.equations.generator[: len(B), : len(B)], np.zeros(len(B))
        for g in loads[::-1]:
            total = J @ total + B @ g
        return total

    def _effect(self, change: np.ndarray, loads: Sequence[np.ndarray], orders: int) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        """Jumps of x^(i) for i < orders, and impulses of x."""
        pairs, highest = self.pairs, self.pairs.form.highest_impulse

        def total(index_of_load, index_of_jump) -> np.ndarray:
            terms = [(pairs.laurent(index_of_load(k)), g) for k, g in enumerate(loads) if index_of_load(k) <= highest]
            terms += [(pairs.laurent(index_of_jump(k)), c) for k, c in enumerate(change) if index_of_jump(k) <= highest and c.any()]
            value = sum((H @ vector for H, vector in terms), np.zeros(len(self.equations.output)))
            size = sum((np.abs(H) @ np.abs(vector) for H, vector in terms), np.zeros(len(self.equations.output)))
            return np.where(np.abs(value) > noise_of(size, len(value)), value, 0.0)

        jump = np.array([total(lambda k, i=i: -i - k - 1, lambda k, i=i: k - i) for i in range(orders)])
        impulses = [total(lambda k, p=p: p - k, lambda k, p=p: p + 1 + k) for p in range(highest + len(loads))]
        return jump, without_zeros(impulses)

    def _delay(self, time, values, jump, own, jumps, impulses) -> list[Fraction]:
        """Add what the delayed terms do with jumps of x^(i), their sizes (2, orders, r), and with impulses; return the times."""
        times = []
        for term, delay in zip(self.terms, self.delays):
            change = np.zeros((2, values.shape[1] - len(term.coefficients), values.shape[2]))
            for power, matrix in enumerate(term.coefficients):
                part = values[:, power : power + change.shape[1]]
                change[0] -= part[0] @ matrix.T
                change[1] += part[1] @ np.abs(matrix.T)
            loads = delayed_impulses(term, jump, own)
            if _cleaned(change).any() or any(g.any() for g in loads):
                total = jumps[time + delay]
                count = min(total.shape[1], change.shape[1])
                total[:, :count] += change[:, :count]
                if any(g.any() for g in loads):
                    _add_impulses(impulses[time + delay], loads, values.shape[2])
                times.append(time + delay)
        return times


def _taylor(rows: np.ndarray, generator: np.ndarray, states: np.ndarray, orders: int) -> np.ndarray:
    """rows @ generator^k @ states for k < orders, and the sizes of their terms, shape (2, orders, r)."""
    result = np.zeros((2, orders, len(rows)))
    for k in range(orders):
        result[:, k] = rows @ states, np.abs(rows) @ np.abs(states)
        rows = rows @ generator
    return result


def _cleaned(values: np.ndarray) -> np.ndarray:
    """Values (orders, r), those within the rounding errors of their terms set to zero."""
    return np.where(np.abs(values[0]) > noise_of(values[1], values.shape[2]), values[0], 0.0)


def _add_impulses(total: list[np.ndarray], more: Sequence[np.ndarray], size: int) -> None:
    total += [np.zeros(size) for _ in more[len(total) :]]
    for order, g in enumerate(more):
        total[order] = total[order] + g


def _decimal(time: float) -> Fraction:
    return Fraction(repr(float(time)))


def delayed_impulses(term: DelayedTerm, jump: np.ndarray, impulses: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The impulses of minus a delayed term, one delay after x jumps, (q, r), and has impulses."""
    loads: list[np.ndarray] = []
    size = len(term.coefficients[0])
    for power, matrix in enumerate(term.coefficients):
        _add_impulses(loads, [-matrix @ jump[order] for order in range(min(power, len(jump)))][::-1], size)
        _add_impulses(loads, [*[np.zeros(size)] * power, *(-matrix @ one for one in impulses)] if impulses else [], size)
    return loads


def past_force(terms: Sequence[DelayedTerm], past: BohlFunction | None, size: int) -> ImpulsiveSmooth:
    """The force of the delayed terms by the motion before t = 0: minus A_j(d/dt) h(t - delay_j) until t = delay_j."""
    total = zero(size)
    if past is None:
        return total
    longest = terms[-1].delay
    for term in terms:
        function = past.differential(*(-matrix for matrix in term.coefficients))
        begin = longest - term.delay
        own = function.with_knots(np.union1d(function.restarts.knots, [begin, longest])).restarts
        first, last = np.searchsorted(own.knots, [begin, longest])
        nothing = np.zeros((len(own.states), 1))
        states = np.hstack([own.states[:, first:last], nothing])
        end = states_before(function, longest)[:, None]
        jumps = np.hstack([own.states[:, first : first + 1], own.jumps[:, first + 1 : last], -end])
        knots = np.append(own.knots[first:last] - begin, term.delay)
        smooth = BohlFunction(function.coefficients, function.blocks, Restarts(knots, states, jumps))
        total = total + ImpulsiveSmooth(smooth)
    return total


# The solution.


class StepsFunction(BohlFunction):
    """Rows over the chain as a function of time, whose knots are computed as far as values are requested."""

    steps: Steps

    def __init__(self, coefficients: np.ndarray, steps: Steps):
        self.__dict__.update(coefficients=coefficients, steps=steps)

    blocks = property(lambda self: self.steps.blocks)
    start = property(lambda self: self.steps.restarts)
    restarts = property(lambda self: self.steps.restarts)

    def _values(self, times) -> np.ndarray:
        return self.until(times.max(initial=0.0))._values(times)

    def until(self, end: float) -> BohlFunction:
        """The function with all knots up to a time, not valid after it."""
        self.steps.reach(end)
        return BohlFunction(self.coefficients, self.blocks, self.steps.restarts)

    def delayed_by(self, delay: Fraction) -> StepsFunction:
        """The function of t - delay, zero before."""
        steps, total = self.steps, np.zeros_like(self.coefficients)
        m = steps.size
        for s, place in steps._place.items():
            own = self.coefficients[:, place * m : (place + 1) * m]
            if own.any():
                at = steps._place[s + delay] * m
                total[:, at : at + m] = own
        return StepsFunction(total, steps)

    def derivative(self, order: int = 1) -> StepsFunction:
        return StepsFunction(super().derivative(order).coefficients, self.steps)

    def differential(self, *matrices: np.ndarray) -> StepsFunction:
        return StepsFunction(super().differential(*matrices).coefficients, self.steps)

    def mapped(self, matrix) -> StepsFunction:
        return StepsFunction(super().mapped(matrix).coefficients, self.steps)

    def rows(self, indices) -> StepsFunction:
        return StepsFunction(super().rows(indices).coefficients, self.steps)

    def __mul__(self, factor: float) -> StepsFunction:
        return StepsFunction(super().__mul__(factor).coefficients, self.steps)

    __rmul__ = __mul__


@dataclass(frozen=True, eq=False)
class StepsSolution:
    """x by the method of steps; attributes as those of ``PairSolution``."""

    method: Method
    steps: Steps

    is_precise = False
    dropped_near_bound = False
    as_written = None

    function = property(lambda self: self.steps.function)
    coupling = property(lambda self: self.steps.pairs.finite.coupling)
    jump = property(lambda self: self.steps.start.jump)
    impulses = property(lambda self: self.steps.start.impulses)
    events = property(lambda self: self.steps.events)
    has_clear_ranks = property(lambda self: all(decision.clear for decision in self.steps.pairs.form.decisions))
    finite_count = property(lambda self: self.steps.pairs.structure.finite_count)

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps of the pairs, and the length of the chain."""
        chain = self.steps.chain
        return (
            *self.steps.pairs.evidence,
            Evidence("delays in the chain", len(chain.shifts) - 1, f"sums of delays that act within {float(self.steps.gap):.3g} s"),
            Evidence("left out", chain.first_left_out, "bound of what longer sums of delays contribute, relative to the states"),
        )

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Doubtful decisions on the equations without the delayed terms; their zeros are not those of the motion."""
        with np.errstate(all="ignore"):
            return tuple(notice for notice in pair_notices(self.steps.pairs) if notice.doubtful)


def with_delayed(function: BohlFunction, x: BohlFunction, terms: Sequence[DelayedTerm]) -> BohlFunction:
    """A function over the same chain plus sum of A_j(d/dt) x(t - delay_j); a system of only zero terms has no chain."""
    if not isinstance(function, StepsFunction) or not isinstance(x, StepsFunction):
        return function
    total = function.coefficients
    for term in terms:
        total = total + x.delayed_by(term.decimal).differential(*term.coefficients).coefficients
    return StepsFunction(total, x.steps)


def residual_of(x: BohlFunction, A: PolynomialMatrix, terms: Sequence[DelayedTerm]) -> BohlFunction:
    """A(d/dt) x + sum of A_j(d/dt) x(t - delay_j), which is the force for t > 0."""
    return with_delayed(x.differential(*A.coefficients), x, terms)
