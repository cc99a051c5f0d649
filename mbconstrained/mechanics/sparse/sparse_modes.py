"""The modes of lowest frequency of sparse matrices with their evidence: residuals, orthogonality, and a count of missing modes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, repeat

import numpy as np
import scipy

from ...ground.checks import counted
from ...ground.errors import IllConditioned
from ...ground.named_arrays import named_array
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import DEPENDENT_DIRECTION, EPS, NEWTON_STEP, NOISE_SAFETY, RITZ_RESIDUAL, SAME_SHAPE, TRUST_LIMIT
from ...linalg.arrays import block_diag
from ..modes import Kind, Mode, Modes, kind_of
from .pencil import ReducedPencil, Solver, bordered, combined, quadratic_form, times
from .undamped_modes import SOFT, UndampedModes, balanced, undamped_modes

# Newton's method for an eigenvalue and its vector of a symmetric quadratic pencil, sparse or small and dense.
#
# Two-sided, as the matrices are symmetric (Lancaster 1961): x <- P(s)^-1 P'(s) x and s <- s - (v^T x) / (v^T P(s)^-1 P'(s) x) with
# v = P'(s) x, one factorization of P(s) = s^2 M + s C + K a step.

#: The steps after which a pair has not converged.
MOST_STEPS = 8


@dataclass(frozen=True, eq=False)
class Residual:
    """P(s) x without the forces of the long rows, and norms."""

    forces: np.ndarray  # P(s) x, shape (r,)
    norm: float  # that of P(s) x
    terms: float  # that of the sums of the sizes of its terms
    inertia: float  # that of s^2 M x
    damping: float  # that of s C x

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
    """P(value) vector = 0 with Im value >= 0, during the iteration."""

    value: complex
    vector: np.ndarray
    resting: bool = False  # whether it is a rigid body without damping (two states)
    converged: bool = True  # whether Newton's method ended at its own zero
    residual: Residual | None = None  # residual of P(value) vector, once it is known
    of_body: bool = False  # whether it is a mode of a softly supported body


def _gap(values: np.ndarray, place: int) -> float:
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
            image = quadratic.solver(value)(slope)
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
    """P(s) = s^2 M + s C + K on the free coordinates of a pencil: one pattern, one order of elimination, no sums of sparse matrices.

    Where that order can bring all entries next to the diagonal (Cuthill and McKee 1969), as in chains and frames of beams, LAPACK's
    banded factors take a tenth of the time of general sparse ones.
    """

    pencil: ReducedPencil  # the matrices
    undamped: UndampedModes  # its undamped modes, with the order of elimination that made few entries there

    @cached_property
    def _entries_off_diagonal(self) -> scipy.sparse.csr_array:
        parts = (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)
        sizes = sum(map(abs, parts), scipy.sparse.csr_array(scipy.sparse.eye_array(self.pencil.size)))
        return scipy.sparse.csr_array(sizes + sizes.T)

    @cached_property
    def _narrow(self) -> tuple[np.ndarray, int]:
        """The order of Cuthill and McKee, and how far from the diagonal there are entries in it."""
        order = scipy.sparse.csgraph.reverse_cuthill_mckee(self._entries_off_diagonal, symmetric_mode=True)
        place, entries = np.argsort(order), self._entries_off_diagonal.tocoo()
        return order, int(np.abs(place[entries.row] - place[entries.col]).max())

    @property
    def is_narrow(self) -> bool:
        """Whether the factors are banded, fast enough for one factorization per eigenvalue."""
        return self._narrow[1] <= NARROW

    @cached_property
    def order(self) -> np.ndarray:
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

    def solver(self, s: complex) -> Solver:
        """Solutions with P(s), up to forces of the rows that were not eliminated."""
        whole, (stiffness, damping, mass) = self._pattern
        data = stiffness + s * (damping + s * mass)
        try:
            if self.is_narrow:
                solve = _banded(data, self._diagonals, self._narrow[1])
            else:
                matrix = scipy.sparse.csc_array((data, whole.indices, whole.indptr), shape=whole.shape)
                solve = scipy.sparse.linalg.splu(
                    matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
                ).solve
        except (RuntimeError, np.linalg.LinAlgError):
            raise IllConditioned(f"s^2 M + s C + K is singular at s = {s:.6g} 1/s") from None

        def ordered(right: np.ndarray) -> np.ndarray:
            solved = solve(np.asfortranarray(right[self.order]).astype(data.dtype))
            solution = np.empty_like(solved)
            solution[self.order] = solved
            return solution

        rows = self.pencil.rows
        return bordered(ordered, rows, data.dtype)[0] if rows.shape[0] else ordered

    def applied(self, s: complex, x: np.ndarray) -> np.ndarray:
        """P(s) x."""
        static, damping, inertia = self._forces(x)
        return static + s * (damping + s * inertia)

    def _forces(self, x: np.ndarray) -> list[np.ndarray]:
        return [_product(part, x) for part in (self.pencil.stiffness, self.pencil.damping, self.pencil.mass)]

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return _product(self.pencil.damping, x) + 2 * s * _product(self.pencil.mass, x)

    def residual(self, s: complex, x: np.ndarray) -> Residual:
        terms = sum(abs(s) ** power * (part @ np.abs(x)) for power, part in enumerate(self._sizes))
        static, damping, inertia = self._forces(x)
        left = balanced(self.pencil, static + s * (damping + s * inertia))
        norms = (np.linalg.norm(part) for part in (left, terms, s**2 * inertia, s * damping))
        return Residual(left, *map(float, norms))

    @cached_property
    def _sizes(self) -> tuple[scipy.sparse.csc_array, ...]:
        return abs(self.pencil.stiffness), abs(self.pencil.damping), abs(self.pencil.mass)


def _product(matrix, x: np.ndarray) -> np.ndarray:
    """A real sparse matrix times a vector that may be complex, without conversion of the matrix."""
    return matrix @ x.real + 1j * (matrix @ x.imag) if x.dtype.kind == "c" else matrix @ x


def _banded(data: np.ndarray, diagonals: tuple[np.ndarray, int], band: int) -> Solver:
    """Solutions with a banded matrix, by LAPACK's factors."""
    places, size = diagonals
    stored = np.zeros(size, dtype=data.dtype)
    stored[places] = data
    stored = stored.reshape((3 * band + 1, -1), order="F")
    factorize, solve = scipy.linalg.get_lapack_funcs(("gbtrf", "gbtrs"), (stored,))
    factors, pivots, singular = factorize(stored, band, band, overwrite_ab=True)
    if singular:
        raise np.linalg.LinAlgError
    return lambda right: solve(factors, band, band, right, pivots)[0]


