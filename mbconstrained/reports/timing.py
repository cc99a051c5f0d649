"""Run times that can be trusted: many repeats, in turns with the others, by a clock that other programs do not move."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import get_clock_info, perf_counter, process_time

import numpy as np

#: Models with so many states are small: eigenvalues of their size are found no faster by two threads than by one.
SMALL = 250

#: A clock of coarser steps, in s, cannot tell runs of a millisecond.
FINE_STEP = 1e-5


@dataclass(frozen=True)
class Timing:
    """Repeats of one run.

    Attributes:
        seconds: of each repeat, in the order in which they were made.
    """

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """In s."""
        return float(np.median(self.seconds))

    @property
    def quartiles(self) -> tuple[float, float]:
        """The lower and the upper one, in s."""
        low, high = np.quantile(self.seconds, (0.25, 0.75))
        return float(low), float(high)

    def __add__(self, other: Timing) -> Timing:
        """Of two runs one after the other, repeat by repeat."""
        return Timing(tuple(one + two for one, two in zip(self.seconds, other.seconds)))

    def as_json(self) -> dict:
        """As plain data."""
        low, high = self.quartiles
        return {"median": self.median, "lower_quartile": low, "upper_quartile": high, "repeats": len(self.seconds)}


@dataclass(frozen=True)
class Clock:
    """What times are taken with.

    Attributes:
        name: for the reader.
        read: gives s.
    """

    name: str
    read: Callable[[], float]


def suitable_clock(states: int) -> Clock:
    """For what runs in one thread its own processor time, which stands still while another program has the processor.

    On an idle machine that is the time on the wall; where several threads work, or the clock is coarse, that one is taken.
    """
    if states <= SMALL and get_clock_info("process_time").resolution <= FINE_STEP:
        return Clock("processor time of one thread", process_time)
    return Clock("elapsed time", perf_counter)


def timed(work: Callable, clock: Callable[[], float] = perf_counter):
    """What the work gives and how long it took, in s."""
    begun = clock()
    found = work()
    return found, clock() - begun


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """What is left over by one method is not cleared away in the time of another."""
    gc.collect()
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def small_heap() -> Iterator[None]:
    """What there is already is not looked through again each time that something is cleared away."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


@contextmanager
def suitable_threads(states: int) -> Iterator[None]:
    """One thread for the linear algebra of small models: several are slower there, and much slower on a busy machine."""
    if states > SMALL:
        yield
        return
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


def duration(seconds: float) -> str:
    """A time to three digits, with a unit that reads well.

    >>> duration(2e-05), duration(0.99999), duration(0.0123), duration(12.0)
    ('20 µs', '1 s', '12.3 ms', '12 s')
    """
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"
