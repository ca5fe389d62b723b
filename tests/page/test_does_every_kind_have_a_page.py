"""Folders of every kind, as their commands leave them: what does the page say of them?"""

from __future__ import annotations

import json
import re
import shutil
import warnings
from pathlib import Path
from unittest import mock

import cv2
import numpy as np
import pytest
import yaml
from asked import Answer
from experiment.small_experiment import scene_file
from made_tables import grid, page, scene_data, written
from one_process import call_here
from oracles.stereo_boards import TARGET, photograph
from regress.small_suites import fixed_ratio

from simtip.calibration_images.record import read_record
from simtip.page.folder import results_in
from simtip.page.make import page_of
from simtip.page.options import Options

pytestmark = pytest.mark.slow


def ask(*words: object) -> Answer:
    with mock.patch("simtip.regress.timing.ratio_of", fixed_ratio):
        return call_here(*words)


def simtip(*words: object) -> None:
    answer = ask(*words)
    assert answer.code in {0, 1}, answer.err


@pytest.fixture(scope="module")
def made(tmp_path_factory, ran) -> dict[str, Path]:
    """A folder of each kind."""
    folder = tmp_path_factory.mktemp("kinds")
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene_data()))
    cache = ("--cache", folder / "cache", "--workers", "1")
    kinds = {"run": ran, "sweep": grid(folder / "sweep")}
    kinds["render"] = folder / "render"
    simtip("render", folder / "scene.yaml", "-o", kinds["render"])
    experiment = scene_file(folder, "experiment.yaml")
    for kind in ("mca", "budget"):
        kinds[kind] = folder / kind
        more = ("--replicates", 2) if kind == "budget" else ()
        simtip(kind, experiment, "-o", kinds[kind], *cache, *more)
    boards = folder / "boards"
    boards.mkdir()
    photograph(boards)
    kinds["calibrate"] = folder / "calibrate"
    truth = ("--truth", boards / "truth.json")
    simtip("calibrate", boards, "--target", TARGET, *truth, "--plots", kinds["calibrate"])
    kinds["boards"] = folder / "of_scene"
    board = {"target": "chessboard:3x3:1.5", "views": 2, "poses": {"depth_mm": 2.0, "margin_px": 1}}
    board["plate"] = {"margin_mm": 0.5, "thickness_mm": 0.5}
    (folder / "boards.yaml").write_text(yaml.safe_dump(scene_data(boards=board)))
    simtip("boards", folder / "boards.yaml", "-o", kinds["boards"])
    suite = {"name": "small", "scene": "scene.yaml", "repeats": 3}
    suite["cases"] = [{"name": "power", "factors": {"lamps[0].power": [0.8, 1.2]}}]
    (folder / "suite.yaml").write_text(yaml.safe_dump(suite))
    simtip("regress", "record", folder / "suite.yaml", "-o", folder / "base.json", *cache)
    kinds["regress"] = folder / "regress"
    again = ("regress", "check", folder / "base.json", "-o", kinds["regress"], *cache)
    simtip(*again, "--set", "threshold=70")
    return kinds


KINDS = ["run", "render", "sweep", "mca", "budget", "boards", "calibrate", "regress"]


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_recognised_and_shown(made, opened, kind):
    assert results_in(made[kind]).kind == kind
    file = written(made[kind])
    for width, scheme in ((1280, "light"), (400, "dark")):
        with opened(file, width=width, scheme=scheme, touch=width < 500) as shown:
            assert shown.locator(".kind").inner_text() == f"simtip {kind}"
            assert shown.evaluate("document.documentElement.scrollWidth") <= width
            assert shown.locator("#provenance td").count() > 4
            names = shown.eval_on_selector_all("[id]", "all => all.map((one) => one.id)")
            assert len(names) == len(set(names))
            unnamed = "all => all.filter((one) => !one.ariaLabel && !one.textContent.trim()).length"
            assert shown.eval_on_selector_all("button, [role=img], [role=region]", unnamed) == 0


def facts(folder: Path) -> dict[str, str]:
    shown = page_of(results_in(folder), Options(pictures=0))
    return {fact.name: fact.value for fact in shown.facts}


