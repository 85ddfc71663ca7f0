"""Vehicles drawn on made pictures, and a camera that sees them on a road."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.channels.aggregated import compute_channels
from fcw.detection.model import VehicleStatistics, Window
from fcw.frame import ImageSize

WINDOW = Window()
ASPECT = 1.4
STATISTICS = VehicleStatistics(0.9, 2.1, 4.5, (5.0, 50.0), (ASPECT, ASPECT))
SIZE = ImageSize(641, 363)
CAMERA = GroundPlaneCamera(0.03, 560.0, 180.0, 1.3, 320.0)
CALIBRATION = Calibration.from_camera(CAMERA, SIZE)
MARGIN_PX = 16


def background(height: int, width: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Soft blobs of several sizes in muted colours."""
    picture = np.full((height, width, 3), 120.0)
    for cell, strength in ((4, 6), (16, 15), (64, 30)):
        coarse = rng.normal(0, strength, (height // cell + 2, width // cell + 2, 3))
        picture += cv2.resize(coarse, (width, height), interpolation=cv2.INTER_CUBIC)
    return np.clip(picture, 0, 255).astype(np.uint8)


def draw_vehicle(picture: NDArray[np.uint8], box: NDArray[np.float64]) -> None:
    """A dark rear with a bright window, red lights and a shadow, antialiased at any size."""
    x, y, w, h = box
    bits = 6

    def fill(left: float, top: float, width: float, height: float, colour: tuple[int, int, int]) -> None:
        corners = [(left, top), (left + width, top), (left + width, top + height), (left, top + height)]
        points = np.array([(x + w * u, y + h * v) for u, v in corners])
        fixed = np.rint(points * 2**bits).astype(np.int32)
        cv2.fillConvexPoly(picture, fixed, colour, cv2.LINE_AA, bits)

    fill(0.0, 0.35, 1.0, 0.55, (60, 50, 45))
    fill(0.15, 0.0, 0.7, 0.4, (70, 60, 55))
    fill(0.2, 0.06, 0.6, 0.28, (200, 190, 180))
    fill(0.02, 0.42, 0.16, 0.14, (30, 20, 200))
    fill(0.82, 0.42, 0.16, 0.14, (30, 20, 200))
    fill(0.35, 0.65, 0.3, 0.12, (220, 220, 220))
    fill(0.05, 0.88, 0.9, 0.12, (15, 15, 15))


def box_of(size_px: float, middle: float, bottom: float) -> NDArray[np.float64]:
    w, h = size_px * math.sqrt(ASPECT), size_px / math.sqrt(ASPECT)
    return np.array([middle - w / 2, bottom - h, w, h])


def example(rng: np.random.Generator, positive: bool) -> NDArray[np.uint8]:
    """Features of a window with a vehicle in its place, or without, or with one out of place."""
    side = WINDOW.size_px + 2 * MARGIN_PX
    picture = background(side, side, rng)
    size, middle, bottom = WINDOW.vehicle_size_px, side / 2 - 0.5, MARGIN_PX + WINDOW.vehicle_bottom_px - 0.5
    if positive:
        size *= math.exp(rng.uniform(-0.1, 0.1))
        middle, bottom = middle + rng.uniform(-2.5, 2.5), bottom + rng.uniform(-2.5, 2.5)
        draw_vehicle(picture, box_of(size, middle, bottom))
    elif rng.uniform() < 0.6:
        angle = rng.uniform(0, 2 * math.pi)
        away = rng.uniform(0.5, 1.0) * size
        factor = rng.choice([0.5, 0.7, 1.0, 1.4, 1.9])
        away *= factor in (0.5, 1.0) or (factor != 1.9 and rng.uniform() < 0.5)
        draw_vehicle(
            picture, box_of(size * factor, middle + away * math.cos(angle), bottom + away * math.sin(angle))
        )
    cut = slice(MARGIN_PX // 4, MARGIN_PX // 4 + WINDOW.cells)
    return compute_channels(picture)[:, cut, cut].reshape(-1)


def vehicle_at(distance_m: float, lateral_m: float) -> NDArray[np.float64]:
    bottom = CAMERA.row_at(distance_m)
    size_px = 2.1 * (bottom - CAMERA.horizon_row_px) / CAMERA.height_m
    return box_of(size_px, float(CAMERA.column_at(lateral_m, distance_m)), bottom)