# Damped modes, refined from undamped ones: in a common small space, then one by one where that is not sufficient.
#
# In the space of the undamped modes s^2 + s X^T C X + W^2 is a small quadratic eigenproblem. Each of its pairs (s, x) starts
# Newton's method, first in that space with the directions that damping couples to it (``mixed``): one real factorization, already there, for all
# of them. Where the residual then is more than rounding, Newton's method follows on s^2 M + s C + K itself, one complex sparse
# factorization a step. Modal damping needs none of it.

#: Modes are corrected outside of the undamped shapes at most so often, and only as long as each time this part is left.
MOST_CORRECTIONS, GAIN = 12, 0.5

#: A vector is cleared of rounding with factors this part of a gap from its eigenvalue, where they are not singular.
GAP_SHIFT = 1 / 64


@dataclass(frozen=True, eq=False)
class SlowBody:
    """A body on soft springs and dampers: x = (u + y d/dt) q with q'' + c q' + k q = u^T f, to first order of its rates.

    Its zeros are too close for modes of their own, which would cancel; K x and C x are rounding errors of the forces inside of the body.
    """

    shape: np.ndarray  # u, shape (r,), of norm 1 in M
    response: np.ndarray  # y, the shape that the forces C u of dampers cause, shape (r,)
    stiffness: float  # stiffness, damping: k and c, in which nothing cancels
    damping: float
    noise: float  # the rounding error of the forces of dampers inside of the body, on u

    def pairs(self) -> list[Pair]:
        values = _roots(self.stiffness, self.damping)
        return [Pair(value, self.shape + (value if value.imag else value.real) * self.response, of_body=True) for value in values]


