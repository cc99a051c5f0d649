"""Units taken out of the data: powers of two for time, rows and columns, chosen jointly from the entries.

For A(s) = sum A_k s^k the scaled coefficients are D_l A_k D_r sigma^k. Changing the units of time, length or
force changes the data by exactly such factors, so they are chosen by a rule that follows such a change: the
least-squares fit of log2|A_k[i, j]| + k log2 sigma + l_i + c_j to zero over all nonzero entries, then an
equilibration of rows and columns of what remains. Powers of two cost no rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from ..errors import IllConditioned
from ..tolerances import EPS
from .precise import is_precise, power_of_two

#: Factors stay within 2^(+-this), where they and their inverses are normal numbers.
LARGEST_EXPONENT = 1000.0

#: Rounds of alternating row and column scaling; each at least halves the spread that is left.
EQUILIBRATION_ROUNDS = 6

#: Rounds of balancing a sparse matrix.
BALANCING_ROUNDS = 12

#: What makes a Laplace equation regular; a matrix with a tenth of its entries is solved as a full one.
SLIGHT, FILLED = 1e-9, 10


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


def balancing_units(generator: csr_array) -> np.ndarray:
    """Units of the states of a square sparse matrix, powers of two: S * units / units[:, None] has rows and columns of like size.

    From the least-squares fit of log2|S_ij| + u_j - u_i to one number each round brings them half way, all at once (after Parlett
    and Reinsch 1969): states of one kind keep one unit, which one after another they would not. What drives states without being
    driven by them is left out.

    >>> balancing_units(csr_array([[0.0, 1.0], [-256.0, 0.0]])).tolist()
    [0.25, 4.0]
    """
    row, column, size, n = *_mutual(generator), generator.shape[0]
    exponents = _fitted_exponents(row, column, np.log2(size), n)
    for _ in range(BALANCING_ROUNDS):
        now = size * np.exp2(exponents[column] - exponents[row])
        rows, columns = np.bincount(row, now, n), np.bincount(column, now, n)
        both = (rows > 0) & (columns > 0)
        exponents += (np.log2(np.where(both, rows, 1.0)) - np.log2(np.where(both, columns, 1.0))) / 4
    return np.exp2(np.rint(exponents))


def balanced_norm(generator: csr_array) -> float:
    """The smaller one of the 1-norm and the maximum norm, states in balancing units, those that only drive in ever smaller ones.

    >>> balanced_norm(csr_array([[0.0, 1.0, 1e9], [-(4.0**20), 0.0, 0.0], [0.0, 0.0, 1.0]])) == 2.0**20
    True
    """
    row, column, size = _mutual(generator)
    units = balancing_units(generator)
    size = size * (units[column] / units[row])
    return float(min(np.bincount(places, size).max(initial=0.0) for places in (row, column)))


def _fitted_exponents(row, column, logs, n: int) -> np.ndarray:
    """u with the least sum of (log_ij + u_j - u_i - mean)^2: a Laplace equation on the graph of the entries."""
    apart = row != column
    row, column, logs = row[apart], column[apart], logs[apart]
    ones, degree = np.ones(len(row)), np.bincount(row, minlength=n) + np.bincount(column, minlength=n)
    pattern = csr_array((ones, (row, column)), shape=(n, n))
    laplacian = diags_array(degree + SLIGHT) - pattern - pattern.T
    logs = logs - (logs.mean() if len(logs) else 0.0)
    right = np.bincount(row, logs, n) - np.bincount(column, logs, n)
    if len(row) * FILLED > n * n:
        return np.linalg.solve(laplacian.toarray(), right)
    return np.atleast_1d(spsolve(laplacian.tocsc(), right))


def _mutual(generator: csr_array) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and sizes of the entries that couple states both ways, if only by way of others."""
    entries, part = generator.tocoo(), connected_components(generator, connection="strong")[1]
    both = (part[entries.row] == part[entries.col]) & (entries.data != 0)
    return entries.row[both], entries.col[both], np.abs(entries.data[both])


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
