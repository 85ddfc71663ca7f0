"""The straight picture: what a camera without distortion, roll and yaw would have seen.

A real camera has a roll and a yaw, and its lens bends lines. All geometry (`GroundPlaneCamera`) is that of
the straight picture; only this module converts between the two. The straight camera has the real one's
position, pitch, focal length and principal row. Its principal column is where the vehicle's direction of
travel appears, so that the content of the picture stays in place.

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
"""If straightening moves no pixel by more than this, the picture counts as straight."""
GRID = 9
MOST_TURN_RAD = math.pi / 4
"""Largest yaw and roll of a camera that looks ahead; a larger value is a mistake."""


@dataclass(frozen=True, slots=True)
class Orientation:
    """Yaw and roll of a camera relative to the vehicle.

    Attributes:
        yaw_rad: angle of the axis to the left of the direction of travel.
        roll_rad: angle about the axis to the right, so that the horizon falls to the left in the picture.
        yaw_sigma_rad: standard deviation of the yaw.
        roll_sigma_rad: standard deviation of the roll.
    """

    yaw_rad: float = 0.0
    roll_rad: float = 0.0
    yaw_sigma_rad: float = 0.0
    roll_sigma_rad: float = 0.0


LEVEL = Orientation()


@dataclass(frozen=True, slots=True)
class Undone:
    """What straightening removed from a camera's pictures.

    Attributes:
        orientation: yaw and roll of the real camera.
        lens: its lens; None if the picture had no distortion.
    """

    orientation: Orientation
    lens: Lens | None

    def through(self, pixels: PixelMap) -> "Undone":
        """The same for the pictures that a map leads to."""
        return Undone(self.orientation, None if self.lens is None else self.lens.through(pixels))


@dataclass(frozen=True, slots=True)
class Straightening:
    """Converts between a picture and its straight picture.

    Attributes:
        camera: the straight camera.
        orientation: yaw and roll of the real camera.
        lens: lens of the real camera; None if its picture has no distortion.
        image_size: size of both pictures.
    """

    camera: GroundPlaneCamera
    orientation: Orientation
    lens: Lens | None
    image_size: ImageSize

    @property
    def is_identity(self) -> bool:
        """Whether the picture is already straight, to within `SEEN_PX`."""
        if self.lens is None and self.orientation.roll_rad == 0 and self.orientation.yaw_rad == 0:
            return True
        columns, rows = np.meshgrid(
            np.linspace(0, self.image_size.width - 1, GRID), np.linspace(0, self.image_size.height - 1, GRID)
        )
        places = np.column_stack((columns.ravel(), rows.ravel()))
        return bool(np.abs(self.to_straight(places) - places).max() < SEEN_PX)

    def to_straight(self, places_px: FloatArray) -> FloatArray:
        """Convert (N, 2) columns and rows of the picture to those of the straight picture."""
        rays = self._rays(places_px) @ self._turn().T
        return _projected(rays, self._straight_axis_px, self.camera.focal_y_px)

    def to_picture(self, places_px: FloatArray) -> FloatArray:
        """Convert (N, 2) columns and rows of the straight picture to those of the picture.

        They are nan behind the camera.
        """
        rays = _with_depth((places_px - self._straight_axis_px) / self.camera.focal_y_px)
        rays = rays @ self._turn()
        rays[rays[:, 2] <= 0] = math.nan
        if self.lens is not None:
            return self.lens.distorted(rays[:, :2] / rays[:, 2:])
        return _projected(rays, self._real_axis_px, self.camera.focal_y_px)

    def image(self, image: NDArray[np.uint8], maps: tuple[NDArray, NDArray]) -> NDArray[np.uint8]:
        """The (height, width, 3) straight picture of a picture; `maps` comes from the method `maps`."""
        straight = cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(straight, np.uint8)

    def maps(self) -> tuple[NDArray, NDArray]:
        """The place in the picture of each pixel of the straight picture, for `image`."""
        size = self.image_size
        columns, rows = np.meshgrid(np.arange(size.width, dtype=float), np.arange(size.height, dtype=float))
        places = self.to_picture(np.column_stack((columns.ravel(), rows.ravel())))
        places = np.nan_to_num(places, nan=-1e4).astype(np.float32).reshape(size.height, size.width, 2)
        return cv2.convertMaps(places, np.empty(0, np.float32), cv2.CV_16SC2)

    def _rays(self, places_px: FloatArray) -> FloatArray:
        """(N, 3) rays in the axes of the real camera."""
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
    """Principal column of the real camera of a straight one; the inverse of `straight_column`."""
    return camera.principal_column_px - _axis_shift_px(camera, orientation)


def straight_column(camera: GroundPlaneCamera, orientation: Orientation) -> float:
    """Principal column of the straight camera, where `camera.principal_column_px` is the real one's."""
    return camera.principal_column_px + _axis_shift_px(camera, orientation)


def turn(pitch_rad: float, orientation: Orientation) -> FloatArray:
    """(3, 3) rotation from the axes of the real camera to those of the straight one."""
    cosine, sine = math.cos(pitch_rad), math.sin(pitch_rad)
    ahead, left = math.cos(orientation.yaw_rad), math.sin(orientation.yaw_rad)
    level, rolled = math.cos(orientation.roll_rad), math.sin(orientation.roll_rad)
    # Rodrigues' formula: yaw is about the vertical, which is (0, cosine, sine) in the camera's axes.
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
    # The real axis keeps its place in the picture; by `turn`, the direction of travel is beside it.
    return camera.focal_y_px * math.sin(yaw) * cosine / (1 + (math.cos(yaw) - 1) * cosine**2)


def _with_depth(slopes: FloatArray) -> FloatArray:
    """(N, 3) rays with the (N, 2) slopes."""
    return np.concatenate((slopes, np.ones((len(slopes), 1))), axis=1)


def _projected(rays: FloatArray, axis_px: FloatArray, focal_px: float) -> FloatArray:
    depths = np.where(rays[:, 2:] > 0, rays[:, 2:], math.nan)
    return axis_px + focal_px * rays[:, :2] / depths
