"""The modes of lowest frequency of M x'' + K x = 0 with A x = 0, computed, corrected and counted.

Shift-invert Lanczos from a shift just below the spectrum computes them. Sylvester's law of inertia counts the eigenvalues below a
frequency in a gap: missing ones are computed in the complement of the others (Grimes, Lewis and Simon 1994). Small systems, or
nearly all modes of a system, take a dense decomposition of the same shifted and inverted pencil instead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from ...ground.errors import InputError
from ...ground.tolerances import EPS, FREQUENCY_GAP, NOISE_SAFETY, RIGID_BODY_FORCE, RITZ_RESIDUAL, noise_of
from .pencil import Factorization, ReducedPencil, factorize, quadratic_form, times

# Block Lanczos with full orthogonalization and thick restarts, for x -> P^-1 M x in the inner product of M >= 0.
#
# The method of Ericsson and Ruhe (1980) in blocks (Grimes, Lewis and Simon 1994), restarted as by Wu and Simon (2000). What a
# vector has in the null space of M never enters: only M q is ever used, and a last application of P^-1 M corrects it (Nour-Omid,
# Parlett, Ericsson and Jensen 1987). The projected matrix is built from the products that orthogonalization needs anyway.
#
# Measured against ``scipy.sparse.linalg.eigsh`` with the same factors (two threads): 100 modes of a tied chain of 1.2e5 coordinates
# 24 s for 50 s, 20 modes of a ring of 20000 7 s for 17 s, 100 modes of a membrane of 40000 76 s for 79 s, equal to 5e-15. Blocks
# also have frequencies of high multiplicity at once, and known vectors can be excluded, which the search for missing modes needs.

#: Block size: large enough for products of matrices to pay, and for frequencies of this multiplicity.
BLOCK = 6

#: The basis is restarted when it has this many vectors for each requested one, and some more.
BASIS_PER_VECTOR, BASIS_MORE = 3, 40

#: Blocks between tests of convergence.
BETWEEN_LOOKS = 3

#: Rows that are multiplied at a time.
CHUNK = 8192

#: Restarts after which the pairs are returned as they are.
MOST_RESTARTS = 60


def _product(mass) -> Callable:
    """M x for columns x, fast where M is diagonal."""
    entries = mass.tocoo()
    if (entries.row == entries.col).all():
        diagonal = mass.diagonal()[:, None]
        return lambda columns: diagonal * columns
    return lambda columns: times(mass, columns)


class _Lanczos:
    """The basis Q with its projected matrix H = Q^T M P^-1 M Q."""

    def __init__(self, apply, mass, requested, locked, block=BLOCK):
        self.apply, self.requested, self.locked, self.block = apply, requested, locked, block
        self.weighed = _product(mass)
        self.size = mass.shape[0]
        self.capacity = min(BASIS_PER_VECTOR * requested + BASIS_MORE, self.size + block) + block
        self.basis = np.empty((self.size, self.capacity), order="F")
        self.projected = np.zeros((self.capacity, self.capacity))
        self.count, self.scale = 0, 0.0
        self.recent = 0  # the first vector that the next product is not orthogonal to by itself
        self.generator = np.random.default_rng(self.size)

    def run(self) -> tuple[np.ndarray, np.ndarray, bool]:
        """The pairs P^-1 M X = X diag(values), X^T M X = I, with the largest values, descending, and whether there are no others."""
        fresh, coupling = self._random(), np.zeros((0, 0))
        restarts, looks, exhausted = 0, 0, False
        while fresh.shape[1]:
            if self.count + fresh.shape[1] > self.capacity:
                coupling = self._restart(coupling)
                restarts += 1
            coupling, fresh = self._expand(fresh)
            looks += 1
            ready = self.count >= self.requested and (looks % BETWEEN_LOOKS == 0 or not fresh.shape[1])
            if restarts > MOST_RESTARTS or (ready and self._all_converged(coupling)):
                break
            if not fresh.shape[1]:  # all that the first block leads to: there may be more
                fresh = self._random()
        else:
            exhausted = True
        if not self.count:
            return np.zeros(0), np.zeros((self.size, 0)), True
        values, turn, _ = self._ritz(coupling)
        take = min(self.requested, self.count)
        _turn(self.basis, turn[:, :take])
        return values[:take], self.basis[:, :take].copy(order="F"), exhausted

    def first_values(self, steps: int) -> np.ndarray:
        """Estimates of the largest values from below, descending, by a given number of blocks."""
        fresh = self._random()
        for _ in range(steps):
            if not fresh.shape[1]:
                break
            fresh = self._expand(fresh)[1]
        return self._ritz(np.zeros((0, 0)))[0] if self.count else np.zeros(0)

    def _expand(self, fresh) -> tuple[np.ndarray, np.ndarray]:
        """Add a block; return the coupling to the next one, and the next one."""
        begin, end = self.count, self.count + fresh.shape[1]
        self.basis[:, begin:end] = fresh
        self.count = end
        image = self.apply(self.weighed(fresh))
        self.scale = max(self.scale, float(np.abs(self._norms(image)).max()))
        image, h = self._orthogonalized(image)
        self.projected[:end, begin:end] = h
        self.projected[begin:end, :end] = h.T
        own = self.projected[begin:end, begin:end]
        self.projected[begin:end, begin:end] = (own + own.T) / 2
        self.recent = begin
        fresh, coupling = self._normalized(image)
        padded = np.zeros((len(coupling), end))
        padded[:, begin:end] = coupling
        return padded, fresh

    def _orthogonalized(self, image) -> tuple[np.ndarray, np.ndarray]:
        """Vectors orthogonalized twice against recent and once against older vectors, for which the recurrence suffices."""
        total = np.zeros((self.count, image.shape[1]))
        for begin in (self.recent, 0):
            weighed = self.weighed(image)
            if self.locked.shape[1]:
                image = image - self.locked @ (self.locked.T @ weighed)
            Q = self.basis[:, begin : self.count]
            h = Q.T @ weighed
            image = image - (h.T @ Q.T).T
            total[begin:] += h
        return image, total

    def _normalized(self, image) -> tuple[np.ndarray, np.ndarray]:
        """An M-orthonormal basis of the columns without rounding errors, and the columns in it."""
        coupling = np.eye(image.shape[1])
        for _ in range(2):
            gram = image.T @ (self.weighed(image))
            squares, turn = scipy.linalg.eigh((gram + gram.T) / 2)
            least = noise_of(self.scale, self.count) if coupling.shape[0] == image.shape[1] == len(squares) else 0.0
            kept = squares > max(least**2, NOISE_SAFETY * EPS * squares.max(initial=0.0))
            length = squares[kept] ** 0.5
            image = ((turn[:, kept] / length).T @ image.T).T
            coupling = (turn[:, kept] * length).T @ coupling
            if not kept.any():
                break
        return image, coupling

    def _random(self) -> np.ndarray:
        """A random block in the range of P^-1 M, M-orthogonal to the basis; no columns if the space is exhausted."""
        start = self.apply(self.weighed(self.generator.standard_normal((self.size, min(self.block, self.size)))))
        norms = self._norms(start)
        self.scale = max(self.scale, float(norms.max()))
        self.recent = 0
        image = self._orthogonalized(start)[0]
        return self._normalized(image)[0]

    def _norms(self, columns) -> np.ndarray:
        return np.maximum((columns * (self.weighed(columns))).sum(axis=0), 0.0) ** 0.5

    def _ritz(self, coupling) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values, descending, coordinates of the vectors in the basis, residuals."""
        values, turn = scipy.linalg.eigh(self.projected[: self.count, : self.count])
        values, turn = values[::-1], turn[:, ::-1]
        residuals = np.linalg.norm(coupling @ turn, axis=0) if coupling.size else np.zeros(len(values))
        return values, turn, residuals

    def _all_converged(self, coupling) -> bool:
        values, _, residuals = self._ritz(coupling)
        limit = np.maximum(RITZ_RESIDUAL * values, NOISE_SAFETY * EPS * values.max(initial=0.0))
        return bool((residuals <= limit)[: self.requested].all())

    def _restart(self, coupling) -> np.ndarray:
        """Keep the requested pairs and the best half of the others."""
        values, turn, _ = self._ritz(coupling)
        keep = min(self.count - 1, (self.requested + self.count) // 2)
        _turn(self.basis, turn[:, :keep])
        self.projected[:] = 0.0
        self.projected[range(keep), range(keep)] = values[:keep]
        self.count, self.recent = keep, 0
        return coupling @ turn[:, :keep]


def _turn(vectors: np.ndarray, turn: np.ndarray) -> None:
    """The first columns times a matrix, in place, some rows at a time: no second array as large as all vectors."""
    for begin in range(0, len(vectors), CHUNK):
        part = vectors[begin : begin + CHUNK]
        part[:, : turn.shape[1]] = part[:, : len(turn)] @ turn


#: Up to this size a dense decomposition is as fast.
DENSE = 400

#: Each step takes nine tenths of what is elastic out of a rigid body's shape.
RIGID_STEPS = 4

#: Modes computed beyond the requested ones, so that there is a gap among them.
GUARD = 4

#: Number of searches for modes that the count misses.
ROUNDS = 12

#: Missing modes are copies of others: they are computed in blocks as wide as their number, at most this.
WIDEST = 48

#: A shift this many times closer to zero than the first elastic mode costs digits, as rigid modes outweigh it; its better place.
TOO_CLOSE, BETTER_SHIFT = 1e-3, 0.1

#: Modes of so soft supports relative to the shift have values in which nothing may cancel.
SOFT = 0.01

#: Distance below an estimate of the lowest growing mode, which is above it, at which the shift is tried.
MARGINS = (0.05, 0.5, 2.0)

#: Number of improvements of the shift.
MOST_SHIFTS = 4

#: Blocks of the first look at the spectrum.
FIRST_LOOK = 4


@dataclass(frozen=True, eq=False)
class UndampedModes:
    """K X = M X diag(values) on the free coordinates, ascending."""

    values: np.ndarray  # w^2 in 1/s^2, exactly zero for rigid bodies, negative for growth
    vectors: np.ndarray  # X, shape (r, m), X^T M X = I
    # residuals, bounds: |K x - w^2 M x| and the part of it that rounding and the stopping rule explain, both relative to the sum of
    # the sizes of its terms
    residuals: np.ndarray
    bounds: np.ndarray
    shift: float  # shift, factors: K - shift M, below all values
    factors: Factorization
    below: float | None  # the w^2 up to which modes were counted; None where no count was to be had
    counted: int | None  # number of eigenvalues below it
    computed_below: int  # the number of computed ones below it
    complete: bool  # whether the system has no other finite modes


def undamped_modes(pencil: ReducedPencil, count: int) -> UndampedModes:
    """The ``count`` undamped modes of lowest frequency; the last result is cached."""
    if count not in pencil._undamped:
        pencil._undamped.clear()
        pencil._undamped[count] = _lowest_modes(pencil, count)
    return pencil._undamped[count]


def _lowest_modes(pencil: ReducedPencil, count: int) -> UndampedModes:
    """The ``count`` modes of lowest w^2, at most all that exist."""
    _check_mass(pencil)
    dense = pencil.size <= DENSE or 3 * count > pencil.size
    shift, factors = _settled(pencil, *pencil.below_all())
    if dense:
        values, vectors, exhausted = _dense(pencil, shift, factors, count + GUARD)
    else:
        values, vectors, exhausted = _computed(pencil, shift, factors, count + GUARD, np.zeros((pencil.size, 0)))
    for _ in range(ROUNDS):
        below, inside = _boundary(values, shift, count, exhausted)
        counted = _counted(pencil, values, below, inside, factors)
        if counted is None or counted <= inside or dense:
            break
        missing = counted - inside
        more, others, exhausted = _computed(pencil, shift, factors, missing + GUARD, vectors, max(BLOCK, min(missing, WIDEST)))
        order = np.argsort(np.concatenate([values, more]), kind="stable")
        values, vectors = np.concatenate([values, more])[order], np.asfortranarray(np.hstack([vectors, others])[:, order])
    take = min(count, len(values))
    complete = exhausted and take == len(values)
    vectors = np.asfortranarray(vectors[:, :take])
    resting = np.abs(values[:take]) <= EPS**0.5 * abs(shift)
    for _ in range(RIGID_STEPS * bool(resting.any())):
        vectors[:, resting] = _purified(pencil, factors, np.ones(resting.sum()), np.asfortranarray(vectors[:, resting]))[1]
    vectors = _orthonormal(pencil, vectors)
    values, residuals, bounds = _evidence(pencil, values[:take], vectors, shift)
    return UndampedModes(values, vectors, residuals, bounds, shift, factors, below, counted, inside, complete)


def _check_mass(pencil: ReducedPencil) -> None:
    """Refuse a mass matrix that has negative eigenvalues, beyond rounding errors."""
    diagonal, sizes = pencil.mass.diagonal(), abs(pencil.mass).sum(axis=0)
    wrong = (diagonal < 0) | ((diagonal == 0) & (sizes > 0))
    if not wrong.any() and not (sizes > diagonal * (2 + NOISE_SAFETY * EPS)).any():
        return  # diagonally dominant
    if not wrong.any():
        lifted = pencil.mass + scipy.sparse.diags_array(EPS**0.5 * np.where(diagonal > 0, diagonal, diagonal.max(initial=0.0)))
        none = scipy.sparse.csr_array((0, pencil.size))
        if factorize(scipy.sparse.csc_array(lifted), none, pencil.described).negative in (0, None):
            return
    at = f" at {pencil.described(np.flatnonzero(wrong)[:1])}" if wrong.any() else ""
    raise InputError(f"mass: it has negative eigenvalues{at}; a mass matrix has none, zero for coordinates without mass")


def _settled(pencil: ReducedPencil, shift: float, factors: Factorization) -> tuple[float, Factorization]:
    """A better shift: farther below zero where rigid bodies would outweigh all else, nearer to growing modes if there are any."""
    for _ in range(MOST_SHIFTS):
        values = _Lanczos(factors.solve, pencil.mass, BLOCK * FIRST_LOOK, np.zeros((pencil.size, 0))).first_values(FIRST_LOOK)
        values = values[values > 0]
        estimates = shift + 1 / values
        elastic = estimates[estimates > abs(shift)]
        if not len(values):
            break
        if estimates[0] < -TOO_CLOSE * abs(shift) and estimates[0] - shift > 2 * BETTER_SHIFT * abs(estimates[0]):
            candidates = [float(estimates[0] - margin * abs(estimates[0])) for margin in MARGINS]
        elif values[-1] < values[0] * TOO_CLOSE and 0 < len(elastic) < len(estimates):
            candidates = [-BETTER_SHIFT * float(elastic[0])]
        else:
            break
        for better in candidates:
            closer = pencil.shifted(better)
            if not closer.negative:
                break
        if closer.negative:
            break
        shift, factors = better, closer
    return shift, factors


def _computed(pencil: ReducedPencil, shift, factors, wanted, locked, block: int = BLOCK) -> tuple[np.ndarray, np.ndarray, bool]:
    """Values, ascending, and vectors by Lanczos, outside of locked vectors."""
    *pairs, exhausted = _Lanczos(factors.solve, pencil.mass, wanted, locked, block).run()
    values, vectors = _purified(pencil, factors, *pairs)
    return shift + 1 / values, vectors, exhausted


def _purified(pencil: ReducedPencil, factors, values, vectors) -> tuple[np.ndarray, np.ndarray]:
    """The vectors multiplied once more by P^-1 M, which corrects massless coordinates, with norm 1 in M."""
    kept = values > 0
    values, vectors = values[kept], vectors[:, kept]
    for begin in range(0, len(values), 8):
        at = slice(begin, begin + 8)
        vectors[:, at] = factors.solve(times(pencil.mass, vectors[:, at]))
        vectors[:, at] /= (vectors[:, at] * times(pencil.mass, vectors[:, at])).sum(axis=0) ** 0.5
    return values, vectors


def _dense(pencil: ReducedPencil, shift, factors, wanted) -> tuple[np.ndarray, np.ndarray, bool]:
    """Values and vectors by one dense decomposition; as many finite modes as M has rank."""
    mass, shifted = pencil.mass.toarray(), (pencil.stiffness - shift * pencil.mass).toarray()
    free = scipy.linalg.null_space(pencil.rows.toarray()) if pencil.rows.shape[0] else np.eye(pencil.size)
    mass, shifted = free.T @ mass @ free, free.T @ shifted @ free
    scale = 1 / np.maximum(np.diag(mass), EPS * np.diag(mass).max()) ** 0.5 if mass.any() else np.ones(len(mass))
    weights = np.linalg.eigvalsh(mass * scale * scale[:, None])
    finite = int((weights > noise_of(weights.max(), len(weights))).sum())
    unit = 1 / np.diag(shifted) ** 0.5
    values, turn = scipy.linalg.eigh(mass * unit * unit[:, None], shifted * unit * unit[:, None])
    take = min(finite, wanted)
    values, vectors = values[::-1][:take], free @ (unit[:, None] * turn[:, ::-1][:, :take])
    positive, vectors = _purified(pencil, factors, values, np.asfortranarray(vectors))
    return shift + 1 / positive, vectors, take == finite


def _orthonormal(pencil: ReducedPencil, vectors: np.ndarray) -> np.ndarray:
    """Orthonormalize in place with respect to M, each vector corrected by those of lower frequency only: these are most accurate."""
    gram = vectors.T @ times(pencil.mass, vectors)
    try:
        turn = scipy.linalg.solve_triangular(scipy.linalg.cholesky((gram + gram.T) / 2), np.eye(len(gram)))
    except scipy.linalg.LinAlgError:  # reported by the orthogonality and the count
        return vectors
    _turn(vectors, turn)
    return vectors


def _boundary(values, shift, count, exhausted) -> tuple[float | None, int]:
    """A w^2 in a gap at or after the last requested mode (before it if there is none), and the number of modes below."""
    distance = values - shift
    if not len(values):
        return (0.0, 0) if exhausted else (None, 0)
    if exhausted and len(values) <= count:
        return float(shift + 2 * distance[-1]), len(values)
    gaps = np.diff(distance) / distance[1:]
    after = np.arange(min(count, len(gaps)) - 1, len(gaps))
    at = after[gaps[after].argmax()] if len(after) else -1
    if at < 0 or gaps[at] < FREQUENCY_GAP:
        clear = np.flatnonzero(gaps >= FREQUENCY_GAP)
        if not len(clear):
            return None, 0
        at = clear[-1]
    return float(shift + distance[at : at + 2].mean()), int(at) + 1


def _counted(pencil: ReducedPencil, values, below, inside, factors) -> int | None:
    """The number of modes below; another shift in the same gap is tried where the pivots are not accurate enough."""
    if below is None or factors.negative is None:
        return None
    if not inside:
        return factors.negative
    lower = values[inside - 1]
    for part in (1.0, 0.8, 1.2, 0.6):
        negative = pencil.shifted(float(lower + part * (below - lower))).negative
        if negative is not None:
            return negative
    return None


def _evidence(pencil: ReducedPencil, values, vectors, shift) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The values, zero for rigid bodies, relative residuals and bounds of them."""
    values, residuals, bounds = values.copy(), np.zeros(len(values)), np.zeros(len(values))
    stiffness, mass = abs(pencil.stiffness), abs(pencil.mass)
    steepest = 1 / (values.min(initial=np.inf) - shift)
    for i, x in enumerate(vectors.T):
        static, inertia_force = balanced(pencil, pencil.stiffness @ x), balanced(pencil, pencil.mass @ x)
        size = np.linalg.norm(stiffness @ np.abs(x))
        inertia = np.linalg.norm(mass @ np.abs(x))
        terms = stiffness @ np.abs(x)
        if _is_rigid(pencil, x, static, terms):
            values[i] = 0.0
        elif abs(values[i]) <= SOFT * abs(shift):
            values[i] = quadratic_form(pencil.stiffness, x, 0.0) / (x @ inertia_force)
        elif np.abs(x) @ terms < steepest * (values[i] - shift) ** 2:  # high ones are known better by Rayleigh's quotient
            values[i] = (x @ static) / (x @ inertia_force)
        whole = size + abs(values[i]) * inertia
        unit = abs(values[i]) * np.linalg.norm(inertia_force) or whole or 1.0
        residuals[i] = np.linalg.norm(static - values[i] * inertia_force) / unit
        bounds[i] = (NOISE_SAFETY * EPS * whole + RITZ_RESIDUAL * (abs(values[i]) + abs(shift)) * inertia) / unit
    return values, residuals, bounds


def _is_rigid(pencil: ReducedPencil, x: np.ndarray, forces: np.ndarray, sizes: np.ndarray) -> bool:
    """Whether forces are rounding errors of their terms, coordinate by coordinate, so that soft parts count as much as stiff ones.

    The energy of the shape must be rounding error too: forces of a soft support are spread over all masses.
    """
    parts = np.abs(forces[sizes > 0]) / sizes[sizes > 0]
    if float(np.mean(parts**2) if parts.size else 0.0) ** 0.5 > RIGID_BODY_FORCE:
        return False
    return bool(pencil.rows.shape[0]) or not quadratic_form(pencil.stiffness, x, pencil.rounding)


def balanced(pencil: ReducedPencil, forces: np.ndarray) -> np.ndarray:
    """Forces on the free coordinates without the part that the long rows balance."""
    if not pencil.rows.shape[0]:
        return forces
    rows = pencil.rows
    return forces - rows.T @ np.linalg.lstsq((rows @ rows.T).toarray(), rows @ forces, rcond=None)[0]
