"""Put values into the fields of a scene: `lamps[0].power`, `needle.tip`, `detect.threshold`."""

from __future__ import annotations

import copy
import difflib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from simtip.errors import InputError
from simtip.scene_error import input_error
from simtip.spec import SceneSpec
from simtip.yaml_file import Document, FieldPath, dotted, undotted

KIND = "kind"
"""The key of a part that says which of several parts it is."""


class Scenes:
    """Makes scenes that differ from one in some fields.

    Parameters
    ----------
    base
        The scene.
    name
        Of its file, for messages.
    """

    def __init__(self, base: SceneSpec, name: str = "") -> None:
        self.base = base
        self._name = name
        self._data = base.model_dump(mode="json", exclude_unset=True)
        self._whole = base.model_dump(mode="json")

    def with_values(self, values: Mapping[str, Any]) -> SceneSpec:
        """Give the scene with other values in some fields, by dotted path.

        A part whose `kind` changes keeps only what the new kind knows, too.

        Raises
        ------
        InputError
            There is no such field (the remedy names the nearest), or the scene is none any more.
        """
        data = copy.deepcopy(self._data)
        # A part before what is in it, whatever the order.
        for path in sorted(values, key=lambda text: len(undotted(text))):
            self._put(data, undotted(path), values[path])
        for _ in range(MOST_STRANGERS):
            try:
                return SceneSpec.model_validate_json(json.dumps(data, allow_nan=False), strict=True)
            except ValidationError as error:
                if not _drop_strangers(data, error, values):
                    raise self._said(error, data) from None
            except (ArithmeticError, ValueError) as error:
                raise InputError(
                    f"cannot be ({error})", field=", ".join(values), remedy="choose other values"
                ) from error
        raise InputError("cannot be made", field=", ".join(values), remedy="choose other values")

    def paths(self) -> list[str]:
        """List the fields that can be set, dotted."""
        return [dotted(path) for path in _leaves(self._whole, ())]

    def value(self, path: str) -> Any:
        """Give a field's value in the scene; None if it has none."""
        here: Any = self._whole
        for part in undotted(path):
            try:
                here = here[part]
            except (KeyError, IndexError, TypeError):
                return None
        return here

    def _put(self, data: Any, path: FieldPath, value: Any) -> None:
        here = data
        for k, part in enumerate(path[:-1]):
            here = self._into(here, part, path[: k + 1], path)
        last = path[-1]
        if isinstance(last, int):
            if not isinstance(here, list) or last >= len(here):
                raise self._unknown(path)
        elif not isinstance(here, dict):
            raise self._unknown(path)
        here[last] = value

    def _into(self, here: Any, part: str | int, so_far: FieldPath, path: FieldPath) -> Any:
        """Step into a part, written out first if the scene leaves it to its default."""
        missing = isinstance(here, dict) and here.get(str(part)) is None
        if missing and isinstance(part, str):
            default = self.value(dotted(so_far))
            here[part] = copy.deepcopy(default) if default is not None else {}
        try:
            found = here[part]
        except (KeyError, IndexError, TypeError):
            raise self._unknown(path) from None
        if not isinstance(found, dict | list):
            raise self._unknown(path)
        return found

    def _unknown(self, path: FieldPath) -> InputError:
        text = dotted(path)
        if text in self.paths():
            return InputError(
                "is not there any more where another factor is varied, too",
                field=text,
                remedy="vary one of them",
            )
        return InputError("is no field of the scene", field=text, remedy=self.nearest(text))

    def nearest(self, path: str) -> str:
        """Say which field was probably meant."""
        known = self.paths()
        close = difflib.get_close_matches(path, known, n=1, cutoff=0.5)
        if not close:  # perhaps only the last part is right
            last = str(undotted(path)[-1]) if undotted(path) else path
            close = [one for one in known if one.rsplit(".", 1)[-1] == last][:1]
        if close:
            return f"did you mean {close[0]!r}?"
        return "see `simtip schema` for the fields of a scene"

    def _said(self, error: ValidationError, data: Any) -> InputError:
        said = input_error(Document(self._name, data, {}), error)
        if said.problem.startswith("unknown key") and said.field:
            if said.field in self.paths():
                return InputError(
                    "is nothing that this kind has", field=said.field, remedy="leave it out"
                )
            return InputError(
                "is no field of the scene", field=said.field, remedy=self.nearest(said.field)
            )
        return InputError(said.problem, field=said.field, remedy=said.remedy)


def require_plain(paths: Iterable[str]) -> None:
    """Refuse fields that are not written as simtip writes them: the same could stand there twice.

    Raises
    ------
    InputError
        One is not.
    """
    for path in paths:
        plain = dotted(undotted(path))
        if not plain:
            raise InputError("names no field", field=repr(path), remedy="write e.g. lamps[0].power")
        if FROM_THE_END.search(path):
            raise InputError(
                "counts from the end", field=path, remedy="count from the first, which is [0]"
            )
        if path != plain:
            raise InputError("is no plain name", field=path, remedy=f"write it {plain!r}")


FROM_THE_END = re.compile(r"\[\s*-\s*[0-9]+\s*\]")

MOST_STRANGERS = 20


def _drop_strangers(data: Any, error: ValidationError, values: Mapping[str, Any]) -> bool:
    """Take away what the new kind of a part does not know; say whether there was anything."""
    changed = [path[:-1] for path in map(undotted, values) if path[-1] == KIND]
    dropped = False
    for one in error.errors(include_url=False):
        if one["type"] != "extra_forbidden":
            continue
        key = one["loc"][-1]
        for path in changed:
            part = _at(data, path)
            wanted = dotted((*path, key)) in values
            if isinstance(part, dict) and key in part and not wanted and _within(one["loc"], path):
                del part[key]
                dropped = True
    return dropped


def _within(location: tuple[int | str, ...], path: FieldPath) -> bool:
    """Say whether a location of pydantic's, with names of kinds in between, lies in a part."""
    rest = iter(location)
    return all(part in rest for part in path)


def _at(data: Any, path: FieldPath) -> Any:
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _leaves(value: Any, path: FieldPath) -> Iterator[FieldPath]:
    if isinstance(value, dict) and value:
        for key, child in value.items():
            yield from _leaves(child, (*path, key))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for index, child in enumerate(value):
            yield from _leaves(child, (*path, index))
    elif path:
        yield path
