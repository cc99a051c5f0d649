"""The structure of an A(s) that is not regular, in floating point: minimal indices and kernels from the Kronecker form of its companion pencil.

The companion pencil of an m x n matrix of degree q is a strong linearization: it has the elementary divisors of A(s), finite and infinite,
and the left minimal indices; the right ones are greater by q - 1 (De Teran, Dopico and Mackey 2009, and 2012 for m != n).
Staircases of the pencil and of that of A(s)^T give both kernels, and the infinite divisors twice. What neither takes away is regular, and
has the finite zeros.
"""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.errors import OUT_OF_RANGE, IllConditioned, SingularPolynomialMatrix, within_float64
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import PRECISE_KRONECKER_STATES, SHORT_BITS, noise_of
from ..linalg.precise import floats, precise_arithmetic
from ..linalg.rank import RankDecision
from ..linalg.staircase import RightStaircase, right_staircase
from .coefficients import PolynomialCoefficients
from .decoupling import ScaledCompanion, scaled_companion
from .jordan_pairs import jordan_pairs
from .structure import FiniteZero, PolynomialVector, Structure


def kronecker_structure(A: PolynomialCoefficients, rank_tolerance: float | None = None) -> Structure:
    """The structure of any A(s), as ``PolynomialMatrix.structure``.

    By elimination first, which keeps small entries and exact zeros; where its noise grows too much, by orthogonal matrices. Where both
    leave a doubt, whole numbers and other short ones are taken exactly, and so are data of which that confirms the decision.
    """
    in_float64 = rank_tolerance != 0 and all(factors is None for factors in A.factors)
    form, doubt = _form(A, rank_tolerance, in_float64), ""
    if in_float64 and not (form and form.is_clear):
        form = _form(A, rank_tolerance, by_rotation=True) or form
    is_small = max(A.shape) * max(A.degree, 1) <= PRECISE_KRONECKER_STATES
    if in_float64 and not (form and form.is_clear) and rank_tolerance is None and is_small and not A.is_uncertain:
        written = _form(A, 0.0, in_float64=False)
        if written and (_is_short(A.coefficients) or (form and written.indices == form.indices)):
            form = written
        elif written:
            doubt = "; taken exactly, the data have " + written.text
    if form is None:
        raise IllConditioned(
            "the equations are so close to other numbers of dependent ones that float64 cannot determine which coordinates are free; write them "
            "in coordinates closer to the machine's own, or ask mb.exact.structure(A) for the structure of the exact numbers"
        )
    doubts = (
        ()
        if form.is_clear
        else (Notice(NoticeKind.RANK, f"rounding errors of the data decide: {form.text}{doubt}", doubtful=True),)
    )
    with within_float64():
        return form.structure(A, doubts)


def _is_short(coefficients: np.ndarray) -> bool:
    """Whether all numbers are a few digits times a power of two, as whole numbers are and rounded results are not."""
    mantissas, _ = np.frexp(coefficients)
    return not np.mod(np.ldexp(mantissas, SHORT_BITS), 1).any()


def _form(A: PolynomialCoefficients, rank_tolerance: float | None, in_float64=True, by_rotation=False) -> KroneckerForm | None:
    """The Kronecker form; None where staircases disagree, or leave the range of float64."""
    with suppress(IllConditioned), within_float64(), nullcontext() if in_float64 else precise_arithmetic():
        companion = scaled_companion(A, rank_tolerance, in_float64)
        right, left = (right_staircase(*each.pencil, by_rotation) for each in (companion, companion.transposed))
        form = KroneckerForm(companion, right, left, right_staircase(right.E.T, right.F.T, by_rotation))
        return form if form.is_consistent else None
    return None


