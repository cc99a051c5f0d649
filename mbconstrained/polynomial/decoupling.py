"""The scaled companion pencil of A(s), and its finite and infinite part decoupled (the Weierstrass form)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.tolerances import EPS, NOISE_SAFETY, PRECISE_DECOUPLING
from ..linalg.arrays import block_diag
from ..linalg.blocks import coupled_rows
from ..linalg.precise import floats, is_precise, magnitude, of_kind, precise, precise_arithmetic, product, zero_multiplicity
from ..linalg.rank import Noisy, RankDecision, columnwise
from ..linalg.scaling import Scaling, joint_scaling
from ..linalg.staircase import SplitPencil, split_pencil, split_regular
from ..linalg.triangular import triangular_form
from .coefficients import PolynomialCoefficients

# A(s) as a first-order pencil s E - F with states x, x', ..., x^(q-1), in scaled units.
# E = diag(I, ..., I, A_q), F = [[0, I, ..., 0], ..., [-A_0, ..., -A_(q-1)]] is a strong linearization: it has the
# finite and the infinite elementary divisors of A(s), and its solutions from values at 0- are those of
# A(d/dt) x = f exactly, impulses included, because every row but the last only states that the next state is
# the derivative of the one before.


@dataclass(frozen=True, eq=False)
class ScaledCompanion:
    """The companion pencil of the scaled coefficients.

    Attributes:
        known: scaled A_0 ... A_g with g = max(q, 1), shape (g + 1, m, n), in float64 or precise, and how well they are known.
        scaling: the powers of two used.
    """

    known: Noisy
    scaling: Scaling

    @property
    def is_precise(self) -> bool:
        """True where the coefficients have more digits than float64."""
        return is_precise(self.known.data)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """The coefficients in float64."""
        return self.known.data.astype(float)

    @property
    def size(self) -> int:
        """r."""
        return self.known.data.shape[1]

    @property
    def grade(self) -> int:
        """g, the number of stacked derivatives."""
        return len(self.known.data) - 1

    @property
    def state_count(self) -> int:
        """g r, the size of the pencil."""
        return self.grade * self.size

    @property
    def E(self) -> np.ndarray:
        """Shape (g r, g r), in float64."""
        return self.pencil[0].data.astype(float)

    @cached_property
    def pencil(self) -> tuple[Noisy, Noisy]:
        """E and F with their uncertainty, shape ((g - 1) n + m, g n)."""
        (_, m, n), g = self.known.data.shape, self.grade
        last = slice((g - 1) * n, None)
        E, F = (Noisy.exact(of_kind(np.eye((g - 1) * n + m, g * n, k=shift), self.known.data)) for shift in (0, n))
        E[last, last] = self.known[g]
        for power in range(g):
            F[last, power * n : (power + 1) * n] = -self.known[power]
        return E, F

    @property
    def transposed(self) -> ScaledCompanion:
        """The companion pencil of A(s)^T in the same units."""
        known, (time, rows, columns) = self.known, (self.scaling.time, self.scaling.rows, self.scaling.columns)
        return ScaledCompanion(
            Noisy(known.data.transpose(0, 2, 1), known.noise.transpose(0, 2, 1)), Scaling(time, rows=columns, columns=rows)
        )

    @cached_property
    def split(self) -> SplitPencil:
        """The finite and the infinite part."""
        return split_regular(*self.pencil)

    def scaled_stack(self, initial: np.ndarray) -> np.ndarray:
        """Values (q, r) at 0- as the pencil's state (g r,), in its units; S of them, (q, r, S), as (g r, S)."""
        stack = np.zeros((self.grade, *initial.shape[1:]))
        powers = self.scaling.time ** -np.arange(len(initial), dtype=float)
        stack[: len(initial)] = (initial.T * powers / self.scaling.columns[:, None]).T
        return stack.reshape(-1, *initial.shape[2:])


