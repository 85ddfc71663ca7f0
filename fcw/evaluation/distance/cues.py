"""What the tracker goes by; apart from `ablation`, so that the command line loads quickly."""

from typing import Literal

Cue = Literal["pitch", "width", "row", "ego-speed"]
