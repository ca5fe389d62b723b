"""`simtip measure`: the measuring wing alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from simtip.cli.detector_options import (
    DetectorOption,
    SettingsOption,
    as_detector_options,
    configured,
    parse_roi,
    parse_settings,
)
from simtip.cli.errors import as_option
from simtip.cli.options import JsonOption, named
from simtip.cli.output import print_json, to_stdout
from simtip.errors import InputError
from simtip.triangulate import Method

if TYPE_CHECKING:
    from simtip.refine import Refiner

REFINEMENTS = ("none", "silhouette")


def measure(
    left: Annotated[Path, typer.Argument(parser=named, metavar="LEFT", help="Left image file.")],
    right: Annotated[Path, typer.Argument(parser=named, metavar="RIGHT", help="Right image file.")],
    rig: Annotated[
        Path,
        typer.Option(
            "--rig", parser=named, metavar="RIG", help="OpenCV, JSON or Kalibr file, or a ROS pair."
        ),
    ],
    detector: DetectorOption = "lin2020",
    settings: SettingsOption = None,
    roi_left: Annotated[
        str | None,
        typer.Option("--roi-left", metavar="X,Y,W,H", help="Look there in the left image, px."),
    ] = None,
    roi_right: Annotated[
        str | None, typer.Option("--roi-right", metavar="X,Y,W,H", help="Likewise in the right.")
    ] = None,
    method: Annotated[
        Method, typer.Option("--method", help="How two rays become one point.")
    ] = "svd",
    max_distance_px: Annotated[
        float, typer.Option("--max-distance", metavar="PX", help="From the epipolar line.")
    ] = 2.0,
    refine: Annotated[
        str, typer.Option("--refine", metavar="NAME", help="silhouette: with the needle's shape.")
    ] = "none",
    needle: Annotated[
        str | None,
        typer.Option(
            "--needle",
            metavar="SHAPE",
            help="For --refine: .ply or .stl file, mm, or cone:DIAMETER:LENGTH, "
            "bevel:DIAMETER:ANGLE.",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Measure the needle tip on a pair of image files of any origin."""
    from simtip.console import show_result
    from simtip.image_file import read_image
    from simtip.measure import measure_pair, require_size
    from simtip.rig_file import read_rig

    chosen = configured(detector, settings)
    regions = parse_roi(roi_left, "--roi-left"), parse_roi(roi_right, "--roi-right")
    if not max_distance_px > 0:
        raise InputError(
            f"{max_distance_px:g} px is no distance", field="--max-distance", remedy="give above 0"
        )
    refiner = _refiner(refine, needle, _full_scale(settings))
    image_left, image_right = read_image(left), read_image(right)
    cameras = read_rig(
        rig,
        (image_left.shape[1], image_left.shape[0]),
        (image_right.shape[1], image_right.shape[0]),
    )
    remedy = f"give the rig that took the images, not {rig}, or images of that size"
    require_size("left", image_left, cameras.left, file=left, remedy=remedy)
    require_size("right", image_right, cameras.right, file=right, remedy=remedy)
    for side, region, image in zip(
        ("left", "right"), regions, (image_left, image_right), strict=True
    ):
        if region is not None:
            with as_option(f"--roi-{side}"):
                region.check(image.shape)
    with as_detector_options():
        measurement = measure_pair(
            image_left,
            image_right,
            cameras,
            chosen,
            max_distance_px=max_distance_px,
            method=method,
            regions=regions,
            refiner=refiner,
        )
    names = {"rig": str(rig), "left": str(left), "right": str(right), "detector": detector}
    result = {**names, **measurement.to_dict()}
    if as_json:
        print_json(result)
        return
    with to_stdout():
        show_result(result)


def _full_scale(settings: list[str] | None) -> int | None:
    """Give what was told to the detector of white: the refinement looks at the same images."""
    value = str(parse_settings(settings).get("full_scale", ""))
    return int(value) if value.isdecimal() else None


def _refiner(name: str, needle: str | None, full_scale: int | None) -> Refiner | None:
    """Set up what `--refine` and `--needle` ask for."""
    from simtip.refine import silhouette, solid_of

    if name not in REFINEMENTS:
        raise InputError(
            f"{name[:80]!r} is no refinement",
            field="--refine",
            remedy=f"give {' or '.join(REFINEMENTS)}",
        )
    if name == "none":
        if needle is not None:
            raise InputError("is not used", field="--needle", remedy="give --refine silhouette too")
        return None
    if needle is None:
        raise InputError(
            "needs the needle's shape", field="--refine silhouette", remedy="give --needle SHAPE"
        )
    with as_option("--needle"):
        return silhouette(solid_of(needle), full_scale)
