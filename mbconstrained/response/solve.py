"""A(d/dt) x = f from values at 0-, in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..checks import counted, real_array
from ..errors import InputError
from ..jordan.pairs import JordanPairs
from ..linalg.threads import short_work
from ..polynomial.matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import zero
from .events import kicks_of
from .parts import start_of
from .reduced import reduced_solution
from .regular import regular_part
from .response import Response
from .series import with_series
from .solution import PairSolution
from .taylor import taylor_series

if TYPE_CHECKING:
    from .many import Responses

#: What makes a force.
MAKERS = "mb.step, mb.ramp, mb.harmonic, mb.term, mb.impulse, mb.pulse, mb.sampled or mb.approximated"


def solve(
    A: PolynomialMatrix, initial=None, force: ImpulsiveSmooth | None = None, rank_tolerance: float | None = None
) -> Response | Responses:
    """The solution of A(d/dt) x = f on t >= 0 from any values at 0- (Moysis et al., Theorem 3.1, corrected).

    With X(s) = A(s)^-1 (X_in(s) + F(s)), the transform taken from 0-: only the values at 0- and the force on
    [0, inf) enter. Values that do not fit the equations are not repaired: the answer tells the jumps and
    impulses that they cause. Where the force starts, stops, changes or strikes later, ``Response.events`` tells what
    happens to x; between such times it is the same closed form from another start.

    Args:
        A: the polynomial matrix, degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r); None for zeros. Of shape (S, q, r): S starts at once.
        force: f with r rows, see ``mbconstrained.signals``; None for zero. A list of S forces: S answers at once.
        rank_tolerance: overrides how rank decisions are made: a difference of entries of A(s) counts as zero if it is no
            larger than this part of them (1e-9 for measured data, say); None for the rounding noise of float64.

    Returns:
        A ``Response``; of S starts or forces a ``Responses``, which is evaluated for all of them together.

    Raises:
        InputError: shapes that do not fit, values that are not finite.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> A = PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])
    >>> x = solve(A, initial=[[1.0], [0.0]])
    >>> bool(np.isclose(x(0.5)[0], np.cos(1.0)))
    True
    """
    q, r = checked_matrix(A).degree, A.size
    if is_many(initial, force):
        from .many import solve_many

        return solve_many(A, initial, force, rank_tolerance)
    initial = np.zeros((q, r)) if initial is None else real_array(initial, "initial", shape=(q, r))
    force = checked_force(force, r)
    with short_work(q * r):
        if rank_tolerance is None and (found := reduced_solution(A, initial, force)) is not None:
            return Response(A, initial, force, found, found.jump, found.impulses, events=found.events)
        return solve_with(A.jordan_pairs(rank_tolerance), initial, force)


def solve_with(pairs: JordanPairs, initial: np.ndarray, force: ImpulsiveSmooth) -> Response:
    """The solution read off pairs that were made before, values at 0- of shape (q, r) and force given in full."""
    A, q = pairs.polynomial_matrix, len(initial)
    start, kicks = start_of(pairs.form, initial, force), kicks_of(pairs.form, force, q)
    function, coupling = regular_part(pairs.form, start, force, kicks)
    function = with_series(function, taylor_series(pairs.form, initial, start.jump, force))
    return Response(A, initial, force, PairSolution(pairs, function, coupling), start.jump, start.impulses, events=kicks.events)


def is_many(initial, force) -> bool:
    """Whether several answers are asked for."""
    if isinstance(force, (list, tuple)) and any(isinstance(one, ImpulsiveSmooth) for one in force):
        return True
    try:
        return np.ndim(initial) == 3
    except ValueError:  # rows of different lengths, which is told later
        return False


def checked_matrix(A) -> PolynomialMatrix:
    """A(s), or an InputError."""
    if not isinstance(A, PolynomialMatrix):
        raise InputError(f"A: found {type(A).__name__}; expected a PolynomialMatrix, e.g. mb.PolynomialMatrix([A0, A1, A2])")
    return A


def checked_force(force, size: int) -> ImpulsiveSmooth:
    """A force with so many rows, zero for None, or an InputError."""
    if force is None:
        return zero(size)
    if not isinstance(force, ImpulsiveSmooth):
        of_function = "of a function of time make it with mb.approximated(function, end)"
        raise InputError(f"force: found {type(force).__name__}; {of_function if callable(force) else f'make it with {MAKERS}'}")
    if force.size != size:
        raise InputError(f"force: it has {counted(force.size, 'row')}, but A(s) has {size}")
    return force
