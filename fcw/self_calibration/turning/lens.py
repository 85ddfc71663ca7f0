"""A lens of two unknowns, with the slopes that a fit of it needs."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fcw.camera.ground_plane import FloatArray

UNBEND_STEPS = 12
LEAST_STRETCH, LEAST_AREA = 0.3, 0.05
"""Where a lens would fold its picture over, it is taken not to."""


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
    """A focal length and one coefficient of distortion (k1 of Brown 1971), with the axis in a known place.

    Attributes:
        focal_px: focal length.
        bend: k1.
        axis_px: column and row of the optical axis.
    """

    focal_px: float
    bend: float
    axis_px: tuple[float, float]

    def rays(self, places_px: FloatArray) -> Rays:
        """Of (N, 2) columns and rows."""
        bent = (places_px - np.array(self.axis_px)) / self.focal_px
        bent_squared = (bent**2).sum(axis=1)
        stretch = np.ones(len(bent))
        for _ in range(UNBEND_STEPS):
            stretch = 1 / np.maximum(1 + self.bend * bent_squared * stretch**2, LEAST_STRETCH)
        rays = bent * stretch[:, None]
        slopes = self.bending(rays)
        area = np.maximum(slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] ** 2, LEAST_AREA)
        inverse = np.empty_like(slopes)
        inverse[:, 0, 0], inverse[:, 1, 1] = slopes[:, 1, 1], slopes[:, 0, 0]
        inverse[:, 0, 1] = inverse[:, 1, 0] = -slopes[:, 0, 1]
        return Rays(rays, inverse / (area * self.focal_px)[:, None, None])

    def bent(self, rays: FloatArray) -> FloatArray:
        """(N, 2) rays as the lens bends them, in focal lengths."""
        return rays * (1 + self.bend * (rays**2).sum(axis=1))[:, None]

    def bending(self, rays: FloatArray) -> FloatArray:
        """(N, 2, 2) slopes of `bent`."""
        slopes = 2 * self.bend * rays[:, :, None] * rays[:, None, :]
        stretch = 1 + self.bend * (rays**2).sum(axis=1)
        slopes[:, 0, 0] += stretch
        slopes[:, 1, 1] += stretch
        return slopes
