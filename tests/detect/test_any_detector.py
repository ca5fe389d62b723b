"""What every registered detector has to do, whatever its method."""

import numpy as np
import pytest

from simtip import detect
from simtip.errors import InputError

NAMES = detect.names()


def needle(dtype=np.uint8, *, colour=False):
    image = np.full((400, 300), 180, np.uint8)
    image[0:300, 100:121] = 40
    if dtype == np.uint16:
        image = image.astype(np.uint16) * 257
    return np.stack([image] * 3, axis=-1) if colour else image


@pytest.fixture(params=NAMES)
def name(request):
    return request.param


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_it_finds_a_plain_needle_to_two_pixels_in_every_kind_of_image(name, dtype, colour):
    observation = detect.configure(name)(needle(dtype, colour=colour))
    assert observation.ok, observation.reason
    assert observation.tip_px == pytest.approx([110, 299], abs=2)


def test_memory_layout_changes_nothing_and_the_image_stays_as_it_was(name):
    run = detect.configure(name)
    plain = needle(colour=True)
    expected = run(plain).tip_px
    reversed_twice = np.ascontiguousarray(plain[:, ::-1])[:, ::-1]
    strided = np.repeat(np.repeat(plain, 2, axis=0), 2, axis=1)[::2, ::2]
    fortran = np.asfortranarray(plain)
    frozen = plain.copy()
    frozen.setflags(write=False)
    for image in (reversed_twice, strided, fortran, frozen):
        before = image.copy()
        assert np.array_equal(run(image).tip_px, expected)
        assert np.array_equal(image, before)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (7, 1), (2, 2), (3, 3, 3), (64, 64)])
@pytest.mark.parametrize("value", [0, 255])
def test_an_image_without_content_is_a_failure_with_a_reason(name, shape, value):
    observation = detect.configure(name)(np.full(shape, value, np.uint8))
    assert not observation.ok
    assert observation.reason
    assert observation.tip_px is None


def test_noise_alone_is_no_exception(name):
    rng = np.random.default_rng(3)
    for shape in [(5, 9), (40, 31), (33, 64, 3)]:
        observation = detect.configure(name)(rng.integers(0, 256, shape, dtype=np.uint8))
        assert observation.ok == (observation.tip_px is not None)


def test_what_is_no_image_is_an_input_error(name):
    run = detect.configure(name)
    for image in (np.zeros((4, 4)), np.zeros((4, 4, 2), np.uint8), np.zeros((0, 3), np.uint8)):
        with pytest.raises(InputError):
            run(image)


def test_its_parameters_are_declared_and_their_defaults_are_accepted(name):
    declared = detect.parameters_of(name)
    assert declared
    for parameter in declared:
        assert parameter.description
        assert parameter.type
    values = {p.name: p.default for p in declared}
    as_text = {
        n: ",".join(map(str, v)) if isinstance(v, tuple) else str(v) for n, v in values.items()
    }
    tips = [detect.configure(name, v)(needle()).tip_px.tolist() for v in ({}, values, as_text)]
    assert tips[0] == tips[1] == tips[2]


def test_calling_it_is_configuring_and_running_it(name):
    detector = detect.get(name)
    assert detector.name == name
    assert detector.summary
    observation = detector(needle(), layers=True)
    assert observation.layers
    assert observation.tip_px.tolist() == detect.configure(name)(needle()).tip_px.tolist()
