"""What stands on the ground ahead at a frame: vehicles, the own path and distance rings, in vehicle axes.

The axes are those of ISO 8855 on the road: x forward from the calibration's reference, y to the left, z up.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.logs.overlay import (
    LEVEL_COLORS,
    VEHICLE_LENGTH_M,
    OverlayBox,
    Rgb,
    overlay_boxes,
    rear_size_m,
)
from fcw.logs.records import FrameResult
from fcw.motion.path import path_curvature_per_m
from fcw.motion.state import OwnPath
from fcw.tracking.lead import Corridor
from fcw.tracking.types import Track
from fcw.units import distance_text, speed_text

Point = tuple[float, float, float]
Floats = NDArray[np.float64]

RING_DISTANCES_M = (10.0, 20.0, 30.0, 40.0, 50.0, 80.0)
RING_HALF_ANGLE_RAD = math.radians(38)
"""Of the rings only what a camera may see is drawn."""
RING_POINTS = 25
EYE_BEHIND_M = 36.0
"""How far behind us the view's first place is."""
LABEL_SLOPE = 0.137
"""Distance of the rings' labels to the right of the view's middle, over their distance from the eye. So they
form a column, which fits a window that is as wide as high. The nearest one stands at the end of its ring."""
PATH_LENGTH_M = 80.0
PATH_POINTS = 33
SMALLEST_M, SMALLEST_HEIGHT_M, LARGEST_M = 1.0, 1.0, 4.0
"""A box cut off by the picture's edge still stands for a vehicle."""
SIZE_STEP_M = 0.1
"""Sizes change in such steps: what changes less is not sent."""
ARROW_S = 1.0
"""An arrow is as long as the way that the vehicle comes nearer in this time."""
SHORTEST_ARROW_M = 0.5
ARROW_HEIGHT_M = 0.4
FARTHEST_M = 150.0
"""An interval that is open ends here."""
LABEL_ABOVE_M = 0.8


@dataclass(frozen=True, slots=True)
class GroundVehicle:
    """A vehicle as a box on the road.

    Attributes:
        track_id: of its track.
        centre_m: middle of the box.
        size_m: length, width and height.
        color: the lead's says the warning level.
        label: distance, and TTC where it is short; empty for most, see `fcw.logs.overlay.told_ids`.
        label_at_m: where the label stands.
        interval_m: from where to where its rear may be, two times out of three.
        arrow_m: from its rear to where it will be in `ARROW_S`, seen from us; None where that is noise.
    """

    track_id: int
    centre_m: Point
    size_m: Point
    color: Rgb
    label: str
    label_at_m: Point
    interval_m: tuple[Point, Point]
    arrow_m: tuple[Point, Point] | None


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """All that changes from frame to frame.

    Attributes:
        vehicles: the nearest first.
        path_left_m: (`PATH_POINTS`, 3) left edge of the own path, from us on.
        path_right_m: its right edge, likewise.
        path_color: that of the warning level.
        own_speed: in words; empty where it is unknown.
    """

    vehicles: tuple[GroundVehicle, ...]
    path_left_m: Floats
    path_right_m: Floats
    path_color: Rgb
    own_speed: str = ""


def ground(
    result: FrameResult, calibration: Calibration, imperial: bool, yaw_rate_radps: float | None = None
) -> Ground:
    """What stands on the ground at a frame.

    Args:
        result: of the frame.
        calibration: of the drive.
        imperial: units of the words.
        yaw_rate_radps: how fast we turn, positive to the left; the path is straight where it is unknown.
    """
    drawn = zip(result.tracks, overlay_boxes(result, imperial), strict=True)
    nearest_first = sorted(drawn, key=lambda pair: pair[0].distance_m)
    level_color = LEVEL_COLORS[result.warning.level]
    if result.own_path is not None:
        left, right = own_path_edges(result.own_path, calibration.reference_offset_m)
    else:
        left, right = path_edges(path_curvature_per_m(result.ego_speed_mps, yaw_rate_radps))
    vehicles = tuple(_vehicle(track, calibration, box) for track, box in nearest_first)
    own_mps = result.ego_speed_mps
    return Ground(
        vehicles, left, right, level_color, "" if own_mps is None else speed_text(own_mps, imperial)
    )


def own_path_edges(path: OwnPath, reference_offset_m: float) -> tuple[Floats, Floats]:
    """Left and right edge of the own path as it was believed, each (`PATH_POINTS`, 3).

    Args:
        path: over the distance from the camera.
        reference_offset_m: from the camera to where the distances shown begin.
    """
    along_m = np.linspace(0.0, PATH_LENGTH_M, PATH_POINTS)
    middle_m = np.array([path.lateral_at(distance_m) for distance_m in along_m + reference_offset_m])
    half_m = Corridor().leave_m if path.lane_width_m is None else path.lane_width_m / 2
    left, right = (
        np.stack([along_m, middle_m + side_m, np.zeros(PATH_POINTS)], axis=1) for side_m in (half_m, -half_m)
    )
    return left, right


