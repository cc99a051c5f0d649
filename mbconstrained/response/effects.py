"""What a change of the force at one time does, as linear maps; every column of the arguments is a time of its own.

At such a time the finite state gains sum T^l B g_l from the impulses g_l delta^(l) of the force, the inconsistency is
g = sum N^i B2 (jump of f^(i)), and the states jump by -Q_2 g as at t = 0: what came before has followed the force.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..jordan.weierstrass import WeierstrassForm
from ..linalg.noise import Noisy, stacked
from .forcing import ScaledForce


def driven_inconsistency(form: WeierstrassForm, f: ScaledForce, change: np.ndarray) -> Noisy:
    """sum N^i B2 C_f J_f^i change, for changes of the force's states of shape (m,) or (m, K)."""
    total, power = Noisy.exact(np.zeros((len(form.B2.data), *change.shape[1:]))), form.B2
    if not (total.data.size and change.size):
        return total
    for derivative in f.derivatives(len(form.split.deficiencies)):  # so many powers of N are not zero
        total = total + power @ (Noisy.rounded(derivative) @ Noisy.rounded(change))
        power = form.nilpotent @ power
    return total


def finite_kick(form: WeierstrassForm, impulses: Sequence[np.ndarray], count: int) -> np.ndarray:
    """By how much the finite state changes, shape (n, count)."""
    kick = np.zeros((len(form.T), count))
    for order, g in enumerate(impulses):
        kick = kick + np.linalg.matrix_power(form.T, order) @ (form.B @ g)
    return kick


def jump_effect(form: WeierstrassForm, inconsistency: Noisy, impulses: Sequence[np.ndarray], q: int) -> np.ndarray:
    """Jumps of x^(i), i < q, shape (q, r, K): -Q_2 g, and H_(-i-l-1) g_l for each impulse delta^(l) of the force."""
    scaling, r = form.companion.scaling, form.companion.size
    total = -form.infinite_columns[: q * r] @ inconsistency
    for order, g in enumerate(impulses):
        by_impulse = [form.laurent(-i - order - 1) @ Noisy.rounded(g) for i in range(q)]
        total = total + stacked(*by_impulse) if q else total
    jumps = total.cleaned().reshape(q, r, inconsistency.data.shape[1])
    return scaling.columns[:, None] * jumps * scaling.time ** np.arange(float(q))[:, None, None]


def impulse_effect(form: WeierstrassForm, inconsistency: Noisy, impulses: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The factors of delta, delta', ... in x, each of shape (r, K): -C2 N^(p+1) g, and H_(p-l) g_l."""
    scaling, shape = form.companion.scaling, (form.companion.size, inconsistency.data.shape[1])
    highest = form.highest_impulse
    totals = [Noisy.exact(np.zeros(shape)) for _ in range(highest + len(impulses))]
    state = inconsistency
    for order in range(highest):
        state = form.nilpotent @ state
        totals[order] = totals[order] + -form.C2 @ state
    for order, g in enumerate(impulses):
        for k in range(len(totals)):
            totals[k] = totals[k] + form.laurent(k - order) @ Noisy.rounded(g)
    return [scaling.columns[:, None] * total.cleaned() * scaling.time ** -(k + 1.0) for k, total in enumerate(totals)]
