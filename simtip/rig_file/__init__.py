"""Stereo rigs in files: OpenCV FileStorage (YAML, XML), ROS camera_info, Kalibr, JSON.

Each format has its own convention and unit; all are converted here, on reading and on writing, to
`StereoRig`'s: millimetres, ``p_left = R p_right + t``. What a format cannot hold is refused.
"""

from simtip.rig_file.read import read_rig
from simtip.rig_file.write import FORMATS, Format, rig_files, rig_text, write_rig

__all__ = ["FORMATS", "Format", "read_rig", "rig_files", "rig_text", "write_rig"]
