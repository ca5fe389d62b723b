"""Experiment files: YAML in, a checked experiment out."""

from __future__ import annotations

import json
from pathlib import Path

from pydantic import ValidationError

from simtip.scene_error import input_error
from simtip.spec.experiment import ExperimentSpec
from simtip.yaml_file import load_yaml, shown


def read_experiment(path: str | Path) -> ExperimentSpec:
    """Read and check an experiment: what a scene has under ``experiment``.

    Raises
    ------
    InputError
        Whatever is wrong first, with its line and dotted field.
    """
    document = load_yaml(path)
    if not isinstance(document.value, dict):
        raise document.error(
            f"an experiment is a mapping of keys, not {shown(document.value)}",
            remedy="see docs/capability.md",
        )
    try:
        text = json.dumps(document.value, allow_nan=False)
        return ExperimentSpec.model_validate_json(text, strict=True)
    except ValidationError as error:
        raise input_error(document, error, ("experiment",)) from None
    except ValueError as error:
        raise document.error(
            "holds a number that is not finite", remedy="write a number"
        ) from error
