"""Execution backends for chunks, with identical results: this process, local processes, or workers of a Dask cluster.

Each worker holds one chunk at a time, and gets the next one when the last was stored, so that an interruption costs at most one
chunk each.
"""

from __future__ import annotations

import asyncio
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import cache
from hashlib import sha256
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Lock, Thread
from typing import Any, cast

import numpy as np

from ...ground.checks import optional_package
from ...ground.errors import InputError, MbconstrainedError
from ..timing import version_of
from .evaluation import FAILURES, Job, evaluate, without_answer
from .store import files_of

#: A chunk: its number and the values of its samples.
Chunk = tuple[int, list[dict[str, Any]]]
Answers = Generator[tuple[int, dict[str, np.ndarray]], None, None]

#: A cluster that does not answer for so long is given up, s.
PATIENCE = 10.0

#: Seconds in which a scheduler is to answer.
CONNECTING = 5.0

#: A worker of a cluster without a sign of life for so long is given no chunks until it has one; when all are, the run ends later, s.
SILENCE, ABANDONED = 30.0, 300.0

#: A chunk whose worker ends so often is not tried again.
MOST_LOSSES = 2

_PACKAGE = Path(__file__).parents[3]
_PROGRAM = "from mbconstrained.analyses.sweep.execution import serve; serve()"
_ONE_CHUNK = Lock()


def in_process(job: Job, chunks: Iterator[Chunk], seconds: float | None = None) -> Answers:
    with _evaluation(job, seconds) as work:
        for number, rows in chunks:
            yield number, work(rows)


@contextmanager
def _evaluation(job: Job, seconds: float | None) -> Iterator[Callable[[Sequence], dict[str, np.ndarray]]]:
    """A function that computes samples, in a separate process where their time is limited, as computations cannot be stopped."""
    if seconds is None:
        yield lambda rows: evaluate(job, rows)
        return
    with closing(_TimedProcess(job, seconds)) as process:
        yield process.evaluate


