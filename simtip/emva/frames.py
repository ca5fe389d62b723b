"""From frames to numbers: one pass over a series, whatever its length, in a few frames' memory."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simtip.emva.estimate import Array
from simtip.errors import InputError

Frame = NDArray[np.uint8] | NDArray[np.uint16]


@dataclass(frozen=True)
class Level:
    """One point of the photon transfer: equal frames, summed up.

    Attributes
    ----------
    photons
        Mean photons on a pixel during the exposure; 0 is dark.
    exposure_s
        Exposure time, s.
    mean_dn
        Over all pixels and frames, DN.
    variance_dn2
        Temporal variance, rounding included, averaged over the pixels, DN^2.
    frames, pixels
        How many.
    zero_fraction, top_fraction
        Share of the samples at DN 0 and at the top code.
    """

    photons: float
    exposure_s: float
    mean_dn: float
    variance_dn2: float
    frames: int
    pixels: int
    zero_fraction: float = 0.0
    top_fraction: float = 0.0

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the variance: a pair of frames gives one per pixel, less one."""
        return (self.frames // 2) * (self.pixels - 1)


@dataclass(frozen=True)
class MeanFrame:
    """The average of a series, pixel by pixel.

    Attributes
    ----------
    level
        The same series, summed up.
    mean_dn
        (H, W) float64, DN.
    residual_dn2
        Temporal variance left in `mean_dn`, averaged over the pixels: sigma^2 / frames, DN^2.
    """

    level: Level
    mean_dn: Array
    residual_dn2: float


class _Sums:
    """Running sums over a series; checks every frame as it comes."""

    def __init__(self, bit_depth: int) -> None:
        if not 1 <= bit_depth <= 16:
            raise InputError(
                f"{bit_depth} bits", field="bit_depth", remedy="give a number from 1 to 16"
            )
        self.top = 2**bit_depth - 1
        self.frames = 0
        self.shape: tuple[int, ...] = ()
        self.total = self.squares = 0.0
        self.zeros = self.tops = 0
        self._waiting: NDArray[Any] | None = None

    def add(self, frame: NDArray[Any]) -> None:
        if frame.dtype not in (np.uint8, np.uint16) or frame.ndim != 2 or frame.size < 2:
            raise InputError(
                f"a frame is (H, W) uint8 or uint16, not {frame.shape} {frame.dtype}",
                field="frames",
                remedy="give raw frames of one channel",
            )
        self.shape = self.shape or frame.shape
        if frame.shape != self.shape:
            raise InputError(
                f"a frame of {frame.shape} among frames of {self.shape}",
                field="frames",
                remedy="give frames of one size",
            )
        if int(frame.max()) > self.top:
            raise InputError(
                f"a frame holds {frame.max()} DN, above the top code {self.top}",
                field="bit_depth",
                remedy="give the bit depth of the values as stored",
            )
        self.frames += 1
        self.total += float(frame.sum(dtype=np.uint64))
        self.zeros += frame.size - int(np.count_nonzero(frame))
        self.tops += int(np.count_nonzero(frame == self.top))
        if self._waiting is None:
            # A copy: a grabber may fill one buffer again and again.
            self._waiting = frame.copy()
        else:
            difference = np.subtract(frame, self._waiting, dtype=np.float64).ravel()
            # A change of the light between the two is no noise of the pixels.
            offset = difference.sum() ** 2 / difference.size
            self.squares += float(difference @ difference - offset)
            self._waiting = None

    def level(self, photons: float, exposure_s: float) -> Level:
        if self.frames < 2:
            raise InputError(
                f"{self.frames} frames at {photons:g} photons, {exposure_s:g} s",
                field="frames",
                remedy="give two at least: temporal noise is the difference of a pair",
            )
        pixels = int(np.prod(self.shape))
        samples = pixels * self.frames
        return Level(
            photons=photons,
            exposure_s=exposure_s,
            mean_dn=self.total / samples,
            variance_dn2=self.squares / (2 * (self.frames // 2) * (pixels - 1)),
            frames=self.frames,
            pixels=pixels,
            zero_fraction=self.zeros / samples,
            top_fraction=self.tops / samples,
        )


def summarise(
    frames: Iterable[Frame], *, photons: float, exposure_s: float, bit_depth: int
) -> Level:
    """Sum up equal frames: mean, and temporal variance from the differences of pairs.

    Frames 1 and 2, 3 and 4, ... are pairs; each gives half the variance over the pixels of its
    difference (EMVA 1288, temporal variance), with one degree of freedom taken by its mean.

    Parameters
    ----------
    frames
        At least two, (H, W) uint8 or uint16, raw, of one channel. Two are in memory at a time.
    photons, exposure_s
        Mean photons on a pixel (0 is dark) and exposure time, s, of these frames.
    bit_depth
        Bits of the values as stored; the top code is ``2**bit_depth - 1``.

    Raises
    ------
    InputError
        Fewer than two frames, frames of differing or wrong shape, or a value above the top code.
    """
    sums = _Sums(bit_depth)
    for frame in frames:
        sums.add(frame)
    return sums.level(photons, exposure_s)


def average(
    frames: Iterable[Frame], *, photons: float, exposure_s: float, bit_depth: int
) -> MeanFrame:
    """Average equal frames pixel by pixel, for spatial statistics.

    Arguments and errors as for `summarise`. Keeps the running mean and the running sum of
    squared deviations of each pixel (Welford 1962), whatever the number of frames.
    """
    sums = _Sums(bit_depth)
    mean, squares = _moments(frames, sums)
    level = sums.level(photons, exposure_s)
    variance = float(np.mean(squares)) / (level.frames - 1)
    return MeanFrame(level, mean, variance / level.frames)


def _moments(frames: Iterable[Frame], sums: _Sums) -> tuple[Array, Array]:
    source: Iterator[Frame] = iter(frames)
    mean = squares = np.zeros(())
    for frame in source:
        sums.add(frame)
        if sums.frames == 1:
            mean, squares = np.zeros(frame.shape), np.zeros(frame.shape)
        step = frame - mean
        mean += step / sums.frames
        squares += step * (frame - mean)
    return mean, squares
