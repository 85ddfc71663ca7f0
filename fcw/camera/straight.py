"""The straight picture: what a level camera without distortion that looks along the vehicle would have seen.

A real camera is rolled, looks aside, and its lens bends lines. All geometry (`GroundPlaneCamera`) is that of
the straight picture, and this is the one place between the two. The straight camera keeps the real one's
place, pitch, focal length and axis row; its axis column is where the vehicle's direction of travel shows, so
that the picture's content stays where it was.

Axes of a camera: x right, y down, z forward. Yaw turns to the left, pitch down, roll to the right (ISO 8855).
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.camera.lens.model import Lens
from fcw.camera.lens.pixel_map import PixelMap
from fcw.frame import ImageSize

SEEN_PX = 1.0
"""A picture that straightening moves by less than this everywhere is straight as it is."""
GRID = 9
MOST_TURN_RAD = math.pi / 4
"""Yaw and roll of a camera that looks ahead; beyond, something was said that is not so."""


@dataclass(frozen=True, slots=True)
class Orientation:
    """How a camera is turned against the vehicle, besides its pitch.

    Attributes:
        yaw_rad: of its axis to the left of the direction of travel.
        roll_rad: about its axis to the right: the horizon falls to the left in the picture.
        yaw_sigma_rad: 1-sigma.
        roll_sigma_rad: 1-sigma.
    """

    yaw_rad: float = 0.0
    roll_rad: float = 0.0
    yaw_sigma_rad: float = 0.0
    roll_sigma_rad: float = 0.0


LEVEL = Orientation()


@dataclass(frozen=True, slots=True)
class Undone:
    """What was undone of a camera's pictures to make them straight.

    Attributes:
        orientation: how the real camera is turned besides its pitch.
        lens: of it; None where its picture has no distortion.
    """

    orientation: Orientation
    lens: Lens | None

    def through(self, pixels: PixelMap) -> "Undone":
        """The same of the pictures that a map leads to."""
        return Undone(self.orientation, None if self.lens is None else self.lens.through(pixels))


@dataclass(frozen=True, slots=True)
class Straightening:
    """The way between a picture and its straight one.

    Attributes:
        camera: the straight camera.
        orientation: of the real one.
        lens: of the real one; None where its picture has no distortion.
        image_size: of both pictures.
    """

    camera: GroundPlaneCamera
    orientation: Orientation
    lens: Lens | None
    image_size: ImageSize

    @property
    def is_identity(self) -> bool:
        """Whether the picture is straight as it is, to `SEEN_PX`."""
        if self.lens is None and self.orientation.roll_rad == 0 and self.orientation.yaw_rad == 0:
            return True
        columns, rows = np.meshgrid(
            np.linspace(0, self.image_size.width - 1, GRID), np.linspace(0, self.image_size.height - 1, GRID)
        )
        places = np.column_stack((columns.ravel(), rows.ravel()))
        return bool(np.abs(self.to_straight(places) - places).max() < SEEN_PX)

    def to_straight(self, places_px: FloatArray) -> FloatArray:
        """(N, 2) columns and rows of the picture in the straight picture."""
        rays = self._rays(places_px) @ self._turn().T
        return _projected(rays, self._straight_axis_px, self.camera.focal_y_px)

    def to_picture(self, places_px: FloatArray) -> FloatArray:
        """(N, 2) columns and rows of the straight picture in the picture; nan behind the camera."""
        rays = _with_depth((places_px - self._straight_axis_px) / self.camera.focal_y_px)
        rays = rays @ self._turn()
        rays[rays[:, 2] <= 0] = math.nan
        if self.lens is not None:
            return self.lens.distorted(rays[:, :2] / rays[:, 2:])
        return _projected(rays, self._real_axis_px, self.camera.focal_y_px)

    def image(self, image: NDArray[np.uint8], maps: tuple[NDArray, NDArray]) -> NDArray[np.uint8]:
        """(height, width, 3) straight picture of a picture; `maps` are those of `maps`."""
        straight = cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(straight, np.uint8)

    def maps(self) -> tuple[NDArray, NDArray]:
        """Where each pixel of the straight picture lies in the picture, for `image`."""
        size = self.image_size
        columns, rows = np.meshgrid(np.arange(size.width, dtype=float), np.arange(size.height, dtype=float))
        places = self.to_picture(np.column_stack((columns.ravel(), rows.ravel())))
        places = np.nan_to_num(places, nan=-1e4).astype(np.float32).reshape(size.height, size.width, 2)
        return cv2.convertMaps(places, np.empty(0, np.float32), cv2.CV_16SC2)

    def _rays(self, places_px: FloatArray) -> FloatArray:
        """(N, 3) in the real camera's axes."""
        if self.lens is not None:
            return _with_depth(self.lens.undistorted(places_px))
        return _with_depth((places_px - self._real_axis_px) / self.camera.focal_y_px)

    @property
    def _straight_axis_px(self) -> FloatArray:
        return np.array((self.camera.principal_column_px, self.camera.principal_row_px))

    @property
    def _real_axis_px(self) -> FloatArray:
        shift_px = _axis_shift_px(self.camera, self.orientation)
        return np.array((self.camera.principal_column_px - shift_px, self.camera.principal_row_px))

    def _turn(self) -> FloatArray:
        return turn(self.camera.pitch_rad, self.orientation)


def real_column(camera: GroundPlaneCamera, orientation: Orientation) -> float:
    """Column of the real camera's axis; the inverse of `straight_column`."""
    return camera.principal_column_px - _axis_shift_px(camera, orientation)


def straight_column(camera: GroundPlaneCamera, orientation: Orientation) -> float:
    """Column of the straight camera's axis, of a real camera whose own is `camera.principal_column_px`."""
    return camera.principal_column_px + _axis_shift_px(camera, orientation)


def turn(pitch_rad: float, orientation: Orientation) -> FloatArray:
    """(3, 3) from the real camera's axes to those of the straight one."""
    cosine, sine = math.cos(pitch_rad), math.sin(pitch_rad)
    ahead, left = math.cos(orientation.yaw_rad), math.sin(orientation.yaw_rad)
    level, rolled = math.cos(orientation.roll_rad), math.sin(orientation.roll_rad)
    # Rodrigues' formula: yaw is about the vertical, which has the camera's axes (0, cosine, sine).
    both = (1 - ahead) * cosine * sine
    yaw = np.array(
        [
            [ahead, left * sine, -left * cosine],
            [-left * sine, cosine**2 + ahead * sine**2, both],
            [left * cosine, both, sine**2 + ahead * cosine**2],
        ]
    )
    return yaw @ np.array([[level, -rolled, 0], [rolled, level, 0], [0, 0, 1]])


def _axis_shift_px(camera: GroundPlaneCamera, orientation: Orientation) -> float:
    cosine, yaw = math.cos(camera.pitch_rad), orientation.yaw_rad
    # The real axis stays where it is in the picture; the vehicle's direction, by `turn`, lies beside it.
    return camera.focal_y_px * math.sin(yaw) * cosine / (1 + (math.cos(yaw) - 1) * cosine**2)


def _with_depth(slopes: FloatArray) -> FloatArray:
    """(N, 3) rays of (N, 2) slopes."""
    return np.concatenate((slopes, np.ones((len(slopes), 1))), axis=1)


def _projected(rays: FloatArray, axis_px: FloatArray, focal_px: float) -> FloatArray:
    depths = np.where(rays[:, 2:] > 0, rays[:, 2:], math.nan)
    return axis_px + focal_px * rays[:, :2] / depths
