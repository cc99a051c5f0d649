"""A regular pencil s E - F with regular E as s I - T, T in real Schur form, and precise matrices in block diagonal form."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from ..ground.errors import IllConditioned
from ..ground.threads import one_thread
from ..ground.tolerances import DECOUPLING_LIMIT, PRECISE_DECOUPLING, PRECISE_GUARD_DIGITS, PRECISE_LEVELS, QR_STEPS, STRETCH_LIMIT
from .arrays import block_diag, lapack
from .blocks import BlockDiagonal, assembled, coupled_rows
from .precise import (
    floats,
    inverse,
    is_precise,
    magnitude,
    midpoints,
    of_kind,
    power_of_two,
    precise,
    precise_arithmetic,
    product,
    solved,
)
from .rank import Noisy, RankDecision
from .scaling import balanced, equilibration
from .staircase import SingularPencil, split_pencil

# A precise matrix turned into block diagonal form, one block for each eigenvalue, complex pair or cluster.
# The eigenvectors are those of flint's QR algorithm, of the matrix plus a random perturbation far below every digit that counts. It
# separates multiple eigenvalues by so much that the vectors are independent (Davies 2007, "approximate diagonalization"; Banks et al.
# 2022), and each cluster is joined again through its spectral projector, in which the perturbation cancels. Where the eigenvalues span
# more orders of magnitude than the digits resolve, all is computed with more digits. A stiff chain of 40 masses, 80 states, takes 4 s,
# where Newton steps on arrays of ``Decimal`` took 17 s.

INSEPARABLE = (
    "the eigenvalues of A(s) span so many orders of magnitude, and are so strongly coupled, that they cannot be separated; "
    "look for a mass, stiffness or ratio far out of proportion, or a wrong unit"
)


def block_diagonal(matrix: np.ndarray) -> BlockDiagonal:
    """Block-diagonalize a precise square matrix."""
    if not len(matrix):
        return BlockDiagonal(matrix, matrix, (), 0.0)
    groups = coupled_rows(magnitude(matrix))
    return assembled(groups, [_of_coupled(matrix[np.ix_(at, at)]) for at in groups])


def _of_coupled(matrix: np.ndarray) -> BlockDiagonal:
    balance = power_of_two(_balancing_exponents(magnitude(matrix)))
    balanced = matrix * balance / balance[:, None]
    for digits in PRECISE_LEVELS:
        with precise_arithmetic(digits):
            spectrum = PreciseSpectrum.of(balanced, digits)
            if spectrum.is_resolved(digits):
                return _decoupled(matrix, balance, spectrum)
    raise IllConditioned(INSEPARABLE)


def _decoupled(matrix: np.ndarray, balance: np.ndarray, spectrum: PreciseSpectrum) -> BlockDiagonal:
    spaces = [_in_schur_form(space) for space in spectrum.spaces(_clusters(spectrum))]
    basis, rows = np.hstack([space.basis for space in spaces]), np.vstack([space.inverse for space in spaces])
    if magnitude(product(rows, basis) - np.eye(len(matrix))).max() > PRECISE_DECOUPLING:
        raise IllConditioned(INSEPARABLE)
    coupling = max(space.coupling for space in spaces)
    return BlockDiagonal(balance[:, None] * basis, rows / balance, tuple(space.block for space in spaces), coupling)


@dataclass(frozen=True, eq=False)
class InvariantSpace:
    """Some eigenvalues: inverse @ A @ basis = block, inverse @ basis = I.

    Attributes:
        basis, inverse: precise, shapes (n, k), (k, n).
        block: precise, later its float64 real Schur form, shape (k, k).
        coupling: norm of the projector basis @ inverse over the root of its rank, in units of this motion.
    """

    basis: np.ndarray
    inverse: np.ndarray
    block: np.ndarray
    coupling: float


@dataclass(frozen=True, eq=False)
class PreciseSpectrum:
    """The eigenvalues of a precise matrix A after its perturbation.

    Attributes:
        matrix: A.
        values: values of complex pairs the one above the real axis.
        columns: which columns of the vectors belong to each of them.
        vectors, rows: precise, rows @ vectors = I.
        projectors: those that are known by their cluster, as ``_projector`` returns them.
    """

    matrix: np.ndarray
    values: np.ndarray
    columns: list[np.ndarray]
    vectors: np.ndarray
    rows: np.ndarray
    projectors: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)

    @staticmethod
    def of(matrix: np.ndarray, digits: int) -> PreciseSpectrum:
        """Eigenvalues with their vectors by flint's QR algorithm."""
        from flint import acb_mat, arb

        n = len(matrix)
        size = arb(10) ** (PRECISE_GUARD_DIGITS - digits) * float(magnitude(matrix).max())
        perturbed = midpoints(matrix + size * precise(np.random.default_rng(n).uniform(-1, 1, (n, n))))
        eigenvalues, right = acb_mat(n, n, perturbed.ravel().tolist()).eig(right=True, algorithm="approx", maxiter=QR_STEPS * n)
        vectors = np.array(right.mid().entries(), dtype=object).reshape(n, n)
        chosen, columns, basis = [], [], []
        for at, value in enumerate(eigenvalues):
            nearest = min((float(abs(value - other)) for other in eigenvalues[:at] + eigenvalues[at + 1 :]), default=np.inf)
            column = vectors[:, at] / vectors[np.argmax([float(abs(entry)) for entry in vectors[:, at]]), at]
            if 4 * abs(float(value.imag)) < nearest:  # its conjugate is no other eigenvalue
                parts = [[entry.real for entry in column]]
            elif value.imag > 0:
                parts = [[entry.real for entry in column], [entry.imag for entry in column]]
            else:
                continue
            columns.append(len(basis) + np.arange(len(parts)))
            chosen.append(complex(value) if len(parts) == 2 else complex(float(value.real)))
            basis += parts
        if len(basis) != n:
            raise IllConditioned("the QR algorithm finds no eigenvalues of A(s); choose other units")
        vectors = midpoints(np.array(basis, dtype=object).T)
        return PreciseSpectrum(matrix, np.array(chosen), columns, vectors, inverse(vectors))

    def is_resolved(self, digits: int) -> bool:
        """Whether the perturbation is negligible relative to the slowest eigenvalue, which is not zero."""
        moduli = np.abs(self.values)
        return (
            float(np.log10(moduli.max()) - np.log10(moduli.min())) <= digits - 2 * PRECISE_GUARD_DIGITS if moduli.min() else False
        )

    def spaces(self, clusters: list[list[int]]) -> list[InvariantSpace]:
        """The invariant space of each cluster."""
        return [self.space(cluster) for cluster in clusters]

    def coupling(self, cluster: list[int]) -> float:
        """Norm of the projector of a cluster in units of its motion, over the root of its rank: 1 for orthogonal motions."""
        scaled, _ = self._projector(cluster)
        return float(np.linalg.norm(scaled)) / sum(len(self.columns[i]) for i in cluster) ** 0.5

    def _projector(self, cluster: list[int]) -> tuple[np.ndarray, np.ndarray]:
        """The projector in float64, states in units in which the motion of the cluster is balanced, and these units, powers of
        two."""
        known = self.projectors.get(tuple(cluster))
        if known:
            return known
        at = np.concatenate([self.columns[i] for i in cluster])
        projector = floats(product(self.vectors[:, at], self.rows[at]))
        motion = magnitude(product(product(self.matrix, self.vectors[:, at]), self.rows[at]))
        units = 2.0 ** _balancing_exponents(np.abs(self.values[cluster]).max() * np.abs(projector) + motion)
        self.projectors[tuple(cluster)] = scaled = projector * units / units[:, None], units
        return scaled

    def space(self, cluster: list[int]) -> InvariantSpace:
        """The range of the projector, by the singular vectors of its float64 copy."""
        at = np.concatenate([self.columns[i] for i in cluster])
        scaled, units = self._projector(cluster)
        left, _, right = np.linalg.svd(scaled)
        left, right = left[:, : len(at)] * units[:, None], right[: len(at)] / units
        basis = product(self.vectors[:, at], product(self.rows[at], left))
        rows = product(product(right, self.vectors[:, at]), self.rows[at])
        rows = product(inverse(product(rows, basis)), rows)
        return InvariantSpace(basis, rows, product(rows, self.matrix, basis), float(np.linalg.norm(scaled)) / len(at) ** 0.5)


