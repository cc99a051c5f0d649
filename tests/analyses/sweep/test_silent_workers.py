"""Samples that never end, workers that are stopped or have other code: each is named, and the other samples have their right values."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep import execution
from mbconstrained.analyses.sweep.evaluation import TIMED_OUT, Job
from tests.analyses.sweep.interrupted import ENVIRONMENT, SCENE, bytes_of, cluster, scene_file


@pytest.fixture
def study(tmp_path):
    """Eight samples in four chunks."""
    scene = mb.read_scene(scene_file(tmp_path, SCENE))
    return scene.sweep({"k": mb.linspace("90 N/m", "110 N/m", 8)}, keep=["frequencies"], chunk=2)


#: The sample of k = 100 N/m never ends, in the processes of workers, which import this instead of the package's own program.
ENDLESS = """
import time
from mbconstrained.analyses.sweep import execution
whole = execution.evaluate
def evaluate(job, rows):
    while any(abs(row["k"] - {k!r}) < 1e-9 for row in rows):
        time.sleep(1)
    return whole(job, rows)
execution.evaluate, execution._PROGRAM = evaluate, {program!r}
execution.serve()
"""


@pytest.mark.parametrize("workers", [None, pytest.param(2, marks=pytest.mark.long)], ids=["alone", "workers"])
def test_an_endless_sample_is_timed_out_and_the_others_are_not(study, tmp_path, monkeypatch, workers):
    """The limit is far beyond the milliseconds of a sample, and the endless one exceeds every limit."""
    expected = study.run().values("frequency")
    k = float(study.samples.column("k")[3])
    program = f"exec(open({str(tmp_path / 'endless.py')!r}).read())"
    (tmp_path / "endless.py").write_text(ENDLESS.format(k=k, program=program))
    monkeypatch.setattr(execution, "_PROGRAM", program)
    result = study.run(store=tmp_path / "k.zarr", workers=workers, sample_timeout=6.0)
    status = result.chunks.read("status").tolist()
    assert status == [1, 1, 1, TIMED_OUT, 1, 1, 1, 1] and result.failures == {3: "timed out: it takes longer than 6 s"}
    others = np.arange(8) != 3
    assert np.isnan(result.values("frequency")[3]).all()
    assert np.allclose(result.values("frequency")[others], expected[others], rtol=1e-13)


def test_a_limit_that_nobody_exceeds_changes_no_bit(study, tmp_path):
    study.run(store=tmp_path / "free.zarr")
    study.run(store=tmp_path / "limited.zarr", sample_timeout=300.0)
    assert bytes_of(tmp_path / "free.zarr") == bytes_of(tmp_path / "limited.zarr")


def test_the_process_of_an_endless_sample_ends_with_the_run(tmp_path):
    """It watches who has started it."""
    script = "import sys, time; from mbconstrained.analyses.sweep import execution as e; import os, threading; "
    child = (
        script
        + "threading.Thread(target=e._end_with, args=(os.getppid(),), daemon=True).start(); print(os.getpid(), flush=True); time.sleep(600)"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])"],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
    )
    own = int(parent.stdout.readline())
    parent.kill()
    parent.wait()
    parent.stdout.close()
    limit = time.monotonic() + 60
    while Path(f"/proc/{own}").exists() and "Z" not in Path(f"/proc/{own}/stat").read_text().rpartition(")")[2].split()[0]:
        assert time.monotonic() < limit
        time.sleep(0.1)


@pytest.mark.long
def test_a_stopped_dask_worker_is_named_and_its_chunk_is_done_by_the_other_and_other_code_is_refused(study, tmp_path, monkeypatch):
    """It is stopped during a run, whose other worker may be done before anybody misses it, and before another run."""
    pytest.importorskip("distributed")
    study.run(store=tmp_path / "expected.zarr")
    monkeypatch.setattr(execution, "SILENCE", 4.0)
    said, messages = "has not answered for 4 s; others compute its chunk", {"during": [], "before": []}
    with cluster(tmp_path) as workers:
        stopped = workers.workers[0].pid

        def run(name, progress=None):
            try:
                study.run(store=tmp_path / name, dask=workers.address, progress=progress, message=messages[name].append)
            finally:
                os.kill(stopped, signal.SIGCONT)
            assert bytes_of(tmp_path / name) == bytes_of(tmp_path / "expected.zarr")

        run("during", lambda done, count: os.kill(stopped, signal.SIGSTOP) if done == 1 else None)
        study.run(dask=workers.address)  # both are there again
        os.kill(stopped, signal.SIGSTOP)
        run("before")
        monkeypatch.setattr(execution, "CODE", "0" * 64)
        with pytest.raises(mb.InputError, match="has other code of the package mbconstrained, perhaps under the same version"):
            study.run(dask=workers.address)
    assert said in messages["before"][0] and (not messages["during"] or said in messages["during"][0])


def test_a_chunk_of_other_code_is_refused_by_the_worker_itself():
    """Also one that joins the cluster while the study runs."""
    with pytest.raises(mb.InputError, match="has other code of the package"):
        execution.evaluate_there(Job("", {}, {}, {}, ()), [], {}, "0" * 64, None)


def test_the_hash_of_the_code_is_that_of_all_its_files():
    """Computed here in another way, from the list of files that is shipped."""
    from hashlib import sha256

    root = Path(mb.__file__).parent
    names = sorted(str(path.relative_to(root)) for path in root.glob("**/*.py"))
    assert execution.CODE == execution._hash_of_code() and len(names) > 200
    text = b"".join(
        name.encode() + b"\0" + (root / name).read_bytes() + b"\0"
        for name in sorted(names, key=lambda name: Path(name).parts)
        if not name.startswith("docs")
    )
    assert execution.CODE == sha256(text).hexdigest()


def test_a_large_study_says_how_large_it_is_before_it_begins(tmp_path, monkeypatch):
    """Of ten million samples only the rows of a chunk are made at a time; a list of all numbers for each chunk took 26 min."""
    scene = mb.read_scene(scene_file(tmp_path, SCENE))
    study = scene.sweep({"k": "normal(100 N/m, 5 %)"}, samples=10_000_000, keep=["frequencies"])
    messages, calls = [], []

    class Enough(Exception):
        pass

    def progress(done, count):
        calls.append((done, count))
        if done:
            raise Enough

    with pytest.raises(Enough):
        study.run(progress=progress, message=messages.append)
    assert (
        messages[0] == "10,000,000 samples in 39,063 chunks, 0 of them done; 0.41 GB of numbers"
    )  # 8 B of k and 4 figures, 1 B of status
    assert messages[1].startswith("the first chunk took ") and messages[1].endswith(" h of one process") and len(messages) == 2
    assert calls == [(0, 39063), (1, 39063)]
    large = scene.sweep({"k": "normal(100 N/m, 5 %)"}, samples=10_000_000, keep=["curve a"])
    with pytest.raises(mb.InputError, match="10000000 samples need 8.17 GB of memory; give a store, or keep less"):
        large.run()


def test_a_run_waits_for_a_cluster_that_does_not_answer_at_first(monkeypatch):
    pytest.importorskip("distributed")
    answers = iter([set(), {"worker"}])

    class Workers:
        silent = frozenset()

        def __init__(self, *_):
            pass

        def check(self, distributed):
            pass

        def answering(self):
            return next(answers, {"worker"})

    class Future:
        def __init__(self, rows):
            self.rows = rows

        def result(self, timeout):
            return self.rows

    class Client:
        def submit(self, function, job, rows, *_, **options):
            return Future(rows)

    monkeypatch.setattr(execution, "_DaskWorkers", Workers)
    monkeypatch.setattr(execution, "_client", lambda *_: Client())
    monkeypatch.setattr(execution, "_done", lambda distributed, client, futures, address: futures)
    chunks = [(0, ["first"]), (1, ["second"])]
    assert list(execution.by_dask(None, iter(chunks), "address", {})) == chunks
