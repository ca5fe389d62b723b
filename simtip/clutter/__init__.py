"""Paper texture and everything in the picture that is not the needle, as plain arrays.

`board_texture` gives what is printed on the board, `objects` the solid things about it. Both follow
from the scene and a seed alone and know the truth about what they made; nothing here renders.
"""

from simtip.clutter.objects import ClutterObject, grouped, objects, objects_truth
from simtip.clutter.setting import LampPlace, Setting
from simtip.clutter.texture import BoardTexture, board_texture

__all__ = [
    "BoardTexture",
    "ClutterObject",
    "LampPlace",
    "Setting",
    "board_texture",
    "grouped",
    "objects",
    "objects_truth",
]