def _clusters(spectrum: PreciseSpectrum) -> list[list[int]]:
    """Eigenvalues joined, each with the nearest, where their separation would cost more digits than the limit."""
    clusters = [[i] for i in range(len(spectrum.values))]
    couplings = [spectrum.coupling(cluster) for cluster in clusters]
    while len(clusters) > 1 and max(couplings) > DECOUPLING_LIMIT:
        worst = int(np.argmax(couplings))
        own = spectrum.values[clusters[worst]]
        distances = [_distance(own, spectrum.values[cluster]) for cluster in clusters]
        distances[worst] = np.inf
        nearest = int(np.argmin(distances))
        joined = clusters[worst] + clusters[nearest]
        for i in sorted((worst, nearest), reverse=True):
            del clusters[i], couplings[i]
        clusters.append(joined)
        couplings.append(spectrum.coupling(joined))
    return clusters


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    """Distance between the nearest eigenvalues or conjugates of two clusters."""
    return min(np.abs(np.subtract.outer(one, other)).min(), np.abs(np.subtract.outer(one, other.conj())).min())


def _in_schur_form(space: InvariantSpace) -> InvariantSpace:
    """The space in a basis of norm one in which its block is a float64 real Schur form."""
    T, turn = _triangle(space.block) or _rotation(space.block) or _float64_schur(space.block)
    basis, back = product(space.basis, turn), product(inverse(turn), space.inverse)
    size = power_of_two(np.round(np.log2(magnitude(basis).max())))
    return InvariantSpace(basis / size, back * size, T, space.coupling)


