"""A plain drive with exact truth: following, a lead that brakes hard, and neighbours; no weather, no bends.

    python -m fcw.simulation.plain_drive FOLDER

writes the video, its calibration from three exact points, the own speed and the truth.
"""

import csv
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from fcw.camera.calibration import Calibration, GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.detection.types import Box
from fcw.simulation.scene import PlacedVehicle, Scene
from fcw.simulation.textures import LANE_WIDTH_M, Body
from fcw.sources.frame import Frame, ImageSize

IMAGE_SIZE = ImageSize(1280, 720)
CAMERA = GroundPlaneCamera(
    pitch_rad=0.03, focal_y_px=1000.0, principal_row_px=359.5, height_m=1.3, principal_column_px=639.5
)
REFERENCE_OFFSET_M = 1.6
"""From the camera forward to the front bumper."""
FRAMES_PER_SECOND = 30
DURATION_S = 24
BRAKE_LAMPS_MPS2 = -0.7
"""Brake lamps light below this acceleration; rolling out is weaker."""
CALIBRATION_DISTANCES_M = (6.0, 15.0, 40.0)
CALIBRATION_ROW_SIGMA_PX = 0.5
"""The points are exact; the file says what careful clicks would be."""


@dataclass(frozen=True, slots=True)
class Motion:
    """Motion along the road with piecewise constant acceleration.

    Attributes:
        start_m: position of the front bumper (own vehicle) or the rear (others) at time zero.
        speed_mps: speed at time zero.
        phases: (time in seconds, acceleration from then on), ascending.
    """

    start_m: float
    speed_mps: float
    phases: tuple[tuple[float, float], ...] = ()

    def at(self, time_s: float) -> tuple[float, float, float]:
        """Position, speed and acceleration at a time."""
        position_m, speed_mps, acceleration_mps2, since_s = self.start_m, self.speed_mps, 0.0, 0.0
        for start_s, next_mps2 in (*self.phases, (time_s, 0.0)):
            step_s = min(start_s, time_s) - since_s
            position_m += speed_mps * step_s + acceleration_mps2 * step_s**2 / 2
            speed_mps += acceleration_mps2 * step_s
            since_s += step_s
            if start_s >= time_s:
                break
            acceleration_mps2 = next_mps2
        return position_m, speed_mps, acceleration_mps2


@dataclass(frozen=True, slots=True)
class Actor:
    """Another vehicle of the drive."""

    name: str
    body: Body
    lateral_m: float
    motion: Motion


@dataclass(frozen=True, slots=True)
class VehicleTruth:
    """Where a vehicle truly is at a frame.

    Attributes:
        name: which one.
        distance_m: from the own front bumper to its rear; negative when it is beside or behind.
        lateral_m: of its middle from the camera's axis, positive to the left.
        closing_speed_mps: rate at which the distance shrinks.
        box: around its rear, not cut to the picture; None when the rear is not ahead of the bumper.
    """

    name: str
    distance_m: float
    lateral_m: float
    closing_speed_mps: float
    box: Box | None


EGO = Motion(0.0, 25.0, ((8.9, -7.0), (11.0, -2.0), (11.6, 0.0), (13.2, 1.5), (20.0, 0.0)))
"""Brakes 1.9 s after the lead begins to: late, and just enough."""
HATCHBACK = Body(
    width_m=1.8,
    height_m=1.46,
    length_m=4.4,
    cabin_length_m=3.1,
    roof_width=0.7,
    waist_m=0.98,
    color=(120, 62, 38),
)
ESTATE = Body(
    width_m=1.82,
    height_m=1.5,
    length_m=4.7,
    cabin_length_m=3.4,
    roof_width=0.74,
    waist_m=1.0,
    color=(196, 199, 201),
)
VAN = Body(
    width_m=1.95,
    height_m=2.0,
    length_m=5.2,
    cabin_length_m=4.6,
    roof_width=0.88,
    waist_m=1.2,
    color=(58, 58, 62),
)
RED_CAR = Body(
    width_m=1.76,
    height_m=1.44,
    length_m=4.2,
    cabin_length_m=3.0,
    roof_width=0.7,
    waist_m=0.96,
    color=(34, 30, 128),
)
ACTORS = (
    Actor("lead", HATCHBACK, 0.0, Motion(25.0, 25.0, ((7.0, -5.0), (10.0, 0.0), (12.0, 2.0), (17.0, 0.0)))),
    Actor("overtaker", ESTATE, LANE_WIDTH_M, Motion(-12.0, 29.5, ((8.2, -5.0), (11.2, 0.0)))),
    Actor("van", VAN, -LANE_WIDTH_M, Motion(46.0, 22.0, ((8.5, -3.0), (11.5, 0.0)))),
    Actor("far car", RED_CAR, LANE_WIDTH_M, Motion(75.0, 27.0, ((8.0, -3.0), (12.0, 0.0)))),
)


def truth_at(time_s: float) -> tuple[VehicleTruth, ...]:
    """The truth of every other vehicle at a time."""
    own_m, own_mps, _ = EGO.at(time_s)
    return tuple(_vehicle_truth(actor, time_s, own_m, own_mps) for actor in ACTORS)


