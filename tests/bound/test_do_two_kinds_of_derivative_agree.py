"""Central differences of moved renders, against derivatives that move nothing."""

from __future__ import annotations

import numpy as np
import pytest
from bound_scenes import square_pixels
from oracles.border_derivative import shift_derivatives
from oracles.projective_derivative import coverage_derivatives

from simtip.bound import Information, tip_bound
from simtip.bound.pose import STEP_PX, VIEW_PLACE, ViewMoves
from simtip.bound.tip import watch
from simtip.geometry import Pose
from simtip.render import choose, movable_needle
from simtip.simulation import expose_pair
from simtip.truth import scene_truth

SEEDS = 4
ALONG_ACROSS = VIEW_PLACE[:2]


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
def test_edges_move_as_projective_sampling_says(tip_scene, side):
    """The coverage's derivative; a cone looks the same when it moves along the line of sight."""
    backend = choose("llvm")
    spec = square_pixels(tip_scene)
    moves = ViewMoves.of(scene_truth(spec), side)
    rates = {
        "along_px": lambda p: np.tile(moves.place[:, 0], (len(p), 1)),
        "across_px": lambda p: np.tile(moves.place[:, 1], (len(p), 1)),
        "turn": lambda p: np.cross(moves.axes.depth, p - moves.tip_mm),
    }
    rig = spec.rig.rig()
    camera, T_wc = (rig.left, Pose.identity()) if side == "left" else (rig.right, rig.T_lr)
    other = coverage_derivatives(spec, camera, T_wc, rates.values(), range(SEEDS), backend=backend)
    with movable_needle(spec, backend=backend, seed=1) as needle:
        band = needle.band(side)
        samples = np.full(len(band), 1024)
        for k, name in enumerate(rates):
            step = moves.step(name, STEP_PX)
            forth, back = (
                needle.look(side, band, moves.moved(name, sign * step), samples).coverage
                for sign in (1, -1)
            )
            mine = (forth - back) / (2 * step)
            theirs = other[:, k].reshape(SEEDS, -1)[:, band]
            # Products of independent estimates: their noise adds nothing.
            energy = (theirs[:2].mean(axis=0) * theirs[2:].mean(axis=0)).sum()
            assert (mine * theirs.mean(axis=0)).sum() == pytest.approx(energy, rel=0.03), name


@pytest.mark.slow
def test_light_through_pixel_borders_gives_the_same_bound(tip_scene):
    """Along and across, nuisances known: no step, no moved needle."""
    backend = choose("llvm")
    bound = tip_bound(tip_scene, backend=backend, samples=96, check=False)
    with movable_needle(tip_scene, backend=backend, seed=1) as needle:
        spec = expose_pair(tip_scene, needle.views, seed=1, backend=backend).spec
        for side in ("left", "right"):
            moves = ViewMoves.of(scene_truth(spec), side)
            found = through_borders(spec, needle, side, moves)
            np.testing.assert_allclose(
                found, bound.views[side].known_deviations_px(), rtol=0.03, err_msg=side
            )


def through_borders(spec, needle, side, moves):
    watched = watch(spec, moves, needle, side, 256)
    picture, band = watched.picture, watched.band
    replicas = []
    for seed in range(SEEDS):
        by_u, by_v = map(picture.mixed, shift_derivatives(needle, side, band, 256, seed))
        a_u, a_v = moves.axis_px
        ways = [a_u * by_u + a_v * by_v, -a_v * by_u + a_u * by_v]
        replicas.append(
            [
                picture.irradiance(np.maximum(d, 0), alone=True)
                - picture.irradiance(np.maximum(-d, 0), alone=True)
                for d in ways
            ]
        )
    light = needle.look(side, band, Pose.identity(), np.full(len(band), 256))
    told = picture.information(picture.irradiance(picture.mixed(light.total)))
    return Information.from_derivatives(
        ALONG_ACROSS, np.reshape(replicas, (SEEDS, 2, -1)), told.reshape(-1)
    ).deviations([{name: 1.0} for name in ALONG_ACROSS])
