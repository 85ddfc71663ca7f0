"""Pictures of a flat textured road with hills beside it, seen by a camera that moves over it; exact geometry.

Written apart from the program's renderer and from its equations of motion: every pixel's ray is cut with the
road's plane, or with walls to both sides, and looks up a texture there.
"""

import functools
import math
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from fcw.camera.ground_plane import GroundPlaneCamera

WIDTH, HEIGHT = 640, 360
FOCAL_PX = 500.0
CELL_M = 0.05
WALL_M = 12.0


def camera(pitch_deg=2.0, height_m=1.3):
    return GroundPlaneCamera(math.radians(pitch_deg), FOCAL_PX, (HEIGHT - 1) / 2, height_m, (WIDTH - 1) / 2)


@dataclass
class Pose:
    """Of the camera: place on the road (x forward, y left) and heading, rad to the left."""

    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0


class Road:
    """A textured road between two textured walls; `lines_m` are painted along x at these lateral places."""

    def __init__(self, seed=0, lines_m=()):
        self._road, self._wall = _textures(seed)
        self._lines_m = lines_m

    def picture(self, pose, pitch_deg=2.0, height_m=1.3, yaw_deg=0.0, roll_deg=0.0, lane_of=None):
        """(HEIGHT, WIDTH, 3) BGR; `lane_of` gives the lateral place of the road's middle at distances x."""
        ahead, right, down = _rays(pitch_deg, roll_deg)
        turn = pose.heading_rad + math.radians(yaw_deg)
        x = ahead * math.cos(turn) + right * math.sin(turn)
        y = ahead * math.sin(turn) - right * math.cos(turn)
        with np.errstate(divide="ignore", invalid="ignore"):
            to_road = np.where(down > 1e-6, height_m / down, np.inf)
            to_wall = np.abs((np.sign(y) * WALL_M - pose.y_m) / y)
        on_road = to_road < to_wall
        reach = np.minimum(np.minimum(to_road, to_wall), 400.0)
        at_x, at_y, at_z = pose.x_m + reach * x, pose.y_m + reach * y, height_m - reach * down
        road, wall = _looked_up(self._road, at_x, at_y), _looked_up(self._wall, at_z * 0.5, at_x * 0.5)
        grey = np.where(on_road, road, wall)
        for line_m in self._lines_m:
            off_m = at_y - line_m - (0.0 if lane_of is None else lane_of(at_x))
            grey[on_road & (np.abs(off_m) < 0.08)] = 235.0
        grey = cv2.GaussianBlur(grey, (0, 0), 0.6)
        return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


@functools.lru_cache(maxsize=4)
def _rays(pitch_deg, roll_deg):
    """Of each pixel of a camera above the origin: forward, to the right and down."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    right, down = (u - (WIDTH - 1) / 2) / FOCAL_PX, (v - (HEIGHT - 1) / 2) / FOCAL_PX
    roll, pitch = math.radians(roll_deg), math.radians(pitch_deg)
    # The camera is rolled to the right: its rows' right ends look farther down.
    right, down = (
        right * math.cos(roll) - down * math.sin(roll),
        right * math.sin(roll) + down * math.cos(roll),
    )
    return math.cos(pitch) - down * math.sin(pitch), right, down * math.cos(pitch) + math.sin(pitch)


@functools.cache
def _textures(seed):
    """Of road and walls."""
    rng = np.random.default_rng(seed)
    return 110 + 90 * _texture(rng, (1200, 1200)), 130 + 300 * _texture(rng, (400, 2000), 4.0)


def _texture(rng, shape, smooth=2.0):
    fine = gaussian_filter(rng.standard_normal(shape), smooth, mode="wrap")
    coarse = gaussian_filter(rng.standard_normal(shape), 4 * smooth, mode="wrap")
    return (fine + 2 * coarse).astype(np.float32)


def _looked_up(texture, along_m, across_m):
    """Bilinear; the texture repeats."""
    rows, columns = texture.shape
    row, column = _remainder(along_m / CELL_M, rows), _remainder(across_m / CELL_M, columns)
    return cv2.remap(texture, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)


def _remainder(values, divisor):
    """As NumPy's `%`, which takes ten times as long."""
    return (values - divisor * np.floor(values / divisor)).astype(np.float32)
