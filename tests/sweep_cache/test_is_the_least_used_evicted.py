"""Is the limit kept, and does what was not used for longest go first?"""

from __future__ import annotations

import os
import time

import pytest
from cache_processes import BLOCK, KEYS, blocks, ended, kept, leftovers, start

from simtip.sweep import cache_items as module
from simtip.sweep.cache import Cache

HOUR_S = 3600


def filled(folder, count, limit_blocks=None, size=2):
    """Give a cache with entries of equal size, the first one not used for longest."""
    cache = Cache(folder, None)
    for i, key in enumerate(KEYS[:count]):
        put = cache.put("light", key, blocks(size))
        used = time.time() - (100 - i) * HOUR_S
        os.utime(put, (used, used))
    return Cache(folder, None if limit_blocks is None else limit_blocks * BLOCK)


def total(cache):
    return sum(kind.bytes for kind in cache.summary().values())


def test_sizes_are_those_on_the_disk(cache):
    def write(folder):
        (folder / "deep").mkdir()
        (folder / "deep" / "one").write_bytes(b"1")
        (folder / "two").write_bytes(b"2" * (BLOCK + 1))

    cache.put("light", KEYS[0], write)
    assert total(cache) == 5 * BLOCK


def test_those_unused_for_longest_go(tmp_path):
    cache = filled(tmp_path, 8, limit_blocks=16)
    cache.put("light", KEYS[8], blocks(2))
    # 18 blocks were 2 too many, and 16/20 are left free.
    assert kept(cache) == [2, 3, 4, 5, 6, 7, 8]
    assert leftovers(cache) == []


def test_a_look_at_it_is_a_use(tmp_path):
    cache = filled(tmp_path, 8, limit_blocks=16)
    cache.entry("light", KEYS[0])
    cache.put("light", KEYS[8], blocks(2))
    assert kept(cache) == [0, 3, 4, 5, 6, 7, 8]


def test_the_one_just_put_stays_though_it_seems_old(tmp_path, monkeypatch):
    cache = filled(tmp_path, 8, limit_blocks=16)
    utime = os.utime
    monkeypatch.setattr(os, "utime", lambda path: utime(path, (1, 1)))
    cache.put("light", KEYS[8], blocks(16))
    assert kept(cache) == [8]
    assert total(cache) == 16 * BLOCK


def test_one_larger_than_the_limit_drives_out_nothing(tmp_path):
    cache = filled(tmp_path, 8, limit_blocks=16)
    assert cache.put("light", KEYS[8], blocks(17)) is None
    assert kept(cache) == list(range(8))
    assert leftovers(cache) == []


def test_a_limit_of_nothing_keeps_nothing(tmp_path):
    cache = Cache(tmp_path, 0)
    assert cache.put("light", KEYS[0], blocks(1)) is None
    cache.append("trial", KEYS[0], "record")
    assert cache.summary() == {}


def test_without_a_limit_nothing_is_looked_through(tmp_path, monkeypatch):
    cache = filled(tmp_path, 8)
    monkeypatch.setattr(cache, "_items", lambda: pytest.fail("looked"))
    cache.put("light", KEYS[8], blocks(2))


def test_logs_count_and_go_like_entries(tmp_path):
    cache = filled(tmp_path, 6, limit_blocks=16)
    for i, key in enumerate(KEYS[:4]):
        cache.append("trial", key, "record")
        path = cache.folder / "v1" / "trial" / key[:2] / f"{key}.log"
        used = time.time() - (200 - i) * HOUR_S
        os.utime(path, (used, used))
    assert total(cache) == 16 * BLOCK
    cache.lines("trial", KEYS[0])
    cache.put("light", KEYS[8], blocks(2))
    assert [len(cache.lines("trial", key)) for key in KEYS[:4]] == [1, 0, 0, 0]
    assert kept(cache) == [0, 1, 2, 3, 4, 5, 8]


