"""The road: lanes, markings, and its course through space.

The reference line, the centre line of lane 0, is given by its curvature and its grade as smooth functions of
the arc length `s`. Both are sums of swells: each rises from 0 to its peak and falls back like sin^2, so that
heading and slope have a closed form and neither the steering nor the vertical acceleration ever jumps.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fcw.camera.ground_plane import FloatArray

TABLE_STEP_M = 0.5
"""Positions between two entries are interpolated: at a radius of 200 m that is wrong by 0.2 mm."""


@dataclass(frozen=True, slots=True)
class Swell:
    """A quantity that rises to its peak and back: peak sin^2(pi (s - start) / length) inside, else 0."""

    start_m: float
    length_m: float
    peak: float

    def at(self, s_m: FloatArray) -> FloatArray:
        """The value at arc lengths."""
        inside = np.clip((s_m - self.start_m) / self.length_m, 0.0, 1.0)
        return self.peak * np.sin(np.pi * inside) ** 2

    def integral(self, s_m: FloatArray) -> FloatArray:
        """The integral up to arc lengths."""
        inside = np.clip((s_m - self.start_m) / self.length_m, 0.0, 1.0)
        return self.peak * self.length_m * (inside / 2 - np.sin(2 * np.pi * inside) / (4 * np.pi))


@dataclass(frozen=True, slots=True)
class Lane:
    """A lane: its middle's lateral position, its width, and whether its traffic comes towards us."""

    lateral_m: float
    width_m: float
    oncoming: bool = False


@dataclass(frozen=True, slots=True)
class LaneMarking:
    """A painted line along the road: all of it, or the first `dash_m` of every `period_m`, from s = 0."""

    lateral_m: float
    dashed: bool
    width_m: float = 0.15
    dash_m: float = 4.0
    period_m: float = 12.0


@dataclass(frozen=True)
class RoadProfile:
    """A road of constant cross-section along a smooth line.

    Attributes:
        lanes: from right to left; lane 0 is the one around lateral 0.
        markings: every painted line.
        right_edge_m: lateral position of the asphalt's right edge, negative.
        left_edge_m: of its left edge.
        bends: curvature in 1/m, positive to the left.
        grades: sine of the slope, the rise per metre of road, positive uphill.
    """

    lanes: tuple[Lane, ...]
    markings: tuple[LaneMarking, ...]
    right_edge_m: float
    left_edge_m: float
    bends: tuple[Swell, ...] = ()
    grades: tuple[Swell, ...] = ()

    def grade_at(self, s_m: FloatArray | float) -> FloatArray:
        """Rise per metre of road."""
        return _total(self.grades, s_m)

    def heading_at(self, s_m: FloatArray | float) -> FloatArray:
        """Heading in the world frame, 0 along x, positive to the left."""
        return _total(self.bends, s_m, integral=True)

    def axes(self, s_m: float) -> FloatArray:
        """Forward, left and up of the road at an arc length, one a row, in the world frame."""
        heading, sine = float(self.heading_at(s_m)), float(self.grade_at(s_m))
        cosine = math.sqrt(1 - sine**2)
        forward = (math.cos(heading) * cosine, math.sin(heading) * cosine, sine)
        left = (-math.sin(heading), math.cos(heading), 0.0)
        up = (-math.cos(heading) * sine, -math.sin(heading) * sine, cosine)
        return np.array((forward, left, up))

    def world_points(
        self, s_m: FloatArray | float, lateral_m: FloatArray | float, height_m: FloatArray | float = 0.0
    ) -> FloatArray:
        """Points in the world frame, (..., 3): x along the road's start, y left, z up; inputs broadcast."""
        s_m, lateral_m, height_m = np.broadcast_arrays(
            np.asarray(s_m, np.float64), np.asarray(lateral_m, np.float64), np.asarray(height_m, np.float64)
        )
        heading, sine = self.heading_at(s_m), self.grade_at(s_m)
        cosine = np.sqrt(1 - sine**2)
        left = np.stack((-np.sin(heading), np.cos(heading), np.zeros_like(heading)), axis=-1)
        up = np.stack((-np.cos(heading) * sine, -np.sin(heading) * sine, cosine), axis=-1)
        return self._line(s_m) + lateral_m[..., None] * left + height_m[..., None] * up

    def _line(self, s_m: FloatArray) -> FloatArray:
        """Points of the reference line in the world frame."""
        table_s, table = self._table
        inside = np.clip(s_m, table_s[0], table_s[-1])
        line = np.stack([np.interp(inside, table_s, table[:, axis]) for axis in range(3)], axis=-1)
        # Beyond every swell the road is straight and level, at its final heading.
        heading = self.heading_at(s_m)
        tangent = np.stack((np.cos(heading), np.sin(heading), np.zeros_like(heading)), axis=-1)
        return line + (s_m - inside)[..., None] * tangent

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray]:
        """Arc lengths (N,) and the reference line's points (N, 3) there."""
        swells = (*self.bends, *self.grades)
        start_m = min([0.0, *(swell.start_m for swell in swells)])
        end_m = max([TABLE_STEP_M, *(swell.start_m + swell.length_m for swell in swells)])
        s_m = np.arange(start_m, end_m + TABLE_STEP_M, TABLE_STEP_M)
        middles_m = s_m[:-1] + TABLE_STEP_M / 2
        heading, sine = self.heading_at(middles_m), self.grade_at(middles_m)
        level = np.sqrt(1 - sine**2)
        steps = TABLE_STEP_M * np.stack((np.cos(heading) * level, np.sin(heading) * level, sine), axis=-1)
        points = np.vstack((np.zeros(3), np.cumsum(steps, axis=0)))
        points[:, 0] += start_m
        return s_m, points


def _total(swells: Sequence[Swell], s_m: FloatArray | float, integral: bool = False) -> FloatArray:
    s_m = np.asarray(s_m, np.float64)
    total = np.zeros_like(s_m)
    for swell in swells:
        total = total + (swell.integral(s_m) if integral else swell.at(s_m))
    return total
