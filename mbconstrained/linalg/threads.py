"""How many threads the linear algebra library uses: never more than the user lets it, one where more are in each other's way.

The QR algorithm of LAPACK hands many small pieces of work to its threads and waits for each: with two threads it is at best a
little faster than with one, and where the processor has other work too it is many times slower. Meant are the libraries of
NumPy and SciPy: those that other packages bring and load later are left to them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import cache

#: Smaller problems are not handed to several threads by the library itself.
SMALL = 64

#: Up to this size products and factorizations that follow one another are too short for more than one thread.
SHORT = 1200


@cache
def _libraries():
    import scipy.linalg  # noqa: F401  whose library has a number of threads of its own, and must be there to be found
    from threadpoolctl import ThreadpoolController  # looks through all libraries of the process once

    return ThreadpoolController().select(user_api="blas")


def one_thread(size: int) -> AbstractContextManager[None]:
    """One thread within, for matrices of this size; the setting before is there again afterwards.

    That is for the QR algorithm; for other work see ``short_work``.

    >>> with one_thread(100):
    ...     pass
    """
    return nullcontext() if size < SMALL else _limited()


@contextmanager
def _limited() -> Iterator[None]:
    if all(library.num_threads == 1 for library in _libraries().lib_controllers):
        yield
        return
    with _libraries().limit(limits=1):
        yield


def short_work(size: int) -> AbstractContextManager[None]:
    """One thread within where matrices of this size are too small for more.

    >>> with short_work(2000):
    ...     pass
    """
    return one_thread(size if size <= SHORT else 0)
