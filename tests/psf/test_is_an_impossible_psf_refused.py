"""Is a value that cannot be said in one line that names the field?"""

from __future__ import annotations

import math

import numpy as np
import pytest

from simtip.errors import InputError
from simtip.psf import Psf, blur

GOOD = {"f_number": 1.4, "wavelength_nm": (600.0, 540.0, 460.0), "pixel_um": 3.2}


@pytest.mark.parametrize(
    ("field", "value"),
    [
        *[("f_number", bad) for bad in (0, -1.4, math.nan, math.inf)],
        *[("pixel_um", bad) for bad in (0, -3.2, math.nan, math.inf)],
        *[("aberration_um", bad) for bad in (-0.1, math.nan, math.inf, 1e4)],
        *[("encircled_energy", bad) for bad in (0, 0.4, 1, 1.1, math.nan)],
        ("wavelength_nm", (550.0,)),
        ("wavelength_nm", 550.0),
        ("wavelength_nm[1]", (600.0, 0.0, 460.0)),
        ("wavelength_nm[2]", (600.0, 540.0, math.nan)),
        ("f_number", 200),
    ],
)
def test_a_bad_value_names_its_field(field, value):
    with pytest.raises(InputError) as caught:
        Psf(**{**GOOD, field.partition("[")[0]: value})
    assert caught.value.field == field
    assert str(caught.value).startswith(f"{field}: ")
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("image", "says"),
    [
        (np.zeros((4, 5), np.float32), "shape"),
        (np.zeros((4, 5, 4), np.float32), "shape"),
        (np.zeros((0, 5, 3), np.float32), "shape"),
        (np.zeros((4, 5, 3), np.uint8), "float32"),
        (np.full((4, 5, 3), -1e-9, np.float32), "negative"),
        (np.full((4, 5, 3), np.nan, np.float32), "not finite"),
        (np.full((4, 5, 3), np.inf, np.float32), "not finite"),
    ],
)
def test_a_bad_image_is_refused(image, says):
    for psf in (Psf(**GOOD), Psf(**GOOD, diffraction=False)):
        with pytest.raises(ValueError, match=f"irradiance .*{says}"):
            blur(image, psf)
