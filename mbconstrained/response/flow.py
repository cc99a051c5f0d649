"""Functions of time y = P z of a large linear system z' = S z that are evaluated in the way that costs least.

For even times and the first time powers of e^{S h} by blocks, no decomposition at all (``linalg.propagation``); for other times,
few rows, or when it is asked again, the eigenvectors. Just after t = 0 the Taylor series, in which nothing cancels.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse

from ..checks import real_array, real_number, whole_number
from ..linalg.blocks import CHUNK_ENTRIES, block_slices
from ..linalg.kinds import Matrix, alike, below, beside, full, nothing
from ..linalg.oscillations import even_step
from ..linalg.propagation import Propagator
from ..linalg.scaling import balanced_norm
from ..polynomial.reduction import Reduction
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from .cost import decomposition_cost, stepping_cost
from .driven import Driven
from .even_pieces import pieces_of
from .forcing import units_of_pieces
from .pieces import Pieces
from .records import record_values
from .regular import FinitePart, driven_motion

#: The Taylor series serves for |S t| <= EARLY, with so many terms: 2^27/27! is far below EPS. After a start from rest sums of modes
#: still cancel there, by as many digits as a force begins slowly.
EARLY, TERMS = 2.0, 27

#: Pieces of a force larger than this are not measured as they are: products of such units leave the range of float64.
STEEPEST = 2.0**100

#: Fewer times than these are not worth the powers of e^{S h}.
FEW_TIMES = 32


@dataclass(eq=False)
class Flow:
    """z = (w, v): the states w of A(s) and v of the force, from their start.

    Attributes:
        reduction: the equations w' = S w + ....
        force: f, its states v.
        start: w at 0+, shape (n,).
        drive: D with w' = S w + D v, shape (n, m).
        spent: what has been evaluated by powers so far (``response.cost``).
    """

    reduction: Reduction
    force: ImpulsiveSmooth
    start: np.ndarray
    drive: Matrix
    spent: float = field(default=0.0, init=False)

    @cached_property
    def generator(self) -> Matrix:
        """[[S, D], [0, J]]."""
        S, m = self.reduction.generator, self.force.smooth.state_count
        if not m:
            return S
        J = alike(self.force.smooth.generator, S)
        return below(beside(S, self.drive), beside(nothing((m, S.shape[0]), S), J))

    @cached_property
    def knots(self) -> np.ndarray:
        """The times at which the force may change, the first is 0."""
        return self.force.knots

    @cached_property
    def start_with_force(self) -> np.ndarray:
        """z at 0+."""
        return np.concatenate([self.start, self.force.smooth.start_at_zero])

    @cached_property
    def norm(self) -> float:
        """Of the generator, its states in units that balance it, in 1/s."""
        return balanced_norm(self.generator)

    @cached_property
    def rate(self) -> float:
        """What no motion changes faster than, in 1/s: a norm of the generator, its states in units that balance it, or of its modes.

        Where nothing but powers of t is there, any rate serves.
        """
        if "decoupled" not in self.reduction.__dict__:
            return self.norm or 1.0
        blocks = (*self.reduction.decoupled.blocks, *self.force.smooth.blocks)
        return max((sum(map(abs, column)) for block in blocks for column in block.T.tolist()), default=0.0) or 1.0

    @cached_property
    def states(self) -> BohlFunction:
        """z as a sum of modes; where no force acts without rows: the modes of S are seen through what is asked for alone."""
        return self._decoupled[0]

    def seen(self, place: Matrix) -> np.ndarray:
        """C of place @ z = C e^{J t} v, J and v those of ``states``."""
        if not self.force.smooth.state_count:
            return self.reduction.decoupled.seen(place)
        used = np.flatnonzero(abs(place).sum(axis=0))
        return place[:, used] @ self.states.coefficients[used]

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separates the modes."""
        return self._decoupled[1]

    @cached_property
    def _decoupled(self) -> tuple[BohlFunction, float]:
        self._propagator = None  # of no more use
        smooth, n = self.force.smooth, len(self.start)
        m, free = smooth.coefficients.shape[1], self.reduction.decoupled
        if not m:
            return BohlFunction(np.zeros((0, n)), free.blocks, free.coordinates(self.start)), free.coupling
        units = np.ones(m)
        for block, at in zip(smooth.blocks, block_slices(smooth.blocks)):
            found = units_of_pieces(smooth, block, at)
            units[at] = found if found is not None and found.max() <= STEEPEST else 1.0
        generator, through = smooth.generator * units / units[:, None], np.eye(n + m)[:, n:] * units
        driven = Driven(full(self.drive) * units, generator, through, units)
        kicks = np.broadcast_to(np.zeros((n, 1)), (n, len(self.knots) - 1))
        part = FinitePart(free, scipy.sparse.eye_array(n + m, n), driven, self.start, kicks, 1.0, np.ones(n + m))
        return driven_motion(part, self.force)

    def turned(self, times: np.ndarray) -> float | None:
        """|S| h for even times 0, h, 2 h, ..., None where powers of e^{S h} do not serve."""
        step = even_step(times) if len(times) >= FEW_TIMES and times[0] == 0 and len(self.knots) == 1 else None
        return None if step is None else self.rate * step

    def stepped(self, output: Matrix, times: np.ndarray) -> np.ndarray | None:
        """output @ z at even times from 0 on by powers, None where that is not possible or costs more than the modes."""
        known = "_decoupled" in self.__dict__ or "decoupled" in self.reduction.__dict__
        turned = None if known or self.reduction.is_small else self.turned(times)
        if turned is None:
            return None
        step = float(times[-1]) / (len(times) - 1)
        known = self._propagator if self._propagator and self._propagator.step == step else None
        cost = stepping_cost(self.generator.shape[0], len(times), turned, known is not None)
        if not self._is_less((2 if self.spent else 1) * (self.spent + cost)):
            return None
        self._propagator = known or Propagator(self.generator, step)
        self.spent += cost
        return self._propagator.values(output, self.start_with_force, len(times))

    def _is_less(self, cost: float) -> bool:
        """Than decoupling S; by its couplings that is tried first, as it may turn out not to be possible."""
        if cost <= decomposition_cost(self.reduction):
            return True
        return cost <= decomposition_cost(self.reduction, by_couplings=False) and self.reduction.is_refused

    _propagator: Propagator | None = field(default=None, init=False)

    @cached_property
    def pieces(self) -> Pieces | None:
        """The motion under a force that starts anew often."""
        self._propagator = None  # of no more use
        return pieces_of(self)

    def after(self, knot: int, states: np.ndarray) -> Flow:
        """The motion after a knot as one of its own, for states w there."""
        smooth = self.force.smooth
        smooth = BohlFunction(smooth.coefficients, smooth.blocks, smooth.restarts.states[:, knot])
        return Flow(self.reduction, ImpulsiveSmooth(smooth), states, self.drive)

    @cached_property
    def _powers(self) -> np.ndarray:
        """(S / unit)^k z / k! at 0+ for k = 0, 1, ... as columns."""
        columns, step = [self.start_with_force], self.generator / self._unit
        longest = max(map(len, self.force.smooth.blocks), default=0)  # a force may begin like a power of t
        for _ in range(1, TERMS + longest):
            columns.append(step.dot(columns[-1]))  # less to do before it starts than @
        return np.array(columns).T / np.cumprod(np.maximum(np.arange(float(len(columns))), 1.0))

    @cached_property
    def _unit(self) -> float:
        """The rate to a power of two: dividing by it costs no rounding."""
        return float(2.0 ** np.floor(np.log2(self.rate)))

    @cached_property
    def early_end(self) -> float:
        """Until when the Taylor series at 0+ serves: rate * t <= EARLY, and the force does not change."""
        return min(EARLY / self.rate, float(self.knots[1:2].min(initial=np.inf)))

    def early(self, output: Matrix, times: np.ndarray) -> np.ndarray:
        """output @ z before ``early_end``."""
        series = output @ self._powers
        return series @ np.power.outer(self._unit * times, np.arange(series.shape[1])).T


