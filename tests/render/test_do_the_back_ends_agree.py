"""Is the picture the same whoever renders it? Two renderers of different make must agree."""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.render import View, choose, render_pair
from simtip.truth import scene_truth


@pytest.fixture(scope="module")
def pairs(scene):
    """The same crop by simtip's vectorised transport and by Mitsuba's stock integrators."""
    small = with_roi(scene, [780, 800, 80, 100], [990, 795, 80, 100], samples=256)
    vectorised = choose()
    assert vectorised.name != "scalar"
    seeds = range(2)
    return [
        (
            render_pair(small, backend=vectorised, seed=s),
            render_pair(small, backend=choose("scalar"), seed=s),
        )
        for s in seeds
    ]


REGIONS = {
    "needle": lambda view: view.coverage > 0.999,
    "background": lambda view: view.coverage == 0,
    "edge": lambda view: (view.coverage > 0.05) & (view.coverage < 0.95),
}
RELATIVE = {"needle": 0.01, "background": 0.004, "edge": 0.04}
"""About four standard errors of the regional means at these samples, seen over ten seeds."""


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
@pytest.mark.parametrize("region", REGIONS)
def test_each_lamp_gives_each_region_the_same_light(pairs, side, region):
    for mine, stock in ((a[side], b[side]) for a, b in pairs):
        assert mine.lamps == stock.lamps
        where = REGIONS[region](mine)
        assert where.sum() > 50
        found = mine.response[:, where].mean(axis=1)
        expected = stock.response[:, where].mean(axis=1)
        np.testing.assert_allclose(found, expected, rtol=RELATIVE[region])


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_coverage_and_depth_are_the_same(pairs, side):
    for mine, stock in ((a[side], b[side]) for a, b in pairs):
        assert np.abs(mine.coverage - stock.coverage).max() < 0.06
        assert mine.coverage.sum() == pytest.approx(stock.coverage.sum(), rel=1e-3)
        np.testing.assert_allclose(mine.depth_mm, stock.depth_mm, atol=2e-3)


def test_the_truth_does_not_depend_on_the_renderer(small_scene):
    truth = scene_truth(small_scene)
    assert truth.tip_mm.tolist() == list(small_scene.needle.tip_mm)


def views_equal(a: View, b: View) -> bool:
    return all(
        np.array_equal(getattr(a, name), getattr(b, name))
        for name in ("response", "coverage", "depth_mm")
    )


@pytest.mark.parametrize("name", ["auto", "scalar"])
def test_equal_seeds_give_equal_bits_and_others_do_not(scene, name):
    small = with_roi(scene, [800, 860, 40, 30], [1010, 860, 40, 30], samples=16)
    first, again, other = (
        render_pair(small, backend=choose(name), seed=seed) for seed in (7, 7, 8)
    )
    for side in (0, 1):
        assert views_equal(first[side], again[side])
        assert not np.array_equal(first[side].response, other[side].response)
