"""What a response says about itself, in sentences."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ..linalg.precise import MOST_STATES
from ..notices import Notice
from ..signals.impulsive import Blow
from ..tolerances import EPS, noise_of, rounding_radius
from .events import Event

if TYPE_CHECKING:
    from .response import Response

#: So many jumps and impulses after t = 0 are told in a sentence each; of more, the others are counted.
MOST_LATER = 6

#: How many singular values a notice about a rank decision tells, the smallest ones.
SINGULAR_VALUES_TOLD = 4

DERIVATIVE_NAMES = ("value", "velocity", "acceleration", "jerk")


def response_notices(x: Response) -> tuple[Notice, ...]:
    """Jumps, impulses, what the force says of itself, growth and doubtful rank decisions of a response."""
    return (*_jumps(x), *_impulses(x), *_later(x), *x.force.notices, *x.solution.notices)


def pair_notices(pairs) -> tuple[Notice, ...]:
    """Zeros in the right half plane, rank decisions without a clear gap, pairs that do not invert A(s)."""
    return (*_growth(pairs), *_rank(pairs), *_digits(pairs), *_residual(pairs))


def _jumps(x: Response):
    for order, row in enumerate(x.jump):
        yield from _jump_sentences(x, order, row, x.initial[order], x.start[order], "t = 0")


def _jump_sentences(x: Response, order, jump, before, after, when):
    names = x.polynomial_matrix.coordinates
    what = DERIVATIVE_NAMES[order] if order < len(DERIVATIVE_NAMES) else f"derivative {order}"
    for i in np.flatnonzero(jump):
        yield Notice("jump", f"{names[i]}: its {what} jumps at {when} from {before[i]:.6g} to {after[i]:.6g}")


def _impulses(x: Response, impulses=None, when: str = "t = 0"):
    names = x.polynomial_matrix.coordinates
    for order, row in enumerate(x.impulses if impulses is None else impulses):
        for i in np.flatnonzero(row):
            delta = "a Dirac impulse" if order == 0 else f"the derivative of order {order} of a Dirac impulse"
            yield Notice("impulse", f"{names[i]}: {delta} at {when} of size {row[i]:.6g}")


def _later(x: Response):
    yield from first_and_count(lambda event: _event_sentences(x, event), x.events)


def _event_sentences(x: Response, event: Event):
    when = f"t = {event.time:.6g} s"
    for order, row in enumerate(event.jump):
        if row.any():
            yield from _jump_sentences(x, order, row, *sides(x, event, order), when)
    yield from _impulses(x, event.impulses, when)


def sides(x: Response, event: Event, order: int) -> tuple[np.ndarray, np.ndarray]:
    """x^(order) just before and just after an event; what a jump leaves of a value below its rounding is zero."""
    after = x.derivative(order)(event.time)
    before = after - event.jump[order]
    noise = noise_of(np.abs(event.jump[order]))
    return np.where(np.abs(before) <= noise, 0.0, before), np.where(np.abs(after) <= noise, 0.0, after)


def first_and_count(sentences: Callable, *happenings: Sequence[Event | Blow]) -> Iterator[Notice]:
    """The notices of the first happenings after t = 0, and one that counts the others.

    Args:
        sentences: the notices of one happening, one for each of its jumps and impulses.
        happenings: each by ascending time.
    """
    events = sorted((event for events in happenings for event in events), key=lambda event: event.time)
    told = list(islice((notice for event in events for notice in sentences(event)), MOST_LATER))
    yield from told
    jumps, impulses = counts(events)
    rest = jumps + impulses - len(told)
    if rest > 0:
        times = len({event.time for event in events})
        yield Notice(
            "jump" if jumps else "impulse",
            f"after t = 0 there are {jumps} jumps and {impulses} impulses in all, at {times} times from "
            f"t = {events[0].time:.6g} s to t = {events[-1].time:.6g} s",
        )


def counts(events: Sequence[Event | Blow]) -> tuple[int, int]:
    """How many numbers jump at events, and how many impulses there are."""
    jumps = sum(np.count_nonzero(event.jump) for event in events if isinstance(event, Event))
    return jumps, sum(np.count_nonzero(impulse) for event in events for impulse in event.impulses)


def _growth(pairs):
    zeros = pairs.finite.zeros
    noise = noise_of(max((abs(zero.value) for zero in zeros), default=0.0))
    growing = [z.value for z in zeros if z.value.real > max(rounding_radius(z.multiplicity) * abs(z.value), noise)]
    if growing:
        fastest = max(growing, key=lambda value: value.real)
        yield Notice(
            "unstable", f"{len(growing)} zero(s) in the right half plane: the motion grows, fastest like e^({fastest.real:.6g} t)"
        )


def _rank(pairs):
    for decision in pairs.form.decisions:
        if not decision.clear:
            yield Notice(
                "rank",
                f"a rank decision has no clear gap: the smallest value kept is {decision.smallest_kept:.3g} times, the largest "
                f"dropped {decision.largest_dropped:.3g} times its rounding noise; rank {decision.rank} was decided; smallest "
                f"singular values of the scaled matrix: {_few(decision.singular_values)}. Give rank_tolerance to decide otherwise",
                doubtful=True,
            )


def _digits(pairs):
    states = pairs.form.companion.state_count
    stiff = any(factors is not None for factors in pairs.polynomial_matrix.factors)
    if stiff and not pairs.form.companion.is_precise:
        yield Notice(
            "accuracy",
            f"elements of very different stiffness were assembled in float64: with {states} states, more than {MOST_STATES}, they "
            "are not solved with more digits, and the softest may have lost theirs",
            doubtful=True,
        )


def _few(values) -> str:
    return ", ".join(f"{value:.3g}" for value in values[-SINGULAR_VALUES_TOLD:])


def _residual(pairs):
    residual = next(item.value for item in pairs.evidence if item.name == "residual")
    if not residual <= EPS**0.5:
        yield Notice("accuracy", f"the pairs do not invert A(s): relative residual {residual:.2g}", doubtful=True)
