"""Draw docs/images/hard.jpg: both views of every scene in scenes/hard, and the left tip enlarged.

Run as ``python docs/figures/hard_images.py``; takes some minutes.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from simtip.scene_file import load_scene
from simtip.simulation import simulate

ROOT = Path(__file__).resolve().parents[2]
HEIGHT = 170
"""Of every picture, px."""
WIDTH = 460
"""Of an entry, px."""
ZOOM_PX = 100
"""Side of the part of the left view that is enlarged."""
COLUMNS = 3
SAMPLES = 64

Picture = NDArray[np.uint8]


def zoomed(image: Picture, tip_px: NDArray[np.float64]) -> Picture:
    """Give the square around a tip; what lies outside the image is white."""
    half = ZOOM_PX // 2
    around = np.pad(image, ((half, half), (half, half), (0, 0)), constant_values=255)
    u, v = np.rint(tip_px).astype(int)
    part = around[v : v + ZOOM_PX, u : u + ZOOM_PX]
    return np.asarray(cv2.resize(part, (HEIGHT, HEIGHT), interpolation=cv2.INTER_NEAREST), np.uint8)


def entry(path: Path) -> Picture:
    """Draw one scene: its name, both views, the left tip."""
    scene = load_scene(path)
    render = scene.render.model_copy(update={"noise": None, "samples": SAMPLES})
    seen = simulate(scene.model_copy(update={"render": render}))
    views = [
        cv2.resize(
            image,
            (round(image.shape[1] * HEIGHT / image.shape[0]), HEIGHT),
            interpolation=cv2.INTER_AREA,
        )
        for image in seen.images
    ]
    gap = np.full((HEIGHT, 4, 3), 255, np.uint8)
    row = np.hstack([views[0], gap, views[1], gap, zoomed(seen.images[0], seen.truth.left.tip_px)])
    # A needle that lies level has wide views: all is made narrower.
    if row.shape[1] > WIDTH:
        scale = WIDTH / row.shape[1]
        row = cv2.resize(row, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    sheet = np.full((HEIGHT + 22, WIDTH, 3), 255, np.uint8)
    sheet[22 : 22 + row.shape[0], : row.shape[1]] = row
    cv2.putText(
        sheet, path.stem, (2, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (20, 20, 20), 1, cv2.LINE_AA
    )
    return sheet


def main() -> None:
    """Draw all."""
    entries = [entry(path) for path in sorted((ROOT / "scenes" / "hard").glob("*.yaml"))]
    while len(entries) % COLUMNS:
        entries.append(np.full_like(entries[0], 255))
    rows = [np.hstack(entries[k : k + COLUMNS]) for k in range(0, len(entries), COLUMNS)]
    sheet = cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR)
    out = ROOT / "docs" / "images" / "hard.jpg"
    cv2.imwrite(str(out), sheet, [cv2.IMWRITE_JPEG_QUALITY, 82])


if __name__ == "__main__":
    main()
