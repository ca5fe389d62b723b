#!/usr/bin/env python3
"""Make the meshes of this folder from parameters.yaml: ``python regenerate.py [FOLDER]``."""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

from simtip.spec import NeedleSpec

HERE = Path(__file__).resolve().parent


def regenerate(folder: Path) -> list[Path]:
    """Write every mesh into a folder as binary PLY and return the paths."""
    source = yaml.safe_load((HERE / "parameters.yaml").read_text(encoding="utf-8"))
    written = []
    for name, parameters in source["meshes"].items():
        spec = NeedleSpec.model_validate({**parameters, "tip_mm": (0, 0, 0)})
        mesh = spec.needle().mesh(source["segments"])
        path = folder / name
        path.write_bytes(mesh.export(file_type="ply", encoding="binary", vertex_normal=False))
        written.append(path)
    return written


if __name__ == "__main__":
    for made in regenerate(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE):
        sys.stdout.write(f"{made}\n")
