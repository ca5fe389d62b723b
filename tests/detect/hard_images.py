"""Images of every kind that may go wrong, and parameters, all decided by one number each."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from simtip.detect.lin2020_parameters import Lin2020Parameters

CROPS = sorted((Path(__file__).parents[1] / "scenes" / "reference").glob("*.npz"))


def needle(rng, shape):
    """A bar with a point, slanted, at any place, its end inside or beyond any border."""
    height, width = shape
    image = np.full(shape, rng.integers(110, 256), np.uint8)
    end = rng.uniform(-0.05, 1.05, 2) * (width, height)
    angle, half = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, max(width / 8, 1))
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    far, taper = 2 * max(shape) * along, rng.uniform(0, 6) * half * along
    outline = [end, end + taper + half * across, end + far + half * across]
    outline += [end + far - half * across, end + taper - half * across]
    points = np.round(np.array(outline) * 64).astype(np.int32)
    cv2.fillPoly(image, [points], int(rng.integers(0, 100)), cv2.LINE_AA, 6)
    return cv2.GaussianBlur(image, (0, 0), s) if (s := rng.uniform(0, 3)) > 1 else image


def cluttered(rng, shape):
    image = needle(rng, shape)
    for _ in range(rng.integers(1, 40)):
        u, v, radius = rng.integers(0, shape[1]), rng.integers(0, shape[0]), rng.integers(0, 9)
        cv2.circle(image, (int(u), int(v)), int(radius), int(rng.integers(0, 256)), -1)
    return image


def salted(rng, shape):
    image = needle(rng, shape)
    image[rng.random(shape) < rng.uniform(0, 0.3)] = 0
    image[rng.random(shape) < rng.uniform(0, 0.3)] = 255
    return image


def noisy(rng, shape):
    image = needle(rng, shape) + rng.normal(0, rng.uniform(1, 40), shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def noise(rng, shape):
    return rng.integers(0, 256, shape, dtype=np.uint8)


def bars(rng, shape):
    image = np.full(shape, 200, np.uint8)
    for _ in range(rng.integers(1, 12)):
        v, u = (sorted(rng.integers(0, n + 1, 2)) for n in shape)
        image[v[0] : v[1], u[0] : u[1]] = rng.integers(0, 256)
    return image


def gradient(rng, shape):
    v, u = np.mgrid[: shape[0], : shape[1]]
    slope = rng.uniform(-1, 1, 2)
    ramp = slope[0] * u / shape[1] + slope[1] * v / shape[0]
    return (np.clip(ramp - ramp.min() + rng.random(), 0, 1) * needle(rng, shape)).astype(np.uint8)


def checkerboard(rng, shape):
    v, u = np.mgrid[: shape[0], : shape[1]]
    side = rng.integers(1, 12)
    return np.where((v // side + u // side) % 2, np.uint8(230), np.uint8(rng.integers(0, 230)))


def blobs(rng, shape):
    smooth = cv2.GaussianBlur(rng.random(shape), (0, 0), rng.uniform(1, 12))
    smooth -= smooth.min()
    return (255 * smooth / max(smooth.max(), 1e-9)).astype(np.uint8)


def thin(rng, shape):
    image = np.full(shape, 220, np.uint8)
    for _ in range(rng.integers(1, 4)):
        ends = [(int(rng.integers(-3, shape[1] + 3)), int(rng.integers(-3, shape[0] + 3)))
                for _ in range(2)]  # fmt: skip
        cv2.line(image, *ends, int(rng.integers(0, 100)), int(rng.integers(1, 4)))
    return image


def at_the_threshold(rng, shape):
    return (rng.integers(100, 110, shape) + 30 * (needle(rng, shape) > 90)).astype(np.uint8)


def level(rng, shape):
    return np.full(shape, rng.choice([0, 104, 105, 255]), np.uint8)


def rendered(rng, _shape):
    """A crop of a scene's stored radiance, both cameras, with noise: its own size and colours."""
    with np.load(CROPS[rng.integers(len(CROPS))], allow_pickle=False) as stored:
        light = stored["mean"][rng.integers(2)]
    codes = light / np.percentile(light, 95) * rng.uniform(120, 250) + rng.normal(0, 2, light.shape)
    codes = np.clip(codes, 0, 255).astype(np.uint8)
    return np.kron(codes, np.ones((*rng.integers(1, 4, 2), 1), np.uint8))


KINDS = (
    *(needle, cluttered, salted, noisy, noise, bars, gradient, checkerboard, blobs, thin),
    *(at_the_threshold, level, rendered),
)


def shape_of(rng):
    """Mostly pictures, sometimes slivers, down to one pixel."""
    most = rng.choice([7, 40, 160, 400], p=[0.08, 0.22, 0.45, 0.25])
    return tuple(int(n) for n in rng.integers(1, most + 1, 2))


PROBABLE = (0.03, 0.1, 0.15, 0.25, 0.15, 0.15, 0.15, 0.02)


def parameters(rng):
    low, high = np.sort(rng.choice([0, 40, 80, 300, 600, 1100], 2))
    weights = [(0.299, 0.587, 0.114), (1.0, 0.0, 0.0), (0.2, 0.3, 0.5)]
    if rng.random() < 0.4:  # the paper's
        low, high, weights = 40, 80, weights[:1]
    return {
        "weights": weights[rng.integers(len(weights))],
        "median_window": int(rng.choice([1, 3, 5, 5, 5, 7, 11, 31])),
        "threshold": int(rng.choice([1, 60, 104, 105, 106, 130, 180, 255], p=PROBABLE)),
        "min_area_px": int(rng.choice([0, 1, 8, 30, 50, 400, 4500])),
        "connectivity": int(rng.choice([4, 8])),
        "polarity": str(rng.choice(["dark", "dark", "bright", "both"])),
        "keep": str(rng.choice(["all", "largest"])),
        "canny_low": float(low),
        "canny_high": float(high),
        "canny_aperture": int(rng.choice([3, 3, 5, 7])),
        "canny_l2": bool(rng.integers(2)),
        "ties": str(rng.choice(["mean", "left", "right"])),
        "border_margin_px": int(rng.choice([0, 0, 1, 3])),
    }


def case(number: int):
    """Give the kind's name, an image, and the parameters to use on it."""
    rng = np.random.default_rng([2020, number])
    kind = KINDS[number % len(KINDS)]
    image, values = kind(rng, shape_of(rng)), parameters(rng)
    if image.ndim == 2 and rng.random() < 0.5:
        tint = rng.integers(-20, 21, 3) if rng.random() < 0.7 else np.zeros(3, int)
        image = np.clip(image[..., None] + tint, 0, 255).astype(np.uint8)
    if rng.random() < 0.35:
        white = int(rng.choice([100, 255, 1023, 4095, 65535]))
        image = (image * (white / 255) + rng.random(image.shape) * 0.99).astype(np.uint16)
        image = np.minimum(image, white).astype(np.uint16)
        values["full_scale"] = None if white == 65535 else white
    if rng.random() < 0.2:
        image = np.repeat(image, 2, axis=1)[:, ::-2]
    return kind.__name__, image, Lin2020Parameters(**values)
