"""Converts records to the project's own messages (`schemas/drive.proto`) and back, bit for bit."""

import math
from dataclasses import fields
from typing import Any

from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.logs.records import FrameResult
from fcw.logs.schemas import drive_pb2
from fcw.logs.series import NO_TRACK
from fcw.motion.state import Mount, OwnMotion, OwnPath, SpeedSource
from fcw.tracking.types import USUAL_WIDTH_M, SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

WARNING_FIGURES = (
    "track_id",
    "ttc_s",
    "required_deceleration_mps2",
    "headway_s",
    "distance_m",
    "distance_low_m",
    "distance_high_m",
    "closing_speed_mps",
    "overlap_m",
    "collision_probability",
    "needed_distance_m",
)
"""Optional figures of a warning state, with the same names in the message."""


def track_message(track: Track) -> drive_pb2.Track:
    """A track as a message."""
    return drive_pb2.Track(
        track_id=track.track_id,
        box=_box_message(track.box),
        score=track.score,
        distance_m=track.distance_m,
        distance_low_m=track.distance_low_m,
        distance_high_m=track.distance_high_m,
        lateral_m=track.lateral_m,
        closing_speed_mps=track.closing_speed_mps,
        closing_speed_sigma_mps=track.closing_speed_sigma_mps,
        ttc_s=track.ttc_s,
        age_s=track.age_s,
        coasting=track.coasting,
        in_path=track.in_path,
        closing_acceleration_mps2=track.closing_acceleration_mps2,
        closing_acceleration_sigma_mps2=track.closing_acceleration_sigma_mps2,
        lateral_speed_mps=track.lateral_speed_mps,
        width_m=track.width_m,
        lateral_sigma_m=track.lateral_sigma_m,
        lateral_speed_sigma_mps=track.lateral_speed_sigma_mps,
        lateral_slowing_mps2=track.lateral_slowing_mps2,
        lateral_speed_by_bearing_mps=track.lateral_speed_by_bearing_mps,
        lateral_speed_by_bearing_sigma_mps=track.lateral_speed_by_bearing_sigma_mps,
        doubtful=track.doubtful,
        found_part=track.found_part,
        closing_speed_sigma_at_distance_mps=track.closing_speed_sigma_at_distance_mps,
        seen_by=track.seen_by.name,
    )


def no_track_message() -> drive_pb2.Track:
    """A message that there is no lead any more; its figures are NaN, so that plots break their lines."""
    message = drive_pb2.Track(track_id=NO_TRACK, seen_by="UNSAID")
    for field in message.DESCRIPTOR.fields:
        if field.cpp_type == field.CPPTYPE_DOUBLE:
            setattr(message, field.name, math.nan)
    return message


def warning_message(warning: WarningState) -> drive_pb2.WarningState:
    """A warning state as a message."""
    return drive_pb2.WarningState(
        level=warning.level.name,
        rule=warning.rule,
        assumes=warning.assumes,
        extrapolated=warning.extrapolated,
        **{name: getattr(warning, name) for name in WARNING_FIGURES},
    )


def result_message(result: FrameResult) -> drive_pb2.FrameResult:
    """A frame's result as a message."""
    return drive_pb2.FrameResult(
        index=result.index,
        time_ns=result.time_ns,
        detections=[
            drive_pb2.Detection(box=_box_message(detection.box), score=detection.score)
            for detection in result.detections
        ],
        tracks=[track_message(track) for track in result.tracks],
        lead_id=result.lead_id,
        warning=warning_message(result.warning),
        ego_speed_mps=result.ego_speed_mps,
        notes=result.notes,
        own_motion=None if result.own_motion is None else _motion_message(result.own_motion),
        own_path=None if result.own_path is None else drive_pb2.OwnPath(**_fields(result.own_path)),
        unsearched=not result.searched,
        repeated_picture=result.repeated,
    )


def result_from_message(data: bytes) -> FrameResult:
    """The result that was converted by `result_message`, from the message's bytes."""
    message = drive_pb2.FrameResult.FromString(data)
    return FrameResult(
        index=message.index,
        time_ns=message.time_ns,
        detections=tuple(Detection(_box(item.box), item.score) for item in message.detections),
        tracks=tuple(_track(item) for item in message.tracks),
        lead_id=message.lead_id if message.HasField("lead_id") else None,
        warning=_warning(message.warning),
        ego_speed_mps=message.ego_speed_mps if message.HasField("ego_speed_mps") else None,
        notes=tuple(message.notes),
        own_motion=_motion(message.own_motion) if message.HasField("own_motion") else None,
        own_path=_path(message.own_path) if message.HasField("own_path") else None,
        searched=not message.unsearched,
        repeated=message.repeated_picture,
    )


