"""Scaling of time, rows and columns by powers of two, chosen jointly from the entries.

For A(s) = sum A_k s^k the scaled coefficients are D_l A_k D_r sigma^k. Changing the units of time, length or
force changes the data by exactly such factors, so they are chosen by a rule that follows such a change: the
least-squares fit of log2|A_k[i, j]| + k log2 sigma + l_i + c_j to zero over all nonzero entries, then an
equilibration of rows and columns of what remains. Powers of two cost no rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..ground.errors import IllConditioned
from ..ground.tolerances import BALANCE_RATIO, EPS, NOISE_SAFETY
from .arrays import Matrix, compressed, full, lapack
from .precise import is_precise, power_of_two

#: Factors stay within 2^(+-this), where they and their inverses are normal numbers.
LARGEST_EXPONENT = 1000.0

#: Rounds of alternating row and column scaling; each at least halves the spread that is left.
EQUILIBRATION_ROUNDS = 6

#: Rounds of balancing.
BALANCING_ROUNDS = 12

#: Newton's method for sparse matrices: most steps, and the longest and the last change of the exponent of an entry.
NEWTON_STEPS, LONGEST_STEP, SHORTEST_STEP = 40, 3.0, 0.25

#: Up to so many states equations are solved as full ones, which takes less time than to build sparse ones.
DENSE = 100

#: Beyond so many states what couples them is found by their graph, not by powers of their matrix.
FEW_STATES = 48

#: Number of rows from which the exponents of a sparse A(s) come from sparse equations.
MANY_ROWS = 150

#: Matrices of fewer entries times rows are written with their zeros: a product takes less time than a sparse one, and no import.
LARGE_DESIGN = 50_000

#: What makes a Laplace equation regular; a matrix with a tenth of its entries is solved as a full one.
SLIGHT, FILLED = 1e-9, 10


@dataclass(frozen=True, eq=False)
class Scaling:
    """Scale factors, all powers of two: scaled A_k = rows[:, None] * A_k * columns * time**k.

    With s = time * s', x = columns * x' and f' = rows * f the scaled equation reads A'(d/dt') x' = f', t' = time * t.
    """

    time: float
    rows: np.ndarray
    columns: np.ndarray

    def apply(self, coefficients: np.ndarray) -> np.ndarray:
        """The scaled coefficients, shape (q + 1, m, n)."""
        powers = np.arange(len(coefficients))[:, None, None] * np.log2(self.time)
        exponents = powers + np.log2(self.rows)[:, None] + np.log2(self.columns)
        if is_precise(coefficients):
            return coefficients * power_of_two(exponents)
        return np.ldexp(coefficients, exponents.astype(int))  # added first: the factors alone might overflow


def joint_scaling(coefficients: np.ndarray) -> Scaling:
    """The scaling of time, rows and columns for coefficients of shape (q + 1, m, n).

    Entries that turn out as mere rounding error next to others of their row and of their column are left out of a second fit.
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
    more_rows, more_columns = equilibration(size)
    return Scaling(scaling.time, scaling.rows * more_rows, scaling.columns * more_columns)


def equilibration(size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Powers of two for the rows and columns of a matrix of magnitudes, scaled in turns, that bring its largest entries near 1."""
    rows, columns, scaled = np.ones(len(size)), np.ones(size.shape[1]), size
    for _ in range(EQUILIBRATION_ROUNDS):
        largest = np.concatenate([scaled.max(axis=1, initial=0.0), scaled.max(axis=0, initial=0.0)])
        steps = _inverse(largest, 2)
        if (steps == 1).all():
            break
        rows, columns = rows * steps[: len(size)], columns * steps[len(size) :]
        scaled = rows[:, None] * size * columns
    return rows * _inverse(scaled.max(axis=1, initial=0.0)), columns


def balancing_units(generator: Matrix) -> np.ndarray:
    """Units of the states of a square matrix, powers of two: S * units / units[:, None] has rows and columns of like size.

    From the least-squares fit of log2|S_ij| + u_j - u_i to one number each round brings them half way, all at once (after Parlett
    and Reinsch 1969): states of one kind keep one unit, which one after another they would not. What drives states without being
    driven by them is left out.
    """
    if isinstance(generator, np.ndarray):
        if len(generator) <= FEW_STATES:
            return _balancing(*_mutual_sizes(generator))
        generator = compressed(generator)
    row, column, size, first = _mutual(generator)
    exponents = _fitted_exponents(row, column, np.log2(size), len(first))
    return _powers_of_two(_balanced_exponents(row, column, size, exponents), first)


def _balanced_exponents(row: np.ndarray, column: np.ndarray, size: np.ndarray, exponents: np.ndarray) -> np.ndarray:
    """Exponents that balance the sizes of rows and columns."""
    n = len(exponents)
    for _ in range(BALANCING_ROUNDS):
        now = size * np.exp2(exponents[column] - exponents[row])
        rows, columns = np.bincount(row, now, n), np.bincount(column, now, n)
        both = (rows > 0) & (columns > 0)
        exponents = exponents + (np.log2(np.where(both, rows, 1.0)) - np.log2(np.where(both, columns, 1.0))) / 4
    return _least_sum(row, column, size, exponents) if 0 < len(size) * FILLED <= n * n else exponents


def _least_sum(row: np.ndarray, column: np.ndarray, size: np.ndarray, exponents: np.ndarray) -> np.ndarray:
    """Exponents u of the least sum of |S_ij| 2^(u_j - u_i), by Newton's method with bounded steps (Cohen et al. 2017).

    A weak coupling at the end of a chain bends the fit all along the chain, and rounds from state to state would take long to undo it.
    """
    n = len(exponents)
    for _ in range(NEWTON_STEPS):
        now = size * np.exp2(exponents[column] - exponents[row])
        right = np.bincount(row, now, n) - np.bincount(column, now, n)
        step = _laplace_solution(row, column, now / now.max(), right[:, None] / now.max(), n)[:, 0] / np.log(2)
        longest = np.abs(step[column] - step[row]).max()
        exponents = exponents + step * min(1.0, LONGEST_STEP / longest if longest else 1.0)
        if longest <= SHORTEST_STEP:
            break
    return exponents


def balanced(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """U^-1 A U with rows and columns of about the same size, and the diagonal of U, by LAPACK.

    >>> balanced(np.array([[1.0, 256.0], [1.0, 1.0]]))[1].tolist()
    [16.0, 1.0]
    """
    if not len(matrix):
        return matrix, np.ones(0)
    result, *_, units, _ = lapack.dgebal(np.asarray_chkfinite(matrix), scale=1, permute=0)
    return result, units


def balanced_norm(generator: Matrix, units: np.ndarray | None = None) -> float:
    """The smaller of the 1-norm and the maximum norm in balancing units, decreasing for states that only excite others."""
    if isinstance(generator, np.ndarray) and len(generator) > FEW_STATES:
        generator = compressed(generator)
    if isinstance(generator, np.ndarray):
        size, first = _mutual_sizes(generator)
        units = _balancing(size, first) if units is None else units
        size = size * units / units[:, None]
        return float(min(size.sum(axis=axis).max(initial=0.0) for axis in (0, 1)))
    row, column, size, _ = _mutual(generator)
    units = balancing_units(generator) if units is None else units
    size = size * (units[column] / units[row])
    return float(min(np.bincount(places, size).max(initial=0.0) for places in (row, column)))


def _balancing(size: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Balancing units of a small full matrix of magnitudes: the better of those of all entries, and of those above rounding."""
    result = _balanced(size, first)
    now = size * result / result[:, None]
    least = NOISE_SAFETY * EPS * np.minimum(now.max(axis=1, initial=0.0)[:, None], now.max(axis=0, initial=0.0))
    if not ((now > 0) & (now <= least)).any():
        return result
    other = _balanced(np.where(now > least, size, 0.0), first)
    return min(result, other, key=lambda units: (size * units / units[:, None]).sum())


def _balanced(size: np.ndarray, first: np.ndarray) -> np.ndarray:
    if not len(size):  # LAPACK takes no empty equations
        return np.ones(0)
    pattern, diagonal = size > 0, slice(None, None, len(size) + 1)
    alone = 1.0 - pattern.any(axis=0)
    pattern.reshape(-1)[diagonal] = False
    both = np.array([np.log2(np.where(pattern, size, 1.0)), pattern])
    out, into = both.sum(axis=2), both.sum(axis=1)
    laplacian, right = -both[1] - both[1].T, (out - into).T
    laplacian.reshape(-1)[diagonal] = out[1] + into[1] + SLIGHT
    units = np.exp2(_about_their_mean(lapack.dgesv(laplacian, right)[2], right, *out.sum(axis=1)))
    for _ in range(BALANCING_ROUNDS):
        ratios = (size.dot(units) / units + alone) / ((1 / units).dot(size) * units + alone)
        units *= ratios**0.25
        if ratios.max() < BALANCE_RATIO * ratios.min():
            break
    return _powers_of_two(np.log2(units), first)


def _about_their_mean(result, right, total, count) -> np.ndarray:
    """u of ``_fitted_exponents`` from the answers to both right sides of its equation, of the logarithms and of ones.

    Its mean is fitted too: in another unit of time all the units change by that unit, and no digit of the answer does.
    """
    ratios = count - right[:, 1] @ result[:, 1]
    mean = (total - right[:, 1] @ result[:, 0]) / ratios if ratios > SLIGHT * count else 0.0
    return result[:, 0] - mean * result[:, 1]


def _powers_of_two(exponents: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Powers of two relative to the first state of each part, so that exponents half way are rounded alike in all units."""
    return np.exp2(np.floor(exponents - exponents[first] + 0.5 + SLIGHT))


def _mutual_sizes(generator: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Magnitudes of the entries that couple states in both directions, also indirectly, and the first state of each one's part."""
    if len(generator) > FEW_STATES:
        part = scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(generator), connection="strong")[1]
        return np.abs(generator) * (part[:, None] == part), _first_of_parts(part)
    reached, steps = (generator != 0) + np.eye(len(generator)), 1
    while steps < len(generator):
        reached, steps = np.minimum(reached.dot(reached), 1.0), 2 * steps
    mutual = reached * reached.T
    return np.abs(generator) * mutual, mutual.argmax(axis=1) if len(mutual) else np.zeros(0, dtype=int)


def _first_of_parts(part: np.ndarray) -> np.ndarray:
    """The first state of the part of each state."""
    return np.unique(part, return_index=True)[1][part]


def _fitted_exponents(row, column, logs, n: int) -> np.ndarray:
    """u and m with the least sum of (log_ij + u_j - u_i - m)^2, only u: a Laplace equation on the graph of the entries."""
    ratios = row != column
    row, column, logs = row[ratios], column[ratios], logs[ratios]
    ones = np.ones(len(row))
    right = np.array([np.bincount(row, result, n) - np.bincount(column, result, n) for result in (logs, ones)]).T
    return _about_their_mean(_laplace_solution(row, column, ones, right, n), right, logs.sum(), len(row))


def _laplace_solution(row, column, weights, right: np.ndarray, n: int) -> np.ndarray:
    """The potentials of a graph with these weights of its edges for right sides of shape (n, k)."""
    degree = np.bincount(row, weights, n) + np.bincount(column, weights, n)
    rows, columns = np.concatenate([np.arange(n), row, column]), np.concatenate([np.arange(n), column, row])
    values = np.concatenate([degree + SLIGHT, -weights, -weights])
    if n <= DENSE or len(row) * FILLED > n * n:
        return np.linalg.solve(np.bincount(rows * n + columns, values, n * n).reshape(n, n), right)
    laplacian = scipy.sparse.csc_array((values, (rows, columns)), shape=(n, n))
    return scipy.sparse.linalg.spsolve(laplacian, right).reshape(n, right.shape[1])


def _mutual(generator: scipy.sparse.csr_array) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Rows, columns and sizes of the entries that couple states in both directions, also indirectly, and the first of each part."""
    entries, part = generator.tocoo(), scipy.sparse.csgraph.connected_components(generator, connection="strong")[1]
    both = (part[entries.row] == part[entries.col]) & (entries.data != 0)
    return entries.row[both], entries.col[both], np.abs(entries.data[both]), _first_of_parts(part)


def _log_fit(coefficients):
    """Minimum-norm least-squares exponents (time, rows, columns) over the nonzero entries."""
    powers, i, j = np.nonzero(coefficients)
    _, m, n = coefficients.shape
    if not powers.size:
        return 0.0, np.zeros(m), np.zeros(n)
    logs, unknowns = np.log2(np.abs(coefficients[powers, i, j])), 1 + m + n
    places = np.concatenate([np.zeros_like(i), 1 + i, 1 + m + j])
    right = np.bincount(places, np.concatenate([-powers * logs, -logs, -logs]), unknowns)
    each, ones = np.tile(np.arange(len(logs)), 3), np.ones(2 * len(logs))
    if len(logs) * max(m, n) > LARGE_DESIGN:
        design: Matrix = scipy.sparse.csr_array((np.concatenate([powers, ones]), (each, places)), shape=(len(logs), unknowns))
    else:
        design = np.zeros((len(logs), unknowns))
        design[each, places] = np.concatenate([powers, ones])
    normal = design.T @ design  # whole numbers, and the sums in order: what is halfway between two powers stays so
    if max(m, n) > MANY_ROWS and len(logs) * FILLED < m * n:
        fit = scipy.sparse.linalg.spsolve((normal + SLIGHT * scipy.sparse.eye_array(unknowns)).tocsc(), right)
    else:
        fit = np.linalg.lstsq(full(normal), right, rcond=None)[0]
    return fit[0], fit[1 : 1 + m], fit[1 + m :]


def _power_of_two(exponents):
    if np.abs(exponents).max(initial=0.0) > LARGEST_EXPONENT:
        raise IllConditioned(
            "the entries of A(s) differ so much that no unit of time keeps its zeros in the range of float64; "
            "choose other units, or look for an entry that is wrong by hundreds of orders of magnitude"
        )
    return np.exp2(np.rint(exponents))


def _inverse(size: np.ndarray, root: int = 1) -> np.ndarray:
    """Powers of two near 1 / size, or near its root; 1 for 0."""
    return np.exp2(-np.rint(np.log2(size + (size == 0)) / root))