def is_modal(pencil: ReducedPencil, undamped: UndampedModes) -> bool:
    """Whether damping is modal: C X = M X diag, without coupling of the undamped shapes."""
    X, sizes = undamped.vectors, abs(pencil.damping)
    for x in X.T if pencil.damping.nnz else ():
        forces = pencil.damping @ x
        left = balanced(pencil, forces - (x @ forces) * (pencil.mass @ x))
        if np.linalg.norm(left) > RITZ_RESIDUAL * np.linalg.norm(sizes @ np.abs(x)) * X.shape[1] ** 0.5:
            return False
    return True


def damped_modes(pencil: ReducedPencil, undamped: UndampedModes) -> tuple[list[Pair], SlowBody | None]:
    """The pairs that the undamped modes lead to, ascending by |s|, with residuals; and the softly supported body among them, if any."""
    quadratic = QuadraticPencil(pencil, undamped)
    pairs, body = (_sorted(_modal(pencil, undamped)), None) if is_modal(pencil, undamped) else _coupled(quadratic)
    for pair in pairs:
        pair.residual = pair.residual or quadratic.residual(pair.value, pair.vector)
        size, bound = pair.residual.evidence
        pair.converged = pair.converged and size <= bound
    return pairs, body


def arrays_of(pairs: list[Pair], size: int) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues, shape (m,), and vectors of this size, one a column."""
    vectors = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), size).T
    return np.array([pair.value for pair in pairs], dtype=complex), vectors


def modal_rates(pencil: ReducedPencil, undamped: UndampedModes) -> np.ndarray:
    """x^T C x of each undamped shape, in 1/s, zero where it is rounding error."""
    X, C = undamped.vectors, pencil.damping
    rates, sizes = (X * times(C, X)).sum(axis=0), (np.abs(X) * times(abs(C), np.abs(X))).sum(axis=0)
    for i in np.flatnonzero(np.abs(rates) <= EPS**0.5 * sizes):
        rates[i] = quadratic_form(C, X[:, i], pencil.rounding)
    return rates


def _modal(pencil: ReducedPencil, undamped: UndampedModes) -> list[Pair]:
    """The eigenpairs of undamped shapes under modal damping: two roots of s^2 + z s + w^2 each."""
    pairs = []
    for w2, x, rate in zip(undamped.values, undamped.vectors.T, modal_rates(pencil, undamped)):
        if not w2 and not rate:
            pairs.append(Pair(0j, x, resting=True))
            continue
        pairs += [Pair(root, x) for root in _roots(w2, rate)]
    return pairs


def _roots(w2: float, rate: float) -> list[complex]:
    """Roots of s^2 + z s + w^2, not both zero; of a complex pair the upper one."""
    half, under = rate / 2, w2 - rate**2 / 4
    if under > 0:
        return [complex(-half, under**0.5)]
    larger = -(half + np.copysign((-under) ** 0.5, half))
    return [complex(w2 / larger), complex(larger)]


def _coupled(quadratic: QuadraticPencil) -> tuple[list[Pair], SlowBody | None]:
    """The pairs of the projected problem, refined; undamped rigid bodies are separate, damped ones have an eigenvalue 0."""
    pencil, undamped = quadratic.pencil, quadratic.undamped
    X, rests = undamped.vectors, undamped.values == 0
    forces = times(pencil.damping, X)
    free = rests.copy()
    sizes = np.linalg.norm(times(abs(pencil.damping), np.abs(X[:, rests])), axis=0)
    supported = [bool(quadratic_form(pencil.damping, x, pencil.rounding)) for x in X[:, rests].T]
    free[rests] = (np.linalg.norm(forces[:, rests], axis=0) <= NOISE_SAFETY * EPS * sizes) & ~np.array(supported, dtype=bool)
    body = _slow_body(quadratic, forces, ~free)
    resting = [Pair(0j, x, resting=bool(alone)) for x, alone in zip(X.T[rests], free[rests])]
    moving, forces = (X, forces) if not free.any() else (X[:, ~free], forces[:, ~free])
    estimates = _projected(moving.T @ forces, undamped.values[~free], int((rests & ~free).sum()) if body is None else 2)
    if body is not None:
        resting = [pair for pair in resting if pair.resting] + body.pairs()
    gaps = [_gap(np.array([pair.value for pair in estimates]), place) for place in range(len(estimates))]
    if quadratic.is_narrow or undamped.complete:  # of all shapes nothing is left that damping could couple to them
        pairs = _sorted([*resting, *map(_followed, repeat(quadratic), _shown(moving, estimates), gaps)])
        if undamped.complete or all(pair.converged for pair in pairs):
            return pairs, body
    space = _mixed_space(pencil, undamped, ~free, forces)
    padded = [replace(pair, vector=np.pad(pair.vector, (0, len(space.mass) - len(pair.vector)))) for pair in estimates]
    mixed = [newton(space, pair, room) for pair, room in zip(padded, gaps)]
    pairs = _corrected(quadratic, _shown(np.hstack([space.shapes, space.mixed]), mixed))
    return _sorted(resting + [_settled(quadratic, pair, room) for pair, room in zip(pairs, gaps)]), body


def _slow_body(quadratic: QuadraticPencil, forces: np.ndarray, damped: np.ndarray) -> SlowBody | None:
    """The only softly supported body, where its rates are far below those of all other motions."""
    pencil, undamped = quadratic.pencil, quadratic.undamped
    X, w2 = undamped.vectors, undamped.values
    soft = damped & (np.abs(w2) <= SOFT * abs(undamped.shift))
    if soft.sum() != 1 or pencil.rows.shape[0] or soft.all():
        return None
    (place,), others = np.flatnonzero(soft), w2 > SOFT * abs(undamped.shift)
    x, C = X[:, place], pencil.damping
    rate = float(np.sqrt(w2[others].min(initial=np.inf)))
    c, k = quadratic_form(C, x, pencil.rounding), float(w2[place])
    force = forces[:, place]
    response = -X[:, others] @ (X[:, others].T @ force / w2[others])
    if not undamped.complete:
        response = response - _outside(pencil, undamped, force[:, None])[:, 0]
    fastest = max(abs(c), abs(k) ** 0.5)
    part = fastest * np.abs(response).max() / np.abs(x).max()  # of the shape, and of first order in the rates
    if not 0 < fastest < rate or max(part, (fastest / rate) ** 2) * part > EPS:
        return None
    mass = 1 + float(force @ response)  # of (u + s y)^T P(s) (u + s y) = k + c s + mass s^2 + ..., as K y is -C u
    x, response = x / mass**0.5, response / mass**0.5
    return SlowBody(x, response, k / mass, c / mass, EPS * float(np.linalg.norm(np.abs(x) * (abs(C) @ np.abs(x)))))


def _settled(quadratic: QuadraticPencil, pair: Pair, room: float) -> Pair:
    """The pair after Newton's method, where that makes its residual smaller and does not lead to another eigenvalue."""
    if pair.residual.is_rounding:
        return pair
    refined = _followed(quadratic, pair, room)
    own = refined.converged and abs(refined.value - pair.value) <= room / 2
    return refined if own and refined.residual.relative < pair.residual.relative else pair


