"""Whoever is killed, the study goes on: at most one chunk per worker is done again, and the store has the same bytes."""

import signal
from pathlib import Path
from time import monotonic, sleep

import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep import execution
from tests.analyses.sweep.interrupted import (
    CHUNKS,
    bytes_of,
    children,
    chunks,
    cluster,
    completed,
    kill,
    scene_file,
    started,
    wait_for_chunks,
)

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A scene, and the bytes of its finished store."""
    folder = tmp_path_factory.mktemp("whole")
    scene = scene_file(folder)
    completed(scene, folder / "k.zarr")
    return scene, bytes_of(folder / "k.zarr")


def redone(store, before):
    """How many chunks that were stored have been written again: none."""
    return [name for name, time in before.items() if (store / "status" / name).stat().st_mtime_ns != time]


def times(store):
    return {name: (store / "status" / name).stat().st_mtime_ns for name in chunks(store)}


@pytest.mark.parametrize("workers", [(), ("--workers", "2")], ids=["alone", "workers"])
def test_a_killed_run_goes_on(whole, tmp_path, workers):
    scene, expected = whole
    store = tmp_path / "k.zarr"
    run = started(scene, store, *workers)
    wait_for_chunks(run, store, 3)
    own = children(run)
    kill(run.pid)
    run.communicate()
    limit = monotonic() + 30
    while any(Path(f"/proc/{pid}").exists() for pid in own):  # workers end with their run
        assert monotonic() < limit
        sleep(0.05)
    before = times(store)
    assert 3 <= len(before) < CHUNKS
    completed(scene, store, *workers)
    assert redone(store, before) == [] and bytes_of(store) == expected
    assert len(own) == (2 if workers else 0)


def test_a_run_killed_at_its_start_goes_on(whole, tmp_path):
    """Before there is a store, and while it is made."""
    scene, expected = whole
    store = tmp_path / "k.zarr"
    run = started(scene, store)
    while run.poll() is None and not list(tmp_path.glob(".k.zarr*")) and not store.exists():
        pass
    kill(run.pid)
    run.communicate()
    completed(scene, store)
    assert bytes_of(store) == expected
    assert [path.name for path in tmp_path.iterdir()] == ["k.zarr"]


def test_a_killed_worker_is_replaced(whole, tmp_path):
    scene, expected = whole
    store = tmp_path / "k.zarr"
    run = started(scene, store, "--workers", "2")
    wait_for_chunks(run, store, 2)
    kill(children(run)[0])
    _, errors = run.communicate(timeout=300)
    assert run.returncode == 0, errors
    assert bytes_of(store) == expected


def test_an_interrupted_run_says_how_to_go_on(whole, tmp_path):
    scene, _ = whole
    store = tmp_path / "k.zarr"
    run = started(scene, store)
    wait_for_chunks(run, store, 2)
    run.send_signal(signal.SIGINT)
    output, errors = run.communicate(timeout=60)
    assert run.returncode == 130 and output == ""
    assert errors.startswith("interrupted: ") and errors.endswith("of 12 chunks are stored; the same command goes on from there\n")


def test_a_killed_dask_worker_costs_its_chunk(whole, tmp_path):
    pytest.importorskip("distributed")
    scene, expected = whole
    store = tmp_path / "k.zarr"
    with cluster(tmp_path) as workers:
        run = started(scene, store, "--dask", workers.address)
        wait_for_chunks(run, store, 3)
        kill(workers.workers[0].pid)
        _, errors = run.communicate(timeout=300)
        assert run.returncode == 0, errors
    assert bytes_of(store) == expected


def test_a_killed_scheduler_ends_the_run_with_advice(whole, tmp_path):
    pytest.importorskip("distributed")
    scene, _ = whole
    store = tmp_path / "k.zarr"
    with cluster(tmp_path) as workers:
        run = started(scene, store, "--dask", workers.address)
        wait_for_chunks(run, store, 3)
        kill(workers.scheduler.pid)
        _, errors = run.communicate(timeout=60)
    assert run.returncode == 1 and "of 12 chunks are stored; the same command goes on from there" in errors, errors


def test_workers_that_cannot_begin_are_an_error_and_not_waited_for(monkeypatch):
    monkeypatch.setattr(execution, "_PROGRAM", "raise SystemExit(1)")
    with pytest.raises(mb.MbconstrainedError, match="the process that computed chunk 1 ended twice"):
        list(execution.by_processes(None, iter([(0, [])]), workers=2))
