"""`simtip schema`: the JSON Schema of scene files."""

from __future__ import annotations

import json

from simtip.cli.output import say
from simtip.scene_file import scene_schema


def schema() -> None:
    """Print the JSON Schema of scene files, for completion in editors."""
    say(json.dumps(scene_schema(), indent=2))
