"""Pairs of images and their truth, written as other programs read them: one module a format.

No format knows where the pairs come from (`simtip.image_sets`). All are streamed: what is in memory
at a time is one pair. ``docs/export.md`` states the conventions of each format.
"""

from simtip.export.formats import FORMATS, Format, Settings, write_export

__all__ = ["FORMATS", "Format", "Settings", "write_export"]
