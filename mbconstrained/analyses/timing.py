"""Run times: repeats, clocks that other programs do not disturb, threads, and the machine."""

from __future__ import annotations

import gc
import os
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import get_clock_info, perf_counter, process_time
from typing import NamedTuple

import numpy as np

#: States of a small model, whose eigenvalues two threads compute no faster than one.
SMALL = 250

#: Packages on which run times depend.
PACKAGES = ("numpy", "scipy", "python-flint", "control", "scikit-sundae")

#: Called with the name of what is being computed.
Progress = Callable[[str], None]

#: Coarsest resolution of a clock for runs of a millisecond, s.
FINE_STEP = 1e-5


@dataclass(frozen=True)
class Timing:
    """Repeats of one run."""

    seconds: tuple[float, ...]  # duration of each repeat, in order

    @property
    def median(self) -> float:
        return float(np.median(self.seconds))

    @property
    def quartiles(self) -> tuple[float, float]:
        """Lower and upper quartile in s."""
        low, high = np.quantile(self.seconds, (0.25, 0.75))
        return float(low), float(high)

    def __add__(self, other: Timing) -> Timing:
        """Timing of two successive runs, repeat by repeat."""
        return Timing(tuple(one + two for one, two in zip(self.seconds, other.seconds)))

    def to_dict(self) -> dict:
        low, high = self.quartiles
        return {"median": self.median, "lower_quartile": low, "upper_quartile": high, "repeats": len(self.seconds)}


class Clock(NamedTuple):
    """A clock: its name for the reader, and a function that returns s."""

    name: str
    read: Callable[[], float]


def no_progress(text: str) -> None:
    """Ignore progress."""


def suitable_clock(states: int) -> Clock:
    """Processor time for small models, which run in one thread, independent of other programs.

    Elapsed time for larger ones, and where the clock of processor time is coarse.
    """
    if states <= SMALL and get_clock_info("process_time").resolution <= FINE_STEP:
        return Clock("processor time of one thread", process_time)
    return Clock("elapsed time", perf_counter)


def timed(work: Callable, clock: Callable[[], float] = perf_counter):
    start = clock()
    result = work()
    return result, clock() - start


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """A context in which garbage of one method is not collected in the run time of another."""
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
    """A context in which garbage collections ignore all existing objects."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


@contextmanager
def suitable_threads(states: int) -> Iterator[None]:
    """A context with one thread for the linear algebra of small models: several are slower, especially on a busy machine."""
    if states > SMALL:
        yield
        return
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield


def duration(seconds: float) -> str:
    """A time to three digits, with a suitable unit.

    >>> duration(2e-05), duration(0.99999), duration(0.0123), duration(12.0)
    ('20 µs', '1 s', '12.3 ms', '12 s')
    """
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def machine() -> dict[str, str]:
    """Processor, cores, system, and versions of packages.

    >>> "cores" in machine()
    True
    """
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count() or "unknown"),
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "packages": ", ".join(f"{name} {number}" for name in PACKAGES if (number := version_of(name))),
    }


def _processor() -> str:
    """The name of the processor; on some systems only its kind."""
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
        if name := next(filter(None, names), ""):
            return name
    return platform.processor() or platform.machine() or "unknown"


def version_of(name: str) -> str:
    """The version of an installed package; an empty string where it is not installed."""
    with suppress(PackageNotFoundError):
        return version(name)
    return ""
