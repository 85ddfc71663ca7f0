"""Vehicles in the picture: a box with a painted rear and front, two sides, and its shadows on the road."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.simulation.picture.canvas import mixed
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.quads import Texture
from fcw.simulation.picture.road.textures import soft_shadow
from fcw.simulation.picture.vehicles.parts import GREENHOUSES
from fcw.simulation.picture.vehicles.rears import rear_texture
from fcw.simulation.picture.vehicles.sides import front_texture, side_texture
from fcw.simulation.picture.view import View
from fcw.simulation.world.state import VEHICLE_SIZES, VehicleKind, VehicleState

FARTHEST_M = 400.0
CONTACT_MARGIN_M = 1.4
"""The picture of the contact shadow is larger than the body by so much. Below the bumper's edge half of the
sky is hidden, and half a metre farther in nine tenths."""
SHADOW_REACH = 0.5
"""The body's shadow reaches as far as that of a thing of half its height: it is not a sharp wall."""
SEAM_M = 0.15
"""The panes' plane reaches so far behind the near face, so that nothing shines through where they meet."""
LAP_M = 0.03
"""What stands below a bumper reaches so far above its lower edge."""
LEDGE = 0.01
"""Part of the side's texture below the waist that is shown on the ledge beside the panes."""
SKY_ON_PAINT, GLOSS = (140.0, 124.0, 108.0), 0.32
"""Clear coat mirrors the sky: what a camera sees of a paint is bluer and less saturated than its pigment."""
SIDE_CONTRAST = 0.22
"""How much brighter the side towards the sun is than the other one."""


class _End(NamedTuple):
    """The front or the rear, and how far it is from the near face."""

    at_m: float
    is_front: bool


