"""Images of a sweep's trials: once each, from the cache or made again, and the same ones."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from cli.command_line import one_line, snapshot
from export.exported import exported
from sweep.small_sweeps import run, sweep_file
from sweep.spoilt_tables import filled, without_column

from simtip.sweep.table import Table

pytestmark = pytest.mark.slow

TIPS = [{"kind": "cone", "length_mm": 5}, {"kind": "bevel", "angle_deg": 20}]
FACTORS = {
    "needle.tip": TIPS,
    "lamps[0].power": [1.0, 1.2],
    "name": ["<b>one</b>", "=two"],
    "detect.threshold": {"from": 60, "to": 120, "count": 3},
}


@pytest.fixture(scope="module")
def swept(tmp_path_factory) -> Path:
    """A folder with the sweep ``out`` and its ``cache``: 2 renders, 4 pairs, 24 trials."""
    folder = tmp_path_factory.mktemp("swept")
    run(sweep_file(folder, factors=FACTORS), folder / "out", "--workers", "1")
    return folder


@pytest.fixture(scope="module")
def table(swept, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("csv") / "out"
    return exported(out, "csv", swept / "out", more=("--cache", str(swept / "cache")))


def rows_of(out: Path) -> pd.DataFrame:
    return pd.read_csv(out / "pairs.csv", engine="python")


def test_each_pair_is_written_once_and_each_trial_has_a_row(table):
    rows = rows_of(table)
    assert len(rows) == 24
    assert rows["pair"].nunique() == len(list((table / "images").iterdir())) / 2 == 4
    assert sorted(rows["trial"]) == list(range(24))
    same = rows.groupby("pair")[["needle.tip", "lamps[0].power"]].nunique()
    assert (same == 1).all().all()


def test_rows_say_what_the_sweeps_table_says(table, swept):
    """Measured - true is the table's error, to rounding; settings are its own."""
    rows, told = rows_of(table).set_index("trial"), Table.open(swept / "out").frame()
    for _, row in told.iterrows():
        ours = rows.loc[row["trial"]]
        assert ours["status"] == row["status"]
        assert ours["detect.threshold"] == row["detect.threshold"]
        assert json.loads(ours["needle.tip"]) == json.loads(row["needle.tip"])
        if row["status"] != "ok":
            continue
        for axis in "xyz":
            error = ours[f"measured_tip_{axis}_mm"] - ours[f"true_tip_{axis}_mm"]
            assert error == pytest.approx(row[f"error_{axis}_mm"], abs=1e-12)
        for axis in "uv":
            error = ours[f"left_detected_tip_{axis}_px"] - ours[f"left_true_tip_{axis}_px"]
            assert error == pytest.approx(row[f"left_error_{axis}_px"], abs=1e-9)


def test_values_that_hold_markup_or_formulas_are_text(table):
    with (table / "pairs.csv").open(newline="") as stream:
        found = {row["name"] for row in csv.DictReader(stream)}
    assert found == {"<b>one</b>", "'=two"}


def test_images_that_are_not_in_the_cache_are_made_again_the_same(table, swept, tmp_path):
    out = exported(
        tmp_path / "out", "opencv", swept / "out", more=("--cache", str(tmp_path / "new"))
    )
    for number in range(4):
        for side in ("left", "right"):
            made, kept = (
                cv2.imread(str(file))
                for file in (
                    out / f"{side}_{number:06d}.png",
                    table / "images" / f"{number:06d}_{side}.png",
                )
            )
            assert np.array_equal(made, kept)


def test_images_are_what_the_detector_saw(table, swept):
    """Detecting on an exported image gives the row's own tip."""
    from simtip.detect import configure
    from simtip.image_file import read_image

    row = next(row for _, row in rows_of(table).iterrows() if row["status"] == "ok")
    detector = configure(
        "lin2020", {"threshold": float(row["detect.threshold"]), "min_area_px": 300}
    )
    seen = detector(read_image(table / row["left_image"]))
    found = [row[f"left_detected_tip_{axis}_px"] for axis in "uv"]
    assert seen.tip_px == pytest.approx(found, abs=1e-9)
    assert swept.exists()


