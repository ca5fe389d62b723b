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
from simtip.render.sobol import TABLE_POINTS, Points, points_of

Floats = NDArray[np.float32]
Pixels = NDArray[np.uint32]

REPLICAS = 4
FIRST_SAMPLES = 16
"""Of each replica, before the first look at the noise."""
EDGE_SAMPLES = 256
"""Likewise where an edge runs: few samples often miss what is rare there, and look quiet."""

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
    tracer: Tracer, pixels: Pixels, scene: Layout, goal: Goal, seed: int, tally: Tally
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
    """
    most = min(-(-goal.samples // REPLICAS), TABLE_POINTS)
    work = _Sampling(tracer, pixels, scene, seed, tally)
    if goal.tolerance is None:
        work.extend(np.arange(len(pixels)), most)
        return work.estimates()
    work.extend(np.arange(len(pixels)), min(FIRST_SAMPLES, most))
    if most >= EDGE_SAMPLES:
        work.extend(work.edges(), EDGE_SAMPLES - FIRST_SAMPLES)
    while (wanted := work.wanted(goal.weights, goal.tolerance, most)).any():
        for add in np.unique(wanted[wanted > 0]):
            work.extend(np.flatnonzero(wanted == add), int(add))
    return work.estimates()


class _Sampling:
    """Running sums of pixels, each replica on its own."""

    def __init__(
        self, tracer: Tracer, pixels: Pixels, scene: Layout, seed: int, tally: Tally
    ) -> None:
        self._tracer, self._pixels, self._scene = tracer, pixels, scene
        self._seed, self._tally = seed, tally
        self._sums = np.zeros((len(pixels), REPLICAS, 3 * scene.groups + 2), np.float32)
        self._done = np.zeros(len(pixels), np.int64)

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

    def wanted(self, weights: Floats, tolerance: Tolerance, most: int) -> NDArray[np.int64]:
        """Give how many more samples each pixel's replicas need (n,), in powers of two.

        From the noise so far, as if its variance fell with the samples; never more than there are,
        so that a first guess from few is looked at again.
        """
        response = self._average()[..., : 3 * self._scene.groups]
        mixed = np.einsum(
            "nrgc,gc->nrc",
            response.reshape(*response.shape[:2], self._scene.groups, 3),
            weights,
        )
        scatter = mixed.mean(axis=2).var(axis=1, ddof=1) / REPLICAS
        variance = self._pooled(scatter)
        allowed = np.maximum(tolerance(mixed.mean(axis=1)), np.float32(1e-30)) ** 2
        needle, clutter = np.moveaxis(self._sums[..., -2:].sum(axis=1), -1, 0)
        allowed[(needle == 0) & (clutter > 0)] *= CLUTTER_LEAVE**2
        lacking = self._done * (np.minimum(variance / allowed, 1e6) - 1)
        add = 2 ** np.ceil(np.log2(np.maximum(lacking, FIRST_SAMPLES / 2)))
        add = np.minimum(np.minimum(add, self._done), most - self._done)
        wanted: NDArray[np.int64] = np.where(lacking > 0, add, 0).astype(np.int64)
        return wanted

    def estimates(self) -> Estimates:
        """Give the means, and their errors."""
        average = self._average()
        total = average.mean(axis=1)
        groups = self._scene.groups
        return Estimates(
            response=total[:, : 3 * groups].reshape(len(total), groups, 3),
            needle=total[:, -2],
            clutter=total[:, -1],
            covariance=self._covariance(average),
            samples=(self._done * REPLICAS).astype(np.uint32),
        )

    def _average(self) -> Floats:
        count = np.maximum(self._done, 1).astype(np.float32)
        average: Floats = self._sums / count[:, None, None]
        return average

    def _covariance(self, average: Floats) -> Floats:
        """Give the covariance (n, groups, groups) of the pixels' means, per channel mean."""
        groups = self._scene.groups
        gray = average[..., : 3 * groups].reshape(*average.shape[:2], groups, 3).mean(axis=3)
        off = gray - gray.mean(axis=1, keepdims=True)
        found: Floats = np.einsum("nri,nrj->nij", off, off) / np.float32(REPLICAS * (REPLICAS - 1))
        for i in range(groups):
            for j in range(i, groups):
                found[:, i, j] = found[:, j, i] = self._pooled(found[:, i, j])
        return found

    def _pooled(self, variance: Floats) -> Floats:
        """Average (n,) variances over a pixel's neighbours, as if all had as many samples.

        Only neighbours of its kind count: an edge is far noisier than what lies beside it.
        """
        count = np.maximum(self._done, 1).astype(np.float32)
        v, u = np.divmod(self._pixels.astype(np.intp), self._scene.columns)
        v, u = v - v.min(initial=v.max(initial=0)), u - u.min(initial=u.max(initial=0))
        kinds = self._kinds()
        pooled = variance.copy()
        for kind in np.unique(kinds):
            (own,) = np.nonzero(kinds == kind)
            image = np.zeros((v.max() + 1, u.max() + 1, 2), np.float32)
            image[v[own], u[own], 0] = variance[own] * count[own]
            image[v[own], u[own], 1] = 1
            near = cv2.blur(image, (3, 3), borderType=cv2.BORDER_CONSTANT)[v[own], u[own]]
            pooled[own] = near[:, 0] / near[:, 1] / count[own]
        return pooled

    def edges(self) -> NDArray[np.intp]:
        """Give the pixels in which needle or clutter begins, and those beside them."""
        covered = self._average()[..., -2:].mean(axis=1)
        partly = ((covered > 0) & (covered < 1)).any(axis=1)
        if not partly.any():
            return np.zeros(0, np.intp)
        v, u = np.divmod(self._pixels.astype(np.intp), self._scene.columns)
        v, u = v - v.min(), u - u.min()
        image = np.zeros((v.max() + 1, u.max() + 1), np.uint8)
        image[v[partly], u[partly]] = 1
        return np.flatnonzero(cv2.dilate(image, np.ones((3, 3), np.uint8))[v, u])

    def _kinds(self) -> NDArray[np.int64]:
        """Tell pixels (n,) apart: needle and clutter cover them not, in part or wholly."""
        covered = self._average()[..., -2:].mean(axis=1)
        needle, clutter = ((covered > 0).astype(np.int64) + (covered >= 1)).T
        return np.asarray(3 * needle + clutter)
