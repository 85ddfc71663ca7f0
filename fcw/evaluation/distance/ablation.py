"""The tracker without one of the things it goes by, to see what each is worth."""

from collections.abc import Iterable
from dataclasses import replace

from fcw.evaluation.distance.cues import Cue
from fcw.tracking.range.model import VehicleKind
from fcw.tracking.tracker import TrackerSettings

UNKNOWN_SIZE = VehicleKind(share=1.0, width_m=1.7, width_sigma=1.0, height_m=1.5, height_sigma=1.0)
"""A vehicle of any size: a factor of 2.7 either way."""
ROW_NOISE_RATIO = 1e4
"""An edge with so much noise may always be the picture's border, and is never measured."""


def without_cues(settings: TrackerSettings, cues: Iterable[Cue]) -> TrackerSettings:
    """Settings of a tracker that does without some cues.

    Args:
        settings: of the whole tracker.
        cues: `pitch`: no vehicle tells of the camera, so that its pitch stays as calibrated; `width`: no
            belief in usual widths and heights; `row`: no lower edge is measured. `ego-speed` is no setting:
            the tracker is not told it.
    """
    model, noise = settings.model, settings.box_noise
    for cue in cues:
        if cue == "pitch":
            model = replace(model, common_path_m=-1.0)
        elif cue == "width":
            model = replace(model, rears=(UNKNOWN_SIZE,), turned=())
        elif cue == "row":
            noise = replace(noise, bottom_ratio=ROW_NOISE_RATIO)
    return replace(settings, model=model, box_noise=noise)
