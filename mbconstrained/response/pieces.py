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
from typing import TYPE_CHECKING

import numpy as np

from ..linalg.exponential import BlockGroups, block_states
from ..linalg.kinds import full
from ..linalg.modes import Modes
from ..linalg.recursion import advance, powers, scanned, shared_gaps
from ..linalg.scaling import balanced_norm
from ..tolerances import EPS

if TYPE_CHECKING:
    from .flow import Flow, FlowFunction

#: A gap is short where nothing turns farther within it, rate times length, and the exponential for half of it takes so many terms:
#: 2^27 / 27! is far below EPS.
SHORT, TERMS = 4.0, 27

#: So many numbers of one table are made at once.
TABLE = 200_000

#: Fewer pieces are not worth it, and more long gaps neither.
FEW_PIECES, MANY_LONG = 64, 8


@dataclass(frozen=True, eq=False)
class Pieces:
    """A flow whose short gaps one table serves.

    Attributes:
        flow: the motion and its force.
        modes: those of S.
        middle: half of the longest short gap, s.
        long: which pieces are longer, the last one being endless.
    """

    flow: Flow
    modes: Modes
    middle: float
    long: np.ndarray

    @staticmethod
    def of(flow: Flow) -> Pieces | None:
        """None where gaps are few, or long beside the motion."""
        gaps, states = np.diff(flow.knots), flow.force.smooth.restarts.states
        if len(gaps) < FEW_PIECES or not len(states) or not len(flow.start):  # nothing acts, or on nothing that moves
            return None
        short = gaps * balanced_norm(flow.generator) <= SHORT
        long = np.append(~short, True)
        acting = long[:-1] & states[:, :-1].any(axis=0)  # what a force does in a long gap would have to be known at its end
        if short.sum() < FEW_PIECES or long.sum() > MANY_LONG or acting.any():
            return None
        return Pieces(flow, Modes.of(flow.reduction.decoupled), float(gaps[short].max()) / 2, long)

    @cached_property
    def states(self) -> tuple[np.ndarray, np.ndarray]:
        """The modes at every knot, complex, shape (K, p), and the states of what is left, shape (q, K)."""
        flow, modes, gaps = self.flow, self.modes, shared_gaps(self.flow.knots)
        driven = self._driven[: len(flow.start)]
        gains = modes.split(flow.reduction.decoupled.coordinates(driven.reshape(len(driven), -1)))
        by_mode = np.ascontiguousarray(gains[0].T).view(float)
        found, rest = np.empty((len(self.long), len(modes.rates)), dtype=complex), np.zeros((len(modes.rest), len(self.long)))
        found[0], rest[:, 0] = modes.split(flow.reduction.decoupled.coordinates(flow.start))
        begin = 0
        for end in np.flatnonzero(self.long):
            self._scan(found[begin : end + 1], gaps[begin:end], self._inputs[begin:end], by_mode)
            if end < len(gaps):
                moved = np.exp(modes.rates * gaps[end]) * found[end]
                found[end + 1] = np.where(found[end] == 0, 0.0, moved)  # what is zero stays zero, however fast it would grow
            begin = end + 1
        if len(rest):
            for at in self._chunks(np.flatnonzero(~self.long)):
                rest[:, 1:][:, at] = gains[1] @ self._beside(self._powers(gaps[at]), self._inputs[at]).T
            advance(modes.blocks, rest, gaps)
        return found, rest

    def _scan(self, found, gaps, inputs, gains) -> None:
        """From the first state of a run of short gaps to the others, in place."""
        different, which = np.unique(gaps, return_inverse=True)
        table = self._powers(different)
        if len(different) == 1:
            taken = table[0] @ gains.reshape(inputs.shape[1], table.shape[1], -1)
            found[1:] = (inputs @ taken).view(complex)
            scanned(found, (table @ self._table).view(complex))
        elif len(gaps):
            table, factors = table[which], np.empty((len(gaps), found.shape[1]), dtype=complex)
            for at in self._chunks(np.arange(len(gaps))):
                found[1:][at] = (self._beside(table[at], inputs[at]) @ gains).view(complex)
                factors[at] = (table[at] @ self._table).view(complex)
            scanned(found, factors)

    def values(self, asked: FlowFunction, times: np.ndarray) -> np.ndarray:
        """Of a function of this flow, shape (r, T)."""
        piece, since = self.flow.force.smooth.start.located(times)
        n, output, late = len(self.flow.start), asked.output, self.long[piece]
        made, driven = self._between, output @ self._driven.reshape(output.shape[1], -1)
        if not since.any():
            made, driven, late = self._at_knots, full(output[:, n:]), np.zeros(len(times), dtype=bool)
        own, others = self.modes.seen(asked.place[:, :n], asked.order)
        coefficients, found = np.hstack([own, driven, others]), np.empty((len(own), len(times)))
        for at in self._chunks(np.flatnonzero(~late)):
            found[:, at] = coefficients @ made(piece[at], since[at]).T
        for number in np.unique(piece[late]):
            at = np.flatnonzero(piece == number)
            found[:, at] = self._alone(number, asked)._values(since[at])
        return found

    def _between(self, piece, since) -> np.ndarray:
        """What makes values within short gaps, one row for each: modes, powers of time with states of the force, and the rest."""
        (states, rest), table, inputs = self.states, self._powers(since), self._inputs[piece]
        modes = self._table.shape[1]
        begin = modes + inputs.shape[1] * table.shape[1]
        found = np.empty((len(since), begin + len(rest)))
        np.matmul(table, self._table, out=found[:, :modes])
        moved = found[:, :modes].view(complex)
        moved *= states[piece]
        np.einsum("tm,tk->tmk", inputs, table, out=found[:, modes:begin].reshape(*inputs.shape, -1))
        if len(rest):
            found[:, begin:] = block_states(self._groups, rest[:, piece], since).T
        return found

    def _at_knots(self, piece, since) -> np.ndarray:
        """The same at knots: modes, states of the force, and the rest."""
        states, rest = self.states
        return np.hstack([states[piece].view(float), self._inputs[piece], rest[:, piece].T])

    def _alone(self, number: int, asked: FlowFunction) -> FlowFunction:
        """A piece as a motion of its own."""
        states, rest = self.states
        return type(asked)(self.flow.after(number, self.modes.states(states[number], rest[:, number])), asked.place, asked.order)

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
            part = places[begin : begin + width]
            in_order = part[-1] - part[0] == len(part) - 1
            yield slice(part[0], part[-1] + 1) if in_order else part
