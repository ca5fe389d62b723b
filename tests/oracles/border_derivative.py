"""The derivative of an image by a shift, without any step: light along the borders of pixels.

A pixel integrates radiance over its square. When the image moves by du, what enters through its
left border does so at the rate of the radiance there, integrated along the border, and what leaves
through the right border likewise (the divergence theorem). A needle that moves parallel to the
image plane moves its image so, up to the perspective of its own thickness (0.5 %) and its motion
against the light; the smooth board's own gradient is counted in.
"""

from __future__ import annotations

import numpy as np


def shift_derivatives(needle, side, pixels, samples, seed):
    """Give (n, groups, 3) by a shift of 1 px along u, and along v.

    Parameters
    ----------
    needle
        A `MovableNeedle`.
    side
        Which camera, a pinhole.
    pixels
        (n,) flat indices.
    samples
        Along each border.
    seed
        Of the samples.
    """
    from simtip.render.engine import dr, mi
    from simtip.render.sobol import points_of
    from simtip.render.transport import radiance

    stage, eye = needle._stage, needle._looks[side].eye
    groups = stage.backdrop.groups

    def border(at):
        found = []
        for part in np.array_split(pixels, max(1, len(pixels) * samples // (1 << 21))):
            points, index = points_of(part, samples, seed)
            pixel = dr.gather(mi.UInt32, mi.UInt32(part), index)
            ray = eye.chief_rays(pixel, at(points.pixel().x))
            shares, _, _ = radiance(stage.world, stage.backdrop, ray, points)
            values = [channel for share in shares for channel in share]
            dr.eval(values)
            found.append(np.stack([dr.block_sum(v, samples).numpy() / samples for v in values], 1))
        return np.concatenate(found).reshape(-1, groups, 3)

    left, right = (border(lambda t, x=x: mi.Point2f(x, t)) for x in (0.0, 1.0))
    top, bottom = (border(lambda t, y=y: mi.Point2f(t, y)) for y in (0.0, 1.0))
    return left - right, top - bottom
