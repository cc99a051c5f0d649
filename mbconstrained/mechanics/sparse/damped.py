"""Damped modes, refined from the undamped ones: a small projected problem first, then Newton's method for each zero.

In the space of the undamped modes s^2 + s X^T C X + W^2 is a small quadratic eigenproblem. Each of its pairs (s, x) starts
Newton's method on s^2 M + s C + K (two-sided, as the matrices are symmetric; Lancaster 1961), x <- P(s)^-1 P'(s) x and
s <- s - (v^T x) / (v^T P(s)^-1 P'(s) x) with v = P'(s) x, one sparse factorization a step. Modal damping needs no step.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg

from ...errors import IllConditioned
from ...tolerances import EPS, NOISE_SAFETY
from .lanczos import CONVERGED
from .matrices import times
from .pencil import ReducedPencil
from .quadratic import QuadraticPencil
from .undamped import UndampedModes, balanced

#: After so many steps a pair that has not converged is told.
MOST_STEPS = 8

#: A value that moved by no more than this part of the gap has a vector that is right to this times its square root.
CLOSE = EPS**0.5

#: Two vectors whose cosine is this near to one are one mode found twice.
SAME = 1 - EPS**0.5


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


@dataclass
class _Pair:
    value: complex
    vector: np.ndarray
    resting: bool = False
    exact: bool = False
    converged: bool = True


def is_modal(pencil: ReducedPencil, undamped: UndampedModes) -> bool:
    """Whether C X = M X diag: damping leaves the undamped shapes alone, and does not couple them."""
    X = undamped.vectors
    if not pencil.damping.nnz:
        return True
    forces, weights = times(pencil.damping, X), times(pencil.mass, X)
    own = (X * forces).sum(axis=0)
    sizes = times(abs(pencil.damping), np.abs(X))
    left = balanced(pencil, forces - weights * own)
    return bool((np.linalg.norm(left, axis=0) <= CONVERGED * np.linalg.norm(sizes, axis=0) * len(own) ** 0.5).all())


def damped_modes(pencil: ReducedPencil, undamped: UndampedModes) -> DampedModes:
    """All zeros that the undamped modes lead to."""
    modal = is_modal(pencil, undamped)
    pairs = _modal(pencil, undamped) if modal else _projected(pencil, undamped)
    quadratic = QuadraticPencil(pencil, np.argsort(undamped.factors.lower_upper.perm_c))
    values = np.array([pair.value for pair in pairs])
    for place, pair in enumerate(pairs):
        if not (modal or pair.exact):
            _newton(quadratic, pair, _gap(values, place))
    pairs.sort(key=lambda pair: (abs(pair.value), pair.value.real))
    _tell_apart(pencil, pairs)
    evidence = np.array([_evidence(quadratic, pair) for pair in pairs]).reshape(len(pairs), 2)
    vectors = np.array([pair.vector for pair in pairs], dtype=complex).reshape(len(pairs), pencil.size).T
    converged = np.array([pair.converged for pair in pairs], dtype=bool) & (evidence[:, 0] <= evidence[:, 1])
    resting = np.array([pair.resting for pair in pairs], dtype=bool)
    values = np.array([pair.value for pair in pairs], dtype=complex)
    return DampedModes(values, vectors, resting, evidence[:, 0], evidence[:, 1], converged, modal)


def _modal(pencil: ReducedPencil, undamped: UndampedModes) -> list[_Pair]:
    """Each undamped shape with the two roots of s^2 + z s + w^2."""
    X = undamped.vectors
    rates = (X * times(pencil.damping, X)).sum(axis=0)
    sizes = (np.abs(X) * (times(abs(pencil.damping), np.abs(X)))).sum(axis=0)
    found = []
    for w2, rate, size, x in zip(undamped.values, rates, sizes, X.T):
        rate = rate if abs(rate) > NOISE_SAFETY * EPS * size else 0.0
        if not w2 and not rate:
            found.append(_Pair(0j, x, resting=True, exact=True))
            continue
        half, under = rate / 2, w2 - rate**2 / 4
        if under > 0:
            found.append(_Pair(complex(-half, under**0.5), x))
        else:
            larger = -(half + np.copysign((-under) ** 0.5, half))
            found += [_Pair(complex(root), x, exact=not root) for root in (w2 / larger, larger)]
    return found


def _projected(pencil: ReducedPencil, undamped: UndampedModes) -> list[_Pair]:
    """The pairs of the projected problem; rigid bodies without dampers stand apart, those with them have a zero at 0 exactly."""
    X, w2 = undamped.vectors, undamped.values
    forces = times(pencil.damping, X)
    sizes = np.linalg.norm(times(abs(pencil.damping), np.abs(X)), axis=0)
    free = (w2 == 0) & (np.linalg.norm(forces, axis=0) <= NOISE_SAFETY * EPS * sizes)
    found = [_Pair(0j, x, resting=True, exact=True) for x in X.T[free]]
    found += [_Pair(0j, x, exact=True) for x in X.T[(w2 == 0) & ~free]]
    at_zero = int(((w2 == 0) & ~free).sum())
    X, w2 = X[:, ~free], w2[~free]
    rates = X.T @ forces[:, ~free]
    unit = float(np.abs(w2).max(initial=0.0)) ** 0.5 or 1.0
    m = len(w2)
    state = np.block([[np.zeros((m, m)), unit * np.eye(m)], [-np.diag(w2) / unit, -rates]])
    values, turn = scipy.linalg.eig(state)
    order = np.argsort(np.abs(values), kind="stable")[at_zero:]
    order = order[values[order].imag >= 0]
    vectors = X @ turn[:m, order].real + 1j * (X @ turn[:m, order].imag)
    return found + [_Pair(complex(value), x if value.imag else x.real) for value, x in zip(values[order], vectors.T)]


def _gap(values, place) -> float:
    """How far the nearest other zero of the projected problem lies, conjugates included."""
    others = np.delete(values, place)
    distances = np.abs(np.concatenate([others, np.conj(values)]) - values[place])
    return float(distances[distances > 0].min(initial=abs(values[place])))


def _newton(quadratic: QuadraticPencil, pair: _Pair, gap: float) -> None:
    """Refine a pair in place.

    With a value wrong by a part p of the gap the vector was wrong by p^(1/2), and is by p^(3/2) after a step.
    """
    value, x, moved = pair.value, pair.vector.astype(complex), np.inf
    real = value.imag == 0
    for _ in range(MOST_STEPS):
        slope = quadratic.slope(value, x)
        try:
            image = quadratic.factors(value).solve(slope)
        except IllConditioned:  # the value is a zero to the last digit
            break
        if not np.isfinite(image).all():
            break
        step = (slope @ x) / (slope @ image)
        x = image / np.abs(image).max()
        value = complex((value - step).real) if real else value - step
        moved, last = abs(step), moved
        if moved <= CLOSE * gap or moved <= EPS**0.5 * abs(value) and moved >= last / 2:
            break
    else:
        pair.converged = False
    pair.converged &= bool(real or value.imag > 0)
    pair.value, pair.vector = value, (x.real if real else x)


def _tell_apart(pencil: ReducedPencil, pairs: list[_Pair]) -> None:
    """Of neighbours with one zero and one shape the second has not converged to its own."""
    for one, two in pairwise(pairs):
        if not (one.exact or two.exact) and abs(one.value - two.value) <= EPS**0.5 * abs(two.value):
            overlap = np.vdot(one.vector, two.vector)
            if abs(overlap) >= SAME * np.linalg.norm(one.vector) * np.linalg.norm(two.vector):
                two.converged = False


def _evidence(quadratic: QuadraticPencil, pair: _Pair) -> tuple[float, float]:
    left, size, inertia = quadratic.residual(pair.value, pair.vector)
    whole, damping = inertia or size or 1.0, abs(pair.value) * np.linalg.norm(quadratic.pencil.damping @ pair.vector)
    return left / whole, (NOISE_SAFETY * EPS * size + CONVERGED * (inertia + damping)) / whole
