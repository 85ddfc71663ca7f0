"""KITTI tracking sequences: labels, camera and own motion, as ranging and warning are measured on them.

A folder holds `label_02/NNNN.txt`, `calib/NNNN.txt` and, where own motion is asked for, `poses/NNNN.txt`
(Geiger et al. 2012, "Are we ready for autonomous driving?"; the format is in the tracking development kit).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fcw.bounded.files import MalformedError, read_text
from fcw.box import Box
from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import FloatArray
from fcw.camera.solve import calibrate
from fcw.errors import UserError
from fcw.evaluation.motion.poses import POSE_FIELDS
from fcw.frame import ImageSize

FRAME_RATE_HZ = 10.0
CAMERA_HEIGHT_M = 1.65
"""Of the KITTI cameras above the road (Geiger et al. 2013, figure 3)."""
CALIBRATION_POINTS_M = (8.0, 15.0, 30.0)
"""Where the road is clicked, here and in simulated scenes."""
SMALLEST_IMAGE = ImageSize(1224, 370)
"""The rectified pictures of KITTI are no smaller; labels that reach the border tell how large they are."""

VEHICLES = frozenset({"Car", "Van", "Truck", "Tram", "Misc"})
IN_PATH_M = 2.0
"""A vehicle whose middle is this near the camera's axis stands in the own path."""
FROM_BEHIND_RAD = 0.3
"""A vehicle turned away by less than this is seen from behind."""
NEAREST_M, FARTHEST_M = 4.0, 80.0

MOST_FRAMES = 100_000
"""Nearly three hours; the longest sequence has 1,059."""
LARGEST_PX = 16384
_LABEL_FIELDS = 17


@dataclass(frozen=True, slots=True)
class KittiVehicle:
    """A labelled vehicle in one frame.

    Attributes:
        track_id: its identity within the sequence.
        kind: KITTI's class.
        occluded: 0 fully visible, 1 partly, 2 largely hidden, 3 unknown.
        box: in the picture, cut at its border.
        rear_m: depth of the middle of its rear face, along the camera's axis, which is level.
        lateral_m: of its middle from the camera's axis, positive to the left.
        heading_rad: 0 where it points as we do, positive to the left, in (-pi, pi].
    """

    track_id: int
    kind: str
    occluded: int
    box: Box
    rear_m: float
    lateral_m: float
    heading_rad: float

    @property
    def is_measured(self) -> bool:
        """Whether its distance counts: in the own path, from behind, in full sight, 4 to 80 m away."""
        return (
            self.occluded == 0
            and abs(self.lateral_m) <= IN_PATH_M
            and abs(self.heading_rad) <= FROM_BEHIND_RAD
            and NEAREST_M <= self.rear_m <= FARTHEST_M
        )


@dataclass(frozen=True, slots=True, eq=False)
class KittiSequence:
    """One drive.

    Attributes:
        name: four digits.
        projection: (3, 4), from the labels' coordinates to pixels.
        image_size: of its pictures.
        frames: the vehicles of each frame.
    """

    name: str
    projection: FloatArray
    image_size: ImageSize
    frames: tuple[tuple[KittiVehicle, ...], ...]

    def ground_row_px(self, distance_m: float) -> float:
        """Row of the flat road straight ahead, by the true camera."""
        point = self.projection @ np.array([0.0, CAMERA_HEIGHT_M, distance_m, 1.0])
        return float(point[1] / point[2])

    def calibration(
        self, rng: np.random.Generator, row_sigma_px: float = 1.0, pitch_error_rad: float = 0.0
    ) -> Calibration:
        """What a person makes of it who clicks the road at 8, 15 and 30 m.

        Args:
            rng: of the clicks.
            row_sigma_px: of a click.
            pitch_error_rad: the camera looked farther down by so much while it was calibrated than it does
                in the drive: on a ramp, or with another load.
        """
        focal_px, axis_px = float(self.projection[1, 1]), float(self.projection[1, 2])
        points = []
        for distance_m in CALIBRATION_POINTS_M:
            angle_rad = math.atan((self.ground_row_px(distance_m) - axis_px) / focal_px) - pitch_error_rad
            row_px = axis_px + focal_px * math.tan(angle_rad)
            points.append(GroundPoint(distance_m, row_px + row_sigma_px * rng.standard_normal()))
        # Their distances are the lidar's, not a tape's.
        return calibrate(points, self.image_size, CAMERA_HEIGHT_M, row_sigma_px=row_sigma_px, tape_error=0.0)


def time_ns(frame: int) -> int:
    """Time of a frame from the start of its sequence."""
    return round(frame / FRAME_RATE_HZ * 1e9)


def sequence_names(folder: Path, chosen: Sequence[str] = ()) -> tuple[str, ...]:
    """Names of the sequences in a folder, or of the chosen ones, each once.

    Raises:
        UserError: there are none, or a chosen one is not there.
    """
    labels = folder / "label_02"
    names = tuple(sorted(path.stem for path in labels.glob("*.txt")))
    if not names:
        raise UserError(
            f"{folder}: no KITTI tracking labels there; expected label_02/0000.txt and calib/0000.txt in it"
        )
    for name in chosen:
        if name not in names:
            raise UserError(f"{labels / name}.txt: no such sequence; expected one of {', '.join(names)}")
    return tuple(dict.fromkeys(chosen)) or names