class VehiclePainter:
    """Paints vehicles; keeps the textures of those it has met.

    Args:
        light: of the drive.
    """

    def __init__(self, light: Daylight) -> None:
        self._textures: dict[tuple[VehicleKind, tuple[int, int, int], int, str], Texture] = {}
        self._rear_light = light.rear_light
        self._contact = Texture(soft_shadow(96, 48, 12, 0.94))
        self._shade = Texture(soft_shadow(96, 48, 8, light.shadow))

    def paint_shadows(self, view: View, vehicle: VehicleState) -> None:
        """The dark under the body, and the shadow it casts in the sun."""
        size, light = vehicle.size, view.light
        reach_m = SHADOW_REACH * size.height_m
        shift = np.array((light.shadow_along * reach_m, light.shadow_lateral * reach_m, 0.0))
        margin_m = CONTACT_MARGIN_M / 2
        foot = np.array(
            (
                (-margin_m, size.width_m / 2 + margin_m, 0.0),
                (size.length_m + margin_m, size.width_m / 2 + margin_m, 0.0),
                (size.length_m + margin_m, -size.width_m / 2 - margin_m, 0.0),
                (-margin_m, -size.width_m / 2 - margin_m, 0.0),
            )
        )
        lowest = view.lowest_row(vehicle.s_m)
        cast = view.state.vehicle_points(vehicle, foot + shift)
        view.quad(self._shade, cast, lowest_row_px=lowest)
        view.quad(self._contact, view.state.vehicle_points(vehicle, foot), lowest_row_px=lowest)

    def paint(self, view: View, vehicle: VehicleState, shaded: bool) -> None:
        """The body; shaded: it stands under a bridge."""
        size, house = vehicle.size, GREENHOUSES[vehicle.kind]
        side_seen = self._texture(vehicle, "side")
        half_m, length_m, top_m = size.width_m / 2, size.length_m, size.height_m
        waist = 1 - house.waist_m / VEHICLE_SIZES[vehicle.kind].height_m
        waist_m = (1 - waist) * top_m
        dim = 1 - 0.5 * view.light.shadow if shaded else 1.0
        lowest = view.lowest_row(vehicle.s_m)
        near, far = _End(0.0, vehicle.oncoming), _End(length_m, not vehicle.oncoming)
        ends = [
            end
            for end, other in ((near, far), (far, near))
            if _faces_camera(view, vehicle, (end.at_m, 0.0, 0.0), (other.at_m, 0.0, 0.0))
        ]
        # What stands below a bumper stands as far inside as the axle, and is painted before the bumper. Of a
        # vehicle that stands across, its side hides that.
        below = (size.overhang_m, 0.0), (size.overhang_m, size.clearance_m + LAP_M)
        if vehicle.stands_across:
            for end in ends:
                self._paint_across(view, vehicle, end, *below, dim)
        for side in (-1, 1):
            if not _faces_camera(view, vehicle, (0.0, side * half_m, 0.0), (0.0, 0.0, 0.0)):
                continue
            sunny = -side * view.light.shadow_lateral
            lit = dim * (1 + SIDE_CONTRAST * sunny * view.light.shadow)
            shoulder_m, roof_m = house.foot * half_m, house.roof * half_m
            for (low_m, low_half_m), (high_m, high_half_m), part, seam_m in (
                ((0.0, half_m), (waist_m, half_m), (waist, 1.0), 0.0),
                ((waist_m, half_m), (waist_m, shoulder_m), (waist, waist + LEDGE), SEAM_M),
                ((waist_m, shoulder_m), (top_m, roof_m), (0.0, waist), SEAM_M),
            ):
                rear_m, front_m = (length_m, -seam_m) if vehicle.oncoming else (-seam_m, length_m)
                corners = _body_points(
                    view,
                    vehicle,
                    (
                        (rear_m, side * high_half_m, high_m),
                        (front_m, side * high_half_m, high_m),
                        (front_m, side * low_half_m, low_m),
                        (rear_m, side * low_half_m, low_m),
                    ),
                )
                view.quad(side_seen, corners, lit, part, lowest)
        for end in ends:
            if not vehicle.stands_across:
                self._paint_across(view, vehicle, end, *below, dim)
            profile = _front_profile(vehicle) if end.is_front else ((0.0, size.clearance_m), (0.0, top_m))
            for low, high in reversed(list(pairwise(profile))):
                self._paint_across(view, vehicle, end, low, high, dim)

    def _paint_across(
        self,
        view: View,
        vehicle: VehicleState,
        end: _End,
        low: tuple[float, float],
        high: tuple[float, float],
        dim: float,
    ) -> None:
        """A part of front or rear between two edges: metres from that end, and up."""
        inwards, top_m = 1.0 if end.at_m == 0 else -1.0, vehicle.size.height_m
        left_m = inwards * vehicle.size.width_m / 2
        lamps_lit = vehicle.brake_lamps and not end.is_front
        (low_x_m, low_m), (high_x_m, high_m) = low, high
        corners = _body_points(
            view,
            vehicle,
            (
                (end.at_m + inwards * high_x_m, left_m, high_m),
                (end.at_m + inwards * high_x_m, -left_m, high_m),
                (end.at_m + inwards * low_x_m, -left_m, low_m),
                (end.at_m + inwards * low_x_m, left_m, low_m),
            ),
        )
        shown = self._texture(vehicle, "front" if end.is_front else "braking" if lamps_lit else "rear")
        part = (1 - high_m / top_m, 1 - low_m / top_m)
        view.quad(shown, corners, dim * view.light.rear_light, part, view.lowest_row(vehicle.s_m))

    def _texture(self, vehicle: VehicleState, what: str) -> Texture:
        """Of a vehicle's "side", "front", "rear", or rear with "braking" lamps."""
        key = (vehicle.kind, vehicle.color, vehicle.seed, what)
        if key not in self._textures:
            kind, seed = vehicle.kind, vehicle.seed
            color = mixed(vehicle.color, SKY_ON_PAINT, GLOSS)
            if what == "side":
                pixels = side_texture(kind, color)
            elif what == "front":
                pixels = front_texture(kind, color, seed)
            else:
                pixels = rear_texture(kind, color, seed, what == "braking")
            if what == "braking":
                # Lamps shine by themselves: they do not dim where the rear is in the shade.
                own = np.abs(pixels[..., 2:3] - rear_texture(kind, color, seed, False)[..., 2:3]) > 1
                pixels[..., :3] = np.where(own, pixels[..., :3] / self._rear_light, pixels[..., :3])
            self._textures[key] = Texture(pixels)
        return self._textures[key]


def _faces_camera(
    view: View,
    vehicle: VehicleState,
    outside_m: tuple[float, float, float],
    inside_m: tuple[float, float, float],
) -> bool:
    """Whether a face shows its outside: one of its feet, and what lies straight behind that in the body."""
    foot, inside = _body_points(view, vehicle, (outside_m, inside_m))
    return float((foot - inside) @ (np.array((0.0, 0.0, foot[2])) - foot)) > 0


def _front_profile(vehicle: VehicleState) -> tuple[tuple[float, float], ...]:
    """Where an oncoming vehicle's front, bonnet and windscreen meet: metres from the front, and up."""
    nominal, house, size = VEHICLE_SIZES[vehicle.kind], GREENHOUSES[vehicle.kind], vehicle.size
    sill = (0.0, size.clearance_m)
    if vehicle.kind is VehicleKind.TRUCK:
        return sill, (0.0, size.height_m)
    nose_m, waist_m = (
        drawn_m * size.height_m / nominal.height_m for drawn_m in (house.nose_m, house.waist_m)
    )
    foot_m = size.length_m * (1 - house.length_m / nominal.length_m)
    roof_m = foot_m + house.lean * (size.height_m - waist_m)
    return sill, (0.0, nose_m), (foot_m, waist_m), (roof_m, size.height_m)


def _body_points(
    view: View, vehicle: VehicleState, points_m: Sequence[tuple[float, float, float]]
) -> FloatArray:
    return view.state.vehicle_points(vehicle, np.array(points_m, np.float64))
