"""Sample pixels until each is as free of noise as was asked.

Every pixel is estimated by four independent replicas, each with its own sequence of low
discrepancy. Their scatter is the error of the pixel's mean; averaged over the neighbours it also
decides which pixels go on. A pixel that stops because its replicas agree by chance makes a small
bias; averaging over 3 x 3 pixels with 27 degrees of freedom keeps it under a tenth of the noise
asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.render.chunks import batches, means
from simtip.render.engine import dr, mi
from simtip.render.progress import Tally
from simtip.render.sobol import Points, points_of
from simtip.render.sobol_table import TABLE_POINTS

Floats = NDArray[np.float32]
Pixels = NDArray[np.uint32]

REPLICAS = 4
FIRST_SAMPLES = 16
"""Of each replica, before the first look at the noise."""
EDGE_SAMPLES = 256
"""Likewise where an edge runs: few samples often miss what is rare there, and look quiet."""

PLAIN_SAMPLES = 1
"""Likewise in pixels known to be smooth."""

CLUTTER_LEAVE = 3.0
"""Clutter away from the needle may be so many times as noisy."""

Tolerance = Callable[[Floats], Floats]
"""From mixed radiance (n, 3) to the standard deviation (n,) that its mean may have."""

Tracer = Callable[[Any, Points], list[Any]]
"""From pixel indices and sample points to values: groups x (r, g, b), needle, clutter."""


@dataclass(frozen=True)
class Goal:
    """How much is to be spent.

    Attributes
    ----------
    samples
        Per pixel, at most; all of them without a tolerance.
    weights
        (groups, 3) by which the groups are mixed when the noise is judged.
    tolerance
        From mixed radiance (n, 3) to the standard deviation (n,) that its mean over the channels
        may have; None: no looking.
    """

    samples: int
    weights: Floats
    tolerance: Tolerance | None = None


@dataclass(frozen=True)
class Layout:
    """What is to be sampled.

    Attributes
    ----------
    columns
        Width of the image, px.
    groups
        Number of light groups, the ambient included.
    """

    columns: int
    groups: int


@dataclass(frozen=True, eq=False)
class Estimates:
    """Means of pixels, in the order asked for.

    Attributes
    ----------
    response
        (n, groups, 3) float32.
    needle, clutter
        (n,) float32, the part of each pixel that each covers.
    covariance
        (n, groups, groups), see `simtip.render.noise.Noise`.
    samples
        (n,) uint32.
    """

    response: Floats
    needle: Floats
    clutter: Floats
    covariance: Floats
    samples: NDArray[np.uint32]


def estimate(
    tracer: Tracer,
    pixels: Pixels,
    scene: Layout,
    goal: Goal,
    seed: int,
    tally: Tally,
    plain: NDArray[np.bool_] | None = None,
) -> Estimates:
    """Estimate pixels.

    Parameters
    ----------
    tracer
        What a sample brings back.
    pixels
        (n,) flat indices.
    scene
        What is to be sampled.
    goal
        When to stop.
    seed
        Of the samples.
    tally
        Told what is planned and done.
    plain
        (n,) pixels known to show something smooth, for which a few samples do.
    """
    most = min(-(-goal.samples // REPLICAS), TABLE_POINTS)
    easy = np.zeros(len(pixels), np.bool_) if plain is None else plain
    work = _Sampling(tracer, pixels, scene, goal, seed, tally, easy)
    every = np.arange(len(pixels))
    if goal.tolerance is None:
        work.extend(every, most)
        return work.estimates()
    work.extend(every[easy], min(PLAIN_SAMPLES, most))
    work.extend(every[~easy], min(FIRST_SAMPLES, most))
    if most >= EDGE_SAMPLES:
        work.extend(work.edges(), EDGE_SAMPLES - FIRST_SAMPLES)
    while len(which := (wanted := work.wanted(goal.tolerance, most)).nonzero()[0]):
        for add in np.unique(wanted[which]):
            work.extend(np.flatnonzero(wanted == add), int(add))
    return work.estimates()


class _Sampling:
    """Running sums of pixels, each replica on its own."""

    def __init__(
        self,
        tracer: Tracer,
        pixels: Pixels,
        scene: Layout,
        goal: Goal,
        seed: int,
        tally: Tally,
        plain: NDArray[np.bool_],
    ) -> None:
        self._plain = plain
        self._tracer, self._pixels, self._scene = tracer, pixels, scene
        self._weights, self._seed, self._tally = goal.weights, seed, tally
        self._sums = np.zeros((len(pixels), REPLICAS, 3 * scene.groups + 2), np.float32)
        self._done = np.zeros(len(pixels), np.int64)
        self._mixed = np.zeros((len(pixels), 3), np.float32)
        self._scatter = np.zeros(len(pixels), np.float32)
        self._covered = np.zeros((len(pixels), 2), np.float32)
        v, u = np.divmod(pixels.astype(np.intp), scene.columns)
        self._place = v - v.min(initial=v.max(initial=0)), u - u.min(initial=u.max(initial=0))
        self._shape = (
            int(self._place[0].max(initial=0)) + 1,
            int(self._place[1].max(initial=0)) + 1,
        )

    def extend(self, which: NDArray[np.intp], add: int) -> None:
        """Take `add` more samples of each replica of some pixels."""
        if not len(which):
            return
        self._tally.plan(len(which) * REPLICAS * add)
        replica = np.arange(REPLICAS, dtype=np.uint32)
        owners = (self._pixels[which, None] * np.uint32(REPLICAS) + replica).reshape(-1)
        starts = np.repeat(self._done[which], REPLICAS).astype(np.uint32)
        found = []
        for part in batches(np.stack([owners, starts], axis=1), add):
            points, index = points_of(part[:, 0], add, self._seed, start=part[:, 1])
            pixel = dr.gather(mi.UInt32, mi.UInt32(part[:, 0] // np.uint32(REPLICAS)), index)
            found.append(means(self._tracer(pixel, points), add))
            self._tally.add(len(part) * add)
        sums = np.concatenate(found) * np.float32(add)
        self._sums[which] += sums.reshape(len(which), REPLICAS, -1)
        self._done[which] += add
        self._look_at(which)

    def _look_at(self, which: NDArray[np.intp]) -> None:
        """Work out what some pixels show, and how their replicas scatter."""
        average = self._average(which)
        groups = self._scene.groups
        response = average[..., : 3 * groups].reshape(len(which) * REPLICAS, groups * 3)
        # Each channel's mix at once: (groups * 3, 3).
        power = (self._weights[:, :, None] * np.eye(3, dtype=np.float32)).reshape(-1, 3)
        mixed = (response @ power).reshape(len(which), REPLICAS, 3)
        gray = mixed.mean(axis=2)
        off = gray - gray.mean(axis=1, keepdims=True)
        self._mixed[which] = mixed.mean(axis=1)
        self._scatter[which] = (off**2).sum(axis=1) / np.float32(REPLICAS * (REPLICAS - 1))
        self._covered[which] = average[..., -2:].mean(axis=1)

    def wanted(self, tolerance: Tolerance, most: int) -> NDArray[np.int64]:
        """Give how many more samples each pixel's replicas need (n,), in powers of two.

        From the noise so far, as if its variance fell with the samples; never more than there are,
        so that a first guess from few is looked at again.
        """
        (variance,) = self._pooled(self._scatter[:, None]).T
        allowed = np.maximum(tolerance(self._mixed), np.float32(1e-30)) ** 2
        needle, clutter = self._covered.T
        allowed[(needle == 0) & (clutter > 0)] *= CLUTTER_LEAVE**2
        lacking = self._done * (np.minimum(variance / allowed, 1e6) - 1)
        add = 2 ** np.ceil(np.log2(np.maximum(lacking, FIRST_SAMPLES / 2)))
        add = np.minimum(np.minimum(add, self._done), most - self._done)
        wanted: NDArray[np.int64] = np.where(lacking > 0, add, 0).astype(np.int64)
        return wanted

    def estimates(self) -> Estimates:
        """Give the means, and their errors."""
        every = np.arange(len(self._pixels))
        average = self._average(every)
        total = average.mean(axis=1)
        groups = self._scene.groups
        return Estimates(
            response=total[:, : 3 * groups].reshape(len(total), groups, 3),
            needle=total[:, -2],
            clutter=total[:, -1],
            covariance=self._covariance(average),
            samples=(self._done * REPLICAS).astype(np.uint32),
        )

    def _average(self, which: NDArray[np.intp]) -> Floats:
        count = np.maximum(self._done[which], 1).astype(np.float32)
        average: Floats = self._sums[which] / count[:, None, None]
        return average

    def _covariance(self, average: Floats) -> Floats:
        """Give the covariance (n, groups, groups) of the pixels' means, per channel mean."""
        groups = self._scene.groups
        gray = average[..., : 3 * groups].reshape(*average.shape[:2], groups, 3).mean(axis=3)
        off = gray - gray.mean(axis=1, keepdims=True)
        i, j = np.triu_indices(groups)
        products = (off[..., i] * off[..., j]).sum(axis=1) / np.float32(REPLICAS * (REPLICAS - 1))
        pooled = self._pooled(products)
        found = np.empty((len(average), groups, groups), np.float32)
        found[:, i, j] = found[:, j, i] = pooled
        return found

    def _pooled(self, variance: Floats) -> Floats:
        """Average (n, k) variances over a pixel's neighbours, as if all had as many samples.

        Only neighbours of its kind count: an edge is far noisier than what lies beside it.
        """
        count = np.maximum(self._done, 1).astype(np.float32)[:, None]
        weighted = variance * count
        v, u = self._place
        kinds = self._kinds()
        pooled = np.empty_like(variance)
        for kind in np.unique(kinds):
            (own,) = np.nonzero(kinds == kind)
            image = np.zeros((*self._shape, 1), np.float32)
            image[v[own], u[own], 0] = 1
            many = _around(image)[v[own], u[own]]
            for k in range(variance.shape[1]):
                image[v[own], u[own], 0] = weighted[own, k]
                pooled[own, k] = _around(image)[v[own], u[own]] / many
        return pooled / count

    def edges(self) -> NDArray[np.intp]:
        """Give the pixels in which needle or clutter begins, and those beside them."""
        partly = ((self._covered > 0) & (self._covered < 1)).any(axis=1)
        if not partly.any():
            return np.zeros(0, np.intp)
        v, u = self._place
        image = np.zeros(self._shape, np.uint8)
        image[v[partly], u[partly]] = 1
        return np.flatnonzero(cv2.dilate(image, np.ones((3, 3), np.uint8))[v, u])

    def _kinds(self) -> NDArray[np.int64]:
        """Tell pixels (n,) apart: plain ones; needle and clutter cover them not, partly, wholly."""
        needle, clutter = ((self._covered > 0).astype(np.int64) + (self._covered >= 1)).T
        return np.asarray(9 * self._plain + 3 * needle + clutter)


def _around(image: Floats) -> Floats:
    """Average an image (H, W, 1) over 3 x 3 pixels: (H, W)."""
    mean: Floats = np.asarray(cv2.blur(image, (3, 3), borderType=cv2.BORDER_CONSTANT), np.float32)
    return mean
