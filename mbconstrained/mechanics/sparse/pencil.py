"""K - s M on the coordinates that the constraint rows leave free, and where its spectrum lies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg

from ...errors import ContradictoryConstraints, InputError
from ...notices import Notice
from ...tolerances import EPS, NOISE_SAFETY
from .elimination import Elimination, eliminate, told
from .factorization import Factorization, factorize
from .rows import HeldRows

#: The first shift is this part of a typical K_ii / M_ii below zero: far above rounding, where a body is free, and below the
#: lowest frequencies of all but the longest chains.
FIRST_SHIFT = 1e-9

#: A negative stiffness is looked for by shifts, each this many times farther below zero, as often as this.
FARTHER, FARTHEST = 100.0, 9

#: More rows than this are not bordered but eliminated, however long they are.
MOST_BORDERED = 200


@dataclass(frozen=True)
class ReducedPencil:
    """M, C, K as N^T . N on r free coordinates y with x = N y + x_held, and the long rows L y = 0 that are left.

    Attributes:
        mass, damping, stiffness: shape (r, r), sparse.
        basis: N, shape (n, r).
        offset: x_held, shape (n,).
        rows: L, shape (k, r).
        row_values: what they hold.
        names: of the n coordinates, by place.
        free: the coordinate that each of y is.
        notices: rows that say nothing new.
    """

    mass: scipy.sparse.csc_array
    damping: scipy.sparse.csc_array
    stiffness: scipy.sparse.csc_array
    basis: scipy.sparse.csc_array
    offset: np.ndarray
    rows: scipy.sparse.csr_array
    row_values: np.ndarray
    names: Callable[[int], str]
    free: np.ndarray
    notices: tuple[Notice, ...]

    @property
    def size(self) -> int:
        """Number r of free coordinates."""
        return self.mass.shape[0]

    @cached_property
    def typical(self) -> float:
        """The median of K_ii / M_ii over coordinates with mass and stiffness, 1 where there is none."""
        mass, stiffness = self.mass.diagonal(), np.abs(self.stiffness.diagonal())
        both = (mass > 0) & (stiffness > 0)
        if both.any():
            return float(np.median(stiffness[both] / mass[both]))
        return float(stiffness.max() / mass.max()) if stiffness.any() and (mass > 0).any() else 1.0

    def described(self, places) -> str:
        """Names of some free coordinates in words."""
        return ", ".join(f'"{self.names(int(self.free[place]))}"' for place in places)

    def shifted(self, shift: float, counted: bool = True) -> Factorization:
        """The factors of K - shift M."""
        return factorize(scipy.sparse.csc_array(self.stiffness - shift * self.mass), self.rows, self.described, counted)

    def below_all(self, first: float | None = None) -> tuple[float, Factorization]:
        """A shift below all eigenvalues, and the factors there.

        Raises:
            InputError: no shift is, so that something without mass has negative stiffness.
        """
        shift = -FIRST_SHIFT * self.typical if first is None else first
        for _ in range(FARTHEST):
            factors = self.shifted(shift)
            if factors.negative in (0, None):
                return shift, factors
            shift *= FARTHER
        raise InputError(
            "stiffness: massless coordinates have a negative stiffness, or the mass matrix has negative eigenvalues: the modes of "
            "lowest frequency are not defined; check the signs of stiffness and mass"
        )


def reduced_pencil(mass, damping, stiffness, held: HeldRows, names) -> ReducedPencil:
    """Eliminate the rows and project the matrices.

    Raises:
        ContradictoryConstraints: dependent rows ask for different values.
        InputError: the rows leave nothing free.
    """
    long = int((np.diff(held.matrix.indptr) > 0).sum())
    found = eliminate(held)
    if len(found.kept) > MOST_BORDERED:
        found = eliminate(held, longest=mass.shape[0])
    if not len(found.free):
        raise InputError(f"constraints: the {long} rows leave no coordinate free; take some of them out")
    N = found.basis
    project = _projection(N)
    rows = scipy.sparse.csr_array(held.matrix[found.kept] @ N)
    values = held.values[found.kept] - held.matrix[found.kept] @ found.offset
    pencil = ReducedPencil(
        project(mass), project(damping), project(stiffness), N, found.offset, rows, values, names, found.free, _told(held, found)
    )
    return _independent(pencil, held, found)


def _projection(N) -> Callable:
    if N.shape[0] == N.shape[1]:
        return scipy.sparse.csc_array

    def projected(matrix):
        small = scipy.sparse.csc_array(N.T @ matrix @ N)
        small.eliminate_zeros()
        return small

    return projected


def _told(held: HeldRows, found: Elimination) -> tuple[Notice, ...]:
    notices = []
    for place, others in found.dependent.items():
        reason = f"it follows from {told(held, others)}" if others else "all its coefficients are zero"
        notices.append(Notice("redundant", f'constraint "{held.names[place]}" says nothing new and was left out: {reason}'))
    return tuple(notices)


def _independent(pencil: ReducedPencil, held: HeldRows, found: Elimination) -> ReducedPencil:
    """The pencil without long rows that follow from others; these are few, and so dense products of them are small."""
    if not pencil.rows.shape[0]:
        return pencil
    sizes = scipy.sparse.linalg.norm(pencil.rows, axis=1)
    given = scipy.sparse.linalg.norm(held.matrix[found.kept], axis=1)
    scaled = scipy.sparse.csr_array(scipy.sparse.diags_array(1 / np.where(given > 0, given, 1.0)) @ pencil.rows)
    limit = NOISE_SAFETY * EPS * pencil.size**0.5
    gram = (scaled @ scaled.T).toarray()
    triangle, order = scipy.linalg.qr(gram, mode="r", pivoting=True)
    rank = int((np.abs(np.diag(triangle)) > limit * max(np.abs(triangle[0, 0]), 1.0)).sum()) if sizes.any() else 0
    kept, left = np.sort(order[:rank]), order[rank:]
    notices = list(pencil.notices)
    for place in left:
        mixed = np.linalg.lstsq(gram[np.ix_(kept, kept)], gram[kept, place], rcond=None)[0]
        values = pencil.row_values / np.where(given > 0, given, 1.0)
        implied, name = mixed @ values[kept], held.names[found.kept[place]]
        if abs(values[place] - implied) > limit * np.abs(values).max():
            raise ContradictoryConstraints(
                f'constraint "{name}" follows from other rows, which ask for another value; make the values agree or take it out'
            )
        notices.append(Notice("redundant", f'constraint "{name}" says nothing new and was left out: it follows from other rows'))
    return replace(pencil, rows=pencil.rows[kept], row_values=pencil.row_values[kept], notices=tuple(notices))

