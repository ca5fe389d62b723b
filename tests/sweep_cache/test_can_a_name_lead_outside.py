"""Can a kind or a key, or what lies in the folder, make the cache touch anything else?"""

from __future__ import annotations

import pytest
from cache_processes import KEYS, blocks

from simtip.sweep.cache import Cache

KEY = KEYS[0]
BAD_KEYS = [
    "", "..", "../../../x", "/etc/passwd", "a" * 15, "a" * 65, "A" * 16, "g" * 16, "0" * 16 + "\n",
    "0" * 15 + "/", "0" * 15 + "\0", "\u0660" * 16, "0" * 16 + ".log", "0123456789abcdef/../x",
]  # fmt: skip
BAD_KINDS = [
    "",
    ".",
    "..",
    "tmp",
    "locks",
    "Light",
    "light/x",
    "light\n",
    "lumière",
    "a-b",
    "a" + "\0",
]


def uses(cache, kind, key):
    """Give every use of a kind and a key."""
    return [
        lambda: cache.entry(kind, key),
        lambda: cache.put(kind, key, lambda _: pytest.fail("was called")),
        lambda: cache.lock(kind, key).__enter__(),
        lambda: cache.append(kind, key, "record"),
        lambda: cache.lines(kind, key),
        lambda: cache.discard(kind, key),
    ]


@pytest.mark.parametrize(
    ("kind", "key"), [("light", k) for k in BAD_KEYS] + [(k, KEY) for k in BAD_KINDS], ids=ascii
)
def test_a_hostile_name_is_refused_and_nothing_is_made(cache, kind, key):
    for use in uses(cache, kind, key):
        with pytest.raises(ValueError, match="of a cache"):
            use()
    if key == KEY:
        with pytest.raises(ValueError, match="kind of a cache"):
            cache.clear(kind)
    assert not cache.folder.exists()


@pytest.mark.parametrize("key", ["0123456789abcdef", "f" * 64])
def test_the_shortest_and_the_longest_key_can_be_used(cache, key):
    assert cache.put("a", key, blocks(2)) == cache.entry("a", key)
    cache.append("a", key, "record")
    assert cache.lines("a", key) == ["record"]


def test_clearing_leaves_what_is_no_cache(tmp_path):
    cache = Cache(tmp_path)
    cache.put("light", KEY, blocks(2))
    mine = [
        "mine.txt", "light/00/0123456789abcdef/a", "v1/light/notes.txt", "v1/light/00/notes.txt",
        "v1/Light/00/0123456789abcdef/a", "v1/light/00/0123456789/a", "v1/light/00/0123456789.log",
        "v2/light/00/0123456789abcdef/a",
    ]  # fmt: skip
    for name in mine:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("mine")
    cache.clear()
    cache.trim(0)
    cache.sweep_up()
    assert cache.entry("light", KEY) is None
    assert [name for name in mine if not (tmp_path / name).exists()] == []


@pytest.mark.parametrize("link", ["v1/light", "v1/light/00", f"v1/light/00/{KEY}"])
def test_links_are_not_followed_when_something_is_removed(tmp_path, link):
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "00" / KEY).mkdir(parents=True)
    (elsewhere / KEY).mkdir()
    (elsewhere / "00" / KEY / "mine").write_text("mine")
    (elsewhere / KEY / "mine").write_text("mine")
    place = tmp_path / "cache" / link
    place.parent.mkdir(parents=True)
    place.symlink_to(elsewhere)
    cache = Cache(tmp_path / "cache")
    assert (cache.summary(), cache.clear(), cache.trim(0)) == ({}, 0, 0)
    assert len(list(elsewhere.rglob("mine"))) == 2


def test_a_link_in_an_entry_goes_alone(cache, tmp_path):
    (tmp_path / "mine").write_text("mine")
    cache.put("light", KEY, lambda folder: (folder / "link").symlink_to(tmp_path))
    cache.clear()
    assert (tmp_path / "mine").read_text() == "mine"
