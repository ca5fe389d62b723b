"""simtip: synthetic-rendering validation for stereo needle-tip measurement."""

__version__ = "0.1.0"
