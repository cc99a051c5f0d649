"""Which equations the values at 0- contradict, and by how much.

The infinite part N w' = w + B2 f of the decoupled pencil holds the algebraic equations hidden in A(d/dt) x = f. Each
condition g_j = 0 on the values at 0- (condition (60) of Moysis et al., corrected) is the sum over k of N^k B2, row j, times
the equations differentiated k times: its weights say where it comes from. The rows are combined by Gauss-Jordan
elimination, high derivatives first, so that each condition is told by the least differentiated and fewest equations:
a constraint row on positions appears as itself and as its first derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.noise import Noisy, columnwise
from ..polynomial.matrix import PolynomialMatrix
from ..tolerances import EPS, NOISE_SAFETY
from .notices import DERIVATIVE_NAMES

#: So many equations and coordinates of a condition are named, the largest ones.
MOST_NAMED = 4

TIMES = ("", " differentiated once", " differentiated twice")


@dataclass(frozen=True)
class Violation:
    """A condition on the values at 0- that they do not fulfil, in words.

    Attributes:
        number: of the condition, from 1; the least differentiated equations come first.
        equations: (name, how many times differentiated), the leading one first.
        coordinates: (name, order of its derivative) that the condition involves, the largest first.
        amount: the leading equation's left side less its right side at 0-, in its units per s^(times differentiated).
        impulsive: whether it makes Dirac impulses; otherwise jumps only.
    """

    number: int
    equations: tuple[tuple[str, int], ...]
    coordinates: tuple[tuple[str, int], ...]
    amount: float
    impulsive: bool

    @property
    def text(self) -> str:
        """One sentence."""
        leading, *others = (f'"{name}"{_times(order)}' for name, order in self.equations)
        together = f" together with {_listed(others)}" if others else ""
        involved = _listed([f'the {_derivative(order)} of "{name}"' for name, order in self.coordinates])
        contradicted = f", on {involved}" if involved else ""
        return (
            f"condition {self.number}: {leading}{together}{contradicted}, does not hold at 0-: the left side less the right is "
            f"{self.amount:.6g}; this makes {'a Dirac impulse' if self.impulsive else 'a jump'}"
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
        """Eliminate; the (level, equation) that leads each row, but for rows with no weight above its noise."""
        leading: dict[int, tuple[int, int]] = {}
        for level in reversed(range(self.levels)):
            while (pivot := self._pivot(level, leading)) is not None:
                row, column = pivot
                leading[row] = level, column
                self._eliminate(row, self.weights(level).start + column)
        return leading

    def _pivot(self, level, leading) -> tuple[int, int] | None:
        size = np.abs(self.table.data[:, self.weights(level)])
        size[list(leading)] = 0.0
        if not size.any():
            return None
        row, column = np.unravel_index(size.argmax(), size.shape)
        return int(row), int(column)

    def _eliminate(self, row, column) -> None:
        data, noise = self.table.data, self.table.noise
        factor = data[:, column] / data[row, column]
        factor[row] = 0.0
        change = np.multiply.outer(factor, data[row])
        squares = noise**2 + np.multiply.outer(factor**2, noise[row] ** 2) + (EPS * change) ** 2
        data, noise = data - change, np.sqrt(squares)
        data[np.abs(data) <= NOISE_SAFETY * noise] = 0.0
        data[factor != 0, column] = 0.0
        self.table = Noisy(data, noise)


def violations_of(
    A: PolynomialMatrix, form: WeierstrassForm, inconsistency: Noisy, size: float, makes_impulses: bool
) -> tuple[Violation, ...]:
    """The violated conditions, from the inconsistency g of the values at 0- in scaled units, divided by ``size``.

    With ``makes_impulses`` False the start as a whole is known to make none.
    """
    conditions = _conditions(form, inconsistency)
    leading, r = conditions.solved(), form.companion.size
    begin = conditions.levels * r
    g, asked = conditions.table.data[:, begin], conditions.table.data[:, begin + 1 : begin + 1 + r * form.companion.grade]
    impulsive, scaling = _impulses(form, conditions.table.data[:, begin + 1 + r * form.companion.grade :]), form.companion.scaling
    found = []
    for number, row in enumerate(sorted(leading, key=leading.__getitem__), start=1):
        if g[row]:
            level, equation = leading[row]
            weight = conditions.table.data[row, conditions.weights(level)][equation]
            amount = -size * g[row] / weight / scaling.rows[equation] * scaling.time ** float(level)
            equations = _equations(conditions, row, leading[row], A.equations)
            coordinates = tuple((A.coordinates[i % r], i // r) for i in _largest(asked[row]))
            found.append(Violation(number, equations, coordinates, float(amount), bool(impulsive[row]) and makes_impulses))
    return tuple(found)


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
    """Which conditions, violated alone, make an impulse of any order: -C2 N^(p + 1) g is not zero."""
    back = np.linalg.pinv(combination)
    power, found = columnwise(back), np.zeros(len(back), dtype=bool)
    for _ in range(form.highest_impulse):
        power = form.nilpotent @ power
        found |= (form.C2 @ power).cleaned().any(axis=0)
    return found


def _times(order: int) -> str:
    return TIMES[order] if order < len(TIMES) else f" differentiated {order} times"


def _derivative(order: int) -> str:
    return DERIVATIVE_NAMES[order] if order < len(DERIVATIVE_NAMES) else f"derivative {order}"


def _listed(parts: Sequence[str]) -> str:
    return ", ".join(parts[:-1]) + " and " + parts[-1] if len(parts) > 1 else "".join(parts)
