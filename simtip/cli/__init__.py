"""The command line: arguments in, tables or one JSON object out. A file a command."""

from simtip.cli.program import app, main

__all__ = ["app", "main"]
