"""What own motion goes by: physical beliefs with their sources, and what bounds its cost."""

import math
from dataclasses import dataclass

from fcw.motion.bend.turn import LARGEST_SIGMA_RADPS


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSettings:
    """Beliefs of the estimator of own motion.

    `kitti-odometry-03` was at hand when the numbers were chosen; nothing was fitted to it.

    Attributes:
        working_width_px: pictures are made smaller by a whole factor to about this width.
        cell_px: one corner is looked for in each cell of the small picture.
        road_points: the most points of the road that are followed; it bounds the cost.
        other_points: the most other points that are followed, likewise.
        faintest: corners whose grey values change by less than this (mean square) are noise of about 2 grey
            values.
        least_roundness: a corner that is less round is an edge, and left out. Edges along the road look the
            same wherever we are: what little can be followed on them stays in the picture, and would say that
            we are slow.
        largest_difference: the largest mean difference between a window and where it went, as a part of its
            contrast. Beyond, it is another place.
        window_px: side of the window that is followed.
        levels: levels of the pyramid above the small picture. A prediction may be off by about 2^levels times
            half the window.
        shortest_step_s: pictures closer in time than this to the last one used are left out. Of 48 to 60 a
            second every fourth is used: where they were made of 25 or 30, every second one may be a blend.
        longest_step_s: pictures farther apart than this show too little of the same.
        repeated_s: a picture like the last one is left out as repeated (the video was made from one with
            fewer pictures) for up to this time; after that, we stand.
        place_sigma_px: 1-sigma of a followed point in the small picture, including what it has in common with
            its neighbours.
        scales: scales of the robust weights of points, in sigmas, one for each step of the solver.
        road_half_width_m: the road is taken as flat this far to either side; kerbs and ditches begin beyond.
        road_near_m: nearest distance at which the road is looked at.
        road_far_m: farthest distance, likewise: beyond it one pixel is more than 5 % of the distance.
        largest_growth: a point that grows by more than this between two pictures is too coarse in the first
            one to be found again.
        unevenness: 1-sigma of the road, as a part of the inverse depth: 3 cm below a camera 1.5 m high are 2
            %.
        far_inverse_depth: guess of the inverse depth of a point that is not on the road, 1/m.
        far_inverse_depth_sigma: 1-sigma of `far_inverse_depth`.
        acceleration_sigma_mps2: 1-sigma of the own acceleration (Singer 1970).
        acceleration_s: correlation time of the own acceleration.
        yaw_acceleration: random walk of the yaw rate, rad/s in the root of a second.
        calibration_pitch_sigma_rad: 1-sigma of the pitch of calibrations in use: people park on ramps and
            load the boot.
        calibration_yaw_sigma_rad: 1-sigma of their yaw: cameras are mounted by eye.
        calibration_roll_sigma_rad: 1-sigma of their roll, likewise.
        mount_drift_rad_per_sqrt_s: random walk of the angles of the mount, by load and warmth.
        fast_pitch_sigma_rad: 1-sigma of the pitch of the body on its springs.
        fast_pitch_s: correlation time of that pitch.
        slope_turn_rad: 1-sigma of the turn in pitch between two pictures that is the road's own.
        roll_turn_sigma_radps: 1-sigma of the rolling of the body.
        heave_mps: 1-sigma of the camera's speed up and down, which moves the focus of expansion.
        slip_mps: 1-sigma of the camera's speed sideways.
        axle_m: distance of the camera ahead of the rear axle, less the slip of the tyres. Only the rear axle
            moves in the direction in which the vehicle points.
        axle_sigma_m: 1-sigma of `axle_m`.
        travel_part: 1-sigma of the travel between two pictures, as a part of it: the road under the points is
            not exactly the plane below the wheels.
        road_roll_sigma_rad: 1-sigma of the roll of the road ahead against the plane below the wheels.
        road_pitch_sigma_rad: 1-sigma of its pitch, likewise.
        verge_roll_sigma_rad: 1-sigma of an error of the roll that lasts for the whole drive: kerbs stand and
            verges slope, and are followed with the road. On 27 clips, most of them of cameras that look
            level, the roll ended at -5 to 8 degrees, 2.2 in the root mean square.
        known_part: the speed is known while its 1-sigma is below this part of it, or below `known_mps`.
        known_mps: see `known_part`.
        lost_part: the speed is searched for anew when its 1-sigma is above this part of it and above
            `lost_mps`.
        lost_mps: see `lost_part`.
        fewest_points: two pictures with fewer inlying points of the road than this say nothing.
        fewest_inlying: the smallest part of all points that must be inlying, likewise.
        sure_part: if a smaller part of the road's points and a smaller part of the others is inlying, another
            speed may be true.
        least_road_part: so it may if a smaller part than this of the road's points alone is inlying.
        turn_points: the fewest inlying points off the road from which two pictures tell how we turn.
        known_turn_radps: the turn is known while its 1-sigma is below this.
        standing_mps: a speed below this is believed only if the picture agrees as a whole: `standing_part` of
            its points, of all and of the road's, and at least `standing_points`. In the dark there is little
            but lamps and reflections in the windscreen.
        standing_part: see `standing_mps`.
        standing_points: see `standing_mps`.
        still_mps: below this speed we stand, and the picture must not move.
        search_s: shortest time between two searches for another speed: a search takes as long as ten
            pictures.
        lost_search_s: the same while the speed is unknown.
        supposed_mps: the speeds that a search tries.
        supposed_sigma_mps: 1-sigma of each of them.
        first_evidence: logarithm of the odds against chance from which a speed that was found is believed.
        other_evidence: logarithm of the odds against the present speed from which another one is believed.
        jump_sigmas: pictures that would move the speed by more than this many of its sigmas, and more than
            `jump_mps`, are misread: a few points of a plain road, or of a shadow, agree by chance. Chosen on
            strangers' clips (docs/figures/own-motion.md).
        jump_mps: see `jump_sigmas`.
        confirmed_s: another speed is looked for once pictures have doubted the present one for this long. One
            that was found is known once they have told it for as long.
        grey_sigma: 1-sigma of a grey value, by noise, compression and what the window sees from elsewhere. It
            says how well a place is known, along an edge and across it.
        first_trust: trust in a cell of the picture of which nothing is known yet: the part of the time in
            which its points keep to the motion.
        least_trust: a cell with less trust is left alone, until its trust comes back.
        trust_s: time constant with which trust follows what is seen.
        trust_lasts_s: time constant with which trust is forgotten.
        learns_above_mps: trust and mount are learnt only above this speed; standing proves nothing.
        asks_direction: whether the point that we drive to is looked for; else steps alone teach the mount.
        asks_road: whether the road as a whole is asked for the speed when its points do not tell it.
        mount_after_s: what pictures tell of the mount counts once they have told one speed for this long, and
            is forgotten if they stop before: a speed found by chance turns the mount by degrees.
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
