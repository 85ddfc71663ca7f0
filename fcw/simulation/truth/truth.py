"""What is true at an instant: distances, closing speeds, boxes, what hides what, and the horizon.

All of it is about the face of a vehicle that looks along the road towards us: its near face, or, where it
stands across the road, its near side.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.frame import ImageSize
from fcw.simulation.picture.projection import dynamic_camera, project
from fcw.simulation.world.state import VehicleState, WorldState
from fcw.warning.driver import EXPECTED_DRIVER

IN_PATH_M = 1.75
"""A vehicle whose middle is nearer than half a lane to our own path is in it."""
NEAREST_DEPTH_M = 0.3
"""A face nearer to the camera than this has no box: it is beside the bonnet."""
VISIBILITY_SAMPLES = 24
"""Visibility is counted on so many points across a face, and so many down."""


@dataclass(frozen=True, slots=True)
class VehicleTruth:
    """A vehicle ahead of our bumper at one instant.

    Attributes:
        name: which one.
        distance_m: along the road from our front bumper to its near face.
        lateral_m: of that face's middle along the camera's left axis.
        path_lateral_m: of that face's middle from our own path, along the road.
        closing_speed_mps: rate at which the distance shrinks.
        ttc_s: distance over closing speed; None when the gap is not closing.
        box: exact, around its near face and down to where its tyres meet the road, not cut to the picture.
        body_box: around its whole body.
        visible_fraction: of the near face: inside the picture, not behind nearer vehicles nor its own body.
        oncoming: whether the near face is its front.
        in_path: whether it stands in our path and does not come towards us.
    """

    name: str
    distance_m: float
    lateral_m: float
    path_lateral_m: float
    closing_speed_mps: float
    ttc_s: float | None
    box: Box
    body_box: Box
    visible_fraction: float
    oncoming: bool
    in_path: bool


@dataclass(frozen=True, slots=True)
class FrameTruth:
    """Everything that is true at one instant.

    Attributes:
        time_ns: since the start.
        ego_speed_mps: own speed.
        pitch_deviation_rad: of the camera from its calibration.
        bounce_m: of the camera from its calibrated height.
        horizon_row_px: where the plane of the road below us has its horizon now.
        vehicles: those ahead whose near face the camera could see, nearest first.
    """

    time_ns: int
    ego_speed_mps: float
    pitch_deviation_rad: float
    bounce_m: float
    horizon_row_px: float
    vehicles: tuple[VehicleTruth, ...]

    @property
    def lead(self) -> VehicleTruth | None:
        """The nearest vehicle in our path, or None."""
        return next((vehicle for vehicle in self.vehicles if vehicle.in_path), None)


def frame_truth(
    state: WorldState, camera: GroundPlaneCamera, image_size: ImageSize, reference_offset_m: float
) -> FrameTruth:
    """The truth of one instant.

    Args:
        state: of the world.
        camera: as calibrated.
        image_size: of the picture.
        reference_offset_m: from the camera forward to the front bumper.
    """
    ego = state.ego
    now = dynamic_camera(camera, ego.pitch_deviation_rad, ego.bounce_m)
    outlines: list[FloatArray] = []
    vehicles: list[VehicleTruth] = []
    for vehicle in sorted(state.vehicles, key=lambda vehicle: vehicle.s_m):
        distance_m = vehicle.s_m + _from_foot(vehicle)[0] - ego.s_m - reference_offset_m
        seen = _seen(state, vehicle, now)
        if seen is None:
            continue
        face, foot_row_px, outline = seen
        if distance_m > 0:
            visible = _visible_fraction(face, image_size, outlines)
            box, body_box = _box(face, foot_row_px), _box(outline)
            vehicles.append(_vehicle_truth(state, vehicle, distance_m, box, body_box, visible))
        outlines.append(outline)
    return FrameTruth(
        state.time_ns,
        ego.speed_mps,
        ego.pitch_deviation_rad,
        ego.bounce_m,
        now.horizon_row_px,
        tuple(vehicles),
    )


def _vehicle_truth(
    state: WorldState,
    vehicle: VehicleState,
    distance_m: float,
    box: Box,
    body_box: Box,
    visible_fraction: float,
) -> VehicleTruth:
    ego = state.ego
    closing_mps = ego.speed_mps - vehicle.speed_mps
    path_lateral_m = vehicle.lateral_m + _from_foot(vehicle)[1] - ego.lateral_m
    middle = state.vehicle_points(vehicle, np.array((*_near_face(vehicle).edges.mean(axis=0), 0.0)))
    return VehicleTruth(
        name=vehicle.name,
        distance_m=distance_m,
        lateral_m=float(middle[1]),
        path_lateral_m=path_lateral_m,
        closing_speed_mps=closing_mps,
        ttc_s=distance_m / closing_mps if closing_mps > 0 else None,
        box=box,
        body_box=body_box,
        visible_fraction=visible_fraction,
        oncoming=vehicle.oncoming,
        in_path=not vehicle.oncoming and abs(path_lateral_m) <= IN_PATH_M,
    )


class _Face(NamedTuple):
    """Feet of a face, (2, 2) metres along the body and to its left, from our left to our right.

    Attributes:
        edges: of the body.
        tyres: where those behind it meet the road.
    """

    edges: FloatArray
    tyres: FloatArray


def _near_face(vehicle: VehicleState) -> _Face:
    size, half_m = vehicle.size, vehicle.size.width_m / 2
    if not vehicle.stands_across:
        edges = np.array(((0.0, half_m), (0.0, -half_m)))
        return _Face(edges, edges + np.array((size.overhang_m, 0.0)))
    # Who faces to our left shows the left side, with the front at the left.
    to_left = math.sin(vehicle.heading_rad) > 0
    side_m = half_m if to_left else -half_m
    edges = np.array(((size.length_m, side_m), (0.0, side_m)))
    tyres = edges + np.array(((-size.overhang_m, 0.0), (size.overhang_m, 0.0)))
    return _Face(edges, tyres) if to_left else _Face(edges[::-1], tyres[::-1])


def _from_foot(vehicle: VehicleState) -> tuple[float, float]:
    """Where the middle of that face is from where the vehicle is placed: along the road, and to the left."""
    along_m, left_m = (float(metres) for metres in _near_face(vehicle).edges.mean(axis=0))
    cosine, sine = math.cos(vehicle.heading_rad), math.sin(vehicle.heading_rad)
    return along_m * cosine - left_m * sine, along_m * sine + left_m * cosine


def _seen(
    state: WorldState, vehicle: VehicleState, now: GroundPlaneCamera
) -> tuple[FloatArray, float, FloatArray] | None:
    """What is seen of a vehicle; None when it is not ahead.

    Returns:
        Pixels of the near face's corners (4, 2), from the bumper to the roof and back; the row where the
        tyres below it meet the road; and pixels of the body's outline (N, 2).
    """
    size, face = vehicle.size, _near_face(vehicle)
    (left, right), clearance_m, top_m = face.edges, size.clearance_m, size.height_m
    corners = np.array(((*left, clearance_m), (*left, top_m), (*right, top_m), (*right, clearance_m)))
    tyres = np.column_stack((face.tyres, (0.0, 0.0)))
    near, far = ((0.0, clearance_m), (0.0, top_m)), ((size.length_m, top_m), (size.length_m, 0.0))
    half_m = size.width_m / 2
    body = [(x, y, z) for x, z in (*near, *far, (size.overhang_m, 0.0)) for y in (half_m, -half_m)]
    points = state.vehicle_points(vehicle, np.concatenate((corners, tyres, body)))
    if points[..., 0].min() < NEAREST_DEPTH_M:
        return None
    pixels = np.stack(project(points, now), axis=-1)
    hull = cv2.convexHull(pixels.astype(np.float32))[:, 0]
    return pixels[:4], float(pixels[4:6, 1].max()), np.asarray(hull, np.float64)


def _box(pixels: FloatArray, foot_row_px: float = -math.inf) -> Box:
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    return Box(float(left), float(top), float(right - left), max(float(bottom), foot_row_px) - float(top))


def _visible_fraction(face: FloatArray, image_size: ImageSize, outlines: list[FloatArray]) -> float:
    """Part of a face that is in the picture and outside every outline; none where it is seen from inside."""
    bottom_left, top_left, top_right, bottom_right = face
    if bottom_right[0] <= bottom_left[0]:
        return 0.0
    u, v = np.meshgrid(*[(np.arange(VISIBILITY_SAMPLES) + 0.5) / VISIBILITY_SAMPLES] * 2)
    u, v = u[..., None], v[..., None]
    points = (1 - v) * ((1 - u) * top_left + u * top_right) + v * ((1 - u) * bottom_left + u * bottom_right)
    points = points.reshape(-1, 2)
    inside = ((points >= -0.5) & (points <= (image_size.width - 0.5, image_size.height - 0.5))).all(axis=1)
    for outline in outlines:
        inside &= ~_inside_convex(points, outline)
    return float(inside.mean())


def _inside_convex(points: FloatArray, outline: FloatArray) -> NDArray[np.bool_]:
    """Which points (N, 2) lie inside a convex outline, in whichever sense it runs."""
    edges = np.roll(outline, -1, axis=0) - outline
    offsets = points[:, None] - outline
    sides = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0]
    return np.asarray((sides >= 0).all(axis=1) | (sides <= 0).all(axis=1))


def warning_is_due(vehicle: VehicleTruth) -> bool:
    """Whether a driver of 1.2 s and 0.4 g must be warned by now of a vehicle in the path."""
    closing_mps = vehicle.closing_speed_mps
    return closing_mps > 0 and vehicle.distance_m <= EXPECTED_DRIVER.needed_distance_m(closing_mps)
