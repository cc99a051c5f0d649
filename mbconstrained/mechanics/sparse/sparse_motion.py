"""The motion of a system of sparse matrices in its modes of lowest frequency, with a bound on the rest."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ...ground.checks import counted, places_of
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.errors import IllConditioned, InputError, MbconstrainedError
from ...ground.named_arrays import named_array
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CORRECTION_RESIDUAL, EPS, FREQUENCY_GAP, NOISE_SAFETY, RESONANCE_RATIO, ROUNDED_FREE, noise_of
from ...linalg.arrays import full, kept
from ...linalg.blocks import block_matrix, block_slices
from ...linalg.exponential import block_states
from ...linalg.recursion import recursion
from ...signals.bohl import BohlFunction, Restarts
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step
from ..equations import EquationsOfMotion
from ..motion import FunctionSum, SystemMotion
from .pencil import ReducedPencil, Solver, asymmetry, factorize, quadratic_form, times
from .sparse_modes import Pair, QuadraticPencil, arrays_of, damped_modes, is_modal, modal_rates
from .undamped_modes import SOFT, UndampedModes, balanced, undamped_modes

# The space of the kept modes: x = W y, y' = B y + G^T f, an exact part of the motion of the whole system.
#
# Undamped and modally damped shapes have y = (q, q') with q'' + z q' + w^2 q = x^T f. Where damping couples them, each complex
# pair has y = (Re c, Im c) with c' = s c + g^T f, g = x / (x^T (2 s M + C) x), as the matrices are symmetric (Lancaster 1966).


@dataclass(frozen=True, eq=False)
class ModeSpace:
    """W and B with M W B^2 + C W B + K W = 0, and the inputs of y."""

    shapes: np.ndarray  # the columns of W that are not zero, shape (r, w)
    places: np.ndarray  # which of the states each of them belongs to, shape (w,)
    blocks: tuple[np.ndarray, ...]  # the diagonal blocks of B, 1 x 1 and 2 x 2
    input_shapes: np.ndarray  # the columns of G that are not zero, shape (r, d)
    input_places: np.ndarray  # the states that they act on, shape (d,)
    rate_errors: np.ndarray  # the errors of the eigenvalues by rounding of M, C, K, for each column of W, in 1/s
    supports: np.ndarray  # restoring stiffness of free bodies from rounding errors of springs, for each column, in 1/s^2
    shape_errors: np.ndarray  # errors of the columns relative to their sizes, by the residuals of undamped shapes
    modal: bool  # whether y are displacements and velocities of undamped shapes, M-orthonormal
    left_out: int = 0  # the number of modes that did not converge

    def relative_errors(self, times: np.ndarray) -> np.ndarray:
        """Relative errors of the columns of W with their amplitudes at times (T,) by rounding, shape (w, T)."""
        drifted = np.minimum(np.multiply.outer(self.supports, times**2) / 2, 1.0)  # 1 - cos of that frequency
        return np.multiply.outer(self.rate_errors, times) + drifted + self.shape_errors[:, None] + NOISE_SAFETY * EPS

    @property
    def count(self) -> int:
        """Number of states."""
        return sum(map(len, self.blocks))

    def displacements(self, states: np.ndarray) -> np.ndarray:
        """W y for columns of states."""
        return self.shapes @ states[self.places]

    def modal_forces(self, forces: np.ndarray) -> np.ndarray:
        """G^T f for columns of forces."""
        total = np.zeros((self.count, forces.shape[1]))
        np.add.at(total, self.input_places, self.input_shapes.T @ forces)
        return total

    def times_generator(self, states: np.ndarray) -> np.ndarray:
        """B y."""
        parts = (block @ states[at] for block, at in zip(self.blocks, block_slices(self.blocks)))
        return np.concatenate([states[:0], *parts])

    def initial_states(self, pencil: ReducedPencil, displacement, velocity) -> np.ndarray:
        """y at 0+ from x and x' at 0-: y = G^T (M x' + C x) + B G^T M x, as impulses M x' + C x and M x delta' would start it."""
        momentum = (pencil.mass @ velocity + pencil.damping @ displacement)[:, None]
        return (self.modal_forces(momentum) + self.times_generator(self.modal_forces((pencil.mass @ displacement)[:, None])))[:, 0]


def _modal_space(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    X, count, soft = undamped.vectors, len(undamped.values), np.abs(undamped.values) <= SOFT * abs(undamped.shift)
    rates = modal_rates(pencil, undamped)
    blocks = tuple(np.array([[0.0, 1.0], [-w2, -rate]]) for w2, rate in zip(undamped.values, rates))
    places = 2 * np.arange(count)
    values = np.sqrt((rates**2 / 4 - undamped.values).astype(complex)) - rates / 2
    errors = _rate_errors(pencil, X, values, 2 * values + rates)
    # in the values of soft supports nothing cancels
    errors = np.where(soft, np.minimum(errors, NOISE_SAFETY * EPS * (np.sqrt(np.abs(undamped.values)) + np.abs(rates))), errors)
    return ModeSpace(
        X, places, blocks, X, places + 1, errors, _supports(pencil, X, undamped.values == 0), _mixed(pencil, undamped), True
    )


def _mixed(pencil: ReducedPencil, undamped: UndampedModes) -> np.ndarray:
    """Mixing of the undamped shapes relative to their sizes: X^T (K X - M X W) over the differences of W."""
    X, w2 = undamped.vectors, undamped.values
    residuals = X.T @ (times(pencil.stiffness, X) - times(pencil.mass, X) * w2)
    gaps = np.abs(w2[:, None] - w2)
    close = gaps <= FREQUENCY_GAP * np.abs(w2)  # equal ones have any shapes
    return np.linalg.norm(np.where(close, 0.0, residuals) / np.where(close, 1.0, gaps), axis=0)


def _supports(pencil: ReducedPencil, X: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Restoring stiffness |x^T K x| of free bodies, as large as the rounding errors of assembled entries."""
    supports = np.zeros(X.shape[1])
    for place in np.flatnonzero(free):
        x = X[:, place]
        supports[place] = abs(quadratic_form(pencil.stiffness, x, 0.0)) / (x @ (pencil.mass @ x))
    return supports


