"""Who computes chunks: this process, processes of this machine, or the workers of a Dask cluster; the results are the same bits.

Nobody has more than one chunk, and gets the next one when the last was kept, so that an interruption costs at most one chunk each.
"""

from __future__ import annotations

import asyncio
import os
import platform
import subprocess
import sys
import time
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from functools import cache
from hashlib import sha256
from multiprocessing.connection import Client, Listener, wait
from pathlib import Path
from threading import Event, Lock, Thread
from typing import Any, cast

import numpy as np

from ...ground.checks import optional_package
from ...ground.errors import InputError, MbconstrainedError
from .evaluation import Job, evaluate
from .store import files_of

#: A chunk: its number and the values of its samples.
Chunk = tuple[int, list[dict[str, Any]]]
Answers = Generator[tuple[int, dict[str, np.ndarray]], None, None]

#: A cluster that does not answer for so long is given up, s.
PATIENCE = 10.0

#: Seconds in which a scheduler is to answer.
CONNECTING = 5.0

#: A chunk whose worker ends so often is not tried again.
MOST_LOSSES = 2

_PACKAGE = Path(__file__).parents[3]
_PROGRAM = "from mbconstrained.studies.sweep.execution import serve; serve()"
_ONE_CHUNK = Lock()


def in_process(job: Job, chunks: Iterator[Chunk]) -> Answers:
    """Compute chunks one after the other.

    Args:
        job: the scene.
        chunks: what is to be computed.

    Yields:
        Chunks as they are done.
    """
    for number, rows in chunks:
        yield number, evaluate(job, rows)


def by_processes(job: Job, chunks: Iterator[Chunk], workers: int) -> Answers:
    """Compute chunks in processes with one thread of linear algebra each. One that ends early is replaced, and its chunk is done again.

    Args:
        job: the scene.
        chunks: what is to be computed.
        workers: number of processes.

    Yields:
        Chunks as they are done.

    Raises:
        MbconstrainedError: a chunk ended its process twice.
    """
    key = os.urandom(32)
    with ExitStack() as stack:
        listener = stack.enter_context(closing(Listener(authkey=key)))
        busy: dict[Any, Chunk] = {}
        losses: dict[int, int] = {}
        waiting: list[Chunk] = []

        def give(connection) -> None:
            chunk = waiting.pop() if waiting else next(chunks, None)
            if chunk is None:
                return
            try:
                connection = connection or stack.enter_context(closing(_worker(listener, key, job, stack)))
                connection.send(chunk[1])
            except (EOFError, OSError):  # it ended while it had nothing to do
                lose(chunk)
            else:
                busy[connection] = chunk

        def lose(chunk: Chunk) -> None:
            losses[chunk[0]] = losses.get(chunk[0], 0) + 1
            if losses[chunk[0]] >= MOST_LOSSES:
                raise MbconstrainedError(
                    f"the process that computed chunk {chunk[0] + 1} ended twice, perhaps for lack of memory; give fewer workers or a "
                    "smaller chunk"
                )
            waiting.append(chunk)
            give(None)

        for _ in range(workers):
            give(None)
        while busy:
            for ready in cast(list, wait(list(busy))):
                chunk = busy.pop(ready)
                try:
                    answer = ready.recv()
                except (EOFError, OSError):
                    lose(chunk)
                    continue
                if isinstance(answer, BaseException):
                    raise answer
                yield chunk[0], answer
                give(ready)


def _worker(listener: Listener, key: bytes, job: Job, stack: ExitStack):
    """A new process, which ends when its connection does."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    path = os.pathsep.join(filter(None, (str(_PACKAGE), os.environ.get("PYTHONPATH", ""))))
    process = subprocess.Popen(
        [sys.executable, "-c", _PROGRAM, str(listener.address)],
        stdin=subprocess.PIPE,
        env={**os.environ, **threads, "PYTHONPATH": path},
    )
    stack.callback(_end, process)
    with suppress(BrokenPipeError):  # it has ended already
        process.stdin.write(key)
        process.stdin.close()
    connected = Event()
    Thread(target=_connect_for, args=(process, connected, listener, key), daemon=True).start()
    connection = listener.accept()
    connected.set()
    connection.send(job)
    return connection


def _connect_for(process: subprocess.Popen, connected: Event, listener: Listener, key: bytes) -> None:
    """A connection, closed at once, for a process that has ended without one, so that it is not waited for."""
    process.wait()
    if not connected.is_set():
        with suppress(OSError, EOFError):  # nobody listens any more
            Client(listener.address, authkey=key).close()


def _end(process: subprocess.Popen) -> None:
    process.terminate()
    process.wait()


def serve() -> None:
    """Compute what comes over the connection whose address is the first argument, until it is closed: the program of a worker."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the run itself reports the interruption
    with Client(sys.argv[1], authkey=sys.stdin.buffer.read()) as connection:
        try:
            job = connection.recv()
            while True:
                rows = connection.recv()
                try:
                    answer: Any = evaluate(job, rows)
                except Exception as problem:  # is raised in the run
                    answer = problem
                connection.send(answer)
        except (EOFError, OSError):
            return