def _vehicle_truth(actor: Actor, time_s: float, own_m: float, own_mps: float) -> VehicleTruth:
    position_m, speed_mps, _ = actor.motion.at(time_s)
    distance_m = position_m - own_m
    box = None
    if distance_m > 0:
        body = actor.body
        box = CAMERA.ground_box(distance_m + REFERENCE_OFFSET_M, actor.lateral_m, body.width_m, body.height_m)
    return VehicleTruth(actor.name, distance_m, actor.lateral_m, own_mps - speed_mps, box)


def frame_time_ns(index: int) -> int:
    """Time of a frame."""
    return round(index * 1e9 / FRAMES_PER_SECOND)


def render_plain_drive(
    seed: int = 0, duration_s: int = DURATION_S
) -> Iterator[tuple[Frame, tuple[VehicleTruth, ...]]]:
    """The frames of the drive, each with its truth; the same for the same seed, bit for bit.

    Args:
        seed: of surfaces and roadside; the motion is always the same.
        duration_s: how much of the drive, from its beginning.
    """
    scene = Scene(CAMERA, IMAGE_SIZE, seed)
    for index in range(duration_s * FRAMES_PER_SECOND):
        time_s = index / FRAMES_PER_SECOND
        truth = truth_at(time_s)
        placed = tuple(
            PlacedVehicle(
                actor.body,
                vehicle.distance_m + REFERENCE_OFFSET_M,
                actor.lateral_m,
                actor.motion.at(time_s)[2] < BRAKE_LAMPS_MPS2,
            )
            for actor, vehicle in zip(ACTORS, truth, strict=True)
        )
        image = scene.paint(EGO.at(time_s)[0], placed)
        yield Frame(index, frame_time_ns(index), image), truth


def exact_calibration() -> Calibration:
    """The calibration from three exact points, as somebody with a tape measure would find it."""
    points = tuple(
        GroundPoint(distance_m, CAMERA.row_at(distance_m + REFERENCE_OFFSET_M))
        for distance_m in CALIBRATION_DISTANCES_M
    )
    return calibrate(
        points, IMAGE_SIZE, CAMERA.height_m, REFERENCE_OFFSET_M, row_sigma_px=CALIBRATION_ROW_SIGMA_PX
    )


def write_plain_drive(directory: Path, seed: int = 0, duration_s: int = DURATION_S) -> None:
    """Write `drive.mp4`, `drive.calibration.yaml`, `drive.speed.csv` and `truth.csv` into a folder.

    The video is H.264 without B frames, with a keyframe a second, so that a log can relay its packets.
    The own speed is given where its slope changes: linear interpolation is exact.
    """
    directory.mkdir(parents=True, exist_ok=True)
    exact_calibration().save(directory / "drive.calibration.yaml")
    changes_s = (start_s for start_s, _ in EGO.phases if start_s < duration_s)
    knots_s = [0.0, *changes_s, float(duration_s)]
    speeds = [(f"{time_s:g}", f"{EGO.at(time_s)[1]:.6g}") for time_s in knots_s]
    _write_csv(directory / "drive.speed.csv", ("time_s", "speed_mps"), speeds)
    truth_rows: list[tuple[str, ...]] = []
    partial = directory / ".drive.partial.mp4"
    with av.open(str(partial), "w", format="mp4") as container:
        stream = container.add_stream(
            "libx264",
            rate=FRAMES_PER_SECOND,
            options={"preset": "slow", "crf": "27", "bf": "0", "g": str(FRAMES_PER_SECOND), "threads": "1"},
        )
        stream.width, stream.height, stream.pix_fmt = IMAGE_SIZE.width, IMAGE_SIZE.height, "yuv420p"
        stream.time_base = Fraction(1, FRAMES_PER_SECOND)
        for frame, truth in render_plain_drive(seed, duration_s):
            planes = np.asarray(cv2.cvtColor(frame.image, cv2.COLOR_BGR2YUV_I420), np.uint8)
            picture = av.VideoFrame.from_ndarray(planes, format="yuv420p")
            picture.pts = frame.index
            container.mux(stream.encode(picture))
            truth_rows += [_truth_row(frame, vehicle) for vehicle in truth]
        container.mux(stream.encode(None))
    partial.replace(directory / "drive.mp4")
    _write_csv(directory / "truth.csv", TRUTH_COLUMNS, truth_rows)


TRUTH_COLUMNS = (
    "frame",
    "time_s",
    "ego_speed_mps",
    "vehicle",
    "distance_m",
    "lateral_m",
    "closing_speed_mps",
    "box_x",
    "box_y",
    "box_w",
    "box_h",
)
"""Of `truth.csv`: see `VehicleTruth`; the box is empty where there is none."""


def _truth_row(frame: Frame, vehicle: VehicleTruth) -> tuple[str, ...]:
    box = vehicle.box
    edges = ("", "", "", "") if box is None else tuple(f"{x:.2f}" for x in (box.x, box.y, box.w, box.h))
    time_s = frame.index / FRAMES_PER_SECOND
    numbers = (vehicle.distance_m, vehicle.lateral_m, vehicle.closing_speed_mps)
    return (
        str(frame.index),
        f"{time_s:.6f}",
        f"{EGO.at(time_s)[1]:.4f}",
        vehicle.name,
        *(f"{number:.4f}" for number in numbers),
        *edges,
    )


def _write_csv(path: Path, columns: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    partial = path.with_name(f".{path.name}.partial")
    with partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    partial.replace(path)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m fcw.simulation.plain_drive FOLDER")
    write_plain_drive(Path(sys.argv[1]))
