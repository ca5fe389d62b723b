"""Does the EMVA 1288 measurement of simulated frames find what was configured?"""

from __future__ import annotations

import json

import numpy as np
import pytest

from simtip import bench_camera
from simtip.bench_camera import measure_scene_camera
from simtip.cli import main
from simtip.errors import InputError
from simtip.spec import SceneSpec

KEYS = [
    "K_dn_per_e",
    "sigma_d_e",
    "dark_current_e_per_s",
    "full_well_e",
    "prnu_percent",
    "dsnu_e",
    "snr_max",
]


def with_sensor(scene: SceneSpec, sensor: dict) -> SceneSpec:
    data = scene.model_dump(mode="json", exclude_unset=True)
    return SceneSpec.model_validate({**data, "sensor": sensor})


CAMERAS = {
    "generic": {"preset": "generic_3um2"},
    "low noise": {"preset": "low_noise"},
    "ten bits": {
        "bit_depth": 10,
        "gain_dn_per_e": 0.08,
        "full_well_e": 12000,
        "read_noise_e": 9,
        "black_level_dn": 30,
        "prnu_percent": 1.5,
        "dsnu_e": 4,
        "dark_current_e_per_s": 40,
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CAMERAS)
def test_every_parameter_is_recovered(scene, name):
    result = measure_scene_camera(with_sensor(scene, CAMERAS[name])).to_dict()
    assert list(result["configured"]) == KEYS
    print(f"{'parameter':24}{'configured':>14}{'recovered':>14}  99 % interval")  # noqa: T201
    for key, truth in result["configured"].items():
        found, (low, high) = result["recovered"][key], result["ci99"][key]
        print(f"{key:24}{truth:14.5g}{found:14.5g}  {low:.5g} .. {high:.5g}")  # noqa: T201
        assert low <= truth <= high or found == pytest.approx(truth, rel=0.02)


@pytest.mark.slow
def test_the_command_prints_one_object_and_draws_the_plot(
    scene_path, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr("simtip.bench_camera.SIDE_PX", 96)
    plot = tmp_path / "ptc.svg"
    with pytest.raises(SystemExit) as done:
        main(["camera", str(scene_path), "--json", "--plot", str(plot)])
    assert done.value.code == 0
    result = json.loads(capsys.readouterr().out)
    assert list(result["recovered"]) == list(result["configured"]) == list(result["ci99"]) == KEYS
    assert plot.read_text().lstrip().startswith("<?xml")


@pytest.mark.parametrize(
    ("sensor", "field"),
    [
        ({"preset": "ideal"}, "sensor.noise"),
        ({"noise": False}, "sensor.noise"),
        ({"gamma": 0.5}, "sensor.gamma"),
        ({"quantum_efficiency": [0.5, 0, 0.5]}, "sensor.quantum_efficiency[1]"),
    ],
)
def test_what_cannot_be_measured_names_the_scenes_own_field(scene, sensor, field):
    with pytest.raises(InputError) as caught:
        measure_scene_camera(with_sensor(scene, sensor))
    assert caught.value.field == field
    assert caught.value.remedy


@pytest.mark.slow
def test_progress_rises_to_the_end(scene, monkeypatch):
    monkeypatch.setattr(bench_camera, "SIDE_PX", 24)
    seen: list[float] = []
    measure_scene_camera(with_sensor(scene, CAMERAS["ten bits"]), progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1
    assert seen[0] < 0.01
    # Even steps after the planning: a person may trust the time left.
    steps = np.diff([done for done in seen if done > bench_camera.PLANNING])
    np.testing.assert_allclose(steps, (1 - bench_camera.PLANNING) / (len(steps) + 1), rtol=1e-6)


def test_a_camera_without_shot_noise_is_null_with_reasons(scene, monkeypatch):
    monkeypatch.setattr(bench_camera, "SIDE_PX", 48)
    sensor = {"preset": "low_noise", "effects": {"shot_noise": False}}
    result = measure_scene_camera(with_sensor(scene, sensor)).to_dict()
    assert all(value is None for value in result["recovered"].values())
    assert set(result["reasons"]) == set(KEYS)


@pytest.mark.parametrize("plot", ["there.png", "plot.pdf", "no/such/folder.png"])
def test_a_plot_that_cannot_be_written_is_refused_at_once(scene_path, tmp_path, capsys, plot):
    (tmp_path / "there.png").write_bytes(b"mine")
    with pytest.raises(SystemExit) as done:
        main(["camera", str(scene_path), "--plot", str(tmp_path / plot)])
    assert done.value.code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert plot in error
    assert (tmp_path / "there.png").read_bytes() == b"mine"
