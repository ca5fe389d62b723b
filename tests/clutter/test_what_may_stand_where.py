"""Is solid clutter solid, clear of the needle, behind it, and where a camera sees it or not?

Oracle for what hides what: rays from the cameras against every triangle, one by one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from simtip.clutter import LampPlace, Setting, grouped, objects, objects_truth
from simtip.clutter.setting import CAMERA_CLEAR_MM, NEEDLE_CLEAR_MM
from simtip.render.board import Board
from simtip.spec.background import BackgroundSpec
from simtip.spec.clutter import ClutterSpec

TIP = np.array([-10.0, 20.0, 170.0])
RADIUS = 0.835
SEEDS = range(3)
HOSTILE = ClutterSpec(level="hostile")


def setting_of(rig, tip=TIP, hub=TIP - [0, 150, 0], lamps=True):
    board = Board.of(BackgroundSpec(centre_mm=(-20, 0, 260)))
    tubes = [LampPlace(np.array([0.0, -1500, z]), np.array([600.0, 0, 0])) for z in (-600, -1800)]
    return Setting(board, rig, tip, np.stack([tip, hub]), RADIUS, tubes if lamps else ())


@pytest.fixture(scope="module")
def setting(paper_rig):
    return setting_of(paper_rig)


def needle_points(setting, count=20):
    share = np.linspace(0, 1, count)[:, None]
    return setting.needle_mm[0] + share * (setting.needle_mm[-1] - setting.needle_mm[0])


def blocked(thing, start, end):
    """Say whether the thing's surface lies between two points (Moeller and Trumbore 1997)."""
    a, b, c = thing.vertices[thing.faces].transpose(1, 0, 2)
    d = end - start
    p = np.cross(d, c - a)
    det = ((b - a) * p).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((start - a) * p).sum(axis=1) / det
        q = np.cross(start - a, b - a)
        v = (q @ d) / det
        t = ((c - a) * q).sum(axis=1) / det
    return bool(((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 1)).any())


def hides(things, setting, points):
    """Say whether any thing is before any of the points in either view."""
    eyes = np.zeros(3), setting.rig.T_lr.t
    return any(blocked(x, eye, p) for x in things if x.in_view for eye in eyes for p in points)


@pytest.mark.parametrize(
    "level", ["medium", "heavy", pytest.param("hostile", marks=pytest.mark.slow)]
)
def test_every_thing_is_closed_and_faces_outward(setting, level):
    things = objects(ClutterSpec(level=level), setting, 1)
    assert {x.kind for x in things} >= {"dust", "lint", "shadow"}
    for thing in things:
        mesh = trimesh.Trimesh(thing.vertices, thing.faces, process=False)
        assert mesh.is_watertight, thing.name
        assert mesh.is_winding_consistent, thing.name
        assert mesh.volume > 0, thing.name
        assert len(np.unique(thing.faces)) == len(thing.vertices), thing.name


def test_a_tube_has_its_volume(setting):
    """A polygon of 24 sides has 0.9886 of the circle's area."""
    clutter = ClutterSpec(cables=1, cable_diameter_mm=(3, 3))
    (cable,) = objects(clutter, setting, 1)
    mesh = trimesh.Trimesh(cable.vertices, cable.faces, process=False)
    spine = cable.vertices[:-2].reshape(-1, 24, 3).mean(axis=1)
    length = np.linalg.norm(np.diff(spine, axis=0), axis=1).sum()
    assert length > 100
    assert mesh.volume == pytest.approx(0.9886 * np.pi * 1.5**2 * length, rel=0.01)
    assert cable.diameter_mm == 3


@pytest.mark.parametrize("occlude", [False, True])
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_nothing_comes_near_the_needle_or_the_cameras_or_into_the_board(setting, seed, occlude):
    clutter = HOSTILE.model_copy(update={"occlude": occlude})
    tip, hub = setting.needle_mm
    for thing in objects(clutter, setting, seed):
        mesh = trimesh.Trimesh(thing.vertices, thing.faces, process=False)
        points = np.concatenate([thing.vertices, mesh.triangles_center])
        share = np.clip((points - tip) @ (hub - tip) / 150**2, 0, 1)[:, None]
        gap = np.linalg.norm(points - tip - share * (hub - tip), axis=1).min() - RADIUS
        assert gap >= NEEDLE_CLEAR_MM, thing.name
        for eye in (np.zeros(3), setting.rig.T_lr.t):
            assert np.linalg.norm(points - eye, axis=1).min() >= CAMERA_CLEAR_MM, thing.name
        assert (260 - points[:, 2]).min() > 0, thing.name


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_nothing_hides_the_needle(setting, seed):
    clutter = HOSTILE.model_copy(update={"dust_per_100cm2": 3.0})
    assert not hides(objects(clutter, setting, seed), setting, needle_points(setting))


