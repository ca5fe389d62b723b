"""Is a dithered detector the other one without its rounding to pixels, and nothing else?"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from simtip import detect
from simtip.camera import Camera
from simtip.detect import TipObservation, TipStatus, contract
from simtip.detect.dithered import ConfiguredDither, DitheredDetector, dithered_detector, shifts_px
from simtip.detect.function import function_detector
from simtip.detect.protocol import for_camera, for_region
from simtip.detect.shifted import continued, odd_length, shifted
from simtip.errors import InputError
from simtip.spec.scene import DetectSpec
from simtip.sweep import stage_keys
from simtip.sweep.detectors import Measuring
from simtip.trial import detector_of

SHIFT = np.array([0.3, -0.45])
CELLS = 8
"""Of a pixel, along each side, that the drawn needle is worked out at."""


def moved(image, shift=SHIFT):
    (one,) = shifted(image, [shift])
    return one


# The shift


WAVES = ((0.31, 0.05, 0.4, 9000), (-0.12, 0.41, 1.3, 7000), (0.01, -0.02, 2.0, 12000))
"""Cycles a pixel in u and v, phase, amplitude: close to what pixels can show, and slow ones."""


def waves(shape, shift=(0.0, 0.0)):
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    u, v = u - shift[0], v - shift[1]
    return 32000 + sum(a * np.sin(2 * np.pi * (f * u + g * v) + p) for f, g, p, a in WAVES)


@pytest.mark.parametrize("shape", [(200, 240), (151, 333)])
def test_what_is_band_limited_is_moved_as_it_should_be(shape):
    image = np.rint(waves(shape)).astype(np.uint16)
    expected = np.clip(waves(shape, SHIFT), image.min(), image.max())
    off = np.abs(moved(image) - expected)
    # Fast waves end at the border: their mirror images make kinks, which ring.
    assert off[30:-30, 30:-30].max() < 0.005 * 28000
    assert off[8:-8, 8:-8].max() < 0.02 * 28000


def test_colours_are_moved_one_by_one():
    planes = [np.rint(waves((90, 120)) / k).astype(np.uint16) for k in (1, 2, 3)]
    image = np.stack(planes, axis=-1)
    before = image.copy()
    seen = moved(image)
    assert np.array_equal(image, before)
    assert (seen.shape, seen.dtype) == (image.shape, image.dtype)
    for k, plane in enumerate(planes):
        expected = np.clip(moved(plane).astype(int), image.min(), image.max())
        inside = (expected > plane.min()) & (expected < plane.max())
        assert np.abs(seen[..., k].astype(int) - expected)[inside].max() <= 1


@pytest.mark.parametrize("shift", [(0.5, 0.5), (0.5, 0.0), (0.125, -0.375)])
def test_white_noise_keeps_its_variance(shift):
    noise = np.random.default_rng(1).normal(30000, 2000, (400, 500))
    image = np.rint(noise).astype(np.uint16)
    seen = moved(image, np.array(shift))[20:-20, 20:-20].astype(float)
    assert seen.var() == pytest.approx(image[20:-20, 20:-20].var(), rel=0.02)
    beside = (seen - seen.mean())[:, 1:] * (seen - seen.mean())[:, :-1]
    assert abs(beside.mean()) < 0.02 * seen.var()


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (50, 1), (2, 2), (3, 90, 3), (17, 16)])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_level_stays_that_level_in_any_shape(shape, dtype):
    for level in (0, 131, np.iinfo(dtype).max):
        image = np.full(shape, level, dtype)
        seen = moved(image)
        assert (seen.shape, seen.dtype) == (image.shape, image.dtype)
        assert (seen == level).all()


def test_nothing_gets_darker_or_brighter_than_the_image():
    """A sharp edge rings: over 12 bits it would be above white, below 0 it would come round."""
    image = np.zeros((60, 60), np.uint16)
    image[:, 30:] = 4095
    seen = moved(image)
    assert (seen.min(), seen.max()) == (0, 4095)
    assert (seen[:, :25] < 500).all()


def test_a_border_does_not_ring_into_the_image():
    """Bright on the left, dark on the right: wrapped around, both borders would be edges."""
    ramp = np.linspace(250, 5, 300)
    image = np.rint(np.tile(ramp, (200, 1))).astype(np.uint8)
    expected = np.tile(np.interp(np.arange(300) - SHIFT[0], np.arange(300), ramp), (200, 1))
    assert np.abs(moved(image) - expected).max() <= 1.1


def test_an_image_is_continued_by_its_mirror_images():
    samples = np.arange(40, dtype=np.float32)[None]
    length = odd_length(40)
    whole = continued(samples, length, 1)[0]
    assert length % 2 == 1
    assert length >= 64
    assert np.array_equal(whole[:40], samples[0])
    assert np.abs(np.diff(np.append(whole, whole[0]))).max() < 4
    assert whole[40] == pytest.approx(39, abs=0.2)
    assert whole[-1] == pytest.approx(0, abs=0.2)


@pytest.mark.parametrize("steps", range(1, 9))
def test_shifts_fill_a_pixel_in_two_ways(steps):
    shifts = shifts_px(steps)
    assert shifts.shape == (steps**2, 2)
    assert np.abs(shifts).max() < 0.5
    assert np.allclose(shifts.sum(axis=0), 0)
    fine = (np.arange(steps**2) + 0.5) / steps**2 - 0.5
    for axis in (0, 1):
        assert np.allclose(np.sort(shifts[:, axis]), fine)
    cells = np.floor((shifts + 0.5) * steps).astype(int)
    assert len({tuple(cell) for cell in cells}) == steps**2


# Needles drawn where they should be


@dataclass(frozen=True)
class Pin:
    """A cone on a slanted shaft that leaves the picture above."""

    tip: tuple[float, float] = (80.0, 150.0)
    degrees: float = 8.0
    width: float = 20.0
    point: float = 28.0
    shape: tuple[int, int] = (180, 160)
    sigma: float = 0.8

    def at(self, off):
        return Pin(tuple(np.add(self.tip, off)))

    def image(self, noise_dn=0.0, seed=0):
        """Cover fine cells by their distance from the outline, blur them, and add up pixels."""
        height, width = self.shape
        v, u = (np.arange(n * CELLS)[:, None] for n in (height, width))
        v, u = (v + 0.5) / CELLS - 0.5 - self.tip[1], (u.T + 0.5) / CELLS - 0.5 - self.tip[0]
        lean = np.radians(self.degrees)
        along = -u * np.sin(lean) - v * np.cos(lean)
        across = np.abs(u * np.cos(lean) - v * np.sin(lean))
        flank = np.arctan2(self.width / 2, self.point)
        inside = np.minimum(self.width / 2 - across, along * np.sin(flank) - across * np.cos(flank))
        covered = np.clip(0.5 + CELLS * inside, 0, 1).astype(np.float32)
        sigma = self.sigma * CELLS
        blurred = cv2.GaussianBlur(covered, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
        light = blurred.reshape(height, CELLS, width, CELLS).mean(axis=(1, 3))
        noise = np.random.default_rng([7, seed]).normal(0, noise_dn, self.shape)
        return np.clip(np.rint(200 - 165 * light + noise), 0, 255).astype(np.uint8)


SETTINGS = {"min_area_px": 500}


@pytest.fixture(scope="module")
def pixels():
    return detect.configure("lin2020", SETTINGS)


@pytest.fixture(scope="module")
def dithered():
    return detect.configure("dithered:lin2020", SETTINGS)


def errors(detector, offsets):
    """Tip seen less tip drawn, at every place, (n, 2)."""
    pins = [Pin().at(off) for off in offsets]
    return np.array([detector(pin.image()).tip_px - pin.tip for pin in pins])


@pytest.mark.slow
def test_the_error_of_pixels_is_gone_and_the_rest_stays(pixels, dithered):
    offsets = np.random.default_rng(3).uniform(-0.5, 0.5, (24, 2))
    on_pixels, without = errors(pixels, offsets), errors(dithered, offsets)
    # In v the answer is a row: the error is spread evenly over a pixel.
    v = on_pixels[:, 1] - on_pixels[:, 1].mean()
    assert v.std() == pytest.approx(1 / np.sqrt(12), rel=0.25)
    assert np.ptp(v) > 0.75
    assert np.ptp(on_pixels[:, 0]) > 0.4
    # 16 places in a pixel leave 0.025 px of it in u and 0.05 px in v.
    assert (without.std(axis=0) < [0.04, 0.065]).all()
    assert np.abs(without - without.mean(axis=0)).max() < 0.16
    # How far the cone recedes, some pixels, is the same.
    assert without[:, 1].mean() < -1
    assert np.allclose(without.mean(axis=0), on_pixels.mean(axis=0), atol=0.2)


@pytest.mark.slow
def test_many_shifts_leave_nothing_of_the_pixels():
    offsets = np.random.default_rng(5).uniform(-0.5, 0.5, (16, 2))
    seen = errors(detect.configure("dithered:lin2020", {**SETTINGS, "dither_steps": 8}), offsets)
    assert np.abs(seen - seen.mean(axis=0)).max() < 0.05


@pytest.mark.slow
def test_it_is_the_mean_over_scenes_that_are_really_moved(pixels, dithered):
    order = np.arange(16)
    places = np.stack([order, order * 7 % 16], axis=-1) / 16 - 15 / 32
    mean = errors(pixels, places).mean(axis=0)
    one = errors(dithered, [(0.21, -0.34)])[0]
    assert one == pytest.approx(mean, abs=0.05)
    assert np.abs(errors(pixels, [(0.21, -0.34)])[0] - mean).max() > 0.1


@pytest.mark.slow
def test_finer_steps_leave_less_of_the_pixels():
    offsets = np.random.default_rng(4).uniform(-0.5, 0.5, (12, 2))
    spread = []
    for steps in (1, 2, 4):
        values = {**SETTINGS, "dither_steps": steps}
        seen = errors(detect.configure("dithered:lin2020", values), offsets)
        spread.append(seen[:, 1].std())
    assert spread[0] > 2 * spread[1] > 4 * spread[2]


def test_one_step_is_the_other_detector(pixels):
    image = Pin().image(noise_dn=2)
    one = detect.configure("dithered:lin2020", {**SETTINGS, "dither_steps": "1"})(image)
    assert one.tip_px.tolist() == pixels(image).tip_px.tolist()


def test_a_detector_between_pixels_answers_as_before():
    image = Pin((80.37, 150.21)).image(noise_dn=1.0)
    before = detect.configure("subpixel")(image)
    seen = detect.configure("dithered:subpixel", {"dither_steps": 2})(image)
    assert seen.tip_px == pytest.approx(before.tip_px, abs=0.01)
    assert seen.axis_px == pytest.approx(before.axis_px, abs=1e-3)
    assert seen.covariance_px.tolist() == before.covariance_px.tolist()


# What is made of the answers


class Recorded:
    """Answers in turn, and what it was told."""

    def __init__(self, *answers):
        self.answers, self.asked, self.told = list(answers), [], []

    def __call__(self, image, *, layers=False):
        self.asked.append((image, layers))
        return self.answers[min(len(self.asked), len(self.answers)) - 1]

    def for_camera(self, camera):
        self.told.append(camera)
        return self

    def for_region(self, u0, v0, shape):
        self.told.append((u0, v0, shape))
        return self


IMAGE = np.tile(np.arange(40, 80, dtype=np.uint8), (50, 1))
LOST = TipObservation.failed(TipStatus.NO_EDGE, "Canny finds no edge")


def tip(u=20.0, v=30.0, **more):
    return TipObservation.found((u, v), **more)


def test_shifts_are_subtracted_and_the_axis_is_a_mean():
    first = tip(axis_px=(0, -1), covariance_px=np.eye(2), confidence=0.5, layers={"gray": IMAGE})
    inner = Recorded(first, *[tip(axis_px=(0.6, -0.8)), tip(axis_px=(-0.6, -0.8))] * 2)
    seen = ConfiguredDither(inner, 2)(IMAGE, layers=True)
    assert seen.tip_px == pytest.approx([20, 30], abs=1e-12)
    assert seen.axis_px == pytest.approx([0, -1], abs=1e-12)
    assert seen.covariance_px.tolist() == np.eye(2).tolist()
    assert (seen.confidence, list(seen.layers)) == (0.5, ["gray"])
    assert [layers for _, layers in inner.asked] == [True, False, False, False, False]
    assert inner.asked[0][0] is IMAGE
    one = ConfiguredDither(Recorded(first, tip(), LOST, LOST, LOST), 2)
    assert not one(IMAGE).ok


def centre(image, *, layers=False):
    """Give the centre of darkness: exact between pixels."""
    del layers
    v, u = np.indices(image.shape)
    dark = 200.0 - image
    return tip(*(np.sum(dark * x) / dark.sum() for x in (u, v)))


def test_the_picture_moves_by_the_shift_that_is_subtracted():
    """Where a shift's answer is missing, too, of which the sum over all is 0."""
    v, u = np.mgrid[:50, :40]
    blob = 200 - 150 * np.exp(-((u - 20.3) ** 2 + (v - 24.6) ** 2) / 18)
    image = np.rint(blob).astype(np.uint8)
    asked = iter(range(17))

    def some(one, *, layers=False):
        return LOST if next(asked) in {1, 2, 4} else centre(one, layers=layers)

    seen = ConfiguredDither(some, 4)(image)
    assert seen.tip_px == pytest.approx([20.3, 24.6], abs=0.01)


