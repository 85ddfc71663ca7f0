"""The contents of a drive log, and the protocol that each log format implements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from typing import Any, Protocol, TypeVar

import numpy as np

from fcw.camera.calibration import Calibration
from fcw.detection.detector import Detection
from fcw.frame import ImageSize, VideoPacket
from fcw.motion.flow.sight import PoorSight
from fcw.motion.state import OwnMotion, OwnPath
from fcw.threat.threat import required_deceleration_mps2
from fcw.tracking.types import Track
from fcw.warning.types import WarningState

NOTHING_SEEN = (
    "nothing can be seen: the picture is black or blank, as of a covered lens; there can be no warning"
)
"""Note of a frame in which nothing is seen (`fcw.frame.nothing_seen`): a dead camera gives pictures too."""
CUT = "cut: the picture is of another place or camera than before; all vehicles begin anew"
"""Note of the first frame that is known to come after a cut (`fcw.motion.flow.cuts`)."""
POOR_SIGHT = tuple(poor.value for poor in PoorSight)
"""Beginnings of notes about pictures that show too little (`fcw.motion.flow.sight`)."""
MOMENTS = (NOTHING_SEEN, CUT, *POOR_SIGHT)
"""Beginnings of notes about a part of the drive. All other notes are about the camera."""


@dataclass(frozen=True, slots=True)
class FrameResult:
    """Everything that the pipeline found at one frame. Logs return it bit for bit.

    Attributes:
        index: 0-based number of the frame.
        time_ns: presentation time on the source's clock.
        detections: the detector's output, best score first.
        tracks: confirmed tracks, in the order of their ids.
        lead_id: id of the lead among `tracks`; None when the own path is free.
        warning: the warning shown.
        ego_speed_mps: own speed; None when unknown.
        notes: sentences that the user should read, e.g. that the camera's mount has moved. The overlay shows
            the part before the first colon, which should make sense on its own.
        own_motion: estimated speed, yaw rate and mount; None in logs that were written before it existed.
        own_path: the path that we will take; None in logs that were written before it existed.
        searched: whether the detector was run on this frame. If not, vehicles were carried on; see
            `SearchSchedule`.
        repeated: whether the picture repeats the previous one. The result is then the previous one without
            detections.
    """

    index: int
    time_ns: int
    detections: tuple[Detection, ...]
    tracks: tuple[Track, ...]
    lead_id: int | None
    warning: WarningState
    ego_speed_mps: float | None
    notes: tuple[str, ...] = ()
    own_motion: OwnMotion | None = None
    own_path: OwnPath | None = None
    searched: bool = True
    repeated: bool = False

    @property
    def lead(self) -> Track | None:
        """The lead vehicle, or None."""
        return next((track for track in self.tracks if track.track_id == self.lead_id), None)

    @property
    def warned(self) -> Track | None:
        """The track that the warning is about; None if there is none, or if it is no longer tracked."""
        return next((track for track in self.tracks if track.track_id == self.warning.track_id), None)

    @property
    def told_warning(self) -> WarningState:
        """The warning, completed with the figures of its vehicle if a policy or an old log left them out."""
        warning, track = self.warning, self.warned
        if warning.distance_m is not None or track is None:
            return warning
        return replace(
            warning,
            ttc_s=track.ttc_s if warning.ttc_s is None else warning.ttc_s,
            required_deceleration_mps2=(
                required_deceleration_mps2(track.distance_m, track.closing_speed_mps)
                if warning.required_deceleration_mps2 is None
                else warning.required_deceleration_mps2
            ),
            distance_m=track.distance_m,
            distance_low_m=track.distance_low_m,
            distance_high_m=track.distance_high_m,
            closing_speed_mps=track.closing_speed_mps,
        )


FIRST_UTC_NS = 946_684_800 * 10**9
"""The year 2000. An earlier time of a source's clock counts from the start of the recording, not from
1970."""


@dataclass(frozen=True, slots=True)
class DriveHeader:
    """What is known about a drive before its first frame.

    Attributes:
        source: name of the source.
        image_size: size of every picture.
        frame_rate_hz: nominal frame rate.
        calibration: the calibration used, already for this image size.
        relays_video: True if the log holds the source's own video packets, False if it was encoded anew.
        detector: name of the detector.
        model_sha256: hash of the detector's weights; empty if it has none.
        versions: program and library versions by name.
        imperial: whether distances are shown in feet.
        zero_utc_ns: UTC time of time 0 of the source's clock, in nanoseconds since 1970; None if the source's
            file does not say.
        gpx: contents of the GPX file that the own speed came from, which begins with the drive; empty if
            there is none.
        gpx_begins_ns: start of the GPX track on the source's clock; None if it is the log's first frame, as
            in all logs but those of a part cut out of a drive.
    """

    source: str
    image_size: ImageSize
    frame_rate_hz: float
    calibration: Calibration
    relays_video: bool
    detector: str
    model_sha256: str
    versions: Mapping[str, str]
    imperial: bool = False
    zero_utc_ns: int | None = None
    gpx: bytes = b""
    gpx_begins_ns: int | None = None

    def begun_utc_ns(self, first_ns: int) -> int | None:
        """UTC time of the drive's first frame, in nanoseconds since 1970; None when unknown."""
        if self.zero_utc_ns is not None:
            return self.zero_utc_ns + first_ns
        # Recorders' own clocks count from 1970.
        return first_ns if first_ns > FIRST_UTC_NS else None


Record = TypeVar("Record")


def in_single_precision(record: Record) -> Record:
    """A detection or a track with all its floats rounded to single precision.

    None of them is known to seven digits. The other 29 bits would be noise that does not compress, and half
    of a log's size.
    """
    values: dict[str, Any] = {}
    for name in _field_names(type(record)):
        value = getattr(record, name)
        if isinstance(value, float):
            value = float(np.float32(value))
        elif is_dataclass(value):
            value = in_single_precision(value)
        values[name] = value
    return type(record)(**values)


@cache
def _field_names(kind: type[Any]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(kind))


class Sink(Protocol):
    """A log that a drive is written to. `close` leaves a complete file, even after an interruption."""

    def open(self, header: DriveHeader) -> None:
        """Start the log."""
        ...

    def write(self, result: FrameResult, packets: Sequence[VideoPacket]) -> None:
        """Add a frame: its result, and its video packets in decoding order, its own packet last.

        Indices and times rise from frame to frame.
        """
        ...

    def close(self) -> None:
        """Finish the log."""
        ...
