"""The response of a state space: its states, and its outputs with their own jumps and impulses.

The outputs are not computed from the states: [[s E - A, 0], [-C, I]] [x; y] = [B; D] u is solved as a whole. So cancellation in
C x + D u is decided with the rounding errors of the data, and an output far from the input starts as accurately as a state.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..ground.display import TextTable
from ..ground.notices import Notice
from ..response.estimate import error_estimate
from ..response.events import Event
from ..response.response import Response
from ..response.solve import solve
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from .state_equations import StateEquations

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse
    from ..exact.enclosure.intervals import Enclosure


@dataclass(frozen=True, repr=False, eq=False)
class StateSpaceResponse(Response):
    """x(t), a ``Response`` of the states to E x' = A x + B u, and y = C x + D u.

    u is zero before t = 0, so that y(0-) = C x(0-).

    Attributes:
        system: the state space.
        input: u, p rows.
    """

    system: StateEquations
    input: ImpulsiveSmooth

    def _summary(self) -> str:
        return self.together._summary() if self.system.outputs else super()._summary()

    def _tables(self) -> tuple[TextTable, ...]:
        return self.together._tables() if self.system.outputs else super()._tables()

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on jumps, impulses, growth and doubtful decisions, for states and outputs."""
        return self.together.notices if self.system.outputs else super().notices

    def output(self, times) -> np.ndarray:
        """The regular part of y at a time (-> (q,)) or at times (T,) (-> (q, T)); t = 0 means 0+."""
        return self.output_function(times)

    @cached_property
    def together(self) -> Response:
        """x and y, one below the other, as one response of n + q rows."""
        system = self.system
        start, force = system.start_with_outputs(self.initial[0]), system.force_with_outputs(self.input)
        return solve(system.polynomial_matrix_with_outputs(), start, force, self.problem.rank_tolerance)

    @cached_property
    def output_function(self) -> BohlFunction:
        """y for t > 0 in closed form, q rows."""
        return self.output_of(self.together)

    def output_of(self, together: Response) -> BohlFunction:
        """Return the outputs among the rows of a response of x and y."""
        return together.function.mapped(np.eye(together.function.size)[len(self.system.states) :])

    @property
    def output_initial(self) -> np.ndarray:
        """y(0-) = C x(0-), shape (q,)."""
        return self.together.initial[0, len(self.system.states) :]

    @property
    def output_jump(self) -> np.ndarray:
        """y(0+) - y(0-), shape (q,); exactly zero where it is continuous."""
        return self.together.jump[0, len(self.system.states) :]

    @property
    def output_impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (q,); the k-th multiplies the k-th derivative of Dirac's delta at t = 0 in y."""
        return _rows(self.together.impulses, len(self.system.states))

    @property
    def output_events(self) -> tuple[Event, ...]:
        """Jumps and impulses of y after t = 0, by ascending time."""
        n = len(self.system.states)
        events = [Event(event.time, event.jump[:, n:], _rows(event.impulses, n)) for event in self.together.events]
        return tuple(event for event in events if event.jump.any() or event.impulses)

    @cached_property
    def exact_output(self) -> ExactResponse:
        """The exact answer of y, for the data taken exactly, q rows."""
        whole = self.together.exact
        return whole.with_rows(range(len(self.system.states), whole.size))

    def enclose_output(self, times, digits: int = 15, *, order: int = 0) -> Enclosure:
        """Return intervals that are guaranteed to contain y, or a derivative of it, as ``enclose`` does for x.

        Args:
            times: a time or shape (T,), in s.
            digits: correct digits, at least.
            order: order of the derivative.

        Returns:
            Lower and upper bounds, shape (q,) or (q, T).
        """
        from ..exact.enclosure.exact_response import structure_notices

        enclosure = self.exact_output.enclose(times, digits, order=order)
        return enclosure.with_notices(structure_notices(self.together.solution.finite_count, self.exact_output))

    def output_error_estimate(self, times) -> float:
        """Return an estimate of max |error| / max |y| over the times."""
        return error_estimate(self.together, times, self.output_of)


def _rows(impulses, first: int) -> tuple[np.ndarray, ...]:
    parts = [impulse[first:] for impulse in impulses]
    while parts and not parts[-1].any():
        parts.pop()
    return tuple(parts)
