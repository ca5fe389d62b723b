"""Is a plain function a detector, whatever it declares, gives, raises or does to the image?"""

from __future__ import annotations

import functools
from typing import Annotated, Literal

import numpy as np
import pytest
from programs import GRAY

from simtip import detect
from simtip.detect.adopted import adopted
from simtip.detect.parameters import Declared
from simtip.errors import InputError


def of(function, values=(), image=GRAY, **more):
    return adopted("mine", function).configure(dict(values))(image, **more)


def declared(
    image,
    /,
    window: int = 5,
    *,
    gain: Annotated[float, Declared("of the edge", minimum=0, maximum=9)] = 1.5,
    polarity: Annotated[Literal["dark", "bright"], "of the needle"] = "dark",
    limit: int | None = None,
    weights: tuple[float, float] = (0.5, 0.5),
    fine: bool = False,
    label: str = "a",
    guessed=2.5,
    needed: float,
    layers: bool = False,
    **rest: object,
):
    """Say what arrived.

    More is not in the summary.
    """
    assert image.ndim == 2
    text = repr([window, gain, polarity, limit, weights, fine, label, guessed, needed, layers])
    return {"reason": text + repr(rest)}


# As if imported for type checkers only.
declared.__annotations__["image"] = "UnknownHere"


def test_a_signature_declares_the_parameters():
    detector = adopted("mine", declared)
    assert detector.summary == "Say what arrived."
    listed = {p.name: (p.type, p.default, p.required) for p in detector.parameters}
    assert listed == {
        "window": ("int", 5, False),
        "gain": ("float", 1.5, False),
        "polarity": ("dark | bright", "dark", False),
        "limit": ("int | none", None, False),
        "weights": ("2 x float", (0.5, 0.5), False),
        "fine": ("bool", False, False),
        "label": ("text", "a", False),
        "guessed": ("float", 2.5, False),
        "needed": ("float", None, True),
    }
    described = {p.name: p.description for p in detector.parameters}
    assert (described["gain"], described["polarity"]) == ("of the edge", "of the needle")


def test_text_from_a_command_line_becomes_the_declared_types():
    values = {
        "window": "7",
        "gain": "2",
        "polarity": "bright",
        "limit": "none",
        "weights": "1,0",
        "fine": "true",
        "label": "7",
        "guessed": "1",
        "needed": "3",
    }
    o = of(declared, values, layers=True)
    assert o.reason == "[7, 2.0, 'bright', None, (1.0, 0.0), True, '7', 1.0, 3.0, True]{}"
    assert of(declared, {"needed": 1}).reason.endswith("2.5, 1.0, False]{}")


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({}, "detect.needed: has no value"),
        ({"needed": 1, "gian": 1}, "did you mean 'gain'"),
        ({"needed": 1, "gain": 10}, "at most 9: of the edge"),
        ({"needed": 1, "window": "x"}, "not a whole number"),
        ({"needed": 1, "layers": "true"}, "no parameter 'layers'"),
    ],
)
def test_a_value_that_does_not_fit_is_an_input_error(values, problem):
    with pytest.raises(InputError) as caught:
        adopted("mine", declared).configure(values)
    assert problem in str(caught.value)


def takes_nothing():
    return None


def takes_an_array(image, mask: np.ndarray = GRAY):
    return None if mask is image else (1, 1)


def takes_a_secret(image, key):
    return image, key


def takes_a_name(image, name="x"):
    return image, name


def takes_what_is_unknown(image, model=None):
    return image, model


takes_what_is_unknown.__annotations__["model"] = "UnknownHere"


@pytest.mark.parametrize(
    ("found", "problem"),
    [
        (takes_nothing, "takes no image"),
        (takes_an_array, "'mask' of no type that a text can give"),
        (takes_a_secret, "'key' of no type"),
        (takes_a_name, "'name'"),
        (takes_what_is_unknown, "annotation cannot be read"),
        (dict, "is a class"),
        (7, "of the type int"),
        (None, "of the type NoneType"),
    ],
)
def test_what_is_no_detector_is_an_input_error(found, problem):
    with pytest.raises(InputError) as caught:
        adopted("mine", found)
    assert problem in str(caught.value)
    assert caught.value.remedy


class Instance:
    """A detector with a state."""

    def __call__(self, image, shift: float = 0.0):
        return (1 + shift, image.ndim)


def test_instances_methods_and_partial_functions_will_do():
    for function in (Instance(), Instance().__call__, functools.partial(Instance(), shift=1)):
        assert of(function, {"shift": "2"}).tip_px.tolist() == [3, 2]
    assert of(lambda image: (image.shape[1], 0)).tip_px.tolist() == [20, 0]


