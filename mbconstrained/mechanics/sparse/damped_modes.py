"""Damped modes, refined from undamped ones: in a common small space, then one by one where that is not sufficient.

In the space of the undamped modes s^2 + s X^T C X + W^2 is a small quadratic eigenproblem. Each of its pairs (s, x) starts
Newton's method, first in that space with the directions that damping couples to it (``mixed``): one real factorization, already there, for all
of them. Where the residual then is more than rounding, Newton's method follows on s^2 M + s C + K itself, one complex sparse
factorization a step. Modal damping needs none of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, repeat

import numpy as np
import scipy.linalg

from ...ground.errors import IllConditioned
from ...ground.tolerances import DEPENDENT_DIRECTION, EPS, NEWTON_STEP, NOISE_SAFETY, RITZ_RESIDUAL, SAME_SHAPE
from .pencil import ReducedPencil
from .quadratic_pencil import Pair, QuadraticPencil, gap, newton
from .sparse_matrices import combined, quadratic_form, times
from .undamped_modes import SOFT, UndampedModes, balanced

#: Modes are corrected outside of the undamped shapes at most so often, and only as long as each time this part is left.
MOST_CORRECTIONS, GAIN = 12, 0.5

#: A vector is cleared of rounding with factors this part of a gap from its eigenvalue, where they are not singular.
GAP_SHIFT = 1 / 64


@dataclass(frozen=True, eq=False)
class DampedModes:
    """P(s_i) x_i = 0 on the free coordinates, ascending by |s|.

    Attributes:
        values: s with Im s >= 0; exactly zero for rigid bodies and offsets.
        vectors: complex, shape (r, m).
        resting: for each whether it is a rigid body without damping (two states).
        residuals, bounds: |P(s) x| / (|s|^2 |M x|) and the part of it that rounding errors explain.
        converged: for each whether Newton's method ended at its own zero.
        modal: whether damping does not couple the undamped shapes.
        body: a softly supported body, whose zeros are close to each other; None where there is none.
        of_body: for each whether it is a mode of this body.
    """

    values: np.ndarray
    vectors: np.ndarray
    resting: np.ndarray
    residuals: np.ndarray
    bounds: np.ndarray
    converged: np.ndarray
    modal: bool
    body: SlowBody | None
    of_body: np.ndarray


@dataclass(frozen=True, eq=False)
class SlowBody:
    """A body on soft springs and dampers: x = (u + y d/dt) q with q'' + c q' + k q = u^T f, to first order of its rates.

    Its zeros are too close for modes of their own, which would cancel; K x and C x are rounding errors of the forces inside of the body.

    Attributes:
        shape: u, shape (r,), of norm 1 in M.
        response: y, the shape that the forces C u of dampers cause, shape (r,).
        stiffness, damping: k and c, in which nothing cancels.
        noise: the rounding error of the forces of dampers inside of the body, on u.
    """

    shape: np.ndarray
    response: np.ndarray
    stiffness: float
    damping: float
    noise: float

    def pairs(self) -> list[Pair]:
        """The eigenpairs of the body."""
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


def damped_modes(pencil: ReducedPencil, undamped: UndampedModes) -> DampedModes:
    """All eigenvalues that the undamped modes lead to."""
    modal, body = is_modal(pencil, undamped), None
    quadratic = QuadraticPencil(pencil, undamped)
    if modal:
        pairs = _sorted(_modal(pencil, undamped))
    else:
        pairs, body = _coupled(quadratic)
    residuals = (pair.residual or quadratic.residual(pair.value, pair.vector) for pair in pairs)
    evidence = np.array([residual.evidence for residual in residuals]).reshape(len(pairs), 2)
    vectors = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), pencil.size).T
    converged = np.array([pair.converged for pair in pairs], dtype=bool) & (evidence[:, 0] <= evidence[:, 1])
    resting = np.array([pair.resting for pair in pairs], dtype=bool)
    values = np.array([pair.value for pair in pairs], dtype=complex)
    of_body = np.array([pair.of_body for pair in pairs], dtype=bool)
    return DampedModes(values, vectors, resting, evidence[:, 0], evidence[:, 1], converged, modal, body, of_body)


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
    gaps = [gap(np.array([pair.value for pair in estimates]), place) for place in range(len(estimates))]
    if quadratic.is_narrow or undamped.complete:  # of all shapes nothing is left that damping could couple to them
        pairs = _sorted([*resting, *map(_followed, repeat(quadratic), _shown(moving, estimates), gaps)])
        if undamped.complete or all(pair.converged for pair in pairs):
            return pairs, body
    space = _mixed_space(pencil, undamped, ~free, forces)
    padded = [replace(pair, vector=_padded(pair.vector, len(space.mass))) for pair in estimates]
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
    coordinates = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), basis.shape[1]).T
    return [replace(pair, vector=x) for pair, x in zip(pairs, combined(basis, coordinates).T)]


def _padded(x, size) -> np.ndarray:
    return np.concatenate([x, np.zeros(size - len(x))])


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
        neighbour = quadratic.factors(refined.value + room * GAP_SHIFT)
        cleared = refined.vector - neighbour.solve(quadratic.applied(refined.value, refined.vector))
    except IllConditioned:
        cleared = refined.vector
    after = quadratic.residual(refined.value, cleared)
    if after.is_rounding:
        return replace(refined, vector=cleared, residual=after)
    before = quadratic.residual(refined.value, refined.vector)
    return (
        replace(refined, residual=before) if before.relative < after.relative else replace(refined, vector=cleared, residual=after)
    )


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
    middle = np.mean([pair.value for pair in group])
    X = np.array([pair.vector for pair in group]).T
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
    """The space of [X, Y] with X^T M X = I, X^T K X = diag(w^2), X^T M Y = 0 and Y^T (K - shift M) Y a multiple of I.

    Attributes:
        shapes: X, shape (r, m).
        mixed: Y, shape (r, k).
        mass, damping, stiffness: M, C and K on it, shape (m + k, m + k).
    """

    shapes: np.ndarray
    mixed: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray

    def slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """(2 s M + C) x."""
        return self.damping @ x + 2 * s * (self.mass @ x)

    def factors(self, s: complex) -> _Factors:
        """The factors of P(s)."""
        return _Factors(self.stiffness + s * (self.damping + s * self.mass))


class _Factors:
    def __init__(self, matrix):
        self.lower_upper = scipy.linalg.lu_factor(matrix, check_finite=False)
        if not np.diag(self.lower_upper[0]).all():
            raise IllConditioned("s^2 M + s C + K is singular")

    def solve(self, right: np.ndarray) -> np.ndarray:
        return scipy.linalg.lu_solve(self.lower_upper, right, check_finite=False)


def _mixed_space(pencil: ReducedPencil, undamped: UndampedModes, moving: np.ndarray, forces: np.ndarray) -> _MixedSpace:
    """The mixed space of the undamped shapes that move."""
    X, w2 = undamped.vectors[:, moving], undamped.values[moving]
    unit = float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0  # the projected matrices are of one size then
    Y = unit * _caused(pencil, undamped, forces)
    damped = times(pencil.damping, Y)
    C = np.block([[X.T @ forces, X.T @ damped], [Y.T @ forces, Y.T @ damped]])
    M, K = (Y.T @ times(matrix, Y) for matrix in (pencil.mass, pencil.stiffness))
    return _MixedSpace(X, Y, scipy.linalg.block_diag(np.eye(len(w2)), M), C, scipy.linalg.block_diag(np.diag(w2), K))


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
