"""Finite and infinite Jordan pairs of A(s) in floating point, and its finite zeros with their multiplicities."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from ..ground.checks import counted
from ..ground.display import Displayed, TextTable
from ..ground.errors import IllConditioned, InputError, Overflow, SingularPolynomialMatrix
from ..ground.notices import Evidence, Notice, NoticeKind
from ..ground.threads import short_work
from ..ground.tolerances import (
    AS_WRITTEN_STATES,
    CLUSTER_SAFETY,
    EPS,
    JOINED_MULTIPLICITIES,
    NOISE_SAFETY,
    PRECISE_STATES,
    RANK_TRIALS,
    rounding_radius,
)
from ..linalg.arrays import block_diag, lapack
from ..linalg.blocks import block_diagonalize, coupled_rows, eigenvalues
from ..linalg.precise import floats, is_precise, is_worthwhile, precise_arithmetic, product, unit
from ..linalg.rank import RankDecision
from ..linalg.staircase import GENERIC, SingularPencil
from .coefficients import PolynomialCoefficients
from .decoupling import WeierstrassForm, multiplicity_at_zero, scaled_companion, weierstrass_form
from .structure import FiniteZero, Structure, singular_message

# Zeros with multiplicities, from the finite part in real Schur form.


def finite_zeros(form: WeierstrassForm) -> tuple[FiniteZero, ...]:
    """The zeros of A(s) in 1/s, ascending by modulus; of each complex pair the one above the real axis.

    A defective zero of multiplicity m is computed as m zeros around it, at a distance of about eps^(1/m). Zeros of
    one block are therefore one zero, at their mean, where no decoupling separates them that a rounding error of the
    data could not undo. Zeros of different blocks are one if they differ by a few units in the last place, or if they
    are close and rank decisions make them one within the noise of the data. Zeros at s = 0 were split off by rank decisions and
    have the exact value 0.
    """
    moving = form.T[: form.nonzero_count, : form.nonzero_count]
    groups = [zero for block in block_diagonalize(moving).blocks for zero in _merged(_zeros_of_block(block), rounding_radius(2))]
    parts, scale = ZeroParts(form), form.companion.scaling.time
    ascending = sorted(groups, key=lambda zero: (abs(zero.value), zero.value.real, zero.value.imag))
    zeros = []
    for zero in _joined(_merged(ascending, rounding_radius(1)), parts):  # one doubtful chain where decisions make it no single zero
        result = parts.divisors(zero.value, zero.multiplicity) or Divisors((zero.multiplicity,), within_noise=False, clear=False)
        zeros.append(FiniteZero(complex(scale * zero.value), zero.multiplicity, result.degrees, result.clear))
    if count := len(form.T) - form.nonzero_count:
        zeros.append(FiniteZero(0j, count, form.zero_divisors, all(decision.clear for decision in form.decisions)))
    return in_order(zeros)


def _joined(zeros, parts: ZeroParts) -> list[FiniteZero]:
    """Close zeros become one where they are a single zero within the noise of the data.

    The radius within which zeros are tried grows as for higher and higher multiplicities: a zero that is slow relative to others
    is moved by rounding errors of those, and further than by those of its own size.
    """
    for multiplicity in JOINED_MULTIPLICITIES:
        radius, joined = rounding_radius(multiplicity), []
        for run in _clusters(zeros, radius):
            whole = _whole(run, radius)
            tried = (len(run) > 1 or whole != run[0]) and whole.multiplicity <= 2 * JOINED_MULTIPLICITIES[-1]
            result = parts.divisors(whole.value, whole.multiplicity) if tried else None
            joined += [whole] if result and result.within_noise else run
        zeros = joined
    return list(zeros)


def _clusters(zeros, radius) -> list[list[FiniteZero]]:
    """The zeros in groups; each member is within the radius times its size of another."""
    values = np.array([zero.value for zero in zeros])
    near = np.abs(values[:, None] - values) <= radius * np.abs(values)
    return [[zeros[i] for i in group] for group in coupled_rows(near)]


def _whole(run, radius) -> FiniteZero:
    """One zero for all at their mean; real, including conjugates, where all are near the real axis."""
    real = all(zero.value.imag <= radius * abs(zero.value) for zero in run)
    weights = [zero.count if real else zero.multiplicity for zero in run]
    mean = np.average([zero.value for zero in run], weights=weights)
    return FiniteZero(complex(mean.real) if real else complex(mean), sum(weights))


def _zeros_of_block(block) -> list[FiniteZero]:
    """Zeros of one cluster: separate where a decoupling below the limit for its size separates them, or they are well separated."""
    values = eigenvalues(block)
    above = values[values.imag > 0]
    pairs = 2 * len(above) == len(values) and above.imag.min() > _spread(above)
    multiplicity = len(above) if pairs else len(values)
    if pairs and multiplicity == 1:
        return [_pair_or_double(complex(above[0]))]
    limit = 0.5 * (CLUSTER_SAFETY * EPS) ** (1 / multiplicity - 1)  # the decoupling norm of zeros that rounding errors separate
    parts = block_diagonalize(block, limit).blocks
    if len(parts) > 1:
        return [zero for part in parts for zero in _zeros_of_block(part)]
    group = above if pairs else values
    if _spread(group) > rounding_radius(multiplicity) * np.abs(group).max():
        return [
            _pair_or_double(complex(value)) if value.imag else FiniteZero(complex(value), 1) for value in values if value.imag >= 0
        ]
    return [FiniteZero(complex(above.mean()) if pairs else complex(values.mean().real), multiplicity)]


def _pair_or_double(value: complex) -> FiniteZero:
    """A pair a +- i w, or the double zero a where w is within the rounding error of a double zero."""
    if value.imag <= rounding_radius(2) * abs(value.real):
        return FiniteZero(complex(value.real), 2)
    return FiniteZero(value, 1)


def _spread(values) -> float:
    return float(np.abs(values - values.mean()).max())


def _merged(zeros, radius) -> list[FiniteZero]:
    """Zeros that differ by less than radius times their size become one, at their mean."""
    merged: list[FiniteZero] = []
    for zero in zeros:
        for place, other in enumerate(merged):
            if abs(zero.value - other.value) <= radius * abs(zero.value):
                total = zero.multiplicity + other.multiplicity
                mean = (zero.multiplicity * zero.value + other.multiplicity * other.value) / total
                merged[place] = FiniteZero(mean, total)
                break
        else:
            merged.append(zero)
    return merged


def in_order(zeros) -> tuple[FiniteZero, ...]:
    """Zeros by modulus, real and imaginary part; values that agree to rounding errors count as equal, for a robust order."""
    return tuple(
        zero
        for ring in _runs(zeros, lambda zero: abs(zero.value))
        for line in _runs(ring, lambda zero: zero.value.real)
        for zero in sorted(line, key=lambda zero: zero.value.imag)
    )


def _runs(zeros, key) -> list[list[FiniteZero]]:
    """Ascending by the key, cut where it grows by more than rounding moves the parts of a double zero."""
    runs: list[list[FiniteZero]] = []
    for zero in sorted(zeros, key=key):
        if runs and key(zero) - key(runs[-1][-1]) <= rounding_radius(2) * abs(zero.value):
            runs[-1].append(zero)
        else:
            runs.append([zero])
    return runs


# The partial multiplicities of a zero: the degrees of its elementary divisors, the lengths of its Jordan chains.
#
# They are rank decisions on the part of the pencil that belongs to the zero. With left and right bases L and R of that
# part, taken from the Schur form, J = (L E R)^-1 L F R is formed again from the given coefficients: errors of the bases
# enter only as their product, so that what remains is the noise of the data, and that is known. J less the mean of its
# zeros, which is known far better than each of them, is nilpotent to within that noise, and a staircase of orthogonal
# transformations counts its chains (Kublanovskaya 1966, Kagstrom and Ruhe 1980). The zeros themselves, scattered by
# eps^(1/m), are never looked at.


@dataclass(frozen=True)
class Divisors:
    """The degrees of the elementary divisors of one zero, ascending, and their reliability.

    Attributes:
        within_noise: it is a single zero within the noise of the data, not only within a multiple of it.
        clear: and all decisions behind that were clear.
    """

    degrees: tuple[int, ...]
    within_noise: bool
    clear: bool


@dataclass(frozen=True)
class ZeroParts:
    """The parts of a decoupled pencil for its zeros, computed on demand."""

    form: WeierstrassForm

    @cached_property
    def _schur(self) -> tuple[np.ndarray, np.ndarray]:
        return scipy.linalg.rsf2csf(self.form.T, np.eye(len(self.form.T)))

    def divisors(self, value: complex, multiplicity: int) -> Divisors | None:
        """Divisors of this number of zeros nearest to a value (scaled); None where they are no single zero within the noise."""
        if multiplicity == 1:
            return Divisors((1,), True, True)
        N, noise = self._nilpotent(value, multiplicity)
        for factor in RANK_TRIALS:
            degrees, decisions = _chains(N, factor * noise)
            if sum(degrees) == multiplicity:
                within = factor == 1.0
                return Divisors(degrees, within, within and all(decision.clear for decision in decisions))
        return None

    def _nilpotent(self, value, multiplicity) -> tuple[np.ndarray, float]:
        """J less the mean of its zeros, and its noise (Frobenius norm)."""
        E, F = self.form.companion.pencil
        L, R = self._bases(value, multiplicity)
        balance = np.sqrt(np.linalg.norm(L, axis=1) / np.linalg.norm(R, axis=0))  # alike noise in all directions
        L, R = L / balance[:, None], R * balance
        inverse = np.linalg.inv(_between(L, E.data, R))
        J = inverse @ _between(L, F.data, R)
        mean = np.trace(J) / multiplicity
        square = (F.noise**2 + (unit(F.data) * F.size) ** 2) + abs(mean) ** 2 * (E.noise**2 + (unit(E.data) * E.size) ** 2)
        noise = np.sqrt(np.abs(inverse @ L) ** 2 @ square @ np.abs(R) ** 2)
        rounding = EPS * abs(mean) * multiplicity**0.5  # J is formed in float64 in the end
        return J - mean * np.eye(multiplicity), float(np.hypot(np.linalg.norm(noise), rounding))

    def _bases(self, value, multiplicity) -> tuple[np.ndarray, np.ndarray]:
        """Left (m, g r) and right (g r, m) bases of the m zeros nearest to the value."""
        T, Q = self._schur
        chosen = np.zeros(len(T), dtype=np.int32)
        chosen[np.argsort(np.abs(np.diag(T) - value), kind="stable")[:multiplicity]] = 1
        T, Q, *_ = lapack.ztrsen(chosen, T, Q, job="N")
        first, rest = slice(multiplicity), slice(multiplicity, None)
        rows = Q.conj().T
        left = rows[first]
        if len(T) > multiplicity:
            coupling, scale, _ = lapack.ztrsyl(T[first, first], T[rest, rest], -T[first, rest], isgn=-1)
            left = left - coupling / scale @ rows[rest]
        return left @ self.form.finite_rows, self.form.finite_columns @ Q[:, first]


def _between(L, matrix, R) -> np.ndarray:
    """L @ matrix @ R for a real matrix, float64 or precise, the sums in its arithmetic."""
    with precise_arithmetic() if is_precise(matrix) else nullcontext():
        left, right = np.vstack([L.real, L.imag]), np.hstack([R.real, R.imag])
        value, m = product(left, matrix, right), len(L)
        return floats(value[:m, :m] - value[m:, m:]) + 1j * floats(value[:m, m:] + value[m:, :m])


def _chains(N, noise) -> tuple[tuple[int, ...], list[RankDecision]]:
    """Chain lengths of a matrix that is nilpotent to within its noise, ascending; their sum is less where it is not.

    The null space of N is taken out, then that of what is left, and so on: each time one link of every chain. A null space is
    known to the noise over the smallest singular value kept, and turns what is left by as much.
    """
    links, decisions = [], []
    while len(N):
        values, rows = np.linalg.svd(N)[1:]
        bound = NOISE_SAFETY * noise
        rank = int((values > bound).sum())
        smallest, largest = (values[rank - 1] if rank else np.inf), (values[rank] if rank < len(N) else 0.0)
        decisions.append(RankDecision(rank, float(smallest / bound), float(largest / bound)))
        if rank == len(N):
            break
        links.append(len(N) - rank)
        N = rows[:rank] @ N @ rows[:rank].conj().T
        noise = noise * float(np.hypot(1.0, values[0] / smallest))
    longer = [*links[1:], 0]
    return tuple(k + 1 for k, link in enumerate(links) for _ in range(link - longer[k])), decisions


# The finite and the infinite Jordan pair of A(s) in the user's units, with their evidence.

#: The least normal number of float64.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, repr=False, eq=False)
class FinitePair(Displayed):
    """The strictly proper part of A(s)^-1 as C (s I - J)^-1 B (Moysis et al., Theorem 2.8).

    J is block diagonal, real and quasi-triangular, one block for each zero, complex pair or cluster of close
    zeros; it is similar to the Jordan form, which cannot be computed literally in floating point.

    Attributes:
        C: shape (r, n).  B: shape (n, r).  blocks: the diagonal blocks of J, in 1/s.
        coupling: the largest entry of the transformation that decoupled the blocks.
        form: the decoupled pencil that it is read from.
    """

    C: np.ndarray
    B: np.ndarray
    blocks: tuple[np.ndarray, ...]
    coupling: float
    form: WeierstrassForm = field(repr=False)

    def _summary(self) -> str:
        return f"{counted(len(self.B), 'state')}, {counted(len(self.blocks), 'block')}"

    @cached_property
    def J(self) -> np.ndarray:
        """Shape (n, n)."""
        return block_diag(*self.blocks)

    @cached_property
    def zeros(self) -> tuple[FiniteZero, ...]:
        """The zeros with their multiplicities, ascending by modulus; of each complex pair the one above the real axis."""
        return finite_zeros(self.form)


@dataclass(frozen=True, repr=False, eq=False)
class InfinitePair(Displayed):
    """The polynomial part of A(s)^-1 as C (I - s J)^-1 B, minimal, J nilpotent (Theorem 2.8, sizes corrected).

    Attributes:
        C: shape (r, mu).  J: shape (mu, mu), in s.  B: shape (mu, r).
    """

    C: np.ndarray
    J: np.ndarray
    B: np.ndarray

    def _summary(self) -> str:
        return counted(len(self.J), "state")


@dataclass(frozen=True, repr=False, eq=False)
class JordanPairs(Displayed):
    """Finite and infinite Jordan pair of a regular A(s), computed on demand.

    Attributes:
        polynomial_matrix: A(s).
        form: the decoupled companion pencil of both.
        rank_tolerance: the requested one, None for the noise of the data.
    """

    polynomial_matrix: PolynomialCoefficients
    form: WeierstrassForm
    rank_tolerance: float | None = None

    def _summary(self) -> str:
        A = self.polynomial_matrix
        return f"size {A.size}, degree {A.degree}, {counted(len(self.form.T), 'finite state')}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((item.name, f"{item.value:.2g}", item.text) for item in self.evidence)
        return (TextTable("Evidence", ("quantity", "value", "meaning"), tuple(rows)),)

    @cached_property
    def finite(self) -> FinitePair:
        """(C, J, B) of the finite zeros."""
        form, scaling = self.form, self.form.companion.scaling
        parts = block_diagonalize(form.T)
        with np.errstate(over="ignore", invalid="ignore"):  # values that are not finite are reported with their time
            return FinitePair(
                C=scaling.columns[:, None] * (form.C @ parts.basis),
                B=scaling.time * (parts.inverse @ form.B) * scaling.rows,
                blocks=tuple(scaling.time * block for block in parts.blocks),
                coupling=parts.coupling,
                form=form,
            )

    @cached_property
    def infinite(self) -> InfinitePair:
        """(C, J, B) of the zeros at infinity, of the minimal size mu."""
        form, scaling = self.form, self.form.companion.scaling
        terms = [form.laurent(index).cleaned() for index in range(self.structure.highest_impulse + 1)]
        C, J, B = minimal_nilpotent(terms, self.structure.infinite_chains)
        return InfinitePair(scaling.columns[:, None] * C, J / scaling.time, B * scaling.rows)

    def laurent(self, index: int) -> np.ndarray:
        """H_i of A(s)^-1 = sum over i of H_i s^i near infinity, shape (r, r) (Eqs. 18, 27).

        Raises:
            Overflow: an entry leaves the range of float64 (for i far below zero).
        """
        if isinstance(index, bool) or not isinstance(index, (int, np.integer)):
            raise InputError(f"index: found {index!r}; expected a whole number")
        scaling = self.form.companion.scaling
        with np.errstate(over="ignore", invalid="ignore"):
            H = scaling.columns[:, None] * self.form.laurent(index).cleaned() * scaling.rows * scaling.time ** -float(index)
        if not np.isfinite(H).all():
            raise Overflow(f"H_{index} has entries beyond the range of float64")
        return H

    @cached_property
    def structure(self) -> Structure:
        """Zeros and their multiplicities, finite and infinite."""
        A = self.polynomial_matrix
        divisors = self.form.split.infinite_divisors
        if A.degree == 0:  # the pencil declared one power more
            divisors = tuple(degree - 1 for degree in divisors)
        divisors = (0,) * (A.size - len(divisors)) + divisors
        is_clear = all(decision.clear for decision in self.form.split.decisions)
        doubts = (
            () if is_clear else (Notice(NoticeKind.RANK, "rounding errors of the data decide: A(s) is taken for regular", True),)
        )
        return Structure(A.shape, A.degree, self.finite.zeros, divisors, doubts=doubts)

    @cached_property
    def as_written(self) -> JordanPairs | None:
        """Jordan pairs of the exact data with respect to zeros at s = 0; None where no zeros can have been lost.

        A stiffness of the size of the rounding error of larger ones is that of a free body, or of a soft support: the data do not
        tell. What was taken for zero at infinity stays so.
        """
        form, A, counted_at_zero = self.form, self.polynomial_matrix, sum(self.form.zero_divisors)
        if self.rank_tolerance is not None or not counted_at_zero or not form.companion.known.noise.any():
            return None
        dropped = any(decision.largest_dropped for decision in form.decisions)  # rounding errors of float64 itself, if not more
        if multiplicity_at_zero(A) >= counted_at_zero and not (dropped and form.companion.state_count <= AS_WRITTEN_STATES):
            return None
        return JordanPairs(A, _form_as_written(A, form), 0.0)

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residual of the finite pair, condition of the decouplings, and the gap of the rank decisions."""
        decisions = self.form.decisions
        kept = min((decision.smallest_kept for decision in decisions), default=np.inf)
        dropped = max((decision.largest_dropped for decision in decisions), default=0.0)
        return (
            Evidence(
                "residual", inverse_residual(self), "largest relative residual of A(s) times the inverse made from both pairs"
            ),
            Evidence("decoupling", self.finite.coupling, "largest entry of the transformation that separates the zeros"),
            Evidence("rank gap", float(kept), "smallest value kept in a rank decision, in units of the noise"),
            Evidence("rank remainder", float(dropped), "largest value dropped in a rank decision, in units of the noise"),
        )


