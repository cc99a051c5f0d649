"""Solutions of difference equations in closed form, in ball arithmetic.

With X(z) = sum of x_k z^(-k-1) the equations A(sigma) x = f become A(z) X(z) = X_in(z) + F(z), X_in as for differential equations
(x_k in place of the k-th derivative at 0-). Partial fractions c_j / (z - p)^j of X give c_j binom(k, j - 1) p^(k-j+1), p^k by repeated
squaring of a ball. Sums over the values of a force go from sample to sample in the coordinates of the poles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb, inf
from typing import TypeAlias

import flint
import numpy as np

from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.sequences import GeometricSequence, GeometricTerm, stirling_numbers
from ..rational import RationalMatrix, exact_value, rational, rational_matrix, working_precision
from .exact_response import MOST_BITS, ROUNDED_BITS, SMALLEST_EXPONENT, Inverse, RationalResponse, real_sums, start_transform
from .exact_sources import ball, phase_factors, vector_of

#: Bits of the first attempt, and of ratios e^(a + i w), whose error then does not matter up to any k that has a value in float64.
FIRST_BITS, RATIO_BITS = 128, 600

#: Bits of values at the end of a horizon, of which those that run forwards and backwards may cancel most.
BOUNDARY_BITS = 256

#: Values below this vanish in float64.
SMALLEST = flint.arb(2) ** SMALLEST_EXPONENT

ZERO, ZERO_POLYNOMIAL, ONE_POLYNOMIAL = flint.fmpq(0), flint.fmpq_poly([0]), flint.fmpq_poly([1])


class RealizedMatrix:
    """C (z I - J)^-1 B + H_0 + H_1 z + ... in place of A(z)^-1, all numbers taken exactly."""

    def __init__(self, C: np.ndarray, J: np.ndarray, B: np.ndarray, H: Sequence[np.ndarray]):
        self._pencil = RationalMatrix([(-J).tolist(), np.eye(len(J)).tolist()]) if len(J) else None
        self._C, self._B = exact_rows(C), exact_rows(B)
        self._H = [exact_rows(matrix) for matrix in H]
        self.size = len(C)

    @property
    def determinant(self) -> flint.fmpq_poly:
        """det(z I - J)."""
        return ONE_POLYNOMIAL if self._pencil is None else self._pencil.determinant

    def numerators(self, b: Sequence[flint.fmpq_poly]) -> list[flint.fmpq_poly]:
        """The inverse times b, times the determinant."""
        total = [ZERO_POLYNOMIAL] * self.size
        if self._pencil is not None:
            total = applied(self._C, self._pencil.numerators(applied(self._B, b)))
        for power, matrix in enumerate(self._H):
            shift = self.determinant.left_shift(power)
            total = [one + other * shift for one, other in zip(total, applied(matrix, b))]
        return total


def exact_rows(matrix: np.ndarray) -> list[list[flint.fmpq]]:
    return [[rational(entry) for entry in row] for row in np.asarray(matrix).tolist()]


def applied(matrix: Sequence[Sequence[flint.fmpq]], values: Sequence, zero=ZERO_POLYNOMIAL) -> list:
    """The product of a matrix with polynomials, or with numbers and their zero."""
    return [sum((entry * value for entry, value in zip(row, values) if entry and value), zero) for row in matrix]


def inverse_columns(inverse: Inverse, size: int) -> tuple[RationalResponse, ...]:
    """A(z)^-1, column by column."""
    units = ([flint.fmpq_poly([int(i == j)]) for i in range(size)] for j in range(size))
    return tuple(RationalResponse(inverse, unit, ONE_POLYNOMIAL, range(size)) for unit in units)


def response_to(
    inverse: Inverse, A: PolynomialMatrix, initial: np.ndarray, sequence: GeometricSequence | None, matrix: np.ndarray | None = None
) -> RationalResponse:
    """The response to a start of shape (q, r) and to a force in closed form, a sequence or the product of a matrix with it."""
    coefficients = [rational_matrix(one) for one in A.exact_coefficients]
    b, below = start_transform(coefficients, [vector_of(row) for row in initial.tolist()]), ONE_POLYNOMIAL
    if sequence is not None:
        own, below = transform_of(sequence)
        own = own if matrix is None else applied(exact_rows(matrix), own)
        b = [one * below + other for one, other in zip(b, own)]
    return RationalResponse(inverse, b, below, range(A.size))


def rows_before(response: RationalResponse) -> list[np.ndarray]:
    """The coefficients of z^0, z^1, ..., which are x_-1, x_-2, ..., rounded."""
    return [np.array([float(flint.arb(entry)) for entry in column]) for column in response.impulses]


# Transforms of sequences in closed form.

Transform = tuple[list[flint.fmpq_poly], flint.fmpq_poly]


def transform_of(sequence: GeometricSequence) -> Transform:
    """F(z) = sum of f_k z^(-k-1) as polynomials over a common denominator."""
    b, denominator = [ZERO_POLYNOMIAL] * sequence.size, ONE_POLYNOMIAL
    for term in sequence.terms:
        own, below = _term_transform(term)
        b = [one * below + other * denominator for one, other in zip(b, own)]
        denominator *= below
    return b, denominator


def _term_transform(term: GeometricTerm) -> Transform:
    """Real part of v sum of S(p, j) j! m^j / (z - m)^(j + 1)."""
    a, b = _ratio(term)
    cosine, sine = _phase(term)
    real, imaginary = (ZERO_POLYNOMIAL, ZERO_POLYNOMIAL)
    factor = (flint.fmpq(1), flint.fmpq(0))  # m^j
    p = term.power
    below = flint.fmpq_poly([a * a + b * b, -2 * a, 1]) if b else flint.fmpq_poly([-a, 1])
    above = (flint.fmpq_poly([-a, 1]), flint.fmpq_poly([-b]))  # z - m
    conjugate = (flint.fmpq_poly([-a, 1]), flint.fmpq_poly([b])) if b else (ONE_POLYNOMIAL, ZERO_POLYNOMIAL)
    for j, number in enumerate(stirling_numbers(p)):
        product = _complex_product((factor[0] * number * ONE_POLYNOMIAL, factor[1] * number * ONE_POLYNOMIAL), (cosine, sine))
        for other in (*[above] * (p - j), *[conjugate] * (p + 1)):
            product = _complex_product(product, other)
        real, imaginary = real + product[0], imaginary + product[1]
        factor = (factor[0] * a - factor[1] * b, factor[0] * b + factor[1] * a)
    vector = np.asarray(term.vector)
    rows = [real * rational(v.real) - imaginary * rational(v.imag) for v in vector.astype(complex).tolist()]
    scale = rational(term.step) ** p / term.divisor
    return [row * scale for row in rows], below ** (p + 1)


def _complex_product(one, other):
    return one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]


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


# Forces given by their values: x_k = sum over i <= k - 1 of H_(i-k) f_i + sum over i >= 0 of H_i f_(k+i).


@dataclass
class PoleChain:
    """States s_1 ... s_m of a pole p: s_j(k + 1) = p s_j(k) + s_(j-1)(k), s_0 = f of one input."""

    input: int
    pole: flint.acb
    states: list[flint.acb]
    sizes: list[float]

    def step(self, value: flint.acb, modulus: float) -> None:
        """Move from k to k + 1, with the middles of balls, and bounds of the moduli of all that is added."""
        size = float(self.pole.abs_upper())
        before, mass = value, modulus
        for j, (state, own) in enumerate(zip(self.states, self.sizes)):
            self.states[j], self.sizes[j] = (self.pole * state + before).mid(), size * own + mass
            before, mass = state, own

    def later(self, count: int) -> tuple[list[flint.acb], list[float]]:
        """The states after so many samples without force."""
        powers = [self.pole ** (count - a) * comb(count, a) if count >= a else flint.acb(0) for a in range(len(self.states))]
        sizes = [float(power.abs_upper()) for power in powers]
        states = [sum((powers[a] * self.states[j - a] for a in range(j + 1)), flint.acb(0)) for j in range(len(self.states))]
        return states, [sum(sizes[a] * self.sizes[j - a] for a in range(j + 1)) for j in range(len(self.states))]


class ForceSums:
    """The response from rest to a force given by its values.

    Args:
        responses: the response to a unit pulse of each input, that is a column of A(z)^-1.
        values: returns f_k as exact numbers (p,), zero from ``end`` on.
        end: the number of values; infinite for a function.
    """

    def __init__(self, responses: Sequence[RationalResponse], values: Callable[[int], Sequence[flint.fmpq]], end: float):
        self.responses, self.values, self.end = responses, values, end
        self.size = responses[0].size if responses else 0

    def at(self, indices: Sequence[int]) -> tuple[list[list[flint.arb]], list[flint.arb]]:
        """x_k for ascending k at the working precision, and bounds of the errors of the recursion."""
        chains, columns, radii, relative = self._chains()
        lines: list[list[flint.acb]] = []
        errors, number = [], 0
        weights = [max((abs(c).abs_upper() for c in column), default=flint.arb(0)) for column in columns]
        for k in indices:
            while number < min(k, self.end):
                values = self.values(number)
                for chain in chains:
                    value = values[chain.input]
                    chain.step(flint.acb(flint.arb(value)), abs(float(value)))
                number += 1
            present = [(chain.states, chain.sizes) if number == k else chain.later(k - number) for chain in chains]
            states = [state for own, _ in present for state in own]
            sizes = [size for _, own in present for size in own]
            lines.append(states)
            errors.append(sum(((relative * (4 * k + 16) * w + r) * s for w, r, s in zip(weights, radii, sizes)), flint.arb(0)))
        rows = real_sums(list(zip(*lines)), columns, len(indices), self.size).tolist()
        for row, k in zip(rows, indices):
            row[:] = [a + flint.arb(b) for a, b in zip(row, self._direct(k))]
        return rows, errors

    def _chains(self):
        """The chains of all poles, their columns and the radii of these, and the relative error of a pole."""
        chains, columns, radii = [], [], []
        relative = flint.arb(2) ** (4 - flint.ctx.prec)
        for place, response in enumerate(self.responses):
            for pole in response.poles(0):
                count, size = len(pole.columns), abs(pole.value).abs_lower()
                relative = max(relative, _radius(pole.value) / size)
                chains.append(PoleChain(place, pole.value.mid(), [flint.acb(0)] * count, [0.0] * count))
                for column in pole.columns:
                    columns.append([c.mid() * pole.weight for c in column])
                    radii.append(max((_radius(c) * pole.weight for c in column), default=flint.arb(0)))
        return chains, columns, radii, relative

    def _direct(self, k: int) -> list[flint.fmpq]:
        """The contribution of poles at z = 0 and of the polynomial part, exactly."""
        total = [flint.fmpq(0)] * self.size
        for place, response in enumerate(self.responses):
            taps = [(k - 1 - i, column) for i, column in enumerate(response.at_zero)]
            taps += [(k + i, column) for i, column in enumerate(response.impulses)]
            for number, column in taps:
                if 0 <= number < self.end and (value := self.values(number)[place]):
                    total = [a + value * c for a, c in zip(total, column)]
        return total


def _radius(number: flint.acb) -> flint.arb:
    """A bound of the radius of a complex ball."""
    return number.real.rad() + number.imag.rad()


Row: TypeAlias = "tuple[list[flint.arb], flint.arb, float]"


def ball_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int], bits: int) -> list[Row]:
    """Balls with so many bits relative to the largest entry of a sample, an additional bound, and the relative error of each sample."""
    size, result = closed[0].size, [([], flint.arb(0), 0.0) for _ in indices]
    pending, precision = sorted(range(len(indices)), key=indices.__getitem__), max(FIRST_BITS, 2 * bits)
    while pending and size:
        numbers = [indices[place] for place in pending]
        with working_precision(precision):
            rows, bounds = [[flint.arb(0)] * size for _ in numbers], [flint.arb(0)] * len(numbers)
            for one in closed:
                rows = [[a + b for a, b in zip(*both)] for both in zip(rows, closed_values(one, numbers))]
            for own in sums:
                more, error = own.at(numbers)
                rows = [[a + b for a, b in zip(*both)] for both in zip(rows, more)]
                bounds = [a + b for a, b in zip(bounds, error)]
            left = []
            for place, row, bound in zip(pending, rows, bounds):
                radius, largest = max(entry.rad() for entry in row) + bound, max(entry.abs_lower() for entry in row)
                settled = bool(radius * 2**bits <= largest) or bool(largest + radius < SMALLEST)
                result[place] = row, bound, float(radius / largest) if largest > 0 else (0.0 if settled else inf)
                if not settled and precision < MOST_BITS:
                    left.append(place)
        pending, precision = left, 2 * precision
    return result


def rounded_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int]):
    """Values (r, T) rounded to float64, and bounds of their errors relative to the largest entry of each column, shape (T,)."""
    values, errors = np.zeros((closed[0].size, len(indices))), np.zeros(len(indices))
    for place, (row, bound, errors[place]) in enumerate(ball_values(closed, sums, indices, ROUNDED_BITS)):
        for i, entry in enumerate(row):
            values[i, place] = 0.0 if abs(entry.mid()) <= entry.rad() + bound else float(entry.mid())
    return values, errors


def exact_values(closed: Sequence[RationalResponse], sums: Sequence[ForceSums], indices: Sequence[int]) -> list[list[flint.fmpq]]:
    """Numbers that agree with the samples to ``BOUNDARY_BITS`` bits of the largest entry."""
    return [[_middle(entry) for entry in row] for row, *_ in ball_values(closed, sums, indices, BOUNDARY_BITS)]


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
