"""A state space without its descriptor: the same G(s) by x' = A x + B u, y = C x + D u."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import InputError
from ..linalg.noise import Noisy

if TYPE_CHECKING:
    from .state_space import StateSpace


class OrdinaryForm(NamedTuple):
    """A, B, C, D of x' = A x + B u, y = C x + D u."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


def ordinary_form(system: StateSpace) -> OrdinaryForm:
    """The same transfer functions without E.

    Where E is regular the states stay, A becomes E^-1 A. Where it is singular, (s E - A)^-1 = C_F (s I - J)^-1 B_F + H_0 + s H_1
    + ... (Moysis et al., Theorem 2.8) gives A = J, B = B_F B, C = C C_F, D + C H_0 B; the states are those of the finite
    Jordan pair.

    Raises:
        InputError: C H_i B is not zero for some i >= 1: G(s) has a pole at infinity.
        SingularPolynomialMatrix: det (s E - A) = 0 for every s.
    """
    if (system.E == np.eye(len(system.E))).all():
        return OrdinaryForm(system.A, system.B, system.C, system.D)
    pairs = system.polynomial_matrix().jordan_pairs()
    if not any(pairs.structure.infinite_divisors):
        found = np.linalg.solve(system.E, np.hstack([system.A, system.B]))
        n = len(system.A)
        return OrdinaryForm(found[:, :n], found[:, n:], system.C, system.D)
    highest = max((i for i in range(1, pairs.structure.highest_impulse + 1) if _through(system, i).any()), default=0)
    if highest:
        raise InputError(
            f"the descriptor is singular and G(s) grows like s^{highest}: there are no A, B, C, D without descriptor; "
            "use the form transfer function"
        )
    finite = pairs.finite
    return OrdinaryForm(finite.J, finite.B @ system.B, system.C @ finite.C, system.D + _through(system, 0))


def _through(system: StateSpace, order: int) -> np.ndarray:
    """C H_order B, zero where it is rounding."""
    pairs = system.polynomial_matrix().jordan_pairs()
    scaling = pairs.form.companion.scaling
    H = pairs.form.laurent(order)
    left, right = Noisy.rounded(system.C * scaling.columns), Noisy.rounded(scaling.rows[:, None] * system.B)
    return (left @ H @ right).cleaned() / scaling.time**order
