"""Two-point boundary values: x given partly at 0+ and partly at T-, by the finite Jordan pair.

    x(t) = x_p(t) + C e^{J t} c

with x_p from rest under the force. Of a growing block b of J the unknown is d_b = e^{J_b T} c_b, its states at the end, of the others
c_b: no entry of the equations for them grows with T, so that growing and decaying motions are determined equally well. With C J^k and
e^{J T} the conditions are linear equations, whose rank is decided by the gap of their singular values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import scipy

from ..ground.checks import counted, evaluation_times, listed, nearest, real_array, real_number, whole_number
from ..ground.errors import ContradictoryConstraints, InputError, Overflow, within_float64
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import CLEAR_KEPT, EPS, NOISE_SAFETY, UNCLEAR_ERROR
from ..linalg.blocks import block_slices
from ..linalg.exponential import block_states
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.problem import Problem, checked_force, checked_matrix
from ..response.response import Response
from ..signals.bohl import BohlFunction
from .motion import FunctionSum, Motion
from .system import MechanicalSystem

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactBoundary

#: The words for derivatives of x, in which values are given.
ORDERS = ("displacement", "velocity", "acceleration")

#: Growing motions over more than e^{this} leave the range of float64.
LARGEST_GROWTH = 690.0


class BoundaryValue(NamedTuple):
    """The value of one coordinate or of its derivative at one end."""

    coordinate: int  # its place
    order: int  # 0: x, 1: x', ...
    at_end: bool  # at T- instead of 0+
    value: float  # the given value
    text: str  # as messages name it


@dataclass(frozen=True, eq=False)
class Boundary:
    """The conditions of a two-point problem, and their evidence.

    Attributes:
        duration: T in s.
        conditions: the given values.
        free_motion: C e^{J t} c.
        undetermined: free motions that satisfy all conditions with zero values, one each that may be added; usually none.
        residual: the largest difference from a given value, relative to the values of its derivative of x at both ends.
        condition: the condition number of the scaled equations on their rank.
        rank: how many conditions are independent.
        singular_values: of the scaled equations, descending.
        noise: the bound below which a singular value is zero.
        error: estimate of the relative error at the ends.
        notices: what is undetermined, and decisions without a clear gap.
    """

    duration: float
    conditions: tuple[BoundaryValue, ...]
    free_motion: BohlFunction
    undetermined: tuple[BohlFunction, ...]
    residual: float
    condition: float
    rank: int
    singular_values: np.ndarray
    noise: float
    error: float
    notices: tuple[Notice, ...]


@dataclass(frozen=True, repr=False, eq=False)
class BoundaryResponse(Response):
    """A ``Response`` of which values at both ends were given; t = 0 means 0+. Beyond T it goes on as the same solution.

    Attributes:
        boundary: the conditions with their evidence.
        forced: the solution from rest under the force.
    """

    boundary: Boundary
    forced: Response

    @cached_property
    def function(self) -> BohlFunction:
        """x_p(t) + C e^{J t} c."""
        return FunctionSum((self.forced.function, self.boundary.free_motion))

    @cached_property
    def exact(self) -> ExactBoundary:
        """The exact solution for the same data and boundary values taken as exact numbers; as many of these as finite zeros."""
        from ..exact.enclosure.exact_response import ExactValue, with_boundary_values

        values = [ExactValue(*one[:4]) for one in self.boundary.conditions]
        return with_boundary_values(super().exact, values, self.boundary.duration)

    def error_estimate(self, times, *, order: int = 0) -> float:
        """Return an estimate of max |error| / max |value| over the given times, from the conditions and the forced motion.

        Args:
            times: in s, a number or shape (T,).
            order: order of the derivative.

        Returns:
            Relative to the largest value at these times.
        """
        order, times = whole_number(order, "order"), np.atleast_1d(evaluation_times(times))
        parts = [
            one.derivative(order) if order else one for one in (self.function, self.forced.function, self.boundary.free_motion)
        ]
        total, *summands = (float(np.abs(one(times)).max(initial=0.0)) for one in parts)
        if not total:
            return self.boundary.error
        # the error of c, and that of a forced motion that grows and is cancelled, relative to the values
        return max(self.boundary.error, self.forced.error_estimate(times)) * max(1.0, max(summands) / total)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the boundary values and of the motion."""
        return (*self.boundary.notices, *super().notices)


