"""Own motion from picture to picture: points are tracked, the motion is solved for, and filtered."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fcw.box import Box
from fcw.camera.calibration import Calibration, Gaussian
from fcw.motion.attempt import INLYING, Attempt
from fcw.motion.filter import MOUNT_PITCH, MOUNT_ROLL, MOUNT_YAW, SPEED, SPRING, MotionFilter
from fcw.motion.flow.pacing import Pacing
from fcw.motion.flow.points import PointFollower, SmallPicture
from fcw.motion.flow.road_plane import RoadPair, RoadPlane
from fcw.motion.flow.stillness import Stillness
from fcw.motion.settings import MotionSettings
from fcw.motion.solver import PITCH_TURN, TRAVEL, YAW_TURN, Solution, solve
from fcw.motion.state import Mount, OwnMotion, SpeedSource
from fcw.motion.travel.looks import Told, TravelLooks, contradict
from fcw.motion.view import RoadView

ANY_SPEED_MPS = 15.0
"""Prior of the own speed while driving: mean and 1-sigma."""
POINTS_TELL_S = 1.0
"""Once points have given a speed for this long, the road as a whole is no longer used. Until then it takes
precedence if it contradicts them, because a few points may agree by chance on a speed that is too low."""
CONTRADICTING_SIGMAS = 2.0
"""Two speeds contradict each other if they differ by more than this many sigmas of the road's."""
HARDEST_BRAKING_MPS2, HARDEST_SPEEDING_UP_MPS2 = 10.0, 6.0
"""Limits of a car on a dry road. A speed from points is rejected if it is lower than braking from the last
known speed allows; one from the road as a whole, if it is higher than accelerating from the last speed by
points allows."""
CHANGED_FROM_SIGMAS = 3.0
"""Margin of these limits, in sigmas of the last known speed."""