def test_a_failure_in_the_image_as_it_is_stays():
    inner = Recorded(LOST, tip())
    assert ConfiguredDither(inner, 4)(IMAGE) is LOST
    assert len(inner.asked) == 1


def test_three_of_four_tips_are_enough():
    answers = [tip(), *[LOST] * 4, *[tip()] * 12]
    seen = ConfiguredDither(Recorded(*answers), 4)(IMAGE)
    assert seen.tip_px == pytest.approx(20 - shifts_px(4)[4:].mean(axis=0) + [0, 10], abs=1e-12)
    answers[5] = LOST
    seen = ConfiguredDither(Recorded(*answers), 4)(IMAGE)
    assert seen.status is TipStatus.NO_EDGE
    assert seen.reason.startswith("Canny finds no edge [the tip was found again in 11 of 16 ")


def test_a_mean_does_not_lie_between_two_things():
    far = tip(20, 200)
    seen = ConfiguredDither(Recorded(tip(), *[far] * 3, *[tip()] * 13), 4)(IMAGE)
    assert seen.tip_px[1] == pytest.approx(30, abs=0.5)
    seen = ConfiguredDither(Recorded(tip(), *[far] * 8, *[tip()] * 8), 4)(IMAGE)
    assert seen.status is TipStatus.NOT_FOUND
    assert "in 8 of 16" in seen.reason
    assert "more than 20 px away" in seen.reason


