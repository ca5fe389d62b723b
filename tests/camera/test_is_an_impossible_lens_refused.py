"""Is a lens that cannot be refused, naming the field, instead of giving a folded picture?"""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from regions import with_roi

from simtip.camera import Camera, folds
from simtip.errors import BackendError, InputError
from simtip.exposure import auto_expose, gray_level
from simtip.render import choose, render_pair
from simtip.scene_file import load_scene
from simtip.simulation import simulate
from simtip.spec import LensSpec, SceneSpec, SensorSpec

K = np.array([[1909.84, 0, 932.97], [0, 1910.22, 657.90], [0, 0, 1]])


@pytest.mark.parametrize(
    ("coefficients", "folded"),
    [
        ((-0.12, 0.05, 8e-4, -6e-4, 0.01), False),
        ((0.3, -0.1, 5e-4, 9e-4, 0.02, 0.42, -0.05, 0.01), False),
        ((-0.25, 0, 0, 0), False),
        # r (1 + k1 r^2) turns back at r = 1 / sqrt(-3 k1), where it has reached 2/3 of that: for
        # k1 = -0.3 at 0.703, inside the corner at hypot(0.584, 0.407) = 0.712.
        ((-0.3, 0, 0, 0), True),
        ((-1.2, 0, 0, 0), True),
    ],
)
def test_a_model_that_folds_inside_the_image_is_known(coefficients, folded):
    assert folds(Camera(K, 2048, 1436, coefficients)) is folded


@pytest.mark.parametrize(
    ("lens", "fragment"),
    [
        ({"distortion": [-1.2, 0, 0, 0]}, "folds inside the image"),
        ({"distortion": [0.1, 0]}, "coefficients"),
        ({"focus_mm": 5}, "inside the focal length"),
        ({"f_number": 0}, "f_number"),
        ({"aberration_um": -1}, "aberration_um"),
    ],
)
def test_a_scene_with_such_a_lens_is_refused(tmp_path, scene, lens, fragment):
    data = scene.model_dump(mode="json", exclude_unset=True)
    data["rig"]["left"]["lens"] = lens
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(InputError) as caught:
        load_scene(path)
    assert fragment in str(caught.value)
    assert "rig.left" in str(caught.value)


def test_the_scalar_back_end_says_that_it_has_no_lens(small_scene):
    left = small_scene.rig.left.model_copy(update={"lens": LensSpec(focus_mm=170)})
    rig = small_scene.rig.model_copy(update={"left": left})
    with pytest.raises(BackendError, match="pinholes only"):
        render_pair(small_scene.model_copy(update={"rig": rig}), backend=choose("scalar"))


@pytest.mark.parametrize("wanted", [60.0, 180.0])
def test_auto_exposure_gives_the_background_its_gray_level(scene, wanted):
    data = with_roi(scene, [780, 840, 90, 60], [990, 840, 90, 60]).model_dump(
        mode="json", exclude_unset=True
    )
    data["sensor"] = {"preset": "generic_3um2", "background_dn": wanted}
    found = simulate(SceneSpec.model_validate(data))
    gray = [
        image[view.coverage == 0] @ [0.299, 0.587, 0.114]
        for image, view in zip(found.images, found.views, strict=True)
    ]
    assert np.mean([np.median(levels) for levels in gray]) == pytest.approx(wanted, abs=1)
    assert found.spec.sensor.exposure_s != SensorSpec().exposure_s


def test_a_level_out_of_reach_names_its_field():
    with pytest.raises(InputError, match="background_dn") as caught:
        auto_expose(np.full(3, 1e-3), SensorSpec(background_dn=300.0))
    assert caught.value.field == "sensor.background_dn"


def test_the_gray_level_grows_with_the_exposure():
    light = np.full(3, 1e-3)
    levels = [gray_level(light, SensorSpec(exposure_s=t)) for t in (0.001, 0.002)]
    assert levels[1] == pytest.approx(2 * levels[0], rel=1e-6)


def test_a_lens_is_frozen():
    with pytest.raises(ValidationError):
        LensSpec().f_number = 2
