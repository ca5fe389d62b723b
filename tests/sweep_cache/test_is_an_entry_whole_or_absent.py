"""Is what others see of an entry all of it or nothing, whoever is killed when?"""

from __future__ import annotations

import os
import random
import shutil
import socket
import time
from pathlib import Path

import pytest
from cache_processes import BLOCK, KEYS, blocks, kept, kill, leftovers, run, start

from simtip.errors import InputError
from simtip.sweep.cache import Cache

KEY = KEYS[0]


def write(folder):
    (folder / "left.bin").write_bytes(b"left")
    (folder / "deep").mkdir()
    (folder / "deep" / "right.bin").write_bytes(b"right")


def test_what_was_put_is_there_for_every_process(cache):
    assert cache.entry("light", KEY) is None
    put = cache.put("light", KEY, write)
    assert put == cache.entry("light", KEY) == cache.folder / "v1/light/00" / KEY
    assert (put / "deep/right.bin").read_bytes() == b"right"
    code = f"print((cache.entry('light', '{KEY}') / 'left.bin').read_text())"
    assert run(code, cache.folder) == "left\n"
    assert leftovers(cache) == []


def test_kinds_and_keys_are_apart(cache):
    cache.put("light", KEY, write)
    assert cache.entry("trial", KEY) is None
    assert cache.entry("light", KEYS[1]) is None
    assert cache.entry("light", KEY + "0") is None


def test_it_is_not_there_while_it_is_written(cache):
    seen = []

    def watch(folder):
        assert list(folder.iterdir()) == []
        write(folder)
        assert folder.stat().st_dev == cache.folder.stat().st_dev
        seen.append(cache.entry("light", KEY))

    cache.put("light", KEY, watch)
    assert seen == [None]


def test_it_is_on_the_disk_before_it_is_there(cache, monkeypatch):
    order = []
    fsync, rename = os.fsync, Path.rename
    monkeypatch.setattr(os, "fsync", lambda fd: order.append(inode(fd)) or fsync(fd))
    monkeypatch.setattr(Path, "rename", lambda a, b: order.append("there") or rename(a, b))

    def inode(descriptor):
        return os.fstat(descriptor).st_ino

    put = cache.put("light", KEY, write)
    files = {put.stat().st_ino, *(p.stat().st_ino for p in put.rglob("*.bin"))}
    assert set(order[:-1]) == files
    assert order[-1] == "there"


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, MemoryError, InputError])
def test_an_exception_is_passed_on_and_leaves_nothing(cache, error):
    def fail(folder):
        write(folder)
        raise error("stop")

    with pytest.raises(error, match="stop"):
        cache.put("light", KEY, fail)
    assert cache.entry("light", KEY) is None
    assert leftovers(cache) == []


def test_who_is_first_stays(cache):
    def late(folder):
        (folder / "who").write_text("late")
        Cache(cache.folder).put("light", KEY, early)

    def early(folder):
        (folder / "who").write_text("early")

    put = cache.put("light", KEY, late)
    assert (put / "who").read_text() == "early"
    assert leftovers(cache) == []


def test_a_damaged_one_is_removed_and_can_be_put_again(cache):
    cache.put("light", KEY, write)
    cache.append("light", KEY, "record")
    cache.put("light", KEYS[1], write)
    cache.discard("light", KEY)
    assert cache.entry("light", KEY) is None
    assert cache.lines("light", KEY) == []
    assert kept(cache) == [1]
    assert cache.put("light", KEY, write) == cache.entry("light", KEY)
    assert leftovers(cache) == []
    cache.discard("trial", KEY)


