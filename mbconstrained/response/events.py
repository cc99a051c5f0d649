"""What happens after t = 0, where the force starts, stops, changes or strikes: jumps and Dirac impulses of x."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import Overflow
from ..jordan.weierstrass import WeierstrassForm
from ..linalg.noise import Noisy
from ..signals.impulsive import ImpulsiveSmooth
from .effects import driven_inconsistency, finite_kick, impulse_effect, jump_effect
from .forcing import power_of_two_of, scaled_force, scaled_impulses
from .parts import without_zeros


@dataclass(frozen=True)
class Event:
    """Jumps and Dirac impulses of x at one time after t = 0.

    Attributes:
        time: when, in s.
        jump: x^(i)(t+) - x^(i)(t-), shape (q, r); exactly zero where x^(i) is continuous.
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta at that time.
    """

    time: float
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]


@dataclass(frozen=True)
class Kicks:
    """What the force does at all of its K knots after t = 0.

    Attributes:
        times: the knots, shape (K,), in s.
        finite: what the finite state gains by impulses, in scaled units, shape (n, K).
        jump: of x^(i), shape (q, r, K), in the user's units.
        impulses: arrays (r, K), the k-th multiplies delta^(k), in the user's units.
    """

    times: np.ndarray
    finite: np.ndarray
    jump: np.ndarray
    impulses: list[np.ndarray]

    @property
    def events(self) -> tuple[Event, ...]:
        """The knots at which something happens to x."""
        happens = self.jump.any(axis=(0, 1))
        for impulse in self.impulses:
            happens = happens | impulse.any(axis=0)
        return tuple(
            Event(float(self.times[k]), self.jump[:, :, k].copy(), without_zeros([c[:, k].copy() for c in self.impulses]))
            for k in np.flatnonzero(happens)
        )


def kicks_of(form: WeierstrassForm, force: ImpulsiveSmooth, q: int) -> Kicks:
    """Jumps and impulses at the knots of the force after t = 0, q rows of derivatives.

    Every knot is divided by a power of two near its own size first: squares of noise shall stay in range.

    Raises:
        Overflow: one of them leaves the range of float64.
    """
    times = force.knots[1:]
    if not len(times):
        return Kicks(times, np.zeros((len(form.T), 0)), np.zeros((q, force.size, 0)), [])
    f = scaled_force(form, force)
    largest = power_of_two_of(f.coefficients)
    changes = force.smooth.with_knots(force.knots).restarts.jumps[:, 1:] / f.units[:, None]
    impulses = _impulses_by_order(form, force, times)
    size = np.array([power_of_two_of(column) for column in np.vstack([changes * largest, *impulses]).T])
    impulses = [g / size for g in impulses]
    inconsistency = driven_inconsistency(form, f.divided(largest), changes * (largest / size))
    inconsistency = Noisy(inconsistency.cleaned(), inconsistency.noise)
    with np.errstate(over="ignore", invalid="ignore"):  # reported below
        finite = size * finite_kick(form, impulses, len(times))
        jump = size * jump_effect(form, inconsistency, impulses, q)
        found = [size * c for c in impulse_effect(form, inconsistency, impulses)]
    if not all(np.isfinite(values).all() for values in (finite, jump, *found)):
        raise Overflow("the jumps or impulses after t = 0 grow beyond the range of float64; choose other units or smaller values")
    return Kicks(times, finite, jump, found)


def _impulses_by_order(form, force, times) -> list[np.ndarray]:
    """The force's own Dirac impulses, scaled: for each order an array (r, K)."""
    count = max((len(blow.impulses) for blow in force.later), default=0)
    found = [np.zeros((force.size, len(times))) for _ in range(count)]
    for blow in force.later:
        at = np.searchsorted(times, blow.time)
        for order, g in enumerate(scaled_impulses(form, blow.impulses)):
            found[order][:, at] = g
    return found
