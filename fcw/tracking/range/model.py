"""The range filter's prior knowledge of vehicles, roads and cameras.

Each number is a physical quantity with its source. The sequences of KITTI tracking (`fcw evaluate distance`)
were at hand when they were chosen.
"""

import math
from dataclasses import dataclass

from fcw.camera.joint.evidence import CAR_LENGTH_M


@dataclass(frozen=True, slots=True)
class VehicleKind:
    """A kind of vehicle, seen from one direction.

    Attributes:
        share: fraction of all vehicles.
        width_m: median visible width.
        width_sigma: 1-sigma of the logarithm of the width.
        height_m: median height.
        height_sigma: 1-sigma of the logarithm of the height.
        overhang_m: distance from the nearest part of it to where its tyres meet the road.
        length_m: length of the side that it shows beside our path or in a bend.
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
    """Prior knowledge of the range filter.

    Attributes:
        rears: kinds of vehicles seen from behind.
        turned: further kinds, found by detectors that measure heights.
        acceleration_sigma_mps2: 1-sigma of the relative acceleration of two vehicles in traffic. Hard
            braking is two to four sigmas, and lasts long enough to be followed.
        acceleration_correlation_s: how long a manoeuvre lasts (Singer 1970).
        closing_sigma_mps: 1-sigma of the closing speed of a vehicle just found, if the own speed is unknown:
            2 sigma is a standing vehicle met at 108 km/h. If it is known, the vehicle is anything between
            standing and as fast as we are, give or take `closing_margin_mps`.
        closing_margin_mps: see `closing_sigma_mps`.
        fleet_width_sigma: 1-sigma of the log factor by which all vehicles of a place and time are wider than
            assumed, which does not average out: 1.63 m in KITTI, 1.75 to 1.85 m today.
        size_drift_per_sqrt_s: relative drift in one second of a vehicle's own width and height.
        aspect_sigma: 1-sigma of the logarithm of the apparent over the true width of a vehicle straight
            ahead, which turns a little. One degree shows 7 cm of its side.
        aspect_correlation_s: correlation time of that: the duration of a lane change or a bend.
        side_sigma: 1-sigma of the visible side of a vehicle beside our path, as a fraction of it.
        calibration_pitch_sigma_rad: 1-sigma of the pitch of calibrations in use, in addition to the error of
            their clicks: people park on ramps, load the boot, bump the mount.
        overhang_sigma: 1-sigma of an overhang, as a fraction of it. It only widens the interval, because each
            vehicle keeps its own overhang.
        unmodelled_sigma: 1-sigma of the log distance due to what the filter does not model: roads that are
            not flat for long, vehicles that are taken for another kind. It only widens the interval.
        mount_sigma_rad: 1-sigma of the mount's pitch by own motion, in addition to its own sigma, as roads
            are not parallel to the direction of travel.
        mount_lasts_s: correlation time of its errors.
        slow_pitch_sigma_rad: 1-sigma of the pitch relative to the road due to load and to changes of slope
            between us and the vehicles. Most roads are nearly flat over 50 m.
        slow_pitch_correlation_s: correlation time of that pitch.
        fast_pitch_sigma_rad: 1-sigma of the pitch of the body on its springs, with short waves of the road.
            On KITTI tracking the rows of the lower edges of vehicles ahead scatter by 0.17 to 0.42 degrees in
            a drive.
        fast_pitch_correlation_s: correlation time of that pitch. Bodies swing at 1 to 2 Hz; on KITTI the
            correlation is a half after 0.4 s.
        dive_rad_per_mps2: 1-sigma of the pitch due to our own braking and accelerating, per m/s^2, if the own
            speed is known. Hard braking was seen to lift the horizon by 12 rows of 360, about 2 degrees.
        lasting_gain_error: fraction of an error of our change of speed that stays in the closing speeds. The
            rest is corrected later, because the measured speed scatters about the true one and does not
            drift away from it. 1 made simulated threats and KITTI's `warning`s worse; 0 trusts outliers of
            the speed too much.
        mount_drift_rad_per_sqrt_s: random walk of the mount's pitch: 0.1 degrees in a minute and a half. With
            less, a turned mount would be taken for pitch of the road; with more, pitch of the road for a
            turned mount.
        bump_sigma_rad: 1-sigma of the road below one vehicle relative to that below another. On KITTI
            tracking, two vehicles ahead on the same road differ by 0.03 to 0.11 degrees over root two.
        bump_correlation_s: correlation time of that difference.
        looks_correlation_s: correlation time of the errors of the growth by the picture.
        cross_slope: vehicles beside our path stand higher or lower by this fraction of the lateral distance:
            roads are built with a cross slope of 2 to 3 %.
        common_path_m: vehicles farther aside than the next lane do not update the camera, because they stand
            on another road, and many of them are parked and seen from a corner.
        corner_aspect: a box this many times as wide as high shows a corner or a side. How much of the side it
            shows is a guess, so it updates the camera only up to `corner_path_m`.
        corner_path_m: half a lane. A vehicle that looks wide there crosses our path or turns in it, and its
            row tells more than its width. On KITTI tracking, seeds 0 to 9, the mean error is 6.6 % with this
            rule and 6.9 % without; in seeds 10 to 13, which had no say, 7.0 and 7.1 % (medians 4.9 and 5.2 %,
            5.4 and 5.4 %). For `corner_aspect`, 1.3, 1.4, 1.5 and 1.6 were tried without the half lane; for
            the half lane, no other value.
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
