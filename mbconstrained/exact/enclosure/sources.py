"""An input as a sum of vectors times scalar functions that start at given times, from what the input was made of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import flint
import numpy as np

from ...linalg.blocks import block_slices
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.origins import ImpulseOrigin, Origin, RecordOrigin, StatesOrigin, TermOrigin
from ..rational.arithmetic import rational
from ..rational.matrix import RationalMatrix
from .factors import Carried, Factor, turned
from .shapes import Shape, decaying_power, delta, power, turning_powers

Vector = tuple[flint.fmpq, ...]


@dataclass(frozen=True)
class Source:
    """factor * vector * g(t - time), g given by its shape."""

    shape: Shape
    vector: Vector
    time: flint.fmpq
    factor: Factor

    def normalized(self) -> Source:
        """The same with a vector whose first entry that is not zero is one."""
        first = next(entry for entry in self.vector if entry)
        return replace(self, vector=tuple(entry / first for entry in self.vector), factor=self.factor * first)

    def mapped(self, matrix: Sequence[Sequence[flint.fmpq]]) -> Source:
        """matrix @ the source."""
        return replace(self, vector=_product(matrix, self.vector))


def sources_of(force: ImpulsiveSmooth) -> tuple[Source, ...]:
    """All that the input is a sum of; what vanishes is left out."""
    found = (source for origin in force.made_of for source in _of_origin(origin))
    return tuple(source for source in found if any(source.vector) and source.factor != 0)


def vector_of(values: Iterable) -> Vector:
    """Exact numbers."""
    return tuple(rational(value) for value in values)


def _of_origin(origin: Origin) -> Iterator[Source]:
    make = {TermOrigin: _of_term, ImpulseOrigin: _of_impulse, RecordOrigin: _of_record, StatesOrigin: _of_states}
    for source in make[type(origin.data)](origin):
        for change in origin.maps:
            if np.ndim(change):
                source = source.mapped([vector_of(row) for row in np.asarray(change)])
            else:
                source = replace(source, factor=source.factor * rational(change))
        yield replace(source, shape=source.shape.derivative(origin.derivatives))


def _of_term(origin: Origin) -> Iterator[Source]:
    term, time = origin.data, rational(origin.time())
    vector = tuple(entry / term.divisor for entry in vector_of(term.vector))
    cosine, sine = turned(term.phase)
    if term.angular_frequency == 0:
        yield Source(decaying_power(term.power, term.rate), vector, time, cosine)
        return
    with_cosine, with_sine = turning_powers(term.power, term.rate, term.angular_frequency)
    yield Source(with_cosine, vector, time, cosine)
    yield Source(with_sine, vector, time, sine * flint.fmpq(-1))


def _of_impulse(origin: Origin) -> Iterator[Source]:
    yield Source(delta(origin.data.order), vector_of(origin.data.vector), rational(origin.time()), flint.fmpq(1))


def _of_record(origin: Origin) -> Iterator[Source]:
    """Steps and ramps at the samples, one row after the other."""
    times = [rational(origin.time(float(time))) for time in origin.data.times]
    for row, values in enumerate(origin.data.values):
        unit = tuple(flint.fmpq(int(k == row)) for k in range(len(origin.data.values)))
        before, slope = flint.fmpq(0), flint.fmpq(0)
        samples = list(zip(times, map(rational, values)))
        for (time, value), (end, next_value) in pairwise([*samples, (times[-1], flint.fmpq(0))]):
            new = (next_value - value) / (end - time) if end != time else flint.fmpq(0)
            yield Source(power(0), unit, time, value - before)
            yield Source(power(1), unit, time, new - slope)
            before, slope = (next_value if end != time else value), new
        yield Source(power(0), unit, times[-1], -before)


def _of_states(origin: Origin) -> Iterator[Source]:
    """e^{J (t - t_j)} z_j from each knot to the next: it starts, and what has become of it by then is taken away."""
    data = origin.data
    for order, vector in enumerate(data.impulses):
        yield Source(delta(order), vector_of(vector), rational(origin.time()), flint.fmpq(1))
    for blow in data.later:
        for order, vector in enumerate(blow.impulses):
            yield Source(delta(order), vector_of(vector), rational(origin.time(blow.time)), flint.fmpq(1))
    restarts = data.smooth.restarts
    knots = [rational(origin.time(float(knot))) for knot in restarts.knots]
    for block, at in zip(data.smooth.blocks, block_slices(data.smooth.blocks)):
        shapes = _states_shapes(block)
        for row, vector in enumerate(data.smooth.coefficients[:, at].T):
            if vector.any():
                yield from _pieces(shapes[row], vector_of(vector), block, knots, restarts.states[at].T)


def _pieces(shapes: Sequence[Shape], vector: Vector, block, knots, states) -> Iterator[Source]:
    """At each knot the new states begin, and what has become of those before is taken away."""
    generator = tuple(vector_of(line) for line in block)
    nothing = (flint.fmpq(0),) * len(generator)
    before, since = nothing, knots[0]
    for knot, state in zip(knots, map(vector_of, states)):
        left = _carried(generator, before, knot - since)
        for entry, shape in enumerate(shapes):
            if left is not None:
                yield Source(shape, vector, knot, state[entry] - left[entry])
            else:
                yield Source(shape, vector, knot, state[entry])
                yield Source(shape, vector, knot, Carried(flint.fmpq(-1), generator, before, knot - since, entry))
        before, since = state, knot


def _carried(generator, start: Vector, time: flint.fmpq) -> Vector | None:
    """e^{J t} v where it is rational, because J is nilpotent or v is zero."""
    total, power = start, start
    for k in range(1, len(generator) + 1):
        power = tuple(entry * time / k for entry in _product(generator, power))
        if not any(power):
            return total
        total = tuple(a + b for a, b in zip(total, power))
    return None


def _states_shapes(block: np.ndarray) -> list[list[Shape]]:
    """The entries of (s I - J)^-1."""
    size = len(block)
    pencil = RationalMatrix([(-block).tolist(), np.eye(size).tolist()])
    below = pencil.determinant
    columns = [pencil.numerators([flint.fmpq_poly([int(k == entry)]) for k in range(size)]) for entry in range(size)]
    return [[_reduced(columns[column][row], below) for column in range(size)] for row in range(size)]


def _reduced(above: flint.fmpq_poly, below: flint.fmpq_poly) -> Shape:
    common = above.gcd(below)
    return Shape(above // common, below // common)


def _product(matrix, vector: Vector) -> Vector:
    return tuple(sum((a * b for a, b in zip(row, vector) if a and b), flint.fmpq(0)) for row in matrix)
