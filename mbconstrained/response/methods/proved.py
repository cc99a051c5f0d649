"""Values of small models that are accurate to ``PROVED_ACCURACY`` of their own size at each time, however the model is graded.

The float64 values are kept at the times at which a bound of their error (``response.methods.defect``) allows it; all others, and all
values of motions of many radians, come from the sums of refined modes (``response.methods.refined``), and those that these do not prove
from the exact engine, poles and residues of A(s)^-1 in balls, as many digits as the value at that time needs. The choice depends on the
problem and on the times alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import real_array, real_number, whole_number
from ...ground.errors import SingularPolynomialMatrix
from ...ground.tolerances import CANCELLED_ROW, EPS, PROVED_ACCURACY
from ...signals.bohl import BohlFunction
from ..events import Event, without_zeros
from ..flow import LATER
from .defect import Defect, are_right
from .refined import RefinedDefect

if TYPE_CHECKING:
    from ...exact.enclosure.exact_response import ExactResponse
    from .reduced_solution import FlowFunction

#: At more times than these the exact engine takes too long: a minute for ten states. The error estimate holds without it, too.
MOST_TIMES = 50_000

#: Sums of modes without first moments of forces are kept where they are surely right to this, and where the first moments are no better.
KEPT_ACCURACY = PROVED_ACCURACY / 3

#: Sums of refined modes are as much better as their rounding to float64 may take.
REFINED_ACCURACY = PROVED_ACCURACY - 2 * EPS

#: Times at which a row that float64 loses is zero before it counts as zero.
SAMPLED_ZEROS = 8

#: From so many radians of the fastest mode on, phases in float64 are not right where all coordinates are small at once.
MANY_RADIANS = 64.0

#: The exact engine is asked for so many times at once.
AT_ONCE = 2048


class ProvedFunction(BohlFunction):
    """matrix @ x^(order) of a small model.

    Attributes:
        rough: the function in float64; any Bohl function without a defect, which bounds functions of reduced equations only.
        exact: returns the exact response that x belongs to.
        order: order of the derivative.
        matrix: shape (p, r); None for x itself.
        finite_count: the number of finite zeros of A(s).
        defect: bounds the error of the float64 values; None where nothing does.
        refined: the same of sums of refined modes.
    """

    rough: FlowFunction
    exact: Callable[[], ExactResponse]
    finite_count: int
    order: int
    matrix: np.ndarray | None
    defect: Defect | None
    refined: RefinedDefect | None

    def __init__(self, rough: BohlFunction, exact, finite_count: int, defect=None, refined=None, order: int = 0, matrix=None):
        self.__dict__.update(rough=rough, exact=exact, finite_count=finite_count, defect=defect, refined=refined)
        self.__dict__.update(order=order, matrix=matrix)

    coefficients = property(attrgetter("rough.coefficients"))
    blocks = property(attrgetter("rough.blocks"))
    start = property(attrgetter("rough.start"))
    size = property(attrgetter("rough.size"))
    state_count = property(attrgetter("rough.state_count"))
    summed_from = property(attrgetter("rough.summed_from"))

    @property
    def is_bounded(self) -> bool:
        """Whether the errors of the float64 values are bounded with respect to the exact data."""
        return self.defect is not None and self.defect.has_exact_zeros

    @property
    def is_provable(self) -> bool:
        """Whether the exact data determine a motion with the same number of states, not one caused by rounding errors."""
        if self.is_bounded:
            return True
        try:
            return self.exact().matrix.determinant.degree() == self.finite_count
        except SingularPolynomialMatrix:
            return False

    def _values(self, times: np.ndarray) -> np.ndarray:
        return self.evaluated(times)[0]

    def evaluated(self, times: np.ndarray, accuracy: float = PROVED_ACCURACY) -> tuple[np.ndarray, np.ndarray]:
        """Values, shape (p, T), and a bound of the largest error at each time, shape (T,); infinite where none is known.

        One bound serves many times where it is within this accuracy relative to the values; with 0 each time has its own, which is closer.
        """
        if self.defect is None or not self.size:
            if len(times) <= MOST_TIMES and self.is_provable:
                return self.proved(times)
            return self.rough(times), np.full(len(times), np.inf)
        refining = self.defect.flow.refined is not None
        bounds = self.refined if refining else self.defect
        covered = None if bounds.is_whole else bounds.covers(times)
        if covered is not None and not covered.all() and np.count_nonzero(~covered) <= MOST_TIMES and self.is_provable:
            values, errors = np.empty((self.size, len(times))), np.zeros(len(times))
            values[:, ~covered], errors[~covered] = self.proved(times[~covered])
            if covered.any():
                values[:, covered], errors[covered] = self.evaluated(times[covered], accuracy)
            return values, errors
        often = refining or self._turns_often(times)
        if often:
            values, errors = self._by_refined_modes(times, self.refined.rounded, accuracy)
        else:
            values, errors = self._sums_of_modes(times, accuracy)
        doubtful = np.flatnonzero(~are_right(values, errors))
        if not refining:
            doubtful = self._begun(values, errors, times, doubtful)
        if len(doubtful) and self.refined is not None and self.refined.refined is not None:
            better, bound = self._by_refined_modes(
                times[doubtful], self.refined.doubled if often else self.refined.proved, accuracy
            )
            sure = are_right(better, bound)
            values[:, doubtful[sure]], errors[doubtful[sure]] = better[:, sure], bound[sure]
            doubtful = doubtful[~sure]
        if 0 < len(doubtful) <= MOST_TIMES and self.is_provable:
            values[:, doubtful], errors[doubtful] = self.proved(times[doubtful])
        return values, errors

    def _turns_often(self, times: np.ndarray) -> bool:
        """Whether phases turn so often that refined modes are needed at many times, where there are such."""
        if not self.defect.is_one_piece or self.defect.flow.modal_rate * times.max(initial=0.0) < MANY_RADIANS:
            return False
        return self.refined is not None and self.refined.refined is not None

    def _sums_of_modes(self, times: np.ndarray, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """Values and bounds of their errors."""
        if (whole := self._in_whole_pieces) is None:
            values = self.rough.by_modes(times)
            return values, self._bounds(values, times, accuracy)
        values = whole.rough.by_modes(times)
        errors = whole._bounds(values, times, min(accuracy, KEPT_ACCURACY))
        if len(places := np.flatnonzero(~are_right(values, errors, KEPT_ACCURACY))):
            better = self.rough.by_modes(times[places])
            bounds = self._bounds(better, times[places], accuracy)
            sure = are_right(better, bounds)
            values[:, places[sure]], errors[places[sure]] = better[:, sure], bounds[sure]
        return values, errors

    @cached_property
    def _in_whole_pieces(self) -> ProvedFunction | None:
        """The function without first moments of later forces, which take longer than the rest; None where no force is delayed."""
        if (whole := self.defect.in_whole_pieces) is None:
            return None
        rough = self.rough.of(whole.flow)
        return ProvedFunction(rough, self.exact, self.finite_count, whole, None, self.order, self.matrix)

    def _bounds(self, values: np.ndarray, times: np.ndarray, accuracy: float) -> np.ndarray:
        """Bounds of the errors of sums of modes, one for all times where it is within this accuracy."""
        return self.defect.errors(self.rough.place, self.rough.order, times, accuracy * np.abs(values).max(axis=0))

    def _begun(self, values: np.ndarray, errors: np.ndarray, times: np.ndarray, doubtful: np.ndarray) -> np.ndarray:
        """Replace values at the first doubtful times by the Taylor series, and return the indices that remain doubtful."""
        if not len(doubtful):
            return doubtful
        flow = self.defect.flow
        if not flow.jumping and flow.impulsive is None and self._starts_at_zero:
            at_start = doubtful[times[doubtful] == 0]
            values[:, at_start] = errors[at_start] = 0.0
            doubtful = doubtful[times[doubtful] > 0]
        if not len(doubtful) or times[doubtful].min() * flow.modal_rate >= LATER:
            return doubtful
        start = flow.taylor_start(modal=True)
        early = doubtful[times[doubtful] < start.end]
        if not len(early):
            return doubtful
        begun = values[:, early]
        replace(start, bounds=None).replace(begun, times[early], self.rough.output, lambda: np.zeros(0))
        values[:, early] = begun
        errors[early] = self.defect.of_series(self.rough.place, self.rough.order, times[early])
        return np.setdiff1d(doubtful, early[are_right(begun, errors[early])])

    @property
    def _starts_at_zero(self) -> bool:
        """Whether all terms of the value at 0+ are zero: a velocity given as 0 is so only where the coordinate has mass."""
        terms = np.abs(self.rough.flow.start_with_force)
        for _ in range(self.order):
            terms = abs(self.rough.flow.generator) @ terms
        return not (abs(self.rough.place) @ terms).any()

    def _by_refined_modes(self, times: np.ndarray, sums: Callable, accuracy: float) -> tuple[np.ndarray, np.ndarray]:
        """Sums of refined modes, and bounds of their errors, with that of their rounding to float64."""
        with np.errstate(all="ignore"):
            values, errors = sums(self._through, self.order, times, min(accuracy, REFINED_ACCURACY))
            return values, errors + 2 * EPS * np.abs(values).max(axis=0, initial=0.0)

    def proved(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values by the exact engine, shape (p, T), with bounds of their errors, shape (T,)."""
        exact = self.exact()
        parts = [exact.rounded(times[k : k + AT_ONCE], self.order, self.matrix) for k in range(0, max(len(times), 1), AT_ONCE)]
        return np.hstack([values for values, _ in parts]), np.hstack([errors for _, errors in parts]).max(axis=0, initial=0.0)

    def _with(self, rough: BohlFunction, order: int, matrix) -> ProvedFunction:
        return ProvedFunction(rough, self.exact, self.finite_count, self.defect, self.refined, order, matrix)

    @cached_property
    def _through(self) -> np.ndarray:
        if self.matrix is not None:
            return self.matrix
        return np.eye(self.size) if self.refined is None else self.refined.identity

    def derivative(self, order: int = 1) -> BohlFunction:
        """The classical derivative."""
        order = whole_number(order, "order")
        return self._with(self.rough.derivative(order), self.order + order, self.matrix) if order else self

    def mapped(self, matrix) -> BohlFunction:
        """matrix @ y(t), matrix of shape (p, r)."""
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        if self.matrix is not None:  # a product of matrices would be rounded
            return self.rough.mapped(matrix)
        return self._with(self.rough.mapped(matrix), self.order, matrix)

    def differential(self, *matrices: np.ndarray) -> BohlFunction:
        """matrices[0] @ f + matrices[1] @ f' + ...; rows in which float64 cancels, such as forces of stiff springs, are proved."""
        rough = super().differential(*matrices)
        size, coefficients = np.abs(self.restarts.states).max(axis=1, initial=0.0), self.coefficients
        terms = np.zeros(rough.coefficients.shape)
        for matrix in matrices:
            terms, coefficients = terms + np.abs(matrix) @ np.abs(coefficients), self._times_generator(coefficients)
        lost, largest = EPS * (terms @ size), (np.abs(rough.coefficients) * size).max(axis=1, initial=0.0)
        if not (cancelled := lost > CANCELLED_ROW * largest).any():
            return rough
        return ProvedCombination(rough, self, matrices, cancelled)

    def rows(self, indices) -> BohlFunction:
        indices = np.asarray(indices, dtype=int)
        return self._with(self.rough.rows(indices), self.order, self._through[indices])

    def __mul__(self, factor: float) -> BohlFunction:
        factor = real_number(factor, "factor")
        return self.mapped(factor * np.eye(self.size)) if self.matrix is None else self.rough * factor

    __rmul__ = __mul__

    def __add__(self, other: BohlFunction) -> BohlFunction:
        return self.rough + (other.rough if isinstance(other, ProvedFunction) else other)

    __radd__ = __add__


