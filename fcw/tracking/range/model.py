"""What the range filter believes of vehicles, roads and cameras before it has seen any.

Each number is a physical belief with its source. The sequences of KITTI tracking (`fcw evaluate distance`)
were at hand when they were chosen.
"""

import math
from dataclasses import dataclass

from fcw.camera.joint.evidence import CAR_LENGTH_M


@dataclass(frozen=True, slots=True)
class VehicleKind:
    """A kind of vehicle, as one side of it is seen.

    Attributes:
        share: how often it is met.
        width_m: median width of what is seen.
        width_sigma: 1-sigma of the logarithm of the width.
        height_m: median height.
        height_sigma: 1-sigma of the logarithm of the height.
        overhang_m: from what is seen of it nearest to us to where its tyres meet the road.
        length_m: of the side that is seen where it stands beside our path, or along a bend.
    """

    share: float
    width_m: float
    width_sigma: float
    height_m: float
    height_sigma: float
    overhang_m: float = 0.0
    length_m: float = CAR_LENGTH_M


REARS = (
    # Passenger cars: KITTI's labels are 1.63 m wide in the mean, cars sold today 1.75 to 1.85 m, TuSimple's
    # American ones fit best with 1.8 m. Drawings show a rear overhang of 0.6 to 1.1 m; a camera 1.3 m high
    # sees tyres below the bumper from 3 m on.
    VehicleKind(0.65, 1.74, 0.08, 1.50, 0.12, 0.75),
    # Vans.
    VehicleKind(0.10, 1.90, 0.06, 2.10, 0.12, 0.9),
    # Lorries and buses: 2.55 m is the widest that is allowed in Europe, 2.6 m in the United States.
    # Axles stand 1 m (vans with a box) to 3.3 m (city buses) ahead of the rear. They are 7 m (those vans) to
    # 16.5 m long (with a trailer); twelve of KITTI tracking 9.0 m in the median.
    VehicleKind(0.10, 2.60, 0.10, 3.30, 0.15, 1.5, 10.1),
    # Motorcycles, mopeds and bicycles with their riders: handlebars are 0.6 to 0.95 m wide.
    VehicleKind(0.03, 0.75, 0.15, 1.60, 0.10, 0.3, 2.1),
)
TURNED = (
    # Cars seen from a corner, and from the side.
    VehicleKind(0.10, 2.60, 0.25, 1.50, 0.12, 0.5),
    VehicleKind(0.05, 4.20, 0.12, 1.50, 0.12),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeModel:
    """Beliefs of the range filter.

    Attributes:
        rears: kinds of vehicles seen from behind.
        turned: kinds that a detector also finds whose boxes have a height of their own.
        acceleration_sigma_mps2: 1-sigma of the relative acceleration of two vehicles in traffic. Hard
            braking, at two to four sigma, lasts long enough to be followed.
        acceleration_correlation_s: how long a manoeuvre lasts (Singer 1970).
        closing_sigma_mps: 1-sigma of the closing speed of a vehicle just found, if the own speed is unknown:
            2 sigma is a standing vehicle met at 108 km/h. If it is known, the vehicle is anything between
            standing and as fast as we are, give or take `closing_margin_mps`.
        closing_margin_mps: see `closing_sigma_mps`.
        fleet_width_sigma: 1-sigma of the logarithm by which all vehicles of a place and time are wider than
            believed, which many vehicles cannot average away: 1.63 m in KITTI, 1.75 to 1.85 m today.
        size_drift_per_sqrt_s: relative drift in one second of a vehicle's own width and height.
        aspect_sigma: 1-sigma of the logarithm of the apparent over the true width of a vehicle straight
            ahead, which turns a little. One degree shows 7 cm of its side.
        aspect_correlation_s: correlation time of that: a change of lane, a bend.
        side_sigma: how well the visible side of a vehicle beside our path is known, as a part of it.
        calibration_pitch_sigma_rad: how far calibrations are off in use, beside their clicks: people park on
            ramps, load the boot, bump the mount.
        overhang_sigma: 1-sigma of an overhang, as a part of it. It is in the interval alone: a vehicle keeps
            its own.
        unmodelled_sigma: 1-sigma of the logarithm of a distance by what the filter knows nothing of: roads
            that are not flat for long, kinds of vehicles that are taken for others. It is in the interval
            alone.
        mount_sigma_rad: 1-sigma of the mount by the picture, beside what it says itself: roads are not level
            with the direction of travel.
        mount_lasts_s: correlation time of its errors.
        slow_pitch_sigma_rad: 1-sigma of the pitch against the road by load and long slopes, that is by bends
            of the road between us and the vehicles; most roads are nearly straight over 50 m.
        slow_pitch_correlation_s: correlation time of that pitch.
        fast_pitch_sigma_rad: 1-sigma of the pitch of the body on its springs, with short waves of the road.
            On KITTI tracking the rows of the lower edges of vehicles ahead scatter by 0.17 to 0.42 degrees in
            a drive.
        fast_pitch_correlation_s: correlation time of that pitch: bodies swing at 1 to 2 Hz; on KITTI the
            correlation is a half after 0.4 s.
        dive_rad_per_mps2: 1-sigma of the pitch by our own braking and speeding up, for each m/s^2, if the own
            speed is known. Hard braking was seen to lift the horizon by 12 rows of 360, about 2 degrees.
        lasting_gain_error: the part of an error of a gain in own speed that stays in the closing speeds. The
            rest is taken back: the measured speed errs about the true one and does not run away from it. 1
            made simulated threats and KITTI's `warning`s worse; 0 believes wild speeds too much.
        mount_drift_rad_per_sqrt_s: how fast the filter may come to believe that the camera looks elsewhere
            than it did: 0.1 degrees in a minute and a half. Less, and a turned mount would stay hidden in the
            pitch of the road; more, and the road's pitch would pass for the mount's.
        bump_sigma_rad: 1-sigma of the road below one vehicle against that below another: on KITTI tracking
            two vehicles ahead in our own direction differ by 0.03 to 0.11 degrees over root two where they
            share a road.
        bump_correlation_s: correlation time of that difference.
        looks_correlation_s: correlation time of the errors of the growth by the picture.
        cross_slope: vehicles beside our path stand higher or lower by this part of the lateral distance:
            roads are built with 2 to 3 %.
        common_path_m: vehicles farther aside than the next lane say nothing of the camera: what they stand on
            is another road, and of many of them that are parked we see a corner.
        corner_aspect: a box this many times as wide as high shows a corner or a side. How much of the side
            is a guess, so that it says something of the camera only up to `corner_path_m`.
        corner_path_m: half a lane: who is wide there crosses our way or turns in it, and its row tells more
            than its width. On KITTI tracking, seeds 0 to 9, the mean error is 6.6 % with this rule and 6.9 %
            without, in seeds 10 to 13, which had no say, 7.0 and 7.1 % (medians 4.9 and 5.2 %, 5.4 and
            5.4 %). Without the half lane 1.3, 1.4, 1.5 and 1.6 were tried; of the half lane nothing else.
    """

    rears: tuple[VehicleKind, ...] = REARS
    turned: tuple[VehicleKind, ...] = TURNED
    acceleration_sigma_mps2: float = 1.5
    acceleration_correlation_s: float = 2.0
    closing_sigma_mps: float = 15.0
    closing_margin_mps: float = 3.0
    fleet_width_sigma: float = 0.05
    size_drift_per_sqrt_s: float = 0.003
    aspect_sigma: float = 0.03
    aspect_correlation_s: float = 5.0
    side_sigma: float = 0.5
    calibration_pitch_sigma_rad: float = math.radians(0.5)
    overhang_sigma: float = 0.33
    unmodelled_sigma: float = 0.04
    mount_sigma_rad: float = math.radians(0.15)
    mount_lasts_s: float = 5.0
    slow_pitch_sigma_rad: float = math.radians(0.05)
    slow_pitch_correlation_s: float = 20.0
    fast_pitch_sigma_rad: float = math.radians(0.2)
    fast_pitch_correlation_s: float = 0.5
    dive_rad_per_mps2: float = math.radians(0.1)
    lasting_gain_error: float = 0.5
    mount_drift_rad_per_sqrt_s: float = math.radians(0.01)
    bump_sigma_rad: float = math.radians(0.1)
    bump_correlation_s: float = 0.5
    looks_correlation_s: float = 0.1
    cross_slope: float = 0.03
    common_path_m: float = 4.0
    corner_aspect: float = 1.5
    corner_path_m: float = 1.75

    @property
    def single_picture_pitch_sigma_rad(self) -> float:
        """1-sigma of the camera's pitch against the road below a vehicle that was seen just once."""
        return math.hypot(self.slow_pitch_sigma_rad, self.fast_pitch_sigma_rad, self.bump_sigma_rad)
