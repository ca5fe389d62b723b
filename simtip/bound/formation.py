"""From light per lamp in the band around the needle to what falls on the sensor there."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.bound.reading import reading_information
from simtip.geometry import Array
from simtip.mix import mix, weights
from simtip.optics import expose_lens
from simtip.render import View
from simtip.render.view import Floats
from simtip.sensor import FixedPattern, fixed_pattern, responsivity
from simtip.sensor.dark import dark_electrons, hot_electrons
from simtip.sensor.mosaic import tile
from simtip.spec import SceneSpec

SPARE_PX = 2
"""Around what the point spread reaches: the blur's derivative needs neighbours."""


class Picture:
    """One camera's image around the needle.

    Parameters
    ----------
    spec
        The scene, its exposure settled.
    side
        "left" or "right".
    view
        The rendered view.
    band
        (n,) flat indices of the pixels that the needle may touch; at least one.

    Attributes
    ----------
    window
        Rows and columns of the image that this is about.
    touched
        (h, w) bool, pixels of the window that the needle can change, the point spread included.
    """

    def __init__(self, spec: SceneSpec, side: str, view: View, band: NDArray[np.uint32]) -> None:
        self._spec, self._side = spec, side
        self._camera_spec = spec.rig.left if side == "left" else spec.rig.right
        height, width = view.coverage.shape
        rows, columns = np.divmod(band.astype(np.intp), width)
        reach = _reach_px(self._camera_spec.lens.point_spread(spec.sensor).parts)
        self.window = _framed(rows, height, 2 * reach), _framed(columns, width, 2 * reach)
        self._place = rows - self.window[0].start, columns - self.window[1].start
        shape = tuple(s.stop - s.start for s in self.window)
        mask = np.zeros(shape, np.uint8)
        mask[self._place] = 1
        self.touched = cv2.dilate(mask, np.ones((2 * reach + 1,) * 2, np.uint8)) > 0
        power = weights(spec, height)
        self._power = [power[name] for name in view.lamps]
        crop = view.response[:, self.window[0], self.window[1]]
        by_row = [w if w.ndim == 1 else w[self.window[0]] for w in self._power]
        self._around = mix(np.ascontiguousarray(crop), by_row).astype(np.float64)
        self._band_rows = rows

    def mixed(self, light: Floats, which: NDArray[np.intp] | None = None) -> Array:
        """Mix light as the lamps are.

        Parameters
        ----------
        light
            (n, groups, 3) of the band's pixels, per unit radiance of each group.
        which
            (n,) places in the band, if not all of it.

        Returns
        -------
        radiance
            (n, 3) W m^-2 sr^-1.
        """
        rows = self._band_rows if which is None else self._band_rows[which]
        total = np.zeros((len(light), 3))
        for k, power in enumerate(self._power):
            total += light[:, k] * (power if power.ndim == 1 else power[rows])
        return total

    def irradiance(self, radiance: Array, *, alone: bool = False) -> Array:
        """Give the irradiance of the sensor (h, w, 3), W m^-2.

        Parameters
        ----------
        radiance
            (n, 3) of the band's pixels, W m^-2 sr^-1.
        alone
            Whether nothing lies around the band, or what the view has there.
        """
        image = np.zeros_like(self._around) if alone else self._around.copy()
        image[self._place] = radiance
        camera = self._camera_spec.camera()
        return expose_lens(image, camera, self._camera_spec.lens, self._spec.sensor, self.window)

    def information(self, irradiance: Array) -> Array:
        """Give the information of each reading about its irradiance: (h, w, 3), (W m^-2)^-2.

        With a colour mosaic a pixel has a reading of one channel only.
        """
        sensor = self._spec.sensor
        pattern = fixed_pattern(sensor, self._camera_spec, self._side)
        per_irradiance = responsivity(sensor) * self._response(pattern, irradiance.shape)
        collected = irradiance * per_irradiance + dark_electrons(sensor)
        if pattern.hot is not None:
            collected += hot_electrons(sensor) * self._hot(pattern.hot)
        if pattern.dsnu_e is not None:
            collected += pattern.dsnu_e[self.window]
        told = per_irradiance**2 * reading_information(collected, sensor)
        return told if sensor.mosaic is None else told * self._sampled(pattern)

    def _response(self, pattern: FixedPattern, shape: tuple[int, ...]) -> Array:
        if pattern.response is None:
            return np.ones(shape)
        return pattern.response[self.window].astype(np.float64)

    def _hot(self, hot: NDArray[np.intp]) -> Array:
        camera = self._camera_spec.camera()
        marked = np.zeros((camera.height, camera.width, 3))
        marked.reshape(-1)[hot] = 1
        return marked[self.window]

    def _sampled(self, pattern: FixedPattern) -> Array:
        """Mark the channel (h, w, 3) that each pixel of a mosaic has."""
        channels = tile(pattern.origin)
        rows, columns = (np.arange(s.start, s.stop) % 2 for s in self.window)
        return np.asarray(channels[np.ix_(rows, columns)][..., None] == np.arange(3), np.float64)


def _reach_px(parts: tuple[Array, tuple[Array, ...]]) -> int:
    gaussian, airy = parts
    widest = max(len(kernel) for kernel in airy)
    return SPARE_PX + len(gaussian) // 2 + widest // 2


def _framed(places: NDArray[np.intp], size: int, margin: int) -> slice:
    return slice(max(int(places.min()) - margin, 0), min(int(places.max()) + margin + 1, size))
