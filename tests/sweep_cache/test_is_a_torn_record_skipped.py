"""Is every record of a log whole or skipped, and those after it still read?"""

from __future__ import annotations

import json
import os
import random
import time

import pytest
from cache_processes import KEYS, ended, kill, run, start

KEY = KEYS[0]
RECORDS = ['{"trial": 1}', "", "0 00000000 ", "тип µ \r \x00 \u2028", "a" * 5000, "\udcff"]


def log(cache):
    return cache.folder / "v1" / "trial" / KEY[:2] / f"{KEY}.log"


def test_records_come_back_in_order(cache):
    assert cache.lines("trial", KEY) == []
    for record in RECORDS:
        cache.append("trial", KEY, record)
    assert cache.lines("trial", KEY) == RECORDS


def test_what_was_added_comes_alone_but_for_the_last(cache):
    """The last one may have been cut short when it was read."""
    cache.append("trial", KEY, "first")
    found, read = cache.added_lines("trial", KEY, 0)
    assert found == ["first"]
    for record in ("second", "third"):
        cache.append("trial", KEY, record)
    found, read = cache.added_lines("trial", KEY, read)
    assert found == ["first", "second", "third"]
    assert cache.added_lines("trial", KEY, read)[0] == ["third"]
    cache.discard("trial", KEY)
    cache.append("trial", KEY, "anew")
    assert cache.added_lines("trial", KEY, read)[0] == ["anew"]


def test_one_read_while_it_was_being_written_is_read_again(cache):
    cache.append("trial", KEY, "first")
    before = log(cache).stat().st_size
    cache.append("trial", KEY, "second")
    data = log(cache).read_bytes()
    for end in range(before, len(data)):
        log(cache).write_bytes(data[:end])
        _, read = cache.added_lines("trial", KEY, 0)
        log(cache).write_bytes(data)
        assert "second" in cache.added_lines("trial", KEY, read)[0], end


def test_a_line_feed_is_refused(cache):
    with pytest.raises(ValueError, match="one line"):
        cache.append("trial", KEY, "a\nb")
    assert cache.lines("trial", KEY) == []


def test_cut_anywhere_only_the_cut_one_is_lost(cache):
    cache.append("trial", KEY, "first")
    start = log(cache).stat().st_size
    cache.append("trial", KEY, '{"second": 10}')
    data = log(cache).read_bytes()
    for end in range(start, len(data)):
        log(cache).write_bytes(data[:end])
        cache.append("trial", KEY, "third")
        assert cache.lines("trial", KEY) == ["first", "third"], end


def test_a_changed_byte_loses_no_more_than_its_record_and_invents_none(cache):
    for record in ("first", "second", "third"):
        cache.append("trial", KEY, record)
    data = log(cache).read_bytes()
    for place in range(len(data)):
        for flip in (1, 0x20, 0x80):
            changed = bytearray(data)
            changed[place] ^= flip
            log(cache).write_bytes(changed)
            lines = cache.lines("trial", KEY)
            assert set(lines) <= {"first", "second", "third"}
            assert len(lines) >= (2 if data[place] != ord("\n") else 1)


def test_what_is_no_log_has_no_records(cache):
    log(cache).parent.mkdir(parents=True)
    for data in (b"", b"\0" * 1000, os.urandom(5000), b"\n1 b7b2364b \xff", b"\n-1 0 \n1_0 0 a"):
        log(cache).write_bytes(data)
        assert cache.lines("trial", KEY) == []


def test_a_file_that_may_not_grow_tears_one_record(cache):
    cache.append("trial", KEY, "first")
    code = f"""
import resource
end = cache.folder / "v1/trial/{KEY[:2]}/{KEY}.log"
limit = end.stat().st_size + 20
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
for _ in range(3):
    cache.append("trial", "{KEY}", "torn" * 10)
print(end.stat().st_size - limit)
"""
    assert run(code, cache.folder) == "0\n"
    cache.append("trial", KEY, "third")
    assert cache.lines("trial", KEY) == ["first", "third"]


def test_one_record_is_one_write(cache, monkeypatch):
    writes = []
    write = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: writes.append(data) or write(fd, data))
    cache.append("trial", KEY, "a" * 100_000)
    assert len(writes) == 1


@pytest.mark.slow
def test_many_processes_append_and_some_are_killed(cache):
    code = f"""
import json
for number in range(10**9 if sys.argv[2] == "killed" else 400):
    cache.append("trial", "{KEY}", json.dumps([sys.argv[2], number, "x" * (number % 700)]))
    if number == 10:
        print("going", flush=True)
"""
    lasting = [start(code, cache.folder, name) for name in ("a", "b")]
    for _ in range(3):
        process = start(code, cache.folder, "killed")
        process.stdout.readline()
        time.sleep(random.random() * 0.2)  # noqa: S311 (of kills)
        kill(process)
    for process in lasting:
        ended(process)
    found = [json.loads(line) for line in cache.lines("trial", KEY)]
    assert all(text == "x" * (number % 700) for _, number, text in found)
    for name in ("a", "b"):
        assert [number for who, number, _ in found if who == name] == list(range(400))
    assert sum(who == "killed" for who, _, _ in found) >= 33


def test_an_append_to_a_log_being_removed_goes_to_the_new_one(cache):
    code = f"""
for number in range(300):
    cache.append("trial", "{KEY}", str(number))
print("done")
"""
    process = start(code, cache.folder)
    while process.poll() is None:
        cache.clear()
    ended(process)
    cache.append("trial", KEY, "last")
    assert cache.lines("trial", KEY)[-1] == "last"


def test_a_log_is_not_removed_while_it_is_appended_to(cache, monkeypatch):
    cache.append("trial", KEY, "first")
    write = os.write
    freed = []

    def meanwhile(descriptor, data):
        freed.append(cache.clear())
        return write(descriptor, data)

    monkeypatch.setattr(os, "write", meanwhile)
    cache.append("trial", KEY, "second")
    assert freed == [0]
    assert cache.lines("trial", KEY) == ["first", "second"]


def test_a_record_is_never_written_into_a_removed_log(cache, monkeypatch):
    """The log goes between the opening and the locking of another process."""
    cache.append("trial", KEY, "first")
    open_ = os.open
    removed = []

    def slow(path, flags, *mode):
        descriptor = open_(path, flags, *mode)
        if not removed and str(path).endswith(".log"):
            removed.append(True)
            log(cache).unlink()
        return descriptor

    monkeypatch.setattr(os, "open", slow)
    cache.append("trial", KEY, "second")
    assert removed
    assert cache.lines("trial", KEY) == ["second"]
