"""What stands beside and over the road, in the picture."""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.simulation.picture.canvas import FloatImage
from fcw.simulation.picture.light import Daylight
from fcw.simulation.picture.quads import Texture
from fcw.simulation.picture.road.textures import (
    RAIL_PANEL_M,
    concrete_texture,
    post_texture,
    rail_texture,
    shadow_of_tree,
    sign_texture,
    soft_shadow,
    tree_texture,
    wall_texture,
)
from fcw.simulation.picture.view import View
from fcw.simulation.world.state import RoadsideItem, RoadsideKind, VehicleState, WorldState

Job = tuple[float, Callable[[], None]]
"""Something to paint and its distance along the road: the farthest is painted first."""

FARTHEST_M = {
    RoadsideKind.TREE: 600.0,
    RoadsideKind.BUSH: 350.0,
    RoadsideKind.POST: 200.0,
    RoadsideKind.SIGN: 350.0,
    RoadsideKind.BARRIER: 500.0,
    RoadsideKind.BRIDGE: 900.0,
}
TREE_KINDS, BUSH_KINDS = 7, 4
SHADOW_REACH = 0.75
"""Shadows of trees fall this many heights away for each unit of the light's direction."""
SHADOWS_WITHIN_M = 160.0
SLOPE_M = 16.0
"""Width of the grassy slope on either side of a bridge."""
ORDER_STEP_M = 0.01
LONG_PANELS_BEYOND_M, PANELS_IN_LONG = 84.0, 4


