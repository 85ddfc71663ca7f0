"""What a drive log holds, and the seam behind which each log format stands."""

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
"""The note of a frame whose picture is so (`fcw.frame.nothing_seen`): a dead camera gives pictures too."""
CUT = "cut: the picture is of another place or camera than before; all vehicles begin anew"
"""The note of the first frame that is known to come after a cut (`fcw.motion.flow.cuts`)."""
POOR_SIGHT = tuple(poor.value for poor in PoorSight)
"""How notes begin of times in which pictures show too little (`fcw.motion.flow.sight`)."""
MOMENTS = (NOTHING_SEEN, CUT, *POOR_SIGHT)
"""How notes begin that are on a time of the drive; all others tell what is known of the camera by then."""


@dataclass(frozen=True, slots=True)
class FrameResult:
    """Everything the pipeline found at one frame; logs give it back bit for bit.

    Attributes:
        index: 0-based number of the shown frame.
        time_ns: presentation time on the source's clock.
        detections: what the detector gave, best score first.
        tracks: vehicles followed, in the order of their ids.
        lead_id: id of the lead vehicle among `tracks`; None when the own path is free.
        warning: the warning shown.
        ego_speed_mps: own speed; None when unknown.
        notes: what a person should know of the whole drive by now, e.g. that the camera's mount has moved.
            Over the picture stands what is before a note's first colon: it should say enough.
        own_motion: speed, yaw rate and mount as believed now; None in logs of before they were known.
        own_path: the way that we will take; None likewise.
        searched: whether the detector was asked; else the vehicles were carried on, see `SearchSchedule`.
        repeated: whether the picture is the one before, shown once more; all else is as it was there, and
            there were no detections.
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
        """The vehicle that the warning is about, while it is followed."""
        return next((track for track in self.tracks if track.track_id == self.warning.track_id), None)

    @property
    def told_warning(self) -> WarningState:
        """The warning, with the figures of its vehicle where the policy, or an old log, left them out."""
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
"""The year 2000: what a source's clock says before is a time since its start, not a date."""


@dataclass(frozen=True, slots=True)
class DriveHeader:
    """What is known of a drive before its first frame.

    Attributes:
        source: name of the source.
        image_size: size of every picture.
        frame_rate_hz: nominal rate.
        calibration: the calibration used, already for this image size.
        relays_video: True when the video is the source's own packets, False when encoded anew.
        detector: name of the detector.
        model_sha256: hash of the detector's weights; empty where it has none.
        versions: program and library versions by name.
        imperial: whether distances shown to a person are in feet.
        zero_utc_ns: what time 0 of the source's clock is in UTC, in nanoseconds since 1970, as the source's
            file says it; None where that says nothing.
        gpx: the GPX file that the own speed came from, which begins with the drive; empty for none.
        gpx_begins_ns: when it does, on the source's clock; None where it is with the log's first frame, as
            with all but a part cut out of a drive.
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
        """What the time of the drive's first frame is in UTC, in nanoseconds since 1970; None where nothing
        says so."""
        if self.zero_utc_ns is not None:
            return self.zero_utc_ns + first_ns
        # Clocks of recorders count from 1970.
        return first_ns if first_ns > FIRST_UTC_NS else None


Record = TypeVar("Record")


def in_single_precision(record: Record) -> Record:
    """A detection or a track with all its numbers at 24 bits of precision.

    None of them is known to seven digits, and noise in the other 29 bits would be half of a log's size:
    it does not compress.
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
    """Where a drive is written; `close` leaves a complete file, also after an interruption."""

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