def by_dask(job: Job, chunks: Iterator[Chunk], address: str, files: Mapping[str, str]) -> Answers:
    """Compute chunks by the workers of a Dask cluster, one at a time each.

    Args:
        job: the scene.
        chunks: what is to be computed.
        address: of the scheduler.
        files: hashes of the data files, which the workers must have.

    Yields:
        Chunks as they are done.

    Raises:
        InputError: no cluster answers, it has no workers, or they lack the package or have other versions.
        MbconstrainedError: the cluster is lost, or a chunk ended several workers.
    """
    distributed = optional_package("distributed", "a Dask cluster")
    with ExitStack() as stack:
        client = _client(distributed, address, stack)
        workers = _checked_workers(client, address)
        pending: dict[Any, int] = {}

        def give() -> None:
            if (chunk := next(chunks, None)) is not None:
                future = client.submit(evaluate_there, job, chunk[1], files, pure=False, retries=1)
                pending[future] = chunk[0]

        for _ in range(workers):
            give()
        while pending:
            for future in _done(distributed, client, list(pending), address):
                number = pending.pop(future)
                try:
                    answer = future.result(timeout=PATIENCE)
                except MbconstrainedError:
                    raise
                except Exception as problem:  # whatever a worker or the cluster raises, serialized
                    text = f"the cluster at {address} lost chunk {number + 1} ({type(problem).__name__}: {str(problem)[:200]})"
                    raise MbconstrainedError(text) from None
                yield number, answer
                give()


def evaluate_there(job: Job, rows: Sequence[Mapping[str, Any]], files: Mapping[str, str]) -> dict[str, np.ndarray]:
    """As ``evaluate``, one chunk at a time in a worker, whose data files are compared with those of the run.

    Args:
        job, rows: as of ``evaluate``.
        files: hashes by name.

    Returns:
        As ``evaluate``.

    Raises:
        InputError: the worker has not the same files.
    """
    folder = Path(job.path).parent
    for name, known in files.items():
        path = folder / name
        if not _has_content(path, known):
            raise InputError(
                f"the worker {platform.node()} has not the same file {path}; share the folder of the scene with the cluster"
            )
    with _ONE_CHUNK:
        return evaluate(job, rows)


@cache
def _has_content(path: Path, known: str) -> bool:
    return path.is_file() and sha256(path.read_bytes()).hexdigest() == known


def _client(distributed, address: str, stack: ExitStack):
    import logging

    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what it would log is raised here
    try:
        asyncio.run(_reach(distributed, address))  # a Client that reaches none would wait for itself when it is left
        return stack.enter_context(distributed.Client(address, timeout=CONNECTING, set_as_default=False))
    except (OSError, TimeoutError, ValueError, MemoryError) as problem:
        reason = (str(problem).splitlines() or [type(problem).__name__])[0][:160]
        if isinstance(problem, MemoryError):  # other words than those of Dask, read as a length
            reason = "another program answers there"
        raise InputError(
            f"--dask: no Dask cluster answers at {address} within {CONNECTING:g} s ({reason}); give the address of a scheduler"
        ) from None


async def _reach(distributed, address: str) -> None:
    """Connect to a scheduler, and leave."""
    connection = await distributed.comm.connect(address, timeout=CONNECTING)
    await connection.close()


def _checked_workers(client, address: str) -> int:
    """The number of workers, all with this package."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE - 2)
        versions = client.get_versions(packages=["mbconstrained", "numpy", "scipy"])
    except (TimeoutError, OSError):
        raise InputError(f"--dask: the cluster at {address} has no workers; start some with dask worker {address}") from None
    own = versions["client"]["packages"]
    for worker, there in versions["workers"].items():
        for package in ("mbconstrained", "numpy", "scipy"):
            if (installed := there["packages"].get(package)) != own[package]:
                what = "lacks" if installed is None else f"has version {installed} of"
                raise InputError(f"--dask: the worker {worker} {what} the package {package}; install version {own[package]} there")
    return len(versions["workers"])


def _done(distributed, client, futures: list, address: str) -> list:
    """Those that are done; a cluster that is gone for too long is an error."""
    lost = None
    while True:
        try:
            with client.as_current():
                return list(distributed.wait(futures, timeout=1.0, return_when="FIRST_COMPLETED").done)
        except (TimeoutError, OSError):
            if client.status == "running":
                lost = None
                continue
            lost = lost or time.monotonic()
            if client.status == "closed" or time.monotonic() - lost > PATIENCE:
                raise MbconstrainedError(f"the cluster at {address} does not answer any more") from None
        except distributed.CancelledError:
            raise MbconstrainedError(f"the cluster at {address} does not answer any more") from None


def hashes(job: Job, texts: Sequence[str]) -> dict[str, str]:
    """The data files of a job with the hashes of their contents.

    Args:
        job: the scene.
        texts: that are varied, some of which may be names of files.

    Returns:
        Hashes by name relative to the scene.
    """
    return files_of([job.data, dict(job.settings), list(texts)], Path(job.path).parent)
