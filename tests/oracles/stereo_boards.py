"""A folder of small stereo photographs of a chessboard, with truth.json, made without simtip.

The rig file inside the truth is written by hand, too: P_left = R P_right + T.
"""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
from oracles.board_photograph import Photographer, chessboard, pose

TARGET = "chessboard:6x5:6"
COLUMNS, ROWS, SQUARE = 6, 5, 6.0
SIZE = (320, 240)
R = cv2.Rodrigues(np.array([0.01, -0.35, -0.02]))[0]
T = np.array([34.0, 1.0, 6.0])
BASELINE = float(np.linalg.norm(T))

LEFT = Photographer(
    np.array([[420.0, 0, 158], [0, 421, 121], [0, 0, 1]]),
    SIZE,
    np.array([-0.1, 0.05, 0.0005, -0.0005, 0]),
    blur_px=0.7,
    noise_dn=1.0,
)
RIGHT = Photographer(
    np.array([[424.0, 0, 161], [0, 423, 118], [0, 0, 1]]),
    SIZE,
    np.array([-0.08, 0.03, -0.0004, 0.0004, 0]),
    blur_px=0.7,
    noise_dn=1.0,
)

TILTS = ((32, 0), (32, 60), (30, 120), (32, 180), (30, 240), (32, 300), (8, 30), (15, 200))
"""Degrees: how far each board is tilted, and about which axis."""


def points() -> np.ndarray:
    y, x = np.mgrid[:ROWS, :COLUMNS] * SQUARE
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]).astype(float)


def poses(tilts=TILTS) -> list[tuple[np.ndarray, np.ndarray]]:
    """Boards about 100 mm away, half turned to the right camera."""
    middle = np.array([15.0, 12.0])
    half = cv2.Rodrigues(np.array([0, -0.17, 0.0]))[0]
    found = []
    for k, (tilt, about) in enumerate(tilts):
        at = np.array([3.0 + 3 * np.cos(2.4 * k), 2 * np.sin(2.4 * k), 98.0 + 2 * (k % 3)])
        rvec, _ = pose(tilt, about, 7 * (k % 3) - 7, middle, at)
        turned = half @ cv2.Rodrigues(rvec)[0]
        found.append((cv2.Rodrigues(turned)[0].ravel(), at - turned @ np.array([*middle, 0.0])))
    return found


def to_right(rvec: np.ndarray, tvec: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return cv2.Rodrigues(R.T @ cv2.Rodrigues(rvec)[0])[0].ravel(), R.T @ (tvec - T)


def photograph(folder: Path, tilts=TILTS, target: str = TARGET) -> dict:
    """Write left_01.png, right_01.png, ... and truth.json; give the truth."""
    ink = chessboard(COLUMNS, ROWS, SQUARE)
    box = np.array([[-SQUARE, -SQUARE], [COLUMNS * SQUARE, ROWS * SQUARE]])
    views = []
    for k, board in enumerate(poses(tilts)):
        view: dict = {"name": f"{k + 1:02d}", "R": cv2.Rodrigues(board[0])[0].tolist()}
        view["t_mm"] = board[1].tolist()
        for side, camera, at in (("left", LEFT, board), ("right", RIGHT, to_right(*board))):
            file = f"{side}_{k + 1:02d}.png"
            image = camera.shoot(ink, box, *at, seed=2 * k + (side == "left"))
            assert cv2.imwrite(str(folder / file), image)
            seen = camera.pixels(points(), *at)
            assert (seen > 8).all()
            assert (seen < np.array(SIZE) - 9).all()
            view[side] = {"file": file, "points_px": seen.tolist(), "visible": [True] * len(seen)}
        views.append(view)
    truth = {
        "target": target,
        "plate": {"bow_mm": 0.0, "print_scale": [1.0, 1.0], "points_mm": points().tolist()},
        "working_volume_mm": {"low": [-5, -5, 92], "high": [11, 5, 104]},
        "image_size": {"left": list(SIZE), "right": list(SIZE)},
        "views": views,
        "rig": rig_json(),
    }
    (folder / "truth.json").write_text(json.dumps(truth))
    return truth


def rig_json() -> dict:
    rig: dict = {"format": "simtip-rig", "version": 1, "R": R.tolist(), "T_mm": T.tolist()}
    for side, camera in (("left", LEFT), ("right", RIGHT)):
        rig |= {
            f"size_{side}": list(SIZE),
            f"K_{side}": camera.K.tolist(),
            f"D_{side}": camera.distortion.tolist(),
        }
    return rig
