"""A camera for the tests, written down in a few lines of NumPy: nothing of simtip in it."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class BenchCamera:
    """One channel; the pattern belongs to `pattern_seed`, the noise to `noise_seed`."""

    K: float
    sigma_d_e: float
    full_well_e: float
    bit_depth: int
    black_dn: float
    prnu_percent: float = 1.0
    dsnu_e: float = 2.0
    dark_e_per_s: float = 20.0
    eta: float = 0.6
    shape: tuple[int, int] = (64, 64)
    pattern_seed: int = 1
    noise_seed: int = 2
    frames_taken: int = field(default=0, init=False)

    def __post_init__(self):
        pattern = np.random.default_rng(self.pattern_seed)
        self.response = 1 + pattern.standard_normal(self.shape) * self.prnu_percent / 100
        self.offset_e = pattern.standard_normal(self.shape) * self.dsnu_e
        self.rng = np.random.default_rng(self.noise_seed)

    def __call__(self, photons, exposure_s, count):
        mean = self.eta * photons * self.response + self.dark_e_per_s * exposure_s
        for _ in range(count):
            self.frames_taken += 1
            electrons = np.minimum(self.rng.poisson(mean), self.full_well_e)
            electrons = electrons + self.rng.standard_normal(self.shape) * self.sigma_d_e
            dn = np.rint(self.black_dn + self.K * (electrons + self.offset_e))
            frame = np.clip(dn, 0, 2**self.bit_depth - 1)
            yield frame.astype(np.uint8 if self.bit_depth <= 8 else np.uint16)


def noisy_8_bit(**change):
    own = {"K": 0.0255, "sigma_d_e": 5.0, "full_well_e": 9500, "bit_depth": 8, "black_dn": 4.0}
    return BenchCamera(**{**own, **change})


def quiet_12_bit(**change):
    own = {"K": 0.2, "sigma_d_e": 2.5, "full_well_e": 20000, "bit_depth": 12, "black_dn": 32.3}
    return BenchCamera(**{**own, "prnu_percent": 0.6, "dsnu_e": 1.5, **change})


def middling_10_bit(**change):
    own = {"K": 0.08, "sigma_d_e": 12.0, "full_well_e": 12000, "bit_depth": 10, "black_dn": 16.0}
    return BenchCamera(**{**own, "prnu_percent": 0.8, "dsnu_e": 4.0, **change})


def counting_12_bit(**change):
    """So much gain that single electrons show: far from normal noise at low light."""
    own = {"K": 4.0, "sigma_d_e": 0.35, "full_well_e": 900, "bit_depth": 12, "black_dn": 100.0}
    return BenchCamera(**{**own, "prnu_percent": 2.0, "dsnu_e": 0.3, **change})


CAMERAS = {"8 bit": noisy_8_bit, "10 bit": middling_10_bit, "12 bit": quiet_12_bit}
