"""A scene, a rig and images small enough for a test, and ways to call simtip on them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np

# The paper's set-up, written out here so that no change of scenes/ moves a line number; each
# sensor is read out only around the tip.
SCENE = """\
name: bench
seed: 3
rig:
  left: {width: 2048, height: 1436, fx: 1909.84, fy: 1910.22, cx: 932.97, cy: 657.90,
         roi: [780, 800, 80, 100]}
  right: {width: 2048, height: 1436, fx: 1923.38, fy: 1914.32, cx: 935.88, cy: 729.04,
          roi: [990, 795, 80, 100]}
  R:
    - [0.862, -0.020, -0.507]
    - [0.036, 0.999, 0.022]
    - [0.506, -0.037, 0.861]
  t_mm: [72.047, 2.138, 14.041]
needle:
  tip: {kind: cone, length_mm: 5}
  tip_mm: [-10, 20, 170]
  axis: [0, -1, 0]
background:
  centre_mm: [-20, 0, 260]
lamps:
  - {name: front, kind: tube, centre_mm: [0, -1500, -600]}
  - {name: rear, kind: tube, centre_mm: [0, -1500, -1800]}
ambient:
  radiance_w_m2_sr: [0.003, 0.003, 0.003]
sensor:
  pixel_um: 3.2
  exposure_s: 0.04
render: {samples: 16}
detect:
  name: lin2020
  min_area_px: 200
"""
SIZE = (80, 100)
"""Width and height of its images, px."""

RIG = """\
%YAML:1.0
---
image_width: 80
image_height: 100
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1909.84, 0., 152.97, 0., 1910.22, -142.1, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1923.38, 0., -54.12, 0., 1914.32, -65.96, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.8616920175414768, 0.035998522799932015, 0.506153112468472,
       -0.019936979367032644, 0.9991120183738471, -0.037117268146456564,
       -0.5070398246282214, 0.02189248951490487, 0.8616445526688034 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -69.26618548172685, -0.17853838078229262, 24.385540938383933 ]
"""

MEASURE = ("measure", "--rig", "rig.yaml", "left.png", "right.png", "--set", "min_area_px=100")


def needle_png(size: tuple[int, int] = SIZE) -> bytes:
    """Draw a dark wedge on white, pointing down."""
    width, height = size
    image = np.full((height, width), 200, np.uint8)
    wedge = np.array([[width // 2 - 8, 0], [width // 2 + 8, 0], [width // 2, height - 20]])
    cv2.fillPoly(image, [wedge], 40)
    return cv2.imencode(".png", image)[1].tobytes()


def lay_out(folder: Path) -> Path:
    """Put the files of `MEASURE` and ``scene.yaml`` into a folder."""
    (folder / "scene.yaml").write_text(SCENE)
    (folder / "rig.yaml").write_text(RIG)
    for name in ("left.png", "right.png"):
        (folder / name).write_bytes(needle_png())
    return folder


def snapshot(folder: Path) -> dict[str, bytes | None]:
    """Give every file with its content and every folder, with None."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def in_a_process(
    *arguments: str, cwd: Path, code: str = "from simtip.cli import main; main()", **environment
) -> subprocess.CompletedProcess[str]:
    """Call simtip in a process of its own; `environment` is added, None takes away."""
    variables = {**os.environ, **environment}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=cwd,
        env={name: value for name, value in variables.items() if value is not None},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def one_line(stderr: str) -> str:
    """Give the one line that an error is, without simtip's name; anything more is a fault."""
    assert stderr.endswith("\n"), stderr
    assert stderr.count("\n") == 1, stderr
    assert stderr.startswith("simtip: "), stderr
    return stderr.removeprefix("simtip: ").rstrip("\n")
