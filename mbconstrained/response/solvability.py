"""Solve A(d/dt) x = f for any m x n matrix A(s): conditions on the force and on the values at 0-, and coordinates that are free.

Let r be the rank of A(s). With a minimal polynomial basis N(s) of the left kernel, N(s) A(s) = 0, there is a solution exactly where
N(s) (F(s) + X_in(s)) = 0, X_in of the values at 0-: m - r conditions, differential equations in f alone and equations at t = 0
(Kronecker; Gantmacher, "The theory of matrices", chapter XII). With a basis K(s) of the right kernel, K(s) W(s) may be added to a
solution: n - r coordinates may be chosen whose rows of K(s) are independent.

Then r combinations T of the equations and the choices C are a regular system [T A(s); C] x = [T f; u], which is solved like any other.
T A(s) has no more finite zeros than A(s) where that is possible: others would be excited by rounding errors, and might grow.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..ground.by_name import Public, answering
from ..ground.checks import counted, listed, places_of, real_array
from ..ground.display import Displayed, TextTable, notice_table, number_text, signed, table_text
from ..ground.errors import InputError, NotSolvable, SingularPolynomialMatrix, named, within_float64
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import CLEAR_KEPT, EPS, PROVED_RESTARTS, SHORT_BITS, noise_of
from ..linalg.blocks import block_matrix, zeros_of
from ..linalg.exponential import block_states
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import power, step, zero
from .problem import Problem, checked_force, checked_matrix
from .response import Response

if TYPE_CHECKING:
    from ..exact.rational import RationalMatrix

#: Times within each piece of a force at which a condition is tested, as parts of a finite piece.
PARTS = np.array([0.0, 0.3, 0.7, 0.95])

#: More pieces are tested at these parts alone.
MANY_PIECES = 200

#: Kernels of matrices of up to so many states are exact: some seconds.
MOST_EXACT_STATES = 64

#: The choice of free coordinates with which x(0+) has the least norm.
LEAST_START = "least start"

#: Number of coordinates named in an error.
MOST_NAMES = 12


@dataclass(frozen=True)
class Condition(Public):
    """A combination of equations without coordinates: the same combination of the forces must vanish.

    Attributes:
        equations: the name of each equation in it, with the factors of 1, d/dt, d^2/dt^2, ... that are applied to the equation.
        coordinates: those whose values at 0- enter.
        size: by how much it is violated: the right side that is not zero at ``time``, or the largest one where it starts from zero; at t = 0
            the factor of an impulse. 0.0 where it is satisfied.
        time: the first time in s at which it is violated; None where it is satisfied.
        impulse: order of the derivative of Dirac's delta at ``time``; None where a function of time remains.
        relative: size relative to the terms that should cancel.
        is_doubtful: True where rounding errors of the data leave open whether it is satisfied.
    """

    equations: tuple[tuple[str, tuple[float, ...]], ...]
    coordinates: tuple[str, ...] = ()
    size: float = 0.0
    time: float | None = None
    impulse: int | None = None
    relative: float = 0.0
    is_doubtful: bool = False

    @property
    def is_satisfied(self) -> bool:
        """True where forces and values at 0- satisfy it to rounding errors."""
        return self.time is None

    @property
    def combination(self) -> str:
        """The combination of equations as text."""
        return sum_text((coefficients, f'"{name}"') for name, coefficients in self.equations)

    @property
    def text(self) -> str:
        """One sentence on the condition."""
        if self.time is None:
            return f"{self.combination}: satisfied"
        when, size = f"t = {number_text(self.time)} s", number_text(self.size)
        if self.impulse is None:
            what = f"is {size} from {when} on"
        else:
            delta = "an impulse" if not self.impulse else f"the derivative of order {self.impulse} of an impulse"
            start = f", with the values of {', '.join(self.coordinates)} at 0-" if self.coordinates and self.time == 0 else ""
            what = f"has {delta} of size {size} at {when}{start}"
        doubt = f"; relative to its terms that is {self.relative:.1g}, which rounding errors may cause" if self.is_doubtful else ""
        return f"{self.combination}: the left side is zero for every motion, but the right side {what}{doubt}"


@dataclass(frozen=True, repr=False, eq=False)
class Solvability(Displayed):
    """Whether A(d/dt) x = f has solutions, and which of its coordinates are free.

    Attributes:
        polynomial_matrix: A(s), m x n.
        rank: r, the rank of A(s) for almost every s.
        conditions: the m - r conditions on forces and values at 0-.
        may_be_chosen: coordinates that are not determined by the equations.
        chosen: n - r of them, whose motion is given: those that the user named, then others.
        kernel: n - r motions that no force opposes, each the polynomials of its coordinates, shape (degree + 1, n), lowest power first.
        kept: combinations T of the equations that are solved, shape (r, m).
        completed: the regular matrix [T A(s); C] with rows that choose the coordinates.
        notices: redundant equations, choices that were made, doubtful decisions.
    """

    polynomial_matrix: PolynomialMatrix
    rank: int
    conditions: tuple[Condition, ...]
    may_be_chosen: tuple[str, ...]
    chosen: tuple[str, ...]
    kernel: tuple[np.ndarray, ...]
    kept: np.ndarray
    completed: PolynomialMatrix
    notices: tuple[Notice, ...]

    @property
    def is_solvable(self) -> bool:
        """True where every condition is satisfied."""
        return all(condition.is_satisfied or condition.is_doubtful for condition in self.conditions)

    @property
    def freedom(self) -> int:
        """n - r, the number of coordinates that may be chosen together."""
        return len(self.kernel)

    def _summary(self) -> str:
        m, n = self.polynomial_matrix.shape
        state = "solvable" if self.is_solvable else "not solvable"
        return (
            f"{state}: {counted(m, 'equation')} of rank {self.rank} for {counted(n, 'coordinate')}, "
            f"{counted(len(self.conditions), 'condition')}, {self.freedom} free"
        )

    def _tables(self) -> tuple[TextTable, ...]:
        names = self.polynomial_matrix.coordinates
        conditions = tuple((str(k), one.text) for k, one in enumerate(self.conditions, start=1))
        free = [
            (
                f"w{k}",
                ", ".join(
                    f"{names[i]} = {sum_text([(column[:, i], '')], 'w' + str(k))}" for i in np.flatnonzero(column.any(axis=0))
                ),
            )
            for k, column in enumerate(self.kernel, start=1)
        ]
        choice = f"{counted(self.freedom, 'coordinate')} may be chosen, of {', '.join(self.may_be_chosen)}" if self.freedom else ""
        return (
            TextTable("Conditions: combinations of equations that leave no coordinate", ("", "condition"), conditions),
            TextTable("Motions that no force opposes", ("any", "motion"), tuple(free), choice),
            notice_table(self.notices),
        )

    def summary(self) -> str:
        """The report as text of at most 80 columns."""
        head = f"A(d/dt) x = f is {self._summary()}"
        return "\n".join([table_text(TextTable(head, (), ())), *(table_text(table) for table in self._tables() if table.rows)])


def sum_text(terms, variable: str = "") -> str:
    """A sum of polynomials in d/dt, coefficients lowest power first, times names, as text.

    >>> sum_text([((0, 2.0), '"rod 1"'), ((-1.0,), '"rod 2"')])
    '2 d/dt "rod 1" - "rod 2"'
    """
    text = ""
    for coefficients, name in terms:
        powers = [(float(c), power) for power, c in enumerate(coefficients) if c][::-1]
        parts = [(c, "d/dt" if power == 1 else f"d^{power}/dt^{power}" if power else "") for c, power in powers]
        if len(parts) > 1:
            inner = "".join(
                signed(c, number_text(abs(c)) if not of or abs(c) != 1 else "", of, bool(k)) for k, (c, of) in enumerate(parts)
            )
            parts = [(1.0, f"({inner})")]
        for c, of in parts:
            number = number_text(abs(c)) if abs(c) != 1 or not (of or name or variable) else ""
            text += signed(c, number, " ".join(filter(None, (of, name, variable))), bool(text))
    return text or "0"


@answering
def solvability(
    A: PolynomialMatrix,
    initial=None,
    force: ImpulsiveSmooth | None = None,
    free: Mapping | None = None,
    rank_tolerance: float | None = None,
) -> Solvability:
    """Report whether A(d/dt) x = f has solutions from values at 0-, and which coordinates are free, for any m x n matrix A(s).

    There is a solution exactly where N(s) (F(s) + X_in(s)) = 0 for a minimal basis N(s) of the left kernel of A(s) (Gantmacher, "The
    theory of matrices", chapter XII); rank and kernels are those of the exact numbers.

    Args:
        A: the polynomial matrix, degree q, m x n.
        initial: x^(i)(0-) as row i, shape (q, n); None for zeros.
        force: f with m rows as in ``solve``, in the units of the equations; None for zero.
        free: coordinates to choose, by name, with their signals; others are chosen where these are not enough.
        rank_tolerance: conditions count as satisfied up to this part of their terms; None for rounding errors of float64.

    Returns:
        A ``Solvability``: .is_solvable, .conditions, .may_be_chosen, .kernel, .completed.

    Raises:
        InputError: shapes that do not fit, coordinates that are not free.
        IllConditioned: float64 does not determine the rank.

    >>> A = PolynomialMatrix([[[0.0], [1.0]], [[1.0], [0.0]]], equations=["speed", "place"])  # x' = f1, x = f2
    >>> print(solvability(A, force=step([0.0, 3.0]) + step([0.0, 2.0]).delayed(1.0)).summary())
    A(d/dt) x = f is not solvable: 2 equations of rank 1 for 1 coordinate, 1
      condition, 0 free
    Conditions: combinations of equations that leave no coordinate
         condition
      1  "speed" - d/dt "place": the left side is zero for every motion, but the
         right side has an impulse of size -3 at t = 0 s, with the values of x1 at
         0-
    """
    return _completed(A, initial, force, free or {}, rank_tolerance)[0]


def completed(
    A: PolynomialMatrix,
    initial=None,
    force: ImpulsiveSmooth | None = None,
    free: Mapping | str | None = None,
    rank_tolerance: float | None = None,
) -> tuple[Problem, Solvability]:
    """The regular problem whose solution is x, with the report; NotSolvable, or SingularPolynomialMatrix where free is None and needed."""
    if isinstance(free, str):
        free = _least_start(*completed(A, initial, force, {}, rank_tolerance), free)
    report, problem = _completed(A, initial, force, free or {}, rank_tolerance)
    if not report.is_solvable:
        raise NotSolvable(_refusal(report), report.conditions)
    if report.freedom and free is None:
        raise SingularPolynomialMatrix(
            _undetermined(report), (), tuple(places_of(report.may_be_chosen, A.coordinates, "coordinate"))
        )
    return replace(problem, notices=report.notices), report


def _least_start(problem: Problem, report: Solvability, word: str) -> dict[str, ImpulsiveSmooth]:
    """Polynomials in t as motions of the chosen coordinates, with which x(0+) has the least norm."""
    if word != LEAST_START:
        raise InputError(f"free: found {word!r}; expected {LEAST_START!r}, or signals by names of coordinates")
    A, orders = report.completed, range(1, 1 + max(map(len, report.kernel), default=0))
    units = np.eye(A.size)[report.rank :]
    inputs = [power(unit, order) for unit in units for order in orders]
    start = Response._solved(problem)(0.0)
    changes = [Response._solved(Problem(A, np.zeros_like(problem.initial), one, problem.rank_tolerance))(0.0) for one in inputs]
    weights = np.linalg.lstsq(np.array(changes).reshape(-1, A.size).T, -start)[0].reshape(len(units), -1)
    return {
        name: sum((power([weight], order) for weight, order in zip(row, orders)), start=zero(1))
        for name, row in zip(report.chosen, weights)
    }


def _refusal(report: Solvability) -> str:
    violated = [condition for condition in report.conditions if not condition.is_satisfied]
    texts = "; ".join(condition.text for condition in violated)
    least = max(condition.relative for condition in violated)
    remedy = f". If the data are measured, rank_tolerance={2 * least:.0e} accepts them" if least < EPS**0.5 else ""
    return f"A(d/dt) x = f has no solution: {texts}. Correct the forces or the values at 0-, or leave an equation out{remedy}."


def _undetermined(report: Solvability) -> str:
    names = listed([f'"{name}"' for name in report.may_be_chosen], MOST_NAMES)
    return (
        f"the equations leave {counted(report.freedom, 'coordinate')} free, of {names}: give free={{name: signal}}, or free={{}} for "
        "zero motions of coordinates that are chosen automatically; mb.solvability(A) shows the free motions"
    )


# Rank, kernels and the completed system.


@dataclass(frozen=True, eq=False)
class _Kernels:
    """Rank and minimal bases of the kernels of A(s).

    Attributes:
        coefficients: the numbers that they belong to, Fractions, shape (q + 1, m, n).
        rank: of A(s).
        left, right: polynomial vectors, shapes (degree + 1, m) and (degree + 1, n).
        noise: rounding errors of the vectors relative to them; 0.0 where they are exact.
    """

    coefficients: np.ndarray
    rank: int
    left: list[np.ndarray]
    right: list[np.ndarray]
    noise: float = 0.0


def _kernels(A: PolynomialMatrix, rank_tolerance: float | None) -> _Kernels:
    """Kernels from exact numbers whose rank and minimal indices are those to rounding errors; others, and large ones, from float64.

    Numbers such as 0.1 are no binary fractions: where their rounding errors make equations independent, the decimals are taken.
    """
    from ..exact.rational import RationalMatrix

    binary = _fractions(A.exact_coefficients)
    is_small = A.degree * max(A.shape) <= MOST_EXACT_STATES
    if is_small and rank_tolerance is None and all(entry.numerator.bit_length() <= SHORT_BITS for entry in binary.ravel().tolist()):
        return _exact_kernels(binary, RationalMatrix(binary))
    structure = A.structure(rank_tolerance)
    expected = structure.left_minimal_indices, structure.right_minimal_indices
    for numbers in (binary, _fractions(A.coefficients, lambda entry: Fraction(repr(entry)))) if is_small else ():
        if (matrix := RationalMatrix(numbers)).rank == structure.rank:
            kernels = _exact_kernels(numbers, matrix)
            if expected == tuple(tuple(len(vector) - 1 for vector in side) for side in (kernels.left, kernels.right)):
                return kernels
    left, right = (
        [_fractions(vector.coefficients) for vector in vectors] for vectors in (structure.left_kernel, structure.right_kernel)
    )
    return _Kernels(_fractions(A.exact_coefficients), structure.rank, left, right, EPS**0.5)


def _exact_kernels(numbers: np.ndarray, matrix: RationalMatrix) -> _Kernels:
    """Rank and kernels of exact numbers, and of the matrix of FLINT that has them."""
    from ..exact.kernels import whole_basis

    return _Kernels(numbers, matrix.rank, whole_basis(matrix.transposed), whole_basis(matrix))


def _fractions(array: np.ndarray, exact=Fraction) -> np.ndarray:
    result = np.empty(array.shape, dtype=object)
    result.ravel()[:] = [exact(entry) for entry in array.ravel().tolist()]
    return result


def _completed(A, initial, force, free: Mapping, rank_tolerance: float | None) -> tuple[Solvability, Problem]:
    from ..exact.kernels import best_rows, floats

    (m, n), q = checked_matrix(A).shape, A.degree
    initial = np.zeros((q, n)) if initial is None else real_array(initial, "initial", shape=(q, n))
    force = checked_force(force, m, A)
    kernels = _kernels(A, rank_tolerance)
    rank, left, right = kernels.rank, kernels.left, kernels.right
    required, signals = _checked_free(A, right, free)
    chosen = best_rows(right, required, most=True, noise=kernels.noise)[0] if right else ()
    notices: list[Notice] = []
    kept, completed = _regular(A, kernels, chosen, notices)
    with within_float64():
        conditions = tuple(_condition(A, row, initial, force, rank_tolerance) for row in left)
    notices += _notices(A, conditions, kept, chosen, required)
    load = force.mapped(np.vstack([kept, np.zeros((n - rank, m))]))
    for place, signal in signals.items():
        load = load + signal.mapped(np.eye(n)[:, [rank + chosen.index(place)]])
    may = tuple(A.coordinates[i] for i in range(n) if any((column[:, i] != 0).any() for column in right))
    kernel = tuple(map(floats, right))
    names = tuple(A.coordinates[i] for i in chosen)
    report = Solvability(A, rank, conditions, may, names, kernel, kept, completed, tuple(notices))
    return report, Problem(completed, initial, load, rank_tolerance)


def _checked_free(A: PolynomialMatrix, right: Sequence[np.ndarray], free: Mapping) -> tuple[list[int], dict[int, ImpulsiveSmooth]]:
    """Places of the coordinates that the user chooses, with their signals of one row."""
    from ..exact.kernels import independent_rows

    if not isinstance(free, Mapping):
        raise InputError(
            f"free: found {type(free).__name__}; expected signals by names of coordinates, such as {{'x3': mb.step([1.0])}}"
        )
    if not free:
        return [], {}
    with named("free"):
        places = places_of(free, A.coordinates, "coordinate")
        quoted = [f'"{A.coordinates[i]}"' for i in places]
        if not right:
            raise InputError(f"the equations determine every coordinate, {', '.join(quoted)} too; leave it out")
        may = [name for i, name in enumerate(A.coordinates) if any((column[:, i] != 0).any() for column in right)]
        choices = listed(may, MOST_NAMES)
        for place in places:
            if A.coordinates[place] not in may:
                raise InputError(f'"{A.coordinates[place]}" is determined by the equations; choose of {choices}')
        if len(places) > len(right):
            raise InputError(f"found {', '.join(quoted)}; {counted(len(right), 'coordinate')} may be chosen, of {choices}")
        if independent_rows(right, places) < len(places):
            raise InputError(f"{', '.join(quoted)} determine each other and cannot all be chosen; choose of {choices}")
    signals = {}
    for place, (name, signal) in zip(places, free.items()):
        with named(f"free: {name}"):
            if np.isscalar(signal) or (np.ndim(signal) == 0 and not isinstance(signal, ImpulsiveSmooth) and signal is not None):
                signal = step(real_array([signal], "value"))
            signals[place] = checked_signal(signal)
    return places, signals


def checked_signal(signal) -> ImpulsiveSmooth:
    """A signal with one row, zero for None."""
    if isinstance(signal, ImpulsiveSmooth) and signal.size != 1:
        raise InputError(f"the signal has {signal.size} rows; expected 1")
    return zero(1) if signal is None else checked_force(signal, 1)


def _regular(A: PolynomialMatrix, kernels: _Kernels, chosen, notices: list[Notice]) -> tuple[np.ndarray, PolynomialMatrix]:
    """The combinations T, and [T A(s); C]."""
    from ..exact.kernels import best_rows, combinations_without_zeros, floats

    (m, n), count, left = A.shape, A.shape[1] - len(chosen), kernels.left
    T = np.eye(m, dtype=int) + Fraction(0)
    if left:
        dropped, determinant = best_rows(left, noise=kernels.noise)
        T = np.delete(T, dropped, axis=0)
        combined = None
        if len(determinant) > 1:
            combined = _orthonormal_combinations(left) if kernels.noise else combinations_without_zeros(left)
        if combined is not None:
            T = combined
        elif len(determinant) > 1:
            notices.append(_additional(np.roots(determinant[::-1])))
    kept = np.array([floats(row) for row in T]).reshape(T.shape)
    names = [
        sum_text(((t,), f'"{A.equations[i]}"') for i, t in enumerate(row) if t)
        if np.count_nonzero(row) > 1
        else A.equations[int(row.argmax())]
        for row in kept
    ]
    choices = np.eye(n)[list(chosen)]
    coefficients = np.zeros((A.degree + 1, n, n))
    uncertainty = np.zeros_like(coefficients)
    is_selection = not left or (np.count_nonzero(kept, axis=1) == 1).all()
    if is_selection:
        coefficients[:, :count] = kept @ A.coefficients
    else:
        product = np.array([_fractions(kept) @ matrix for matrix in kernels.coefficients])
        coefficients[:, :count] = product.astype(float)
        inexact = (_fractions(coefficients[:, :count]) != product) | (np.abs(T).max() > 2**53)
        uncertainty[:, :count] = EPS * np.abs(coefficients[:, :count]) * inexact
    uncertainty[:, :count] = np.maximum(uncertainty[:, :count], np.abs(kept) @ A.uncertainty)
    if kernels.noise:
        uncertainty = np.maximum(uncertainty, EPS * np.abs(coefficients))
    coefficients[0, count:] = choices
    matrices: list = list(coefficients)
    if is_selection:
        for power, factors in enumerate(A.factors):
            if factors is not None:
                matrices[power] = _with_choices(factors, kept, choices if power == 0 else 0.0 * choices)
    chosen_names = [f"choice of {A.coordinates[i]}" for i in chosen]
    return kept, PolynomialMatrix(matrices, A.coordinates, [*names, *chosen_names], uncertainty if uncertainty.any() else None)


def _orthonormal_combinations(left: list[np.ndarray]) -> np.ndarray | None:
    """``combinations_without_zeros`` of vectors with rounding errors: N(s) B is the unit matrix, T orthonormal."""
    from ..exact.kernels import floats, stacked

    matrix = stacked([_fractions(floats(vector) / np.abs(floats(vector)).max()) for vector in left]).astype(float)
    higher = matrix[1:].transpose(0, 2, 1).reshape(-1, matrix.shape[1])
    _, sizes, rows = np.linalg.svd(higher)
    space = rows[int((sizes > EPS**0.5 * sizes.max(initial=0.0)).sum()) :].T
    lowest = matrix[0].T @ space
    if np.linalg.matrix_rank(lowest, tol=EPS**0.5) < len(left):
        return None
    u, _, _ = np.linalg.svd(space @ np.linalg.pinv(lowest))
    return _fractions(u[:, len(left) :].T)


def _with_choices(factors: Factors, kept: np.ndarray, choices: np.ndarray) -> Factors:
    """The elements of a coefficient in the rows that are kept, and rows of choices below them."""
    count, rows = len(choices), kept.argmax(axis=1)
    left = np.zeros((len(rows) + count, factors.left.shape[1] + count), dtype=object)
    left[: len(rows), : factors.left.shape[1]] = factors.left[rows]
    left[len(rows) :, factors.left.shape[1] :] = np.eye(count, dtype=int)
    return Factors(left.astype(factors.left.dtype), np.append(factors.values, np.ones(count)), np.vstack([factors.right, choices]))


def _additional(roots: np.ndarray) -> Notice:
    """The notice of zeros that are none of A(s)."""
    growing = roots[roots.real > 0]
    text = f"the equations that are solved have {counted(len(roots), 'more eigenvalue')} than all together"
    if growing.size:
        text += f", and rounding errors of the data grow like e^({number_text(growing.real.max())} t)"
    return Notice(NoticeKind.RANK, text, doubtful=bool(growing.size))


def _notices(A: PolynomialMatrix, conditions, kept: np.ndarray, chosen, required) -> Iterator[Notice]:
    used = {A.equations[row] for row in np.flatnonzero(kept.any(axis=0))}
    for condition in conditions:
        own = [name for name, _ in condition.equations if name not in used]
        what = f'"{own[0]}" follows from the others and is left out: ' if len(own) == 1 else "redundant equations, satisfied: "
        if condition.is_satisfied:
            yield Notice(NoticeKind.REDUNDANT, f"{what}{condition.combination} leaves no coordinate and no force")
        elif condition.is_doubtful:
            yield Notice(NoticeKind.REDUNDANT, condition.text, doubtful=True)
    for place in chosen:
        if place not in required:
            yield Notice(NoticeKind.FREE, f"{A.coordinates[place]}: the equations leave it free; its motion was chosen to be zero")


# Conditions: N(s) (F(s) + X_in(s)) = 0, row by row, with rounding errors from the sizes of all terms.


@dataclass(frozen=True)
class _Residual:
    """A value that must vanish, with the sum of the magnitudes of its terms: at a time, or the factor of an impulse there."""

    time: float
    start: float
    order: int | None
    value: float
    terms: float

    @property
    def relative(self) -> float:
        """The value relative to its terms, of which one at least is not zero."""
        return abs(self.value) / self.terms


def _condition(
    A: PolynomialMatrix, row: np.ndarray, initial: np.ndarray, force: ImpulsiveSmooth, tolerance: float | None
) -> Condition:
    from ..exact.kernels import floats

    n = floats(row)
    used = np.flatnonzero(n.any(axis=0))
    equations = tuple((A.equations[i], tuple(np.trim_zeros(n[:, i], "b").tolist())) for i in used)
    moving = A.coefficients[1:][:, used].any(axis=(0, 1)) if A.degree else np.zeros(A.shape[1], bool)
    condition = Condition(equations, tuple(A.coordinates[i] for i in np.flatnonzero(moving)))
    residuals = [*_impulse_residuals(A, n, initial, force), *_function_residuals(n, force)]
    bound = max(noise_of(1.0, n.size * (A.degree + 1)), tolerance or 0.0)
    broken = [one for one in residuals if one.relative > bound]
    clear = [one for one in broken if one.relative > CLEAR_KEPT * bound]
    if broken and not clear and tolerance is None:
        broken = _settled(row, A, initial, force, broken)
        clear = [one for one in broken if one.relative > CLEAR_KEPT * bound]
    if not broken:
        return condition
    begin = min(one.start for one in clear or broken)
    first = [one for one in clear or broken if one.start == begin]
    worst = max(first, key=lambda one: (one.order is not None, one.relative))
    if worst.order is None:  # the value from the beginning where there is one
        now = [one for one in first if one.order is None and one.time == begin]
        worst = now[0] if now else max((one for one in first if one.order is None), key=lambda one: abs(one.value))
    return replace(condition, size=worst.value, time=begin, impulse=worst.order, relative=worst.relative, is_doubtful=not clear)


def _function_residuals(n: np.ndarray, force: ImpulsiveSmooth) -> Iterator[_Residual]:
    """Values of sum of N_k f^(k) at times within each piece of the force."""
    smooth = force.smooth
    if not len(smooth.blocks) or smooth.is_zero:
        return
    J, C = block_matrix(smooth.blocks), smooth.coefficients
    rows, sizes = np.zeros((1, len(J))), np.zeros((1, len(J)))
    derivative, size = C, np.abs(C)
    for part in n:
        rows, sizes = rows + part @ derivative, sizes + np.abs(part) @ size
        derivative, size = derivative @ J, size @ np.abs(J)
    restarts, rates = smooth.restarts, np.abs(zeros_of(smooth.blocks))
    moving = rates[rates > 0]
    fastest, slowest = (moving.max(), moving.min()) if moving.size else (1.0, 1.0)
    since = np.append(0.0, np.geomspace(0.1 / fastest, 10.0 / slowest, 8 + len(J)))
    gaps = np.append(restarts.gaps, np.inf)
    for piece, gap in enumerate(gaps):
        own = since if len(gaps) <= MANY_PIECES or gap == np.inf else since[:0]
        times = own if gap == np.inf else np.unique([*own[own < gap], *(PARTS * gap)])
        states = block_states(smooth.blocks, restarts.states[:, [piece]], times)
        drift = 1.0 + np.array([np.abs(block).max() for block in smooth.blocks for _ in block])[:, None] * times
        values, terms = (rows @ states)[0], (sizes @ (np.abs(states) * drift))[0]
        knot = float(restarts.knots[piece])
        for time, value, term in zip(times, values, terms):
            if np.isfinite(value) and np.isfinite(term) and term > 0:
                yield _Residual(knot + time, knot, None, float(value), float(term))


def _impulse_residuals(A: PolynomialMatrix, n: np.ndarray, initial: np.ndarray, force: ImpulsiveSmooth) -> Iterator[_Residual]:
    """Factors of impulses of N(s) (F(s) + X_in(s)) at t = 0 and later."""
    smooth = force.smooth
    restarts, J = smooth.restarts, block_matrix(smooth.blocks)
    impulses = {0.0: force.impulses, **{load.time: load.impulses for load in force.later}}
    jumps = {float(t): jump for t, jump in zip(restarts.knots, restarts.jumps.T)}
    for time in sorted({*impulses, *jumps}):
        vectors: list[tuple[int, np.ndarray, np.ndarray]] = []  # order of the impulse, its factors, sizes of their terms
        jump, derivative, size = jumps.get(time), smooth.coefficients, np.abs(smooth.coefficients)
        for i in range(len(n) - 1) if jump is not None and jump.any() else ():  # the jump of f^(i)
            vectors.append((-1 - i, derivative @ jump, size @ np.abs(jump)))
            derivative, size = derivative @ J, size @ np.abs(J)
        vectors += [(order, vector, np.abs(vector)) for order, vector in enumerate(impulses.get(time, ()))]
        for k, matrix in enumerate(A.coefficients if time == 0 else ()):  # A_k s^(k - 1 - i) x^(i)(0-)
            vectors += [(k - 1 - i, matrix @ initial[i], np.abs(matrix) @ np.abs(initial[i])) for i in range(k)]
        terms: dict[int, list[tuple[float, float]]] = {}
        for order, vector, size in vectors:
            for k, factors in enumerate(n):
                terms.setdefault(order + k, []).append((float(factors @ vector), float(np.abs(factors) @ size)))
        for order, pairs in sorted(terms.items()):
            value, sizes = map(sum, zip(*pairs))
            if sizes > 0 and order >= 0:
                yield _Residual(time, time, order, value, sizes)


def _settled(
    row: np.ndarray, A: PolynomialMatrix, initial: np.ndarray, force: ImpulsiveSmooth, residuals: list[_Residual]
) -> list[_Residual]:
    """The residuals from the exact numbers, without those that vanish; as they are where the force restarts too often."""
    if len(force.knots) > PROVED_RESTARTS:
        return residuals
    from ..exact.enclosure.exact_response import exact_combination

    combined = exact_combination(row, A, initial, force)
    result = []
    for one in residuals:
        if one.order is None:
            (value,), (error,) = (array[0] for array in combined.rounded(np.array([one.time])))
        else:
            impulses = combined.event(one.time)[1]
            value, error = float(impulses[one.order, 0]) if one.order < len(impulses) else 0.0, 0.0
        if abs(value) > error:
            result.append(replace(one, value=float(value)))
    return result
