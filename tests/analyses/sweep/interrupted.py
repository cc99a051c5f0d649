"""Studies in processes of their own, which tests kill; and a Dask cluster of a real scheduler with two workers."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[3]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}

SCENE = """
[parameters]
k = "100 N/m"
m = "1 kg"

[model]
kind = "lumped"
[[model.mass]]
name = "a"
mass = "=m"
[[model.mass]]
name = "b"
mass = "2 kg"
[[model.spring]]
name = "left"
between = ["ground", "a"]
stiffness = "=k"
[[model.spring]]
name = "right"
between = ["a", "b"]
stiffness = "150 N/m"
[[model.damper]]
name = "damper"
between = ["ground", "b"]
damping = "0.5 N*s/m"

[initial]
displacement = { a = "1 mm" }

[time]
end = "2 s"
points = 101
"""

#: Chunks of eight samples, each of which takes some tenths of a second.
VARIED = ("--vary", "k=normal(100 N/m, 5 %)", "--vary", "m=0.5..2 kg:4", "--samples", "24")
ARGUMENTS = (*VARIED, "--keep", "frequencies", "--keep", "peak b")
CHUNKS = 12


def scene_file(folder: Path, text: str = SCENE) -> Path:
    path = folder / "pair.toml"
    path.write_text(text, encoding="utf-8")
    return path


def started(scene: Path, store: Path, *arguments: str) -> subprocess.Popen:
    files = ("--store", str(store), "--out", str(scene.parent / "out"))
    command = [sys.executable, "-m", "mbconstrained", "sweep", str(scene), *ARGUMENTS, *files, *arguments]
    return subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def completed(scene: Path, store: Path, *arguments: str) -> str:
    run = started(scene, store, *arguments)
    output, errors = run.communicate(timeout=300)
    assert run.returncode == 0, errors
    return output


def chunks(store: Path) -> list[str]:
    """The chunks whose status is stored."""
    return [path.name for path in (store / "status").glob("[0-9]*") if path.name.isdecimal()] if store.exists() else []


def wait_for_chunks(run: subprocess.Popen, store: Path, count: int) -> None:
    """Wait until so many chunks are stored."""
    limit = time.monotonic() + 120
    while len(chunks(store)) < count:
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < limit
        time.sleep(0.01)


def children(process: subprocess.Popen) -> list[int]:
    """The processes that a process started."""
    return [int(one) for task in Path(f"/proc/{process.pid}/task").iterdir() for one in (task / "children").read_text().split()]


def kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)


def bytes_of(store: Path) -> dict[str, bytes]:
    """All files of a store by name."""
    return {str(path.relative_to(store)): path.read_bytes() for path in sorted(store.rglob("*")) if path.is_file()}


class Cluster:
    """A scheduler with workers."""

    def __init__(self, scheduler: subprocess.Popen, workers: list[subprocess.Popen], address: str):
        self.scheduler, self.workers, self.address = scheduler, workers, address


@contextmanager
def cluster(folder: Path, workers: int = 2):
    """A scheduler in a process of its own with so many worker processes of two threads each."""
    file = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": ENVIRONMENT, "cwd": folder}
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", "--no-dashboard"]
    processes = [subprocess.Popen([*dask, "--scheduler-file", str(file)], **quiet)]
    try:
        limit = time.monotonic() + 60
        while not file.exists() or not file.read_text():
            assert time.monotonic() < limit
            time.sleep(0.05)
        import json

        address = json.loads(file.read_text())["address"]
        worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "2", "--no-nanny", "--no-dashboard"]
        processes += [subprocess.Popen([*worker, "--local-directory", str(folder / f"w{i}")], **quiet) for i in range(workers)]
        yield Cluster(processes[0], processes[1:], address)
    finally:
        for process in processes[::-1]:
            process.kill()
            process.wait()
