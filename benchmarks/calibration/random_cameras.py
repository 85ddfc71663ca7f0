"""Random plausible cameras behind windscreens, and the mistakes that people make with them."""

import math
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)
POINT_SETS: dict[str, tuple[float, ...]] = {
    "4/5/7": (4.0, 5.0, 7.0),
    "5/10/20": (5.0, 10.0, 20.0),
    "7.6/16.6/31.6": (7.6, 16.6, 31.6),
    "6/15/40": (6.0, 15.0, 40.0),
}
COLUMN_SPREAD_PX = 300.0


@dataclass(frozen=True)
class Trial:
    """A camera, and the points clicked in its picture."""

    camera: GroundPlaneCamera
    points: tuple[GroundPoint, ...]


def random_camera(rng: np.random.Generator, nearest_m: float) -> GroundPlaneCamera:
    """A lens of 45 to 110 degrees, 1.1 to 1.8 m high, 2 degrees up to 10 down, that sees the nearest mark."""
    while True:
        field_of_view = math.radians(rng.uniform(45, 110))
        camera = GroundPlaneCamera(
            math.radians(rng.uniform(-2, 10)),
            SIZE.width / 2 / math.tan(field_of_view / 2),
            (SIZE.height - 1) / 2 + 0.03 * SIZE.height * rng.standard_normal(),
            rng.uniform(1.1, 1.8),
            (SIZE.width - 1) / 2,
        )
        if camera.row_at(nearest_m) <= SIZE.height - 0.5 and camera.horizon_row_px > 0:
            return camera


def clicked(
    rng: np.random.Generator,
    camera: GroundPlaneCamera,
    distances_m: tuple[float, ...],
    click_px: float = 1.0,
    tape: float = 0.0,
    uneven: float = 0.0,
    offset_m: float = 0.0,
    roll_rad: float = 0.0,
) -> tuple[GroundPoint, ...]:
    """Marks at distances from a reference, clicked; with a roll they lie to the left and to the right.

    Args:
        rng: of all noise.
        camera: that sees them.
        distances_m: as they were said.
        click_px: error of a click.
        tape: error of all distances together, as a part of them.
        uneven: error of each distance for itself, likewise.
        offset_m: from the camera forward to where the distances start in truth.
        roll_rad: of the camera to the left.
    """
    points = []
    scale = 1 + tape * rng.standard_normal()
    for distance_m in distances_m:
        true_m = distance_m * (1 + uneven * rng.standard_normal()) * scale + offset_m
        row = camera.row_at(true_m) + click_px * rng.standard_normal()
        column = None
        if roll_rad:
            aside_px = rng.uniform(-COLUMN_SPREAD_PX, COLUMN_SPREAD_PX)
            column = camera.principal_column_px + aside_px
            row += math.tan(roll_rad) * aside_px
        points.append(GroundPoint(distance_m, row, column))
    return tuple(points)
