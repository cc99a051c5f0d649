"""Existence of a mechanical normal form: the two conditions, as distances to systems that violate them.

With Q_2 an orthonormal basis of the complement of the inputs, and W_1 one of the states F^-1 B that they act on,

    rank [B, A B] = 2 p                   means that  K = Q_2^T A W_1  has full rank p, and
    rank [A - lambda I, B] >= n/2 + p     that  P(lambda) = Q_2^T (A - lambda F)  has at least the rank n/2 for every real lambda

(F = I without a descriptor; with one the conditions are those of F^-1 A and F^-1 B, but neither is formed).

(The printed theorem uses the rank of a matrix G that no similarity preserves instead of the second, and is wrong in both
directions.) So the singular values sigma_p(K) and min sigma_(n/2)(P(lambda)) are the distances, in the 2-norm of A, to the
nearest A that fails. They are compared with the noise of A. No eigenvalue is judged by its multiplicity: those of a defective
one are scattered by far more than the noise, which the singular values are not.

Where P(lambda) falls below rank n/2 the first n/2 of its elementary divisors there are linear: with at least
n/2 - p + 1 Jordan blocks in an uncontrollable part of at most n - 2 p states, enough of the blocks have size one. A random
compression of the pencil P to n/2 rows and columns has this lambda as a semisimple eigenvalue, therefore, known to rounding.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from ...ground.checks import counted
from ...ground.errors import NoNormalForm
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CLEAR_DROPPED, CLEAR_KEPT, COUNTED_DISTANCE, EPS, FAR_FROM_EIGENVALUE, NEARLY_REAL, NOISE_SAFETY
from .descriptor import ScaledPencil

#: Random compressions of the pencil; each finds what there is with probability one.
COMPRESSIONS = 2

#: Steps of refinement of an eigenvalue; they converge at least quadratically.
REFINEMENTS = 6


@dataclass(frozen=True)
class Margin:
    """Margin of one condition: the distance to violating it.

    Attributes:
        rank, needed: the rank, and the one needed, of [B, A B] or [A - lambda I, B].
        distance: distance in the scaled units; infinite where the condition cannot fail.
        bound: the bound below which it counts as zero: the noise times its safety.
        size: |A| in the same units.
        eigenvalue: the lambda of the smallest distance, in 1/s.
    """

    rank: int
    needed: int
    distance: float
    bound: float
    size: float
    eigenvalue: float | None = None

    @property
    def ratio(self) -> float:
        """The distance in units of its bound."""
        return self.distance / self.bound if self.distance else 0.0

    @property
    def relative(self) -> float:
        """The distance relative to A."""
        return self.distance / self.size if self.size else 0.0

    @property
    def holds(self) -> bool:
        """Whether the condition is satisfied."""
        return self.rank == self.needed

    @property
    def clear(self) -> bool:
        """Whether the decision is clear."""
        return (
            self.ratio >= CLEAR_KEPT
            if self.holds
            else self.ratio <= CLEAR_DROPPED and self.bound <= FAR_FROM_EIGENVALUE * self.size
        )


@dataclass(frozen=True)
class NormalFormExistence:
    """Margins of both conditions of a pair that has a normal form.

    Attributes:
        inputs: the margin of rank [B, A B] = 2 p.
        eigenvalues: the margin of rank [A - lambda I, B] >= n/2 + p over all real lambda.
        rests_on: number of weak entries of A on which the existence depends.
    """

    inputs: Margin
    eigenvalues: Margin
    rests_on: int = 0

    @property
    def notices(self) -> tuple[Notice, ...]:
        """A warning for each condition with a narrow margin, and for decisive entries that may be rounding errors."""
        if self.rests_on:
            text = (
                f"the normal form rests on {counted(self.rests_on, 'entry', 'entries')} of A that are very small relative to others of "
                "their row and their column; if they are rounding errors of zeros there is none"
            )
            return (*replace(self, rests_on=0).notices, Notice(NoticeKind.RANK, text, doubtful=True))
        named = (
            ("rank [B, A B] = 2 p", self.inputs),
            (f"rank [A - lambda I, B] >= n/2 + p{_at(self.eigenvalues)}", self.eigenvalues),
        )
        return tuple(
            Notice(
                NoticeKind.RANK,
                f"{name} holds by a narrow margin: a change of A by {margin.relative:.1e} of its size would break it, and "
                f"{margin.bound / margin.size:.1e} of it may be rounding; the normal form may be an artefact of rounding",
                doubtful=True,
            )
            for name, margin in named
            if not margin.clear
        )


def existence(pair: ScaledPencil) -> NormalFormExistence:
    """Margins of both conditions."""
    try:
        margins = _margins(pair)
    except NoNormalForm:
        if pair.explicit:
            raise
        margins = _margins(pair.solved)
    if not pair.weak.any():
        return margins
    try:
        _margins(pair.without_weak)
    except NoNormalForm:
        return replace(margins, rests_on=int(pair.weak.sum()))
    return margins


def _margins(pair: ScaledPencil) -> NormalFormExistence:
    n, p = pair.B.shape
    Q, condition = _basis(pair.B)
    W = Q if pair.explicit else pair.input_space
    size = float(np.linalg.norm(pair.A))
    noise = size * float(np.hypot(pair.known, max(condition * pair.known, pair.input_space_noise) if p else 0.0))
    inputs = _margin(2 * p, np.linalg.svd(Q[:, p:].T @ pair.A @ W[:, :p], compute_uv=False), p, noise, size)
    if not inputs.holds:
        raise _no_inputs(inputs, pair)
    noise = size * pair.known * float(np.hypot(1.0, condition if p else 0.0))
    eigenvalues = Margin(n // 2 + p, n // 2 + p, np.inf, NOISE_SAFETY * noise, size)
    if 2 * p < n:
        rate, values = min(_values_at_candidates(pair, Q[:, p:]), key=lambda candidate: candidate[1][n // 2 - 1])
        of_F = 0.0 if pair.explicit else pair.known * abs(rate) * float(np.linalg.norm(pair.F))
        eigenvalues = _margin(n // 2 + p, values, n // 2, np.hypot(noise, of_F), size, rate * pair.rate)
    if not eigenvalues.holds:
        raise _no_eigenvalues(eigenvalues, pair)
    return NormalFormExistence(inputs, eigenvalues)


def _basis(matrix) -> tuple[np.ndarray, float]:
    """An orthogonal matrix whose first p columns span those of the matrix, and its condition with columns of length one."""
    n, p = matrix.shape
    if not p:
        return np.eye(n), 1.0
    U, values, _ = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0))
    return U, float(values[0] / values[-1])


def _margin(needed: int, values, count: int, noise, size, eigenvalue=None) -> Margin:
    """The margin of the count-th singular value; the rank is ``needed`` less the number of negligible ones."""
    bound = NOISE_SAFETY * noise
    missing = int((values[:count] <= COUNTED_DISTANCE * bound).sum())
    distance = float(values[count - 1]) if count else np.inf
    return Margin(needed - missing, needed, distance, float(bound), size, eigenvalue)


def _values_at_candidates(pair: ScaledPencil, complement) -> Iterator[tuple[float, np.ndarray]]:
    """(lambda, singular values of P(lambda)) at the real lambda where the rank may fall, or nearly does."""
    constant, linear = complement.T @ pair.A, complement.T @ pair.F
    for value in _candidates(constant, linear):
        yield _refined(value, constant, linear)


def _candidates(constant, linear) -> list[float]:
    """Real parts of the nearly real eigenvalues of random compressions of the pencil; of the one nearest the axis if none is."""
    rows, n = constant.shape
    size, random = np.linalg.norm(constant), np.random.default_rng(n)
    candidates = []
    for _ in range(COMPRESSIONS):
        left = np.linalg.qr(random.standard_normal((rows, n // 2)))[0].T
        right = np.linalg.qr(random.standard_normal((n, n // 2)))[0]
        values = scipy.linalg.eigvals(left @ constant @ right, left @ linear @ right)
        values = values[np.isfinite(values) & (values.imag >= 0)]
        values = values[np.argsort(values.imag, kind="stable")]
        near = values.imag <= NEARLY_REAL * np.maximum(size, np.abs(values))
        near[:1] = True
        candidates += values[near].real.tolist()
    return candidates


def _refined(value: float, constant, linear) -> tuple[float, np.ndarray]:
    """lambda improved by Rayleigh quotients with the rows that P(lambda) nearly annihilates, and the singular values there."""
    count = constant.shape[1] // 2
    values = scipy.linalg.svdvals(constant - value * linear)
    best = value, values
    if values[count - 1] > FAR_FROM_EIGENVALUE * values[0]:
        return best
    for _ in range(REFINEMENTS):
        left = _left_vectors(constant - value * linear)[:, count - 1 :].T
        along = left @ linear
        value = float(np.vdot(along, left @ constant) / np.vdot(along, along))
        values = scipy.linalg.svdvals(constant - value * linear)
        if values[count - 1] >= best[1][count - 1]:
            break
        best = value, values
    return best


def _left_vectors(matrix) -> np.ndarray:
    try:
        return scipy.linalg.svd(matrix, full_matrices=False)[0]
    except np.linalg.LinAlgError:  # the fast algorithm may not converge for many equal singular values, the slow one does
        return scipy.linalg.svd(matrix, full_matrices=False, lapack_driver="gesvd")[0]


def _at(margin: Margin) -> str:
    return "" if margin.eigenvalue is None else f" at lambda = {margin.eigenvalue:.6g}"


def _no_inputs(margin: Margin, pair: ScaledPencil) -> NoNormalForm:
    text = (
        f" = {margin.rank}, but 2 p = {margin.needed} is needed: some combination of the inputs acts on no velocity of its own, but on "
        "displacements at once, or on a velocity of another input"
    )
    return _no_form("rank [B, A B]", text, margin, pair)


def _no_eigenvalues(margin: Margin, pair: ScaledPencil) -> NoNormalForm:
    text = (
        f" = {margin.rank} at the eigenvalue lambda = {margin.eigenvalue:.6g}, but at least n/2 + p = {margin.needed} is needed: too "
        "many motions exp(lambda t) that no input reaches, more than one for each coordinate that is left"
    )
    return _no_form("rank [A - lambda I, B]", text, margin, pair)


def _no_form(name: str, text: str, margin: Margin, pair: ScaledPencil) -> NoNormalForm:
    return NoNormalForm(
        f"no mechanical normal form: {name}{text}. {_nearness(margin, pair)}",
        condition=name,
        rank=margin.rank,
        needed=margin.needed,
        eigenvalue=margin.eigenvalue,
        margin=margin.relative,
        doubtful=not margin.clear,
    )


def _nearness(margin: Margin, pair: ScaledPencil) -> str:
    known = margin.bound / margin.size if margin.size else EPS
    text = f"The distance to it is {margin.relative:.1e} of the size of A"
    text += f", known to {known:.1e}: " if margin.clear else f" and {known:.1e} of it may be rounding, so that it is in doubt: "
    if pair.dropped:
        counted_entries = "1 entry was" if pair.dropped == 1 else f"{pair.dropped} entries were"
        text += f"{counted_entries} taken as rounding error relative to others of the same row and column; "
    return text + "add states or inputs that are missing, or work with the first-order system as it is"
