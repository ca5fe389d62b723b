"""The bounds of a condition's scenes, worked out once and kept."""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path
from typing import Any

from kept_file import keep_json

from simtip import InputError, SceneSpec
from simtip.bound import SAMPLES, bound_digests, tip_bound
from simtip.render import Backend, choose
from simtip.version import __version__

Bound = dict[str, Any]
"""What ``simtip bound SCENE --json`` gives."""


class Bounds:
    """Bounds of scenes, by what they depend on; conditions with equal scenes share them.

    Without the check of the step, which takes twice the time and changes nothing.

    Parameters
    ----------
    cache
        Folder in which they are kept, under ``bounds``; None keeps them while this object lasts.
    """

    def __init__(self, cache: Path | None) -> None:
        self._folder = None if cache is None else cache / "bounds"
        self._known: dict[str, Bound | None] = {}

    def of(self, scenes: list[SceneSpec]) -> dict[int, Bound]:
        """Give the bound of every scene by its place in the list, but of those that have none."""
        backend = choose()
        found = {k: self._of(scene, backend) for k, scene in enumerate(scenes)}
        return {k: bound for k, bound in found.items() if bound is not None}

    def _of(self, scene: SceneSpec, backend: Backend) -> Bound | None:
        name = _name(scene, backend)
        if name not in self._known:
            self._known[name] = self._kept(name) or self._worked_out(scene, backend, name)
        return self._known[name]

    def _kept(self, name: str) -> Bound | None:
        file = None if self._folder is None else self._folder / name
        return json.loads(file.read_text()) if file is not None and file.exists() else None

    def _worked_out(self, scene: SceneSpec, backend: Backend, name: str) -> Bound | None:
        print("  bound", file=sys.stderr, flush=True)
        try:
            bound = tip_bound(scene, backend=backend, check=False).to_dict()
        except InputError as error:
            print(f"  no bound: {error}", file=sys.stderr, flush=True)
            return None
        if self._folder is not None:
            self._folder.mkdir(parents=True, exist_ok=True)
            keep_json(self._folder / name, bound)
        return bound


def _name(scene: SceneSpec, backend: Backend) -> str:
    made_by = [bound_digests(scene), SAMPLES, backend.variant, __version__]
    digest = hashlib.sha256(json.dumps(made_by, sort_keys=True).encode()).hexdigest()
    return f"{digest}.json"
