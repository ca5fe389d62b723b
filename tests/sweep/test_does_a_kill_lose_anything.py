"""Does a kill lose a row, double one, or spoil the cache? With real kills of real processes."""

import os
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from small_sweeps import assert_same_rows, command, rows, run, summary, sweep_file

KILLS = int(os.environ.get("SIMTIP_KILLS", "3"))
"""Of the whole group, and as many of single workers."""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A sweep file, and its rows when nothing goes wrong."""
    folder = tmp_path_factory.mktemp("undisturbed")
    file = sweep_file(folder, repeats=3)
    said = summary(file, folder / "out", "--workers", 2, cache=folder / "cache")
    assert said["done"] == 96
    return file, folder / "out"


def started(file, out, cache):
    return subprocess.Popen(
        command(file, out, "--workers", 2, cache=cache),
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def workers_of(process):
    """Give the processes that a sweep started."""
    proc = Path("/proc")
    try:
        children = (proc / f"{process.pid}/task/{process.pid}/children").read_text().split()
        return [
            int(child)
            for child in children
            if b"spawn_main" in (proc / child / "cmdline").read_bytes()
        ]
    except OSError:  # it ended meanwhile
        return []


@pytest.mark.slow
def test_of_the_whole_process_group(undisturbed, tmp_path):
    file, expected = undisturbed
    rng = np.random.default_rng(1)
    out, cache = tmp_path / "out", tmp_path / "cache"
    for _ in range(KILLS):
        process = started(file, out, cache)
        with suppress(subprocess.TimeoutExpired):  # what has ended need not be waited for
            process.wait(rng.uniform(1, 12))
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        if (out / "table.json").exists():
            rows(out)  # readable at any time
    said = summary(file, out, "--workers", 2, cache=cache)
    assert said["found"] + said["done"] == 96
    assert_same_rows(out, expected)


@pytest.mark.slow
def test_of_a_worker(undisturbed, tmp_path):
    file, expected = undisturbed
    rng = np.random.default_rng(2)
    out, cache = tmp_path / "out", tmp_path / "cache"
    killed = begun = 0
    process = started(file, out, cache)
    while killed < KILLS:
        time.sleep(rng.uniform(0.5, 4))
        if process.poll() is not None:  # it came to its end meanwhile: from the beginning
            assert process.returncode == 0
            begun += 1
            out, cache = tmp_path / f"out{begun}", tmp_path / f"cache{begun}"
            process = started(file, out, cache)
            continue
        workers = workers_of(process)
        if workers:
            with suppress(ProcessLookupError):
                os.kill(int(rng.choice(workers)), signal.SIGKILL)
                killed += 1
    assert process.wait(300) == 0
    # A trial whose process was killed several times over may have been given up.
    run(file, out, "--workers", 2, "--retry-failed", cache=cache)
    assert_same_rows(out, expected)


@pytest.mark.slow
def test_an_interrupt_finishes_cleanly(undisturbed, tmp_path):
    file, expected = undisturbed
    out, cache = tmp_path / "out", tmp_path / "cache"
    process = subprocess.Popen(
        command(file, out, "--workers", 2, cache=cache),
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (out / "table.json").exists():
        time.sleep(0.05)
    time.sleep(4)
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    if process.returncode != 0:
        assert process.returncode == 130
        assert "the same command goes on" in said
        assert "Traceback" not in said
    summary(file, out, "--workers", 2, cache=cache)
    assert_same_rows(out, expected)
