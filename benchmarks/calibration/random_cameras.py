"""Random plausible cameras behind windscreens, and the mistakes that people make with them."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.straight import Orientation, Straightening
from fcw.frame import ImageSize

SIZE = ImageSize(1280, 720)


@dataclass(frozen=True)
class Population:
    """Cameras of one kind, and the marks that people lay before them.

    Attributes:
        name: of it.
        camera: draws one.
        marks_m: distances of the marks, by their name.
    """

    name: str
    camera: Callable[[np.random.Generator], GroundPlaneCamera]
    marks_m: dict[str, tuple[float, ...]]

    def seeing(self, rng: np.random.Generator, nearest_m: float) -> GroundPlaneCamera:
        """One that sees the nearest mark, and the horizon."""
        while True:
            camera = self.camera(rng)
            if camera.row_at(nearest_m) <= SIZE.height - 0.5 and camera.horizon_row_px > 0:
                return camera


def _camera(field_of_view_deg: float, pitch_deg: float, axis_px: float, height_m: float) -> GroundPlaneCamera:
    focal_px = SIZE.width / 2 / math.tan(math.radians(field_of_view_deg) / 2)
    return GroundPlaneCamera(math.radians(pitch_deg), focal_px, axis_px, height_m, (SIZE.width - 1) / 2)


def _windscreen(rng: np.random.Generator) -> GroundPlaneCamera:
    """A lens of 45 to 110 degrees, 1.1 to 1.8 m high, 2 degrees up to 10 down."""
    return _camera(
        rng.uniform(45, 110),
        rng.uniform(-2, 10),
        (SIZE.height - 1) / 2 + 0.03 * SIZE.height * rng.standard_normal(),
        rng.uniform(1.1, 1.8),
    )


def _any_vehicle(rng: np.random.Generator) -> GroundPlaneCamera:
    """Sports cars to lorries, telephones to wide lenses, most of them nearly level; axes with heavy tails."""
    return _camera(
        math.exp(rng.uniform(math.log(40), math.log(115))),
        rng.normal(2.5, 4.0),
        (SIZE.height - 1) / 2 + 0.02 * SIZE.height * rng.standard_t(4),
        rng.uniform(0.95, 2.6),
    )


CHOSEN_ON = Population(
    "chosen on",
    _windscreen,
    {
        "4/5/7": (4.0, 5.0, 7.0),
        "5/10/20": (5.0, 10.0, 20.0),
        "7.6/16.6/31.6": (7.6, 16.6, 31.6),
        "6/15/40": (6.0, 15.0, 40.0),
    },
)
"""The verdicts' thresholds were chosen on these."""
OTHER = Population(
    "other",
    _any_vehicle,
    {
        "4/5/7": (4.0, 5.0, 7.0),
        "5/8/12": (5.0, 8.0, 12.0),
        "6/9/14/22": (6.0, 9.0, 14.0, 22.0),
        "8/16/35": (8.0, 16.0, 35.0),
    },
)
"""Nothing was chosen on these: other heights, lenses and marks."""


@dataclass(frozen=True)
class Mistakes:
    """What goes wrong besides the noise of clicks.

    Attributes:
        tape: error of all distances together, as a part of them.
        uneven: error of each distance for itself, likewise.
        offset_m: from the camera forward to where the distances start in truth.
    """

    tape: float = 0.0
    uneven: float = 0.0
    offset_m: float = 0.0


def clicked(
    rng: np.random.Generator,
    camera: GroundPlaneCamera,
    distances_m: tuple[float, ...],
    mistakes: Mistakes = Mistakes(),
    click_px: float = 1.0,
) -> tuple[GroundPoint, ...]:
    """Marks at distances from a reference, as they were said and clicked."""
    points = []
    scale = 1 + mistakes.tape * rng.standard_normal()
    for distance_m in distances_m:
        true_m = distance_m * (1 + mistakes.uneven * rng.standard_normal()) * scale + mistakes.offset_m
        points.append(GroundPoint(distance_m, camera.row_at(true_m) + click_px * rng.standard_normal()))
    return tuple(points)


def clicked_beside(
    rng: np.random.Generator,
    camera: GroundPlaneCamera,
    distances_m: tuple[float, ...],
    mistakes: Mistakes,
    roll_rad: float,
    side_m: float,
    click_px: float = 1.0,
) -> tuple[GroundPoint, ...]:
    """The same with columns, as on the page: marks so far (sigma) to the sides of a camera so rolled."""
    way = Straightening(camera, Orientation(roll_rad=roll_rad), None, SIZE)
    points = []
    scale = 1 + mistakes.tape * rng.standard_normal()
    for distance_m in distances_m:
        true_m = distance_m * (1 + mistakes.uneven * rng.standard_normal()) * scale + mistakes.offset_m
        column_px = camera.column_at(side_m * rng.standard_normal(), true_m)
        place = way.to_picture(np.array([[column_px, camera.row_at(true_m)]]))[0]
        column_px, row_px = (place + click_px * rng.standard_normal(2)).tolist()
        points.append(GroundPoint(distance_m, row_px, column_px))
    return tuple(points)
