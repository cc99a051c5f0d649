"""Damped modes, refined from the undamped ones: in a small space for all at once, then each by itself where that is not enough.

In the space of the undamped modes s^2 + s X^T C X + W^2 is a small quadratic eigenproblem. Each of its pairs (s, x) starts
Newton's method, first in that space with what damping mixes into it (``mixed``): one real factorization, already there, for all
of them. Where the residual then is more than rounding, Newton's method follows on s^2 M + s C + K itself, one complex sparse
factorization a step. Modal damping needs none of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise, repeat

import numpy as np
import scipy.linalg

from ...errors import IllConditioned
from ...tolerances import EPS, NOISE_SAFETY
from .lanczos import CONVERGED
from .matrices import combined, times
from .mixed import mixed_space, outside
from .newton import CLOSE, Pair, gap, newton
from .pencil import ReducedPencil
from .quadratic import QuadraticPencil
from .undamped import UndampedModes, balanced

#: Two vectors whose cosine is this near to one are one mode found twice.
SAME = 1 - EPS**0.5

#: Modes are corrected outside of the undamped shapes at most so often, and only as long as each time this part is left.
MOST_CORRECTIONS, GAIN = 12, 0.5

#: A vector is cleared of rounding with factors this part of a gap beside its zero, where they are not singular.
BESIDE = 1 / 64


@dataclass(frozen=True)
class DampedModes:
    """P(s_i) x_i = 0 on the free coordinates, ascending by |s|.

    Attributes:
        values: s with Im s >= 0; exactly zero for rigid bodies and offsets.
        vectors: complex, shape (r, m).
        resting: for each whether it is a rigid body without damping (two states).
        residuals, bounds: |P(s) x| / (|s|^2 |M x|) and what rounding explains of it.
        converged: for each whether Newton's method ended at its own zero.
        modal: whether damping leaves the undamped shapes alone and apart.
    """

    values: np.ndarray
    vectors: np.ndarray
    resting: np.ndarray
    residuals: np.ndarray
    bounds: np.ndarray
    converged: np.ndarray
    modal: bool


def is_modal(pencil: ReducedPencil, undamped: UndampedModes) -> bool:
    """Whether C X = M X diag: damping leaves the undamped shapes alone, and does not couple them."""
    X, sizes = undamped.vectors, abs(pencil.damping)
    for x in X.T if pencil.damping.nnz else ():
        forces = pencil.damping @ x
        left = balanced(pencil, forces - (x @ forces) * (pencil.mass @ x))
        if np.linalg.norm(left) > CONVERGED * np.linalg.norm(sizes @ np.abs(x)) * X.shape[1] ** 0.5:
            return False
    return True


def damped_modes(pencil: ReducedPencil, undamped: UndampedModes) -> DampedModes:
    """All zeros that the undamped modes lead to."""
    modal = is_modal(pencil, undamped)
    quadratic = QuadraticPencil(pencil, undamped)
    pairs = _sorted(_modal(pencil, undamped)) if modal else _coupled(quadratic)
    residuals = (pair.residual or quadratic.residual(pair.value, pair.vector) for pair in pairs)
    evidence = np.array([residual.evidence for residual in residuals]).reshape(len(pairs), 2)
    vectors = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), pencil.size).T
    converged = np.array([pair.converged for pair in pairs], dtype=bool) & (evidence[:, 0] <= evidence[:, 1])
    resting = np.array([pair.resting for pair in pairs], dtype=bool)
    values = np.array([pair.value for pair in pairs], dtype=complex)
    return DampedModes(values, vectors, resting, evidence[:, 0], evidence[:, 1], converged, modal)


def _modal(pencil: ReducedPencil, undamped: UndampedModes) -> list[Pair]:
    """Each undamped shape with the two roots of s^2 + z s + w^2."""
    X = undamped.vectors
    rates = (X * times(pencil.damping, X)).sum(axis=0)
    sizes = (np.abs(X) * (times(abs(pencil.damping), np.abs(X)))).sum(axis=0)
    found = []
    for w2, rate, size, x in zip(undamped.values, rates, sizes, X.T):
        rate = rate if abs(rate) > NOISE_SAFETY * EPS * size else 0.0
        if not w2 and not rate:
            found.append(Pair(0j, x, resting=True))
            continue
        half, under = rate / 2, w2 - rate**2 / 4
        if under > 0:
            found.append(Pair(complex(-half, under**0.5), x))
        else:
            larger = -(half + np.copysign((-under) ** 0.5, half))
            found += [Pair(complex(root), x) for root in (w2 / larger, larger)]
    return found


def _coupled(quadratic: QuadraticPencil) -> list[Pair]:
    """The pairs of the projected problem, refined; rigid bodies without dampers stand apart, with them they have a zero at 0."""
    pencil, undamped = quadratic.pencil, quadratic.undamped
    X, rests = undamped.vectors, undamped.values == 0
    forces = times(pencil.damping, X)
    free = rests.copy()
    sizes = np.linalg.norm(times(abs(pencil.damping), np.abs(X[:, rests])), axis=0)
    free[rests] = np.linalg.norm(forces[:, rests], axis=0) <= NOISE_SAFETY * EPS * sizes
    resting = [Pair(0j, x, resting=bool(alone)) for x, alone in zip(X.T[rests], free[rests])]
    moving, forces = (X, forces) if not free.any() else (X[:, ~free], forces[:, ~free])
    estimates = _projected(moving.T @ forces, undamped.values[~free], int((rests & ~free).sum()))
    gaps = [gap(np.array([pair.value for pair in estimates]), place) for place in range(len(estimates))]
    if quadratic.is_narrow:
        found = _sorted([*resting, *map(_followed, repeat(quadratic), _shown(moving, estimates), gaps)])
        if all(pair.converged for pair in found):
            return found
    space = mixed_space(pencil, undamped, ~free, forces)
    padded = [replace(pair, vector=_padded(pair.vector, len(space.mass))) for pair in estimates]
    mixed = [newton(space, pair, room) for pair, room in zip(padded, gaps)]
    pairs = _corrected(quadratic, _shown(np.hstack([space.shapes, space.mixed]), mixed))
    return _sorted(resting + [_settled(quadratic, pair, room) for pair, room in zip(pairs, gaps)])


def _settled(quadratic: QuadraticPencil, pair: Pair, room: float) -> Pair:
    """The pair, followed where that makes its residual smaller and does not lead to another zero."""
    if pair.residual.is_rounding:
        return pair
    found = _followed(quadratic, pair, room)
    own = found.converged and abs(found.value - pair.value) <= room / 2
    return found if own and found.residual.relative < pair.residual.relative else pair


def _shown(basis: np.ndarray, pairs: list[Pair]) -> list[Pair]:
    """The pairs on the free coordinates from those in a basis."""
    coordinates = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), basis.shape[1]).T
    return [replace(pair, vector=x) for pair, x in zip(pairs, combined(basis, coordinates).T)]


def _padded(x, size) -> np.ndarray:
    return np.concatenate([x, np.zeros(size - len(x))])


def _projected(C: np.ndarray, w2: np.ndarray, at_zero: int) -> list[Pair]:
    """The pairs of s^2 + s C + W^2 without so many next to 0."""
    m, unit = len(w2), float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0
    state = np.block([[np.zeros((m, m)), unit * np.eye(m)], [-np.diag(w2) / unit, -C]])
    values, turn = scipy.linalg.eig(state)
    order = np.argsort(np.abs(values), kind="stable")[at_zero:]
    order = order[values[order].imag >= 0]
    return [Pair(complex(value), x if value.imag else x.real) for value, x in zip(values[order], turn[:m, order].T)]


def _followed(quadratic: QuadraticPencil, pair: Pair, room: float) -> Pair:
    """Newton's method on all free coordinates, and its vector without what rounding of the factors left in it."""
    found = newton(quadratic, pair, room)
    try:
        beside = quadratic.factors(found.value + room * BESIDE)
        cleared = found.vector - beside.solve(quadratic.applied(found.value, found.vector))
    except IllConditioned:
        cleared = found.vector
    after = quadratic.residual(found.value, cleared)
    if after.is_rounding:
        return replace(found, vector=cleared, residual=after)
    before = quadratic.residual(found.value, found.vector)
    return replace(found, residual=before) if before.relative < after.relative else replace(found, vector=cleared, residual=after)


