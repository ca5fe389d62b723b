"""The command line: arguments in, tables or one JSON object out."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Annotated, Any, Literal, NoReturn

import typer

from simtip.cli_bound import bound
from simtip.detect import configure
from simtip.detect.parameters import FIELD_PREFIX
from simtip.errors import InputError, SimtipError
from simtip.rig_file import Format, rig_files
from simtip.scene_file import SceneFile, read_scene, scene_schema
from simtip.seeding import SEED_LIMIT
from simtip.triangulate import Method
from simtip.version import __version__

app = typer.Typer(
    name="simtip",
    help="Validate stereo needle-tip measurement on rendered images with known truth.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

# Typer brings its own copy of click, of which only the leaves are public.
ClickError: Any = next(
    kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException"
)

INTERRUPTED = 130
"""Exit code after SIGINT, as shells have it: 128 + 2."""

SceneArgument = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (YAML).")]
OutOption = Annotated[
    Path | None, typer.Option("-o", "--out", metavar="DIR", help="New or empty folder for results.")
]
SeedOption = Annotated[
    int | None,
    typer.Option(
        "--seed", min=0, max=SEED_LIMIT - 1, help="Root seed, instead of the scene's own."
    ),
]
BackendOption = Annotated[
    str | None,
    typer.Option("--backend", metavar="NAME", help="auto, cuda, llvm or scalar [default: auto]."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")]


@contextmanager
def located(scene: SceneFile) -> Iterator[None]:
    """Give an error about a scene's field its file and line."""
    try:
        yield
    except InputError as error:
        if error.file is None and error.field is not None and not error.field.startswith("-"):
            raise scene.error(error.problem, error.field, remedy=error.remedy) from error
        raise


@contextmanager
def _to_stdout() -> Iterator[None]:
    """Say in one line that standard output is full or closed; a reader that left is no error."""
    if sys.stdout is None:
        raise InputError("is closed", file="standard output", remedy="send it somewhere")
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        # What is still buffered would fail once more at exit, with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise InputError(
            f"cannot be written ({error.strerror})",
            file="standard output",
            remedy="free some space or send it elsewhere",
        ) from error


def _say(text: str) -> None:
    with _to_stdout():
        sys.stdout.write(text + "\n")


