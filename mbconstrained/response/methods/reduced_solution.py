"""Solutions of the reduced equations w' = S w + f, also under records."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil
from operator import attrgetter

import numpy as np

from ...ground.checks import real_array, real_number, whole_number
from ...ground.notices import Evidence, Notice, NoticeKind
from ...ground.tolerances import EPS, ROUNDED_FREE, noise_of, rounding_radius
from ...linalg.arrays import Matrix, full, of_like_kind
from ...linalg.exponential import BlockGroups, block_states
from ...linalg.recursion import ModalBasis, advance, powers, scanned, shared_gaps, values_of_steps
from ...signals.bohl import BohlFunction, consecutive
from ..choose import MODES, POWERS, STEPS, Evaluations, Method, Request, evaluation_method, is_by_series
from ..events import Event
from ..flow import FEWEST_KNOTS, Flow
from ..response_notices import growth_notice, modal_sums

# The motion of a large linear system under a force that restarts often, a record of many samples, by its modes.
# Between two knots x = P (e^{S tau} w + the response from rest to the force). Of the modes, each by itself and complex, e^{s tau} is a
# polynomial in tau on every gap, as no gap is long relative to any motion: a table of them is one product of matrices. So is the
# response to the force, its Taylor series about the middle of the longest gap: nothing has to be separated for it, be an eigenvalue of
# A(s) close to one of the force or not. States are kept at the knots, and values between are computed when they are requested. Of a record
# with even samples the modes are kept at every sixteenth knot only; those at the knots between follow from these, all groups of sixteen
# a step at once, so that memory stays near that of the answer.

#: A gap is short where nothing turns farther within it, rate times length, and the exponential for half of it takes so many terms:
#: 2^27 / 27! is far below EPS.
SHORT, TERMS = 4.0, 27

#: A longer gap has at most so many parts that are short.
PARTS = 64

#: Number of entries of a table computed at once.
TABLE = 200_000

#: A part this many times smaller than the whole is far below its rounding.
NOTHING = EPS / 256

#: More long gaps are not worth a table.
MOST_LONG = 8

#: So many knots are a group: with more of them a step of all groups at once is too short, with fewer more is kept.
GROUP = 16

#: Up to so many modes of all knots are kept, 32 MB: reading them takes a tenth less of the time of all values than computing them.
KEPT = 2_000_000

#: Number of groups computed at once.
TOGETHER = 64


@dataclass(frozen=True, eq=False)
class RecordFlow:
    """A flow whose short gaps share one table.

    Attributes:
        flow: the motion and its force.
        modes: modes of S.
        middle: half of the longest short gap or part of a gap, s.
        long: which pieces are longer, the last one being endless.
        parts: number of parts of the longest of the other gaps.
    """

    flow: Flow
    modes: ModalBasis
    middle: float
    long: np.ndarray
    parts: int = 1

    @staticmethod
    def of(flow: Flow) -> RecordFlow | None:
        """The record flow of a flow; None where gaps are few, or long relative to the motion."""
        gaps, states = flow.force.smooth.restarts.gaps, flow.force.smooth.restarts.states
        if (
            len(gaps) < FEWEST_KNOTS or flow.force.later or not len(states) or not len(flow.start)
        ):  # no force, or nothing that moves
            return None
        modes = ModalBasis.of(flow.reduction.decoupled)
        short = gaps * flow.norm <= (SHORT if len(modes.rest) else SHORT * PARTS)
        short &= gaps * min(modes.rates.real.max(initial=0.0), flow.norm) <= SHORT
        long = np.append(~short, True)
        acting = long[:-1] & states[:, :-1].any(axis=0)  # its effect would have to be known at the end of the long gap
        if short.sum() < FEWEST_KNOTS or long.sum() > MOST_LONG or acting.any():
            return None
        longest = float(gaps[short].max())
        parts = max(1, ceil(longest * flow.norm / SHORT))
        record = RecordFlow(flow, modes, longest / (2 * parts), long, parts)
        if long[:-1].any() or (record.gaps != record.gaps[0]).any():
            return record
        return EvenRecord(flow, modes, record.middle, long, parts)

    @cached_property
    def gaps(self) -> np.ndarray:
        """Gaps between the knots in s."""
        return shared_gaps(self.flow.knots, self.flow.force.smooth.restarts.gaps)

    @cached_property
    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """The modes at every knot, complex, shape (K, p), and the remaining states, shape (q, K)."""
        first, rest = self.modes.split(self.flow.reduction.decoupled.coordinates(self.flow.start))
        return self._modes_from(first), self._rest_from(rest)

    def _modes_from(self, first) -> np.ndarray:
        states, begin, rates = np.empty((len(self.long), len(first)), dtype=complex), 0, self.modes.rates
        states[0] = first
        for end in np.flatnonzero(self.long):
            self._scan(states[begin : end + 1], self.gaps[begin:end], self._inputs[begin:end])
            if end < len(self.gaps):
                moved = np.exp(rates * self.gaps[end]) * states[end]
                states[end + 1] = np.where(states[end] == 0, 0.0, moved)  # zero stays zero, however fast it would grow
            begin = end + 1
        return states

    def _rest_from(self, first) -> np.ndarray:
        states = np.zeros((len(first), len(self.long)))
        states[:, 0] = first
        if len(first):
            for at in self._chunks(np.flatnonzero(~self.long)):
                states[:, 1:][:, at] = self._gains[1] @ self._products(self._powers(self.gaps[at]), self._inputs[at]).T
            advance(self.modes.blocks, states, self.gaps)
        return states

    def _scan(self, states, gaps, inputs) -> None:
        """Propagate the first state of a run of short gaps to the others, in place."""
        if not len(gaps):
            return
        factors = np.empty((len(gaps), states.shape[1]), dtype=complex)
        for at in self._chunks(np.arange(len(gaps))):
            factors[at], states[1:][at] = self._stepped(gaps[at], inputs[at])
        scanned(states, factors)

    def _stepped(self, since, inputs) -> tuple[np.ndarray, np.ndarray]:
        """e^{s tau} of each of the modes, and their response to the force from rest, shape (T, p)."""
        number, left = self._part(since)
        table = self._powers(left)
        factors = (table @ self._table).view(complex)
        begun, inputs = self._at_part(np.zeros((), dtype=complex), inputs, number)
        gained = (self._products(table, inputs) @ self._gains[0]).view(complex)
        return factors * self._across[0][number], gained + factors * begun

    def _part(self, since) -> tuple[np.ndarray, np.ndarray]:
        """The index of the part of a gap, and the time since its beginning."""
        number = np.minimum((since / (2 * self.middle)).astype(int), self.parts - 1)
        return number, since - 2 * self.middle * number

    def _at_part(self, modes, inputs, number) -> tuple[np.ndarray, np.ndarray]:
        """The modes and the states of the force from the beginning of gaps to that of their parts."""
        if self.parts == 1:
            return modes, inputs
        factors, gained, moved = self._across
        modes = modes * factors[number]
        for column, gains in zip(inputs.T, gained.swapaxes(0, 1)):
            modes = modes + column[:, None] * gains[number]
        return modes, np.einsum("tm,tmn->tn", inputs, moved[number])

    def values(self, function: FlowFunction, times: np.ndarray) -> np.ndarray:
        """Values of a function of this flow, shape (r, T)."""
        if (np.diff(times) < 0).any():  # neighbours are computed together
            order = np.argsort(times)
            return self.values(function, times[order])[:, np.argsort(order)]
        piece, since = self.flow.force.smooth.restarts.located(times)
        own, others = self.modes.modal_output(function.place[:, : len(self.flow.start)], function.order)
        between = since.any()
        late = self.long[piece] & between
        driven = self._modal_response(function.output, own) if between else full(function.output[:, len(self.flow.start) :])
        driven_rows, values = np.flatnonzero(driven.any(axis=1)), np.empty((len(own), len(times)))
        for at in self._chunks(np.flatnonzero(~late)):
            modes, forces, rest = (self._between if between else self._at_knots)(piece[at], since[at])
            part = own @ modes.T
            part[driven_rows] += driven[driven_rows] @ forces.T
            if len(rest):
                part += others @ rest
            values[:, at] = part
        for number in np.unique(piece[late]):
            at = np.flatnonzero(piece == number)
            values[:, at] = self._alone(number, function)._values(since[at])
        return values

    def _modal_response(self, output, own) -> np.ndarray:
        """output @ the response to the force within a gap, shape (r, m terms); rows far below their part of the modes are zero."""
        driven = output @ self._driven.reshape(output.shape[1], -1)
        within = np.abs(self._gains[0]).max(axis=0, initial=0.0)
        driven[np.abs(driven).max(axis=1, initial=0.0) < NOTHING * (np.abs(own) @ within)] = 0.0
        return driven

    def _between(self, piece, since) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Within short gaps: modes, states of the force with powers of time, one row for each, and the remaining states."""
        number, left = self._part(since)
        rest, table = self.states[1], self._powers(left)
        begun, inputs = self._at_part(self._modes_at(piece), self._inputs[piece], number)
        modes = table @ self._table
        moved = modes.view(complex)
        moved *= begun
        rest = block_states(self._groups, rest[:, piece], since) if len(rest) else rest
        return modes, self._products(table, inputs), rest

    def _at_knots(self, piece, since) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Modes, states of the force and remaining states at knots."""
        return self._modes_at(piece).view(float), self._inputs[piece], self.states[1][:, piece]

    def _modes_at(self, piece) -> np.ndarray:
        """The modes at the beginnings of pieces, complex, shape (T, p)."""
        return self.states[0][piece]

    def _alone(self, number: int, function: FlowFunction) -> FlowFunction:
        """A piece as a separate motion, evaluated at many times."""
        modes, rest = self._modes_at(np.array([number]))[0], self.states[1][:, number]
        return FlowFunction(self.flow.after(number, self.modes.states(modes, rest)), function.place, function.order, "many")

    @cached_property
    def _inputs(self) -> np.ndarray:
        """The states of the force at every knot, shape (K, m)."""
        return np.ascontiguousarray(self.flow.force.smooth.restarts.states.T)

    @cached_property
    def _groups(self) -> BlockGroups:
        return BlockGroups.of(self.modes.blocks)

    @cached_property
    def _count(self) -> int:
        """Terms of the series about the middle: the tail of an exponential is below rounding.

        Powers of time of the force, integrated by zeros at 0 or slow ones, have so many more terms.
        """
        forcing, own = self.flow.force.smooth.blocks, self.modes.blocks
        rates = np.concatenate([self.modes.rates, *map(np.linalg.eigvals, (*forcing, *own))])
        turned, count, term = np.abs(rates).max() * self.middle, 0, 1.0
        while term > EPS / 32:
            count += 1
            term *= turned / count
        return count + max(map(len, forcing)) + max(map(len, own), default=1) - 1

    @cached_property
    def _table(self) -> np.ndarray:
        """e^{s tau} by powers of (tau / middle - 1), real and imaginary parts in turn, shape (terms, 2 p)."""
        s, terms = self.modes.rates * self.middle, [np.exp(self.modes.rates * self.middle)]
        for k in range(1, self._count):
            terms.append(terms[-1] * s / k)
        return np.array(terms).view(float)

    @cached_property
    def _driven(self) -> np.ndarray:
        """(w, v) from rest and unit states of the force, by powers of (tau / middle - 1), shape (n + m, m, terms)."""
        n, G, longest = len(self.flow.start), self.flow.generator * self.middle, max(map(len, self.flow.force.smooth.blocks))
        term = total = np.eye(G.shape[0])[:, n:]
        for k in range(1, TERMS + longest):
            term = G @ term / k
            total = total + term
        terms = [total]
        for k in range(1, self._count):
            terms.append(G @ terms[-1] / k)
        return np.stack(terms, axis=2)

    @cached_property
    def _gains(self) -> tuple[np.ndarray, np.ndarray]:
        """The effect of ``_products`` on the modes, shape (m terms, 2 p), and to the rest, shape (q, m terms)."""
        driven = self._driven[: len(self.flow.start)]
        modes, rest = self.modes.split(self.flow.reduction.decoupled.coordinates(driven.reshape(len(driven), -1)))
        return np.ascontiguousarray(modes.T).view(float), rest

    @cached_property
    def _across(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Propagation to the parts of a gap: e^{s tau}, shape (parts, p), the response to unit states of the force, (parts,
        m, p), and these states, (parts, m, m), one row for each.
        """
        m, length = self._inputs.shape[1], 2 * self.middle
        times, blocks = length * np.arange(self.parts), self.flow.force.smooth.blocks
        factors = np.exp(np.multiply.outer(times, self.modes.rates))
        moved = np.array([block_states(blocks, unit, times) for unit in np.eye(m)]).transpose(2, 0, 1)
        gained, table = np.zeros((self.parts, m, factors.shape[1]), dtype=complex), self._powers(np.full(m, length))
        for number in range(1, self.parts):
            more = (self._products(table, moved[number - 1]) @ self._gains[0]).view(complex)
            gained[number] = factors[1] * gained[number - 1] + more
        return factors, gained, moved

    def _powers(self, since) -> np.ndarray:
        """Powers of (tau / middle - 1), shape (T, terms)."""
        return powers(since / self.middle - 1.0, self._count)

    @staticmethod
    def _products(table, inputs) -> np.ndarray:
        """Products of states of the force and powers, shape (T, m terms)."""
        return np.einsum("tm,tk->tmk", inputs, table).reshape(len(table), -1)

    def _chunks(self, places: np.ndarray) -> Iterator[np.ndarray | slice]:
        """Chunks of ascending indices; a slice where they are consecutive."""
        width = max(1, TABLE // max(self.flow.generator.shape[0], 1))
        for begin in range(0, len(places), width):
            yield consecutive(places[begin : begin + width])


def record_of(flow: Flow) -> RecordFlow | None:
    """The motion gap by gap, where the force restarts often; computed once."""
    key = "record", flow.first_moments
    if key not in flow.computed:
        flow.computed[key] = RecordFlow.of(flow)
    return flow.computed[key]


class EvenRecord(RecordFlow):
    """A flow with short gaps of one length; the first of ``states`` are those of each group of knots."""

    def _modes_from(self, first) -> np.ndarray:
        gained = (self._each[GROUP - 1 :: -1, None] * self._gap_response).reshape(-1, len(first))
        first_of_groups = (self._given @ gained.view(float)).view(complex)
        following, across = first, np.exp(self.modes.rates * (self.gaps[0] * GROUP))
        for begin in first_of_groups:
            begin[:], following = following, across * following + begin
        return first_of_groups

    def _modes_at(self, piece) -> np.ndarray:
        if self._every is None:
            groups, which = np.unique(piece // GROUP, return_inverse=True)
            return self._within(groups)[piece % GROUP, which]
        return self._every[consecutive(piece)]

    @cached_property
    def _every(self) -> np.ndarray | None:
        """The modes at all knots, shape (K or slightly more, p); None for a long record."""
        groups, p = self.states[0].shape
        if groups * GROUP * p > KEPT:
            return None
        modes = np.empty((groups, GROUP, p), dtype=complex)
        for begin in range(0, groups, TOGETHER):
            at = slice(begin, begin + TOGETHER)
            modes[at] = self._within(at).transpose(1, 0, 2)
        return modes.reshape(-1, p)

    def _within(self, groups) -> np.ndarray:
        """The modes at the knots of some groups, shape (GROUP, number of groups, p)."""
        begins, given = self.states[0][groups], self._given[groups]
        modes, part = np.empty((GROUP, *begins.shape), dtype=complex), np.empty_like(begins)
        given = given.reshape(len(given), GROUP, -1)[:, :-1].transpose(1, 0, 2).reshape(len(given) * (GROUP - 1), -1)
        np.matmul(given, self._gap_response.view(float), out=modes[1:].reshape(len(given), -1).view(float))
        modes[0] = begins
        for before, after in pairwise(modes):
            after += np.multiply(before, self._each[1], out=part)
        return modes

    @cached_property
    def _each(self) -> np.ndarray:
        """e^{s h i} for every i of a group, shape (GROUP, p)."""
        return np.exp(np.multiply.outer(self.gaps[0] * np.arange(GROUP), self.modes.rates))

    @cached_property
    def _gap_response(self) -> np.ndarray:
        """The response of the modes to states of the force within one gap, complex, shape (m, p)."""
        m = self._inputs.shape[1]
        return self._stepped(np.full(m, self.gaps[0]), np.eye(m))[1]

    @cached_property
    def _given(self) -> np.ndarray:
        """The states of the force at all knots of a group side by side, one row for each group."""
        count, m = self._inputs.shape
        groups = -(-count // GROUP)
        given = np.zeros((groups * GROUP, m))
        given[:count] = self._inputs
        return given.reshape(groups, GROUP * m)


# The solution of the reduced equations: its function of time, its evidence and its notices.
# Coordinates with mass keep their values at 0-, and coordinates with dampers only keep theirs; a coordinate that an algebraic equation
# determines satisfies it at 0-, with its velocity, where mass or damping goes with it. All others take the values at 0+ that the
# equations give them: they jump there without impulses, as they do where the force jumps later.


@dataclass(frozen=True, eq=False)
class ReducedSolution:
    """x of a directly reducible problem.

    Attributes:
        method: the reduced equations, chosen with a reason.
        function: the regular part.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r).
        events: jumps after t = 0.
        impulses: none.
    """

    method: Method
    function: FlowFunction
    jump: np.ndarray
    events: tuple[Event, ...]
    impulses: tuple[np.ndarray, ...] = ()

    #: Float64 throughout, no rank decided by a tolerance, and no datum taken for zero.
    is_precise, has_clear_ranks, dropped_near_bound, as_written = False, True, False, None

    @classmethod
    def of(cls, method: Method) -> ReducedSolution:
        """The solution of the equations of a method."""
        flow = method.flow
        return cls(method, FlowFunction(flow, flow.output, 0, method.evaluations), flow.jump, flow.events)

    def sums(self, count: int, times: np.ndarray | None = None) -> tuple[np.ndarray, list[Matrix], np.ndarray, float]:
        """Rows and states as ``response_notices.modal_sums``; for many states evaluated by powers at 0+ only."""
        flow = self.method.flow
        if flow.reduction.is_small or self.method.evaluations == "many":
            return modal_sums(self.function.modal, count, times)
        rows = [FlowFunction(flow, flow.output, order).output for order in range(count)]
        return np.zeros(1), rows, flow.start_with_force[:, None], flow.norm

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separates the modes."""
        return self.method.flow.coupling

    @property
    def finite_count(self) -> int:
        """The number of finite zeros of A(s)."""
        return self.method.flow.reduction.state_count

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """Conditions and residual of the reduction and of its modes; not computed for many states evaluated by powers."""
        reduction = self.method.flow.reduction
        text = "largest condition of the masses, dampers and algebraic equations that were divided by, brought to one size"
        condition = Evidence("condition", reduction.largest_condition, text)
        if not (reduction.is_small or self.method.evaluations == "many"):
            return (condition,)
        if self.method.flow.refined is not None:
            text = "largest change by their residual of modes refined with twice the digits, relative to their poles or distances"
            return Evidence("residual", self.method.flow.computed["residual"], text), condition
        text = (
            "residual |S X - X J| of the modes X of the reduced equations w' = S w, relative to J, in the coordinates of the modes"
        )
        residual = Evidence("residual", reduction.modal_residual, text)
        return (
            residual,
            Evidence("decoupling", self.coupling, "largest entry of the transformation that separates the modes"),
            condition,
        )

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Supports that may be rounding errors, and growing motions."""
        reduction = self.method.flow.reduction
        supports = tuple(
            Notice(
                NoticeKind.RANK,
                f"springs on a body of {count} coordinates cancel to a few units in the last place of their terms: these count as the "
                f"support that they are; if they are rounding errors, the body is free, and x differs by {ROUNDED_FREE:g} of itself "
                f"and more from t = {time:.3g} s on",
            )
            for count, time in reduction.rounded_supports
        )
        if reduction.is_dissipative:
            return supports
        values = reduction.eigenvalues
        noise = np.maximum(rounding_radius(1) * np.abs(values), noise_of(np.abs(values).max(initial=0.0)))
        return supports + growth_notice(values[(values.imag >= 0) & (values.real > noise)])


class FlowFunction(BohlFunction):
    """P z(t), P of shape (r, n), of the reduced equations z' = G z; a Bohl function whose blocks are computed when they are needed."""

    flow: Flow
    place: Matrix
    order: int
    output: Matrix
    evaluations: Evaluations

    def __init__(self, flow: Flow, place: Matrix, order: int = 0, evaluations: Evaluations = "once"):
        """The derivative of this order of place @ z."""
        output = place
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            for _ in range(order):
                output = output @ flow.generator
        self.__dict__.update(flow=flow, place=place, order=order, output=output, evaluations=evaluations)

    @property
    def modal(self) -> BohlFunction:
        """The function as a sum of modes, each differentiated separately so that slow ones lose no accuracy relative to fast ones."""
        function = BohlFunction(self.flow.modal_output(self.place), self.blocks, self.start)
        return function.derivative(self.order) if self.order else function

    coefficients = property(attrgetter("modal.coefficients"))
    blocks = property(attrgetter("flow.states.blocks"))
    start = property(attrgetter("flow.states.start"))
    _groups = property(attrgetter("flow.states._groups"))
    _oscillating_part = property(attrgetter("flow.states._oscillating_part"))

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.output.shape[0]

    @property
    def state_count(self) -> int:
        """Number of states of A(s) and of the force."""
        return self.output.shape[1]

    @property
    def summed_from(self) -> np.ndarray:
        """First time of evaluation by modes, never: problems with cancelling modes are not solved by them (``response.choose``)."""
        return np.full(self.size, np.inf)

    def _values(self, times) -> np.ndarray:
        flow = self.flow
        name, _ = evaluation_method(flow, self.output.shape, Request(self.evaluations, times))
        values = {MODES: self.by_modes, POWERS: self._by_powers, STEPS: self._by_steps}[name](times)
        start = flow.taylor_start(modal=name == MODES)
        start.replace(values, times, self.output, lambda: np.abs(self.coefficients) @ np.abs(flow.states.start_at_zero))
        return values

    def by_modes(self, times: np.ndarray) -> np.ndarray:
        """The sum of modes, from t = 0 on."""
        record = record_of(self.flow)
        return super()._values(times) if record is None else record.values(self, times)

    def _by_powers(self, times: np.ndarray) -> np.ndarray:
        step = float(times[-1]) / (len(times) - 1)
        if is_by_series(self.flow, times):
            return self.flow.series(step, len(times)).values(self.output)
        propagator = self.flow.propagator(step)
        return propagator.values(self.output, self.flow.start_with_force, len(times))

    def _by_steps(self, times: np.ndarray) -> np.ndarray:
        flow, n = self.flow, len(self.flow.start)
        inputs, matrix = (
            flow.force.smooth.restarts.states[:, : len(times)],
            flow.propagator(float(shared_gaps(times)[0])).matrix[:n],
        )
        values = values_of_steps(self.output[:, :n], matrix[:, :n], matrix[:, n:], flow.start, inputs[:, :-1])
        through = self.output[:, n:]
        return values + through @ inputs if abs(through).sum() else values

    def _with(self, place: Matrix, order: int) -> FlowFunction:
        return FlowFunction(self.flow, place, order, self.evaluations)

    def of(self, flow: Flow) -> FlowFunction:
        """The function by other modes of the same motion."""
        return FlowFunction(flow, self.place, self.order, self.evaluations)

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative."""
        return self._with(self.place, self.order + whole_number(order, "order"))

    def differential(self, *matrices: np.ndarray) -> BohlFunction:
        """matrices[0] @ y + matrices[1] @ y' + ..., with the same states."""
        place, total = self.place, of_like_kind(matrices[0], self.place) @ self.place
        for matrix in matrices[1:]:
            place = place @ self.flow.generator
            total = total + of_like_kind(matrix, place) @ place
        return self._with(total, self.order)

    def mapped(self, matrix) -> BohlFunction:
        """matrix @ y(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return self._with(of_like_kind(matrix, self.place) @ self.place, self.order)

    def rows(self, indices) -> BohlFunction:
        return self._with(self.place[np.asarray(indices, dtype=int)], self.order)

    def __mul__(self, factor: float) -> BohlFunction:
        return self._with(self.place * real_number(factor, "factor"), self.order)

    __rmul__ = __mul__
