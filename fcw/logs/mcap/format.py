"""The layout of the MCAP log, shared by writer and reader.

A drive is one MCAP file (https://mcap.dev/spec). Before the first message are the metadata records
`fcw.drive` and `fcw.versions` and the attachment `calibration.yaml`, so that a file whose writer was killed
still tells what it is, and `track.gpx` if the own speed came from a GPX file.

Log times are the source's presentation times. They cannot be negative in MCAP. Packets before 0, which only
feed the decoder, have log time 0, keep their order, and have their own time on `/fcw/video_index`, whose
message for a packet has the same sequence number as the packet's message on `/camera/image`.

Pictures and all other messages are in separate chunks. At the end is the attachment `drive.series`
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
"""Attachment with the drive's calibration; files by other programs may have one, too."""
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
"""Longest time in a chunk of signals, which is lost if the process is killed."""
PICTURES_CHUNK_NS = 500_000_000
"""Longest time in a chunk of pictures. A chunk also ends before each keyframe, where a jump starts to
read."""
CHUNK_BYTES = 1 << 30
"""So large that chunks end by time, never by size."""

_TRUTH = {True: "true", False: "false"}
_LATER_TIMES = ("zero_utc_ns", "gpx_begins_ns")
"""Times in the header that not every log has."""


def drive_metadata(header: DriveHeader) -> dict[str, str]:
    """The metadata record `fcw.drive`; numbers keep all their digits."""
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
    """The header from a log's records.

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
    """Parse a calibration, cached, as many drives of one camera have the same and YAML is slow to read."""
    try:
        return _known_calibration(text)
    except UserError:
        return parse_calibration(text, name)


@lru_cache(maxsize=32)
def _known_calibration(text: str) -> Calibration:
    return parse_calibration(text, "")
