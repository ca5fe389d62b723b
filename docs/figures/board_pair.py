"""Draw docs/images/board_pair.jpg: a pair of the tutorial's boards, true corners on it.

Run as ``python docs/figures/board_pair.py boards``, with the folder that the tutorial makes.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import cv2
import numpy as np

OUT = Path(__file__).resolve().parents[1] / "images" / "board_pair.jpg"
BLUE = (200, 110, 20)
GAP_PX = 8


def main(folder: Path) -> None:
    """Mark the true corners of the first view in both images, and put them side by side."""
    view = json.loads((folder / "truth.json").read_text(encoding="utf-8"))["views"][0]
    pictures = []
    for side in ("left", "right"):
        picture = cv2.imread(str(folder / view[side]["file"]))
        for u, v in view[side]["points_px"]:
            place = (round(u * 16), round(v * 16))
            cv2.circle(picture, place, 5 * 16, BLUE, 1, cv2.LINE_AA, shift=4)
        pictures.append(picture)
    gap = np.full((pictures[0].shape[0], GAP_PX, 3), 255, np.uint8)
    pair = np.hstack([pictures[0], gap, pictures[1]])
    cv2.imwrite(str(OUT), pair, [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
