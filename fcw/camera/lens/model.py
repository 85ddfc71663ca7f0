"""A lens with distortion, in the models of OpenCV, ROS and Kalibr."""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray
from fcw.camera.lens.pixel_map import PixelMap
from fcw.errors import UserError
from fcw.frame import ImageSize

DistortionModel = Literal["radtan", "equidistant"]
DISTORTION_MODELS: tuple[str, ...] = get_args(DistortionModel)
COEFFICIENT_COUNTS = {"radtan": (4, 5, 8), "equidistant": (4,)}
ASPECT_TOLERANCE = 0.02
"""Encoders cut or pad some rows (1088 for 1080); the modes of cameras differ by more than that."""
UNDISTORT_STEPS = 100
"""OpenCV's default of five leaves errors of pixels at the edge of a wide lens."""


@dataclass(frozen=True, slots=True)
class Lens:
    """Intrinsics and distortion of a camera.

    Attributes:
        model: `radtan` (Brown 1971; OpenCV's k1, k2, p1, p2, k3 and the rational k4 to k6; ROS plumb_bob) or
            `equidistant` (Kannala & Brandt 2006, four coefficients; OpenCV's fisheye).
        focal_x_px: horizontal focal length.
        focal_y_px: vertical focal length; it differs if the picture was squeezed.
        column_px: column of the optical axis.
        row_px: row of the optical axis.
        coefficients: distortion coefficients of the model.
        image_size: size of the camera's pictures.
    """

    model: DistortionModel
    focal_x_px: float
    focal_y_px: float
    column_px: float
    row_px: float
    coefficients: tuple[float, ...]
    image_size: ImageSize

    @property
    def matrix(self) -> FloatArray:
        """(3, 3) camera matrix."""
        return np.array(
            [[self.focal_x_px, 0, self.column_px], [0, self.focal_y_px, self.row_px], [0, 0, 1.0]]
        )

    def undistorted(self, places_px: FloatArray) -> FloatArray:
        """(N, 2) x / z and y / z of the rays through (N, 2) columns and rows."""
        places = np.ascontiguousarray(places_px, np.float64).reshape(-1, 1, 2)
        coefficients = np.array(self.coefficients)
        if self.model == "equidistant":
            return _plain(cv2.fisheye.undistortPoints(places, self.matrix, coefficients))
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, UNDISTORT_STEPS, 1e-12)
        return _plain(cv2.undistortPoints(places, self.matrix, coefficients, criteria=criteria))

    def distorted(self, rays: FloatArray) -> FloatArray:
        """(N, 2) columns and rows of rays given by their x / z and y / z."""
        if self.model == "equidistant":
            places = np.ascontiguousarray(rays, np.float64).reshape(-1, 1, 2)
            return _plain(cv2.fisheye.distortPoints(places, self.matrix, np.array(self.coefficients)))
        points = np.column_stack((rays, np.ones(len(rays))))
        zero = np.zeros(3)
        return _plain(cv2.projectPoints(points, zero, zero, self.matrix, np.array(self.coefficients))[0])

    def for_image_size(self, size: ImageSize) -> "Lens":
        """The same lens for pictures of the same camera in another size.

        Raises:
            UserError: the aspect ratios differ, so that one cannot be the other one scaled.
        """
        across, down = size.width / self.image_size.width, size.height / self.image_size.height
        if abs(across / down - 1) > ASPECT_TOLERANCE:
            raise UserError(
                f"the lens is of pictures of {self.image_size}, these are {size}: another aspect ratio; "
                "take the lens of this camera in this mode"
            )
        return self.through(PixelMap(size, across, down))

    def through(self, pixels: PixelMap) -> "Lens":
        """The same lens for the pictures that a map leads to."""
        return replace(
            self,
            focal_x_px=self.focal_x_px * pixels.across,
            focal_y_px=self.focal_y_px * pixels.down,
            column_px=pixels.column(self.column_px),
            row_px=pixels.row(self.row_px),
            image_size=pixels.size,
        )


def _plain(places: NDArray) -> FloatArray:
    return np.asarray(places, np.float64).reshape(-1, 2)
