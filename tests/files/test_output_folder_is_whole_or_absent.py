"""Does an output folder appear whole or not at all, and is what exists never touched?"""

import os
import stat
from pathlib import Path

import pytest

from simtip import output_folder
from simtip.errors import InputError
from simtip.output_folder import OutputFolder, write_atomically


def tree(folder):
    """Every path below a folder, with what the files hold."""
    return {
        str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None
        for p in folder.rglob("*")
    }


def fill(folder):
    (folder / "result.json").write_text("{}")
    (folder / "left").mkdir()
    (folder / "left" / "image.png").write_bytes(b"x")


FILLED = {"result.json": b"{}", "left": None, "left/image.png": b"x"}


@pytest.mark.parametrize("name", ["out", "out/", "new/parents/out", "игла"])
def test_a_new_folder_appears_at_the_end(tmp_path, name):
    target = tmp_path / name
    with OutputFolder(f"{tmp_path}/{name}") as folder:
        assert folder.parent == target.parent
        assert not target.exists()
        fill(folder)
        assert not target.exists()
    assert tree(target) == FILLED
    assert [p.name for p in target.parent.iterdir()] == [target.name]


def test_an_empty_folder_is_replaced(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    with OutputFolder(target) as folder:
        fill(folder)
        assert tree(target) == {}
    assert tree(tmp_path) == {"out": None} | {f"out/{k}": v for k, v in FILLED.items()}


def test_a_relative_path_is_taken_from_where_the_work_began(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    with OutputFolder("out") as folder:
        fill(folder)
        os.chdir(tmp_path / "elsewhere")
    assert tree(tmp_path / "out") == FILLED


def test_a_link_to_an_empty_folder_is_followed(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    with OutputFolder(tmp_path / "link") as folder:
        fill(folder)
    assert (tmp_path / "link").is_symlink()
    assert tree(tmp_path / "real") == FILLED


def test_permissions_are_those_of_any_new_folder(tmp_path):
    before = os.umask(0o027)
    try:
        with OutputFolder(tmp_path / "out") as folder:
            write_atomically(folder / "a.txt", b"a")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "out").stat().st_mode) == 0o750
    assert stat.S_IMODE((tmp_path / "out" / "a.txt").stat().st_mode) == 0o640


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, InputError])
@pytest.mark.parametrize("name", ["out", "new/parents/out", "empty"])
def test_an_exception_leaves_nothing_behind(tmp_path, error, name):
    (tmp_path / "empty").mkdir()

    def work():
        with OutputFolder(tmp_path / name) as folder:
            fill(folder)
            raise error("stop")

    with pytest.raises(error, match="stop"):
        work()
    assert tree(tmp_path) == {"empty": None}


def refused():
    """Make each kind of target that may not be used, in the working folder; yield its path."""
    Path("full").mkdir()
    Path("full/mine.txt").write_text("mine")
    Path("file").write_text("mine")
    Path("dangling").symlink_to("full/none/none")
    Path("loop").symlink_to("loop")
    Path("to_full").symlink_to("full")
    os.mkfifo("pipe")
    return {
        "full": "not empty",
        "to_full": "not empty",
        "file": "not a folder",
        "pipe": "not a folder",
        "loop": "not a folder|cannot be written",
        "file/out": "cannot be written",
        "file/new/out": "cannot be written",
        "x" * 300: "cannot be written",
        "a\0b": "cannot be written",
        "": "not empty",
        ".": "not empty",
        "/": "not empty",
        "/proc/out": "cannot be written",
        "/proc/new/out": "cannot be written",
        "/dev/null": "not a folder",
        "/dev/null/out": "cannot be written",
    }


KINDS = [
    "full", "to_full", "file", "pipe", "loop", "file/out", "file/new/out", "x" * 300, "a\0b", "",
    ".", "/", "/proc/out", "/proc/new/out", "/dev/null", "/dev/null/out",
]  # fmt: skip


@pytest.mark.parametrize("path", KINDS, ids=lambda p: repr(p)[:20])
def test_what_cannot_be_used_is_refused_early_and_not_touched(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    pattern = refused()[path]
    before = {p.name: p.lstat() for p in tmp_path.iterdir()}
    content = Path("full/mine.txt").read_text()
    for attempt in (OutputFolder(path).check, OutputFolder(path).__enter__):
        with pytest.raises(InputError, match=pattern) as caught:
            attempt()
        assert caught.value.file == path
        assert caught.value.remedy
        assert "\n" not in str(caught.value)
    assert Path("full/mine.txt").read_text() == content == "mine"
    after = {p.name: p.lstat() for p in tmp_path.iterdir()}
    assert after.keys() == before.keys()
    assert all(after[k].st_ino == before[k].st_ino for k in before)


def test_the_working_folder_is_refused_though_it_is_empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="working folder"):
        OutputFolder(".").check()


def test_a_mount_point_is_refused_though_it_is_empty(tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    monkeypatch.setattr(output_folder.os.path, "ismount", lambda _: True)
    with pytest.raises(InputError, match="mount point"):
        OutputFolder(tmp_path / "out").check()


def test_a_parent_without_permission_is_refused(tmp_path, monkeypatch):
    def refuse(*_args, **_kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(output_folder.Path, "mkdir", refuse)
    for attempt in (OutputFolder(tmp_path / "out").check, OutputFolder(tmp_path / "o").__enter__):
        with pytest.raises(InputError, match=r"cannot be written \(Permission denied\)"):
            attempt()


def test_checking_leaves_no_trace(tmp_path):
    OutputFolder(tmp_path / "new" / "out").check()
    assert tree(tmp_path) == {}


def test_what_appeared_meanwhile_is_not_overwritten(tmp_path):
    target = tmp_path / "out"

    def work():
        with OutputFolder(target) as folder:
            fill(folder)
            target.mkdir()
            (target / "mine.txt").write_text("mine")

    with pytest.raises(InputError, match="cannot be written"):
        work()
    assert tree(tmp_path) == {"out": None, "out/mine.txt": b"mine"}


def test_parents_that_others_use_by_now_stay(tmp_path):
    def work():
        with OutputFolder(tmp_path / "new" / "out"):
            (tmp_path / "new" / "mine.txt").write_text("mine")
            raise ValueError("stop")

    with pytest.raises(ValueError, match="stop"):
        work()
    assert tree(tmp_path) == {"new": None, "new/mine.txt": b"mine"}


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "a.txt"
    write_atomically(path, b"old")
    write_atomically(path, b"new")
    assert tree(tmp_path) == {"a.txt": b"new"}
