"""Does `simtip mca SCENE` run the experiment, each render once, and go on when it is killed?"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time

import pytest
import yaml
from asked import call
from experiment.small_experiment import asked, asked_as_users_do, command, scene_file

from simtip.sweep.table import Table

KEYS = {
    "accuracy": {"mean_abs_mm", "max_abs_mm", "rms_mm", "r2_step", "r2_cumulative"},
    "agreement": {
        *("bias_mm", "sd_mm", "loa_lower_mm", "loa_upper_mm", "loa_lower_ci_mm"),
        *("loa_upper_ci_mm", "pearson_r", "ccc"),
    },
    "repeatability": {"sigma_mm", "p_t_percent", "multiplier"},
    "grr": {"ev", "av", "grr", "pv", "tv", "interaction", "ndc", "grr_percent_tv"},
}

SETUPS = [
    {"name": "calibrated anew", "recalibrate": {}},
    {"name": "brighter", "set": {"lamps[0].power": 1.1}},
]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mca")
    file = scene_file(
        folder, setups=SETUPS, schedule={"registration": [2, 2, 1]}, stage={"stroke_mm": [8, 1, 1]}
    )
    return file, folder / "out", asked("mca", file, "-o", folder / "out")


@pytest.mark.slow
def test_it_says_all_that_it_is_asked_for(done):
    _, _, told = done
    for part, keys in KEYS.items():
        assert keys <= set(told[part]), part
    assert told["agreement"]["n"] == 12
    assert told["grr"]["operators"] == 3
    assert told["registration"]["fre_rms_mm"] < 0.1
    assert told["detection"]["rate"] == 1.0


@pytest.mark.slow
def test_each_distinct_place_is_rendered_once(done):
    _, _, told = done
    # Five places of the runs and four of the registration, of which the two on the line are shared.
    assert told["worked_out"]["light"] == 7
    assert told["worked_out"]["images"] == 15 + 2 * 10 + 4


@pytest.mark.slow
def test_it_is_there_when_asked_again(done):
    file, out, told = done
    again = asked("mca", file, "-o", out)
    assert again["worked_out"] == {"light": 0, "images": 0, "measure": 0}
    for part in (*KEYS, "position", "registration"):
        assert again[part] == told[part]


@pytest.mark.slow
def test_positions_are_told_in_the_stages_frame_on_request(done):
    file, out, told = done
    staged = asked("mca", file, "-o", out, "--frame", "stage")["position"]
    assert told["position"]["frame"] == "camera"
    assert staged["frame"] == "stage"
    error = told["registration"]["position_error_mm"]
    assert [staged["rms_mm"], staged["max_mm"]] == [error["rms"], error["max"]]
    assert staged["rms_mm"] < told["position"]["rms_mm"]


@pytest.mark.slow
def test_its_folder_holds_what_a_user_looks_for(done):
    _, out, told = done
    assert json.loads((out / "mca.json").read_text())["agreement"] == told["agreement"]
    for name in ("accuracy.png", "agreement.png", "repeatability.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_its_rows_are_what_mca_csv_reads(done):
    _, out, told = done

    def read(name):
        asked = call("mca", "--csv", str(out / name), "--tolerance", "0.62", "--json")
        assert asked.code == 0, asked.err
        return json.loads(asked.out)

    again = read("measurements.csv")
    for key in ("bias_mm", "sd_mm", "pearson_r", "ccc"):
        assert again["agreement"][key] == pytest.approx(told["agreement"][key], rel=1e-9)
    assert again["repeatability"]["p_t_percent"] == pytest.approx(
        told["repeatability"]["p_t_percent"], rel=1e-9
    )
    steps = read("steps.csv")["accuracy"]
    assert steps["mean_abs_mm"] == pytest.approx(told["accuracy"]["mean_abs_mm"], rel=1e-9)
    gauge = read("gauge.csv")["grr"]
    assert gauge["grr"] == pytest.approx(told["grr"]["grr"], rel=1e-9)
    assert gauge["operators"] == 3


@pytest.mark.slow
def test_only_a_set_up_that_asks_for_it_is_calibrated_anew(tmp_path):
    file = scene_file(tmp_path, setups=SETUPS, calibration={"views": 6},
                      schedule={"steps": 3, "runs": 2})  # fmt: skip
    asked("mca", file, "-o", tmp_path / "out")
    measured = [
        json.loads(Table.open(tmp_path / "out" / "sweeps" / name).provenance["scene"])["rig"]
        for name in ("00", "01", "02")
    ]
    own, anew, brighter = (one["measured"] for one in measured)
    assert own == brighter
    assert own != anew


@pytest.mark.slow
def test_a_kill_costs_what_was_in_flight(done, tmp_path):
    _, _, told = done
    file = scene_file(
        tmp_path,
        setups=SETUPS,
        schedule={"registration": [2, 2, 1]},
        stage={"stroke_mm": [8, 1, 1]},
    )
    out = tmp_path / "out"
    started = subprocess.Popen(
        command("mca", file, "-o", out),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    rows = out / "sweeps" / "00"
    until = time.monotonic() + 120
    while not list(rows.glob("rows*/part-*")) and time.monotonic() < until:
        time.sleep(0.05)
    os.killpg(started.pid, signal.SIGKILL)
    started.wait()
    assert not (out / "mca.json").exists()
    again = asked_as_users_do("mca", file, "-o", out)
    assert again["worked_out"]["light"] < told["worked_out"]["light"]
    # The last bits of a calibration may differ.
    for part, key in (("agreement", "sd_mm"), ("grr", "grr"), ("position", "rms_mm")):
        assert again[part][key] == pytest.approx(told[part][key], rel=1e-6)
    assert again["detection"] == told["detection"]


@pytest.mark.slow
def test_moments_of_the_mains_need_no_renders(tmp_path):
    ballast = {"lamps[0].ballast": {"kind": "magnetic", "ripple": 0.35}}
    file = scene_file(tmp_path, schedule={"start_jitter_s": 0.01, "steps": 3, "runs": 2},
                      setups=[{"name": "on the mains", "set": ballast}])  # fmt: skip
    # Rendered for a sensor's noise, as scenes are by default: all set-ups share the strictest.
    data = yaml.safe_load(file.read_text())
    data["render"] = {"noise": 3.0, "samples": 16, "light_step_mm": 4.0}
    data["experiment"]["setups"].append({"name": "longer", "set": {"sensor.exposure_s": 0.06}})
    file.write_text(yaml.safe_dump(data))
    told = asked("mca", file)
    assert told["worked_out"] == {"light": 4, "images": 24, "measure": 24}
