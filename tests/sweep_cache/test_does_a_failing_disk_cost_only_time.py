"""Does the caller of a cache go on when it cannot be used, and is nothing half kept then?"""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest
from cache_processes import KEYS, blocks, kept, leftovers, run

from simtip.errors import InputError
from simtip.output_folder import write_atomically
from simtip.sweep.cache import Cache, default_folder

KEY = KEYS[0]


def full(*_arguments, **_options):
    raise OSError(errno.ENOSPC, "No space left on device")


def half(folder):
    (folder / "a").write_bytes(b"a" * 5000)
    full()


def unusable(tmp_path):
    """Caches in a file and where nobody, not even root, may make a folder."""
    (tmp_path / "file").write_text("mine")
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "v1").write_text("mine")
    return [Cache(Path(p)) for p in (tmp_path / "file", tmp_path / "taken", "/proc/x", "/dev/null")]


def test_a_full_disk_half_way(cache):
    cache.put("light", KEYS[1], blocks(2))
    assert cache.put("light", KEY, half) is None
    assert kept(cache) == [1]
    assert leftovers(cache) == []
    assert cache.put("light", KEY, blocks(2)) is not None


def test_a_full_disk_told_as_an_input_error(cache, monkeypatch):
    def write(folder):
        monkeypatch.setattr(Path, "open", full)
        write_atomically(folder / "deep.json", b"{}")

    assert cache.put("light", KEY, write) is None
    assert leftovers(cache) == []


@pytest.mark.parametrize("inside", [True, False])
def test_another_input_error_is_the_callers(cache, inside):
    def write(folder):
        if inside:  # it is about the content, no OSError is behind it
            raise InputError("is bad", file=folder / "a")
        try:
            full()
        except OSError as error:
            raise InputError("cannot be read", file="scene.yaml") from error

    with pytest.raises(InputError, match=r"is bad|cannot be read"):
        cache.put("light", KEY, write)
    assert leftovers(cache) == []


@pytest.mark.parametrize("what", ["fsync", "rename", "mkdir"])
def test_a_disk_that_fails_late(cache, monkeypatch, what):
    cache.put("light", KEYS[1], blocks(2))
    with monkeypatch.context() as patch:
        patch.setattr(os if what == "fsync" else Path, what, full)
        assert cache.put("light", KEY, blocks(2)) is None
        if what != "fsync":
            assert cache.clear() == 0
    assert kept(cache) == [1]
    assert leftovers(cache) == []


def test_files_that_may_not_grow(cache):
    code = f"""
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
def write(size):
    return lambda folder: (folder / "a").write_bytes(b"a" * size) and None
print(cache.put("light", "{KEY}", write(20_000)))
print(cache.put("light", "{KEYS[1]}", write(9_000)).name)
"""
    assert run(code, cache.folder) == f"None\n{KEYS[1]}\n"
    assert kept(cache) == [1]
    assert leftovers(cache) == []


def test_where_nothing_can_be_kept_everything_is_absent(tmp_path):
    for cache in unusable(tmp_path):
        assert cache.put("light", KEY, blocks(2)) is None
        assert cache.entry("light", KEY) is None
        cache.append("trial", KEY, "record")
        assert cache.lines("trial", KEY) == []
        with cache.lock("light", KEY) as locked:
            assert not locked
        cache.discard("light", KEY)
        assert (cache.summary(), cache.clear(), cache.trim(0), cache.sweep_up()) == ({}, 0, 0, 0)
    assert (tmp_path / "file").read_text() == (tmp_path / "taken" / "v1").read_text() == "mine"


def test_a_folder_that_cannot_be_used_is_refused_when_asked(tmp_path):
    for cache in [*unusable(tmp_path), Cache(Path("a\0b"))]:
        with pytest.raises(InputError, match="cannot be used as a cache") as caught:
            cache.check()
        assert caught.value.file == str(cache.folder)


def test_a_folder_that_can_be_used_is_made(cache):
    cache.check()
    assert leftovers(cache) == []
    assert cache.summary() == {}


def test_one_that_can_only_be_read_still_serves(cache, monkeypatch):
    cache.put("light", KEY, blocks(2))
    cache.append("trial", KEY, "record")

    def refuse(*_arguments, **_options):
        raise OSError(errno.EROFS, "Read-only file system")

    for module, name in ((Path, "mkdir"), (Path, "rename"), (os, "utime"), (os, "open")):
        monkeypatch.setattr(module, name, refuse)
    cache.check()
    assert cache.entry("light", KEY) is not None
    assert cache.lines("trial", KEY) == ["record"]
    assert cache.put("light", KEYS[1], blocks(2)) is None
    cache.append("trial", KEY, "lost")
    assert cache.lines("trial", KEY) == ["record"]


def test_a_folder_removed_in_between_is_made_again(cache):
    cache.put("light", KEY, blocks(2))
    cache.folder.rename(cache.folder.with_name("away"))
    assert cache.entry("light", KEY) is None
    assert cache.put("light", KEY, blocks(2)) is not None
    assert kept(cache) == [0]


def test_the_folder_stays_the_same_when_the_working_folder_changes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    cache = Cache(Path("here"))
    monkeypatch.chdir("/")
    cache.put("light", KEY, blocks(2))
    assert kept(Cache(tmp_path / "here")) == [0]


def test_the_variable_names_the_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SIMTIP_CACHE", str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.setenv("SIMTIP_CACHE", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_folder().name == "simtip"
