"""All steps of the sensor, in order."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.sensor.dark import dark_electrons, hot_electrons
from simtip.sensor.light import checked, responsivity
from simtip.sensor.mosaic import demosaic, sample, sample_indices, tile
from simtip.sensor.pattern import FixedPattern
from simtip.sensor.readout import Image, amplify, gains, gamma_curve, quantise, read_noise, saturate
from simtip.sensor.real import Array
from simtip.sensor.shot import draw
from simtip.spec import SensorSpec

_BLOCK = 65536  # values worked on at a time: several such arrays stay in the cache
_HUGE_E = 1e30  # below the end of single precision, far beyond every well


def expose(
    irradiance_w_m2: ArrayLike,
    spec: SensorSpec,
    *,
    camera: FixedPattern,
    rng: np.random.Generator,
) -> Image:
    """Take the picture.

    Parameters
    ----------
    irradiance_w_m2
        (H, W, 3) W m^-2 per channel, on the sensor.
    spec
        The sensor. With ``noise: false`` the result is `expected_dn`, rounded.
    camera
        Fixed differences between the pixels, from `fixed_pattern`, or `UNIFORM`. They are what
        counts: `prnu_percent`, `dsnu_e` and the defects' fractions are not looked at here.
    rng
        Gives each source of noise a stream of its own (by spawning), so that one effect switched
        off leaves the others' noise as it was. Generators made alike give the same picture; one
        used twice gives two. The noise belongs to places in the array: a crop has other noise.

    Returns
    -------
    image
        (H, W, 3) DN, uint8 at 8 bit, uint16 above.

    Raises
    ------
    ValueError
        Another shape, also of the pattern; an irradiance that is negative or not finite; with a
        mosaic, fewer than 3 x 3 pixels.
    """
    light = checked(irradiance_w_m2)
    steps = _Steps(light, spec, camera)
    normals, uniforms, reading = rng.spawn(3)
    shot = spec.noise and spec.effects.shot_noise
    read = spec.noise and spec.effects.read_noise and spec.read_noise_e > 0
    noisy = shot or read
    shape = steps.shape
    image: Image = np.empty(shape, np.uint8) if spec.bit_depth <= 8 else np.empty(shape, np.uint16)
    for rows in steps.blocks():
        # Without noise, rounding decides: double precision keeps it right.
        collected = steps.mean(rows, np.dtype(np.float32 if noisy else np.float64))
        if shot:
            collected = draw(collected, normals, uniforms)
        collected = steps.filled(collected, rows)
        if read:
            collected = read_noise(collected, spec.read_noise_e, reading)
        image[rows] = quantise(steps.amplified(collected, rows), spec.bit_depth)
    return image.reshape(light.shape) if spec.mosaic is None else demosaic(image, camera.origin)


def expected_dn(irradiance_w_m2: ArrayLike, spec: SensorSpec, *, camera: FixedPattern) -> Array:
    """Give the noise-free digital number before rounding, (H, W, 3) float64, within the range.

    It is the mean of what `expose` gives wherever neither the full well nor an end of the range
    is within reach of the noise, quantisation is finer than it and gamma is 1. A mosaic is left
    out: every pixel has all channels. Arguments and errors as there.
    """
    light = checked(irradiance_w_m2)
    steps = _Steps(light, spec.model_copy(update={"mosaic": None}), camera)
    dn = np.empty(steps.shape)
    for rows in steps.blocks():
        collected = steps.filled(steps.mean(rows, np.dtype(np.float64)), rows)
        dn[rows] = steps.amplified(collected, rows)
    return np.clip(dn, 0, 2**spec.bit_depth - 1).reshape(light.shape)


class _Steps:
    """The steps without temporal noise, for blocks of rows of (H, 3 W), or with a mosaic (H, W)."""

    def __init__(self, light: NDArray[Any], spec: SensorSpec, camera: FixedPattern) -> None:
        for pattern in (camera.response, camera.dsnu_e):
            if pattern is not None and pattern.shape != light.shape:
                raise ValueError(
                    f"the fixed pattern has the shape {pattern.shape}, the light {light.shape}"
                )
        self.spec = spec
        height, width, _ = light.shape
        self._hot = camera.hot
        if spec.mosaic is None:
            self.shape = (height, 3 * width)
            self._rows = light.reshape(self.shape)
            self._response, self._dsnu_e = (
                None if planes is None else planes.reshape(self.shape)
                for planes in (camera.response, camera.dsnu_e)
            )
            self._per_irradiance = np.tile(responsivity(spec), width)[None]
            self._gain = np.tile(gains(spec), width)[None]
        else:
            self.shape = (height, width)
            self._rows = sample(light, camera.origin)
            self._response, self._dsnu_e = (
                None if planes is None else sample(planes, camera.origin)
                for planes in (camera.response, camera.dsnu_e)
            )
            channels = np.tile(tile(camera.origin), (1, width))[:, :width]
            self._per_irradiance = responsivity(spec)[channels]
            self._gain = gains(spec)[channels]
            if camera.hot is not None:
                self._hot = sample_indices(camera.hot, width, camera.origin)
        self._dark_e, self._hot_e = dark_electrons(spec), hot_electrons(spec)
        self._limit_e = _surely_full_e(spec, camera)

    def blocks(self) -> list[slice]:
        """Give groups of rows of about `_BLOCK` values."""
        height, width = self.shape
        step = max(1, _BLOCK // width)
        return [slice(top, min(top + step, height)) for top in range(0, height, step)]

    def mean(self, rows: slice, kind: np.dtype[Any]) -> NDArray[Any]:
        """Give what the pixels collect on average: light times response, and dark current.

        Both kinds of electrons are drawn in one: the sum of two Poisson numbers is Poisson.
        Limited to where the well is full whatever the noise, so that nothing overflows.
        """
        per_irradiance = self._per_irradiance.astype(kind)
        if len(per_irradiance) > 1:  # rows of a mosaic differ
            per_irradiance = per_irradiance[np.arange(rows.start, rows.stop) % 2]
        with np.errstate(over="ignore"):
            mean = self._rows[rows].astype(kind) * per_irradiance
        mean = np.minimum(mean, _HUGE_E)
        if self._response is not None:
            mean *= self._response[rows]
        if self._dark_e > 0:
            mean += min(self._dark_e, _HUGE_E)
        if self._hot is not None:
            begin, end = rows.start * self.shape[1], rows.stop * self.shape[1]
            first, last = np.searchsorted(self._hot, (begin, end))
            mean.reshape(-1)[self._hot[first:last] - begin] += min(self._hot_e, _HUGE_E)
        limited: NDArray[Any] = np.minimum(mean, self._limit_e)
        return limited

    def filled(self, collected: NDArray[Any], rows: slice) -> NDArray[Any]:
        """Add DSNU and clip at the full well."""
        if self._dsnu_e is not None:
            collected = collected + self._dsnu_e[rows]
        if self.spec.effects.full_well:
            collected = saturate(collected, self.spec.full_well_e)
        return collected

    def amplified(self, collected: NDArray[Any], rows: slice) -> NDArray[Any]:
        """Give DN, not yet whole, as they leave the camera."""
        gain: float | NDArray[Any] = self.spec.gain_dn_per_e
        if any(factor != 1 for factor in self.spec.white_balance):
            gain = self._gain.astype(collected.dtype)
            if len(gain) > 1:  # rows of a mosaic differ
                gain = gain[np.arange(rows.start, rows.stop) % 2]
        dn = amplify(collected, gain, self.spec.black_level_dn)
        return dn if self.spec.gamma == 1 else gamma_curve(dn, self.spec.gamma, self.spec.bit_depth)


def _surely_full_e(spec: SensorSpec, camera: FixedPattern) -> float:
    """Give the mean above which the well, or the range if there is none, is full for certain."""
    full_e = float(2**spec.bit_depth / gains(spec).min())
    if spec.effects.full_well:
        full_e = min(full_e, spec.full_well_e)
    margin_e = 20 * math.sqrt(full_e) + 20 * spec.read_noise_e + 200
    return full_e + margin_e - min(camera.lowest_dsnu_e, 0)
