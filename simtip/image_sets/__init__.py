"""What folders of simtip's hold: pairs of images with their truth, one at a time.

Each kind of folder has its reader, which checks all that it can before the first pair is given:
what is missing, cut short or edited is the user's error. Who uses the pairs knows no folders.
"""

from simtip.image_sets.folders import Contents, open_folders
from simtip.image_sets.pairs import BoardImages, BoardPair, NeedleImages, NeedlePair, Reading

__all__ = [
    "BoardImages",
    "BoardPair",
    "Contents",
    "NeedleImages",
    "NeedlePair",
    "Reading",
    "open_folders",
]
