"""Drive logs for the tests of exports."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import Frame, ImageSize, VideoPacket
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.reader import DriveLog
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

Entries = Sequence[tuple[FrameResult, tuple[VideoPacket, ...]]]
SIZE = ImageSize(640, 360)
RATE_HZ = 25.0
STEP_NS = 40_000_000
START_NS = 3_000_000_000
"""Clocks of sources need not start at 0."""
KEYFRAME_FRAMES = 25


def drive_header(size: ImageSize = SIZE) -> DriveHeader:
    camera = GroundPlaneCamera(0.02, 500.0, size.height / 2, 1.3, size.width / 2)
    return DriveHeader(
        source="drive.mp4",
        image_size=size,
        frame_rate_hz=RATE_HZ,
        calibration=Calibration.from_camera(camera, size, reference_offset_m=1.5),
        relays_video=False,
        detector="acf",
        model_sha256="ab" * 32,
        versions={"fcw": "0.1.0"},
    )


def marked_box(index: int, size: ImageSize = SIZE) -> Box:
    """Where the vehicle of a frame is; it moves by a pixel and a half a frame."""
    return Box(40.0 + 1.5 * (index % 150), size.height / 2, 72.0, 54.0)


def marked_picture(index: int, size: ImageSize = SIZE) -> NDArray[np.uint8]:
    """Grey, brighter from frame to frame within a second; a white line a pixel wide around the vehicle."""
    image = np.full((size.height, size.width, 3), 60 + 6 * (index % 25), np.uint8)
    box = marked_box(index, size)
    corners = np.array([(box.x, box.y), (box.right, box.y), (box.right, box.bottom), (box.x, box.bottom)])
    cv2.polylines(image, [np.round(corners * 16).astype(np.int32)], True, (255, 255, 255), 1, cv2.LINE_AA, 4)
    return image


def marked_result(index: int, size: ImageSize = SIZE) -> FrameResult:
    """A lead at 20 m; a warning from 1.2 s to 2.0 s; every fifth frame has no vehicle at all."""
    time_ns = START_NS + index * STEP_NS
    if index % 5 == 4:
        return FrameResult(index, time_ns, (), (), None, WarningState(WarningLevel.NONE), None)
    box = marked_box(index, size)
    seen_by = {2: SeenBy.PICTURE, 3: SeenBy.COASTING}.get(index % 7, SeenBy.DETECTOR)
    lead = Track(3, box, 7.5, 20.0, 18.5, 22.0, 0.4, 6.0, 0.5, 20 / 6, 1.0 + index / 25, seen_by, True)
    warned = 30 <= index <= 50
    state = (
        WarningState(WarningLevel.WARNING, 3, "ttc", 20 / 6, 2.1, 0.9)
        if warned
        else WarningState(WarningLevel.NONE)
    )
    return FrameResult(index, time_ns, (Detection(box, 7.5),), (lead,), 3, state, 22.5)


def marked_drive(frames: int, size: ImageSize = SIZE) -> list[tuple[FrameResult, tuple[VideoPacket, ...]]]:
    """A drive with real video, a keyframe a second."""
    encoder = VideoEncoder(size, RATE_HZ)
    drive = []
    for index in range(frames):
        result = marked_result(index, size)
        packets = encoder.encode(Frame(index, result.time_ns, marked_picture(index, size)))
        drive.append((result, packets))
    encoder.close()
    return drive


def write_log(
    path: Path, drive: Iterable[tuple[FrameResult, Sequence[VideoPacket]]], header: DriveHeader
) -> DriveLog:
    path.parent.mkdir(parents=True, exist_ok=True)
    sink = McapSink(path)
    sink.open(header)
    for result, packets in drive:
        sink.write(result, packets)
    sink.close()
    return DriveLog(path)


def write_torn_log(path: Path, drive: Entries, header: DriveHeader) -> DriveLog:
    """What is on the disk where the writer is killed at the end of the drive."""
    writing = path.with_suffix(".writing")
    sink = McapSink(writing)
    sink.open(header)
    for result, packets in drive:
        sink.write(result, packets)
    path.write_bytes(writing.read_bytes())
    sink.close()
    writing.unlink()
    return DriveLog(path)


def in_time(results: Sequence[FrameResult], start_ns: int = START_NS) -> list[FrameResult]:
    """The same results as consecutive frames of one drive."""
    return [
        replace(result, index=index, time_ns=start_ns + index * STEP_NS)
        for index, result in enumerate(results)
    ]
