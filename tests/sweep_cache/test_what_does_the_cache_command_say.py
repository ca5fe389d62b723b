"""`simtip cache`: what it tells, what it removes, and which mistakes are one line."""

from __future__ import annotations

import json
import os
import re
from datetime import UTC, datetime

import pytest
import typer
from cache_processes import BLOCK, KEYS, blocks, kept

from simtip.cli import cache as command
from simtip.errors import InputError
from simtip.sweep.cache import Cache


@pytest.fixture
def say(capsys):
    """Call the command, and give what it printed."""
    app = typer.Typer()
    app.callback()(lambda: None)
    app.add_typer(command.cache, name="cache")

    def call(*arguments):
        app(["cache", *map(str, arguments)], standalone_mode=False)
        out, err = capsys.readouterr()
        assert err == ""
        return out

    return call


@pytest.fixture
def full(tmp_path):
    """Three entries of two kinds and a log: 2 + 2 + 4 + 1 blocks."""
    cache = Cache(tmp_path / "cache")
    for i, (kind, size) in enumerate([("light", 2), ("light", 2), ("mesh", 4)]):
        used = 1_000_000_000 + 1000 * i
        os.utime(cache.put(kind, KEYS[i], blocks(size)), (used, used))
    cache.append("trial", KEYS[0], "record")
    return cache


def test_it_shows_what_there_is(full, say):
    out = say("--cache", full.folder)
    assert str(full.folder) in out
    assert re.search(r"light\W+2\W+16.4 kB\W+2001-09-0", out)
    assert re.search(r"mesh\W+1\W+16.4 kB", out)
    assert "36.9 kB in all" in out
    assert "20 GB" in out
    assert kept(full) == [0, 1]


def test_it_tells_the_same_as_json(full, say):
    told = json.loads(say("--cache", full.folder, "--json"))
    assert told["folder"] == str(full.folder)
    assert (told["bytes"], told["limit_bytes"]) == (9 * BLOCK, 20_000_000_000)
    assert list(told["kinds"]) == ["light", "mesh", "trial"]
    assert told["kinds"]["light"] == {
        "count": 2,
        "bytes": 4 * BLOCK,
        "oldest_use_utc": datetime.fromtimestamp(1_000_000_000, UTC).isoformat(),
        "newest_use_utc": datetime.fromtimestamp(1_000_001_000, UTC).isoformat(),
    }


def test_where_nothing_is_it_says_so_and_makes_nothing(tmp_path, say):
    folder = tmp_path / "none"
    assert "0 B in all" in say("--cache", folder)
    assert json.loads(say("--cache", folder, "--json"))["kinds"] == {}
    assert "0 B freed, 0 B left" in say("clear", "--cache", folder)
    assert "0 B freed" in say("trim", "--cache-size", "1GB", "--cache", folder)
    assert not folder.exists()


def test_the_variable_names_the_folder(full, say, monkeypatch):
    monkeypatch.setenv("SIMTIP_CACHE", str(full.folder))
    assert json.loads(say("--json"))["bytes"] == 9 * BLOCK


def test_clearing(full, say):
    assert say("clear", "--cache", full.folder) == f"{full.folder}: 36.9 kB freed, 0 B left\n"
    assert full.summary() == {}


def test_clearing_one_kind(full, say):
    told = json.loads(say("clear", "--kind", "light", "--cache", full.folder, "--json"))
    assert (told["freed_bytes"], told["left_bytes"]) == (4 * BLOCK, 5 * BLOCK)
    assert set(full.summary()) == {"mesh", "trial"}


def test_options_may_stand_before_the_command_too(full, say):
    told = json.loads(say("--cache", full.folder, "--json", "clear"))
    assert told["freed_bytes"] == 9 * BLOCK


def test_trimming(full, say):
    assert say("trim", "--cache-size", "25kB", "--cache", full.folder).endswith(
        "16.4 kB freed, 20.5 kB left\n"
    )
    assert kept(full) == []


@pytest.mark.parametrize("words", [["clear"], ["trim", "--cache-size", "1GB"]])
def test_both_sweep_up_after_the_killed(full, say, words):
    left = full.folder / "v1" / "tmp" / "elsewhere-1-1-ab"
    left.mkdir()
    os.utime(left, (1, 1))
    say(*words, "--cache", full.folder)
    assert not left.exists()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["clear", "--kind", "../x"], r"--kind: '../x' is no kind; "),
        (["clear", "--kind", "tmp"], r"--kind: 'tmp' is no kind; "),
        (["trim", "--cache-size", "5"], r"--cache-size: '5' is no size; "),
    ],
)
def test_a_mistake_is_one_line(full, say, words, problem):
    with pytest.raises(InputError, match=problem):
        say(*words, "--cache", full.folder)
    assert kept(full) == [0, 1]


@pytest.mark.parametrize("words", [[], ["clear"], ["trim", "--cache-size", "5GB"]])
def test_a_file_is_no_cache(tmp_path, say, words):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match=r"file: cannot be used as a cache \(Not a directory\)"):
        say(*words, "--cache", tmp_path / "file")


def test_a_time_outside_the_calendar_is_no_error(full, say):
    entry = full.entry("light", KEYS[0])
    os.utime(entry, ns=(2**62, 2**62))
    os.utime(full.entry("mesh", KEYS[2]), (-(10**9), -(10**9)))
    assert "light" in say("--cache", full.folder)
    assert command._time(1e15).year == 1970