class _TimedProcess:
    """A process that computes samples, replaced when one of them takes too long.

    A chunk that is not done in the time of one sample is computed again, each sample alone. Where that happens though none of them is
    too slow, the following chunks are computed in this way from the start.
    """

    def __init__(self, job: Job, seconds: float):
        self.job, self.seconds = job, seconds
        self._stack, self._alone = ExitStack(), False
        self._connection: Any = None

    def evaluate(self, rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
        """Kept quantities of samples; those that take too long have the status TIMED_OUT."""
        if not self._alone and (together := self._within_time(rows)):
            return together
        parts = [self._within_time([row]) for row in rows]
        self._alone = None not in parts
        timed_out = without_answer(self.job, f"timed out: it takes longer than {self.seconds:g} s")
        known = [part or timed_out for part in parts]
        return {name: np.concatenate([part[name] for part in known]) for name in timed_out}

    def close(self) -> None:
        self._stack.close()
        self._connection = None

    def _within_time(self, rows) -> dict[str, np.ndarray] | None:
        try:
            if self._connection is None:
                self._connection = _worker(self.job, None, self._stack)
                self._connection.send(None)  # what takes long only once is not part of a sample's time
                self._connection.recv()
            self._connection.send(rows)
            answer = self._connection.recv() if self._connection.poll(self.seconds) else None
        except (EOFError, OSError):
            self.close()
            raise MbconstrainedError("a process that computed samples ended early, perhaps for lack of memory") from None
        if answer is None:
            self.close()
        if isinstance(answer, BaseException):
            raise answer
        return answer


def by_processes(job: Job, chunks: Iterator[Chunk], workers: int, seconds: float | None = None) -> Answers:
    """Compute chunks in processes with one thread of linear algebra each; lost ones are replaced, and their chunks repeated."""
    with ExitStack() as stack:
        busy: dict[Any, Chunk] = {}
        losses: dict[int, int] = {}
        waiting: list[Chunk] = []

        def give(connection) -> None:
            chunk = waiting.pop() if waiting else next(chunks, None)
            if chunk is None:
                return
            try:
                connection = connection or _worker(job, seconds, stack)
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


def _worker(job: Job, seconds: float | None, stack: ExitStack) -> Connection:
    """The connection to a new process for a job and a time limit per sample, which ends with the connection."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    path = os.pathsep.join(filter(None, (str(_PACKAGE), os.environ.get("PYTHONPATH", ""))))
    connection, other = Pipe()
    stack.enter_context(closing(connection))
    with closing(other):
        process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, str(other.fileno())],
            stdin=subprocess.DEVNULL,
            env={**os.environ, **threads, "PYTHONPATH": path},
            pass_fds=[other.fileno()],
        )
    stack.callback(_end, process)
    connection.send((job, seconds))
    return connection


def _end(process: subprocess.Popen) -> None:
    process.kill()  # it only computes, and one that is stopped does not terminate
    process.wait()


def serve() -> None:
    """Compute the requests from the connection of the number in the first argument, until it is closed: the program of a worker."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the run itself reports the interruption
    Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    with ExitStack() as stack:
        connection = stack.enter_context(Connection(int(sys.argv[1])))
        try:
            job, seconds = connection.recv()
            work = stack.enter_context(_evaluation(job, seconds))
            while True:
                rows = connection.recv()
                try:
                    answer: Any = _prepare(job) if rows is None else work(rows)
                except Exception as problem:  # is raised in the run
                    answer = problem
                connection.send(answer)
        except (EOFError, OSError):
            return


def _end_with(parent: int) -> None:
    """End this process when its parent has ended, even during a computation."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


def _prepare(job: Job) -> str:
    """Import and set up the requirements of the first sample."""
    with suppress(*FAILURES):
        job.scene({}).equations.polynomial_matrix.jordan_pairs()
    return "ready"


def by_dask(
    job: Job,
    chunks: Iterator[Chunk],
    address: str,
    files: Mapping[str, str],
    seconds: float | None = None,
    message: Callable[[str], None] = print,
) -> Answers:
    """Compute chunks by the workers of a Dask cluster, one at a time each; the chunk of a lost or silent worker is reassigned."""
    distributed = optional_package("distributed", "a Dask cluster")
    with ExitStack() as stack:
        client = _client(distributed, address, stack)
        workers = _DaskWorkers(client, address, message)
        workers.check(distributed)
        pending: dict[Any, tuple[Chunk, str]] = {}
        waiting: list[Chunk] = []
        losses: dict[int, int] = {}
        following = next(chunks, None)
        while pending or waiting or following:  # also while no worker answers
            answering = workers.answering()
            for future, (chunk, worker) in list(pending.items()):
                if worker not in answering:
                    del pending[future]
                    client.cancel([future])
                    waiting.append(chunk)
                    losses[chunk[0]] = losses.get(chunk[0], 0) + (worker not in workers.silent)
            for number, count in losses.items():
                if count >= MOST_LOSSES:
                    raise MbconstrainedError(
                        f"the cluster at {address} lost chunk {number + 1} with its worker {MOST_LOSSES} times"
                    )
            for worker in sorted(answering - {worker for _, worker in pending.values()}):
                if waiting:
                    chunk = waiting.pop()
                elif following:
                    chunk, following = following, next(chunks, None)
                else:
                    break
                arguments = (job, chunk[1], files, CODE, seconds)
                pending[client.submit(evaluate_there, *arguments, pure=False, workers=[worker])] = chunk, worker
            for future in _done(distributed, client, list(pending), address):
                chunk, _ = pending.pop(future)
                try:
                    answer = future.result(timeout=PATIENCE)
                except MbconstrainedError:
                    raise
                except TimeoutError:  # its worker has it, and is silent
                    waiting.append(chunk)
                    continue
                except Exception as problem:  # whatever a worker or the cluster raises, serialized
                    text = f"the cluster at {address} lost chunk {chunk[0] + 1} ({type(problem).__name__}: {str(problem)[:200]})"
                    raise MbconstrainedError(text) from None
                yield chunk[0], answer


class _DaskWorkers:
    """The workers of a cluster that respond."""

    def __init__(self, client, address: str, message: Callable[[str], None]):
        self._client, self._address, self._message = client, address, message
        self.silent: set[str] = set()  # the addresses of the others
        self._signs: dict[
            str, tuple[float, float]
        ] = {}  # the time of the last sign on the scheduler's clock, and when it was noticed
        self._polled, self._last_answer = -np.inf, time.monotonic()

    def check(self, distributed) -> None:
        """Compare packages and code of the workers with those of this process."""
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE - 2)
        except (TimeoutError, OSError):
            text = f"--dask: the cluster at {self._address} has no workers; start some with dask worker {self._address}"
            raise InputError(text) from None
        submit = self._client.submit
        answers = {submit(versions_there, pure=False, workers=[worker]): worker for worker in sorted(self.answering())}
        with suppress(TimeoutError), self._client.as_current():
            distributed.wait(list(answers), timeout=SILENCE)
        for answer, worker in answers.items():
            if answer.done():
                _check_versions(worker, answer)

    def answering(self) -> set[str]:
        """The addresses of workers that responded within the last second."""
        now = time.monotonic()
        if now - self._polled >= 1.0:
            self._polled = now
            with suppress(TimeoutError, OSError):  # a scheduler that is lost shows in other ways
                identity = self._client.sync(self._client.scheduler.identity, callback_timeout=PATIENCE)
                heartbeats = {worker: one["last_seen"] for worker, one in identity["workers"].items()}
                before, now = self._signs, time.monotonic()
                self._signs = {
                    worker: before[worker] if worker in before and before[worker][0] == sign else (sign, now)
                    for worker, sign in heartbeats.items()
                }
        silent = {worker for worker, (_, noticed) in self._signs.items() if now - noticed > SILENCE}
        for worker in sorted(silent - self.silent):
            self._message(f"the worker {worker} has not answered for {SILENCE:g} s; others compute its chunk, and it gets no more")
        for worker in sorted((self.silent - silent) & set(self._signs)):
            self._message(f"the worker {worker} answers again")
        self.silent = silent
        answering = set(self._signs) - silent
        if answering:
            self._last_answer = now
        elif now - self._last_answer > ABANDONED:
            raise MbconstrainedError(f"no worker of the cluster at {self._address} answers any more")
        return answering


def _check_versions(worker: str, answer) -> None:
    own = versions_there()
    try:
        there = answer.result(timeout=PATIENCE)
    except TimeoutError:
        return  # it is silent now, and each chunk is checked as well
    except ImportError:
        raise InputError(f"--dask: the worker {worker} lacks the package mbconstrained; install it there") from None
    except Exception:  # what unpickling raises where the package has no such function
        there = {**own, _CODE: ""}
    for package, version in own.items():
        if package != _CODE and there[package] != version:
            text = f"has version {there[package]} of the package {package}; install version {version} there"
            raise InputError(f"--dask: the worker {worker} {text}")
    if there[_CODE] != CODE:
        raise InputError(_other_code(worker))


def _other_code(worker: str) -> str:
    return f"--dask: the worker {worker} has other code of the package mbconstrained, perhaps under the same version; install the same there, and start it again"


def versions_there() -> dict[str, str]:
    """Versions of the numerical packages and the hash of the code of this package, in the calling process."""
    return {**{name: version_of(name) for name in ("numpy", "scipy")}, _CODE: CODE}


def _hash_of_code() -> str:
    """SHA-256 of the names and contents of the source files of this package, except its documentation, which is not installed."""
    root, digest = Path(__file__).parents[2], sha256()
    for file in sorted(root.rglob("*.py")):
        name = file.relative_to(root).as_posix()
        if not name.startswith("docs/"):
            digest.update(name.encode() + b"\0" + file.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return digest.hexdigest()


_CODE = "code"

#: The hash of the code that is imported: files may change while a worker runs.
CODE = _hash_of_code()


def evaluate_there(
    job: Job, rows: Sequence[Mapping[str, Any]], files: Mapping[str, str], code: str, seconds: float | None
) -> dict[str, np.ndarray]:
    """Evaluate a chunk in a worker, after comparing its code and data files with those of the run."""
    if code != CODE:
        raise InputError(_other_code(platform.node()))
    folder = Path(job.path).parent
    for name, known in files.items():
        path = folder / name
        if not _has_content(path, known):
            raise InputError(
                f"the worker {platform.node()} has not the same file {path}; share the folder of the scene with the cluster"
            )
    with _ONE_CHUNK, _evaluation(job, seconds) as work:
        return work(rows)


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
    """Connect to a scheduler and disconnect."""
    connection = await distributed.comm.connect(address, timeout=CONNECTING)
    await connection.close()


def _done(distributed, client, futures: list, address: str) -> list:
    """Futures that finish within a second; a cluster that is lost for too long is an error."""
    if not futures:
        time.sleep(1.0)
    start = time.monotonic()
    while futures:
        try:
            with client.as_current():
                return list(distributed.wait(futures, timeout=1.0, return_when="FIRST_COMPLETED").done)
        except (TimeoutError, OSError):
            if client.status == "running":
                break
            if client.status == "closed" or time.monotonic() - start > PATIENCE:
                raise MbconstrainedError(f"the cluster at {address} does not answer any more") from None
        except distributed.CancelledError:
            raise MbconstrainedError(f"the cluster at {address} does not answer any more") from None
    return []


def hashes(job: Job, texts: Sequence[str]) -> dict[str, str]:
    """The data files of a job with the hashes of their contents."""
    return files_of([job.data, dict(job.settings), list(texts)], Path(job.path).parent)
