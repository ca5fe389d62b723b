"""Crops around the tip of every named scene, and what independent renders of them gave.

A reference holds, per pixel and channel, mean and standard deviation over `RENDERS` renders, each
just like the one that a test makes but for its seed.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from regions import with_roi

from simtip.render import View, render_pair
from simtip.scene_file import load_scene
from simtip.spec import SceneSpec
from simtip.truth import scene_truth

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))
QUICK = ("01",)
"""The others take their time."""
FOLDER = Path(__file__).parent / "reference"
MAKE = "python tests/scenes/make_references.py"

SIZE, ABOVE = 48, 36
"""Side of a crop, and how many of its rows lie above the tip, px."""
SAMPLES = 64
RENDERS = 32
FIRST_SEED = 1000
"""Of the references; tests use others."""

MAX_Z = 12.0
"""For 14,000 values, a few with long tails: lamps that are met by chance. Seen: 9."""
RMS_Z = 2.0
"""The room's light on the board is off by the same everywhere. Seen: 0.6 to 1.4."""
MAX_T = 6.5
"""For 6 means over a crop, and 6 over its needle: Student's t of 31 degrees of freedom, a level of
4e-6 a scene."""
LEAST_SD, LEAST_WHOLE_SD = 3e-4, 1e-4
"""Of the mean radiance, a pixel's and a crop's: the light map's errors are no larger, but have long
tails."""


def quick_or_slow(path: Path):
    """Give the parameter of a test of every scene."""
    return pytest.param(path, marks=() if path.stem.startswith(QUICK) else pytest.mark.slow)


