"""The plan: every possible stage of a scene, needed or omitted, with the reason and, after a run, its cost in seconds and memory.

Linux keeps the highest resident memory of a process and allows resetting it, so that each stage has a peak of its own.
Elsewhere only the peak since the start of the process is known, which grows where a stage exceeds all before, or nothing at all.
A measurement takes some 0.1 ms and never fails.
"""

from __future__ import annotations

import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

from ...ground.checks import counted
from ...ground.display import TextTable

#: Written into this file, "5" sets the highest resident memory back to the present one (man proc_pid_clear_refs).
_CLEAR, _SET_BACK = "/proc/self/clear_refs", "5"
_STATUS = "/proc/self/status"
_RESIDENT = re.compile(r"^(VmHWM|VmRSS):\s*(\d+)", re.MULTILINE)

#: Bytes per unit of ru_maxrss: macOS counts bytes, all others kilobytes (man getrusage).
_UNIT_OF_GROWTH = 1 if sys.platform == "darwin" else 1024

OWN_PEAK = "Memory is the highest resident memory during a stage above that at its start, with what it imports."
GROWTH = "Memory is by how much a stage raised the highest resident memory of the process; 0 where an earlier one needed more."
NOT_MEASURED = "Memory is not measured on this system."


@dataclass(frozen=True)
class Cost:
    """Cost of a stage."""

    seconds: float  # wall-clock time
    memory: int | None = None  # highest resident memory above that at the start, in bytes; None where it cannot be measured
    peak: int | None = None  # highest resident memory of the process, in bytes, or None

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
        highest, now = _resident()
        self._memory, self._started = highest if now is None else now, time.perf_counter()

    def lap(self, name: str) -> Cost:
        """Add the time since the previous lap to a name; return the cost of this lap."""
        seconds, (peak, now) = time.perf_counter() - self._started, _resident()
        cost = Cost(seconds, None if self._memory is None or peak is None else max(peak - self._memory, 0), peak)
        self.by_name[name] = self.by_name[name] + cost if name in self.by_name else cost
        self._memory, self._started = peak if now is None else now, time.perf_counter()
        return cost


def memory_note() -> str:
    """Description of the measurement of memory on this system."""
    highest, now = _resident()
    return OWN_PEAK if now is not None else NOT_MEASURED if highest is None else GROWTH


def _resident() -> tuple[int | None, int | None]:
    """The highest resident memory since the last call, or else since the start of the process, and the present one, to which the highest
    is set back, in bytes; None where that is not possible."""
    try:
        with open(_STATUS, encoding="utf-8") as file:
            sizes = {key: 1024 * int(kilobytes) for key, kilobytes in _RESIDENT.findall(file.read())}
        with open(_CLEAR, "w", encoding="ascii") as file:
            file.write(_SET_BACK)
        return sizes["VmHWM"], sizes["VmRSS"]
    except (OSError, ValueError, KeyError):
        try:
            import resource
        except ImportError:  # Windows
            return None, None
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * _UNIT_OF_GROWTH, None


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


#: The stage that lists the others.
PAGE = "page"

#: Instead of a number that is not known.
NOTHING = "–"


@dataclass(frozen=True)
class Stage:
    """Stage of the computation."""

    name: str  # name of the stage
    needed: bool  # whether this scene needs it
    # the reason for needing or omitting it, or a function that returns it: some take an analysis of their own
    because: str | Callable[[], str]
    cost: Cost | None = None  # time and memory, once it has run
    part_of: str = ""  # the stage that contains it, including its cost, or an empty string

    @property
    def reason(self) -> str:
        """The reason for needing or omitting it."""
        return self.because if isinstance(self.because, str) else self.because()

    @property
    def seconds(self) -> float | None:
        """Run time in s, once it has run."""
        return self.cost and self.cost.seconds

    @property
    def memory(self) -> int | None:
        """Highest resident memory above that at its start, in bytes; None where it has not run or it is not measured."""
        return self.cost and self.cost.memory


