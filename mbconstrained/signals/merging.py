"""Sums of Bohl functions: parts with the same generator share their states wherever they can."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..tolerances import EPS
from .restarts import Restarts


class Part(NamedTuple):
    """One diagonal block of J, its states (m,) or Restarts, and its columns of C, shape (r, m)."""

    block: np.ndarray
    start: np.ndarray | Restarts
    coefficients: np.ndarray


def merged(parts: Sequence[Part]) -> list[Part]:
    """As few parts with the same sum as are easily found; those with restarts must have common knots."""
    kept: list[Part] = []
    for part in sorted(parts, key=lambda part: -len(part.block)):
        for place, other in enumerate(kept):
            total = _sum(other, part)
            if total is not None:
                kept[place] = total
                break
        else:
            kept.append(part)
    return kept


def _sum(larger: Part, part: Part) -> Part | None:
    """The sum as one part, or None."""
    if _is_tail(part, larger):
        total = larger.coefficients.copy()
        total[:, len(larger.block) - len(part.block) :] += part.coefficients
        return larger._replace(coefficients=total)
    factor = _factor(part, larger) if isinstance(part.start, Restarts) else None
    return None if factor is None else larger._replace(start=_added(larger.start, factor, part.start))


def _is_tail(part: Part, larger: Part) -> bool:
    """Whether the states of a part are the last ones of a larger part."""
    skip = len(larger.block) - len(part.block)
    return bool(
        np.array_equal(larger.block[skip:, skip:], part.block)
        and not larger.block[skip:, :skip].any()
        and _same(_rows(larger.start, skip), part.start)
    )


def _factor(part: Part, larger: Part) -> float | None:
    """How many times the leading columns of a larger part those of this one are, its generator being the same there.

    Delayed steps of one vector, or the slopes and jumps of a record, then need one chain for all.
    """
    size = len(part.block)
    columns = larger.coefficients[:, :size]
    if not np.array_equal(larger.block[:size, :size], part.block) or larger.block[size:, :size].any() or not columns.any():
        return None
    place = np.unravel_index(np.abs(columns).argmax(), columns.shape)
    factor = part.coefficients[place] / columns[place]
    same = np.abs(part.coefficients - factor * columns) <= EPS * np.abs(part.coefficients)
    return float(factor) if np.isfinite(factor) and same.all() else None


def _added(start: Restarts, factor: float, other: Restarts) -> Restarts:
    states, jumps, size = start.states.copy(), start.jumps.copy(), len(other.states)
    states[:size] += factor * other.states
    jumps[:size] += factor * other.jumps
    return Restarts(start.knots, states, jumps)


def _rows(start, skip):
    return start.rows(slice(skip, None)) if isinstance(start, Restarts) else start[skip:]


def _same(one, two) -> bool:
    if isinstance(one, Restarts):
        return np.array_equal(one.states, two.states) and np.array_equal(one.jumps, two.jumps)
    return np.array_equal(one, two)