def _rate_errors(pencil: ReducedPencil, X, values, slopes) -> np.ndarray:
    """|x|^T (|K| + |s| |C| + |s|^2 |M|) |x| / |x^T (2 s M + C) x| times the rounding errors of entries, which are independent."""
    matrices, size = (pencil.stiffness, pencil.damping, pencil.mass), np.abs(X)
    terms = sum(np.abs(values) ** k * times(abs(matrix), size) for k, matrix in enumerate(matrices))
    return EPS * np.linalg.norm(size * terms, axis=0) / np.where(slopes != 0, np.abs(slopes), np.inf)


def _of_pairs(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    pairs, body = damped_modes(pencil, undamped)
    separate = [pair for pair in pairs if pair.converged and not pair.of_body]
    parts = [_states_of(pencil, pair) for pair in separate]
    values, X = arrays_of(separate, pencil.size)
    slopes = 2 * values * (X * times(pencil.mass, X)).sum(axis=0) + (X * times(pencil.damping, X)).sum(axis=0)
    free, counts = np.array([pair.resting for pair in separate], dtype=bool), np.where(values.imag != 0, 2, 1)
    sizes = np.linalg.norm(np.abs(X) * times(abs(pencil.damping), np.abs(X)), axis=0)
    errors = np.repeat(np.where(free, EPS * sizes, _rate_errors(pencil, X, values, slopes)), counts)
    supports = np.repeat(_supports(pencil, X.real, free), counts)
    if body is not None:  # (u + s y) (u + s y)^T / (s^2 + c s + k)
        block = np.array([[0.0, 1.0], [-body.stiffness, -body.damping]])
        columns, rows = [body.shape, body.response], [body.response, body.shape - body.damping * body.response]
        parts.append((columns, rows, block, [0, 1], [0, 1]))
        own = NOISE_SAFETY * EPS * (abs(body.stiffness) ** 0.5 + abs(body.damping)) + body.noise
        errors = np.append(errors, [own, own])
        supports = np.append(supports, _supports(pencil, body.shape[:, None], np.array([not body.stiffness])).repeat(2))
    each = list(zip(*parts)) or [()] * 5
    begins = np.cumsum([0, *map(len, each[2])])
    shapes, input_shapes = (np.array([x for own in part for x in own]).reshape(-1, pencil.size).T for part in each[:2])
    places, input_places = (np.array([begin + i for begin, own in zip(begins, part) for i in own], dtype=int) for part in each[3:])
    lost = sum(not pair.converged for pair in pairs)
    none = np.zeros(len(errors))
    return ModeSpace(shapes, places, each[2], input_shapes, input_places, errors, supports, none, False, lost)


def _states_of(pencil: ReducedPencil, pair: Pair) -> tuple[list, list, np.ndarray, list[int], list[int]]:
    """Shapes and input shapes of a pair, its block of B, and the states that they belong to."""
    value, x = pair.value, pair.vector if pair.value.imag else pair.vector.real
    if pair.resting:
        x = x / (x @ (pencil.mass @ x)) ** 0.5
        return [x], [x], np.array([[0.0, 1.0], [0.0, 0.0]]), [0], [1]
    rate = value if value.imag else value.real
    g = x / (x @ (pencil.damping @ x + 2 * rate * (pencil.mass @ x)))
    if not value.imag:
        return [x], [g], np.array([[rate]]), [0], [0]
    block = np.array([[value.real, -value.imag], [value.imag, value.real]])
    return [2 * x.real, -2 * x.imag], [g.real, g.imag], block, [0, 1], [0, 1]


# y' = B y + U z with z' = J z, restarted wherever the force starts, stops or changes: y(t) as a Bohl function.
#
# With B Y - Y J = -U the force causes Y z and a free motion, as in ``response.methods.finite_motion`` for the whole system; where Y
# is large, near resonance, y and a copy of z are evaluated together instead.


def amplitudes(space: ModeSpace, start: np.ndarray, coupling: np.ndarray, smooth: BohlFunction) -> BohlFunction:
    """The factors of the columns of W, then z, from the free part of y at 0+ and U."""
    (n, m), restarts, outer = coupling.shape, smooth.restarts, block_slices(smooth.blocks)
    units, Y, coupled = np.ones(n), np.zeros((n, m)), []
    for block, at in zip(space.blocks, block_slices(space.blocks)):
        for J, of in zip(smooth.blocks, outer):
            if coupling[at, of].any():
                units[at] = _state_units(block, J)
                own, U = block * units[at] / units[at][:, None], coupling[at, of] / units[at][:, None]
                solution = _separated(own, J, U)
                if solution is None:
                    unit = max(np.abs(U).max(), np.finfo(float).tiny) / max(np.abs(own).max(), np.abs(J).max(), 1.0)
                    coupled.append((at, of, np.block([[own, U / unit], [np.zeros((len(J), len(own))), J]]), unit * units[at]))
                else:
                    Y[at, of] = units[at][:, None] * solution
    rows, inputs = [np.eye(n), Y], restarts.states
    caused = [-Y @ inputs, inputs]
    for at, of, block, own in coupled:
        rows.append(np.zeros((n, len(block))))
        rows[-1][at, : len(own)] = np.diag(own)
        caused.append(np.pad(inputs[of], ((len(own), 0), (0, 0))))
    output, states = kept(np.hstack(rows)), np.vstack(caused)  # y of the states of all blocks
    blocks, gaps = [*space.blocks, *smooth.blocks, *(block for _, _, block, _ in coupled)], restarts.gaps
    with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
        states[:n] += recursion(space.blocks, start, output @ block_states(blocks, states[:, :-1], gaps), gaps)
        before = np.hstack([np.zeros((len(states), 1)), block_states(blocks, states[:, :-1], gaps)])
    at_knots = states[:, 0] if len(restarts.knots) == 1 else Restarts(restarts.knots, states, states - before, restarts.remainders)
    coefficients = np.vstack([full(output)[space.places], np.eye(m, len(states), n)])
    return BohlFunction(coefficients, tuple(blocks), at_knots)


def _state_units(block, J) -> np.ndarray:
    """Scales of displacement and velocity of a mode: 1 and the larger rate of the two."""
    if len(block) == 1 or block[0, 1] != 1.0 or block[0, 0]:
        return np.ones(len(block))
    rate = max(abs(block[1, 0]) ** 0.5, abs(block[1, 1]), float(np.abs(np.diag(J)).max()), float(np.abs(J).max()))
    return np.array([1.0, 2.0 ** np.round(np.log2(rate)) if rate else 1.0])


def _separated(own, J, U) -> np.ndarray | None:
    """Y, or None near resonance."""
    matrix = np.kron(own, np.eye(len(J))) - np.kron(np.eye(len(own)), J.T)
    scale = max(np.abs(own).max(), np.abs(J).max())
    if not scale or not np.linalg.cond(matrix) < RESONANCE_RATIO**4:
        return None
    solution = scipy.linalg.solve(matrix, -U.ravel(), check_finite=False)
    return None if np.abs(solution).max() * scale > RESONANCE_RATIO * np.abs(U).max() * len(J) else solution.reshape(U.shape)


# The static correction, exact for every force: X with M X J^2 + C X J + K X = D outside of the kept modes.
#
# For a force D e^{J t} v the left-out modes follow X e^{J t} v exactly, whatever their number, and beyond it move freely. A static
# force so has its full static deflection. This is the mode-acceleration method (Williams 1945), for every force in closed form.

#: The refinement steps after which a force cannot be followed.
MOST_STEPS = 60


class StaticCorrection:
    """Solutions of P(s) x = d outside of the kept modes."""

    def __init__(self, pencil: ReducedPencil, undamped: UndampedModes, space: ModeSpace):
        self.pencil, self.undamped, self.space = pencil, undamped, space
        self.quadratic = QuadraticPencil(pencil, undamped)
        self.known: dict[complex, Solver] = {}

    def _residual_forces(self, forces: np.ndarray, blocks) -> np.ndarray:
        """D without the part that acts on the kept modes."""
        pencil, space, generator = self.pencil, self.space, block_matrix(blocks)
        states = space.modal_forces(forces)
        along, turned = space.displacements(states), space.displacements(space.times_generator(states))
        return forces - times(pencil.mass, turned + along @ generator) - times(pencil.damping, along)

    def followed(self, forces: np.ndarray, blocks) -> np.ndarray:
        """X for D and the diagonal blocks of J, one column of a block after another in its Schur form."""
        correction = np.zeros(forces.shape)
        if not blocks:
            return correction
        left = self._residual_forces(forces, blocks)
        for block, at in zip(blocks, block_slices(blocks)):
            if not left[:, at].any():
                continue
            triangle, turn = scipy.linalg.schur(block, output="complex")
            size = float(np.linalg.norm(forces[:, at]))
            correction[:, at] = (self._columns(left[:, at] @ turn, triangle, size) @ turn.conj().T).real
        return correction

    def _columns(self, right, triangle, size) -> np.ndarray:
        squared, columns = triangle @ triangle, np.zeros(right.shape, dtype=complex)
        for j in range(right.shape[1]):
            inertia, damping = columns[:, :j] @ squared[:j, j], columns[:, :j] @ triangle[:j, j]
            own = right[:, j] - self.pencil.mass @ inertia - self.pencil.damping @ damping
            columns[:, j] = self.solved(complex(triangle[j, j]), own, size)
        return columns

    def solved(self, s: complex, right: np.ndarray, size: float = 0.0) -> np.ndarray:
        """x with P(s) x = right, refined; right has rounding errors of this size."""
        solve, size = self._solver(s), max(np.linalg.norm(right), size)
        solution, rest, before = np.zeros(right.shape, dtype=complex), self._residual(right.astype(complex)), np.inf
        for _ in range(MOST_STEPS):
            solution = self._outside(solution + solve(rest))
            rest = self._residual(balanced(self.pencil, right - self.quadratic.applied(s, solution)))
            floor = NOISE_SAFETY * EPS * np.linalg.norm(abs(self.pencil.stiffness) @ np.abs(solution))
            left = np.linalg.norm(rest)
            if left <= max(CORRECTION_RESIDUAL * size, floor):
                return solution
            if not np.isfinite(left) or left > 2 * before:
                break
            before = left
        rate = f"s = {s.real:.6g} 1/s" if not s.imag else f"{abs(s.imag):.6g} rad/s"
        raise InputError(
            f"force: a mode beyond the {len(self.undamped.values)} computed ones is free, or in resonance with it at {rate}; "
            "increase count"
        )

    def _solver(self, s: complex):
        if not s:  # the first steps of a Neumann series, with factors that are there
            solve = self.undamped.factors.solve
            return lambda right: solve(right.real) + 1j * solve(right.imag)
        for moved in (s, s * (1 + EPS**0.5)):  # next to an eigenvalue in the last digit, which refinement corrects
            with suppress(IllConditioned):
                if moved not in self.known:
                    self.known = {moved: self.quadratic.solver(moved)}
                return self.known[moved]
        raise InputError(f"force: it is in resonance with an undamped mode at {abs(s):.6g} rad/s; increase count")

    def _outside(self, x: np.ndarray) -> np.ndarray:
        """x without the kept modes: rounding along them is large near resonance."""
        return x - self._kept(self.pencil.mass @ x) if self.space.modal else x

    def _residual(self, forces: np.ndarray) -> np.ndarray:
        """Forces without their part on the kept modes, which is rounding error here."""
        return forces - self.pencil.mass @ self._kept(forces) if self.space.modal else forces

    def _kept(self, forces: np.ndarray) -> np.ndarray:
        X = self.space.shapes
        return X @ (X.T @ forces.real) + 1j * (X @ (X.T @ forces.imag))


# The energy outside of the kept modes: that of a free motion of the whole system, so that it never grows.
#
# x_rest = x - W a - X z solves M x'' + C x' + K x = 0 between the times at which the force changes, exactly, and there it gains the
# jump of -X z. With x'^T C x' >= 0 its energy is at most that of its starts: sqrt(2 E) <= sum of sqrt(2 E_j), as this is a norm.


def remainder(
    left: StaticCorrection, displacement, velocity, start: np.ndarray, followed, smooth: BohlFunction
) -> tuple[float, float, bool]:
    """A bound of sqrt(2 E) for a start and a force that changes at knots; the same relative to the norm of the whole motion; and whether
    coordinates without mass jump at the start."""
    pencil, space, restarts = left.pencil, left.space, smooth.restarts
    generator = smooth.generator
    z, jumps = restarts.states[:, 0], restarts.jumps[:, 1:]
    states = start[:, None]
    forced = space.modal_forces(np.asarray(pencil.basis.T @ smooth.coefficients) @ z[:, None])
    kept = space.displacements(states)[:, 0], space.displacements(space.times_generator(states) + forced)[:, 0]
    forced = followed @ z, followed @ (generator @ z)
    rest, jumped = _relaxed(pencil, displacement - kept[0] - forced[0])
    terms = [(displacement, velocity), kept, forced]
    first = _norm(pencil.mass, pencil.stiffness, rest, velocity - kept[1] - forced[1])
    sizes = [_norm(pencil.mass, pencil.stiffness, *term) for term in terms]
    # the norm of absolute values, times the unit roundoff, bounds the rounding errors of the norm
    if first <= NOISE_SAFETY * EPS * sum(_norm(abs(pencil.mass), abs(pencil.stiffness), *map(np.abs, term)) for term in terms):
        first = 0.0
    changes = _norms(pencil, followed, generator, jumps)
    norm = 0.0 if left.undamped.complete and space.modal else float(first + changes.sum())
    whole = max(sizes[0], sizes[1]) + sizes[2] + changes.sum()
    relative = min(norm / np.hypot(norm, whole), 1.0) if norm else 0.0
    return norm, float(relative), jumped


def _norm(mass, stiffness, x: np.ndarray, v: np.ndarray) -> float:
    """(v^T M v + x^T K x)^(1/2)."""
    return max(float(v @ (mass @ v) + x @ (stiffness @ x)), 0.0) ** 0.5


def _norms(pencil: ReducedPencil, followed, generator, jumps) -> np.ndarray:
    """The energy norm of X dz at each of the later changes of the force, shape (K - 1,)."""
    if not jumps.size:
        return np.zeros(0)
    turned = followed @ generator
    square = followed.T @ times(pencil.stiffness, followed) + turned.T @ times(pencil.mass, turned)
    return np.maximum((jumps * (square @ jumps)).sum(axis=0), 0.0) ** 0.5


def _relaxed(pencil: ReducedPencil, rest: np.ndarray) -> tuple[np.ndarray, bool]:
    """The displacement with massless, undamped coordinates in equilibrium between the springs, and whether any of them changed."""
    empty = np.diff(pencil.mass.indptr) + np.diff(pencil.damping.indptr) == 0
    if not empty.any() or pencil.rows.shape[0]:
        return rest, False
    stiffness = scipy.sparse.csr_array(pencil.stiffness)[empty]
    own, forces = scipy.sparse.csc_array(stiffness[:, empty]), stiffness @ rest
    noise = NOISE_SAFETY * EPS * (abs(stiffness) @ np.abs(rest))
    if (np.abs(forces) <= noise).all():
        return rest, False
    relaxed = rest.copy()
    relaxed[empty] -= scipy.sparse.linalg.splu(own).solve(forces)
    moved = np.abs(relaxed - rest).max()
    return relaxed, bool(moved > EPS**0.5 * np.abs(rest).max())


def _is_passive(left: StaticCorrection) -> bool:
    """Whether stiffness and damping supply no energy to the motion outside of the kept modes."""
    values = left.undamped.values
    if (len(values) and values[-1] < 0) or left.undamped.factors.negative != 0:
        return False
    if not left.space.modal and (values < 0).any():
        return False
    C = left.pencil.damping
    diagonal = C.diagonal()
    if (diagonal >= 0).all() and (2 * diagonal >= abs(C).sum(axis=0) * (1 - NOISE_SAFETY * EPS)).all():
        return True
    try:
        lifted = C + scipy.sparse.diags_array(NOISE_SAFETY * EPS * np.where(diagonal > 0, diagonal, np.abs(C.data).max()))
        return factorize(lifted, scipy.sparse.csr_array((0, C.shape[0])), left.pencil.described).negative == 0
    except MbconstrainedError:
        return False


@dataclass(frozen=True, repr=False, eq=False)
class SparseMotion(SystemMotion, Displayed):
    """x(t) = W a(t) + X z(t) + x_0 + x_rest(t): kept modes, static correction, constrained displacement, and a bounded rest.

    W, a: shapes and amplitudes of the kept modes; z: states of the force, z' = J z; X: the response of all other modes to it. The
    values leave out x_rest, a free motion of the other modes, whose energy E is bounded: sqrt(2 E) <= ``rest_norm``.

    Attributes:
        system: the system that moves.
        applied: all forces f on its n coordinates.
        amplitudes: a and z in closed form.
        shapes: W and X side by side, shape (n, w + s).
        offset: x_0, a displacement with the values of all constraint rows, shape (n,).
        rest_norm: (2 E)^(1/2) in J^(1/2), an upper bound of the energy norm of x_rest for all times.
        truncation: the bound relative to the energy norm of the whole motion.
        bounded: whether the bound is valid for all times, as damping and stiffness supply no energy; otherwise at t = 0 only.
        notices: the size of the rest, jumps of massless coordinates, redundant rows.
    """

    system: EquationsOfMotion
    applied: ImpulsiveSmooth
    amplitudes: BohlFunction
    shapes: np.ndarray
    offset: np.ndarray
    rest_norm: float
    truncation: float
    bounded: bool
    notices: tuple[Notice, ...]
    space: ModeSpace
    left: StaticCorrection

    def _summary(self) -> str:
        kept, size = counted(len(self.space.blocks), "mode"), counted(self.system.size, "coordinate")
        return f"{kept} of {size}, truncation {self.truncation:.2g}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (n,)) or at times (T,) (-> (n, T)), in m or rad; t >= 0, t = 0 means 0+."""
        values = self.shapes @ self.amplitudes(times)
        return self._named(values + (self.offset if values.ndim == 1 else self.offset[:, None]))

    def _rate(self, order: int, times) -> np.ndarray:
        return self.shapes @ self.amplitudes.derivative(order)(times) if order else self(times)

    def of(self, *coordinates: str | int) -> BohlFunction:
        """The function of some coordinates only, by name or number from 0, a row for each: no other is computed."""
        places = places_of(coordinates, self.names, "coordinate")
        function = self.amplitudes.mapped(self.shapes[places])
        offset = self.offset[places]
        return function + step(offset).smooth if offset.any() else function

    @property
    def row_names(self) -> tuple[str, ...]:
        """The independent constraint rows, in the order of the multipliers."""
        pencil = self.system.pencil
        return tuple(pencil.constraints.names[place] for place in pencil.independent)

    def reaction(self, times) -> np.ndarray:
        """The multipliers lambda of the independent constraint rows, M x'' + C x' + K x = f + A^T lambda; without those of x_rest."""
        return named_array(self.reaction_function(times), self.row_names)

    @cached_property
    def reaction_function(self) -> BohlFunction:
        """lambda for t > 0 in closed form, k rows."""
        pencil, system, force = self.system.pencil, self.system, self.applied.smooth
        A = pencil.constraints.matrix[pencil.independent]
        gram = scipy.sparse.linalg.splu(scipy.sparse.csc_array(A @ A.T)) if A.shape[0] else None

        def multipliers(columns) -> np.ndarray:
            forces = np.asarray(A @ columns)
            return forces if gram is None else gram.solve(forces)

        matrices = (system.stiffness, system.damping, system.mass)
        inertial = self.amplitudes.differential(*(multipliers(matrix @ self.shapes) for matrix in matrices))
        return FunctionSum((inertial, BohlFunction(-multipliers(force.coefficients), force.blocks, force.start)))

    def error_estimate(self, times) -> float:
        """Estimate of the rounding error, max |error| / max |x|; x_rest, which is left out, has its own ``bound``.

        Rounding errors of M, C, K change the eigenvalues, and so the phases by their error times t, and what the springs of a free
        body leave of their sums moves it in the end; sums and shapes add their own.
        """
        times = np.atleast_1d(times)
        parts, own = np.abs(self.amplitudes(times)), len(self.space.places)
        parts[:own] *= self.space.relative_errors(times)
        parts[own:] *= NOISE_SAFETY * EPS
        largest = np.abs(self(times)).max(initial=0.0)
        return float((np.abs(self.shapes) @ parts).max(initial=0.0) / largest) if largest else 0.0

    def bound(self, *coordinates: str | int) -> np.ndarray:
        """An upper bound of |x_rest| at each of some coordinates, by name or number from 0, for all times, shape (p,).

        |x_i| <= (e_i^T F e_i)^(1/2) rest_norm, F the flexibility that the kept modes leave (all of it where damping couples them):
        one sparse solution for each coordinate.
        """
        places = places_of(coordinates, self.names, "coordinate")
        return np.array([self._flexibility(place) ** 0.5 * self.rest_norm for place in places])

    def _flexibility(self, place) -> float:
        """e_i^T F e_i."""
        if not self.rest_norm:
            return 0.0
        pencil, space = self.system.pencil, self.space
        unit = pencil.basis[[int(place)], :].toarray()[0]
        if space.modal:
            unit = unit - pencil.mass @ (space.shapes @ (space.shapes.T @ unit))
            return max(float(unit @ self.left.solved(0j, unit.astype(complex)).real), 0.0)
        if (self.left.undamped.values <= 0).any():
            return np.inf
        return max(float(unit @ self.left.quadratic.solver(0.0)(unit).real), 0.0)


def sparse_motion(system: EquationsOfMotion, start: np.ndarray, applied: ImpulsiveSmooth, count: int) -> SparseMotion:
    """The motion from x(0-), x'(0-) in the rows of start, shape (2, n)."""
    if any(impulse.any() for impulse in applied.impulses) or applied.later:
        raise InputError(
            "force: Dirac impulses are not available for sparse matrices; give the velocity that the impulse causes, or a pulse"
        )
    pencil = system.pencil
    offset = _constrained_displacement(pencil)
    if offset.any():
        applied = applied + step(-(system.stiffness @ offset))
    displacement, velocity = _free_start(pencil, start, offset)
    undamped = undamped_modes(pencil, count)
    if asymmetry(pencil.damping)[0]:
        raise InputError(
            "damping: it is not symmetric; the motion of large sparse systems needs symmetric damping; its modes can be had, and "
            "the motion of a small system given as arrays"
        )
    space = (_modal_space if is_modal(pencil, undamped) else _of_pairs)(pencil, undamped)
    left = StaticCorrection(pencil, undamped, space)
    smooth = applied.smooth
    forces = np.asarray(pencil.basis.T @ smooth.coefficients)
    followed = left.followed(forces, smooth.blocks)
    begin = space.initial_states(pencil, displacement, velocity)
    function = amplitudes(space, begin, space.modal_forces(forces), smooth)
    norm, relative, jumps = remainder(left, displacement, velocity, begin, followed, smooth)
    passive, shapes = _is_passive(left), times(pencil.basis, np.hstack([space.shapes, followed]))
    notices = (*system.notices, *_notices(norm, relative, passive, jumps, space, count))
    return SparseMotion(system, applied, function, shapes, offset, norm, relative, passive, notices, space, left)


def _constrained_displacement(pencil: ReducedPencil) -> np.ndarray:
    """A displacement with the values of all constraint rows."""
    if not pencil.row_values.any():
        return pencil.offset
    rows = pencil.rows
    return pencil.offset + pencil.basis @ (rows.T @ np.linalg.solve((rows @ rows.T).toarray(), pencil.row_values))


def _notices(norm: float, relative: float, passive: bool, jumps: bool, space: ModeSpace, count: int) -> Iterator[Notice]:
    if jumps:
        yield Notice(NoticeKind.JUMP, "massless coordinates jump at t = 0 to their equilibrium between the springs")
    if space.left_out:
        yield Notice(NoticeKind.ACCURACY, f"{space.left_out} damped modes did not converge and count as part of the rest")
    if (support := space.supports.max(initial=0.0)) > 0:
        since = (2 * ROUNDED_FREE / support) ** 0.5
        text = (
            "the springs on a free body cancel up to rounding errors of their sums, which count as zero; if they are the support that "
            f"they are, x differs by {ROUNDED_FREE:g} of itself and more from t = {since:.3g} s on"
        )
        yield Notice(NoticeKind.RANK, text)
    if norm:
        when = "for all times" if passive else "at t = 0; later it may grow, as damping or stiffness supply energy"
        text = (
            f"the motion outside of these modes has an energy of at most {norm**2 / 2:.3g} J, {relative:.2g} of all in "
            f"the energy norm, {when}; increase count above {count} to include more of it"
        )
        yield Notice(NoticeKind.OMITTED, text, doubtful=not passive)


def _free_start(pencil: ReducedPencil, start: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x - x_0 and x' at 0- on the free coordinates."""
    A, names = pencil.constraints.matrix, pencil.constraints.names
    free = []
    for what, given, constant, values in (
        ("displacement", start[0], offset, pencil.constraints.values),
        ("velocity", start[1], np.zeros(len(offset)), np.zeros(len(names))),
    ):
        violation = A @ given - values
        # a vector projected on the constraints has the rounding error of its largest entry
        size = abs(A) @ (np.abs(given).max(initial=0.0) + np.abs(constant)) + np.abs(values)
        beyond = np.abs(violation) > noise_of(size, int(np.diff(A.indptr).max(initial=1)))
        if beyond.any():
            worst = int(np.argmax(np.abs(violation) * beyond))
            raise InputError(
                f'{what}: constraint "{names[worst]}" has the value {values[worst]:.6g}, the values at 0- give '
                f"{values[worst] + violation[worst]:.6g}; give consistent values, as the motion of sparse matrices has no jumps"
            )
        free.append((given - constant)[pencil.free])
    return free[0], free[1]