def _float64_schur(block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    T, turn = scipy.linalg.schur(floats(block), output="real")
    return T, precise(turn)


def _triangle(block: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Triangular form of one multiple real eigenvalue: equal diagonal entries, exact zeros below, and its orthogonal basis.

    A float64 Schur form would separate the eigenvalues by the root of eps of that order. None where they are separate.
    """
    n = len(block)
    identity, value = precise(np.eye(n)), sum(block[i, i] for i in range(n)) / n
    rest, basis = midpoints(block - value * identity), identity
    size = magnitude(block).max()
    for k in range(n - 1):
        inner = product(basis.T, rest, basis)[k:, k:]
        own = identity[k:, k:]
        vector = solved(product(inner.T, inner) + (PRECISE_DECOUPLING * size) ** 2 * own, np.ones((n - k, 1)))
        vector = midpoints(vector / magnitude(vector).max())
        if magnitude(product(inner, vector)).max() > PRECISE_DECOUPLING * size:
            return None
        reflection = midpoints(
            vector + (-1 if float(vector[0, 0]) < 0 else 1) * product(vector.T, vector)[0, 0].sqrt().mid() * own[:, :1]
        )
        H = identity.copy()
        H[k:, k:] = own - 2 / product(reflection.T, reflection)[0, 0] * product(reflection, reflection.T)
        basis = product(basis, H)
    T = product(basis.T, rest, basis)
    if magnitude(np.diag(T)).max() > PRECISE_DECOUPLING * size:
        return None
    return np.triu(floats(T), 1) + float(value) * np.eye(n), basis


def _rotation(block: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """A complex pair as [[a, w], [-w, a]], with a and w accurate to the last digit, and its basis.

    The block is the same however its two states are rotated. None where the eigenvalues are no pair, or nearly a double one.
    """
    couplings = np.sort(magnitude(np.array([block[0, -1], block[-1, 0]])))
    if len(block) != 2 or couplings[1] >= STRETCH_LIMIT * couplings[0]:
        return None
    a = (block[0, 0] + block[1, 1]) / 2
    square = (block[0, 0] * block[1, 1] - block[0, 1] * block[1, 0] - a * a).mid()
    if square <= 0:
        return None
    w = square.sqrt()
    first = precise(np.array([1.0, 0.0]))
    turn = midpoints(np.column_stack([first, (block[:, 0] - a * first) / -w]))
    return np.array([[float(a), float(w)], [-float(w), float(a)]]), turn


def _balancing_exponents(size: np.ndarray) -> np.ndarray:
    """Whole exponents e for which 2^-e A 2^e has rows and columns of about the same size (LAPACK's balancing)."""
    return np.round(np.log2(balanced(size)[1]))


# A regular pencil s E - F with regular E as s I - T, T in real Schur form.
# Zeros at s = 0 (rigid bodies, the drift of constraints) are split off first, by rank decisions: their part of T is
# nilpotent to the last bit, however stiff the rest is. E^-1 F is never formed from an ill-conditioned E: next
# to fast zeros it has entries so large that rounding errors of its eigenvalues swamps the slow ones. The QZ algorithm
# works on the equilibrated pencil instead, where a zero lambda suffers a relative error of about
# eps (|lambda| + 1 / |lambda|) in the pencil's own unit of time, and only then the two factors are divided.


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
    T = precise(block_diag(*result.blocks))
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
