"""The whole command line: its commands, and what happens to their errors."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Annotated

import typer

from simtip.cli.boards import boards
from simtip.cli.bound import bound
from simtip.cli.budget import budget
from simtip.cli.cache import cache
from simtip.cli.calibrate import calibrate
from simtip.cli.camera import camera
from simtip.cli.detect import detect
from simtip.cli.detectors import detectors
from simtip.cli.doctor import doctor
from simtip.cli.errors import ClickError, fail, usage
from simtip.cli.export import export
from simtip.cli.mca import mca
from simtip.cli.measure import measure
from simtip.cli.output import say
from simtip.cli.regress import regress
from simtip.cli.remix import remix
from simtip.cli.render import render
from simtip.cli.report import report
from simtip.cli.results import results
from simtip.cli.rig import rig
from simtip.cli.run import run
from simtip.cli.schema import schema
from simtip.cli.sweep import sweep
from simtip.cli.view import view
from simtip.errors import SimtipError
from simtip.interrupts import INTERRUPTED, NOTHING_WRITTEN
from simtip.version import __version__

app = typer.Typer(
    name="simtip",
    help="Validate stereo needle-tip measurement on rendered images with known truth.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        say(f"simtip {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        say(context.get_help())
        raise typer.Exit(2)


COMMANDS: tuple[Callable[..., None], ...] = (
    *(run, render, remix, measure, detect, sweep, results, report, export, view),
    *(rig, boards, calibrate, camera, mca, budget, bound, doctor, schema),
)
"""In the order of `simtip --help`, which lists groups last."""

for command in COMMANDS:
    app.command()(command)
app.add_typer(detectors, name="detectors")
app.add_typer(regress, name="regress")
app.add_typer(cache, name="cache")


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; user errors are one line on stderr and exit code 2."""
    try:
        code = app(arguments, prog_name="simtip", standalone_mode=False)
    except SimtipError as error:
        fail(str(error), 2)
    except ClickError as error:
        fail(usage(error), 2)
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    if code == INTERRUPTED:  # Typer, too, makes an interrupt this code
        fail(NOTHING_WRITTEN, INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)
