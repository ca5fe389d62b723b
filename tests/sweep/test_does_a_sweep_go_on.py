"""Does a sweep go on: when it is done, its file has changed, a trial failed, the disk was full?"""

import errno

import pytest
import yaml
from small_sweeps import FACTORS, assert_same_rows, rows, run, scene_file, summary, sweep_file
from typer.testing import CliRunner

from simtip.cli.program import app
from simtip.errors import InputError
from simtip.sweep.plan import Plan
from simtip.sweep.resuming import as_json, open_table
from simtip.sweep.sweep_file import read_sweep
from simtip.sweep.table import Table
from simtip.sweep.work import Job, Setup, run_job

FEW = {"detect.threshold": [80, 100], "sensor.exposure_s": [0.045, 0.05]}


def changed(file, **said):
    file.write_text(yaml.safe_dump({"scene": "scene.yaml", **said}))


@pytest.mark.slow
def test_what_is_done_is_not_done_again_and_a_changed_file_adds_what_is_new(tmp_path):
    file, out = sweep_file(tmp_path, factors=FEW), tmp_path / "out"
    assert summary(file, out)["done"] == 4
    assert summary(file, out)["done"] == 0
    changed(file, factors={**FEW, "detect.threshold": [80, 100, 120]})
    said = summary(file, out)
    assert (said["found"], said["done"]) == (4, 2)
    assert said["worked_out"] == {"light": 0, "images": 0, "measure": 2}
    changed(file, factors={**FEW, "detect.threshold": [120, 80]})
    said = summary(file, out)
    assert (said["found"], said["done"]) == (4, 0)
    assert sorted(rows(out)["detect.threshold"]) == [80, 80, 120, 120]
    fresh = tmp_path / "fresh"
    summary(file, fresh, cache=tmp_path / "another")
    assert_same_rows(out, fresh)


@pytest.mark.slow
def test_retry_failed_tries_again_what_has_no_tip(tmp_path):
    file = sweep_file(tmp_path, factors={"detect.threshold": [5, 100]})
    out = tmp_path / "out"
    assert summary(file, out)["failed"] == {"left_nothing_darker_than_threshold": 1}
    assert summary(file, out)["done"] == 0
    assert summary(file, out, "--retry-failed")["done"] == 1
    assert len(rows(out)) == 2


@pytest.mark.slow
def test_a_full_disk_loses_nothing(tmp_path, monkeypatch):
    file, out = sweep_file(tmp_path, factors=FEW, repeats=2), tmp_path / "out"
    append = Table.append
    written = []

    def full(self, given):
        if written:
            raise OSError(errno.ENOSPC, "No space left on device")
        written.append(given)
        append(self, given)

    monkeypatch.setattr(Table, "append", full)
    monkeypatch.setattr("simtip.sweep.running.FLUSH_S", 0.0)
    cache = ["--cache", str(tmp_path / "cache"), "--workers", "1"]
    done = CliRunner().invoke(app, ["sweep", str(file), "-o", str(out), *cache])
    assert isinstance(done.exception, InputError)
    assert "No space left on device" in str(done.exception)
    assert len(rows(out)) == len(written[0])
    monkeypatch.undo()
    said = summary(file, out)
    assert said["found"] == len(written[0])
    assert said["found"] + said["done"] == 8


def test_two_sweeps_do_not_share_a_folder(tmp_path):
    from simtip.sweep.resuming import alone

    file = sweep_file(tmp_path, factors=FEW)
    with alone(tmp_path / "out"):
        said = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out")])
    assert "another sweep is at work in it" in str(said.exception)


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    file = sweep_file(tmp_path, factors=FEW)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "diary.txt").write_text("mine")
    said = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out")])
    assert "holds something else (diary.txt)" in str(said.exception)


@pytest.mark.slow
def test_a_dry_run_says_how_much_and_does_nothing(tmp_path):
    scene_file(tmp_path)
    file = sweep_file(tmp_path, factors=FACTORS, repeats=2)
    options = ["--dry-run", "--json", "--cache", str(tmp_path / "cache")]
    said = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out"), *options])
    told = yaml.safe_load(said.stdout)
    assert (told["trials"], told["renders"], told["images"]) == (64, 2, 16)
    assert told["measurements"] == 64
    assert told["seconds"] > 0
    assert not told["measured_speeds"]
    assert not (tmp_path / "out").exists()
    assert "seconds" not in run(file, tmp_path / "out", "--dry-run", cache=tmp_path / "cache")


@pytest.mark.slow
def test_a_dry_run_knows_what_was_measured(tmp_path):
    """`subpixel` has no threshold: its measurements do not repeat for both of them."""
    thresholds = {"detect.threshold": FEW["detect.threshold"]}
    file = sweep_file(tmp_path, factors=thresholds, detectors=["lin2020", "subpixel"])
    did = summary(file, tmp_path / "out", cache=tmp_path / "cache")
    options = ["--dry-run", "--json", "--cache", str(tmp_path / "cache")]
    told = CliRunner().invoke(app, ["sweep", str(file), "-o", "x", *options])
    said = yaml.safe_load(told.stdout)
    assert said["measured_speeds"]
    assert said["images"] == did["worked_out"]["images"]
    assert said["measurements"] == did["worked_out"]["measure"]
    assert said["cached_renders"] == said["renders"] == did["worked_out"]["light"]
    assert 0.1 * did["seconds"] < said["seconds"] < 5 * did["seconds"]


def setup_of(file, cache=None):
    source = read_sweep(file)
    plan = Plan(source.spec, source.scene)
    sweep, scene = as_json(plan)
    return plan, Setup(sweep, scene, (), "llvm", cache, 10**9, 100.0)


def test_a_job_that_would_take_long_comes_back_with_what_it_has(tmp_path, monkeypatch):
    monkeypatch.setattr("simtip.sweep.work.LONGEST_JOB_S", 0.0)
    _, setup = setup_of(sweep_file(tmp_path, factors=FEW))
    done = run_job(Job(setup, (0, 1, 2, 3)))
    assert [row["trial"] for row in done.rows] == [0]
    assert done.rest == (1, 2, 3)


def test_something_unforeseen_is_a_row(tmp_path, monkeypatch):
    def no_memory(*_, **__):
        raise MemoryError("of 3 TB")

    monkeypatch.setattr("simtip.sweep.stages.measured", no_memory)
    _, setup = setup_of(sweep_file(tmp_path, factors=FEW), str(tmp_path / "cache"))
    (row,) = run_job(Job(setup, (0,))).rows
    assert (row["status"], row["reason"]) == ("error", "MemoryError: of 3 TB")
    monkeypatch.undo()
    assert run_job(Job(setup, (0,))).rows[0]["status"] == "ok"  # nothing wrong was kept


def test_what_a_kill_leaves_before_there_is_a_table_is_no_stranger(tmp_path):
    plan, _ = setup_of(sweep_file(tmp_path, factors=FEW))
    out = tmp_path / "out"
    (out / "rows").mkdir(parents=True)
    (out / ".simtip-table-0123").write_bytes(b"half")
    _, done = open_table(out, plan, {}, retry_failed=False)
    assert not done.any()


@pytest.mark.slow
def test_the_scenes_own_seed_may_vary(tmp_path):
    summary(sweep_file(tmp_path, factors={"seed": [1, 2]}), tmp_path / "out")
    found = rows(tmp_path / "out")
    assert list(found.seed) == [1, 2]
    assert found.light_key.nunique() == found.noise_seed.nunique() == 2
