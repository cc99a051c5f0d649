"""Functions of time y = P z of a large linear system z' = S z that are evaluated in the way that costs least.

For even times and the first time powers of e^{S h} by blocks, no decomposition at all (``linalg.propagation``); for other times,
few rows, or when it is asked again, the eigenvectors. Just after t = 0 the Taylor series, in which nothing cancels.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array

from ..checks import real_array, real_number, whole_number
from ..linalg.exponential import CHUNK_ENTRIES
from ..linalg.oscillations import even_step
from ..linalg.propagation import Propagator
from ..linalg.scaling import balanced_norm
from ..polynomial.reduction import Reduction
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from .cost import decomposition_cost, stepping_cost
from .driven import Driven
from .regular import FinitePart, driven_motion

#: The Taylor series serves for |S t| <= EARLY, with so many terms: 2^27/27! is far below EPS. After a start from rest sums of modes
#: still cancel there, by as many digits as a force begins slowly.
EARLY, TERMS = 2.0, 27

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
    drive: csr_array
    spent: float = field(default=0.0, init=False)

    @cached_property
    def generator(self) -> csr_array:
        """[[S, D], [0, J]], sparse."""
        S, J = self.reduction.generator, csr_array(self.force.smooth.generator)
        return scipy.sparse.block_array([[S, self.drive], [None, J]], format="csr") if J.shape[0] else S

    @cached_property
    def start_with_force(self) -> np.ndarray:
        """z at 0+."""
        return np.concatenate([self.start, self.force.smooth.start_at_zero])

    @cached_property
    def rate(self) -> float:
        """What no motion changes faster than, in 1/s: a norm of the generator, its states in units that balance it."""
        return balanced_norm(self.generator)

    @cached_property
    def states(self) -> BohlFunction:
        """z as a sum of modes."""
        return self._decoupled[0]

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separates the modes."""
        return self._decoupled[1]

    @cached_property
    def _decoupled(self) -> tuple[BohlFunction, float]:
        self._propagator = None  # of no more use
        smooth, n = self.force.smooth, len(self.start)
        m = smooth.coefficients.shape[1]
        driven = Driven(self.drive.toarray(), smooth.generator, np.eye(n + m)[:, n:], np.ones(m))
        kicks = np.broadcast_to(np.zeros((n, 1)), (n, len(self.force.knots) - 1))
        free = self.reduction.decoupled
        part = FinitePart(free, scipy.sparse.eye_array(n + m, n), driven, self.start, kicks, 1.0, np.ones(n + m))
        return driven_motion(part, self.force)

    def turned(self, times: np.ndarray) -> float | None:
        """|S| h for even times 0, h, 2 h, ..., None where powers of e^{S h} do not serve."""
        step = even_step(times) if len(times) >= FEW_TIMES and times[0] == 0 and len(self.force.knots) == 1 else None
        return None if step is None else self.rate * step

    def stepped(self, output: csr_array, times: np.ndarray) -> np.ndarray | None:
        """output @ z at even times from 0 on by powers, None where that is not possible or costs more than the modes."""
        turned = self.turned(times)
        if turned is None or "_decoupled" in self.__dict__ or "decoupled" in self.reduction.__dict__:
            return None
        step, limit = float(times[-1]) / (len(times) - 1), decomposition_cost(self.reduction)
        known = self._propagator if self._propagator and self._propagator.step == step else None
        cost = stepping_cost(self.generator.shape[0], len(times), turned, known is not None)
        if self.spent + cost > (limit / 2 if self.spent else limit):
            return None
        self._propagator = known or Propagator(self.generator.toarray(), step)
        self.spent += cost
        return self._propagator.values(output, self.start_with_force, len(times))

    _propagator: Propagator | None = field(default=None, init=False)

    @cached_property
    def _powers(self) -> np.ndarray:
        """(S / rate)^k z / k! at 0+ for k = 0, 1, ... as columns."""
        columns = [self.start_with_force]
        rate, longest = self.rate, max(map(len, self.force.smooth.blocks), default=0)  # a force may begin like a power of t
        for k in range(1, TERMS + longest):
            columns.append(self.generator @ columns[-1] / (rate * k))
        return np.array(columns).T

    def early(self, output: csr_array, times: np.ndarray) -> np.ndarray:
        """output @ z for rate * t <= EARLY."""
        powers = self._powers
        return (output @ powers) @ np.power.outer(self.rate * times, np.arange(powers.shape[1])).T


class FlowFunction(BohlFunction):
    """P z(t), P sparse, shape (r, n); a Bohl function whose blocks are found when something needs them.

    >>> from mbconstrained.polynomial.matrix import PolynomialMatrix
    >>> from mbconstrained.response.reduced import reduced_solution
    >>> from mbconstrained.signals.inputs import zero
    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> cosine = reduced_solution(A, np.array([[1.0], [0.0]]), zero(1)).function
    >>> bool(np.isclose(cosine(0.5)[0], np.cos(1.0)))
    True
    """

    def __init__(self, flow: Flow, place: csr_array, order: int = 0):
        """The derivative of this order of place @ z."""
        output = place
        for _ in range(order):
            output = csr_array(output @ flow.generator)
        for name, value in (("flow", flow), ("place", place), ("order", order), ("output", output)):
            object.__setattr__(self, name, value)

    @cached_property
    def modal(self) -> BohlFunction:
        """The same as a sum of modes: each is differentiated by itself, slow ones lose nothing beside fast ones."""
        states = self.flow.states
        return BohlFunction(self.place @ states.coefficients, states.blocks, states.start).derivative(self.order)

    @property
    def coefficients(self) -> np.ndarray:
        """C of C e^{J t} v."""
        return self.modal.coefficients

    @property
    def blocks(self) -> tuple[np.ndarray, ...]:
        """The diagonal blocks of J."""
        return self.modal.blocks

    @property
    def start(self):
        """v, or ``Restarts``."""
        return self.modal.start

    @property
    def size(self) -> int:
        """Number of rows."""
        return self.output.shape[0]

    @property
    def state_count(self) -> int:
        """Number of states of A(s) and of the force."""
        return self.output.shape[1]

    def _values(self, times) -> np.ndarray:
        values = self.flow.stepped(self.output, times)
        if values is None:
            values = self.modal._values(times)
        early = np.flatnonzero((times * self.flow.rate <= EARLY) & (times < self.flow.force.knots[1:2].min(initial=np.inf)))
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
        return FlowFunction(self.flow, csr_array(csr_array(matrix) @ self.place), self.order)

    def rows(self, indices) -> BohlFunction:
        """Some of its rows, in this order."""
        return FlowFunction(self.flow, self.place[np.asarray(indices, dtype=int)], self.order)

    def __mul__(self, factor: float) -> BohlFunction:
        return FlowFunction(self.flow, csr_array(self.place * real_number(factor, "factor")), self.order)

    __rmul__ = __mul__