@dataclass(frozen=True, repr=False, eq=False)
class BoundaryMotion(BoundaryResponse, Motion):
    """A ``Motion`` of which values at both ends were given: a ``BoundaryResponse`` with velocities, reactions and energy."""

    def error_estimate(
        self, times, of: Literal["displacement", "velocity", "acceleration", "reaction"] = "displacement", *, order: int = 0
    ) -> float:
        """Return an estimate of max |error| / max |value| over the given times, from the conditions and the forced motion.

        Args:
            times: in s, a number or shape (T,).
            of: "displacement", "velocity", "acceleration" or "reaction".
            order: order of the derivative.

        Returns:
            Relative to the largest value at these times.
        """
        if of not in ORDERS:
            return Motion.error_estimate(self, times, of, order=order)
        return super().error_estimate(times, order=whole_number(order, "order") + ORDERS.index(of))


def boundary_solve(
    A, start: Mapping | None = None, end: Mapping | None = None, duration: float | None = None, force=None
) -> BoundaryResponse | BoundaryMotion:
    """Solve A(d/dt) x = f with x given partly at 0 and partly at the time T (two-point boundary values).

        x(t) = x_p(t) + C e^{J t} c

    with the finite Jordan pair (C, J) and x_p from rest under the force. The conditions are linear equations for c; growing motions are
    measured at the end T, so that they stay well conditioned for long T. The values are those at 0+ and at T-: jumps and impulses of a
    force at 0 come before the first, those at T after the second, and are reported in the solution as ever.

    As many independent conditions as there are finite zeros (``A.jordan_pairs().finite``) determine one solution. With fewer, and where T
    is a conjugate point (half a period of an oscillator with x given at both ends), the free combination is named in a notice, and of all
    solutions that with the least values at both ends is returned (least sum of squares of all x and T x' there).

    Args:
        A: a ``MechanicalSystem`` of arrays or a ``PolynomialMatrix``.
        start: values at 0+ by name of the coordinate, ``{"x1": 0.0}``; velocities as in
            ``{"displacement": {"x1": 0.0}, "velocity": {"x2": 1.0}}``, each also as a vector of all coordinates. What is not given is free.
        end: values at T-, in the same form.
        duration: T in s.
        force: f as in ``mbconstrained.solve``, or in ``system.solve`` of a mechanical system, in addition to its own.

    Returns:
        A ``Response``, of a mechanical system a ``Motion``, with ``.boundary``: ``.condition``, ``.residual``, ``.rank``,
        ``.singular_values``, ``.undetermined``.

    Raises:
        InputError: names that do not exist, values that are not finite, no duration.
        ContradictoryConstraints: no motion has these values; the text names the combination of them that contradicts.
        SingularPolynomialMatrix: det A(s) = 0 for every s.
        Overflow: a motion grows over the duration beyond the range of float64.

    Sources: Ascher, Mattheij and Russell, Numerical Solution of Boundary Value Problems for Ordinary Differential Equations, SIAM 1995,
    sections 3.1 and 4.2 (dichotomy: growing motions belong to the end).

    >>> oscillator = MechanicalSystem([[1.0]], stiffness=[[4.0]])
    >>> x = boundary_solve(oscillator, start={"x1": 0.0}, end={"x1": 1.0}, duration=0.5)
    >>> bool(np.isclose(x(0.25)[0], np.sin(0.5) / np.sin(1.0)))
    True
    """
    if duration is None:
        raise InputError("duration: give the time T in s between start and end")
    T = real_number(duration, "duration", positive=True)
    if isinstance(A, MechanicalSystem):
        if A.is_sparse:
            raise InputError("A: boundary values need all modes; give the matrices of the system as arrays")
        applied, form = A._applied(force), A.constrained_form()
        matrix, right_side = form.polynomial_matrix, form.force(applied)
    else:
        matrix = checked_matrix(A)
        right_side = checked_force(force, matrix.size, matrix)
    conditions = (*_values(matrix, start, "start", False), *_values(matrix, end, "end", True))
    with within_float64():
        forced = Response._solved(Problem.checked(matrix, None, right_side))
        boundary = _solved(matrix, forced, conditions, T)
    function = FunctionSum((forced.function, boundary.free_motion))
    # values at 0+ are consistent; impulses at 0 would act on them a second time, so that those of the free motion are given then
    source = boundary.free_motion if right_side.impulses else function
    initial = np.array([(source.derivative(k) if k else source)(0.0) for k in range(matrix.degree)]).reshape(
        matrix.degree, matrix.size
    )
    x = Response._solved(Problem.checked(matrix, initial, right_side))
    if isinstance(A, MechanicalSystem):
        return BoundaryMotion(x.problem, x.solution, A, applied, boundary, forced)
    return BoundaryResponse(x.problem, x.solution, boundary, forced)