class ProvedCombination(BohlFunction):
    """matrices[0] @ f + matrices[1] @ f' + ... of a proved function, the cancelled rows by the exact engine, each with its own digits.

    Attributes:
        rough: the sum in float64.
        of: f.
        matrices: each of shape (p, r).
        cancelled: which rows float64 does not resolve, shape (p,).
    """

    rough: BohlFunction
    of: ProvedFunction
    matrices: tuple[np.ndarray, ...]
    cancelled: np.ndarray

    def __init__(self, rough: BohlFunction, of: ProvedFunction, matrices, cancelled: np.ndarray):
        self.__dict__.update(rough=rough, of=of, matrices=tuple(matrices), cancelled=cancelled)

    coefficients = property(attrgetter("rough.coefficients"))
    blocks = property(attrgetter("rough.blocks"))
    start = property(attrgetter("rough.start"))

    def _values(self, times: np.ndarray) -> np.ndarray:
        values = self.rough._values(times)
        if len(times) <= MOST_TIMES and self.of.is_provable:
            ordered = np.sort(times)
            last = np.flatnonzero(
                np.diff(self.restarts.located(ordered)[0], append=-1)
            )  # of each piece, where a row that does not vanish has begun to move
            some = ordered[np.unique([*range(0, len(times), len(times) // SAMPLED_ZEROS + 1), *last])]
            for row in np.flatnonzero(self.cancelled).tolist():  # rows that vanish by symmetry are zero there, and everywhere
                values[row] = self._proved(row, times) if self._proved(row, some).any() else 0.0
        return values

    def _proved(self, row: int, times: np.ndarray) -> np.ndarray:
        parts = enumerate(matrix[[row]] @ self.of._through for matrix in self.matrices)
        terms = [self.of._with(self.of.rough, self.of.order + k, part).proved(times)[0] for k, part in parts if part.any()]
        return sum(terms, np.zeros((1, len(times))))[0]

    def derivative(self, order: int = 1) -> BohlFunction:
        none = (np.zeros_like(self.matrices[0]),) * whole_number(order, "order")
        return ProvedCombination(self.rough.derivative(order), self.of, (*none, *self.matrices), self.cancelled)

    def mapped(self, matrix) -> BohlFunction:
        matrix = real_array(matrix, "matrix", shape=(None, self.size))
        return self.of.differential(*(matrix @ own for own in self.matrices))

    def rows(self, indices) -> BohlFunction:
        indices = np.asarray(indices, dtype=int)
        return ProvedCombination(
            self.rough.rows(indices), self.of, [own[indices] for own in self.matrices], self.cancelled[indices]
        )

    def __mul__(self, factor: float) -> BohlFunction:
        return self.mapped(real_number(factor, "factor") * np.eye(self.size))

    __rmul__ = __mul__


def proved_event(exact: ExactResponse, event: Event, initial: np.ndarray) -> Event:
    """An event with the exact jumps and impulses, where float64 has some: rounded starts do not decide which values jump."""
    jump, impulses = exact.event(event.time)
    if event.time:
        before = np.array([exact.rounded(np.array([event.time]), order)[0][:, 0] for order in range(len(jump))]) - jump
    else:
        before = initial
    jump[(event.jump == 0) & (np.abs(jump) <= EPS**0.5 * (np.abs(before) + np.abs(before + jump)))] = 0.0
    kept = [np.where(own != 0, true, 0.0) for own, true in zip(event.impulses, impulses)]
    return Event(event.time, jump, without_zeros(kept))