def crop(path: Path) -> SceneSpec:
    """The scene, read out around its tip, sampled evenly."""
    scene = load_scene(path)
    truth = scene_truth(scene)
    corners = [
        np.rint(v.tip_px).astype(int) - [SIZE // 2, ABOVE] for v in (truth.left, truth.right)
    ]
    rois = [[int(u), int(v), SIZE, SIZE] for u, v in corners]
    data = with_roi(scene, *rois, noise=None, samples=SAMPLES).model_dump(mode="json")
    # The same paper and dirt whatever the renderer's seed.
    for part, seed in (("background", "texture_seed"), ("clutter", "seed")):
        if data[part][seed] is None:
            data[part][seed] = scene.seed
    return SceneSpec.model_validate(data)


def mixed(spec: SceneSpec, views: tuple[View, View]) -> np.ndarray:
    """Radiance (2, SIZE, SIZE, 3) of both views."""
    return np.stack([view.radiance(spec) for view in views])


def identity(spec: SceneSpec) -> str:
    """All of a scene that its light depends on, as text."""
    parts = {"rig", "needle", "background", "clutter", "lamps", "ambient", "room", "seed"}
    data = spec.model_dump(mode="json", include=parts)
    del data["rig"]["measured"]
    light = {"exposure_s", "row_time_s", "start_s", "spectral_response", "wavelength_nm"}
    data["sensor"] = spec.sensor.model_dump(mode="json", include=light)
    if not any(lamp.ballast.ripples for lamp in spec.lamps):
        del data["sensor"]["exposure_s"], data["sensor"]["row_time_s"], data["sensor"]["start_s"]
    return json.dumps(data, sort_keys=True)


def coverage(views: tuple[View, View]) -> np.ndarray:
    """Give the needle's share of each pixel, (2, SIZE, SIZE)."""
    return np.stack([view.coverage for view in views])


def _alike(sd: np.ndarray, needle: np.ndarray) -> np.ndarray:
    """Raise standard deviations (H, W, 3) to those of neighbours that the needle covers alike."""
    found = sd.copy()
    for kind in (needle == 0, (needle > 0) & (needle < 1), needle == 1):
        near = cv2.blur(np.dstack([sd**2 * kind[..., None], kind.astype(sd.dtype)]), (3, 3))
        around = np.sqrt(near[..., :3] / np.maximum(near[..., 3:], 1e-6))
        found[kind] = np.maximum(sd, around)[kind]
    return found


@dataclass(frozen=True, eq=False)
class Reference:
    """Mean (2, H, W, 3) and standard deviation of one render; both of a crop's mean, (2, 3)."""

    mean: np.ndarray
    sd: np.ndarray
    whole_mean: np.ndarray
    whole_sd: np.ndarray
    renders: int
    scene: str

    def z(self, light: np.ndarray, needle: np.ndarray) -> np.ndarray:
        """Give how many standard deviations another render is off, (2, H, W, 3).

        A pixel whose neighbours of its kind (by the needle's share) vary more is taken to vary as
        they do: rare events may be missing.
        """
        sd = np.stack([_alike(*pair) for pair in zip(self.sd, needle, strict=True)])
        least = LEAST_SD * self.mean.mean()
        return (light - self.mean) / (np.maximum(sd, least) * np.sqrt(1 + 1 / self.renders))

    def t(self, light: np.ndarray) -> np.ndarray:
        """Give the same of the crops' means, (2, 3)."""
        least = LEAST_WHOLE_SD * self.mean.mean()
        off = light.mean(axis=(1, 2), dtype=float) - self.whole_mean
        return off / (np.maximum(self.whole_sd, least) * np.sqrt(1 + 1 / self.renders))


def made(path: Path) -> Reference:
    """Render a scene's reference."""
    spec = crop(path)
    runs = [
        mixed(spec, render_pair(spec, seed=FIRST_SEED + k)).astype(float) for k in range(RENDERS)
    ]
    whole = np.stack([run.mean(axis=(1, 2)) for run in runs])
    return Reference(
        mean=np.mean(runs, axis=0).astype(np.float32),
        sd=np.std(runs, axis=0, ddof=1).astype(np.float32),
        whole_mean=whole.mean(axis=0),
        whole_sd=whole.std(axis=0, ddof=1),
        renders=RENDERS,
        scene=identity(spec),
    )


def file_of(path: Path) -> Path:
    return FOLDER / f"{path.stem}.npz"


def save(reference: Reference, file: Path) -> None:
    """Store it; standard deviations as half floats of the mean radiance: 1e-3 is enough."""
    scale = float(reference.mean.mean())
    np.savez_compressed(
        file,
        mean=reference.mean,
        sd=(reference.sd / scale).astype(np.float16),
        whole_mean=reference.whole_mean,
        whole_sd=reference.whole_sd,
        renders=reference.renders,
        scene=reference.scene,
    )


def load(file: Path) -> Reference:
    """Read it."""
    with np.load(file, allow_pickle=False) as stored:
        mean = stored["mean"]
        return Reference(
            mean=mean,
            sd=stored["sd"].astype(np.float32) * np.float32(mean.mean()),
            whole_mean=stored["whole_mean"],
            whole_sd=stored["whole_sd"],
            renders=int(stored["renders"]),
            scene=str(stored["scene"]),
        )


def needle_t(z: np.ndarray, needle: np.ndarray) -> np.ndarray:
    """Give how far the needle is off as a whole, (2, 3): its pixels are sampled one by one."""
    return np.array([side[where].sum(axis=0) / np.sqrt(max(where.sum(), 1))
                     for side, where in zip(z, needle == 1, strict=True)])  # fmt: skip


def faults(reference: Reference, light: np.ndarray, needle: np.ndarray) -> list[str]:
    """Say in words what is not as it was.

    Parameters
    ----------
    reference
        What is stored.
    light
        (2, H, W, 3) what was rendered.
    needle
        (2, H, W) its share of each pixel.
    """
    z, t = reference.z(light, needle), reference.t(light)
    whole = needle_t(z, needle)
    found = []
    if not np.isfinite(z).all():
        return ["not finite"]
    worst = np.unravel_index(np.abs(z).argmax(), z.shape)
    rms = float(np.sqrt((z**2).mean()))
    if abs(z[worst]) > MAX_Z:
        side, v, u, channel = worst
        where = f"{('left', 'right')[side]} pixel ({u}, {v}) channel {'rgb'[channel]}"
        found.append(f"{where}: z = {z[worst]:.1f}")
    if rms > RMS_Z:
        found.append(f"root mean square z = {rms:.2f}")
    if np.abs(t).max() > MAX_T:
        found.append(f"mean of the crop: t = {t.flat[np.abs(t).argmax()]:.1f}")
    if np.abs(whole).max() > MAX_T:
        found.append(f"mean of the needle: t = {whole.flat[np.abs(whole).argmax()]:.1f}")
    return found


def leave_pictures(
    reference: Reference, light: np.ndarray, needle: np.ndarray, folder: Path
) -> None:
    """Write what was rendered, what is stored, and z (gray 0, white +10, black -10), enlarged."""
    folder.mkdir(parents=True, exist_ok=True)
    top = max(float(reference.mean.max()), 1e-30)
    for k, side in enumerate(("left", "right")):
        pictures = {
            "rendered": light[k] / top,
            "reference": reference.mean[k] / top,
            "z": 0.5 + reference.z(light, needle)[k] / 20,
        }
        for name, picture in pictures.items():
            codes = np.rint(255 * np.clip(np.nan_to_num(picture), 0, 1)).astype(np.uint8)
            large = cv2.resize(codes[..., ::-1], None, fx=8, fy=8, interpolation=cv2.INTER_NEAREST)
            cv2.imwrite(str(folder / f"{side}_{name}.png"), large)
