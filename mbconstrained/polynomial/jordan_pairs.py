"""The finite and the infinite Jordan pair of A(s) in the user's units, with their evidence."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg

from ..ground.checks import counted
from ..ground.display import Displayed, TextTable
from ..ground.errors import IllConditioned, InputError, Overflow, SingularPolynomialMatrix
from ..ground.notices import Evidence
from ..ground.threads import short_work
from ..ground.tolerances import AS_WRITTEN_STATES, PRECISE_STATES
from ..linalg.blocks import block_diagonalize, eigenvalues
from ..linalg.precise import is_worthwhile, precise_arithmetic
from ..linalg.rank import RankDecision
from ..linalg.staircase import GENERIC, SingularPencil
from .coefficients import PolynomialCoefficients
from .companion import multiplicity_at_zero, scaled_companion
from .decoupling import WeierstrassForm, weierstrass_form
from .structure import FiniteZero, Structure, singular_message
from .zeros import finite_zeros

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
        return scipy.linalg.block_diag(*self.blocks) if self.blocks else np.zeros((0, 0))

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
        return Structure(A.size, A.degree, self.finite.zeros, divisors)

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
        """Residuals, conditions and gaps: evidence of the accuracy of the pairs."""
        return pair_evidence(self)


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
        form = _form_in_float64(A, rank_tolerance, is_large)
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
    """The decoupled pencil with zeros at s = 0 decided in precise arithmetic; where that takes long or fails, by _form_with_none."""
    if form.companion.state_count > AS_WRITTEN_STATES:
        return _form_with_none(A, form)
    try:
        with precise_arithmetic():
            return weierstrass_form(scaled_companion(A, 0.0, in_float64=False), form.split.decisions)
    except IllConditioned:
        return _form_with_none(A, form)


def _form_with_none(A: PolynomialCoefficients, form: WeierstrassForm) -> WeierstrassForm:
    """The decoupled pencil in float64, without zeros at s = 0."""
    return weierstrass_form(scaled_companion(A), [*form.split.decisions, RankDecision(len(form.T), np.inf, 0.0)])


def _form_in_float64(A: PolynomialCoefficients, rank_tolerance: float | None, is_final: bool) -> WeierstrassForm | None:
    """The decoupled pencil in float64; None where float64 has too few digits and another arithmetic is available."""
    try:
        return weierstrass_form(scaled_companion(A, rank_tolerance))
    except IllConditioned:
        if is_final:
            raise
        return None


def _slowness(form: WeierstrassForm) -> float:
    """max(|s|, 1/|s|) over the zeros s other than 0 in the pencil's own unit of time: the eps of the QZ algorithm's error."""
    moduli = np.abs(eigenvalues(form.T[: form.nonzero_count, : form.nonzero_count]))
    return float(np.maximum(moduli, 1 / np.maximum(moduli, TINY)).max(initial=1.0))


def pair_evidence(pairs: JordanPairs) -> tuple[Evidence, ...]:
    """Residual of the finite pair, condition of the decouplings, and the gap of the rank decisions."""
    form = pairs.form
    kept = min((decision.smallest_kept for decision in form.decisions), default=np.inf)
    dropped = max((decision.largest_dropped for decision in form.decisions), default=0.0)
    return (
        Evidence("residual", inverse_residual(pairs), "largest relative residual of A(s) times the inverse made from both pairs"),
        Evidence("decoupling", pairs.finite.coupling, "largest entry of the transformation that separates the zeros"),
        Evidence("rank gap", float(kept), "smallest value kept in a rank decision, in units of the noise"),
        Evidence("rank remainder", float(dropped), "largest value dropped in a rank decision, in units of the noise"),
    )


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
