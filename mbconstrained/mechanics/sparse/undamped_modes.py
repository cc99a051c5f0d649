"""The modes of lowest frequency of M x'' + K x = 0 with A x = 0, computed, corrected and counted.

Shift-invert Lanczos from a shift just below the spectrum computes them. Sylvester's law of inertia counts the eigenvalues below a
frequency in a gap: missing ones are computed in the complement of the others (Grimes, Lewis and Simon 1994). Small systems, or
nearly all modes of a system, take a dense decomposition of the same shifted and inverted pencil instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse

from ...ground.errors import InputError
from ...ground.tolerances import EPS, FREQUENCY_GAP, NOISE_SAFETY, RIGID_BODY_FORCE, RITZ_RESIDUAL, noise_of
from .factorization import Factorization, factorize
from .lanczos import BLOCK, first_values, largest_pairs
from .pencil import ReducedPencil
from .sparse_matrices import quadratic_form, times

#: Up to this size a dense decomposition is as fast.
DENSE = 400

#: Each step takes nine tenths of what is elastic out of a rigid body's shape.
RIGID_STEPS = 4

#: Modes computed beyond the requested ones, so that there is a gap among them.
GUARD = 4

#: Rows that are turned at a time: no second array as large as all vectors.
CHUNK = 8192

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
    """K X = M X diag(values) on the free coordinates, ascending.

    Attributes:
        values: w^2 in 1/s^2, exactly zero for rigid bodies, negative for growth.
        vectors: X, shape (r, m), X^T M X = I.
        residuals, bounds: |K x - w^2 M x| and the part of it that rounding and the stopping rule explain, both relative to
            the sum of the sizes of its terms.
        shift, factors: K - shift M, below all values.
        below: the w^2 up to which modes were counted; None where no count was to be had.
        counted: number of eigenvalues below it.
        computed_below: the number of computed ones below it.
        complete: whether the system has no other finite modes.
    """

    values: np.ndarray
    vectors: np.ndarray
    residuals: np.ndarray
    bounds: np.ndarray
    shift: float
    factors: Factorization
    below: float | None
    counted: int | None
    computed_below: int
    complete: bool


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
        values = first_values(factors.solve, pencil.mass, FIRST_LOOK)
        values = values[values > 0]
        estimates = shift + 1 / values
        if not len(values):
            break
        if estimates[0] < -TOO_CLOSE * abs(shift) and estimates[0] - shift > 2 * BETTER_SHIFT * abs(estimates[0]):
            candidates = [float(estimates[0] - margin * abs(estimates[0])) for margin in MARGINS]
        elif (
            values[-1] < values[0] * TOO_CLOSE
            and (elastic := estimates[estimates > abs(shift)]).size < len(estimates)
            and elastic.size
        ):
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
    pairs = largest_pairs(factors.solve, pencil.mass, wanted, locked, block)
    values, vectors = _purified(pencil, factors, pairs.values, pairs.vectors)
    return shift + 1 / values, vectors, pairs.exhausted


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
    for begin in range(0, len(vectors), CHUNK):
        vectors[begin : begin + CHUNK] = vectors[begin : begin + CHUNK] @ turn
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
