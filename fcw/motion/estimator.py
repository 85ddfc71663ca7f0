"""Own motion from picture to picture: points followed from one to the next, solved, and filtered."""

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
"""Of a vehicle that drives, and the 1-sigma of it."""
POINTS_TELL_S = 1.0
"""Once points have told a speed for so long, the road as a whole is not asked. Until then it goes first where
it contradicts them: of a few points many agree by chance on a speed that is too low."""
CONTRADICTING_SIGMAS = 2.0
"""Of the road's speed."""
HARDEST_BRAKING_MPS2, HARDEST_SPEEDING_UP_MPS2 = 10.0, 6.0
"""Of a car on a dry road: points find no speed that is lower than this allows from one that was known, less
`CHANGED_FROM_SIGMAS`; the road none that is higher than it allows from one that points told for long."""
CHANGED_FROM_SIGMAS = 3.0


class MotionEstimator:
    """Own motion and mount of one drive.

    Args:
        calibration: for the size of the pictures.
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
        """Whether steps taught angles of the mount that are wrong."""
        self._found_s = self._doubtful_s = 0.0
        """For how long pictures have told the speed that was found last, and for how long they doubt it."""
        self._mount = self._filter.mount()
        self._turn = self._filter.yaw_rate()
        """Mean and variance of the yaw rate. The filter does not take it where no speed is known: on one of
        ten clips more speeds were found by chance with it, and on another the horizon became wrong."""
        self._since_search_s = float("inf")
        self._slowest_mps, self._fastest_mps = -math.inf, math.inf
        """What we may have braked down to since a speed was last known, and reached since points told it."""
        self.points = (0, 0)

    def update(self, time_ns: int, image: NDArray[np.uint8], boxes: Sequence[Box] = ()) -> OwnMotion:
        """Take a picture.

        Args:
            time_ns: of it; must rise.
            image: (height, width, 3) BGR.
            boxes: of other vehicles in it.
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
        """A new estimator for what comes after a cut; of all beliefs it keeps that in the mount."""
        other = MotionEstimator(self._calibration, self._settings)
        other._filter.take_mount(self._mount)
        other._mount = self._mount
        return other

    def _take_look(self, told: Told) -> None:
        """What a look tells goes before what steps taught of pitch and yaw, if the two contradict each other.

        Steps tell the angles more exactly, where the road is a plane and their speed is true. Once they
        taught something else than looks see, they are believed no more in this drive.
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
        """What a short acquaintance with the speed taught of the mount is forgotten with it."""
        if not self._known:
            self._known_s = 0.0
        if self._known_s >= self._settings.mount_after_s and not self._misled:
            self._mount = self._filter.mount()
        elif not self._known or self._misled:
            self._filter.take_mount(self._mount)

    @property
    def state(self) -> OwnMotion:
        """What is believed now."""
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
        """What the road as a whole tells, if we can have reached it."""
        speed = self._plane.speed_mps(self._camera.height_m, self._believed_mount.pitch_sigma_rad)
        if speed is None or speed.value - CHANGED_FROM_SIGMAS * speed.sigma > self._fastest_mps:
            return None
        return speed

    @property
    def _speed_by_points(self) -> Gaussian | None:
        settings, sigma_mps = self._settings, self._filter.sigma(SPEED)
        if self._filter.x[SPEED] < -settings.still_mps:
            return None  # backwards: who reverses does not stand
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
        """How much lower the camera looks at a time than its mount does: the body on its springs, in rad.

        None while no points tell the speed: what turns the pictures is not told apart then.
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
        """Where the road is in that picture, as believed now."""
        x = self._filter.x
        return self._follower.view.turned(float(x[MOUNT_PITCH] + x[SPRING]), float(x[MOUNT_ROLL]))

    def _take_step(
        self, pictures: tuple[SmallPicture, SmallPicture], dt_s: float, before: MotionFilter
    ) -> None:
        """Take what two pictures say; in doubt, whether another speed explains them better."""
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
        """The speed that explains two pictures best, of those that are supposed.

        Args:
            pictures: the two.
            dt_s: between them.
            before: what was believed at the first.
            needed: evidence that it must have more of.

        Returns:
            None where none has, or where nearly each has: noise goes wherever it is looked for.
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
        """Gather what the road as a whole tells of the speed; how the camera turned is solved, or unknown.

        Nothing else learns of it: where it is wrong, points and mount go on as without it.
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
        """Take how two pictures turn, at whatever speed.

        A plain road tells no speed. All beside and above it still turns as we do.

        Returns:
            What points beside the road tell; None where they are few.
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
