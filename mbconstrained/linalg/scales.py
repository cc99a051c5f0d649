"""A precise matrix turned into block diagonal form, from its fastest zeros to its slowest.

A float64 eigenvalue algorithm is right about zeros near the largest in modulus; of zeros many orders slower it knows
little or nothing. So the fast ones are separated first, by the float64 algorithm and Newton steps on the decoupling
with precise residuals, which converge quadratically (Demmel 1987; Bujanovic, Kressner and Schroeder 2021 for Schur
forms). What is left is a smaller precise matrix with the slow zeros alone, and the same is done with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.linalg import block_diag, lapack

from ..errors import IllConditioned
from ..tolerances import DECOUPLING_LIMIT
from .blocks import BlockDiagonal, block_diagonalize, eigenvalues
from .precise import DECOUPLED, inverse, magnitude, power_of_two, precise, rounded_to_float

#: Zeros below this part of the largest are left to the next, slower scale. Float64 knows the faster ones to at least
#: twelve digits less the condition: enough for Newton steps to converge.
SLOW = 1e-4

#: Convergence is quadratic: three steps from 1e-8 to beyond what is wanted, some more where zeros have to be joined.
MOST_STEPS = 12

#: A step larger than this is no correction: its two blocks are kept together.
LARGEST_STEP = 0.1


#: Decoupling norm up to which float64 makes a start; what of it the answer cannot bear is joined again at the end.
START_LIMIT = 1e8

#: Largest ratio of the couplings of a complex pair: one that is stretched more is nearly a double zero on the real axis.
MOST_STRETCHED = 1e4

#: A step that has not become smaller than this part of the one before comes from zeros too close to be separated.
CONVERGING = 1e-2


@dataclass(frozen=True)
class _Part:
    """Some zeros: inverse @ matrix @ basis = block, inverse @ basis = I; all precise."""

    basis: np.ndarray
    inverse: np.ndarray
    block: np.ndarray

    @cached_property
    def zeros(self) -> np.ndarray:
        """The eigenvalues of the block."""
        return np.linalg.eigvals(rounded_to_float(self.block))

    @cached_property
    def projector(self) -> np.ndarray:
        """basis @ inverse in float64."""
        return rounded_to_float(self.basis @ self.inverse)

    @cached_property
    def units(self) -> np.ndarray:
        """Powers of two for the coordinates in which the part of the matrix that belongs to it is balanced."""
        motion = magnitude((self.basis @ self.block) @ self.inverse)
        return 2.0 ** _balancing_exponents(np.abs(self.zeros).max() * np.abs(self.projector) + motion)

    @cached_property
    def coupling(self) -> float:
        """Norm of the projector in these units, by the root of its rank: 1 for orthogonal motions."""
        return float(np.linalg.norm(self.projector * self.units / self.units[:, None])) / len(self.block) ** 0.5


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
    balance = power_of_two(_balancing_exponents(magnitude(matrix)))
    parts = _clustered(_separated(matrix * balance / balance[:, None]))
    schur = [_schur(part) for part in parts]
    return BlockDiagonal(
        balance[:, None] * np.hstack([part.basis for part in schur]),
        np.vstack([part.inverse for part in schur]) / balance,
        tuple(part.block for part in schur),
        max(part.coupling for part in parts),
    )


def _separated(matrix) -> list[_Part]:
    """The blocks of a balanced matrix, each as small as the arithmetic can separate."""
    start, sets = _start(rounded_to_float(matrix))
    scale = _refined(matrix, precise(start), sets)
    found = []
    for at in scale.parts:
        part = _Part(scale.basis[:, at], scale.inverse[at], scale.product[np.ix_(at, at)])
        found += [part] if len(at) == 1 or len(scale.parts) == 1 else [_within(part, inner) for inner in _balanced(part.block)]
    return found


def _balanced(matrix) -> list[_Part]:
    """The same for a matrix that is not balanced yet."""
    balance = power_of_two(_balancing_exponents(magnitude(matrix)))
    parts = _separated(matrix * balance / balance[:, None])
    return [_Part(balance[:, None] * part.basis, part.inverse / balance, part.block) for part in parts]


def _within(outer: _Part, inner: _Part) -> _Part:
    return _Part(outer.basis @ inner.basis, inner.inverse @ outer.inverse, inner.block)


def _schur(part: _Part) -> _Part:
    """The part in a basis of norm one in which its block is a float64 real Schur form."""
    part = _in_own_units(part)
    T, turn = scipy.linalg.schur(rounded_to_float(part.block), output="real")
    ratio = abs(T[1, 0] / T[0, 1]) if len(T) == 2 and T[1, 0] else 0.0
    rotation = _rotation(part.block) if 1 / MOST_STRETCHED < ratio < MOST_STRETCHED else None
    T, turn = rotation or (T, precise(turn))
    basis, back = part.basis @ turn, inverse(turn) @ part.inverse
    size = power_of_two(np.round(np.log2(magnitude(basis).max())))
    return _Part(basis / size, back * size, T)


def _rotation(block):
    """A complex pair as [[a, w], [-w, a]], a and w to their own last digits, and the basis in which it is that.

    It stays what it is however its two states are rotated. None where the zeros are real, if only by more digits.
    """
    a = (block[0, 0] + block[1, 1]) / 2
    square = block[0, 0] * block[1, 1] - block[0, 1] * block[1, 0] - a * a
    if square <= 0:
        return None
    w = square.sqrt()
    first = precise(np.array([1.0, 0.0]))
    turn = np.column_stack([first, (block @ first - a * first) / -w])
    return np.array([[float(a), float(w)], [-float(w), float(a)]]), turn


def _clustered(parts: list[_Part]) -> list[_Part]:
    """Join parts whose separation costs more digits than the limit, each with the one whose zeros are nearest."""
    while len(parts) > 1:
        worst = int(np.argmax([part.coupling for part in parts]))
        if parts[worst].coupling <= DECOUPLING_LIMIT:
            break
        distance = [np.abs(np.subtract.outer(parts[worst].zeros, part.zeros)).min() for part in parts]
        distance[worst] = np.inf
        nearest = int(np.argmin(distance))
        together = _together(parts[worst], parts[nearest])
        parts = [part for i, part in enumerate(parts) if i not in (worst, nearest)] + [together]
    return parts


def _together(first: _Part, second: _Part) -> _Part:
    """Two parts as one."""
    count = len(first.block)
    block = precise(np.zeros((count + len(second.block),) * 2))
    block[:count, :count], block[count:, count:] = first.block, second.block
    return _in_own_units(_Part(np.hstack([first.basis, second.basis]), np.vstack([first.inverse, second.inverse]), block))


def _in_own_units(part: _Part) -> _Part:
    """The part in a basis that is orthonormal in the units that its own motion suggests.

    In those of a faster motion the block of a slow one would have entries much larger than its zeros.
    """
    turn = precise(np.linalg.qr(rounded_to_float(part.basis) / part.units[:, None], mode="r"))
    back = inverse(turn)
    return _Part(part.basis @ back, turn @ part.inverse, turn @ part.block @ back)


def _balancing_exponents(size: np.ndarray) -> np.ndarray:
    """Whole exponents e for which 2^-e A 2^e has rows and columns of about the same size (LAPACK's balancing)."""
    scale = lapack.dgebal(size, scale=1, permute=0)[3]
    return np.round(np.log2(scale))


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
    for _ in range(MOST_STEPS + len(parts)):
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
