"""The lens's point-spread function on the sensor: diffraction and a Gaussian aberration.

A stage between irradiance and the sensor. `blur` acts on irradiance, (H, W, 3), one wavelength
per channel; `Psf` holds the physical values and makes the discrete kernels.

**What the kernel has to be.** The image g is already integrated over pixels (a box filter), and
convolution commutes, so blur by the PSF h comes last, and h must not be averaged over the pixel a
second time. But g is known at pixel centres only, and diffraction at f/1.4 is far narrower than a
pixel: h sampled at pixel centres would be nonsense, and its OTF cut at the pixel's Nyquist
frequency would have negative weights, which put dark rings around bright points. Here a weight is
h integrated over the pixel at that lag. That alone has the wrong width: too narrow for a small h,
whose light stays in the middle pixel, and too wide by 1/12 px^2, the pixel's own second moment,
for a large one. So it is corrected by the 3-tap second difference that gives exactly the second
moment of h on each axis. Weights below zero, which occur when h is about as wide as a pixel, are
set to zero and the correction is solved again. The kernel is thus never negative, sums to 1, is
centred, and has the second moment of h (within 0.1 % for a diffraction pattern tens of pixels
wide). Where nothing was set to zero, its transfer function is
``(sum_k H(f + k) sinc(f + k)) (1 + d sum_axes (1 - cos 2 pi f))``, with H the OTF of h, k the
aliases, f in cycles per pixel, d the change of the second moment.

**How far the Airy pattern goes.** Its second moment is infinite. It is cut at the radius that holds
`Psf.encircled_energy` (98 % unless told: 10.0 lambda N, 7.7 um at f/1.4 and 0.55 um) and scaled to
1; "second moment" here is that of the cut pattern. What is lost is a wide veil of 2 % of the light,
so the transfer function is too high by its 1/50 except near frequency 0, where it is 1.

**Error against the exact image.** The reference is a sharp straight edge along the columns, blurred
exactly (whole Airy pattern, 16 samples per pixel), at 16 phases below the pixel; f/1.4, 0.55 um,
3.2 um pixels. By area (the sum of the profile) the edge's place is exact at every phase. By where
the profile, linear between pixels, crosses a level, it is off by, in px:

=============  ======================  ======================
aberration     at 50 %: mean, largest  at 25 %: mean, largest
=============  ======================  ======================
0 um           0.000, 0.002           +0.010, 0.023
1 um           0.000, 0.015           +0.024, 0.088
2 um           0.000, 0.021           +0.020, 0.113
5 um           0.000, 0.006           +0.015, 0.042
2 um, halved   0.000, 0.004
=============  ======================  ======================

So half height has no bias, but at one phase it can be 0.02 px off, and at other levels there is a
bias, at 75 % of the opposite sign; a third to a half of it is the veil. The largest errors come
with any kernel at pixel pitch: what lies between the pixels is not in the image. At 2 um, a
band-limited kernel and a cubic spline, both with negative weights, reach 0.019 and 0.017 px at half
height. Who needs better renders pixels of half the size, blurs those with their `pixel_um`, and
averages them in blocks of 2 x 2 ("halved" above).

Sources: Goodman, Introduction to Fourier Optics, 6.3 (OTF of a circular pupil); Born & Wolf,
Principles of Optics, 8.5.2 (Airy pattern, encircled energy 1 - J0^2 - J1^2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from simtip.errors import InputError

Array = NDArray[np.float64]

MAX_RADIUS_PX = 128
"""Kernels beyond this radius are refused: they are a veil over the picture, not a blur."""

GAUSSIAN_RADIUS = 5.0
"""Where the Gaussian is cut, in standard deviations; 6e-7 of it lies outside."""

_FINE_PER_AIRY = 8.0  # integration cells per lambda N: the pattern oscillates once per lambda N


@dataclass(frozen=True)
class Psf:
    """Diffraction of a circular pupil, incoherent, and a Gaussian aberration after it.

    Parameters
    ----------
    f_number
        N, the working f-number (on the image side), focal length over aperture for a far scene.
    wavelength_nm
        Red, green, blue.
    pixel_um
        Pixel pitch, the same on both axes.
    aberration_um
        Standard deviation of the Gaussian on each axis, on the sensor; 0 leaves it out.
    diffraction
        False leaves diffraction out.
    encircled_energy
        Share of the Airy pattern's energy that is kept, and then scaled to 1.

    Raises
    ------
    InputError
        A value that is not possible (a ValueError that names the field), or a kernel larger than
        `MAX_RADIUS_PX`.
    """

    f_number: float
    wavelength_nm: tuple[float, float, float]
    pixel_um: float
    aberration_um: float = 0.0
    diffraction: bool = True
    encircled_energy: float = 0.98

    def __post_init__(self) -> None:
        _require_positive("f_number", self.f_number)
        _require_positive("pixel_um", self.pixel_um)
        if np.shape(self.wavelength_nm) != (3,):
            raise InputError(
                f"not three values: {self.wavelength_nm}",
                field="wavelength_nm",
                remedy="give red, green, blue",
            )
        for k, wavelength in enumerate(self.wavelength_nm):
            _require_positive(f"wavelength_nm[{k}]", wavelength)
        if not (np.isfinite(self.aberration_um) and self.aberration_um >= 0):
            raise InputError(
                f"{self.aberration_um} is not a length",
                field="aberration_um",
                remedy="give um on the sensor, 0 or more",
            )
        if not 0.5 <= self.encircled_energy < 1:
            raise InputError(
                f"{self.encircled_energy} is out of range",
                field="encircled_energy",
                remedy="give 0.5 or more, under 1",
            )
        reach = GAUSSIAN_RADIUS * self.aberration_px
        self._require_small("aberration_um", "sigma", self.aberration_um, reach)
        if self.diffraction:
            reach = max(self.airy_radius_px(k) for k in range(3))
            self._require_small("f_number", "the working f-number N (1 + m)", self.f_number, reach)

    def _require_small(self, field: str, name: str, value: float, radius_px: float) -> None:
        if radius_px > MAX_RADIUS_PX:
            most = value * MAX_RADIUS_PX / radius_px
            unit = 10.0 ** (np.floor(np.log10(most)) - 2)  # rounded down to three digits
            raise InputError(
                f"the blur reaches {radius_px:.0f} px, more than {MAX_RADIUS_PX}",
                field=field,
                remedy=f"{name} can be {np.floor(most / unit) * unit:g} at most with pixels of "
                f"{self.pixel_um:g} um",
            )

    @property
    def is_identity(self) -> bool:
        """Whether there is nothing to blur."""
        return not self.diffraction and self.aberration_um == 0

    @property
    def aberration_px(self) -> float:
        """Standard deviation of the Gaussian, px."""
        return self.aberration_um / self.pixel_um

    def airy_unit_px(self, channel: int) -> float:
        """Give lambda N in px; the first dark ring is at 1.21967 of it."""
        return self.wavelength_nm[channel] * 1e-3 * self.f_number / self.pixel_um

    def airy_radius_px(self, channel: int) -> float:
        """Give the radius where the Airy pattern is cut, px."""
        return self.airy_unit_px(channel) * _radius_holding(self.encircled_energy) / np.pi

    def gaussian_kernel(self) -> Array:
        """Give the aberration's weights along one axis, (2 r + 1,), sum 1."""
        sigma = self.aberration_px
        if sigma == 0:
            return np.ones(1)
        radius = int(np.ceil(GAUSSIAN_RADIUS * sigma))
        borders = np.arange(-radius, radius + 2) - 0.5
        return _with_second_moment(np.diff(scipy.special.ndtr(borders / sigma)), sigma**2)

    def airy_kernel(self, channel: int) -> Array:
        """Give the weights of diffraction alone, (2 r + 1, 2 r + 1), sum 1."""
        if not self.diffraction:
            return np.ones((1, 1))
        unit, radius = self.airy_unit_px(channel), self.airy_radius_px(channel)
        weights = _airy_over_pixels(unit, radius)
        return _with_second_moment(weights, _airy_second_moment(unit, radius))

    def kernel(self, channel: int) -> Array:
        """Give the whole kernel of a channel.

        Returns
        -------
        weights
            (2 r + 1, 2 r + 1), the same along both axes and both ways, none negative, sum 1, the
            middle one at lag 0.
        """
        from scipy.signal import convolve  # takes longer to load than all the rest

        g = self.gaussian_kernel()
        full: Array = convolve(self.airy_kernel(channel), np.outer(g, g), method="direct")
        return full

    @cached_property
    def parts(self) -> tuple[Array, tuple[Array, ...]]:
        """The Gaussian and the diffraction of each channel, made once."""
        return self.gaussian_kernel(), tuple(self.airy_kernel(k) for k in range(3))


