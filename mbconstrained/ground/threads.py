"""The number of threads of the linear algebra library: one for work that several threads slow down.

The QR algorithm of LAPACK distributes many small tasks over its threads and waits for each: two threads are at best a little
faster than one, and on a busy processor many times slower. This concerns the libraries of NumPy and SciPy, not those that
other packages load.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from functools import cache

#: Below this size the library itself uses one thread.
SMALL = 64

#: Up to this size sequences of products and factorizations are too short for several threads.
SHORT = 1200


@cache
def _libraries():
    import scipy.linalg  # noqa: F401  whose library has a number of threads of its own, and must be there to be found
    from threadpoolctl import ThreadpoolController  # looks through all libraries of the process once

    return ThreadpoolController().select(user_api="blas")


def one_thread(size: int) -> AbstractContextManager:
    """A context with one thread for the QR algorithm on matrices of this size; see ``short_work`` for other work.

    >>> with one_thread(100):
    ...     pass
    """
    if size < SMALL or all(library.num_threads == 1 for library in _libraries().lib_controllers):
        return nullcontext()
    return _libraries().limit(limits=1)


def short_work(size: int) -> AbstractContextManager:
    """A context with one thread where products and factorizations of this size are too short for several.

    >>> with short_work(2000):
    ...     pass
    """
    return one_thread(size if size <= SHORT else 0)