def values_by_order(given, names: Sequence[str], orders: Sequence[str], what: str) -> dict[str, dict[str, float]]:
    """Values at one end by the words for their orders and by name; those by name alone are of the first order."""
    by_order: dict[str, dict[str, float]] = {word: {} for word in orders}
    if given is None:
        return by_order
    if not isinstance(given, Mapping):
        raise InputError(f'{what}: found {type(given).__name__}; expected values by name, such as {{"{names[0]}": 0.0}}')
    for key, entry in given.items():
        if key in orders and (isinstance(entry, Mapping) or np.ndim(entry) == 1):
            word, numbers = key, entry
            if not isinstance(entry, Mapping):
                numbers = dict(zip(names, real_array(entry, f"{what}: {word}", shape=(len(names),))))
        else:
            word, numbers = orders[0], {key: entry}
        for name, value in numbers.items():
            if name not in names:
                known = names if word == key else (*names, *orders)
                of = f"{word}: " if word == key else ""
                raise InputError(f'{what}: {of}there is no coordinate "{name}"{nearest(str(name), known)}')
            if name in by_order[word]:
                raise InputError(f'{what}: the {word} of "{name}" is given twice')
            by_order[word][name] = real_number(value, f"{what}: {word} of {name}")
    return by_order


def _values(matrix: PolynomialMatrix, given, what: str, at_end: bool) -> tuple[BoundaryValue, ...]:
    """The conditions of one end."""
    result = []
    by_order = values_by_order(given, matrix.coordinates, ORDERS[: max(matrix.degree, 1)], what)
    for order, (word, numbers) in enumerate(by_order.items()):
        for name, number in numbers.items():
            text = f"{word + ' of ' if order else ''}{name} at {'T' if at_end else '0'}"
            result.append(BoundaryValue(matrix.coordinates.index(name), order, at_end, number, text))
    return tuple(result)


def ends_of(blocks, T: float) -> tuple[np.ndarray, np.ndarray]:
    """States at 0 and at T, square matrices, of unknowns that are the states at T of growing blocks and those at 0 of others."""
    n = sum(map(len, blocks))
    at_start, at_end = np.eye(n), np.eye(n)
    for block, at in zip(blocks, block_slices(blocks)):
        size = len(block)
        rate = np.trace(block) / size
        if rate * T > LARGEST_GROWTH:
            raise Overflow(
                f"duration: a motion grows over {T:g} s by e^{rate * T:.4g}, beyond the range of float64; choose a shorter one"
            )
        target, own = (at_start, -block) if rate > 0 else (at_end, block)
        target[at, at] = block_states((own,), np.eye(size), np.full(size, T))
    return at_start, at_end


