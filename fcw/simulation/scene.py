"""Painting a straight road with vehicles, seen by a ground-plane camera: numpy and OpenCV, nothing else."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.simulation.ground import HAZE, HAZE_M, Ground
from fcw.simulation.textures import (
    SHOULDER_WIDTH,
    Body,
    FloatImage,
    body_side_texture,
    cabin_side_texture,
    post_texture,
    rear_texture,
    shadow_texture,
    tree_texture,
)
from fcw.sources.frame import ImageSize

ROADSIDE_PERIOD_M = 480.0
TREE_COUNT, TREE_KINDS = 110, 5
TREE_ASPECT = 0.8
POST_SPACING_M, POST_LATERAL_M = 40.0, 8.6
FARTHEST_M = 240.0
NEAREST_M = 1.5
"""What is nearer than this along the ground is cut off: it lies below or beside the picture."""
SHADOW_MARGIN_M = 0.25


@dataclass(frozen=True, slots=True)
class PlacedVehicle:
    """A vehicle at one moment.

    Attributes:
        body: shape and colour.
        distance_m: of its rear from the camera, along the ground; negative when it is beside or behind.
        lateral_m: of its middle, positive to the left.
        braking: whether its brake lamps are lit.
    """

    body: Body
    distance_m: float
    lateral_m: float
    braking: bool


@dataclass(frozen=True, slots=True, eq=False)
class _VehicleTextures:
    rear: list[FloatImage]
    braking: list[FloatImage]
    body_side: list[FloatImage]
    cabin_side: list[FloatImage]


@dataclass(frozen=True, slots=True)
class _Tree:
    position_m: float
    lateral_m: float
    height_m: float
    kind: int


class Scene:
    """A three-lane road through flat country, the camera above the middle lane.

    Args:
        camera: the true camera.
        image_size: of the pictures.
        seed: of surfaces and roadside.
    """

    def __init__(self, camera: GroundPlaneCamera, image_size: ImageSize, seed: int) -> None:
        generator = np.random.default_rng(seed)
        self._camera, self._size = camera, image_size
        self._backdrop = self._paint_backdrop(generator)
        self._ground = Ground(camera, image_size, generator)
        self._trees = [
            _Tree(
                float(generator.uniform(0, ROADSIDE_PERIOD_M)),
                float(generator.choice((-1, 1)) * generator.uniform(14, 38)),
                float(generator.uniform(3, 8)),
                int(generator.integers(TREE_KINDS)),
            )
            for _ in range(TREE_COUNT)
        ]
        self._tree_pyramids = [_pyramid(tree_texture(generator)) for _ in range(TREE_KINDS)]
        self._post_pyramid = _pyramid(post_texture())
        self._shadow_pyramid = _pyramid(shadow_texture())
        self._textures: dict[Body, _VehicleTextures] = {}

    def paint(self, travelled_m: float, vehicles: tuple[PlacedVehicle, ...]) -> NDArray[np.uint8]:
        """The picture after a distance travelled: (height, width, 3) BGR."""
        image = self._backdrop.copy()
        self._ground.paint(image, travelled_m)
        jobs: list[tuple[float, Callable[[], None]]] = []
        for tree in self._trees:
            distance_m = (tree.position_m - travelled_m) % ROADSIDE_PERIOD_M
            width_m, pyramid = tree.height_m * TREE_ASPECT, self._tree_pyramids[tree.kind]
            jobs.append(self._upright(image, pyramid, distance_m, tree.lateral_m, width_m, tree.height_m))
        for index in range(int(FARTHEST_M / POST_SPACING_M)):
            distance_m = (index * POST_SPACING_M - travelled_m) % FARTHEST_M
            for lateral_m in (POST_LATERAL_M, -POST_LATERAL_M):
                jobs.append(self._upright(image, self._post_pyramid, distance_m, lateral_m, 0.12, 1.0))
        for vehicle in vehicles:
            jobs.append((vehicle.distance_m, lambda v=vehicle: self._paint_vehicle(image, v)))
        for distance_m, paint in sorted(jobs, key=lambda job: -job[0]):
            if distance_m < FARTHEST_M:
                paint()
        return np.clip(np.rint(image), 0, 255).astype(np.uint8)

    def _paint_backdrop(self, generator: np.random.Generator) -> FloatImage:
        """Sky that pales towards the horizon, clouds, and a far line of woods."""
        width, height = self._size.width, self._size.height
        horizon = self._camera.horizon_row_px
        image = np.empty((height, width, 3), np.float32)
        elevation = np.clip((horizon - np.arange(height)) / horizon, 0, 1)[:, None, None] ** 0.7
        image[:] = HAZE + (np.array((205.0, 165.0, 120.0), np.float32) - HAZE) * elevation.astype(np.float32)
        clouds = cv2.GaussianBlur(
            generator.standard_normal((height, width)).astype(np.float32), (0, 0), 60, sigmaY=14
        )
        clouds = np.clip(clouds / clouds.std() - 0.4, 0, 2)[..., None] * elevation.astype(np.float32)
        image += clouds * 22
        ridge = cv2.GaussianBlur(generator.standard_normal((1, width)).astype(np.float32), (0, 0), 9)[0]
        tops = horizon - 13 - 4 * ridge / ridge.std()
        rows = np.arange(height, dtype=np.float32)[:, None]
        cover = np.clip(rows - tops[None, :], 0, 1)[..., None] * 0.75
        return image * (1 - cover) + np.array((128.0, 132.0, 118.0), np.float32) * cover

    def _upright(
        self,
        image: FloatImage,
        pyramid: list[FloatImage],
        distance_m: float,
        lateral_m: float,
        width_m: float,
        height_m: float,
    ) -> tuple[float, Callable[[], None]]:
        """Something flat that faces the camera, as a job with its distance."""

        def paint() -> None:
            if distance_m > NEAREST_M:
                left, right = lateral_m + width_m / 2, lateral_m - width_m / 2
                corners = [(distance_m, left, height_m), (distance_m, right, height_m)]
                corners += [(distance_m, right, 0.0), (distance_m, left, 0.0)]
                self._paint_quad(image, pyramid, corners)

        return distance_m, paint

    def _paint_vehicle(self, image: FloatImage, vehicle: PlacedVehicle) -> None:
        body = vehicle.body
        rear_m, front_m = vehicle.distance_m, vehicle.distance_m + body.length_m
        if front_m <= NEAREST_M + SHADOW_MARGIN_M:
            return
        half_m, lateral_m = body.width_m / 2, vehicle.lateral_m
        near_m, far_m = max(rear_m - SHADOW_MARGIN_M, NEAREST_M), front_m + SHADOW_MARGIN_M
        reach_m = half_m + SHADOW_MARGIN_M
        shadow = [(far_m, lateral_m + reach_m, 0.0), (far_m, lateral_m - reach_m, 0.0)]
        shadow += [(near_m, lateral_m - reach_m, 0.0), (near_m, lateral_m + reach_m, 0.0)]
        self._paint_quad(image, self._shadow_pyramid, shadow)
        textures = self._vehicle_textures(body)
        if abs(lateral_m) > half_m:
            inward_m = -math.copysign(half_m, lateral_m)
            foot_m, roof_m = (lateral_m + inward_m * part for part in (SHOULDER_WIDTH, body.roof_width))
            self._paint_side(
                image,
                textures.body_side,
                rear_m,
                front_m,
                (lateral_m + inward_m, 0.0),
                (foot_m, body.waist_m),
            )
            cabin_m = rear_m + body.cabin_length_m
            self._paint_side(
                image, textures.cabin_side, rear_m, cabin_m, (foot_m, body.waist_m), (roof_m, body.height_m)
            )
        rear = textures.braking if vehicle.braking else textures.rear
        self._upright(image, rear, rear_m, lateral_m, body.width_m, body.height_m)[1]()

    def _paint_side(
        self,
        image: FloatImage,
        pyramid: list[FloatImage],
        rear_m: float,
        front_m: float,
        foot: tuple[float, float],
        top: tuple[float, float],
    ) -> None:
        """A strip along the vehicle between two heights, each edge given as lateral position and height."""
        seen_m = max(rear_m, NEAREST_M)
        if seen_m < front_m:
            corners = [(seen_m, *top), (front_m, *top), (front_m, *foot), (seen_m, *foot)]
            self._paint_quad(image, pyramid, corners, (seen_m - rear_m) / (front_m - rear_m))

    def _vehicle_textures(self, body: Body) -> "_VehicleTextures":
        if body not in self._textures:
            self._textures[body] = _VehicleTextures(
                _pyramid(rear_texture(body, braking=False)),
                _pyramid(rear_texture(body, braking=True)),
                _pyramid(body_side_texture(body)),
                _pyramid(cabin_side_texture(body)),
            )
        return self._textures[body]

    def _project(self, distance_m: float, lateral_m: float, height_m: float) -> tuple[float, float]:
        """Column and row of a point of the world."""
        camera = self._camera
        cosine, sine = math.cos(camera.pitch_rad), math.sin(camera.pitch_rad)
        below_m = camera.height_m - height_m
        depth_m = distance_m * cosine + below_m * sine
        return (
            camera.principal_column_px - camera.focal_y_px * lateral_m / depth_m,
            camera.principal_row_px + camera.focal_y_px * (below_m * cosine - distance_m * sine) / depth_m,
        )

    def _paint_quad(
        self,
        image: FloatImage,
        pyramid: list[FloatImage],
        corners_m: list[tuple[float, float, float]],
        cut_left: float = 0.0,
    ) -> None:
        """Paint a flat texture by the homography of its corners.

        Args:
            image: painted on.
            pyramid: the texture in halved sizes, colours multiplied by alpha.
            corners_m: distance, lateral and height of the top left corner, then clockwise.
            cut_left: part of the texture's width that is cut off at its left.
        """
        corners = np.array([self._project(*corner) for corner in corners_m], np.float32)
        low = np.floor(corners.min(axis=0)).astype(int)
        high = np.ceil(corners.max(axis=0)).astype(int) + 1
        left, top = max(low[0], 0), max(low[1], 0)
        right, bottom = min(high[0], self._size.width), min(high[1], self._size.height)
        if right <= left or bottom <= top:
            return
        wanted = max(float(np.ptp(corners[:, 1])), 1.0)
        texture = next((level for level in reversed(pyramid) if level.shape[0] >= wanted), pyramid[0])
        height, width = texture.shape[:2]
        x0, x1, y1 = cut_left * width - 0.5, width - 0.5, height - 0.5
        source = np.array([(x0, -0.5), (x1, -0.5), (x1, y1), (x0, y1)], np.float32)
        homography = cv2.getPerspectiveTransform(source, corners - np.array((left, top), np.float32))
        painted = cv2.warpPerspective(texture, homography, (int(right - left), int(bottom - top)))
        alpha = painted[..., 3:]
        clarity = math.exp(-max(corners_m[-1][0], 0.0) / HAZE_M)
        region = image[top:bottom, left:right]
        region *= 1 - alpha
        region += painted[..., :3] * clarity + HAZE * alpha * (1 - clarity)


def _pyramid(texture: FloatImage) -> list[FloatImage]:
    """The texture and its halves, down to a few pixels, each with a clear border that smooths its edges."""
    levels = [texture]
    while min(levels[-1].shape[:2]) >= 8:
        height, width = levels[-1].shape[:2]
        half = cv2.resize(texture, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
        levels.append(np.asarray(half, np.float32))
    return levels
