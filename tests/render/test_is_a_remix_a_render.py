"""Is a picture mixed from light groups the one that would have been rendered?

Lamps change their power, colour, spectrum and ripple; only the seed differs otherwise.
"""

from __future__ import annotations

import numpy as np
import pytest
from regions import with_roi

from simtip.noise_budget import noise_tolerance
from simtip.render import View, render_pair
from simtip.spec import SceneSpec

ROIS = [800, 856, 40, 36], [1012, 852, 40, 36]


@pytest.fixture(scope="module")
def scenes(scene):
    """The same scene in two lights."""
    data = with_roi(scene, *ROIS, samples=256).model_dump(mode="json")
    one = SceneSpec.model_validate(data)
    data["lamps"][0] |= {"power": 0.2, "spectrum": "FL2"}
    data["lamps"][1] |= {
        "radiant_power_w": 25,
        "rgb": [1, 0.6, 0.2],
        "ballast": {"kind": "magnetic", "ripple": 0.6, "phase_deg": 70},
    }
    data["ambient"]["radiance_w_m2_sr"] = [0.02, 0.001, 0.008]
    data["sensor"] |= {"exposure_s": 0.0013, "row_time_s": 1e-4}
    return one, SceneSpec.model_validate(data)


@pytest.fixture(scope="module")
def rendered(scenes):
    one, other = scenes
    return (
        render_pair(one, seed=1, tolerance=noise_tolerance(one)),
        render_pair(other, seed=2, tolerance=noise_tolerance(other)),
    )


def z_scores(spec: SceneSpec, a: View, b: View) -> np.ndarray:
    """Differences (H, W) of the mean over the channels in their standard deviations."""
    from simtip.mix import weights

    power = [
        np.broadcast_to(w, (a.response.shape[1], 3))
        for w in weights(spec, len(a.coverage)).values()
    ]
    variance = np.zeros(a.coverage.shape)
    for view in (a, b):
        # Row by row: a ripple before a rolling shutter has other weights in each.
        for row in range(len(variance)):
            variance[row] += view.noise.sd([w[row] for w in power])[row].astype(float) ** 2
    off = a.radiance(spec).mean(axis=2).astype(float) - b.radiance(spec).mean(axis=2)
    return off / np.sqrt(np.maximum(variance, 1e-30))


@pytest.mark.parametrize("side", [0, 1], ids=["left", "right"])
def test_a_remix_and_a_render_differ_by_noise_alone(scenes, rendered, side):
    one, other = scenes
    a, b = rendered[0][side], rendered[1][side]
    assert np.median(np.abs(a.radiance(one) / a.radiance(other) - 1)) > 0.1
    z = z_scores(other, a, b)
    sampled = (a.coverage > 0) | (b.coverage > 0)
    # Of a standard normal: root mean square 1, mean modulus 0.80.
    assert 0.8 < np.sqrt((z[sampled] ** 2).mean()) < 1.2
    assert 0.62 < np.abs(z[sampled]).mean() < 0.96
    assert abs(z[sampled].mean()) < 4 / np.sqrt(sampled.sum())
    assert np.sqrt((z[~sampled] ** 2).mean()) < 1.05
    assert np.abs(z).max() < 6


def test_a_lamp_of_one_percent_more_would_be_seen(scenes, rendered):
    one, _ = scenes
    data = one.model_dump(mode="json")
    a, b = rendered[0][0], rendered[1][0]
    data["lamps"][0]["power"] *= 1.01
    louder = SceneSpec.model_validate(data)
    off = (a.radiance(louder) - b.radiance(one)).mean(axis=2)
    honest = (a.radiance(one) - b.radiance(one)).mean(axis=2)
    board = a.coverage == 0
    assert abs(off[board].mean()) > 5 * abs(honest[board].mean())


@pytest.mark.slow
def test_equal_seeds_remix_to_equal_bits(scenes):
    _, other = scenes
    data = other.model_dump(mode="json")
    data["render"]["noise"] = None
    fixed = SceneSpec.model_validate(data)
    data["lamps"][0]["power"], data["sensor"]["exposure_s"] = 3.0, 0.02
    changed = SceneSpec.model_validate(data)
    for a, b in zip(render_pair(fixed, seed=5), render_pair(changed, seed=5), strict=True):
        np.testing.assert_array_equal(a.response, b.response)
        np.testing.assert_array_equal(a.radiance(fixed), b.radiance(fixed))
