"""Is the Monte-Carlo error that a view states the one it has, and as small as was asked?

Claimed and true are compared by their mean squares over a region.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from regions import with_roi

from simtip.mix import weights
from simtip.noise_budget import noise_tolerance
from simtip.render import render_pair
from simtip.spec import SceneSpec

ROIS = [797, 843, 40, 40], [1009, 838, 40, 40]
REGIONS = {
    "needle": lambda coverage: coverage > 0.9999,
    "edge": lambda coverage: (coverage > 0) & (coverage <= 0.9999),
    "open": lambda coverage: coverage == 0,
}
CLAIMED = {"needle": (0.85, 1.2), "edge": (0.85, 1.2), "open": (0.8, 1.25)}
"""Claimed over true, sampled evenly. Seen, in six scenes: 0.93 to 1.08, 0.96 to 1.07, and on the
open board 0.99 to 1.02."""
ADAPTIVE = {"needle": (0.85, 1.2), "edge": (0.75, 1.2), "open": (0.8, 1.25)}
"""The same of pixels that stop once they seem good enough: those that seem better than they are
stop first. Seen with 16 seeds: 0.94 to 0.98, 0.87 to 0.96."""


class Renders:
    """Renders of one scene that differ in their seed only."""

    def __init__(self, spec: SceneSpec, seeds: int) -> None:
        tolerance = noise_tolerance(spec)
        self.views = [render_pair(spec, tolerance=tolerance, seed=k + 1) for k in range(seeds)]
        power = [np.asarray(w).reshape(-1, 3)[0] for w in weights(spec, 40).values()]
        self.light = np.stack([
            [np.einsum("ghwc,gc->hwc", view.response, power) for view in pair]
            for pair in self.views
        ]).astype(float)  # fmt: skip
        self.variance = self.light.mean(axis=-1).var(axis=0, ddof=1)
        claims = [[view.noise.sd(power) ** 2 for view in pair] for pair in self.views]
        self.claimed = np.mean(claims, axis=0, dtype=float)
        self.coverage = np.mean([[view.coverage for view in pair] for pair in self.views], axis=0)
        self.allowed = np.zeros_like(self.variance)
        if tolerance is not None:
            mean = self.light.mean(axis=0).astype(np.float32)
            board = np.median(mean[self.coverage == 0], axis=0)
            self.allowed = tolerance(mean.reshape(-1, 3), board).reshape(2, 40, 40).astype(float)

    def capped(self, samples: int) -> np.ndarray:
        """Pixels (2, 40, 40) that took all they might in some render."""
        found = np.zeros((2, 1600), bool)
        for pair in self.views:
            for side, view in enumerate(pair):
                found[side, view.noise.pixels[view.noise.samples >= samples]] = True
        return found.reshape(2, 40, 40)


@pytest.fixture(scope="module")
def renders(scene):
    @cache
    def make(*, adaptive: bool, seeds: int) -> Renders:
        render = {} if adaptive else {"noise": None, "samples": 64}
        return Renders(with_roi(scene, *ROIS, **render), seeds)

    return make


def check(found: Renders, bounds: dict[str, tuple[float, float]]) -> None:
    for name, region in REGIONS.items():
        where = region(found.coverage)
        assert where.sum() > 100
        ratio = np.sqrt(found.claimed[where].mean() / found.variance[where].mean())
        low, high = bounds[name]
        assert low < ratio < high, f"{name}: {ratio:.2f}"


def test_evenly_sampled_pixels_are_as_noisy_as_they_claim(renders):
    check(renders(adaptive=False, seeds=4), CLAIMED)


@pytest.mark.slow
def test_adaptive_pixels_are_nearly_so(renders):
    check(renders(adaptive=True, seeds=8), ADAPTIVE)


@pytest.mark.slow
def test_the_noise_is_what_was_asked_for(renders, scene):
    """0.3 of the sensor's own. Seen: needle 0.8 to 0.95, edges 0.8 to 1.0."""
    found = renders(adaptive=True, seeds=8)
    free = ~found.capped(scene.render.samples)
    for name, most in (("needle", 1.1), ("edge", 1.25), ("open", 1.1)):
        where = REGIONS[name](found.coverage) & free
        asked = np.sqrt((found.variance / found.allowed**2)[where].mean())
        assert asked < most, f"{name}: {asked:.2f}"


@pytest.mark.slow
def test_stopping_early_hardly_biases(renders, scene):
    """Against three renders of 2048 samples: mean bias under a tenth of the noise asked for."""
    found = renders(adaptive=True, seeds=8)
    fixed = Renders(with_roi(scene, *ROIS, noise=None, samples=2048), 3)
    off = (found.light.mean(axis=0) - fixed.light.mean(axis=0)).mean(axis=-1) / found.allowed
    for name in ("needle", "edge"):
        where = REGIONS[name](found.coverage)
        chance = np.sqrt((found.variance / 8 / found.allowed**2)[where].mean() / where.sum())
        assert abs(off[where].mean()) < 0.1 + 4 * chance, f"{name}: {off[where].mean():.3f}"


@pytest.mark.slow
def test_the_light_map_too_gets_as_quiet_as_asked(scene):
    """A twentieth of the sensor's noise: four times less than its usual samples bring."""
    found = Renders(with_roi(scene, *ROIS, noise=0.05, samples=64), 6)
    open_board = found.coverage == 0
    asked = np.sqrt((found.variance / found.allowed**2)[open_board].mean())
    assert 0.2 < asked < 1.1, f"{asked:.2f}"
    ratio = np.sqrt(found.claimed[open_board].mean() / found.variance[open_board].mean())
    assert 0.8 < ratio < 1.25, f"{ratio:.2f}"


def test_half_the_claim_would_be_seen(renders):
    found = renders(adaptive=False, seeds=4)
    halved = object.__new__(Renders)
    halved.__dict__ |= found.__dict__ | {"claimed": found.claimed / 4}
    with pytest.raises(AssertionError):
        check(halved, CLAIMED)
