"""A(d/dt) x = f from values at 0-, in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth
from .choose import Evaluations, Request
from .problem import Problem, checked_matrix
from .response import Response


def solve(
    A: PolynomialMatrix,
    initial=None,
    force: ImpulsiveSmooth | None = None,
    rank_tolerance: float | None = None,
    *,
    evaluations: Evaluations = "once",
) -> Response | Any:
    """Solve A(d/dt) x = f on t >= 0 from any values at 0- (Moysis et al., Theorem 3.1, corrected).

    With X(s) = A(s)^-1 (X_in(s) + F(s)), the transform taken from 0-: only the values at 0- and the force on
    [0, inf) enter. Values that do not satisfy the equations are not repaired: the response reports the jumps and
    impulses that they cause. Where the force starts, stops, changes or has impulses later, ``Response.events`` has their
    effects on x; between such times x is the same closed form from another state.

    The method is chosen once (``response.choose``): ``x.method`` has its name and the reason.

    Args:
        A: the polynomial matrix, degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r); None for zeros. Of shape (S, q, r): S starts at once.
        force: f with r rows, see ``mbconstrained.signals``; None for zero. A list of S forces: S solutions at once.
        rank_tolerance: overrides how rank decisions are made: a difference of entries of A(s) counts as zero if it is no
            larger than this part of them (1e-9 for measured data, say); None for rounding errors of float64.
        evaluations: "once": each evaluation takes the method that costs least for its own times; even times of a large model
            then need no eigenvectors. "many": all evaluations share the modes, which are computed at the first one. Small
            models, and solutions by the Jordan pairs, have their modes in any case.

    Returns:
        A ``Response``; of S starts or forces a ``Responses``, which is evaluated for all of them together.

    Raises:
        InputError: shapes that do not fit, values that are not finite, another word for ``evaluations``.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> x = solve(A, initial=[[1.0], [0.0]])
    >>> bool(np.isclose(x(0.5)[0], np.cos(1.0)))
    True
    """
    request = Request(evaluations)
    if _is_family(initial, force):
        from .many import solve_many

        return solve_many(checked_matrix(A), initial, force, rank_tolerance, request)
    return Response.solved(Problem.checked(A, initial, force, rank_tolerance), request)


def _is_family(initial, force) -> bool:
    """Whether several starts or forces are given."""
    if isinstance(force, (list, tuple)) and any(isinstance(one, ImpulsiveSmooth) for one in force):
        return True
    try:
        return np.ndim(initial) == 3
    except ValueError:  # rows of different lengths, which are refused later
        return False
