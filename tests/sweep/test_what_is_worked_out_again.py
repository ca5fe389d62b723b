"""What is worked out again when something changes: no more than depends on it?"""

import shutil

import pytest
import yaml
from small_sweeps import scene_file

from simtip.measuring_rig import measuring_rig
from simtip.render import choose
from simtip.sweep import stage_keys
from simtip.sweep.cache import Cache
from simtip.sweep.limit import Limit
from simtip.sweep.plan import Plan
from simtip.sweep.stages import Stages
from simtip.sweep.sweep_file import read_sweep

VARIANT = "llvm_ad_rgb"


def plan_of(folder, **said):
    folder.mkdir(exist_ok=True)
    scene_file(folder)
    file = folder / "sweep.yaml"
    file.write_text(yaml.safe_dump({"scene": "scene.yaml", **said}, sort_keys=False))
    source = read_sweep(file)
    return Plan(source.spec, source.scene)


def keys(folder, base, factor):
    """Give the three keys of the only trial of a sweep with this base and these factors."""
    plan = plan_of(folder, base=base, factors=factor)
    trial = plan.trial(0)
    spec = plan.scenes.with_values(trial.values)
    light = stage_keys.light_key(plan.reference(trial), VARIANT)
    images = stage_keys.image_key(light, stage_keys.image_inputs(spec), 1)
    seen = spec.model_copy(update={"detect": trial.measuring.spec})
    return light, images, stage_keys.measure_key(images, seen, measuring_rig(seen))


@pytest.mark.parametrize(
    ("field", "value", "changed"),
    [
        ("detect.threshold", 99, (False, False, True)),
        ("match.max_distance_px", 5.0, (False, False, True)),
        ("triangulate.method", "midpoint", (False, False, True)),
        ("name", "another", (False, False, False)),
        ("lamps[0].power", 0.7, (False, True, True)),
        ("sensor.exposure_s", 0.02, (False, True, True)),
        ("sensor.read_noise_e", 9.0, (False, True, True)),
        ("rig.left.lens.aberration_um", 2.0, (False, True, True)),
        ("needle.roll_deg", 33.0, (True, True, True)),
        ("needle.material.roughness", 0.3, (True, True, True)),
        ("lamps[0].centre_mm", [0.0, -1400.0, -600.0], (True, True, True)),
        ("background.albedo", [0.5, 0.5, 0.5], (True, True, True)),
        ("seed", 5, (True, True, True)),
    ],
)
def test_a_field_changes_the_keys_of_what_depends_on_it(field, value, changed, tmp_path):
    """Rendered with a fixed number of rays: with `render.noise` light is rendered for a sensor."""
    one = keys(tmp_path, {}, {})
    factors = {field: [value]} if field.startswith("detect.") else {}
    base = {} if factors else {field: value}
    other = keys(tmp_path, base, factors)
    assert tuple(a != b for a, b in zip(one, other, strict=True)) == changed


