"""Methods of the accuracy study, those of this package first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...response.response import Response
from ...signals.bohl import BohlFunction
from ..study_problem import StudyProblem, given_of
from . import ida, linear_simulation, matrix_exponential, solve_ivp
from .method import ComparedMethod, Evaluate

#: Digits of exact arithmetic.
DIGITS = 15


def _evaluation(solve: Callable[[], Response], times) -> Evaluate:
    """Set up by solving; the first evaluation includes its own preparations."""
    response = solve()
    return lambda: response(times)


def _assembled(problem: StudyProblem, _) -> Evaluate:
    A = problem.polynomial_matrix
    matrix = PolynomialMatrix(A.coefficients, A.coordinates, A.equations)
    return _evaluation(replace(problem, polynomial_matrix=matrix, system=None).solve_equations, problem.times)


def _has_elements(problem: StudyProblem) -> bool:
    return any(not isinstance(given, np.ndarray) for given in given_of(problem.polynomial_matrix))


def _exact(problem: StudyProblem, _) -> Evaluate:
    exact = problem.solve().exact
    return lambda: exact.enclose(problem.times, DIGITS).lower.astype(float)


def _apostol_kolodner(problem: StudyProblem, _) -> Evaluate:
    """C e^{J t} x_s(0) with x_s(0) = [J^(q-1) B A_q ... B A_q] X_0 (Eq. 75)."""
    A = PolynomialMatrix(given_of(problem.polynomial_matrix))
    pair, power = A.jordan_pairs().finite, np.linalg.matrix_power
    parts = (power(pair.J, A.degree - 1 - i) @ (pair.B @ (A.coefficients[-1] @ x)) for i, x in enumerate(problem.initial))
    motion = BohlFunction(pair.C, pair.blocks, sum(parts, np.zeros(len(pair.J))))
    return lambda: motion(problem.times)


def _is_free_and_undamped(problem: StudyProblem) -> bool:
    return problem.force.is_zero and not any(np.any(matrix) for matrix in problem.polynomial_matrix.coefficients[1:-1])


#: The default first. Eqs. (73)-(76) of Moysis et al. are those of Apostol and Kolodner for free motion without damping.
OURS = (
    ComparedMethod("closed form", lambda problem, _: _evaluation(problem.solve, problem.times)),
    ComparedMethod("closed form, assembled matrices", _assembled, concerns=_has_elements),
    ComparedMethod(
        "closed form of A(s)",
        lambda problem, _: _evaluation(problem.solve_equations, problem.times),
        concerns=lambda problem: problem.respond is not None,
    ),
    ComparedMethod("closed form, Eqs. (73)-(76)", _apostol_kolodner, concerns=_is_free_and_undamped),
    ComparedMethod(f"exact arithmetic, {DIGITS} digits", _exact),
)

METHODS: tuple[ComparedMethod, ...] = (
    *(replace(method, is_ours=True) for method in OURS),
    *matrix_exponential.METHODS,
    *linear_simulation.METHODS,
    *solve_ivp.METHODS,
    *ida.METHODS,
)