def _print_json(data: dict[str, Any]) -> None:
    _say(json.dumps(data, allow_nan=False))


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        _say(f"simtip {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        _say(context.get_help())
        raise typer.Exit(2)


@app.command()
def run(
    scene: SceneArgument,
    out: OutOption = None,
    seed: SeedOption = None,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Render a scene, measure the needle tip, score it against the truth."""
    from simtip.console import progress_bar, show_result
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose
    from simtip.result_folder import write_manifest, write_simulation, write_trial
    from simtip.trial import run_trial

    source = read_scene(scene)
    if out is not None:
        OutputFolder(out).check()
    chosen = choose(backend)
    with located(source), progress_bar("rendering") as progress:
        trial = run_trial(source.spec, seed=seed, backend=chosen, progress=progress)
    result = trial.to_dict()
    if out is not None:
        with result_folder(out) as folder:
            write_simulation(folder, trial.simulation)
            write_trial(folder, trial)
            write_manifest(folder, trial.simulation, result["timings_s"])
    if as_json:
        _print_json(result)
        return
    with _to_stdout():
        show_result(result)
    _say_where(out, "overlay.png, result.json")


@app.command()
def render(
    scene: SceneArgument,
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="DIR", help="New or empty folder for results.")
    ],
    seed: SeedOption = None,
    backend: BackendOption = None,
    exr: Annotated[
        bool, typer.Option("--exr", help="Also float radiance, needle coverage and depth.")
    ] = False,
    lights: Annotated[
        bool, typer.Option("--lights", help="Also every lamp's light, for `simtip remix`.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Render a scene's images and write its truth, without measuring."""
    from simtip.console import progress_bar
    from simtip.measuring_rig import measuring_rig
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.render import choose
    from simtip.result_folder import write_manifest, write_simulation
    from simtip.simulation import simulate

    source = read_scene(scene)
    measuring_rig(source.spec)  # the folder will hold it, too: refused before long work
    OutputFolder(out).check()
    chosen = choose(backend)
    with located(source), progress_bar("rendering") as progress:
        done = simulate(source.spec, seed=seed, backend=chosen, progress=progress)
    with result_folder(out) as folder:
        write_simulation(folder, done, exr=exr, lights=lights)
        write_manifest(folder, done, done.timings_s)
    if as_json:
        truth = done.truth.to_dict()
        facts = {"scene": source.spec.name, "seed": done.seed, "backend": done.backend.variant}
        _print_json({**facts, "out": str(out), "truth": truth, "timings_s": done.timings_s})
        return
    _say_where(out, "left.png, right.png, truth.json")


@app.command()
def remix(
    lights: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder that `simtip render --lights` wrote.")
    ],
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="DIR", help="New or empty folder for results.")
    ],
    scene: Annotated[
        Path | None,
        typer.Argument(
            metavar="SCENE", help="The scene with other lamp powers, colours, exposure or sensor."
        ),
    ] = None,
    seed: SeedOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make new images from rendered light, without rendering again."""
    from simtip.output_folder import OutputFolder, result_folder
    from simtip.remix import remix as mixed
    from simtip.result_folder import write_manifest, write_simulation

    source = None if scene is None else read_scene(scene)
    OutputFolder(out).check()
    with nullcontext() if source is None else located(source):
        done = mixed(lights, None if source is None else source.spec, seed=seed)
    with result_folder(out) as folder:
        write_simulation(folder, done)
        write_manifest(folder, done, done.timings_s)
    if as_json:
        facts = {"scene": done.spec.name, "seed": done.seed, "lights": str(lights)}
        truth = done.truth.to_dict()
        _print_json({**facts, "out": str(out), "truth": truth, "timings_s": done.timings_s})
        return
    _say_where(out, "left.png, right.png, truth.json")


@app.command()
def measure(
    left: Annotated[Path, typer.Argument(metavar="LEFT", help="Left image file.")],
    right: Annotated[Path, typer.Argument(metavar="RIGHT", help="Right image file.")],
    rig: Annotated[
        Path,
        typer.Option("--rig", metavar="RIG", help="OpenCV, JSON or Kalibr file, or a ROS pair."),
    ],
    detector: Annotated[str, typer.Option("--detector", metavar="NAME")] = "lin2020",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Detector parameter; repeatable."),
    ] = None,
    method: Annotated[
        Method, typer.Option("--method", help="How two rays become one point.")
    ] = "svd",
    max_distance_px: Annotated[
        float, typer.Option("--max-distance", metavar="PX", help="From the epipolar line.")
    ] = 2.0,
    as_json: JsonOption = False,
) -> None:
    """Measure the needle tip on a pair of image files of any origin."""
    from simtip.console import show_result
    from simtip.image_file import read_image
    from simtip.measure import measure_pair, require_size
    from simtip.rig_file import read_rig

    with _as_options():
        configured = configure(detector, _parse_settings(settings or []))
    if not max_distance_px > 0:
        raise InputError(
            f"{max_distance_px:g} px is no distance", field="--max-distance", remedy="give above 0"
        )
    image_left, image_right = read_image(left), read_image(right)
    cameras = read_rig(
        rig,
        (image_left.shape[1], image_left.shape[0]),
        (image_right.shape[1], image_right.shape[0]),
    )
    remedy = f"give the rig that took the images, not {rig}, or images of that size"
    require_size("left", image_left, cameras.left, file=left, remedy=remedy)
    require_size("right", image_right, cameras.right, file=right, remedy=remedy)
    with _as_options():
        measurement = measure_pair(
            image_left,
            image_right,
            cameras,
            configured,
            max_distance_px=max_distance_px,
            method=method,
        )
    names = {"rig": str(rig), "left": str(left), "right": str(right), "detector": detector}
    result = {**names, **measurement.to_dict()}
    if as_json:
        _print_json(result)
        return
    with _to_stdout():
        show_result(result)


@app.command()
def rig(
    scene: SceneArgument,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="FILE", help="Instead of stdout.")
    ] = None,
    form: Annotated[
        Format | None,
        typer.Option("--format", help="Of the file; by default what its ending says."),
    ] = None,
) -> None:
    """Export a scene's true rig in OpenCV's, ROS's, Kalibr's or simtip's JSON form."""
    from simtip.rig_file import rig_text, write_rig

    cameras = read_scene(scene).spec.rig.rig()
    if out is None:
        _say(rig_text(cameras, form or "opencv").rstrip("\n"))
        return
    _require_new(out, form)
    write_rig(out, cameras, form)


