"""A limit on work whose length nobody can tell beforehand."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


#: An alarm that strikes in a finalizer, from which nothing can be raised, is lost: it is rung again after so many seconds.
AGAIN = 1.0


class OutOfTime(BaseException):
    """The time is over; no Exception, so that nothing in between takes it for a problem of its own."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Break off what is done inside after so many seconds.

    Where there are no alarms (in threads, on Windows) there is no limit either.

    Raises:
        OutOfTime: it took longer.

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
