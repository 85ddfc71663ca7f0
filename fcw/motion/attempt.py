"""Estimate the motion between two pictures, starting from an expected one."""

import math

import numpy as np
from numpy.typing import NDArray

from fcw.camera.ground_plane import FloatArray
from fcw.motion.filter import MotionFilter
from fcw.motion.flow.points import Flow, PointFollower, SmallPicture
from fcw.motion.flow.stillness import Stillness
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import TRAVEL, Solution, solve

INLYING = 0.25
"""A point with at least this weight is an inlier: it is within one scale of the weights."""
OWN_CAR_REACHES_M = (6.0, 8.0, 12.0)
"""If our own car was not learned (a bonnet that mirrors the world, say), it hides the road up to one of
these."""


class Attempt:
    """The motion between two pictures, solved from a filter's expectation; the filter is updated with it.

    If the speed is known, a larger pitch than usual on springs is allowed for. If the speed is only a
    hypothesis, it is not, because the pitch would compensate for a wrong speed.

    Attributes:
        flow: the points that were tracked.
        filter: the filter, updated with them.
        solution: None if the points give no plausible motion.
        evidence: evidence of the solution.
        points: number of inliers on the road, and elsewhere.
        doubtful: whether another speed may be right.
    """

    def __init__(
        self,
        follower: PointFollower,
        pictures: tuple[SmallPicture, SmallPicture],
        height_m: float,
        expectation: MotionFilter,
        dt_s: float,
        settings: MotionSettings,
        stillness: Stillness,
        known: bool,
    ) -> None:
        mean, covariance, by_state = expectation.expect(dt_s)
        self.flow: Flow = follower.follow(*pictures, mean)
        flow, road = self.flow, self.flow.road
        self.filter = expectation
        self.solution: Solution | None = None
        self.evidence = 0.0
        self.points = (0, 0)
        self.doubtful = True
        if road.sum() < settings.fewest_points:
            return
        standing_m, in_place = settings.standing_mps * dt_s, road & follower.in_place(flow)
        solution = _solution(flow, in_place, height_m, (mean, covariance), standing_m, settings)
        if not np.isfinite(solution.unknowns).all():
            return
        inlying = solution.inlying > INLYING
        self.points = int((inlying & road).sum()), int((inlying & ~road).sum())
        others = inlying[~road] if (~road).sum() >= settings.fewest_points else inlying
        road_part = inlying[road].mean()
        self.doubtful = bool(
            (others.mean() < settings.sure_part and road_part < settings.sure_part)
            or (road_part < settings.least_road_part and not _beyond_own_car(flow, inlying, others, settings))
        )
        if solution.unknowns[TRAVEL] < standing_m:
            # If we stand, the whole picture does. Reflections and lines along the road alone seem to stand,
            # too.
            few = inlying.sum() < settings.standing_points
            fast_back = solution.unknowns[TRAVEL] < -standing_m
            self.doubtful = bool(
                fast_back or few or min(inlying.mean(), inlying[road].mean()) < settings.standing_part
            )
            if not self.doubtful and abs(solution.unknowns[TRAVEL]) < settings.still_mps * dt_s:
                # A few points on a dashboard may stand while everything beyond moves.
                self.doubtful = follower.picture_moves or not stillness.lasts(pictures[1], mean)
            if self.doubtful:
                return
        if self.points[0] < settings.fewest_points or inlying.mean() < settings.fewest_inlying:
            return
        shift_m = abs(float(solution.unknowns[TRAVEL] - mean[TRAVEL]))
        sigma_m = math.sqrt(covariance[TRAVEL, TRAVEL])
        if shift_m > settings.jump_sigmas * sigma_m + settings.jump_mps * dt_s:
            return
        if known and not self.doubtful and expectation.allow_nod(solution, mean, covariance):
            mean, covariance, by_state = expectation.expect(dt_s)
            solution = _solution(flow, in_place, height_m, (mean, covariance), standing_m, settings)
        self.evidence, self.solution = solution.evidence, solution
        expectation.correct(solution, mean, covariance, by_state)


def _solution(
    flow: Flow,
    in_place: NDArray[np.bool_],
    height_m: float,
    expected: tuple[FloatArray, FloatArray],
    standing_m: float,
    settings: MotionSettings,
) -> Solution:
    """Solve for the motion. If the result is that we stand, but with too few inliers, use moving points only.

    A bonnet that mirrors the world may half stand, without having been learned as our own car. More points
    may agree there than on the road, and near points count most. In that case they are treated as outliers.

    Args:
        flow: N points.
        in_place: (N,) points that are taken for road and did not move.
        height_m: height of the camera.
        expected: mean (8,) and covariance (8, 8) of the unknowns.
        standing_m: a travel below this counts as standing.
        settings: see `MotionSettings`.
    """
    mean, covariance = expected
    solution = solve(*flow[1:], height_m, mean, covariance, settings.scales)
    if not solution.unknowns[TRAVEL] < standing_m <= mean[TRAVEL]:
        return solution
    inlying = solution.inlying > INLYING
    stands = min(inlying.mean(), inlying[flow.road].mean()) >= settings.standing_part
    if stands or (flow.road & ~in_place).sum() < settings.fewest_points:
        return solution
    moved = solve(*flow.of(~in_place)[1:], height_m, mean, covariance, settings.scales)
    if not moved.unknowns[TRAVEL] >= standing_m:
        return solution
    astray = np.zeros(len(in_place))
    astray[~in_place] = moved.inlying
    return moved._replace(inlying=astray)


def _beyond_own_car(
    flow: Flow, inlying: NDArray[np.bool_], others: NDArray[np.bool_], settings: MotionSettings
) -> bool:
    """Whether the motion fits the points off the road, and those on it beyond a possible own car."""
    if others.mean() < settings.standing_part:
        return False
    far = (flow.road & (flow.inverse_depth < 1 / reach_m) for reach_m in OWN_CAR_REACHES_M)
    return any(
        inlying[road].sum() >= settings.fewest_points and inlying[road].mean() >= settings.standing_part
        for road in far
    )
