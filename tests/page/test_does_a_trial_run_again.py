"""The command that the page gives: does it make the very error of the row again?"""

from __future__ import annotations

import contextlib
import json
import shlex

import pytest
import yaml
from made_tables import SCENES, scene_data
from one_process import call_here
from typer.testing import CliRunner

from simtip.cli.program import app
from simtip.page.folder import results_in
from simtip.page.make import page_of
from simtip.page.options import Options
from simtip.page.parts import Code, Entry, Views, Words
from simtip.sweep.table import Table

pytestmark = pytest.mark.slow


def simtip(*words, cwd):
    with contextlib.chdir(cwd):
        done = call_here(*words)
    assert done.code == 0, done.err
    return done.out


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep whose trials share light that is rendered for the strictest of them."""
    folder = tmp_path_factory.mktemp("swept")
    scene = scene_data(
        render={"noise": 1.0, "samples": 32, "light_step_mm": 4.0},
        detect={"name": "lin2020", "min_area_px": 300, "threshold": 90},
    )
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    sweep = {
        "scene": "scene.yaml",
        "factors": {
            "needle.tip": [{"kind": "cone", "length_mm": 5}, {"kind": "bevel", "angle_deg": 20}],
            "detect.threshold": [80, 110],
        },
        "zipped": [
            {
                "lamps[0].power": [0.7, 1.3],
                "sensor.exposure_s": [0.04, 0.05],
                "detect.median_window": [3, 5],
            }
        ],
        "repeats": 2,
        "detectors": ["lin2020", {"name": "subpixel", "label": "fitted"}],
        "seed": 77,
    }
    (folder / "sweep.yaml").write_text(yaml.safe_dump(sweep))
    simtip("sweep", "sweep.yaml", "-o", "out", "--cache", "cache", cwd=folder)
    return folder


def entries(folder, cache, pictures):
    page = page_of(results_in(folder), Options(pictures=pictures, cache=cache, backend="llvm"))
    worst = next(one for one in page.sections if one.name == "worst")
    return [part for part in worst.parts if isinstance(part, Entry)]


def test_every_kind_of_trial_does(swept):
    frame = Table.open(swept / "out").frame()
    shown = entries(swept / "out", swept / "cache", len(frame))
    tried = {}
    for entry in shown:
        number = int(entry.title.split()[1].rstrip(":"))
        row = frame[frame["trial"] == number].iloc[0]
        kind = (row["detector"], row["needle.tip"], row["lamps[0].power"], row["status"])
        tried.setdefault(kind, (entry, row))
    assert len({kind[2] for kind in tried}) == 2
    assert len({kind[0] for kind in tried}) == 2
    seen_light = 0
    for entry, row in list(tried.values())[:5]:
        assert not [part for part in entry.parts if isinstance(part, Words) and part.note]
        codes = [part for part in entry.parts if isinstance(part, Code)]
        for code in codes[1:]:
            (swept / code.name).write_text(code.text)
        command = shlex.split(codes[0].text)
        assert command[:2] == ["simtip", "run"]
        seen_light += "--light" in command
        simtip(*command[1:], cwd=swept)
        result = json.loads((swept / command[command.index("-o") + 1] / "result.json").read_text())
        assert result["status"] == row["status"]
        if row["status"] == "ok":
            error = [result["error_mm"][axis] for axis in "xyz"]
            assert error == [row[f"error_{axis}_mm"] for axis in "xyz"]  # bit for bit
    assert seen_light, "no trial's light was that of another"


def test_pictures_come_out_the_same_without_the_cache(swept, tmp_path):
    first = entries(swept / "out", swept / "cache", 2)
    again = entries(swept / "out", tmp_path / "no cache", 2)
    for one, other in zip(first, again, strict=True):
        pictures = [part for part in one.parts if isinstance(part, Views)]
        assert pictures
        assert pictures == [part for part in other.parts if isinstance(part, Views)]


def test_the_marks_are_where_the_row_says(swept):
    frame = Table.open(swept / "out").frame()
    (entry, *_) = entries(swept / "out", swept / "cache", 1)
    row = frame.loc[frame["error_norm_mm"].idxmax()]
    assert entry.title.startswith(f"Trial {row['trial']}:")
    (views,) = (part for part in entry.parts if isinstance(part, Views))
    for view in views.views:
        off = [view.detected[k] - view.true[k] for k in (0, 1)]
        assert off == pytest.approx(
            [row[f"{view.title}_error_{axis}_px"] for axis in "uv"], abs=1e-9
        )
        assert 0 <= view.true[0] < view.width
        assert 0 <= view.true[1] < view.height


def test_a_detector_that_is_a_program_is_not_started(tmp_path):
    """The table is data, perhaps somebody else's: its detectors are named, no more."""
    from made_tables import make, row

    flag = tmp_path / "started"
    reference = f"cmd:touch {flag} {{image}}"
    rows = [row(k, 0.1 + k, **{"detect.threshold": 60 + k}) for k in range(2)]
    detectors = [{"name": reference, "label": "lin2020"}, {"name": "os:system", "label": "mine"}]
    factors = {"detect.threshold": [60, 61]}
    folder = make(
        tmp_path / "sweep",
        [("detect.threshold", "int")],
        rows,
        detectors=detectors,
        factors=factors,
    )
    (first, *_) = entries(folder, tmp_path / "cache", 2)
    assert not flag.exists()
    command = next(part for part in first.parts if isinstance(part, Code)).text
    assert shlex.split(command)[-4:-2] == ["--detector", reference]


@pytest.mark.parametrize("other", ["needle.roll_deg", "render.light_step_mm"])
def test_a_scene_lit_otherwise_is_refused(tmp_path, other):
    data = yaml.safe_load((SCENES / "01_single_tip.yaml").read_text())
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(data))
    part, name = data, other.split(".")
    for key in name[:-1]:
        part = part.setdefault(key, {})
    part.setdefault(name[-1], 0)
    part[name[-1]] = 16.0
    (tmp_path / "light.yaml").write_text(yaml.safe_dump(data))
    words = ["run", str(tmp_path / "scene.yaml"), "--light", str(tmp_path / "light.yaml")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code != 0
    assert f"{other}: differs from the scene that the light is to be rendered for" in str(
        done.exception
    )