def jordan_pairs(A: PolynomialCoefficients, rank_tolerance: float | None = None) -> JordanPairs:
    """The Jordan pairs of A(s), as ``PolynomialMatrix.jordan_pairs``."""
    states = A.size * max(A.degree, 1)
    try:
        with short_work(states):
            return JordanPairs(A, _form_in_enough_digits(A, rank_tolerance), rank_tolerance)
    except SingularPencil:
        message, equations, coordinates = singular_message(A)
        raise SingularPolynomialMatrix(message, equations, coordinates) from None


def _form_in_enough_digits(A: PolynomialCoefficients, rank_tolerance: float | None) -> WeierstrassForm:
    """The decoupled pencil, computed in float64 where that is enough."""
    form, is_large = None, A.size * max(A.degree, 1) > PRECISE_STATES
    if is_large or (rank_tolerance != 0 and all(factors is None for factors in A.factors)):
        try:
            form = weierstrass_form(scaled_companion(A, rank_tolerance))
        except IllConditioned:
            if is_large:
                raise
        if form is not None and not is_worthwhile(_slowness(form), form.companion.state_count):
            return form
    try:
        with precise_arithmetic():
            companion = scaled_companion(A, rank_tolerance, in_float64=False)
            return weierstrass_form(companion, None if form is None else form.decisions)
    except IllConditioned:
        if form is None:
            raise
        return form


