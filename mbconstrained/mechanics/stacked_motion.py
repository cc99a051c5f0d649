"""Motions of S models of one structure at given times, by matrix exponentials of stacks: z' = G z, z = (states, states of the force).

e^{G h} of a stack is SciPy's (Al-Mohy and Higham 2009). Its powers take many times at once on an even grid; a force that starts, stops
or is sampled restarts its states at its knots. No decomposition is needed: double and defective eigenvalues are as good as any.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ..ground.tolerances import EPS
from ..linalg.blocks import decoupled
from ..linalg.exponential import block_states, even_step
from ..linalg.recursion import shared_gaps
from ..linalg.scaling import balancing_units
from ..signals.bohl import BohlFunction, FreeRestarts
from .stacked_equations import StackedEquations

#: Number of times computed together on an even grid.
WIDTH = 16

#: Terms of the exponential that bounds the entries of e^(G h) where |G| h is 1.
TERMS = 5


@dataclass(frozen=True, eq=False)
class StackedFlow:
    """z' = G z and x = P z of S models."""

    generator: np.ndarray  # G, shape (S, N, N)
    output: np.ndarray  # P, shape (S, n, N)
    start: np.ndarray  # z at 0+, shape (S, N)
    states: np.ndarray  # states of the force, the last of z, at its knots, shape (v, K)
    knots: np.ndarray  # times of restart, beginning with 0, shape (K,)
    moved: float = 0.0  # perturbation of the generator, in rounding errors of squarings
    trial: int = 0  # which pattern of signs these have

    def derivative(self, order: int = 1) -> StackedFlow:
        """P G^order z."""
        output = self.output
        for _ in range(order):
            output = output @ self.generator
        return replace(self, output=output)

    def mapped(self, matrix: np.ndarray) -> StackedFlow:
        return replace(self, output=matrix @ self.output)

    def of(self, place: int) -> StackedFlow:
        one = slice(place, place + 1)
        return replace(self, generator=self.generator[one], output=self.output[one], start=self.start[one])

    def function(self) -> BohlFunction:
        """x of the first model, its states decoupled."""
        modes = decoupled(self.generator[0])
        states = np.empty((len(modes.basis), len(self.knots)))
        states[:, 0] = z = modes.coordinates(self.start[0])
        force = slice(len(z) - len(self.states), None)
        for knot, gap in enumerate(np.diff(self.knots), 1):
            z = modes.basis @ block_states(modes.blocks, z[:, None], np.array([gap]))[:, 0]
            z[force] = self.states[:, knot]
            states[:, knot] = z = modes.coordinates(z)
        start = states[:, 0] if len(self.knots) == 1 else FreeRestarts(self.knots, states, 0.0, modes.blocks)
        return BohlFunction(modes.modal_output(self.output[0]), modes.blocks, start)

    def __call__(self, times: np.ndarray) -> np.ndarray:
        """x at ascending times, shape (S, n, T)."""
        units = balancing_units(np.abs(self.generator).max(axis=0))
        G, z = self.generator * units / units[:, None], self.start / units
        if self.moved:
            G = G + self._rounding(G)
        output, step = self.output * units, even_step(times)
        if len(self.knots) == 1 and step is not None:
            if times[0]:
                z = _times(scipy.linalg.expm(G * times[0]), z)
            return _at_even_times(output, scipy.linalg.expm(G * step), z, len(times))
        knots = self.knots[self.knots <= times[-1]] if len(times) else self.knots[:1]
        points = np.union1d(times, knots)
        gaps = np.concatenate([[0.0], shared_gaps(points)])
        at_time, at_knot = (np.full(len(points), -1) for _ in range(2))
        at_time[np.searchsorted(points, times)] = range(len(times))
        at_knot[np.searchsorted(points, knots)] = range(len(knots))
        values, matrices = np.empty((len(G), output.shape[1], len(times))), {}
        force = slice(G.shape[1] - len(self.states), None)
        for place, gap in enumerate(gaps):
            if gap:
                if gap not in matrices:
                    matrices[gap] = scipy.linalg.expm(G * gap)
                z = _times(matrices[gap], z)
            if place and at_knot[place] >= 0:
                z[:, force] = self.states[:, at_knot[place]] / units[force]
            if at_time[place] >= 0:
                values[:, :, at_time[place]] = _times(output, z)
        return values

    def _rounding(self, G: np.ndarray) -> np.ndarray:
        """Rounding errors of repeated squaring of E = e^(G h), per step h: those of |E| |E| for each product E E.

        The states of constant and sampled forces have none.
        """
        norm = np.linalg.norm(G, 1, axis=(1, 2))[:, None, None]
        steps = np.abs(G) / np.where(norm > 0, norm, 1.0)
        sizes = power = np.broadcast_to(np.eye(G.shape[1]), G.shape)
        for k in range(1, TERMS):
            power = power @ steps / k
            sizes = sizes + power
        signs = np.random.default_rng(self.trial).choice([-1.0, 1.0], G.shape[1:])
        force = slice(G.shape[1] - len(self.states), None)
        turned = G[0, force, force] != 0
        signs[force, force] *= turned & turned.T
        return self.moved * EPS * norm * sizes * signs


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return (matrices @ vectors[:, :, None])[:, :, 0]


