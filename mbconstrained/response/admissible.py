"""Admissible values at 0-: violated conditions of given values, and the nearest values that satisfy all of them.

Three sets of values lie in each other: those whose motion is continuous (condition (60) of Moysis et al. in its
corrected form), those without impulses (condition (58), with the force taken at 0+), and all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..ground.by_name import answering
from ..ground.checks import counted
from ..ground.display import Displayed, TextTable
from ..ground.errors import OUT_OF_RANGE, IllConditioned, within_float64
from ..linalg.rank import Noisy, columnwise, eliminate
from ..polynomial.decoupling import WeierstrassForm
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.inputs import ImpulsiveSmooth
from .events import inconsistency_of
from .problem import checked_force, checked_matrix, scaled_data
from .response import Response
from .response_notices import derivative_word
from .solve import solve


@dataclass(frozen=True, repr=False, eq=False)
class Admissibility(Displayed):
    """Consequences of values at 0-, and the nearest admissible values.

    Attributes:
        residuals: arrays (r,), one for each condition k = 1 ... q_hat_r of (58), the impulse of order k - 1 that the
            values cause; all zero where they are impulse-free.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r), the residual of (60); all zero where the start is continuous.
        violations: the algebraic conditions implied by the equations that the values violate, each with the equations and
            coordinates involved and the amount (``.text`` is a sentence); empty where the motion is continuous.
        nearest: values (q, r) without impulses, nearest to the given ones.
        nearest_continuous: values (q, r) without impulses and jumps, nearest to the given ones.
        dimensions: of the sets of continuous, of impulse-free and of all values, (n, r q - sum of q_hat_i, r q).
    """

    residuals: tuple[np.ndarray, ...]
    jump: np.ndarray
    violations: tuple[Violation, ...]
    nearest: np.ndarray
    nearest_continuous: np.ndarray
    dimensions: tuple[int, int, int]

    def _summary(self) -> str:
        state = "continuous" if self.is_continuous else "jumps, no impulses" if self.is_impulse_free else "impulses"
        return f"{state}, {counted(len(self.violations), 'violated condition')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (TextTable("Violated conditions", ("condition",), tuple((item.text,) for item in self.violations)),)

    @property
    def is_impulse_free(self) -> bool:
        """True where no condition of (58) is violated."""
        return not any(residual.any() for residual in self.residuals)

    @property
    def is_continuous(self) -> bool:
        """True where (60), as corrected, holds."""
        return self.is_impulse_free and not self.jump.any()


@answering
def admissible(A: PolynomialMatrix, initial=None, force: ImpulsiveSmooth | None = None) -> Admissibility:
    """Test values at 0- against (58) and (60) of Moysis et al., both as corrected: with f^(j)(0+), Toeplitz in (60).

    "Nearest" is the least sum of squares of the changes, each coordinate and derivative measured in the solver's own
    units (``linalg.scaling``), so that the answer does not depend on the user's.

    Args:
        A: the polynomial matrix, degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r); None for zeros.
        force: f with r rows as in ``solve``, None for zero; its own Dirac impulses act for all values at 0- and are left out here.

    Returns:
        An ``Admissibility``.

    Raises:
        InputError, SingularPolynomialMatrix, IllConditioned: as ``solve``.

    >>> A = PolynomialMatrix([[[1.0, -1.0], [-1.0, 1.0]], [[0, 0], [0, 0]], [[0, 0], [0, 1.0]]])  # a massless body on a spring
    >>> admissibility = admissible(A, initial=[[1.0, 0.0], [0.0, 0.0]])
    >>> admissibility.is_impulse_free, admissibility.is_continuous, admissibility.dimensions
    (True, False, (2, 4, 4))
    >>> (violation,) = admissibility.violations
    >>> violation.equations, violation.coordinates, violation.amount
    ((('equation 1', 0),), (('x1', 0), ('x2', 0)), 1.0)
    """
    smooth = checked_force(force, checked_matrix(A).size, A).smooth
    start = solve(A, initial, ImpulsiveSmooth(smooth))
    with within_float64():
        answer = _admissibility(A, start)
    if not (np.isfinite(answer.nearest).all() and np.isfinite(answer.nearest_continuous).all()):
        raise IllConditioned(OUT_OF_RANGE)
    return answer


def _admissibility(A: PolynomialMatrix, start: Response) -> Admissibility:
    form, structure = start.pairs.form, start.pairs.structure
    stack, f, size = scaled_data(form, start.initial, start.force)
    inconsistency = inconsistency_of(form, stack, f)
    g, to_g = size * inconsistency.data, form.infinite_start.data
    to_impulses = _impulse_map(form)
    zeros_at_infinity = sum(max(0, -order) for order in structure.at_infinity)
    residuals = (*start.impulses, *[np.zeros(A.size)] * structure.highest_impulse)[: structure.highest_impulse]
    return Admissibility(
        residuals=residuals,
        jump=start.jump,
        violations=_violations_of(A, form, inconsistency, size, bool(start.impulses)) if start.jump.any() or start.impulses else (),
        nearest=start.initial + _least_change(form, to_impulses @ to_g, to_impulses @ g, zeros_at_infinity, A.degree),
        nearest_continuous=start.initial + _least_change(form, to_g, g, len(g), A.degree),
        dimensions=(structure.finite_count, A.size * A.degree - zeros_at_infinity, A.size * A.degree),
    )


def _impulse_map(form) -> np.ndarray:
    """The impulses, all orders stacked, as a linear map of the inconsistency g: -C2 N^(p + 1)."""
    rows, power = [np.zeros((0, len(form.nilpotent.data)))], np.eye(len(form.nilpotent.data))
    for _ in range(form.highest_impulse):
        power = power @ form.nilpotent.data
        rows.append(-form.C2.data @ power)
    return np.vstack(rows)


def _least_change(form, matrix, residual, rank, q) -> np.ndarray:
    """The least change of the values that makes matrix @ change = -residual, as rows (q, r) in the user's units.

    The rank of the matrix is known from the structure at infinity, so none is guessed.
    """
    scaling, r = form.companion.scaling, form.companion.size
    u, values, vt = np.linalg.svd(matrix, full_matrices=False)
    change = -vt[:rank].T @ ((u[:, :rank].T @ residual) / values[:rank])
    return scaling.columns * change.reshape(form.companion.grade, r)[:q] * scaling.time ** np.arange(q, dtype=float)[:, None]


# Which equations the values at 0- violate, and by how much.
#
# The infinite part N w' = w + B2 f of the decoupled pencil contains the algebraic equations implied by A(d/dt) x = f. Each
# condition g_j = 0 on the values at 0- (condition (60) of Moysis et al., corrected) is the sum over k of N^k B2, row j, times
# the equations differentiated k times: its weights name its origin. The rows are combined by Gauss-Jordan
# elimination, high derivatives first, so that each condition is expressed by the least differentiated and fewest equations:
# a constraint row on positions appears as itself and as its first derivative.

#: Number of named equations and coordinates of a condition, the largest ones.
MOST_NAMED = 4

TIMES = ("", " differentiated once", " differentiated twice")


@dataclass(frozen=True)
class Violation:
    """A condition that the values at 0- do not satisfy.

    Attributes:
        number: number of the condition, from 1; the least differentiated equations come first.
        equations: (name, how many times differentiated), the leading one first.
        coordinates: (name, order of its derivative) that the condition involves, the largest first.
        amount: the leading equation's left side less its right side at 0-, in its units per s^(times differentiated).
        impulsive: whether it causes Dirac impulses; otherwise jumps only.
    """

    number: int
    equations: tuple[tuple[str, int], ...]
    coordinates: tuple[tuple[str, int], ...]
    amount: float
    impulsive: bool

    @property
    def text(self) -> str:
        """Text of the violation, one sentence."""
        leading, *others = (
            f'"{name}"{TIMES[order] if order < len(TIMES) else f" differentiated {order} times"}' for name, order in self.equations
        )
        together = f" together with {_listed(others)}" if others else ""
        involved = _listed([f'the {derivative_word(order)} of "{name}"' for name, order in self.coordinates])
        contradicted = f", on {involved}" if involved else ""
        return (
            f"condition {self.number}: {leading}{together}{contradicted}, does not hold at 0-: the left side less the right is "
            f"{self.amount:.6g}; this causes {'a Dirac impulse' if self.impulsive else 'a jump'}"
        )


@dataclass
class _Conditions:
    """Rows of conditions with their noise: the weights by level (highest first), g, the values' weights, the combinations."""

    table: Noisy
    levels: int
    size: int

    def weights(self, level: int) -> slice:
        """Columns of the equations differentiated ``level`` times."""
        start = (self.levels - 1 - level) * self.size
        return slice(start, start + self.size)

    def solved(self) -> dict[int, tuple[int, int]]:
        """Eliminate; the (level, equation) that leads each row, without rows whose weights are noise."""
        leading: dict[int, tuple[int, int]] = {}
        for level in reversed(range(self.levels)):
            while (pivot := self._pivot(level, leading)) is not None:
                row, column = pivot
                leading[row] = level, column
                eliminate(self.table, row, self.weights(level).start + column)
        return leading

    def _pivot(self, level, leading) -> tuple[int, int] | None:
        size = np.abs(self.table.data[:, self.weights(level)])
        size[list(leading)] = 0.0
        if not size.any():
            return None
        row, column = np.unravel_index(size.argmax(), size.shape)
        return int(row), int(column)


