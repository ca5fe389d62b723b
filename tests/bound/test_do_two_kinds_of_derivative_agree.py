"""Central differences of moved renders, against derivatives that move nothing."""

import numpy as np
import pytest
from bound_scenes import square_pixels
from oracles.border_derivative import shift_derivatives
from oracles.projective_derivative import coverage_derivatives

from simtip.bound import Information, tip_bound
from simtip.bound.pose import VIEW_PLACE, ViewMoves
from simtip.bound.tip import watch
from simtip.geometry import Pose
from simtip.render import choose, movable_needle
from simtip.simulation import expose_pair
from simtip.truth import scene_truth

SEEDS = 4


def energy(one: np.ndarray, other: np.ndarray) -> float:
    return float((one * other).sum())


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
def test_edges_move_as_projective_sampling_says(tip_scene, side):
    """The coverage's derivative, by every move but the roll of a round needle."""
    backend = choose("llvm")
    spec = square_pixels(tip_scene)
    truth = scene_truth(spec)
    moves = ViewMoves.of(truth, side)
    axes = moves.axes
    rates = [lambda p, k=k: np.tile(moves.place[:, k], (len(p), 1)) for k in range(3)] + [
        lambda p, a=a: np.cross(a, p - moves.tip_mm) for a in (axes.across, axes.depth)
    ]
    rig = spec.rig.rig()
    camera, T_wc = (rig.left, Pose.identity()) if side == "left" else (rig.right, rig.T_lr)
    other = coverage_derivatives(spec, camera, T_wc, rates, range(SEEDS), backend=backend)
    with movable_needle(spec, backend=backend, seed=1) as needle:
        band = needle.band(side)
        samples = np.full(len(band), 4096)
        for k, name in enumerate((*VIEW_PLACE, "tilt", "turn")):
            step = moves.step(name, 0.02)
            forth, back = (
                needle.look(side, band, moves.moved(name, sign * step), samples).coverage
                for sign in (1, -1)
            )
            mine = (forth - back) / (2 * step)
            theirs = other[:, k].reshape(SEEDS, -1)[:, band]
            truth_energy = energy(theirs[:2].mean(axis=0), theirs[2:].mean(axis=0))
            print(name, energy(mine, theirs.mean(axis=0)) / truth_energy, energy(mine, mine)/truth_energy)
            assert energy(mine, theirs.mean(axis=0)) == pytest.approx(truth_energy, rel=0.03), name


@pytest.mark.slow
@pytest.mark.parametrize("side", ["left", "right"])
def test_light_through_pixel_borders_gives_the_same_bound(tip_scene, side):
    """Along and across, nuisances known: no step, no moved needle."""
    backend = choose("llvm")
    bound = tip_bound(tip_scene, backend=backend, samples=2048, check=False)
    wanted = bound.views[side].known_deviations_px()
    with movable_needle(tip_scene, backend=backend, seed=1) as needle:
        spec = expose_pair(tip_scene, needle.views, seed=1, backend=backend).spec
        moves = ViewMoves.of(scene_truth(spec), side)
        watched = watch(spec, moves, needle, side, 512)
        picture, band = watched.picture, watched.band
        beside = needle.views[0 if side == "left" else 1].coverage.reshape(-1)[band] == 0
        replicas = []
        for seed in range(SEEDS):
            by_u, by_v = (
                picture.mixed(light)
                for light in shift_derivatives(needle, side, band, 2048, seed)
            )
            a_u, a_v = moves.axis_px
            ways = [a_u * by_u + a_v * by_v, -a_v * by_u + a_u * by_v]
            replicas.append(
                [
                    picture.irradiance(np.maximum(d, 0), alone=True)
                    - picture.irradiance(np.maximum(-d, 0), alone=True)
                    for d in ways
                ]
            )
        view = picture.irradiance(picture.mixed(needle.look(side, band, Pose.identity(), np.full(len(band), 256)).total))
        told = picture.information(view)
    found = Information.from_derivatives(
        VIEW_PLACE[:2], np.reshape(replicas, (SEEDS, 2, -1)), told.reshape(-1)
    ).deviations([{name: 1.0} for name in VIEW_PLACE[:2]])
    print(found, wanted)
    np.testing.assert_allclose(found, wanted, rtol=0.03)