def scaled_companion(A: PolynomialCoefficients, rank_tolerance: float | None = None, in_float64: bool = True) -> ScaledCompanion:
    """The companion pencil of A(s) in units chosen from its entries, in float64 or precise.

    Entries given in float64 are known to a unit in the last place, a coefficient given by its factors is known exactly; where
    a rank tolerance is given, a difference of entries counts as zero if it is no larger than that part of them.
    """
    exact = _with_first_power(A.coefficients if in_float64 else precise(A.exact_coefficients))
    scaling = joint_scaling(_with_first_power(_telling(A)))
    scaled = scaling.apply(exact)
    if rank_tolerance is not None:
        known = np.full(len(exact), rank_tolerance / NOISE_SAFETY)
    else:
        by_factors = [factors is not None and not in_float64 for factors in A.factors]
        known = np.where([*by_factors, True][: len(exact)], 0.0, EPS)
    noise = known[:, None, None] * magnitude(scaled)
    if rank_tolerance is None:
        noise = np.maximum(noise, scaling.apply(_with_first_power(A.uncertainty)))
    return ScaledCompanion(Noisy(scaled, noise), scaling)


def multiplicity_at_zero(A: PolynomialCoefficients) -> int:
    """The multiplicity of s = 0 as a zero of a regular det A(s) with exact entries."""
    *lower, highest = _with_first_power(A.exact_coefficients)
    states, last = len(lower) * A.size, slice((len(lower) - 1) * A.size, None)
    E, F = np.eye(states, dtype=object), np.eye(states, k=A.size, dtype=object)
    E[last, last], F[last] = highest, -np.hstack(lower)
    return zero_multiplicity(E, F)


def _telling(A: PolynomialCoefficients) -> np.ndarray:
    """The coefficients without entries that may be zero, which have no size for scaling.

    Those are within their uncertainty, or rounding errors of the largest of their row and of the largest of their column, in one
    coefficient: what computed matrices have in place of zeros.
    """
    size = np.abs(A.coefficients)
    rounding = EPS * np.minimum(size.max(axis=1, keepdims=True, initial=0.0), size.max(axis=2, keepdims=True, initial=0.0))
    return np.where(size > np.maximum(NOISE_SAFETY * A.uncertainty, rounding), A.coefficients, 0.0)


def _with_first_power(coefficients: np.ndarray) -> np.ndarray:
    """The coefficients with a first power, which a pencil needs, added where there is none."""
    return coefficients if len(coefficients) > 1 else np.concatenate([coefficients, 0 * coefficients])


def known_coefficient(A: PolynomialCoefficients, power: int) -> Noisy:
    """A_power with its uncertainty: precise and exact where it is given by its factors."""
    factors = A.factors[power]
    known = Noisy.rounded(A.coefficients[power]) if factors is None else Noisy.exact(precise(factors.exact))
    return Noisy(known.data, np.maximum(known.noise, A.uncertainty[power]))


# The companion pencil decoupled into s I - T (finite, T in real Schur form) and s N - I (infinite).
# With P (s E - F) Q = diag(s I - T, s N - I) the inverse of A(s) is read off the first r rows of Q and the last
# r columns of P (Moysis et al., Theorem 2.8):  A(s)^-1 = C (s I - T)^-1 B - C2 (I + s N + s^2 N^2 + ...) B2,
# all in the scaled units of the companion pencil. Values z0 at 0- enter the finite part as P_1 E z0 and the
# infinite one as P_2 F z0 (Eqs. 43-44).


