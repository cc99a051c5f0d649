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

from dataclasses import dataclass, replace

import numpy as np
import scipy

from ..ground.checks import counted, real_array
from ..ground.errors import InputError, NoNormalForm
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import (
    CLEAR_DROPPED,
    CLEAR_KEPT,
    COUNTED_DISTANCE,
    EPS,
    FAR_FROM_EIGENVALUE,
    NEARLY_REAL,
    NOISE_SAFETY,
    ROUNDED_COUPLING,
)
from ..linalg.rank import Noisy, RankDecision, compress_rows, null_columns
from ..linalg.scaling import joint_scaling

# The matrices of a state-space system, checked.


@dataclass(frozen=True, eq=False)
class StateSpaceData:
    """F x' = A x + B u, y = C x + D u as given."""

    A: np.ndarray  # A, B: shape (n, n) and (n, p)
    B: np.ndarray
    C: np.ndarray | None = None  # C, D: shape (m, n) and (m, p); None where no outputs are given
    D: np.ndarray | None = None
    F: np.ndarray | None = None  # shape (n, n); None for the identity
    rank: RankDecision | None = None  # of F; None for the identity

    @property
    def has_infinite_part(self) -> bool:
        """True where F is singular."""
        return self.rank is not None and self.rank.rank < len(self.A)


def state_space_data(A, B, C, D, descriptor) -> StateSpaceData:
    A = real_array(A, "A", shape=(None, None))
    n = len(A)
    if n != A.shape[1]:
        raise InputError(f"A: expected a square matrix, found {n} x {A.shape[1]}")
    F = None if descriptor is None or not n else real_array(descriptor, "descriptor", shape=(n, n))
    rank = None if F is None else compress_rows(Noisy.rounded(F)).decision
    singular = rank is not None and rank.rank < n
    if not n or (n % 2 and not singular):
        states = f"found {counted(n, 'state')}" if n else "found no states"
        raise InputError(
            f"A: {states}; a mechanical system has an even number of them, a displacement and a velocity for each coordinate"
        )
    B = _inputs(B, n, singular)
    C, D = _outputs(C, D, n, B.shape[1])
    return StateSpaceData(A, B, C, D, F, rank)


