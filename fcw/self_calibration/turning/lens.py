"""A lens of two unknowns, with the slopes that a fit of it needs."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.camera.lens.model import Lens
from fcw.frame import ImageSize

WIDEST_RAD = 1.35
"""Angle from the axis to which the family is used."""
STEEPEST_RAD, NEARLY_ONE = 1.45, 0.999
"""Of its tangent and hyperbolic tangent, short of where they end."""
NEARLY_NONE = 1e-6


class Rays(NamedTuple):
    """Where places look to.

    Attributes:
        places: (N, 2) x / z and y / z.
        slopes: (N, 2, 2) of them by column and row.
    """

    places: FloatArray
    slopes: FloatArray


@dataclass(frozen=True, slots=True)
class PlainLens:
    """A focal length and how much the lens bends, with the axis in a known place.

    What is seen at the angle a from the axis shows tan(s a) / s focal lengths from it. The family holds the
    straight picture (s = 1) and those of fisheyes: stereographic (s = 1/2), equidistant (s = 0), and with s²
    below 0, where tan becomes tanh, close to equal areas. Makers of panoramas use it for any lens (the
    "fisheye factor" of PTGui).

    Attributes:
        focal_px: focal length.
        bend: (s² - 1) / 3, which near the axis is k1 of Brown 1971; -1/3 is equidistant.
        axis_px: column and row of the optical axis.
    """

    focal_px: float
    bend: float
    axis_px: tuple[float, float]

    def rays(self, places_px: FloatArray) -> Rays:
        """Rays of the places (N, 2), columns and rows."""
        bent = (places_px - np.array(self.axis_px)) / self.focal_px
        radius = np.linalg.norm(bent, axis=1)
        rays = bent * (np.tan(self._angle(radius)) / np.maximum(radius, 1e-12))[:, None]
        rays[radius < 1e-9] = bent[radius < 1e-9]
        slopes = self.bending(rays)
        area = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] ** 2
        inverse = np.empty_like(slopes)
        inverse[:, 0, 0], inverse[:, 1, 1] = slopes[:, 1, 1], slopes[:, 0, 0]
        inverse[:, 0, 1] = inverse[:, 1, 0] = -slopes[:, 0, 1]
        return Rays(rays, inverse / (area * self.focal_px)[:, None, None])

    def bent(self, rays: FloatArray) -> FloatArray:
        """(N, 2) rays as the lens bends them, in focal lengths."""
        tangent, angle = _from_axis(rays)
        return rays * (self._radius(angle) / tangent)[:, None]

    def bending(self, rays: FloatArray) -> FloatArray:
        """(N, 2, 2) slopes of `bent`."""
        tangent, angle = _from_axis(rays)
        radius, along = self._radius(angle), rays / tangent[:, None]
        across = radius / tangent
        outwards = (1 + self._squared * radius**2) / (1 + tangent**2)
        slopes = (outwards - across)[:, None, None] * along[:, :, None] * along[:, None, :]
        slopes[:, 0, 0] += across
        slopes[:, 1, 1] += across
        return slopes

    def by_bend(self, rays: FloatArray) -> FloatArray:
        """(N, 2) slopes of `bent` by the bend."""
        tangent, angle = _from_axis(rays)
        squared, radius = self._squared, self._radius(angle)
        if abs(squared) < 1e-3:
            slope = angle**3 / 3 + squared * 4 * angle**5 / 15
        else:
            slope = (angle * (1 + squared * radius**2) - radius) / (2 * squared)
        return rays * (3 * slope / tangent)[:, None]

    def fisheye(self, size: ImageSize) -> Lens:
        """As OpenCV, ROS and Kalibr know it: the first terms of tan(s a) / s in powers of a.

        Args:
            size: of its pictures.
        """
        squared = self._squared
        terms = (squared / 3, 2 * squared**2 / 15, 17 * squared**3 / 315, 62 * squared**4 / 2835)
        return Lens("equidistant", self.focal_px, self.focal_px, *self.axis_px, terms, size)

    @property
    def _squared(self) -> float:
        """s²."""
        return 1 + 3 * self.bend

    def _radius(self, angle: FloatArray) -> FloatArray:
        squared, s = self._squared, math.sqrt(abs(self._squared))
        if abs(squared) < NEARLY_NONE:
            return angle
        return np.tan(np.minimum(s * angle, STEEPEST_RAD)) / s if squared > 0 else np.tanh(s * angle) / s

    def _angle(self, radius: FloatArray) -> FloatArray:
        squared, s = self._squared, math.sqrt(abs(self._squared))
        angle = radius
        if squared >= NEARLY_NONE:
            angle = np.arctan(s * radius) / s
        elif squared <= -NEARLY_NONE:
            angle = np.arctanh(np.minimum(s * radius, NEARLY_ONE)) / s
        return np.minimum(angle, WIDEST_RAD)


def _from_axis(rays: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(N,) tangents of angles from the axis, above 0, and the angles."""
    tangent = np.maximum(np.linalg.norm(rays, axis=1), 1e-9)
    return tangent, np.arctan(tangent)
