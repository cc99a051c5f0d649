"""s^2 M + s C + K for many s: one pattern, one order of elimination, no sums of sparse matrices.

Where that order can bring all entries next to the diagonal (Cuthill and McKee 1969), as in chains and frames of beams, LAPACK's
banded factors take a tenth of the time of general sparse ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from ...ground.errors import IllConditioned
from ...ground.tolerances import EPS, NEWTON_STEP, NOISE_SAFETY, RITZ_RESIDUAL
from .factorization import Factorization
from .pencil import ReducedPencil
from .undamped_modes import UndampedModes, balanced

# Newton's method for an eigenvalue and its vector of a symmetric quadratic pencil, sparse or small and dense.
#
# Two-sided, as the matrices are symmetric (Lancaster 1961): x <- P(s)^-1 P'(s) x and s <- s - (v^T x) / (v^T P(s)^-1 P'(s) x) with
# v = P'(s) x, one factorization of P(s) = s^2 M + s C + K a step.

#: The steps after which a pair has not converged.
MOST_STEPS = 8


@dataclass(frozen=True, eq=False)
class Residual:
    """P(s) x without the forces of the long rows.

    Attributes:
        forces: it, shape (r,), and its
        norm, besides those of
        terms: terms of the sum of the sizes of its terms,
        inertia: inertia of s^2 M x, and
        damping: of s C x.
    """

    forces: np.ndarray
    norm: float
    terms: float
    inertia: float
    damping: float

    @property
    def relative(self) -> float:
        """The residual as a part of its terms, whatever the length of the vector."""
        return self.norm / (self.terms or 1.0)

    @property
    def is_rounding(self) -> bool:
        """Whether the residual is rounding error, which no correction reduces."""
        return self.norm <= 2 * EPS * self.terms + RITZ_RESIDUAL * self.inertia

    @property
    def evidence(self) -> tuple[float, float]:
        """The residual, and the part that rounding and the stopping rule explain, relative to the inertia."""
        whole = self.inertia or self.terms or 1.0
        return self.norm / whole, (NOISE_SAFETY * EPS * self.terms + RITZ_RESIDUAL * (self.inertia + self.damping)) / whole


@dataclass
class Pair:
    """P(value) vector = 0 with Im value >= 0, during the iteration.

    Attributes:
        resting: whether it is a rigid body without damping (two states).
        converged: whether Newton's method ended at its own zero.
        residual: residual of P(value) vector, once it is known.
        of_body: whether it is a mode of a softly supported body.
    """

    value: complex
    vector: np.ndarray
    resting: bool = False
    converged: bool = True
    residual: Residual | None = None
    of_body: bool = False


def gap(values: np.ndarray, place: int) -> float:
    """Distance from an eigenvalue to the nearest other one, conjugates included."""
    others = np.delete(values, place)
    distances = np.abs(np.concatenate([others, np.conj(values)]) - values[place])
    return float(distances[distances > 0].min(initial=abs(values[place])))


def newton(quadratic, estimate: Pair, room: float) -> Pair:
    """The pair to which Newton's method converges from an estimate.

    With a value wrong by a part p of the gap the vector was wrong by p^(1/2), and is by p^(3/2) after a step.
    """
    value, x, moved, converged = estimate.value, estimate.vector.astype(complex), np.inf, True
    real = value.imag == 0
    for _ in range(MOST_STEPS):
        slope = quadratic.slope(value, x)
        try:
            image = quadratic.factors(value).solve(slope)
        except IllConditioned:  # the value is a zero to the last digit
            break
        if not np.isfinite(image).all():
            break
        step = (slope @ x) / (slope @ image)
        x = image / np.abs(image).max()
        value = complex((value - step).real) if real else value - step
        moved, last = abs(step), moved
        if moved <= NEWTON_STEP * room or (moved <= EPS**0.5 * abs(value) and moved >= last / 2):
            break
    else:
        converged = False
    return Pair(value, x.real if real else x, converged=bool(converged and (real or value.imag > 0)))


#: Up to so many diagonals on each side of the main one banded factors are quicker.
NARROW = 8


@dataclass(frozen=True)
class QuadraticPencil:
    """P(s) = s^2 M + s C + K on the free coordinates of a pencil.

    Attributes:
        pencil: the matrices.
        undamped: its undamped modes, with the order of elimination that made few entries there.
    """

    pencil: ReducedPencil
    undamped: UndampedModes

    @cached_property
    def _entries_off_diagonal(self) -> scipy.sparse.csr_array:
        parts = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        sizes = sum(map(abs, parts), scipy.sparse.csr_array(scipy.sparse.eye_array(self.pencil.size)))
        return scipy.sparse.csr_array(sizes + sizes.T)

    @cached_property
    def _narrow(self) -> tuple[np.ndarray, int]:
        """The order of Cuthill and McKee, and how far from the diagonal there are entries in it."""
        order = reverse_cuthill_mckee(self._entries_off_diagonal, symmetric_mode=True)
        place, entries = np.argsort(order), self._entries_off_diagonal.tocoo()
        return order, int(np.abs(place[entries.row] - place[entries.col]).max())

    @property
    def is_narrow(self) -> bool:
        """Whether the factors are banded, fast enough for one factorization per eigenvalue."""
        return self._narrow[1] <= NARROW

    @cached_property
    def order(self) -> np.ndarray:
        """The order of elimination of the coordinates."""
        return self._narrow[0] if self.is_narrow else np.argsort(self.undamped.factors.lower_upper.perm_c)

    @cached_property
    def _pattern(self) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        """The common pattern in the order of elimination, and the entries of K, C, M on it, shape (3, nnz)."""
        given = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        parts = [scipy.sparse.csc_array(part[self.order][:, self.order]) for part in given]
        whole = scipy.sparse.csc_array(self._entries_off_diagonal[self.order][:, self.order])
        whole.sort_indices()
        column = np.repeat(np.arange(self.pencil.size), np.diff(whole.indptr))
        place = column * self.pencil.size + whole.indices
        entries = np.zeros((3, whole.nnz))
        for row, part in zip(entries, parts):
            coordinates = part.tocoo()
            row[np.searchsorted(place, coordinates.col.astype(np.int64) * self.pencil.size + coordinates.row)] = coordinates.data
        return whole, entries

    @cached_property
    def _diagonals(self) -> tuple[np.ndarray, int]:
        """Positions of the entries of the pattern in LAPACK's band storage, column by column, and the length of that storage."""
        whole, band = self._pattern[0], self._narrow[1]
        column = np.repeat(np.arange(whole.shape[0]), np.diff(whole.indptr))
        return 2 * band + whole.indices + 3 * band * column, (3 * band + 1) * whole.shape[0]

    def factors(self, s: complex) -> Factorization:
        """The factors of P(s), with the rows that were not eliminated."""
        whole, (stiffness, damping, mass) = self._pattern
        data = stiffness + s * (damping + s * mass)
        try:
            if self.is_narrow:
                lower_upper = _Banded.of(data, self._diagonals, self._narrow[1])
            else:
                matrix = scipy.sparse.csc_array((data, whole.indices, whole.indptr), shape=whole.shape)
                lower_upper = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except (RuntimeError, np.linalg.LinAlgError):
            raise IllConditioned(f"s^2 M + s C + K is singular at s = {s:.6g} 1/s") from None
        ordered = _Ordered(lower_upper, self.order, data.dtype)
        rows = self.pencil.rows
        if not rows.shape[0]:
            return Factorization(ordered, None)
        reach = ordered.solve(rows.T.toarray().astype(data.dtype))
        return Factorization(ordered, None, reach, scipy.linalg.lu_factor(rows @ reach), rows)

    def applied(self, s: complex, x: np.ndarray) -> np.ndarray:
        """P(s) x."""
        static, damping, inertia = (_product(part, x) for part in (self.pencil.stiffness, self.pencil.damping, self.pencil.mass))
        return static + s * (damping + s * inertia)

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return _product(self.pencil.damping, x) + 2 * s * _product(self.pencil.mass, x)

    def residual(self, s: complex, x: np.ndarray) -> Residual:
        """The residual of P(s) x = 0."""
        size = np.abs(x)
        terms = sum(abs(s) ** power * (part @ size) for power, part in enumerate(self._sizes))
        static, damping, inertia = (_product(part, x) for part in (self.pencil.stiffness, self.pencil.damping, self.pencil.mass))
        left = balanced(self.pencil, static + s * (damping + s * inertia))
        norms = (np.linalg.norm(part) for part in (left, terms, s**2 * inertia, s * damping))
        return Residual(left, *map(float, norms))

    @cached_property
    def _sizes(self) -> tuple[scipy.sparse.csc_array, ...]:
        return abs(self.pencil.stiffness), abs(self.pencil.damping), abs(self.pencil.mass)