GIVEN = {
    "a tuple": ((3, 4), "ok"),
    "an array": (np.array([3, 4]), "ok"),
    "unsigned 64 bit": (np.array([3, 4], np.uint64), "ok"),
    "a dict": ({"tip_px": np.float32([3, 4])}, "ok"),
    "an observation": (detect.TipObservation.found((3, 4)), "ok"),
    "a line as covariance": ({"tip_px": (3, 4), "covariance_px": [[1, 3], [3, 9]]}, "ok"),
    "none": (None, "not_found"),
    "text": ("here", "invalid_output"),
    "truth": (True, "invalid_output"),
    "complex": (np.array([3j, 4]), "invalid_output"),
    "objects": (np.array([3, None]), "invalid_output"),
    "nan": ((float("nan"), 4), "invalid_output"),
    "far away": ((1e300, 4), "invalid_output"),
    "a column": (np.ones((2, 1)), "invalid_output"),
    "a huge axis": ({"tip_px": (3, 4), "axis_px": (1e300, 1e300)}, "invalid_output"),
}


@pytest.mark.parametrize(("given", "status"), GIVEN.values(), ids=GIVEN)
def test_what_it_gives_is_checked(given, status):
    o = of(lambda image: given if image.size else None)
    assert o.status == status, o.reason
    assert o.ok == (o.tip_px is not None)
    assert o.ok == (not o.reason)


def raising(error):
    def find(image):
        raise error if image.size else ValueError

    return find


class UnspeakableError(Exception):
    def __str__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ValueError("no\n\x1b[2J edge"), r"ValueError: no \x1b[2J edge (test_what_may_"),
        (ZeroDivisionError(), "ZeroDivisionError"),
        (MemoryError("4 TB"), "MemoryError: 4 TB"),
        (RecursionError("deep"), "RecursionError"),
        (SystemExit(3), "SystemExit: 3"),
        (UnspeakableError(), "UnspeakableError"),
        (ValueError("x" * 10**6), "ValueError: xxx"),
    ],
)
def test_an_exception_is_an_observation_with_its_place(error, said):
    o = of(raising(error))
    assert o.status == "detector_error"
    assert said in o.reason
    assert "py:" in o.reason
    assert " in find)" in o.reason
    assert o.reason.isprintable()
    assert len(o.reason) < 400


def test_the_place_is_the_users_line_not_one_of_a_library():
    def find(image):
        return np.linalg.inv(image[:2, :2] * 0)

    o = of(find)
    assert "LinAlgError" in o.reason
    assert "test_what_may_a_function_be.py" in o.reason


@pytest.mark.parametrize("error", [KeyboardInterrupt(), InputError("this camera is unknown")])
def test_an_interrupt_and_an_input_error_pass(error):
    with pytest.raises(type(error)):
        of(raising(error))


def test_the_image_cannot_be_changed():
    def find(image):
        image[0, 0] = 0

    image = np.full((4, 4), 9, np.uint8)
    o = of(find, image=image)
    assert (o.status, "read-only" in o.reason) == ("detector_error", True)
    assert (image == 9).all()
    assert image.flags.writeable


def test_what_is_no_image_never_reaches_it():
    with pytest.raises(InputError, match="give an array of uint8"):
        of(lambda image: image[0, :2], image=np.zeros((4, 4)))


class Whole:
    """An object with the protocol, and hostile ways."""

    name = "another"
    summary = "whole"

    def __init__(self, fault=None):
        self.fault = fault

    @property
    def parameters(self):
        return detect.parameters_of("lin2020")

    def configure(self, values):
        if self.fault:
            raise self.fault
        return detect.configure("lin2020", values)

    def __call__(self, image, **values):
        return self.configure(values)(image)


def test_an_object_with_the_protocol_is_taken_as_it_is():
    detector = adopted("mine", Whole())
    assert (detector.name, detector.summary) == ("mine", "whole")
    assert detector.parameters == detect.parameters_of("lin2020")
    threshold = {"threshold": 1}
    expected = detect.configure("lin2020", threshold)(GRAY)
    assert detector(GRAY, **threshold).reason == expected.reason
    with pytest.raises(InputError, match=r"^detect\.treshold"):
        detector.configure({"treshold": 1})
    with pytest.raises(InputError, match="mine cannot be set up: KeyError"):
        adopted("mine", Whole(KeyError("x"))).configure({})
