"""The project's own messages (`schemas/drive.proto`) from records and back, bit for bit."""

from fcw.box import Box
from fcw.detection.detector import Detection
from fcw.logs.records import FrameResult
from fcw.logs.schemas import drive_pb2
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
"""What a warning state has or has not, named alike in the message."""


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
        doubtful=track.doubtful,
        seen_by=track.seen_by.name,
    )


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
    )


def result_from_message(data: bytes) -> FrameResult:
    """The result that `result_message` was made of, from the message's bytes."""
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
    )


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
        doubtful=message.doubtful,
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
