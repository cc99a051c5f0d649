"""X^T of a transformation T = [X^T F; X^T A] that takes the inputs to [0; I_p], of small condition.

B extended by n/2 - p columns B_2 to B_e with [B_e, A B_e] regular gives X^T = [0 I] [B_e, A B_e]^-1 at once. Seen from X^T these
are the solutions of X^T B = 0 and X^T A B = [0; I_p]: one of them, and any multiple of the (n - 2 p) rows N^T that
annihilate [B, A B], in each of the n/2 rows. Almost every choice is regular where a normal form exists, and the
(n/2) (n - 2 p) free numbers serve to make the condition of T small. With a descriptor matrix F the rows multiply the equations:
X^T B = 0 and X^T A F^-1 B = [0; I_p], and only F^-1 B has to be solved for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...ground.tolerances import EPS, NOISE_SAFETY
from .descriptor import ScaledPencil

#: Random starting points, and steps from the best of them: local minima are near each other, and a minimum is flat.
STARTS, STEPS = 4, 100

#: For more states than this fewer: each step costs the inverse of a full matrix.
LARGE, STARTS_OF_LARGE, STEPS_OF_LARGE = 60, 2, 30

#: By how much the logarithm of the condition must become smaller for a system in normal form to change its coordinates.
WORTH = 1e-3

#: The logarithm of the condition where T is singular, beyond that of any regular matrix.
SINGULAR = 1e3


@dataclass(frozen=True, eq=False)
class TransformationFamily:
    """All rows X^T = particular + free @ null^T of the transformations of a pencil.

    Attributes:
        A, F: shape (n, n).
        particular: shape (n/2, n); its last p rows belong to the inputs.
        null: N, shape (n, n - 2 p), orthonormal, N^T [B, A B] = 0.
    """

    A: np.ndarray
    F: np.ndarray
    particular: np.ndarray
    null: np.ndarray

    def rows(self, free) -> np.ndarray:
        """X^T for the free parameters (n/2, n - 2 p)."""
        return self.particular + free.reshape(len(self.particular), -1) @ self.null.T

    def transformation(self, free) -> np.ndarray:
        """T, shape (n, n)."""
        rows = self.rows(free)
        return np.vstack([rows @ self.F, rows @ self.A])


def family(pair: ScaledPencil) -> TransformationFamily:
    """The solutions of X^T [B, A F^-1 B] = [0, [0; I_p]]."""
    n, p = pair.B.shape
    both = np.hstack([pair.B, pair.A @ pair.input_space])
    Q, R = np.linalg.qr(both, mode="complete") if p else (np.eye(n), np.zeros((n, 0)))
    particular = np.zeros((n // 2, n))
    if p:
        coordinates = np.eye(p) if pair.explicit else np.linalg.inv(pair.input_space.T @ pair.through)
        right = np.vstack([np.zeros((p, p)), coordinates.T])
        particular[n // 2 - p :] = (Q[:, : 2 * p] @ scipy.linalg.solve_triangular(R[: 2 * p], right, trans="T")).T
    return TransformationFamily(pair.A, pair.F, particular, Q[:, 2 * p :])


def well_conditioned_rows(pair: ScaledPencil) -> np.ndarray:
    """X^T in the given units, shape (n/2, n): solutions in those of the pair, improved in the given ones.

    A system that is in normal form keeps its coordinates, the first half of its states.
    """
    solutions = family(pair)
    n, p = pair.B.shape
    coordinates = np.concatenate([np.full(n // 2 - p, pair.rate), pair.input / pair.rate])
    units = np.concatenate([coordinates / pair.rate, coordinates])[:, None], 1 / pair.state
    own = (np.eye(n // 2, n) / (coordinates[:, None] * pair.equation) - solutions.particular) @ solutions.null
    free = _best(solutions, own, units) if 2 * p < n else own
    return coordinates[:, None] * _without_rounding(solutions.rows(free)) * pair.equation


def _best(solutions: TransformationFamily, own, units) -> np.ndarray:
    """The free parameters of the best start, improved; ``own`` where the gain is too small."""
    starts, steps = (STARTS, STEPS) if len(solutions.A) < LARGE else (STARTS_OF_LARGE, STEPS_OF_LARGE)
    start = min([own, *_starts(solutions, starts)], key=lambda free: _condition(free.ravel(), solutions)[0])
    best = _improved(_improved(start, solutions, steps), solutions, steps, *units)
    before, after = (_condition(free.ravel(), solutions, *units)[0] for free in (own, best))
    return own if before <= after + WORTH else best


def _without_rounding(rows) -> np.ndarray:
    """Entries below the noise of their row and column set to zero, so that sparse systems stay sparse."""
    size = np.abs(rows)
    noise = NOISE_SAFETY * EPS * np.minimum(size.max(axis=1, keepdims=True), size.max(axis=0, initial=0.0))
    return np.where(size <= noise, 0.0, rows)


def _starts(solutions: TransformationFamily, count: int) -> Iterator[np.ndarray]:
    """Orthonormal rows for the coordinates, also for those with inputs, without which T may be singular (Eq. 11 as printed)."""
    half, free = len(solutions.particular), solutions.null.shape[1]
    random = np.random.default_rng(half)
    lengths = np.linalg.norm(solutions.particular, axis=1, keepdims=True)
    for _ in range(count):
        start = lengths * random.standard_normal((half, free)) / free**0.5
        start[: free // 2] = np.linalg.qr(random.standard_normal((free, free // 2)))[0].T
        yield start


def _improved(free, solutions: TransformationFamily, steps: int, left=1.0, right=1.0) -> np.ndarray:
    """Quasi-Newton steps on the logarithm of |T| |T^-1| in the Frobenius norm; a worse result is rejected."""
    from scipy.optimize import minimize  # takes half a second

    before = _condition(free.ravel(), solutions, left, right)[0]
    answer = minimize(_condition, free.ravel(), (solutions, left, right), method="L-BFGS-B", jac=True, options={"maxiter": steps})
    return answer.x.reshape(free.shape) if answer.fun < before else free


def _condition(free, solutions: TransformationFamily, left=1.0, right=1.0) -> tuple[float, np.ndarray]:
    """log of |left T right| |(left T right)^-1|, and its gradient by the free numbers."""
    T = left * solutions.transformation(free) * right
    try:
        inverse = np.linalg.inv(T)
    except np.linalg.LinAlgError:
        return SINGULAR, np.zeros(free.shape)
    size, inverse_size = np.linalg.norm(T), np.linalg.norm(inverse)
    if not np.isfinite(size) or not np.isfinite(inverse_size):
        return SINGULAR, np.zeros(free.shape)
    unit = inverse / inverse_size
    gradient = left * (T / size**2 - unit.T @ unit @ inverse.T) * right
    half = len(solutions.particular)
    by_rows = gradient[:half] @ solutions.F.T + gradient[half:] @ solutions.A.T
    return float(np.log(size) + np.log(inverse_size)), (by_rows @ solutions.null).ravel()
