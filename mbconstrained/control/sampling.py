"""Exact discretization of state spaces with E singular or not: which inputs may be constant or linear between samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..exact.enclosure.discretization import DiscretizedSystem, discretized
from ..ground.checks import real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from .conversions import through
from .state_equations import delays_of_inputs

if TYPE_CHECKING:
    from .state_equations import StateEquations

HOLDS = (0, 1, "impulse")

#: Each step of a delay is a state.
MOST_DELAYED = 2000


@dataclass(frozen=True, eq=False)
class SampledEquations:
    """A discretized system, and what connects it with the continuous one.

    Attributes:
        matrices: A, B, C, D with the added states.
        start_map: the discrete states that belong to the states x(0-) of the continuous system, shape (n, N).
        notices: remarks.
    """

    matrices: DiscretizedSystem
    start_map: np.ndarray
    notices: tuple[Notice, ...]


def sampled_equations(system: StateEquations, step, hold=1, delays: Mapping[str, float] | None = None) -> SampledEquations:
    """Discretize E x' = A x + B u, y = C x + D u; where E is singular, its finite Jordan pair and the polynomial part of G(s)."""
    step = Fraction(real_number(step, "step", positive=True))
    if isinstance(hold, bool) or hold not in HOLDS:
        raise InputError(f"hold: found {hold!r}; expected 0 (constant between samples), 1 (linear between samples) or 'impulse'")
    late = _delays(system, delays, step)
    n, nothing = len(system.A), np.zeros(system.D.shape)
    is_ordinary = bool((system.E == np.eye(n)).all())
    pairs = None if is_ordinary else system.polynomial_matrix().jordan_pairs()
    if pairs is None or not any(pairs.structure.infinite_divisors):
        _refuse_feedthrough(system, system.D, hold)
        E = None if is_ordinary else system.E
        return SampledEquations(discretized(system.A, system.B, system.C, system.D, nothing, late, step, hold, E), np.eye(n), ())
    polynomial = [through(system, order) for order in range(pairs.structure.highest_impulse + 1)] or [nothing]
    for order in range(len(polynomial) - 1, 0, -1):
        _refuse_impulses(system, polynomial[order], order, hold)
    D, slopes = system.D + polynomial[0], polynomial[1] if len(polynomial) > 1 else nothing
    _refuse_feedthrough(system, D, hold)
    finite = pairs.finite
    matrices = discretized(finite.J, finite.B @ system.B, system.C @ finite.C, D, slopes, late, step, hold)
    texts = (
        f'{system.outputs[i]}: the part that follows the derivative of "{system.inputs[j]}" is that just before each sample'
        for i, j in np.argwhere(slopes)
    )
    return SampledEquations(matrices, finite.B @ system.E, tuple(Notice(NoticeKind.KINK, text) for text in texts))


def _refuse_impulses(system: StateEquations, factors: np.ndarray, order: int, hold) -> None:
    """Refuse outputs that follow a derivative of an input that is not smooth enough between samples."""
    if factors.any() and (hold != 1 or order > 1):
        i, j = np.argwhere(factors)[0]
        which = {1: "derivative", 2: "second derivative"}.get(order, f"derivative of order {order}")
        remedy = "give hold=1, or leave this output out" if order == 1 else "leave this output out"
        raise InputError(
            f'hold={hold!r}: the output "{system.outputs[i]}" follows the {which} of the input "{system.inputs[j]}", which has '
            f"Dirac impulses at the samples there; {remedy}"
        )


def _refuse_feedthrough(system: StateEquations, D: np.ndarray, hold) -> None:
    if hold == "impulse" and D.any():
        i, j = np.argwhere(D)[0]
        text = f'hold="impulse": the output "{system.outputs[i]}" follows the input "{system.inputs[j]}" itself'
        raise InputError(f"{text}, which is a train of Dirac impulses; leave this output out")


def _delays(system: StateEquations, delays: Mapping[str, float] | None, step: Fraction) -> list[Fraction]:
    """The delay of each input in s."""
    late = [Fraction(delay) for delay in delays_of_inputs(system, delays)]
    for name, delay in zip(system.inputs, late):
        if delay > MOST_DELAYED * step:
            raise InputError(
                f"delay of {name}: found {float(delay):g} s, which is more than {MOST_DELAYED} steps of {float(step):g} s, a state for each; "
                "give a larger step, or delay the input itself"
            )
    return late
