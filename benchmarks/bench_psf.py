"""How long the lens's blur takes on a full-size image, against one Gaussian blur by OpenCV.

The paper's lens and pixel, with 2 um of aberration; the measure is `cv2.GaussianBlur` of all three
channels with the same aberration, which has no diffraction. One thread.

    python benchmarks/bench_psf.py [--quick]
"""

from __future__ import annotations

import cv2
import numpy as np
from environment import best_s, parser, report

from simtip.psf import Psf, blur
from simtip.seeding import stream
from simtip.spec import SensorSpec

ABERRATION_UM = 2.0


def main() -> None:
    """Measure and print."""
    quick = parser(__doc__).parse_args().quick
    height, width, repeats = (64, 96, 1) if quick else (1436, 2048, 15)
    cv2.setNumThreads(1)
    spec = SensorSpec(exposure_s=0.04)
    lens = (1.4, spec.wavelength_nm, spec.pixel_um)
    psfs = {
        "both": Psf(*lens, ABERRATION_UM),
        "diffraction": Psf(*lens),
        "gaussian": Psf(*lens, ABERRATION_UM, diffraction=False),
        "both_at_f4": Psf(4.0, *lens[1:], ABERRATION_UM),
    }
    image = stream(1, "benchmark").random((height, width, 3), dtype=np.float32)
    for psf in psfs.values():
        blur(image, psf)  # its kernels are made once
    times_s = {
        name: best_s(lambda psf=psf: blur(image, psf), repeats) for name, psf in psfs.items()
    }
    sigma_px = psfs["both"].aberration_px
    gaussian_s = best_s(lambda: cv2.GaussianBlur(image, (5, 5), sigma_px), repeats)
    before, after = (x.sum(dtype=np.float64) for x in (image, blur(image, psfs["both"])))
    report(
        "psf",
        quick=quick,
        threads=cv2.getNumThreads(),
        size_px=[width, height],
        repeats=repeats,
        kernel_px=[len(psfs["both"].kernel(channel)) for channel in range(3)],
        make_kernels_s=best_s(
            lambda: [Psf(*lens, ABERRATION_UM).kernel(channel) for channel in range(3)], repeats
        ),
        blur_s=times_s,
        opencv_gaussian_s=gaussian_s,
        ratio_to_opencv_gaussian=times_s["both"] / gaussian_s,
        largest_relative_change_of_energy=float(abs(after / before - 1)),
    )


if __name__ == "__main__":
    main()
