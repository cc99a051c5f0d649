"""s^2 M + s C + K for many s: one pattern, one order of elimination, no sums of sparse matrices."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse.linalg import splu

from ...errors import IllConditioned
from .factorization import Factorization
from .pencil import ReducedPencil
from .undamped import balanced


@dataclass(frozen=True)
class QuadraticPencil:
    """P(s) = s^2 M + s C + K on the free coordinates of a pencil.

    Attributes:
        pencil: the matrices.
        order: in which the coordinates are eliminated.
    """

    pencil: ReducedPencil
    order: np.ndarray

    @cached_property
    def _pattern(self) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        """The common pattern in the order of elimination, and the entries of K, C, M on it, shape (3, nnz)."""
        given = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        parts = [scipy.sparse.csc_array(part[self.order][:, self.order]) for part in given]
        whole = abs(parts[0]) + abs(parts[1]) + abs(parts[2]) + scipy.sparse.eye_array(self.pencil.size)
        whole = scipy.sparse.csc_array(whole)
        whole.sort_indices()
        column = np.repeat(np.arange(self.pencil.size), np.diff(whole.indptr))
        place = column * self.pencil.size + whole.indices
        entries = np.zeros((3, whole.nnz))
        for row, part in zip(entries, parts):
            found = part.tocoo()
            row[np.searchsorted(place, found.col.astype(np.int64) * self.pencil.size + found.row)] = found.data
        return whole, entries

    def factors(self, s: complex) -> Factorization:
        """The factors of P(s), with the rows that were not eliminated.

        Raises:
            IllConditioned: P(s) is singular, or its pivots cannot be trusted.
        """
        whole, (stiffness, damping, mass) = self._pattern
        data = stiffness + s * (damping + s * mass)
        matrix = scipy.sparse.csc_array((data, whole.indices, whole.indptr), shape=whole.shape)
        try:
            found = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError:
            raise IllConditioned(f"s^2 M + s C + K is singular at s = {s:.6g} 1/s") from None
        ordered = _Ordered(found, self.order, data.dtype)
        rows = self.pencil.rows
        if not rows.shape[0]:
            return Factorization(ordered, None)
        reach = ordered.solve(rows.T.toarray().astype(data.dtype))
        return Factorization(ordered, None, reach, scipy.linalg.lu_factor(rows @ reach), rows)

    def applied(self, s: complex, x: np.ndarray) -> np.ndarray:
        """P(s) x."""
        pencil = self.pencil
        return pencil.stiffness @ x + s * (pencil.damping @ x + s * (pencil.mass @ x))

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return self.pencil.damping @ x + 2 * s * (self.pencil.mass @ x)

    def residual(self, s: complex, x: np.ndarray) -> tuple[float, float, float]:
        """|P(s) x| without what the long rows carry, the sum of the sizes of its terms, and |s|^2 |M x|."""
        pencil, size = self.pencil, np.abs(x)
        terms = abs(pencil.stiffness) @ size + abs(s) * (abs(pencil.damping) @ size) + abs(s) ** 2 * (abs(pencil.mass) @ size)
        left = np.linalg.norm(balanced(pencil, self.applied(s, x)))
        return float(left), float(np.linalg.norm(terms)), float(abs(s) ** 2 * np.linalg.norm(pencil.mass @ x))


@dataclass(frozen=True)
class _Ordered:
    """Factors of a permuted matrix."""

    factors: object
    order: np.ndarray
    kind: type

    def solve(self, right: np.ndarray) -> np.ndarray:
        """One or several right sides in the order of the coordinates."""
        solved = self.factors.solve(np.asfortranarray(right[self.order]).astype(self.kind))
        found = np.empty_like(solved)
        found[self.order] = solved
        return found
