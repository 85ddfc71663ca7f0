"""What is drawn over a frame, said once for every surface: logs, viewers, exports."""

import math
from dataclasses import dataclass, replace

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.logs.records import FrameResult
from fcw.motion.state import SpeedSource
from fcw.tracking.lead import Corridor, rivals
from fcw.tracking.types import Track
from fcw.units import distance_text, speed_text
from fcw.warning.types import WarningLevel

Rgb = tuple[int, int, int]
PixelLine = tuple[tuple[float, float], ...]

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
MOST_TOLD, TOLD_ON_FREE_ROAD = 3, 2
"""Most vehicles with words, and how many have some where none is or may become the lead."""
MINIMUM_ROW_GAP_PX = 6.0
ROW_LABEL_PARTS = (0.03, 0.09, 0.15)
"""Where the words of the rows stand in turn, as parts of the width: far rows are close together."""
PITCH_STEP_RAD = 1e-3
"""A row at a focal length of 1000 px: smaller turns of the camera change nothing that is drawn."""
PATH_COLOR: Rgb = (60, 190, 110)
PATH_DRAWN_M = (4.0, 60.0)
PATH_POINTS = 24
PIXEL_CENTRE_PX = 0.5
"""Foxglove and rerun count from the corner of the top-left pixel, we from its centre."""
VEHICLE_LENGTH_M = 4.5
"""No length is seen from behind: vehicles on the road are drawn as long as a common car."""
OWN_CAR_SIZE_M = (VEHICLE_LENGTH_M, 1.8, 1.5)
"""Length, width and height of the own car, as it is drawn."""


@dataclass(frozen=True, slots=True)
class OverlayBox:
    """A vehicle's box with the words beside it.

    Attributes:
        box: in the picture.
        label: its words; empty for most vehicles, see `told_ids`.
        color: of the box.
        is_lead: whether it is the lead's, or that of the vehicle that is warned of.
    """

    box: Box
    label: str
    color: Rgb
    is_lead: bool

    @property
    def told(self) -> bool:
        """Whether it has words; without them the box is thin."""
        return bool(self.label)


def told_ids(result: FrameResult) -> frozenset[int]:
    """Ids of the vehicles that have words wherever a frame is shown; words on all of them hide the road.

    They are the lead, the one that the warning is about, and of those that may become the lead the nearest,
    so that there are three at most. Where there is none of these, the two nearest ones have words.
    """
    ids = [track_id for track_id in (result.lead_id, result.warning.track_id) if track_id is not None]
    near = rivals(result.tracks, result.lead, result.ego_speed_mps, result.own_path)
    ids += [track.track_id for track in near]
    if not ids:
        ids = [track.track_id for track in sorted(result.tracks, key=lambda track: track.distance_m)]
        return frozenset(ids[:TOLD_ON_FREE_ROAD])
    return frozenset(list(dict.fromkeys(ids))[:MOST_TOLD])


@dataclass(frozen=True, slots=True)
class OverlayRow:
    """A line across the picture at a distance; its words stand at a part of the picture's width."""

    row_px: float
    distance_m: float
    label: str
    label_part: float


def overlay_boxes(result: FrameResult, imperial: bool = False) -> tuple[OverlayBox, ...]:
    """Boxes of all tracks; the warned one in the colour of the level, the lead green, the others violet."""
    told = told_ids(result)
    return tuple(
        OverlayBox(
            track.box,
            track_label(track, imperial) if track.track_id in told else "",
            track_color(result, track.track_id),
            track.track_id in (result.lead_id, result.warning.track_id),
        )
        for track in result.tracks
    )


def track_color(result: FrameResult, track_id: int) -> Rgb:
    """Of a vehicle: that of the level where it is warned of, else by whether it is the lead."""
    if track_id == result.warning.track_id:
        return LEVEL_COLORS[result.warning.level]
    return LEVEL_COLORS[WarningLevel.NONE] if track_id == result.lead_id else OTHER_TRACK_COLOR


def track_label(track: Track, imperial: bool = False) -> str:
    """Distance, and the TTC where it is under ten seconds."""
    text = distance_text(track.distance_m, imperial)
    return text if track.ttc_s is None or track.ttc_s > 10 else f"{text}  {track.ttc_s:.1f} s"


