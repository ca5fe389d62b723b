"""Parameters of the sub-pixel detector."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal, TypeAlias

from typing_extensions import override

from simtip.camera import Camera
from simtip.detect.parameters import Declared, DetectorParameters, bad_value

TipKind: TypeAlias = Literal["auto", "cone", "round", "wedge", "bevel"]


@dataclass(frozen=True)
class SubpixelParameters(DetectorParameters):
    """Parameters of `detect`; none has to be given."""

    tip: Annotated[
        TipKind,
        Declared(
            "the needle's tip, if known: a sharp cone, a cone with a round end, a wedge (any point "
            "with two straight flanks), a bevel; auto takes what describes the picture best"
        ),
    ] = "auto"
    min_width_px: Annotated[
        float, Declared("narrowest needle looked for, px", minimum=3, maximum=1000)
    ] = 6.0
    max_width_px: Annotated[
        float, Declared("widest needle looked for, px", minimum=3, maximum=1000)
    ] = 80.0
    full_scale: Annotated[
        int | None,
        Declared(
            "white of a 16-bit image, DN, e.g. 4095 for 12-bit data; none is 65535",
            minimum=1,
            maximum=65535,
        ),
    ] = None
    focal_px: Annotated[
        float | None,
        Declared(
            "the camera's focal length, px, if known; it tells how a bevel is seen; none takes the "
            "image's longer side",
            minimum=1,
            maximum=1e7,
        ),
    ] = None
    centre_px: Annotated[
        tuple[float, float] | None,
        Declared(
            "the camera's principal point u, v, px, if known; none takes the image's middle",
            minimum=-1e6,
            maximum=1e6,
        ),
    ] = None
    candidates: Annotated[
        int, Declared("bands that are tried, the most promising first", minimum=1, maximum=50)
    ] = 4

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.min_width_px > self.max_width_px:
            raise bad_value(
                "min_width_px",
                f"{self.min_width_px:g} is above max_width_px = {self.max_width_px:g}",
                "give the smaller width here",
            )

    @override
    def for_camera(self, camera: Camera, /) -> SubpixelParameters:
        """Take focal length and principal point from a camera where they are not set."""
        fx, fy = float(camera.K[0, 0]), float(camera.K[1, 1])
        centre = float(camera.K[0, 2]), float(camera.K[1, 2])
        return replace(
            self,
            focal_px=self.focal_px or (fx + fy) / 2,
            centre_px=self.centre_px or centre,
        )

    @override
    def for_region(self, u0: int, v0: int, shape: tuple[int, ...], /) -> SubpixelParameters:
        """Move the principal point, or else the image's middle, into the region's pixels."""
        u, v = self.centre_px or ((shape[1] - 1) / 2, (shape[0] - 1) / 2)
        return replace(self, centre_px=(u - u0, v - v0))


DEFAULTS = SubpixelParameters()