@pytest.mark.slow
def test_what_may_hide_the_needle_sometimes_does(setting):
    clutter = HOSTILE.model_copy(update={"occlude": True, "dust_per_100cm2": 0.0})
    points = needle_points(setting)
    assert any(hides(objects(clutter, setting, s), setting, points) for s in range(6))


def gap_to_tip(things, setting):
    """Smallest distance of a thing's outline from the tip in either image, mm at the tip."""
    least = np.inf
    for camera, to in views(setting):
        tip = to(setting.tip_mm)
        for thing in things:
            pixels = camera.project(to(thing.vertices))
            corners = pixels[thing.faces] - camera.project(tip)
            middles = (corners + np.roll(corners, 1, axis=1)) / 2
            near = np.linalg.norm(np.concatenate([corners, middles], axis=1), axis=-1).min()
            least = min(least, near * np.linalg.norm(tip) / camera.K[0, 0])
    return least


@pytest.mark.slow
@pytest.mark.parametrize("level", ["light", "medium", "heavy"])
def test_the_tip_keeps_free_in_both_images(setting, level):
    """Away from the image's centre a pixel stands for a smaller angle: 10 % are allowed for."""
    clutter = ClutterSpec(level=level, dust_per_100cm2=30, cables=2, rods=2)
    for seed in range(2):
        things = [x for x in objects(clutter, setting, seed) if x.in_view]
        assert gap_to_tip(things, setting) > 0.9 * clutter.amounts().tip_clear_mm


@pytest.mark.slow
def test_at_hostile_something_comes_near_the_tip(setting):
    gaps = (
        gap_to_tip([x for x in objects(HOSTILE, setting, s) if x.in_view], setting) for s in SEEDS
    )
    assert any(gap < 4 for gap in gaps)


def views(setting):
    T = setting.rig.T_lr
    return (setting.rig.left, lambda p: p), (setting.rig.right, T.inverse().apply)


@pytest.mark.parametrize("seed", range(12))
def test_a_shadow_caster_is_out_of_view(setting, seed):
    (bar,) = objects(ClutterSpec(shadows=1), setting, seed)
    assert not bar.in_view
    for camera, to in views(setting):
        pixels = camera.project(to(bar.vertices))
        wide = (pixels > -30) & (pixels < np.array(camera.size) + 30)
        assert not wide.all(axis=1).any()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_a_shadow_falls_on_what_both_cameras_see(setting, seed):
    (bar,) = objects(ClutterSpec(shadows=1), setting, seed)
    s, t = np.meshgrid(np.arange(-155, 150, 10.0), np.arange(-115, 115, 8.0))
    board = np.stack([s, t, np.full_like(s, 260)], axis=-1).reshape(-1, 3)
    seen = [camera.contains(camera.project(to(board))) for camera, to in views(setting)]
    lit = board[seen[0] & seen[1]]
    assert len(lit) > 200
    assert any(blocked(bar, p, lamp.centre_mm) for lamp in setting.lamps for p in lit)


def test_what_is_near_a_camera_is_not_free(setting):
    for eye in (np.zeros(3), setting.rig.T_lr.t):
        assert not setting.is_free(eye[None] + [0, 0, 35], 1.0)
        assert not setting.is_free(eye[None] + [0, 0, 40.5], 1.0)
        assert setting.is_free(eye[None] + [0, 0, 42], 1.0)


def test_without_lamps_there_are_no_shadows_and_the_truth_says_so(paper_rig):
    dark = setting_of(paper_rig, lamps=False)
    clutter = ClutterSpec(shadows=2, cables=1)
    truth = objects_truth(clutter, objects(clutter, dark, 1))
    assert truth["left_out"] == {"shadow": 2}
    assert [x["name"] for x in truth["objects"]] == ["cable_1"]


@pytest.mark.slow
def test_a_needle_that_touches_the_board_leaves_no_room_behind_it(paper_rig):
    low = setting_of(paper_rig, tip=np.array([-10.0, 20, 258]), hub=np.array([-10.0, -130, 258]))
    clutter = ClutterSpec(level="hostile")
    things = objects(clutter, low, 1)
    assert not [x for x in things if x.in_view]
    assert objects_truth(clutter, things)["left_out"]["cable"] == 3


