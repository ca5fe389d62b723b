"""A needle in space: true, measured, and the rays between."""

from __future__ import annotations

import numpy as np
import rerun as rr

from simtip.detect.excerpt import printable
from simtip.geometry import Array
from simtip.image_sets import NeedlePair, Reading
from simtip.image_sets.pairs import SIDES
from simtip.measuring_rig import measuring_rig
from simtip.needle import Needle
from simtip.render.board import Board
from simtip.spec import SceneSpec
from simtip.viewer.cameras import log_cameras, log_pixels
from simtip.viewer.paths import (
    ABOUT,
    AXIS,
    BACKGROUND,
    ERROR,
    GAP,
    LAMPS,
    NEEDLE,
    RAYS,
    TIP_MEASURED,
    TIP_TRUE,
)
from simtip.viewer.rays import RayPair, ray_pair

TRUE, MEASURED = [0, 114, 178], [230, 159, 0]
"""Blue and orange, as in the overlays of images."""
RAY, GAP_COLOUR = [204, 121, 167], [213, 94, 0]
METAL, PAPER, LIGHT = [150, 150, 155], [200, 200, 200], [255, 240, 170]

MESH_SEGMENTS = 96
"""Sides of the needle's circle: enough to look at."""

AXIS_POINTS = 65
THIN = -0.75
"""Half the width of lines: below 0, in points of the screen."""

TIP_MM = 0.15
"""Radius of the points that mark tips."""


def log_needle(recording: rr.RecordingStream, pair: NeedlePair) -> None:
    """Record what is true of a pair, and its images."""
    truth, needle = pair.truth, pair.truth.needle
    log_cameras(recording, truth.rig, pair.images, pair.spec.sensor.bit_depth)
    vertices, faces = needle.surface(MESH_SEGMENTS, sagitta_mm=0.01)
    mesh = rr.Mesh3D(
        vertex_positions=truth.T_wn.apply(vertices), triangle_indices=faces, albedo_factor=METAL
    )
    recording.log(NEEDLE, mesh)
    axis = truth.T_wn.apply(axis_points(needle))
    recording.log(AXIS, rr.LineStrips3D([axis], colors=[TRUE], radii=THIN))
    recording.log(TIP_TRUE, rr.Points3D([truth.tip_mm], colors=[TRUE], radii=TIP_MM))
    for side, view in zip(SIDES, (truth.left, truth.right), strict=True):
        log_pixels(recording, side, "tip_true", view.tip_px, TRUE)
    _log_surroundings(recording, pair.spec)


def log_reading(recording: rr.RecordingStream, pair: NeedlePair, reading: Reading | None) -> None:
    """Record what was measured, and take away what an earlier reading left."""
    tips = (None, None) if reading is None else reading.tips_px
    for side, place in zip(SIDES, tips, strict=True):
        found = np.zeros((0, 2)) if place is None else place
        log_pixels(recording, side, "tip_detected", found, MEASURED)
    place_mm = None if reading is None else reading.tip_mm
    shown = np.zeros((0, 3)) if place_mm is None else place_mm[None]
    recording.log(TIP_MEASURED, rr.Points3D(shown, colors=[MEASURED], radii=TIP_MM))
    if place_mm is not None:
        error = float(np.linalg.norm(place_mm - pair.truth.tip_mm))
        recording.log(ERROR, rr.Scalars(error))
    rays = None if reading is None else rays_of(reading)
    lines = [] if rays is None else list(rays.lines_mm)
    recording.log(RAYS, rr.LineStrips3D(lines, colors=[RAY], radii=THIN))
    gap = [] if rays is None else [rays.nearest_mm]
    recording.log(GAP, rr.LineStrips3D(gap, colors=[GAP_COLOUR]))
    # As plain text: names and values are anybody's.
    recording.log(ABOUT, rr.TextDocument(_words(pair, reading), media_type="text/plain"))


def rays_of(reading: Reading) -> RayPair | None:
    """Give the rays of the rig that measured; None where a tip was not detected."""
    left, right = reading.tips_px
    if left is None or right is None:
        return None
    return ray_pair(measuring_rig(reading.spec), left, right)


def axis_points(needle: Needle) -> Array:
    """Give points (n, 3) along the axis from its foremost point to the hub, needle frame, mm."""
    z = np.linspace(0, needle.length_mm, AXIS_POINTS)
    points = np.stack([np.zeros_like(z), np.zeros_like(z), z], axis=1)
    return points if needle.bend is None else needle.bend.apply(points)


def _log_surroundings(recording: rr.RecordingStream, spec: SceneSpec) -> None:
    board = Board.of(spec.background)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * board.half
    recording.log(BACKGROUND, rr.LineStrips3D([board.points(corners)], colors=[PAPER], radii=THIN))
    outlines = [lamp.outline_mm() for lamp in spec.lamps]
    lamps = rr.Points3D(
        np.concatenate([np.zeros((0, 3)), *outlines]),
        labels=[lamp.name for lamp, o in zip(spec.lamps, outlines, strict=True) for _ in o],
        colors=[LIGHT],
        radii=10.0,
    )
    recording.log(LAMPS, lamps)


def _words(pair: NeedlePair, reading: Reading | None) -> str:
    lines = [pair.source]
    if reading is not None:
        told = {"detector": reading.detector, "status": reading.status, "reason": reading.reason}
        lines += [f"{name}: {value}" for name, value in {**told, **reading.settings}.items()]
        rays = rays_of(reading)
        lines += [] if rays is None else [f"gap between the rays: {rays.gap_mm:.4g} mm"]
    return "\n".join(map(printable, lines))
