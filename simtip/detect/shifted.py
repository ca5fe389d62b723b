"""Images moved by parts of a pixel, with their noise.

Fourier's shift: each frequency keeps its amplitude and is turned by its phase, so that white noise
keeps its variance, which an interpolation by a few pixels lowers. It is exact for what is band
limited; an edge that no lens has blurred rings beside itself.

The transform takes an image for periodic. Beyond its borders it is continued by its own mirror
images, one fading into the other, so that nothing jumps there; a slanted edge that runs through a
border has a kink on it. With an odd number of samples there is no Nyquist frequency, the only one
that a real image cannot have turned.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

from simtip.detect.protocol import Image
from simtip.geometry import Array

Samples: TypeAlias = NDArray[np.float32]
Spectrum: TypeAlias = NDArray[np.complex64]

LEAST_TAIL_PX = 24
"""Over so many pixels, or more, one border's mirror image fades into that of the opposite one."""


def shifted(image: Image, shifts_px: Iterable[Array]) -> Iterator[Image]:
    """Move an image, once for each shift.

    Parameters
    ----------
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16, of at least one pixel. Not changed.
    shifts_px
        (2,) u, v each, px: what was at (x, y) comes to (x + u, y + v). Meant for less than a pixel:
        what comes in at a border is a mirror image.

    Yields
    ------
    Image
        Of the same shape and type. Rounded, which adds noise of 0.29 DN, and cut to the range of
        the image's own values: what is white stays the white of its sensor, also below 16 bits.
    """
    height, width = image.shape[:2]
    least, most = image.min(), image.max()
    planes = np.moveaxis(np.atleast_3d(image), -1, 0).astype(np.float32)
    lengths = odd_length(height), odd_length(width)
    spectrum = scipy.fft.rfft2(continued(continued(planes, lengths[0], -2), lengths[1], -1))
    for u, v in shifts_px:
        turned = spectrum * _phases(lengths[0], v)[:, None]
        rows = scipy.fft.ifft(turned, axis=-2, overwrite_x=True)[:, :height]
        rows *= _phases(lengths[1], u)[: rows.shape[-1]]
        moved = scipy.fft.irfft(rows, n=lengths[1], axis=-1, overwrite_x=True)[..., :width]
        yield _as_given(np.clip(np.rint(moved), least, most), image)


def continued(samples: Samples, length: int, axis: int) -> Samples:
    """Continue samples along an axis to that length, so that their end meets their beginning.

    Parameters
    ----------
    samples
        Of any shape, with n samples along the axis.
    length
        n or more. What follows the n-th begins as the mirror image of their end and fades into that
        of their beginning, by a raised cosine.
    axis
        Which one.
    """
    count = samples.shape[axis]
    tail = np.arange(length - count)
    fading = (1 - np.cos(np.pi * (tail + 0.5) / max(len(tail), 1))) / 2
    shape = [1] * samples.ndim
    shape[axis] = -1
    weight = fading.astype(np.float32).reshape(shape)
    of_end = np.take(samples, _mirrored(count + tail, count), axis)
    of_begin = np.take(samples, _mirrored(tail - len(tail), count), axis)
    return np.concatenate([samples, of_end + weight * (of_begin - of_end)], axis)


def odd_length(count: int) -> int:
    """Give an odd number, `LEAST_TAIL_PX` or more above the given one, of small prime factors."""
    length = scipy.fft.next_fast_len(count + LEAST_TAIL_PX)
    while length % 2 == 0:
        length = scipy.fft.next_fast_len(length + 1)
    return int(length)


def _mirrored(index: NDArray[np.int_], count: int) -> NDArray[np.int_]:
    """Give which of `count` samples lies at an index beyond them, mirrored as often as it takes."""
    index = index % (2 * count)
    return np.where(index < count, index, 2 * count - 1 - index)


def _phases(length: int, shift_px: float) -> Spectrum:
    """Give by what each frequency is multiplied, (length,), in the order of the transform."""
    turns = scipy.fft.fftfreq(length) * shift_px
    phases: Spectrum = np.exp(-2j * np.pi * turns).astype(np.complex64)
    return phases


def _as_given(planes: NDArray[np.floating], image: Image) -> Image:
    """Give planes (1 or 3, H, W) of whole numbers the image's shape and type."""
    moved = np.empty(image.shape, image.dtype)
    moved[...] = np.moveaxis(planes, 0, -1).reshape(image.shape)
    return moved
