"""Folders that hold nothing, too little or something else: one line, and nothing written."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
from made_tables import grid
from sweep.spoilt_tables import filled, without_column
from typer.testing import CliRunner

from simtip.cli.program import main


@pytest.fixture
def complaint(capsys):
    """Ask for a report that cannot be, and give what is said."""

    def of(*words: object) -> str:
        with pytest.raises(SystemExit) as ended:
            main(["report", *map(str, words)])
        said = capsys.readouterr()
        assert ended.value.code == 2
        assert not said.out
        assert said.err.count("\n") == 1
        assert "Traceback" not in said.err
        return said.err

    return of


def test_a_folder_that_is_none(tmp_path, complaint):
    assert "no such folder; name the folder of a run, render" in complaint(tmp_path / "gone")
    (tmp_path / "file").write_text("x")
    assert "is not a folder" in complaint(tmp_path / "file")
    (tmp_path / "empty").mkdir()
    said = complaint(tmp_path / "empty")
    assert "holds no results of simtip" in said
    assert all(
        kind in said for kind in ("sweep", "mca", "budget", "boards", "calibrate", "regress")
    )
    assert not list((tmp_path / "empty").iterdir())


def test_a_run_that_was_cut_short(tmp_path, complaint):
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "truth.json").write_text("{}")
    assert "is cut short: there is no manifest.json" in complaint(folder)
    (folder / "manifest.json").write_text('{"seed"')
    assert "manifest.json: is damaged or cut short" in complaint(folder)
    (folder / "manifest.json").write_text("{}")
    (folder / "scene.yaml").write_text("name: x")
    assert "left.png: no such file" in complaint(folder)
    cv2.imwrite(str(folder / "left.png"), np.zeros((4, 6), np.uint8))
    assert "truth.json: is damaged or cut short" in complaint(folder)


def test_an_image_that_is_missing_or_cut_short(tmp_path, complaint, ran):
    folder = tmp_path / "run"
    shutil.copytree(ran, folder)
    image = (folder / "right.png").read_bytes()
    (folder / "right.png").unlink()
    assert "right.png: no such file" in complaint(folder)
    (folder / "right.png").write_bytes(image[: len(image) // 2])
    assert "right.png: is cut short" in complaint(folder)
    assert not (folder / "report.html").exists()


@pytest.fixture
def edited(tmp_path, ran):
    """Put a value into a field of one of a run's files, and give the folder."""

    def of(name: str, path: str, value: object):
        folder = tmp_path / "run"
        if not folder.exists():
            shutil.copytree(ran, folder)
        shutil.copy(ran / name, folder / name)
        data = json.loads((folder / name).read_text())
        part, keys = data, path.split(".")
        for key in keys[:-1]:
            part = part[key]
        part[keys[-1]] = value
        (folder / name).write_text(json.dumps(data))
        return folder

    return of


SPOILT = [
    ("truth.json", "tip_mm"),
    ("truth.json", "needle.diameter_mm"),
    ("truth.json", "left.tip_px"),
    ("truth.json", "right.silhouette_tip_px"),
    ("result.json", "tip_measured_mm"),
    ("result.json", "tip_detected_px.left"),
    ("result.json", "error_mm.norm"),
    ("manifest.json", "exposure_s"),
    ("manifest.json", "timings_s"),
]


@pytest.mark.parametrize(("name", "path"), SPOILT)
def test_a_field_that_holds_something_else_names_its_file(edited, complaint, ran, name, path):
    for value in ("text", [10**400] * 3):
        folder = edited(name, path, value)
        assert f"{name}: is damaged or cut short" in complaint(folder)
        assert not (folder / "report.html").exists()
        shutil.copy(ran / name, folder / name)


@pytest.mark.parametrize("name", ["../../../etc/passwd", "/dev/zero", "a/left.png"])
def test_a_listed_file_that_is_elsewhere_is_not_read(edited, complaint, name):
    folder = edited("manifest.json", "sha256", {name: "0" * 64})
    assert f"manifest.json: names {name!r}, which is no file of its folder" in complaint(folder)


@pytest.mark.slow
def test_a_pipe_in_place_of_a_listed_file_does_not_hold_the_page_up(edited):
    folder = edited("manifest.json", "seed", 5)
    (folder / "left_mask.png").unlink()
    os.mkfifo(folder / "left_mask.png")
    subprocess.run([sys.executable, "-m", "simtip", "report", folder], check=True, timeout=120)
    assert "Not as they were written: left_mask.png" in (folder / "report.html").read_text()


