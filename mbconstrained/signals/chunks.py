"""Values of a function of time piece by piece, for answers larger than memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..checks import real_array, whole_number
from ..errors import InputError
from ..linalg.blocks import CHUNK_ENTRIES

Piece = tuple[np.ndarray, np.ndarray]


def in_chunks(function: Callable, times, count: int | None = None) -> Iterator[Piece]:
    """Pairs (times, function(times)) whose values have no more than CHUNK_ENTRIES numbers each (one time at least), in order.

    Args:
        function: of times (T,), with ``size`` rows.
        times: shape (T,), in s; or its first and last one, where a count is given.
        count: how many even times there are, from the first to the last; they are made piece by piece too.

    Raises:
        InputError: times or a count that are not such.

    >>> from .bohl import BohlFunction
    >>> clock = BohlFunction(np.array([[1.0, 0.0]]), (np.array([[0.0, 1.0], [0.0, 0.0]]),), np.array([0.0, 1.0]))
    >>> [values.tolist() for _, values in in_chunks(clock, (0.0, 2.0), 3)]
    [[[0.0, 1.0, 2.0]]]
    """
    width = max(1, CHUNK_ENTRIES // max(function.size, 1))
    if count is None:
        given = real_array(times, "times", shape=(None,))
        parts = (given[begin : begin + width] for begin in range(0, len(given), width))
    else:
        parts = _even_parts(times, whole_number(count, "count", minimum=2), width)
    return ((part, function(part)) for part in parts)


def _even_parts(ends, count: int, width: int) -> Iterator[np.ndarray]:
    first, last = real_array(ends, "times with a count, the first and the last one", shape=(2,)).tolist()
    if not 0 <= first < last:
        raise InputError(f"times: found {first:g} s to {last:g} s; expected a first one of at least 0 and a later last one")
    step = (last - first) / (count - 1)
    numbers = ((begin, min(begin + width, count)) for begin in range(0, count, width))
    return (np.minimum(first + step * np.arange(*part), last) for part in numbers)