@app.command()
def boards(
    scene: SceneArgument,
    out: Annotated[
        Path,
        typer.Option("-o", "--out", metavar="DIR", help="New folder, or one begun before."),
    ],
    views: Annotated[
        int | None,
        typer.Option("--views", metavar="N", min=1, max=10_000, help="Instead of the scene's."),
    ] = None,
    target: Annotated[
        str | None,
        typer.Option("--target", metavar="TARGET", help="E.g. chessboard:11x8:6 (inner corners)."),
    ] = None,
    seed: SeedOption = None,
    backend: BackendOption = None,
    as_json: JsonOption = False,
) -> None:
    """Render calibration images with known truth: left_01.png, right_01.png, ..., truth.json.

    A run that was stopped goes on where it was.
    """
    from simtip.boards import plan_boards
    from simtip.boards_folder import check_folder, fill_folder
    from simtip.console import progress_bar
    from simtip.render import choose
    from simtip.target import parse_target

    source = read_scene(scene)
    wanted: dict[str, Any] = {} if views is None else {"views": views}
    if target is not None:
        with _as_option("--target"):
            wanted["target"] = str(parse_target(target))
    shown = source.spec.boards.model_copy(update=wanted)
    spec = source.spec.model_copy(update={"boards": shown})
    with located(source):
        plan = plan_boards(spec, seed=seed)
    check_folder(out, plan)
    chosen = choose(backend)
    try:
        with located(source), progress_bar("rendering boards") as progress:
            rendered, found = fill_folder(out, plan, backend=chosen, progress=progress)
    except KeyboardInterrupt:
        _fail(f"interrupted; the same command goes on with {out}", INTERRUPTED)
    if as_json:
        facts = {"scene": spec.name, "seed": plan.seed, "backend": chosen.variant}
        counts = {"views": len(plan.poses), "rendered": rendered, "found": found}
        _print_json({**facts, "out": str(out), "target": str(plan.plate.target), **counts})
        return
    _say(f"{rendered} views rendered, {found} were there")
    _say_where(out, "left_*.png, right_*.png, truth.json, rig_true.yaml")


