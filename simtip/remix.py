"""New pictures from rendered light: other powers, colours, exposures, sensors; no rendering."""

from __future__ import annotations

from pathlib import Path

from simtip.errors import InputError
from simtip.light_file import Lights, lights_name, read_lights
from simtip.light_inputs import first_difference
from simtip.render.backend import VARIANTS, Backend, Name
from simtip.simulation import Simulation, expose_pair
from simtip.spec import SceneSpec


def read_pair(folder: Path) -> tuple[Lights, Lights]:
    """Read both views' light groups from a folder of `simtip render --lights`.

    Raises
    ------
    InputError
        A file is missing or unusable, or the two are not of one scene.
    """
    left, right = (read_lights(folder / lights_name(side)) for side in ("left", "right"))
    for lights, side in ((left, "left"), (right, "right")):
        if lights.side != side:
            raise InputError(
                f"holds the {lights.side} view",
                file=folder / lights_name(side),
                remedy="left and right are swapped: rename them",
            )
    if left.spec != right.spec or left.seed != right.seed:
        raise InputError(
            "is of another scene or seed than the left view",
            file=folder / lights_name("right"),
            remedy="take both from one folder",
        )
    return left, right


def remix(folder: Path, spec: SceneSpec | None = None, *, seed: int | None = None) -> Simulation:
    """Expose the sensors to rendered light again.

    Parameters
    ----------
    folder
        Where `simtip render --lights` wrote.
    spec
        The scene as it is to be: what the light depends on (`simtip.light_inputs`) has to be as it
        was. By default the scene as it was rendered.
    seed
        Of the sensors' noise; by default the one it was rendered with.

    Raises
    ------
    InputError
        Files are missing or unusable; or, with `field`, the scene would have to be rendered again.
    """
    left, right = read_pair(folder)
    wanted = left.spec if spec is None else spec
    seeded = wanted.model_copy(update={"seed": left.spec.seed})
    field = first_difference(left.spec, seeded)
    if field is not None:
        raise InputError(
            f"differs from the scene whose light is in {folder}, and the light depends on it",
            field=field,
            remedy="render the scene anew with `simtip render --lights`",
        )
    names: dict[str, Name] = {variant: name for name, variant in VARIANTS.items()}
    backend = Backend(names[left.view.backend], f"light groups read from {folder}")
    chosen = left.seed if seed is None else seed
    views = left.view, right.view
    return expose_pair(wanted, views, seed=chosen, backend=backend, light_seed=left.seed)
