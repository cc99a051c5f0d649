"""The way from (A, B, C, D) to the normal form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...checks import nearest
from ...errors import IllConditioned, InputError
from .existence import existence
from .extension import well_conditioned_rows
from .form import NormalForm, assembled
from .paper import kronecker_rows, null_space_rows
from .state_space import state_space_data
from .units import ScaledPencil, scaled_pencil

OUT_OF_RANGE = "the normal form leaves the range of float64; choose units of time and of inputs in which A and B are near 1"


def mechanical_normal_form(A, B, C=None, D=None, descriptor=None, method: str = "extension") -> NormalForm:
    """A transformation x^ = T x that turns F x' = A x + B u, y = C x + D u into second-order equations of motion.

    x^ = (q, q') obeys q'' = A^_21 q + A^_22 q' + [0; I_p] u: unit masses, -A^_21 is the stiffness, -A^_22 the damping, and the
    inputs are forces on the last p coordinates. T exists if and only if rank [B, A B] = 2 p and rank [A - lambda I, B] >= n/2 + p
    for every real lambda (F^-1 A and F^-1 B in place of A and B for a descriptor form). This corrects Theorem 2.1 of Mayet and
    Kammermeier, *Mechanical normal form of first order state-space systems*, which is wrong in both directions.

    Args:
        A: shape (n, n), n even.
        B: shape (n, p), p <= n/2, independent columns; None or no columns for a system without inputs.
        C, D: shape (m, n) and (m, p), where there are outputs.
        descriptor: F, shape (n, n), regular, not symmetric in general; the identity when not given. It is not inverted:
            X^T multiplies the equations, T = [X^T F; X^T A], and T F^-1 is the left multiplier of Eq. 16 (corrected: F^T where F
            is printed).
        method: "extension" extends B to B_e with [B_e, A B_e] regular, X^T = [0 I] [B_e, A B_e]^-1 and T = [X^T; X^T A]; of
            the family of all T it takes one of small condition. "null space" (Eqs. 9-14 and appendix C, corrected) and
            "kronecker" (Eqs. 15-16) are the paper's routes. Both fail for some systems that have a normal form: the first
            where it needs what Eq. 11 leaves out or where G is defective, the second where no combination of solutions tried is
            regular, and for many states. Neither makes the condition of T small.

    Raises:
        NoNormalForm: a condition fails; the text names it, with the ranks and the eigenvalue. Or the descriptor is singular.
        IllConditioned: units so far from the system's own that the form leaves the range of float64.
        InputError: shapes, n odd, p > n/2, dependent inputs, entries that are not finite, a method that fails.

    >>> form = mechanical_normal_form([[1.0, -2.0], [3.0, -2.0]], [[1.0], [1.0]])
    >>> form.stiffness.round(12).tolist(), form.damping.round(12).tolist(), form.is_unique
    ([[4.0]], [[1.0]], True)
    """
    if method not in METHODS:
        expected = ", ".join(f'"{name}"' for name in METHODS)
        raise InputError(f"method: found {method!r}{nearest(method, METHODS)}; expected one of {expected}")
    data = state_space_data(A, B, C, D, descriptor)
    try:
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            pair = scaled_pencil(data)
            exists = existence(pair)
            form = assembled(data, METHODS[method](pair), exists)
    except np.linalg.LinAlgError:
        raise IllConditioned(OUT_OF_RANGE) from None
    if not (np.isfinite(form.state_matrix).all() and form.condition < np.inf):
        raise IllConditioned(OUT_OF_RANGE)
    return form


def _in_given_units(rows_of: Callable[[ScaledPencil], np.ndarray]) -> Callable[[ScaledPencil], np.ndarray]:
    """The rows X^T of a route that works in the units of the pair."""

    def rows(pair: ScaledPencil) -> np.ndarray:
        found, p = rows_of(pair), len(pair.input)
        found[len(found) - p :] *= pair.input[:, None] / pair.rate
        return found * pair.equation

    return rows


METHODS: dict[str, Callable[[ScaledPencil], np.ndarray]] = {
    "extension": well_conditioned_rows,
    "null space": _in_given_units(null_space_rows),
    "kronecker": _in_given_units(kronecker_rows),
}