class MotionEstimator:
    """Estimates own motion and mount of one drive.

    Args:
        calibration: calibration for the image size.
        settings: see `MotionSettings`.
    """

    def __init__(self, calibration: Calibration, settings: MotionSettings | None = None) -> None:
        self._settings = settings or MotionSettings()
        self._calibration, self._camera = calibration, calibration.camera
        self._follower = PointFollower(self._camera, calibration.image_size.width, self._settings)
        self._filter = MotionFilter(self._settings)
        self._stillness = Stillness(self._follower)
        self._plane = RoadPlane()
        self._pacing = Pacing()
        self._last: SmallPicture | None = None
        self._known = False
        self._looks = TravelLooks(calibration) if self._settings.asks_direction else None
        self._known_s = 0.0
        self._misled = False
        """Whether the steps from picture to picture have led to wrong angles of the mount."""
        self._found_s = self._doubtful_s = 0.0
        """How long the pictures have supported the speed that was found last, and how long they doubt it."""
        self._mount = self._filter.mount()
        self._turn = self._filter.yaw_rate()
        """Mean and variance of the yaw rate. It is kept out of the filter while no speed is known: with it,
        more wrong speeds were found on one of ten clips, and on another the horizon became wrong."""
        self._since_search_s = float("inf")
        self._slowest_mps, self._fastest_mps = -math.inf, math.inf
        """The speeds that we may have braked down to since a speed was last known, and accelerated to since
        points last gave one."""
        self.points = (0, 0)

    def update(self, time_ns: int, image: NDArray[np.uint8], boxes: Sequence[Box] = ()) -> OwnMotion:
        """Update with a picture.

        Args:
            time_ns: time of the picture; must increase.
            image: (height, width, 3) BGR.
            boxes: boxes of other vehicles in it.
        """
        settings, last = self._settings, self._last
        if self._looks is not None:
            told = self._looks.update(time_ns / 1e9, image, boxes)
            if told is not None:
                self._take_look(told)
        grey = self._follower.small(image)
        is_new = self._pacing.is_new(time_ns / 1e9, grey)
        taken_ns = round(self._pacing.taken_s * 1e9)
        dt_s = 0.0 if last is None else (taken_ns - last.time_ns) / 1e9
        if last is not None and dt_s < (settings.shortest_step_s if is_new else settings.repeated_s):
            return self.state
        now = self._follower.picture(taken_ns, grey, boxes)
        self._last = now
        if last is None:
            self._stillness.keep(now, moves=False)
            return self.state
        self._since_search_s += dt_s
        before = self._filter.copy()
        self._filter.predict(dt_s)
        self._turn = self._turn[0], self._turn[1] + settings.yaw_acceleration**2 * dt_s
        if not self._known and not self._misled:
            self._mount = self._filter.mount()
        if dt_s <= settings.longest_step_s:
            self._follower.find_own_car(last, now)
            self._take_step((last, now), dt_s, before)
        else:
            self._plane.forget()
        self._known &= (
            self._filter.sigma(SPEED)
            < settings.lost_part * abs(float(self._filter.x[SPEED])) + settings.lost_mps
        )
        self._judge_mount()
        state = self.state
        self._stillness.keep(now, (state.speed_mps or 0.0) > settings.still_mps)
        self._slowest_mps -= HARDEST_BRAKING_MPS2 * dt_s
        self._fastest_mps += HARDEST_SPEEDING_UP_MPS2 * dt_s
        if state.speed_mps is not None and not (self._known and self._doubtful_s):
            assert state.speed_sigma_mps is not None
            self._slowest_mps = state.speed_mps - CHANGED_FROM_SIGMAS * state.speed_sigma_mps
            if self._speed_by_points is not None and self._found_s >= POINTS_TELL_S:
                self._fastest_mps = state.speed_mps + CHANGED_FROM_SIGMAS * state.speed_sigma_mps
        return state

    def after_cut(self) -> "MotionEstimator":
        """A new estimator for the pictures after a cut. It keeps only the estimate of the mount."""
        other = MotionEstimator(self._calibration, self._settings)
        other._filter.take_mount(self._mount)
        other._mount = self._mount
        return other

    def _take_look(self, told: Told) -> None:
        """Use the direction of travel seen by a look, which takes precedence over the steps' pitch and yaw.

        The steps from picture to picture are more exact, but only if the road is a plane and their speed is
        right. Once they contradict a look, their angles are not used any more in this drive.
        """
        is_taught = self._known_s >= self._settings.mount_after_s
        if not is_taught:
            self._filter.take_mount(self._mount)
        pitch_rad = Gaussian(told.pitch_rad.value - self._camera.pitch_rad, told.pitch_rad.sigma)
        angles = [(MOUNT_PITCH, pitch_rad)]
        if told.yaw_rad is not None:
            angles.append((MOUNT_YAW, told.yaw_rad))
        for place, angle_rad in angles:
            believed = Gaussian(float(self._filter.x[place]), self._filter.sigma(place))
            if contradict(believed, angle_rad):
                self._misled |= is_taught
                self._filter.take_angle(place, angle_rad)
            elif told.is_whole:
                self._filter.measure_angle(place, angle_rad)
        self._mount = self._filter.mount()

    def _judge_mount(self) -> None:
        """Keep the filter's mount if the speed has been known for long enough; otherwise undo its changes."""
        if not self._known:
            self._known_s = 0.0
        if self._known_s >= self._settings.mount_after_s and not self._misled:
            self._mount = self._filter.mount()
        elif not self._known or self._misled:
            self._filter.take_mount(self._mount)

    @property
    def state(self) -> OwnMotion:
        """The current estimate."""
        settings, mount = self._settings, self._believed_mount
        speed = by_points = self._speed_by_points
        if speed is None or self._found_s < POINTS_TELL_S:
            by_road = self._speed_by_road
            if by_road is not None and (speed is None or _contradicts(by_road, speed)):
                speed = by_road
        turn_radps, turn_sigma_radps = self._turn[0], math.sqrt(self._turn[1])
        turn_known = by_points is not None or turn_sigma_radps < settings.known_turn_radps
        return OwnMotion(
            speed_mps=None if speed is None else speed.value,
            speed_sigma_mps=None if speed is None else speed.sigma,
            speed_source=SpeedSource.UNKNOWN if speed is None else SpeedSource.PICTURE,
            yaw_rate_radps=turn_radps if turn_known else None,
            yaw_rate_sigma_radps=turn_sigma_radps if turn_known else None,
            mount=mount,
            picture_speed_mps=None if by_points is None else by_points.value,
        )

    @property
    def _speed_by_road(self) -> Gaussian | None:
        """The speed estimated from the road as a whole; None if we cannot have accelerated to it."""
        speed = self._plane.speed_mps(self._camera.height_m, self._believed_mount.pitch_sigma_rad)
        if speed is None or speed.value - CHANGED_FROM_SIGMAS * speed.sigma > self._fastest_mps:
            return None
        return speed

    @property
    def _speed_by_points(self) -> Gaussian | None:
        settings, sigma_mps = self._settings, self._filter.sigma(SPEED)
        if self._filter.x[SPEED] < -settings.still_mps:
            return None  # we drive backwards, which must not be taken for standing
        speed_mps = max(float(self._filter.x[SPEED]), 0.0)
        is_sure = sigma_mps < max(settings.known_part * speed_mps, settings.known_mps)
        known = self._known and is_sure and self._found_s >= settings.confirmed_s
        return Gaussian(speed_mps, sigma_mps) if known else None

    @property
    def _believed_mount(self) -> Mount:
        (pitch_rad, yaw_rad, roll_rad), covariance = self._mount
        sigmas_rad = [math.sqrt(max(variance, 0.0)) for variance in covariance.diagonal().tolist()]
        return Mount(
            pitch_rad=self._camera.pitch_rad + float(pitch_rad),
            yaw_rad=float(yaw_rad),
            roll_rad=float(roll_rad),
            pitch_sigma_rad=sigmas_rad[0],
            yaw_sigma_rad=sigmas_rad[1],
            roll_sigma_rad=math.hypot(sigmas_rad[2], self._settings.verge_roll_sigma_rad),
        )

    def body_pitch(self, time_ns: int) -> Gaussian | None:
        """Pitch of the body on its springs at a time, in rad, positive nose down.

        None while the speed is not known from points, because the causes of a pitch cannot be told apart
        then.
        """
        if not self._known or self._last is None:
            return None
        settings, age_s = self._settings, max((time_ns - self._last.time_ns) / 1e9, 0.0)
        lasting = math.exp(-age_s / settings.fast_pitch_s)
        since_rad = settings.fast_pitch_sigma_rad * math.sqrt(1 - lasting**2)
        sigma_rad = math.hypot(self._filter.sigma(SPRING) * lasting, since_rad)
        return Gaussian(float(self._filter.x[SPRING]) * lasting, sigma_rad)

    @property
    def picture(self) -> SmallPicture | None:
        """The latest picture that was used."""
        return self._last

    @property
    def view(self) -> RoadView:
        """The current estimate of where the road is in that picture."""
        x = self._filter.x
        return self._follower.view.turned(float(x[MOUNT_PITCH] + x[SPRING]), float(x[MOUNT_ROLL]))

    def _take_step(
        self, pictures: tuple[SmallPicture, SmallPicture], dt_s: float, before: MotionFilter
    ) -> None:
        """Update with two pictures; in doubt, look for another speed that explains them better."""
        settings = self._settings
        best = None
        needed = settings.first_evidence
        if self._known:
            best = self._attempt(pictures, dt_s, self._filter.copy(), known=True)
            needed = best.evidence + settings.other_evidence
            doubtful = best.solution is None or best.doubtful
            self._doubtful_s = self._doubtful_s + dt_s if doubtful else 0.0
        if (
            self._doubtful_s >= settings.confirmed_s and self._since_search_s >= settings.search_s
            if self._known
            else self._since_search_s >= settings.lost_search_s
        ):
            self._since_search_s = 0.0
            if self._known_s < settings.mount_after_s:
                before.take_mount(self._mount)
            found = self._search(pictures, dt_s, before, needed)
            if found is not None:
                best = found
                self._known_s, self._found_s, self._doubtful_s = 0.0, -dt_s, 0.0
        if best is None or best.solution is None:
            self._look_at_road(pictures, self._take_turn(pictures, dt_s), dt_s)
            return
        self._filter, self._known = best.filter, True
        self._found_s += dt_s
        if self._found_s < POINTS_TELL_S:
            self._look_at_road(pictures, best.solution, dt_s)
        else:
            self._plane.forget()
        self._turn = self._filter.yaw_rate()
        self.points = best.points
        if float(self._filter.x[SPEED]) > settings.learns_above_mps:
            self._known_s += dt_s
            self._follower.learn(best.flow.cells, best.solution.inlying, dt_s)

    def _search(
        self,
        pictures: tuple[SmallPicture, SmallPicture],
        dt_s: float,
        before: MotionFilter,
        needed: float,
    ) -> Attempt | None:
        """Try several speeds, and find the one that explains two pictures best.

        Args:
            pictures: the two pictures.
            dt_s: time between them.
            before: the filter's state at the first picture.
            needed: the evidence that the best one must exceed.

        Returns:
            None if no speed does. Also None if nearly every speed fits, because noise fits any speed.
        """
        settings, best, agreeing = self._settings, None, 0
        for speed_mps in settings.supposed_mps:
            supposed = before.copy()
            supposed.forget_speed(speed_mps, settings.supposed_sigma_mps)
            supposed.predict(dt_s)
            other = self._attempt(pictures, dt_s, supposed, known=False)
            if other.solution is None:
                continue
            agreeing += 1
            reached = other.solution.unknowns[TRAVEL] >= self._slowest_mps * dt_s
            if reached and not other.doubtful and other.evidence > needed:
                best, needed = other, other.evidence
        return best if agreeing < len(settings.supposed_mps) - 1 else None

    def _look_at_road(
        self, pictures: tuple[SmallPicture, SmallPicture], solution: Solution | None, dt_s: float
    ) -> None:
        """Collect evidence on the speed from the road as a whole; `solution` tells how the camera turned.

        The result is kept apart. If it is wrong, points and mount are not affected.
        """
        if not self._settings.asks_road:
            return
        pitch_rad, yaw_rad, roll_rad = (float(angle) for angle in self._mount[0])
        turns = np.zeros(2) if solution is None else solution.unknowns[[PITCH_TURN, YAW_TURN]]
        down_rad, left_rad = (-float(turn) for turn in turns)
        view = self._follower.view
        views = view.turned(pitch_rad, roll_rad), view.turned(pitch_rad + down_rad, roll_rad)
        greys = pictures[0].grey, pictures[1].grey
        boxes = self._follower.small_boxes(pictures[1])
        self._plane.look(RoadPair(greys, views, yaw_rad, left_rad, boxes, dt_s))

    def _take_turn(self, pictures: tuple[SmallPicture, SmallPicture], dt_s: float) -> Solution | None:
        """Estimate the yaw rate from two pictures without knowing the speed.

        A road without texture does not show the speed, but everything beside and above it still shows the
        rotation.

        Returns:
            The solution from points beside the road; None if there are too few.
        """
        settings, filtered = self._settings, self._filter.copy()
        filtered.take_yaw_rate(self._turn)
        filtered.forget_speed(ANY_SPEED_MPS, ANY_SPEED_MPS)
        mean, covariance, by_state = filtered.expect(dt_s)
        flow = self._follower.follow(*pictures, mean)
        others = flow.of(~flow.road)
        if len(others.cells) < settings.turn_points:
            return None
        solution = solve(*others[1:], self._camera.height_m, mean, covariance, settings.scales)
        inlying = solution.inlying > INLYING
        few = inlying.sum() < settings.turn_points or inlying.mean() < settings.standing_part
        if few or not np.isfinite(solution.unknowns).all():
            return None
        filtered.correct(solution, mean, covariance, by_state)
        self._turn = filtered.yaw_rate()
        return solution

    def _attempt(
        self, pictures: tuple[SmallPicture, SmallPicture], dt_s: float, expectation: MotionFilter, known: bool
    ) -> Attempt:
        height_m, settings, stillness = self._camera.height_m, self._settings, self._stillness
        return Attempt(self._follower, pictures, height_m, expectation, dt_s, settings, stillness, known)


def _contradicts(by_road: Gaussian, by_points: Gaussian) -> bool:
    return abs(by_points.value - by_road.value) > CONTRADICTING_SIGMAS * by_road.sigma
