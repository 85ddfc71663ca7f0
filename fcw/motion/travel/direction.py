"""The direction of travel, estimated from many pictures of a clip together.

Every standing object flows away from that point (the focus of expansion), however far away it is. The point
is searched for on a grid of directions: pairs of pictures give the likelihood of each, and all pairs are
combined. So no guess of the camera's pitch is needed, and no mode is missed because another one was closer to
a guess.

Consecutive pairs are not independent, and some pairs are wrong because we turn, or a lorry fills the picture.
So each pair has a small weight, some seconds may be wrong, and the uncertainty is found by resampling the
seconds (the bootstrap, Efron 1979).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fcw.box import Box
from fcw.camera.calibration import Gaussian
from fcw.camera.ground_plane import FloatArray, GroundPlaneCamera
from fcw.motion.travel.likelihood import log_likelihoods
from fcw.motion.travel.tracks import FollowedPoints

PAIR_S = 0.3
"""Time between the pictures of a pair."""
LONGEST_PAIR_S = 2 * PAIR_S
FEWEST_POINTS, MOST_POINTS = 30, 150
MOVING_PX, MOVING_PART = 1.0, 0.4
"""We drive if at least this fraction of the points moves by at least this much between the pictures of a
pair. On 20 clips, the fraction was at least 0.44 while driving, and at most 0.36 while standing with others
passing."""
STILL_PX = 0.5
"""Points that move by less while we drive are on our own car or the windscreen, or tell nothing."""
FASTEST_TURN_RADPS = math.radians(3.0)
"""In a faster turn the camera, which is ahead of the rear axle, also moves sideways: by 2 degrees at 7 m/s.
The median flow of all points is the rotation, because objects on the left move left as fast as those on the
right move right."""
LARGEST_ASIDE_RAD = math.radians(2.0)
"""A column with a larger 1-sigma is not used, as cameras mounted by eye look ahead that well."""
TURN_SIGMAS_RADPS = np.radians((0.6, 8.0, 1.5))
"""1-sigmas of a car's pitch, yaw and roll rates."""
COARSE_STEP_RAD = math.radians(1.5)
COARSE_RAD = COARSE_STEP_RAD * np.arange(-12, 13)
"""Directions of the coarse grid, to the right of the camera's axis and below it."""
COARSE_SIGMA_PX, FINE_SIGMA_PX = 1.0, 0.7
"""1-sigma of a point's motion across its direction, in the small picture; wider for the coarse grid, which
must not miss a mode between two of its directions."""
FINE_RAD, FINE_STEP_RAD = math.radians(4.0), math.radians(0.5)
"""Half width and step of the fine grid around the best coarse direction."""
POINTS_AS_ONE = 16.0
"""This many points count as one, because the errors of neighbours are correlated. With 8, two halves of a
clip differed by 1.3 of their sigmas; with 16, by 0.9."""
BLOCK_S = 1.5
ASTRAY_BLOCKS = 0.1
"""Length of the blocks into which a clip is divided, and the fraction of them that may be wrong."""
FEWEST_PAIRS = 4
DRAWS = 60
"""Number of bootstrap samples."""
LARGEST_SIGMA_RAD = math.radians(1.0)
"""A row with a larger 1-sigma is not used, as it tells no more than the prior of any camera."""
SLOPE_SIGMA_RAD = math.radians(0.25)
"""1-sigma of the angle between the road ahead and the direction of travel, averaged over a clip."""


class _Pair(NamedTuple):
    """A pair of pictures: time of the first, time between them, rays of their points, and whether we turn."""

    time_s: float
    dt_s: float
    before: FloatArray
    after: FloatArray
    turns: bool


