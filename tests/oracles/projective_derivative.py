"""Derivatives of a needle's coverage by Mitsuba's projective sampling, which moves no needle.

What moving edges contribute is sampled on the silhouette itself (Zhang et al. 2023, "Projective
sampling for differentiable rendering of geometry"). The needle shines, and nothing else does.

Its mesh is coarser here: with triangles as thin as the scene's (1024 around), Mitsuba 3.9 loses up
to a third of what one of the edges contributes, as the sum over a row of pixels shows, which has to
be 1 for a shift of 1 px.
"""

from __future__ import annotations

import numpy as np

from simtip.render.backend import activated

SAMPLES = 512
SEGMENTS = 128
"""Around the needle: 0.003 px off the circle."""


def coverage_derivatives(spec, camera, T_wc, moves, seeds, *, backend):
    """Give (seeds, moves, H, W) per unit of each move.

    Parameters
    ----------
    spec
        The scene.
    camera, T_wc
        With square pixels and no distortion.
    moves
        From the needle's mesh (n, 3), world, to how fast its points move (n, 3).
    seeds
        Of the samples.
    backend
        A vectorised one.
    """
    with activated(backend):
        from simtip.render.engine import dr, mi
        from simtip.render.mesh import mesh_of
        from simtip.render.stock import stock_scene
        from simtip.render.world import BLACK, GLOW

        described = stock_scene(spec, "needle")
        vertices, faces = spec.needle.needle().surface(SEGMENTS)
        described["needle"] = mesh_of(
            "needle", spec.needle.pose().apply(vertices), faces, {"bsdf": BLACK, "emitter": GLOW}
        )
        scene = mi.load_dict(described, parallel=False)
        sensor = mi.load_dict(_sensor(camera, T_wc, mi))
        integrator = mi.load_dict(
            {"type": "prb_projective", "max_depth": 1, "sppc": 0, "sppi": 0, "guiding": "none"}
        )
        parameters = mi.traverse(scene)
        rest = dr.copy(parameters["needle.vertex_positions"])
        points = np.array(rest).reshape(-1, 3)
        found = []
        for seed in seeds:
            for k, move in enumerate(moves):
                moved = mi.Float(rest)
                dr.enable_grad(moved)
                dr.set_grad(moved, mi.Float(move(points).astype(np.float32).ravel()))
                parameters["needle.vertex_positions"] = moved
                parameters.update()
                image = mi.render(
                    scene,
                    params=parameters,
                    sensor=sensor,
                    integrator=integrator,
                    spp=SAMPLES,
                    seed=20 * seed + 2 * k,
                )
                dr.forward_to(image)
                found.append(np.array(dr.grad(image))[..., 0])
    return np.reshape(found, (len(seeds), len(moves), camera.height, camera.width))


def _sensor(camera, T_wc, mi):
    to_world = np.eye(4)
    # Mitsuba's camera has x to the left and y up.
    to_world[:3, :3] = T_wc.R @ np.diag([-1.0, -1.0, 1.0])
    to_world[:3, 3] = T_wc.t
    K, width, height = camera.K, camera.width, camera.height
    return {
        "type": "perspective",
        "to_world": mi.ScalarTransform4f(to_world),
        "fov": float(np.degrees(2 * np.arctan(width / 2 / K[0, 0]))),
        "fov_axis": "x",
        "near_clip": 1.0,
        "far_clip": 1e5,
        # A film spans [0, width); pixel centres lie half a pixel in.
        "principal_point_offset_x": float(0.5 - (K[0, 2] + 0.5) / width),
        "principal_point_offset_y": float(0.5 - (K[1, 2] + 0.5) / height),
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": 16},
    }