def test_what_is_no_unicode_is_shown_all_the_same(edited):
    from simtip.cli.program import app

    folder = edited("truth.json", "needle.tip.kind", "co\ud800ne")
    done = CliRunner().invoke(app, ["report", str(folder)])
    assert done.exit_code == 0, done.output
    assert "co\\ud800ne" in (folder / "report.html").read_text()


def test_a_table_that_is_damaged(tmp_path, complaint):
    folder = grid(tmp_path / "sweep")
    part = next(folder.glob("rows/part-*.parquet"))
    part.write_bytes(part.read_bytes()[:100])
    assert "part-" in complaint(folder)
    (folder / "table.json").write_text("{")
    assert "table.json: is damaged or no table of a sweep" in complaint(folder)


def test_rows_that_are_a_file(tmp_path, complaint, monkeypatch):
    monkeypatch.setattr("simtip.sweep.table._PAUSE_S", 0.0)
    folder = grid(tmp_path / "sweep")
    shutil.rmtree(folder / "rows")
    (folder / "rows").write_text("")
    assert "rows: parts of it are missing" in complaint(folder)


@pytest.mark.parametrize("name", ["repeat", "detector", "reason", "error_norm_mm"])
def test_a_table_without_a_column_that_the_page_needs(tmp_path, complaint, name):
    without_column(grid(tmp_path / "sweep"), name)
    assert f"table.json: columns: lists no column {name}" in complaint(tmp_path / "sweep")


@pytest.mark.parametrize("name", ["trial", "repeat"])
def test_a_row_without_a_number(tmp_path, complaint, name):
    filled(grid(tmp_path / "sweep"), name, None)
    assert f"rows: a row has no {name}" in complaint(tmp_path / "sweep")


def test_a_name_that_is_too_long(tmp_path, complaint, ran):
    name = "x" * 300
    assert "File name too long" in complaint(tmp_path / name)
    assert "File name too long" in complaint(ran, "-o", tmp_path / f"{name}.html")


@pytest.mark.parametrize("kind", ["mca", "budget"])
def test_an_analysis_that_has_not_come_to_its_end(tmp_path, complaint, kind):
    (tmp_path / "experiment.json").write_text(json.dumps({"made_by": f"simtip {kind}"}))
    assert f"there is no {kind}.json; give the same `simtip {kind}`" in complaint(tmp_path)
    (tmp_path / f"{kind}.json").write_text('{"scene": "x"}')
    missing = {"mca": "measurements.csv: no such file", "budget": "budget.json: is damaged"}
    assert missing[kind] in complaint(tmp_path)


def test_options_that_make_no_sense(tmp_path, complaint, ran):
    folder = grid(tmp_path / "sweep")
    assert "--limit" in complaint(folder, "--limit", -1)
    assert "name a file that ends in .html" in complaint(folder, "-o", tmp_path / "page.txt")
    (tmp_path / "mine.html").write_text("my own")
    assert "exists" in complaint(folder, "-o", tmp_path / "mine.html")
    assert (tmp_path / "mine.html").read_text() == "my own"
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "x").write_text("")
    assert "is not empty" in complaint(folder, "--figures", tmp_path / "figures")
    assert not (folder / "report.html").exists()
    (tmp_path / "bound.json").write_text("{}")
    assert "bound.json" in complaint(ran, "--bound", tmp_path / "bound.json")


def test_a_page_is_made_anew_over_an_old_one(tmp_path):
    from simtip.cli.program import app

    folder = grid(tmp_path / "sweep")
    for _ in range(2):
        done = CliRunner().invoke(app, ["report", str(folder), "--pictures", "0"])
        assert done.exit_code == 0, done.output
    assert (folder / "report.html").read_text().startswith("<!doctype html>")


def test_boards_of_another_size_than_they_are_said_to_be(tmp_path, complaint):
    view = {"name": "01", "t_mm": [0, 0, 0]}
    for side in ("left", "right"):
        cv2.imwrite(str(tmp_path / f"{side}_01.png"), np.zeros((4, 6), np.uint8))
        view[side] = {"file": f"{side}_01.png", "visible": [True]}
    truth = {"views": [view], "target": "x", "image_size": {"left": [6, 5], "right": [6, 4]}}
    truth["plate"] = {"points_mm": [], "bow_mm": 0}
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    (tmp_path / "scene.yaml").write_text("name: x")
    assert "left_01.png: has 6 x 4 px, not 6 x 5" in complaint(tmp_path)
