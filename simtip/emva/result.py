"""What a camera was found to be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from simtip.emva.estimate import Estimate
from simtip.emva.frames import Level

KEYS = (
    "K_dn_per_e",
    "sigma_d_e",
    "dark_current_e_per_s",
    "full_well_e",
    "prnu_percent",
    "dsnu_e",
    "snr_max",
)


@dataclass(frozen=True)
class CameraCharacteristics:
    """EMVA 1288 parameters of one channel; `simtip.emva.characterise` defines each.

    Attributes
    ----------
    K_dn_per_e
        System gain, DN/e-.
    sigma_d_e
        Temporal dark noise without exposure, e-.
    dark_current_e_per_s
        Dark current from means, e-/s.
    dark_current_by_variance_e_per_s
        The same from variances: a check.
    full_well_e
        Where the signal stops, e-; see `full_well_limit`.
    full_well_limit
        "well": electrons clip first; "adc": the top code does, so the well holds more than that;
        None: not seen.
    saturation_capacity_e
        The standard's: signal at the greatest temporal variance, e-. Its interval reaches to the
        neighbouring levels.
    prnu_percent, dsnu_e
        Photo response and dark signal non-uniformity, % and e-.
    snr_max
        ``sqrt(full_well_e)``.
    quantum_efficiency
        Electrons per photon; missing if photon numbers are relative.
    black_level_dn
        Mean of these pixels without light and exposure, DN.
    photon_transfer
        Every level, by rising photons, for plotting.
    in_fit
        Which of them lie below 70 % of saturation and made K.
    notes
        What a reader should know before trusting the numbers, one sentence each.
    """

    K_dn_per_e: Estimate
    sigma_d_e: Estimate
    dark_current_e_per_s: Estimate
    dark_current_by_variance_e_per_s: Estimate
    full_well_e: Estimate
    full_well_limit: Literal["well", "adc"] | None
    saturation_capacity_e: Estimate
    prnu_percent: Estimate
    dsnu_e: Estimate
    snr_max: Estimate
    quantum_efficiency: Estimate
    black_level_dn: Estimate
    photon_transfer: tuple[Level, ...]
    in_fit: tuple[bool, ...]
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Give values under their names, and `ci99` and `reasons` under the same names.

        A missing value is None in all places but `reasons`.
        """
        found: dict[str, Estimate] = {key: getattr(self, key) for key in KEYS}
        return {
            **{key: estimate.value for key, estimate in found.items()},
            "ci99": {key: estimate.ci99() for key, estimate in found.items()},
            "reasons": {key: e.reason for key, e in found.items() if e.reason},
            "full_well_limit": self.full_well_limit,
            "notes": list(self.notes),
        }