def blur(irradiance: ArrayLike, psf: Psf) -> NDArray[Any]:
    """Blur an image by a point-spread function, each channel by its own.

    Beyond its border the image goes on as its mirror image (the border pixel repeated). So a
    constant stays constant, and as the kernel is symmetric, no light is lost or made anywhere.

    Parameters
    ----------
    irradiance
        (H, W, 3), float32 (or float64, slower), at least 0; integrated over pixels, not yet blurred
        by anything else than geometry. Linear: radiance or photons will do as well.
    psf
        What to blur with.

    Returns
    -------
    irradiance
        A new array of the same shape and type, at least 0.

    Raises
    ------
    ValueError
        Another shape or type, or a value that is negative or not finite.
    """
    light = _checked(irradiance)
    if psf.is_identity:
        return light.copy()
    gaussian, airy = psf.parts
    blurred = np.empty_like(light)
    plane, other = (np.empty(light.shape[:2], light.dtype) for _ in range(2))
    border = cv2.BORDER_REFLECT
    for channel in range(3):
        cv2.extractChannel(light, channel, dst=plane)
        if gaussian.size > 1:
            cv2.sepFilter2D(plane, -1, gaussian, gaussian, dst=other, borderType=border)
            plane, other = other, plane
        if airy[channel].size > 1:
            cv2.filter2D(plane, -1, airy[channel], dst=other, borderType=border)
            plane, other = other, plane
        # Large kernels go through a Fourier transform, whose rounding may fall below 0.
        cv2.insertChannel(np.maximum(plane, 0, out=plane), blurred, channel)
    return blurred