def path_edges(curvature_per_m: float) -> tuple[Floats, Floats]:
    """Left and right edge of the own path, each (`PATH_POINTS`, 3), along a circle that starts ahead.

    Args:
        curvature_per_m: one over the circle's radius, positive to the left.
    """
    along_m = np.linspace(0.0, PATH_LENGTH_M, PATH_POINTS)
    turned_rad = along_m * curvature_per_m
    # sin(a) / a and (1 - cos(a)) / a with their limits at 0: np.sinc(t) is sin(pi t) / (pi t).
    x = along_m * np.sinc(turned_rad / np.pi)
    y = along_m * np.sinc(turned_rad / (2 * np.pi)) * np.sin(turned_rad / 2)
    half_width_m = Corridor().leave_m
    to_left = np.stack([-np.sin(turned_rad), np.cos(turned_rad), np.zeros(PATH_POINTS)], axis=1)
    middle = np.stack([x, y, np.zeros(PATH_POINTS)], axis=1)
    return middle + half_width_m * to_left, middle - half_width_m * to_left


def ring(distance_m: float) -> Floats:
    """(`RING_POINTS`, 3) points at the same distance from us, from the right to the left."""
    angles_rad = np.linspace(-RING_HALF_ANGLE_RAD, RING_HALF_ANGLE_RAD, RING_POINTS)
    return distance_m * np.stack([np.cos(angles_rad), np.sin(angles_rad), np.zeros(RING_POINTS)], axis=1)


def ring_label(distance_m: float, imperial: bool) -> tuple[str, Point]:
    """The words of a ring, and where they stand: on it, to the right, in one column for all rings."""
    # On the ring x^2 + y^2 = d^2, and on the line y = -k (x + e) through the eye.
    k2, e = LABEL_SLOPE**2, EYE_BEHIND_M
    x = (math.sqrt(distance_m**2 * (1 + k2) - k2 * e**2) - k2 * e) / (1 + k2)
    return distance_text(distance_m, imperial), (x, -LABEL_SLOPE * (x + e), 0.0)


def segments(points: Floats) -> Floats:
    """(N, 3) points of a line as (N - 1, 2, 3) segments."""
    return np.stack([points[:-1], points[1:]], axis=1)


def strip_faces(count: int) -> NDArray[np.uint32]:
    """(2 (N - 1), 3) triangles between two edges of N points each, one after the other in a list of 2 N."""
    first = np.arange(count - 1, dtype=np.uint32)
    return np.concatenate(
        [
            np.stack([first + count, first + count + 1, first], axis=1),
            np.stack([first + count + 1, first + 1, first], axis=1),
        ]
    ).astype(np.uint32)


def arrows(vehicles: Sequence[GroundVehicle]) -> tuple[Floats, NDArray[np.uint8]]:
    """(N, 2, 3) from and to, and the (N, 3) colours, of the arrows there are."""
    moving = [vehicle for vehicle in vehicles if vehicle.arrow_m is not None]
    points = np.array([vehicle.arrow_m for vehicle in moving], np.float64).reshape(-1, 2, 3)
    return points, np.array([vehicle.color for vehicle in moving], np.uint8).reshape(-1, 3)


def _vehicle(track: Track, calibration: Calibration, drawn: OverlayBox) -> GroundVehicle:
    width_m, height_m = rear_size_m(track, calibration)
    width_m = _stepped(min(max(width_m, SMALLEST_M), LARGEST_M))
    height_m = _stepped(min(max(height_m, SMALLEST_HEIGHT_M), LARGEST_M))
    x, y = track.distance_m, track.lateral_m
    high_m = min(track.distance_high_m, max(FARTHEST_M, x))
    arrow = None
    way_m = track.closing_speed_mps * ARROW_S
    if abs(way_m) >= SHORTEST_ARROW_M and abs(track.closing_speed_mps) > track.closing_speed_sigma_mps:
        start_m = x if way_m > 0 else x + VEHICLE_LENGTH_M
        arrow = ((start_m, y, ARROW_HEIGHT_M), (start_m - way_m, y, ARROW_HEIGHT_M))
    return GroundVehicle(
        track_id=track.track_id,
        centre_m=(x + VEHICLE_LENGTH_M / 2, y, height_m / 2),
        size_m=(VEHICLE_LENGTH_M, width_m, height_m),
        color=drawn.color,
        label=drawn.label,
        label_at_m=(x, y, height_m + LABEL_ABOVE_M),
        interval_m=((track.distance_low_m, y, 0.0), (high_m, y, 0.0)),
        arrow_m=arrow,
    )


def _stepped(length_m: float) -> float:
    return round(length_m / SIZE_STEP_M) * SIZE_STEP_M
