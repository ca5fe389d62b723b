"""Folders that hold nothing, too little or something else: one line, and nothing written."""

from __future__ import annotations

import json
import shutil

import cv2
import numpy as np
import pytest
from made_tables import grid
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


def test_a_table_that_is_damaged(tmp_path, complaint):
    folder = grid(tmp_path / "sweep")
    part = next(folder.glob("rows/part-*.parquet"))
    part.write_bytes(part.read_bytes()[:100])
    assert "part-" in complaint(folder)
    (folder / "table.json").write_text("{")
    assert "table.json: is damaged or no table of a sweep" in complaint(folder)


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
