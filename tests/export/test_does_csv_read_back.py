"""Tables as pandas reads them: every number to the last bit, texts as texts."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from export.exported import exported

from simtip.export.csv_stream import csv_rows


@pytest.fixture(scope="module")
def out(plain, bevel, hidden, tmp_path_factory) -> Path:
    return exported(tmp_path_factory.mktemp("csv") / "out", "csv", plain, bevel, hidden)


@pytest.fixture(scope="module")
def table(out) -> pd.DataFrame:
    return pd.read_csv(out / "pairs.csv", engine="python")


def numbers(row: pd.Series, *names: str) -> list[float]:
    return [float(row[name]) for name in names]


def test_what_is_true_reads_back_to_the_last_bit(table, plain, bevel, hidden):
    for row, source in zip(table.itertuples(index=False), (plain, bevel, hidden), strict=True):
        told = pd.Series(row._asdict() if hasattr(row, "_asdict") else row, index=table.columns)
        truth = json.loads((source / "truth.json").read_text())
        assert numbers(told, *(f"true_tip_{a}_mm" for a in "xyz")) == truth["tip_mm"]
        assert numbers(told, *(f"axis_{a}" for a in "xyz")) == truth["axis"]
        for side in ("left", "right"):
            true = truth[side]
            places = {"true_tip": "tip_px", "silhouette_tip": "silhouette_tip_px"}
            for name, key in places.items():
                assert numbers(told, *(f"{side}_{name}_{a}_px" for a in "uv")) == true[key]
            assert numbers(told, f"{side}_axis_u", f"{side}_axis_v") == true["axis_px"]
            K = np.array(true["K_px"])
            names = (f"{side}_{name}_px" for name in ("fx", "fy", "cx", "cy"))
            assert numbers(told, *names) == [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]
            size = numbers(told, f"{side}_width_px", f"{side}_height_px")
            assert size == [true["width_px"], true["height_px"]]


def test_the_pose_is_opencvs(table, plain):
    file = cv2.FileStorage(str(plain / "rig_true.yaml"), cv2.FILE_STORAGE_READ)
    row = table.iloc[0]
    R = numbers(row, *(f"R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)))
    assert file.getNode("R").mat().ravel().tolist() == R
    assert numbers(row, *(f"T_{a}_mm" for a in "xyz")) == file.getNode("T").mat().ravel().tolist()


def test_distortion_is_in_opencvs_order(bent_lens, tmp_path):
    out = exported(tmp_path / "out", "csv", bent_lens)
    row = pd.read_csv(out / "pairs.csv", engine="python").iloc[0]
    names = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    left = numbers(row, *(f"left_{name}" for name in names))
    assert left == [-0.12, 0.05, 0.001, -0.0008, 0.01, 0, 0, 0]
    assert numbers(row, *(f"right_{name}" for name in names[:5])) == [
        -0.10,
        0.04,
        -0.0007,
        0.0012,
        0,
    ]


def test_what_was_measured_is_there_and_empty_where_nothing_was(table, plain):
    result = json.loads((plain / "result.json").read_text())
    row = table.iloc[0]
    assert result["status"] == row["status"] == "ok"
    assert row["detector"] == "lin2020"
    assert numbers(row, *(f"measured_tip_{a}_mm" for a in "xyz")) == result["tip_measured_mm"]
    for side in ("left", "right"):
        found = numbers(row, *(f"{side}_detected_tip_{a}_px" for a in "uv"))
        assert found == result["tip_detected_px"][side]
    rendered = table.iloc[1]
    measured = [name for name in table if name.startswith(("measured", "status", "detector"))]
    assert len(measured) == 5
    assert rendered[measured].isna().all()


def test_files_are_there_and_masks_have_their_area(out, table):
    for _, row in table.iterrows():
        for side in ("left", "right"):
            image = cv2.imread(str(out / row[f"{side}_image"]), cv2.IMREAD_UNCHANGED)
            mask = cv2.imread(str(out / row[f"{side}_mask"]), cv2.IMREAD_UNCHANGED)
            assert image.shape[:2] == mask.shape
            assert set(np.unique(mask)) == {0, 255}
            assert (mask > 0).sum() == row[f"{side}_mask_area_px"]
    assert table["left_tip_visible"].tolist() == [True, True, False]  # a cable hides the last


def test_boards_have_a_row_a_view_and_a_row_a_point(boards, tmp_path):
    out = exported(tmp_path / "out", "csv", boards)
    views = pd.read_csv(out / "pairs.csv", engine="python")
    points = pd.read_csv(out / "points.csv", engine="python")
    truth = json.loads((boards / "truth.json").read_text())
    assert len(views) == 3
    assert len(points) == 3 * 2 * 9
    for k, view in enumerate(truth["views"]):
        row = views.iloc[k]
        assert row["label"] == f"view {view['name']}"
        R = numbers(row, *(f"board_R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)))
        assert np.ravel(view["R"]).tolist() == R
        assert numbers(row, *(f"board_t_{a}_mm" for a in "xyz")) == view["t_mm"]
        for side in ("left", "right"):
            part = points[(points["pair"] == k) & (points["side"] == side)]
            assert part[["u_px", "v_px"]].to_numpy().tolist() == view[side]["points_px"]
            assert part["visible"].tolist() == view[side]["visible"]
            true = truth["plate"]["points_mm"]
            assert part[[f"board_{a}_mm" for a in "xyz"]].to_numpy().tolist() == true
            made, taken = (
                cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
                for file in (out / row[f"{side}_image"], boards / view[side]["file"])
            )
            assert np.array_equal(made, taken)


HOSTILE = ["=1+1", "+cmd", "-2", "@SUM(A1)", "<script>alert(1)</script>", 'a "b", c', "two\nlines"]


def test_texts_are_no_formulas_and_come_back(tmp_path):
    with csv_rows(tmp_path / "t.csv", ["text", "=head", "number"]) as rows:
        for text in HOSTILE:
            rows.add({"text": text, "number": -0.1})
    with (tmp_path / "t.csv").open(newline="") as stream:
        header, *found = csv.reader(stream)
    assert header == ["text", "'=head", "number"]
    for text, (cell, empty, number) in zip(HOSTILE, found, strict=True):
        assert cell == (f"'{text}" if text[0] in "=+-@" else text)
        assert (empty, number) == ("", "-0.1")


def test_a_column_that_is_not_there_is_an_error(tmp_path):
    with csv_rows(tmp_path / "t.csv", ["a"]) as rows, pytest.raises(KeyError, match="b"):
        rows.add({"a": 1, "b": 2})


def test_a_folder_named_like_a_formula_or_markup_stays_text(plain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = ["=cmd", "<script>alert(1)<script>", "\udcff"]
    for name in names:
        Path(name).symlink_to(plain)
    out = exported(tmp_path / "out", "opencv", *map(Path, names))
    with (out / "sources.csv").open(newline="", encoding="utf-8") as stream:
        _, *rows = csv.reader(stream)
    assert [row[2] for row in rows] == ["'=cmd", names[1], "\\udcff"]