class TravelDirection:
    """Estimates the direction of travel, picture by picture.

    Args:
        camera: its focal length and axis are used, but not its pitch.
        factor: reduction factor of the pictures in which points are tracked.
    """

    def __init__(self, camera: GroundPlaneCamera, factor: int) -> None:
        self._camera, self._factor = camera, factor
        self._focal_px = camera.focal_y_px / factor
        axis_px = np.array((camera.principal_column_px, camera.principal_row_px))
        self._axis_px = (axis_px + 0.5) / factor - 0.5
        self._first: FollowedPoints | None = None
        self._first_boxes: Sequence[Box] = ()
        self._pairs: list[_Pair] = []
        self._random = np.random.default_rng(0)

    @property
    def driven_s(self) -> float:
        """Total time for which we were seen to drive."""
        return sum(pair.dt_s for pair in self._pairs)

    def between(self, begin_s: float, end_s: float) -> "TravelDirection":
        """An estimator with only the pictures from one time to another."""
        part = TravelDirection(self._camera, self._factor)
        part._pairs = [
            pair for pair in self._pairs if begin_s <= pair.time_s and pair.time_s + pair.dt_s <= end_s
        ]
        return part

    def update(self, points: FollowedPoints, boxes: Sequence[Box]) -> None:
        """Update with the points of a picture.

        Args:
            points: its points; times must increase.
            boxes: boxes of vehicles in the whole picture.
        """
        first = self._first
        if first is not None and points.time_s - first.time_s < PAIR_S - 1e-6:
            return
        if first is not None and points.time_s - first.time_s <= LONGEST_PAIR_S:
            pair = self._pair(first, points)
            if pair is not None:
                self._pairs.append(pair)
        self._first, self._first_boxes = points, boxes

    def _pair(self, first: FollowedPoints, second: FollowedPoints) -> _Pair | None:
        """Make a pair; None if too few points are in both pictures, or if we stand."""
        _, here, there = np.intersect1d(first.numbers, second.numbers, return_indices=True)
        before, after = first.places[here].astype(np.float64), second.places[there].astype(np.float64)
        kept = np.ones(len(before), bool)
        for box in self._first_boxes:
            low, high = (
                np.array(place) / self._factor for place in ((box.x, box.y), (box.right, box.bottom))
            )
            kept &= ~((before > low) & (before < high)).all(axis=1)
        moved_px = np.hypot(*(after - before).T)
        if kept.sum() < FEWEST_POINTS or np.mean(moved_px[kept] > MOVING_PX) < MOVING_PART:
            return None
        chosen = np.flatnonzero(kept & (moved_px > STILL_PX))
        if len(chosen) < FEWEST_POINTS:
            return None
        chosen = self._random.permutation(chosen)[:MOST_POINTS]
        rays = [(places[chosen] - self._axis_px) / self._focal_px for places in (before, after)]
        dt_s = second.time_s - first.time_s
        turns = abs(float(np.median(rays[1][:, 0] - rays[0][:, 0]))) > FASTEST_TURN_RADPS * dt_s
        return _Pair(first.time_s, dt_s, rays[0], rays[1], turns)

    def told(self) -> tuple[Gaussian | None, Gaussian] | None:
        """Column and row in the whole picture; None if the pictures do not determine the row.

        Only the column is None if we turn all the time.
        """
        coarse = np.tan(COARSE_RAD)
        if len(self._pairs) < FEWEST_PAIRS:
            return None
        blocks = self._blocks(self._pairs, coarse, coarse, COARSE_SIGMA_PX)
        rows = _around(coarse, _best(blocks.sum(axis=2)))
        if rows is None:
            return None
        # In a bend, each block has another column, but all have the same row.
        row = self._mean(self._blocks(self._pairs, coarse, rows, FINE_SIGMA_PX).sum(axis=2), rows)
        if row.sigma > LARGEST_SIGMA_RAD:
            return None
        column, camera = self._column(rows), self._camera
        column_px = None if column is None else self._place(column, camera.principal_column_px)
        return column_px, self._place(row, camera.principal_row_px)

    def _column(self, rows: FloatArray) -> Gaussian | None:
        """The horizontal direction, from pairs in which we do not turn."""
        straight = [pair for pair in self._pairs if not pair.turns]
        if len(straight) < FEWEST_PAIRS:
            return None
        coarse = np.tan(COARSE_RAD)
        blocks = self._blocks(straight, coarse, rows, COARSE_SIGMA_PX).sum(axis=1)
        column, columns = self._mean(blocks, coarse), _around(coarse, _best(blocks))
        if columns is not None and column.sigma < COARSE_STEP_RAD:
            column = self._mean(self._blocks(straight, columns, rows, FINE_SIGMA_PX).sum(axis=1), columns)
        return column if column.sigma < LARGEST_ASIDE_RAD else None

    def _place(self, ray: Gaussian, axis_px: float) -> Gaussian:
        focal_px = self._camera.focal_y_px
        sigma_px = focal_px * math.hypot(ray.sigma, SLOPE_SIGMA_RAD)
        return Gaussian(axis_px + focal_px * ray.value, sigma_px)

    def _blocks(
        self, pairs: Sequence[_Pair], columns: FloatArray, rows: FloatArray, sigma_px: float
    ) -> FloatArray:
        """(blocks, rows, columns) probability of each direction by each block."""
        directions = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        likelihoods = np.array(
            [
                log_likelihoods(
                    pair.before,
                    pair.after,
                    directions,
                    TURN_SIGMAS_RADPS * pair.dt_s,
                    sigma_px,
                    self._focal_px,
                )
                for pair in pairs
            ]
        )
        times_s = np.array([pair.time_s for pair in pairs])
        count = max(2, round((times_s[-1] - times_s[0] + PAIR_S) / BLOCK_S))
        of_block = np.digitize(times_s, np.linspace(times_s[0], times_s[-1] + PAIR_S, count + 1))
        told = [likelihoods[of_block == block].sum(axis=0) / POINTS_AS_ONE for block in np.unique(of_block)]
        return np.array([_probability(block) for block in told]).reshape(-1, len(rows), len(columns))

    def _mean(self, blocks: FloatArray, rays: FloatArray) -> Gaussian:
        """Mean by all blocks' (blocks, rays) probabilities, with a sigma from resampling the blocks."""
        logs, count = _logs(blocks), len(blocks)
        probability = _probability(logs.sum(axis=0))
        mean = float(probability @ rays)
        drawn = [
            _probability(logs[draw].sum(axis=0)) @ rays
            for draw in self._random.integers(count, size=(DRAWS, count))
        ]
        # Samples of few blocks vary too little, and nothing is known better than the step of the grid.
        by_draws = float(np.var(drawn)) * count / (count - 1) + float(rays[1] - rays[0]) ** 2 / 12
        return Gaussian(mean, math.sqrt(float(probability @ (rays - mean) ** 2) + by_draws))


def _probability(logs: FloatArray) -> FloatArray:
    probability = np.exp(logs - logs.max())
    return probability / probability.sum()


def _logs(blocks: FloatArray) -> FloatArray:
    """Logarithms of (blocks, rays) probabilities, allowing for blocks that are wrong."""
    return np.log((1 - ASTRAY_BLOCKS) * blocks + ASTRAY_BLOCKS / blocks.shape[1])


def _best(blocks: FloatArray) -> int:
    """Index of the likeliest ray, given (blocks, rays) probabilities."""
    return int(_logs(blocks).sum(axis=0).argmax())


def _around(rays: FloatArray, best: int) -> FloatArray | None:
    """Rays in finer steps around one of them; None if it is the first or the last."""
    if best in (0, len(rays) - 1):
        return None
    return np.tan(math.atan(rays[best]) + np.arange(-FINE_RAD, FINE_RAD + FINE_STEP_RAD / 2, FINE_STEP_RAD))