def in_mm(text: str) -> float:
    number, unit = text.replace("\N{MINUS SIGN}", "-").split()
    return float(number) * {"mm": 1.0, "\N{MICRO SIGN}m": 1e-3}[unit]


def told(folder: Path, name: str) -> dict:
    return json.loads((folder / name).read_text())


def test_the_numbers_are_those_of_the_files(made):
    run = told(made["run"], "result.json")
    assert in_mm(facts(made["run"])["Error"]) == pytest.approx(run["error_mm"]["norm"], rel=5e-3)
    mca = told(made["mca"], "mca.json")
    said = facts(made["mca"])
    assert in_mm(said["Mean |error|"]) == pytest.approx(mca["accuracy"]["mean_abs_mm"], rel=5e-3)
    assert in_mm(said["Bias"]) == pytest.approx(mca["agreement"]["bias_mm"], rel=5e-3)
    budget = told(made["budget"], "budget.json")
    said = facts(made["budget"])
    rms = budget["position"]["rms_mm"]
    assert in_mm(said["Position: RMS error"]) == pytest.approx(rms, rel=5e-3)
    calibration = told(made["calibrate"], "calibration.json")
    said = facts(made["calibrate"])
    assert float(said["RMS reprojection"].split()[0]) == pytest.approx(
        calibration["rms_px"]["stereo"], abs=6e-4
    )
    check = told(made["regress"], "regress.json")
    assert facts(made["regress"])["Verdict"] == check["verdict"] == "worse"


def test_pictures_hold_the_tips_where_the_truth_says(made, opened):
    truth, result = (told(made["run"], f"{name}.json") for name in ("truth", "result"))
    with opened(written(made["run"])) as shown:
        for number, side in enumerate(("left", "right")):
            view = shown.locator(".frame svg").nth(number)
            for mark, expected in (
                ("true", truth[side]["tip_px"]),
                ("detected", result["tip_detected_px"][side]),
            ):
                spot = view.locator(f".mark.{mark}")
                place = [float(spot.get_attribute(f"data-{axis}")) for axis in "uv"]
                assert place == pytest.approx(expected, rel=1e-5)


def test_a_picture_is_zoomed_by_wheel_keys_and_buttons(made, opened):
    with opened(written(made["run"])) as shown:
        view = shown.locator(".frame svg").first

        def width():
            return float(view.get_attribute("viewBox").split()[2])

        first = width()
        view.hover()
        shown.mouse.wheel(0, -300)
        shown.wait_for_timeout(100)
        assert width() == first, "a page that is scrolled past goes on scrolling"
        shown.evaluate("scrollTo(0, 0)")
        view.click()
        shown.mouse.wheel(0, -300)
        shown.wait_for_function(
            "([at]) => Number(document.querySelector('.frame svg').getAttribute('viewBox')"
            ".split(' ')[2]) < at",
            arg=[first],
        )
        shown.keyboard.press("Home")
        assert width() == first
        shown.keyboard.press("+")
        assert width() < first
        left = view.get_attribute("viewBox")
        shown.keyboard.press("ArrowLeft")
        assert view.get_attribute("viewBox") != left
        shown.locator(".tools button:has-text('All')").first.click()
        assert width() == 100
        mark = view.locator(".mark.true").get_attribute("transform")
        shown.keyboard.press("+")
        assert view.locator(".mark.true").get_attribute("transform") != mark, (
            "marks keep their size"
        )


def test_the_exact_picture_is_pixel_for_pixel(made):
    """What lies around the tip is that of the file; what lies there is found by its corner."""
    import base64

    shown = page_of(results_in(made["run"]), Options())
    views = next(part for part in shown.sections[0].parts if part.shape == "views")
    for view in views.views:
        image = cv2.imread(str(made["run"] / f"{view.title}.png"), cv2.IMREAD_UNCHANGED)
        layer = view.layers[-1]
        data = base64.b64decode(layer.uri.partition(",")[2])
        crop = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
        u, v = round(layer.u + 0.5), round(layer.v + 0.5)
        assert crop.shape[:2] == (layer.height, layer.width)
        np.testing.assert_array_equal(crop, image[v : v + layer.height, u : u + layer.width])


