"""Are light groups read back as they were written, and is anything else refused in one line?"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from regions import with_roi

from simtip.errors import InputError
from simtip.light_file import ATTRIBUTE, Lights, read_lights, write_lights
from simtip.light_file.layers import to_parts, to_view
from simtip.render import View, render_pair
from simtip.render.noise import Noise
from simtip.render.threads import limited_threads


@pytest.fixture(scope="module")
def lights(scene) -> Lights:
    spec = with_roi(
        scene, [800, 850, 40, 50], [1010, 850, 20, 20], noise=None, samples=16, light_step_mm=2.0
    )
    left, _ = render_pair(spec, seed=3)
    return Lights(left, spec, 3, "left")


@pytest.fixture(scope="module")
def whole(lights, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("lights") / "left_lights.exr"
    write_lights(path, lights)
    return path.read_bytes()


@pytest.fixture
def stored(whole, tmp_path):
    path = tmp_path / "left_lights.exr"
    path.write_bytes(whole)
    return path


def assert_equal(found: View, view: View) -> None:
    assert (found.lamps, found.backend) == (view.lamps, view.backend)
    for name in ("response", "coverage", "clutter", "depth_mm"):
        np.testing.assert_array_equal(getattr(found, name), getattr(view, name))
    for name in ("open_sd", "pixels", "covariance", "samples"):
        one, other = getattr(found.noise, name), getattr(view.noise, name)
        np.testing.assert_array_equal(one, other)
        assert one.dtype == other.dtype


def test_everything_comes_back_bit_for_bit(lights, stored):
    found = read_lights(stored)
    assert (found.spec, found.seed, found.side) == (lights.spec, 3, "left")
    assert len(found.view.noise.pixels) > 20
    assert_equal(found.view, lights.view)
    power = np.array([2.0, 1.0, 0.5])
    np.testing.assert_array_equal(found.view.noise.sd(power), lights.view.noise.sd(power))


def test_a_view_with_no_pixel_sampled_on_its_own_comes_back(lights, tmp_path):
    noise = lights.view.noise
    none = Noise(noise.open_sd, noise.pixels[:0], noise.covariance[:0], noise.samples[:0])
    view = replace(lights.view, noise=none)
    write_lights(tmp_path / "x.exr", replace(lights, view=view))
    assert_equal(read_lights(tmp_path / "x.exr").view, view)


@given(st.integers(1, 7), st.integers(1, 7), st.integers(1, 3), st.data())
@settings(derandomize=True, deadline=None, max_examples=60)
def test_sampled_pixels_keep_their_places_wherever_they_are(height, width, groups, data):
    places = data.draw(st.sets(st.integers(0, height * width - 1)))
    pixels = np.array(sorted(places), np.uint32)
    rng = np.random.default_rng(len(places))
    half = rng.random((len(pixels), groups, groups), np.float32)
    view = View(
        lamps=(*(f"l{k}" for k in range(groups - 1)), "ambient"),
        response=rng.random((groups, height, width, 3), np.float32),
        coverage=rng.random((height, width), np.float32),
        clutter=rng.random((height, width), np.float32),
        depth_mm=rng.random((height, width), np.float32),
        noise=Noise(
            rng.random((groups, height, width), np.float32),
            pixels,
            half + half.transpose(0, 2, 1),
            rng.integers(1, 4096, len(pixels), np.uint32),
        ),
        backend="llvm_ad_rgb",
    )
    assert_equal(to_view(to_parts(view), view.lamps, view.backend), view)


def test_other_programs_find_the_layers_by_name(lights, stored):
    with OpenEXR.File(str(stored), separate_channels=True) as file:
        parts = {part.name(): set(file.channels(k)) for k, part in enumerate(file.parts)}
        low, high = file.header(3)["dataWindow"]
        samples = file.channels(3)["samples"].pixels
    lamps = {f"lamp.{lamp}.{c}" for lamp in ("front", "rear") for c in "RGB"}
    assert parts["light"] == lamps | {f"ambient.{c}" for c in "RGB"}
    assert parts["scene"] == {"mask.needle", "mask.clutter", "Z"}
    assert parts["noise"] == {"noise.front", "noise.rear", "noise.ambient"}
    # The window lies where the samples were taken.
    rows, columns = np.divmod(lights.view.noise.pixels.astype(int), 40)
    assert (tuple(low), tuple(high)) == (
        (columns.min(), rows.min()),
        (columns.max(), rows.max()),
    )
    np.testing.assert_array_equal(
        samples[rows - low[1], columns - low[0]], lights.view.noise.samples
    )


def test_mitsubas_own_reader_sees_the_light(lights, stored):
    import mitsuba as mi

    with limited_threads(2):  # it hands its work to another thread, and waits for it
        bitmap = mi.Bitmap(str(stored))
    names = [field.name for field in bitmap.struct_()]
    pixels = np.array(bitmap)
    for k, lamp in enumerate(("lamp.front", "lamp.rear", "ambient")):
        for c, colour in enumerate("RGB"):
            seen = pixels[..., names.index(f"{lamp}.{colour}")]
            np.testing.assert_array_equal(seen, lights.view.response[k, ..., c])


def rewritten(path, change) -> None:
    """Write the file anew, as another program would; `change` gets (header, channels) by part."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        parts = {}
        for k, part in enumerate(file.parts):
            header = {key: value for key, value in file.header(k).items() if key != "channels"}
            channels = {name: c.pixels for name, c in file.channels(k).items()}
            parts[part.name()] = header, channels
        change(parts)
        made = [OpenEXR.Part(header, c, name) for name, (header, c) in parts.items()]
        with OpenEXR.File(made) as other:
            other.write(str(path))


