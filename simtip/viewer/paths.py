"""Names of what is recorded; world frame = left camera's, mm."""

from __future__ import annotations

WORLD = "/world"
CAMERAS = f"{WORLD}/cameras"
NEEDLE, AXIS = f"{WORLD}/needle", f"{WORLD}/axis"
TIP_TRUE, TIP_MEASURED = f"{WORLD}/tip/true", f"{WORLD}/tip/measured"
RAYS, GAP = f"{WORLD}/rays", f"{WORLD}/gap"
BACKGROUND, LAMPS = f"{WORLD}/background", f"{WORLD}/lamps"
PLATE, POINTS = f"{WORLD}/plate", f"{WORLD}/points"
ABOUT, ERROR = "/about", "/error/norm_mm"

TIMELINE = "trial"


def camera_of(side: str) -> str:
    """Name a camera, where its pose is."""
    return f"{CAMERAS}/{side}"


def image_of(side: str) -> str:
    """Name a camera's image plane, within which pixels count."""
    return f"{camera_of(side)}/image"
