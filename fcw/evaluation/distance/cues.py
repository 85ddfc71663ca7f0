"""What the tracker goes by; apart from `ablation`, so that the command line loads quickly."""

from typing import Literal, get_args

Cue = Literal["pitch", "width", "row", "ego-speed"]
CUES: tuple[Cue, ...] = get_args(Cue)
