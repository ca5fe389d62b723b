"""Draw docs/images/camera_pair.jpg and camera_focus.jpg: an ideal camera beside a realistic one.

Run as ``python docs/figures/camera_pair.py``; takes about a minute.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from zoom import around_the_tip

from simtip.scene_file import load_scene
from simtip.simulation import simulate
from simtip.spec import CameraSpec, LensSpec, SceneSpec, SensorSpec

ROOT = Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"

FOCUS_MM = 170.0
STEPS_MM = (0.0, 10.0, -10.0)
ZOOM_PX = (72, 64)
"""Width and height of the part around the tip that is shown enlarged."""
ENLARGED = 6
ABOVE = 0.7
"""Part of the zoom's height that lies above the tip."""

Picture = NDArray[np.uint8]


def realistic(scene: SceneSpec, tip_z_mm: float) -> SceneSpec:
    """Focus both cameras at FOCUS_MM, and move the tip along the left camera's ray through it."""
    tip = np.array(scene.needle.tip_mm)
    tip *= tip_z_mm / tip[2]
    needle = scene.needle.model_copy(update={"tip_mm": tuple(tip.tolist())})

    def focused(camera: CameraSpec) -> CameraSpec:
        lens = camera.lens.model_copy(update={"focus_mm": FOCUS_MM})
        return camera.model_copy(update={"lens": lens})

    rig = scene.rig.model_copy(
        update={"left": focused(scene.rig.left), "right": focused(scene.rig.right)}
    )
    return scene.model_copy(update={"needle": needle, "rig": rig})


def idealised(scene: SceneSpec) -> SceneSpec:
    """Give the same scene pinholes without any fault, and sensors that only round."""

    def pinhole(camera: CameraSpec) -> CameraSpec:
        lens = LensSpec(f_number=camera.lens.f_number)
        return camera.model_copy(update={"lens": lens})

    rig = scene.rig.model_copy(
        update={"left": pinhole(scene.rig.left), "right": pinhole(scene.rig.right)}
    )
    sensor = SensorSpec(preset="ideal", background_dn=scene.sensor.background_dn)
    return scene.model_copy(update={"rig": rig, "sensor": sensor})


def labelled(picture: Picture, text: str, height: int = 36) -> Picture:
    """Put a line of text over a picture."""
    bar = np.full((height, picture.shape[1], 3), 255, np.uint8)
    cv2.putText(
        bar, text, (8, height - 11), cv2.FONT_HERSHEY_SIMPLEX, 0.65, (20, 20, 20), 1, cv2.LINE_AA
    )
    return np.vstack([bar, picture])


def beside(pictures: list[Picture]) -> Picture:
    """Set pictures of one height side by side."""
    gap = np.full((pictures[0].shape[0], 10, 3), 255, np.uint8)
    row = [part for picture in pictures for part in (picture, gap)]
    return np.hstack(row[:-1])


def save(name: str, picture: Picture) -> None:
    """Write an RGB picture."""
    cv2.imwrite(
        str(IMAGES / name),
        cv2.cvtColor(picture, cv2.COLOR_RGB2BGR),
        [cv2.IMWRITE_JPEG_QUALITY, 92],
    )


def whole(scene: SceneSpec) -> Picture:
    """Give the left image at half its size."""
    left = np.asarray(simulate(scene).images[0], np.uint8)
    half = cv2.resize(left, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    return np.asarray(half, np.uint8)


def zoom(scene: SceneSpec) -> Picture:
    """Give the part around the tip, each pixel a square."""
    left = np.asarray(simulate(around_the_tip(scene, ZOOM_PX, ABOVE)).images[0], np.uint8)
    return left.repeat(ENLARGED, axis=0).repeat(ENLARGED, axis=1)


def main() -> None:
    """Draw both pictures."""
    scene = load_scene(ROOT / "scenes" / "02_real_camera.yaml")
    at_focus = realistic(scene, FOCUS_MM)
    save(
        "camera_pair.jpg",
        beside(
            [
                labelled(whole(idealised(at_focus)), "ideal camera"),
                labelled(whole(at_focus), "6 mm f/1.4 lens, 3.2 um CMOS sensor"),
            ]
        ),
    )
    rows = []
    for name, change in (("ideal", idealised), ("realistic", lambda scene: scene)):
        row = []
        for step in STEPS_MM:
            where = f"{step:+.0f} mm" if step else "at focus"
            picture = zoom(change(realistic(scene, FOCUS_MM + step)))
            row.append(labelled(picture, f"{name}, {where}"))
        rows.append(beside(row))
    save("camera_focus.jpg", np.vstack(rows))


if __name__ == "__main__":
    main()
