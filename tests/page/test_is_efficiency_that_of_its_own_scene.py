"""A bound is one scene's: do only trials of that scene count against it?"""

from __future__ import annotations

import json

import numpy as np
import pytest
from made_tables import grid, scene_data

from simtip.bound import KnownBound
from simtip.bound.inputs import bound_digests
from simtip.errors import InputError
from simtip.page.folder import results_in
from simtip.page.make import page_of
from simtip.page.options import Options
from simtip.spec import SceneSpec
from simtip.sweep.assignment import Scenes
from simtip.sweep.table import Table

BOUND_MM = 0.01


def bound_of(**values) -> KnownBound:
    scene = SceneSpec.model_validate_json(json.dumps(scene_data()), strict=True)
    return KnownBound(BOUND_MM, bound_digests(Scenes(scene).with_values(values)))


def test_trials_of_the_bounds_scene_count_and_no_others(tmp_path):
    """Thresholds and detectors share a scene; lamp powers do not."""
    folder = grid(tmp_path / "sweep")
    bound = bound_of(**{"lamps[0].power": 1.5})
    page = page_of(results_in(folder), Options(pictures=0, bound=bound))
    frame = Table.open(folder).frame()
    own = frame[(frame["lamps[0].power"] == 1.5) & frame["error_norm_mm"].notna()]
    expected = BOUND_MM / np.sqrt((own["error_norm_mm"].astype(float) ** 2).mean())
    fact = next(fact for fact in page.facts if fact.name == "Efficiency")
    assert float(fact.value) == pytest.approx(expected, rel=6e-3)
    assert fact.remark.endswith(f"{len(own)} trials")


@pytest.mark.slow
def test_the_map_shows_it_where_it_is_known(tmp_path, opened):
    from made_tables import written

    folder = grid(tmp_path / "sweep")
    file = written(folder, bound=bound_of(**{"lamps[0].power": 1.5}))
    frame = Table.open(folder).frame()
    own = frame[(frame["lamps[0].power"] == 1.5) & (frame["detect.threshold"] == 80)]
    own = own[own["detector"] == "lin2020"]["error_norm_mm"].astype(float)
    with opened(file) as page:
        page.get_by_label("Colour", exact=True).select_option("efficiency")
        drawn = page.locator(".map svg text").all_text_contents()
        cells = page.locator(".map [data-cell]:not(.none)").count()
        assert cells == 5  # a threshold each, at one power
        value = BOUND_MM / np.sqrt((own**2).mean())
        assert f"{value:.3f}" in drawn or f"{value:.4f}" in drawn


def test_a_bound_of_none_of_its_scenes_is_refused(tmp_path):
    folder = grid(tmp_path / "sweep")
    bound = bound_of(**{"lamps[0].power": 1.7})
    with pytest.raises(InputError, match=r"is the bound of another scene .* not the same lamps"):
        page_of(results_in(folder), Options(pictures=0, bound=bound))
