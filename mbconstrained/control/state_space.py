"""E x' = A x + B u, y = C x + D u, with E singular or not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..frequency.frequency_response import FrequencyResponse, evaluated
from ..frequency.harmonic import Harmonic
from ..ground.by_name import answering
from ..ground.display import TextTable
from ..ground.notices import Notice
from ..response.estimate import error_estimate
from ..response.events import Event, without_zeros
from ..response.response import Response
from ..response.solve import solve
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import named_rows, zero
from .conversions import factored_realization, ordinary_form, rational_realization, realization_of, to_control, to_scipy
from .rational import checked_input
from .state_equations import StateEquations, channel_places, delays_of_inputs, transfer_of

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse
    from ..exact.enclosure.intervals import Enclosure
    from .discrete_time import DiscreteStateSpace


# The response of a state space: its states, and its outputs with their own jumps and impulses.
#
# The outputs are not computed from the states: [[s E - A, 0], [-C, I]] [x; y] = [B; D] u is solved as a whole. So cancellation in
# C x + D u is decided with the rounding errors of the data, and an output far from the input starts as accurately as a state.


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
        return without_zeros([impulse[len(self.system.states) :] for impulse in self.together.impulses])

    @property
    def output_events(self) -> tuple[Event, ...]:
        """Jumps and impulses of y after t = 0, by ascending time."""
        n = len(self.system.states)
        events = [
            Event(event.time, event.jump[:, n:], without_zeros([one[n:] for one in event.impulses]))
            for event in self.together.events
        ]
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


@answering
class StateSpace(StateEquations):
    """E x' = A x + B u, y = C x + D u, real, in continuous time, with E singular or not.

    Args:
        A: shape (n, n), n >= 1.
        B, C, D: shapes (n, p), (q, n), (q, p); no inputs, no outputs and zero by default.
        descriptor: E, shape (n, n); the identity by default.
        states, inputs, outputs: names; x1, ..., u1, ..., y1, ... by default.
        units: units of states, inputs and outputs by name; "1" by default.

    Raises:
        InputError: shapes that do not match, entries that are not finite real numbers, names used twice.

    >>> motor = StateSpace([[-2.0]], [[2.0]], [[1.0]], outputs=["speed"], units={"speed": "rad/s"})
    >>> motor
    StateSpace(1 state, 1 input, 1 output)
    >>> from mbconstrained import step
    >>> bool(np.isclose(motor.solve(input=step([1.0])).output(0.5)[0], 1 - np.exp(-1)))
    True
    """

    def solve(self, initial=None, input: ImpulsiveSmooth | None = None, rank_tolerance: float | None = None) -> StateSpaceResponse:
        """Solve for x and y on t >= 0 in closed form, from any x(0-), also where E is singular and x(0-) is inconsistent.

        Args:
            initial: x(0-), shape (n,), or a mapping from names of states to numbers, zero for the others; None for zeros.
            input: u with p rows, see ``mbconstrained.signals``, or by name, such as {"u": mb.step(1.0)}; from t = 0 on. None for zero.
            rank_tolerance: see ``mbconstrained.solve``.

        Returns:
            The states, a ``Response``, with the outputs.

        Raises:
            InputError: shapes that do not match, unknown names.
            SingularPolynomialMatrix: det (s E - A) = 0 for every s.
        """
        places = {name: place for place, name in enumerate(self.inputs)}
        if isinstance(input, Mapping):
            input = named_rows(input, places, len(places), "input", "input")
        u = zero(len(places)) if input is None else checked_input(input, len(places), "input")
        response = solve(self._pencil, self.start(initial)[None, :], u.mapped(self.B), rank_tolerance)
        return StateSpaceResponse(response.problem, response.solution, self, u)

    def frequency_response(
        self, frequencies_hz="auto", inputs=None, outputs=None, *, delays: Mapping[str, float] | None = None
    ) -> FrequencyResponse:
        """Return the frequency response G(i w) = C (i w E - A)^-1 B + D with error estimates, poles, residues and polynomial part.

        Args:
            frequencies_hz: in Hz, shape (F,), or "auto", placed by the poles.
            inputs, outputs: names or numbers from 0; all by default.
            delays: dead times of inputs in s by name, G_j(i w) e^(-i w delay_j).

        Returns:
            A ``FrequencyResponse``.

        Raises:
            InputError: unknown names, negative delays, frequencies that are negative or not finite.
            SingularPolynomialMatrix: det (s E - A) = 0 for every s.

        >>> lag = StateSpace([[-2.0]], [[2.0]], [[1.0]])
        >>> lag.frequency_response([1 / np.pi]).values.item()
        (0.5-0.5j)
        >>> complex(lag.frequency_response([1 / np.pi], delays={"u1": np.pi / 4}).values.round(15).item())
        (-0.5-0.5j)
        """
        late = delays_of_inputs(self, delays)
        columns, rows = channel_places(inputs, self.inputs, "input"), channel_places(outputs, self.outputs, "output")
        own_inputs, own_outputs = [self.inputs[j] for j in columns], [self.outputs[i] for i in rows]
        n, q = len(self.A), len(self.C)
        B, C = np.vstack([self.B, self.D])[:, columns], np.eye(n + q)[n:][rows]
        units = [[_unit_ratio(self.units[output], self.units[input]) for input in own_inputs] for output in own_outputs]
        names = tuple(own_inputs), tuple(own_outputs)
        harmonic = Harmonic(self._pencil_with_outputs, B, C, 0, None, None, *names, np.array(units), "transfer function")
        own = tuple(late[j] for j in columns) if any(late) else ()
        return evaluated(replace(harmonic, input_delays=own), frequencies_hz)

    transfer = transfer_of
    ordinary = ordinary_form
    to_scipy = to_scipy
    to_control = to_control

    def discretize(self, step: float, hold: int | str = 1, *, delays: Mapping[str, float] | None = None) -> DiscreteStateSpace:
        """Discretize exactly: the states and outputs at t = k step of the continuous system under a hold of its input.

            x_(k+1) = Phi x_k + integral over a step of e^(A (h - s)) B u(k h + s) ds

        by exponentials of matrices in ball arithmetic. A singular E (massless coordinates, constraints): the finite Jordan pair is
        discretized, the constant of the polynomial part of G(s) goes into D, jumps of an inconsistent start into the map of the start; a
        part that follows the derivative of an input needs hold=1, where it is the slope of the interval before the sample.

        Args:
            step: h in s.
            hold: how the input continues between samples: 0 constant, 1 linear (then states are those of the continuous system less a
                multiple of the input, as in ``scipy.signal.cont2discrete``), "impulse" for Dirac impulses of size u_k at the samples, y_k
                just after them.
            delays: delays of inputs in s by name: multiples of the step and parts of it, as exact extra states. A delayed linear hold
                begins with its rise from u_-1 = 0 to u_0.

        Returns:
            A ``DiscreteStateSpace`` with the names of inputs and outputs.

        Raises:
            InputError: a step that is not positive, an unknown hold or input, an output that would have Dirac impulses.

        >>> double = StateSpace([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]])
        >>> zero_order = double.discretize(0.5, hold=0)
        >>> zero_order.A.tolist(), zero_order.B.tolist()
        ([[1.0, 0.5], [0.0, 1.0]], [[0.125], [0.5]])
        """
        from .discrete_time import DiscreteStateSpace  # balls, which nothing else here needs

        return DiscreteStateSpace.of_continuous(self, step, hold, delays)

    def to_dict(self) -> dict:
        """A, B, C, D, E, and lists of states, inputs, outputs and their units, as plain data.

        >>> StateSpace([[-2.0]], [[1.0]], [[1.0]]).to_dict()["A"].tolist()
        [[-2.0]]
        """
        matrices = {name: getattr(self, name).copy() for name in "ABCDE"}
        names = {key: list(getattr(self, key)) for key in ("states", "inputs", "outputs")}
        return {**matrices, **names, "units": dict(self.units)}

    def dc_gains(self) -> np.ndarray | None:
        """G(0), shape (q, p); None where s E - A has a zero at 0."""
        if any(not zero.value for zero in self.polynomial_matrix().jordan_pairs().structure.finite_zeros):
            return None
        return self(0.0)

    @classmethod
    def from_transfer_function(cls, numerator, denominator, **names) -> StateSpace:
        """Return a realization of b(s)/a(s), highest powers first as in scipy.signal (``control.conversions``).

        Args:
            numerator, denominator: coefficients of one input and output; or of each, as lists of lists: numerator[output][input].
            names: states, inputs, outputs, units, as for the class.

        Returns:
            The state space.

        >>> double = StateSpace.from_transfer_function([2.0, 1.0], [1.0, 0.0, 0.0])  # (2 s + 1)/s^2
        >>> double(2.0).item()
        1.25
        """
        E, *matrices = rational_realization(numerator, denominator)
        return cls(*matrices, descriptor=E, **names)

    @classmethod
    def from_zeros_poles_gain(cls, zeros, poles, gain: float, **names) -> StateSpace:
        """Return a realization of gain prod(s - zeros)/prod(s - poles) as a series of sections of second order.

        Args:
            zeros, poles: complex numbers with their conjugates.
            gain: the factor.
            names: states, inputs, outputs, units, as for the class.

        Returns:
            The state space.

        >>> bool(np.isclose(StateSpace.from_zeros_poles_gain([], [-1 + 1j, -1 - 1j], 4.0)(0).item(), 2.0))
        True
        """
        E, *matrices = factored_realization(zeros, poles, gain)
        return cls(*matrices, descriptor=E, **names)

    @classmethod
    def from_scipy(cls, system) -> StateSpace:
        """Return the state space of a continuous-time scipy.signal ``StateSpace``, ``TransferFunction`` or ``ZerosPolesGain``.

        Raises:
            InputError: a discrete-time system, or another object.

        >>> import scipy.signal
        >>> StateSpace.from_scipy(scipy.signal.TransferFunction([1.0], [1.0, 2.0]))(0).item()
        0.5
        """
        return cls(**realization_of(system))

    @classmethod
    def from_control(cls, system) -> StateSpace:
        """Return the state space of a python-control ``StateSpace`` or ``TransferFunction`` with its names, as ``from_scipy``."""
        return cls(**realization_of(system))


def _unit_ratio(above: str, below: str) -> str:
    return "1" if above == below else above if below == "1" else f"{above}/({below})" if "/" in below else f"{above}/{below}"
