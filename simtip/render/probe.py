"""Try a renderer back end in a process of its own, since a bad LLVM aborts the whole process.

Run as ``python -m simtip.render.probe VARIANT``; prints one JSON line, or dies. The environment
variable DRJIT_LIBLLVM_PATH says which LLVM is tried.
"""

from __future__ import annotations

import json
import sys


def render_trifle(variant: str) -> float:
    """Render a lit plate and give its mean, pi * albedo / pi = 0.5 for a unit environment."""
    import mitsuba as mi

    mi.set_variant(variant)
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sensor": {
                "type": "orthographic",
                "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
                "sampler": {"type": "independent", "sample_count": 16},
            },
            "plate": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().translate([0, 0, 2]).rotate([0, 1, 0], 180),
                "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
            },
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
        }
    )
    # The kernel has minima, maxima and ray tracing in it: what LLVM 14 and 15 cannot select.
    return float(mi.TensorXf(mi.render(scene, spp=16)).array.numpy().mean())


def main() -> None:
    """Print ``{"ok": ..., "mean": ...}`` for the variant named on the command line."""
    mean = render_trifle(sys.argv[1])
    sys.stdout.write(json.dumps({"ok": abs(mean - 0.5) < 0.05, "mean": mean}) + "\n")


if __name__ == "__main__":
    main()
