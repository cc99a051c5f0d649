"""Forces that start, stop and have impulses later: jumps, impulses and motion against superposition in rational arithmetic.

By linearity and time invariance the answer is that of what acts from t = 0 on, plus that of each delayed part from
rest, later: ``tests.oracles.exact`` knows all of them as Laurent and Taylor series.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from tests.oracles.exact import ExactResponse
from tests.properties.problems import Problem, Term, problems, scale_of

BAR = 1e-8
DELAYS = (0.125, 0.25)
TIMES = np.array([0.0, 0.0625, 0.125, 0.1875, 0.25, 0.3125, 0.5])


@dataclass(frozen=True)
class Late:
    """A problem and what acts in addition from each of the delays on: terms and impulses."""

    problem: Problem
    parts: tuple[tuple[tuple[Term, ...], tuple[tuple[int, ...], ...]], ...]

    @cached_property
    def force(self) -> mb.ImpulsiveSmooth:
        total = self.problem.force
        for delay, (terms, impulses) in zip(DELAYS, self.parts):
            signals = [term.force for term in terms] + [mb.impulse(v, order=k) for k, v in enumerate(impulses)]
            total = total + sum(signals, mb.zero(self.problem.sample.size)).delayed(delay)
        return total

    @cached_property
    def answer(self) -> mb.Response:
        return mb.solve(self.problem.sample.matrix, self.problem.initial, self.force)

    @cached_property
    def exact(self) -> list[ExactResponse]:
        """What each delayed part causes from rest, as a function of the time since it began."""
        sample = self.problem.sample
        rest = [[Fraction(0)] * sample.size for _ in range(sample.degree)]
        return [
            ExactResponse(
                sample.exact, rest, [term.rational for term in terms], [list(map(Fraction, v)) for v in impulses], count=45
            )
            for terms, impulses in self.parts
        ]

    @cached_property
    def known(self) -> np.ndarray:
        """x at TIMES."""
        total = np.array([self.problem.exact(t) for t in TIMES])
        for delay, exact in zip(DELAYS, self.exact):
            total[TIMES >= delay] += [exact(t - delay) for t in TIMES[TIMES >= delay]]
        return total.T

    @cached_property
    def jumps(self) -> dict[float, np.ndarray]:
        """x^(i)(t+) - x^(i)(t-), i < q, exact, at each delay."""
        sample = self.problem.sample
        shape = sample.degree, sample.size
        return {d: np.array(e.derivatives[: sample.degree], float).reshape(shape) for d, e in zip(DELAYS, self.exact)}

    @cached_property
    def impulses(self) -> dict[float, np.ndarray]:
        size = self.problem.sample.size
        return {delay: np.array(exact.impulses, float).reshape(-1, size) for delay, exact in zip(DELAYS, self.exact)}


@st.composite
def late_problems(draw):
    problem = draw(problems(largest_size=3))
    vectors = st.tuples(*[st.integers(-3, 3)] * problem.sample.size)
    terms = st.builds(Term, vectors, st.integers(0, 2), st.integers(-2, 1), st.integers(0, 2), st.sampled_from(["cos", "sin"]))
    parts = [(tuple(draw(st.lists(terms, max_size=2))), tuple(draw(st.lists(vectors, max_size=2)))) for _ in DELAYS]
    return Late(problem, tuple(parts))


@pytest.mark.long
@given(late_problems())
def test_motion_is_the_sum_of_the_delayed_motions(late: Late):
    assert np.abs(late.answer(TIMES) - late.known).max() <= BAR * scale_of(late.known)


@pytest.mark.long
@given(late_problems())
def test_events_are_where_something_happens_and_nowhere_else(late: Late):
    happens = [d for d in DELAYS if late.jumps[d].any() or len(late.impulses[d])]
    assert [event.time for event in late.answer.events] == happens


@pytest.mark.long
@given(late_problems())
def test_jumps_and_impulses_of_events(late: Late):
    """A coordinate that goes on without a jump is not said to jump: zeros are exact, and only those."""
    for event in late.answer.events:
        jump, impulses = late.jumps[event.time], late.impulses[event.time]
        assert np.array_equal(event.jump != 0, jump != 0)
        assert np.abs(event.jump - jump).max(initial=0.0) <= BAR * scale_of(jump)
        found = np.array(event.impulses).reshape(-1, impulses.shape[1])
        assert found.shape == impulses.shape
        assert np.abs(found - impulses).max(initial=0.0) <= BAR * scale_of(impulses)


@given(late_problems())
def test_what_happens_later_does_not_change_what_happens_at_zero(late: Late):
    x, alone = late.answer, late.problem.answer
    assert np.array_equal(x.jump, alone.jump)
    assert [g.tolist() for g in x.impulses] == [g.tolist() for g in alone.impulses]


@given(late_problems())
def test_derivatives_at_an_event_are_right_limits(late: Late):
    """x^(k)(t+) is the sum of the Taylor series of all parts there, k < q; x^(k)(t-) is less by the jump."""
    for order in range(late.problem.sample.degree):
        derivative = late.answer.derivative(order)
        for event in late.answer.events:
            before = derivative(np.nextafter(event.time, 0.0))
            after = derivative(event.time)
            assert np.abs(after - before - event.jump[order]).max() <= BAR * scale_of(after, before)
