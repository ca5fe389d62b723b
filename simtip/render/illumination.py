"""Light that falls on a matt point: from each lamp on its own, and ways into the room."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simtip.render.engine import dr, mi
from simtip.render.sobol import Points

if TYPE_CHECKING:
    from simtip.render.lamps import Lamp

Vec = Any  # a Dr.Jit array of the active variant: these types exist only once it is set


def matt_point(point: Vec, normal: Vec) -> Vec:
    """Make the interaction from which rays are spawned."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.p, si.n, si.t = point, normal, mi.Float(1)
    return si


def direct(lamps: list[Lamp], scene: Any, si: Vec, points: Points) -> tuple[list[Vec], Vec]:
    """Give irradiance / pi per lamp of unit radiance, one sample each, and who met a shadow.

    Parameters
    ----------
    lamps
        The light groups.
    scene
        What throws shadows; None: nothing does.
    si
        Points and normals.
    points
        Random numbers.
    """
    shares, blocked = [], dr.zeros(mi.Float, dr.width(si.p)) > 0
    for lamp in lamps:
        share = dr.zeros(mi.Float, dr.width(si.p))
        for number, body in lamp.bodies:
            sample = body.sample(si.p, points.lamp(number))
            cosine = dr.dot(si.n, sample.direction)
            lit = (cosine > 0) & (sample.weight > 0)
            if scene is not None:
                shadow = lit & scene.ray_test(si.spawn_ray_to(sample.point), lit)
                blocked |= shadow
                lit &= ~shadow
            share += dr.select(lit, cosine * sample.weight * dr.inv_pi, 0)
        shares.append(share)
    return shares, blocked


def room_ray(si: Vec, points: Points) -> Vec:
    """Send a ray in a direction of cosine density about the normal."""
    towards = mi.warp.square_to_cosine_hemisphere(points.room())
    return si.spawn_ray(mi.Frame3f(si.n).to_world(towards))
