"""One call for every family of targets."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from simtip.find_target.gray import to_gray
from simtip.find_target.grids import find_grid
from simtip.find_target.markers import find_charuco
from simtip.find_target.outcome import NotFound
from simtip.target import Charuco, Sighting, Target

SMALLEST_PX = 16
"""Least side of an image that could show a target."""


def find(target: Target, image: NDArray[Any]) -> Sighting | NotFound:
    """Find a target in an image.

    The points are those of the print: an image of a circle is no circle whose centre is the
    centre's image, and that is accounted for, without knowing the camera, from how the grid itself
    is distorted.

    **Which point is which.** A view that is mirrored is never read as one that is not. Point 0 is
    the same physical point in every view unless the target looks the same upside down
    (`Target.half_turn_ambiguous`) or after a quarter turn; then, of the possible readings, the one
    is given whose rows run most nearly to the right and down in this image. Two cameras, or two
    views, may then disagree by half a turn: the caller has to decide.

    **A mirrored image** is refused for targets that are `chiral`. The others look in a mirror like
    themselves turned, so that no finder could tell.

    Parameters
    ----------
    target
        What to look for. Of a chessboard or a grid of circles, all has to be in the image (points
        that are covered or spoilt are left out, up to a quarter); of a ChArUco board a part.
    image
        (H, W) gray or (H, W, 3) RGB, uint8 or uint16. Not changed.

    Returns
    -------
    Sighting or NotFound
        Points with pixels of the image as given, or the reason why there are none.

    Raises
    ------
    InputError
        The image has another shape or type.
    """
    gray = to_gray(image)
    h, w = image.shape[:2]
    if min(h, w) < SMALLEST_PX:
        return NotFound(f"the image has only {w}x{h} pixels")
    if gray is None:
        return NotFound("the image is uniform: nothing in it is darker or brighter")
    if isinstance(target, Charuco):
        return find_charuco(target, gray)
    return find_grid(target, gray)