@dataclass(frozen=True)
class Plan:
    """The stages of a scene in the order in which they run."""

    stages: tuple[Stage, ...]  # all of them, needed or left out

    @property
    def needed(self) -> tuple[Stage, ...]:
        """The stages that run."""
        return tuple(stage for stage in self.stages if stage.needed)

    @property
    def left_out(self) -> tuple[Stage, ...]:
        """The stages that do not run."""
        return tuple(stage for stage in self.stages if not stage.needed)

    @property
    def costs(self) -> dict[str, Cost]:
        """The cost of each stage that has run, by name."""
        return {stage.name: stage.cost for stage in self.stages if stage.cost}

    @property
    def total(self) -> Cost:
        """The cost of all stages that have run; memory above that at the start of the first."""
        costs = [stage.cost for stage in self.stages if stage.cost]
        peak = max((cost.peak for cost in costs if cost.peak is not None), default=None)
        known = peak is not None and costs[0].memory is not None
        memory = max(peak - (costs[0].peak - costs[0].memory), 0) if known else None
        return Cost(sum(cost.seconds for cost in costs), memory, peak)

    def with_costs(self, costs: Mapping[str, Cost]) -> Plan:
        """The plan with the costs of stages by name."""
        return Plan(tuple(replace(stage, cost=costs[stage.name]) if stage.name in costs else stage for stage in self.stages))

    def to_list(self) -> list[dict]:
        return [
            {"name": stage.name, "taken": stage.needed, "reason": stage.reason, "seconds": stage.seconds, "memory": stage.memory}
            | ({"part_of": stage.part_of} if stage.part_of else {})
            for stage in self.stages
        ]

    def totals_to_dict(self) -> dict:
        """The cost of all stages as plain data."""
        return {"taken": len(self.needed), "left_out": len(self.left_out), **vars(self.total)}

    def totals(self) -> str:
        """The cost of all stages in a line."""
        ran = sum(stage.needed and (stage.cost is not None or bool(stage.part_of)) for stage in self.stages)
        cost = self.total
        memory = "" if cost.memory is None else f", {cost.memory / 1e6:.1f} MB of memory"
        return f"{counted(ran, 'stage')} in {cost.seconds:.3g} s{memory}; {sum(not stage.needed for stage in self.stages)} left out"

    def table(self) -> TextTable:
        """Needed stages first, in the order in which they run."""
        rows = [("taken", stage.name, stage.reason) for stage in self.needed]
        rows += [("left out", stage.name, stage.reason) for stage in self.left_out]
        return TextTable("Plan", ("", "stage", "reason"), tuple(rows))

    def cost_tables(self) -> tuple[TextTable, TextTable]:
        """The cost of each stage that ran and of all together, and the stages that did not run."""
        all_stages, rows = self.total, []
        for stage in self.needed:
            share = NOTHING if stage.cost is None else f"{100 * stage.cost.seconds / all_stages.seconds:.1f} %"
            seconds, memory = _cells(stage.cost)
            rows.append((stage.name, seconds, share, memory, _reason(stage)))
        seconds, memory = _cells(all_stages)
        rows.append(("all", seconds, "100 %", memory, "highest above the start of the first"))
        columns = ("stage", "time (ms)", "share", "memory (MB)", "reason")
        left_out = tuple((stage.name, stage.reason) for stage in self.left_out)
        return TextTable("Taken", columns, tuple(rows), memory_note()), TextTable("Left out", ("stage", "reason"), left_out)

    def page_table(self) -> TextTable:
        """The plan on the page, without times and memory: the same scene gives the same page."""
        needed = [stage for stage in self.needed if stage.name != PAGE]
        left_out = [stage for stage in self.left_out if stage.name != PAGE]
        rows = [*(("taken", stage.name, _reason(stage)) for stage in needed), ("taken", PAGE, "this page")]
        title = f"Plan: {counted(len(rows), 'stage')} taken, {len(left_out)} left out"
        rows += [("left out", stage.name, stage.reason) for stage in left_out]
        return TextTable(title, ("", "stage", "reason"), tuple(rows), folded=True)


def _reason(stage: Stage) -> str:
    return f"{stage.reason} (in: {stage.part_of})" if stage.part_of else stage.reason


def _cells(cost: Cost | None) -> tuple[str, str]:
    """Milliseconds and megabytes."""
    seconds, memory = (cost.seconds, cost.memory) if cost else (None, None)
    return NOTHING if seconds is None else f"{1e3 * seconds:.1f}", NOTHING if memory is None else f"{memory / 1e6:.1f}"
