"""Units taken out of the data: powers of two for time, rows and columns, chosen jointly from the entries.

For A(s) = sum A_k s^k the scaled coefficients are D_l A_k D_r sigma^k. Changing the units of time, length or
force changes the data by exactly such factors, so they are chosen by a rule that follows such a change: the
least-squares fit of log2|A_k[i, j]| + k log2 sigma + l_i + c_j to zero over all nonzero entries, then an
equilibration of rows and columns of what remains. Powers of two cost no rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from ..errors import IllConditioned
from ..tolerances import EPS
from .precise import is_precise, power_of_two

#: Factors stay within 2^(+-this), where they and their inverses are normal numbers.
LARGEST_EXPONENT = 1000.0

#: Rounds of alternating row and column scaling; each at least halves the spread that is left.
EQUILIBRATION_ROUNDS = 6

#: Rounds of balancing a sparse matrix.
BALANCING_ROUNDS = 12


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


def balanced_norm(generator: csr_array) -> float:
    """The smaller one of the 1-norm and the maximum norm of a sparse matrix, its states in units that about balance it.

    Each round brings rows and columns half way to one size, all at once (after Parlett and Reinsch 1969).

    >>> round(balanced_norm(csr_array([[0.0, 1.0], [-1e12, 0.0]])) / 1e6, 3)
    1.0
    """
    entries, n = generator.tocoo(), generator.shape[0]
    size = np.abs(entries.data)
    for _ in range(BALANCING_ROUNDS):
        rows, columns = np.bincount(entries.row, size, n), np.bincount(entries.col, size, n)
        both = (rows > 0) & (columns > 0)
        units = np.where(both, rows, 1.0) ** 0.25 / np.where(both, columns, 1.0) ** 0.25
        size = size * (units[entries.col] / units[entries.row])
    return float(min(np.bincount(places, size, n).max(initial=0.0) for places in (entries.row, entries.col)))


def _log_fit(coefficients):
    """Minimum-norm least-squares exponents (time, rows, columns) over the nonzero entries."""
    powers, i, j = np.nonzero(coefficients)
    r = coefficients.shape[1]
    if not powers.size:
        return 0.0, np.zeros(r), np.zeros(r)
    logs = np.log2(np.abs(coefficients[powers, i, j]))
    design = np.zeros((len(logs), 1 + 2 * r))
    design[:, 0], places = powers, np.arange(len(logs))
    design[places, 1 + i] = design[places, 1 + r + j] = 1.0
    normal = design.T @ design  # whole numbers, and the sums in order: what is halfway between two powers stays so
    places = np.concatenate([np.zeros_like(i), 1 + i, 1 + r + j])
    right = np.bincount(places, np.concatenate([-powers * logs, -logs, -logs]), 1 + 2 * r)
    fit = np.linalg.lstsq(normal, right, rcond=None)[0]
    return fit[0], fit[1 : 1 + r], fit[1 + r :]


def _power_of_two(exponents):
    if np.abs(exponents).max(initial=0.0) > LARGEST_EXPONENT:
        raise IllConditioned(
            "the entries of A(s) are so far apart that no unit of time keeps its zeros within the range of float64; "
            "choose other units, or look for an entry that is wrong by hundreds of orders of magnitude"
        )
    return np.exp2(np.rint(exponents))


def _inverse_root(size):
    return np.exp2(-np.rint(np.log2(size + (size == 0)) / 2))


def _inverse(size):
    return np.exp2(-np.rint(np.log2(size + (size == 0))))
