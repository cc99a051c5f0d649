"""The equations of S models of one structure, M q'' + C q' + K q = L f, x = T q + Y f, in stacks of matrices, and their motions.

The structure is that of the first model: V with x = V z satisfies the constraints; rows of V^T K V without mass and dampers make
coordinates without them static (condensation); of the others those with mass come first, then those with dampers only. What is divided
by is measured in each model, and a model that lacks the structure, or divides by an ill-conditioned matrix, is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ..ground.tolerances import CLEAR_KEPT, DIVISOR_CONDITION, EPS, GOOD_CONDITION, noise_of
from ..linalg.arrays import others
from ..linalg.blocks import decoupled
from ..linalg.exponential import block_states, even_step
from ..linalg.recursion import shared_gaps
from ..linalg.scaling import balancing_units
from ..polynomial.direct_reduction import matching_rows, pivots_of
from ..signals.bohl import BohlFunction, FreeRestarts

#: Number of times computed together on an even grid.
WIDTH = 16

#: Terms of the exponential that bounds the entries of e^(G h) where |G| h is 1.
TERMS = 5


@dataclass(frozen=True, eq=False)
class StackedEquations:
    """S models with the coordinates q, the first m of which have mass, the other d dampers only."""

    M: np.ndarray  # M, C, K: shape (S, m + d, m + d); M is zero outside its first m rows and columns
    C: np.ndarray
    K: np.ndarray
    T: np.ndarray  # x from q, shape (S, n, m + d)
    L: np.ndarray  # forces on q from f, shape (S, m + d, n)
    Y: np.ndarray  # x from f directly, of massless coordinates without dampers, shape (S, n, n)
    free: np.ndarray  # which columns of V move the coordinates q, shape (m + d,)
    masses: int  # m
    serve: np.ndarray  # which models have this structure with a margin, shape (S,)

    @property
    def generator(self) -> np.ndarray:
        """S with w' = S w for w = (q_m, q_m', q_d), shape (S, 2 m + d, 2 m + d)."""
        count, size, m = len(self.K), self.K.shape[1], self.masses
        by_state = -np.concatenate([self.K[:, :, :m], self.C[:, :, :m], self.K[:, :, m:]], axis=2)
        result = np.zeros((count, size + m, size + m))
        result[:, range(m), range(m, 2 * m)] = 1.0
        result[:, m:] = self.accelerations(by_state)
        return result

    def accelerations(self, right: np.ndarray) -> np.ndarray:
        """(q_m'', q_d') where M q_m'' + C_md q_d' and C_dd q_d' are these right sides, shape (S, m + d, any)."""
        m, result = self.masses, np.empty(right.shape)
        upper = right[:, :m]
        if m < self.K.shape[1]:
            result[:, m:] = np.linalg.solve(self.C[:, m:, m:], right[:, m:])
            upper = upper - self.C[:, :m, m:] @ result[:, m:]
        result[:, :m] = np.linalg.solve(self.M[:, :m, :m], upper)
        return result

    def of(self, members) -> StackedEquations:
        """The equations of some models, selected by a slice or an array of indices."""
        M, C, K, T, L, Y = (each[members] for each in (self.M, self.C, self.K, self.T, self.L, self.Y))
        return StackedEquations(M, C, K, T, L, Y, self.free, self.masses, self.serve[members])

    @property
    def is_symmetric(self) -> bool:
        """Whether each M, C and K is exactly symmetric and all coordinates have mass."""
        symmetric = ((matrix == matrix.transpose(0, 2, 1)).all() for matrix in (self.M, self.C, self.K))
        return self.masses == self.K.shape[1] and all(symmetric)

    def without_rigid_motions(self, shapes: np.ndarray) -> StackedEquations:
        """The equations of the motions without momentum along shapes against which there is neither stiffness nor damping.

        With q = E p + U a, E the columns of all coordinates but one for each shape, a = -(U^T M U)^-1 U^T M E p: what is left of the
        matrices is regular where K is regular but for U. The coordinates that are left out have the largest masses, so that no
        difference of masses cancels. They serve no model where the shapes depend on each other, or not all coordinates have mass.
        """
        free = self._free_coordinates(shapes)
        if free is None or not self.is_symmetric:
            return replace(self, serve=np.zeros(len(self.K), dtype=bool))
        U, rest = free
        along = U.T @ self.M  # (S, z, r)
        total, serve = _regular(along @ U, self.serve)
        P = np.eye(len(U))[:, rest] - U @ np.linalg.solve(total, along[:, :, rest])
        M, C, K = P.transpose(0, 2, 1) @ self.M @ P, self.C[:, rest[:, None], rest], self.K[:, rest[:, None], rest]
        own, left = self.M.diagonal(axis1=1, axis2=2)[:, rest], M.diagonal(axis1=1, axis2=2)
        serve = serve & (own <= GOOD_CONDITION * left).all(axis=1)
        M = (M + M.transpose(0, 2, 1)) / 2
        T, L = self.T @ P, P.transpose(0, 2, 1) @ self.L
        return replace(self, M=M, C=C, K=K, T=T, L=L, free=self.free[rest], masses=len(rest), serve=serve)

    def with_resting_motion(self, shape: np.ndarray) -> tuple[StackedEquations, np.ndarray] | None:
        """The equations in coordinates (p, a), q = E p + u a, where a is the amplitude of a motion that springs do not resist.

        K has exact zeros for it, so that a slow motion against dampers alone does not have the rounding errors of stiffness. The second
        array bounds the relative rounding errors of the damping of u, shape (S,); None where not all coordinates have mass.
        """
        free = self._free_coordinates(shape)
        if free is None or not (self.K == self.K.transpose(0, 2, 1)).all():
            return None
        u, rest = free
        P = np.hstack([np.eye(len(u))[:, rest], u])
        M, C, K = P.T @ self.M @ P, P.T @ self.C @ P, np.zeros_like(self.K)
        K[:, :-1, :-1] = self.K[:, rest[:, None], rest]
        with np.errstate(divide="ignore", invalid="ignore"):
            doubt = noise_of((np.abs(u.T) @ np.abs(self.C) @ np.abs(u))[:, 0, 0]) / np.abs(C[:, -1, -1])
        return replace(self, M=M, C=C, K=K, T=self.T @ P, L=np.broadcast_to(np.eye(len(u)), K.shape)), doubt

    def _free_coordinates(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """The shapes U in the coordinates q, and all coordinates but one for each of them, that with the largest mass."""
        size, first = self.K.shape[1], int(self.serve.argmax())
        U = np.linalg.lstsq(self.T[first], shapes, rcond=None)[0]
        masses = np.abs(self.M[first].diagonal())
        if self.masses < size or not masses.all():
            return None
        pivots = pivots_of(U.T, np.ones(size, dtype=bool), np.sqrt(masses))
        return None if pivots is None else (U, others(size, pivots))


def stacked_equations(M: np.ndarray, C: np.ndarray, K: np.ndarray, V: np.ndarray) -> StackedEquations | None:
    """Stack the equations of S models; None where the structure of the first one needs rank decisions."""
    size = V.shape[1]
    if size == V.shape[0] and (np.eye(size) == V).all():
        serve = np.ones(len(K), dtype=bool)
    else:
        (M, one), (C, two), (K, three) = (projected(matrix, V) for matrix in (M, C, K))
        serve = one & two & three
    (heavy, damped), (massive, braked) = ([(matrix != 0).any(axis=(0, axis)) for matrix in (M, C)] for axis in (2, 1))
    light, resting, static = damped & ~heavy, ~(heavy | damped), ~(massive | braked)
    if resting.sum() != static.sum() or heavy.sum() != massive.sum() or not size:
        return None
    serve = serve & (M.any(axis=2) == heavy).all(axis=1) & ((M.any(axis=2) | C.any(axis=2)) == ~resting).all(axis=1)
    first = int(serve.argmax())
    pivots = np.flatnonzero(static)
    if len(pivots) and pivots_of(K[first][np.ix_(resting, static)], np.ones(len(pivots), dtype=bool)) is None:
        return None
    order = np.argsort(~massive[~static], kind="stable")
    free = np.flatnonzero(~static)[order]
    m = int(heavy.sum())
    matching = matching_rows(M[first][np.ix_(heavy, free[:m])]) if m else np.zeros(0, dtype=int)
    if matching is None:
        return None
    rest = np.concatenate([np.flatnonzero(heavy)[matching], np.flatnonzero(light)])
    own, K_rest = np.flatnonzero(resting), K[:, rest[:, None], free]
    T, L = np.zeros((len(K), size, len(free))), np.zeros((len(K), len(free), size))
    T[:, free, range(len(free))] = 1.0
    L[:, range(len(free)), rest] = 1.0
    Y = np.zeros((len(K), size, size))
    if len(own):
        K_aa, serve = _regular(K[:, own[:, None], pivots], serve, GOOD_CONDITION)
        inverse = np.linalg.inv(K_aa)
        across, along = K[:, rest[:, None], pivots], K[:, own[:, None], free]
        T[:, pivots], L[:, :, own], Y[:, pivots[:, None], own] = -inverse @ along, -across @ inverse, inverse
        K_rest, clear = _sum(K_rest, across @ T[:, pivots], np.abs(across) @ np.abs(inverse) @ np.abs(along))
        serve = serve & clear
    M, C = M[:, rest[:, None], free], C[:, rest[:, None], free]
    if m:
        M[:, :m, :m], serve = _regular(M[:, :m, :m], serve)
    if m < len(free):
        C[:, m:, m:], serve = _regular(C[:, m:, m:], serve)
    return StackedEquations(M, C, K_rest, V @ T, L @ V.T, V @ Y @ V.T, free, m, serve)


def projected(matrix: np.ndarray, V: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """V^T matrix V with exact zeros for what cancels, exactly symmetric where the matrix is; and where no entry is doubtful."""
    result, sizes = V.T @ matrix @ V, np.abs(V).T @ np.abs(matrix) @ np.abs(V)
    result, clear = _cleaned(result, sizes)
    symmetric = (matrix == matrix.transpose(0, 2, 1)).all(axis=(1, 2))
    result[symmetric] = (result[symmetric] + result[symmetric].transpose(0, 2, 1)) / 2
    return result, clear


def _sum(one: np.ndarray, other: np.ndarray, terms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    result, clear = _cleaned(one + other, np.abs(one) + terms)
    mirrored = result.transpose(0, 2, 1)
    near = (np.abs(result - mirrored) <= noise_of(np.abs(one) + terms)).all(axis=(1, 2))
    result[near] = (result + mirrored)[near] / 2
    return result, clear


def _cleaned(result: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Entries that are rounding errors of terms of these sizes are zero; and where no entry is near that bound."""
    noise = noise_of(sizes)
    small = np.abs(result) <= noise
    clear = (small | (np.abs(result) > CLEAR_KEPT * noise)).all(axis=(1, 2))
    result[small] = 0.0
    return result, clear


def _regular(matrix: np.ndarray, serve: np.ndarray, limit: float = DIVISOR_CONDITION) -> tuple[np.ndarray, np.ndarray]:
    """The stack with the unit matrix where a model lacks a well-conditioned one, and which models have one.

    The condition is that of rows and columns in units in which their largest entries are one.
    """
    if (np.count_nonzero(matrix, axis=(1, 2)) == np.count_nonzero(matrix.diagonal(axis1=1, axis2=2), axis=1)).all():
        regular = serve & matrix.diagonal(axis1=1, axis2=2).all(axis=1)
        return np.where(regular[:, None, None], matrix, np.eye(matrix.shape[1])), regular
    size = np.abs(matrix)
    rows = size.max(axis=2, keepdims=True)
    rows[rows == 0] = 1.0
    columns = (size / rows).max(axis=1, keepdims=True)
    columns[columns == 0] = 1.0
    scaled = matrix / rows / columns
    serve = serve & np.isfinite(scaled).all(axis=(1, 2))
    unit = np.eye(matrix.shape[1])
    with np.errstate(all="ignore"):
        values = np.linalg.svd(np.where(serve[:, None, None], scaled, unit), compute_uv=False)
        serve = serve & (values[:, 0] <= limit * values[:, -1])
    return np.where(serve[:, None, None], matrix, unit), serve


# Motions at given times by matrix exponentials of stacks: z' = G z, z = (states, states of the force).
#
# e^{G h} of a stack is SciPy's (Al-Mohy and Higham 2009). Its powers take many times at once on an even grid; a force that starts, stops
# or is sampled restarts its states at its knots. No decomposition is needed: double and defective eigenvalues are as good as any.


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