def test_a_log_can_drive_out_entries_but_not_itself(tmp_path):
    cache = filled(tmp_path, 8, limit_blocks=16)
    cache.append("trial", KEYS[0], "x" * 2 * BLOCK)
    assert len(cache.lines("trial", KEYS[0])) == 1
    assert kept(cache) == [2, 3, 4, 5, 6, 7]


def test_what_is_used_after_the_look_stays(tmp_path, monkeypatch):
    cache = filled(tmp_path, 8, limit_blocks=16)
    items = list(cache._items())
    cache.entry("light", KEYS[0])
    monkeypatch.setattr(cache, "_items", lambda: items)
    cache.trim(14 * BLOCK)
    assert kept(cache) == [0, 2, 3, 4, 5, 6, 7]


def test_what_another_evicts_makes_room_too(tmp_path, monkeypatch):
    cache = filled(tmp_path, 8)
    items = list(cache._items())
    Cache(tmp_path).trim(12 * BLOCK)
    monkeypatch.setattr(cache, "_items", lambda: items)
    cache.trim(12 * BLOCK)
    assert kept(cache) == [2, 3, 4, 5, 6, 7]


@pytest.mark.slow
def test_the_cache_is_seldom_looked_through(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: None)
    cache = Cache(tmp_path, 400 * BLOCK)
    looks = []
    items = cache._items
    monkeypatch.setattr(cache, "_items", lambda: looks.append(1) or items())
    for number in range(600):
        cache.put("light", f"{number:016x}", blocks(1))
        assert number % 50 or total(cache) <= 400 * BLOCK
    # Once at first, then at every 20 blocks and a bit.
    assert 600 // 21 <= len(looks) - (600 // 50) <= 1 + 600 // 20


@pytest.mark.slow
def test_each_process_may_pass_the_limit_by_a_twentieth_alone(tmp_path):
    code = f"""
cache = Cache(folder, {200 * BLOCK})
for _ in range(150):
    cache.put("light", os.urandom(8).hex(), lambda f: (f / "a").write_bytes(bytes(4000)) and None)
"""
    for process in [start(code, tmp_path) for _ in range(3)]:
        ended(process)
    cache = Cache(tmp_path)
    # No more than that is evicted, either, though all of them do it at the same time.
    assert 150 * BLOCK <= total(cache) <= (200 + 3 * 10 + 2) * BLOCK
    assert leftovers(cache) == []


def test_trimming_keeps_what_fits(tmp_path):
    cache = filled(tmp_path, 8)
    assert cache.trim(16 * BLOCK) == 0
    assert cache.trim(11 * BLOCK) == 6 * BLOCK
    assert kept(cache) == [3, 4, 5, 6, 7]
    assert cache.trim(0) == 10 * BLOCK
    assert cache.summary() == {}


def test_clearing_takes_one_kind_or_all(cache):
    cache.put("light", KEYS[0], blocks(2))
    cache.put("mesh", KEYS[0], blocks(3))
    cache.append("trial", KEYS[0], "record")
    assert cache.clear("mesh") == 3 * BLOCK
    assert set(cache.summary()) == {"light", "trial"}
    assert cache.clear() == 3 * BLOCK
    assert cache.summary() == {}


def test_the_summary_tells_uses(tmp_path):
    cache = filled(tmp_path, 3)
    kind = cache.summary()["light"]
    now = time.time()
    assert (kind.count, kind.bytes) == (3, 6 * BLOCK)
    assert now - kind.oldest_s == pytest.approx(100 * HOUR_S, abs=60)
    assert now - kind.newest_s == pytest.approx(98 * HOUR_S, abs=60)
    cache.entry("light", KEYS[0])
    assert cache.summary()["light"].newest_s == pytest.approx(now, abs=60)


def test_what_vanishes_while_it_is_looked_at_is_no_error(tmp_path, monkeypatch):
    cache = filled(tmp_path, 8, limit_blocks=16)
    listed = module.listed
    gone = []

    def late(folder):
        found = listed(folder)
        if not gone and any(item.name in KEYS for item in found):
            gone.append(True)
            Cache(tmp_path).clear()
        return found

    monkeypatch.setattr(module, "listed", late)
    assert cache.summary() == {}
    assert gone
