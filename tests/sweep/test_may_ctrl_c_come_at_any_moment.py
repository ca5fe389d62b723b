"""Is Ctrl-C one line whenever it comes, once or twice, with nothing left running or torn apart?"""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from pathlib import Path

import pytest
from small_sweeps import command, rows, summary, sweep_file

from simtip import interrupts
from simtip.interrupts import counted, nothing_begun
from simtip.sweep.plan import Plan
from simtip.sweep.resuming import open_table
from simtip.sweep.running import run_sweep
from simtip.sweep.sweep_file import read_sweep
from simtip.sweep.work import Done, Setup

pytestmark = pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")


@pytest.fixture(autouse=True)
def _long_ago(monkeypatch):
    """Let no test's Ctrl-C be one with the last test's."""
    monkeypatch.setattr(interrupts, "_TAKEN", interrupts._Taken())


CALL = """
import sys
from simtip import interrupts

def told():
    take_over()
    sys.stdout.write("started\\n")
    sys.stdout.flush()

take_over, interrupts.take_over = interrupts.take_over, told
from simtip.__main__ import main
main()
"""


def started(argv):
    """Start simtip in a process group of its own, as a shell does, and wait until it has begun."""
    process = subprocess.Popen(
        [sys.executable, "-c", CALL, *argv],
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline() == "started\n"
    return process


def press(process, times):
    """Press Ctrl-C: all of the group gets it."""
    for _ in range(times):
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.07)


def judge(process):
    """Check that it ends soon, says one line, and leaves no process; give the line."""
    said = process.communicate(timeout=30)[1]
    assert process.returncode == 130, said
    assert said.startswith("simtip: interrupted"), said
    assert said.count("\n") == 1, said
    until = time.monotonic() + 10
    while running(process.pid):
        assert time.monotonic() < until, running(process.pid)
        time.sleep(0.05)
    return said


def running(session):
    """Give the processes of a session that are no corpses."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, of = (place / "stat").read_text().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(of) == session and state != "Z":
            found.append(place.name)
    return found


def at(delay_s, times, argv):
    process = started(argv)
    time.sleep(delay_s)
    press(process, times)
    return judge(process)


@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("delay_s", [0, 0.4])
def test_while_it_is_loaded(delay_s, times, tmp_path):
    # A sweep of nothing but imports: its file is looked at last.
    assert "nothing was written" in at(delay_s, times, ["sweep", "-", "-o", str(tmp_path / "out")])


@pytest.mark.slow
@pytest.mark.parametrize("times", [1, 2])
@pytest.mark.parametrize("delay_s", [0, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 2.5, 4])
def test_while_a_sweep_begins(delay_s, times, tmp_path):
    file = sweep_file(tmp_path, repeats=20)
    said = at(delay_s, times, command(file, tmp_path / "out", "--workers", 2)[3:])
    assert "nothing was written" in said or "the same command goes on" in said


@pytest.mark.slow
def test_twice_while_rows_come_keeps_those_at_hand(tmp_path):
    file = sweep_file(tmp_path, repeats=20)
    out, cache = tmp_path / "out", tmp_path / "cache"
    process = started(command(file, out, "--workers", 2, cache=cache)[3:])
    until = time.monotonic() + 120
    while not any(out.glob("rows*/*.parquet")) and time.monotonic() < until:
        time.sleep(0.05)
    press(process, 2)
    process.communicate(timeout=30)
    kept = len(rows(out))
    assert kept > 0
    said = summary(file, out, "--workers", 2, cache=cache)
    assert (said["found"], said["found"] + said["done"]) == (kept, 640)


class Slow:
    """An executor and its pool; jobs come back while Ctrl-C is pressed again and again."""

    local, workers, most_jobs = True, 1, 1

    def __init__(self, plan):
        self.plan, self.handed_out = plan, 0

    def executor(self):
        return self

    def submit(self, _, job):
        future = Future()
        self.handed_out += 1
        rows = [
            {"key": self.plan.key(self.plan.trial(n)), "trial": n, "status": "ok"}
            for n in job.trials
        ]
        found = Done([] if job.only_light else rows, {}, 0.1)
        threading.Timer(0.05, future.set_result, (found,)).start()
        if self.handed_out > 5:
            signal.raise_signal(signal.SIGINT)
        return future

    def shutdown(self, **_):
        signal.raise_signal(signal.SIGINT)


def test_no_row_is_lost_wherever_it_strikes(tmp_path, monkeypatch):
    file = sweep_file(tmp_path, repeats=20)
    source = read_sweep(file)
    plan = Plan(source.spec, source.scene)
    (tmp_path / "out").mkdir()
    table, _ = open_table(tmp_path / "out", plan, {}, retry_failed=False)
    append = table.append

    def interrupted(rows):
        signal.raise_signal(signal.SIGINT)
        append(rows)

    monkeypatch.setattr(table, "append", interrupted)
    monkeypatch.setattr("simtip.sweep.running.FLUSH_S", 0.0)
    pool = Slow(plan)
    setup = Setup("", "", (), "llvm", None, 0, 60.0)
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(plan, table, setup, pool, done=lambda _: False)
    assert signal.getsignal(signal.SIGINT) == before
    assert len(table.keys()) == 2  # those of the first job, for its rows were being written


def test_several_in_quick_succession_are_one():
    with counted() as presses:
        for _ in range(5):
            signal.raise_signal(signal.SIGINT)
    assert presses.count == 1


def test_without_the_command_line_an_interrupt_is_what_it_was():
    with pytest.raises(KeyboardInterrupt), nothing_begun():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_in_another_thread_nothing_is_counted():
    found = []

    def count():
        with counted() as presses:
            found.append(presses.count)

    thread = threading.Thread(target=count)
    thread.start()
    thread.join()
    assert found == [0]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_one_that_cannot_be_raised_comes_again():
    """Python drops what a finaliser raises; so it would drop an interrupt that comes in one."""
    code = """
import signal, sys, time
from simtip import interrupts
interrupts.take_over()
interrupts.let_clean_up()
class Ending:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
        time.sleep(0)
try:
    Ending()
    time.sleep(20)
except KeyboardInterrupt:
    sys.exit(130)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=15, check=False
    )
    assert (done.returncode, done.stderr) == (130, "")