def test_opposite_axes_leave_the_first():
    up, down = tip(axis_px=(0, -1)), tip(axis_px=(0, 1))
    seen = ConfiguredDither(Recorded(up, up, down, up, down), 2)(IMAGE)
    assert seen.axis_px.tolist() == [0, -1]
    assert ConfiguredDither(Recorded(tip()), 2)(IMAGE).axis_px is None


def test_camera_and_region_are_passed_on():
    inner = Recorded(tip())
    camera = Camera(np.array([[900.0, 0, 20], [0, 900, 25], [0, 0, 1]]), 40, 50)
    told = for_region(for_camera(ConfiguredDither(inner, 2), camera), 3, 4, (90, 80))
    assert inner.told == [camera, (3, 4, (90, 80))]
    assert told(IMAGE).ok


# The reference


@pytest.mark.slow
def test_it_keeps_the_contract():
    result = contract.check("dithered:lin2020", {"dither_steps": 2})
    assert result.ok, [r for r in result.results if r.outcome is contract.Outcome.FAILED]
    failed = {r.name for r in result.results if r.outcome is contract.Outcome.FAILED}
    assert failed == {"at any angle", "no tip in a disc or a cable"}


def test_it_has_the_others_parameters_and_its_own():
    declared = detect.parameters_of("dithered:lin2020")
    assert declared[:-1] == detect.parameters_of("lin2020")
    assert (declared[-1].name, declared[-1].type, declared[-1].default) == (
        "dither_steps",
        "int",
        4,
    )
    detector = detect.get("dithered:lin2020")
    assert detector.name == "dithered:lin2020"
    assert detect.get("lin2020").summary in detector.summary
    image = Pin().image()
    seen = detector(image, dither_steps=2, **SETTINGS)
    values = {**SETTINGS, "dither_steps": 2}
    assert seen.tip_px.tolist() == detect.configure(detector.name, values)(image).tip_px.tolist()


