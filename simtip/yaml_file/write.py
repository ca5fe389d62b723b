"""Plain data to YAML."""

from __future__ import annotations

import yaml

from simtip.yaml_file.document import Yaml
from simtip.yaml_file.scalars import FLOAT, HEX, INT, OCTAL

_TAGS = "tag:yaml.org,2002:"


def dump_yaml(value: Yaml) -> str:
    """Write plain data as YAML that `parse_yaml` reads back exactly."""
    text: str = yaml.dump(
        value,
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=100,
    )
    return text


class _Dumper(yaml.SafeDumper):
    """Writes what the core schema reads back: no aliases, floats at full precision."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002 - PyYAML's signature
        return True


def _represent_float(dumper: yaml.SafeDumper, number: float) -> yaml.ScalarNode:
    # repr() is the shortest text that reads back to the same float.
    special = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}
    text = repr(number)
    return dumper.represent_scalar(_TAGS + "float", special.get(text, text))


# PyYAML follows YAML 1.1, where 1e-3 and 08 are text: told of both schemas, it puts quotes around
# any text that either would take for something else.
_Dumper.add_representer(float, _represent_float)
_Dumper.add_implicit_resolver(_TAGS + "float", FLOAT, list("-+.0123456789"))
for _pattern in (INT, OCTAL, HEX):
    _Dumper.add_implicit_resolver(_TAGS + "int", _pattern, list("-+0123456789"))
