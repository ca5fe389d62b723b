"""`simtip measure`: the measuring wing alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.detector_options import (
    DetectorOption,
    SettingsOption,
    as_detector_options,
    configured,
    parse_roi,
)
from simtip.cli.errors import as_option
from simtip.cli.options import JsonOption
from simtip.cli.output import print_json, to_stdout
from simtip.errors import InputError
from simtip.triangulate import Method


def measure(
    left: Annotated[Path, typer.Argument(metavar="LEFT", help="Left image file.")],
    right: Annotated[Path, typer.Argument(metavar="RIGHT", help="Right image file.")],
    rig: Annotated[
        Path,
        typer.Option("--rig", metavar="RIG", help="OpenCV, JSON or Kalibr file, or a ROS pair."),
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
        )
    names = {"rig": str(rig), "left": str(left), "right": str(right), "detector": detector}
    result = {**names, **measurement.to_dict()}
    if as_json:
        print_json(result)
        return
    with to_stdout():
        show_result(result)
