"""A few samples do where a board is said to be plain: is no edge within the blur's reach there?"""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from boards.board_scenes import cameras, changed, even
from oracles.board_photograph import pose

from simtip.geometry import Pose
from simtip.render import choose
from simtip.render.backend import activated
from simtip.spec import SceneSpec

WIDTH, HEIGHT = 220, 200
SLOW = pytest.mark.slow


def ink_at(spec: SceneSpec, T_ct: Pose, pixels: np.ndarray) -> np.ndarray:
    """Ink (n,) where rays meet the bent plate, -1 beside it: marched along each ray."""
    plate, camera = spec.boards.build(), cameras(spec)[0][0]
    d = camera.rays(pixels) @ T_ct.R
    o = -T_ct.R.T @ T_ct.t
    t = -o[2] / d[:, 2]
    for _ in range(60):
        at = o + t[:, None] * d
        t = t + 0.7 * (plate.height(at[:, :2]) - at[:, 2]) / d[:, 2]
    at = (o + t[:, None] * d)[:, :2]
    on = ((at > plate.low) & (at < plate.high)).all(axis=1)
    return np.where(on, plate.target.ink(at / plate.print_scale), -1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bow", "tilt", "blur_px"),
    [(0.0, 60, 6), *(pytest.param(*case, marks=SLOW) for case in [(0.0, 30, 3.0), (0.4, 55, 0.0)])],
)
def test_no_edge_is_near_a_plain_pixel(scene, bow, tilt, blur_px):
    rig = scene.model_dump(mode="json")["rig"]
    rig["left"]["roi"] = [780, 700, WIDTH, HEIGHT]
    plate = {"bow_mm": bow, "edge_blur_mm": 0, "print_scale": [1.03, 0.97]}
    spec = changed(even(scene), rig=rig, boards={"target": "chessboard:3x2:8", "plate": plate})
    middle = spec.boards.build().middle[:2]
    rvec, t = pose(tilt, 45, 15, middle, np.array([-4.0, 11.0, 170.0]))
    T_wt = Pose(cv2.Rodrigues(rvec)[0], t)
    pixels = np.arange(WIDTH * HEIGHT, dtype=np.uint32)
    with activated(choose()):
        from simtip.render.board_subject import BoardSubject
        from simtip.render.eye import Eye

        subject = BoardSubject(spec.boards.build(), T_wt, spec.boards.plate)
        eye = Eye(cameras(spec)[0][0], Pose.identity(), None)
        plain = subject.plain(eye, pixels, blur_px).reshape(HEIGHT, WIDTH)
    # Ink between pixels, and how far the next other value is.
    v, u = (a.ravel() for a in np.mgrid[: 2 * HEIGHT, : 2 * WIDTH] / 2 - 0.25)
    fine = ink_at(spec, T_wt, np.stack([u, v], axis=1)).reshape(2 * HEIGHT, 2 * WIDTH)
    edge = cv2.dilate(fine, np.ones((3, 3))) != cv2.erode(fine, np.ones((3, 3)))
    free = cv2.distanceTransform((~edge).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) / 2
    nearest = free.reshape(HEIGHT, 2, WIDTH, 2).min(axis=(1, 3))
    assert plain.mean() > 0.05
    assert nearest[plain].min() >= blur_px
