"""`simtip rig`: a scene's true rig for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from simtip.cli.options import SceneArgument, named
from simtip.cli.output import say
from simtip.cli.rig_output import require_new
from simtip.rig_file import Format
from simtip.scene_file import read_scene


def rig(
    scene: SceneArgument,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", parser=named, metavar="FILE", help="Instead of stdout."),
    ] = None,
    form: Annotated[
        Format | None,
        typer.Option("--format", help="Of the file; by default what its ending says."),
    ] = None,
) -> None:
    """Export a scene's true rig in OpenCV's, ROS's, Kalibr's or simtip's JSON form."""
    from simtip.rig_file import rig_text, write_rig

    cameras = read_scene(scene).spec.rig.rig()
    if out is None:
        say(rig_text(cameras, form or "opencv").rstrip("\n"))
        return
    require_new(out, form)
    write_rig(out, cameras, form)
