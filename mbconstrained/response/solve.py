"""Solve A(d/dt) x = f for one start and force, or for many at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import counted, evaluation_times, item_of, optional_package, places_of, real_array, whole_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError, Overflow, SingularPolynomialMatrix
from ..ground.named_arrays import named_array
from ..ground.notices import Notice, NoticeKind
from ..ground.threads import short_work
from ..linalg.blocks import CHUNK_ENTRIES
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction, Piece, in_chunks
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import zero
from .choose import Evaluations, Method, Request, reducible
from .events import Event, starts_of
from .problem import Problem, checked_force, checked_matrix
from .response import Response, start_after
from .response_notices import remaining_notices
from .solvability import completed

if TYPE_CHECKING:
    from ..exact.enclosure.intervals import Enclosure


# Many starts or forces of one A(s): one decomposition, and a joint evaluation.
# The motion is linear in the values at 0-: x_s = x_0 + sum over j of X_s[j] x_j, x_0 that from rest under the force and x_j that from
# the j-th unit value alone. Where there are more starts than values at 0-, these are evaluated, each with its own digits just after
# t = 0, and one product of matrices gives all motions.

#: Products are added in parts so many times smaller than other chunks: they are still at hand in the cache.
IN_CACHE = 16


@dataclass(frozen=True, eq=False)
class _Superposed:
    """x_0 + sum over j of weights[j] x_j(t) for some of the members.

    Attributes:
        members: their numbers, S of them.
        base: x_0.
        units: x_j, m of them; none where the only member is x_0 itself.
        weights: shape (m, S).
    """

    members: np.ndarray
    base: BohlFunction
    units: tuple[BohlFunction, ...]
    weights: np.ndarray

    def values_into(self, values: np.ndarray, times: np.ndarray) -> None:
        """Write the values into an array (S, r, T)."""
        values[...] = self.base._values(times)
        for at in _parts(len(times) if self.units else 0, len(self.units) * values.shape[1]):
            table = np.array([unit._values(times[at]) for unit in self.units])
            flat, finite = table.reshape(len(table), -1), bool(np.isfinite(table).all())
            for members in _parts(values.shape[0], table[0].size * IN_CACHE):
                weights = self.weights[:, members].T
                if finite:
                    product = weights @ flat
                else:  # zero stays zero, however fast it would grow
                    product = np.array([one[one != 0] @ flat[one != 0] for one in weights])
                values[members, :, at] += product.reshape(-1, *table.shape[1:])

    def mapped(self, change) -> _Superposed:
        """The superposition of mapped functions."""
        return replace(self, base=change(self.base), units=tuple(map(change, self.units)))


@dataclass(frozen=True)
class ManyFunctions:
    """S functions of time with r rows each, evaluated together.

    Attributes:
        shape: (S, r).
        groups: which of them, and how these are evaluated.
    """

    shape: tuple[int, int]
    groups: tuple[_Superposed, ...]

    @property
    def size(self) -> int:
        """Number of rows in total."""
        return self.shape[0] * self.shape[1]

    def __call__(self, times) -> np.ndarray:
        """All functions at a time (-> shape (S, r)) or at times (T,) (-> (S, r, T)); t = 0 means 0+."""
        times = evaluation_times(times)
        values = np.empty((*self.shape, times.size))
        with np.errstate(over="ignore", invalid="ignore"), short_work(self.shape[1]):  # reported below
            for group in self.groups:
                for at in _parts(times.size, len(group.members) * self.shape[1]):
                    part = np.empty((len(group.members), self.shape[1], at.stop - at.start))
                    group.values_into(part, times.reshape(-1)[at])
                    values[group.members, :, at] = part
        for member, own in enumerate(values):
            if not np.isfinite(own).all():
                raise Overflow(f"values of member {member} lie beyond the range of float64; choose earlier times")
        return values if times.ndim else values[..., 0]

    def derivative(self, order: int = 1) -> ManyFunctions:
        """The classical derivatives for t > 0."""
        order = whole_number(order, "order")
        return ManyFunctions(self.shape, tuple(group.mapped(lambda one: one.derivative(order)) for group in self.groups))

    def rows(self, indices) -> ManyFunctions:
        """Selected rows of each, in this order."""
        indices = np.asarray(indices, dtype=int)
        return ManyFunctions(
            (self.shape[0], len(indices)), tuple(group.mapped(lambda one: one.rows(indices)) for group in self.groups)
        )


def _parts(count: int, each: int) -> Iterator[slice]:
    """Slices of a number of items, each of a given number of entries, that stay below CHUNK_ENTRIES."""
    width = max(1, CHUNK_ENTRIES // max(each, 1))
    return (slice(begin, min(begin + width, count)) for begin in range(0, count, width))


@dataclass(frozen=True, repr=False, eq=False)
class Responses(Displayed):
    """The solutions of S problems A(d/dt) x_s = f_s, each from its own values at 0-.

    ``xs(t)`` gives all of them, shape (S, r), ``xs(times)`` shape (S, r, T); ``xs[3]`` is one ``Response``, as if solved alone,
    ``for x in xs`` iterates over all.

    Attributes:
        polynomial_matrix: A(s).
        initial: x_s^(i)(0-), shape (S, q, r).
        forces: S of them; a force that several have in common is the same object.
        rank_tolerance: as given to ``solve``.
        request: as given to ``solve``.
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    forces: tuple[ImpulsiveSmooth, ...]
    rank_tolerance: float | None = None
    request: Request = field(default=Request())

    def _summary(self) -> str:
        return f"{counted(len(self), 'solution')} of {counted(self.polynomial_matrix.size, 'coordinate')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __len__(self) -> int:
        return len(self.forces)

    def __getitem__(self, index: int | slice) -> Response | Any:
        if isinstance(index, slice):
            return replace(self, initial=self.initial[index], forces=self.forces[index])
        place = item_of(index, len(self), "solution")
        return self._solved(self.initial[place], self.forces[place])

    def __iter__(self) -> Iterator[Response]:
        return (self[index] for index in range(len(self)))

    def _solved(self, initial: np.ndarray, force: ImpulsiveSmooth) -> Response:
        return Response._solved(Problem(self.polynomial_matrix, initial, force, self.rank_tolerance), self.request)

    def __call__(self, times) -> np.ndarray:
        """Return all responses at a time (-> shape (S, r)) or at times (T,) (-> (S, r, T)); t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        return named_array(self.function(times), (), self.polynomial_matrix.coordinates)

    def derivative(self, order: int = 1) -> ManyFunctions:
        """Return the classical derivatives for t > 0, as functions of the same kind."""
        return self.function.derivative(order)

    def of(self, *coordinates: str | int) -> ManyFunctions:
        """Return the function of some coordinates, by name or index from 0."""
        return self.function.rows(places_of(coordinates, self.polynomial_matrix.coordinates, "coordinate"))

    def chunks(self, times, count: int | None = None) -> Iterator[Piece]:
        """Yield all responses at many times as pairs (times, values), for results larger than memory.

        Args:
            times: times in s, shape (T,); or the first and the last one, where a count is given.
            count: number of evenly spaced times.

        Returns:
            Pairs in order, the values of shape (S, r, number of times).
        """
        return in_chunks(self.function, times, count)

    @cached_property
    def function(self) -> ManyFunctions:
        """The regular parts."""
        shape, groups = self.initial.shape[1:], []
        for members in self._by_force:
            force = self.forces[members[0]]
            if len(members) > shape[0] * shape[1]:
                weights = self.initial[members].reshape(len(members), -1).T
                used, none = weights.any(axis=1), zero(shape[1])
                units = (self._solved(unit.reshape(shape), none).function for unit in np.eye(len(weights))[used])
                groups.append(_Superposed(members, self._solved(np.zeros(shape), force).function, tuple(units), weights[used]))
            else:
                alone = (self._solved(self.initial[member], force).function for member in members)
                groups += [_Superposed(members[[k]], one, (), np.zeros((0, 1))) for k, one in enumerate(alone)]
        return ManyFunctions((len(self), shape[1]), tuple(groups))

    @property
    def _by_force(self) -> list[np.ndarray]:
        """The members with a common force."""
        by_force: dict[int, list[int]] = {}
        for member, force in enumerate(self.forces):
            by_force.setdefault(id(force), []).append(member)
        return [np.array(members) for members in by_force.values()]

    @cached_property
    def _alike(self) -> list[tuple[np.ndarray, Response]]:
        """Members with one force and one method, and the solution of the first: the others differ by their starts only."""
        result = []
        for members in self._by_force:
            force = self.forces[members[0]]
            reduced = reducible(self.polynomial_matrix, self.initial[members], force, self.rank_tolerance)
            result += [
                (own, self._solved(self.initial[own[0]], force)) for own in (members[reduced], members[~reduced]) if len(own)
            ]
        return result

    @cached_property
    def _starts(self) -> tuple[np.ndarray, tuple[tuple[np.ndarray, ...], ...]]:
        """Jumps, shape (S, q, r), and impulses of the members."""
        jumps = np.zeros(self.initial.shape)
        impulses: list[tuple[np.ndarray, ...]] = [()] * len(self)
        for members, first in self._alike:
            with np.errstate(all="ignore"), short_work(self.initial[0].size):
                if first.method.flow is not None:
                    jumps[members] = first.method.flow.jumps(self.initial[members])
                    continue
                if first._is_decided_exactly:
                    for member in members:
                        jumps[member], impulses[member] = self[int(member)].jump, self[int(member)].impulses
                    continue
                starts = starts_of(first.pairs.form, self.initial[members].transpose(1, 2, 0), first.force)
                jumps[members] = starts.jump.transpose(2, 0, 1)
                for place, member in enumerate(members):
                    impulses[member] = starts[place].impulses
        return jumps, tuple(impulses)

    @property
    def jump(self) -> np.ndarray:
        """x_s^(i)(0+) - x_s^(i)(0-), shape (S, q, r); exactly zero where a start is consistent."""
        return self._starts[0]

    @property
    def impulses(self) -> tuple[tuple[np.ndarray, ...], ...]:
        """Impulses of each member at t = 0: arrays (r,), the k-th of which multiplies the k-th derivative of Dirac's delta."""
        return self._starts[1]

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Common notices, once, and how many members jump or have impulses; ``xs[s].notices`` are those of one."""
        notices = dict.fromkeys(notice for _, x in self._alike for notice in (*x.force.notices, *remaining_notices(x)))
        jumping = int(self.jump.any(axis=(1, 2)).sum())
        impulsive = sum(any(part.any() for part in impulses) for impulses in self.impulses)
        for count, kind, what in (
            (jumping, NoticeKind.JUMP, "values jump"),
            (impulsive, NoticeKind.IMPULSE, "there are Dirac impulses"),
        ):
            if count:
                notices[Notice(kind, f"{what} at t = 0 in {count} of {counted(len(self), 'solution')}")] = None
        return tuple(notices)

    @property
    def methods(self) -> tuple[Method, ...]:
        """The method of each member, with its reason."""
        return tuple(x.method for x in self)

    @property
    def start(self) -> np.ndarray:
        """x_s^(i)(0+), shape (S, q, r)."""
        return start_after(self.initial, self.jump)

    @property
    def events(self) -> tuple[tuple[Event, ...], ...]:
        """Events of each member, its jumps and impulses after t = 0 by ascending time; they are those of its force."""
        events: list[tuple[Event, ...]] = [()] * len(self)
        for members, first in self._alike:
            for member in members:
                events[member] = first.events
        return tuple(events)

    def error_estimate(self, times, **options) -> np.ndarray:
        """Estimates of max |error| / max |value| over the times for each member.

        Args:
            times: in s, a number or shape (T,).
            options: as in ``error_estimate`` of one member.

        Returns:
            Shape (S,).
        """
        return np.array([x.error_estimate(times, **options) for x in self])

    def enclose(self, times, digits: int = 15, **options) -> tuple[Enclosure, ...]:
        """Return intervals for each member that are guaranteed to contain its values.

        Args:
            times: times in s, a number or shape (T,).
            digits: significant digits of each value.
            options: options of ``Response.enclose``.

        Returns:
            An ``Enclosure`` for each.
        """
        return tuple(x.enclose(times, digits, **options) for x in self)

    def to_xarray(self, times):
        """Return all responses at times (T,) as a ``DataArray`` over member, time and coordinate (``Response.to_xarray``)."""
        xarray = optional_package("xarray", "to_xarray")
        return xarray.concat([x.to_xarray(times) for x in self], "member", combine_attrs="drop_conflicts")

    def to_pandas(self, times):
        """Return all responses at times (T,) as a ``DataFrame``, indexed by member and time (``Response.to_pandas``)."""
        pandas = optional_package("pandas", "to_pandas")
        return pandas.concat({member: x.to_pandas(times) for member, x in enumerate(self)}, names=["member"])


def solve_many(A: PolynomialMatrix, initial, force, rank_tolerance: float | None = None, request: Request = Request()) -> Responses:
    """``solve`` of several starts, or several forces, or one of each for every member.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> (solve_many(A, [[[1.0], [0.0]], [[0.0], [2.0]]], None)([0.0, np.pi / 4]).round(12) + 0.0).tolist()
    [[[1.0, 0.0]], [[0.0, 1.0]]]
    """
    q, r = A.degree, A.size
    starts = np.zeros((1, q, r)) if initial is None else real_array(initial, "initial")
    if starts.shape[-2:] != (q, r) or starts.ndim not in (2, 3):
        raise InputError(
            f"initial: expected shape {q} x {r}, or S x {q} x {r} for S starts, found {' x '.join(map(str, starts.shape))}"
        )
    starts = starts.reshape(-1, q, r) if q else np.zeros((len(starts) if starts.ndim == 3 else 1, 0, r))
    forces = tuple(force) if isinstance(force, (list, tuple)) else (force,) * len(starts)
    if not len(starts) or not forces:
        raise InputError("initial and force: found none; expected at least one start and one force")
    if initial is None or np.ndim(initial) == 2:
        starts = np.broadcast_to(starts, (len(forces), q, r))
    if len(forces) != len(starts):
        raise InputError(
            f"force: found {counted(len(forces), 'force')} for {counted(len(starts), 'start')}; give as many, or one for all"
        )
    nothing = zero(r)
    checked = {id(one): checked_force(one, r, A) for one in forces}
    members = (checked[id(one)] for one in forces)
    return Responses(A, starts, tuple(nothing if one.is_zero else one for one in members), rank_tolerance, request)


# A(d/dt) x = f from values at 0-, in closed form.


@answering
def solve(
    A: PolynomialMatrix,
    initial=None,
    force: ImpulsiveSmooth | None = None,
    rank_tolerance: float | None = None,
    *,
    evaluations: Evaluations = "once",
    delayed: Mapping | None = None,
    history=None,
    free: Mapping | str | None = None,
) -> Response | Any:
    """Solve A(d/dt) x = f on t >= 0 from any values at 0- (Moysis et al., Theorem 3.1, corrected).

    With X(s) = A(s)^-1 (X_in(s) + F(s)), the transform taken from 0-: only the values at 0- and the force on
    [0, inf) enter. Values that do not satisfy the equations are not repaired: the response reports the jumps and
    impulses that they cause. Where the force starts, stops, changes or has impulses later, ``Response.events`` has their
    effects on x; between such times x is the same closed form from another state.

    The method is chosen once (``response.choose``): ``x.method`` has its name and the reason.

    Args:
        A: the polynomial matrix, degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r); None for zeros. Of shape (S, q, r): S starts at once.
        force: f with r rows, see ``mbconstrained.signals``, or by the names of equations or coordinates, such as
            {"cart": mb.step(5.0)}; None for zero. A list of S forces: S solutions at once.
        rank_tolerance: overrides how rank decisions are made: a difference of entries of A(s) counts as zero if it is no
            larger than this part of them (1e-9 for measured data, say); None for rounding errors of float64.
        delayed: terms with dead time, A_j(s) by their delays in s: a polynomial matrix, a list of coefficients, or one matrix. The equations
            are A(d/dt) x + sum of A_j(d/dt) x(t - delay_j) = f, solved from delay to delay (``response.methods.method_of_steps``).
        history: x before t = 0, which enters with delays only: a function of t < 0 that returns (r,), a constant vector, or an input as
            a function of the time since the longest delay before t = 0; None for zero. Where ``initial`` is None it also gives the
            values at 0-.
        evaluations: "once": each evaluation takes the method that costs least for its own times; even times of a large model
            then need no eigenvectors. "many": all evaluations share the modes, which are computed at the first one. Small
            models, and solutions by the Jordan pairs, have their modes in any case.
        free: signals of coordinates that the equations do not determine, by name, each with one row: A(s) may be singular, or m x n,
            and x with free coordinates that are not named is that in which they are zero; {} for zero motions of all of them; "least start"
            for polynomials in t (of the degree of the kernel of A(s)) with which the norm of x(0+) is least. Dependent equations must
            not contradict each other; ``mb.solvability`` reports both.

    Returns:
        A ``Response``; of S starts or forces a ``Responses``, which is evaluated for all of them together.

    Raises:
        InputError: shapes that do not fit, values that are not finite, another word for ``evaluations``; delayed terms of neutral or
            advanced type, whose jumps return after each delay.
        SingularPolynomialMatrix: det A(s) = 0 for every s, or free coordinates and no ``free``.
        NotSolvable: dependent equations contradict each other; ``.conditions`` has the combinations.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> x = solve(A, initial=[[1.0], [0.0]])
    >>> bool(np.isclose(x(0.5)[0], np.cos(1.0)))
    True
    >>> late = solve(PolynomialMatrix([[[0.0]], [[1.0]]]), [[1.0]], delayed={1.0: [[1.0]]})  # x' = -x(t - 1), zero before t = 0
    >>> late([1.0, 2.0]).round(12).tolist()  # 1, and 1 - (t - 1)
    [[1.0, 0.0]]
    """
    request = Request(evaluations)
    if free is not None or not checked_matrix(A).is_square:
        if delayed or history is not None or _is_family(initial, force):
            raise InputError(
                "free: equations with free coordinates or of another number than the coordinates are solved without delays, for one start "
                "and one force"
            )
        return Response._solved(completed(A, initial, force, free, rank_tolerance)[0], request)
    if _is_family(initial, force):
        if delayed:
            raise InputError("delayed: several starts or forces are given; equations with delays are solved for one of each")
        return solve_many(checked_matrix(A), initial, force, rank_tolerance, request)
    problem = Problem.checked(A, initial, force, rank_tolerance, delayed, history)
    try:
        return Response._solved(problem, request)
    except SingularPolynomialMatrix as error:
        if delayed:
            raise
        completed(A, initial, force, {}, rank_tolerance)  # NotSolvable where the equations contradict each other
        text = f"{error} To solve it as it is, give free={{name: signal}}; mb.solvability(A) shows the free motions."
        raise SingularPolynomialMatrix(text, error.equations, error.coordinates) from None


def _is_family(initial, force) -> bool:
    """Whether several starts or forces are given."""
    if isinstance(force, (list, tuple)) and any(isinstance(one, (ImpulsiveSmooth, Mapping)) for one in force):
        return True
    try:
        return np.ndim(initial) == 3
    except ValueError:  # rows of different lengths, which are refused later
        return False
