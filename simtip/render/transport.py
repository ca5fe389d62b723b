"""Light transport of this scene: what one camera ray brings back, per light group.

A path is camera - [mirror -] surface - lamp, camera - mirror - lamp, or camera - lamp, where a
surface is the background, clutter or a wall, and a mirror the needle or the coat of glossy clutter.
Each lamp is sampled on its own, so that its noise does not grow with their number (in a mirror they
share the mirrored ray, and their noise is correlated); the background's light comes from
`simtip.render.lightmap`. Left out: light that reaches the background by way of a mirror (caustics,
under 0.4 % of the background close to the needle), and light from the background by way of the room
(`ambient` stands for that).

All results are radiance per unit lamp radiance: light is linear, so lamp power, exposure and colour
are applied afterwards without rendering again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from simtip.render.backdrop import Backdrop
from simtip.render.engine import dr, mi
from simtip.render.illumination import direct, matt_point, room_ray
from simtip.render.sobol import Points
from simtip.render.world import Thing, World

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


def on_background(world: World, ray: Vec, si: Vec) -> Vec:
    """Say which rays meet the lit side of the background."""
    return si.is_valid() & (si.shape == world.background) & (dr.dot(si.n, ray.d) < 0)


def on_clutter(things: Iterable[Thing], si: Vec) -> Vec:
    """Say which rays meet one of these pieces of clutter."""
    met = mi.Mask(False)
    for thing in things:
        met |= si.shape == thing.shape
    return met & si.is_valid()


def without_lamps(world: World, backdrop: Backdrop, ray: Vec, si: Vec) -> tuple[list[Vec], Vec]:
    """Give what rays that met `si` bring from background and surroundings, and prints' coverage."""
    matt = on_background(world, ray, si)
    lit, printed = backdrop.radiance(si.p, matt)
    free = ~si.is_valid()
    beyond = world.surround.light(ray, free)
    shares = [
        dr.select(matt, a, 0) + dr.select(free, mi.Color3f(b), 0)
        for a, b in zip(lit, beyond, strict=True)
    ]
    return shares, dr.select(matt, printed, 0)


def reflected(
    world: World,
    backdrop: Backdrop,
    bsdf: Vec,
    si: Vec,
    points: Points,
    lobe: tuple[Vec, Vec],
    active: Vec,
    kinds: int | None = None,
) -> list[Vec]:
    """Give the radiance that a material throws back: lamps (two techniques, weighted), all else.

    Parameters
    ----------
    world, backdrop
        What there is.
    bsdf
        The material, one or one per ray.
    si
        Where rays meet it.
    points
        Random numbers for the lamps.
    lobe
        And for the way on: one number and two.
    active
        Which rays count.
    kinds
        Which kinds of reflection count (`mitsuba.BSDFFlags`); None: all.
    """
    context = mi.BSDFContext()
    if kinds is not None:
        context.type_mask = kinds
    shares = [mi.Color3f(0) for _ in range(len(world.lamps) + 1)]
    for k, lamp in enumerate(world.lamps):
        for number, body in lamp.bodies:
            sample = body.sample(si.p, points.lamp(number))
            value, pdf = bsdf.eval_pdf(context, si, si.to_local(sample.direction), active)
            lit = active & (sample.weight > 0) & (pdf > 0)
            lit &= ~world.scene.ray_test(si.spawn_ray_to(sample.point), lit)
            weight = sample.weight * power_heuristic(sample.pdf, pdf)
            shares[k] += dr.select(lit, value * weight, 0)

    mirrored, value = bsdf.sample(context, si, *lobe, active)
    sent = active & (mirrored.pdf > 0)
    away = si.spawn_ray(si.to_world(mirrored.wo))
    there = world.scene.ray_intersect(away, sent)
    for k, lamp in enumerate(world.lamps):
        for hit, body in lamp.hits(there, away):
            other = body.pdf(si.p, there.p, there.n)
            shares[k] += dr.select(sent & hit, value * power_heuristic(mirrored.pdf, other), 0)
    seen, _ = without_lamps(world, backdrop, away, there)
    mirrored_clutter = sent & on_clutter(world.clutter, there)
    for k, share in enumerate(seen):
        shares[k] += dr.select(sent, value * share, 0)
    if world.clutter:
        # Clutter lies near the board: in the mirror it is lit as the board beneath it.
        st = backdrop.coordinates(there.p)
        for k, light in enumerate(backdrop.light(st, mirrored_clutter)):
            albedo = there.bsdf().eval_diffuse_reflectance(there, mirrored_clutter)
            shares[k] += dr.select(mirrored_clutter, value * albedo * light, 0)
    return shares


def matt(world: World, backdrop: Backdrop, si: Vec, points: Points, active: Vec) -> list[Vec]:
    """Give the radiance of matt clutter: lamps, room, and what the board throws back at it."""
    place = matt_point(si.p, si.n)
    lit, _ = direct(world.lamps, world.scene, place, points)
    away = room_ray(place, points)
    there = world.scene.ray_intersect(away, active)
    back, _ = without_lamps(world, backdrop, away, there)
    albedo = si.bsdf().eval_diffuse_reflectance(si, active)
    return [
        dr.select(active, albedo * (share + other), 0)
        for share, other in zip([*lit, mi.Float(0)], back, strict=True)
    ]


def glossy(world: World, backdrop: Backdrop, si: Vec, points: Points, active: Vec) -> list[Vec]:
    """Give the radiance of glossy clutter: what its coat mirrors, and what its matt body shows.

    Both ways are followed, not one chosen by chance: the coat mirrors a twentieth of what it sees.
    """
    coat = reflected(world, backdrop, world.coat, si, points, points.lobe(), active)
    below = mi.Float(0), points.room()
    diffuse = int(mi.BSDFFlags.DiffuseReflection)
    body = reflected(world, backdrop, si.bsdf(), si, points, below, active, diffuse)
    return [share + other for share, other in zip(coat, body, strict=True)]


def radiance(
    world: World, backdrop: Backdrop, ray: Vec, points: Points
) -> tuple[list[Vec], Vec, Vec]:
    """Give radiance per group (ambient last), and whether rays meet the subject, or clutter."""
    si = world.scene.ray_intersect(ray)
    subject = world.subject.met(si)
    shares, printed = without_lamps(world, backdrop, ray, si)
    for k, share in enumerate(world.subject.radiance(world, backdrop, ray, si, points, subject)):
        shares[k] += share
    if world.clutter:
        dull = on_clutter((thing for thing in world.clutter if not thing.glossy), si)
        for k, share in enumerate(matt(world, backdrop, si, points, dull)):
            shares[k] += share
        coated = [thing for thing in world.clutter if thing.glossy]
        if coated:
            for k, share in enumerate(glossy(world, backdrop, si, points, on_clutter(coated, si))):
                shares[k] += share
        seen = on_clutter((thing for thing in world.clutter if thing.in_view), si)
        printed = dr.select(seen, 1, printed)
    for k, lamp in enumerate(world.lamps):
        for hit, _ in lamp.hits(si, ray):
            shares[k] += dr.select(hit, mi.Color3f(1), 0)
    return shares, dr.select(subject, mi.Float(1), 0), printed


def power_heuristic(pdf: Vec, other: Vec) -> Vec:
    """Weigh a sample against another technique (Veach and Guibas 1995, exponent 2)."""
    ratio = other / pdf
    return dr.rcp(1 + dr.square(ratio))
