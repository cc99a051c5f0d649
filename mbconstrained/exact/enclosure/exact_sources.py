"""An input as a sum of vectors times scalar functions that start at given times, from the exact data of the input."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise
from math import factorial

import flint
import numpy as np

from ...linalg.blocks import block_slices
from ...signals.impulsive import ExactImpulse, ExactInput, ExactRecord, ExactStates, ExactTerm, ImpulsiveSmooth, without_phase_noise
from ..rational import RationalMatrix, rational

Vector = tuple[flint.fmpq, ...]


@dataclass(frozen=True)
class ExactSource:
    """factor * vector * g(t - time), g given by its shape."""

    shape: Shape
    vector: Vector
    time: flint.fmpq
    factor: Factor

    def normalized(self) -> ExactSource:
        """The source with a vector whose first nonzero entry is one."""
        first = next(entry for entry in self.vector if entry)
        return replace(self, vector=tuple(entry / first for entry in self.vector), factor=self.factor * first)


def sources_of(force: ImpulsiveSmooth) -> tuple[ExactSource, ...]:
    """The sources whose sum is the input, without vanishing ones."""
    sources = (source for origin in force.exact_parts for source in _of_origin(origin))
    return tuple(source for source in sources if any(source.vector) and source.factor != 0)


def vector_of(values: Iterable) -> Vector:
    return tuple(rational(value) for value in values)


def _of_origin(origin: ExactInput) -> Iterator[ExactSource]:
    for source in _MAKERS[type(origin.data)](origin.data, origin):
        for change in origin.maps:
            if np.ndim(change):
                source = replace(source, vector=tuple(applied([vector_of(row) for row in np.asarray(change)], source.vector)))
            else:
                source = replace(source, factor=source.factor * rational(change))
        yield replace(source, shape=source.shape.times(S**origin.derivatives))


def _of_term(term: ExactTerm, origin: ExactInput) -> Iterator[ExactSource]:
    time = rational(origin.time())
    vector = tuple(entry / term.divisor for entry in vector_of(term.vector))
    cosine, sine = phase_factors(term.phase)
    with_cosine, with_sine = harmonic_powers(term.power, term.rate, term.angular_frequency)
    yield ExactSource(with_cosine, vector, time, cosine)
    if with_sine.numerator:
        yield ExactSource(with_sine, vector, time, sine * flint.fmpq(-1))


def _impulses(vectors: Iterable, time: float) -> Iterator[ExactSource]:
    for order, vector in enumerate(vectors):
        yield ExactSource(delta(order), vector_of(vector), rational(time), flint.fmpq(1))


def _of_record(record: ExactRecord, origin: ExactInput) -> Iterator[ExactSource]:
    """Steps and ramps at the samples, row by row."""
    times = [rational(origin.time(float(time))) for time in record.times]
    for row, values in enumerate(record.values):
        unit = tuple(flint.fmpq(int(k == row)) for k in range(len(record.values)))
        before, slope = flint.fmpq(0), flint.fmpq(0)
        samples = list(zip(times, map(rational, values)))
        for (time, value), (end, next_value) in pairwise([*samples, (times[-1], flint.fmpq(0))]):
            new = (next_value - value) / (end - time) if end != time else flint.fmpq(0)
            yield ExactSource(power(0), unit, time, value - before)
            yield ExactSource(power(1), unit, time, new - slope)
            before, slope = (next_value if end != time else value), new
        yield ExactSource(power(0), unit, times[-1], -before)


def _of_states(data: ExactStates, origin: ExactInput) -> Iterator[ExactSource]:
    """e^{J (t - t_j)} z_j between knots: each piece starts, and its continuation beyond the next knot is subtracted."""
    yield from _impulses(data.impulses, origin.rounded_time())
    for load in data.later:
        yield from _impulses(load.impulses, origin.rounded_time(load.time))
    restarts = data.smooth.restarts
    moments = restarts.moments.tolist()
    knots = [rational(origin.time(moment.real)) + rational(moment.imag) for moment in moments]
    for block, at in zip(data.smooth.blocks, block_slices(data.smooth.blocks)):
        shapes = _states_shapes(block)
        for row, vector in enumerate(data.smooth.coefficients[:, at].T):
            if vector.any():
                yield from _pieces(shapes[row], vector_of(vector), block, knots, restarts.states[at].T)


def _pieces(shapes: Sequence[Shape], vector: Vector, block, knots, states) -> Iterator[ExactSource]:
    """Pieces of the function: at each knot the new states begin, and the continuation of those before is subtracted."""
    generator = tuple(vector_of(line) for line in block)
    nothing = (flint.fmpq(0),) * len(generator)
    before, since = nothing, knots[0]
    for knot, state in zip(knots, map(vector_of, states)):
        left = _propagated(generator, before, knot - since)
        for entry, shape in enumerate(shapes):
            yield ExactSource(shape, vector, knot, state[entry] if left is None else state[entry] - left[entry])
            if left is None:
                left_over = Irrational(flint.fmpq(-1), _state, (generator, before, knot - since, entry))
                yield ExactSource(shape, vector, knot, left_over)
        before, since = state, knot


def _propagated(generator, start: Vector, time: flint.fmpq) -> Vector | None:
    """e^{J t} v where it is rational, because J is nilpotent or v is zero."""
    total, power = start, start
    for k in range(1, len(generator) + 1):
        power = tuple(entry * time / k for entry in applied(generator, power))
        if not any(power):
            return total
        total = tuple(a + b for a, b in zip(total, power))
    return None


def _states_shapes(block: np.ndarray) -> list[list[Shape]]:
    """The entries of (s I - J)^-1."""
    pencil = RationalMatrix([-block, np.eye(len(block))])
    return [[_reduced(entry, pencil.determinant) for entry in row] for row in pencil.adjugate]


def _reduced(above: flint.fmpq_poly, below: flint.fmpq_poly) -> Shape:
    common = above.gcd(below)
    return Shape(above // common, below // common)


def applied(matrix: Iterable[Iterable[flint.fmpq]], values: Sequence, zero=flint.fmpq(0)) -> list:
    """The product of a matrix with numbers, or with polynomials and their zero."""
    return [sum((entry * value for entry, value in zip(row, values) if entry and value), zero) for row in matrix]


_MAKERS: dict[type, Callable[..., Iterator[ExactSource]]] = {
    ExactTerm: _of_term,
    ExactImpulse: lambda data, origin: _impulses([*[0 * data.vector] * data.order, data.vector], origin.rounded_time()),
    ExactRecord: _of_record,
    ExactStates: _of_states,
}


# Real factors of inputs: rational ones, and those that are known as balls of any precision, such as the cosine of a phase.


@dataclass(frozen=True)
class Irrational:
    """amount times an irrational number, of which there are balls of any precision: ``enclosed`` of the data."""

    amount: flint.fmpq
    enclosed: Callable[..., flint.arb]
    data: tuple

    def __mul__(self, factor: flint.fmpq) -> Irrational:
        return replace(self, amount=self.amount * factor)


def _sine(phase: flint.fmpq) -> flint.arb:
    return flint.arb(phase).sin()


def _cosine(phase: flint.fmpq) -> flint.arb:
    return flint.arb(phase).cos()


def _state(generator, start, time, entry: int) -> flint.arb:
    """One entry of e^{J t} v, the states of a piece at its end."""
    return _propagated_ball(generator, start, time, flint.ctx.prec)[entry]


@lru_cache(maxsize=4096)
def _propagated_ball(generator, start, time, precision: int) -> list[flint.arb]:
    """e^{J t} v at the working precision."""
    moved = flint.arb_mat([[flint.arb(entry * time) for entry in row] for row in generator]).exp()
    return (moved * flint.arb_mat([[flint.arb(value)] for value in start])).entries()


Factor = flint.fmpq | Irrational


def ball(factor: Factor) -> flint.arb:
    """A ball that contains a factor, at the working precision."""
    if isinstance(factor, flint.fmpq):
        return flint.arb(factor)
    return flint.arb(factor.amount) * factor.enclosed(*factor.data)


def added(calls: Iterable[tuple[flint.fmpq, Factor]]) -> tuple[tuple[flint.fmpq, Factor], ...]:
    """Times and factors, with factors of one kind added at equal times; those that cancel exactly are omitted."""
    total: dict[tuple[flint.fmpq, Irrational | None], flint.fmpq] = {}
    for time, factor in calls:
        kind = replace(factor, amount=flint.fmpq(1)) if isinstance(factor, Irrational) else None
        amount = factor.amount if isinstance(factor, Irrational) else factor
        total[time, kind] = total.get((time, kind), flint.fmpq(0)) + amount
    return tuple((time, amount if kind is None else kind * amount) for (time, kind), amount in total.items() if amount)


def phase_factors(phase: float) -> Sequence[Factor]:
    """cos p and sin p; a quarter turn up to rounding errors is taken as exact (``signals.impulsive``)."""
    factors, values = [], (math.cos(phase), math.sin(phase))
    for sine, value in enumerate(values):
        other = values[1 - sine]
        if without_phase_noise(value, phase) == 0:
            factors.append(flint.fmpq(0))
        elif without_phase_noise(other, phase) == 0:
            factors.append(flint.fmpq(round(value)))
        else:
            factors.append(Irrational(flint.fmpq(1), _sine if sine else _cosine, (rational(phase),)))
    return factors


# Scalar functions of time by their Laplace transforms, which are rational: t^k e^{at} cos wt, Dirac's delta and its derivatives.

ONE = flint.fmpq_poly([1])
S = flint.fmpq_poly([0, 1])


@dataclass(frozen=True)
class Shape:
    """A function of time, zero before t = 0, with the transform numerator / denominator."""

    numerator: flint.fmpq_poly
    denominator: flint.fmpq_poly = field(default_factory=lambda: flint.fmpq_poly([1]))

    def times(self, p: flint.fmpq_poly) -> Shape:
        """The function after p(d/dt), with jumps and impulses at t = 0."""
        return Shape(self.numerator * p, self.denominator)

    @property
    def key(self) -> tuple:
        """A key that is equal for equal transforms."""
        return tuple(map(str, self.numerator.coeffs())), tuple(map(str, self.denominator.coeffs()))


def summed(parts: Iterable[tuple[Vector, Shape]], size: int) -> tuple[list[flint.fmpq_poly], flint.fmpq_poly]:
    """The sum of vectors times transforms, over a common denominator."""
    total, below = [flint.fmpq_poly([0])] * size, ONE
    for vector, shape in parts:
        common = below.gcd(shape.denominator)
        own, other = shape.denominator // common, below // common
        total, below = [entry * own + shape.numerator * other * factor for entry, factor in zip(total, vector)], below * own
    return total, below


def delta(order: int) -> Shape:
    """The derivative of this order of Dirac's delta."""
    return Shape(S**order)


def power(k: int) -> Shape:
    """t^k / k!."""
    return Shape(ONE, S ** (k + 1))


def harmonic_powers(k: int, rate, angular_frequency) -> tuple[Shape, Shape]:
    """t^k e^{at} cos wt and t^k e^{at} sin wt: real and imaginary part of k! / (s - a - i w)^(k + 1) for real s."""
    moved, w = S - rational(rate), flint.fmpq_poly([rational(angular_frequency)])
    real, imaginary = flint.fmpq_poly([factorial(k)]), flint.fmpq_poly([0])
    for _ in range(k + 1):
        real, imaginary = real * moved - imaginary * w, real * w + imaginary * moved
    below = (moved**2 + w**2) ** (k + 1)
    return _reduced(real, below), _reduced(imaginary, below)
