"""The closed form's own ways, as methods that are measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...polynomial import PolynomialMatrix
from ...response import Response
from ...response.apostol_kolodner import apostol_kolodner
from ..problem import Problem, given_of
from .method import Evaluate, Method, Setting

#: Digits that exact arithmetic is asked for, as users do.
DIGITS = 15


def _evaluation(solve: Callable[[], Response], times) -> Evaluate:
    """Set up by solving; what is left is to evaluate, the first evaluation's own preparations included."""
    response = solve()
    return lambda: response(times)


def _elements_added_up(problem: Problem) -> Evaluate:
    A = problem.polynomial_matrix
    plain = PolynomialMatrix(A.coefficients, A.coordinates, A.equations)
    return _evaluation(replace(problem, polynomial_matrix=plain, system=None).solve_equations, problem.times)


def _has_elements(problem: Problem) -> bool:
    return any(not isinstance(given, np.ndarray) for given in given_of(problem.polynomial_matrix))


def _exact(problem: Problem) -> Evaluate:
    response = problem.solve()
    made = response.exact
    return lambda: made.enclose(problem.times, DIGITS).lower.astype(float)


def _apostol_kolodner(problem: Problem) -> Evaluate:
    found = apostol_kolodner(PolynomialMatrix(given_of(problem.polynomial_matrix)), problem.initial)
    return lambda: found(problem.times)


def _is_free_and_undamped(problem: Problem) -> bool:
    return problem.force.is_zero and not any(np.any(matrix) for matrix in problem.polynomial_matrix.coefficients[1:-1])


def _is_transfer_function(problem: Problem) -> bool:
    return problem.respond is not None


def _ours(name: str, prepare: Callable[[Problem], Evaluate], concerns: Callable[[Problem], bool] = lambda problem: True) -> Method:
    return Method(name, (Setting(),), lambda problem, _: prepare(problem), concerns=concerns, is_ours=True)


#: By their equations are meant those of Apostol and Kolodner, (73)-(76) of Moysis et al., for free motion without damping.
#: The one that everybody gets who asks for nothing else comes first.
METHODS = (
    _ours("closed form", lambda problem: _evaluation(problem.solve, problem.times)),
    _ours("closed form, matrices added up", _elements_added_up, _has_elements),
    _ours("closed form of A(s)", lambda problem: _evaluation(problem.solve_equations, problem.times), _is_transfer_function),
    _ours("closed form, Eqs. (73)-(76)", _apostol_kolodner, _is_free_and_undamped),
    _ours(f"exact arithmetic, {DIGITS} digits", _exact),
)
