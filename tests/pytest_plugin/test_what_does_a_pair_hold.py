from __future__ import annotations

import json

import numpy as np
import pytest
from a_users_tests import tiny_scene

from simtip.render import choose
from simtip.simulation import expose_pair, simulate
from simtip.spec import SceneSpec

SAVE = """
import json, pathlib, numpy as np

def save(pair, name):
    np.savez(name, left=pair.left, right=pair.right)
    truth = pair.truth
    said = {
        "name": pair.name,
        "tips": [truth.left.tip_px.tolist(), truth.right.tip_px.tolist()],
        "tip_mm": truth.tip_mm.tolist(),
        "axis": truth.axis.tolist(),
        "size": [pair.rig.left.size, pair.rig.right.size],
        "K": pair.rig.left.K.tolist(),
        "scene": pair.scene.model_dump(mode="json"),
        "exposure_s": pair.exposure_s,
        "noise_seed": pair.noise_seed,
        "writable": bool(pair.left.flags.writeable),
        "condition": dict(pair.condition),
        "repeat": pair.repeat,
    }
    pathlib.Path(name + ".json").write_text(json.dumps(said))
"""


@pytest.fixture
def saved(mine):
    """Run the body of a test, which saves pairs, and read one of them."""

    def run(body: str, *options: object):
        mine.test(f"{SAVE}\ndef test(simtip_pair):\n    {body}")
        mine.run(*options).assert_outcomes(passed=1)

        def read(name: str):
            said = json.loads((mine.path / f"{name}.json").read_text())
            with np.load(mine.path / f"{name}.npz") as images:
                return said, (images["left"], images["right"])

        return read

    return run


def test_the_images_are_those_that_simulating_makes(saved):
    """By the road of `simtip render` and `simtip remix --seed`, without a cache."""
    read = saved("save(simtip_pair('tiny.yaml', seed=5), 'a')")
    said, images = read("a")
    scene = SceneSpec.model_validate(tiny_scene())
    lit = simulate(scene)
    seed = said["noise_seed"]
    expected = expose_pair(scene, lit.views, seed=seed, backend=choose(), light_seed=scene.seed)
    for image, other in zip(images, expected.images, strict=True):
        assert image.dtype == np.uint8
        np.testing.assert_array_equal(image, other)
    assert said["exposure_s"] == expected.spec.sensor.exposure_s
    assert not said["writable"]


def test_the_truth_is_the_pinholes(saved):
    """By Table 1 and Eq. 19, with the origin moved to the region that is read out."""
    said, _ = saved("save(simtip_pair('tiny.yaml'), 'a')")("a")
    data = tiny_scene()
    tip, rig = np.array(data["needle"]["tip_mm"]), data["rig"]
    R, t = np.array(rig["R"]), np.array(rig["t_mm"])
    u, _, v = np.linalg.svd(R)  # printed with three digits
    for side, point in (("left", tip), ("right", (u @ v).T @ (tip - t))):
        one = rig[side]
        x, y = point[:2] / point[2]
        expected = [
            one["fx"] * x + one["cx"] - one["roi"][0],
            one["fy"] * y + one["cy"] - one["roi"][1],
        ]
        assert said["tips"][side == "right"] == pytest.approx(expected, abs=1e-6)
    assert said["tip_mm"] == pytest.approx(tip)
    assert said["size"] == [[100, 150], [100, 150]]
    assert said["K"][0][2] == pytest.approx(rig["left"]["cx"] - 770)


def test_seeds_change_the_noise_and_nothing_else(saved):
    read = saved(
        "[save(simtip_pair('tiny.yaml', seed=s), n) for n, s in zip('abcd', (1, 2, 1, None))]"
    )
    (a, left_a), (b, left_b), (_, left_c), (d, left_d) = map(read, "abcd")
    np.testing.assert_array_equal(left_a, left_c)
    np.testing.assert_array_equal(left_a, left_d)  # the scene's own seed is 1
    assert tiny_scene().get("seed", 1) == 1
    difference = np.asarray(left_a, dtype=float) - left_b
    assert 0.3 < difference.std() < 10
    assert abs(difference.mean()) < 0.2
    assert a["tips"] == b["tips"]
    assert (a["name"], b["name"], d["name"]) == ("tiny, seed 1", "tiny, seed 2", "tiny")


@pytest.mark.slow
def test_fresh_noise_draws_all_anew_and_keeps_pairs_apart(saved):
    body = "[save(simtip_pair('tiny.yaml', seed=s), n) for n, s in zip('abc', (1, 2, None))]"
    old = [saved(body)(name) for name in "abc"]
    new = [saved(body, "--simtip-seed=77")(name) for name in "abc"]
    seeds = {said["noise_seed"] for said, _ in (*old, *new)}
    assert len(seeds) == 2 + 3
    again = [saved(body, "--simtip-seed=77")(name) for name in "abc"]
    for (_, one), (_, other) in zip(new, again, strict=True):
        np.testing.assert_array_equal(one, other)
    assert new[0][0]["name"] == "tiny, seed 1, noise anew (77)"


