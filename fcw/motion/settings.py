"""What own motion goes by: physical beliefs with their sources, and what bounds its cost."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionSettings:
    """Beliefs of the estimator of own motion.

    `kitti-odometry-03` was at hand when the numbers were chosen; nothing was fitted to it.

    Attributes:
        working_width_px: pictures are made smaller by a whole factor to about this width.
        cell_px: one corner is looked for in each cell of the small picture.
        road_points: at most so many points of the road are followed,
        other_points: and so many others: they bound the cost.
        faintest: corners whose grey values change by less in the mean square are noise.
        window_px: side of the window that is followed.
        levels: of the pyramid above the small picture: what was predicted may be off by about 2^levels times
            half the window.
        shortest_step_s: pictures nearer in time than this to the last one used are left out.
        longest_step_s: pictures farther apart show too little of the same.
        place_sigma_px: of a followed point in the small picture, with what neighbours have in common.
        scales: of the weights of points, in sigmas, one a step of the solver.
        road_half_width_m: the road is flat this far to either side; kerbs and ditches begin beyond.
        road_near_m: the nearest road that is looked at.
        road_far_m: the farthest: beyond it a pixel is more than 5 % of the distance.
        largest_growth: what grows by more between two pictures cannot be followed.
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
        road_roll_sigma_rad: of the road below against the mean.
        known_part: speed is known while its 1-sigma is less than this part of it,
        known_mps: or less than this.
        fewest_points: with fewer inlying points of the road two pictures say nothing.
        fewest_inlying: and with a smaller part of them.
        first_speeds_mps: tried in turn where the speed is unknown.
    """

    working_width_px: int = 640
    cell_px: tuple[int, int] = (24, 12)
    road_points: int = 90
    other_points: int = 60
    faintest: float = 6.0
    window_px: int = 9
    levels: int = 2
    shortest_step_s: float = 0.045
    longest_step_s: float = 0.5
    place_sigma_px: float = 0.4
    scales: tuple[float, ...] = (16.0, 8.0, 4.0, 2.5, 2.5, 2.5)
    road_half_width_m: float = 3.5
    road_near_m: float = 4.0
    road_far_m: float = 22.0
    largest_growth: float = 1.35
    unevenness: float = 0.03
    far_inverse_depth: float = 0.03
    far_inverse_depth_sigma: float = 0.05
    acceleration_sigma_mps2: float = 1.5
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
    heave_mps: float = 0.08
    slip_mps: float = 0.08
    axle_m: float = 1.3
    axle_sigma_m: float = 0.5
    travel_part: float = 0.03
    road_roll_sigma_rad: float = math.radians(0.5)
    known_part: float = 0.15
    known_mps: float = 0.3
    fewest_points: int = 10
    fewest_inlying: float = 0.25
    first_speeds_mps: tuple[float, ...] = (8.0, 0.0, 15.0, 25.0, 4.0, 35.0)
