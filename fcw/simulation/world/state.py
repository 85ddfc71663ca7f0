"""One instant of the simulated world, complete: what the renderer paints and the truth is computed from.

Positions along the road are arc lengths `s` of the reference line, the centre line of lane 0 (the lane in
which the own vehicle starts). `lateral` is the distance from that line, positive to the left.

Vehicles, whichever way they face, are placed by their *near face*: the one of smaller `s`, which looks
towards the own vehicle while the vehicle is ahead. It is the rear of traffic in our direction and the front
of oncoming traffic. The body reaches from the near face `size.length_m` onwards, at `heading_rad` to the
road. Speeds and accelerations are along the road in the sense of growing `s`: oncoming traffic has a
negative speed.

`WorldState.road_points` and `WorldState.vehicle_points` give positions in the own vehicle's ISO 8855 axes
(x forward, y left, z up; origin on the road below the camera; x along the road's tangent there, slope
included). `fcw.simulation.picture.projection.project` gives their pixels.
"""

import math
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.simulation.world.road import RoadProfile


class VehicleKind(Enum):
    """How a vehicle looks."""

    SALOON = "saloon"
    HATCHBACK = "hatchback"
    VAN = "van"
    TRUCK = "truck"


@dataclass(frozen=True, slots=True)
class VehicleSize:
    """Outer measures of a body, without mirrors.

    Attributes:
        width_m: of the body.
        height_m: above the road.
        length_m: of the body.
        overhang_m: from either end to the axle next to it, below which tyres meet the road.
        clearance_m: between the road and the lower edge of a bumper.
    """

    width_m: float
    height_m: float
    length_m: float
    overhang_m: float
    clearance_m: float


VEHICLE_SIZES: dict[VehicleKind, VehicleSize] = {
    VehicleKind.SALOON: VehicleSize(1.82, 1.45, 4.70, 0.90, 0.27),
    VehicleKind.HATCHBACK: VehicleSize(1.77, 1.50, 4.10, 0.75, 0.27),
    VehicleKind.VAN: VehicleSize(1.98, 2.05, 5.20, 0.95, 0.32),
    VehicleKind.TRUCK: VehicleSize(2.50, 3.60, 9.50, 1.60, 0.50),
}
"""Typical measures; a vehicle's own may differ by a few per cent."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleState:
    """A vehicle at one instant; the module says how it is placed.

    Attributes:
        name: unique in its world, constant in time.
        kind: how it looks.
        size: of its body.
        color: of its paint, BGR 0 to 255.
        seed: for everything else that varies between vehicles of one kind.
        s_m: of the middle of its near face.
        lateral_m: of the middle of its near face.
        heading_rad: of the axis from the near to the far face against the road, positive to the left.
        speed_mps: along the road; negative when oncoming.
        acceleration_mps2: along the road.
        brake_lamps: whether they are lit.
        oncoming: whether it shows its front.
    """

    name: str
    kind: VehicleKind
    size: VehicleSize
    color: tuple[int, int, int]
    seed: int
    s_m: float
    lateral_m: float
    heading_rad: float = 0.0
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    brake_lamps: bool = False
    oncoming: bool = False

    @property
    def stands_across(self) -> bool:
        """Whether its side looks along the road rather than its ends."""
        return abs(math.sin(self.heading_rad)) > abs(math.cos(self.heading_rad))


class RoadsideKind(Enum):
    """What stands beside or over the road."""

    TREE = "tree"
    BUSH = "bush"
    POST = "post"
    SIGN = "sign"
    BARRIER = "barrier"
    BRIDGE = "bridge"


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadsideItem:
    """A thing beside or over the road that never moves.

    Attributes:
        kind: what it is.
        s_m: where it begins along the road.
        lateral_m: of its middle; a bridge's is the middle of its span.
        width_m: across the road; of a bridge, its span.
        height_m: of its top above the road.
        length_m: along the road; of a barrier the whole run, of a bridge the deck's width.
        clearance_m: height of its underside above the road: of a bridge's deck, of a sign's plate.
        seed: for everything else that varies.
    """

    kind: RoadsideKind
    s_m: float
    lateral_m: float
    width_m: float
    height_m: float
    length_m: float = 0.0
    clearance_m: float = 0.0
    seed: int = 0


@dataclass(frozen=True, slots=True)
class RoadMark:
    """A white rectangle painted on the road around a point of known distance; its middle is the point."""

    s_m: float
    lateral_m: float
    along_m: float
    across_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class EgoState:
    """The own vehicle and its camera at one instant.

    Attributes:
        s_m: of the road below the camera.
        speed_mps: along the road.
        acceleration_mps2: along the road.
        lateral_m: of the camera.
        heading_rad: against the road, positive to the left.
        pitch_deviation_rad: added to the calibrated camera's pitch: positive when the nose dives.
        bounce_m: added to the calibrated camera's height.
    """

    s_m: float
    speed_mps: float = 0.0
    acceleration_mps2: float = 0.0
    lateral_m: float = 0.0
    heading_rad: float = 0.0
    pitch_deviation_rad: float = 0.0
    bounce_m: float = 0.0


@dataclass(frozen=True)
class WorldState:
    """Everything there is at one instant.

    Attributes:
        time_ns: since the drive's start.
        ego: the own vehicle.
        vehicles: the others, in the scenario's order, also those behind or too far away to be seen.
        road: the same at every instant of a drive.
        roadside: the same at every instant of a drive.
        marks: the same at every instant of a drive.
    """

    time_ns: int
    ego: EgoState
    vehicles: tuple[VehicleState, ...]
    road: RoadProfile
    roadside: tuple[RoadsideItem, ...] = field(repr=False, default=())
    marks: tuple[RoadMark, ...] = ()

    @cached_property
    def _ego_frame(self) -> tuple[FloatArray, FloatArray]:
        """Origin (3,) and axes (3, 3), one a row, of the own vehicle in the road's world frame."""
        ego = self.ego
        origin = self.road.world_points(ego.s_m, ego.lateral_m)
        return origin, _turned(self.road.axes(ego.s_m), ego.heading_rad)

    def road_points(
        self, s_m: FloatArray | float, lateral_m: FloatArray | float, height_m: FloatArray | float = 0.0
    ) -> FloatArray:
        """Points beside, on or above the road in the own vehicle's axes, shape (..., 3); inputs broadcast."""
        origin, axes = self._ego_frame
        return (self.road.world_points(s_m, lateral_m, height_m) - origin) @ axes.T

    def vehicle_points(self, vehicle: VehicleState, body_points_m: FloatArray) -> FloatArray:
        """Points of a vehicle in the own vehicle's axes.

        Args:
            vehicle: one of `vehicles`.
            body_points_m: (..., 3): metres from the near face onwards, to the left of the middle as we see
                it, above the road.

        Returns:
            (..., 3).
        """
        origin, axes = self._ego_frame
        foot = self.road.world_points(vehicle.s_m, vehicle.lateral_m)
        body_axes = _turned(self.road.axes(vehicle.s_m), vehicle.heading_rad)
        return (foot + body_points_m @ body_axes - origin) @ axes.T


def _turned(axes: FloatArray, heading_rad: float) -> FloatArray:
    """Axes turned to the left about their own z axis."""
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    forward, left, up = axes
    return np.stack((cosine * forward + sine * left, cosine * left - sine * forward, up))
