"""Arrays of real numbers with 96 digits, for data over more orders of magnitude than the 16 digits of float64 resolve.

At the end the multiplicity of the zero at s = 0 of a pencil of floats, in the integers modulo a prime: exact but for a chance of 1e-16.
Floats are fractions with powers of two as denominators, so they have images modulo an odd prime, and what is zero stays zero there.
What is not zero vanishes there only if the prime happens to divide it. flint takes 0.4 s for 400 states, NumPy took 1.1 s.

Such an array has dtype object and entries ``arb`` of python-flint, of which only the midpoints count. Entrywise operations are
NumPy's; products and solutions are flint's. A product of 80 rows takes 31 ms, one of ``decimal.Decimal`` 232 ms. flint is imported
when the first such array is created. ``is_precise`` distinguishes the two kinds of array, and each function here takes both, so
that one algorithm serves both.
"""

from __future__ import annotations

import copyreg
from contextlib import AbstractContextManager
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..ground.tolerances import EPS, PRECISE_DIGITS, PRECISE_EPS, PRECISE_STATES, WORTHWHILE_DIGITS, WORTHWHILE_STATES_PER_DIGIT

if TYPE_CHECKING:
    from flint import nmod_mat

#: The largest prime below 2^63, the largest word that flint computes with.
PRIME = 2**63 - 25

#: Where the pencil is inverted: any residues without a pattern.
SHIFTS = (0x5A827999_6ED9EBA1, 0x3243F6A8_885A308D, 0x2B7E1516_28AED2A6)


def precise_arithmetic(digits: int = PRECISE_DIGITS) -> AbstractContextManager:
    """A context in which operations on precise arrays keep their digits; such arrays can be pickled from then on."""
    from flint import arb, ctx

    copyreg.pickle(arb, _pickled)
    return ctx.workdps(digits)


def _pickled(number) -> tuple:
    """Pickle data of a number of a precise array: its midpoint."""
    mantissa, exponent = map(int, number.mid().man_exp())
    return _unpickled, (mantissa, exponent)


def _unpickled(mantissa: int, exponent: int):
    from flint import arb

    return arb((mantissa, exponent))


def is_worthwhile(loss: float, states: int) -> bool:
    """Whether errors ``loss`` times larger than a rounding error justify the time of precise arithmetic for this number of states.

    >>> is_worthwhile(1e6, 60), is_worthwhile(1e6, 100), is_worthwhile(10.0, 2)
    (True, False, False)
    """
    return states <= PRECISE_STATES and loss > 10.0 ** max(WORTHWHILE_DIGITS, states / WORTHWHILE_STATES_PER_DIGIT)


def is_precise(array: np.ndarray) -> bool:
    """True for an array of 96 digits, False for float64."""
    return array.dtype.kind == "O"


def precise(array: np.ndarray) -> np.ndarray:
    """An array with 96 digits: floats exactly, Fractions rounded."""
    from flint import arb, fmpq

    def number(value) -> arb:
        if isinstance(value, arb):
            return value
        return arb(fmpq(value.numerator, value.denominator)).mid() if isinstance(value, Fraction) else arb(float(value))

    with precise_arithmetic():
        return _array([number(value) for value in np.asarray(array).flat], np.shape(array))


