"""What a lens does to geometry and light, beyond the pinhole: the depth that is sharp."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ThinLens:
    """A thin lens, sharp at one distance.

    Attributes
    ----------
    aperture_mm
        Diameter of the entrance pupil, which lies at the camera's centre.
    focus_mm
        Camera z of the plane that is sharp.
    """

    aperture_mm: float
    focus_mm: float

    def blur_px(self, focal_px: float, depth_mm: float) -> float:
        """Diameter of the circle of confusion, px: ``c = f A |1/z - 1/z_f|``.

        Exact for the thin lens in terms of the focal length in pixels, which is the image
        distance that the camera was calibrated at.
        """
        return focal_px * self.aperture_mm * abs(1 / depth_mm - 1 / self.focus_mm)
