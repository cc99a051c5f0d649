"""Solutions of difference equations in closed form, in ball arithmetic.

With X(z) = sum of x_k z^(-k-1) the equations A(sigma) x = f become A(z) X(z) = X_in(z) + F(z), X_in as for differential equations
(x_k in place of the k-th derivative at 0-). Partial fractions c_j / (z - p)^j of X give c_j binom(k, j - 1) p^(k-j+1), p^k by repeated
squaring of a ball. Sums over the values of a force go from sample to sample in the coordinates of the poles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import comb, factorial, inf
from typing import TypeAlias

import flint
import numpy as np

from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.sequences import GeometricSequence, GeometricTerm, stirling_numbers
from ..rational import RationalMatrix, exact_value, rational, rational_matrix, working_precision
from .exact_response import MOST_BITS, ROUNDED_BITS, SMALLEST_EXPONENT, ZERO, Inverse, RationalResponse, real_sums, start_transform
from .exact_sources import ONE, Shape, Vector, applied, ball, harmonic_powers, phase_factors, summed, vector_of

#: Bits of the first attempt, and of ratios e^(a + i w), whose error then does not matter up to any k that has a value in float64.
FIRST_BITS, RATIO_BITS = 128, 600

#: Bits of values at the end of a horizon, of which those that run forwards and backwards may cancel most.
BOUNDARY_BITS = 256

#: Values below this vanish in float64.
SMALLEST = flint.arb(2) ** SMALLEST_EXPONENT

ZERO_POLYNOMIAL = flint.fmpq_poly([0])


class RealizedMatrix:
    """C (z I - J)^-1 B + H_0 + H_1 z + ... in place of A(z)^-1, all numbers taken exactly."""

    def __init__(self, C: np.ndarray, J: np.ndarray, B: np.ndarray, H: Sequence[np.ndarray]):
        self._pencil = RationalMatrix([-J, np.eye(len(J))]) if len(J) else None
        self._C, self._B = exact_rows(C), exact_rows(B)
        self._H = [exact_rows(matrix) for matrix in H]
        self.size = len(C)

    @property
    def determinant(self) -> flint.fmpq_poly:
        """det(z I - J)."""
        return ONE if self._pencil is None else self._pencil.determinant

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]:
        """The inverse times b, times the determinant."""
        total = [ZERO_POLYNOMIAL] * self.size
        if self._pencil is not None:
            total = applied(self._C, self._pencil.numerators(applied(self._B, b, ZERO_POLYNOMIAL)), ZERO_POLYNOMIAL)
        for power, matrix in enumerate(self._H):
            shift = self.determinant.left_shift(power)
            total = [one + other * shift for one, other in zip(total, applied(matrix, b, ZERO_POLYNOMIAL))]
        return total


def exact_rows(matrix: np.ndarray) -> list[Vector]:
    return [vector_of(row) for row in np.asarray(matrix).tolist()]


def inverse_columns(inverse: Inverse, size: int) -> tuple[RationalResponse, ...]:
    """A(z)^-1, column by column."""
    units = ([flint.fmpq_poly([int(i == j)]) for i in range(size)] for j in range(size))
    return tuple(RationalResponse(inverse, unit, ONE, range(size)) for unit in units)


def response_to(
    inverse: Inverse, A: PolynomialMatrix, initial: np.ndarray, sequence: GeometricSequence | None, matrix: np.ndarray | None = None
) -> RationalResponse:
    """The response to a start of shape (q, r) and to a force in closed form, a sequence or the product of a matrix with it."""
    coefficients = [rational_matrix(one) for one in A.exact_coefficients]
    b, below = start_transform(coefficients, [vector_of(row) for row in initial.tolist()]), ONE
    if sequence is not None:
        own, below = transform_of(sequence)
        own = own if matrix is None else applied(exact_rows(matrix), own, ZERO_POLYNOMIAL)
        b = [one * below + other for one, other in zip(b, own)]
    return RationalResponse(inverse, b, below, range(A.size))


def rows_before(response: RationalResponse) -> list[np.ndarray]:
    """The coefficients of z^0, z^1, ..., which are x_-1, x_-2, ..., rounded."""
    return [np.array([float(flint.arb(entry)) for entry in column]) for column in response.impulses]


# Transforms of sequences in closed form.


def transform_of(sequence: GeometricSequence) -> tuple[list[flint.fmpq_poly], flint.fmpq_poly]:
    """F(z) = sum of f_k z^(-k-1) as polynomials over a common denominator."""
    return summed((part for term in sequence.terms for part in _term_transform(term)), sequence.size)


def _term_transform(term: GeometricTerm) -> Iterator[tuple[list[flint.fmpq], Shape]]:
    """Real part of v sum of S(p, j) j! m^j / (z - m)^(j + 1) as vectors times functions of z."""
    (a, b), (real, imaginary), p = _ratio(term), _phase(term), term.power
    values = [(rational(v.real), rational(v.imag)) for v in np.asarray(term.vector).astype(complex).tolist()]
    scale = rational(term.step) ** p / term.divisor
    for j, number in enumerate(stirling_numbers(p)):  # S(p, j) j!, j! that of the shape
        (cosine, sine), own = harmonic_powers(j, a, b), scale * number / factorial(j)
        yield [(v * real - w * imaginary) * own for v, w in values], cosine
        yield [-(v * imaginary + w * real) * own for v, w in values], sine
        real, imaginary = real * a - imaginary * b, real * b + imaginary * a  # times m


def _ratio(term: GeometricTerm) -> tuple[flint.fmpq, flint.fmpq]:
    a, b = (rational(part) for part in term.ratio)
    if not term.is_exponent:
        return a, b
    with working_precision(RATIO_BITS):
        step = rational(term.step)
        size, angle = flint.arb(a * step).exp(), flint.arb(b * step)
        return _middle(size * angle.cos()), _middle(size * angle.sin())


def _phase(term: GeometricTerm) -> tuple[flint.fmpq, flint.fmpq]:
    if not term.phase:
        return flint.fmpq(1), flint.fmpq(0)
    with working_precision(RATIO_BITS):
        cosine, sine = (_middle(ball(factor)) for factor in phase_factors(term.phase))
        return cosine, sine


def _middle(ball: flint.arb) -> flint.fmpq:
    return rational(exact_value(ball.mid()))


# Values at sample numbers, at the working precision.


def closed_values(response: RationalResponse, indices: Sequence[int]) -> list[list[flint.arb]]:
    """x_k of the strictly proper part, one row (r,) of balls for each k."""
    factors: list[list[flint.acb]] = []
    columns: list[list[flint.acb]] = []
    for pole in response.poles(0):
        for j, column in enumerate(pole.columns):
            factors.append([pole.value ** (k - j) * comb(k, j) if k >= j else flint.acb(0) for k in indices])
            columns.append([c * pole.weight for c in column])
    rows = real_sums(factors, columns, len(indices), response.size).tolist()
    at_zero = response.at_zero
    for row, k in zip(rows, indices):
        if k < len(at_zero):
            row[:] = [a + flint.arb(c) for a, c in zip(row, at_zero[k])]
    return rows


# Forces given by their values: x_k = sum over i of g_(k-i) f_i, a product of power series, g the response to a unit pulse.


class ForceSums:
    """The response from rest to a force given by its values.

    Args:
        responses: the response to a unit pulse of each input, that is a column of A(z)^-1.
        values: returns f_k as exact numbers (p,), zero from ``end`` on.
        end: the number of values; infinite for a function.
    """

    def __init__(self, responses: Sequence[RationalResponse], values: Callable[[int], Sequence[flint.fmpq]], end: float):
        self.responses, self.values, self.end = responses, values, end
        self._ahead = max([1, *(len(response.impulses) for response in responses)])  # f_k acts from x_(k+1-ahead) on

    def at(self, indices: Sequence[int]) -> list[list[flint.arb]]:
        """x_k for ascending k at the working precision."""
        windows: list[list[int]] = []
        for k in indices:
            if windows and k - windows[-1][-1] <= self.end:
                windows[-1].append(k)
            else:
                windows.append([k])
        return [row for window in windows for row in self._window(window)]

    def _window(self, indices: list[int]) -> list[list[flint.arb]]:
        last, count = indices[-1], int(min(self.end, indices[-1] + self._ahead))
        first = max(indices[0] - max(count, 1) + 1, 1 - self._ahead)
        forces, rows = [self.values(i) for i in range(count)], []
        for place, response in enumerate(self.responses):
            force = flint.arb_poly([flint.arb(value[place]) for value in forces])
            before = [*response.impulses, *[[ZERO] * response.size] * (self._ahead - len(response.impulses))]
            pulse = [[flint.arb(c) for c in before[-lag]] for lag in range(first, min(last, 0) + 1)]
            pulse += closed_values(response, range(max(first - 1, 0), last))
            products = [flint.arb_poly(list(own)) * force for own in zip(*pulse)]
            rows.append([[product[k - first] for product in products] for k in indices])
        return [[sum(entries, flint.arb(0)) for entries in zip(*own)] for own in zip(*rows)]


#: Balls of a sample, and their largest radius relative to its largest entry.
Row: TypeAlias = tuple[list[flint.arb], float]


def ball_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int], bits: int) -> list[Row]:
    """Balls with so many bits relative to the largest entry of a sample, and the relative error of each sample."""
    size, result = closed[0].size, [([], 0.0) for _ in indices]
    pending, precision = sorted(range(len(indices)), key=indices.__getitem__), max(FIRST_BITS, 2 * bits)
    while pending and size:
        numbers, left = [indices[place] for place in pending], []
        with working_precision(precision):
            parts = [*(closed_values(one, numbers) for one in closed), *(own.at(numbers) for own in sums)]
            for place, *rows in zip(pending, *parts):
                row = [sum(entries[1:], entries[0]) for entries in zip(*rows)]
                radius, largest = max(entry.rad() for entry in row), max(entry.abs_lower() for entry in row)
                settled = bool(radius * 2**bits <= largest) or bool(largest + radius < SMALLEST)
                result[place] = row, float(radius / largest) if largest > 0 else (0.0 if settled else inf)
                if not settled and precision < MOST_BITS:
                    left.append(place)
        pending, precision = left, 2 * precision
    return result


def rounded_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int]):
    """Values (r, T) rounded to float64, and bounds of their errors relative to the largest entry of each column, shape (T,)."""
    rows = ball_values(closed, sums, indices, ROUNDED_BITS)
    values = [[0.0 if entry.contains(0) else float(entry.mid()) for entry in row] for row, _ in rows]
    return np.array(values).reshape(len(indices), closed[0].size).T, np.array([error for _, error in rows])


def exact_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int]) -> list[list[flint.fmpq]]:
    """Numbers that agree with the samples to ``BOUNDARY_BITS`` bits of the largest entry."""
    return [[_middle(entry) for entry in row] for row, _ in ball_values(closed, sums, indices, BOUNDARY_BITS)]


def without_cancelled(rows: Sequence[Sequence[flint.fmpq]], terms: Sequence[Sequence[flint.fmpq]]) -> list[list[flint.fmpq]]:
    """Rows in which sums of terms that agree to half of ``BOUNDARY_BITS`` are zero."""
    noise = max((abs(entry) for row in terms for entry in row), default=ZERO) / 2 ** (BOUNDARY_BITS // 2)
    return [[entry if abs(entry) > noise else ZERO for entry in row] for row in rows]


@dataclass(frozen=True, eq=False)
class SequenceTerm:
    """A term of x_k: the real part of v binom(k, j) p^(k - j); a p above the real axis stands for a pair."""

    pole: complex  # p
    order: int  # j
    vector: np.ndarray  # v, shape (r,), complex; twice the residue of a complex p


def closed_terms(response: RationalResponse) -> tuple[SequenceTerm, ...]:
    """The closed form of the strictly proper part, rounded to float64; p = 0 contributes v at k = j alone."""
    with working_precision(2 * FIRST_BITS):
        terms = [
            SequenceTerm(complex(pole.value), j, np.array([complex(c) * pole.weight for c in column]))
            for pole in response.poles(0)
            for j, column in enumerate(pole.columns)
        ]
    zero = [
        SequenceTerm(0j, k, np.array([complex(float(flint.arb(c))) for c in column])) for k, column in enumerate(response.at_zero)
    ]
    return tuple(term for term in (*zero, *terms) if term.vector.any())
