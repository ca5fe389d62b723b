"""`simtip run`: render, measure, score."""

from __future__ import annotations

from simtip.cli.errors import located
from simtip.cli.options import BackendOption, JsonOption, OutOption, SceneArgument, SeedOption
from simtip.cli.output import print_json, say_where, to_stdout
from simtip.scene_file import read_scene


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
        print_json(result)
        return
    with to_stdout():
        show_result(result)
    say_where(out, "overlay.png, result.json")
