"""Draw docs/images/scenes.jpg: the left view of every scene in scenes/, and the tip enlarged.

Run as ``python docs/figures/contact_sheet.py``; takes some minutes.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from zoom import around_the_tip

from simtip.scene_file import load_scene
from simtip.simulation import simulate
from simtip.spec import CameraSpec, SceneSpec

ROOT = Path(__file__).resolve().parents[2]
SHRUNK = 3
"""Of the camera's resolution, for the view; the zoom is at full resolution."""
ZOOM_PX = (100, 140)
ABOVE = 0.75
"""Part of the zoom's height that lies above the tip."""
COLUMNS = 2

Picture = NDArray[np.uint8]


def shrunk(scene: SceneSpec) -> SceneSpec:
    """Give the same cameras with pixels so many times as large."""

    def coarse(camera: CameraSpec) -> CameraSpec:
        size = {key: getattr(camera, key) // SHRUNK for key in ("width", "height")}
        focal = {key: getattr(camera, key) / SHRUNK for key in ("fx", "fy")}
        # A pixel's centre is the origin: its edge, half a pixel before, is what scales.
        centre = {key: (getattr(camera, key) + 0.5) / SHRUNK - 0.5 for key in ("cx", "cy")}
        return camera.model_copy(update={**size, **focal, **centre})

    sensor = scene.sensor.model_copy(update={"row_time_s": scene.sensor.row_time_s * SHRUNK})
    rig = scene.rig.model_copy(
        update={"left": coarse(scene.rig.left), "right": coarse(scene.rig.right)}
    )
    return scene.model_copy(update={"rig": rig, "sensor": sensor})


def left_view(scene: SceneSpec) -> Picture:
    """Give the left image at 8 bit."""
    image = simulate(scene).images[0].astype(np.float32)
    return np.rint(image * (255 / (2**scene.sensor.bit_depth - 1))).astype(np.uint8)


def entry(path: Path) -> Picture:
    """Draw one scene: its name, its left view, the tip."""
    scene = load_scene(path)
    view = left_view(shrunk(scene))
    # The zoom is exposed as the whole is.
    zoom = left_view(around_the_tip(scene, ZOOM_PX, ABOVE))
    height = view.shape[0]
    side = round(height * ZOOM_PX[0] / ZOOM_PX[1])
    tip = np.asarray(cv2.resize(zoom, (side, height), interpolation=cv2.INTER_NEAREST), np.uint8)
    row = np.hstack([view, np.full((height, 6, 3), 255, np.uint8), tip])
    bar = np.full((30, row.shape[1], 3), 255, np.uint8)
    cv2.putText(
        bar, path.stem, (4, 21), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (20, 20, 20), 1, cv2.LINE_AA
    )
    return np.vstack([bar, row])


def main() -> None:
    """Draw all."""
    entries = [entry(path) for path in sorted((ROOT / "scenes").glob("*.yaml"))]
    gap = np.full((entries[0].shape[0], 14, 3), 255, np.uint8)
    while len(entries) % COLUMNS:
        entries.append(np.full_like(entries[0], 255))
    rows = [
        np.hstack([part for one in entries[k : k + COLUMNS] for part in (one, gap)])
        for k in range(0, len(entries), COLUMNS)
    ]
    sheet = cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR)
    out = ROOT / "docs" / "images" / "scenes.jpg"
    cv2.imwrite(str(out), sheet, [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
