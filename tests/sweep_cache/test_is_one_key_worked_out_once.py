"""Does one process work and the others wait, and is the lock free when its holder is killed?"""

from __future__ import annotations

import errno
import os
import threading

import pytest
from cache_processes import KEYS, ended, kill, start

from simtip.sweep import locked_file as module

pytestmark = pytest.mark.skipif(os.name != "posix", reason="flock")

KEY = KEYS[0]

HOLD = f"""
with cache.lock("light", "{KEY}") as locked:
    print(locked, flush=True)
    time.sleep(60)
"""


def lock_files(cache):
    return sorted(p.name for p in (cache.folder / "v1" / "locks").iterdir())


class Waiting(threading.Thread):
    """Wait for a lock, hold it for a moment, and say when it was got."""

    def __init__(self, cache):
        super().__init__(daemon=True)
        self.cache = cache
        self.got = threading.Event()
        self.start()

    def run(self):
        with self.cache.lock("light", KEY) as locked:
            if locked:
                self.got.set()


def test_of_several_processes_one_works(cache):
    code = f"""
with cache.lock("light", "{KEY}"):
    if cache.entry("light", "{KEY}") is None:
        print("working")
        time.sleep(0.3)
        cache.put("light", "{KEY}", lambda folder: None)
"""
    processes = [start(code, cache.folder) for _ in range(4)]
    assert "".join(ended(process) for process in processes) == "working\n"
    assert lock_files(cache) == []


@pytest.mark.slow
def test_two_never_hold_it_though_its_file_comes_and_goes(cache):
    cache.folder.mkdir()
    counter = cache.folder / "counter"
    counter.write_text("0")
    code = f"""
counter = folder / "counter"
for _ in range(300):
    with cache.lock("light", "{KEY}"):
        n = int(counter.read_text())
        counter.write_text(str(n + 1))
"""
    for process in [start(code, cache.folder) for _ in range(4)]:
        ended(process)
    assert counter.read_text() == "1200"
    assert lock_files(cache) == []


def test_a_killed_holder_frees_it(cache):
    holder = start(HOLD, cache.folder)
    assert holder.stdout.readline() == "True\n"
    waiting = Waiting(cache)
    assert not waiting.got.wait(0.3)
    kill(holder)
    assert waiting.got.wait(10)
    waiting.join(10)
    assert lock_files(cache) == []


def test_the_file_of_a_killed_holder_is_swept_up(cache):
    holder = start(HOLD, cache.folder)
    assert holder.stdout.readline() == "True\n"
    cache.sweep_up()
    assert lock_files(cache) == [f"light-{KEY}"]
    waiting = Waiting(cache)
    assert not waiting.got.wait(0.2)
    kill(holder)
    waiting.join(10)
    holder = start(HOLD, cache.folder)
    holder.stdout.readline()
    kill(holder)
    assert lock_files(cache) == [f"light-{KEY}"]
    cache.sweep_up()
    assert lock_files(cache) == []


def test_other_keys_and_kinds_do_not_wait(cache):
    with (
        cache.lock("light", KEY) as one,
        cache.lock("light", KEYS[1]) as two,
        cache.lock("trial", KEY) as three,
    ):
        assert (one, two, three) == (True, True, True)


def test_threads_exclude_each_other_too(cache):
    with cache.lock("light", KEY):
        waiting = Waiting(cache)
        assert not waiting.got.wait(0.2)
    assert waiting.got.wait(10)


def test_an_exception_frees_it_and_is_passed_on(cache):
    with pytest.raises(FileNotFoundError, match="mine"), cache.lock("light", KEY):
        raise FileNotFoundError("mine")
    assert lock_files(cache) == []
    with cache.lock("light", KEY) as locked:
        assert locked


def test_a_child_forked_meanwhile_does_not_hold_it(cache):
    code = f"""
with cache.lock("light", "{KEY}"):
    child = os.fork()
    if child == 0:
        os.close(1)
        time.sleep(3)
        os._exit(0)
    print("held", flush=True)
    time.sleep(0.3)
"""
    holder = start(code, cache.folder)
    holder.stdout.readline()
    waiting = Waiting(cache)
    ended(holder)
    assert waiting.got.wait(2)


def test_where_locking_is_not_possible_it_goes_on(cache, monkeypatch):
    def refuse(_descriptor, operation):
        if operation != module.fcntl.LOCK_UN:
            raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(module.fcntl, "flock", refuse)
    with cache.lock("light", KEY) as locked:
        assert not locked
    cache.append("trial", KEY, "record")
    assert cache.lines("trial", KEY) == ["record"]
    assert cache.clear() > 0
    cache.sweep_up()
    assert lock_files(cache) == []


def test_file_numbers_that_do_not_last_are_no_endless_loop(cache, monkeypatch):
    monkeypatch.setattr(module, "_names", lambda *_: False)
    with cache.lock("light", KEY) as locked:
        assert not locked