class FlowFunction(BohlFunction):
    """P z(t), P of shape (r, n); a Bohl function whose blocks are found when something needs them.

    >>> from mbconstrained.polynomial.matrix import PolynomialMatrix
    >>> from mbconstrained.response.reduced import reduced_solution
    >>> from mbconstrained.signals.inputs import zero
    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> cosine = reduced_solution(A, np.array([[1.0], [0.0]]), zero(1)).function
    >>> bool(np.isclose(cosine(0.5)[0], np.cos(1.0)))
    True
    """

    def __init__(self, flow: Flow, place: Matrix, order: int = 0):
        """The derivative of this order of place @ z."""
        output = place
        for _ in range(order):
            output = output @ flow.generator
        for name, value in (("flow", flow), ("place", place), ("order", order), ("output", output)):
            object.__setattr__(self, name, value)

    @property
    def modal(self) -> BohlFunction:
        """The same as a sum of modes: each is differentiated by itself, slow ones lose nothing beside fast ones."""
        found = BohlFunction(self.flow.seen(self.place), self.blocks, self.start)
        return found.derivative(self.order) if self.order else found

    @property
    def _groups(self):
        return self.flow.states._groups

    @property
    def _turning(self):
        return self.flow.states._turning

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
        """As ``BohlFunction``: what cancels in its modes is not solved in them (``response.cancellation``)."""
        return np.full(self.size, np.inf)

    def _values(self, times) -> np.ndarray:
        values = self.flow.stepped(self.output, times)
        if values is None:
            values = record_values(self, times)
        if values is None:
            values = super()._values(times)
        early = (times < self.flow.early_end).nonzero()[0]
        width = max(1, CHUNK_ENTRIES // max(self.size, TERMS))
        for part in (early[begin : begin + width] for begin in range(0, len(early), width)):
            values[:, part] = self.flow.early(self.output, times[part])
        return values

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative."""
        return FlowFunction(self.flow, self.place, self.order + whole_number(order, "order"))

    def mapped(self, matrix) -> BohlFunction:
        """matrix @ y(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return FlowFunction(self.flow, alike(matrix, self.place) @ self.place, self.order)

    def rows(self, indices) -> BohlFunction:
        """Some of its rows, in this order."""
        return FlowFunction(self.flow, self.place[np.asarray(indices, dtype=int)], self.order)

    def __mul__(self, factor: float) -> BohlFunction:
        return FlowFunction(self.flow, self.place * real_number(factor, "factor"), self.order)

    __rmul__ = __mul__
