"""Jumps and Dirac impulses of x: at t = 0, and later where the force starts, stops, changes or has impulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..ground.by_name import Public
from ..ground.errors import Overflow
from ..ground.tolerances import noise_of
from ..linalg.rank import Noisy, stacked
from ..polynomial.decoupling import WeierstrassForm
from ..signals.impulsive import ImpulsiveSmooth
from .problem import ScaledForce, power_of_two_of, scaled_force, scaled_impulses


@dataclass(frozen=True, eq=False)
class Event(Public):
    """Jumps and Dirac impulses of x at one time after t = 0.

    Attributes:
        time: when, in s.
        jump: x^(i)(t+) - x^(i)(t-), shape (q, r); exactly zero where x^(i) is continuous.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta at that time.
    """

    time: float
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]


def kinks_of(events: Sequence[Event], force: ImpulsiveSmooth) -> tuple[Event, ...]:
    """The events without a jump of x and without impulses, at which the value of the force does not jump."""
    own = set(force.knots.tolist())  # with delays there are events at other times
    candidates = [event for event in events if event.time in own and not event.impulses and not event.jump[:1].any()]
    if not candidates:
        return ()
    C, restarts = force.smooth.coefficients, force.smooth.restarts
    jumps = np.abs(C @ restarts.jumps) > noise_of(np.abs(C) @ np.abs(restarts.jumps))
    steps = set(restarts.knots[jumps.any(axis=0)].tolist()) | {load.time for load in force.later}
    return tuple(event for event in candidates if event.time not in steps)


@dataclass(frozen=True, eq=False)
class KnotJumps:
    """Jumps and impulses at all K knots of the force after t = 0.

    Attributes:
        times: the knots, shape (K,), in s.
        finite: jumps of the finite state by impulses, in scaled units, shape (n, K).
        jump: of x^(i), shape (q, r, K), in the user's units.
        impulses: arrays (r, K), the k-th multiplies delta^(k), in the user's units.
    """

    times: np.ndarray
    finite: np.ndarray
    jump: np.ndarray
    impulses: list[np.ndarray]

    @property
    def events(self) -> tuple[Event, ...]:
        """The knots at which x jumps or has impulses."""
        affected = self.jump.any(axis=(0, 1))
        for impulse in self.impulses:
            affected = affected | impulse.any(axis=0)
        return tuple(
            Event(float(self.times[k]), self.jump[:, :, k].copy(), without_zeros([c[:, k].copy() for c in self.impulses]))
            for k in np.flatnonzero(affected)
        )


def knot_jumps(form: WeierstrassForm, force: ImpulsiveSmooth, q: int) -> KnotJumps:
    """Jumps and impulses at the knots of the force after t = 0, q rows of derivatives.

    Every knot is divided by a power of two near its own size first: the squares of noise then stay in range.
    """
    times = force.knots[1:]
    if not len(times):
        return KnotJumps(times, np.zeros((len(form.T), 0)), np.zeros((q, force.size, 0)), [])
    f = scaled_force(form, force)
    largest = power_of_two_of(f.coefficients)
    changes = force.smooth.with_knots(force.knots).restarts.jumps[:, 1:] / f.units[:, None]
    impulses = _impulses_by_order(form, force, times)
    size = np.array([power_of_two_of(column) for column in np.vstack([changes * largest, *impulses]).T])
    impulses = [g / size for g in impulses]
    inconsistency = _driven_inconsistency(form, f.divided(largest), changes * (largest / size))
    inconsistency = Noisy(inconsistency.cleaned(), inconsistency.noise)
    with np.errstate(over="ignore", invalid="ignore"):  # reported below
        finite = size * _finite_jump(form, impulses, len(times))
        jump = size * _jump_effect(form, inconsistency, impulses, q)
        effect = [size * c for c in _impulse_effect(form, inconsistency, impulses)]
    if not all(np.isfinite(values).all() for values in (finite, jump, *effect)):
        raise Overflow("the jumps or impulses after t = 0 grow beyond the range of float64; choose other units or smaller values")
    return KnotJumps(times, finite, jump, effect)


def _impulses_by_order(form, force, times) -> list[np.ndarray]:
    """The force's own Dirac impulses, scaled: for each order an array (r, K)."""
    count = max((len(load.impulses) for load in force.later), default=0)
    by_order = [np.zeros((force.size, len(times))) for _ in range(count)]
    for load in force.later:
        at = np.searchsorted(times, load.time)
        for order, g in enumerate(scaled_impulses(form, load.impulses)):
            by_order[order][:, at] = g
    return by_order


# The effect of a change of the force at one time, as linear maps; every column of the arguments is a time of its own.
#
# At such a time the finite state gains sum T^l B g_l from the impulses g_l delta^(l) of the force, the inconsistency is
# g = sum N^i B2 (jump of f^(i)), and the states jump by -Q_2 g as at t = 0: before it they satisfied the equations.