def test_a_scene_of_bop_is_a_sweep_and_each_shape_a_model(swept, tmp_path):
    out = exported(
        tmp_path / "out",
        "bop",
        swept / "out",
        more=("--cache", str(swept / "cache"), "--where", "detect.threshold<70"),
    )
    poses = json.loads((out / "test" / "000000" / "scene_gt.json").read_text())
    assert [poses[str(k)][0]["obj_id"] for k in range(8)] == [1, 1, 1, 1, 2, 2, 2, 2]
    tips = json.loads((out / "models" / "tips.json").read_text())
    assert [tips["1"]["kind"], tips["2"]["kind"]] == ["cone", "bevel"]


def test_where_chooses_trials(swept, tmp_path, ask):
    more = ("--cache", str(swept / "cache"), "--where", "lamps[0].power==1.2")
    out = exported(tmp_path / "out", "csv", swept / "out", more=more)
    rows = rows_of(out)
    assert len(rows) == 12
    assert rows["pair"].nunique() == 2
    assert set(rows["lamps[0].power"]) == {1.2}
    answer = ask(
        *("export", str(swept / "out"), "--format", "csv", "-o", str(tmp_path / "none")),
        *("--where", "lamps[0].power==7"),
    )
    assert answer.code == 2
    assert "no trial that is asked for has images" in one_line(answer.err)


def test_other_code_makes_no_images_under_an_old_name(swept, tmp_path, ask, monkeypatch):
    """Not in the cache, and this simtip's key differs: refused, not quietly made anew."""
    monkeypatch.setattr("simtip.sweep.stage_keys.__version__", "0.0.0")
    from simtip.sweep import stage_keys

    stage_keys._stage_code.cache_clear()
    try:
        arguments = ("export", str(swept / "out"), "--format", "opencv", "-o")
        before = snapshot(swept)
        answer = ask(*arguments, str(tmp_path / "out"), "--cache", str(tmp_path / "new"))
        assert answer.code == 2
        assert "are not in the cache, and this simtip" in one_line(answer.err)
        assert not (tmp_path / "out").exists()
        # What is in the cache is what the trial saw, whoever asks.
        kept = ask(*arguments, str(tmp_path / "kept"), "--cache", str(swept / "cache"))
        assert kept.code == 0, kept.err
        assert snapshot(swept).keys() == before.keys()
    finally:
        stage_keys._stage_code.cache_clear()


def test_a_row_that_was_scored_against_another_tip_is_refused(swept, tmp_path, ask):
    shutil.copytree(swept / "out", tmp_path / "edited")
    table = Table.open(tmp_path / "edited")
    rows = [
        [{**row, "error_x_mm": row["error_x_mm"] and row["error_x_mm"] + 1e-3} for row in batch]
        for batch in table.batches()
    ]
    table.rewrite(table.columns, rows, table.provenance)
    answer = ask(
        *("export", str(tmp_path / "edited"), "--format", "opencv"),
        *("-o", str(tmp_path / "out"), "--cache", str(swept / "cache")),
    )
    assert answer.code == 2
    assert "was scored against another tip" in one_line(answer.err)


def test_a_table_that_names_a_program_starts_none(swept, tmp_path):
    """The detectors of a sweep are not looked at."""
    shutil.copytree(swept / "out", tmp_path / "named")
    table = Table.open(tmp_path / "named")
    sweep = json.loads(table.provenance["sweep"])
    sweep["detectors"] = [f"cmd:touch {tmp_path}/ran {{image}}", "evil_module:function"]
    scene = json.loads(table.provenance["scene"])
    scene["detect"] = {"name": f"cmd:touch {tmp_path}/ran {{image}}"}
    about = {**table.provenance, "sweep": json.dumps(sweep), "scene": json.dumps(scene)}
    table.rewrite(table.columns, list(table.batches()), about)
    more = ("--cache", str(swept / "cache"))
    exported(tmp_path / "out", "opencv", tmp_path / "named", more=more)
    assert not (tmp_path / "ran").exists()


