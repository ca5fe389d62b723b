"""Reference pages that are made when the site is built, from the program itself."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

sys.path.insert(0, str(Path(__file__).parent))

from schema_tables import schema_page

from simtip.regress.suite import SuiteSpec
from simtip.scene_file import scene_schema
from simtip.sweep.spec import SweepSpec

LISTED = re.compile(r"^\*\*Commands\*\*:\n\n(?:\* .*\n)+", re.MULTILINE)
"""Lists of commands with their help cut short: the page's own contents list them."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages."""
    pages = {
        "reference/cli.md": command_line(),
        "reference/scene_fields.md": schema_page(
            "Fields of a scene", "All that a scene file may say.", scene_schema()
        ),
        "reference/sweep_fields.md": schema_page(
            "Fields of a sweep", "All that a sweep file may say.", SweepSpec.model_json_schema()
        ),
        "reference/suite_fields.md": schema_page(
            "Fields of a suite", "All that a suite file may say.", SuiteSpec.model_json_schema()
        ),
    }
    for uri, text in pages.items():
        files.append(File.generated(config, uri, content=text))
    return files


def command_line() -> str:
    """Give every command's help, as Typer writes it."""
    words = [sys.executable, "-m", "typer", "simtip.cli", "utils", "docs", "--name", "simtip"]
    told = subprocess.run(words, capture_output=True, text=True, check=True).stdout  # noqa: S603 (fixed words)
    named = told.replace("# `simtip`", "# Command line", 1).replace("```console", "```text")
    return LISTED.sub("", named)