@pytest.mark.parametrize("way", ["clear", "trim", "discard", "full"])
def test_it_is_gone_under_its_name_before_any_of_it_is_removed(cache, monkeypatch, way):
    whole = cache.put("light", KEY, write)
    removed = []
    rmtree = shutil.rmtree

    def watch(path, **options):
        if Path(path).exists():
            removed.append(whole.exists())
            assert (path / "left.bin").exists()
        rmtree(path, **options)

    monkeypatch.setattr(shutil, "rmtree", watch)
    cache.limit_bytes = 8 * BLOCK
    {
        "clear": cache.clear,
        "trim": lambda: cache.trim(0),
        "discard": lambda: cache.discard("light", KEY),
        "full": lambda: cache.put("light", KEYS[1], blocks(8)),
    }[way]()
    assert removed == [False]


# Ten files, written with pauses: there is time to be killed in between.
WRITER = """
from cache_processes import KEYS
while True:
    key = random.choice(KEYS[:4])
    def write(folder):
        for i in range(10):
            (folder / str(i)).write_text(key * 50)
            time.sleep(random.random() * 2e-3)
    cache.put("light", key, write)
    cache.append("trial", key, key)
"""
EVICTOR = """
from cache_processes import KEYS
while True:
    random.choice([
        cache.clear,
        lambda: cache.trim(50_000),
        lambda: cache.discard("light", random.choice(KEYS[:4])),
    ])()
    time.sleep(random.random() * 0.01)
"""


def whole(cache, key):
    """Say whether an entry is whole, None if it is not there or went while it was looked at."""
    path = cache.entry("light", key)
    try:
        place = None if path is None else os.open(path, os.O_RDONLY)
    except FileNotFoundError:
        return None
    if place is None:
        return None
    try:
        found = sorted(os.listdir(place))  # noqa: PTH208 (of what is open)
        sizes = {os.stat(name, dir_fd=place).st_size for name in found}
        still = os.path.samestat(path.stat(), os.fstat(place))
    except FileNotFoundError:
        return None if not path.exists() else whole(cache, key)
    finally:
        os.close(place)
    return (found == list("0123456789") and sizes == {800}) if still else None


@pytest.mark.slow
def test_no_kill_ever_leaves_a_part_to_see(cache, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    moments = random.Random(1)  # noqa: S311 (of kills)
    jobs = [WRITER, WRITER, EVICTOR]
    running = [start(job, cache.folder) for job in jobs]
    seen = []
    for turn in range(6):
        until = time.monotonic() + 0.25 + moments.random() * 0.25
        while time.monotonic() < until:
            seen.extend(whole(cache, key) for key in KEYS[:4])
            seen.append(all(line == KEYS[0] for line in cache.lines("trial", KEYS[0])) or False)
        kill(running[turn % 3])
        running[turn % 3] = start(jobs[turn % 3], cache.folder)
    for process in running:
        kill(process)
    seen.extend(whole(cache, key) for key in KEYS)
    assert False not in seen
    assert seen.count(True) > 100
    cache.sweep_up()
    assert leftovers(cache) == []
    assert set(cache.summary()) <= {"light", "trial"}


def test_what_the_killed_leave_is_swept_up(cache):
    code = f"""
def write(folder):
    (folder / "a").write_bytes(b"x" * 5000)
    print("writing", flush=True)
    time.sleep(60)
cache.put("light", "{KEY}", write)
"""
    process = start(code, cache.folder)
    assert process.stdout.readline() == "writing\n"
    assert cache.sweep_up() == 0
    assert len(leftovers(cache)) == 1
    kill(process)
    assert cache.entry("light", KEY) is None
    assert cache.sweep_up() == 3 * BLOCK
    assert leftovers(cache) == []


def test_what_others_write_is_left_alone_for_a_day(cache):
    dead = 2**22 + 1  # above any number of a process
    here = socket.gethostname().replace("-", "_")
    folder = cache.folder / "v1" / "tmp"
    for name in (f"elsewhere-1-{dead}-ab", f"{here}-1-{dead}-ab", "no process at all"):
        (folder / name).mkdir(parents=True)
    cache.sweep_up()
    assert len(leftovers(cache)) == 3
    long_ago = time.time() - 25 * 3600
    for path in folder.iterdir():
        os.utime(path, (long_ago, long_ago))
    cache.sweep_up()
    assert leftovers(cache) == []
