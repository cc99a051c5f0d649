"""The space of the kept modes: x = W y, y' = B y + G^T f, an exact part of the motion of the whole system.

Undamped and modally damped shapes have y = (q, q') with q'' + z q' + w^2 q = x^T f. Where damping couples them, each complex
pair has y = (Re c, Im c) with c' = s c + g^T f, g = x / (x^T (2 s M + C) x), as the matrices are symmetric (Lancaster 1966).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...ground.errors import InputError
from ...ground.tolerances import EPS, FREQUENCY_GAP, NOISE_SAFETY, RESONANCE_RATIO
from ...linalg.blocks import block_slices
from ...linalg.exponential import block_states
from ...linalg.recursion import recursion
from ...signals.bohl import BohlFunction, Restarts
from .damped_modes import damped_modes, is_modal, modal_rates
from .pencil import ReducedPencil
from .sparse_matrices import asymmetry, quadratic_form, times
from .undamped_modes import SOFT, UndampedModes


@dataclass(frozen=True, eq=False)
class ModeSpace:
    """W and B with M W B^2 + C W B + K W = 0, and the inputs of y.

    Attributes:
        shapes: the columns of W that are not zero, shape (r, w).
        places: which of the states each of them belongs to, shape (w,).
        blocks: the diagonal blocks of B, 1 x 1 and 2 x 2.
        input_shapes: the columns of G that are not zero, shape (r, d), and
        input_places: the states that they act on, shape (d,).
        rate_errors: the errors of the eigenvalues by rounding of M, C, K, for each column of W, in 1/s.
        supports: restoring stiffness of free bodies from rounding errors of springs, for each column, in 1/s^2.
        shape_errors: errors of the columns relative to their sizes, by the residuals of undamped shapes.
        modal: whether y are displacements and velocities of undamped shapes, M-orthonormal.
        left_out: the number of modes that did not converge.
    """

    shapes: np.ndarray
    places: np.ndarray
    blocks: tuple[np.ndarray, ...]
    input_shapes: np.ndarray
    input_places: np.ndarray
    rate_errors: np.ndarray
    supports: np.ndarray
    shape_errors: np.ndarray
    modal: bool
    left_out: int = 0

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
        product, begin = np.empty_like(states), 0
        for block in self.blocks:
            at = slice(begin, begin + len(block))
            product[at] = block @ states[at]
            begin += len(block)
        return product

    def initial_states(self, pencil: ReducedPencil, displacement, velocity) -> np.ndarray:
        """y at 0+ from x and x' at 0-: y = G^T (M x' + C x) + B G^T M x, as impulses M x' + C x and M x delta' would start it."""
        momentum = (pencil.mass @ velocity + pencil.damping @ displacement)[:, None]
        return (self.modal_forces(momentum) + self.times_generator(self.modal_forces((pencil.mass @ displacement)[:, None])))[:, 0]


def mode_space(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    """The space of undamped modes, or of the damped modes computed from them."""
    if asymmetry(pencil.damping)[0]:
        raise InputError(
            "damping: it is not symmetric; the motion of large sparse systems needs symmetric damping; its modes can be had, and "
            "the motion of a small system given as arrays"
        )
    if is_modal(pencil, undamped):
        return _modal(pencil, undamped)
    return _of_pairs(pencil, undamped)


def _modal(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
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
    modes = damped_modes(pencil, undamped)
    shapes, places, blocks, input_shapes, input_places, begin = [], [], [], [], [], 0
    separate = modes.converged & ~modes.of_body
    for value, x, resting in zip(modes.values[separate], modes.vectors.T[separate], modes.resting[separate]):
        if resting:
            x = x.real / (x.real @ (pencil.mass @ x.real)) ** 0.5
            columns, rows, own, at = [x], [x], np.array([[0.0, 1.0], [0.0, 0.0]]), ([0], [1])
        elif not value.imag:
            x = x.real
            g = x / (x @ (pencil.damping @ x + 2 * value.real * (pencil.mass @ x)))
            columns, rows, own, at = [x], [g], np.array([[value.real]]), ([0], [0])
        else:
            g = x / (x @ (pencil.damping @ x + 2 * value * (pencil.mass @ x)))
            own = np.array([[value.real, -value.imag], [value.imag, value.real]])
            columns, rows, at = [2 * x.real, -2 * x.imag], [g.real, g.imag], ([0, 1], [0, 1])
        shapes, input_shapes, blocks = shapes + columns, input_shapes + rows, [*blocks, own]
        places, input_places = places + [begin + i for i in at[0]], input_places + [begin + i for i in at[1]]
        begin += len(own)
    X, values = modes.vectors[:, separate], modes.values[separate]
    slopes = 2 * values * (X * times(pencil.mass, X)).sum(axis=0) + (X * times(pencil.damping, X)).sum(axis=0)
    counts = np.where(values.imag != 0, 2, 1)
    free, sizes = modes.resting[separate], np.linalg.norm(np.abs(X) * times(abs(pencil.damping), np.abs(X)), axis=0)
    errors = np.repeat(np.where(free, EPS * sizes, _rate_errors(pencil, X, values, slopes)), counts)
    supports = np.repeat(_supports(pencil, X.real, free), counts)
    if (body := modes.body) is not None:  # (u + s y) (u + s y)^T / (s^2 + c s + k)
        blocks.append(np.array([[0.0, 1.0], [-body.stiffness, -body.damping]]))
        shapes, input_shapes = (
            [*shapes, body.shape, body.response],
            [*input_shapes, body.response, body.shape - body.damping * body.response],
        )
        places, input_places = [*places, begin, begin + 1], [*input_places, begin, begin + 1]
        own = NOISE_SAFETY * EPS * (abs(body.stiffness) ** 0.5 + abs(body.damping)) + body.noise
        errors = np.append(errors, [own, own])
        supports = np.append(supports, _supports(pencil, body.shape[:, None], np.array([not body.stiffness])).repeat(2))
    empty = np.zeros((0, pencil.size))
    return ModeSpace(
        np.array(shapes).T if shapes else empty.T,
        np.array(places, dtype=int),
        tuple(blocks),
        np.array(input_shapes).T if input_shapes else empty.T,
        np.array(input_places, dtype=int),
        errors,
        supports,
        np.zeros(len(errors)),
        False,
        int((~modes.converged).sum()),
    )


# y' = B y + U z with z' = J z, restarted wherever the force starts, stops or changes: y(t) as a Bohl function.
#
# With B Y - Y J = -U the force causes Y z and a free motion, as in ``response.methods.by_pairs`` for the whole system; where Y
# is large, near resonance, y and a copy of z are evaluated together instead.


class Amplitudes:
    """The states y of the kept modes and z of the force.

    Attributes:
        function: w + s rows: the factors of the columns of W, and z.
        start: the free part of y at 0+.
    """

    def __init__(self, space: ModeSpace, start: np.ndarray, coupling: np.ndarray, smooth: BohlFunction):
        self.space, restarts = space, smooth.restarts
        blocks, units, outer = [], np.ones(space.count), block_slices(smooth.blocks)
        Y, coupled = np.zeros(coupling.shape), []
        for block, at in zip(space.blocks, block_slices(space.blocks)):
            for J, of in zip(smooth.blocks, outer):
                if coupling[at, of].any():
                    units[at] = _units(block, J)
                    own, U = _measured(block, units[at]), coupling[at, of] / units[at][:, None]
                    solution = _separated(own, J, U)
                    if solution is None:
                        unit = max(np.abs(U).max(), np.finfo(float).tiny) / max(np.abs(own).max(), np.abs(J).max(), 1.0)
                        coupled.append((at, of, np.block([[own, U / unit], [np.zeros((len(J), len(own))), J]]), unit * units[at]))
                    else:
                        Y[at, of] = units[at][:, None] * solution
            blocks.append(block)
        self.Y, self.coupled = Y, coupled
        knots, inputs = restarts.knots, restarts.states
        caused = np.vstack([-Y @ inputs, inputs, *(_from_rest(at, inputs[of]) for at, of, _, _ in coupled)])
        blocks += [*smooth.blocks, *(block for _, _, block, _ in coupled)]
        gaps = restarts.gaps
        with np.errstate(over="ignore", invalid="ignore"):  # reported when the function is evaluated
            gained = self._finite(block_states(blocks, caused[:, :-1], gaps))
            own = recursion(space.blocks, start, gained, gaps)
            states = caused
            states[: space.count] += own
            before = np.hstack([np.zeros((len(states), 1)), block_states(blocks, states[:, :-1], gaps)])
        rows = np.vstack([self._rows(len(inputs), len(states)), self._force_rows(len(inputs), len(states))])
        at_knots = states[:, 0] if len(knots) == 1 else Restarts(knots, states, states - before, restarts.remainders)
        self.function, self.start = BohlFunction(rows, tuple(blocks), at_knots), start

    def _finite(self, states) -> np.ndarray:
        """y from the states of all blocks."""
        n, m = self.Y.shape
        y, begin = states[:n] + self.Y @ states[n : n + m], n + m
        for at, _, block, units in self.coupled:
            y[at] += units[:, None] * states[begin : begin + len(units)]
            begin += len(block)
        return y

    def _rows(self, inputs, size) -> np.ndarray:
        n, places = self.space.count, self.space.places
        rows = np.zeros((n, size))
        rows[:, :n], rows[:, n : n + inputs] = np.eye(n), self.Y
        begin = n + inputs
        for at, _, block, units in self.coupled:
            rows[at, begin : begin + len(units)] = np.diag(units)
            begin += len(block)
        return rows[places]

    def _force_rows(self, inputs, size) -> np.ndarray:
        rows = np.zeros((inputs, size))
        rows[:, self.space.count : self.space.count + inputs] = np.eye(inputs)
        return rows


def _units(block, J) -> np.ndarray:
    """Scales of displacement and velocity of a mode: 1 and the larger rate of the two."""
    if len(block) == 1 or block[0, 1] != 1.0 or block[0, 0]:
        return np.ones(len(block))
    rate = max(abs(block[1, 0]) ** 0.5, abs(block[1, 1]), float(np.abs(np.diag(J)).max()), float(np.abs(J).max()))
    return np.array([1.0, 2.0 ** np.round(np.log2(rate)) if rate else 1.0])


def _measured(block, units) -> np.ndarray:
    return block * units / units[:, None]


def _separated(own, J, U) -> np.ndarray | None:
    """Y, or None near resonance."""
    matrix = np.kron(own, np.eye(len(J))) - np.kron(np.eye(len(own)), J.T)
    scale = max(np.abs(own).max(), np.abs(J).max())
    if not scale:
        return None
    try:
        solution = (
            scipy.linalg.solve(matrix, -U.ravel(), check_finite=False) if np.linalg.cond(matrix) < RESONANCE_RATIO**4 else None
        )
    except np.linalg.LinAlgError:
        return None
    if solution is None or np.abs(solution).max() * scale > RESONANCE_RATIO * np.abs(U).max() * len(J):
        return None
    return solution.reshape(U.shape)


def _from_rest(at, inputs) -> np.ndarray:
    return np.vstack([np.zeros((at.stop - at.start, inputs.shape[1])), inputs])