@dataclass(frozen=True, eq=False)
class WeierstrassForm:
    """The decoupled pencil, in scaled units.

    Attributes:
        companion: the pencil it came from.
        split: the staircase result.
        decisions: the rank decisions taken, at infinity and at s = 0.
        T: real Schur form of the finite part, shape (n, n), the zeros at s = 0 last.
        nonzero_count: number of rows of T for the other zeros.
        zero_divisors: degrees of the elementary divisors at s = 0, ascending.
        finite_columns: Q_1, shape (g r, n).   finite_rows: P_1, shape (n, g r).   finite_start: P_1 E, likewise.
        nilpotent: N, shape (m, m).
        infinite_columns: Q_2, shape (g r, m). infinite_rows: P_2, shape (m, g r). infinite_start: P_2 F, likewise.
        The infinite part is small and read for zeros, so it carries its rounding noise.
        exact_pair: C, T and B before they were rounded, where the arithmetic was precise.
    """

    companion: ScaledCompanion
    split: SplitPencil
    decisions: tuple[RankDecision, ...]
    T: np.ndarray
    nonzero_count: int
    zero_divisors: tuple[int, ...]
    finite_columns: np.ndarray
    finite_rows: np.ndarray
    finite_start: np.ndarray
    nilpotent: Noisy
    infinite_columns: Noisy
    infinite_rows: Noisy
    infinite_start: Noisy
    exact_pair: tuple[np.ndarray, np.ndarray, np.ndarray] | None

    @property
    def C(self) -> np.ndarray:
        """Shape (r, n)."""
        return self.finite_columns[: self.companion.size]

    @property
    def B(self) -> np.ndarray:
        """Shape (n, r)."""
        return _of_equations(self.finite_rows, self.companion)

    @property
    def noisy_B(self) -> Noisy:
        """B with its rounding errors: those of an eigenvalue algorithm, or of each entry where it was precise."""
        by_rows = columnwise(self.B.T).T
        if not self.companion.is_precise:
            return by_rows
        return Noisy(self.B, EPS * np.abs(self.B) + PRECISE_DECOUPLING / EPS * by_rows.noise)

    @property
    def C2(self) -> Noisy:
        """Shape (r, m)."""
        return self.infinite_columns[: self.companion.size]

    @property
    def B2(self) -> Noisy:
        """Shape (m, r)."""
        return _of_equations(self.infinite_rows, self.companion)

    @property
    def highest_impulse(self) -> int:
        """q_hat_r, the highest order of an infinite zero of A(s): H_i = 0 beyond it."""
        return max([0, *(degree - self.companion.grade for degree in self.split.infinite_divisors)])

    def laurent(self, index: int) -> Noisy:
        """Scaled H_i of A(s)^-1 near infinity, shape (r, r)."""
        r = self.companion.size
        if index > self.highest_impulse:
            return Noisy.exact(np.zeros((r, r)))
        if index < 0:
            return self._precise_laurent(index) if self.exact_pair else self._rounded_laurent(index)
        value = -self.B2
        for _ in range(index):
            value = self.nilpotent @ value
        return self.C2 @ value

    def _rounded_laurent(self, index: int) -> Noisy:
        """C T^(-i-1) B; T is known to rounding errors of its norm, as is what orthogonal transformations make, part by part."""
        size = np.abs(self.T)
        uncertain = size.copy()
        for at in coupled_rows(self.T):
            own = np.ix_(at, at)
            uncertain[own] = np.maximum(size[own], size[own].max() / len(at))
        value, largest = self.B, np.abs(self.B).max(axis=0, keepdims=True, initial=0.0)
        noise = np.maximum(EPS * largest, self.noisy_B.noise)
        for _ in range(-index - 1):
            value, noise = self.T @ value, size @ noise + EPS * uncertain @ np.abs(value)
        return Noisy(self.C @ value, np.abs(self.C) @ noise)

    def _precise_laurent(self, index: int) -> Noisy:
        """C T^(-i-1) B from unrounded matrices: where fast zeros cancel, slow ones keep their digits."""
        C, T, value = self.exact_pair
        with precise_arithmetic():
            size = magnitude(value)
            for _ in range(-index - 1):
                value, size = product(T, value), magnitude(T) @ size
            H = floats(product(C, value))
            return Noisy(H, EPS * np.abs(H) + PRECISE_DECOUPLING * magnitude(C) @ size)