def _shown(basis: np.ndarray, pairs: list[Pair]) -> list[Pair]:
    """The pairs on the free coordinates, from those in a basis."""
    return [replace(pair, vector=x) for pair, x in zip(pairs, combined(basis, arrays_of(pairs, basis.shape[1])[1]).T)]


def _projected(C: np.ndarray, w2: np.ndarray, at_zero: int) -> list[Pair]:
    """The pairs of s^2 + s C + W^2, without a given number of those nearest to 0."""
    m, unit = len(w2), float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0
    state = np.block([[np.zeros((m, m)), unit * np.eye(m)], [-np.diag(w2) / unit, -C]])
    values, turn = scipy.linalg.eig(state)
    order = np.argsort(np.abs(values), kind="stable")[at_zero:]
    order = order[values[order].imag >= 0]
    return [Pair(complex(value), x if value.imag else x.real) for value, x in zip(values[order], turn[:m, order].T)]


def _followed(quadratic: QuadraticPencil, pair: Pair, room: float) -> Pair:
    """Newton's method on all free coordinates, and its vector without the rounding errors of the factors."""
    refined = newton(quadratic, pair, room)
    try:
        neighbour = quadratic.solver(refined.value + room * GAP_SHIFT)
        cleared = refined.vector - neighbour(quadratic.applied(refined.value, refined.vector))
    except IllConditioned:
        cleared = refined.vector
    after = replace(refined, vector=cleared, residual=quadratic.residual(refined.value, cleared))
    if after.residual.is_rounding:
        return after
    before = replace(refined, residual=quadratic.residual(refined.value, refined.vector))
    return before if before.residual.relative < after.residual.relative else after


