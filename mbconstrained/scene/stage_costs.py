"""What a stage takes: seconds and memory, of the whole process.

Linux keeps the highest resident memory of a process and lets it be set back, so that each stage has a highest of its
own. Elsewhere only the highest since the start of the process is known, which grows where a stage goes beyond all before;
and where not even that is known, nothing is told. A measurement takes some 0.1 ms and never fails.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

#: Written into this file, "5" sets the highest resident memory back to the present one (man proc_pid_clear_refs).
_CLEAR, _SET_BACK = "/proc/self/clear_refs", "5"
_STATUS = "/proc/self/status"

#: Of ru_maxrss, in bytes: macOS counts them, all others count kilobytes (man getrusage).
_UNIT_OF_GROWTH = 1 if sys.platform == "darwin" else 1024

OWN_PEAK = "Memory is the highest resident memory during a stage above that at its start, with what it imports."
GROWTH = "Memory is by how much a stage raised the highest resident memory of the process; 0 where an earlier one needed more."
NOT_MEASURED = "Memory is not measured on this system."


@dataclass(frozen=True)
class Cost:
    """What something took.

    Attributes:
        seconds: by the clock on the wall.
        memory: highest resident memory above that at the start, in bytes; None where it cannot be measured.
        peak: highest resident memory of the process, in bytes, or None.
    """

    seconds: float
    memory: int | None = None
    peak: int | None = None

    def __add__(self, other: Cost) -> Cost:
        """What two parts of one stage took, with other work between them; the memory of the first may have stayed.

        >>> Cost(1.0, 10, 110) + Cost(2.0, 5, 120)
        Cost(seconds=3.0, memory=15, peak=120)
        """
        memory = None if self.memory is None or other.memory is None else self.memory + other.memory
        peaks = [peak for peak in (self.peak, other.peak) if peak is not None]
        return Cost(self.seconds + other.seconds, memory, max(peaks, default=None))


class Meter:
    """Measures from one lap to the next; the first begins when it is made."""

    def __init__(self):
        self._begin()

    def lap(self) -> Cost:
        """What the time since the lap before took."""
        seconds = time.perf_counter() - self._started
        peak = _highest()
        cost = Cost(seconds, None if self._memory is None or peak is None else max(peak - self._memory, 0), peak)
        self._begin()
        return cost

    def _begin(self) -> None:
        self._memory = _resident() if _set_back() else _highest()
        self._started = time.perf_counter()


class Costs:
    """Costs by name, of laps that follow one another."""

    def __init__(self):
        self.by_name: dict[str, Cost] = {}
        self._meter = Meter()

    def lap(self, name: str) -> None:
        """Count the time since the lap before for a name."""
        cost = self._meter.lap()
        self.by_name[name] = self.by_name[name] + cost if name in self.by_name else cost


def memory_note() -> str:
    """How memory is measured on this system, in a sentence."""
    if _set_back() and _resident() is not None:
        return OWN_PEAK
    return NOT_MEASURED if _highest() is None else GROWTH


def _set_back() -> bool:
    """Whether the highest resident memory could be set back to the present one."""
    try:
        with open(_CLEAR, "w", encoding="ascii") as file:
            file.write(_SET_BACK)
    except OSError:
        return False
    return True


def _resident() -> int | None:
    return _status("VmRSS:")


def _highest() -> int | None:
    """The highest resident memory since it was set back, or else since the process began."""
    found = _status("VmHWM:")
    return _largest_ever() if found is None else found


def _status(key: str) -> int | None:
    """An entry in bytes."""
    try:
        with open(_STATUS, encoding="utf-8") as file:
            return next((1024 * int(line.split()[1]) for line in file if line.startswith(key)), None)
    except (OSError, ValueError, IndexError):
        return None


def _largest_ever() -> int | None:
    try:
        import resource
    except ImportError:  # Windows
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _UNIT_OF_GROWTH