def weierstrass_form(companion: ScaledCompanion, decided: Sequence[RankDecision] | None = None) -> WeierstrassForm:
    """Decouple the finite from the infinite part.

    The coupling R solves R = T R N + G; N is nilpotent, so the fixed point is reached in as many steps as there
    are blocks in the staircase, row by row in the Schur basis of the finite part.
    """
    (E, F), decisions = companion.pencil, iter(decided or ())
    split = companion.split if decided is None else split_pencil(E, F, decisions)
    n = len(split.E11.data)
    at_zero = tuple(decisions)
    finite = triangular_form(split.E11, split.F11, iter(at_zero) if at_zero else None)
    left = columnwise(finite.left.T).T
    exact_T = product(finite.left, split.F11.data, finite.right) if companion.is_precise else finite.T
    E12, F12 = left @ split.E12, left @ split.F12
    R = _fixed_point(Noisy.rounded(exact_T), split.nilpotent, F12 @ split.nilpotent + -E12, len(split.deficiencies))
    finite_columns = product(split.right.data[:, :n], finite.right)
    finite_rows = product(finite.left, split.left.data[:n]) - product(product(exact_T, R.data) + F12.data, split.left.data[n:])
    infinite_columns = split.right[:, n:] + columnwise(finite_columns) @ R
    T, exact_pair = finite.T.astype(float), None
    if companion.is_precise:
        turn = aligning_rotation(T, _of_equations(finite_rows, companion))
        finite_columns, finite_rows = product(finite_columns, turn.T), product(turn, finite_rows)
        T[:, finite.nonzero_count :] = floats(product(turn, finite.T[:, finite.nonzero_count :]))  # pairs stay what they are
        exact_pair = finite_columns[: companion.size], product(turn, exact_T, turn.T), _of_equations(finite_rows, companion)
    return WeierstrassForm(
        companion=companion,
        split=split.rounded_to_float(),
        decisions=split.decisions + finite.decisions,
        T=T,
        nonzero_count=finite.nonzero_count,
        zero_divisors=finite.zero_divisors,
        finite_columns=floats(finite_columns),
        finite_rows=floats(finite_rows),
        finite_start=floats(product(finite_rows, E.data)),
        nilpotent=split.nilpotent.rounded_to_float(),
        infinite_columns=infinite_columns.rounded_to_float(),
        infinite_rows=split.left[n:].rounded_to_float(),
        infinite_start=(split.left[n:] @ F).rounded_to_float(),
        exact_pair=exact_pair,
    )


def _of_equations(rows, companion: ScaledCompanion):
    """The last r columns, those of the equations A(d/dt) x = f themselves."""
    return rows[:, companion.state_count - companion.size :]


def _fixed_point(T, nilpotent, G, steps):
    R = G
    for _ in range(steps):
        R = T @ R @ nilpotent + G
    return R


# Complex pairs in the basis in which a force enters at one of the two states.
#
# A pair [[a, w], [-w, a]] is the same in every rotated basis, but not what is made of its rounded entries: of a mode that is
# at rest before an impulse, C B = 0, the displacement does not jump. In the basis in which B has one row only, so has C one
# column, the other one, and C B = 0 holds exactly; in any other it is the difference of products, and next to a force much
# faster than the mode its rounding error would be all that is left.


def aligning_rotation(T: np.ndarray, B: np.ndarray) -> np.ndarray:
    """The precise orthogonal matrix G, block diagonal as T is, for which the first row of G B is least for every pair."""
    blocks, at = [], 0
    while at < len(T):
        pair = at + 1 < len(T) and T[at + 1, at] != 0 and T[at + 1, at] == -T[at, at + 1] and T[at, at] == T[at + 1, at + 1]
        blocks.append(_rotation(B[at : at + 2]) if pair else np.eye(1))
        at += len(blocks[-1])
    return precise(block_diag(*blocks))


def _rotation(B) -> np.ndarray:
    """The rotation by the direction of the column of B (2, r) that is largest."""
    column = B[:, magnitude(B).max(axis=0).argmax()] if B.size else precise(np.array([0.0, 1.0]))
    length = (column[0] * column[0] + column[1] * column[1]).sqrt()
    if length == 0:
        return precise(np.eye(2))
    sine, cosine = column / length
    return np.array([[cosine, -sine], [sine, cosine]])
