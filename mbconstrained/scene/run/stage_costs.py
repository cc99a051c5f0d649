"""The cost of a stage in seconds and memory of the whole process, and a time limit for work of unknown length.

Linux keeps the highest resident memory of a process and allows resetting it, so that each stage has a peak of its own.
Elsewhere only the peak since the start of the process is known, which grows where a stage exceeds all before, or nothing at all.
A measurement takes some 0.1 ms and never fails.
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

#: Written into this file, "5" sets the highest resident memory back to the present one (man proc_pid_clear_refs).
_CLEAR, _SET_BACK = "/proc/self/clear_refs", "5"
_STATUS = "/proc/self/status"

#: Bytes per unit of ru_maxrss: macOS counts bytes, all others kilobytes (man getrusage).
_UNIT_OF_GROWTH = 1 if sys.platform == "darwin" else 1024

OWN_PEAK = "Memory is the highest resident memory during a stage above that at its start, with what it imports."
GROWTH = "Memory is by how much a stage raised the highest resident memory of the process; 0 where an earlier one needed more."
NOT_MEASURED = "Memory is not measured on this system."


@dataclass(frozen=True)
class Cost:
    """Cost of a stage.

    Attributes:
        seconds: wall-clock time.
        memory: highest resident memory above that at the start, in bytes; None where it cannot be measured.
        peak: highest resident memory of the process, in bytes, or None.
    """

    seconds: float
    memory: int | None = None
    peak: int | None = None

    def __add__(self, other: Cost) -> Cost:
        """Cost of two parts of one stage, with other work between them; the memory of the first may have stayed.

        >>> Cost(1.0, 10, 110) + Cost(2.0, 5, 120)
        Cost(seconds=3.0, memory=15, peak=120)
        """
        memory = None if self.memory is None or other.memory is None else self.memory + other.memory
        peaks = [peak for peak in (self.peak, other.peak) if peak is not None]
        return Cost(self.seconds + other.seconds, memory, max(peaks, default=None))


class Costs:
    """Costs by name, of successive laps; the first begins with the object."""

    def __init__(self):
        self.by_name: dict[str, Cost] = {}
        self._begin()

    def lap(self, name: str) -> Cost:
        """Add the time since the previous lap to a name; return the cost of this lap."""
        seconds, peak = time.perf_counter() - self._started, _highest()
        cost = Cost(seconds, None if self._memory is None or peak is None else max(peak - self._memory, 0), peak)
        self.by_name[name] = self.by_name[name] + cost if name in self.by_name else cost
        self._begin()
        return cost

    def _begin(self) -> None:
        self._memory = _status("VmRSS:") if _set_back() else _highest()
        self._started = time.perf_counter()


def memory_note() -> str:
    """Description of the measurement of memory on this system."""
    if _set_back() and _status("VmRSS:") is not None:
        return OWN_PEAK
    return NOT_MEASURED if _highest() is None else GROWTH


def _set_back() -> bool:
    """Whether the highest resident memory could be reset to the present one."""
    try:
        with open(_CLEAR, "w", encoding="ascii") as file:
            file.write(_SET_BACK)
    except OSError:
        return False
    return True


def _highest() -> int | None:
    """The highest resident memory since the reset, or else since the start of the process."""
    if (highest := _status("VmHWM:")) is not None:
        return highest
    try:
        import resource
    except ImportError:  # Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _UNIT_OF_GROWTH


def _status(key: str) -> int | None:
    """An entry of the status file in bytes."""
    try:
        with open(_STATUS, encoding="utf-8") as file:
            return next((1024 * int(line.split()[1]) for line in file if line.startswith(key)), None)
    except (OSError, ValueError, IndexError):
        return None


#: An alarm that comes during a finalizer, from which nothing can be raised, is lost: it is rung again after so many seconds.
AGAIN = 1.0


class OutOfTime(BaseException):
    """Time limit exceeded; not an Exception, so that no handler in between catches it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """A context that stops its work after a number of seconds.

    Where there are no alarms (in threads, on Windows) there is no limit either.

    >>> with time_limit(10.0):
    ...     1 + 1
    2
    """
    if not (hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()):
        yield
        return

    def stop(*_) -> None:
        raise OutOfTime

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds, AGAIN)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
