"""`simtip doctor`: which renderers work here."""

from __future__ import annotations

import typer

from simtip.cli.options import BackendOption, JsonOption
from simtip.cli.output import print_json, to_stdout


def doctor(backend: BackendOption = None, as_json: JsonOption = False) -> None:
    """Say which renderers work on this machine, which is used, and how to mend the rest."""
    from simtip.console import show_diagnosis
    from simtip.doctor import diagnose
    from simtip.provenance import environment

    diagnosis = diagnose(backend)
    if as_json:
        print_json({**environment(), **diagnosis.to_dict()})
    else:
        with to_stdout():
            show_diagnosis(diagnosis, environment())
    if not diagnosis.ok:
        raise typer.Exit(1)