def _corrected(quadratic: QuadraticPencil, pairs: list[Pair]) -> list[Pair]:
    """The pairs without the response to their residuals outside of the undamped shapes."""
    groups = [_unmixed(quadratic, group) for group in _neighbours(pairs)]
    before = [np.inf] * len(groups)
    for _ in range(MOST_CORRECTIONS):
        worst = [_worst(group) for group in groups]
        done = [all(pair.residual.is_rounding for pair in group) for group in groups]
        open_ = [place for place in range(len(groups)) if not done[place] and worst[place] <= GAIN * before[place]]
        if not open_:
            break
        forces = (pair.residual.forces for place in open_ for pair in groups[place])
        left = np.array([part for force in forces for part in (force.real, force.imag)]).T
        moved = iter(_outside(quadratic.pencil, quadratic.undamped, left).T)
        for place in open_:
            better = [replace(pair, vector=pair.vector - (next(moved) + 1j * next(moved))) for pair in groups[place]]
            better, before[place] = _unmixed(quadratic, better), worst[place]
            if _worst(better) < worst[place]:
                groups[place] = better
    return [pair for group in groups for pair in group]


def _neighbours(pairs: list[Pair]) -> list[list[Pair]]:
    """Groups of oscillations with nearly the same zero, all others alone."""
    groups: list[list[Pair]] = []
    for pair in sorted(pairs, key=lambda pair: abs(pair.value)):
        last = groups[-1][-1].value if groups else 0j
        if last.imag and pair.value.imag and abs(pair.value - last) <= NEWTON_STEP**0.5 * abs(last):
            groups[-1].append(pair)
        else:
            groups.append([pair])
    return groups


def _unmixed(quadratic: QuadraticPencil, group: list[Pair]) -> list[Pair]:
    """The pairs with residuals, solved in their common space with P(s_0 + d) = P(s_0) + d P'(s_0) where that is better."""
    given = [replace(pair, residual=quadratic.residual(pair.value, pair.vector)) for pair in group]
    middle, X = np.mean([pair.value for pair in group]), np.array([pair.vector for pair in group]).T
    left, slopes = (np.array([image(middle, x) for x in X.T]).T for image in (quadratic.applied, quadratic.slope))
    moved, turn = scipy.linalg.eig(-X.T @ left, X.T @ slopes)
    if not np.isfinite(moved).all():
        return given
    separated = []
    for value, x in zip(middle + moved, (X @ turn).T):
        value, x = (complex(value), x) if middle.imag else (complex(value.real), x.real)
        separated.append(Pair(value, x, residual=quadratic.residual(value, x)))
    return min(given, separated, key=_worst)


def _worst(group: list[Pair]) -> float:
    return max(pair.residual.relative for pair in group)


def _sorted(pairs: list[Pair]) -> list[Pair]:
    """Pairs in ascending order; a second pair with the eigenvalue and shape of its neighbour has not converged."""
    pairs = sorted(pairs, key=lambda pair: (abs(pair.value), pair.value.real))
    for one, two in pairwise(pairs):
        if one.value and two.value and abs(one.value - two.value) <= EPS**0.5 * abs(two.value):
            overlap = np.vdot(one.vector, two.vector)
            if abs(overlap) >= SAME_SHAPE * np.linalg.norm(one.vector) * np.linalg.norm(two.vector):
                two.converged = False
    return pairs


# Undamped shapes and the directions that damping couples to them: all damped modes from the factorization of the undamped ones.
#
# P(s) = s^2 M + s C + K is projected on [X, Y]: X the undamped shapes, Y = (K - shift M)^-1 C X without its part along X, which is
# all other parts of the modes to first order in C. Each mode is then corrected outside of X with the same factors,
# x <- x - (K - shift M)^-1 P(s) x, which reduces an error along a shape of frequency w_j by about |s|^2 / w_j^2 each time (a step of
# Davidson's method, for quadratic pencils: Sleijpen, Booten, Fokkema and van der Vorst 1996).


