"""From a folder of results to its page and figures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from simtip.page.folder import Kind, Results
from simtip.page.options import Options
from simtip.page.parts import Page


def page_of(results: Results, options: Options) -> Page:
    """Make the page of a folder of results.

    Raises
    ------
    InputError
        A file of it is missing, damaged or cut short.
    """
    # Each kind is loaded with what it needs, alone.
    if results.kind == "sweep":
        from simtip.page.sweep import sweep_page

        return sweep_page(results, options)
    return _maker(results.kind)(results)


def _maker(kind: Kind) -> Callable[[Results], Page]:
    match kind:
        case "boards":
            from simtip.page.boards import boards_page as made
        case "calibrate":
            from simtip.page.calibration import calibration_page as made
        case "mca":
            from simtip.page.capability import capability_page as made
        case "budget":
            from simtip.page.budget import budget_page as made
        case "regress":
            from simtip.page.regress import regress_page as made
        case _:
            from simtip.page.run import run_page as made
    return made


def write_figures(page: Page, folder: Path) -> list[str]:
    """Write all figures of a page into a folder, as SVG and as PNG; give their names."""
    from simtip.report.style import png, svg

    names = []
    for drawing in page.all_figures():
        for name, content in (
            (f"{drawing.name}.svg", svg(drawing.figure)),
            (f"{drawing.name}.png", png(drawing.figure)),
        ):
            (folder / name).write_bytes(content)
            names.append(name)
    return names
