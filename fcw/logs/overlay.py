"""What is drawn over a frame, said once for every surface: logs, viewers, exports."""

from dataclasses import dataclass

from fcw.camera.calibration import Calibration
from fcw.detection.types import Box
from fcw.logs.records import FrameResult
from fcw.tracking.types import Track
from fcw.units import distance_text
from fcw.warning.types import WarningLevel

Rgb = tuple[int, int, int]

LEVEL_COLORS: dict[WarningLevel, Rgb] = {
    WarningLevel.NONE: (40, 165, 80),
    WarningLevel.ADVISORY: (50, 130, 235),
    WarningLevel.CAUTION: (235, 145, 0),
    WarningLevel.WARNING: (255, 48, 48),
}
"""Colour of the lead vehicle at each level. All colours here read on light and on dark ground."""
OTHER_TRACK_COLOR: Rgb = (145, 115, 225)
ROW_COLOR: Rgb = (0, 145, 170)
ROW_DISTANCES_M = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 80.0)
MINIMUM_ROW_GAP_PX = 6.0


@dataclass(frozen=True, slots=True)
class OverlayBox:
    """A vehicle's box with the words beside it."""

    box: Box
    label: str
    color: Rgb
    is_lead: bool


@dataclass(frozen=True, slots=True)
class OverlayRow:
    """A line across the picture at a distance."""

    row_px: float
    distance_m: float
    label: str


def overlay_boxes(result: FrameResult, imperial: bool = False) -> tuple[OverlayBox, ...]:
    """Boxes of all tracks; the lead in the colour of the warning level, the others violet."""
    return tuple(
        OverlayBox(
            track.box,
            track_label(track, imperial),
            LEVEL_COLORS[result.warning.level] if track.track_id == result.lead_id else OTHER_TRACK_COLOR,
            track.track_id == result.lead_id,
        )
        for track in result.tracks
    )


def track_label(track: Track, imperial: bool = False) -> str:
    """Distance, and the TTC where it is under ten seconds."""
    text = distance_text(track.distance_m, imperial)
    return text if track.ttc_s is None or track.ttc_s > 10 else f"{text}  {track.ttc_s:.1f} s"


def overlay_rows(calibration: Calibration, imperial: bool = False) -> tuple[OverlayRow, ...]:
    """Distance rows inside the picture, thinned where they would stand too close together."""
    rows: list[OverlayRow] = []
    for distance_m in ROW_DISTANCES_M:
        row_px = float(calibration.row_at(distance_m))
        inside = -0.5 <= row_px <= calibration.image_size.height - 0.5
        if inside and (not rows or rows[-1].row_px - row_px >= MINIMUM_ROW_GAP_PX):
            rows.append(OverlayRow(row_px, distance_m, distance_text(distance_m, imperial)))
    return tuple(rows)
