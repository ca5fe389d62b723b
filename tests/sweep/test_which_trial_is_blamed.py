"""Which trial is blamed when a process dies, and what becomes of the others of its job?"""

import faulthandler
import os
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from simtip.sweep.crashes import DIED, MOST_KILLS, TIMED_OUT, Crashes
from simtip.sweep.leaving import leaving_at_once
from simtip.sweep.limit import Limit
from simtip.sweep.note import Last, Note, read_note
from simtip.sweep.pool import is_crash
from simtip.sweep.processes import Processes

TRIALS = (3, 5, 8, 13)


def judged(last, code, crashes=None):
    return (crashes or Crashes(2.0)).judge(TRIALS, last, code)


def test_one_that_crashes_is_blamed_at_once():
    verdict = judged(Last(8, timed_out=False), -signal.SIGSEGV)
    assert verdict.again == [[3, 5], [13]]
    assert verdict.blamed[:2] == (8, DIED)
    assert "SIGSEGV" in verdict.blamed[2]


def test_one_that_ends_its_process_is_blamed():
    assert "exit code 3" in judged(Last(3, timed_out=False), 3).blamed[2]


def test_one_that_takes_too_long_is_blamed():
    verdict = judged(Last(3, timed_out=True), 1)
    assert verdict.again == [[5, 8, 13]]
    assert verdict.blamed == (3, TIMED_OUT, "its process took longer than 2 s")


def test_one_killed_from_outside_is_tried_again_alone():
    crashes = Crashes(2.0)
    for _ in range(MOST_KILLS - 1):
        verdict = judged(Last(5, timed_out=False), -signal.SIGKILL, crashes)
        assert verdict.again == [[3], [8, 13], [5]]
        assert verdict.blamed is None
    last = judged(Last(5, timed_out=False), -signal.SIGKILL, crashes)
    assert last.blamed[:2] == (5, DIED)
    assert "memory" in last.blamed[2]


@pytest.mark.parametrize("last", [None, Last(99, timed_out=False)])
def test_without_a_note_jobs_are_halved(last):
    assert judged(last, None).again == [[3, 5], [8, 13]]
    assert Crashes(2.0).judge((3,), last, None).blamed[:2] == (3, DIED)


def test_a_note_says_what_came_last(tmp_path):
    path = str(tmp_path / "note")
    note = Note(path)
    with note:
        note.at(3)
        note.at(12)
        assert read_note(path) == Last(12, timed_out=False)
    assert not list(tmp_path.iterdir())
    assert read_note(path) is None


def test_where_no_note_can_be_written_work_goes_on(tmp_path):
    with Note(str(tmp_path / "missing" / "note")) as note:
        note.at(1)


def test_a_pause_leaves_somebody_elses_alarm_as_it_is(tmp_path):
    """Such as pytest's faulthandler_timeout, where a test renders."""
    with (tmp_path / "alarm").open("w+") as file:
        faulthandler.dump_traceback_later(0.2, file=file)
        try:
            with Limit(100.0).paused():
                pass
            time.sleep(0.5)
        finally:
            faulthandler.cancel_dump_traceback_later()
        file.seek(0)
        assert "Timeout" in file.read()


def told(path, ended):
    """Work on two trials, of which the second ends the process."""
    with Note(path) as note:
        limit = Limit(0.3)
        limit.told = note.descriptor
        note.at(1)
        with limit:
            pass
        note.at(2)
        with limit:
            if ended is None:
                time.sleep(60)
            elif ended < 0:
                os.kill(os.getpid(), -ended)
            os._exit(ended)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ended", "code"), [(None, 1), (-signal.SIGSEGV, -signal.SIGSEGV), (-9, -9), (3, 3)]
)
def test_real_processes_say_how_they_ended(tmp_path, ended, code):
    path = str(tmp_path / "note")
    executor = Processes(1)
    try:
        future = executor.submit(told, path, ended)
        assert future.exception(60) is not None
        assert executor.exit_code(future) == code
        assert read_note(path) == Last(2, timed_out=ended is None)
        assert executor.submit(abs, -4).result(60) == 4  # another process has taken its place
    finally:
        executor.kill()


