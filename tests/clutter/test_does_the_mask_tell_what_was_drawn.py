"""Does the mask hold what was printed, no more and no less, and is it as much as was asked for?"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from simtip.clutter import board_texture
from simtip.clutter.grid import Grid
from simtip.clutter.prints import Print, strewn
from simtip.clutter.texture import draw
from simtip.spec.background import BackgroundSpec, PaperTexture
from simtip.spec.clutter import LEVELS, ClutterSpec

BOX = (-60.0, -50.0), (60.0, 50.0)
BOARD = BackgroundSpec()


def dots(**more):
    return ClutterSpec(specks_per_100cm2=60, speck_mm=0.3, speck_sigma=0.4, **more)


def test_a_print_darkens_by_its_contrast_times_the_mask():
    texture = board_texture(BOARD, dots(contrast=(0.7, 0.7)), 4, *BOX)
    single = texture.clutter < 0.999  # where two overlap, 1 - (1 - a)(1 - b) takes its place
    np.testing.assert_allclose(
        1 - texture.albedo[single], 0.7 * texture.clutter[single], atol=2e-6, rtol=1e-3
    )
    assert texture.clutter.max() == 1
    assert texture.albedo.min() == pytest.approx(0.3, abs=1e-5)


@pytest.mark.parametrize(
    "kind", [{"scratches_per_100cm2": 8}, {"hairs_per_100cm2": 8}, {"specks_per_100cm2": 80}]
)
def test_the_masks_area_is_that_of_the_outlines(kind):
    """Also of hairs thinner than a texel and specks smaller than one."""
    clutter = ClutterSpec(speck_mm=0.08, speck_sigma=0.2, hair_width_mm=(0.03, 0.03), **kind)
    amounts = clutter.amounts()
    low, high = np.array(BOX)
    items = list(strewn(amounts, 4, low - 250, high + 250))
    inside = [p for p in items if (p.outline > low + 1).all() and (p.outline < high - 1).all()]
    assert len(inside) > 5
    grid = Grid.over(low, high, 0.1)
    covered, counts = draw(np.ones(grid.shape, np.float32), grid, inside)
    expected = sum(p.area_mm2 for p in inside)
    # Overlaps, of a hair with itself as well, count once.
    assert covered.sum(dtype=float) * 0.01 == pytest.approx(expected, rel=0.01)
    assert sum(counts.values()) == len(inside)


@pytest.mark.parametrize("side", [0.03, 0.7])
def test_a_print_lies_where_its_outline_is(side):
    """By the centroid: within the part of a texel that its shares leave open."""
    corner = np.array([3.14, -2.72])
    square = corner + side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    grid = Grid.over((-5, -5), (5, 5), 0.1)
    covered, _ = draw(np.ones(grid.shape, np.float32), grid, [Print("speck", square, 0.5)])
    s, t = grid.axes()
    total = covered.sum(dtype=float)
    centroid = np.array([(covered * s).sum(), (covered * t[:, None]).sum()]) / total
    assert total * 0.01 == pytest.approx(side**2, rel=1e-4)
    assert np.abs(centroid - corner - side / 2).max() < (0.05 if side < 0.1 else 0.006)


def test_paper_is_no_clutter_and_clutter_leaves_the_paper():
    paper = BackgroundSpec(paper=PaperTexture(contrast=0.05))
    plain = board_texture(paper, ClutterSpec(), 4, *BOX)
    printed = board_texture(paper, dots(), 4, *BOX)
    assert not plain.clutter.any()
    bare = printed.clutter == 0
    assert 0.9 < bare.mean() < 1
    np.testing.assert_array_equal(plain.albedo[bare], printed.albedo[bare])
    assert (printed.albedo[printed.clutter > 0.01] < plain.albedo[printed.clutter > 0.01]).all()


@pytest.mark.slow
def test_specks_are_as_many_and_as_large_as_stated():
    """4.8 m2 of board; Poisson counts and log-normal sizes within four standard errors."""
    clutter = ClutterSpec(specks_per_100cm2=10, speck_mm=0.3, speck_sigma=0.5)
    low, high = np.array([-1000.0, -1200]), np.array([1000.0, 1200])
    found = [
        p
        for p in strewn(clutter.amounts(), 9, low, high)
        if (p.outline.mean(axis=0) > low).all() and (p.outline.mean(axis=0) < high).all()
    ]
    mean = 10 * 480
    assert abs(len(found) - mean) < 4 * math.sqrt(mean)
    diameter = np.sqrt([4 * p.area_mm2 / math.pi for p in found])
    logs = np.log(diameter)
    assert abs(logs.mean() - math.log(0.3)) < 4 * 0.5 / math.sqrt(len(found))
    assert logs.std() == pytest.approx(0.5, rel=4 / math.sqrt(2 * len(found)))
    contrast = np.array([p.contrast for p in found])
    assert 0.2 <= contrast.min() < 0.25
    assert 0.75 < contrast.max() <= 0.8
    # Strewn evenly: each ninth of a tile gets its share.
    centres = np.array([p.outline.mean(axis=0) for p in found])
    place = np.floor(centres % 100 / (100 / 3)).astype(int)
    ninths = np.bincount(place[:, 0] * 3 + place[:, 1], minlength=9)
    assert np.abs(ninths - mean / 9).max() < 4 * math.sqrt(mean / 9)


def test_a_speck_has_the_area_of_its_disc_whatever_its_shape():
    amounts = ClutterSpec(specks_per_100cm2=20, speck_mm=0.5, speck_sigma=0).amounts()
    found = list(strewn(amounts, 3, np.zeros(2), np.full(2, 100.0)))
    areas = [p.area_mm2 for p in found]
    np.testing.assert_allclose(areas, math.pi / 4 * 0.25, rtol=1e-9)
    widths = [np.ptp(p.outline[:, 0]) for p in found]
    assert np.std(widths) > 0.02, "they are not all discs"


def test_lines_have_their_length_and_width():
    clutter = ClutterSpec(
        hairs_per_100cm2=20,
        hair_mm=(10, 10),
        hair_width_mm=(0.1, 0.1),
        scratches_per_100cm2=20,
        scratch_mm=(30, 30),
        scratch_width_mm=(0.2, 0.2),
    )
    found = list(strewn(clutter.amounts(), 2, np.full(2, -200.0), np.full(2, 200.0)))
    for kind, expected in (("hair", 1.0), ("scratch", 6.0)):
        areas = [p.area_mm2 for p in found if p.kind == kind]
        assert len(areas) > 100
        assert np.mean(areas) == pytest.approx(expected, rel=0.01)
    for p in found:
        if p.kind == "scratch":
            extent = np.linalg.norm(np.ptp(p.outline, axis=0))
            assert 27 < extent < 31


@pytest.mark.slow
def test_each_level_has_more_of_everything_than_the_one_before():
    shares = []
    for level in LEVELS:
        texture = board_texture(BOARD, ClutterSpec(level=level), 8, (-150, -150), (150, 150))
        shares.append(0.0 if texture is None else texture.to_dict()["printed_share"])
    assert list(LEVELS) == ["none", "light", "medium", "heavy", "hostile"]
    assert shares[0] == 0
    assert all(2 * a < b or a == 0 < b for a, b in pairwise(shares)), shares
    assert 0.003 < shares[-1] < 0.03
    amounts = list(LEVELS.values())
    for less, more in pairwise(amounts):
        for name in ("specks_per_100cm2", "scratches_per_100cm2", "hairs_per_100cm2"):
            assert getattr(less, name) < getattr(more, name)
        for name in ("dust_per_100cm2", "cables", "rods", "shadows"):
            assert getattr(less, name) <= getattr(more, name)


def test_a_figure_given_replaces_the_levels_and_no_other():
    amounts = ClutterSpec(level="heavy", cables=0, contrast=(0.5, 0.6)).amounts()
    heavy = LEVELS["heavy"]
    assert (amounts.cables, amounts.contrast) == (0, (0.5, 0.6))
    assert (amounts.rods, amounts.specks_per_100cm2) == (heavy.rods, heavy.specks_per_100cm2)
    assert ClutterSpec().amounts() == LEVELS["none"]
    assert not ClutterSpec().amounts().prints()


@pytest.mark.parametrize(
    "wrong",
    [
        {"level": "awful"},
        {"specks": 3},
        {"specks_per_100cm2": -1},
        {"cables": 1.5},
        {"contrast": (0.8, 0.2)},
        {"contrast": (0.8, 1.2)},
        {"hair_mm": (5, 5000)},
        {"cable_diameter_mm": (1, 50)},
        {"seed": -1},
    ],
)
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(ValidationError):
        ClutterSpec.model_validate(wrong)
