from __future__ import annotations

import pytest
from regions import with_roi

from simtip.bound import TipBound, bound_digests
from simtip.bound.pose import ViewMoves
from simtip.bound.tip import _unseen
from simtip.spec import SceneSpec
from simtip.truth import scene_truth


@pytest.fixture(scope="session")
def tip_scene(scene):
    """The paper's set-up, read out where the needle's cone ends."""
    few = {"noise": None, "samples": 64, "light_step_mm": 4.0}
    return with_roi(scene, [804, 848, 34, 34], [1014, 846, 34, 34], **few)


@pytest.fixture
def bound_json():
    """Make what ``simtip bound --json`` prints of a scene, with any norm and no rendering."""

    def make(spec: SceneSpec, norm_mm: float = 0.02) -> dict:
        moves = {side: ViewMoves.of(scene_truth(spec), side) for side in ("left", "right")}
        bound = TipBound(
            scene=spec.name,
            seed=spec.seed,
            backend="none",
            inputs_sha256=bound_digests(spec),
            step_px=0.02,
            step_mm=0.001,
            samples=8,
            replicas=4,
            views={side: _unseen(one) for side, one in moves.items()},
            axes=moves["left"].axes,
        )
        each = norm_mm / 3**0.5
        return {**bound.to_dict(), "bound_mm": {**dict.fromkeys("xyz", each), "norm": norm_mm}}

    return make
