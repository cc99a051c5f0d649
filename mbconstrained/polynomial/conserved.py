"""Zeros at s = 0 that follow exactly from A(s): rows without stiffness.

A row i of M x'' + C x' + K x with K_i = 0 conserves p_i = M_i x' + C_i x, and one with C_i = 0 too lets q_i = M_i x grow with it,
q_i' = p_i: a free mass, the drift of a constraint at velocity or acceleration level. Of the states w these numbers are z = L w
with L S = J L, where J has blocks [0] and [[0, 1], [0, 0]] and nothing is rounded. They take the place of as many states, and the
others are decoupled from them by a linear equation: S has no more zeros at 0 where the matrix of the rows' lowest coefficients,
each of its power of s, is regular (``lowest``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..ground.tolerances import DECOUPLING_LIMIT, EPS, FREE_MOTION_GAP, INTEGER_DISTANCE, SEPARATION_STEPS, SLOWED_RATE, noise_of
from ..linalg.accurate_products import exact_product
from ..linalg.arrays import Matrix, filled_rows, full, kept, others
from ..linalg.blocks import BlockDiagonal, assembled, block_diagonalize, block_matrix
from ..linalg.division import solution
from ..linalg.scaling import balancing_units, equilibration


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
    """The lowest nonzero coefficient of each row, and its power of s, for M of shape (m, m), C and K of (m + d, m + d).

    >>> lowest(np.array([[5.0]]), np.zeros((2, 2)), np.array([[0.0, 0.0], [0.0, 3.0]]))[0].tolist()
    [[5.0, 0.0], [0.0, 3.0]]
    """
    stiff = filled_rows(K)
    if stiff.all():
        return K, np.zeros(len(stiff), dtype=int)
    powers = ~stiff * (2 - filled_rows(C))
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
        X = _separating(A, D, J)
        rows, own = rows - X @ L, own + basis[:, :count] @ X
    if not (np.abs(own) * np.abs(L.T)).sum(axis=0).max() <= DECOUPLING_LIMIT:
        return _by_clusters(A, D, J, basis, inverse)
    return _with_conserved(decoupled(A, rest), basis[:, :count], rows, own, given)


def _decoupled_with_slow(A, D, blocks, left: np.ndarray, basis, inverse, decoupled) -> BlockDiagonal:
    """S decoupled where the quantities change slowly: y' = A y + D z, z' = E y + (J + G) z for [E, G] = R basis.

    y - X z and z - Z (y - X z) are decoupled. Their equations are solved by iteration from the small R on, so that the slow motion has
    as many digits as R has.
    """
    count, size, sizes = len(A), len(basis), [len(block) for block in blocks]
    own = balancing_units(kept(A))
    rate = _power_of_two(np.abs(A * own / own[:, None]).max())
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


def _power_of_two(size: float) -> float:
    """The nearest power of two."""
    return float(2.0 ** np.rint(np.log2(size)))


def _fixed_point(following: Callable[[np.ndarray], np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """x = following(x) by iteration from zero; not finite without convergence."""
    x = np.zeros(shape)
    for _ in range(SEPARATION_STEPS):
        before, x = x, following(x)
        if np.abs(x - before).max(initial=0.0) <= 4 * EPS * np.abs(x).max(initial=0.0):
            return x
    return np.full(shape, np.inf)


def _separating(A: np.ndarray, D: np.ndarray, J: np.ndarray) -> np.ndarray:
    """X with A X - X J = -D, for J J = 0."""
    X = solution(A, -D)
    return X + solution(A, X @ J)


def _with_conserved(parts: BlockDiagonal, basis, inverse, own, given: Conserved) -> BlockDiagonal:
    """The conserved quantities after the others; growth with a momentum is scaled by the others' unit of time."""
    rate = max((float(np.abs(block).max()) for block in parts.blocks), default=0.0)
    unit = _power_of_two(rate) if rate else 1.0
    units = np.concatenate([[1.0, unit][: len(block)] for block in given.blocks])
    return BlockDiagonal(
        np.concatenate([basis @ parts.basis, own * units], axis=1),
        np.concatenate([parts.inverse @ inverse, given.rows / units[:, None]]),
        (*parts.blocks, *(unit * block for block in given.blocks)),
        parts.coupling,
        len(given.blocks),
    )


def _by_clusters(A, D, J, basis, inverse) -> BlockDiagonal:
    """S decoupled where conserved and other motions are nearly coupled: by the Schur form of both, as far as possible."""
    triangle, rotation = scipy.linalg.schur(A, output="real")
    turn = scipy.linalg.block_diag(rotation, np.eye(len(J)))
    result = block_diagonalize(np.block([[triangle, rotation.T @ D], [np.zeros(D.T.shape), J]]))
    return BlockDiagonal(basis @ turn @ result.basis, result.inverse @ turn.T @ inverse, result.blocks, result.coupling)


# Motions without a restoring force where every row has stiffness: free bodies, mechanisms, bodies on dampers alone.
#
# Rows v with v K = 0 make equations v A(s) = s (v C + s v M) without stiffness: v M x' + v C x is conserved, and where v C = 0 too,
# v M x grows with it (the momentum and the centre of mass of a free body). They take the places of as many equations, after which
# the zeros at s = 0 are those of rows without stiffness (``polynomial.conserved``), exactly. How many there are is a decision on
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
    """The equations with those of free motions; None where there are none, or the decision is not clear.

    >>> freed(np.eye(2), np.zeros((2, 2)), np.array([[1.0, -1.0], [-1.0, 1.0]])).sums
    array([[1., 1.]])
    """
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

    >>> (v,), _ = null_rows(np.array([[2.0, -2.0], [-1.0, 1.0]]))
    >>> bool(np.isclose(v[1], 2 * v[0]))
    True
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
    whole, size = _whole(result), np.abs(matrix)
    left, least = ((np.abs(sums @ matrix) / np.where(size.any(axis=0), size.max(axis=0), 1.0)).max() for sums in (whole, result))
    sums = whole if left <= max(2 * least, noise_of(1.0, len(matrix))) else result
    soft = FREE_MOTION_GAP * np.maximum(np.abs(sums) @ size, size.max(axis=0))
    return (sums, places) if (np.abs(sums @ matrix) <= soft).all() else None


def _whole(result: np.ndarray) -> np.ndarray:
    """Entries near whole numbers rounded to them, zero included, since rounding errors may hide these."""
    whole = np.rint(result)
    return np.where(np.abs(result - whole) <= INTEGER_DISTANCE, whole, result)
