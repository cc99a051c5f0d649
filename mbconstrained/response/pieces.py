"""The motion of a large linear system under a force that starts anew often: a record of many samples.

Between two knots x = P (e^{S tau} w + what the force does from rest). Of the modes, each by itself and complex, e^{s tau} is a
polynomial in tau on every gap, as no gap is long beside any motion: a table of them is one product of matrices. So is what the
force does, its Taylor series about the middle of the longest gap: nothing has to be separated for it, be a zero of A(s) close
to one of the force or not. States are kept at the knots, everything between is made when it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from ..linalg.exponential import BlockGroups, block_states
from ..linalg.kinds import full
from ..linalg.modes import Modes
from ..linalg.recursion import advance, powers, scanned, shared_gaps
from ..signals.restarts import as_slice
from ..tolerances import EPS

if TYPE_CHECKING:
    from .flow import Flow, FlowFunction

#: A gap is short where nothing turns farther within it, rate times length, and the exponential for half of it takes so many terms:
#: 2^27 / 27! is far below EPS.
SHORT, TERMS = 4.0, 27

#: A longer gap has at most so many parts that are short.
PARTS = 64

#: So many numbers of one table are made at once.
TABLE = 200_000

#: What is this part of something is far below its rounding.
NOTHING = EPS / 256

#: Fewer pieces are not worth it, and more long gaps neither.
FEW_PIECES, MANY_LONG = 64, 8


@dataclass(frozen=True, eq=False)
class Pieces:
    """A flow whose short gaps one table serves.

    Attributes:
        flow: the motion and its force.
        modes: those of S.
        middle: half of the longest short gap or part of a gap, s.
        long: which pieces are longer, the last one being endless.
        parts: how many the longest of the other gaps has.
    """

    flow: Flow
    modes: Modes
    middle: float
    long: np.ndarray
    parts: int = 1

    @staticmethod
    def of(flow: Flow) -> Pieces | None:
        """None where gaps are few, or long beside the motion."""
        gaps, states = np.diff(flow.knots), flow.force.smooth.restarts.states
        if len(gaps) < FEW_PIECES or not len(states) or not len(flow.start):  # nothing acts, or on nothing that moves
            return None
        modes = Modes.of(flow.reduction.decoupled)
        short = gaps * flow.norm <= (SHORT if len(modes.rest) else SHORT * PARTS)
        short &= gaps * min(modes.rates.real.max(initial=0.0), flow.norm) <= SHORT
        long = np.append(~short, True)
        acting = long[:-1] & states[:, :-1].any(axis=0)  # what a force does in a long gap would have to be known at its end
        if short.sum() < FEW_PIECES or long.sum() > MANY_LONG or acting.any():
            return None
        longest = float(gaps[short].max())
        parts = max(1, ceil(longest * flow.norm / SHORT))
        return Pieces(flow, modes, longest / (2 * parts), long, parts)

    @cached_property
    def gaps(self) -> np.ndarray:
        """Between the knots, s."""
        return shared_gaps(self.flow.knots)

    @cached_property
    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """The modes at every knot, complex, shape (K, p), and the states of what is left, shape (q, K)."""
        first, rest = self.modes.split(self.flow.reduction.decoupled.coordinates(self.flow.start))
        return self._modes_from(first), self._rest_from(rest)

    def _modes_from(self, first) -> np.ndarray:
        found, begin, rates = np.empty((len(self.long), len(first)), dtype=complex), 0, self.modes.rates
        found[0] = first
        for end in np.flatnonzero(self.long):
            self._scan(found[begin : end + 1], self.gaps[begin:end], self._inputs[begin:end])
            if end < len(self.gaps):
                moved = np.exp(rates * self.gaps[end]) * found[end]
                found[end + 1] = np.where(found[end] == 0, 0.0, moved)  # what is zero stays zero, however fast it would grow
            begin = end + 1
        return found

    def _rest_from(self, first) -> np.ndarray:
        found = np.zeros((len(first), len(self.long)))
        found[:, 0] = first
        if len(first):
            for at in self._chunks(np.flatnonzero(~self.long)):
                found[:, 1:][:, at] = self._gains[1] @ self._beside(self._powers(self.gaps[at]), self._inputs[at]).T
            advance(self.modes.blocks, found, self.gaps)
        return found

    def _scan(self, found, gaps, inputs) -> None:
        """From the first state of a run of short gaps to the others, in place."""
        if not len(gaps):
            return
        factors = np.empty((len(gaps), found.shape[1]), dtype=complex)
        for at in self._chunks(np.arange(len(gaps))):
            factors[at], found[1:][at] = self._stepped(gaps[at], inputs[at])
        scanned(found, factors)

    def _stepped(self, since, inputs) -> tuple[np.ndarray, np.ndarray]:
        """e^{s tau} of each of the modes, and what the force adds to it from rest, shape (T, p)."""
        number, left = self._part(since)
        table = self._powers(left)
        factors = (table @ self._table).view(complex)
        begun, inputs = self._carried(np.zeros((), dtype=complex), inputs, number)
        gained = (self._beside(table, inputs) @ self._gains[0]).view(complex)
        return factors * self._across[0][number], gained + factors * begun

    def _part(self, since) -> tuple[np.ndarray, np.ndarray]:
        """Which part of a gap it is, and the time since this began."""
        number = np.minimum((since / (2 * self.middle)).astype(int), self.parts - 1)
        return number, since - 2 * self.middle * number

    def _carried(self, modes, inputs, number) -> tuple[np.ndarray, np.ndarray]:
        """The modes and the states of the force from the beginning of gaps to that of parts of them."""
        if self.parts == 1:
            return modes, inputs
        factors, gained, moved = self._across
        modes = modes * factors[number]
        for column, gains in zip(inputs.T, gained.swapaxes(0, 1)):
            modes = modes + column[:, None] * gains[number]
        return modes, np.einsum("tm,tmn->tn", inputs, moved[number])

    def values(self, asked: FlowFunction, times: np.ndarray) -> np.ndarray:
        """Of a function of this flow, shape (r, T)."""
        if (np.diff(times) < 0).any():  # neighbours are made together
            order = np.argsort(times)
            return self.values(asked, times[order])[:, np.argsort(order)]
        piece, since = self.flow.force.smooth.start.located(times)
        own, others = self.modes.seen(asked.place[:, : len(self.flow.start)], asked.order)
        between = since.any()
        late = self.long[piece] & between
        driven = self._seen_driven(asked.output, own) if between else full(asked.output[:, len(self.flow.start) :])
        pushed, found = np.flatnonzero(driven.any(axis=1)), np.empty((len(own), len(times)))
        for at in self._chunks(np.flatnonzero(~late)):
            modes, forces, rest = (self._between if between else self._at_knots)(piece[at], since[at])
            part = own @ modes.T
            part[pushed] += driven[pushed] @ forces.T
            if len(rest):
                part += others @ rest
            found[:, at] = part
        for number in np.unique(piece[late]):
            at = np.flatnonzero(piece == number)
            found[:, at] = self._alone(number, asked)._values(since[at])
        return found

    def _seen_driven(self, output, own) -> np.ndarray:
        """output @ what the force does within a gap, shape (r, m terms), without what is nothing beside its part of the modes."""
        driven = output @ self._driven.reshape(output.shape[1], -1)
        within = np.abs(self._gains[0]).max(axis=0, initial=0.0)
        driven[np.abs(driven).max(axis=1, initial=0.0) < NOTHING * (np.abs(own) @ within)] = 0.0
        return driven

    def _between(self, piece, since) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What makes values within short gaps: modes, states of the force with powers of time, one row for each, and the rest."""
        number, left = self._part(since)
        rest, table = self.states[1], self._powers(left)
        begun, inputs = self._carried(self._modes_at(piece), self._inputs[piece], number)
        modes = table @ self._table
        moved = modes.view(complex)
        moved *= begun
        rest = block_states(self._groups, rest[:, piece], since) if len(rest) else rest
        return modes, self._beside(table, inputs), rest

    def _at_knots(self, piece, since) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same at knots: modes, states of the force, and the rest."""
        return self._modes_at(piece).view(float), self._inputs[piece], self.states[1][:, piece]

    def _modes_at(self, piece) -> np.ndarray:
        """The modes at the beginnings of pieces, complex, shape (T, p)."""
        return self.states[0][piece]

    def _alone(self, number: int, asked: FlowFunction) -> FlowFunction:
        """A piece as a motion of its own."""
        modes, rest = self._modes_at(np.array([number]))[0], self.states[1][:, number]
        return type(asked)(self.flow.after(number, self.modes.states(modes, rest)), asked.place, asked.order)

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
        """What ``_beside`` adds to the modes, shape (m terms, 2 p), and to the rest, shape (q, m terms)."""
        driven = self._driven[: len(self.flow.start)]
        modes, rest = self.modes.split(self.flow.reduction.decoupled.coordinates(driven.reshape(len(driven), -1)))
        return np.ascontiguousarray(modes.T).view(float), rest

    @cached_property
    def _across(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """From the beginning of a gap to each of its parts: e^{s tau} of the modes, shape (parts, p), what unit states of the force
        add to them, (parts, m, p), and what becomes of these, (parts, m, m), one row for each."""
        m, length = self._inputs.shape[1], 2 * self.middle
        times, blocks = length * np.arange(self.parts), self.flow.force.smooth.blocks
        factors = np.exp(np.multiply.outer(times, self.modes.rates))
        moved = np.array([block_states(blocks, unit, times) for unit in np.eye(m)]).transpose(2, 0, 1)
        gained, table = np.zeros((self.parts, m, factors.shape[1]), dtype=complex), self._powers(np.full(m, length))
        for number in range(1, self.parts):
            more = (self._beside(table, moved[number - 1]) @ self._gains[0]).view(complex)
            gained[number] = factors[1] * gained[number - 1] + more
        return factors, gained, moved

    def _powers(self, since) -> np.ndarray:
        """Powers of (tau / middle - 1), shape (T, terms)."""
        return powers(since / self.middle - 1.0, self._count)

    @staticmethod
    def _beside(table, inputs) -> np.ndarray:
        """Products of states of the force and powers, shape (T, m terms)."""
        return np.einsum("tm,tk->tmk", inputs, table).reshape(len(table), -1)

    def _chunks(self, places: np.ndarray) -> Iterator[np.ndarray | slice]:
        """Some of ascending places at a time; a slice where they follow one another."""
        width = max(1, TABLE // max(self.flow.generator.shape[0], 1))
        for begin in range(0, len(places), width):
            yield as_slice(places[begin : begin + width])