@app.command()
def calibrate(
    images: Annotated[
        list[str],
        typer.Argument(
            metavar="DIR | LEFT RIGHT",
            help="Folder with left*, right* images, or a quoted pattern for each camera.",
        ),
    ],
    target: Annotated[
        str,
        typer.Option("--target", metavar="TARGET", help="E.g. chessboard:11x8:6 (inner corners)."),
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="FILE", help="New file for the rig.")
    ] = None,
    form: Annotated[
        Format | None,
        typer.Option("--format", help="Of that file; by default what its ending says."),
    ] = None,
    model: Annotated[
        str,
        typer.Option(
            "--model", metavar="NAME", help="none, radial2, radtan, opencv5, rational, auto."
        ),
    ] = "opencv5",
    truth: Annotated[
        Path | None,
        typer.Option("--truth", metavar="FILE", help="truth.json of `simtip boards`: errors, too."),
    ] = None,
    plots: Annotated[
        Path | None,
        typer.Option("--plots", metavar="DIR", help="New or empty folder for pictures."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Calibrate a stereo rig from images of a target, simtip's or any."""
    from simtip.calibrate.lens_model import lens_model
    from simtip.calibration_console import show_calibration
    from simtip.calibration_images import calibrate_images, read_board_truth
    from simtip.console import progress_bar
    from simtip.output_folder import OutputFolder
    from simtip.rig_file import write_rig
    from simtip.target import parse_target

    with _as_option("--target"):
        wanted = parse_target(target)
    with _as_option("--model"):
        lens_model(model)
    if out is not None:
        _require_new(out, form)
    elif form is not None:
        raise InputError(
            "says the form of a file, and none is asked for",
            field="--format",
            remedy="name it by -o",
        )
    if plots is not None:
        OutputFolder(plots).check()
    known = None if truth is None else read_board_truth(truth)
    with progress_bar("finding the target") as progress:
        outcome = calibrate_images(images, wanted, model=model, truth=known, report=progress)
    result = outcome.to_dict()
    if plots is not None:
        from simtip.report.calibration import calibration_plots

        with OutputFolder(plots) as folder:
            for name, picture in calibration_plots(outcome).items():
                (folder / name).write_bytes(picture)
    if out is not None:
        write_rig(out, outcome.calibration.rig, form)
    if as_json:
        _print_json(result)
        return
    with _to_stdout():
        show_calibration(result)
    _say_where(out, "the rig")
    _say_where(plots, "pictures")


@app.command()
def camera(
    scene: SceneArgument,
    side: Annotated[
        Literal["left", "right"], typer.Option("--side", help="Which of the two cameras.")
    ] = "left",
    seed: SeedOption = None,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Write the photon-transfer plot, PNG or SVG."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Measure a scene's own camera by EMVA 1288: configured against recovered."""
    from simtip.bench_camera import measure_scene_camera
    from simtip.console import progress_bar, show_camera
    from simtip.output_folder import check_new_file, write_atomically
    from simtip.report.photon_transfer import plot_photon_transfer

    source = read_scene(scene)
    if plot is not None:
        check_new_file(plot, endings=(".png", ".svg"))
    with located(source), progress_bar("measuring") as progress:
        result = measure_scene_camera(source.spec, side, seed=seed, progress=progress)
    if plot is not None:
        write_atomically(plot, plot_photon_transfer(result.recovered, plot.suffix[1:].lower()))
    if as_json:
        _print_json(result.to_dict())
        return
    show_camera(result.to_dict())


app.command()(bound)


@app.command()
def doctor(backend: BackendOption = None, as_json: JsonOption = False) -> None:
    """Say which renderers work on this machine, which is used, and how to mend the rest."""
    from simtip.console import show_diagnosis
    from simtip.doctor import diagnose
    from simtip.provenance import environment

    diagnosis = diagnose(backend)
    if as_json:
        _print_json({**environment(), **diagnosis.to_dict()})
    else:
        with _to_stdout():
            show_diagnosis(diagnosis, environment())
    if not diagnosis.ok:
        raise typer.Exit(1)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files, for completion in editors."""
    _say(json.dumps(scene_schema(), indent=2))


def _parse_settings(settings: list[str]) -> dict[str, object]:
    values: dict[str, object] = {}
    for setting in settings:
        key, equals, value = (part.strip() for part in setting.partition("="))
        if not equals or not key:
            raise InputError(
                f"{setting!r} is not KEY=VALUE", field="--set", remedy="write e.g. threshold=105"
            )
        values[key] = value
    return values


@contextmanager
def _as_options() -> Iterator[None]:
    """Give an error about a detector's parameter the name of the option, not of a scene's field."""
    try:
        yield
    except InputError as error:
        part, _, name = (error.field or "").partition(".")
        if part != FIELD_PREFIX:
            raise
        option = "--detector" if name == "name" else f"--set {name}"
        raise InputError(
            error.problem, file=error.file, field=option, remedy=error.remedy
        ) from error


@contextmanager
def _as_option(option: str) -> Iterator[None]:
    """Give an error about what an option says the option's name."""
    try:
        yield
    except InputError as error:
        raise InputError(
            error.problem, file=error.file, field=option, remedy=error.remedy
        ) from error


def _require_new(out: Path, form: Format | None) -> None:
    """Refuse a rig file that exists: it may be somebody's calibration."""
    for file in rig_files(out, form):
        if file.exists():
            raise InputError("exists", file=file, remedy="name another file or remove this one")
        if not file.parent.is_dir() and file.parent != out:
            raise InputError("its folder does not exist", file=file, remedy="make the folder first")


def _say_where(out: Path | None, what: str) -> None:
    if out is not None:
        _say(f"written to {out}: {what}")


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; user errors are one line on stderr and exit code 2."""
    try:
        code = app(arguments, prog_name="simtip", standalone_mode=False)
    except SimtipError as error:
        _fail(str(error), 2)
    except ClickError as error:
        _fail(_usage(error), 2)
    except (typer.Abort, KeyboardInterrupt):
        code = INTERRUPTED
    if code == INTERRUPTED:  # Typer, too, makes an interrupt this code
        _fail("interrupted; nothing was written", INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _usage(error: Any) -> str:
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "simtip"
    problem = error.format_message().replace("Value error, ", "").rstrip(".?")
    return f"{problem}; see `{command} --help`"


def _fail(message: str, code: int) -> NoReturn:
    # Names of files and keys may hold anything, such as codes that clear the terminal.
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in " ".join(message.split()))
    if sys.stderr is not None:
        sys.stderr.write(f"simtip: {line}\n")
    sys.exit(code)


if __name__ == "__main__":
    main()