def _driven_inconsistency(form: WeierstrassForm, f: ScaledForce, change: np.ndarray) -> Noisy:
    """sum N^i B2 C_f J_f^i change, for changes of the force's states of shape (m,) or (m, K)."""
    total, power = Noisy.exact(np.zeros((len(form.B2.data), *change.shape[1:]))), form.B2.settled()
    if not (total.data.size and change.size):
        return total
    for derivative in f.derivatives(len(form.split.deficiencies)):  # so many powers of N are not zero
        total = total + power @ (Noisy.rounded(derivative) @ Noisy.rounded(change))
        power = form.nilpotent @ power
    return total


def _finite_jump(form: WeierstrassForm, impulses: Sequence[np.ndarray], count: int) -> np.ndarray:
    """The change of the finite state, shape (n, count)."""
    jump = np.zeros((len(form.T), count))
    for order, g in enumerate(impulses):
        jump = jump + np.linalg.matrix_power(form.T, order) @ (form.B @ g)
    return jump


def _jump_effect(form: WeierstrassForm, inconsistency: Noisy, impulses: Sequence[np.ndarray], q: int) -> np.ndarray:
    """Jumps of x^(i), i < q, shape (q, r, K): -Q_2 g, and H_(-i-l-1) g_l for each impulse delta^(l) of the force."""
    scaling, r = form.companion.scaling, form.companion.size
    total = -form.infinite_columns[: q * r] @ inconsistency
    for order, g in enumerate(impulses):
        by_impulse = [form.laurent(-i - order - 1) @ Noisy.rounded(g) for i in range(q)]
        total = total + stacked(*by_impulse) if q else total
    jumps = total.cleaned().reshape(q, r, inconsistency.data.shape[1])
    return scaling.columns[:, None] * jumps * scaling.time ** np.arange(float(q))[:, None, None]


def _impulse_effect(form: WeierstrassForm, inconsistency: Noisy, impulses: Sequence[np.ndarray]) -> list[np.ndarray]:
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


# Jumps and impulses at t = 0, from the decoupled pencil in its scaled units.
#
# The finite state starts at y_1(0+) = P_1 E z0, the infinite one is -sum N^i B2 f^(i). The vector
# g = P_2 F z0 + sum N^i B2 f^(i)(0+) is the inconsistency of the values at 0- : the states jump by -Q_2 g, and
# -C2 N^(p+1) g multiplies delta^(p) (the impulses of Moysis et al., Eq. 42 with (45) taken at 0+; g = 0 is
# condition (60), corrected). Its rounding noise is bounded along with it, so that a consistent start has g = 0.


@dataclass(frozen=True, eq=False)
class Start:
    """State and jump at t = 0; for S starts, each with a last axis of length S.

    Attributes:
        finite: y_1(0+) in scaled units, shape (n,).
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r), in the user's units.
        impulses: arrays (r,), the k-th multiplies delta^(k), in the user's units.
    """

    finite: np.ndarray
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]

    def __getitem__(self, place: int) -> Start:
        """The state and jump of one of S starts."""
        impulses = without_zeros([impulse[:, place].copy() for impulse in self.impulses])
        return Start(self.finite[:, place].copy(), self.jump[..., place].copy(), impulses)


def starts_of(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> Start:
    """The states at 0+, the jumps and the impulses at t = 0 of S starts under one force.

    All effects are linear in values and force, which are divided by a power of two near their size first: the squares of noise then
    stay in range.
    """
    stack, f = form.companion.scaled_stack(initial), scaled_force(form, force)
    own = np.concatenate([f.coefficients.ravel(), *f.impulses])
    largest = power_of_two_of(own)
    size = np.array([power_of_two_of(np.append(column, np.abs(own).max(initial=0.0))) for column in stack.T])
    impulses = [np.multiply.outer(g, 1 / size) for g in f.impulses]
    finite = form.finite_start @ (stack / size) + _finite_jump(form, impulses, len(size))
    driven = replace(f.divided(largest), jump=np.multiply.outer(f.jump, largest / size))
    inconsistency = inconsistency_of(form, stack / size, driven)
    with np.errstate(over="ignore", invalid="ignore"):  # reported below
        jump = size * _jump_effect(form, inconsistency, impulses, len(initial))
        effect = tuple(size * c for c in _impulse_effect(form, inconsistency, impulses))
        start = Start(size * finite, jump, effect)
    if not all(np.isfinite(values).all() for values in (start.finite, start.jump, *start.impulses)):
        raise Overflow("the jumps or impulses at t = 0 grow beyond the range of float64; choose other units or smaller values")
    return start


def start_of(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> Start:
    """The state at 0+, the jump and the impulses at t = 0 of one start."""
    return starts_of(form, initial[..., None], force)[0]


def inconsistency_of(form: WeierstrassForm, stack: np.ndarray, f: ScaledForce) -> Noisy:
    """g = P_2 F z0 + sum N^i B2 f^(i)(0+) in scaled units, entries below their rounding noise set to zero."""
    given = form.infinite_start @ Noisy.rounded(stack)
    total = given + _driven_inconsistency(form, f, f.jump)
    return Noisy(total.cleaned(), total.noise)


def without_zeros(impulses) -> tuple[np.ndarray, ...]:
    """Factors of delta, delta', ... up to the last one that is not zero."""
    count = max((k + 1 for k, impulse in enumerate(impulses) if impulse.any()), default=0)
    return tuple(impulses[:count])
