"""Units taken out of the data: powers of two for time, rows and columns, chosen jointly from the entries.

For A(s) = sum A_k s^k the scaled coefficients are D_l A_k D_r sigma^k. Changing the units of time, length or
force changes the data by exactly such factors, so they are chosen by a rule that follows such a change: the
least-squares fit of log2|A_k[i, j]| + k log2 sigma + l_i + c_j to zero over all nonzero entries, then an
equilibration of rows and columns of what remains. Powers of two cost no rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import IllConditioned
from ..tolerances import EPS
from .precise import is_precise, power_of_two

#: Factors stay within 2^(+-this), where they and their inverses are normal numbers.
LARGEST_EXPONENT = 1000.0

#: Rounds of alternating row and column scaling; each at least halves the spread that is left.
EQUILIBRATION_ROUNDS = 6


@dataclass(frozen=True)
class Scaling:
    """Scale factors, all powers of two: scaled A_k = rows[:, None] * A_k * columns * time**k.

    With s = time * s', x = columns * x' and f' = rows * f the scaled equation reads A'(d/dt') x' = f', t' = time * t.
    """

    time: float
    rows: np.ndarray
    columns: np.ndarray

    def apply(self, coefficients: np.ndarray) -> np.ndarray:
        """The scaled coefficients, shape (q + 1, r, r)."""
        powers = np.arange(len(coefficients))[:, None, None] * np.log2(self.time)
        exponents = powers + np.log2(self.rows)[:, None] + np.log2(self.columns)
        if is_precise(coefficients):
            return coefficients * power_of_two(exponents)
        return np.ldexp(coefficients, exponents.astype(int))  # added first: the factors alone might overflow


def joint_scaling(coefficients: np.ndarray) -> Scaling:
    """The scaling of time, rows and columns for coefficients of shape (q + 1, r, r).

    Entries that turn out as mere rounding beside others of their row and of their column are left out of a second fit.
    """
    scaling = _fitted(coefficients)
    size = np.abs(scaling.apply(coefficients))
    rows, columns = size.max(axis=(0, 2), initial=0.0), size.max(axis=(0, 1), initial=0.0)
    rounding = size <= EPS * np.minimum(rows[:, None], columns)
    return _fitted(np.where(rounding, 0.0, coefficients)) if (rounding & (coefficients != 0)).any() else scaling


def _fitted(coefficients: np.ndarray) -> Scaling:
    time, rows, columns = _log_fit(coefficients)
    scaling = Scaling(_power_of_two(time), _power_of_two(rows), _power_of_two(columns))
    size = np.abs(scaling.apply(coefficients)).max(axis=0, initial=0.0)
    more_rows, more_columns = equilibration(size) if len(size) else (np.ones(0), np.ones(0))
    return Scaling(scaling.time, scaling.rows * more_rows, scaling.columns * more_columns)


def equilibration(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Powers of two for the rows and columns of a matrix of magnitudes that bring its largest entries near 1."""
    rows, columns = np.ones(size.shape[0]), np.ones(size.shape[1])
    for _ in range(EQUILIBRATION_ROUNDS):
        scaled = rows[:, None] * size * columns
        row_step = _inverse_root(scaled.max(axis=1, initial=0.0))
        column_step = _inverse_root(scaled.max(axis=0, initial=0.0))
        if (row_step == 1).all() and (column_step == 1).all():
            break
        rows, columns = rows * row_step, columns * column_step
    final = _inverse(((rows[:, None] * size) * columns).max(axis=1, initial=0.0))
    return rows * final, columns


def _log_fit(coefficients):
    """Minimum-norm least-squares exponents (time, rows, columns) over the nonzero entries."""
    powers, i, j = np.nonzero(coefficients)
    r = coefficients.shape[1]
    if not powers.size:
        return 0.0, np.zeros(r), np.zeros(r)
    logs = np.log2(np.abs(coefficients[powers, i, j]))
    normal = np.zeros((1 + 2 * r, 1 + 2 * r))
    right = np.zeros(1 + 2 * r)
    places = np.stack([np.zeros_like(i), 1 + i, 1 + r + j])
    weights = np.stack([powers.astype(float), np.ones(len(i)), np.ones(len(i))])
    for a in range(3):
        np.add.at(right, places[a], -weights[a] * logs)
        for b in range(3):
            np.add.at(normal, (places[a], places[b]), weights[a] * weights[b])
    fit = np.linalg.lstsq(normal, right, rcond=None)[0]
    return fit[0], fit[1 : 1 + r], fit[1 + r :]


def _power_of_two(exponents):
    if np.abs(exponents).max(initial=0.0) > LARGEST_EXPONENT:
        raise IllConditioned(
            "the entries of A(s) are so far apart that no unit of time keeps its zeros within the range of float64; "
            "choose other units, or look for an entry that is wrong by hundreds of orders of magnitude"
        )
    return np.exp2(np.round(exponents))


def _inverse_root(size):
    return np.exp2(-np.round(np.log2(np.where(size > 0, size, 1.0)) / 2))


def _inverse(size):
    return np.exp2(-np.round(np.log2(np.where(size > 0, size, 1.0))))
