"""Do walls send the light of a tube to the camera, to the needle and to the board as they should?

The tube is summed up in numpy as a thin line of matt emitter; walls as small squares.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracles.metal import fresnel, index
from regions import with_roi

from simtip.geometry import Pose, unit
from simtip.render import choose, render_pair
from simtip.render.backend import activated
from simtip.spec import SceneSpec

LOW, HIGH = np.array([-900.0, -1100, -1500]), np.array([1300.0, 700, 800])
WALLS, CEILING, FLOOR = 0.7, 0.9, 0.3
ALBEDO = [WALLS, WALLS, CEILING, FLOOR, WALLS, WALLS]
"""Of x low, x high, y low (the ceiling), y high, z low, z high."""
CENTRE, ALONG = np.array([250.0, -500.0, -450.0]), unit([1, 0.3, 0.7])
LENGTH_MM, DIAMETER_MM = 500.0, 0.5
ELEMENTS = 100


def room(scene: SceneSpec, rois: list[list[int]], **walls: float) -> SceneSpec:
    data = with_roi(scene, *rois, samples=256, noise=None).model_dump(mode="json")
    data["needle"]["tip_mm"] = [-10, 5000, 170]
    data["lamps"] = [{
        "name": "tube", "kind": "tube", "centre_mm": CENTRE.tolist(), "direction": ALONG.tolist(),
        "length_mm": LENGTH_MM, "diameter_mm": DIAMETER_MM,
    }]  # fmt: skip
    albedo = {"walls": WALLS, "ceiling": CEILING, "floor": FLOOR} | walls
    data["room"] = {"low_mm": LOW.tolist(), "high_mm": HIGH.tolist(), **albedo}
    data["needle"] |= {"tip_mm": [-10, 300, 170], "length_mm": 30, "axis": [0, 1, 0]}
    return SceneSpec.model_validate(data)


def thin_tube(points: np.ndarray, normals: np.ndarray, centre: np.ndarray = CENTRE) -> np.ndarray:
    """Irradiance / pi (n,) under unit radiance: an element dl shines as D sin(theta) dl.

    It errs by the order of the radius over the distance to the axis, here 1e-3.
    """
    along = ((np.arange(ELEMENTS) + 0.5) / ELEMENTS - 0.5) * LENGTH_MM
    total = np.zeros(len(points))
    for place in centre + along[:, None] * ALONG:
        to_lamp = place - points
        d = np.linalg.norm(to_lamp, axis=1)
        direction = to_lamp / d[:, None]
        sine = np.linalg.norm(np.cross(direction, ALONG), axis=1)
        total += np.clip((direction * normals).sum(axis=1), 0, None) * sine / d**2
    return total * DIAMETER_MM * LENGTH_MM / ELEMENTS / np.pi


def wall_points(fractions: np.ndarray, wall: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) of a wall at fractions (n, 2) of its sides, and the inward normals."""
    axis, side = divmod(wall, 2)
    place = np.insert(fractions, axis, side, axis=1)
    normal = np.zeros(3)
    normal[axis] = 1 - 2 * side
    return LOW + place * (HIGH - LOW), np.tile(normal, (len(place), 1))


def leaving(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Radiance (n,) that rays from inside meet: their wall's albedo times its light."""
    ends = np.where(directions > 0, HIGH, LOW)
    t = (ends - points) / directions
    axis = t.argmin(axis=1)
    row = np.arange(len(t))
    found = points + t[row, axis][:, None] * directions
    normals = np.zeros_like(found)
    sign = np.sign(directions[row, axis])
    normals[row, axis] = -sign
    return thin_tube(found, normals) * np.array(ALBEDO)[2 * axis + (sign > 0)]


@pytest.mark.slow
@pytest.mark.parametrize("wall", range(6), ids=["x-", "x+", "y-", "y+", "z-", "z+"])
def test_each_wall_has_its_own_light_in_its_own_place(scene, wall):
    spec = room(scene, [[0, 0, 8, 8]] * 2)
    line = np.array([1e-3, 0.02, 0.3, 0.77, 0.98, 1 - 1e-3])
    fractions = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    points, normals = wall_points(fractions, wall)
    found = looked_up(spec, points)
    expected = thin_tube(points, normals) * ALBEDO[wall]
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=5e-3 * expected.max())


def looked_up(spec: SceneSpec, points: np.ndarray) -> np.ndarray:
    """What rays from within the room to points (n, 3) of its walls bring of the lamp."""
    origin = np.array([-30.0, 40, 100])
    with activated(choose()):
        from simtip.render.engine import mi
        from simtip.render.lamps import lamps_of
        from simtip.render.surround import WalledRoom

        surround = WalledRoom(spec.room, lamps_of(spec.lamps), 1)
        d = unit(points - origin).astype(np.float32)
        ray = mi.Ray3f(mi.Point3f(origin.tolist()), mi.Vector3f(*(mi.Float(c) for c in d.T.copy())))
        light, ambient = surround.light(ray, mi.Mask(True))
        found = light.numpy()
        assert np.all(np.array(ambient) == 1)
    return found


def test_a_linear_light_is_read_back_as_it_is(scene, monkeypatch):
    """Half a grid step would show, and so would a wall in place of another."""
    spec = room(scene, [[0, 0, 8, 8]] * 2, walls=1, ceiling=1, floor=1)
    slope = np.array([1.0, 2.0, 4.0])
    with activated(choose()):
        from simtip.render import surround

        monkeypatch.setattr(surround, "WALL_NODES", 5)
        monkeypatch.setattr(
            surround, "_wall_light", lambda _lamps, points, _normals, _seed: points @ slope[:, None]
        )
    rng = np.random.default_rng(2)
    points = np.concatenate([wall_points(rng.random((50, 2)), wall)[0] for wall in range(6)])
    found = looked_up(spec, points)
    np.testing.assert_allclose(found, points @ slope, rtol=0, atol=1e-3 * np.abs(found).max())