def _corrected(quadratic: QuadraticPencil, pairs: list[Pair]) -> list[Pair]:
    """The pairs without what their residuals cause outside of the undamped shapes."""
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
        moved = iter(outside(quadratic.pencil, quadratic.undamped, left).T)
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
        if last.imag and pair.value.imag and abs(pair.value - last) <= CLOSE**0.5 * abs(last):
            groups[-1].append(pair)
        else:
            groups.append([pair])
    return groups


def _unmixed(quadratic: QuadraticPencil, group: list[Pair]) -> list[Pair]:
    """The pairs with their residuals, solved once more on their own vectors with P(s_0 + d) = P(s_0) + d P'(s_0), if that is better."""
    given = [replace(pair, residual=quadratic.residual(pair.value, pair.vector)) for pair in group]
    middle = np.mean([pair.value for pair in group])
    X = np.array([pair.vector for pair in group]).T
    left, slopes = (np.array([image(middle, x) for x in X.T]).T for image in (quadratic.applied, quadratic.slope))
    moved, turn = scipy.linalg.eig(-X.T @ left, X.T @ slopes)
    if not np.isfinite(moved).all():
        return given
    found = []
    for value, x in zip(middle + moved, (X @ turn).T):
        value, x = (complex(value), x) if middle.imag else (complex(value.real), x.real)
        found.append(Pair(value, x, residual=quadratic.residual(value, x)))
    return min(given, found, key=_worst)


def _worst(group: list[Pair]) -> float:
    return max(pair.residual.relative for pair in group)


def _sorted(pairs: list[Pair]) -> list[Pair]:
    """Ascending; of neighbours with one zero and one shape the second has not converged to its own."""
    pairs = sorted(pairs, key=lambda pair: (abs(pair.value), pair.value.real))
    for one, two in pairwise(pairs):
        if one.value and two.value and abs(one.value - two.value) <= EPS**0.5 * abs(two.value):
            overlap = np.vdot(one.vector, two.vector)
            if abs(overlap) >= SAME * np.linalg.norm(one.vector) * np.linalg.norm(two.vector):
                two.converged = False
    return pairs