def read_sequence(folder: Path, name: str) -> KittiSequence:
    """Read the labels and the camera of one sequence.

    Raises:
        UserError: a file is missing, or a line of it is not as expected.
    """
    projection = _read_projection(folder / "calib" / f"{name}.txt")
    # The labels' origin is the first camera's; depth is wanted from the camera of the pictures.
    depth_offset_m = float(projection[2, 3])
    by_frame: dict[int, list[KittiVehicle]] = {}
    right_px, bottom_px = SMALLEST_IMAGE.width - 1.0, SMALLEST_IMAGE.height - 1.0
    last = -1
    path = folder / "label_02" / f"{name}.txt"
    for number, fields in _lines(path, _LABEL_FIELDS):
        try:
            frame, track_id, occluded = int(fields[0]), int(fields[1]), int(fields[4])
            left, top, right, bottom = map(float, fields[6:10])
            _height, _width, length, x, _y, z, rotation = map(float, fields[10:17])
        except ValueError as error:
            raise _not_as_expected(path, number, "a KITTI tracking label", str(error)) from None
        if not 0 <= frame < MOST_FRAMES:
            raise _not_as_expected(path, number, f"a frame from 0 to {MOST_FRAMES - 1}", fields[0][:20])
        if not all(map(math.isfinite, (left, top, right, bottom, length, x, z, rotation))):
            raise _not_as_expected(path, number, "a KITTI tracking label", "a number is not finite")
        if max(right, bottom) > LARGEST_PX:
            raise _not_as_expected(path, number, f"a box within {LARGEST_PX} pixels", "it is larger")
        last = max(last, frame)
        if fields[2] == "DontCare":
            continue
        right_px, bottom_px = max(right_px, right), max(bottom_px, bottom)
        if fields[2] not in VEHICLES:
            continue
        vehicle = KittiVehicle(
            track_id=track_id,
            kind=fields[2],
            occluded=occluded,
            box=Box(left, top, right - left, bottom - top),
            # The vehicle points along (cos r, -sin r) in x and z.
            rear_m=z + length / 2 * math.sin(rotation) + depth_offset_m,
            lateral_m=-x,
            heading_rad=math.remainder(-rotation - math.pi / 2, 2 * math.pi),
        )
        by_frame.setdefault(frame, []).append(vehicle)
    frames = tuple(tuple(by_frame.get(frame, ())) for frame in range(last + 1))
    return KittiSequence(name, projection, ImageSize(round(right_px) + 1, round(bottom_px) + 1), frames)


def read_own_motion(folder: Path, name: str) -> tuple[FloatArray, FloatArray]:
    """Own speed in m/s and yaw rate in rad/s (positive to the left) at each frame of a sequence.

    Both are differences over two frames, one-sided at the ends.

    Raises:
        UserError: the file of poses is missing, or a line of it is not as expected.
    """
    path = folder / "poses" / f"{name}.txt"
    try:
        poses = np.array([[float(value) for value in fields] for _, fields in _lines(path, POSE_FIELDS)])
    except ValueError as error:
        raise UserError(f"{path}: expected {POSE_FIELDS} numbers a line ({error})") from None
    if len(poses) < 2:
        raise UserError(f"{path}: expected at least two poses, one a line")
    poses = poses.reshape(-1, 3, 4)
    rate_hz = FRAME_RATE_HZ
    speed_mps = np.linalg.norm(np.gradient(poses[:, :, 3], axis=0), axis=1) * rate_hz
    # The camera's axis in the world's x and z, which are those of the first camera: x to the right.
    yaw_rad = np.unwrap(-np.arctan2(poses[:, 0, 2], poses[:, 2, 2]))
    return speed_mps, np.gradient(yaw_rad) * rate_hz


def _read_projection(path: Path) -> FloatArray:
    for number, fields in _lines(path, 1):
        if fields[0] == "P2:":
            try:
                projection = np.array([float(value) for value in fields[1:13]]).reshape(3, 4)
            except ValueError as error:
                raise _not_as_expected(path, number, "P2: and twelve numbers", str(error)) from None
            if not (projection[1, 1] > 0 and projection[2, 2] > 0):
                found = f"{projection[1, 1]:g} and {projection[2, 2]:g}"
                raise _not_as_expected(path, number, "a focal length and a scale above 0", found)
            return projection
    raise UserError(f"{path}: no line P2: in it; expected a calibration file of KITTI tracking")


def _lines(path: Path, fewest: int) -> Iterator[tuple[int, list[str]]]:
    """Numbered lines of a text file as fields, empty ones left out."""
    try:
        text = read_text(path)
    except (OSError, MalformedError) as error:
        raise UserError(f"{path}: cannot be read ({error}); expected a text file of KITTI tracking") from None
    for number, line in enumerate(text.splitlines(), 1):
        fields = line.split()
        if not fields:
            continue
        if len(fields) < fewest:
            raise _not_as_expected(path, number, f"{fewest} fields", f"{len(fields)} found")
        yield number, fields


def _not_as_expected(path: Path, number: int, expected: str, found: str) -> UserError:
    return UserError(f"{path}, line {number}: expected {expected} ({found}); get the file anew")
