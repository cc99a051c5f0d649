"""A precise matrix turned into block diagonal form, from its fastest zeros to its slowest.

A float64 eigenvalue algorithm is right about zeros near the largest in modulus; of zeros many orders slower it knows
little or nothing. So the fast ones are separated first, by the float64 algorithm and Newton steps on the decoupling
with precise residuals, which converge quadratically (as those of Bujanovic, Kressner and Schroeder 2023 for Schur
forms). What is left is a smaller precise matrix with the slow zeros alone, and the same is done with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log

import numpy as np
import scipy.linalg
from scipy.linalg import block_diag

from ..errors import IllConditioned
from .blocks import BlockDiagonal, block_diagonalize, eigenvalues
from .parts import Part, balancing_exponents, clustered, in_schur_form
from .precise import DECOUPLED, magnitude, power_of_two, precise, rounded_to_float

#: Zeros below this part of the largest are left to the next, slower scale. Float64 knows the faster ones to at least
#: twelve digits less the condition: enough for Newton steps to converge.
SLOW = 1e-4

#: A step larger than this is no correction: its two blocks are kept together.
LARGEST_STEP = 0.1

#: Decoupling norm up to which float64 makes a start; what of it the answer cannot bear is joined again at the end.
START_LIMIT = 1e8

#: A step that has not become smaller than this part of the one before comes from zeros too close to be separated. Most
#: converge quadratically; of zeros 1e-14 apart float64 knows the distance to two digits, and a step gains no more.
CONVERGING = 1e-2

#: So many steps take the slowest of those that converge to what is wanted; as many again where zeros have to be joined.
MOST_STEPS = 2 + ceil(log(DECOUPLED / LARGEST_STEP) / log(CONVERGING))


@dataclass(frozen=True)
class _Scale:
    """One scale: the decoupled basis, its inverse, the block diagonal product, and which columns belong together."""

    basis: np.ndarray
    inverse: np.ndarray
    product: np.ndarray
    parts: list[np.ndarray]


def block_diagonal(matrix: np.ndarray) -> BlockDiagonal:
    """Block-diagonalize a precise square matrix; basis and inverse are precise, the blocks float64 real Schur forms.

    Raises:
        IllConditioned: the zeros cannot be separated.
    """
    if not len(matrix):
        return BlockDiagonal(matrix, matrix, (), 0.0)
    balance = power_of_two(balancing_exponents(magnitude(matrix)))
    parts = clustered(_separated(matrix * balance / balance[:, None]))
    schur = [in_schur_form(part) for part in parts]
    return BlockDiagonal(
        balance[:, None] * np.hstack([part.basis for part in schur]),
        np.vstack([part.inverse for part in schur]) / balance,
        tuple(part.block for part in schur),
        max(part.coupling for part in parts),
    )


def _separated(matrix) -> list[Part]:
    """The blocks of a balanced matrix, each as small as the arithmetic can separate."""
    start, sets = _start(rounded_to_float(matrix))
    scale = _refined(matrix, precise(start), sets)
    found = []
    for at in scale.parts:
        part = Part(scale.basis[:, at], scale.inverse[at], scale.product[np.ix_(at, at)])
        found += [part] if len(at) == 1 or len(scale.parts) == 1 else [_within(part, inner) for inner in _balanced(part.block)]
    return found


def _balanced(matrix) -> list[Part]:
    """The same for a matrix that is not balanced yet."""
    balance = power_of_two(balancing_exponents(magnitude(matrix)))
    parts = _separated(matrix * balance / balance[:, None])
    return [Part(balance[:, None] * part.basis, part.inverse / balance, part.block) for part in parts]


def _within(outer: Part, inner: Part) -> Part:
    return Part(outer.basis @ inner.basis, inner.inverse @ outer.inverse, inner.block)


def _start(matrix: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Fast zeros decoupled in float64, a basis and which columns belong together; the slow ones, or none, are the last part."""
    size = len(matrix)
    triangle, turn = scipy.linalg.schur(matrix, output="real")
    triangle, turn, fast = _sorted(matrix, _limit(np.abs(eigenvalues(triangle)))) or (triangle, turn, size)
    found = block_diagonalize(triangle[:fast, :fast], START_LIMIT)
    decoupling = np.eye(size)
    if fast < size:
        decoupling[:fast, fast:] = _sylvester(triangle[:fast, :fast], triangle[fast:, fast:], -triangle[:fast, fast:])
    ends = np.cumsum([len(block) for block in found.blocks])
    basis = turn @ decoupling @ block_diag(found.basis, np.eye(size - fast))
    return basis, [*np.split(np.arange(fast), ends[:-1]), np.arange(fast, size)]