class RoadsidePainter:
    """Paints what never moves; keeps its textures.

    Args:
        generator: of the textures.
        light: of the drive.
        seed: tells steel rails from concrete walls.
    """

    def __init__(self, generator: np.random.Generator, light: Daylight, seed: int) -> None:
        self._light, self._seed = light, seed
        self._trees = [Texture(tree_texture(generator, light.foliage)) for _ in range(TREE_KINDS)]
        self._bushes = [Texture(tree_texture(generator, light.foliage, True)) for _ in range(BUSH_KINDS)]
        self._post = Texture(post_texture())
        self._tree_shadow = Texture(_faded(shadow_of_tree(generator), light.shadow))
        self._bush_shadow = Texture(_faded(soft_shadow(48, 48, 12, 1.0), light.shadow))
        self._bridge_shadow = Texture(soft_shadow(64, 64, 3, 0.25 + 0.6 * light.shadow))
        self._kept: dict[object, Texture] = {}

    def visible(self, state: WorldState) -> list[RoadsideItem]:
        """What may be seen."""
        s_m = state.ego.s_m
        return [
            item
            for item in state.roadside
            if item.s_m < s_m + FARTHEST_M[item.kind] and item.s_m + item.length_m > s_m + 0.5
        ]

    def shaded_by_bridge(self, items: list[RoadsideItem], s_m: float) -> bool:
        """Whether a place of the road lies under a bridge."""
        return any(
            item.kind is RoadsideKind.BRIDGE and 0 <= s_m - item.s_m <= item.length_m for item in items
        )

    def paint_shadows(self, view: View, items: list[RoadsideItem]) -> None:
        """Shadows on the ground."""
        light, s_m = self._light, view.state.ego.s_m
        for item in items:
            if item.kind is RoadsideKind.BRIDGE:
                # A soft edge of a metre, and the light from the sky reaches in from both sides.
                ends = item.s_m - 0.5, item.s_m + item.length_m + 0.5
                self._on_ground(view, self._bridge_shadow, ends, item.lateral_m, item.width_m)
            elif item.kind in (RoadsideKind.TREE, RoadsideKind.BUSH) and item.s_m - s_m < SHADOWS_WITHIN_M:
                reach_m = SHADOW_REACH * item.height_m
                middle_m = item.s_m + light.shadow_along * reach_m
                half_m = item.width_m * 0.75
                texture = self._tree_shadow if item.kind is RoadsideKind.TREE else self._bush_shadow
                lateral_m = item.lateral_m + light.shadow_lateral * reach_m
                self._on_ground(
                    view, texture, (middle_m - half_m, middle_m + half_m), lateral_m, 1.6 * item.width_m
                )

    def jobs(self, view: View, items: list[RoadsideItem], vehicles: Sequence[VehicleState]) -> Iterator[Job]:
        """Everything upright; vehicles are what barriers may run beside."""
        ego_s_m = view.state.ego.s_m
        standing = [item for item in items if item.kind not in (RoadsideKind.BARRIER, RoadsideKind.BRIDGE)]
        feet = view.state.road_points(
            np.array([item.s_m for item in standing]), np.array([item.lateral_m for item in standing])
        ).reshape(-1, 3)
        for item, foot in zip(standing, feet, strict=True):
            # Roots a little in the ground: the verge is rougher than the picture.
            yield item.s_m - ego_s_m, self._upright_job(view, item, foot)
        for item in items:
            if item.kind is RoadsideKind.BARRIER:
                yield from self._barrier_jobs(view, item, vehicles)
            elif item.kind is RoadsideKind.BRIDGE:
                yield from self._bridge_jobs(view, item)

    def _upright_job(self, view: View, item: RoadsideItem, foot: FloatArray) -> Callable[[], None]:
        texture = self._standing_texture(item)
        return lambda: view.upright(texture, foot, item.width_m, item.height_m, view.lowest_row(item.s_m))

    def _standing_texture(self, item: RoadsideItem) -> Texture:
        if item.kind is RoadsideKind.TREE:
            return self._trees[item.seed % TREE_KINDS]
        if item.kind is RoadsideKind.BUSH:
            return self._bushes[item.seed % BUSH_KINDS]
        if item.kind is RoadsideKind.POST:
            return self._post
        if item not in self._kept:
            generator = np.random.default_rng(item.seed)
            self._kept[item] = Texture(sign_texture(item.width_m, item.height_m, item.clearance_m, generator))
        return self._kept[item]

    def _barrier_jobs(
        self, view: View, item: RoadsideItem, vehicles: Sequence[VehicleState]
    ) -> Iterator[Job]:
        ego_s_m = view.state.ego.s_m
        end_m = min(item.s_m + item.length_m, ego_s_m + FARTHEST_M[RoadsideKind.BARRIER])
        first = max(math.floor((ego_s_m - item.s_m) / RAIL_PANEL_M), 0)
        starts: list[float] = []
        start_m = item.s_m + first * RAIL_PANEL_M
        while start_m < end_m:
            starts.append(start_m)
            far = start_m - ego_s_m > LONG_PANELS_BEYOND_M
            start_m += RAIL_PANEL_M * (PANELS_IN_LONG if far else 1)
        ends = np.array([*starts[1:], min(start_m, item.s_m + item.length_m)])
        texture = self._barrier_texture(item)
        s_m = np.stack((starts, ends, ends, starts), axis=1)
        heights_m = np.array((item.height_m, item.height_m, 0.0, 0.0))
        corners = view.state.road_points(s_m, item.lateral_m, heights_m[None, :])
        for quad, start_m, panel_end_m in zip(corners, starts, ends, strict=True):
            lowest = view.lowest_row(start_m)
            yield (
                _panel_order(start_m, float(panel_end_m), item.lateral_m, view.state, vehicles) - ego_s_m,
                lambda quad=quad, lowest=lowest: view.quad(texture, quad, lowest_row_px=lowest),
            )

    def _barrier_texture(self, item: RoadsideItem) -> Texture:
        if item not in self._kept:
            generator = np.random.default_rng([self._seed, item.seed, int(item.lateral_m > 0)])
            wall = generator.uniform() < 0.4
            image = wall_texture(item.height_m, generator) if wall else rail_texture(item.height_m)
            self._kept[item] = Texture(image)
        return self._kept[item]

    def _bridge_jobs(self, view: View, item: RoadsideItem) -> Iterator[Job]:
        near_m, far_m = item.s_m, item.s_m + item.length_m
        left_m, right_m = item.lateral_m + item.width_m / 2, item.lateral_m - item.width_m / 2
        low_m, high_m = item.clearance_m, item.height_m
        distance_m = near_m - view.state.ego.s_m
        face, under, wall, slope = self._bridge_textures(item)

        def quad(texture: Texture, corners: tuple[tuple[float, float, float], ...]) -> Callable[[], None]:
            s_m, lateral_m, height_m = np.array(corners).T
            points = view.state.road_points(s_m, lateral_m, height_m)
            return lambda: view.quad(texture, points, lowest_row_px=view.lowest_row(near_m))

        ceiling = (
            (far_m, left_m, low_m),
            (near_m, left_m, low_m),
            (near_m, right_m, low_m),
            (far_m, right_m, low_m),
        )
        yield distance_m + item.length_m, quad(under, ceiling)
        for side_m, out in ((left_m, SLOPE_M), (right_m, -SLOPE_M)):
            inner = (
                (near_m, side_m, low_m),
                (far_m, side_m, low_m),
                (far_m, side_m, 0.0),
                (near_m, side_m, 0.0),
            )
            yield distance_m + item.length_m - 0.01, quad(wall, inner)
            bank = ((near_m, side_m, high_m), (near_m, side_m + out, high_m), (near_m, side_m + out, 0.0))
            yield distance_m + 0.01, quad(slope, (*bank, (near_m, side_m, 0.0)))
        front = (
            (near_m, left_m, high_m),
            (near_m, right_m, high_m),
            (near_m, right_m, low_m),
            (near_m, left_m, low_m),
        )
        yield distance_m, quad(face, front)

    def _bridge_textures(self, item: RoadsideItem) -> tuple[Texture, Texture, Texture, Texture]:
        key = (item, "face")
        if key not in self._kept:
            generator = np.random.default_rng(item.seed)
            thick_m = item.height_m - item.clearance_m
            face = concrete_texture(generator, item.width_m, thick_m, 1.0)
            under = concrete_texture(generator, item.length_m, item.width_m, 0.3)
            wall = concrete_texture(generator, item.length_m, item.clearance_m, 0.5)
            bank = np.zeros((64, 128, 4), np.float32)
            # Grass that falls from the deck to the ground.
            rise = np.linspace(0, 1, 64)[:, None] >= np.linspace(0, 1, 128)[None, :] ** 1.2
            bank[rise] = (*self._light.grass, 1.0)
            bank[..., :3] *= 1 + 0.12 * generator.standard_normal((64, 128, 1)).astype(np.float32)
            for name, image in (("face", face), ("under", under), ("wall", wall), ("slope", bank)):
                self._kept[(item, name)] = Texture(image)
        face, under, wall, slope = (self._kept[(item, name)] for name in ("face", "under", "wall", "slope"))
        return face, under, wall, slope

    def _on_ground(
        self, view: View, texture: Texture, ends_m: tuple[float, float], lateral_m: float, width_m: float
    ) -> None:
        s_m = np.array((ends_m[0], ends_m[1], ends_m[1], ends_m[0]))
        half_m = np.array((1, 1, -1, -1)) * width_m / 2
        corners = view.state.road_points(s_m, lateral_m + half_m)
        view.quad(texture, corners, lowest_row_px=view.lowest_row(ends_m[0]))


def _panel_order(
    start_m: float, end_m: float, lateral_m: float, state: WorldState, vehicles: Sequence[VehicleState]
) -> float:
    """Where a panel comes in the order: before the vehicles it is hidden by, after those that it hides."""
    ego = state.ego
    order_m = max(start_m, ego.s_m)
    across_m = lateral_m - ego.lateral_m
    for vehicle in vehicles:
        beside_m = vehicle.lateral_m - ego.lateral_m
        overlaps = vehicle.s_m < end_m and vehicle.s_m + vehicle.size.length_m > start_m
        if not overlaps:
            continue
        nearer = abs(beside_m) < abs(across_m) or beside_m * across_m < 0
        if nearer:
            order_m = max(order_m, vehicle.s_m + ORDER_STEP_M)
        else:
            order_m = min(order_m, vehicle.s_m - ORDER_STEP_M)
    return order_m


def _faded(texture: FloatImage, part: float) -> FloatImage:
    return np.asarray(texture * np.float32(part), np.float32)
