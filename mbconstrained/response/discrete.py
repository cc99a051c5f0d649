"""Discrete time: A(sigma) x_k = f_k in closed form, sigma the shift from k to k + 1.

The same algebra as for differential equations (Moysis et al., Theorem 3.1), the shift in place of the derivative: with
A(z)^-1 = C (z I - J)^-1 B + H_0 + H_1 z + ... every solution is

    x_k = C J^k w + sum over i < k of C J^(k-1-i) B f_i + sum over i >= 0 of H_i f_(k+i).

The finite Jordan pair runs forwards from the start, the infinite one looks ahead: it needs the coming values of f. Over a finite
horizon the infinite pair has free values of its own, which run backwards from the end; they are the zeros at z = 0 of the dual
matrix z^q A(1/z) (Antoniou, Vardulakis and Karampetakis, "A spectral characterization of the behavior of discrete time
AR-representations over a finite time interval", Kybernetika 34, 1998).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import TypeAlias

import numpy as np

from ..exact.enclosure.exact_response import RationalResponse
from ..exact.enclosure.sequences import (
    ForceSums,
    RealizedMatrix,
    SequenceTerm,
    applied,
    closed_terms,
    exact_rows,
    exact_values,
    inverse_columns,
    response_to,
    rounded_values,
    without_cancelled,
)
from ..exact.rational import RationalMatrix, fraction, rational, regular_matrix
from ..ground.checks import counted, places_of, real_array, whole_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import IllConditioned, InputError, Overflow
from ..ground.notices import Notice, NoticeKind, doubts_of
from ..ground.tolerances import EPS, noise_of
from ..linalg.double_double import DoubleDouble
from ..polynomial.jordan_pairs import JordanPairs
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import power, zero
from ..signals.sequences import GeometricSequence, sample_numbers, sampled_terms
from .admissible import Violation, admissible
from .problem import checked_matrix
from .sample_recursion import SETTLED, ShiftRecursion, product, refined, with_start

Force: TypeAlias = "GeometricSequence | ImpulsiveSmooth | Callable | Sequence | np.ndarray | None"

#: Sums of (k - 1)-th powers over factorials give a force its first values as derivatives; later factorials leave float64.
MOST_SHIFTS = 170

#: Free motions of fewer coordinates are summed in closed form at once; a recursion that goes on after the last value of the force takes at
#: most so many products for each coordinate.
MANY_COORDINATES, FEW_PRODUCTS = 12, 1 << 17

#: Number of coordinates and conditions that a notice names.
MOST_NAMED = 4


# The force: a closed form, or values one by one.


@dataclass(frozen=True, eq=False)
class DiscreteForce:
    """f_k = matrix u_k, u_k a sequence in closed form or, where that is None, given by its values.

    Attributes:
        size: number of rows of u_k.
        closed: the closed form of u_k.
        value: returns u_k, shape (size,).
        end: number of values; zero from there on; infinite for a function.
        matrix: None for f_k = u_k; its products are exact.
        table: all values of u_k as rows; None for a function.
    """

    size: int
    closed: GeometricSequence | None
    value: Callable[[int], np.ndarray]
    end: float = np.inf
    matrix: np.ndarray | None = None
    table: np.ndarray | None = None
    known: dict[int, list] = field(default_factory=dict)

    def exact(self, k: int) -> list:
        """f_k as exact numbers, computed once."""
        if k not in self.known:
            values = [rational(entry) for entry in self.value(k).tolist()]
            self.known[k] = values if self.matrix is None else applied(exact_rows(self.matrix), values)
        return self.known[k]

    def times(self, matrix: np.ndarray) -> DiscreteForce:
        """The product matrix @ u_k."""
        return replace(self, matrix=matrix, known={})

    def samples(self, count: int) -> DoubleDouble:
        """f_0 ... f_(count - 1) side by side, shape (r, count)."""
        values = np.zeros((self.size, count))
        if self.table is not None:
            values[:, : len(self.table)] = self.table[:count].T
        else:
            for k in range(int(min(count, self.end))):
                values[:, k] = self.value(k)
        return DoubleDouble.of(values) if self.matrix is None else product(self.matrix, DoubleDouble.of(values))

    def __call__(self, k: int) -> np.ndarray:
        value = self.value(k) if k < self.end else np.zeros(self.size)
        return value if self.matrix is None else self.matrix @ value


def discrete_force(force, size: int, what: str = "force", step: float = 1.0) -> DiscreteForce:
    """The force of a system with so many equations, signals at t = k step; an InputError for one that does not fit."""
    if force is None:
        return DiscreteForce(size, GeometricSequence(size, ()), lambda k: np.zeros(size), 0)
    if isinstance(force, (GeometricSequence, ImpulsiveSmooth)):
        return _signal_force(force, size, what, step)
    if callable(force):
        return DiscreteForce(size, None, cache(lambda k: _value(force(k), k, size, what)))
    values = real_array(force, what)
    if values.ndim == 1 and size == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[1] != size:
        shape = " x ".join(map(str, values.shape)) or "a single number"
        hint = "; give its transpose, one row for each k" if values.ndim == 2 and values.shape[0] == size else ""
        constant = f"; a constant is mb.geometric([…], 1) of {size} numbers" if values.shape == (size,) else ""
        raise InputError(f"{what}: expected f_0, f_1, ... as rows, shape any x {size}, found {shape}{hint}{constant}")
    return DiscreteForce(size, None, values.__getitem__, len(values), table=values)


def _signal_force(force: GeometricSequence | ImpulsiveSmooth, size: int, what: str, step: float) -> DiscreteForce:
    if force.size != size:
        raise InputError(f"{what}: it has {counted(force.size, 'row')}; expected {size}, one for each equation")
    if isinstance(force, GeometricSequence):
        return DiscreteForce(size, force, force)
    if force.impulses or force.later:
        raise InputError(
            f"{what}: it contains Dirac impulses, which have no value at k; a unit pulse is 1 at k = 0 alone, as an array or a sampled signal"
        )
    return DiscreteForce(size, sampled_terms(force, step), lambda k: force(k * step))


def _value(value, k: int, size: int, what: str) -> np.ndarray:
    array = real_array(value, f"{what}({k})")
    if array.shape != (size,) and not (size == 1 and array.ndim == 0):
        raise InputError(f"{what}({k}): expected {counted(size, 'number')}, found shape {array.shape}")
    return array.reshape(size)


# The solution.


@dataclass(frozen=True, eq=False)
class ExactInverse:
    """A(z)^-1 exactly: of the numbers of A(z), or of its Jordan pairs where rank decisions give these another structure."""

    polynomial_matrix: PolynomialMatrix
    rank_tolerance: float | None

    @cached_property
    def pairs(self) -> JordanPairs | None:
        """Jordan pairs in float64; None where float64 cannot tell them."""
        try:
            return self.polynomial_matrix.jordan_pairs(self.rank_tolerance)
        except IllConditioned:
            return None

    @cached_property
    def by_rows(self) -> ShiftRecursion | None:
        """The recursion by the highest powers of the rows, where all numbers count as exact and need no rank decision."""
        A = self.polynomial_matrix
        if self.rank_tolerance is not None or A.is_uncertain or any(factors is not None for factors in A.factors):
            return None
        return ShiftRecursion.of_rows(A)

    @cached_property
    def recursion(self) -> ShiftRecursion | None:
        """The recursion in float64 from sample to sample; None where float64 cannot tell its structure."""
        if self.by_rows is not None:
            return self.by_rows
        is_given = all(factors is None for factors in self.polynomial_matrix.factors)
        if self.pairs is None or not is_given:
            return None
        return ShiftRecursion.of_pairs(self.polynomial_matrix, self.pairs) if self.is_exact else ShiftRecursion.realized(self.pairs)

    @cached_property
    def is_exact(self) -> bool:
        """Whether the numbers of A(z), taken as exact, have the structure of the pairs."""
        if self.by_rows is not None or self.pairs is None:
            return True
        return regular_matrix(self.polynomial_matrix).determinant.degree() == len(self.pairs.form.T)

    @cached_property
    def inverse(self) -> RationalMatrix | RealizedMatrix:
        """The matrix or its realization by the pairs."""
        if self.is_exact:
            return regular_matrix(self.polynomial_matrix)
        pairs = self.pairs
        H = [pairs.laurent(i) for i in range(pairs.structure.highest_impulse + 1)]
        return RealizedMatrix(pairs.finite.C, pairs.finite.J, pairs.finite.B, H)

    @cached_property
    def columns(self) -> tuple[RationalResponse, ...]:
        """A(z)^-1, column by column."""
        return inverse_columns(self.inverse, self.polynomial_matrix.size)

    @property
    def look_ahead(self) -> int:
        """The highest i with H_i other than zero, at least 0: x_k depends on f_k ... f_(k+i)."""
        if self.recursion is not None:
            return max(len(self.recursion.taps or self.recursion.lead) - 1, 0)
        return max(max((len(column.impulses) for column in self.columns), default=1) - 1, 0)


class DiscreteFunction(Displayed, ABC):
    """A sequence in closed form, a function of whole numbers k >= 0 alone."""

    @property
    @abstractmethod
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the solution."""

    def __call__(self, k) -> np.ndarray:
        """x_k for a whole number k >= 0 (-> shape (r,)) or for numbers (T,) (-> (r, T)), up to the horizon.

        Raises:
            InputError: no whole number, a negative one, or one beyond the horizon.
            Overflow: a value leaves the range of float64.
        """
        indices = self._checked(k)
        values, _ = self._evaluated(indices)
        if not np.isfinite(values).all():
            first = np.atleast_1d(indices)[~np.isfinite(values).all(axis=0)].min()
            raise Overflow(f"the value at k = {first} lies beyond the range of float64; ask for earlier samples")
        return values if indices.ndim else values[:, 0]

    def error_estimate(self, k) -> float:
        """An estimate of max |error| / max |x_k| over the numbers k, rounding errors of float64 included.

        For exact numbers it bounds the error; where rank decisions on rounded data changed the structure, the rounding errors of
        the Jordan pairs count as many times as they act up to k.
        """
        indices = np.atleast_1d(self._checked(k))
        _, errors = self._evaluated(indices)
        return float((errors + EPS / 2 + self._pair_error * (1 + indices)).max(initial=0.0))

    @property
    def terms(self) -> tuple[SequenceTerm, ...]:
        """The closed form of the response to the start and to a force in closed form: sum of Re(v binom(k, j) p^(k - j))."""
        return closed_terms(self._closed) if len(self(0)) else ()

    @property
    def is_trusted(self) -> bool:
        """False where a notice doubts the values."""
        return not any(notice.doubtful for notice in self.notices)

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def _checked(self, k) -> np.ndarray:
        return sample_numbers(k)

    def _evaluated(self, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (r, T) and bounds of their relative errors."""
        return self._from_start(indices.reshape(-1))

    def _from_start(self, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (r, T) and bounds of their relative errors: by a recursion, in balls where that is not accurate enough."""
        known = self._recursive(int(indices.max(initial=0)))
        if known is None:
            return rounded_values([self._closed], self._sums, indices.tolist())
        values, errors = known[0][:, indices], known[1][indices]
        left = np.flatnonzero(~(errors <= SETTLED))
        beyond, count = np.sort(indices[left][~np.isfinite(values[:, left]).all(axis=0)]), 1
        while left.size:
            last = beyond[count - 1] if count <= len(beyond) else np.iinfo(int).max
            some, left, count = left[indices[left] <= last], left[indices[left] > last], 2 * count
            values[:, some], errors[some] = rounded_values([self._closed], self._sums, indices[some].tolist())
            if not np.isfinite(values[:, some]).all():  # beyond the range of float64 later values need no balls
                values[:, left], errors[left], left = np.inf, np.inf, left[:0]
        return values, errors

    def _recursive(self, last: int) -> tuple[np.ndarray, np.ndarray] | None:
        """x_0, x_1, ... up to x_last at least by a recursion and bounds of their relative errors; None where it does not serve."""
        if self._recursion is None:
            return None
        recursion, end = self._recursion
        if end == np.inf:
            count = last + 1
        elif last < end:
            count = int(end)
        elif recursion.cost * (count := 1 << last.bit_length()) > FEW_PRODUCTS * len(recursion.shifts):
            return None
        if count not in self._windows:
            forces, before = self._forces(count)
            values, errors = refined(recursion, forces)
            self._windows[count] = values[:, before : before + count], errors[before : before + count]
        return self._windows[count]

    @cached_property
    def _windows(self) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Samples by recursion of as many as were computed together."""
        return {}

    @property
    def _recursion(self) -> tuple[ShiftRecursion, float] | None:
        """The recursion and the number of given values of the force; None for closed forms."""
        return None

    def _forces(self, count: int) -> tuple[DoubleDouble, int]:
        """The force that determines x_0 ... x_(count - 1), and how many of its values come before k = 0."""
        raise NotImplementedError

    @property
    @abstractmethod
    def _closed(self) -> RationalResponse:
        """The response to the start and to a force in closed form."""

    @property
    @abstractmethod
    def _sums(self) -> tuple[ForceSums, ...]:
        """The response to a force that is given by its values."""

    @property
    def _pair_error(self) -> float:
        """Relative error of one step by the Jordan pairs; 0.0 where numbers are taken as exact."""
        return 0.0


@dataclass(frozen=True, repr=False, eq=False)
class DiscreteResponse(DiscreteFunction):
    """The solution x_k of A(sigma) x_k = f_k for k = 0, 1, ...: ``y(k)`` of a number or of numbers k.

    Attributes:
        polynomial_matrix: A(z).
        initial: the given x_0 ... x_(q-1), shape (q, r); zeros where none were given.
        final: the given x_(N-q+1) ... x_N, shape (q, r), or None.
        horizon: N, or None.
        is_given: whether the start was given.
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: DiscreteForce = field(repr=False)
    horizon: int | None
    final: np.ndarray | None
    is_given: bool
    equations: ExactInverse = field(repr=False)

    def _summary(self) -> str:
        end = "" if self.horizon is None else f", k = 0 ... {self.horizon}"
        return f"{counted(self.polynomial_matrix.size, 'coordinate')}, degree {self.polynomial_matrix.degree}{end}"

    def of(self, *coordinates: str | int) -> Callable[..., np.ndarray]:
        """The function k -> values of some coordinates, by name or index from 0."""
        places = places_of(coordinates, self.polynomial_matrix.coordinates, "coordinate")
        return lambda k: self(k)[places]

    def _checked(self, k) -> np.ndarray:
        indices = super()._checked(k)
        if self.horizon is not None and indices.size and indices.max() > self.horizon:
            raise InputError(f"k: found {indices.max()}; the horizon ends at k = {self.horizon}")
        return indices

    @property
    def _pair_error(self) -> float:
        return 0.0 if self.equations.is_exact else EPS * self.equations.pairs.finite.coupling

    def _evaluated(self, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (r, T) and bounds of their relative errors."""
        if not self.polynomial_matrix.size:
            return np.zeros((0, indices.size)), np.zeros(indices.size)
        values, errors = super()._evaluated(indices)
        for column, k in enumerate(indices.reshape(-1).tolist()):
            if self._backward and self.horizon - k < len(self._backward):
                (forward,) = exact_values([self._closed], self._sums, [k])
                backward = self._backward[self.horizon - k]
                (total,) = without_cancelled([[a + b for a, b in zip(forward, backward)]], [forward, *self._backward])
                values[:, column] = [float(fraction(entry)) for entry in total]
                errors[column] = 0.0
        return values, errors

    @cached_property
    def _closed(self) -> RationalResponse:
        """The response to the start and to a force in closed form."""
        force = self.force
        return response_to(self.equations.inverse, self.polynomial_matrix, self.initial, force.closed, force.matrix)

    @property
    def _recursion(self) -> tuple[ShiftRecursion, float] | None:
        force, recursion = self.force, self.equations.recursion
        if recursion is None or (force.closed is not None and (force.end or self.polynomial_matrix.size < MANY_COORDINATES)):
            return None
        return recursion, force.end

    def _forces(self, count: int) -> tuple[DoubleDouble, int]:
        forces = self.force.samples(count + self.equations.look_ahead)
        return with_start(self.polynomial_matrix.coefficients, self.initial, forces), self.polynomial_matrix.degree

    @cached_property
    def _sums(self) -> tuple[ForceSums, ...]:
        """The response to a force that is given by its values."""
        if self.force.closed is not None or not self.force.end:
            return ()
        return (ForceSums(self.equations.columns, self.force.exact, self.force.end),)

    @cached_property
    def _backward(self) -> list[list]:
        """The part that runs backwards from the end, at k = N, N - 1, ...: the zeros at z = 0 of the dual matrix, as exact numbers."""
        if self.final is None:
            return []
        A, N = self.polynomial_matrix, self.horizon
        free = exact_values([self._closed], self._sums, list(range(N, N - A.degree, -1)))
        difference = [[rational(given) - own for given, own in zip(*rows)] for rows in zip(self.final[::-1].tolist(), free)]
        dual = ExactInverse(A.dual, self.equations.rank_tolerance)
        difference = without_cancelled(difference, [*free, *difference])
        rows = response_to(dual.inverse, A.dual, np.array(difference, dtype=object).reshape(self.final.shape), None).at_zero
        return without_cancelled(rows, rows)

    # The given values against the solution.

    @cached_property
    def start(self) -> np.ndarray:
        """x_0 ... x_(q-1) of the solution, shape (q, r)."""
        return self(np.arange(self.polynomial_matrix.degree)).T if self.polynomial_matrix.degree else self.initial

    @property
    def end(self) -> np.ndarray | None:
        """x_(N-q+1) ... x_N of the solution, shape (q, r); None without a horizon."""
        q = self.polynomial_matrix.degree
        return None if self.horizon is None else self(np.arange(self.horizon - q + 1, self.horizon + 1)).T

    @cached_property
    def correction(self) -> np.ndarray:
        """The start of the solution less the given one, shape (q, r): zero where the equations admit the given values."""
        if not self._fits_start:
            return self.start - self.initial
        return np.zeros(self.initial.shape)

    @cached_property
    def _fits_start(self) -> bool:
        """Whether x_0 ... x_(q-1) satisfy the equations to rounding errors; nothing was given that could not."""
        if not self.is_given or not self.initial.size:
            return True
        if self._backward or self._taylor is None:
            return _agree(self.start, self.initial, self._scale)
        from .solve import solve

        try:
            x = solve(self.polynomial_matrix, self.initial, self._taylor, self.equations.rank_tolerance)
            return not x.jump.any() and not x.impulses
        except (IllConditioned, Overflow):
            return _agree(self.start, self.initial, self._scale)

    @property
    def _scale(self) -> float:
        """The size of given values and forces."""
        return float(np.abs(self.initial).max(initial=0.0))

    @cached_property
    def _taylor(self) -> ImpulsiveSmooth | None:
        """The force whose derivatives at 0+ are f_0, f_1, ...: with it the start is that of a differential equation."""
        A = self.polynomial_matrix
        count = A.degree + self.equations.look_ahead + 1
        if count > MOST_SHIFTS:
            return None
        return sum((power(self.force(k), k + 1) for k in range(count) if self.force(k).any()), zero(A.size))

    @cached_property
    def violations(self) -> tuple[Violation, ...]:
        """Conditions that the given start violates: combinations of the equations that contain no later values."""
        if self._fits_start or self._taylor is None:
            return ()
        try:
            return admissible(self.polynomial_matrix, self.initial, self._taylor).violations
        except (IllConditioned, Overflow):
            return ()

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Values that the equations do not admit with the violated conditions, growth, doubtful rank decisions."""
        return (*self._start_notices(), *self._end_notices(), *self._structure_notices())

    def _start_notices(self):
        names = self.polynomial_matrix.coordinates
        changed = np.argwhere(self.correction)
        for k, i in changed[:MOST_NAMED]:
            text = f"{names[i]}: its value at k = {k} is {self.start[k, i]:.6g}, not the given {self.initial[k, i]:.6g}: the equations do not admit it"
            yield Notice(NoticeKind.JUMP, text)
        if len(changed) > MOST_NAMED:
            yield Notice(NoticeKind.JUMP, f"so are {len(changed) - MOST_NAMED} other values of the start")
        for violation in self.violations[:MOST_NAMED]:
            yield Notice(NoticeKind.JUMP, condition_text(violation))

    def _end_notices(self):
        if self.final is None or not self.final.size:
            return
        own, names = self.end, self.polynomial_matrix.coordinates
        scale = max(float(np.abs(self.final).max(initial=0.0)), float(np.abs(own).max(initial=0.0)))
        changed = np.argwhere(np.abs(own - self.final) > noise_of(scale, own.size) * 2**10)
        first = self.horizon - self.polynomial_matrix.degree + 1
        for k, i in changed[:MOST_NAMED]:
            text = (
                f"{names[i]}: its value at k = {first + k} is {own[k, i]:.6g}, not the given {self.final[k, i]:.6g}: the start and "
                "the force determine it, only the part that runs backwards is free at the end"
            )
            yield Notice(NoticeKind.JUMP, text)
        if len(changed) > MOST_NAMED:
            yield Notice(NoticeKind.JUMP, f"so are {len(changed) - MOST_NAMED} other values of the end")

    def _structure_notices(self):
        from .response_notices import pair_notices

        pairs = self.equations.pairs
        if pairs is None:
            return
        yield from (notice for notice in pair_notices(pairs) if notice.doubtful)
        if not self.equations.is_exact:
            count = regular_matrix(self.polynomial_matrix).determinant.degree()
            text = (
                f"the numbers as given have {counted(count, 'finite zero')}, the solution {len(pairs.form.T)}: differences of the size "
                "of rounding errors were taken as zero"
            )
            yield Notice(NoticeKind.RANK, text, doubtful=True)
            yield from doubts_of("x_k at k = 1000", self.error_estimate(1000) if self.horizon is None else 0.0)
        yield from growth_notices([zero.value for zero in pairs.finite.zeros])


def growth_notices(eigenvalues) -> tuple[Notice, ...]:
    """The notice of eigenvalues outside the unit circle, of each complex pair one."""
    moduli = np.array([abs(complex(value)) for value in eigenvalues])
    growing = moduli[moduli > 1 + EPS**0.5]
    if not len(growing):
        return ()
    text = f"{counted(len(growing), 'eigenvalue')} outside the unit circle: the sequence grows, fastest like {growing.max():.6g}^k"
    return (Notice(NoticeKind.UNSTABLE, text),)


def _agree(one: np.ndarray, other: np.ndarray, scale: float) -> bool:
    return bool((np.abs(one - other) <= noise_of(max(scale, float(np.abs(one).max(initial=0.0))), one.size) * 2**10).all())


def condition_text(violation: Violation) -> str:
    """A violated condition in the words of discrete time: which equations at which k, on which values."""
    leading, *others = (f'"{name}" at k = {order}' for name, order in violation.equations)
    together = f" together with {', '.join(others)}" if others else ""
    values = ", ".join(f'"{name}" at k = {order}' for name, order in violation.coordinates)
    involved = f", on {values}" if values else ""
    return (
        f"condition {violation.number}: the equation {leading}{together}{involved}, does not hold for the given start: the left side "
        f"less the right is {violation.amount:.6g}"
    )


def solve_discrete(
    A: PolynomialMatrix,
    initial=None,
    force: Force = None,
    horizon: int | None = None,
    *,
    final=None,
    rank_tolerance: float | None = None,
) -> DiscreteResponse:
    """Solve A(sigma) x_k = A_0 x_k + A_1 x_(k+1) + ... + A_q x_(k+q) = f_k for k = 0, 1, ... in closed form.

        x_k = C J^k w + sum over i < k of C J^(k-1-i) B f_i + sum over i >= 0 of H_i f_(k+i)

    with the finite Jordan pair (C, J, B) of A(z), which runs forwards from the start, and H_i of the infinite one, which looks
    ahead (``response.discrete``). Powers are balls by repeated squaring, with more digits until float64 is reached: x at k = 10^6
    costs what x at k = 20 costs, and has as many digits.

    A start that the equations do not admit is never repaired in silence: in discrete time there are no impulses, x_0 ... x_(q-1) of
    the solution differ from the given ones (``correction``), by the projection along the infinite part as for differential equations,
    and ``notices`` name the values and the violated conditions.

    Args:
        A: the polynomial matrix, degree q, size r; its leading coefficient may be singular.
        initial: x_i as row i, i = 0 ... q - 1, shape (q, r) as in ``mb.solve``; a list of numbers where q or r is 1; None for a start
            from rest: no forward part but that of the force, and nothing to admit.
        force: f_0, f_1, ... as rows, shape (N, r), zero afterwards; or a function k -> (r,); or a sequence in closed form
            (``mb.geometric``); or a signal, sampled at t = k (``mb.step``, ``mb.harmonic`` ...). None for zero.
        horizon: N: the equations hold for k = 0 ... N - q, and x_k is sought for k = 0 ... N. Then the part of the infinite pair is
            free at the end.
        final: with a horizon, x_(N-q+1) ... x_N as rows; the backward part is taken from them. None: it follows from the
            force beyond the horizon, zero where there is none.
        rank_tolerance: as in ``mb.solve``.

    Returns:
        A ``DiscreteResponse``: ``y(k)``, ``y.start``, ``y.correction``, ``y.violations``, ``y.notices``, ``y.error_estimate(k)``.

    Raises:
        InputError: shapes that do not fit, numbers that are not finite, a horizon shorter than q.
        SingularPolynomialMatrix: det A(z) = 0 for every z.

    >>> from mbconstrained import PolynomialMatrix, geometric
    >>> fibonacci = solve_discrete(PolynomialMatrix([[[-1.0]], [[-1.0]], [[1.0]]]), initial=[[0.0], [1.0]])
    >>> [int(x) for x in fibonacci([5, 6, 7, 70])[0]]
    [5, 8, 13, 190392490709135]
    >>> ahead = PolynomialMatrix([[[1.0, 0.0], [0.0, 1.0]], [[0.0, -1.0], [0.0, 0.0]]])  # x1_k = x2_(k+1), x2_k = f_k
    >>> solve_discrete(ahead, force=[[0.0, 3.0], [0.0, 5.0]])([0, 1])
    array([[5., 0.],
           [3., 5.]])
    """
    A = checked_matrix(A)
    q, r = A.degree, A.size
    equations = ExactInverse(A, rank_tolerance)
    if equations.by_rows is None:
        regular_matrix(A)
    horizon = None if horizon is None else whole_number(horizon, "horizon", minimum=q)
    if final is not None and horizon is None:
        raise InputError("final: values at the end need a horizon; give horizon=N, the number of the last sample")
    start = np.zeros((q, r)) if initial is None else _rows(initial, q, r, "initial")
    end = None if final is None else _rows(final, q, r, "final")
    return DiscreteResponse(A, start, discrete_force(force, r), horizon, end, initial is not None, equations)


def from_start(A: PolynomialMatrix, start: np.ndarray, force: DiscreteForce, is_given: bool = False) -> DiscreteResponse:
    """The solution from the forward part of a start (q, r); one that is not given, but follows, is not compared with it."""
    return DiscreteResponse(A, start, force, None, None, is_given, ExactInverse(A, None))


def _rows(value, q: int, r: int, what: str) -> np.ndarray:
    """Values (q, r); a list of numbers where q or r is 1."""
    rows = real_array(value, what)
    if rows.shape != (q, r) and rows.ndim < 2 and 1 in (q, r) and rows.size == q * r:
        rows = rows.reshape(q, r)
    if rows.shape != (q, r) and not (q == 0 and not rows.size):
        shape = " x ".join(map(str, rows.shape)) or "a single number"
        raise InputError(f"{what}: expected shape {q} x {r}, one row for each of {q} samples, found {shape}")
    return rows.reshape(q, r)
