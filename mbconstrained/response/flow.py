"""The reduced equations of a problem with their start and force: z' = G z, x = P z.

A ``Flow`` holds what follows from the problem alone and is computed when it is first used: the generator, its modes, the powers of
the Taylor series at t = 0, the matrix e^{G h}. None of it depends on what was evaluated before. Which of them gives the values at
given times ``response.choose`` decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ..ground.tolerances import noise_of
from ..linalg.arrays import Matrix, entry_count, full, kept, matrix_of, of_like_kind
from ..linalg.blocks import CHUNK_ENTRIES, block_slices
from ..linalg.division import accurately_solved
from ..linalg.recursion import ExponentialSeries, Propagator
from ..linalg.scaling import balanced_norm
from ..polynomial.reduced_equations import Reduction
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveLoad, ImpulsiveSmooth
from .events import Event
from .problem import Driven, units_of_pieces

#: A force that restarts at fewer knots is not worth a table.
FEWEST_KNOTS = 64

#: The Taylor series serves for |G t| <= EARLY, with so many terms: 2^27/27! is far below EPS. After a start from rest sums of modes
#: still cancel there, by as many digits as a force begins slowly.
EARLY, TERMS = 2.0, 27

#: States that are still small sums of large modes then have a series of so many terms up to |G t| = LATER, 9^60/60! is far below EPS,
#: each row as long as its rounding errors are below those of its modes.
LATER, MORE_TERMS = 9.0, 60

#: A state that is so many times smaller than the modes that it is a sum of has lost as many digits. So many terms of its bound show
#: that it is not, unless it is far from the start.
MOST_CANCELLED, FEW_TERMS = 1000.0, 12

#: Where the rounding errors of series and modes are compared, as parts of the longest time.
PLACES = 2.0 ** (-np.arange(9) / 4)

#: Pieces of a force larger than this are not measured as they are: products of such units leave the range of float64.
STEEPEST = 2.0**100


@dataclass(frozen=True, eq=False)
class TaylorStart:
    """The Taylor series of z at 0+.

    Attributes:
        powers: (G / unit)^k z / k! as columns.
        unit: a power of two near the largest rate of the motion, in 1/s.
        end: until when it serves, in s.
        bounds: the same as powers for absolute values, where rounding errors decide until when a row is evaluated by it.
    """

    powers: np.ndarray
    unit: float
    end: float
    bounds: np.ndarray | None = None

    def replace(self, values: np.ndarray, times: np.ndarray, output: Matrix, sizes: Callable[[], np.ndarray]) -> None:
        """Put output @ z in place of the values at early times."""
        early = (times < self.end).nonzero()[0]
        if not early.size:
            return
        series, until = output @ self.powers, None
        if self.bounds is not None:
            errors = abs(output) @ (self.bounds @ self._powers(self.end * PLACES))
            good = np.append(errors <= sizes()[:, None], np.ones((len(errors), 1), dtype=bool), axis=1)
            until = np.append(self.end * PLACES, self.end * EARLY / LATER)[good.argmax(axis=1), None]
        width = max(1, CHUNK_ENTRIES // max(series.shape))
        for part in (early[begin : begin + width] for begin in range(0, len(early), width)):
            own = series @ self._powers(times[part])
            values[:, part] = own if until is None else np.where(times[part] < until, own, values[:, part])

    def _powers(self, times: np.ndarray) -> np.ndarray:
        return np.power.outer(self.unit * times, np.arange(self.powers.shape[1])).T


@dataclass(frozen=True, eq=False)
class Flow:
    """z = (w, v): the states w of the reduced equations and v of the force, from their start.

    Attributes:
        reduction: the equations w' = S w + ....
        force: f, its states v; Dirac impulses, none of their derivatives, on rows with mass or dampers only.
        initial: x^(i)(0-) as row i, shape (q, r).
        start: w at 0+, shape (n,).
        excitation: D with w' = S w + D v, shape (n, m).
        output: P, shape (r, n + m).
        impulsive: the jumps of w by Dirac impulses at the knots of the force, shape (n, K); None where there are no impulses.
        first_moments: whether those of a delayed force are pieces of their own, in which nothing cancels.
        jumping: whether the values at 0- do not satisfy the algebraic equations.
        refined: z as a sum of refined modes, where float64 does not resolve slow ones next to fast ones; else None.
        computed: what methods compute once from the flow.
    """

    reduction: Reduction
    force: ImpulsiveSmooth
    initial: np.ndarray
    start: np.ndarray
    excitation: Matrix
    output: Matrix
    impulsive: np.ndarray | None = None
    first_moments: bool = True
    jumping: bool = False
    refined: BohlFunction | None = None
    computed: dict[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, reduction: Reduction, initial: np.ndarray, force: ImpulsiveSmooth, *, jumping: bool = False) -> Flow:
        """The flow from values at 0- (q, r)."""
        smooth, start = force.smooth, reduction.state(initial)
        if jumping:
            start = start + _jumps_to_algebraic_equations(reduction, initial[None], smooth)[:, 0]
        impulsive = _jumps_by_impulses(reduction, force)
        if impulsive is not None:
            start = start + impulsive[:, 0]
        if not smooth.blocks:
            nothing = matrix_of((len(start), 0), reduction.K)
            return cls(reduction, force, initial, start, nothing, reduction.output, impulsive, jumping=jumping)
        J, columns = (of_like_kind(matrix, reduction.K) for matrix in (smooth.generator, smooth.coefficients))
        algebraic, right = columns[reduction.algebraic], columns[np.concatenate([reduction.second, reduction.first])]
        x = reduction.output
        output = matrix_of((x.shape[0], len(start) + columns.shape[1]), x, (0, 0, x), (0, len(start), reduction.Y @ algebraic))
        if entry_count(algebraic):
            for matrix in reduction.through:
                right, algebraic = right - matrix @ algebraic, algebraic @ J
        excitation = reduction.rates(right)
        return cls(reduction, force, initial, start, excitation, output, impulsive, jumping=jumping)

    def after(self, knot: int, states: np.ndarray) -> Flow:
        """The motion after a knot of the force as a separate flow, for states w there."""
        smooth = self.force.smooth
        smooth = BohlFunction(smooth.coefficients, smooth.blocks, smooth.restarts.states[:, knot])
        return Flow(self.reduction, ImpulsiveSmooth(smooth), self.initial, states, self.excitation, self.output)

    @cached_property
    def generator(self) -> Matrix:
        """G = [[S, D], [0, J]]."""
        S, m = self.reduction.generator, self.force.smooth.state_count
        if not m:
            return S
        J = of_like_kind(self.force.smooth.generator, S)
        n = len(self.start)
        return matrix_of((n + m, n + m), S, (0, 0, S), (0, n, self.excitation), (n, n, J))

    @cached_property
    def knots(self) -> np.ndarray:
        """The times at which the force may change, beginning with 0."""
        return self.force.knots

    @cached_property
    def start_with_force(self) -> np.ndarray:
        """z at 0+."""
        return np.concatenate([self.start, self.force.smooth.start_at_zero])

    @cached_property
    def norm(self) -> float:
        """Norm of the balanced generator in 1/s; 1 where the motion has powers of t only."""
        units = None if self.force.smooth.state_count else self.reduction.units
        return balanced_norm(self.generator, units) or 1.0

    @cached_property
    def modal_rate(self) -> float:
        """An upper bound of the rates of the motion in 1/s, by its modes."""
        columns = (
            map(abs, column)
            for block in (*self.reduction.decoupled.blocks, *self.force.smooth.blocks)
            for column in zip(*block.tolist())
        )
        return max(map(sum, columns), default=0.0) or 1.0

    @cached_property
    def states(self) -> BohlFunction:
        """z as a sum of modes, without rows where no force acts: the modes of S are evaluated through the requested output alone."""
        return self._modal[0]

    @property
    def coupling(self) -> float:
        """The largest entry of the transformation that separates the modes."""
        return self._modal[1]

    @property
    def copies(self) -> list[tuple[slice, slice]]:
        """Pairs of states of ``states``: copies of states of the force, and the states that they copy."""
        return self._modal[2]

    def modal_output(self, output: Matrix) -> np.ndarray:
        """C of output @ z = C e^{J t} v, with J and v of ``states``."""
        if not self.force.smooth.state_count and self.refined is None:
            return self.reduction.decoupled.modal_output(output)
        used = np.flatnonzero(abs(output).sum(axis=0))
        return output[:, used] @ self.states.coefficients[used]

    @property
    def modal_states(self) -> np.ndarray:
        """C of z = C e^{J t} v."""
        return self.modal_output(np.eye(len(self.start))) if not self.force.smooth.state_count else self.states.coefficients

    @cached_property
    def _modal(self) -> tuple[BohlFunction, float, list[tuple[slice, slice]]]:
        if self.refined is not None:
            return self.refined, self.reduction.decoupled.coupling, []
        smooth, n = self.force.smooth, len(self.start)
        m, free = smooth.coefficients.shape[1], self.reduction.decoupled
        if not m and len(self.knots) == 1:
            return BohlFunction(np.zeros((0, n)), free.blocks, free.coordinates(self.start)), free.coupling, []
        from .methods.finite_motion import FinitePart, driven_motion

        units = np.ones(m)
        for block, at in zip(smooth.blocks, block_slices(smooth.blocks)):
            sizes = units_of_pieces(smooth, block, at)
            units[at] = sizes if sizes is not None and sizes.max() <= STEEPEST else 1.0
        generator, through = smooth.generator * units / units[:, None], np.eye(n + m)[:, n:] * units
        driven = Driven(full(self.excitation) * units, generator, through, units)
        jumps = np.broadcast_to(np.zeros((n, 1)), (n, len(self.knots) - 1)) if self.impulsive is None else self.impulsive[:, 1:]
        part = FinitePart(free, scipy.sparse.eye_array(n + m, n), driven, self.start, jumps, 1.0, np.ones(n + m))
        return driven_motion(part, self.force, first=self.first_moments)

    def propagator(self, step: float) -> Propagator:
        """The propagator e^{G h} for a step h; the last one is cached."""
        if step not in self._propagators:
            self._propagators.clear()  # each has as many numbers as the square of G
            self._propagators[step] = Propagator(self.generator, step)
        return self._propagators[step]

    @cached_property
    def _propagators(self) -> dict[float, Propagator]:
        return {}

    def series(self, step: float, count: int) -> ExponentialSeries:
        """z at this number of even times by the series of e^{G h}; the last one is cached."""
        if (step, count) not in self._series:
            self._series.clear()
            self._series[step, count] = ExponentialSeries(self.generator, step, self.start_with_force, count)
        return self._series[step, count]

    @cached_property
    def _series(self) -> dict[tuple[float, int], ExponentialSeries]:
        return {}

    def taylor_start(self, *, modal: bool) -> TaylorStart:
        """The Taylor series at 0+, as long as the rate of the modes allows, or the norm of G where modes are not used."""
        return self._modal_taylor if modal else self._taylor

    @cached_property
    def _modal_taylor(self) -> TaylorStart:
        if not (self.reduction.is_small and self._is_cancelled):
            return self._taylor_start(self.modal_rate, EARLY, TERMS)
        start = self._taylor_start(self.modal_rate, LATER, MORE_TERMS)
        return replace(start, bounds=self._scaled_powers(start.unit, start.powers.shape[1], np.abs))

    @property
    def _is_cancelled(self) -> bool:
        """Whether one of a few states is small relative to its modes and to the coupling terms of all states, after EARLY."""
        rate = self.modal_rate
        reached = self._scaled_powers(rate, FEW_TERMS, np.abs) @ EARLY ** np.arange(float(FEW_TERMS))
        sizes = np.abs(self.modal_states) @ np.abs(self.states.start_at_zero)
        return bool((sizes > MOST_CANCELLED * reached).any())

    @cached_property
    def _taylor(self) -> TaylorStart:
        return self._taylor_start(self.norm, EARLY, TERMS)

    def _taylor_start(self, rate: float, turned: float, terms: int) -> TaylorStart:
        unit = float(2.0 ** np.floor(np.log2(rate)))  # dividing by it costs no rounding
        longest = max(map(len, self.force.smooth.blocks), default=0)  # a force may begin like a power of t
        powers = self._scaled_powers(unit, terms + longest)
        return TaylorStart(powers, unit, min(turned / rate, float(self.knots[1:2].min(initial=np.inf))))

    def _scaled_powers(self, unit: float, count: int, part: Callable = np.asarray) -> np.ndarray:
        """(G / unit)^k z / k! as columns, or the same of the absolute values of G and z."""
        columns, step = [part(self.start_with_force)], part(self.generator) / unit
        if self.force.smooth.state_count:  # those of a force have few entries
            step = kept(full(step))
        for _ in range(1, count):
            columns.append(step.dot(columns[-1]))  # less to do before it starts than @
        return np.array(columns).T / np.cumprod(np.maximum(np.arange(float(count)), 1.0))

    @cached_property
    def jump(self) -> np.ndarray:
        """x^(i)(0+) - x^(i)(0-), shape (q, r)."""
        if (
            self.impulsive is None and len(self.reduction.second) == self.initial.shape[1]
        ):  # all values are states, which do not jump
            return np.zeros(self.initial.shape)
        return self.derivatives_less(self.start_with_force[:, None], self.initial[..., None])[..., 0]

    def jumps(self, initial: np.ndarray) -> np.ndarray:
        """Jumps x^(i)(0+) - x^(i)(0-), shape (S, q, r), for other values at 0- that are consistent as those of the flow."""
        if self.impulsive is None and len(self.reduction.second) == initial.shape[2]:
            return np.zeros(initial.shape)
        force = np.repeat(self.force.smooth.start_at_zero[:, None], len(initial), axis=1)
        own = self.reduction.states(initial)
        if self.jumping:
            own = own + _jumps_to_algebraic_equations(self.reduction, initial, self.force.smooth)
        states = np.concatenate([own if self.impulsive is None else own + self.impulsive[:, :1], force])
        return self.derivatives_less(states, initial.transpose(1, 2, 0)).transpose(2, 0, 1)

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Jumps of x and x' where the force jumps after t = 0."""
        if len(self.knots) == 1:
            return ()
        later = self._later_jumps()
        places = np.flatnonzero(np.any([values.any(axis=0) for _, values in later], axis=0))
        jumps = np.zeros((len(later), self.output.shape[0], len(places)))
        for jump, (rows, values) in zip(jumps, later):
            jump[rows] = values[:, places]
        return tuple(Event(float(self.knots[1 + k]), jumps[:, :, place].copy(), ()) for place, k in enumerate(places))

    def derivatives_less(self, states: np.ndarray, given: np.ndarray) -> np.ndarray:
        """x^(i) of states (n + m, K) less given values, shape (q, r, K); zero where the difference is a rounding error."""
        differences, sizes, G, reduction = [], np.abs(states), self.generator, self.reduction
        Y, rows = reduction.Y, reduction.given[0][reduction.algebraic]
        for order, values in enumerate(given):
            if order:
                states, sizes = G @ states, abs(G) @ sizes
            difference, size = self.output @ states - values, np.abs(values)
            size = abs(self.output) @ sizes + size + abs(Y) @ (abs(rows) @ size)  # the last: the tolerance of ``satisfying``
            differences.append(np.where(np.abs(difference) <= noise_of(size, len(size)), 0.0, difference))
        return np.array(differences).reshape(given.shape)

    def _later_jumps(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """For x, x', ...: the rows that jump with the states of the force, and their jumps, shape (rows, K)."""
        changes, G = self.force.smooth.with_knots(self.knots).restarts.jumps[:, 1:], self.generator
        used = np.arange(G.shape[0]) >= len(self.start)
        if self.impulsive is not None:
            used[: len(self.start)] = self.impulsive[:, 1:].any(axis=1)
            changes = np.concatenate([self.impulsive[used[: len(self.start)], 1:], changes])
        jumps, matrix, bound = [], self.output, abs(self.output)
        for order in range(len(self.initial)):
            if order:
                matrix, bound = matrix @ G, bound @ abs(G)
            through, size = full(matrix[:, used]), full(bound[:, used])
            rows = np.flatnonzero(through.any(axis=1))
            values = through[rows] @ changes
            jumps.append((rows, np.where(np.abs(values) <= noise_of(size[rows] @ np.abs(changes)), 0.0, values)))
        return jumps


def _jumps_to_algebraic_equations(reduction: Reduction, initial: np.ndarray, smooth: BohlFunction) -> np.ndarray:
    """Jumps of w at 0+, shape (n, S), from values at 0- (S, q, r) that violate x = V x_f + Y g by r in x and r' in x'.

    The rows with mass or dampers, integrated over t = 0, keep M x_m, C_dd x_d + C_dm x_m and M x_m' + C_md x_d + C_mm x_m, in which x
    is V x_f + Y g afterwards: the part of r in them is a change of x_f.
    """
    m, second, first, V, C = len(reduction.second), reduction.second, reduction.first, reduction.V, reduction.C
    states, g = reduction.states(initial), smooth.coefficients[reduction.algebraic]
    free, at_zero, rest = [np.concatenate([states[:m], states[2 * m :]]), states[m : 2 * m]], smooth.start_at_zero, []
    for x, own in zip(initial.transpose(1, 2, 0), free):
        through = V[:, : len(own)]
        beyond, size = x - through @ own - (reduction.Y @ (g @ at_zero))[:, None], np.abs(x) + abs(through) @ np.abs(own)
        rest.append(np.where(np.abs(beyond) <= noise_of(size, len(size)), 0.0, beyond))
        at_zero = smooth.generator @ at_zero
    damped = reduction.given[1]
    moved = accurately_solved(reduction.M, reduction.given[2][second] @ rest[0]) if m else states[:0]
    slow = accurately_solved(C[m:, m:], damped[first] @ rest[0] - C[m:, :m] @ moved)
    if not m:
        return slow
    momentum = reduction.given[2][second] @ rest[1] + damped[second] @ rest[0] - C[:m] @ np.concatenate([moved, slow])
    return np.concatenate([moved, accurately_solved(reduction.M, momentum), slow])


def _jumps_by_impulses(reduction: Reduction, force: ImpulsiveSmooth) -> np.ndarray | None:
    """Jumps of w at the knots of a force: M x_m'' + C_md x_d' and C_dd x_d' contain its impulses, all other terms are finite."""
    if not (force.impulses or force.later):
        return None
    rows = np.concatenate([reduction.second, reduction.first])
    right = np.zeros((len(rows), len(force.knots)))
    for load in (ImpulsiveLoad(0.0, force.impulses), *force.later):
        for impulse in load.impulses:
            right[:, np.searchsorted(force.knots, load.time)] += impulse[rows]
    return full(reduction.rates(of_like_kind(right, reduction.K)))
