"""Is the picture the same whoever renders it? Two renderers of different make must agree."""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.render import View, choose, render_pair
from simtip.truth import scene_truth


@pytest.fixture(scope="module")
def pair(scene):
    """The same crop by simtip's vectorised transport and by Mitsuba's stock integrators."""
    small = with_roi(scene, [790, 820, 60, 70], [1000, 815, 60, 70], samples=128)
    vectorised = choose()
    assert vectorised.name != "scalar"
    return render_pair(small, backend=vectorised), render_pair(small, backend=choose("scalar"))


REGIONS = {
    "needle": lambda view: view.coverage > 0.999,
    "background": lambda view: view.coverage == 0,
    "edge": lambda view: (view.coverage > 0.05) & (view.coverage < 0.95),
}
RELATIVE = {"needle": 0.02, "background": 0.006, "edge": 0.09}
"""Over four standard deviations of the regional means' ratio, seen over 16 pairs of renders."""


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
@pytest.mark.parametrize("region", REGIONS)
def test_each_lamp_gives_each_region_the_same_light(pair, side, region):
    mine, stock = pair[0][side], pair[1][side]
    assert mine.lamps == stock.lamps
    where = REGIONS[region](mine)
    assert where.sum() > 50
    found = mine.response[:, where].mean(axis=1)
    expected = stock.response[:, where].mean(axis=1)
    np.testing.assert_allclose(found, expected, rtol=RELATIVE[region])


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_coverage_and_depth_are_the_same(pair, side):
    mine, stock = pair[0][side], pair[1][side]
    assert np.abs(mine.coverage - stock.coverage).max() < 0.08
    assert mine.coverage.sum() == pytest.approx(stock.coverage.sum(), rel=2e-3)
    off = np.abs(mine.depth_mm - stock.depth_mm) > 2e-3
    # A silhouette that passes through a pixel's very centre may fall to either side.
    assert off.sum() <= 2
    assert np.all((mine.coverage[off] > 0) & (mine.coverage[off] < 1))


def test_the_truth_does_not_depend_on_the_renderer(small_scene):
    truth = scene_truth(small_scene)
    assert truth.tip_mm.tolist() == list(small_scene.needle.tip_mm)


def views_equal(a: View, b: View) -> bool:
    return all(
        np.array_equal(getattr(a, name), getattr(b, name))
        for name in ("response", "coverage", "depth_mm")
    )


@pytest.mark.parametrize("name", ["auto", pytest.param("scalar", marks=pytest.mark.slow)])
def test_equal_seeds_give_equal_bits_and_others_do_not(scene, name):
    small = with_roi(scene, [800, 860, 40, 30], [1010, 860, 40, 30], samples=16)
    first, again, other = (
        render_pair(small, backend=choose(name), seed=seed) for seed in (7, 7, 8)
    )
    for side in (0, 1):
        assert views_equal(first[side], again[side])
        assert not np.array_equal(first[side].response, other[side].response)
