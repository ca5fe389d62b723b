"""YAML as plain data with line numbers; nothing in a file is ever executed or instantiated.

PyYAML only splits the text into events. What those events mean is decided here, by the core schema
of YAML 1.2 (section 10.3): ``1e-3`` is a number, ``on`` and ``yes`` are text. Depth, number of
values and size are bounded, so that a hostile file costs neither the stack nor the memory.
"""

from simtip.yaml_file.document import Document, FieldPath, Yaml, dotted, shown, undotted
from simtip.yaml_file.read import load_yaml, parse_yaml
from simtip.yaml_file.write import dump_yaml

__all__ = [
    "Document",
    "FieldPath",
    "Yaml",
    "dotted",
    "dump_yaml",
    "load_yaml",
    "parse_yaml",
    "shown",
    "undotted",
]