def _solved(matrix: PolynomialMatrix, forced: Response, conditions: tuple[BoundaryValue, ...], T: float) -> Boundary:
    pair = forced.pairs.finite
    blocks, n, degree = pair.blocks, len(pair.B), max(matrix.degree, 1)
    at_start, at_end = ends_of(blocks, T)
    powers = [pair.C]
    while len(powers) < degree:
        powers.append(powers[-1] @ pair.J)
    # all values at both ends, of x and of its derivatives times powers of T; the unknowns in units in which the largest of these is 1
    ends = np.array([[power @ states * T**k for k, power in enumerate(powers)] for states in (at_start, at_end)])
    columns = np.abs(ends).max(axis=(0, 1, 2), initial=0.0)
    ends = ends / np.where(columns > 0, columns, 1.0)
    before = float(np.nextafter(T, 0.0))
    moments = [[(forced.derivative(k) if k else forced.function)(t) * T**k for k in range(degree)] for t in (0.0, before)]
    particular = np.array(moments).reshape(2, degree, matrix.size)
    places = tuple(np.array([(int(one.at_end), one.order, one.coordinate) for one in conditions], dtype=int).reshape(-1, 3).T)
    units = np.array([T**one.order for one in conditions])
    equations = ends[places].reshape(len(conditions), n)
    natural = np.abs(ends).max(axis=(0, 3), initial=0.0)[places[1:]]  # the size of that derivative of the coordinate at either end
    natural = np.where(natural > 0, natural, 1.0)
    weights = 1 / natural
    given, own = np.array([one.value for one in conditions]) * units, particular[places]
    left, singular, right = np.linalg.svd(weights[:, None] * equations, full_matrices=True)
    turns = max((float(np.abs(block).max()) for block in blocks), default=0.0) * T
    noise = NOISE_SAFETY * EPS * max(n, 1) * (1 + turns) * max(pair.coupling, 1.0)
    rank = int((singular > noise).sum())
    rest = weights * (given - own)
    size = max(float(np.abs(weights * given).max(initial=0.0)), float(np.abs(weights * own).max(initial=0.0)))
    condition = float(singular[0] / singular[rank - 1]) if rank else 1.0
    _refuse_contradiction(left[:, rank:].T, weights, rest, conditions, units, (given, own), noise * condition * size)
    kernel = right[rank:].T
    unknowns = right[:rank].T @ ((left[:, :rank].T @ rest) / singular[:rank])
    if kernel.size:
        flat = ends.reshape(-1, n)
        unknowns -= kernel @ np.linalg.lstsq(flat @ kernel, flat @ unknowns + particular.ravel(), rcond=None)[0]
    scale = np.where(columns > 0, columns, 1.0)

    def motion(amounts) -> BohlFunction:
        return BohlFunction(pair.C, blocks, at_start @ (amounts / scale))

    undetermined = tuple(motion(one) for one in kernel.T)
    differences = np.abs(equations @ unknowns + own - given)
    sizes = np.abs(ends @ unknowns + particular).max(axis=(0, 2), initial=0.0)[places[1]]
    residual = float((differences / np.where(sizes > 0, sizes, 1.0)).max(initial=0.0))
    error, notices = max(noise * condition / NOISE_SAFETY, residual), [*_free_notices(kernel, ends, matrix, conditions, T, n)]
    kept, dropped = (singular[rank - 1] if rank else np.inf), (singular[rank] if rank < len(singular) else 0.0)
    if kept < CLEAR_KEPT * noise:
        error = max(error, UNCLEAR_ERROR)
        text = (
            f"the boundary values were taken to be {counted(rank, 'independent condition')}: the smallest singular value that counts is {kept:.2g}, "
            f"the largest that does not {dropped:.2g}, with rounding errors of {noise:.2g}; T = {T:.6g} s is near a conjugate point"
        )
        notices.append(Notice(NoticeKind.RANK, text, doubtful=True))
    return Boundary(
        T, conditions, motion(unknowns), undetermined, residual, condition, rank, singular, noise, error, tuple(notices)
    )


def _refuse_contradiction(null, weights, rest, conditions, units, values, bound) -> None:
    """Raise the error that names a combination of conditions which every motion satisfies with another value."""
    null = _echelon(null)
    off = np.abs(null @ rest)
    if not (off > bound * np.abs(null).sum(axis=1)).any():
        return
    combination = null[int(off.argmax())] * weights * units
    combination = combination / np.abs(combination).max()
    given, own = (float(combination @ (one / units)) for one in values)
    shown = [(f"{number:.6g} ({one.text})") for number, one in zip(combination, conditions) if abs(number) > EPS**0.5]
    raise ContradictoryConstraints(
        f"boundary values: no motion has them: {' + '.join(shown)} is {own:.6g} in every motion, but {given:.6g} by the given values; "
        "change one of them, leave one out, or choose another duration"
    )


def _echelon(null: np.ndarray) -> np.ndarray:
    """Combinations of the rows that each have a 1 where the others have 0."""
    if not null.size:
        return null
    places = scipy.linalg.qr(null, mode="r", pivoting=True)[1][: len(null)]
    return np.linalg.solve(null[:, places], null)


def _free_notices(kernel, ends, matrix: PolynomialMatrix, conditions, T: float, n: int):
    """The notice of free motions: how many, why, and where they move."""
    count = kernel.shape[1]
    if not count:
        return
    sizes = np.abs(ends @ kernel)
    moving = sizes.max(axis=(0, 1, 3)) > EPS**0.5 * sizes.max(initial=0.0)
    words = [
        f"{ORDERS[order] if order < len(ORDERS) else f'derivative {order}'} of {matrix.coordinates[i]} at {'T' if end else '0'}"
        for end, order, i in np.argwhere(sizes.max(axis=3) > EPS**0.5 * sizes.max(initial=0.0))
    ]
    why = (
        f"{counted(len(conditions), 'condition')} for {counted(n, 'free amount')}"
        if len(conditions) < n
        else f"{counted(len(conditions), 'condition')}, of which {n - count} are independent: T = {T:.6g} s is a conjugate point"
    )
    names = listed([name for name, one in zip(matrix.coordinates, moving) if one])
    yield Notice(
        NoticeKind.RANK,
        f"the boundary values leave {counted(count, 'motion')} free ({why}), in which {names} move; "
        f"free are combinations of {listed(words, 6)}. The solution with the least values at both ends is returned",
    )
