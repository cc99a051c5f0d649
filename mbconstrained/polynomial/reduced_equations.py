"""A(s) reduced to w' = S w, its motions that are conserved (rigid bodies and their drift), and its modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ..ground.tolerances import (
    DECOUPLING_LIMIT,
    DOUBTFUL_SUM,
    EPS,
    FREE_MOTION_GAP,
    INTEGER_DISTANCE,
    REDUCED_AMPLIFICATION,
    ROUNDED_FREE,
    ROUNDING_SUPPORT,
    SEPARATION_STEPS,
    SIMILAR_EIGENVALUES,
    SLOWED_RATE,
    noise_of,
)
from ..linalg.arrays import (
    Matrix,
    block_diag,
    diagonal_parts,
    entries,
    entry_count,
    filled,
    full,
    kept,
    matrix_of,
    of_like_kind,
    others,
)
from ..linalg.blocks import (
    BlockDiagonal,
    assembled,
    block_diagonalize,
    block_matrix,
    block_slices,
    coupled_rows,
    decoupled,
    is_weakly_coupled,
    zeros_of,
)
from ..linalg.division import (
    accurately_solved,
    exact_product,
    exact_row_sums,
    is_semidefinite,
    is_symmetric,
    solution,
    solved,
    vanish_exactly,
    without_noise,
)
from ..linalg.scaling import balancing_units, equilibration
from ..linalg.symmetric import SymmetricModes, may_be_wide, modes_of_wide_spread, symmetric_modes

if TYPE_CHECKING:
    from ..linalg.tree_modes import ResidueModes, SparseTopology

# Zeros at s = 0 that follow exactly from A(s): rows without stiffness.
# A row i of M x'' + C x' + K x with K_i = 0 conserves p_i = M_i x' + C_i x, and one with C_i = 0 too lets q_i = M_i x grow with it,
# q_i' = p_i: a free mass, the drift of a constraint at velocity or acceleration level. Of the states w these numbers are z = L w
# with L S = J L, where J has blocks [0] and [[0, 1], [0, 0]] and nothing is rounded. They take the place of as many states, and the
# others are decoupled from them by a linear equation: S has no more zeros at 0 where the matrix of the rows' lowest coefficients,
# each of its power of s, is regular (``lowest``).


@dataclass(frozen=True, eq=False)
class Conserved:
    """The conserved quantities z = L w of the states w = (x_m, x_m', x_d).

    Attributes:
        rows: L, shape (k, n).
        blocks: blocks of J.
        places: which states they replace, shape (k,).
        left: R with L S = J L + R [I; S_d], S_d the rows of x_d, shape (k, n + d): what soft supports of a free body change of
            them; None where there are none.
    """

    rows: np.ndarray
    blocks: tuple[np.ndarray, ...]
    places: np.ndarray
    left: np.ndarray | None = None


def lowest(M: Matrix, C: Matrix, K: Matrix) -> tuple[Matrix, np.ndarray]:
    """The lowest nonzero coefficient of each row, and its power of s, for M of shape (m, m), C and K of (m + d, m + d)."""
    stiff = filled(K, 1)
    if stiff.all():
        return K, np.zeros(len(stiff), dtype=int)
    powers = ~stiff * (2 - filled(C, 1))
    result, m = full(K).copy(), M.shape[0]
    slow, free = powers == 1, (powers == 2).nonzero()[0]
    result[slow] = full(C)[slow]
    result[free, :m] = full(M)[free]
    return result, powers


def conserved(
    M: Matrix, C: Matrix, rows: np.ndarray, powers: np.ndarray, pivots: np.ndarray, freed: Freed | None = None
) -> Conserved:
    """The conserved quantities of rows without stiffness."""
    m, n = M.shape[0], M.shape[0] + C.shape[0]
    M, C = full(M), full(C)
    L, places, blocks = [], [], []
    for row, power, pivot in zip(rows.tolist(), powers.tolist(), pivots.tolist()):
        momentum, place = np.zeros(n), pivot if pivot < m else m + pivot
        if row < m:
            momentum[m : 2 * m] = M[row]
        if power == 1:
            momentum[:m], momentum[2 * m :] = C[row, :m], C[row, m:]
            L, places, blocks = [*L, momentum], [*places, place], [*blocks, np.zeros((1, 1))]
        else:
            L += [np.concatenate([M[row], np.zeros(n - m)]), momentum]
            places, blocks = [*places, place, m + pivot], [*blocks, np.array([[0.0, 1.0], [0.0, 0.0]])]
    return Conserved(np.array(L), tuple(blocks), np.array(places), None if freed is None else _left(freed, m, rows, powers))


def _left(freed: Freed, m: int, rows: np.ndarray, powers: np.ndarray) -> np.ndarray | None:
    """R of ``Conserved``; for a double zero the first quantity changes by the second alone."""
    stiff, damped = freed.remainders[:, np.searchsorted(freed.places, rows)]
    damped = damped * ~freed.slowed[np.searchsorted(freed.places, rows), None]
    if not stiff.any() and not damped.any():
        return None
    own = np.hstack([stiff[:, :m], damped[:, :m], stiff[:, m:], damped[:, m:]])
    return -np.concatenate([np.stack([0 * row, row])[2 - power :] for row, power in zip(own, powers.tolist())])


def decoupled_with_conserved(S: np.ndarray, given: Conserved, decoupled: Callable[..., BlockDiagonal]) -> BlockDiagonal:
    """S decoupled, with the conserved quantities last."""
    L, n, J = given.rows, len(S), block_matrix(given.blocks)
    count, rest = n - len(L), others(n, given.places)
    basis, inverse = np.zeros((n, n)), np.zeros((n, n))
    basis[rest, range(count)] = inverse[range(count), rest] = 1.0
    basis[given.places] = solution(L[:, given.places], np.concatenate([-L[:, rest], np.eye(len(L))], axis=1))
    inverse[count:] = L
    moving = S[rest] @ basis  # [A, D] of the other states y' = A y + D z
    A, D = moving[:, :count], moving[:, count:]
    rows, own = inverse[:count], basis[:, count:]
    if given.left is not None:
        slow = given.left[:, :n] + given.left[:, n:] @ S[2 * n - given.left.shape[1] :]
        return _decoupled_with_slow(A, D, given.blocks, slow @ basis, basis, inverse, decoupled)
    if np.count_nonzero(D):
        X = solution(A, -D)
        X = X + solution(A, X @ J)  # A X - X J = -D, for J J = 0
        rows, own = rows - X @ L, own + basis[:, :count] @ X
    if not (np.abs(own) * np.abs(L.T)).sum(axis=0).max() <= DECOUPLING_LIMIT:
        return _by_clusters(A, D, J, basis, inverse)
    parts = decoupled(A, rest)
    rate = max((float(np.abs(block).max()) for block in parts.blocks), default=0.0)
    unit = 2.0 ** np.rint(np.log2(rate)) if rate else 1.0  # growth with a momentum is scaled by the others' unit of time
    units = np.concatenate([[1.0, unit][: len(block)] for block in given.blocks])
    return BlockDiagonal(
        np.concatenate([basis[:, :count] @ parts.basis, own * units], axis=1),
        np.concatenate([parts.inverse @ rows, L / units[:, None]]),
        (*parts.blocks, *(unit * block for block in given.blocks)),
        parts.coupling,
        len(given.blocks),
    )


def _decoupled_with_slow(A, D, blocks, left: np.ndarray, basis, inverse, decoupled) -> BlockDiagonal:
    """S decoupled where the quantities change slowly: y' = A y + D z, z' = E y + (J + G) z for [E, G] = R basis.

    y - X z and z - Z (y - X z) are decoupled. Their equations are solved by iteration from the small R on, so that the slow motion has
    as many digits as R has.
    """
    count, size, sizes = len(A), len(basis), [len(block) for block in blocks]
    own = balancing_units(kept(A))
    rate = 2.0 ** np.rint(np.log2(np.abs(A * own / own[:, None]).max()))
    units = np.concatenate([own, *(np.array([1.0, rate])[:width] for width in sizes)])
    basis, inverse = basis * units, inverse / units[:, None]  # the iterations end where their largest entries are right
    whole = np.block([[A, D], [left + np.hstack([np.zeros((size - count, count)), block_matrix(blocks)])]]) * units / units[:, None]
    A, D, E, direct = whole[:count, :count], whole[:count, count:], whole[count:, :count], whole[count:, count:]
    slow = direct
    with np.errstate(over="ignore", invalid="ignore"):  # what does not converge is seen at the end
        X = _fixed_point(lambda X: solution(A, X @ (slow + E @ X) - D), D.shape)
        fast, slow = A - X @ E, slow + E @ X
        Z = _fixed_point(lambda Z: solution(fast.T, (E + slow @ Z).T).T, E.shape)
    if not (np.isfinite(X).all() and np.isfinite(Z).all() and np.abs(Z @ X).max() < 1.0):
        parts = decoupled(whole, None)
        return BlockDiagonal(basis @ parts.basis, parts.inverse @ inverse, parts.blocks, parts.coupling)
    bodies = _of_bodies(slow, sizes, lambda: decoupled(slow, None, direct))
    parts = assembled([np.arange(count), np.arange(count, size)], [decoupled(fast, None, A), bodies])
    unit_fast, unit_slow = np.eye(count), np.eye(len(slow))
    columns, rows = np.block([[unit_fast + X @ Z, X], [Z, unit_slow]]), np.block([[unit_fast, -X], [-Z, unit_slow + Z @ X]])
    bases = basis @ columns @ parts.basis, parts.inverse @ rows @ inverse
    return BlockDiagonal(*bases, parts.blocks, parts.coupling, len(bodies.blocks))


def _of_bodies(slow: np.ndarray, sizes: list[int], decoupled: Callable[[], BlockDiagonal]) -> BlockDiagonal:
    """The slow motions decoupled, with displacement and momentum of a body in one block: initially they are not opposite.

    q' = w p, p' = -G q - C p of all bodies is decoupled by the eigenvectors of G; these are real and C becomes diagonal with them, or
    the general method serves.
    """
    if min(sizes) < 2:
        return decoupled()
    G, C, rate = -slow[1::2, 0::2], -slow[1::2, 1::2], float(slow[0, 1])
    stiffness, shapes = np.linalg.eig(G) if (G != np.diag(np.diag(G))).any() else (np.diag(G), np.eye(len(G)))
    if np.iscomplexobj(stiffness) or not np.linalg.cond(shapes) <= DECOUPLING_LIMIT:
        return decoupled()
    rows = np.linalg.inv(shapes)
    modal = rows @ C @ shapes
    damping = np.diag(modal)
    if np.abs(modal - np.diag(damping)).max() > noise_of(np.abs(damping).max(initial=0.0), len(G)):
        return decoupled()
    blocks = tuple(np.array([[0.0, rate], [-k, -c]]) for k, c in zip(stiffness.tolist(), damping.tolist()))
    return BlockDiagonal(np.kron(shapes, np.eye(2)), np.kron(rows, np.eye(2)), blocks, 1.0)


def _fixed_point(following: Callable[[np.ndarray], np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """x = following(x) by iteration from zero; not finite without convergence."""
    x = np.zeros(shape)
    for _ in range(SEPARATION_STEPS):
        before, x = x, following(x)
        if np.abs(x - before).max(initial=0.0) <= 4 * EPS * np.abs(x).max(initial=0.0):
            return x
    return np.full(shape, np.inf)


def _by_clusters(A, D, J, basis, inverse) -> BlockDiagonal:
    """S decoupled where conserved and other motions are nearly coupled: by the Schur form of both, as far as possible."""
    triangle, rotation = scipy.linalg.schur(A, output="real")
    turn = block_diag(rotation, np.eye(len(J)))
    result = block_diagonalize(np.block([[triangle, rotation.T @ D], [np.zeros(D.T.shape), J]]))
    return BlockDiagonal(basis @ turn @ result.basis, result.inverse @ turn.T @ inverse, result.blocks, result.coupling)


# Motions without a restoring force where every row has stiffness: free bodies, mechanisms, bodies on dampers alone.
#
# Rows v with v K = 0 make equations v A(s) = s (v C + s v M) without stiffness: v M x' + v C x is conserved, and where v C = 0 too,
# v M x grows with it (the momentum and the centre of mass of a free body). They take the places of as many equations, after which
# the zeros at s = 0 are those of rows without stiffness, exactly. How many there are is a decision on
# rank (Businger and Golub 1965, QR with pivots), taken only where it is clear: dropped pivots are rounding errors, kept ones are
# far above.


@dataclass(frozen=True, eq=False)
class Freed:
    """Equations with some replaced by sums of all that have no stiffness.

    Attributes:
        M, C, K: coefficients, M of shape (m, m), C and K of (m + d, m + d).
        sums: the rows v, shape (k, m + d).
        places: the replaced rows, ascending, shape (k,).
        slowed: which of them have damping and are rows of ``C``, shape (k,).
        remainders: exact v K and v C, mostly zero, shape (2, k, m + d).
    """

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    sums: np.ndarray
    places: np.ndarray
    slowed: np.ndarray
    remainders: np.ndarray


def freed(M: Matrix, C: Matrix, K: Matrix, like: tuple[Freed, Matrix, Matrix] | None = None) -> Freed | None:
    """The equations with those of free motions; None where there are none, or the decision is not clear."""
    m, (M, C, K) = M.shape[0], (full(matrix).copy() for matrix in (M, C, K))
    known = _sums(M, C, K) if like is None else (like[0].sums, like[0].places, like[0].slowed, _moved_alike(like, C, K))
    if known is None:
        return None
    sums, places, slowed, remainders = known
    heavy = np.abs(sums[:, :m]).any(axis=1)
    if (heavy & (places >= m)).any():  # an equation of first order has no place for a mass
        return None
    M[places[heavy]] = sums[heavy, :m] @ M
    C[places], K[places] = np.where(slowed[:, None], remainders[1], 0.0), 0.0
    return Freed(M, C, K, *known)


def _sums(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """The last four attributes of ``Freed``; None where no motion is free, or the decision is not clear."""
    result = null_rows(K)
    if result is None or not len(result[0]):
        return None
    sums, places = result
    slowed = _slowed(sums, M, C, K)
    if len(sums) > 1 and slowed.any():  # sums of the sums that no damper acts on either, in the places of some
        within = null_rows(np.where(slowed[:, None], sums @ C, 0.0))
        if within is None:
            return None
        combined, chosen = within
        sums[chosen] = combined @ sums
        slowed = _slowed(sums, M, C, K)
    return sums, places, slowed, np.array([[exact_product(row, matrix) for row in sums] for matrix in (K, C)])


def _slowed(sums: np.ndarray, M: np.ndarray, C: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Which bodies have too much damping for the iteration; massless ones have damping only.

    The rates of the bodies, v C v^T / v M v^T in size, are compared with the slowest one of a single coordinate.
    """
    m = len(M)
    inertia, stiffness = np.abs(np.diag(M)), np.abs(np.diag(K)[:m])
    present = (inertia > 0) & (stiffness > 0)
    rate = np.sqrt((stiffness[present] / inertia[present]).min(initial=np.inf))
    damped = (np.abs(sums @ C) * np.abs(sums)).sum(axis=1)
    masses = (np.abs(sums[:, :m] @ M) * np.abs(sums[:, :m])).sum(axis=1)
    return (damped > SLOWED_RATE * rate * masses) & (masses > 0) | (masses == 0)


def _moved_alike(like: tuple[Freed, Matrix, Matrix], C: np.ndarray, K: np.ndarray) -> np.ndarray:
    """The remainders with each column perturbed by a number of units in the last place of its largest entry."""
    known, *given = like
    sizes = [(abs(moved).max(axis=0), abs(matrix).max(axis=0)) for moved, matrix in zip((K, C), given[::-1])]
    least = np.finfo(float).tiny
    ratios = [full(after).reshape(-1) / np.maximum(full(before).reshape(-1), least) for after, before in sizes]
    return known.remainders * np.array(ratios)[:, None]


def null_rows(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """A basis of v A = 0, each vector 1 at an index where the others are 0, and these indices; None for an unclear rank.

    v A may be small instead of zero, a soft support of the body.
    """
    rows, columns = equilibration(np.abs(matrix))
    Q, R, _ = scipy.linalg.qr(rows[:, None] * matrix * columns, pivoting=True)
    sizes = np.zeros(len(matrix))
    sizes[: min(R.shape)] = np.linalg.norm(R[: min(R.shape)], axis=1)
    rank = int((sizes > FREE_MOTION_GAP * sizes.max(initial=0.0)).sum())
    if rank == len(matrix):
        return np.zeros((0, rank)), np.zeros(0, dtype=int)
    space = Q[:, rank:].T
    places = np.sort(scipy.linalg.qr(space, mode="r", pivoting=True)[1][: len(space)])
    result = np.linalg.solve(space[:, places], space) * rows / rows[places][:, None]
    nearest, size = np.rint(result), np.abs(matrix)  # rounding errors may hide whole numbers, zero included
    whole = np.where(np.abs(result - nearest) <= INTEGER_DISTANCE, nearest, result)
    left, least = ((np.abs(sums @ matrix) / np.where(size.any(axis=0), size.max(axis=0), 1.0)).max() for sums in (whole, result))
    sums = whole if left <= max(2 * least, noise_of(1.0, len(matrix))) else result
    soft = FREE_MOTION_GAP * np.maximum(np.abs(sums) @ size, size.max(axis=0))
    return (sums, places) if (np.abs(sums @ matrix) <= soft).all() else None


# A directly reducible A(s) as first-order equations w' = S w + ..., and S decoupled; ``polynomial.direct_reduction`` creates them.
# M x_m'' + C (x_m', x_d') + K (x_m, x_d) = right sides, the states w = (x_m, x_m', x_d). What nothing couples is decoupled each for
# itself, and what rows without stiffness conserve separately from all else, so that zeros at s = 0 are exact.

#: Number of states decoupled at once without further structure.
FEW_STATES = 48

#: From this number of states on, a tree is decoupled by its topology: with fewer LAPACK is as fast.
MANY_STATES = 100


class NotReducible(Exception):
    """The violated condition of direct reduction or of a solution by it, as a clause, "the force contains ..."."""


@dataclass(frozen=True, eq=False)
class Reduction:
    """The equations of a directly reducible A(s): second-order ones of x_m, first-order ones of x_d, x = V (x_m, x_d) + Y g.

    Attributes:
        given: A_0, A_1, A_2.
        algebraic, second, first: which rows of A(s) are of which kind.
        chosen: which coordinates of x are x_m and x_d, in this order.
        V: shape (r, m + d); x from x_m and x_d.
        Y: shape (r, k); x from the right sides of the algebraic rows.
        M: shape (m, m), what multiplies x_m''.
        C, K: the coefficients of s and of 1 in all remaining rows, the second-order ones first, shape (m + d, m + d).
        moving: which coordinates have mass or damping.
        conserved: conserved quantities of rows without stiffness, and sums of rows; None without any.
        freed: the sums of rows without stiffness among them, where they were looked for.
        largest_condition: of the parts that were divided by.
        order: order of coordinates for modes of a wide spread; None for the given one.
        by_elements: modes by the elements of a stiffness of a wide spread, which K does not resolve; None for other equations.

    All matrices are sparse where A(s) is large, for what is built of elements mostly is; those of a small one are full.
    """

    given: list[Matrix]
    algebraic: np.ndarray
    second: np.ndarray
    first: np.ndarray
    chosen: np.ndarray
    V: Matrix
    Y: Matrix
    M: Matrix
    C: Matrix
    K: Matrix
    moving: np.ndarray
    conserved: Conserved | None
    freed: Freed | None
    largest_condition: float
    order: np.ndarray | None = None
    by_elements: SymmetricModes | BlockDiagonal | None = None

    @property
    def through(self) -> list[Matrix]:
        """Coefficients (A_0 Y, A_1 Y, A_2 Y) of g and its derivatives in the remaining rows, each of shape (m + d, k)."""
        rest = np.concatenate([self.second, self.first])
        return [matrix[rest] @ self.Y for matrix in self.given]

    @property
    def constraining(self) -> np.ndarray:
        """Which algebraic rows constrain coordinates with mass or damping, whose values at 0- have to satisfy them."""
        return np.asarray(abs(self.Y[self.moving]).sum(axis=0)) > 0

    @cached_property
    def has_exact_zeros(self) -> bool:
        """Whether entries of M and C are zero for the data taken as exact numbers, too, so that there are as many states."""
        if not len(self.algebraic):
            return True
        V, rest = full(self.V), np.concatenate([self.second, self.first])
        A0, A1, A2 = map(full, self.given)
        eliminated = A0[self.algebraic], np.zeros((len(self.algebraic), V.shape[1]))
        products = eliminated, (A2[self.second], full(self.M)), (A1[rest], full(self.C))
        return all(vanish_exactly(left, V[:, : product.shape[1]], product) for left, product in products)

    @property
    def state_count(self) -> int:
        """2 m + d."""
        return 2 * len(self.second) + len(self.first)

    @cached_property
    def output(self) -> Matrix:
        """x from the states w = (x_m, x_m', x_d), shape (r, 2 m + d), without Y g."""
        m = len(self.second)
        return matrix_of((self.V.shape[0], self.state_count), self.V, (0, 0, self.V[:, :m]), (0, 2 * m, self.V[:, m:]))

    def rates(self, right: Matrix) -> Matrix:
        """(0, x_m'', x_d') where M x_m'' + C_md x_d' and C_dd x_d' are these right sides, shape (m + d, any)."""
        m, left, rates = len(self.second), right, right[:0]
        if len(self.first):
            rates, C = accurately_solved(self.C[m:, m:], right[m:]), self.C[:m, m:]
            left = without_noise(right[:m] - C @ rates, abs(right[:m]) + abs(C) @ abs(rates))
        parts = (m, 0, accurately_solved(self.M, left)), (2 * m, 0, rates)
        return matrix_of((self.state_count, right.shape[1]), self.K, *parts)

    @cached_property
    def generator(self) -> Matrix:
        """S, shape (2 m + d, 2 m + d)."""
        m, n = len(self.second), self.state_count
        by_state = (0, 0, -self.K[:, :m]), (0, m, -self.C[:, :m]), (0, 2 * m, -self.K[:, m:])
        with np.errstate(over="ignore", invalid="ignore"):  # see ``is_finite``
            rates = self.rates(matrix_of((n - m, n), self.K, *by_state))
        return matrix_of((n, n), self.K, (0, 0, rates), (0, m, np.ones(m)))

    @cached_property
    def units(self) -> np.ndarray:
        """Units of the states in which S is balanced."""
        return balancing_units(self.generator)

    @cached_property
    def is_finite(self) -> bool:
        """Whether S is in the range of float64."""
        S = self.generator
        return bool(np.isfinite(S if isinstance(S, np.ndarray) else S.data).all())

    @cached_property
    def spread_bound(self) -> float:
        """An upper bound of ``spread`` without eigenvalues, |S| |S^-1| in balanced units; ``spread`` itself where these are known."""
        if self.is_small or self.conserved is not None:
            return self.spread
        balanced = full(self.generator) * self.units / self.units[:, None]
        try:
            inverse = np.linalg.inv(balanced)
        except np.linalg.LinAlgError:
            return np.inf
        return float(np.linalg.norm(balanced, 1) * np.linalg.norm(inverse, 1))

    @cached_property
    def spread(self) -> float:
        """The modulus ratio of the fastest and the slowest eigenvalue, without those of rows without stiffness, and of bodies."""
        known = self.is_small or self.conserved is not None
        if not known:
            moduli = np.abs(np.linalg.eigvals(full(self.generator)))
        elif self.freed is not None and self.is_symmetric:  # without exact blocks of slow motions of softly supported bodies
            sizes = [np.abs(zeros_of([block])).max() for block in self.decoupled.blocks]
            moduli = np.abs(zeros_of([self.decoupled.blocks[i] for i in np.argsort(sizes)[len(self.freed.sums) :]]))
        else:
            moduli = np.abs(zeros_of(self.decoupled.blocks[: len(self.decoupled.blocks) - self.decoupled.exact_blocks]))
        if self.conserved is not None:
            moduli = moduli[moduli > 0]
        largest = moduli.max(initial=0.0)
        return float(largest / max(moduli.min(initial=largest), EPS * largest)) if largest else 1.0

    @cached_property
    def modal_residual(self) -> float:
        """|X^-1 S X - J| / |J| of the modes X with their blocks J."""
        parts, J = self.decoupled, block_matrix(self.decoupled.blocks)
        if not len(J):
            return 0.0
        return float(np.abs(parts.inverse @ (self.generator @ parts.basis) - J).max() / (np.abs(J).max() or 1.0))

    @cached_property
    def is_well_separated(self) -> bool:
        """Whether the modes of S are accurate to a quarter of the digits, and none of them is a combination of huge states.

        An eigenvalue may be accurate and its vector close to another's: where one of two like parts drives the other.
        """
        parts, units = self.decoupled, self.units[:, None]
        if not self.state_count:
            return True
        off = np.abs(parts.inverse @ parts.basis - np.eye(self.state_count)).max()
        sizes = ((parts.basis / units) ** 2).sum(axis=0) * ((parts.inverse.T * units) ** 2).sum(axis=0)
        return bool(max(off, self.modal_residual) <= EPS**0.75 and sizes.max() <= REDUCED_AMPLIFICATION**2)

    @cached_property
    def drives_unstable_part(self) -> bool:
        """Whether a motion grows and not all states are coupled: rounding errors would excite the growth from other states."""
        zeros = self.eigenvalues
        if not (zeros.real > noise_of(np.abs(zeros).max(initial=0.0))).any():
            return False
        return scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(self.generator), connection="strong")[0] > 1

    @property
    def is_free(self) -> bool:
        """Whether springs balance a free body within rounding errors, which alone would move it."""
        return self.freed is not None and any(len(block) > 1 for block in self.conserved.blocks)

    @property
    def is_small(self) -> bool:
        """Whether the decoupling of S takes negligible time."""
        return self.state_count <= FEW_STATES

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All eigenvalues, of complex pairs the one above the real axis."""
        return zeros_of(self.decoupled.blocks)

    @cached_property
    def is_reciprocal(self) -> bool:
        """Whether M, C and K are symmetric, and no row is without stiffness."""
        return (self.conserved is None or self.freed is not None) and all(
            is_symmetric(matrix) for matrix in (self.M, self.C, self.K)
        )

    @cached_property
    def topology(self) -> SparseTopology | None:
        """Topology of a large model coupled like a chain, a tree, a ring or a ladder; None for any other."""
        if self.state_count < MANY_STATES or self.conserved is not None or not self.is_reciprocal:
            return None
        from ..linalg.tree_modes import sparse_topology

        return sparse_topology(self.M, self.C, self.K)

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether S can be decoupled by a symmetric eigenproblem: all masses, no damping or a proportional one.

        Its shapes have errors relative to their largest entries. So weakly coupled groups that decay or grow differently are left to
        the general method.
        """
        if len(self.first) or not self.is_reciprocal or self._is_softly_supported:
            return False
        damped = entry_count(self.C) > 0
        if damped and not is_symmetric(self.C @ accurately_solved(self.M, self.K)):
            return False
        if not damped and is_semidefinite(self.K):
            return True
        balanced = of_like_kind(self.generator * self.units / self.units[:, None], self.generator)
        return not is_weakly_coupled(balanced)

    @property
    def _is_softly_supported(self) -> bool:
        """Whether a body has a soft support beyond rounding errors, which affect shapes to first order."""
        if self.conserved is None or self.conserved.left is None:
            return False
        sizes = [float(abs(matrix).max()) for matrix in (self.K, self.C)]
        return any(np.abs(left).max() > ROUNDING_SUPPORT * size for left, size in zip(self.freed.remainders, sizes))

    @property
    def rounded_supports(self) -> list[tuple[int, float]]:
        """Free bodies whose support may be rounding errors: number of coordinates, and time from which motions differ."""
        if self.freed is None:
            return []
        left, m = self.freed.remainders[0], self.M.shape[0]
        units = np.abs(left) / np.maximum(EPS * full(abs(self.K).max(axis=0)).reshape(-1), np.finfo(float).tiny)
        bodies = ((units > DOUBTFUL_SUM[0]) & (units <= DOUBTFUL_SUM[1])).any(axis=1) & (units <= DOUBTFUL_SUM[1]).all(axis=1)
        result = []
        for v, rest in zip(self.freed.sums[bodies], left[bodies]):
            stiffness, mass = abs(rest @ v), abs(v[:m] @ (self.M @ v[:m]))
            if stiffness and mass:
                result.append((int(np.count_nonzero(v)), float(np.sqrt(ROUNDED_FREE * mass / stiffness))))
        return result

    @cached_property
    def is_dissipative(self) -> bool:
        """Whether no motion can grow: M, K positive definite, C positive semidefinite, all symmetric."""
        return all(is_symmetric(matrix) and is_semidefinite(matrix) for matrix in (self.M, self.C, self.K))

    @cached_property
    def decoupled(self) -> BlockDiagonal | ResidueModes:
        """S decoupled, with uncoupled parts separate: growth in one part is absent from the others."""
        if self.conserved is not None and not self.is_symmetric:
            parts = decoupled_with_conserved(full(self.generator), self.conserved, self._decoupled_rest)
            return refined(self, parts)
        if self.wide_modes is not None:
            return self.wide_modes
        groups, modes = self._groups, self._topology_modes
        parts = assembled(groups, [own or self._decoupled(k) for k, own in enumerate(modes)])
        return refined(self, parts) if isinstance(parts, BlockDiagonal) and not self.is_symmetric else parts

    @cached_property
    def wide_modes(self) -> SymmetricModes | BlockDiagonal | None:
        """Modes of symmetric M and K with rates over many orders of magnitude; None for other models, or where inefficient."""
        if self.by_elements is not None:
            return self.by_elements
        if self.is_small or len(self.first) or self.conserved is not None:
            return None
        if not (is_symmetric(self.M) and is_symmetric(self.K) and may_be_wide(self.M, self.K)):
            return None
        if len(self._groups) > 1 or self.topology is not None:
            return None
        return modes_of_wide_spread(self.M, self.C, self.K, self.order)

    @property
    def topology_failed(self) -> bool:
        """Whether the computation of modes by topology failed for a large part."""
        tried = zip(self._topology_modes, self._groups)
        return self.topology is not None and any(modes is None and len(states) >= MANY_STATES for modes, states in tried)

    @cached_property
    def _groups(self) -> list[np.ndarray]:
        """The states in uncoupled groups."""
        if isinstance(self.generator, np.ndarray):
            return coupled_rows(self.generator)
        count, which = scipy.sparse.csgraph.connected_components(self.generator, directed=False)
        return [np.flatnonzero(which == group) for group in range(count)]

    @cached_property
    def _topology_modes(self) -> list[ResidueModes | None]:
        """The modes of each part by its topology, where that is possible."""
        if self.is_symmetric or self.topology is None:
            return [None] * len(self._groups)
        m = len(self.second)
        coordinates = [np.concatenate([states[states < m], states[states >= 2 * m] - m]) for states in self._groups]
        large = [len(states) >= MANY_STATES for states in self._groups]
        return [self.topology.modes(own) if many else None for own, many in zip(coordinates, large)]

    def _decoupled(self, group: int) -> BlockDiagonal:
        """Decoupled form of a part of S: by a symmetric eigenproblem of half the size, where possible."""
        m, result, states = len(self.second), None, self._groups[group]
        if self.is_symmetric:
            own = states[states < m]
            bodies = None
            if self.freed is not None:
                there = self.freed.sums[:, own].any(axis=1)
                bodies = np.concatenate([self.freed.sums[None], self.freed.remainders])[:, there][:, :, own]
            result = symmetric_modes(*(matrices[group] for matrices in self._symmetric_parts), bodies)
        return decoupled(full(self.generator[states][:, states]), self.units[states]) if result is None else result

    @cached_property
    def _symmetric_parts(self) -> list[list[Matrix]]:
        """M, C and K of each part of S without first-order equations."""
        coordinates = [states[states < len(self.second)] for states in self._groups]
        return [diagonal_parts(matrix, coordinates) for matrix in (self.M, self.C, self.K)]

    def _decoupled_rest(self, rest: np.ndarray, states: np.ndarray | None, like: np.ndarray | None = None) -> BlockDiagonal:
        """The rest of S without the conserved quantities, decoupled group by group.

        In the units of its states, or in those that balance it, or a matrix like it: those of very small couplings would be far from those
        of all others, and a row of all momenta would bend them.
        """
        units = balancing_units(kept(rest if like is None else like)) if states is None else self.units[states]
        groups = coupled_rows(rest)
        if len(groups) == 1:
            return decoupled(rest, units)
        return assembled(groups, [decoupled(rest[at[:, None], at], units[at]) for at in groups])

    def states(self, initial: np.ndarray) -> np.ndarray:
        """The states at 0+ for values at 0- (S, q, r), shape (n, S)."""
        m, places = len(self.second), initial[:, 0, self.chosen]
        velocities = initial[:, 1, self.chosen[:m]] if m else places[:, :0]
        return np.concatenate([places[:, :m], velocities, places[:, m:]], axis=1).T

    def state(self, values: np.ndarray) -> np.ndarray:
        """w from values (q, r) of x, x', ..."""
        return self.states(values[None])[:, 0]


# Zeros of a reduced A(s) once more from its equations, where those of S = M^-1 K ... have lost what cancels in them.
#
# A slow motion of a chain has neighbours that move alike: K x is a small difference of large terms, and rounding errors of S move its
# zero by as much as that of the stiffest ones. With the vectors x and u of a zero s, found from S, one step of Newton's method on
#
# u^T P(s) x = 0,  P(s) = M s^2 + C s + K,        s - u^T P(s) x / (u^T P'(s) x)
#
# has an error of the second order in theirs (Lancaster 1961, the generalized Rayleigh quotient), if P(s) x keeps its digits: each
# row is summed as (sum of its entries) x_i + sum over j of K_ij (x_j - x_i), in which nothing large cancels.

#: A matrix of fewer rows is not sparse.
FEW = 48

#: Number of zeros refined at once.
CHUNK = 32


def refined(reduction: Reduction, parts: BlockDiagonal) -> BlockDiagonal:
    """The decoupled form with refined single eigenvalues and pairs [[a, b], [-b, a]]; clusters are unchanged."""
    blocks = list(parts.blocks)
    count = len(blocks) - parts.exact_blocks
    moduli = np.abs(zeros_of(blocks[:count]))
    if SIMILAR_EIGENVALUES * moduli.min(initial=np.inf, where=moduli > 0) >= moduli.max(initial=0.0):
        return parts
    largest, places = max(np.abs(block).max() for block in blocks), block_slices(blocks)
    correction = _correction(reduction)
    single = [i for i, block in enumerate(blocks[:count]) if _is_single(block)]
    for begin in range(0, len(single), CHUNK):
        chosen = single[begin : begin + CHUNK]
        zeros, right, left = _vectors(parts, [blocks[i] for i in chosen], [places[i] for i in chosen])
        change = correction(zeros, right, left)
        change[~(np.abs(change) <= EPS**0.5 * largest)] = 0.0  # no refinement of what was wrong
        for i, zero in zip(chosen, zeros + change):
            a, b = zero.real, zero.imag
            blocks[i] = np.array([[a, b], [-b, a]]) if len(blocks[i]) == 2 else np.array([[a]])
    return replace(parts, blocks=tuple(blocks))


def _is_single(block: np.ndarray) -> bool:
    """Whether a block is a real eigenvalue other than 0, or a pair in the form [[a, b], [-b, a]]."""
    if len(block) == 1:
        return bool(block[0, 0])
    return len(block) == 2 and block[0, 0] == block[1, 1] and block[0, 1] == -block[1, 0]


def _vectors(parts: BlockDiagonal, blocks, places) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The zeros s above the real axis or on it with S x = s x, shape (n, k), and y S = s y, shape (k, n), y x = 1."""
    begin = np.array([place.start for place in places])
    pair = np.array([len(block) == 2 for block in blocks])
    second = begin + pair
    zeros = np.array([block[0, -1] * 1j * (len(block) == 2) + block[0, 0] for block in blocks])
    right = parts.basis[:, begin] + 1j * pair * parts.basis[:, second]
    left = np.where(pair[:, None], (parts.inverse[begin] - 1j * parts.inverse[second]) / 2, parts.inverse[begin])
    return zeros, right, left


def _correction(reduction: Reduction) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
    """Newton step of eigenvalues, from them and their vectors in the states (x_m, x_m', x_d)."""
    m, C = len(reduction.second), reduction.C
    damped, stiff = _Differences(C), _Differences(reduction.K)
    first, mass = C[m:, m:].T, reduction.M.T

    def correction(zeros, right, left) -> np.ndarray:
        x = np.vstack([right[:m], right[2 * m :]])
        u = solved(mass, left[:, m : 2 * m].T)
        if first.shape[0]:
            u = np.vstack([u, solved(first, left[:, 2 * m :].T - C[:m, m:].T @ u)])
        inertia = reduction.M @ x[:m]
        residual = zeros * damped(x) + stiff(x)
        residual[:m] += zeros**2 * inertia
        slope = C @ x
        slope[:m] += 2 * zeros * inertia
        return -np.einsum("ik,ik->k", u, residual) / np.einsum("ik,ik->k", u, slope)

    return correction


class _Differences:
    """A square matrix times vectors by differences of their entries, where these are the smaller terms: units may differ."""

    def __init__(self, matrix: Matrix):
        self.matrix = matrix
        row, column, values = entries(matrix)
        beyond = row != column
        self.row, self.column = row[beyond], column[beyond]
        shape = matrix.shape[0], len(self.row)
        if shape[0] < FEW:
            self.factors: Matrix = np.zeros(shape)
            self.factors[self.row, range(shape[1])] = values[beyond]
        else:
            self.factors = scipy.sparse.csr_array((values[beyond], (self.row, np.arange(shape[1]))), shape=shape)
        self.sums = exact_row_sums(matrix)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        relative, size = x[self.column] - x[self.row], np.abs(x)
        differences = np.abs(self.sums)[:, None] * size + abs(self.factors) @ np.abs(relative)
        less = differences < abs(self.matrix) @ size
        return np.where(less, self.sums[:, None] * x + self.factors @ relative, self.matrix @ x)
