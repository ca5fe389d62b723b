"""Is a lens that cannot be refused, naming the field, instead of giving a folded picture?"""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from simtip.camera import Camera, folds
from simtip.errors import BackendError, InputError
from simtip.optics import relative_illumination
from simtip.render import choose, render_pair
from simtip.scene_file import load_scene
from simtip.spec import LensSpec, SceneSpec

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


LENS, DISTORTION = "rig.left.lens", "rig.left.lens.distortion"
REFUSED = [
    # (lens, field, what is said)
    pytest.param(
        {"distortion": [-1.2, 0, 0, 0]},
        DISTORTION,
        ["folds inside the image", "times 0.24"],
        marks=pytest.mark.slow,
    ),
    # Only the exact corner folds: no ray reaches the last few pixels.
    ({"distortion": [-0.293, 0, 0, 0]}, DISTORTION, ["folds inside the image", "times 0.99"]),
    pytest.param(
        {"distortion": [0, 0, 0.1, 0.1]},
        DISTORTION,
        ["folds inside the image"],
        marks=pytest.mark.slow,
    ),
    ({"distortion": [1e300, 0, 0, 0]}, f"{DISTORTION}[0]", ["from -1e+06 to 1e+06"]),
    ({"distortion": [0.1, 0]}, DISTORTION, ["has 2", "give 0, 4, 5 or 8"]),
    ({"distortion": [0.0] * 12}, DISTORTION, ["thin prism", "give 0, 4, 5 or 8"]),
    ({"vignetting": [1e300]}, f"{LENS}.vignetting[0]", ["from -1e+06 to 1e+06"]),
    ({"vignetting": [-2.1]}, f"{LENS}.vignetting", ["leaves -0.0", "above 0 and at most 2"]),
    ({"vignetting": [2.1]}, f"{LENS}.vignetting", ["leaves 2.0", "above 0 and at most 2"]),
    ({"vignetting": [0, 0, 0, 0, 0]}, f"{LENS}.vignetting", ["has 5", "give at most 4"]),
    ({"focus_mm": 5}, f"{LENS}.focus_mm", ["inside the focal length", "above 6 mm"]),
    ({"f_number": 0}, f"{LENS}.f_number", ["from 0.5 to 1000"]),
    ({"aberration_um": -1}, f"{LENS}.aberration_um", ["from 0 to 100"]),
    ({"aberration_um": 100}, f"{LENS}.aberration_um", ["156 px", "81.9 at most"]),
    ({"f_number": 1000, "diffraction": True}, f"{LENS}.f_number", ["68.4 at most"]),
]


@pytest.mark.parametrize(("lens", "field", "fragments"), REFUSED)
def test_a_scene_with_such_a_lens_is_refused_before_it_is_rendered(
    tmp_path, scene, lens, field, fragments
):
    data = scene.model_dump(mode="json", exclude_unset=True)
    data["rig"]["left"]["lens"] = lens
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(InputError) as caught:
        load_scene(path)
    error = caught.value
    assert error.field == field
    assert error.remedy not in ("", "correct it")
    for fragment in fragments:
        assert fragment in str(error)
    assert "\n" not in str(error)


def test_a_valid_model_that_the_renderer_cannot_undo_is_refused(scene):
    """Upright to the corners, by a hair: Newton's method gets lost there."""
    data = scene.model_dump(mode="json", exclude_unset=True)
    hard = (-0.1396, -0.00764, -0.00164, -0.00084, 0.00121, 0.0908, -0.0112, -0.00935)
    camera = Camera(np.array([[500, 0, 1023.5], [0, 500, 717.5], [0, 0, 1]]), 2048, 1436, hard)
    assert not folds(camera)
    left = {"width": 2048, "height": 1436, "fx": 500, "fy": 500, "cx": 1023.5, "cy": 717.5}
    data["rig"]["left"] = {**left, "lens": {"distortion": hard}}
    with pytest.raises(ValidationError, match=r"lens\.distortion: .* cannot be undone to 0.005 px"):
        SceneSpec.model_validate(data)


def test_the_right_lens_is_named_too(scene):
    data = scene.model_dump(mode="json", exclude_unset=True)
    data["rig"]["right"]["lens"] = {"aberration_um": 100}
    with pytest.raises(ValidationError, match=r"rig\.right\.lens\.aberration_um"):
        SceneSpec.model_validate(data)


@pytest.mark.parametrize(
    "lens",
    [
        {"distortion": [-0.292, 0, 0, 0], "vignetting": [-0.15]},
        {"distortion": [-0.25, 0.1, 0, 0, 0.2], "vignetting": [-1.3]},
        {"vignetting": [-1.9]},
        {"vignetting": [1.9]},
        {"aberration_um": 81},
    ],
)
def test_a_lens_at_the_edge_of_what_is_possible_loads(scene, lens):
    data = scene.model_dump(mode="json", exclude_unset=True)
    data["rig"]["left"]["lens"] = lens
    left = SceneSpec.model_validate(data).rig.left
    kept = relative_illumination(left.camera(), left.lens)
    assert np.isfinite(kept).all()
    assert kept.min() > 0


def test_the_scalar_back_end_says_that_it_has_no_lens(small_scene):
    left = small_scene.rig.left.model_copy(update={"lens": LensSpec(focus_mm=170)})
    rig = small_scene.rig.model_copy(update={"left": left})
    with pytest.raises(BackendError, match="focus_mm"):
        render_pair(small_scene.model_copy(update={"rig": rig}), backend=choose("scalar"))


def test_a_lens_is_frozen():
    with pytest.raises(ValidationError):
        LensSpec().f_number = 2
