"""Parameters of the detector of Lin et al. (2020): the paper's numbers, and what it leaves open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from simtip.detect.components import Connectivity
from simtip.detect.gray import LUMA_WEIGHTS
from simtip.detect.parameters import Declared, DetectorParameters, bad_value

Polarity: TypeAlias = Literal["dark", "bright", "both"]
Ties: TypeAlias = Literal["mean", "left", "right"]


@dataclass(frozen=True)
class Lin2020Parameters(DetectorParameters):
    """Parameters of `detect`. The defaults are the paper's where it gives a number."""

    weights: Annotated[
        tuple[float, float, float],
        Declared(
            "R, G, B weights of the gray value, summing to 1 (paper: 'weighted average')",
            minimum=0,
            maximum=1,
        ),
    ] = LUMA_WEIGHTS
    full_scale: Annotated[
        int | None,
        Declared(
            "white of a 16-bit image, DN, e.g. 4095 for 12-bit data; none is 65535",
            minimum=1,
            maximum=65535,
        ),
    ] = None
    median_window: Annotated[
        int,
        Declared(
            "side of the square median window, px, odd; 1 is no filter (paper: silent)",
            minimum=1,
            maximum=255,
        ),
    ] = 5
    threshold: Annotated[
        int,
        Declared(
            "T, 8-bit DN: below it is needle, at it or above is background", minimum=1, maximum=255
        ),
    ] = 105
    min_area_px: Annotated[
        int, Declared("components of fewer pixels are removed, px", minimum=0, maximum=2**30)
    ] = 4500
    connectivity: Annotated[
        Connectivity, Declared("4 or 8 neighbours make a component (paper: silent)")
    ] = 8
    polarity: Annotated[
        Polarity,
        Declared(
            "which small components are removed: dark ones (needle polarity), bright ones (glare "
            "inside the needle), or dark ones and then bright ones (paper: silent)"
        ),
    ] = "dark"
    keep: Annotated[
        Literal["all", "largest"],
        Declared("dark components that stay: all large enough (the text), or only the largest"),
    ] = "all"
    canny_low: Annotated[float, Declared("lower threshold of Canny", minimum=0, maximum=1e6)] = 40.0
    canny_high: Annotated[float, Declared("upper threshold of Canny", minimum=0, maximum=1e6)] = (
        80.0
    )
    canny_aperture: Annotated[
        Literal[3, 5, 7], Declared("side of Canny's Sobel window, px (paper: silent)")
    ] = 3
    canny_l2: Annotated[
        bool,
        Declared("gradient length by the L2 norm, not by |gx| + |gy| (paper: silent)"),
    ] = False
    ties: Annotated[
        Ties,
        Declared(
            "which of several edge pixels on the lowest row is the tip: the mean of their longest "
            "unbroken run, the left one or the right one (paper: silent)"
        ),
    ] = "mean"
    border_margin_px: Annotated[
        int,
        Declared(
            "a tip closer than this to the border is refused, px; 0 refuses none",
            minimum=0,
            maximum=2**30,
        ),
    ] = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        if abs(sum(self.weights) - 1) > 1e-6:
            raise bad_value("weights", f"they sum to {sum(self.weights):g}", "make the sum 1")
        if self.median_window % 2 == 0:
            raise bad_value("median_window", f"{self.median_window} is even", "give an odd number")
        if self.canny_low > self.canny_high:
            raise bad_value(
                "canny_low",
                f"{self.canny_low:g} is above canny_high = {self.canny_high:g}",
                "give the lower threshold here",
            )


DEFAULTS = Lin2020Parameters()
