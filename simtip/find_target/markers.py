"""Finding a ChArUco board, of which a part is enough: its markers say which part."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from simtip.find_target.gray import Gray, original_pixels, resized, to_8_bit
from simtip.find_target.local_map import local_maps
from simtip.find_target.marker_failure import squares, why_not
from simtip.find_target.outcome import NotFound
from simtip.find_target.refine import LEAST_LIKENESS, refine, spread_out
from simtip.find_target.register import register
from simtip.geometry import Array
from simtip.target import Charuco, Sighting
from simtip.target.charuco import marker_dictionary

WORKING_PX = 2200
"""Longer side to which larger images are shrunk for the search of markers."""

LEAST = 4
"""Corners without which a view is no use to a calibration."""

ASTRAY = 0.3
"""How far a marker's corner may be from where the others put it, in squares."""

AGREEING = 0.6
"""Part of the markers found that have to be where they are on the board."""

MISPLACED = 0.1
"""Most markers, as part of those found, that may be elsewhere than on the board."""

OTHER_SIZE = 0.07
"""Least error of a marker's size, as part of it, that is told."""

EXPLAINING_PX = 1100
"""Longer side of the image that is searched for an explanation."""

OFF_PX = 1.5
"""How much smaller or larger a marker's outline may be found."""

CROWD = 2500
"""Most squares in an image in which markers are sought: the time grows as their square."""


def find_charuco(target: Charuco, gray: Gray) -> Sighting | NotFound:
    """Find the corners of a ChArUco board in (H, W) gray values."""
    small = resized(gray, min(1.0, WORKING_PX / max(gray.shape)))
    image = to_8_bit(small)
    crowd = squares(image)
    if crowd > CROWD:
        return NotFound(f"there are too many squares ({crowd}) in the image to look for markers")
    places, pixels = _marker_corners(target, image)
    pixels = original_pixels(pixels, small, gray)
    agreeing = _agreeing(places, pixels)
    start = _first_corners(target, gray, places[agreeing], pixels[agreeing])
    off = 1.0 if not _enough(target, start) else _misplaced(target, start, places, pixels)
    if off > MISPLACED:
        few = resized(gray, min(1.0, EXPLAINING_PX / max(gray.shape)))
        return NotFound(why_not(target, to_8_bit(few), int(np.count_nonzero(agreeing)) // 4))
    size, unsure = _marker_size(target, start, pixels[agreeing])
    if abs(size / target.marker_mm - 1) > OTHER_SIZE + unsure:
        return NotFound(
            f"the markers are about {size:.3g} mm wide on squares of {target.square_mm:g} mm,"
            f" not {target.marker_mm:g}"
        )
    grown = spread_out(target, gray, start)
    sighting = refine(target, gray, grown.ids, grown.pixels, passes=1)
    if sighting is None or not _enough(target, sighting):
        return NotFound(f"markers of {target} are there, but no corners that look like its print")
    return sighting


def _marker_size(target: Charuco, sighting: Sighting, corners: Array) -> tuple[float, float]:
    """Measure markers by their corners (4 k, 2) against the board's corners around them.

    Returns
    -------
    size, unsure
        mm, and how far it may be off, as part of it: OpenCV puts corners on whole pixels.
    """
    at, step_px = _on_lattice(target, sighting, corners)
    diagonals = np.linalg.norm(at.reshape(-1, 4, 2)[:, :2] - at.reshape(-1, 4, 2)[:, 2:], axis=2)
    side = float(np.median(diagonals) / np.sqrt(2))
    return side * target.square_mm, OFF_PX / (side * step_px)


def _misplaced(target: Charuco, sighting: Sighting, places: Array, corners: Array) -> float:
    """Give the part of the markers, (4 k, 2) places and pixels, that the board has elsewhere."""
    at, _ = _on_lattice(target, sighting, corners)
    off = np.linalg.norm(at - places, axis=1).reshape(-1, 4).max(axis=1)
    return float((~(off < ASTRAY)).mean())


def _on_lattice(target: Charuco, sighting: Sighting, pixels: Array) -> tuple[Array, float]:
    """Map pixels (n, 2) to the lattice by the nearest corner's map; also its step in px."""
    maps = local_maps(target.lattice[sighting.ids], sighting.pixels)
    if maps is None:
        return np.full_like(pixels, np.nan), np.nan
    near = np.asarray(cKDTree(sighting.pixels).query(pixels)[1])
    at = np.array([maps[int(k)].lattice(p[None])[0] for k, p in zip(near, pixels, strict=True)])
    return at, float(np.median([here.step_px for here in maps]))


def _enough(target: Charuco, sighting: Sighting) -> bool:
    """Tell whether there are enough corners, not all on a line."""
    if len(sighting) < LEAST:
        return False
    places = target.lattice[sighting.ids]
    return bool(np.linalg.matrix_rank(places - places.mean(axis=0)) == 2)


def _marker_corners(target: Charuco, image: NDArray[np.uint8]) -> tuple[Array, Array]:
    """Give corners (4 k, 2) of markers on the board's lattice, and their pixels, four a marker."""
    detector = cv2.aruco.ArucoDetector(marker_dictionary(target.dictionary))
    found, ids, _ = detector.detectMarkers(image)
    known = [] if ids is None else [k for k, n in enumerate(ids.ravel()) if n < target.markers]
    if not known or ids is None:
        return np.zeros((0, 2)), np.zeros((0, 2))
    places = np.concatenate([_corners_of(target, int(ids.ravel()[k])) for k in known])
    pixels = np.concatenate([found[k].reshape(4, 2) for k in known]).astype(np.float64)
    return places, pixels


def _agreeing(places: Array, pixels: Array) -> NDArray[np.bool_]:
    """Say which corners, four a marker, belong to markers that a homography brings together."""
    none = np.zeros(len(places), np.bool_)
    if not len(places):
        return none
    _, inside = cv2.findHomography(pixels, places, cv2.RANSAC, ASTRAY)
    # No mask comes back where no homography is found; OpenCV's types do not say so.
    if not np.size(inside):
        return none
    fits = np.asarray(inside) > 0
    if np.count_nonzero(fits) < AGREEING * len(fits):
        return none
    return np.asarray(np.repeat(fits.reshape(-1, 4).all(axis=1), 4))


def _corners_of(target: Charuco, marker: int) -> Array:
    """Give a marker's corners (4, 2) on the lattice, clockwise from the upper left."""
    columns = target.columns
    j = (2 * marker) // columns
    row, column = j, 2 * marker - j * columns
    if (row + column) % 2 == 0:
        column += 1
    if column >= columns:
        row, column = row + 1, 0
    half = target.marker_mm / target.square_mm / 2
    turn = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    corners: Array = np.array([column - 0.5, row - 0.5]) + turn
    return corners


def _first_corners(target: Charuco, gray: Gray, places: Array, pixels: Array) -> Sighting:
    """Find the board's corners next to markers."""
    maps = local_maps(places, pixels)
    ids, at = [], []
    if maps is not None:
        away, near = map(np.asarray, cKDTree(places).query(target.lattice))
        for point in np.flatnonzero(away < 0.5):
            placed = register(target, gray, int(point), maps[int(near[point])])
            if placed is not None and placed.likeness >= LEAST_LIKENESS:
                ids.append(int(point))
                at.append(placed.pixel)
    return Sighting(np.array(ids, dtype=np.intp), np.array(at).reshape(-1, 2))
