"""An experiment's pictures, of the kind of the paper's Fig. 11, 12 and 13."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from simtip.experiment.result import Capability
from simtip.output_folder import write_atomically
from simtip.report.accuracy import accuracy_figure
from simtip.report.bland_altman import bland_altman_figure
from simtip.report.repeatability import repeatability_figure
from simtip.report.style import png


def figures_of(capability: Capability) -> Iterator[tuple[str, bytes]]:
    """Give names and contents of an experiment's pictures, as PNG."""
    steps, whole = capability.steps, capability.from_start
    runs = [run + 1 for run in whole.run]
    yield "accuracy.png", png(accuracy_figure(steps.measured, steps.reference))
    yield (
        "agreement.png",
        png(bland_altman_figure(whole.measured, whole.reference, capability.agreement, runs=runs)),
    )
    found = capability.repeatability_of_errors
    if found is not None:
        yield (
            "repeatability.png",
            png(repeatability_figure(whole.measured, whole.reference, whole.position, runs, found)),
        )


def write_figures(folder: Path, capability: Capability) -> None:
    """Write an experiment's pictures.

    Raises
    ------
    InputError
        One cannot be written.
    """
    for name, content in figures_of(capability):
        write_atomically(folder / name, content)