def test_a_tube_near_the_ceiling_makes_a_sharp_bright_spot(scene):
    data = room(scene, [[0, 0, 8, 8]] * 2).model_dump(mode="json")
    high_up = CENTRE * [1, 0, 1] + [0, LOW[1] + 200, 0]
    data["lamps"][0] |= {"centre_mm": high_up.tolist()}
    fractions = np.stack(np.meshgrid(*2 * [np.linspace(0.2, 0.8, 60)]), axis=-1).reshape(-1, 2)
    points, normals = wall_points(fractions, 2)
    expected = thin_tube(points, normals, high_up) * CEILING
    off = np.abs(looked_up(SceneSpec.model_validate(data), points) - expected)
    # Seen: 5e-3.
    assert off.max() < 0.03 * expected.max()


def test_the_board_gets_one_bounce_of_every_wall(scene):
    spec = room(scene, [[0, 0, 8, 8]] * 2)
    places = np.array([[0.0, 0.0], [300.0, -250.0], [-350.0, 200.0]])
    with activated(choose()):
        from simtip.render.illuminator import Illuminator
        from simtip.render.needle_subject import NeedleSubject
        from simtip.render.progress import Tally
        from simtip.render.world import load_world

        world = load_world(spec, 1, NeedleSubject(spec))
        light = Illuminator(world.scene, world.lamps, world.surround, world.board, 50.0)
        found = light.open_room(places, 8192, 1, Tally(None))
        board = world.board.points(places)
    np.testing.assert_allclose(found[:, 1], 1, rtol=1e-5)
    line = (np.arange(45) + 0.5) / 45
    cells = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    expected = np.zeros(len(places))
    for wall in range(6):
        points, normals = wall_points(cells, wall)
        area = np.prod(np.delete(HIGH - LOW, wall // 2)) / len(cells)
        radiance = thin_tube(points, normals) * ALBEDO[wall]
        for k, place in enumerate(board):
            to_wall = points - place
            d = np.linalg.norm(to_wall, axis=1)
            cosines = np.clip(to_wall @ [0, 0, -1.0], 0, None) / d
            cosines *= np.clip(-(to_wall * normals).sum(axis=1), 0, None) / d
            expected[k] += (radiance * cosines / d**2).sum() * area / np.pi
    np.testing.assert_allclose(found[:, 0], expected, rtol=5e-3)


@pytest.mark.parametrize(
    "plate", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["seen", "mirrored"]
)
def test_the_walls_are_seen_and_mirrored_where_they_are(scene, plate):
    """Through the left and the right camera; in the mirror, the flat end of a blunt needle."""
    tip = np.array([-40.0, 20.0, 170.0])
    rig = scene.rig.rig()
    rois = [[*np.rint(p - 4).astype(int).tolist(), 8, 8] for p in rig.project(tip)]
    data = room(scene, rois).model_dump(mode="json")
    data["background"] |= {"centre_mm": [0, 600, 700], "size_mm": [1, 1]}
    normal = unit([0.35, -0.25, -1])
    if plate:
        data["needle"] |= {"tip": {"kind": "blunt"}, "diameter_mm": 40, "length_mm": 100,
                           "tip_mm": tip.tolist(), "axis": (-normal).tolist()}  # fmt: skip
        data["needle"]["material"]["roughness"] = 0.01
    spec = SceneSpec.model_validate(data)
    rig = spec.rig.rig()
    cameras = (rig.left, Pose.identity()), (rig.right, rig.T_lr)
    # The mirror also shows the tube, in the tail of its lobe: light adds up, so that goes off.
    tube = render_pair(SceneSpec.model_validate(spec.model_dump(mode="json") | {"room": None}))
    walled = zip(render_pair(spec), tube, cameras, strict=True)
    for view, tube_only, (camera, T_wc) in walled:
        assert (view.coverage == float(plate)).all()
        v, u = np.mgrid[:8, :8]
        d = T_wc.rotate(camera.rays(np.stack([u, v], axis=-1).reshape(-1, 2)))
        if plate:
            t = ((tip - T_wc.t) @ normal) / (d @ normal)
            points, cosine = T_wc.t + t[:, None] * d, -d @ normal
            away = d + 2 * cosine[:, None] * normal
            share = fresnel(index("titanium", [600.0, 540.0, 460.0])[:, None], cosine)
            expected = share * leaving(points, away)
        else:
            expected = np.tile(leaving(np.tile(T_wc.t, (len(d), 1)), d), (3, 1))
        found = (view.response[0] - tube_only.response[0]).reshape(-1, 3).T
        # The tail of the mirror's lobe sees other walls: 1 %.
        rtol = 0.02 if plate else 5e-3
        np.testing.assert_allclose(found.mean(axis=1), expected.mean(axis=1), rtol=rtol)
        np.testing.assert_allclose(found, expected, rtol=0.03)


@pytest.mark.slow
def test_black_walls_are_no_walls(scene):
    spec = room(scene, [[800, 860, 24, 24], [1010, 856, 24, 24]], walls=0, ceiling=0, floor=0)
    data = spec.model_dump(mode="json")
    data["needle"]["tip_mm"] = [-10, 22, 170]
    data["needle"]["axis"] = [0, -1, 0]
    black = render_pair(SceneSpec.model_validate(data))
    none = render_pair(SceneSpec.model_validate(data | {"room": None}))
    for one, other in zip(black, none, strict=True):
        assert one.coverage.any()
        np.testing.assert_array_equal(one.response, other.response)