@dataclass(frozen=True, eq=False)
class _MixedSpace:
    """The space of [X, Y] with X^T M X = I, X^T K X = diag(w^2), X^T M Y = 0 and Y^T (K - shift M) Y a multiple of I."""

    shapes: np.ndarray  # X, shape (r, m)
    mixed: np.ndarray  # Y, shape (r, k)
    mass: np.ndarray  # mass, damping, stiffness: M, C and K on it, shape (m + k, m + k)
    damping: np.ndarray
    stiffness: np.ndarray

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return self.damping @ x + 2 * s * (self.mass @ x)

    def solver(self, s: complex) -> Solver:
        factors = scipy.linalg.lu_factor(self.stiffness + s * (self.damping + s * self.mass), check_finite=False)
        if not np.diag(factors[0]).all():
            raise IllConditioned("s^2 M + s C + K is singular")
        return lambda right: scipy.linalg.lu_solve(factors, right, check_finite=False)


def _mixed_space(pencil: ReducedPencil, undamped: UndampedModes, moving: np.ndarray, forces: np.ndarray) -> _MixedSpace:
    """The mixed space of the undamped shapes that move."""
    X, w2 = undamped.vectors[:, moving], undamped.values[moving]
    unit = float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0  # the projected matrices are of one size then
    Y = unit * _caused(pencil, undamped, forces)
    damped = times(pencil.damping, Y)
    C = np.block([[X.T @ forces, X.T @ damped], [Y.T @ forces, Y.T @ damped]])
    M, K = (Y.T @ times(matrix, Y) for matrix in (pencil.mass, pencil.stiffness))
    return _MixedSpace(X, Y, block_diag(np.eye(len(w2)), M), C, block_diag(np.diag(w2), K))


def _caused(pencil: ReducedPencil, undamped: UndampedModes, forces: np.ndarray) -> np.ndarray:
    """An orthonormal basis, in the energy of K - shift M, of the response to forces outside the undamped shapes."""
    basis = _outside(pencil, undamped, forces[:, np.linalg.norm(forces, axis=0) > 0])
    for _ in range(2):  # twice, as directions are nearly dependent
        image = times(pencil.stiffness, basis) - undamped.shift * times(pencil.mass, basis)
        gram = basis.T @ image
        lengths = np.maximum(np.diag(gram), np.finfo(float).tiny) ** 0.5
        squares, turn = scipy.linalg.eigh((gram + gram.T) / (2 * lengths * lengths[:, None]))
        new = squares > DEPENDENT_DIRECTION * squares.max(initial=0.0)
        basis = basis @ (turn[:, new] / squares[new] ** 0.5 / lengths[:, None])
    return np.asfortranarray(basis)


def _outside(pencil: ReducedPencil, undamped: UndampedModes, forces: np.ndarray) -> np.ndarray:
    """(K - shift M)^-1 times real forces, with the parts of force and response along the undamped shapes removed."""
    X = undamped.vectors
    response = undamped.factors.solve(forces - times(pencil.mass, X @ (X.T @ forces)))
    return response - X @ (X.T @ times(pencil.mass, response))


def sparse_modes(pencil: ReducedPencil, count: int, damped: bool) -> Modes:
    undamped = undamped_modes(pencil, count)
    if damped:
        return _damped(pencil, undamped, count)
    X, w2 = undamped.vectors, undamped.values
    values = np.where(w2 < 0, np.abs(w2) ** 0.5, 1j * np.abs(w2) ** 0.5)
    kinds = [kind_of(value, resting=True) for value in values]
    orthogonality = float(np.abs(X.T @ times(pencil.mass, X) - np.eye(X.shape[1])).max(initial=0.0))
    notices = list(_count_notices(undamped, count))
    if (beyond := undamped.residuals > undamped.bounds).any():
        listed = ", ".join(str(place + 1) for place in np.flatnonzero(beyond)[:5])
        text = f"{counted(int(beyond.sum()), 'mode')} (number {listed}) did not converge to the accuracy of the others"
        notices.append(Notice(NoticeKind.ACCURACY, text, doubtful=True))
    notices += _rounding_notices(pencil, undamped)
    return _modes(pencil, undamped, values, X, kinds, (undamped.residuals, undamped.bounds), orthogonality, notices)


