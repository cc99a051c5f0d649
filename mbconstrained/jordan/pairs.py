"""The finite and the infinite Jordan pair of A(s) in the user's units, with their evidence."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.linalg

from ..errors import IllConditioned, InputError, Overflow, SingularPolynomialMatrix
from ..linalg.blocks import block_diagonalize, eigenvalues
from ..linalg.precise import MOST_STATES, is_worthwhile, precise_arithmetic
from ..linalg.rank import RankDecision
from ..linalg.staircase import SingularPencil
from ..linalg.threads import short_work
from ..polynomial.companion import multiplicity_at_zero, scaled_companion
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.regularity import singular_message
from ..polynomial.structure import FiniteZero, Structure
from .evidence import Evidence, pair_evidence
from .minimal import minimal_nilpotent
from .weierstrass import WeierstrassForm, weierstrass_form
from .zeros import finite_zeros

#: Of so many states the pairs of the data as they are written are computed in precise arithmetic: it takes half a second.
MOST_AS_WRITTEN = 24

#: The least normal number of float64.
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class FinitePair:
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

    @cached_property
    def J(self) -> np.ndarray:
        """Shape (n, n)."""
        return scipy.linalg.block_diag(*self.blocks) if self.blocks else np.zeros((0, 0))

    @cached_property
    def zeros(self) -> tuple[FiniteZero, ...]:
        """The zeros with their multiplicities, ascending by modulus; of each complex pair the one above the real axis."""
        return finite_zeros(self.form)


@dataclass(frozen=True)
class InfinitePair:
    """The polynomial part of A(s)^-1 as C (I - s J)^-1 B, minimal, J nilpotent (Theorem 2.8, sizes corrected).

    Attributes:
        C: shape (r, mu).  J: shape (mu, mu), in s.  B: shape (mu, r).
    """

    C: np.ndarray
    J: np.ndarray
    B: np.ndarray


@dataclass(frozen=True)
class JordanPairs:
    """Both pairs of a regular A(s); what is not asked for is not computed.

    Attributes:
        polynomial_matrix: A(s).
        form: the decoupled companion pencil that both are read from.
        rank_tolerance: the one asked for, None for the rounding noise of the data.
    """

    polynomial_matrix: PolynomialMatrix
    form: WeierstrassForm
    rank_tolerance: float | None = None

    @cached_property
    def finite(self) -> FinitePair:
        """(C, J, B) of the finite zeros."""
        form, scaling = self.form, self.form.companion.scaling
        parts = block_diagonalize(form.T)
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
        """The pairs of the data taken exactly, as far as zeros at s = 0 go; None where nothing can have been lost there.

        A stiffness of the size of rounding beside larger ones is that of a free body, or of one held softly: the data do not
        tell. What was taken for zero at infinity stays so.
        """
        form, A, taken = self.form, self.polynomial_matrix, sum(self.form.zero_divisors)
        if self.rank_tolerance is not None or not taken or not form.companion.known.noise.any():
            return None
        dropped = any(decision.largest_dropped for decision in form.decisions)  # the rounding of float64 itself, if not more
        if multiplicity_at_zero(A) >= taken and not (dropped and form.companion.state_count <= MOST_AS_WRITTEN):
            return None
        return JordanPairs(A, _form_as_written(A, form), 0.0)

    @cached_property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps that tell how far the pairs can be trusted."""
        return pair_evidence(self)


def jordan_pairs(A: PolynomialMatrix, rank_tolerance: float | None = None) -> JordanPairs:
    """The pairs of A(s); see ``PolynomialMatrix.jordan_pairs``.

    Raises:
        SingularPolynomialMatrix: det A(s) = 0 for every s; names the dependent equations and free coordinates.
    """
    states = A.size * max(A.degree, 1)
    try:
        with short_work(states):
            return JordanPairs(A, _form_in_enough_digits(A, rank_tolerance), rank_tolerance)
    except SingularPencil:
        message, equations, coordinates = singular_message(A)
        raise SingularPolynomialMatrix(message, equations, coordinates) from None


def _form_in_enough_digits(A: PolynomialMatrix, rank_tolerance: float | None) -> WeierstrassForm:
    """The decoupled pencil, computed in float64 where that is enough."""
    states, form = A.size * max(A.degree, 1), None
    exact = rank_tolerance == 0 or any(factors is not None for factors in A.factors)
    if not exact or states > MOST_STATES:
        form = _form_in_float64(A, rank_tolerance, refuse=states > MOST_STATES)
        if form is not None and not is_worthwhile(_slowness(form), states):
            return form
    try:
        with precise_arithmetic():
            companion = scaled_companion(A, rank_tolerance, in_float64=False)
            return weierstrass_form(companion, None if form is None else form.decisions)
    except IllConditioned:
        if form is None:
            raise
        return form


def _form_as_written(A: PolynomialMatrix, form: WeierstrassForm) -> WeierstrassForm:
    """The decoupled pencil, zeros at s = 0 decided in precise arithmetic; where that takes long or fails, by _form_with_none."""
    if form.companion.state_count > MOST_AS_WRITTEN:
        return _form_with_none(A, form)
    try:
        with precise_arithmetic():
            return weierstrass_form(scaled_companion(A, 0.0, in_float64=False), form.split.decisions)
    except IllConditioned:
        return _form_with_none(A, form)


def _form_with_none(A: PolynomialMatrix, form: WeierstrassForm) -> WeierstrassForm:
    """The decoupled pencil in float64, nothing counted as a zero at s = 0."""
    return weierstrass_form(scaled_companion(A), [*form.split.decisions, RankDecision(len(form.T), np.inf, 0.0)])


def _form_in_float64(A: PolynomialMatrix, rank_tolerance: float | None, refuse: bool) -> WeierstrassForm | None:
    try:
        return weierstrass_form(scaled_companion(A, rank_tolerance))
    except IllConditioned:
        if refuse:
            raise
        return None


def _slowness(form: WeierstrassForm) -> float:
    """max(|s|, 1/|s|) over the zeros s other than 0 in the pencil's own unit of time: the eps of the QZ algorithm's error."""
    moduli = np.abs(eigenvalues(form.T[: form.nonzero_count, : form.nonzero_count]))
    return float(np.maximum(moduli, 1 / np.maximum(moduli, TINY)).max(initial=1.0))
