"""Is a pixel covered as much as points strewn over it say, blurred and not?"""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from simtip.detect.subpixel.outline import FAMILIES
from simtip.detect.subpixel.picture import Cells, Placed, Window, cover, cover_change

SHAPES = {
    "cone": (3.0,),
    "round": (2.5, 0.4),
    "wedge": (0.4, 1.2, 3.1),
    "bevel": (1.2, 1.1),
    "bevel_away": (1.5, 2.0),
}
WINDOW = Window(90, 40, 30, 34)
HALF, TILT, POINTS = 8.3, 0.2, 12


def seen(needle, variance, disc_share=0.0):
    return cover(needle, Cells(WINDOW, variance, disc_share))


def placed(name, slope, *, half=HALF, shift=0.0, along=0.0, longer=0.0, tilt=0.0):
    family, shape = FAMILIES[name], np.array(SHAPES[name])
    shape[-1 if name == "wedge" else 0] += longer
    hub = np.array([-slope, -1.0]) / np.hypot(1, slope)
    across = np.array([-hub[1], hub[0]])
    origin = np.array([104.3 + shift, 66.45 + along])

    def put(points):
        return origin + points[:, :1] * across + points[:, 1:] * hub

    facet = None if family.facet is None else put(family.facet(half, shape, TILT))
    corners = put(family.polygon(half, shape, 120.0, TILT))
    return Placed(corners, facet, origin, hub, half, family.depth(half, shape), tilt)


def inside(corners, u, v):
    """Say of points whether they lie in a convex polygon: on one side of all its sides."""
    a, b = corners, np.roll(corners, -1, axis=0)
    left = right = True
    for p, q in zip(a, b, strict=True):
        side = (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0])
        left, right = left & (side >= 0), right & (side <= 0)
    return left | right


def strewn(there, variance):
    """Give pixels' shares of a function of points: averaged, and blurred by a fine Gaussian."""
    pad = int(np.ceil(6 * np.sqrt(variance)))
    u = WINDOW.u - pad - 0.5 + (np.arange((WINDOW.width + 2 * pad) * POINTS) + 0.5) / POINTS
    v = WINDOW.v - pad - 0.5 + (np.arange((WINDOW.height + 2 * pad) * POINTS) + 0.5) / POINTS
    cells = there(u, v[:, None]).astype(float)
    if variance:
        cells = gaussian_filter(cells, np.sqrt(variance) * POINTS)
    pixels = cells.reshape(len(v) // POINTS, POINTS, len(u) // POINTS, POINTS).mean(axis=(1, 3))
    return pixels[pad : pad + WINDOW.height, pad : pad + WINDOW.width].reshape(-1)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(("slope", "variance"), [(0.0, 0.0), (0.45, 0.0), (-0.3, 0.6)])
def test_the_whole_is_what_points_in_the_outline_say(name, slope, variance):
    needle = placed(name, slope)
    expected = strewn(lambda u, v: inside(needle.corners, u, v), variance)
    found = seen(needle, variance).whole
    assert found == pytest.approx(expected, abs=0.025)
    assert found.sum() == pytest.approx(expected.sum(), rel=1e-3)
    assert moment(found) == pytest.approx(moment(expected), abs=0.01)


@pytest.mark.parametrize(("slope", "variance"), [(0.0, 0.0), (-0.3, 0.6)])
def test_the_facet_is_what_of_its_ellipse_lies_in_the_outline(slope, variance):
    needle = placed("bevel", slope)

    def both(u, v):
        return inside(needle.facet, u, v) & inside(needle.corners, u, v)

    expected = strewn(both, variance)
    found = seen(needle, variance).tip
    assert found == pytest.approx(expected, abs=0.025)
    assert found.sum() == pytest.approx(expected.sum(), rel=5e-3)


def test_of_a_cut_seen_from_behind_nothing_is_the_tips_own():
    assert seen(placed("bevel_away", 0.2), 0.3).tip.max() == 0


def test_of_a_cone_the_tip_ends_where_the_shaft_begins():
    needle = placed("cone", 0.0)
    expected = strewn(
        lambda u, v: inside(needle.corners, u, v) & (needle.origin[1] - v < needle.depth_px), 0.5
    )
    assert seen(needle, 0.5).tip == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("slope", "variance", "disc_share", "most"),
    [(0.2, 0.5, 0.0, 0.12), (-0.3, 1.2, 0.7, 0.12), (1.0, 0.5, 0.0, 0.2), (0.2, 0.0, 0.0, 0.35)],
)
def test_the_derivatives_are_those_of_the_cover(name, slope, variance, disc_share, most):
    ways = [{"half": HALF}, {"shift": 0.0}, {"along": 0.0}, {"longer": 0.0}]
    cells, steps = Cells(WINDOW, variance, disc_share), np.array([0.05, 0.05, 0.05, 0.01])
    needle = placed(name, slope, tilt=0.3)

    def moved(sign):
        changed = (
            {key: value + sign * step for key, value in way.items()}
            for way, step in zip(ways, steps, strict=True)
        )
        return [placed(name, slope, tilt=0.3, **way) for way in changed]

    found = cover_change(needle, moved(1), steps, cells)
    for k, (ahead, behind) in enumerate(zip(moved(1), moved(-1), strict=True)):
        for part in ("whole", "tip"):
            expected = getattr(cover(ahead, cells), part) - getattr(cover(behind, cells), part)
            expected /= 2 * steps[k]
            off = np.linalg.norm(getattr(found, part)[k] - expected)
            assert off <= most * np.linalg.norm(expected)


def moment(shares):
    """Give the mean u, v of shares, px."""
    v, u = np.divmod(np.arange(len(shares)), WINDOW.width)
    return np.array([u, v]) @ shares / shares.sum()