@dataclass(frozen=True, eq=False)
class KroneckerForm:
    """The Kronecker form of a scaled companion pencil.

    Attributes:
        right, left: staircases of the pencils of A(s) and of A(s)^T.
        rest: the staircase of what ``right`` leaves, transposed.
    """

    companion: ScaledCompanion
    right: RightStaircase
    left: RightStaircase
    rest: RightStaircase

    @property
    def indices(self) -> tuple[tuple[int, ...], ...]:
        """Right and left minimal indices of A(s), and degrees of infinite elementary divisors of the pencil."""
        right, left = (tuple(index + 1 - self.companion.grade for index in side.indices) for side in (self.right, self.left))
        return right, left, self.right.divisors

    @property
    def text(self) -> str:
        """The minimal indices as text."""
        right, left = (", ".join(map(str, indices)) or "none" for indices in self.indices[:2])
        return f"right minimal indices {right}, left ones {left}"

    @property
    def decisions(self) -> tuple[RankDecision, ...]:
        """All rank decisions."""
        return self.right.decisions + self.left.decisions + self.rest.decisions

    @property
    def is_consistent(self) -> bool:
        """Whether the staircases agree with each other."""
        right, left, divisors = self.indices
        E = self.rest.E.data
        return (
            (left, divisors, ()) == (self.rest.indices, self.left.divisors, self.rest.divisors)
            and min((*right, *left), default=0) >= 0
            and E.shape[0] == E.shape[1]
        )

    @property
    def is_clear(self) -> bool:
        """Whether no decision is near its bound."""
        return all(decision.clear for decision in self.decisions)

    @cached_property
    def finite_zeros(self) -> tuple[FiniteZero, ...]:
        """Zeros of the regular part that is left."""
        E, F = (part.T.rounded_to_float() for part in (self.rest.E, self.rest.F))
        pencil = PolynomialCoefficients([-F.data, E.data], uncertainty=[F.noise, E.noise])
        try:
            zeros = jordan_pairs(pencil).structure.finite_zeros
        except SingularPolynomialMatrix:
            raise IllConditioned(
                "float64 cannot tell the finite zeros of A(s); mb.exact.structure(A) does, of the exact numbers"
            ) from None
        return tuple(
            FiniteZero(
                complex(self.companion.scaling.time * zero.value), zero.multiplicity, zero.partial_multiplicities, zero.clear
            )
            for zero in zeros
        )

    def structure(self, A: PolynomialCoefficients, doubts: tuple[Notice, ...]) -> Structure:
        """The structure of A(s) in its own units."""
        divisors = [degree - (A.degree == 0) for degree in self.right.divisors]  # the pencil declared one power more
        rank = A.shape[1] - len(self.right.vectors)
        return Structure(
            shape=A.shape,
            degree=A.degree,
            finite_zeros=self.finite_zeros,
            infinite_divisors=(0,) * (rank - len(divisors)) + tuple(divisors),
            right_kernel=_kernel(self.right, self.companion, A.coordinates),
            left_kernel=_kernel(self.left, self.companion.transposed, A.equations),
            doubts=doubts,
        )


def _kernel(staircase: RightStaircase, companion: ScaledCompanion, names: tuple[str, ...]) -> tuple[PolynomialVector, ...]:
    """Vectors of A(s): the first rows of those of the companion pencil, whose states are x, x', x'', ..."""
    vectors, units = [], companion.scaling.columns
    for each in staircase.vectors:
        degree = each.data.shape[1] - companion.grade
        own = each[: len(units), : degree + 1]  # entries within their noise are zero where that does not show in the residual
        choices = [(floats(array).T, _residual(companion.coefficients, floats(array).T)) for array in (own.cleaned(), own.data)]
        v, residual = choices[choices[0][1] > noise_of(1.0, len(units))]
        in_units = units * v * companion.scaling.time ** -np.arange(degree + 1.0)[:, None]
        if not (np.isfinite(in_units).all() and in_units.any() and np.isfinite(residual)):
            raise IllConditioned(OUT_OF_RANGE)
        vectors.append(PolynomialVector.of(in_units, names, residual))
        if not np.isfinite(vectors[-1].coefficients).all():
            raise IllConditioned(OUT_OF_RANGE)
    return tuple(vectors)


def _residual(coefficients: np.ndarray, v: np.ndarray) -> float:
    """The largest coefficient of A(s) v(s), each row relative to the largest sum of the terms of a power of s."""
    value, size = np.zeros((2, len(coefficients) + len(v) - 1, coefficients.shape[1]))
    for power, matrix in enumerate(coefficients):
        value[power : power + len(v)] += v @ matrix.T
        size[power : power + len(v)] += np.abs(v) @ np.abs(matrix).T
    largest = size.max(axis=0)
    return float((np.abs(value).max(axis=0) / np.where(largest > 0, largest, 1.0)).max(initial=0.0))
