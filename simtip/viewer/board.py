"""A calibration board in space."""

from __future__ import annotations

import rerun as rr

from simtip.detect.excerpt import printable
from simtip.image_sets import BoardPair
from simtip.image_sets.pairs import SIDES
from simtip.viewer.cameras import log_cameras, log_pixels
from simtip.viewer.paths import ABOUT, PLATE, POINTS

INK, PLATE_COLOUR = [0, 114, 178], [200, 200, 200]

POINT_MM = 0.4


def log_board(recording: rr.RecordingStream, pair: BoardPair) -> None:
    """Record a pair's cameras, images, plate and points."""
    log_cameras(recording, pair.rig, pair.images, pair.bit_depth)
    outline = pair.T_wt.apply(pair.outline_mm)
    recording.log(PLATE, rr.LineStrips3D([[*outline, outline[0]]], colors=[PLATE_COLOUR]))
    points = pair.T_wt.apply(pair.points_mm)
    recording.log(POINTS, rr.Points3D(points, colors=[INK], radii=POINT_MM))
    for side, places, visible in zip(SIDES, pair.points_px, pair.visible, strict=True):
        log_pixels(recording, side, "points", places[visible], INK)
    words = f"{printable(pair.source)}\n{pair.label}"
    recording.log(ABOUT, rr.TextDocument(words, media_type="text/plain"))
