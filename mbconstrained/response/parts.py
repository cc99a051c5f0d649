"""What happens at t = 0, from the decoupled pencil in its scaled units.

The finite state starts at y_1(0+) = P_1 E z0, the infinite one is -sum N^i B2 f^(i). The vector
g = P_2 F z0 + sum N^i B2 f^(i)(0+) is the inconsistency of the values at 0- : the states jump by -Q_2 g, and
-C2 N^(p+1) g multiplies delta^(p) (the impulses of Moysis et al., Eq. 42 with (45) taken at 0+; g = 0 is
condition (60), corrected). Its rounding noise is bounded along with it, so that a consistent start has g = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import Overflow
from ..jordan.weierstrass import WeierstrassForm
from ..linalg.noise import Noisy
from ..signals.impulsive import ImpulsiveSmooth
from .effects import driven_inconsistency, finite_kick, impulse_effect, jump_effect
from .forcing import ScaledForce, scaled_data


@dataclass(frozen=True)
class Start:
    """State and jump at t = 0.

    Attributes:
        finite: y_1(0+) in scaled units, shape (n,).
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r), in the user's units.
        impulses: arrays (r,), the k-th multiplies delta^(k), in the user's units.
    """

    finite: np.ndarray
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]


def start_of(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> Start:
    """The state at 0+, the jumps and the impulses at t = 0.

    Raises:
        Overflow: one of them leaves the range of float64.
    """
    stack, f, size = scaled_data(form, initial, force)
    impulses = [g[:, None] for g in f.impulses]
    finite = form.finite_start @ stack + finite_kick(form, impulses, 1)[:, 0]
    inconsistency = inconsistency_of(form, stack, f)[:, None]
    with np.errstate(over="ignore", invalid="ignore"):  # reported below
        jump = size * jump_effect(form, inconsistency, impulses, len(initial))[..., 0]
        found = [size * c[:, 0] for c in impulse_effect(form, inconsistency, impulses)]
        start = Start(size * finite, jump, without_zeros(found))
    if not all(np.isfinite(values).all() for values in (start.finite, start.jump, *start.impulses)):
        raise Overflow("the jumps or impulses at t = 0 grow beyond the range of float64; choose other units or smaller values")
    return start


def inconsistency_of(form: WeierstrassForm, stack: np.ndarray, f: ScaledForce) -> Noisy:
    """g = P_2 F z0 + sum N^i B2 f^(i)(0+) in scaled units, entries below their rounding noise set to zero."""
    given = form.infinite_start @ Noisy.rounded(stack)
    total = given + driven_inconsistency(form, f, f.jump)
    return Noisy(total.cleaned(), total.noise)


def without_zeros(impulses) -> tuple[np.ndarray, ...]:
    """Factors of delta, delta', ... up to the last one that is not zero."""
    count = max((k + 1 for k, impulse in enumerate(impulses) if impulse.any()), default=0)
    return tuple(impulses[:count])