def pitch_now(calibration: Calibration, result: FrameResult) -> float:
    """Pitch of the camera as it is believed at a frame, in radians: distances go by that.

    In whole steps from that of the calibration, so that what is drawn by it seldom changes.
    """
    calibrated_rad = calibration.camera.pitch_rad
    mount = None if result.own_motion is None else result.own_motion.mount
    if mount is None or not abs(mount.pitch_rad) < math.pi / 2:
        return calibrated_rad  # a log of others may state anything
    return calibrated_rad + PITCH_STEP_RAD * round((mount.pitch_rad - calibrated_rad) / PITCH_STEP_RAD)


def overlay_rows(
    calibration: Calibration, imperial: bool = False, pitch_rad: float | None = None
) -> tuple[OverlayRow, ...]:
    """Distance rows inside the picture, thinned where they would stand too close together.

    Args:
        calibration: of the pictures.
        imperial: whether the words are in feet.
        pitch_rad: of the camera by now, see `pitch_now`; None: that of the calibration.
    """
    camera = calibration.camera
    camera = camera if pitch_rad is None else replace(camera, pitch_rad=pitch_rad)
    rows: list[OverlayRow] = []
    for distance_m in ROW_DISTANCES_M:
        row_px = float(camera.row_at(distance_m + calibration.reference_offset_m))
        inside = -0.5 <= row_px <= calibration.image_size.height - 0.5
        if inside and (not rows or rows[-1].row_px - row_px >= MINIMUM_ROW_GAP_PX):
            label_part = ROW_LABEL_PARTS[len(rows) % len(ROW_LABEL_PARTS)]
            rows.append(OverlayRow(row_px, distance_m, distance_text(distance_m, imperial), label_part))
    return tuple(rows)


def own_speed_text(result: FrameResult, imperial: bool = False) -> str:
    """Own speed, with its 1-sigma where the picture tells it; `?` when unknown. Of ASCII."""
    if result.ego_speed_mps is None:
        return "?"
    text, motion = speed_text(result.ego_speed_mps, imperial), result.own_motion
    if motion is None or motion.speed_source is not SpeedSource.PICTURE or motion.speed_sigma_mps is None:
        return text
    return f"{text} +- {speed_text(motion.speed_sigma_mps, imperial)} from the picture"


def overlay_path(result: FrameResult, calibration: Calibration) -> tuple[PixelLine, PixelLine] | None:
    """Left and right edge of the own path in the picture, from near to far; None where it is not known.

    Without lane lines it is drawn as wide as the corridor in which a vehicle stays the lead.
    """
    path = result.own_path
    if path is None:
        return None
    camera, size = calibration.camera, calibration.image_size
    distances_m = np.geomspace(*PATH_DRAWN_M, PATH_POINTS)
    half_m = Corridor().leave_m if path.lane_width_m is None else path.lane_width_m / 2
    # The road is where the camera looks now, not where it did when it was calibrated.
    if result.own_motion is not None and result.own_motion.mount is not None:
        camera = replace(camera, pitch_rad=result.own_motion.mount.pitch_rad)
    rows = camera.row_at(distances_m)
    middles_m = np.array([path.lateral_at(distance_m) for distance_m in distances_m])
    lines = []
    for side_m in (half_m, -half_m):
        columns = camera.column_at(middles_m + side_m, distances_m)
        inside = (rows < size.height) & (columns > -0.5) & (columns < size.width - 0.5)
        lines.append(tuple(zip(columns[inside].tolist(), rows[inside].tolist(), strict=True)))
    left, right = lines
    return (left, right) if len(left) > 1 and len(right) > 1 else None


def rear_size_m(track: Track, calibration: Calibration) -> tuple[float, float]:
    """Width and height of a vehicle's rear from the size of its box at its distance."""
    camera = calibration.camera
    along_m = track.distance_m + calibration.reference_offset_m
    depth_m = along_m * math.cos(camera.pitch_rad) + camera.height_m * math.sin(camera.pitch_rad)
    metres_per_px = max(depth_m, 0.0) / camera.focal_y_px
    return track.box.w * metres_per_px, track.box.h * metres_per_px
