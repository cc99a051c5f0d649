"""The notices of a response: jumps, impulses, growth and doubtful decisions, in sentences."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Any, TypeAlias

import numpy as np

from ..ground.checks import counted
from ..ground.errors import IllConditioned, Overflow, within_float64
from ..ground.notices import Notice, NoticeKind, doubts_of
from ..ground.tolerances import EPS, NOISE_SAFETY, PRECISE_STATES, TRUST_LIMIT, noise_of, rounding_radius
from ..linalg.blocks import zeros_of
from ..linalg.exponential import block_states
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveLoad
from .events import Event

#: Number of jumps and impulses after t = 0 reported in a sentence each; the others are counted.
MOST_LATER = 6

#: Number of named coordinates that follow the kinks of an excitation.
MOST_KINK_NAMES = 3

#: Number of singular values in a notice about a rank decision, the smallest ones.
LISTED_SINGULAR_VALUES = 4

DERIVATIVE_NAMES = ("value", "velocity", "acceleration", "jerk")


#: A ``Response``, whose file imports this one.
SolvedProblem: TypeAlias = Any


@within_float64()
def response_notices(x: SolvedProblem) -> tuple[Notice, ...]:
    """Jumps, impulses, the notices of the force, growth, doubtful rank decisions and unsatisfied equations of a response."""

    def jump_text(i: int, order: int, size: float) -> str:
        return f"{derivative_word(order)} of {x.polynomial_matrix.coordinates[i]} by {size:.6g}"

    later = later_notices(x, partial(_event_sentences, x), jump_text)
    return (*_jumps(x), *_impulses(x), *later, *x.force.notices, *x.problem.notices, *remaining_notices(x))


def remaining_notices(x: SolvedProblem) -> tuple[Notice, ...]:
    """Notices of the solution that concern the answer: no doubts about float64 where the exact engine proves the values.

    A rank of a small model that the exact data have not keeps its notice, which names the entry that decides.
    """
    notices, doubts = x.solution.notices, x._doubts
    ranks = any(notice.doubtful and notice.kind == NoticeKind.RANK for notice in notices)
    if (doubts or any(notice.doubtful for notice in notices)) and x.is_proved:
        return tuple(notice for notice in notices if not notice.doubtful)
    if ranks and not doubts and (change := _change_by_ranks(x)) is not None and change <= EPS**0.5:
        evidence = f"; the other decision changes no coordinate by more than {change:.1g} of its largest value"
        notices = tuple(
            replace(one, text=one.text + evidence, doubtful=False) if one.kind == NoticeKind.RANK else one for one in notices
        )
        ranks = False
    if ranks and not x._unproved:
        from ..exact.enclosure.exact_response import deciding_entry

        entry = deciding_entry(x.polynomial_matrix)
        more = f"; {entry}" if entry else ""
        notices = tuple(replace(one, text=one.text + more) if one.kind == NoticeKind.RANK else one for one in notices)
    return (*notices, *doubts, *_without_digits(x))


#: Times at which errors are estimated for a notice.
ESTIMATED_TIMES = 3


def _without_digits(x: SolvedProblem) -> Iterator[Notice]:
    """Values of a larger model without a reliable digit, at some times from the fastest to the slowest motion.

    Where only late values are so, those of a motion that rounding errors excite and that grows, it is no doubt of the earlier ones.
    """
    function = x.solution.function
    if not x._unproved or not len(function.blocks):
        return
    rates = np.abs(zeros_of(function.blocks))
    moving = rates[rates > 0]
    if not moving.size:
        return
    times = np.clip(np.geomspace(1.0 / moving.max(), 10.0 / moving.min(), ESTIMATED_TIMES), *TESTED_RANGE)
    try:
        errors = x._estimates_without_trials(times)
    except (Overflow, IllConditioned):
        return
    if errors is None:
        return
    bad = ~(errors <= TRUST_LIMIT)
    if bad[0] or bad[1]:
        yield from doubts_of(f"values from t = {times[bad][0]:.3g} s on", float(errors[bad].max()))
    elif bad.any():
        yield Notice(
            NoticeKind.ACCURACY, f"the estimated relative error of values at t = {times[bad][0]:.3g} s is {errors[bad].max():.2g}"
        )


def _change_by_ranks(x: SolvedProblem) -> float | None:
    """Change of the values by the alternative rank decision, relative to the largest of each coordinate; None where unknown."""
    other = x._decided_otherwise
    if other is None:
        return None
    times = x.solution.sums(1)[0]
    try:
        values, others = x(times), other(times)
    except Overflow:
        return None
    change, largest = (np.abs(rows).max(axis=1, initial=0.0) for rows in (others - values, values))
    return float(np.divide(change, largest, out=np.where(change > 0, np.inf, 0.0), where=largest > 0).max(initial=0.0))


def pair_notices(pairs) -> tuple[Notice, ...]:
    """Zeros in the right half plane, rank decisions without a clear gap, pairs that do not invert A(s)."""
    return (*_growth(pairs), *_rank(pairs), *_digits(pairs), *_residual(pairs))


def _jumps(x: SolvedProblem):
    for order, row in enumerate(x.jump):
        yield from _jump_sentences(x, order, row, x.initial[order], x.start[order], "t = 0")


def _jump_sentences(x: SolvedProblem, order, jump, before, after, when):
    names = x.polynomial_matrix.coordinates
    what = derivative_word(order)
    for i in np.flatnonzero(jump):
        yield Notice(NoticeKind.JUMP, f"{names[i]}: its {what} jumps at {when} from {before[i]:.6g} to {after[i]:.6g}")


def _impulses(x: SolvedProblem, impulses=None, when: str = "t = 0"):
    names = x.polynomial_matrix.coordinates
    for order, row in enumerate(x.impulses if impulses is None else impulses):
        for i in np.flatnonzero(row):
            delta = "a Dirac impulse" if order == 0 else f"the derivative of order {order} of a Dirac impulse"
            yield Notice(NoticeKind.IMPULSE, f"{names[i]}: {delta} at {when} of size {row[i]:.6g}")


def later_notices(
    x: SolvedProblem, sentences: Callable, jump_text: Callable[[int, int, float], str], loads: Sequence[ImpulsiveLoad] = ()
) -> Iterator[Notice]:
    """The notices of the first events after t = 0, one that counts the others, and one on all kinks of the excitation.

    Args:
        x: the response.
        sentences: the notices of an event or of a load.
        jump_text: the text of a jump of a coordinate, by its index, order of derivative and size.
        loads: impulses of other quantities.
    """
    if x._later_events or loads:
        yield from _first_and_count(sentences, sorted([*without_kinks(x), *loads], key=lambda event: event.time))
        yield from _kink_notice(x._kinks, jump_text)


def without_kinks(x: SolvedProblem) -> list[Event]:
    """The events after t = 0, except kinks of the excitation."""
    kinks = {event.time for event in x._kinks}
    return [event for event in x._later_events if event.time not in kinks]


def _kink_notice(kinks: Sequence[Event], jump_text: Callable[[int, int, float], str]) -> Iterator[Notice]:
    """One notice on all kinks of the excitation after t = 0, with the largest jump of each derivative."""
    if kinks:
        largest = np.abs([event.jump for event in kinks]).max(axis=0)
        order = next(k for k, row in enumerate(largest) if row.any())
        ranked = sorted(np.flatnonzero(largest[order]), key=lambda i: -largest[order, i])
        texts = [jump_text(i, order, largest[order, i]) for i in ranked[:MOST_KINK_NAMES]]
        more = f" and {len(ranked) - len(texts)} others by less" if len(ranked) > len(texts) else ""
        times = f"at {len(kinks)} times from t = {kinks[0].time:.6g} s to t = {kinks[-1].time:.6g} s"
        when, most = (times, "at most ") if len(kinks) > 1 else (f"at t = {kinks[0].time:.6g} s", "")
        yield Notice(
            NoticeKind.KINK, f"{when} the slope of the excitation jumps, its value does not: {most}the {', the '.join(texts)}{more}"
        )


def derivative_word(order: int) -> str:
    """The name of a derivative of a quantity without unit."""
    return DERIVATIVE_NAMES[order] if order < len(DERIVATIVE_NAMES) else f"derivative {order}"


def _event_sentences(x: SolvedProblem, event: Event):
    when = f"t = {event.time:.6g} s"
    for order, row in enumerate(event.jump):
        if row.any():
            yield from _jump_sentences(x, order, row, *sides(x, event, order), when)
    yield from _impulses(x, event.impulses, when)


def sides(x: SolvedProblem, event: Event, order: int) -> tuple[np.ndarray, np.ndarray]:
    """x^(order) just before and just after an event; a remainder of a jump within its rounding error is zero."""
    after = x.derivative(order)(event.time)
    before = after - event.jump[order]
    noise = noise_of(np.abs(event.jump[order]))
    return np.where(np.abs(before) <= noise, 0.0, before), np.where(np.abs(after) <= noise, 0.0, after)


def _first_and_count(sentences: Callable, events: Sequence[Event | ImpulsiveLoad]) -> Iterator[Notice]:
    first = list(islice((notice for event in events for notice in sentences(event)), MOST_LATER))
    yield from first
    jumps, impulses = counts(events)
    rest = jumps + impulses - len(first)
    if rest > 0:
        times = len({event.time for event in events})
        yield Notice(
            NoticeKind.JUMP if jumps else NoticeKind.IMPULSE,
            f"after t = 0 there are {jumps} jumps and {impulses} impulses in all, at {times} times from "
            f"t = {events[0].time:.6g} s to t = {events[-1].time:.6g} s",
        )


def counts(events: Sequence[Event | ImpulsiveLoad]) -> tuple[int, int]:
    """The number of values that jump at events, and of impulses."""
    jumps = sum(np.count_nonzero(event.jump) for event in events if isinstance(event, Event))
    return jumps, sum(np.count_nonzero(impulse) for event in events for impulse in event.impulses)


def _growth(pairs):
    zeros = pairs.finite.zeros
    noise = noise_of(max((abs(zero.value) for zero in zeros), default=0.0))
    return growth_notice(
        np.array([z.value for z in zeros if z.value.real > max(rounding_radius(z.multiplicity) * abs(z.value), noise)])
    )


def growth_notice(growing: np.ndarray) -> tuple[Notice, ...]:
    """The notice of eigenvalues in the right half plane, of each complex pair one."""
    if not len(growing):
        return ()
    text = f"{counted(len(growing), 'eigenvalue')} in the right half plane: the motion grows, fastest like e^({growing.real.max():.6g} t)"
    return (Notice(NoticeKind.UNSTABLE, text),)


def _rank(pairs):
    for decision in pairs.form.decisions:
        if not decision.clear:
            smallest = ", ".join(f"{value:.3g}" for value in decision.singular_values[-LISTED_SINGULAR_VALUES:])
            yield Notice(
                NoticeKind.RANK,
                f"a rank decision has no clear gap: the smallest value kept is {decision.smallest_kept:.3g} times, the largest "
                f"dropped {decision.largest_dropped:.3g} times its rounding noise; rank {decision.rank} was decided; smallest "
                f"singular values of the scaled matrix: {smallest}. Give rank_tolerance to decide otherwise",
                doubtful=True,
            )


def _digits(pairs):
    states = pairs.form.companion.state_count
    stiff = any(factors is not None for factors in pairs.polynomial_matrix.factors)
    if stiff and not pairs.form.companion.is_precise:
        yield Notice(
            NoticeKind.ACCURACY,
            f"elements of very different stiffness were assembled in float64: with {states} states, more than {PRECISE_STATES}, they "
            "are not solved with more digits, and the softest may have lost theirs",
            doubtful=True,
        )


def _residual(pairs):
    residual = next(item.value for item in pairs.evidence if item.name == "residual")
    if not residual <= EPS**0.5:
        yield Notice(NoticeKind.ACCURACY, f"the pairs do not invert A(s): relative residual {residual:.2g}", doubtful=True)


# The residual of each equation, relative to its own terms: what was lost in a row of small numbers shows, however large others are.

#: Number of violated equations and starting values reported in a sentence each.
MOST_UNSATISFIED = 4

#: Times of the motion at which equations are tested, after each of some knots of the force.
TESTED_TIMES, TESTED_KNOTS = 8, 4

#: They are within this range, in s.
TESTED_RANGE = float(np.finfo(float).tiny) ** 0.5, float(np.finfo(float).max) ** 0.5


def unsatisfied(x: SolvedProblem) -> Iterator[Notice]:
    """The equations A(d/dt) x = f and the values at 0+ that the solution does not satisfy to half of the digits."""
    if x.problem.delayed:  # the residual includes the delayed terms
        return
    A = x.polynomial_matrix
    jump = x.solution.jump
    with np.errstate(all="ignore"):  # what is not finite is not tested
        begin = np.where(np.abs(x.initial + jump) <= noise_of(np.abs(jump)), 0.0, x.initial + jump)
        times, derivatives, states, rate = x.solution.sums(A.degree + 1)
        rate = np.float64(rate)  # its powers overflow to infinity
        loads, sizes = x.force.smooth._values(times), [np.abs(rows @ states).max(axis=0, initial=0.0) for rows in derivatives]
        largest = np.max([size / rate**order for order, size in enumerate(sizes)], axis=0)
        residual, terms, noise = -loads, np.abs(loads), noise_of(np.abs(loads))
        starts = []
        for order, (rows, coefficient, uncertainty) in enumerate(zip(derivatives, A.coefficients, A.uncertainty)):
            values, size = rows @ states, abs(rows) @ np.abs(states)
            rounding = noise_of(size, len(states))
            if order < A.degree:
                starts.append((values[:, 0] - begin[order], np.abs(begin[order]), rounding[:, 0]))
            own, moving = np.abs(coefficient), np.abs(values) > noise_of(largest * rate**order, len(states))
            residual, terms = residual + coefficient @ values, terms + own @ np.where(moving, np.abs(values), 0.0)
            noise = noise + own @ rounding + (uncertainty + (x.problem.rank_tolerance or 0.0) * own) @ np.abs(values)
        broken = (np.abs(residual) > np.maximum(EPS**0.5 * terms, noise)) & (terms > 0)
        lost = [(np.abs(off) > np.maximum(EPS**0.5 * size, rounding)) & (size > 0) for off, size, rounding in starts]
        if x._unproved and (broken.any() or any(row.any() for row in lost)):
            moved = _moved_by_rounding(x, times)
            broken &= np.abs(residual) > sum(np.abs(coefficient) @ change for coefficient, change in zip(A.coefficients, moved))
            lost = [row & (np.abs(off) > change[:, 0]) for row, (off, *_), change in zip(lost, starts, moved)]
    texts = [
        f'equation "{A.equations[row]}" is not satisfied: at t = {times[at]:.6g} s its left side less the force is '
        f"{residual[row, at]:.3g}, its terms add up to {terms[row, at]:.3g}"
        for row, at in ((row, int(broken[row].argmax())) for row in np.flatnonzero(broken.any(axis=1)))
    ]
    texts += [
        f"{A.coordinates[i]}: derivative {order} is off by {off[i]:.3g} at 0+, where it is {size[i]:.3g}"
        for order, ((off, size, _), rows) in enumerate(zip(starts, lost))
        for i in np.flatnonzero(rows)
    ]
    for text in texts[:MOST_UNSATISFIED]:
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)
    if len(texts) > MOST_UNSATISFIED:
        yield Notice(NoticeKind.ACCURACY, f"so are {len(texts) - MOST_UNSATISFIED} others", doubtful=True)


def _moved_by_rounding(x: SolvedProblem, times: np.ndarray) -> list[np.ndarray]:
    """Differences of x, x', ... between solutions with perturbed data, shape (r, T) each; zero without such solutions.

    Only these are compared with each other: an error common to all of them is not explained by rounding.
    """
    count = x.polynomial_matrix.degree + 1
    try:
        sums = [one.solution.sums(count, times) for one in x._moved]
    except Overflow:
        return [np.zeros((x.polynomial_matrix.size, len(times)))] * count
    return [NOISE_SAFETY * np.ptp([rows[order] @ states for _, rows, states, _ in sums], axis=0) for order in range(count)]


def modal_sums(
    function: BohlFunction, count: int, times: np.ndarray | None = None
) -> tuple[np.ndarray, list[np.ndarray], np.ndarray, float]:
    """Rows and states whose products are x, x', ... from the fastest to the slowest motion after the first and last knots."""
    rates = np.abs(zeros_of(function.blocks))
    moving = rates[rates > 0]
    rate = float(moving.max(initial=0.0)) or 1.0
    first, last = np.clip([0.1 / rate, 10.0 / moving.min(initial=np.inf if moving.size else 1.0)], *TESTED_RANGE)
    if times is None:
        knots = function.restarts.knots
        knots = np.unique(np.concatenate([knots[:TESTED_KNOTS], knots[-TESTED_KNOTS:]]))
        times = np.unique(np.add.outer(knots, np.append(0.0, np.geomspace(first, last, TESTED_TIMES))))
    piece, since = function.restarts.located(times)
    states = block_states(function.blocks, function.restarts.states[:, piece], since)
    rows = [function.derivative(order).coefficients for order in range(count)]
    return times, rows, states, rate
