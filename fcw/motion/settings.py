"""Settings of own motion: physical quantities with their sources, and what bounds its cost."""

import math
from dataclasses import dataclass

from fcw.motion.bend.turn import LARGEST_SIGMA_RADPS


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSettings:
    """Settings of the estimator of own motion.

    `kitti-odometry-03` was at hand when the numbers were chosen; nothing was fitted to it.

    Attributes:
        working_width_px: pictures are reduced by a whole factor to about this width.
        cell_px: width and height of a cell of the small picture, in which one corner is looked for.
        road_points: the largest number of points on the road; it bounds the cost.
        other_points: the largest number of points off the road; it bounds the cost.
        faintest: corners whose grey values change by less than this (mean square) may be noise of about 2
            grey values.
        least_roundness: a corner with a smaller ratio of eigenvalues is an edge, and not used. Edges along
            the road look the same wherever we are. Points tracked on them seem to stand still, which would
            make us seem slow.
        largest_difference: the largest mean difference between a point's window and the window it was tracked
            to, as a fraction of the contrast. If it is larger, tracking failed.
        window_px: side of the window around a tracked point.
        levels: levels of the pyramid above the small picture. A prediction may be off by about 2^levels times
            half the window.
        shortest_step_s: pictures closer in time than this to the last one used are skipped. At 48 to 60
            frames per second every fourth is used: if they were made from 25 or 30, every second one may be a
            blend.
        longest_step_s: pictures farther apart in time than this share too little.
        repeated_s: a picture equal to the last one is skipped as repeated (the video was made from one with a
            lower frame rate) for up to this time; after that, we stand.
        place_sigma_px: 1-sigma of a tracked point in the small picture, including the error that it shares
            with its neighbours.
        scales: scales of the points' robust weights, in sigmas, one for each step of the solver.
        road_half_width_m: the road is assumed flat this far to either side; kerbs and ditches begin beyond.
        road_near_m: nearest distance at which points on the road are used.
        road_far_m: farthest distance at which they are used. Beyond it, one pixel is more than 5 % of the
            distance.
        largest_growth: a point that grows by more than this between two pictures cannot be tracked, as its
            window in the first picture is too coarse.
        unevenness: 1-sigma of the road's inverse depth, as a fraction of it: 3 cm of unevenness below a
            camera 1.5 m high is 2 %.
        far_inverse_depth: guess of the inverse depth of a point that is not on the road, 1/m.
        far_inverse_depth_sigma: 1-sigma of `far_inverse_depth`.
        acceleration_sigma_mps2: 1-sigma of the own acceleration (Singer 1970).
        acceleration_s: correlation time of the own acceleration.
        yaw_acceleration: random walk of the yaw rate, rad/s in the root of a second.
        calibration_pitch_sigma_rad: 1-sigma of the pitch of calibrations in use: people park on ramps and
            load the boot.
        calibration_yaw_sigma_rad: 1-sigma of their yaw: cameras are mounted by eye.
        calibration_roll_sigma_rad: 1-sigma of their roll.
        mount_drift_rad_per_sqrt_s: random walk of the angles of the mount, due to load and temperature.
        fast_pitch_sigma_rad: 1-sigma of the pitch of the body on its springs.
        fast_pitch_s: correlation time of that pitch.
        slope_turn_rad: 1-sigma of the change of pitch between two pictures that is due to the road's slope.
        roll_turn_sigma_radps: 1-sigma of the roll rate of the body.
        heave_mps: 1-sigma of the camera's vertical speed, which moves the focus of expansion.
        slip_mps: 1-sigma of the camera's lateral speed.
        axle_m: distance of the camera ahead of the rear axle, reduced for the slip of the tyres. Only the
            rear axle moves in the direction in which the vehicle points.
        axle_sigma_m: 1-sigma of `axle_m`.
        travel_part: 1-sigma of the travel between two pictures, as a fraction of it, because the road under
            the points is not exactly the plane below the wheels.
        road_roll_sigma_rad: 1-sigma of the roll of the road ahead relative to the plane below the wheels.
        road_pitch_sigma_rad: 1-sigma of its pitch relative to that plane.
        verge_roll_sigma_rad: 1-sigma of a constant error of the roll, because points on raised kerbs and
            sloping verges are used with those on the road. On 27 clips, most of them from level cameras, the
            roll ended at -5 to 8 degrees, with a root mean square of 2.2.
        known_part: the speed is known while its 1-sigma is below this fraction of it, or below `known_mps`.
        known_mps: see `known_part`.
        lost_part: the speed is lost, and searched for again, when its 1-sigma is above this fraction of it
            and above `lost_mps`.
        lost_mps: see `lost_part`.
        fewest_points: least number of inliers on the road for a motion between two pictures.
        fewest_inlying: least fraction of inliers among all points for a motion between two pictures.
        sure_part: another speed may be right if the fraction of inliers is smaller than this, both on the
            road and elsewhere.
        least_road_part: another speed may also be right if the fraction of inliers on the road is smaller
            than this.
        turn_points: least number of inliers off the road for a yaw rate between two pictures.
        known_turn_radps: the yaw rate is known while its 1-sigma is below this.
        standing_mps: a speed below this is accepted only if the picture agrees as a whole: `standing_part` of
            all points and of the road's, and at least `standing_points`. In the dark, there is often little
            more than lamps and reflections on the windscreen.
        standing_part: see `standing_mps`.
        standing_points: see `standing_mps`.
        still_mps: below this speed we stand, and the picture must not move.
        search_s: shortest time between two searches for another speed, as a search costs as much as ten
            pictures.
        lost_search_s: the same while the speed is unknown.
        supposed_mps: the speeds that a search tries.
        supposed_sigma_mps: 1-sigma of each of them.
        first_evidence: log odds against chance from which a first speed is accepted.
        other_evidence: log odds against the present speed from which another one is accepted.
        jump_sigmas: a step that would change the speed by more than this many of its sigmas, and by more than
            `jump_mps`, is rejected: a few points of a plain road, or of a shadow, may agree by chance. Chosen
            on strangers' clips (docs/figures/own-motion.md).
        jump_mps: see `jump_sigmas`.
        confirmed_s: another speed is searched for once the pictures have doubted the present one for this
            long. A new speed is known once they have supported it for as long.
        grey_sigma: 1-sigma of a grey value, due to noise, compression and other objects in the window. It
            determines how well a point is located, along an edge and across it.
        first_trust: initial trust in a cell of the picture. Trust is the fraction of the time in which the
            cell's points are inliers.
        least_trust: a cell with less trust is not used until its trust has recovered.
        trust_s: time constant with which trust is updated.
        trust_lasts_s: time constant with which trust returns to `first_trust`.
        learns_above_mps: trust and mount are learned only above this speed; at standstill nothing moves.
        asks_direction: whether the direction of travel is looked for (`fcw.motion.travel`). If not, the mount
            is learned only from the motion between pictures.
        asks_road: whether the road as a whole is used for the speed if its points do not give one.
        mount_after_s: the mount is learned only once the speed has been known for this long. If it is lost
            before, what was learned is discarded: a wrong speed, found by chance, turns the mount by degrees.
    """

    working_width_px: int = 640
    cell_px: tuple[int, int] = (24, 12)
    road_points: int = 90
    other_points: int = 60
    faintest: float = 8.0
    least_roundness: float = 0.05
    largest_difference: float = 0.7
    window_px: int = 9
    levels: int = 2
    shortest_step_s: float = 0.064
    longest_step_s: float = 0.5
    repeated_s: float = 0.3
    place_sigma_px: float = 0.3
    scales: tuple[float, ...] = (16.0, 8.0, 4.0, 2.5, 2.5, 2.5)
    road_half_width_m: float = 3.5
    road_near_m: float = 4.0
    road_far_m: float = 32.0
    largest_growth: float = 1.7
    unevenness: float = 0.03
    far_inverse_depth: float = 0.03
    far_inverse_depth_sigma: float = 0.05
    acceleration_sigma_mps2: float = 2.5
    acceleration_s: float = 2.0
    yaw_acceleration: float = 0.15
    calibration_pitch_sigma_rad: float = math.radians(0.7)
    calibration_yaw_sigma_rad: float = math.radians(2.0)
    calibration_roll_sigma_rad: float = math.radians(1.0)
    mount_drift_rad_per_sqrt_s: float = math.radians(0.005)
    fast_pitch_sigma_rad: float = math.radians(0.25)
    fast_pitch_s: float = 0.5
    slope_turn_rad: float = math.radians(0.05)
    roll_turn_sigma_radps: float = math.radians(2.0)
    heave_mps: float = 0.06
    slip_mps: float = 0.08
    axle_m: float = 1.3
    axle_sigma_m: float = 0.5
    travel_part: float = 0.03
    road_roll_sigma_rad: float = math.radians(0.5)
    road_pitch_sigma_rad: float = math.radians(0.25)
    verge_roll_sigma_rad: float = math.radians(2.5)
    known_part: float = 0.15
    known_mps: float = 0.3
    lost_part: float = 0.3
    lost_mps: float = 1.0
    fewest_points: int = 8
    fewest_inlying: float = 0.25
    sure_part: float = 0.5
    least_road_part: float = 0.4
    turn_points: int = 15
    known_turn_radps: float = LARGEST_SIGMA_RADPS
    standing_mps: float = 2.0
    still_mps: float = 0.5
    standing_part: float = 0.75
    standing_points: int = 50
    search_s: float = 1.0
    lost_search_s: float = 0.35
    supposed_mps: tuple[float, ...] = (0.0, 4.0, 8.0, 12.0, 17.0, 22.0, 28.0, 35.0, 43.0)
    supposed_sigma_mps: float = 2.0
    first_evidence: float = 60.0
    other_evidence: float = 50.0
    jump_sigmas: float = 3.0
    jump_mps: float = 0.3
    confirmed_s: float = 0.14
    grey_sigma: float = 5.0
    first_trust: float = 0.7
    least_trust: float = 0.2
    trust_s: float = 3.0
    trust_lasts_s: float = 60.0
    learns_above_mps: float = 3.0
    asks_direction: bool = True
    asks_road: bool = True
    mount_after_s: float = 1.0
