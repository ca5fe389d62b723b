"""The needle's geometry, and the one definition of its tip.

Needle frame, mm: z runs along the axis from the tip to the hub, the axis is x = y = 0, the
foremost point of the solid has z = 0 and the hub's end face z = length. Of a bent needle, z is the
tangent of its axis at the tip. The **tip** is the apex: one 3-D point of the solid, the foremost,
`Needle.apex`. What a camera sees foremost, the extreme point of the silhouette, is another thing
for bevelled and rounded tips: `simtip.silhouette` gives that one.

A new kind of tip is a frozen dataclass with the members of `simtip.needle.tip.Tip`; one that planes
leave is a subclass of `simtip.needle.ground.GroundTip`.
"""

from simtip.needle.bevels import BackBevel, Bevel, Lancet
from simtip.needle.cone import Cone
from simtip.needle.solid import BENT_SEGMENTS, ROUNDED_SEGMENTS, SAGITTA_MM, SEGMENTS, Needle
from simtip.needle.symmetric import Blunt, Diamond, Franseen, Trocar
from simtip.needle.tip import Faces, Front, Tip

__all__ = [
    "BENT_SEGMENTS",
    "ROUNDED_SEGMENTS",
    "SAGITTA_MM",
    "SEGMENTS",
    "BackBevel",
    "Bevel",
    "Blunt",
    "Cone",
    "Diamond",
    "Faces",
    "Franseen",
    "Front",
    "Lancet",
    "Needle",
    "Tip",
    "Trocar",
]
