"""Light transport of this scene: what one camera ray brings back, per lamp.

A path is camera - [needle -] background - lamp, camera - needle - lamp, or camera - lamp. Each lamp
is sampled on its own, so that its noise does not grow with their number (on the needle they share
the mirrored ray, and their noise is correlated); the background's light comes
from `simtip.render.lightmap`. Left out: light that reaches the background by way of the needle
(caustics, under 0.4 % of the background close to the needle), and light from the background by way
of the room (`ambient` stands for the room).

All results are radiance per unit lamp radiance: light is linear, so lamp power, exposure and colour
are applied afterwards without rendering again.
"""

from __future__ import annotations

from typing import Any

from simtip.render.engine import dr, mi
from simtip.render.lightmap import Lookup
from simtip.render.world import World

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


def seen_lamps(world: World, ray: Vec, si: Vec) -> list[Vec]:
    """Say which lamp each ray meets from outside, and whether it leaves the scene (last)."""
    hits = [
        si.is_valid() & (si.shape == tube.shape) & (dr.dot(si.n, ray.d) < 0) for tube in world.tubes
    ]
    return [*hits, ~si.is_valid()]


def metal(world: World, light: Lookup, si: Vec, sampler: Vec, active: Vec) -> list[Vec]:
    """Radiance that the needle mirrors: lamps (by both techniques, weighted), background, room."""
    context = mi.BSDFContext()
    albedo = mi.Color3f(world.albedo.tolist())
    shares = [mi.Color3f(0) for _ in range(len(world.tubes) + 1)]
    for k, tube in enumerate(world.tubes):
        sample = tube.sample(si.p, sampler.next_2d())
        value, pdf = world.metal.eval_pdf(context, si, si.to_local(sample.direction), active)
        lit = active & (sample.weight > 0) & (pdf > 0)
        lit &= ~world.scene.ray_test(si.spawn_ray_to(sample.point), lit)
        weight = sample.weight * power_heuristic(sample.pdf, pdf)
        shares[k] += dr.select(lit, value * weight, 0)

    mirrored, value = world.metal.sample(context, si, sampler.next_1d(), sampler.next_2d(), active)
    lobe = active & (mirrored.pdf > 0)
    ray = si.spawn_ray(si.to_world(mirrored.wo))
    there = world.scene.ray_intersect(ray, lobe)
    *lamps, free = seen_lamps(world, ray, there)
    for k, (tube, hit) in enumerate(zip(world.tubes, lamps, strict=True)):
        other = tube.pdf(si.p, there.p, there.n)
        shares[k] += dr.select(lobe & hit, value * power_heuristic(mirrored.pdf, other), 0)
    shares[-1] += dr.select(lobe & free, value, 0)

    matt = lobe & on_background(world, ray, there)
    for k, lit in enumerate(light.at(there.p, matt)):
        shares[k] += dr.select(matt, value * albedo * lit, 0)
    return shares


def on_background(world: World, ray: Vec, si: Vec) -> Vec:
    """Say which rays meet the lit side of the background."""
    return si.is_valid() & (si.shape == world.background) & (dr.dot(si.n, ray.d) < 0)


def radiance(world: World, light: Lookup, ray: Vec, sampler: Vec) -> tuple[list[Vec], Vec]:
    """Radiance per lamp (and ambient, last), and whether each ray meets the needle."""
    si = world.scene.ray_intersect(ray)
    needle = si.is_valid() & (si.instance == world.needle)
    shares = metal(world, light, si, sampler, needle)
    matt = on_background(world, ray, si)
    albedo = mi.Color3f(world.albedo.tolist())
    for k, lit in enumerate(light.at(si.p, matt)):
        shares[k] += dr.select(matt, albedo * lit, 0)
    for k, hit in enumerate(seen_lamps(world, ray, si)):
        shares[k] += dr.select(hit, mi.Color3f(1), 0)
    return shares, needle


def power_heuristic(pdf: Vec, other: Vec) -> Vec:
    """Weigh a sample against another technique (Veach and Guibas 1995, exponent 2)."""
    ratio = other / pdf
    return dr.rcp(1 + dr.square(ratio))
