"""Pictures of needles by casting rays at the solid in closed form: shares no code with `refine`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from simtip.camera import Camera, StereoRig
from simtip.geometry import Pose

LEVEL = 180.0
FACET = 0.55
SUB_U, SUB_V = 8, 5
FAR = 1e9


@dataclass(frozen=True)
class RoundNeedle:
    """A cylinder of radius R about z, ended by a cone of a length or by a plane at an angle."""

    radius: float
    cone: float | None = None
    bevel_deg: float | None = None

    @property
    def apex(self):
        return np.array([0.0 if self.cone else self.radius, 0.0, 0.0])

    @property
    def name(self) -> str:
        tip = f"cone:{2 * self.radius}:{self.cone}"
        return tip if self.cone else f"bevel:{2 * self.radius}:{self.bevel_deg}"

    def hits(self, o, d):
        """Where rays o + t d (n, 3) enter: hit or not, outward normals, and whether on the cut."""
        enter, leave = np.full(len(d), -FAR), np.full(len(d), FAR)
        normal, flat = np.zeros_like(d), np.zeros(len(d), bool)
        # x^2 + y^2 = R^2
        e, x = _quadric(o, d, self.radius**2, 0.0)
        leave = np.minimum(leave, x)
        normal[:] = (o + e[:, None] * d) * [1, 1, 0]
        enter = e
        if self.cone:
            # x^2 + y^2 = (k z)^2, z > 0
            k = self.radius / self.cone
            e, x = _quadric(o, d, 0.0, k**2)
            z = o[2] + np.stack([e, x]) * d[:, 2]
            e = np.where(z[0] > 0, e, FAR)
            x = np.where(z[1] > 0, x, FAR)
            e, x = np.minimum(e, x), np.maximum(e, x)
            # One root alone ahead of the apex: the ray stays within from there on, or until there.
            lone = (z > 0).sum(axis=0) == 1
            up = d[:, 2] > 0
            x = np.where(lone & ~up, e, x)
            e = np.where(lone & ~up, -FAR, e)
            later = e > enter
            p = o + e[:, None] * d
            slanted = p * [1, 1, -(k**2)]
            normal[later] = slanted[later]
            enter, leave = np.maximum(enter, e), np.minimum(leave, x)
        if self.bevel_deg:
            n = np.array([-1 / np.tan(np.radians(self.bevel_deg)), 0.0, -1.0])
            n /= np.linalg.norm(n)
            side = d @ n
            t = (n @ (self.apex - o)) / side
            later = (side < 0) & (t > enter)
            normal[later], flat[later] = n, True
            enter = np.where(side < 0, np.maximum(enter, t), enter)
            leave = np.where(side > 0, np.minimum(leave, t), leave)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return (enter < leave) & (enter > 0), normal / np.maximum(length, 1e-30), flat


def _quadric(o, d, r2, k2):
    """Where rays cross x^2 + y^2 = r2 + k2 z^2: both t, FAR where they do not."""
    m = np.array([1.0, 1.0, -k2])
    a, b, c = (d * d) @ m, (d * o) @ m, (o * o) @ m - r2
    root = b * b - a * c
    ok = root > 0
    s = np.sqrt(np.where(ok, root, 0))
    t = np.stack([(-b - s) / a, (-b + s) / a])
    t = np.sort(t, axis=0)
    return np.where(ok, t[0], FAR), np.where(ok, t[1], -FAR)


def picture(needle, T_wn, camera, T_wc, seed):
    """A noise-free picture (H, W), DN: each pixel the mean of jittered rays."""
    rng = np.random.default_rng(seed)
    h, w = camera.height, camera.width
    T_nc = T_wn.inverse() @ T_wc
    v, u = np.mgrid[:h, :w].astype(float)
    total = np.zeros((h, w))
    for j in range(SUB_V):
        for i in range(SUB_U):
            du = (i + rng.random((h, w))) / SUB_U - 0.5
            dv = (j + rng.random((h, w))) / SUB_V - 0.5
            rays = camera.rays(np.stack([u + du, v + dv], axis=-1).reshape(-1, 2))
            total += _brightness(needle, T_nc.t, T_nc.rotate(rays)).reshape(h, w)
    return total / (SUB_U * SUB_V) * (1 + 0.02 * (v / h - 0.5))


def _brightness(needle, o, d):
    hit, n, flat = needle.hits(o, d)
    toward = -(n * d).sum(axis=1)
    # Alike at both edges, darker within, and not the same on both sides.
    side = n @ np.array([0.6, 0.8, 0.0])
    value = 0.46 - 0.35 * toward + 0.3 * toward**2 + 0.1 * toward * side
    return LEVEL * np.where(hit, np.where(flat, FACET, value), 1.0)


@dataclass(frozen=True)
class Pair:
    """Both pictures, noise-free, and what is true of them."""

    needle: RoundNeedle
    T_wn: Pose
    rig: StereoRig
    left: np.ndarray
    right: np.ndarray

    @property
    def tip_mm(self):
        return self.T_wn.apply(self.needle.apex)

    def noisy(self, seed, gain=0.0255, read_e=5.0):
        rng = np.random.default_rng(seed)
        noisy = (
            m + np.sqrt(gain * m + (gain * read_e) ** 2) * rng.standard_normal(m.shape)
            for m in (self.left, self.right)
        )
        return tuple(np.clip(np.rint(m), 0, 255).astype(np.uint8) for m in noisy)


def pose(needle, tip_mm, axis, roll_deg=0.0):
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    x0 = np.array([1.0, 0, 0]) - z[0] * z
    x0 /= np.linalg.norm(x0)
    y0 = np.cross(z, x0)
    c, s = np.cos(np.radians(roll_deg)), np.sin(np.radians(roll_deg))
    x = c * x0 + s * y0
    R = np.stack([x, np.cross(z, x), z], axis=1)
    return Pose(R, np.asarray(tip_mm, float) - R @ needle.apex)


def pair(rig, needle, tip_mm, axis=(0.02, -1, 0.05), roll_deg=0.0, room=(70, 330, 40)):
    """Draw a needle in the rig's cameras, cut out around the tip."""
    T_wn = pose(needle, tip_mm, axis, roll_deg)
    side, above, below = room
    cameras = []
    for camera, uv in zip((rig.left, rig.right), rig.project(np.asarray(tip_mm)), strict=True):
        x, y = (int(np.floor(c)) for c in uv - [side, above])
        cameras.append(camera.cropped(x, y, 2 * side, above + below))
    cut = replace(rig, left=cameras[0], right=cameras[1])
    left = picture(needle, T_wn, cut.left, Pose.identity(), 1)
    right = picture(needle, T_wn, cut.right, cut.T_lr, 2)
    return Pair(needle, T_wn, cut, left, right)


__all__ = ["Camera", "Pair", "RoundNeedle", "pair", "pose"]
