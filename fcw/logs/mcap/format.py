"""What writer and reader of the MCAP log agree on.

A drive is one MCAP file (https://mcap.dev/spec). Before the first message stand the metadata records
`fcw.drive` and `fcw.versions` and the attachment `calibration.yaml`, so that a file whose writer was killed
still says what it is, and `track.gpx` where the own speed came from one.
Log times are the source's presentation times. They cannot be negative in MCAP:
packets before 0, which only feed the decoder, have log time 0, keep their order, and have their own time on
`/fcw/video_index`, whose message for a packet has the sequence number of its message on `/camera/image`.
Pictures stand in chunks of their own, all else in others. At the end stands the attachment `drive.series`
(`fcw.logs.series`): the signals as columns, and where decoding can start.
"""

from collections.abc import Mapping
from functools import lru_cache

from fcw.camera.calibration import Calibration
from fcw.camera.file import parse_calibration
from fcw.errors import UserError
from fcw.frame import ImageSize
from fcw.logs.records import DriveHeader

FORMAT_VERSION = "1"
DRIVE_METADATA = "fcw.drive"
VERSIONS_METADATA = "fcw.versions"
CALIBRATION_NAME = "calibration.yaml"
"""Attachment with the drive's calibration; files that others wrote may have one as well."""
TRACK_NAME = "track.gpx"
SERIES_NAME = "drive.series"
SERIES_MEDIA_TYPE = "application/x-npz"

VIDEO_TOPIC = "/camera/image"
CALIBRATION_TOPIC = "/camera/calibration"
ANNOTATIONS_TOPIC = "/camera/annotations"
SCENE_TOPIC = "/scene"
TRANSFORMS_TOPIC = "/tf"
LOG_TOPIC = "/log"
RESULT_TOPIC = "/fcw/frame"
LEAD_TOPIC = "/fcw/lead"
WARNING_TOPIC = "/fcw/warning"
VIDEO_INDEX_TOPIC = "/fcw/video_index"

SIGNALS_CHUNK_NS = 300_000_000
"""A chunk of signals holds no more of the drive than this, which is what is lost when the process is
killed."""
PICTURES_CHUNK_NS = 500_000_000
"""As much of the pictures; a chunk of them ends before each keyframe too, where a jump starts to read."""
CHUNK_BYTES = 1 << 30
"""Chunks end by time, never by size."""

_TRUTH = {True: "true", False: "false"}
_LATER_TIMES = ("zero_utc_ns", "gpx_begins_ns")
"""Of the header, which not every log has."""


def drive_metadata(header: DriveHeader) -> dict[str, str]:
    """The `fcw.drive` record; numbers keep all their digits."""
    times = {name: getattr(header, name) for name in _LATER_TIMES}
    return {name: str(time_ns) for name, time_ns in times.items() if time_ns is not None} | {
        "format_version": FORMAT_VERSION,
        "source": header.source,
        "image_width": str(header.image_size.width),
        "image_height": str(header.image_size.height),
        "frame_rate_hz": repr(float(header.frame_rate_hz)),
        "relays_video": _TRUTH[header.relays_video],
        "detector": header.detector,
        "model_sha256": header.model_sha256,
        "imperial": _TRUTH[header.imperial],
    }


def drive_header(
    drive: Mapping[str, str], versions: Mapping[str, str], calibration_yaml: str, name: str, gpx: bytes = b""
) -> DriveHeader:
    """The header that a log was opened with.

    Raises:
        KeyError, ValueError: a record is not what `drive_metadata` writes.
        UserError: the calibration is not one.
    """
    return DriveHeader(
        source=drive["source"],
        image_size=ImageSize(int(drive["image_width"]), int(drive["image_height"])),
        frame_rate_hz=float(drive["frame_rate_hz"]),
        calibration=_calibration(calibration_yaml, f"{name}: attachment {CALIBRATION_NAME}"),
        relays_video=drive["relays_video"] == _TRUTH[True],
        detector=drive["detector"],
        model_sha256=drive["model_sha256"],
        versions=dict(versions),
        imperial=drive["imperial"] == _TRUTH[True],
        gpx=gpx,
        **{name: int(drive[name]) for name in _LATER_TIMES if name in drive},
    )


def _calibration(text: str, name: str) -> Calibration:
    """The calibration in a text; many drives of one camera have the same, and YAML is slow to read."""
    try:
        return _known_calibration(text)
    except UserError:
        return parse_calibration(text, name)


@lru_cache(maxsize=32)
def _known_calibration(text: str) -> Calibration:
    return parse_calibration(text, "")