def test_a_damaged_table_is_named(swept, tmp_path, ask):
    shutil.copytree(swept / "out", tmp_path / "cut")
    part, *_ = sorted((tmp_path / "cut").glob("rows*/part-*.parquet"))
    part.write_bytes(part.read_bytes()[:-100])
    answer = ask("export", str(tmp_path / "cut"), "--format", "csv", "-o", str(tmp_path / "out"))
    assert answer.code == 2
    assert f"{part.name}: is damaged" in one_line(answer.err)


def test_a_table_of_an_unknown_sweep_is_named(swept, tmp_path, ask):
    shutil.copytree(swept / "out", tmp_path / "other")
    head = json.loads((tmp_path / "other" / "table.json").read_text())
    head["provenance"]["sweep"] = "{}"
    (tmp_path / "other" / "table.json").write_text(json.dumps(head))
    answer = ask("export", str(tmp_path / "other"), "--format", "csv", "-o", str(tmp_path / "out"))
    assert answer.code == 2
    assert "table.json: does not say of which sweep" in one_line(answer.err)


def test_an_experiment_is_all_its_sweeps(tmp_path):
    from experiment.small_experiment import asked, scene_file

    brighter = {"name": "brighter", "set": {"lamps[0].power": 1.1}}
    file = scene_file(tmp_path, schedule={"steps": 3, "runs": 2}, setups=[brighter])
    told = asked("mca", file, "-o", tmp_path / "out")
    out = exported(
        tmp_path / "csv", "csv", tmp_path / "out", more=("--cache", str(tmp_path / "cache"))
    )
    rows = rows_of(out)
    assert len(told["setups"]) == rows["source"].nunique() == 2
    assert rows["pair"].nunique() == told["worked_out"]["images"]
    places = rows[[f"true_tip_{axis}_mm" for axis in "xyz"]].drop_duplicates()
    assert len(places) == 4


def test_pairs_that_differ_by_their_light_alone_are_traced_once(swept, tmp_path, monkeypatch):
    import simtip.export.tracer

    traced = []
    original = simtip.export.tracer.trace_surfaces

    def counted(spec, **more):
        traced.append(spec.needle.tip.kind)
        return original(spec, **more)

    monkeypatch.setattr("simtip.export.tracer.trace_surfaces", counted)
    more = ("--cache", str(swept / "cache"))
    out = exported(tmp_path / "out", "coco", swept / "out", more=more)
    assert traced == ["cone", "bevel"]
    told = json.loads((out / "annotations.json").read_text())["annotations"]
    areas = [one["area"] for one in told]
    assert areas == [*areas[:2], *areas[:2], *areas[4:6], *areas[4:6]]
    assert areas[0] != areas[4]


SPOILT = {
    "a column missing": (
        lambda folder: without_column(folder, "image_key"),
        "table.json: columns: lists no column image_key",
    ),
    "a key that leads elsewhere": (
        lambda folder: filled(folder, "image_key", "../../x"),
        "image_key: trial 0 has '../../x', which is no key of images",
    ),
    "a trial without a number": (
        lambda folder: filled(folder, "trial", None),
        "rows: a row has no trial",
    ),
    "measured, and no tip": (
        lambda folder: filled(folder, "tip_x_mm", None),
        "was scored against another tip",
    ),
}


@pytest.mark.parametrize("case", SPOILT)
def test_a_spoilt_table_is_one_line(case, swept, tmp_path, ask):
    spoil, said = SPOILT[case]
    shutil.copytree(swept / "out", tmp_path / "sweep")
    spoil(tmp_path / "sweep")
    before = snapshot(tmp_path)
    words = ["--format", "opencv", "-o", tmp_path / "made", "--cache", swept / "cache"]
    answer = ask("export", *map(str, [tmp_path / "sweep", *words]))
    assert said in one_line(answer.err)
    assert answer.code == 2
    assert snapshot(tmp_path) == before
