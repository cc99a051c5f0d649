"""Units of time, of the coordinates and of the equations are the user's business: the answer follows them.

With t = tau t', x = c x' and rows multiplied by l the coefficients become l A_k c tau^(-k), the values at 0-
c^-1 x^(k) tau^k and the force l f(tau t').
"""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from tests.properties.problems import Problem, problems, scale_of

BAR = 1e-7
TIMES = np.array([0.0, 0.25, 1.0])

reals = st.floats(-9, 9).map(lambda n: 10.0**n)


def in_other_units(problem: Problem, time: float, columns, rows) -> mb.Response:
    """The same problem, stated in other units."""
    rows, columns = np.array(rows), np.array(columns)
    count = np.arange(problem.sample.degree + 1, dtype=float)
    A = rows[:, None] * problem.sample.coefficients * columns * (time**-count)[:, None, None]
    initial = problem.initial / columns * (time ** count[:-1])[:, None]
    terms = [_term(term, time).mapped(np.diag(rows)) for term in problem.terms]
    return mb.solve(mb.PolynomialMatrix(A), initial, sum(terms, mb.zero(problem.sample.size)))


def _term(term, time) -> mb.ImpulsiveSmooth:
    phase = -np.pi / 2 if term.kind == "sin" else 0.0
    return mb.term(
        np.array(term.vector) * time**term.power * (term.frequency > 0 or term.kind == "cos"),
        power=term.power,
        rate=term.rate * time,
        angular_frequency=term.frequency * time,
        phase=phase,
    )


def check(problem: Problem, time: float, columns, rows) -> None:
    x, y = problem.answer, in_other_units(problem, time, columns, rows)
    found = np.array(columns)[:, None] * y(TIMES / time)
    assert np.abs(found - x(TIMES)).max() <= BAR * scale_of(x(TIMES))
    structure, other = x.pairs.structure, y.pairs.structure
    assert other.at_infinity == structure.at_infinity
    assert sorted(zero.count for zero in other.finite_zeros) == sorted(zero.count for zero in structure.finite_zeros)
    assert len(y.impulses) == len(x.impulses)
    for order, (mine, others) in enumerate(zip(x.impulses, y.impulses)):
        assert np.abs(np.array(columns) * others * time ** (order + 1) - mine).max() <= BAR * scale_of(mine)
    jump = np.array(columns) * y.jump * (time ** -np.arange(len(y.jump), dtype=float))[:, None]
    assert np.abs(jump - x.jump).max(initial=0.0) <= BAR * scale_of(x.jump)


@given(problems(with_impulses=False), reals, st.data())
def test_any_other_units_change_only_the_rounding(problem: Problem, time: float, data):
    factors = st.lists(reals, min_size=problem.sample.size, max_size=problem.sample.size)
    check(problem, time, data.draw(factors), data.draw(factors))