def _inputs(B, n: int, singular: bool) -> np.ndarray:
    B = real_array(np.zeros((n, 0)) if B is None else B, "B")
    B = B[:, None] if B.ndim == 1 else B
    if B.ndim != 2 or len(B) != n:
        raise InputError(f"B: expected shape {n} x p, one row for each of the {n} states, found {' x '.join(map(str, B.shape))}")
    if B.shape[1] > (n if singular else n // 2):
        most = (
            f"at most {n} of them can be independent"  # those that act on the infinite part alone are no forces on coordinates
            if singular
            else f"a mechanical system of {counted(n // 2, 'coordinate')} takes at most {counted(n // 2, 'independent force')}"
        )
        raise InputError(
            f"B: found {counted(B.shape[1], 'input')} for {counted(n, 'state')}; {most}: leave inputs out, or combine them"
        )
    columns = null_columns(Noisy.rounded(B))
    if columns.decision.rank < B.shape[1]:
        *others, last = [str(place + 1) for place in np.flatnonzero(columns.null.data[0])]
        text = f"columns {', '.join(others)} and {last} depend on each other" if others else f"column {last} is zero"
        raise InputError(f"B: {text}; the inputs must be independent: leave one out, or combine them")
    return B


def _outputs(C, D, n, p):
    if C is None:
        if D is not None:
            raise InputError("D: found a feedthrough without outputs; give C as well")
        return None, None
    C = np.atleast_2d(real_array(C, "C"))
    if C.ndim != 2 or C.shape[1] != n:
        raise InputError(f"C: expected shape m x {n}, one column for each of the {n} states, found {' x '.join(map(str, C.shape))}")
    shape = (len(C), p)
    return C, np.zeros(shape) if D is None else real_array(D, "D", shape=shape)


# The pencil s F - A with its inputs B scaled: equations, states, inputs and time by powers of two. A change of units changes the
# data by such factors, so they follow from a rule that is invariant under it. Without
# a descriptor matrix F, A is transformed by similarity: the least-squares fit of log2|a_ij| - d_i + d_j - t and
# log2|b_ij| - d_i + c_j to zero over all nonzero entries. With one, equations and states are scaled separately, jointly for A and F.


@dataclass(frozen=True, eq=False)
class ScaledPencil:
    """A_s = e A d, F_s = rate e F d, B_s = e B c: with x = d x_s, u = c u_s and t = t_s / rate the same equations."""

    A: np.ndarray  # A, F, B: the scaled matrices, entries known to a unit in the last place; an identity F is known exactly
    F: np.ndarray
    B: np.ndarray
    # F_s^-1 B_s, shape (n, p), and ``input_space``, a basis W_1 of the same space, orthonormal where there is an F: that space, the
    # states that the inputs act on, is known far better than F^-1 where F is ill-conditioned
    through: np.ndarray
    input_space: np.ndarray
    input_space_noise: float  # its uncertainty, as an angle
    equation: np.ndarray  # equation, state, input, rate: e and d, shape (n,), c, shape (p,), and rate: powers of two
    state: np.ndarray
    input: np.ndarray
    rate: float
    explicit: bool  # True where F is the identity
    dropped: int  # the number of entries of A and B that count as rounding errors and are zero here
    # shape (n, n), True for small entries of A on no cycle: units could make them of any size, so that they cannot be distinguished
    # from rounding errors
    weak: np.ndarray
    known: float = EPS  # uncertainty of A and F, relative to their size
    part: str = ""  # the part of a larger system whose pencil this is, for texts

    @property
    def solved(self) -> ScaledPencil:
        """The pencil with its equations solved for F x': more accurate where F makes equations nearly dependent."""
        inverse = np.linalg.inv(self.F)
        A, F, B = (inverse @ matrix for matrix in (self.A, self.F, self.B))
        loss = [
            np.linalg.norm(np.abs(inverse) @ np.abs(one)) / (np.linalg.norm(other) or 1.0)
            for one, other in ((self.A, A), (self.F, F))
        ]
        known = EPS * float(max(1.0, *loss))
        B = B / np.linalg.norm(B, axis=0)
        input_space, noise = _input_space(F, B, known)
        return replace(self, A=A, F=F, B=B, input_space=input_space, input_space_noise=noise, known=known)


def scaled_pencil(data: StateSpaceData) -> ScaledPencil:
    """Choose the units; without F, set entries to zero that are rounding errors relative to others of their row and column."""
    return _explicit(data.A, data.B) if data.F is None else _descriptor(data.A, data.B, data.F)


def _explicit(A, B) -> ScaledPencil:
    kept_A, kept_B = _without_rounding(A, B)
    state, inputs, rate = _fitted(kept_A, kept_B)
    equation = 1 / (state * rate)
    scaled_B = equation[:, None] * kept_B * inputs
    dropped = int((kept_A != A).sum() + (kept_B != B).sum())
    scaled_A, size = equation[:, None] * kept_A * state, np.abs(kept_A)
    small = size <= ROUNDED_COUPLING * np.minimum(size.max(axis=1, keepdims=True), size.max(axis=0))
    weak, units = (size > 0) & small & _on_no_cycle(kept_A), (equation, state, inputs, rate)
    return ScaledPencil(scaled_A, np.eye(len(A)), scaled_B, scaled_B, scaled_B, EPS, *units, True, dropped, weak)


def _descriptor(A, B, F) -> ScaledPencil:
    scaling = joint_scaling(np.array([A, F]))
    scaled_A, scaled_F = scaling.apply(np.array([A, F]))
    scaled_B = scaling.rows[:, None] * B
    inputs = np.exp2(-np.round(np.log2(np.linalg.norm(scaled_B, axis=0))))
    scaled_B = scaled_B * inputs
    input_space, noise = _input_space(scaled_F, scaled_B)
    through = np.linalg.solve(scaled_F, scaled_B)
    units = scaling.rows, scaling.columns, inputs, scaling.time
    return ScaledPencil(scaled_A, scaled_F, scaled_B, through, input_space, noise, *units, False, 0, np.zeros(A.shape, dtype=bool))


def _input_space(F, B, known: float = EPS) -> tuple[np.ndarray, float]:
    """An orthonormal basis of the states w with F w in the span of B, and its accuracy."""
    n, p = B.shape
    if not p:
        return B, 0.0
    U, lengths, _ = np.linalg.svd(B)
    _, values, rows = np.linalg.svd(U[:, p:].T @ F)
    return rows[n - p :].T, float(known * (lengths[0] / lengths[-1]) * np.linalg.norm(F) / values[-1])


def _without_rounding(A, B):
    """Matrices with entries set to zero that are rounding errors of their row and column in both the given and the fitted units.

    What is on no cycle of A the fit would bring near 1 whatever it is: there the given units decide alone.
    """
    n, (state, inputs, _) = len(A), _fitted(A, B)
    both, units = np.hstack([A, B]), np.concatenate([state, inputs])
    on_no_cycle = np.hstack([_on_no_cycle(A), np.zeros(B.shape, dtype=bool)])
    drop = _is_rounding(both) & (_is_rounding(both * units / state[:, None]) | on_no_cycle)
    kept = np.where(drop, 0.0, both)
    return kept[:, :n], kept[:, n:]


def _is_rounding(both) -> np.ndarray:
    size = np.abs(both)
    rows, columns = size.max(axis=1, keepdims=True), size.max(axis=0)
    return size <= NOISE_SAFETY * EPS * np.minimum(rows, columns)


def _on_no_cycle(A) -> np.ndarray:
    """Which entries couple parts of A in one direction only."""
    part = scipy.sparse.csgraph.connected_components(A != 0, directed=True, connection="strong")[1]
    return part[:, None] != part


def _fitted(A, B):
    """Powers of two (d, c, rate): the minimum-norm least-squares exponents by the normal equations."""
    n, p = B.shape
    both = np.hstack([A, B])
    i, j = np.nonzero(both)
    of_A = (j < n).astype(float)
    size = n + p + 1
    normal, right, logs = np.zeros((size, size)), np.zeros(size), np.log2(np.abs(both[i, j]))
    places, weights = np.stack([i, j, np.full(len(i), n + p)]), np.stack([np.ones(len(i)), -np.ones(len(i)), of_A])
    for a in range(3):
        np.add.at(right, places[a], weights[a] * logs)
        for b in range(3):
            np.add.at(normal, (places[a], places[b]), weights[a] * weights[b])
    fit = np.exp2(np.round(np.linalg.lstsq(normal, right, rcond=None)[0]))
    return fit[:n], fit[n : n + p], float(fit[-1])


#: Random compressions of the pencil; each finds what there is with probability one.
COMPRESSIONS = 2

#: Steps of refinement of an eigenvalue; they converge at least quadratically.
REFINEMENTS = 6


@dataclass(frozen=True)
class Margin:
    """Margin of one condition: the distance to violating it."""

    rank: int  # rank, needed: the rank, and the one needed, of [B, A B] or [A - lambda I, B]
    needed: int
    distance: float  # distance in the scaled units; infinite where the condition cannot fail
    bound: float  # the bound below which it counts as zero: the noise times its safety
    size: float  # |A| in the same units
    eigenvalue: float | None = None  # the lambda of the smallest distance, in 1/s

    @property
    def ratio(self) -> float:
        """The distance in units of its bound."""
        return self.distance / self.bound if self.distance else 0.0

    @property
    def relative(self) -> float:
        return self.distance / self.size if self.size else 0.0

    @property
    def holds(self) -> bool:
        return self.rank == self.needed

    @property
    def clear(self) -> bool:
        if self.holds:
            return self.ratio >= CLEAR_KEPT
        return self.ratio <= CLEAR_DROPPED and self.bound <= FAR_FROM_EIGENVALUE * self.size


@dataclass(frozen=True)
class NormalFormExistence:
    """Margins of both conditions of a pair that has a normal form."""

    inputs: Margin  # the margin of rank [B, A B] = 2 p
    eigenvalues: Margin  # the margin of rank [A - lambda I, B] >= n/2 + p over all real lambda
    rests_on: int = 0  # number of weak entries of A on which the existence depends

    @property
    def notices(self) -> tuple[Notice, ...]:
        """A warning for each condition with a narrow margin, and for decisive entries that may be rounding errors."""
        if self.rests_on:
            text = (
                f"the normal form rests on {counted(self.rests_on, 'entry', 'entries')} of A that are very small relative to others of "
                "their row and their column; if they are rounding errors of zeros there is none"
            )
            return (*replace(self, rests_on=0).notices, Notice(NoticeKind.RANK, text, doubtful=True))
        rate = self.eigenvalues.eigenvalue
        where = "" if rate is None else f" at lambda = {rate:.6g}"
        named = ("rank [B, A B] = 2 p", self.inputs), (f"rank [A - lambda I, B] >= n/2 + p{where}", self.eigenvalues)
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


#: No state, no condition.
NO_CONDITIONS = NormalFormExistence(Margin(0, 0, np.inf, EPS, 0.0), Margin(0, 0, np.inf, EPS, 0.0))


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
        _margins(replace(pair, A=np.where(pair.weak, 0.0, pair.A), weak=np.zeros_like(pair.weak)))
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
        text = (
            f" = {inputs.rank}, but 2 p = {inputs.needed} is needed: some combination of the inputs acts on no velocity of its own, but on "
            "displacements at once, or on a velocity of another input"
        )
        raise _no_form("rank [B, A B]", text, inputs, pair)
    noise = size * pair.known * float(np.hypot(1.0, condition if p else 0.0))
    eigenvalues = Margin(n // 2 + p, n // 2 + p, np.inf, NOISE_SAFETY * noise, size)
    if 2 * p < n:
        P = Q[:, p:].T @ pair.A, Q[:, p:].T @ pair.F  # its rank may fall, or nearly does, at some real lambda
        rate, values = min((_refined(value, *P) for value in _candidates(*P)), key=lambda candidate: candidate[1][n // 2 - 1])
        of_F = 0.0 if pair.explicit else pair.known * abs(rate) * float(np.linalg.norm(pair.F))
        eigenvalues = _margin(n // 2 + p, values, n // 2, np.hypot(noise, of_F), size, rate * pair.rate)
    if not eigenvalues.holds:
        text = (
            f" = {eigenvalues.rank} at the eigenvalue lambda = {eigenvalues.eigenvalue:.6g}, but at least n/2 + p = {eigenvalues.needed} is "
            "needed: too many motions exp(lambda t) that no input reaches, more than one for each coordinate that is left"
        )
        raise _no_form("rank [A - lambda I, B]", text, eigenvalues, pair)
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
        try:
            left = scipy.linalg.svd(constant - value * linear, full_matrices=False)[0]
        except np.linalg.LinAlgError:  # the fast algorithm may not converge for many equal singular values, the slow one does
            left = scipy.linalg.svd(constant - value * linear, full_matrices=False, lapack_driver="gesvd")[0]
        left = left[:, count - 1 :].T
        along = left @ linear
        value = float(np.vdot(along, left @ constant) / np.vdot(along, along))
        values = scipy.linalg.svdvals(constant - value * linear)
        if values[count - 1] >= best[1][count - 1]:
            break
        best = value, values
    return best


def _no_form(name: str, text: str, margin: Margin, pair: ScaledPencil) -> NoNormalForm:
    return NoNormalForm(
        f"no mechanical normal form{pair.part}: {name}{text}. {_nearness(margin, pair)}",
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
