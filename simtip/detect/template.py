"""The text of an external command: its arguments, with places for the image and for parameters."""

from __future__ import annotations

import keyword
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass

from simtip.detect.parameters import FIELD_PREFIX
from simtip.errors import InputError

FIELD = f"{FIELD_PREFIX}.name"
IMAGE = "image"
RESERVED = "name"
"""In a scene this key names the detector itself."""

# {name} is a place; {{name}} is the text {name}; all other braces are text.
_PLACE = re.compile(r"\{\{([A-Za-z_]\w*)\}\}|\{([A-Za-z_]\w*)\}", re.ASCII)


@dataclass(frozen=True)
class Template:
    """A command, split into arguments.

    Attributes
    ----------
    arguments
        The program and its arguments, with places such as ``{image}``.
    places
        Names of the places but ``image``, each once, in the order of their appearance.
    """

    arguments: tuple[str, ...]
    places: tuple[str, ...]

    def filled(self, values: Mapping[str, str]) -> list[str]:
        """Put the values into their places; no value is split, whatever it holds."""
        return [_PLACE.sub(lambda found: _text(found, values), item) for item in self.arguments]


def _text(found: re.Match[str], values: Mapping[str, str]) -> str:
    literal, place = found.groups()
    return f"{{{literal}}}" if literal else values[place]


def parse_template(text: str) -> Template:
    """Split a command as a shell splits words and quotes; no shell is ever asked.

    Raises
    ------
    InputError
        It is empty, a quote is not closed, ``{image}`` is nowhere, or a place cannot be a
        parameter.
    """
    try:
        arguments = tuple(shlex.split(text))
    except ValueError as error:
        raise InputError(
            f"the command cannot be split into arguments ({str(error).lower()})",
            field=FIELD,
            remedy="close its quotes",
        ) from None
    if not arguments:
        raise InputError(
            "there is no command after cmd:", field=FIELD, remedy="write 'cmd:PROGRAM {image}'"
        )
    found = [match[2] for item in arguments for match in _PLACE.finditer(item) if match[2]]
    if IMAGE not in found:
        raise InputError(
            "the command does not say where the image file goes",
            field=FIELD,
            remedy="put {image} into it, as in 'cmd:PROGRAM {image}'",
        )
    places = tuple(dict.fromkeys(place for place in found if place != IMAGE))
    for place in places:
        if place == RESERVED or keyword.iskeyword(place):
            raise InputError(
                f"{{{place}}} cannot be a parameter", field=FIELD, remedy="call it otherwise"
            )
    return Template(arguments, places)
