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
        road_points: at most so many points of the road are followed,
        other_points: and so many others: they bound the cost.
        faintest: corners whose grey values change by less in the mean square are noise (of 2 grey values).
        least_roundness: what is less round is an edge. Edges along the road look the same wherever we are:
            what little there is to follow stays in the picture, and would say that we are slow.
        largest_difference: mean difference between a window and where it went, in parts of its contrast: with
            more it is another place.
        window_px: side of the window that is followed.
        levels: of the pyramid above the small picture: what was predicted may be off by about 2^levels times
            half the window.
        shortest_step_s: pictures nearer in time than this to the last one used are left out.
        longest_step_s: pictures farther apart show too little of the same.
        repeated_s: a picture like the last one is a repeated one, of a video that was made from one of fewer
            pictures, and is left out; after so long we stand.
        place_sigma_px: of a followed point in the small picture, with what neighbours have in common.
        scales: of the weights of points, in sigmas, one a step of the solver.
        road_half_width_m: the road is flat this far to either side; kerbs and ditches begin beyond.
        road_near_m: the nearest road that is looked at.
        road_far_m: the farthest: beyond it a pixel is more than 5 % of the distance.
        largest_growth: what grows by more between two pictures is too coarse in the first to be found again.
        unevenness: of the road, as a part of the inverse depth: 3 cm below a camera 1.5 m high are 2 %.
        far_inverse_depth: 1/m of what is not road, the guess,
        far_inverse_depth_sigma: and its 1-sigma.
        acceleration_sigma_mps2: own acceleration (Singer 1970), and for how long.
        acceleration_s: see above.
        yaw_acceleration: of the yaw rate, rad/s in the root of a second.
        calibration_pitch_sigma_rad: how far calibrations are off in use: people park on ramps, load the boot.
        calibration_yaw_sigma_rad: cameras are mounted by eye.
        calibration_roll_sigma_rad: likewise.
        mount_drift_rad_per_sqrt_s: of the mount, by load and warmth.
        fast_pitch_sigma_rad: of the body on its springs, and for how long.
        fast_pitch_s: see above.
        slope_turn_rad: pitch turn between two pictures that is the road's own.
        roll_turn_sigma_radps: rolling of the body.
        heave_mps: 1-sigma of the camera's speed up and down, which moves the focus of expansion.
        slip_mps: 1-sigma of its speed sideways.
        axle_m: the camera is so far ahead of the rear axle, which alone goes where the vehicle points; less
            what tyres slip,
        axle_sigma_m: and its 1-sigma.
        travel_part: 1-sigma of the travel of a step, as a part of it: the road under the points is not the
            plane below the wheels.
        road_roll_sigma_rad: of the road ahead against that below the wheels,
        road_pitch_sigma_rad: likewise.
        verge_roll_sigma_rad: of the roll for as long as a drive lasts: kerbs stand and verges slope, and are
            followed with the road. On 27 clips, most of them of cameras that look level, it ended at -5 to 8
            degrees, 2.2 in the root mean square.
        known_part: the speed is known while its 1-sigma is less than this part of it,
        known_mps: or less than this.
        lost_part: it is searched for anew when its 1-sigma is more than this part of it,
        lost_mps: and this.
        fewest_points: with fewer inlying points of the road two pictures say nothing,
        fewest_inlying: and with a smaller part of all points inlying.
        sure_part: with a smaller part of the road's points and of the others' inlying, another speed may be
            true.
        least_road_part: or with a smaller part of the road's.
        turn_points: with fewer of the others inlying two pictures do not say how we turn,
        known_turn_radps: which is known while its 1-sigma is less than this;
        standing_mps: below this speed a whole picture must stand:
        standing_part: so much of its points,
        standing_points: and so many: in the dark there is little but lamps and what the windscreen reflects.
        still_mps: below this speed we stand, and the picture must not move.
        search_s: so often at most another one is looked for: a search takes as long as ten pictures.
        lost_search_s: and so often where the speed is unknown.
        supposed_mps: speeds that are tried,
        supposed_sigma_mps: and the 1-sigma of each.
        first_evidence: a speed is believed that is likelier than chance by this logarithm of odds.
        other_evidence: and another than the present one that is likelier by this.
        jump_sigmas: what would move the speed by more of its sigmas than this,
        jump_mps: and this, is misread: a few points of a plain road, or of a shadow, agree by chance.
            Chosen on strangers' clips (docs/figures/own-motion.md).
        confirmed_s: another speed is looked for once pictures have doubted the present one for so long; what
            was found is known once they have told it for as long.
        grey_sigma: of a grey value, by noise, compression and what the window sees from elsewhere: it says
            how well a place is known, along an edge and across it.
        first_trust: in a cell of the picture of which nothing is known: part of the time that its points keep
            to the motion.
        least_trust: with less a cell is left alone; its trust comes back,
        trust_s: time in which trust follows what is seen.
        trust_lasts_s: time in which it is forgotten.
        learns_above_mps: of trust and of the mount; what stands proves nothing.
        asks_direction: whether it is looked for where we drive to; else steps alone teach the mount.
        asks_road: whether the road as a whole is asked for the speed where its points do not tell it.
        mount_after_s: what pictures tell of the mount counts once they have told one speed for so long, and
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
    shortest_step_s: float = 0.045
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