def _motion_message(motion: OwnMotion) -> drive_pb2.OwnMotion:
    values = _fields(motion)
    values["speed_source"] = motion.speed_source.name
    values["mount"] = None if motion.mount is None else drive_pb2.Mount(**_fields(motion.mount))
    return drive_pb2.OwnMotion(**values)


def _motion(message: drive_pb2.OwnMotion) -> OwnMotion:
    mount = message.mount
    return OwnMotion(
        speed_mps=_optional(message, "speed_mps"),
        speed_sigma_mps=_optional(message, "speed_sigma_mps"),
        speed_source=SpeedSource[drive_pb2.OwnMotion.SpeedSource.Name(message.speed_source)],
        yaw_rate_radps=_optional(message, "yaw_rate_radps"),
        yaw_rate_sigma_radps=_optional(message, "yaw_rate_sigma_radps"),
        mount=Mount(**{field.name: getattr(mount, field.name) for field in fields(Mount)})
        if message.HasField("mount")
        else None,
        picture_speed_mps=_optional(message, "picture_speed_mps"),
    )


def _path(message: drive_pb2.OwnPath) -> OwnPath:
    values = {field.name: getattr(message, field.name) for field in fields(OwnPath)}
    values["lane_width_m"] = _optional(message, "lane_width_m")
    return OwnPath(**values)


def _fields(record: Mount | OwnMotion | OwnPath) -> dict[str, Any]:
    """Values by name; messages have the same names."""
    return {field.name: getattr(record, field.name) for field in fields(record)}


def _optional(message: drive_pb2.OwnMotion | drive_pb2.OwnPath, name: Any) -> float | None:  # noqa: ANN401
    return getattr(message, name) if message.HasField(name) else None


def _track(message: drive_pb2.Track) -> Track:
    return Track(
        track_id=message.track_id,
        box=_box(message.box),
        score=message.score,
        distance_m=message.distance_m,
        distance_low_m=message.distance_low_m,
        distance_high_m=message.distance_high_m,
        lateral_m=message.lateral_m,
        closing_speed_mps=message.closing_speed_mps,
        closing_speed_sigma_mps=message.closing_speed_sigma_mps,
        ttc_s=message.ttc_s if message.HasField("ttc_s") else None,
        age_s=message.age_s,
        seen_by=_seen_by(message),
        in_path=message.in_path,
        closing_acceleration_mps2=message.closing_acceleration_mps2,
        closing_acceleration_sigma_mps2=message.closing_acceleration_sigma_mps2,
        lateral_speed_mps=message.lateral_speed_mps,
        width_m=message.width_m if message.HasField("width_m") else USUAL_WIDTH_M,
        lateral_sigma_m=message.lateral_sigma_m,
        lateral_speed_sigma_mps=message.lateral_speed_sigma_mps,
        lateral_slowing_mps2=message.lateral_slowing_mps2,
        lateral_speed_by_bearing_mps=(
            message.lateral_speed_by_bearing_mps if message.HasField("lateral_speed_by_bearing_mps") else None
        ),
        lateral_speed_by_bearing_sigma_mps=message.lateral_speed_by_bearing_sigma_mps,
        doubtful=message.doubtful,
        found_part=message.found_part if message.HasField("found_part") else 1.0,
        closing_speed_sigma_at_distance_mps=(
            message.closing_speed_sigma_at_distance_mps
            if message.HasField("closing_speed_sigma_at_distance_mps")
            else None
        ),
    )


def _seen_by(message: drive_pb2.Track) -> SeenBy:
    if message.seen_by == drive_pb2.Track.UNSAID:
        return SeenBy.COASTING if message.coasting else SeenBy.DETECTOR
    return SeenBy[drive_pb2.Track.SeenBy.Name(message.seen_by)]


def _warning(message: drive_pb2.WarningState) -> WarningState:
    known = {name: getattr(message, name) for name in WARNING_FIGURES if message.HasField(name)}
    return WarningState(
        level=WarningLevel(message.level),
        rule=message.rule,
        assumes=message.assumes,
        extrapolated=message.extrapolated,
        **known,
    )


def _box_message(box: Box) -> drive_pb2.Box:
    return drive_pb2.Box(x=box.x, y=box.y, w=box.w, h=box.h)


def _box(message: drive_pb2.Box) -> Box:
    return Box(message.x, message.y, message.w, message.h)
