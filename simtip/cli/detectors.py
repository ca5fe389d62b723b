"""`simtip detectors`: which there are, what can be set on them, do they keep the contract."""

from __future__ import annotations

import json
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from simtip.cli.detector_options import (
    SettingsOption,
    as_detector_options,
    chatter_aside,
    configured,
    parse_settings,
)
from simtip.cli.options import JsonOption
from simtip.cli.output import print_json, say, to_stdout
from simtip.detect import Listing, catalogue
from simtip.detect import listing as find

SHOW = "show"
BROKEN = 1
"""Exit code of `check` for a detector that breaks the contract."""


class _DetectorsGroup(TyperGroup):
    """A group in which a name that is no command is a detector to show."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Put `show` before the name of a detector."""
        named = args if args and args[0] in self.commands else [SHOW, *args]
        return super().resolve_command(ctx, named)


detectors = typer.Typer(cls=_DetectorsGroup)


@detectors.callback(
    invoke_without_command=True, subcommand_metavar="[REF | COMMAND]", no_args_is_help=False
)
def list_all(context: typer.Context, as_json: JsonOption = False) -> None:
    """List the detectors with their parameters; with a REF, that one alone."""
    if context.invoked_subcommand is not None:
        context.obj = as_json
        return
    with chatter_aside():
        found = [_described(item) for item in catalogue()]
    if as_json:
        say(json.dumps(found, allow_nan=False))
        return
    _show(found)


@detectors.command(SHOW)
def show(
    context: typer.Context,
    reference: Annotated[str, typer.Argument(metavar="REF", help="As for --detector.")],
    as_json: JsonOption = False,
) -> None:
    """Show one detector and its parameters."""
    with as_detector_options(), chatter_aside():
        found = _described(find(reference))
    if as_json or context.obj:
        print_json(found)
        return
    _show([found])


@detectors.command("check")
def check_contract(
    context: typer.Context,
    reference: Annotated[str, typer.Argument(metavar="REF", help="As for --detector.")],
    settings: SettingsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run one detector through the contract that all have to keep; exit code 1 if it breaks it."""
    from simtip.console import progress_bar
    from simtip.detect.contract import check, report_lines
    from simtip.detect.excerpt import printable

    configured(reference, settings)  # errors are found here, where they know the options' names
    with progress_bar("checking") as progress:
        report = check(reference, parse_settings(settings), progress=progress)
    if as_json or context.obj:
        print_json(report.to_dict())
    else:
        say("\n".join(map(printable, report_lines(report))))
    if not report.ok:
        raise typer.Exit(BROKEN)


def _show(found: list[dict[str, Any]]) -> None:
    from simtip.detection_console import show_detectors

    with to_stdout():
        show_detectors(found)


def _described(item: Listing) -> dict[str, Any]:
    known = item.detector
    return {
        "name": item.name,
        "source": item.source,
        "summary": "" if known is None else known.summary,
        "fault": item.fault,
        "parameters": []
        if known is None
        else [
            {
                "name": parameter.name,
                "type": parameter.type,
                "default": _plain(parameter.default),
                "required": parameter.required,
                "description": parameter.description,
            }
            for parameter in known.parameters
        ],
    }


def _plain(value: object) -> object:
    """Give a default as JSON has it; what JSON has not becomes text."""
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        return str(value)
    return value
