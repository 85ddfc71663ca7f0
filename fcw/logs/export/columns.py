"""The columns of the tables: names with their units, and their meanings, as listed in `docs/export.md`."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from fcw.logs.events import DriveEvent
from fcw.logs.export.clip import DriveClip
from fcw.logs.records import FrameResult
from fcw.tracking.types import Track

Row = TypeVar("Row")
Kind = Literal["string", "int64", "float64", "bool"]
NOTE_SEPARATOR = "; "


@dataclass(frozen=True, slots=True)
class Column(Generic[Row]):
    """One column of a table.

    Attributes:
        name: its name, with the unit at the end if it has one.
        kind: Arrow's name of its type; all columns but the first ones may be empty.
        unit: its unit; empty if it has none.
        meaning: its meaning in one line.
        value: gives the value for a row; None for an empty cell.
    """

    name: str
    kind: Kind
    unit: str
    meaning: str
    value: Callable[[Row], str | int | float | bool | None]


@dataclass(frozen=True, slots=True, eq=False)
class TrackRow:
    """One track at one frame, or a frame without tracks."""

    clip: DriveClip
    result: FrameResult
    track: Track | None


@dataclass(frozen=True, slots=True, eq=False)
class EventRow:
    """One event of a drive."""

    drive: str
    event: DriveEvent


def track_rows(clips: Iterable[DriveClip], on_frame: Callable[[], None]) -> Iterator[TrackRow]:
    """A row for each track of each frame; a frame without tracks has one row, so that no frame is missing."""
    for clip in clips:
        for result in clip.results():
            for track in result.tracks or (None,):
                yield TrackRow(clip, result, track)
            on_frame()


def _of_warning(name: str, kind: Kind, unit: str, meaning: str) -> Column[TrackRow]:
    return Column(f"warning_{name}", kind, unit, meaning, lambda row: getattr(row.result.told_warning, name))


def _of_track(name: str, kind: Kind, unit: str, meaning: str) -> Column[TrackRow]:
    return Column(
        name, kind, unit, meaning, lambda row: None if row.track is None else getattr(row.track, name)
    )


def _of_box(name: str, meaning: str) -> Column[TrackRow]:
    return Column(
        f"box_{name}_px",
        "float64",
        "px",
        meaning,
        lambda row: None if row.track is None else getattr(row.track.box, name),
    )


def _of_motion(name: str, unit: str, meaning: str, field: str = "") -> Column[TrackRow]:
    return Column(
        name,
        "float64",
        unit,
        meaning,
        lambda row: None if row.result.own_motion is None else getattr(row.result.own_motion, field or name),
    )


def _of_mount(angle: str, meaning: str) -> Column[TrackRow]:
    def value(row: TrackRow) -> float | None:
        motion = row.result.own_motion
        return None if motion is None or motion.mount is None else getattr(motion.mount, f"{angle}_rad")

    return Column(f"camera_{angle}_rad", "float64", "rad", meaning, value)


def _of_path(name: str, unit: str, meaning: str) -> Column[TrackRow]:
    return Column(
        f"path_{name}",
        "float64",
        unit,
        meaning,
        lambda row: None if row.result.own_path is None else getattr(row.result.own_path, name),
    )


TRACK_COLUMNS: tuple[Column[TrackRow], ...] = (
    Column("drive", "string", "", "name of the drive", lambda row: row.clip.name),
    Column("frame", "int64", "", "number of the frame in the drive, from 0", lambda row: row.result.index),
    Column(
        "time_ns",
        "int64",
        "ns",
        "presentation time of the frame on the source's clock",
        lambda row: row.result.time_ns,
    ),
    Column(
        "time_s",
        "float64",
        "s",
        "time of the frame from the drive's first frame",
        lambda row: row.clip.time_s(row.result.time_ns),
    ),
    Column(
        "ego_speed_mps",
        "float64",
        "m/s",
        "own speed, the one used; empty when unknown",
        lambda row: row.result.ego_speed_mps,
    ),
    _of_motion(
        "ego_speed_sigma_mps", "m/s", "its standard deviation, 0 where it was given", "speed_sigma_mps"
    ),
    Column(
        "ego_speed_source",
        "string",
        "",
        "where it comes from: given or picture; empty when unknown",
        lambda row: (
            None if row.result.own_motion is None else row.result.own_motion.speed_source.value or None
        ),
    ),
    _of_motion("yaw_rate_radps", "rad/s", "own yaw rate, positive to the left; empty when unknown"),
    _of_mount("yaw", "estimated angle of the camera's axis to the left of the direction of travel"),
    _of_mount("pitch", "estimated angle of the camera's axis below the road"),
    _of_mount("roll", "estimated rotation of the camera to the right, by the road with its kerbs and verges"),
    _of_path("curvature_per_m", "1/m", "curvature of the own path, positive to the left"),
    _of_path(
        "offset_m",
        "m",
        "lateral position of the middle of the own path or lane, from the camera, positive to the left",
    ),
    Column(
        "lead_id",
        "int64",
        "",
        "track id of the lead vehicle; empty when the own path is free",
        lambda row: row.result.lead_id,
    ),
    Column(
        "warning_level",
        "string",
        "",
        "the warning shown: none, advisory, caution or warning",
        lambda row: row.result.warning.level.name.lower(),
    ),
    _of_warning("track_id", "int64", "", "the vehicle that the warning is about"),
    Column(
        "warning_rule",
        "string",
        "",
        "the rule that holds the level; empty for none",
        lambda row: row.result.warning.rule or None,
    ),
    _of_warning("ttc_s", "float64", "s", "time to collision with that vehicle; empty when not closing"),
    _of_warning(
        "required_deceleration_mps2",
        "float64",
        "m/s^2",
        "braking needed to avoid the collision; empty when none is",
    ),
    _of_warning("headway_s", "float64", "s", "distance over own speed; empty when that is unknown or zero"),
    _of_warning("distance_m", "float64", "m", "from the calibration's reference to that vehicle's rear"),
    _of_warning("distance_low_m", "float64", "m", "16th percentile of that distance"),
    _of_warning("distance_high_m", "float64", "m", "84th percentile of it; inf when unbounded"),
    _of_warning("closing_speed_mps", "float64", "m/s", "rate at which it shrinks"),
    _of_warning(
        "overlap_m", "float64", "m", "overlap of its width and ours when we reach it; negative is room"
    ),
    _of_warning("collision_probability", "float64", "", "probability that we hit it if nobody acts, 0 to 1"),
    _of_warning("needed_distance_m", "float64", "m", "the gap that the rule asks for"),
    Column(
        "warning_assumes",
        "string",
        "",
        "what the rule assumes, or its threshold",
        lambda row: row.result.warning.assumes or None,
    ),
    _of_warning(
        "extrapolated",
        "bool",
        "",
        "whether that vehicle is no longer tracked and its figures are extrapolated",
    ),
    Column(
        "notes",
        "string",
        "",
        "what a person should know about the drive so far, e.g. that the mount has moved",
        lambda row: NOTE_SEPARATOR.join(row.result.notes) or None,
    ),
    _of_track("track_id", "int64", "", "the vehicle; this and all following columns are empty without one"),
    Column(
        "is_lead",
        "bool",
        "",
        "whether it is the lead vehicle",
        lambda row: None if row.track is None else row.track.track_id == row.result.lead_id,
    ),
    _of_track("in_path", "bool", "", "whether it stands in the own path"),
    Column(
        "seen_by",
        "string",
        "",
        "source of its position: detector, picture (tracked by its appearance) or coasting; in a frame "
        "that was not searched, the source in the last searched one",
        lambda row: None if row.track is None else row.track.seen_by.value,
    ),
    _of_track("coasting", "bool", "", "whether neither the detector nor the picture showed it"),
    _of_track("age_s", "float64", "s", "time since its first detection"),
    _of_track("score", "float64", "", "score of its latest detection"),
    _of_box("x", "left edge of its box; the centre of the top-left pixel is (0, 0)"),
    _of_box("y", "top edge of its box"),
    _of_box("w", "width of its box"),
    _of_box("h", "height of its box"),
    _of_track("distance_m", "float64", "m", "along the ground from the calibration's reference to its rear"),
    _of_track("distance_low_m", "float64", "m", "16th percentile of the distance"),
    _of_track("distance_high_m", "float64", "m", "84th percentile of the distance; inf when unbounded"),
    _of_track("lateral_m", "float64", "m", "middle of its rear from the camera's axis, positive to the left"),
    _of_track("lateral_speed_mps", "float64", "m/s", "rate at which it moves to the left; 0 where unknown"),
    _of_track("closing_speed_mps", "float64", "m/s", "rate at which the distance shrinks"),
    _of_track("closing_speed_sigma_mps", "float64", "m/s", "standard deviation of the closing speed"),
    _of_track(
        "closing_acceleration_mps2",
        "float64",
        "m/s^2",
        "rate at which the closing speed grows; 0 where unknown",
    ),
    _of_track("closing_acceleration_sigma_mps2", "float64", "m/s^2", "its standard deviation"),
    _of_track("ttc_s", "float64", "s", "distance over closing speed; empty unless the gap surely closes"),
    _of_track("width_m", "float64", "m", "width of its rear"),
    _of_track("lateral_sigma_m", "float64", "m", "standard deviation of lateral_m"),
    _of_track("lateral_speed_sigma_mps", "float64", "m/s", "standard deviation of lateral_speed_mps"),
    _of_track(
        "lateral_slowing_mps2",
        "float64",
        "m/s^2",
        "least deceleration of its own motion across the road; 0 where unknown",
    ),
    _of_track(
        "lateral_speed_by_bearing_mps",
        "float64",
        "m/s",
        "lateral_speed_mps as measured by the change of its bearing; empty where the own yaw rate is unknown",
    ),
    _of_track(
        "lateral_speed_by_bearing_sigma_mps",
        "float64",
        "m/s",
        "its standard deviation, if distance and TTC are right",
    ),
    _of_track("doubtful", "bool", "", "whether it may be no vehicle; it is no lead, and raises no warning"),
    _of_track("found_part", "float64", "", "in how many of its frames the detector found it"),
)
"""Everything in the result of a frame except the raw detections."""


def _of_event(name: str, kind: Kind, unit: str, meaning: str) -> Column[EventRow]:
    return Column(name, kind, unit, meaning, lambda row: getattr(row.event, name))


EVENT_COLUMNS: tuple[Column[EventRow], ...] = (
    Column("drive", "string", "", "name of the drive", lambda row: row.drive),
    _of_event(
        "kind",
        "string",
        "",
        "warning, caution, advisory, near miss, mount moved, nothing seen, cut or poor sight",
    ),
    _of_event("start_s", "float64", "s", "its first frame, from the drive's first frame"),
    _of_event("end_s", "float64", "s", "its last frame"),
    _of_event("peak_s", "float64", "s", "where it was most severe, or else where it was nearest"),
    _of_event(
        "severity",
        "float64",
        "",
        "braking needed, as a share of the hardest possible, times the probability",
    ),
    _of_event("track_id", "int64", "", "the vehicle; empty where there is none"),
    Column(
        "rule",
        "string",
        "",
        "the rule that held the level; empty for none",
        lambda row: row.event.rule or None,
    ),
    _of_event("min_ttc_s", "float64", "s", "smallest time to collision; empty when it never closed"),
    _of_event("min_distance_m", "float64", "m", "smallest distance; empty when it was never measured"),
    _of_event("max_required_deceleration_mps2", "float64", "m/s^2", "hardest braking needed; empty for none"),
    Column(
        "note",
        "string",
        "",
        "the note about a mount that moved, a time in which too little can be seen, or a cut",
        lambda row: row.event.note or None,
    ),
)