def _damped(pencil: ReducedPencil, undamped: UndampedModes, count: int) -> Modes:
    pairs, _ = damped_modes(pencil, undamped)
    chosen = [pair for pair in pairs if pair.converged][:count]
    values, X = arrays_of(chosen, pencil.size)
    inertia, damping = X.T @ times(pencil.mass, X), X.T @ times(pencil.damping, X)
    own = 2 * values * np.diag(inertia) + np.diag(damping)
    target = np.where(values.imag != 0, 2j * values.imag, np.where(np.abs(own) > 0, own, 1.0))
    unit = (target / np.where(own != 0, own, target)) ** 0.5
    X *= unit
    coupling = _coupling(values, (values[:, None] + values) * inertia + damping, unit)
    kinds = [kind_of(value, pair.resting, NOISE_SAFETY * EPS) for value, pair in zip(values, chosen)]
    notices = [*_count_notices(undamped, count), *_rounding_notices(pencil, undamped)]
    if lost := sum(not pair.converged for pair in pairs):
        text = f"{counted(lost, 'eigenvalue')} of strongly damped motion did not converge from the undamped modes and are left out"
        notices.append(Notice(NoticeKind.OMITTED, text, doubtful=True))
    evidence = np.array([pair.residual.evidence for pair in chosen if pair.residual]).reshape(-1, 2).T
    return _modes(pencil, undamped, values, X, kinds, evidence, coupling, notices)


def _modes(pencil, undamped: UndampedModes, values, X, kinds: list[Kind], evidence, orthogonality, notices) -> Modes:
    """The modes on all coordinates from their vectors X on the free ones."""
    vectors = times(pencil.basis, X)
    modes = (
        Mode(kind, value, 1, named_array(shape[:, None], pencil.names))
        for kind, value, shape in zip(kinds, values.astype(complex).tolist(), vectors.T)
    )
    return Modes(
        tuple(modes),
        pencil.names,
        vectors=vectors,
        _residuals=evidence[0],
        bounds=evidence[1],
        orthogonality=orthogonality,
        counted_below=None if undamped.counted is None else max(undamped.below, 0.0) ** 0.5,
        none_missed=undamped.counted is not None and undamped.counted == undamped.computed_below,
        complete=undamped.complete,
        notices=(*pencil.notices, *notices),
    )


def _coupling(values, form, unit) -> float:
    """The largest entry off the diagonal of (s_i + s_j) x_i^T M x_j + x_i^T C x_j, relative to |s_i + s_j|."""
    sizes = np.abs(values[:, None] + values)
    relative = np.abs(form * unit * unit[:, None]) / np.where(sizes > 0, sizes, 1.0)
    np.fill_diagonal(relative, 0.0)
    return float(relative.max(initial=0.0))


def _count_notices(undamped: UndampedModes, count: int) -> Iterator[Notice]:
    size = len(undamped.values)
    if undamped.complete and size < count:
        yield Notice(
            NoticeKind.OMITTED, f"the system has {counted(size, 'finite undamped mode')}, fewer than the {count} requested"
        )
    if undamped.counted is None:
        yield Notice(NoticeKind.ACCURACY, "whether modes of low frequency are missing could not be counted", doubtful=True)
    elif undamped.counted != undamped.computed_below:
        limit = max(undamped.below, 0.0) ** 0.5
        text = f"{undamped.counted} modes lie below {limit:.6g} rad/s, of which {undamped.computed_below} were computed"
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)
    elif undamped.computed_below < size:
        text = (
            f"the last {counted(size - undamped.computed_below, 'mode')} belong to a larger group of equal frequencies; "
            "increase count to have all of it"
        )
        yield Notice(NoticeKind.OMITTED, text)
    if growing := int((undamped.values < 0).sum()):
        yield Notice(NoticeKind.UNSTABLE, f"{counted(growing, 'growing mode')}: the stiffness is negative there")


def _rounding_notices(pencil: ReducedPencil, undamped: UndampedModes) -> Iterator[Notice]:
    """Frequencies that rounding errors of the entries of K may change noticeably."""
    X = np.abs(undamped.vectors)
    terms = EPS * (X * times(abs(pencil.stiffness), X)).sum(axis=0)
    uncertain = (undamped.values != 0) & (terms > TRUST_LIMIT * np.abs(undamped.values))
    if uncertain.any():
        affected = counted(int(uncertain.sum()), "frequency", "frequencies")
        text = (
            f"{affected} may be rounding error of the stiffness matrix, in whose entries stiff and soft parts are added; "
            "replace stiff links by constraints"
        )
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)
