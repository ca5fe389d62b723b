"""Are rows the same bits with one worker, with two, and on a Dask cluster of worker processes?"""

import os
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest
from small_sweeps import (
    assert_same_rows,
    command,
    rows,
    run,
    summary,
    summary_as_users_do,
    sweep_file,
)

TRIALS = 32


@contextmanager
def cluster(folder):
    """Run a scheduler and two workers of one thread; give the scheduler's address and process."""
    address = folder / "scheduler.json"
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    common = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = [
        subprocess.Popen(
            [sys.executable, "-m", "dask", *words, "--scheduler-file", str(address)],
            cwd=folder,
            **common,
        )
        for words in (
            ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"],
            ["worker", "--nworkers", "2", "--nthreads", "1", "--no-dashboard"],
        )
    ]
    try:
        deadline = time.monotonic() + 60
        while not address.exists():
            assert time.monotonic() < deadline, "no scheduler"
            time.sleep(0.2)
        import json

        yield json.loads(address.read_text())["address"], started[0]
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            process.wait(30)


@pytest.mark.slow
def test_one_worker_two_workers_and_a_cluster(tmp_path):
    pytest.importorskip("distributed", reason="comes with simtip[cluster]")
    file = sweep_file(tmp_path, detectors=["lin2020"])
    found = {}
    for name, workers in (("one", 1), ("two", 2)):
        folder, cache = tmp_path / name, tmp_path / f"cache_of_{name}"
        found[name] = summary_as_users_do(file, folder, "--workers", workers, cache=cache)
    found["here"] = summary(file, tmp_path / "here", cache=tmp_path / "cache_of_here")
    with cluster(tmp_path) as (address, _):
        options = ("--scheduler", address)
        found["dask"] = summary(file, tmp_path / "dask", *options, cache=tmp_path / "cache_of_dask")
    expected = {"light": 2, "images": 8, "measure": TRIALS}
    assert {name: said["worked_out"] for name, said in found.items()} == dict.fromkeys(
        found, expected
    )
    assert len(rows(tmp_path / "one")) == TRIALS
    for name in ("two", "dask", "here"):
        assert_same_rows(tmp_path / name, tmp_path / "one")


@pytest.mark.slow
def test_no_scheduler_is_one_line(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="comes with simtip[cluster]")
    monkeypatch.setattr("simtip.sweep.pool.CONNECT_S", 1)
    file = sweep_file(tmp_path)
    said = run(file, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:1", code=2)
    assert "no scheduler answers at tcp://127.0.0.1:1" in said


@pytest.mark.slow
def test_a_scheduler_that_dies_is_one_line_and_the_sweep_goes_on(tmp_path):
    pytest.importorskip("distributed", reason="comes with simtip[cluster]")
    file, out = sweep_file(tmp_path, repeats=30), tmp_path / "out"
    with cluster(tmp_path) as (address, scheduler):
        options = ("--scheduler", address)
        process = subprocess.Popen(
            command(file, out, *options),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        while not list(out.glob("rows/*.parquet")):
            time.sleep(0.1)
        scheduler.kill()
        said = process.communicate(timeout=120)[1]
    assert process.returncode == 2
    # A slow machine has said before how far it is.
    told = [line for line in said.splitlines() if " renders" not in line]
    assert len(told) == 1
    assert "the cluster gave up" in told[0]
    done = summary(sweep_file(tmp_path, repeats=3), out)
    assert done["found"] > 0
    assert done["found"] + done["done"] == 3 * TRIALS
