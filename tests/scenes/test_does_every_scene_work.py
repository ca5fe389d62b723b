"""Does every scene that ships load, render small, and show its needle's tip?"""

from __future__ import annotations

import numpy as np
import pytest
from stored_crops import SCENES, quick_or_slow

from simtip.geometry import Pose

ON_AXIS_MM = (1.5, 2.0, 2.5, 3.0)
"""From the tip; of a bevel, some of them may lie beside the metal."""


@pytest.mark.parametrize(
    "path", [quick_or_slow(path) for path in SCENES], ids=lambda path: path.stem
)
def test_it_loads_and_renders_its_tip(path, simulated):
    done = simulated(path)
    spec = done.spec
    rig, needle = spec.rig.rig(), spec.needle.needle()
    places = np.stack([np.zeros(4), np.zeros(4), ON_AXIS_MM], axis=1)
    if needle.bend is not None:
        places = needle.bend.apply(places)
    shaft = spec.needle.pose().apply(places)
    poses = Pose.identity(), rig.T_lr.inverse()
    truths = done.truth.left, done.truth.right
    for image, view, truth, camera, T_cw in zip(
        done.images, done.views, truths, (rig.left, rig.right), poses, strict=True
    ):
        u, v = np.rint(camera.project(T_cw.apply(shaft))).astype(int).T
        assert view.coverage[v, u].max() == 1
        u, v = np.rint(truth.tip_px).astype(int)
        assert 0 < view.coverage[v - 3 : v + 4, u - 3 : u + 4].mean() < 1
        assert not view.coverage[v + 8 :].any()
        # Neither black nor saturated, and the needle differs from the board.
        top = 2.0**spec.sensor.bit_depth - 1
        gray = image.astype(float).mean(axis=2) / top
        board, metal = gray[view.coverage == 0], gray[view.coverage == 1]
        assert 0.05 < np.median(board) < 0.95
        assert abs(np.median(metal) / np.median(board) - 1) > 0.02