def test_the_seed_decides_and_things_do_not_move_each_other(setting):
    def shapes(clutter, seed):
        return {x.name: x.vertices for x in objects(clutter, setting, seed)}

    first, again, other = shapes(HOSTILE, 1), shapes(HOSTILE, 1), shapes(HOSTILE, 2)
    assert first.keys() == again.keys()
    for name, vertices in first.items():
        np.testing.assert_array_equal(vertices, again[name])
    assert (
        first["cable_1"].shape != other["cable_1"].shape
        or (first["cable_1"] != other["cable_1"]).any()
    )
    fewer = shapes(HOSTILE.model_copy(update={"cables": 1, "rods": 0}), 1)
    np.testing.assert_array_equal(fewer["cable_1"], first["cable_1"])
    strewn = [name for name in first if name.startswith(("dust", "lint"))]
    assert len(strewn) > 50
    for name in strewn:
        np.testing.assert_array_equal(fewer[name], first[name])
    fixed = shapes(HOSTILE.model_copy(update={"seed": 2}), 1)
    np.testing.assert_array_equal(fixed["cable_1"], other["cable_1"])


def test_a_needle_that_moves_a_little_leaves_the_clutter_as_it_is(setting, paper_rig):
    moved = setting_of(paper_rig, tip=TIP + 2, hub=np.add(TIP, [2, -148, 2]))
    for a, b in zip(objects(HOSTILE, setting, 1), objects(HOSTILE, moved, 1), strict=True):
        np.testing.assert_array_equal(a.vertices, b.vertices)


def test_dust_is_as_much_as_stated(setting):
    low, high = setting.box
    clutter = ClutterSpec(dust_per_100cm2=30, tip_clear_mm=0)
    things = objects(clutter, setting, 3)
    mean = 30 * np.prod(high - low) / 1e4
    assert abs(len(things) - mean) < 4 * np.sqrt(mean)
    lint = sum(x.kind == "lint" for x in things) / len(things)
    assert lint == pytest.approx(0.25, abs=4 * np.sqrt(0.19 / len(things)))
    on_board = [260 - x.vertices[:, 2].max() for x in things if x.kind == "dust"]
    assert np.ptp(on_board) < 0.02, "dust lies on the board"


def test_the_box_holds_all_that_is_seen(setting):
    low, high = setting.box
    T = setting.rig.T_lr
    for camera, axes, eye in ((setting.rig.left, np.eye(3), 0), (setting.rig.right, T.R, T.t)):
        corners = [[-0.5, -0.5], [2047.5, -0.5], [-0.5, 1435.5], [2047.5, 1435.5]]
        rays = camera.rays(corners) @ np.transpose(axes)
        origin = np.zeros(3) + eye
        points = origin + rays * ((260 - origin[2]) / rays[:, 2:])
        st = (points - setting.board.centre) @ np.stack([setting.board.x, setting.board.y]).T
        assert (st >= low - 1e-6).all()
        assert (st <= high + 1e-6).all()
    assert ((high - low) < 600).all()


def test_a_camera_that_looks_away_from_the_board_has_no_solid_clutter(setting):
    behind = Board.of(BackgroundSpec(centre_mm=(0, 0, -500), normal=(0, 0, 1)))
    assert objects(HOSTILE, replace(setting, board=behind), 1) == ()


@pytest.mark.slow
def test_groups_hold_all_that_was_in_them(setting):
    things = objects(HOSTILE, setting, 1)
    groups = grouped(things)
    assert len(groups) < 16 < len(things)
    assert sum(len(g.faces) for g in groups) == sum(len(x.faces) for x in things)
    total = sum(trimesh.Trimesh(x.vertices, x.faces, process=False).volume for x in things)
    joined = sum(trimesh.Trimesh(g.vertices, g.faces, process=False).volume for g in groups)
    assert joined == pytest.approx(total)
    assert len({g.name for g in groups}) == len(groups)


def test_the_truth_lists_each_thing(setting):
    things = objects(HOSTILE, setting, 1)
    truth = objects_truth(HOSTILE, things)
    names = [x["name"] for x in truth["objects"]]
    assert names == [x.name for x in things]
    assert len(set(names)) == len(names)
    assert truth["left_out"] == {}
    cable = truth["objects"][0]
    assert (np.array(cable["low_mm"]) < cable["high_mm"]).all()