def _radius_holding(energy: float) -> float:
    """Give v = pi r / (lambda N) of the circle that holds a share of the Airy pattern's energy."""
    # 1 - E falls as 2 / (pi v): twice that is enough on the far side.
    farthest = 4 / (np.pi * (1 - energy)) + 10
    return float(scipy.optimize.brentq(lambda v: _encircled(v) - energy, 0.0, farthest))


def _encircled(v: float) -> float:
    return float(1 - scipy.special.j0(v) ** 2 - scipy.special.j1(v) ** 2)


def _airy_second_moment(unit_px: float, radius_px: float) -> float:
    """Give the second moment on one axis, px^2, of the pattern within a radius.

    From ``integral of v J1(v)^2 = v^2 (J1^2 - J0 J2) / 2``.
    """
    v = np.pi * radius_px / unit_px
    radial = (
        v**2
        * (scipy.special.j1(v) ** 2 - scipy.special.j0(v) * scipy.special.jv(2, v))
        / _encircled(v)
    )
    return float(radial / 2 * (unit_px / np.pi) ** 2)


def _airy_over_pixels(unit_px: float, radius_px: float) -> Array:
    """Integrate the cut Airy pattern over the pixel at every lag, sum 1."""
    reach = int(np.ceil(radius_px - 0.5)) if radius_px > 0.5 else 0
    cells = max(4, int(np.ceil(_FINE_PER_AIRY / unit_px)))
    if reach == 0:  # all in one pixel, whatever is inside
        return np.ones((1, 1))
    count = 2 * reach + 1
    x = (np.arange(count * cells) + 0.5) / cells - count / 2
    v = np.pi / unit_px * np.hypot(x[:, None], x[None, :])
    pattern = np.where(v <= np.pi / unit_px * radius_px, _airy(v), 0.0)
    weights: Array = pattern.reshape(count, cells, count, cells).sum(axis=(1, 3))
    weights /= weights.sum()
    return weights


def _airy(v: Array) -> Array:
    """Airy intensity, 1 in the middle."""
    safe = np.maximum(v, 1e-6)  # there it is 1 to the last digit
    intensity: Array = (2 * scipy.special.j1(safe) / safe) ** 2
    return intensity


def _with_second_moment(weights: Array, moment_px2: float) -> Array:
    """Give weights another second moment on each axis, by second differences; none negative.

    The result may reach one lag farther.
    """
    wide = np.pad(weights, 1)
    curvature = np.zeros_like(wide)
    for axis in range(wide.ndim):
        curvature += np.roll(wide, 1, axis) + np.roll(wide, -1, axis) - 2 * wide

    def changed(by_px2: float) -> Array:
        moved: Array = np.maximum(wide - by_px2 / 2 * curvature, 0)
        moved /= moved.sum()
        return moved

    def excess(by_px2: float) -> float:
        return _second_moment(changed(by_px2)) - moment_px2

    if excess(0.0) < 0:
        return _trimmed(changed(float(scipy.optimize.brentq(excess, -0.5, 0.0, xtol=1e-15))))
    steps = np.linspace(0, 0.25, 26)  # 1/12 where h is wide; more where weights were set to zero
    left = np.array([excess(step) for step in steps])
    nearest = int(np.argmin(left))
    if left[nearest] > 0:  # what is set to zero at the rim of a large pattern outweighs the middle
        return _trimmed(changed(float(steps[nearest])))
    first = float(steps[np.argmax(left <= 0)])
    return _trimmed(changed(float(scipy.optimize.brentq(excess, 0.0, first, xtol=1e-15))))


def _trimmed(weights: Array) -> Array:
    """Take off outer lags whose weights are all 0."""
    middle = len(weights) // 2
    used = np.abs(np.argwhere(weights > 0) - middle).max()
    keep = slice(middle - int(used), middle + int(used) + 1)
    return weights[(keep,) * weights.ndim]


def _second_moment(weights: Array) -> float:
    """Give the second moment along the first axis, px^2; sum 1 and centred at the middle."""
    lags = np.arange(len(weights)) - len(weights) // 2
    profile = weights.reshape(len(weights), -1).sum(axis=1)
    return float(profile @ lags**2)


def _require_positive(field: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0):
        raise InputError(
            f"{value} is not a positive number", field=field, remedy="give a value above 0"
        )


def _checked(irradiance: ArrayLike) -> NDArray[Any]:
    light: NDArray[Any] = np.asarray(irradiance)
    if light.ndim != 3 or light.shape[2] != 3 or not light.size:
        raise ValueError(f"irradiance has the shape (H, W, 3), not {light.shape}")
    if light.dtype not in (np.float32, np.float64):
        raise ValueError(f"irradiance is float32 or float64, not {light.dtype}")
    # NaN passes through min and max, and compares as false.
    if not (light.min() >= 0 and light.max() < np.inf):
        raise ValueError("irradiance has a value that is negative or not finite")
    return np.ascontiguousarray(light)
