"""Is a place that cannot be written refused before the work, and is no result lost at its end?"""

from __future__ import annotations

import json
import os

import pytest
from made_up_baselines import baseline
from small_suites import run, suite_file

from simtip.errors import InputError
from simtip.output_folder import check_writable
from simtip.regress.baseline_file import write_baseline
from simtip.sweep.table import Table


@pytest.fixture
def base(tmp_path):
    """A baseline and its suite; nothing of it is worked out."""
    suite_file(tmp_path)
    file = tmp_path / "base.yaml"
    write_baseline(file, baseline())
    return file


@pytest.fixture
def idle(monkeypatch):
    """Let no work begin."""

    def begin(*_: object, **__: object) -> None:
        raise AssertionError("the work has begun")

    monkeypatch.setattr("simtip.regress.check.check", begin)
    monkeypatch.setattr("simtip.regress.record.record", begin)


@pytest.fixture(params=["readonly", "fifo"])
def bad(request, tmp_path):
    """A file in a folder that takes none, or one that is no file."""
    if request.param == "fifo":
        place = tmp_path / "pipe.yaml"
        os.mkfifo(place)
        return place
    place = tmp_path / "readonly"
    place.mkdir(mode=0o500)
    if os.access(place, os.W_OK):  # root may write everywhere; nobody into /proc
        return "/proc/file.yaml"
    return place / "file.yaml"


@pytest.mark.usefixtures("idle")
@pytest.mark.parametrize("option", ["--junit", "--summary"])
def test_files_for_others(ask, base, bad, option):
    done = ask("regress", "check", str(base), option, str(bad))
    assert (done.code, done.out) == (2, "")
    assert done.err.count("\n") == 1
    assert str(bad) in done.err


@pytest.mark.usefixtures("idle")
def test_the_summary_of_a_job(ask, base, tmp_path, monkeypatch):
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "/proc/summary.md")
    done = ask("regress", "check", str(base))
    assert (done.code, done.out) == (2, "")
    assert "/proc/summary.md" in done.err
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path))
    assert "unset GITHUB_STEP_SUMMARY" in ask("regress", "check", str(base)).err


@pytest.mark.usefixtures("idle")
def test_a_baseline(ask, base, bad):
    suite = base.with_name("suite.yaml")
    done = ask("regress", "record", str(suite), "-o", str(bad))
    assert (done.code, done.out) == (2, "")
    assert str(bad) in done.err


def test_what_is_checked_is_as_it_was(tmp_path):
    file = tmp_path / "there.xml"
    file.write_text("before")
    check_writable(file)
    check_writable(tmp_path / "new.xml")
    assert [one.name for one in tmp_path.iterdir()] == ["there.xml"]
    assert file.read_text() == "before"
    with pytest.raises(InputError, match="its folder does not exist"):
        check_writable(tmp_path / "none" / "x.xml")
    with pytest.raises(InputError, match="is a folder"):
        check_writable(tmp_path)


@pytest.mark.slow
def test_a_disk_that_is_full_at_the_end_loses_no_result(tmp_path):
    """The summary's device takes nothing: what was found is said all the same."""
    if not os.path.exists("/dev/full"):  # noqa: PTH110 (no file of ours)
        pytest.skip("needs /dev/full")
    cache, base = tmp_path / "cache", tmp_path / "base.yaml"
    run("record", suite_file(tmp_path, cases=[{"name": "a"}]), "-o", base, cache=cache)
    out, error = run("check", base, "--json", cache=cache, code=2, GITHUB_STEP_SUMMARY="/dev/full")
    assert json.loads(out)["verdict"] == "same or better"
    assert "/dev/full: cannot be written" in error.splitlines()[-1]


@pytest.mark.slow
def test_rows_that_were_removed_are_worked_out_anew_and_a_file_in_their_place_is_named(tmp_path):
    cache, base, out = tmp_path / "cache", tmp_path / "base.yaml", tmp_path / "out"
    run("record", suite_file(tmp_path, cases=[{"name": "a"}]), "-o", base, cache=cache)
    run("check", base, "-o", out, cache=cache)
    (rows,) = (out / "sweeps" / "000").glob("rows*")
    before = Table.open(rows.parent).frame().drop(columns=["render_s", "sensor_s", "detect_s"])
    for part in rows.iterdir():
        part.unlink()
    rows.rmdir()
    run("check", base, "-o", out, cache=cache)
    again = Table.open(rows.parent).frame().drop(columns=["render_s", "sensor_s", "detect_s"])
    assert again.equals(before)
    for part in rows.iterdir():
        part.unlink()
    rows.rmdir()
    rows.write_text("a file")
    _, error = run("check", base, "-o", out, cache=cache, code=2)
    assert f"{rows}: is a file where the folder of the rows was" in error