def _at_even_times(output: np.ndarray, step: np.ndarray, start: np.ndarray, count: int) -> np.ndarray:
    """P e^{G h k} z for k = 0 ... count - 1: the first of them by doubling, then as many at once."""
    states = start[:, :, None]
    while states.shape[2] < min(WIDTH, count):
        states, step = np.concatenate([states, step @ states], axis=2), step @ step
    width, values = states.shape[2], np.empty((len(start), output.shape[1], count))
    for begin in range(0, count, width):
        part = values[:, :, begin : begin + width]
        part[...] = (output @ states)[:, :, : part.shape[2]]
        states = step @ states
    return values


def stacked_flow(
    equations: StackedEquations,
    matrices: tuple[np.ndarray, np.ndarray, np.ndarray],
    start: np.ndarray,
    force: BohlFunction,
    static: np.ndarray,
    prescribed: np.ndarray,
) -> StackedFlow:
    """The flow from displacements and velocities under a common force, prescribed motions and a constant force of each model.

    x = T q + Y f + G^T b, where G^T b meets the constraints, and the force on q is that of f - (M s^2 + C s + K) G^T b.
    """
    (M, C, K), n, m = matrices, len(prescribed), equations.masses
    J = np.pad(force.generator, ((0, 1), (0, 1)))
    columns = np.pad(force.coefficients, ((0, 0), (0, 1)))
    b = prescribed @ columns[n:]
    f = columns[:n] + static[:, :, None] * np.eye(1, len(J), len(J) - 1)
    load = f - (K @ b + C @ (b @ J) + M @ (b @ J @ J)) if b.any() else f
    N, v = equations.K.shape[1] + m, len(J)
    generator = np.zeros((len(K), N + v, N + v))
    generator[:, :N, :N], generator[:, N:, N:] = equations.generator, J
    generator[:, m:N, N:] = equations.accelerations(equations.L @ load)
    output = np.zeros((len(K), n, N + v))
    output[:, :, :m], output[:, :, 2 * m : N] = equations.T[:, :, :m], equations.T[:, :, m:]
    output[:, :, N:] = equations.Y @ load + b
    restarts = force.restarts
    states = np.concatenate([restarts.states, np.ones((1, restarts.states.shape[1]))])
    begin = np.broadcast_to(states[:, 0], (len(K), v))
    z = np.concatenate([start[:, 0, :m], start[:, 1, :m], start[:, 0, m:], begin], axis=1)
    return StackedFlow(generator, output, z, states, restarts.knots)
