"""What two pictures say if the motion was about as expected."""

import math

import numpy as np

from fcw.motion.filter import MotionFilter
from fcw.motion.flow.points import Flow, PointFollower, SmallPicture
from fcw.motion.flow.stillness import Stillness
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import TRAVEL, Solution, solve

INLYING = 0.25
"""A point with this weight keeps to the motion: it is within one scale of the weights."""


class Attempt:
    """What two pictures say if the motion was about as a filter expects it; the filter has taken it.

    Who knows the motion also takes a turn that is beyond what springs mostly do: among speeds that are only
    supposed it would make up for a wrong one.

    Attributes:
        flow: the points that were followed.
        filter: what was expected, corrected by what they say.
        solution: None where they say nothing, or nothing that can be.
        evidence: of the solution.
        points: how many keep to the motion, of the road and of the rest.
        doubtful: whether another speed may be true.
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
        solution = solve(*flow[1:], height_m, mean, covariance, settings.scales)
        if not np.isfinite(solution.unknowns).all():
            return
        inlying = solution.inlying > INLYING
        self.points = int((inlying & road).sum()), int((inlying & ~road).sum())
        others = inlying[~road] if (~road).sum() >= settings.fewest_points else inlying
        self.doubtful = bool(
            (others.mean() < settings.sure_part and inlying[road].mean() < settings.sure_part)
            or inlying[road].mean() < settings.least_road_part
        )
        if solution.unknowns[TRAVEL] < settings.standing_mps * dt_s:
            # A standing picture stands as a whole: reflections and lines along the road seem to as well.
            few = inlying.sum() < settings.standing_points
            fast_back = solution.unknowns[TRAVEL] < -settings.standing_mps * dt_s
            self.doubtful = bool(
                fast_back or few or min(inlying.mean(), inlying[road].mean()) < settings.standing_part
            )
            if not self.doubtful and abs(solution.unknowns[TRAVEL]) < settings.still_mps * dt_s:
                # Few points on a dashboard may stand while all that is farther away goes by.
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
            solution = solve(*flow[1:], height_m, mean, covariance, settings.scales)
        self.evidence, self.solution = solution.evidence, solution
        expectation.correct(solution, mean, covariance, by_state)
