"""Many starts or forces of one A(s): one decomposition, and values that are made together (``response.starts``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..checks import counted, evaluation_times, places_of, real_array, whole_number
from ..errors import InputError, Overflow
from ..notices import Notice
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.reduction import Reduction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import zero
from .cancellation import cancelled
from .flow import FlowFunction
from .parts import start_of
from .reduced import derivatives_of, fitting, flow_of, reduction_for
from .response import Response
from .solve import checked_force, solve, solve_with
from .starts import Alone, FlowStarts, UnitStarts, parts

Happening = tuple[np.ndarray, tuple[np.ndarray, ...]]


@dataclass(frozen=True)
class ManyFunctions:
    """S functions of time with r rows each, evaluated together.

    Attributes:
        shape: (S, r).
        groups: which of them, and how these are evaluated.
    """

    shape: tuple[int, int]
    groups: tuple[tuple[np.ndarray, Alone | UnitStarts | FlowStarts], ...]

    def __call__(self, times) -> np.ndarray:
        """All at a time (-> shape (S, r)) or at times (T,) (-> (S, r, T)); t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        times = evaluation_times(times)
        found = np.empty((*self.shape, times.size))
        with np.errstate(over="ignore", invalid="ignore"):  # reported below
            for members, functions in self.groups:
                for at in parts(times.size, 0 if len(members) == len(found) else len(members) * self.shape[1]):
                    part = found[..., at] if len(members) == len(found) else np.empty((len(members), self.shape[1], at.stop - at.start))
                    functions.values_into(part, times.reshape(-1)[at])
                    if len(members) < len(found):
                        found[members, :, at] = part
        for member, values in enumerate(found):
            if not np.isfinite(values).all():
                raise Overflow(f"values of member {member} lie beyond the range of float64; ask for earlier times")
        return found if times.ndim else found[..., 0]

    def derivative(self, order: int = 1) -> ManyFunctions:
        """The classical derivatives for t > 0."""
        order = whole_number(order, "order")
        return ManyFunctions(self.shape, tuple((members, functions.derivative(order)) for members, functions in self.groups))

    def rows(self, indices) -> ManyFunctions:
        """Some of the rows of each, in this order."""
        indices = np.asarray(indices, dtype=int)
        groups = tuple((members, functions.rows(indices)) for members, functions in self.groups)
        return ManyFunctions((self.shape[0], len(indices)), groups)


