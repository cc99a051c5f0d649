"""The answer of a state space: its states as a response, and its outputs with their own jumps and impulses.

The outputs are not put together from the states: [[s E - A, 0], [-C, I]] [x; y] = [B; D] u is solved as a whole. So what
cancels in C x + D u is decided with the rounding noise of the data, and an output far from the input begins as accurately as
a state does.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..notices import Notice
from ..response import Event, Response, solve
from ..response.estimate import error_estimate
from ..response.transfer.engine import checked_input
from ..signals import BohlFunction, ImpulsiveSmooth, zero

if TYPE_CHECKING:
    from ..exact.enclosure import Enclosure, ExactResponse
    from .state_space import StateSpace


@dataclass(frozen=True, repr=False)
class StateSpaceResponse(Response):
    """x(t), a ``Response`` of the states to E x' = A x + B u, and y = C x + D u.

    u is zero before t = 0, so that y(0-) = C x(0-).

    Attributes:
        system: the state space.
        input: u, p rows.
        rank_tolerance: as given to ``solve``.
    """

    system: StateSpace
    input: ImpulsiveSmooth
    rank_tolerance: float | None = None

    def __repr__(self) -> str:
        if not self.system.outputs:
            return super().__repr__()
        return type(self).__name__ + repr(self.together).removeprefix("Response")

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Jumps, impulses, growth, doubtful decisions, of states and outputs."""
        return self.together.notices if self.system.outputs else super().notices

    def output(self, times) -> np.ndarray:
        """The regular part of y at a time (-> (q,)) or at times (T,) (-> (q, T)); t = 0 means 0+."""
        return self.output_function(times)

    @cached_property
    def together(self) -> Response:
        """x and y, one below the other, as one response of n + q rows."""
        start = start_with_outputs(self.system, self.initial[0])
        force = force_with_outputs(self.system, self.input)
        return solve(self.system.polynomial_matrix_with_outputs(), start, force, self.rank_tolerance)

    @cached_property
    def output_function(self) -> BohlFunction:
        """y for t > 0 in closed form, q rows."""
        return self.output_of(self.together)

    def output_of(self, together: Response) -> BohlFunction:
        """The outputs among the rows of a response of x and y."""
        return together.function.mapped(np.eye(together.function.size)[len(self.system.states) :])

    @property
    def output_initial(self) -> np.ndarray:
        """y(0-) = C x(0-), shape (q,)."""
        return self.together.initial[0, len(self.system.states) :]

    @property
    def output_jump(self) -> np.ndarray:
        """y(0+) - y(0-), shape (q,); exactly zero where nothing jumps."""
        return self.together.jump[0, len(self.system.states) :]

    @property
    def output_impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (q,); the k-th multiplies the k-th derivative of Dirac's delta at t = 0 in y."""
        return _rows(self.together.impulses, len(self.system.states))

    @property
    def output_events(self) -> tuple[Event, ...]:
        """Jumps and impulses of y after t = 0, by ascending time."""
        n = len(self.system.states)
        found = [Event(event.time, event.jump[:, n:], _rows(event.impulses, n)) for event in self.together.events]
        return tuple(event for event in found if event.jump.any() or event.impulses)

    @cached_property
    def exact_output(self) -> ExactResponse:
        """The exact answer of y, the data taken as the numbers that they are, q rows."""
        whole = self.together.exact
        return whole.with_rows(range(len(self.system.states), whole.size))

    def enclose_output(self, times, digits: int = 15, *, order: int = 0) -> Enclosure:
        """Intervals that are sure to contain y, or a derivative of it, as ``enclose`` does for x."""
        from ..exact.enclosure import structure_notices

        found = self.exact_output.enclose(times, digits, order=order)
        return found.with_notices(structure_notices(self.together, self.exact_output))

    def output_error_estimate(self, times) -> float:
        """Estimate of max |error| / max |y| over the times."""
        return error_estimate(self.together, times, self.output_of)


def state_space_response(system: StateSpace, start: np.ndarray, u, rank_tolerance: float | None) -> StateSpaceResponse:
    """Solve E x' = A x + B u from x(0-), shape (n,)."""
    u = zero(len(system.inputs)) if u is None else checked_input(u, len(system.inputs), "input")
    response = solve(system.polynomial_matrix(), start[None, :], u.mapped(system.B), rank_tolerance)
    found = {field.name: getattr(response, field.name) for field in fields(response)}
    return StateSpaceResponse(**found, system=system, input=u, rank_tolerance=rank_tolerance)


def start_with_outputs(system: StateSpace, start: np.ndarray) -> np.ndarray:
    """[x(0-); C x(0-)] as the only row, the sums rounded once."""
    exact = [Fraction(value) for value in start.tolist()]
    outputs = [float(sum((Fraction(c) * x for c, x in zip(row, exact)), Fraction(0))) for row in system.C.tolist()]
    return np.array([[*start, *outputs]])


def force_with_outputs(system: StateSpace, u: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """[B; D] u."""
    return u.mapped(np.vstack([system.B, system.D]))


def _rows(impulses, first: int) -> tuple[np.ndarray, ...]:
    found = [impulse[first:] for impulse in impulses]
    while found and not found[-1].any():
        found.pop()
    return tuple(found)