def _violations_of(
    A: PolynomialMatrix, form: WeierstrassForm, inconsistency: Noisy, size: float, makes_impulses: bool
) -> tuple[Violation, ...]:
    """The violated conditions, from the inconsistency g of the values at 0- in scaled units, divided by ``size``.

    With ``makes_impulses`` False the values as a whole are known to cause none.
    """
    conditions = _conditions(form, inconsistency)
    leading, r = conditions.solved(), form.companion.size
    begin = conditions.levels * r
    g, values = conditions.table.data[:, begin], conditions.table.data[:, begin + 1 : begin + 1 + r * form.companion.grade]
    impulsive, scaling = _impulses(form, conditions.table.data[:, begin + 1 + r * form.companion.grade :]), form.companion.scaling
    violations = []
    for number, row in enumerate(sorted(leading, key=leading.__getitem__), start=1):
        if g[row]:
            level, equation = leading[row]
            weight = conditions.table.data[row, conditions.weights(level)][equation]
            amount = -size * g[row] / weight / scaling.rows[equation] * scaling.time ** float(level)
            equations = _equations(conditions, row, leading[row], A.equations)
            coordinates = tuple((A.coordinates[i % r], i // r) for i in _largest(values[row]))
            violations.append(Violation(number, equations, coordinates, float(amount), bool(impulsive[row]) and makes_impulses))
    return tuple(violations)


def _conditions(form, inconsistency) -> _Conditions:
    weights = [form.B2]
    while (following := form.nilpotent @ weights[-1]).cleaned().any():
        weights.append(following)
    m, r = form.B2.data.shape
    parts = [*reversed(weights), inconsistency[:, None], form.infinite_start, Noisy.exact(np.eye(m))]
    table = Noisy(np.hstack([part.cleaned() for part in parts]), np.hstack([part.noise for part in parts]))
    return _Conditions(table, len(weights), r)


def _equations(conditions, row, leading, names) -> tuple[tuple[str, int], ...]:
    """The leading equation, then the largest others, each with how many times it is differentiated."""
    weights = np.array([conditions.table.data[row, conditions.weights(level)] for level in range(conditions.levels)])
    places = [divmod(int(i), conditions.size) for i in _largest(weights.ravel())]
    others = [place for place in places if place != leading]
    return tuple((names[equation], level) for level, equation in [leading, *others[: MOST_NAMED - 1]])


def _largest(values) -> list[int]:
    order = np.argsort(-np.abs(values), kind="stable")
    return [int(i) for i in order[:MOST_NAMED] if values[i]]


def _impulses(form, combination) -> np.ndarray:
    """Which conditions, violated alone, cause an impulse of any order: -C2 N^(p + 1) g is not zero."""
    back = np.linalg.pinv(combination)
    power, impulsive = columnwise(back), np.zeros(len(back), dtype=bool)
    for _ in range(form.highest_impulse):
        power = form.nilpotent @ power
        impulsive |= (form.C2 @ power).cleaned().any(axis=0)
    return impulsive


def _listed(parts: Sequence[str]) -> str:
    return ", ".join(parts[:-1]) + " and " + parts[-1] if len(parts) > 1 else "".join(parts)
