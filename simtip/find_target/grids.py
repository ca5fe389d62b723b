"""Finding a chessboard or a grid of circles: all of it is in the image, or it is not found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simtip.find_target.blobs import blobs
from simtip.find_target.gray import Gray, original_pixels, resized
from simtip.find_target.grow import Grown, grow
from simtip.find_target.match import COVERAGE, Reading, extent, readings
from simtip.find_target.outcome import NotFound
from simtip.find_target.refine import LEAST_LIKENESS, likeness, refine, with_missing
from simtip.find_target.saddles import saddles
from simtip.target import AsymmetricCircles, Chessboard, CircleGrid, Sighting, Target

WORKING_PX = 1100
"""Longer side of the image in which candidates are sought first."""

SCALES = (1.0, 2.0, 0.5, 0.25)
"""Of the working size, in the order they are tried; none enlarges the image more than twice."""

TOLD_OF = 16
"""Points of a lattice whose size is told."""

OTHER_DIAMETERS = (0.5, 0.6, 0.7, 0.8, 1.25, 1.4, 1.7, 2.0)
"""Of the stated one, which are tried if circles look unlike it."""

SUSPICIOUS, CLEARLY = 0.03, 0.5
"""Lack of likeness from which others are tried, and part of it that decides for one of them."""


def find_grid(target: Target, gray: Gray) -> Sighting | NotFound:
    """Find a chessboard or a grid of circles in (H, W) gray values."""
    largest: Grown | None = None
    refused: NotFound | None = None
    for scale in _scales(gray):
        small = resized(gray, scale)
        candidates = saddles(small) if target.disc_radius is None else blobs(small)
        for grown in grow(candidates, len(target.points)):
            pixels = original_pixels(grown.pixels, small, gray)
            lattice = Grown(grown.places, pixels)
            outcome = _read(target, gray, lattice)
            if isinstance(outcome, Sighting):
                return outcome
            refused = refused or outcome
            if largest is None or len(lattice.places) > len(largest.places):
                largest = lattice
    if refused is not None:
        return refused
    return NotFound(_instead(target, largest))


def _scales(gray: Gray) -> list[float]:
    working = min(1.0, WORKING_PX / max(gray.shape))
    scales = [working * s for s in SCALES]
    return [s for s in scales if s <= 2 and min(gray.shape) * s >= 16]


def _read(target: Target, gray: Gray, lattice: Grown) -> Sighting | NotFound | None:
    """Read a lattice as the target; None if it has another size."""
    ways = readings(target, lattice)
    if not ways:
        return None
    other = _other_diameter(target, gray, ways[0])
    if other is not None:
        return NotFound(
            f"circles of about {other:.2g} mm are there in the places of {target}: another diameter"
        )
    straight = [way for way in ways if not way.mirrored]
    looks = [likeness(target, gray, way.ids, way.pixels) for way in straight]
    for way, look in zip(straight, looks, strict=True):
        if look >= LEAST_LIKENESS:
            return _refined(target, gray, way, dark=True)
    if target.chiral and (not straight or min(looks) <= -LEAST_LIKENESS):
        return NotFound(_mirrored(target))
    if straight and max(looks) <= -LEAST_LIKENESS:
        # White where it should be black whichever way up, but with its corners in the same places.
        return _refined(target, gray, straight[0], dark=False)
    return NotFound(
        f"a lattice of the size of {target} is there, but its points do not look like the print"
    )


def _other_diameter(target: Target, gray: Gray, way: Reading) -> float | None:
    """Tell about how wide the circles are, mm, if that is clearly not what was stated.

    The ink itself decides, drawn with several diameters: blur widens outlines, too.
    """
    if not isinstance(target, CircleGrid | AsymmetricCircles):
        return None
    unlike = 1 - likeness(target, gray, way.ids, way.pixels)
    if unlike < SUSPICIOUS:
        return None
    widths = [target.diameter_mm * ratio for ratio in OTHER_DIAMETERS]
    others = [
        (1 - likeness(replace(target, diameter_mm=width), gray, way.ids, way.pixels), width)
        for width in widths
        if width < target.nearest_mm
    ]
    best = min(others, default=(2.0, 0.0))
    return best[1] if best[0] < CLEARLY * unlike else None


def _refined(target: Target, gray: Gray, way: Reading, *, dark: bool) -> Sighting | NotFound:
    ids, pixels = with_missing(target, way.ids, way.pixels)
    sighting = refine(target, gray, ids, pixels, dark=dark)
    seen = 0 if sighting is None else len(sighting)
    if sighting is None or seen < COVERAGE * len(target.points):
        return NotFound(
            f"{target} is there, but only {seen} of its {len(target.points)} points can be made out"
        )
    return sighting


def _mirrored(target: Target) -> str:
    if isinstance(target, Chessboard):
        other = Chessboard(target.rows, target.columns, target.square_mm)
        return (
            f"the board is {target} with black and white exchanged: the image is mirrored, or the"
            f" board is {other}"
        )
    return f"{target} is there, but in a mirror: the image is flipped"


def _instead(target: Target, largest: Grown | None) -> str:
    """Say what was seen instead of the target."""
    what = "inner corners" if target.disc_radius is None else "circles"
    if largest is None:
        return f"no lattice of {what} is in the image"
    size = extent(target, largest) if len(largest.places) >= TOLD_OF else None
    if size is None:
        return f"no whole lattice of {what} can be made out, at most {len(largest.places)} of one"
    stated = str(target).split(":")[1]
    seen = f"{size[0]}x{size[1]}"
    columns, rows = (int(n) for n in stated.split("x"))
    least = sorted(size), sorted((columns, rows))
    if all(np.array(least[0]) <= np.array(least[1])):
        return (
            f"a lattice of {seen} {what} is in sight, not of {stated}: part of the board is hidden"
            " or outside of the image, or it is another board"
        )
    return f"a board of {seen} {what} is there, not of {stated}"