def of_kind(array: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The array with as many digits as the other one, where that has more."""
    return precise(array) if is_precise(other) and not is_precise(array) else array


def floats(array: np.ndarray) -> np.ndarray:
    """The nearest float64 numbers, the array itself where it has them."""
    return array if array.dtype.kind == "f" else array.astype(float)


def magnitude(array: np.ndarray) -> np.ndarray:
    """Absolute values in float64."""
    return np.abs(floats(array))


def unit(array: np.ndarray) -> float:
    """Relative rounding error of one operation on such an array."""
    return PRECISE_EPS if is_precise(array) else EPS


def midpoints(array: np.ndarray) -> np.ndarray:
    """The numbers without the radii that operations have added; a float64 array itself."""
    return _array([value.mid() for value in array.flat], array.shape) if is_precise(array) else array


def power_of_two(exponents) -> np.ndarray:
    """2^e for an array of whole exponents, precise."""
    from flint import arb

    return _array([arb(2) ** int(e) for e in np.asarray(exponents).flat], np.shape(exponents))


def product(*factors: np.ndarray) -> np.ndarray:
    """The product of matrices, precise where one of them is."""
    if not any(map(is_precise, factors)):
        return factors[0].dot(product(*factors[1:])) if len(factors) > 2 else factors[0].dot(factors[1])
    total = _matrix(factors[0])
    for factor in factors[1:]:
        total = (total * _matrix(factor)).mid()
    return _array(total.entries(), (total.nrows(), total.ncols()))


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """matrix^-1 @ right for a regular square matrix."""
    if not is_precise(matrix):
        return np.linalg.solve(matrix, right)
    try:
        solved = _matrix(matrix).solve(_matrix(right), algorithm="approx")
    except ZeroDivisionError:
        raise np.linalg.LinAlgError("singular matrix") from None
    return _array(solved.mid().entries(), right.shape)


def inverse(matrix: np.ndarray) -> np.ndarray:
    """matrix^-1, as ``solved``."""
    return np.linalg.inv(matrix) if not is_precise(matrix) else solved(matrix, np.eye(len(matrix)))


def _matrix(array: np.ndarray):
    from flint import arb_mat

    return arb_mat(*array.shape, array.ravel().tolist()).mid()


def _array(values: list, shape: tuple[int, ...]) -> np.ndarray:
    array = np.empty(shape, dtype=object)
    array.flat = values
    return array


def zero_multiplicity(E: np.ndarray, F: np.ndarray) -> int:
    """The multiplicity of s = 0 as a zero of det(s E - F).

    It is the multiplicity of the eigenvalue 1/c of W = (c E - F)^-1 E for any c with det(c E - F) != 0: the number by which the
    rank of (W - I/c)^k falls short of n for large k.
    """
    n = len(F)
    E, F = modular(E), modular(F)
    for shift in SHIFTS:
        try:
            power = (shift * E - F).solve(E) - pow(shift, -1, PRIME) * modular(np.eye(n))
        except ZeroDivisionError:  # the shift is a zero
            continue
        rank, before = power.rank(), n + 1
        while rank < before:
            power = power * power
            rank, before = power.rank(), rank
        return n - rank
    return 0


def remainders(matrix: np.ndarray) -> np.ndarray:
    """The entries, whole numbers, floats or Fractions of floats, modulo the prime, from 0 on, as Python integers."""
    matrix = np.asarray(matrix)
    values, where = np.unique(matrix, return_inverse=True) if matrix.dtype.kind == "f" else (matrix.ravel(), slice(None))
    ratios = [value.as_integer_ratio() for value in values.tolist()]
    inverses = {denominator: pow(denominator, -1, PRIME) for _, denominator in ratios}
    residues = np.empty(len(ratios), dtype=object)
    residues[:] = [numerator * inverses[denominator] % PRIME for numerator, denominator in ratios]
    return residues[where].reshape(matrix.shape)


def modular(matrix: np.ndarray) -> nmod_mat:
    """The matrix modulo the prime; i stands for any residue without a pattern."""
    from flint import nmod_mat

    real = nmod_mat(*matrix.shape, remainders(matrix.real).ravel().tolist(), PRIME)
    return real + pow(3, PRIME // 5, PRIME) * modular(matrix.imag) if np.iscomplexobj(matrix) else real


#: Up to these sizes the degrees of transfer functions are decided modulo a prime, with a leading coefficient that is regular and with another one.
MOST_REGULAR_ROWS, MOST_SINGULAR_ROWS = 400, 48

#: Of transfer functions that fall faster than s to minus this degree, it is not known how much faster.
HIGHEST_DEGREE = 16


def relative_degrees(coefficients: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> np.ndarray | None:
    """The d of C A(s)^-1 B ~ s^-d towards infinity, decided by the data modulo a prime and not by sums that cancel.

    Where A_q is regular modulo the prime, C A^-1 B = s^-q (C X_0 B + C X_1 B / s + ...), A_q X_k = -(A_(q-1) X_(k-1) + ... + A_0 X_(k-q)), X_0 = A_q^-1.
    Else the degrees of det A(s) and of C adj A(s) B follow from their values at as many points as det A(s) can have roots. Each decision is wrong with the
    chance of about 1e-17.
    """
    from flint import nmod_mat

    r, (p, m) = len(inputs), (len(outputs), inputs.shape[1])
    if r > MOST_REGULAR_ROWS:
        return None
    parts, B, C = [modular(A) for A in coefficients], modular(inputs), modular(outputs)
    result = np.full((p, m), np.inf)
    if parts[-1].rank() == r:
        inverse, terms = parts[-1].inv(), []
        for degree in range(len(parts) - 1, HIGHEST_DEGREE + 1):
            right = (
                B
                if not terms
                else sum((part * X for part, X in zip(parts[-2::-1], terms[::-1])), nmod_mat(r, m, PRIME)) * (PRIME - 1)
            )
            terms.append(inverse * right)
            values = np.array([int(entry) != 0 for entry in (C * terms[-1]).entries()]).reshape(p, m)
            result[values & np.isinf(result)] = degree
            if np.isfinite(result).all():
                break
        return result
    if r > MOST_SINGULAR_ROWS:
        return None
    most = int(sum(max((k for k, A in enumerate(coefficients) if A[i].any()), default=0) for i in range(r)))
    points, values, step = [], [], pow(5, PRIME // 7, PRIME)
    point = step
    while len(points) <= most:
        point = point * step % PRIME
        matrix = parts[-1]
        for part in parts[-2::-1]:
            matrix = point * matrix + part
        if determinant := int(matrix.det()):
            points.append(point)
            numerators = C * matrix.solve(B) * determinant
            values += [determinant, *map(int, numerators.entries())]
    powers = [pow(point, k, PRIME) for point in points for k in range(most + 1)]
    size = most + 1
    solution = nmod_mat(size, size, powers, PRIME).solve(nmod_mat(size, 1 + p * m, values, PRIME)).entries()
    nonzero = np.array([int(entry) != 0 for entry in solution]).reshape(size, -1)
    degrees = np.where(nonzero.any(axis=0), size - 1 - nonzero[::-1].argmax(axis=0), -np.inf)
    return (degrees[0] - degrees[1:]).reshape(p, m)


def zero_transfers(coefficients: np.ndarray, inputs: np.ndarray, outputs: np.ndarray) -> np.ndarray | None:
    """Which entries of C A(s)^-1 B vanish for every s: those zero at a point modulo the prime, wrong with a chance of 1e-16.

    >>> links = np.array([[2.0, 1e-200, 0.0], [1e-200, 2.0, 0.0], [0.0, 0.0, 1.0]])
    >>> zero_transfers(links[None], np.eye(3), np.eye(3))[0].tolist()
    [False, False, True]
    """
    if len(inputs) > MOST_REGULAR_ROWS:
        return None
    for shift in SHIFTS:
        matrix = modular(coefficients[-1])
        for part in coefficients[-2::-1]:
            matrix = shift * matrix + modular(part)
        try:
            values = modular(outputs) * matrix.solve(modular(inputs))
        except ZeroDivisionError:  # the shift is a zero
            continue
        return np.array([int(entry) == 0 for entry in values.entries()]).reshape(len(outputs), -1)
    return None
