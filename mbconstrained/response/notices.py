"""What a response says about itself, in sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..notices import Notice
from ..tolerances import EPS, noise_of, rounding_radius

if TYPE_CHECKING:
    from .response import Response

DERIVATIVE_NAMES = ("value", "velocity", "acceleration", "jerk")


def response_notices(x: Response) -> tuple[Notice, ...]:
    """Jumps, impulses, growth and doubtful rank decisions of a response."""
    return (*_jumps(x), *_impulses(x), *pair_notices(x.pairs))


def pair_notices(pairs) -> tuple[Notice, ...]:
    """Zeros in the right half plane, rank decisions without a clear gap, pairs that do not invert A(s)."""
    return (*_growth(pairs), *_rank(pairs), *_residual(pairs))


def _jumps(x: Response):
    names = x.polynomial_matrix.coordinates
    for order, row in enumerate(x.jump):
        for i in np.flatnonzero(row):
            what = DERIVATIVE_NAMES[order] if order < len(DERIVATIVE_NAMES) else f"derivative {order}"
            yield Notice("jump", f"{names[i]}: its {what} jumps at t = 0 from {x.initial[order, i]:.6g} to {x.start[order, i]:.6g}")


def _impulses(x: Response):
    names = x.polynomial_matrix.coordinates
    for order, row in enumerate(x.impulses):
        for i in np.flatnonzero(row):
            delta = "a Dirac impulse" if order == 0 else f"the derivative of order {order} of a Dirac impulse"
            yield Notice("impulse", f"{names[i]}: {delta} at t = 0 of size {row[i]:.6g}")


def _growth(pairs):
    zeros = pairs.finite.zeros
    noise = noise_of(max((abs(zero.value) for zero in zeros), default=0.0))
    growing = [z.value for z in zeros if z.value.real > max(rounding_radius(z.multiplicity) * abs(z.value), noise)]
    if growing:
        fastest = max(growing, key=lambda value: value.real)
        yield Notice("unstable", f"{len(growing)} zero(s) in the right half plane: the motion grows, fastest like e^({fastest.real:.6g} t)")


def _rank(pairs):
    for decision in pairs.form.decisions:
        if not decision.clear:
            yield Notice(
                "rank",
                f"a rank decision has no clear gap: the smallest value kept is {decision.smallest_kept:.3g} times, the largest "
                f"dropped {decision.largest_dropped:.3g} times its rounding noise; rank {decision.rank} was decided",
                doubtful=True,
            )


def _residual(pairs):
    residual = next(item.value for item in pairs.evidence if item.name == "residual")
    if not residual <= EPS**0.5:
        yield Notice("accuracy", f"the pairs do not invert A(s): relative residual {residual:.2g}", doubtful=True)
