"""Writes tracks in the formats of two benchmarks: KITTI tracking and MOTChallenge."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

from fcw.camera.calibration import Calibration
from fcw.files import whole_file
from fcw.logs.export.clip import DriveClip
from fcw.logs.overlay import rear_size_m
from fcw.logs.records import FrameResult
from fcw.tracking.types import Track

KITTI_TYPE = "Car"
"""KITTI's class for all vehicles, because the detector does not tell their kinds."""
UNKNOWN_STATE = -1
UNKNOWN_ANGLE_RAD = -10
UNKNOWN_SIZE_M = -1
UNKNOWN_PLACE_M = -1000
"""KITTI's value for what a tracker does not provide (readme of its tracking benchmark)."""
REAR_LENGTH_M = 0
"""Length of a vehicle: only its rear is seen, and its location is that of the rear."""
MOT_ORIGIN = 1
"""MOTChallenge counts frames and pixels from 1."""
MOT_NO_WORLD = "-1,-1,-1"


def kitti_lines(result: FrameResult, calibration: Calibration) -> Iterator[str]:
    """The tracks of a frame as lines of a KITTI tracking result.

    The fields are frame, track id, type, truncated, occluded, alpha, box (left, top, right, bottom),
    dimensions (height, width, length), location (x, y, z in the axes of the camera: right, down, forward),
    rotation and score.
    """
    for track in result.tracks:
        box = track.box
        yield " ".join(
            map(
                str,
                (
                    *(result.index, track.track_id, KITTI_TYPE, UNKNOWN_STATE, UNKNOWN_STATE),
                    *(UNKNOWN_ANGLE_RAD, box.x, box.y, box.right, box.bottom),
                    *_rear_face(track, calibration),
                    *(UNKNOWN_ANGLE_RAD, track.score),
                ),
            )
        )


def mot_lines(result: FrameResult) -> Iterator[str]:
    """The tracks of a frame as lines of a MOTChallenge result.

    The fields are frame, id, left, top, width and height of the box, score, and -1 for each world coordinate.
    """
    for track in result.tracks:
        box = track.box
        fields = (
            *(result.index + MOT_ORIGIN, track.track_id),
            *(box.x + MOT_ORIGIN, box.y + MOT_ORIGIN, box.w, box.h, track.score),
        )
        yield f"{','.join(map(str, fields))},{MOT_NO_WORLD}"


def write_kitti(path: Path, clip: DriveClip, on_frame: Callable[[], None]) -> int:
    """Write the tracks of a drive as KITTI tracking results and return the number of lines.

    Raises:
        UserError: the file cannot be written there.
    """
    calibration = clip.log.header.calibration
    return _write(path, clip, lambda result: kitti_lines(result, calibration), on_frame)


def write_mot(path: Path, clip: DriveClip, on_frame: Callable[[], None]) -> int:
    """Write the tracks of a drive as MOTChallenge results and return the number of lines.

    Raises:
        UserError: the file cannot be written there.
    """
    return _write(path, clip, mot_lines, on_frame)


def _write(
    path: Path,
    clip: DriveClip,
    lines_of: Callable[[FrameResult], Iterator[str]],
    on_frame: Callable[[], None],
) -> int:
    count = 0
    with whole_file(path) as partial, partial.open("w", encoding="ascii", newline="\n") as file:
        for result in clip.results():
            for line in lines_of(result):
                file.write(f"{line}\n")
                count += 1
            on_frame()
    return count


def _rear_face(track: Track, calibration: Calibration) -> tuple[float, ...]:
    """Height, width and length, then x, y and z of the middle of its lower edge."""
    along_m = track.distance_m + calibration.reference_offset_m
    if not (math.isfinite(along_m) and math.isfinite(track.lateral_m)):
        return (UNKNOWN_SIZE_M,) * 3 + (UNKNOWN_PLACE_M,) * 3
    _, height_m = rear_size_m(track, calibration)  # the box is wider where it shows a side, too
    camera = calibration.camera
    sine, cosine = math.sin(camera.pitch_rad), math.cos(camera.pitch_rad)
    down_m = camera.height_m * cosine - along_m * sine
    forward_m = along_m * cosine + camera.height_m * sine
    return height_m, track.width_m, REAR_LENGTH_M, -track.lateral_m, down_m, forward_m
