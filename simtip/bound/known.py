"""A bound worked out before: what efficiency wants of it, and which scene it is of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simtip.bound.inputs import PARTS, bound_digests
from simtip.bound.result import TipBound
from simtip.errors import InputError
from simtip.spec import SceneSpec


@dataclass(frozen=True)
class KnownBound:
    """The bound of one scene's tip in space, all nuisances free.

    Attributes
    ----------
    norm_mm
        Root of the sum of the squares of x, y, z, mm; None where the images do not determine it.
    inputs_sha256
        Of which scene it is: `simtip.bound.bound_digests`.
    file
        Where it was read from, for messages.
    """

    norm_mm: float | None
    inputs_sha256: Mapping[str, str]
    file: str | None = None

    @classmethod
    def of(cls, bound: TipBound) -> KnownBound:
        """Take it from a bound just worked out."""
        data = bound.to_dict()
        return cls(data["bound_mm"]["norm"], data["inputs_sha256"])

    def require_scene(self, spec: SceneSpec, seed: int | None = None) -> None:
        """Refuse any scene but the one that the bound is of.

        Parameters
        ----------
        spec
            The scene, as given: its exposure not settled. What no bound depends on, such as the
            detector, may differ.
        seed
            Root of its clutter and paper; by default the scene's own.

        Raises
        ------
        InputError
            It is another scene; `field` names the first part that differs.
        """
        wanted = bound_digests(spec, seed)
        for part in PARTS:
            if self.inputs_sha256.get(part) != wanted[part]:
                raise InputError(
                    f"is the bound of another scene than {spec.name!r}: not the same {part}",
                    file=self.file,
                    field=f"inputs_sha256.{part}",
                    remedy="work it out anew, of this scene and seed: "
                    "simtip bound SCENE --json > FILE",
                )