def _form_as_written(A: PolynomialCoefficients, form: WeierstrassForm) -> WeierstrassForm:
    """The decoupled pencil with zeros at s = 0 decided in precise arithmetic; where that takes long or fails, in float64 without any."""
    if form.companion.state_count <= AS_WRITTEN_STATES:
        with suppress(IllConditioned), precise_arithmetic():
            return weierstrass_form(scaled_companion(A, 0.0, in_float64=False), form.split.decisions)
    return weierstrass_form(scaled_companion(A), [*form.split.decisions, RankDecision(len(form.T), np.inf, 0.0)])


def _slowness(form: WeierstrassForm) -> float:
    """max(|s|, 1/|s|) over the zeros s other than 0 in the pencil's own unit of time: the eps of the QZ algorithm's error."""
    moduli = np.abs(eigenvalues(form.T[: form.nonzero_count, : form.nonzero_count]))
    return float(np.maximum(moduli, 1 / np.maximum(moduli, TINY)).max(initial=1.0))


def inverse_residual(pairs: JordanPairs) -> float:
    """max over test points s and rows of |A(s) X(s) - I| / (|A(s)| |X|(s)), X(s) = A(s)^-1 from the pairs (Theorem 2.8).

    |X| is the sum of what the finite zeros and the infinite part contribute to X, without regard to sign.
    """
    form = pairs.form
    companion = form.companion
    if not companion.size:
        return 0.0
    worst = 0.0
    for s in GENERIC:  # at round numbers poles may lie exactly
        A = sum(matrix * s**power for power, matrix in enumerate(companion.coefficients))
        finite, N = np.linalg.solve(s * np.eye(len(form.T)) - form.T, form.B), form.nilpotent.data
        infinite = np.linalg.solve(np.eye(len(N)) - s * N, form.B2.data)
        inverse = form.C @ finite - form.C2.data @ infinite
        parts = np.abs(form.C) @ np.abs(finite) + np.abs(form.C2.data) @ np.abs(infinite)
        size = (np.abs(A) @ parts).max(axis=1)
        worst = max(worst, float((np.abs(A @ inverse - np.eye(companion.size)).max(axis=1) / size).max()))
    return worst


