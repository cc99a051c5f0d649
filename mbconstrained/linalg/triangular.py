"""A regular pencil s E - F with regular E as s I - T, T in real Schur form.

Zeros at s = 0 (rigid bodies, the drift of constraints) are split off first, by rank decisions: their part of T is
nilpotent to the last bit, however stiff the rest is. E^-1 F is never formed from an ill-conditioned E: next
to fast zeros it has entries so large that rounding errors of its eigenvalues swamps the slow ones. The QZ algorithm
works on the equilibrated pencil instead, where a zero lambda suffers a relative error of about
eps (|lambda| + 1 / |lambda|) in the pencil's own unit of time, and only then the two factors are divided.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from scipy.linalg import lapack

from ..ground.errors import IllConditioned
from ..ground.threads import one_thread
from ..ground.tolerances import DECOUPLING_LIMIT
from .blocks import coupled_rows
from .precise import inverse, is_precise, magnitude, of_kind, power_of_two, precise, product, solved
from .precise_blocks import block_diagonal
from .rank import RankDecision
from .rounding import Noisy
from .scaling import equilibration
from .staircase import SingularPencil, split_pencil


@dataclass(frozen=True, eq=False)
class TriangularForm:
    """left (s E - F) right = s I - T, all of shape (n, n).

    Attributes:
        nonzero_count: the leading rows of T with zeros other than 0; the rest is strictly upper triangular.
        decisions: the rank decisions taken.
        zero_divisors: degrees of the elementary divisors at s = 0, ascending.
    """

    left: np.ndarray
    right: np.ndarray
    T: np.ndarray
    nonzero_count: int
    decisions: tuple[RankDecision, ...] = ()
    zero_divisors: tuple[int, ...] = ()


def triangular_form(E: Noisy, F: Noisy, decided: Iterator[RankDecision] | None = None) -> TriangularForm:
    """Bring s E - F, E regular, to s I - T with T in standardized real Schur form."""
    try:
        split = split_pencil(F, E, decided)  # with the roles exchanged: its E11 belongs to F, its F11 to E
    except SingularPencil:  # E was found regular: what seems to vanish with F here is carried noise
        split = split_pencil(Noisy.exact(F.data), Noisy.exact(E.data))
    n = len(split.E11.data)
    rest = (_by_scales if is_precise(E.data) else _schur)(split.F11.data, split.E11.data)
    coupling_E, coupling_F = product(rest.left, split.F12.data), product(rest.left, split.E12.data)
    # the independent chains one after the other
    order = np.concatenate([np.zeros(0, dtype=int), *coupled_rows(split.nilpotent.data)])
    N = split.nilpotent.data[np.ix_(order, order)]
    zero_rows, zero_columns = split.left.data[n:][order], split.right.data[:, n:][:, order]
    coupling_E, coupling_F = coupling_E[:, order], coupling_F[:, order]
    form = TriangularForm(
        left=np.vstack([product(rest.left, split.left.data[:n]) - product(coupling_E, zero_rows), zero_rows]),
        right=np.hstack([product(split.right.data[:, :n], rest.right), zero_columns]),
        T=np.vstack([np.hstack([rest.T, coupling_F - product(coupling_E, N)]), np.hstack([of_kind(np.zeros((len(N), n)), N), N])]),
        nonzero_count=n,
        decisions=split.decisions,
        zero_divisors=split.infinite_divisors,
    )
    return _zeros_decoupled(_measured(form)) if is_precise(E.data) else form


def _by_scales(E: np.ndarray, F: np.ndarray) -> TriangularForm:
    """Triangular form of a precise pencil without zeros at 0, T block diagonal."""
    if not len(E):
        return TriangularForm(E, E, E, 0)
    result = block_diagonal(solved(E, F))
    T = precise(scipy.linalg.block_diag(*result.blocks))
    return TriangularForm(product(result.inverse, inverse(E)), result.basis, T, len(E))


def _measured(form: TriangularForm) -> TriangularForm:
    """Units of the states of each block that give its rows of ``left`` and its columns of ``right`` the same size."""
    n = form.nonzero_count
    units = np.zeros(len(form.T))
    for at in coupled_rows(form.T[:n, :n]):
        units[at] = np.round(np.log2(magnitude(form.left[at]).max() / magnitude(form.right[:, at]).max()) / 2)
    unit = power_of_two(units)
    return replace(form, left=form.left / unit[:, None], right=form.right * unit, T=form.T * unit / unit[:, None])


def _zeros_decoupled(form: TriangularForm) -> TriangularForm:
    """Remove the coupling of the zeros at 0 with the others, except for motions too slow to be separated.

    X solves T X - X N = -G; N is nilpotent, so the fixed point is reached in as many steps as N has rows.
    """
    n, m = form.nonzero_count, len(form.T) - form.nonzero_count
    T, G, N = form.T[:n, :n], form.T[:n, n:], form.T[n:, n:]
    if not n or not m:
        return form
    back, X = inverse(T), 0 * G
    for _ in range(m):
        X = product(back, product(X, N) - G)
    close = magnitude(X).max(axis=1) > DECOUPLING_LIMIT
    for _ in range(n):
        more = close | ((magnitude(T) > 0) @ close)  # rows that reach those of a close motion stay with them
        if (more == close).all():
            break
        close = more
    X = np.where(close[:, None], 0 * X, X)
    kept = np.where(close[:, None], G + product(T, X), 0 * G)  # rows of a block that stay coupled see those that do not
    left, right, T = form.left.copy(), form.right.copy(), form.T.copy()
    left[:n] = left[:n] - product(X, left[n:])
    right[:, n:] = right[:, n:] + product(right[:, :n], X)
    T[:n, n:] = kept
    return replace(form, left=left, right=right, T=T)


def _schur(E: np.ndarray, F: np.ndarray) -> TriangularForm:
    """Triangular form in float64 without zeros at 0."""
    n = len(E)
    if not n:
        empty = np.zeros((0, 0))
        return TriangularForm(empty, empty, empty, 0)
    rows, columns = equilibration(np.maximum(np.abs(E), np.abs(F)))
    S, P, Q, Z = _qz(rows[:, None] * F * columns, rows[:, None] * E * columns)
    if not np.diag(P).all():
        raise IllConditioned(
            "the zeros of A(s) differ by more orders of magnitude than float64 can hold; look for a mass, stiffness or "
            "ratio far out of proportion, or a wrong unit"
        )
    divided = lapack.dtrtrs(P, np.concatenate([S, Q.T * rows], axis=1))[0]
    T, left = divided[:, :n], divided[:, n:]
    right = columns[:, None] * Z
    _standardize(T, S, left, right)
    return TriangularForm(left, right, T, n)


def _qz(F: np.ndarray, E: np.ndarray):
    """S, P, Q, Z with Q^T F Z = S quasi-triangular and Q^T E Z = P triangular."""
    room = int(lapack.dgges(_never, F, E, lwork=-1)[-2][0])
    with one_thread(len(F)):
        S, P, *_, Q, Z, _, failed = lapack.dgges(_never, F, E, lwork=room)
    if failed:
        raise IllConditioned("float64 finds no zeros of A(s): the QZ algorithm does not converge; choose other units")
    return S, P, Q, Z


def _never(*_) -> None:
    """Selection of no zeros for the top."""


def _standardize(T, S, left, right) -> None:
    """Remove rounding errors of the division below the diagonal and give the 2 x 2 blocks equal diagonals, in place."""
    at = 0
    while at < len(T):
        if at + 1 < len(T) and S[at + 1, at] != 0:
            pair = slice(at, at + 2)
            block, *_, turn, _, _ = lapack.dgees(_never, T[pair, pair], sort_t=0)
            T[pair] = turn.T @ T[pair]
            T[:, pair] = T[:, pair] @ turn
            T[pair, pair] = block
            left[pair] = turn.T @ left[pair]
            right[:, pair] = right[:, pair] @ turn
            at += 1
        at += 1
    below = np.diag(T, -1) * (np.diag(S, -1) != 0)
    T[np.tri(len(T), k=-1, dtype=bool)] = 0.0
    T[np.arange(1, len(T)), np.arange(len(T) - 1)] = below