def _limit(moduli: np.ndarray) -> float:
    """Where to cut between fast and slow: at the widest gap among the moduli around SLOW times the largest; 0 for no cut."""
    largest = moduli.max()
    if moduli.min() >= SLOW * largest:
        return 0.0
    ordered = np.unique(moduli[(moduli > SLOW**2 * largest)])
    ordered = np.concatenate([[SLOW**2 * largest], ordered])
    upper = ordered[1:][ordered[:-1] < SLOW * largest]
    lower = ordered[:-1][ordered[:-1] < SLOW * largest]
    widest = (upper / lower).argmax()
    return float(np.sqrt(upper[widest]) * np.sqrt(lower[widest]))


def _sorted(matrix, limit):
    """The real Schur form with zeros of modulus >= limit first, and their number; None where sorting fails."""
    try:
        return scipy.linalg.schur(matrix, output="real", sort=lambda re, im: np.hypot(re, im) >= limit)
    except np.linalg.LinAlgError:
        return None


def _refined(matrix, basis, parts) -> _Scale:
    """Newton steps until inverse @ matrix @ basis is block diagonal; parts that cannot be separated are joined."""
    parts = [part for part in parts if len(part)]
    identity, back = precise(np.eye(len(matrix))), precise(np.linalg.inv(rounded_to_float(basis)))
    before = LARGEST_STEP / CONVERGING
    for _ in range(MOST_STEPS * len(parts)):
        defect = identity - back @ basis
        back = back + defect @ back  # leaves the square of the defect
        product = back @ matrix @ basis
        change, sizes = _step(rounded_to_float(product), parts)
        largest = sizes.max()
        if largest <= DECOUPLED and magnitude(defect).max() ** 2 <= DECOUPLED:
            return _Scale(basis, back, product, parts)
        if largest > max(CONVERGING * before, DECOUPLED):
            parts = _joined(parts, *np.unravel_index(sizes.argmax(), sizes.shape))
            before = LARGEST_STEP / CONVERGING
            continue
        before, change = largest, precise(change)
        basis, back = basis + basis @ change, back - change @ back
    raise IllConditioned(
        "the zeros of A(s) span so many orders of magnitude, and are so strongly coupled, that they cannot be separated; "
        "look for a mass, stiffness or ratio far out of proportion, or a wrong unit"
    )


def _step(product, parts):
    """X of the step basis (I + X), zero within the parts, and its largest entry for each pair of parts."""
    change, sizes = np.zeros_like(product), np.zeros((len(parts), len(parts)))
    for i, rows in enumerate(parts):
        for j, columns in enumerate(parts):
            right = product[np.ix_(rows, columns)]
            if i != j and right.any():
                X = _sylvester(product[np.ix_(rows, rows)], product[np.ix_(columns, columns)], -right)
                change[np.ix_(rows, columns)], sizes[i, j] = X, np.abs(X).max()
    return change, np.where(np.isfinite(sizes), sizes, np.inf)


def _joined(parts, i, j):
    """The parts, numbers i and j joined in the place of the later one."""
    first, second = sorted((int(i), int(j)))
    together = np.concatenate([parts[first], parts[second]])
    return [together if k == second else part for k, part in enumerate(parts) if k != first]


def _sylvester(top, bottom, right):
    """X with top X - X bottom = right, infinite where the two share a zero."""
    if len(top) == len(bottom) == 1:
        gap = top[0, 0] - bottom[0, 0]
        return right / gap if gap else np.full_like(right, np.inf)
    with np.errstate(all="ignore"):
        return scipy.linalg.solve_sylvester(top, -bottom, right)