def test_a_file_that_was_changed_is_told(made, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(made["run"], folder)
    assert "Not as they were written" not in page(folder)
    text = (folder / "result.json").read_text()
    (folder / "result.json").write_text(text + "\n")
    assert "Not as they were written: result.json." in page(folder)


def test_calibrations_come_back_as_they_were(made):
    record = read_record(made["calibrate"])
    calibration = told(made["calibrate"], "calibration.json")
    assert record.left.rms_px == pytest.approx(calibration["rms_px"]["left"], rel=1e-12)
    assert record.right.mean_px == pytest.approx(calibration["mean_px"]["right"], rel=1e-12)
    assert record.rig_px.max() == pytest.approx(calibration["epipolar_rig_px"]["max"], rel=1e-12)
    assert record.raw_px.mean() == pytest.approx(calibration["epipolar_raw_px"]["mean"], rel=1e-12)
    needle = calibration["error_at_needle_mm"]
    lengths = np.linalg.norm(record.error_map.displacement_mm, axis=1)
    assert lengths.max() == pytest.approx(needle["max"], rel=1e-12)


@pytest.mark.parametrize("kind", ["sweep", "mca", "budget", "calibrate", "regress"])
def test_all_figures_are_files_too(made, tmp_path, kind):
    answer = ask(
        *("report", str(made[kind]), "-o", str(tmp_path / "page.html")),
        *("--figures", str(tmp_path / "figures"), "--pictures", "0"),
    )
    assert answer.code == 0, answer.err
    names = sorted(path.stem for path in (tmp_path / "figures").glob("*.svg"))
    assert names == sorted(path.stem for path in (tmp_path / "figures").glob("*.png"))
    assert names
    drawn = re.findall(r'id="figure-([^"]+)"', (tmp_path / "page.html").read_text())
    assert set(drawn) <= set(names)
    for name in names:
        assert cv2.imread(str(tmp_path / "figures" / f"{name}.png")).std() > 5


def test_a_check_goes_on_beside_its_page(made):
    assert ask("report", str(made["regress"])).code == 0
    base = made["regress"].parent / "base.json"
    cache = ("--cache", str(base.parent / "cache"), "--workers", "1")
    again = ("regress", "check", str(base), "-o", str(made["regress"]), "--set", "threshold=70")
    assert ask(*again, *cache).code == 1


SPOILT = [
    ("regress", "regress.json", ("conditions", 0, "after", "left", "sd", 0), 1e308),
    ("regress", "regress.json", ("pooled", "tests", 0, "change"), float("nan")),
    ("mca", "mca.json", ("accuracy", "mean_ci_mm", 0), float("inf")),
    ("budget", "budget.json", ("from_start", "shares", 0, "cause"), float("nan")),
    ("boards", "truth.json", ("views", 1, "right", "file"), "x" * 400),
    ("boards", "truth.json", ("plate", "print_scale", 0), float("nan")),
    ("calibrate", "points.json", ("image_size", "left", 0), 0),
    ("calibrate", "points.json", ("image_size", "left", 0), float("inf")),
    ("calibrate", "points.json", ("left", "id", 0), float("inf")),
    ("calibrate", "points.json", ("left", "seen_px", 0, 0), 1e300),
    ("calibrate", "calibration.json", ("images",), float("nan")),
]


@pytest.mark.parametrize(("kind", "name", "place", "value"), SPOILT)
def test_a_value_that_no_command_writes_is_one_line(made, tmp_path, kind, name, place, value):
    folder = tmp_path / kind
    shutil.copytree(made[kind], folder, ignore=shutil.ignore_patterns("report.html"))
    data = json.loads((folder / name).read_text())
    part = data
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    (folder / name).write_text(json.dumps(data))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        answer = ask("report", str(folder))
    assert answer.code == 2, answer.out
    assert answer.err.count("\n") == 1
    assert str(folder / name) in answer.err
    assert not (folder / "report.html").exists()
