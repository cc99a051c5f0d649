"""The motion of a large linear system under a record of even samples: of a long one its modes are kept at every sixteenth knot only.

Those at the knots between are made from these, all groups of sixteen knots a step at once: of a long record where they are asked for,
so that memory stays near that of the answer, of another one for all knots the first time.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..signals.restarts import as_slice
from .pieces import Pieces

if TYPE_CHECKING:
    from .flow import Flow

#: So many knots are a group: with more of them a step of all groups at once is too short, with fewer more is kept.
GROUP = 16

#: Up to so many modes of all knots are kept, 32 MB: to read them takes a tenth less of the time of all values than to make them again.
KEPT = 2_000_000

#: So many groups are made at once.
TOGETHER = 64


def pieces_of(flow: Flow) -> Pieces | None:
    """None where gaps are few, or long beside the motion."""
    found = Pieces.of(flow)
    if found is None or found.long[:-1].any() or (found.gaps != found.gaps[0]).any():
        return found
    return EvenPieces(flow, found.modes, found.middle, found.long, found.parts)


class EvenPieces(Pieces):
    """A flow whose gaps all are short, and one as long as the other; of ``states`` the first are those of each group."""

    def _modes_from(self, first) -> np.ndarray:
        gained = (self._each[GROUP - 1 :: -1, None] * self._drive).reshape(-1, len(first))
        found = (self._given @ gained.view(float)).view(complex)
        following, across = first, np.exp(self.modes.rates * (self.gaps[0] * GROUP))
        for begin in found:
            begin[:], following = following, across * following + begin
        return found

    def _modes_at(self, piece) -> np.ndarray:
        if self._every is None:
            groups, which = np.unique(piece // GROUP, return_inverse=True)
            return self._within(groups)[piece % GROUP, which]
        return self._every[as_slice(piece)]

    @cached_property
    def _every(self) -> np.ndarray | None:
        """The modes at all knots, shape (K or somewhat more, p); None of a long record."""
        groups, p = self.states[0].shape
        if groups * GROUP * p > KEPT:
            return None
        found = np.empty((groups, GROUP, p), dtype=complex)
        for begin in range(0, groups, TOGETHER):
            at = slice(begin, begin + TOGETHER)
            found[at] = self._within(at).transpose(1, 0, 2)
        return found.reshape(-1, p)

    def _within(self, groups) -> np.ndarray:
        """The modes at the knots of some groups, shape (GROUP, number of groups, p)."""
        begins, given = self.states[0][groups], self._given[groups]
        found, part = np.empty((GROUP, *begins.shape), dtype=complex), np.empty_like(begins)
        given = given.reshape(len(given), GROUP, -1)[:, :-1].transpose(1, 0, 2).reshape(len(given) * (GROUP - 1), -1)
        np.matmul(given, self._drive.view(float), out=found[1:].reshape(len(given), -1).view(float))
        found[0] = begins
        for before, after in pairwise(found):
            after += np.multiply(before, self._each[1], out=part)
        return found

    @cached_property
    def _each(self) -> np.ndarray:
        """e^{s h i} for every i of a group, shape (GROUP, p)."""
        return np.exp(np.multiply.outer(self.gaps[0] * np.arange(GROUP), self.modes.rates))

    @cached_property
    def _drive(self) -> np.ndarray:
        """What states of the force add to the modes within one gap, complex, shape (m, p)."""
        m = self._inputs.shape[1]
        return self._stepped(np.full(m, self.gaps[0]), np.eye(m))[1]

    @cached_property
    def _given(self) -> np.ndarray:
        """The states of the force at all knots of a group side by side, one row for each group."""
        count, m = self._inputs.shape
        groups = -(-count // GROUP)
        found = np.zeros((groups * GROUP, m))
        found[:count] = self._inputs
        return found.reshape(groups, GROUP * m)