def test_another_renderer_or_code_is_another_light(tmp_path, monkeypatch):
    plan = plan_of(tmp_path)
    spec = plan.reference(plan.trial(0))
    usual = stage_keys.light_key(spec, VARIANT)
    assert stage_keys.light_key(spec, "scalar_rgb") != usual
    copy = tmp_path / "simtip"
    shutil.copytree(stage_keys.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(stage_keys, "PACKAGE", copy)
    stage_keys._stage_code.cache_clear()
    assert stage_keys.light_key(spec, VARIANT) == usual
    changed = copy / "render" / "estimate.py"
    changed.write_text(changed.read_text() + "\n# another\n")
    stage_keys._stage_code.cache_clear()
    assert stage_keys.light_key(spec, VARIANT) != usual
    stage_keys._stage_code.cache_clear()


def test_every_module_that_a_key_names_exists():
    for name in {*stage_keys.LIGHT, *stage_keys.IMAGES, *stage_keys.MEASURE}:
        place = stage_keys.PACKAGE / name
        assert place.is_dir() or place.with_suffix(".py").is_file(), name


def test_of_a_program_nobody_knows_whether_it_has_changed():
    assert stage_keys.detector_code("cmd:./mine {image}") is None


def test_a_module_is_told_by_its_files(tmp_path, monkeypatch):
    (tmp_path / "minedet.py").write_text("def find(image): ...\n")
    monkeypatch.syspath_prepend(tmp_path)
    one = stage_keys.detector_code("minedet:find")
    (tmp_path / "minedet.py").write_text("def find(image): pass\n")
    stage_keys.detector_code.cache_clear()
    assert stage_keys.detector_code("minedet:find") != one


FACTORS = {
    "factors": {
        "needle.roll_deg": [0.0, 40.0],
        "lamps[0].power": [1.0, 1.1],
        "detect.threshold": [80, 100, 120],
    },
    "detectors": ["lin2020", "subpixel"],
}


@pytest.mark.slow
def test_counted(tmp_path):
    """24 trials: 2 renders, 4 pairs of images, 4 x (3 + 1) measurements; then nothing."""
    plan = plan_of(tmp_path, **FACTORS)
    cache = Cache(tmp_path / "cache")
    stages = Stages(plan, cache, choose(), Limit(100.0))
    rows = [stages.row(plan.trial(k)) for k in range(len(plan))]
    assert stages.counts == {"light": 2, "images": 4, "measure": 16}
    again = Stages(plan, cache, choose(), Limit(100.0))
    timings = {"render_s", "sensor_s"}
    assert [again.row(plan.trial(k)) for k in range(len(plan))] == [
        {name: value for name, value in row.items() if name not in timings} for row in rows
    ]
    assert again.counts == {"light": 0, "images": 0, "measure": 0}
    assert all(row["status"] == "ok" for row in rows if row["detector"] == "lin2020")
    more = plan_of(
        tmp_path,
        **{**FACTORS, "factors": {**FACTORS["factors"], "lamps[0].power": [1.0, 1.1, 0.9]}},
    )
    third = Stages(more, cache, choose(), Limit(100.0))
    for k in range(len(more)):
        third.row(more.trial(k))
    assert third.counts == {"light": 0, "images": 2, "measure": 8}


@pytest.mark.slow
def test_damaged_entries_are_made_anew(tmp_path):
    plan = plan_of(tmp_path)
    cache = Cache(tmp_path / "cache")
    row = Stages(plan, cache, choose(), Limit(100.0)).row(plan.trial(0))
    for kind, key, file in (
        ("light", row["light_key"], "left_lights.exr"),
        ("images", row["image_key"], "right.npy"),
    ):
        path = cache.entry(kind, str(key)) / file
        content = bytearray(path.read_bytes())
        content[len(content) // 2] ^= 1
        path.write_bytes(content)
    cache.clear("measure")
    stages = Stages(plan, cache, choose(), Limit(100.0))
    again = stages.row(plan.trial(0))
    assert stages.counts == {"light": 1, "images": 1, "measure": 1}
    same = {"error_norm_mm", "left_error_u_px", "noise_seed", "status", "key"}
    assert {name: again[name] for name in same} == {name: row[name] for name in same}


@pytest.mark.slow
def test_without_a_cache_the_rows_are_the_same(tmp_path):
    plan = plan_of(tmp_path, factors={"detect.threshold": [90, 100]})
    kept = Stages(plan, Cache(tmp_path / "cache"), choose(), Limit(100.0))
    bare = Stages(plan, None, choose(), Limit(100.0))
    timings = {"render_s", "sensor_s", "detect_s"}
    for k in range(len(plan)):
        one, other = kept.row(plan.trial(k)), bare.row(plan.trial(k))
        assert {n: v for n, v in one.items() if n not in timings} == {
            n: v for n, v in other.items() if n not in timings
        }
    assert bare.counts == {"light": 1, "images": 1, "measure": 2}
