from __future__ import annotations

import pytest
import yaml
from a_users_tests import SUITE

from simtip.regress.suite import read_suite, standard_suite


def collected(mine, *options: object) -> list[str]:
    done = mine.run("--collect-only", "-q", *options)
    assert done.ret == 0, done.outlines
    return [line.partition("::")[2] for line in done.outlines if "::" in line]


def test_by_default_over_all_of_the_standard_suite(mine):
    mine.test("def test(simtip_suite): ...\ndef test_other(): ...")
    names = [case.name for case in read_suite(standard_suite()).cases]
    assert len(names) > 20
    assert collected(mine) == [*(f"test[{name}]" for name in names), "test_other"]


def test_over_what_its_marker_says(mine):
    mine.test(
        "@pytest.mark.simtip(suite='suite.yaml', cases=['thresholds', 'nominal'])\n"
        "def test(simtip_suite): ...\n"
        "@pytest.mark.simtip(cases='noisy')\n"
        "def test_one(simtip_suite): ..."
    )
    assert collected(mine) == ["test[thresholds]", "test[nominal]", "test_one[noisy]"]


def test_the_option_names_the_suite_of_those_that_name_none(mine):
    mine.test(
        "def test(simtip_suite): ...\n"
        "@pytest.mark.simtip(suite='standard', cases=['noisy'])\n"
        "def test_own(simtip_suite): ..."
    )
    names = [case["name"] for case in SUITE["cases"]]
    expected = [*(f"test[{name}]" for name in names), "test_own[noisy]"]
    assert collected(mine, "--simtip-suite=suite.yaml") == expected
    mine.pytester.makeini("[pytest]\naddopts = --simtip-suite=suite.yaml\n")
    assert collected(mine) == expected


def test_the_nearest_marker_counts(mine):
    mine.test(
        "pytestmark = pytest.mark.simtip(suite='suite.yaml', cases=['away'])\n"
        "def test(simtip_suite): ...\n"
        "@pytest.mark.simtip(cases=['nominal'])\n"
        "def test_nearer(simtip_suite): ..."
    )
    assert collected(mine) == ["test[away]", "test_nearer[nominal]"]


def test_a_marked_suite_lies_beside_the_test(mine):
    other = {**SUITE, "cases": [{"name": "deep", "scene": "../tiny.yaml"}]}
    mine.write("pyproject.toml", "[tool.pytest.ini_options]\npythonpath = ['.']\n")
    mine.write("deep/suite.yaml", yaml.safe_dump(other))
    mine.test(
        "@pytest.mark.simtip(suite='suite.yaml')\ndef test(simtip_suite): ...", "deep/test_a.py"
    )
    assert collected(mine) == ["test[deep]"]
    assert len(collected(mine, "--simtip-suite=suite.yaml")) == 1  # the marker's own


def test_it_goes_with_parameters_of_the_tests_own(mine):
    mine.test(
        "@pytest.mark.simtip(suite='suite.yaml', cases=['nominal', 'away'])\n"
        "@pytest.mark.parametrize('level', [0.4, 0.5])\n"
        "def test(simtip_suite, level): ..."
    )
    assert len(collected(mine)) == 4


@pytest.mark.parametrize(
    ("case", "repeats", "expected"),
    [
        (
            "nominal",
            None,
            [("nominal, repeat 1", {}), ("nominal, repeat 2", {}), ("nominal, repeat 3", {})],
        ),
        ("nominal", 1, [("nominal, repeat 1", {})]),
        (
            "two lamps' powers",
            1,
            [
                ("two lamps' powers, lamps[0].power=1.0, repeat 1", {"lamps[0].power": 1.0}),
                ("two lamps' powers, lamps[0].power=1.5, repeat 1", {"lamps[0].power": 1.5}),
            ],
        ),
        # detectors are the test's: of them no pair is made twice
        ("thresholds", 2, [("thresholds, repeat 1", {}), ("thresholds, repeat 2", {})]),
    ],
)
def test_a_case_gives_each_pair_once(mine, case, repeats, expected):
    marked = f"suite='suite.yaml', cases=[{case!r}]" + (f", repeats={repeats}" if repeats else "")
    mine.test(
        f"@pytest.mark.simtip({marked})\n"
        "def test(simtip_suite):\n"
        f"    expected = {expected!r}\n"
        "    assert len(simtip_suite) == len(expected)\n"
        "    pairs = list(simtip_suite)\n"
        "    assert [(p.name, dict(p.condition)) for p in pairs] == expected\n"
        "    assert len({p.left.tobytes() for p in pairs}) == len(expected)\n"
        f"    assert (simtip_suite.name, simtip_suite.suite) == ({case!r}, 'mine')\n"
    )
    mine.run().assert_outcomes(passed=1)


@pytest.mark.slow
def test_the_standard_suites_cases_have_names_for_single_pairs(mine):
    """The pair is the first of the case; the cheapest: what is rendered are 500 x 700 px."""
    small = {"rig.left.roi": [771, 760, 60, 60], "rig.right.roi": [983, 755, 60, 60]}
    cheap = {**small, "render.noise": None, "render.samples": 4, "render.light_step_mm": 8.0}
    mine.test(
        "def test(simtip_pair):\n"
        f"    pair = simtip_pair('standard:underexposed', changes={cheap})\n"
        "    assert pair.scene.sensor.background_dn == 90\n"
        "    assert pair.left.shape == (60, 60, 3)\n"
        "    assert pair.name == 'underexposed'\n"
        "def test_varied(simtip_pair):\n"
        f"    pair = simtip_pair('standard:lamps', 3, {{**{cheap}, 'lamps[0].power': 0.5}})\n"
        "    assert pair.scene.lamps[0].power == 0.5\n"
    )
    mine.run().assert_outcomes(passed=2)


def test_fresh_noise_is_that_of_all_pairs(mine):
    mine.test(
        "import pathlib\n"
        "@pytest.mark.simtip(suite='suite.yaml', cases=['nominal'])\n"
        "def test(simtip_suite):\n"
        "    seeds = [str(pair.noise_seed) for pair in simtip_suite]\n"
        "    with pathlib.Path('seeds').open('a') as file:\n"
        "        file.write('\\n'.join(seeds) + '\\n')\n"
    )
    for options in ((), ("--simtip-seed=5",), (), ("--simtip-seed=5",)):
        mine.run(*options).assert_outcomes(passed=1)
    seeds = (mine.path / "seeds").read_text().split()
    assert seeds[:6] == seeds[6:]
    assert len(set(seeds[:6])) == 6
