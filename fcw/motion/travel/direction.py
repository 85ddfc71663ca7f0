"""Where straight driving leads to, by all pictures of a clip together.

Everything that stands flows out of that point, however far away it is. It is looked for on a grid of
directions: pairs of pictures say how likely each of them is, and the clip's pairs are taken together. So no
guess of the camera's pitch is needed, and no mode is missed because another one was nearer to a guess.

What one pair says is not independent of what the next one says, and some pairs are astray: we turn, or a
lorry fills the picture. So pairs count little, some seconds of them may be wrong, and how sure the result is
follows from how it changes with the seconds that are drawn (the bootstrap, Efron 1979).
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
"""Between the pictures of a pair."""
LONGEST_PAIR_S = 2 * PAIR_S
FEWEST_POINTS, MOST_POINTS = 30, 150
MOVING_PX, MOVING_PART = 1.0, 0.4
"""We drive where so large a part of the points moves by so much between the pictures of a pair. On 20 clips
it was 0.44 and more while we drive and 0.36 and less while we stand and others pass."""
STILL_PX = 0.5
"""What moves by less then is on the own car, on the glass, or tells nothing."""
FASTEST_TURN_RADPS = math.radians(3.0)
"""Who turns faster goes aside as well, ahead of the rear axle: by 2 degrees at 7 m/s. What stands to the left
goes left as fast as what stands to the right goes right, so the median of all is how the picture turns."""
LARGEST_ASIDE_RAD = math.radians(2.0)
"""A column that is less sure is none: cameras that are put up by eye look ahead to that."""
TURN_SIGMAS_RADPS = np.radians((0.6, 8.0, 1.5))
"""How fast a car pitches, yaws and rolls."""
COARSE_STEP_RAD = math.radians(1.5)
COARSE_RAD = COARSE_STEP_RAD * np.arange(-12, 13)
"""Directions that are looked at first, to the right of the camera's axis and below it."""
COARSE_SIGMA_PX, FINE_SIGMA_PX = 1.0, 0.7
"""Of a point's movement across its way, in the small picture: the coarse grid must miss nothing between."""
FINE_RAD, FINE_STEP_RAD = math.radians(4.0), math.radians(0.5)
"""Then those around the best of them: how far to each side, and in which steps."""
POINTS_AS_ONE = 16.0
"""This many points tell as much as one: neighbours are followed wrongly together. With 8 two halves of a clip
differed by 1.3 of their sigmas, with 16 by 0.9."""
BLOCK_S = 1.5
ASTRAY_BLOCKS = 0.1
"""Part of the blocks of so many seconds that tell nothing true."""
FEWEST_PAIRS = 4
DRAWS = 60
LARGEST_SIGMA_RAD = math.radians(1.0)
"""Of the row: what is less sure is no better than what is believed of every camera."""
SLOPE_SIGMA_RAD = math.radians(0.25)
"""The road ahead is not level with the direction of travel, averaged over a clip."""


class _Pair(NamedTuple):
    """Two pictures: when the first was taken, the time between them, their points' rays, whether we turn."""

    time_s: float
    dt_s: float
    before: FloatArray
    after: FloatArray
    turns: bool


class TravelDirection:
    """Finds where straight driving leads to, picture by picture.

    Args:
        camera: whose focal length and axis are taken for granted; its pitch is not asked for.
        factor: by which the pictures in which points are followed are smaller than the whole ones.
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
        """For how long we were seen to drive."""
        return sum(pair.dt_s for pair in self._pairs)

    def between(self, begin_s: float, end_s: float) -> "TravelDirection":
        """What the pictures from one time to another tell alone."""
        part = TravelDirection(self._camera, self._factor)
        part._pairs = [
            pair for pair in self._pairs if begin_s <= pair.time_s and pair.time_s + pair.dt_s <= end_s
        ]
        return part

    def update(self, points: FollowedPoints, boxes: Sequence[Box]) -> None:
        """Take the points of a picture.

        Args:
            points: of it; times rise.
            boxes: of vehicles in the whole picture.
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
        """None where too few points are in both, or the car stands."""
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
        """Column and row in the whole picture; None where the pictures do not show the row.

        Where they do not show the column alone (we turn all the time), that is None.
        """
        coarse = np.tan(COARSE_RAD)
        if len(self._pairs) < FEWEST_PAIRS:
            return None
        blocks = self._blocks(self._pairs, coarse, coarse, COARSE_SIGMA_PX)
        rows = _around(coarse, _best(blocks.sum(axis=2)))
        if rows is None:
            return None
        # In a bend each block leads to another column, all to the same row.
        row = self._mean(self._blocks(self._pairs, coarse, rows, FINE_SIGMA_PX).sum(axis=2), rows)
        if row.sigma > LARGEST_SIGMA_RAD:
            return None
        column, camera = self._column(rows), self._camera
        column_px = None if column is None else self._place(column, camera.principal_column_px)
        return column_px, self._place(row, camera.principal_row_px)

    def _column(self, rows: FloatArray) -> Gaussian | None:
        """The ray to the side, by the pictures in which we do not turn."""
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
        """(blocks, rows, columns) how probable each block makes each direction."""
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
        """What blocks say together, by (blocks, rays) probabilities, and how far it hangs on the blocks."""
        logs, count = _logs(blocks), len(blocks)
        probability = _probability(logs.sum(axis=0))
        mean = float(probability @ rays)
        drawn = [
            _probability(logs[draw].sum(axis=0)) @ rays
            for draw in self._random.integers(count, size=(DRAWS, count))
        ]
        # Draws from few blocks differ too little, and nothing is known better than the steps of the grid.
        by_draws = float(np.var(drawn)) * count / (count - 1) + float(rays[1] - rays[0]) ** 2 / 12
        return Gaussian(mean, math.sqrt(float(probability @ (rays - mean) ** 2) + by_draws))


def _probability(logs: FloatArray) -> FloatArray:
    probability = np.exp(logs - logs.max())
    return probability / probability.sum()


def _logs(blocks: FloatArray) -> FloatArray:
    """Logarithms of (blocks, rays) probabilities, of which each block may be astray."""
    return np.log((1 - ASTRAY_BLOCKS) * blocks + ASTRAY_BLOCKS / blocks.shape[1])


def _best(blocks: FloatArray) -> int:
    """Which ray is likeliest, by (blocks, rays) probabilities."""
    return int(_logs(blocks).sum(axis=0).argmax())


def _around(rays: FloatArray, best: int) -> FloatArray | None:
    """Rays in finer steps around one of them; None of one at an end."""
    if best in (0, len(rays) - 1):
        return None
    return np.tan(math.atan(rays[best]) + np.arange(-FINE_RAD, FINE_RAD + FINE_STEP_RAD / 2, FINE_STEP_RAD))