def late(seconds):
    time.sleep(seconds)
    return os.getpid()


@pytest.mark.slow
def test_one_that_dies_takes_no_other_with_it():
    executor = Processes(2)
    try:
        lasting = executor.submit(late, 3.0)
        dying = executor.submit(os._exit, 1)
        assert dying.exception(60) is not None
        again = executor.submit(late, 0.0).result(60)
        assert lasting.result(60) != again
    finally:
        executor.kill()


@pytest.mark.slow
def test_a_process_makes_way_for_a_new_one(monkeypatch):
    monkeypatch.setattr("simtip.sweep.processes.RECYCLED_AFTER", 2)
    executor = Processes(1)
    try:
        numbers = [executor.submit(late, 0.0).result(60) for _ in range(4)]
        assert numbers[0] == numbers[1] != numbers[2] == numbers[3]
    finally:
        executor.shutdown()


def forked(seconds):
    """Leave a child behind that outlives this process, and die."""
    if os.fork() == 0:
        time.sleep(seconds)
        os._exit(0)
    os.kill(os.getpid(), signal.SIGSEGV)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_child_that_is_left_behind_hides_nothing():
    executor = Processes(1)
    try:
        executor.submit(abs, 1).result(60)
        start = time.monotonic()
        future = executor.submit(forked, 60)
        while not future.done() and time.monotonic() - start < 30:
            time.sleep(0.2)
            executor.clear_up()
        assert time.monotonic() - start < 20
        assert executor.exit_code(future) == -signal.SIGSEGV
    finally:
        executor.kill()


def with_program(path):
    """Run a program that lasts."""
    from simtip.detect.process import run_program

    run_program([sys.executable, "-c", f"import time; open({path!r}, 'w'); time.sleep(60)"], 60)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="looks in /proc")
def test_programs_end_with_their_worker(tmp_path):
    path = str(tmp_path / "begun")
    executor = Processes(1)
    executor.submit(with_program, path)
    until = time.monotonic() + 60
    while not Path(path).exists() and time.monotonic() < until:
        time.sleep(0.05)
    executor.kill()
    time.sleep(0.5)
    lines = [p.read_bytes() for p in Path("/proc").glob("[0-9]*/cmdline") if p.exists()]
    assert not [line for line in lines if path.encode() in line]


def cleaning_up(path):
    """Say that it is at work, and at its end that it has cleaned up."""
    Path(path).write_text("at work")
    try:
        while True:
            time.sleep(0.01)
    finally:
        Path(path).write_text("cleaned up")


def in_vain(path):
    """Be at work where nothing has to be cleaned up."""
    with leaving_at_once():
        cleaning_up(path)


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize(
    ("work", "left"), [(cleaning_up, "cleaned up"), (in_vain, "at work")], ids=["work", "a render"]
)
def test_a_worker_told_to_leave_cleans_up_and_is_seen_to_be_killed(tmp_path, work, left, capfd):
    path = tmp_path / "said"
    executor = Processes(1)
    try:
        future = executor.submit(work, str(path))
        until = time.monotonic() + 60
        while not path.exists() and time.monotonic() < until:
            time.sleep(0.01)
        executor._process[future].terminate()
        assert is_crash(future.exception(30))
        assert executor.exit_code(future) == -signal.SIGTERM
        assert path.read_text() == left
    finally:
        executor.kill()
    assert capfd.readouterr().err == ""


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_an_idle_worker_told_to_leave_says_nothing(capfd):
    executor = Processes(1)
    try:
        future = executor.submit(os.getpid)
        os.kill(future.result(60), signal.SIGTERM)
        until = time.monotonic() + 10
        while executor._process[future].exitcode is None and time.monotonic() < until:
            time.sleep(0.01)
        assert executor._process[future].exitcode == -signal.SIGTERM
    finally:
        executor.kill()
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("error", [None, ValueError])
def test_a_note_of_what_went_wrong_stays(tmp_path, error):
    path = str(tmp_path / "note")
    with suppress(ValueError), Note(path) as note:
        note.at(7)
        if error is not None:
            raise error
    assert read_note(path) == (None if error is None else Last(7, timed_out=False))
