"""Light groups to one picture: each lamp at its power, colour and moment, without rendering again.

`weights` says how bright every group is, from the scene alone; `mix` adds the rendered groups up.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from simtip.geometry import Array
from simtip.spec import Lamp, SceneSpec, SensorSpec
from simtip.spectra import channel_weights, sensor_response, spectrum

Floats = NDArray[np.float32]

AMBIENT = "ambient"

_ROWS = 32  # worked on at a time, so that partial sums stay in the cache


def weights(spec: SceneSpec, rows: int) -> dict[str, Array]:
    """Give the radiance of every light group, W m^-2 sr^-1 per channel.

    Parameters
    ----------
    spec
        The scene: lamps, ambient light, and the sensor's exposure, shutter and spectral response.
    rows
        Of the image, for the rolling shutter; the first is the first of the region of interest.

    Returns
    -------
    weights
        By name, the lamps in the scene's order and "ambient" last: (3,), or (rows, 3) for a lamp
        that ripples before a rolling shutter.
    """
    start = row_starts(spec.sensor, rows)
    power = {lamp.name: lamp_weights(lamp, spec.sensor, start) for lamp in spec.lamps}
    power[AMBIENT] = np.array(spec.ambient.radiance_w_m2_sr)
    return power


def steady_weights(spec: SceneSpec) -> Array:
    """Give the radiance (groups, 3) of every light group without any ripple.

    Its mean over time, whatever the exposure: what noise and white balance are judged by.
    """
    calm = [
        lamp.model_copy(update={"ballast": lamp.ballast.model_copy(update={"kind": "electronic"})})
        for lamp in spec.lamps
    ]
    start = np.zeros(1)
    power = [lamp_weights(lamp, spec.sensor, start) for lamp in calm]
    return np.stack([*power, np.array(spec.ambient.radiance_w_m2_sr)])


def row_starts(sensor: SensorSpec, rows: int) -> Array:
    """Give when the rows' exposures begin, s: (rows,), or (1,) for a global shutter."""
    row = np.arange(rows if sensor.row_time_s else 1, dtype=np.float64)
    return sensor.start_s + sensor.row_time_s * row


def lamp_weights(lamp: Lamp, sensor: SensorSpec, start_s: Array) -> Array:
    """Give one lamp's radiance by channel, mean over exposures that begin at `start_s` (n,).

    Returns
    -------
    radiance
        (3,) W m^-2 sr^-1 where n is 1 or the lamp does not ripple, else (n, 3).
    """
    steady = lamp.radiance()
    if lamp.spectrum is not None:
        relative = sensor_response(sensor.spectral_response, sensor.wavelength_nm)
        share = channel_weights(spectrum(lamp.spectrum), relative, sensor.wavelength_nm)
        steady = lamp.total_radiance() * share
    if not lamp.ballast.ripples:
        return steady
    light: Array = lamp.ballast.relative(start_s, sensor.exposure_s)[:, None] * steady
    return light[0] if len(light) == 1 else light


def mix(response: Floats, weights: Sequence[ArrayLike]) -> Floats:
    """Add up light groups: ``sum_g weights_g response_g``, in single precision.

    Parameters
    ----------
    response
        (groups, H, W, 3) float32, radiance per unit radiance of each group.
    weights
        One a group, in the same order: (3,) for the whole image or (H, 3) by row. Groups of no
        light are passed over.

    Returns
    -------
    radiance
        (H, W, 3) float32.

    Raises
    ------
    ValueError
        Shapes that do not fit.
    """
    if response.ndim != 4 or response.shape[3] != 3:
        raise ValueError(f"a response is (groups, H, W, 3), not {response.shape}")
    groups, height, width, _ = response.shape
    power = [np.asarray(weight, dtype=np.float64) for weight in weights]
    shapes = [weight.shape for weight in power]
    if len(power) != groups or any(shape not in ((3,), (height, 3)) for shape in shapes):
        raise ValueError(f"weights of the shapes {shapes} for a response of {response.shape}")
    lit = [
        (group.reshape(height, 3 * width), _Weight(weight, width))
        for group, weight in zip(response, power, strict=True)
        if weight.any()
    ]
    total = np.zeros((height, 3 * width), np.float32)
    product = np.empty((min(_ROWS, height), 3 * width), np.float32)
    for top in range(0, height, _ROWS):
        rows = slice(top, min(top + _ROWS, height))
        part = product[: rows.stop - top]
        for group, weight in lit:
            weight.multiply(group[rows], rows, out=part)
            total[rows] += part
    return total.reshape(height, width, 3)


class _Weight:
    """A group's weights, laid out along the rows of (H, 3 W): long loops are quick ones.

    Weights by row are nearly always one colour times a brightness by row, which is quicker.
    """

    def __init__(self, weight: Array, width: int) -> None:
        self._width = width
        self._by_row: Array | None = None
        self._brightness: Floats | None = None
        colour = weight
        if weight.ndim == 2:
            row, channel = np.unravel_index(weight.argmax(), weight.shape)
            colour = weight[row]
            brightness = weight[:, channel] / colour[channel]
            if np.allclose(brightness[:, None] * colour, weight, rtol=1e-9, atol=0):
                self._brightness = brightness[:, None].astype(np.float32)
            else:
                self._by_row = weight
        self._colour = np.tile(colour.astype(np.float32), width)

    def multiply(self, light: Floats, rows: slice, out: Floats) -> None:
        if self._by_row is not None:
            row = self._by_row[rows].astype(np.float32)
            by_pixel = np.repeat(row[:, None], self._width, axis=1)
            np.multiply(light, by_pixel.reshape(light.shape), out=out)
            return
        np.multiply(light, self._colour, out=out)
        if self._brightness is not None:
            out *= self._brightness[rows]
