"""s^2 M + s C + K for many s: one pattern, one order of elimination, no sums of sparse matrices.

Where that order can bring all entries next to the diagonal (Cuthill and McKee 1969), as in chains and frames of beams, LAPACK's
banded factors take a tenth of the time of general sparse ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from ...errors import IllConditioned
from .factorization import Factorization
from .newton import Residual
from .pencil import ReducedPencil
from .undamped import UndampedModes, balanced

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
    def _couplings(self) -> scipy.sparse.csr_array:
        parts = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        sizes = sum(map(abs, parts), scipy.sparse.csr_array(scipy.sparse.eye_array(self.pencil.size)))
        return scipy.sparse.csr_array(sizes + sizes.T)

    @cached_property
    def _narrow(self) -> tuple[np.ndarray, int]:
        """The order of Cuthill and McKee, and how far from the diagonal there are entries in it."""
        order = reverse_cuthill_mckee(self._couplings, symmetric_mode=True)
        place, entries = np.argsort(order), self._couplings.tocoo()
        return order, int(np.abs(place[entries.row] - place[entries.col]).max())

    @property
    def is_narrow(self) -> bool:
        """Whether the factors are banded, quick enough to be made for each zero."""
        return self._narrow[1] <= NARROW

    @cached_property
    def order(self) -> np.ndarray:
        """In which the coordinates are eliminated."""
        return self._narrow[0] if self.is_narrow else np.argsort(self.undamped.factors.lower_upper.perm_c)

    @cached_property
    def _pattern(self) -> tuple[scipy.sparse.csc_array, np.ndarray]:
        """The common pattern in the order of elimination, and the entries of K, C, M on it, shape (3, nnz)."""
        given = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        parts = [scipy.sparse.csc_array(part[self.order][:, self.order]) for part in given]
        whole = scipy.sparse.csc_array(self._couplings[self.order][:, self.order])
        whole.sort_indices()
        column = np.repeat(np.arange(self.pencil.size), np.diff(whole.indptr))
        place = column * self.pencil.size + whole.indices
        entries = np.zeros((3, whole.nnz))
        for row, part in zip(entries, parts):
            found = part.tocoo()
            row[np.searchsorted(place, found.col.astype(np.int64) * self.pencil.size + found.row)] = found.data
        return whole, entries

    @cached_property
    def _diagonals(self) -> tuple[np.ndarray, int]:
        """Where the entries of the pattern are in LAPACK's storage of diagonals, column after column, and how long that is."""
        whole, band = self._pattern[0], self._narrow[1]
        column = np.repeat(np.arange(whole.shape[0]), np.diff(whole.indptr))
        return 2 * band + whole.indices + 3 * band * column, (3 * band + 1) * whole.shape[0]

    def factors(self, s: complex) -> Factorization:
        """The factors of P(s), with the rows that were not eliminated.

        Raises:
            IllConditioned: P(s) is singular, or its pivots cannot be trusted.
        """
        whole, (stiffness, damping, mass) = self._pattern
        data = stiffness + s * (damping + s * mass)
        try:
            if self.is_narrow:
                found = _Banded.of(data, self._diagonals, self._narrow[1])
            else:
                matrix = scipy.sparse.csc_array((data, whole.indices, whole.indptr), shape=whole.shape)
                found = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except (RuntimeError, np.linalg.LinAlgError):
            raise IllConditioned(f"s^2 M + s C + K is singular at s = {s:.6g} 1/s") from None
        ordered = _Ordered(found, self.order, data.dtype)
        rows = self.pencil.rows
        if not rows.shape[0]:
            return Factorization(ordered, None)
        reach = ordered.solve(rows.T.toarray().astype(data.dtype))
        return Factorization(ordered, None, reach, scipy.linalg.lu_factor(rows @ reach), rows)

    def applied(self, s: complex, x: np.ndarray) -> np.ndarray:
        """P(s) x."""
        held, slowed, inertia = (_product(part, x) for part in (self.pencil.stiffness, self.pencil.damping, self.pencil.mass))
        return held + s * (slowed + s * inertia)

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return _product(self.pencil.damping, x) + 2 * s * _product(self.pencil.mass, x)

    def residual(self, s: complex, x: np.ndarray) -> Residual:
        """How well P(s) x = 0 holds."""
        size = np.abs(x)
        terms = sum(abs(s) ** power * (part @ size) for power, part in enumerate(self._sizes))
        held, slowed, inertia = (_product(part, x) for part in (self.pencil.stiffness, self.pencil.damping, self.pencil.mass))
        left = balanced(self.pencil, held + s * (slowed + s * inertia))
        norms = (np.linalg.norm(part) for part in (left, terms, s**2 * inertia, s * slowed))
        return Residual(left, *map(float, norms))

    @cached_property
    def _sizes(self) -> tuple[scipy.sparse.csc_array, ...]:
        return abs(self.pencil.stiffness), abs(self.pencil.damping), abs(self.pencil.mass)


def _product(matrix, x: np.ndarray) -> np.ndarray:
    """A real sparse matrix times a vector that may be complex, for which it need not become complex itself."""
    return matrix @ x.real + 1j * (matrix @ x.imag) if x.dtype.kind == "c" else matrix @ x


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


@dataclass(frozen=True)
class _Banded:
    """Factors of a matrix with few diagonals, by LAPACK."""

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
