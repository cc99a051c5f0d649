"""The solution of the reduced equations: its function of time, its evidence and its notices.

Coordinates with mass keep their values at 0-, and coordinates with dampers only keep theirs; a coordinate that an algebraic equation
determines satisfies it at 0-, with its velocity, where mass or damping goes with it. All others take the values at 0+ that the
equations give them: they jump there without impulses, as they do where the force jumps later.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...ground.checks import real_array, real_number, whole_number
from ...ground.notices import Evidence, Notice, NoticeKind
from ...ground.tolerances import ROUNDED_FREE, noise_of, rounding_radius
from ...linalg.arrays import Matrix, of_like_kind
from ...linalg.exponential.powers import values_of_steps
from ...linalg.exponential.recursion import shared_gaps
from ...signals.bohl import BohlFunction
from ..choose import MODES, POWERS, STEPS, Evaluations, Method, Request, evaluation_method
from ..events import Event
from ..flow import Flow
from ..response_notices import growth_notice, modal_sums
from .record import record_of


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
        """Rows and states as ``response_notices.modal_sums``; for many states evaluated by powers at 0+ only.

        Args:
            count: number of derivatives.
            times: times in place of the default ones, shape (T,).

        Returns:
            Times, rows, states and the rate of the fastest motion.
        """
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
    """P z(t), P of shape (r, n), of the reduced equations z' = G z; a Bohl function whose blocks are computed when they are needed.

    >>> from mbconstrained import PolynomialMatrix, solve
    >>> cosine = solve(PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]]).function
    >>> bool(np.isclose(cosine(0.5)[0], np.cos(1.0)))
    True
    """

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
        for name, value in (("flow", flow), ("place", place), ("order", order), ("output", output), ("evaluations", evaluations)):
            object.__setattr__(self, name, value)

    @property
    def modal(self) -> BohlFunction:
        """The function as a sum of modes, each differentiated separately so that slow ones lose no accuracy relative to fast ones."""
        function = BohlFunction(self.flow.modal_output(self.place), self.blocks, self.start)
        return function.derivative(self.order) if self.order else function

    @property
    def _groups(self):
        return self.flow.states._groups

    @property
    def _oscillating_part(self):
        return self.flow.states._oscillating_part

    @property
    def coefficients(self) -> np.ndarray:
        """C of C e^{J t} v."""
        return self.modal.coefficients

    @property
    def blocks(self) -> tuple[np.ndarray, ...]:
        """The diagonal blocks of J."""
        return self.flow.states.blocks

    @property
    def start(self):
        """v, or ``Restarts``."""
        return self.flow.states.start

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
        values = self._evaluations[name](times)
        start = flow.taylor_start(modal=name == MODES)
        start.replace(values, times, self.output, lambda: np.abs(self.coefficients) @ np.abs(flow.states.start_at_zero))
        return values

    @property
    def _evaluations(self) -> dict[str, Callable[[np.ndarray], np.ndarray]]:
        return {MODES: self.by_modes, POWERS: self._by_powers, STEPS: self._by_steps}

    def by_modes(self, times: np.ndarray) -> np.ndarray:
        """The sum of modes, from t = 0 on."""
        record = record_of(self.flow)
        return super()._values(times) if record is None else record.values(self, times)

    def _by_powers(self, times: np.ndarray) -> np.ndarray:
        propagator = self.flow.propagator(float(times[-1]) / (len(times) - 1))
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

    def alone(self, flow: Flow) -> FlowFunction:
        """The function of a piece of the motion, evaluated at many times."""
        return FlowFunction(flow, self.place, self.order, "many")

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
