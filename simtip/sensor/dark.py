"""Dark current: electrons that no photon made."""

from __future__ import annotations

from simtip.spec import SensorSpec


def dark_factor(temperature_c: float, reference_c: float, doubling_k: float) -> float:
    """Give ``2^((T - T_ref) / T_d)``, the growth of dark current (EMVA 1288, "dark current")."""
    return float(2 ** ((temperature_c - reference_c) / doubling_k))


def dark_electrons(spec: SensorSpec) -> float:
    """Give the mean dark electrons of an ordinary pixel in one exposure, ``mu_I t``, e-."""
    return spec.dark_current_e_per_s * _exposure_at_reference_s(spec)


def hot_electrons(spec: SensorSpec) -> float:
    """Give what a hot pixel collects beside that, on average, e-."""
    return spec.hot_current_e_per_s * _exposure_at_reference_s(spec)


def _exposure_at_reference_s(spec: SensorSpec) -> float:
    """Give the exposure at the reference temperature that makes as many dark electrons, s."""
    if not spec.effects.dark_current:
        return 0.0
    factor = dark_factor(spec.temperature_c, spec.dark_reference_c, spec.dark_doubling_k)
    return spec.exposure_s * factor