def compressed(how):
    def change(parts):
        for header, _ in parts.values():
            header["compression"] = how

    return change


@pytest.mark.parametrize("how", ["ZIPS", "ZIP", "PIZ"])
def test_packed_by_another_program_it_is_the_same(lights, stored, how):
    size = stored.stat().st_size
    rewritten(stored, compressed(getattr(OpenEXR, f"{how}_COMPRESSION")))
    assert stored.stat().st_size < size
    assert_equal(read_lights(stored).view, lights.view)


def about(**changes):
    def change(parts):
        header = parts["light"][0]
        header[ATTRIBUTE] = json.dumps({**json.loads(header[ATTRIBUTE]), **changes})

    return change


def layer(part, name, made):
    def change(parts):
        channels = parts[part][1]
        channels[name] = made(channels[name])

    return change


def one_bit(pixels):
    changed = pixels.copy()
    changed.view(np.uint32)[3, 4] ^= 1
    return changed


def moved(parts):
    low, high = parts["sampled"][0]["dataWindow"]
    parts["sampled"][0]["dataWindow"] = low - np.int32(100), high - np.int32(100)


HOSTILE = {
    "not ours": (lambda p: p["light"][0].pop(ATTRIBUTE), "holds no light groups"),
    "no JSON": (lambda p: p["light"][0].update({ATTRIBUTE: "{"}), "holds no light groups"),
    "another format": (about(format=3), "is a light file of format 3"),
    "the first format": (about(format=1), "of format 1.*render the scene anew"),
    "no groups": (about(lamps=[]), "names no light groups"),
    "a group too many": (about(lamps=["x", "ambient"]), "damaged.*lamp.x.R is missing"),
    "an impossible scene": (about(scene={"seed": -1}), "damaged"),
    "an endless seed": (about(seed=float("inf")), "damaged"),
    "no back end": (about(backend="x"), "back end 'x' is unknown"),
    "no checksums": (about(crc32=[]), "is not as it was written"),
    "a lost layer": (lambda p: p["light"][1].pop("lamp.rear.G"), "lamp.rear.G is missing"),
    "a lost part": (lambda p: p.pop("noise"), "part noise is missing"),
    "a moved part": (moved, "part sampled leaves the frame"),
    "half floats": (layer("scene", "Z", np.float16), "channel Z is float16"),
    "one bit": (layer("light", "lamp.rear.G", one_bit), "lamp.rear.G is not as it was written"),
    "a smaller part": (
        lambda p: [
            p["noise"][0].update(dataWindow=(np.zeros(2, np.int32), np.array([38, 49], np.int32))),
            p["noise"][1].update({k: v[:, 1:].copy() for k, v in p["noise"][1].items()}),
        ],
        "part noise does not fill the frame",
    ),
    "lossy compression": (compressed(OpenEXR.PXR24_COMPRESSION), "is not as it was written"),
}


@pytest.mark.parametrize(("change", "said"), HOSTILE.values(), ids=HOSTILE)
def test_another_file_is_refused(stored, change, said):
    rewritten(stored, change)
    with pytest.raises(InputError, match=said) as caught:
        read_lights(stored)
    assert caught.value.file == str(stored)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kept", [0, 3, 40, 4000, -2000, -1])
def test_a_cut_file_is_refused_quietly(stored, kept, capfd):
    stored.write_bytes(stored.read_bytes()[:kept])
    with pytest.raises(InputError, match="readable OpenEXR file"):
        read_lights(stored)
    assert capfd.readouterr() == ("", "")


def read_or_said(path) -> Lights | str:
    try:
        return read_lights(path)
    except InputError as error:
        return str(error)


HEADERS = 9000  # bytes, and more


@pytest.mark.slow
@given(st.floats(0, 1, exclude_max=True) | st.integers(0, HEADERS), st.integers(0, 7))
@settings(
    derandomize=True,
    deadline=None,
    max_examples=100,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_no_flipped_bit_changes_the_light_unseen(lights, whole, stored, place, bit):
    damaged = bytearray(whole)
    damaged[place if isinstance(place, int) else int(place * len(damaged))] ^= 1 << bit
    stored.write_bytes(damaged)
    found = read_or_said(stored)
    if isinstance(found, str):
        assert "\n" not in found
        return
    for name in ("response", "coverage", "clutter", "depth_mm"):
        np.testing.assert_array_equal(getattr(found.view, name), getattr(lights.view, name))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_lights(tmp_path / "left_lights.exr")
