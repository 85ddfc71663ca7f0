"""A short drive log in which something of every kind happens, for tests of the review page."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from running.made_once import made_once

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import Frame, ImageSize
from fcw.logs.encode import VideoEncoder
from fcw.logs.mcap.writer import McapSink
from fcw.logs.records import DriveHeader, FrameResult
from fcw.tracking.types import SeenBy, Track
from fcw.warning.types import WarningLevel, WarningState

SIZE = ImageSize(640, 360)
RATE_HZ = 25
PERIOD_NS = 1_000_000_000 // RATE_HZ
DURATION_S = 24.0
FRAMES = round(DURATION_S * RATE_HZ)
QUIET_S = 4.0
"""So long nothing happens in it."""
FIRST_NS = 5_000_000_000
"""Drives need not begin at 0."""
CAUTION_S, WARNING_S, WARNING_END_S = 9.0, 9.6, 11.0
NEAR_MISS_S, NEAR_MISS_END_S = 15.0, 16.0
ADVISORY_S, ADVISORY_END_S = 19.0, 21.0
MOVED_S = 22.0
NOTE = "the camera's mount has moved"
BOX = Box(280.0, 180.0, 80.0, 60.0)
OTHER_BOX = Box(60.0, 185.0, 50.0, 40.0)
CODE_BITS, CODE_PX = 12, 16
"""The frame's number in black and white squares at the lower right, clear of words, lowest bit first."""
CODE_LEFT = SIZE.width - CODE_BITS * CODE_PX


def header() -> DriveHeader:
    """A camera 1.3 m high that looks slightly down."""
    camera = GroundPlaneCamera(0.03, 500.0, 179.5, 1.3, 319.5)
    return DriveHeader(
        source="made.mp4",
        image_size=SIZE,
        frame_rate_hz=float(RATE_HZ),
        calibration=Calibration.from_camera(camera, SIZE, reference_offset_m=1.5),
        relays_video=False,
        detector="acf",
        model_sha256="",
        versions={"fcw": "test"},
    )


def picture(index: int) -> NDArray[np.uint8]:
    """Grey road, and the frame's number."""
    image = np.full((SIZE.height, SIZE.width, 3), 90, np.uint8)
    image[: SIZE.height // 2] = 170
    for bit in range(CODE_BITS):
        value = 235 if index >> bit & 1 else 16
        left = CODE_LEFT + bit * CODE_PX
        image[SIZE.height - CODE_PX :, left : left + CODE_PX] = value
    return image


def frame_number(image: NDArray[np.uint8]) -> int:
    """The number that `picture` wrote."""
    row = image.shape[0] - CODE_PX // 2
    squares = [image[row, CODE_LEFT + bit * CODE_PX + CODE_PX // 2].mean() for bit in range(CODE_BITS)]
    return sum(1 << bit for bit, value in enumerate(squares) if value > 128)


def result(index: int) -> FrameResult:
    """What happens at a frame."""
    time_s = index / RATE_HZ
    track_id, distance_m, closing_mps, level, rule = 3, 40.0, 0.0, WarningLevel.NONE, ""
    if CAUTION_S <= time_s < WARNING_END_S:
        track_id, distance_m, closing_mps, rule = 7, 22.5, 15.0, "ttc"
        level = WarningLevel.CAUTION if time_s < WARNING_S else WarningLevel.WARNING
    elif NEAR_MISS_S <= time_s < NEAR_MISS_END_S:
        track_id, distance_m, closing_mps = 9, 11.0, 10.0
    elif ADVISORY_S <= time_s < ADVISORY_END_S:
        track_id, distance_m, level, rule = 11, 12.0, WarningLevel.ADVISORY, "headway"
    ttc_s = distance_m / closing_mps if closing_mps > 0 else None
    lead = Track(
        track_id,
        BOX,
        9.0,
        distance_m,
        distance_m * 0.9,
        distance_m * 1.2,
        0.0,
        closing_mps,
        0.5,
        ttc_s,
        3.0,
        SeenBy.DETECTOR,
        True,
    )
    other = Track(
        2, OTHER_BOX, 5.0, 50.0, 45.0, float("inf"), 8.0, -1.0, 0.5, None, 4.0, SeenBy.DETECTOR, False
    )
    state = WarningState(WarningLevel.NONE)
    if level is not WarningLevel.NONE:
        braking = closing_mps**2 / 2 / distance_m or None
        state = WarningState(level, track_id, rule, ttc_s, braking, distance_m / 20.0)
    notes = (NOTE,) if time_s >= MOVED_S else ()
    time_ns = FIRST_NS + index * PERIOD_NS
    return FrameResult(index, time_ns, (Detection(BOX, 9.0),), (other, lead), track_id, state, 20.0, notes)


class DriveWriting:
    """A log of the drive that is being written."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._sink, self._encoder = McapSink(path), VideoEncoder(SIZE, RATE_HZ)
        self._sink.open(header())

    def write(self, indices: Iterable[int]) -> None:
        """Add frames."""
        for one in map(result, indices):
            packets = self._encoder.encode(Frame(one.index, one.time_ns, picture(one.index)))
            self._sink.write(one, packets)

    def close(self) -> None:
        """Finish it."""
        self._encoder.close()
        self._sink.close()


def write_drive(path: Path, duration_s: float = DURATION_S, finished: bool = True) -> Path:
    """Write the beginning of the drive as a log; one that is not finished is torn as by a killed program."""
    writing = DriveWriting(path)
    writing.write(range(round(duration_s * RATE_HZ)))
    writing.close()
    return path if finished else tear(path, path)


def tear(log: Path, path: Path) -> Path:
    """Write what a killed program would have left of a log."""
    data = log.read_bytes()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data[: len(data) * 2 // 3])
    return path


def whole_drive(factory: pytest.TempPathFactory) -> Path:
    """The log of the whole drive, written once for all test processes; not to be written beside."""
    return made_once(factory, "made", lambda folder: write_drive(folder / "drive.mcap")) / "drive.mcap"
