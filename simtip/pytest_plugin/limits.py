"""How far a tip may be from the true one, and by how much one is beyond that, in words."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Iterator
from dataclasses import dataclass, fields
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from simtip.errors import InputError
from simtip.geometry import Array

if TYPE_CHECKING:
    from simtip.camera import Camera
    from simtip.detect import TipObservation
    from simtip.pytest_plugin.pair import MeasuredPair
    from simtip.score import PixelError
    from simtip.truth import ViewTruth


@dataclass(frozen=True)
class Limits:
    """The largest errors that a test allows; None allows any.

    Attributes
    ----------
    px
        Length of the error in each image, px.
    along_px, across_px
        Its parts along and across the needle's axis, px, of either sign.
    mm
        Length of the error in space, mm.

    Raises
    ------
    InputError
        There is no limit, or one is no number from 0 on.
    """

    px: float | None = None
    along_px: float | None = None
    across_px: float | None = None
    mm: float | None = None

    def __post_init__(self) -> None:
        """Check them."""
        given = self._given()
        if not given:
            raise InputError(
                "the assertion has no limit", remedy="give px=, along_px=, across_px= or mm="
            )
        for name, limit in given.items():
            if not (is_number(limit) and limit >= 0):
                said = reprlib.repr(limit)
                raise InputError(f"is {said}", field=name, remedy="give a number from 0 on")

    def _given(self) -> dict[str, Any]:
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: value for name, value in values.items() if value is not None}

    def __str__(self) -> str:
        """Say them: ``2 px, 0.1 mm``."""
        words = {"px": "px", "along_px": "px along", "across_px": "px across", "mm": "mm"}
        return ", ".join(f"{limit:g} {words[name]}" for name, limit in self._given().items())

    def complaints(self, one: MeasuredPair) -> list[str]:
        """Say what is beyond the limits, a line each; nothing if nothing is.

        Where the true tip lies outside an image, no tip may be found in it.
        """
        truth, seen = one.pair.truth, one.measurement
        said = [
            *self._of_view("left", truth.left, truth.rig.left, seen.left, one.error.left),
            *self._of_view("right", truth.right, truth.rig.right, seen.right, one.error.right),
        ]
        if self.mm is not None and seen.left.ok and seen.right.ok and one.pair.tip_in_images:
            said += self._in_space(one, self.mm)
        return said

    def _of_view(
        self,
        side: str,
        truth: ViewTruth,
        camera: Camera,
        seen: TipObservation,
        error: PixelError | None,
    ) -> Iterator[str]:
        true = _point(truth.tip_px)
        in_image = bool(camera.contains(truth.tip_px))
        if error is None:
            if in_image:
                yield f"{side}: no tip found ({seen.reason}); it is at {true}"
            return
        found = _point(seen.tip_px)
        if not in_image:
            yield f"{side}: a tip found at {found}; the true one, {true}, is outside the image"
        elif self._exceeded(error):
            yield (
                f"{side}: {error.norm_px:.2f} px off, along {error.along_px:+.2f} "
                f"({_direction(error.along_px)}), across {error.across_px:+.2f}; "
                f"found at {found}, truly at {true}"
            )

    def _exceeded(self, error: PixelError) -> bool:
        pairs = (
            (error.norm_px, self.px),
            (error.along_px, self.along_px),
            (error.across_px, self.across_px),
        )
        return any(
            limit is not None and made is not None and abs(made) > limit for made, limit in pairs
        )

    @staticmethod
    def _in_space(one: MeasuredPair, limit: float) -> Iterator[str]:
        point = one.error.point
        if point is None:
            yield f"in space: no tip ({one.measurement.reason})"
        elif point.norm_mm > limit:
            yield (
                f"in space: {point.norm_mm:.3f} mm off, x {point.x_mm:+.3f}, y {point.y_mm:+.3f}, "
                f"z {point.z_mm:+.3f}"
            )


def is_number(value: Any) -> bool:
    """Say whether a test gave a number that an error can be compared with."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _direction(along_px: float | None) -> str:
    return "short of the tip" if along_px is not None and along_px > 0 else "beyond the tip"


def _point(place: Array | None) -> str:
    u, v = np.full(2, np.nan) if place is None else place
    return f"({u:.1f}, {v:.1f})"