def _product(matrix, x: np.ndarray) -> np.ndarray:
    """A real sparse matrix times a vector that may be complex, without conversion of the matrix."""
    return matrix @ x.real + 1j * (matrix @ x.imag) if x.dtype.kind == "c" else matrix @ x


@dataclass(frozen=True, eq=False)
class _Ordered:
    """Factors of a permuted matrix."""

    factors: Any
    order: np.ndarray
    kind: type

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for one or several right sides in the order of the coordinates."""
        solved = self.factors.solve(np.asfortranarray(right[self.order]).astype(self.kind))
        solution = np.empty_like(solved)
        solution[self.order] = solved
        return solution


@dataclass(frozen=True, eq=False)
class _Banded:
    """Factors of a banded matrix, by LAPACK."""

    factors: np.ndarray
    pivots: np.ndarray
    band: int

    @classmethod
    def of(cls, data: np.ndarray, diagonals: tuple[np.ndarray, int], band: int) -> _Banded:
        places, size = diagonals
        stored = np.zeros(size, dtype=data.dtype)
        stored[places] = data
        stored = stored.reshape((3 * band + 1, -1), order="F")
        (factorize,) = scipy.linalg.get_lapack_funcs(("gbtrf",), (stored,))
        factors, pivots, singular = factorize(stored, band, band, overwrite_ab=True)
        if singular:
            raise np.linalg.LinAlgError
        return cls(factors, pivots, band)

    def solve(self, right: np.ndarray) -> np.ndarray:
        (solve,) = scipy.linalg.get_lapack_funcs(("gbtrs",), (self.factors, right))
        return solve(self.factors, self.band, self.band, right, self.pivots)[0]