TWELVE_BIT = "'sensor.bit_depth': 12"


@pytest.mark.parametrize(
    "changes",
    [
        f"{{'needle.roll_deg': 40, {TWELVE_BIT}}}",
        f"**{{'needle.roll_deg': 40, {TWELVE_BIT}}}",
        f"{{'needle.roll_deg': np.float64(40)}}, **{{{TWELVE_BIT}}}",
    ],
    ids=["mapping", "keywords", "both"],
)
def test_changes_are_made_to_the_scene(saved, changes):
    said, images = saved(f"save(simtip_pair('tiny.yaml', 1, {changes}), 'a')")("a")
    assert said["scene"]["needle"]["roll_deg"] == 40
    assert said["scene"]["sensor"]["bit_depth"] == 12
    assert images[0].dtype == np.uint16


def test_a_scene_lies_beside_the_test_or_at_the_root(mine):
    scene = (mine.path / "tiny.yaml").read_text()
    mine.write("pyproject.toml", "[tool.pytest.ini_options]\npythonpath = ['.']\n")
    mine.write("deep/own.yaml", scene.replace("name: tiny", "name: own"))
    mine.write("deep/tiny.yaml", scene.replace("name: tiny", "name: beside"))
    mine.test(
        "def test(simtip_pair):\n"
        "    assert simtip_pair('own.yaml').scene.name == 'own'\n"
        "    assert simtip_pair('tiny.yaml').scene.name == 'beside'\n"
        "    assert simtip_pair('../tiny.yaml').scene.name == 'tiny'\n",
        "deep/test_deep.py",
    )
    mine.test(
        "import pathlib, simtip\n"
        "def test(simtip_pair):\n"
        "    assert simtip_pair('deep/own.yaml').scene.name == 'own'\n"
        "    assert simtip_pair(pathlib.Path('tiny.yaml').absolute()).scene.name == 'tiny'\n"
        "    assert simtip_pair(simtip.load_scene('tiny.yaml')).scene.name == 'tiny'\n",
        "other/test_other.py",
    )
    mine.run().assert_outcomes(passed=2)


def test_a_rig_that_measures_is_the_one_that_the_test_gets(mine):
    from simtip.rig_file import rig_text

    rig = SceneSpec.model_validate(tiny_scene()).rig.rig()
    mine.write("rig.yaml", rig_text(rig).replace("1909.84", "1919.84"))
    mine.test(
        "def test(simtip_pair):\n"
        "    pair = simtip_pair('tiny.yaml', 1, {'rig.measured': 'rig.yaml'})\n"
        "    assert pair.rig.left.K[0, 0] == 1919.84\n"
        "    assert pair.truth.rig.left.K[0, 0] == 1909.84\n",
    )
    mine.run().assert_outcomes(passed=1)


def test_what_was_made_is_not_made_again(mine, monkeypatch, tmp_path):
    mine.test(
        "def test(simtip_pair):\n    simtip_pair('tiny.yaml', 9, {'needle.roll_deg': 11.0})\n"
    )
    mine.run(f"--simtip-cache={tmp_path}").assert_outcomes(passed=1)

    def refuse(*_, **__):
        raise AssertionError("rendered again")

    monkeypatch.setattr("simtip.sweep.stages.render_pair", refuse)
    mine.run(f"--simtip-cache={tmp_path}").assert_outcomes(passed=1)
    mine.run(f"--simtip-cache={tmp_path / 'another'}").assert_outcomes(failed=1)


@pytest.mark.slow
def test_a_sweep_and_a_pair_share_their_cache(mine, ask, monkeypatch, tmp_path):
    mine.write("sweep.yaml", "scene: tiny.yaml\nbase: {needle.roll_deg: 17.0}\nseed: 4\n")
    monkeypatch.chdir(mine.path)
    answer = ask("sweep", "sweep.yaml", "-o", "out", "--cache", str(tmp_path), "--workers", "1")
    assert answer.code == 0, answer.err

    def refuse(*_, **__):
        raise AssertionError("made again")

    monkeypatch.setattr("simtip.sweep.stages.render_pair", refuse)
    monkeypatch.setattr("simtip.sweep.stages.expose_pair", refuse)
    mine.test(
        "def test(simtip_pair):\n    simtip_pair('tiny.yaml', 4, {'needle.roll_deg': 17.0})\n"
    )
    mine.run(f"--simtip-cache={tmp_path}").assert_outcomes(passed=1)
