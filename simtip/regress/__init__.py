"""Has a detector become worse? A suite of scenes, a baseline of what it found there, a check."""
