"""Random initial value problems: a sample A(s), any values at 0-, a force of every kind, all small integers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from hypothesis import strategies as st

import mbconstrained as mb
from tests.oracles.exact import ExactResponse
from tests.properties.matrices import Sample, samples


@dataclass(frozen=True)
class Term:
    """vector t^power e^{rate t} cos(w t) or sin(w t)."""

    vector: tuple[int, ...]
    power: int
    rate: int
    frequency: int
    kind: str

    @property
    def force(self) -> mb.ImpulsiveSmooth:
        phase = -np.pi / 2 if self.kind == "sin" else 0.0
        if self.kind == "sin" and self.frequency == 0:
            return mb.zero(len(self.vector))
        return mb.term(self.vector, power=self.power, rate=self.rate, angular_frequency=self.frequency, phase=phase)

    @property
    def rational(self):
        return [Fraction(v) for v in self.vector], self.power, Fraction(self.rate), Fraction(self.frequency), self.kind


@dataclass(frozen=True)
class Problem:
    """A(d/dt) x = f from values at 0-."""

    sample: Sample
    initial: np.ndarray
    terms: tuple[Term, ...]
    impulses: tuple[tuple[int, ...], ...]

    def __repr__(self) -> str:
        return f"Problem({self.sample}, initial={self.initial.tolist()}, {self.terms}, impulses={self.impulses})"

    @cached_property
    def force(self) -> mb.ImpulsiveSmooth:
        parts = [term.force for term in self.terms]
        parts += [mb.impulse(vector, order=order) for order, vector in enumerate(self.impulses)]
        return sum(parts, mb.zero(self.sample.size))

    @cached_property
    def answer(self) -> mb.Response:
        return mb.solve(self.sample.matrix, self.initial, self.force)

    @cached_property
    def exact(self) -> ExactResponse:
        """Impulses, values at 0+ and x(t) for t up to about 1, in rational arithmetic."""
        return ExactResponse(
            self.sample.exact,
            [[Fraction(float(value)) for value in row] for row in self.initial],
            [term.rational for term in self.terms],
            [[Fraction(value) for value in vector] for vector in self.impulses],
            count=45,
        )

    @property
    def start(self) -> np.ndarray:
        """x^(i)(0+), i < q, exact."""
        rows = self.exact.derivatives[: self.sample.degree]
        return np.array(rows, float).reshape(self.sample.degree, self.sample.size)

    @property
    def known_impulses(self) -> np.ndarray:
        """Shape (number of impulses, r), exact."""
        return np.array(self.exact.impulses, float).reshape(-1, self.sample.size)


@st.composite
def problems(draw, largest_size: int = 3, forced: bool = True, with_impulses: bool = True):
    """Problems of size up to largest_size; the force may hit a zero of A(s), that is, be in resonance."""
    sample = draw(samples(largest_size, over_declared=False))
    vectors = st.tuples(*[st.integers(-3, 3)] * sample.size)
    terms = st.builds(Term, vectors, st.integers(0, 2), st.integers(-2, 1), st.integers(0, 2), st.sampled_from(["cos", "sin"]))
    initial = draw(st.lists(vectors, min_size=sample.degree, max_size=sample.degree))
    return Problem(
        sample,
        np.array(initial, float).reshape(sample.degree, sample.size),
        tuple(draw(st.lists(terms, max_size=2))) if forced else (),
        tuple(draw(st.lists(vectors, max_size=2))) if forced and with_impulses else (),
    )


def scale_of(*arrays) -> float:
    """The largest absolute value in any of the arrays, at least 1."""
    return max([1.0, *(float(np.abs(np.asarray(array, float)).max(initial=0.0)) for array in arrays)])