@dataclass(frozen=True, repr=False)
class Responses:
    """The answers to S problems A(d/dt) x_s = f_s, each from its own values at 0-.

    ``xs(t)`` gives all of them, shape (S, r), ``xs(times)`` shape (S, r, T); ``xs[3]`` is one ``Response``, as it is solved alone,
    ``for x in xs`` goes through all.

    Attributes:
        polynomial_matrix: A(s).
        initial: x_s^(i)(0-), shape (S, q, r).
        forces: S of them; what is common to many is the same object.
        rank_tolerance: as given to ``solve``.
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    forces: tuple[ImpulsiveSmooth, ...]
    rank_tolerance: float | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({counted(len(self), 'answer')} of {counted(self.polynomial_matrix.size, 'coordinate')})"

    def __len__(self) -> int:
        return len(self.forces)

    def __getitem__(self, index: int | slice) -> Response | Responses:
        if isinstance(index, slice):
            return Responses(self.polynomial_matrix, self.initial[index], self.forces[index], self.rank_tolerance)
        place = range(len(self))[index]  # IndexError where there is none
        return solve(self.polynomial_matrix, self.initial[place], self.forces[place], self.rank_tolerance)

    def __iter__(self) -> Iterator[Response]:
        return (self[index] for index in range(len(self)))

    def __call__(self, times) -> np.ndarray:
        """All at a time (-> shape (S, r)) or at times (T,) (-> (S, r, T)); t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        return self.function(times)

    def derivative(self, order: int = 1) -> ManyFunctions:
        """The classical derivatives for t > 0, called like this itself."""
        return self.function.derivative(order)

    def of(self, *coordinates: str | int) -> ManyFunctions:
        """Some coordinates only, by name or number from 0."""
        return self.function.rows(places_of(coordinates, self.polynomial_matrix.coordinates, "coordinate"))

    @cached_property
    def function(self) -> ManyFunctions:
        """The regular parts."""
        groups = tuple((group.members, group.functions) for group in self._groups)
        return ManyFunctions((len(self), self.polynomial_matrix.size), groups)

    @property
    def jumps(self) -> np.ndarray:
        """x_s^(i)(0+) - x_s^(i)(0-), shape (S, q, r); exactly zero where a start is consistent."""
        return np.array([jump for jump, _ in self._happenings]).reshape(self.initial.shape)

    @property
    def impulses(self) -> tuple[tuple[np.ndarray, ...], ...]:
        """For each member the arrays (r,) of which the k-th multiplies the k-th derivative of Dirac's delta at t = 0."""
        return tuple(impulses for _, impulses in self._happenings)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What all have in common, once, and how many of them jump or have impulses; ``xs[s].notices`` says it of one."""
        found = {notice: None for group in self._groups for notice in group.notices}
        jumping = int(self.jumps.any(axis=(1, 2)).sum())
        struck = sum(any(part.any() for part in impulses) for impulses in self.impulses)
        for count, kind, what in ((jumping, "jump", "values jump"), (struck, "impulse", "there are Dirac impulses")):
            if count:
                found[Notice(kind, f"{what} at t = 0 in {count} of {counted(len(self), 'answer')}")] = None
        return tuple(found)

    @cached_property
    def _groups(self) -> tuple[_Group, ...]:
        return tuple(_groups_of(self))

    @cached_property
    def _happenings(self) -> list[Happening]:
        found: list[Happening] = [None] * len(self)
        for group in self._groups:
            for member, happening in zip(group.members, group.happenings()):
                found[member] = happening
        return found


def solve_many(A: PolynomialMatrix, initial, force, rank_tolerance: float | None = None) -> Responses:
    """``solve`` of several starts (S, q, r), or several forces, or one of each for every member.

    Raises:
        InputError: shapes that do not fit, or not as many starts as forces.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> (solve_many(A, [[[1.0], [0.0]], [[0.0], [2.0]]], None)([0.0, np.pi / 4]).round(12) + 0.0).tolist()
    [[[1.0, 0.0]], [[0.0, 1.0]]]
    """
    q, r = A.degree, A.size
    starts = np.zeros((1, q, r)) if initial is None else real_array(initial, "initial")
    if starts.shape[-2:] != (q, r) or starts.ndim not in (2, 3):
        raise InputError(f"initial: expected shape {q} x {r}, or S x {q} x {r} for S starts, found {' x '.join(map(str, starts.shape))}")
    starts = starts.reshape(-1, q, r) if q else np.zeros((len(starts) if starts.ndim == 3 else 1, 0, r))
    forces = tuple(force) if isinstance(force, (list, tuple)) else (force,) * len(starts)
    if not len(starts) or not forces:
        raise InputError("initial and force: found none; expected at least one start and one force")
    if initial is None or np.ndim(initial) == 2:
        starts = np.broadcast_to(starts, (len(forces), q, r))
    if len(forces) != len(starts):
        raise InputError(f"force: found {counted(len(forces), 'force')} for {counted(len(starts), 'start')}; give as many, or one for all")
    nothing = zero(r)
    checked = {id(one): checked_force(one, r) for one in forces}
    members = (checked[id(one)] for one in forces)
    return Responses(A, starts, tuple(nothing if one.is_zero else one for one in members), rank_tolerance)


@dataclass(frozen=True)
class _Group:
    """Some members that are evaluated together, what they have in common, and how jump and impulses of each are found."""

    members: np.ndarray
    functions: Alone | UnitStarts | FlowStarts
    notices: tuple[Notice, ...]
    happenings: Callable[[], list[Happening]]


def _groups_of(x: Responses) -> Iterator[_Group]:
    by_force: dict[int, list[int]] = {}
    for member, force in enumerate(x.forces):
        by_force.setdefault(id(force), []).append(member)
    alone = []
    for members in map(np.array, by_force.values()):
        force, A = x.forces[members[0]], x.polynomial_matrix
        reduction = reduction_for(A, force) if x.rank_tolerance is None and len(members) > 1 else None
        if reduction is not None:
            fits = _serves(x.initial[members], reduction, force)
            if fits.sum() > 1:
                yield _reduced(x, members[fits], reduction, force)
                members = members[~fits]
        if len(members) > A.degree * A.size:
            yield _superposed(x, members, force)
        else:
            alone.extend(members)
    if alone:
        yield _alone(x, np.sort(alone))


def _alone(x: Responses, members) -> _Group:
    found = [x[member] for member in members]
    notices = dict.fromkeys(notice for one in found for notice in (*one.force.notices, *one.solution.notices))
    functions = Alone(tuple(one.function for one in found))
    return _Group(members, functions, tuple(notices), lambda: [(one.jump, one.impulses) for one in found])


def _superposed(x: Responses, members, force) -> _Group:
    pairs, shape = x.polynomial_matrix.jordan_pairs(x.rank_tolerance), x.initial.shape[1:]
    base, none = solve_with(pairs, np.zeros(shape), force), zero(shape[1])
    units = tuple(solve_with(pairs, unit.reshape(shape), none).function for unit in np.eye(shape[0] * shape[1]))
    functions = UnitStarts(base.function, units, x.initial[members].reshape(len(members), -1).T)

    def happenings() -> list[Happening]:
        starts = (start_of(pairs.form, values, force) for values in x.initial[members])
        return [(start.jump, start.impulses) for start in starts]

    return _Group(members, functions, (*force.notices, *base.solution.notices), happenings)


def _serves(initial: np.ndarray, reduction: Reduction, force) -> np.ndarray:
    """For which of the starts (S, q, r) the reduced equations serve, as for each alone: shape (S,)."""
    try:
        with np.errstate(over="raise", invalid="raise"):
            found = fitting(reduction, np.moveaxis(initial, 0, 2), force)
            if found.any() and reduction.is_small:
                flow, _ = flow_of(reduction, np.zeros(initial.shape[1:]), force)
                starts = reduction.decoupled.coordinates(_starts(reduction, initial))
                states = np.tile(flow.states.start_at_zero[:, None], len(initial))
                states[: len(starts)] += starts
                found &= ~cancelled(flow, states)
    except FloatingPointError:  # out of the range of float64 on the way
        return np.zeros(len(initial), dtype=bool)
    return found


def _starts(reduction: Reduction, initial: np.ndarray) -> np.ndarray:
    """The states of the reduced equations at 0+ for values at 0- (S, q, r), shape (n, S)."""
    return np.array([reduction.state(values) for values in initial]).T


def _reduced(x: Responses, members, reduction: Reduction, force) -> _Group:
    initial = x.initial[members]
    flow, output = flow_of(reduction, np.zeros(initial.shape[1:]), force)
    free, own = flow_of(reduction, np.zeros(initial.shape[1:]), zero(initial.shape[2]))
    starts = _starts(reduction, initial)
    functions = FlowStarts(FlowFunction(flow, output), free, own, starts)

    def happenings() -> list[Happening]:
        at_zero = np.vstack([starts, np.tile(force.smooth.start_at_zero[:, None], len(members))])
        return [(jump, ()) for jump in np.moveaxis(derivatives_of(flow, output, at_zero, np.moveaxis(initial, 0, 2)), 2, 0)]

    first = x[int(members[0])]
    return _Group(members, functions, (*force.notices, *first.solution.notices), happenings)