# The minimal realization of a polynomial matrix H_0 + H_1 s + ... = C (I - s J)^-1 B with nilpotent J.
#
# The block Hankel matrix of H_0, H_1, ... factors into observability times reachability (Ho and Kalman). Its
# rank and the kernels of the powers of J are known from the structure at infinity: no rank is guessed here.


def minimal_nilpotent(terms: list[np.ndarray], chains: tuple[int, ...]):
    """(C, J, B) with C J^i B = H_i for the given terms H_0, H_1, ..., J strictly upper triangular, of these chain lengths."""
    r, size = len(terms[0]), sum(chains)
    if size == 0:
        return np.zeros((r, 0)), np.zeros((0, 0)), np.zeros((0, r))
    u, values, vt = scipy.linalg.svd(_hankel(terms, 0))
    if not values[size - 1]:
        raise IllConditioned("the polynomial part of A(s)^-1 spans more orders of magnitude than float64 can hold")
    root = np.sqrt(values[:size])
    observe, reach = u[:, :size] * root, root[:, None] * vt[:size]
    J = (u[:, :size] / root).T @ _hankel(terms, 1) @ (vt[:size].T / root)
    turn = _triangular_basis(J, chains)
    return observe[:r] @ turn, np.triu(turn.T @ J @ turn, 1), turn.T @ reach[:, :r]


def _hankel(terms, shift) -> np.ndarray:
    """The block matrix with H_(i + j + shift) at (i, j), zero beyond the last term."""
    depth, zero = len(terms), np.zeros_like(terms[0])
    padded = list(terms) + [zero] * (depth + shift)
    return np.block([[padded[i + j + shift] for j in range(depth)] for i in range(depth)])


def _triangular_basis(J, chains) -> np.ndarray:
    """Orthogonal basis adapted to ker J < ker J^2 < ..., in which a nilpotent J is strictly upper triangular."""
    size = len(J)
    basis, power = np.zeros((size, 0)), np.eye(size)
    for depth in range(1, max(chains) + 1):
        power = power @ J
        dimension = sum(min(depth, chain) for chain in chains)
        kernel = scipy.linalg.svd(power)[2][size - dimension :].T
        fresh = kernel - basis @ (basis.T @ kernel)
        new = dimension - basis.shape[1]
        basis = np.hstack([basis, scipy.linalg.svd(fresh, full_matrices=False)[0][:, :new]])
    return basis
