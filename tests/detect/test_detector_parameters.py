"""Do names and values from a scene or a command line reach the detector, or fail by name?"""

import pytest

from simtip import detect
from simtip.detect.lin2020_parameters import Lin2020Parameters
from simtip.errors import InputError


def test_an_unknown_detector_is_named_with_the_nearest_known():
    with pytest.raises(InputError, match=r"detect\.name: .*'lin2202'.*'lin2020'") as caught:
        detect.get("lin2202")
    assert caught.value.field == "detect.name"
    with pytest.raises(InputError, match="known: lin2020"):
        detect.configure("xyz")


def test_an_unknown_parameter_is_named_with_the_nearest_known():
    with pytest.raises(InputError, match=r"^detect\.treshold: .*did you mean 'threshold'\?$"):
        detect.configure("lin2020", {"treshold": 105})
    with pytest.raises(InputError, match=r"known: border_margin_px, .*weights$"):
        detect.configure("lin2020", {"zzz": 1})


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        ("threshold", "105", 105),
        ("threshold", 99.0, 99),
        ("threshold", 1, 1),
        ("threshold", 255, 255),
        ("full_scale", "4095", 4095),
        ("full_scale", "none", None),
        ("full_scale", None, None),
        ("connectivity", "4", 4),
        ("polarity", "both", "both"),
        ("canny_low", "12.5", 12.5),
        ("canny_low", 12, 12.0),
        ("canny_l2", "true", True),
        ("canny_l2", "False", False),
        ("weights", "1,0,0", (1.0, 0.0, 0.0)),
        ("weights", [0.5, 0.25, 0.25], (0.5, 0.25, 0.25)),
        ("median_window", "1", 1),
        ("border_margin_px", 0, 0),
    ],
)
def test_a_value_becomes_the_declared_type(name, given, expected):
    value = getattr(Lin2020Parameters.from_mapping({name: given}), name)
    assert value == expected
    assert type(value) is type(expected)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("threshold", "abc"),
        ("threshold", "105.5"),
        ("threshold", 105.5),
        ("threshold", 0),
        ("threshold", 256),
        ("threshold", True),
        ("threshold", None),
        ("threshold", [105]),
        ("threshold", {"value": 105}),
        ("threshold", float("nan")),
        ("threshold", float("inf")),
        ("threshold", "9" * 6000),
        ("full_scale", 0),
        ("full_scale", 70000),
        ("median_window", 4),
        ("median_window", -1),
        ("min_area_px", -1),
        ("connectivity", 6),
        ("connectivity", True),
        ("polarity", "darkish"),
        ("ties", 3),
        ("canny_low", "nan"),
        ("canny_low", 81),
        ("canny_high", -1),
        ("canny_aperture", 4),
        ("canny_l2", 1),
        ("canny_l2", "yes"),
        ("weights", "1,0"),
        ("weights", [1, 1, 1]),
        ("weights", [2, -1, 0]),
        ("weights", 1.0),
        ("border_margin_px", "-1"),
    ],
)
def test_a_value_that_does_not_fit_is_an_input_error_that_names_its_field(name, given):
    with pytest.raises(InputError) as caught:
        detect.configure("lin2020", {name: given})
    assert caught.value.field == f"detect.{name}"
    assert caught.value.remedy
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400
    with pytest.raises(InputError, match=rf"^detect\.{name}: "):
        Lin2020Parameters(**{name: given})


def test_the_paper_gives_these_defaults():
    p = Lin2020Parameters()
    assert (p.threshold, p.min_area_px, p.canny_low, p.canny_high) == (105, 4500, 40, 80)
    by_name = {q.name: q for q in detect.parameters_of("lin2020")}
    assert by_name["threshold"].type == "int"
    assert by_name["threshold"].default == 105
    assert by_name["full_scale"].type == "int | none"
    assert by_name["connectivity"].type == "4 | 8"
    assert by_name["weights"].type == "3 x float"
