"""Are light groups read back as they were written, and is anything else refused in one line?"""

from __future__ import annotations

import json

import numpy as np
import OpenEXR
import pytest
from regions import with_roi

from simtip.errors import InputError
from simtip.light_file import ATTRIBUTE, Lights, read_lights, write_lights
from simtip.render import render_pair


@pytest.fixture(scope="module")
def lights(scene) -> Lights:
    spec = with_roi(
        scene, [800, 850, 40, 50], [1010, 850, 20, 20], noise=None, samples=16, light_step_mm=2.0
    )
    left, _ = render_pair(spec, seed=3)
    return Lights(left, spec, 3, "left")


@pytest.fixture
def stored(lights, tmp_path):
    path = tmp_path / "left_lights.exr"
    write_lights(path, lights)
    return path


def test_everything_comes_back_bit_for_bit(lights, stored):
    found = read_lights(stored)
    assert (found.spec, found.seed, found.side) == (lights.spec, 3, "left")
    assert (found.view.lamps, found.view.backend) == (lights.view.lamps, lights.view.backend)
    for name in ("response", "coverage", "clutter", "depth_mm"):
        np.testing.assert_array_equal(getattr(found.view, name), getattr(lights.view, name))
    for name in ("open_sd", "pixels", "covariance", "samples"):
        np.testing.assert_array_equal(
            getattr(found.view.noise, name), getattr(lights.view.noise, name)
        )
    power = np.array([2.0, 1.0, 0.5])
    np.testing.assert_array_equal(found.view.noise.sd(power), lights.view.noise.sd(power))


def test_other_programs_find_the_layers_by_name(stored):
    with OpenEXR.File(str(stored), separate_channels=True) as file:
        names = set(file.channels())
    lamps = {f"lamp.{lamp}.{c}" for lamp in ("front", "rear") for c in "RGB"}
    assert names >= lamps | {"ambient.R", "mask.needle", "mask.clutter", "Z", "samples"}


def rewritten(path, change) -> None:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        header = {key: value for key, value in file.header().items() if key != "channels"}
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        change(header, channels)
        with OpenEXR.File(header, channels) as other:
            other.write(str(path))


def about(header, **changes):
    header[ATTRIBUTE] = json.dumps({**json.loads(header[ATTRIBUTE]), **changes})


HOSTILE = {
    "not ours": (lambda h, _: h.pop(ATTRIBUTE), "no light groups of format 1"),
    "no JSON": (lambda h, _: h.update({ATTRIBUTE: "{"}), "no light groups of format 1"),
    "another format": (lambda h, _: about(h, format=2), "no light groups of format 1"),
    "no groups": (lambda h, _: about(h, lamps=[]), "names no light groups"),
    "a group too many": (lambda h, _: about(h, lamps=["x", "ambient"]), "damaged"),
    "an impossible scene": (lambda h, _: about(h, scene={"seed": -1}), "damaged"),
    "no back end": (lambda h, _: about(h, backend="x"), "back end 'x' is unknown"),
    "a lost layer": (lambda _, c: c.pop("lamp.rear.G"), "lamp.rear.G"),
    "half floats": (
        lambda _, c: c.update({"Z": c["Z"].astype(np.float16)}),
        "channel Z is float16",
    ),
}


@pytest.mark.parametrize(("change", "said"), HOSTILE.values(), ids=HOSTILE)
def test_another_file_is_refused(stored, change, said):
    rewritten(stored, change)
    with pytest.raises(InputError, match=said) as caught:
        read_lights(stored)
    assert caught.value.file == str(stored)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kept", [0, 3, 40, 4000, -2000])
def test_a_cut_file_is_refused_quietly(stored, kept, capfd):
    stored.write_bytes(stored.read_bytes()[:kept])
    with pytest.raises(InputError, match="readable OpenEXR file"):
        read_lights(stored)
    assert capfd.readouterr() == ("", "")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_lights(tmp_path / "left_lights.exr")