BAD = {
    "no other": ("dithered:", {}, r"no detector after dithered:"),
    "unknown": ("dithered:lin2021", {}, r"no detector 'lin2021'; did you mean 'lin2020'\?"),
    "twice": ("dithered:dithered:lin2020", {}, "dithered twice"),
    "no module": ("dithered:nowhere:find", {}, "there is no module 'nowhere'"),
    "no command": ("dithered:cmd:", {}, "there is no command after cmd:"),
    "too fine": ("dithered:lin2020", {"dither_steps": 9}, r"detect\.dither_steps: .*9"),
    "none": ("dithered:lin2020", {"dither_steps": 0}, r"detect\.dither_steps: "),
    "misspelt": ("dithered:lin2020", {"dither_step": 2}, "did you mean 'dither_steps'"),
    "of the other": ("dithered:lin2020", {"threshold": 300}, r"detect\.threshold: "),
}


@pytest.mark.parametrize(("reference", "values", "said"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_said_in_one_line(reference, values, said):
    with pytest.raises(InputError, match=said) as caught:
        detect.configure(reference, values)
    assert "\n" not in str(caught.value)


def test_a_parameter_of_the_same_name_is_refused():
    def find(image, dither_steps: int = 3):
        del image, dither_steps

    inner = function_detector("mine", find)
    with pytest.raises(InputError, match="mine has a parameter 'dither_steps' itself"):
        dithered_detector("dithered:mine", inner)


CODE = ("cmd:./mine {image}", "mine:find")


@pytest.mark.parametrize("reference", [*CODE, f"dithered:{CODE[0]}", f"dithered:{CODE[1]}"])
def test_no_scene_starts_code_by_dithering_it(reference, small_scene):
    assert detect.names_code(f"dithered:{reference}")
    spec = small_scene.model_copy(update={"detect": DetectSpec(name=f"dithered:{reference}")})
    # Nor does leave for the one mean leave for the other.
    for allowed in (None, reference, "dithered:", "dithered:lin2020"):
        with pytest.raises(InputError, match="a scene may not start a program"):
            detector_of(spec, allowed=allowed)


def test_what_is_allowed_runs(small_scene, tmp_path, monkeypatch):
    (tmp_path / "ditherable.py").write_text("def find(image): return (4, 5)\n")
    monkeypatch.chdir(tmp_path)
    name = "dithered:ditherable:find"
    spec = small_scene.model_copy(update={"detect": DetectSpec(name=name)})
    assert detector_of(spec, allowed=name)(IMAGE).tip_px == pytest.approx([4, 5], abs=1e-9)
    assert detect.listing(name).source == "module"


def test_a_scene_may_dither_what_is_built_in(small_scene):
    assert not detect.names_code("dithered:lin2020")
    spec = small_scene.model_copy(update={"detect": DetectSpec(name="dithered:lin2020")})
    assert isinstance(detector_of(spec), ConfiguredDither)
    found = detect.listing("dithered:lin2020")
    assert (found.name, found.source) == ("dithered:lin2020", "built in")
    assert isinstance(found.detector, DitheredDetector)
    assert "dithered:lin2020" not in detect.names()


def test_a_sweep_knows_whose_code_it_is(tmp_path, monkeypatch):
    assert Measuring("a", "dithered:lin2020", {}).is_own
    assert not any(Measuring("a", f"dithered:{code}", {}).is_own for code in CODE)
    (tmp_path / "dithered.py").write_text("")
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "othermine.py").write_text("def find(image): ...\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.syspath_prepend(tmp_path / "sub")
    code = stage_keys.detector_code
    assert code("dithered:lin2020") == ""
    assert code("dithered:cmd:./mine {image}") is None
    assert code("dithered:othermine:find") == code("othermine:find") is not None
