"""Where a vehicle will be across our path when we reach it, and how well that is known.

The tracker measures the vehicle's lateral position in the camera's frame and the rate at which it changes.
That rate has two causes: the vehicle's own motion across the road, and ours. When we turn, or when the camera
looks aside, standing objects sweep across the picture too. Three unknowns therefore explain one measured
rate: u, the vehicle's own speed across our path, and the heading and the curvature of our path. Each has a
prior and the model is linear, so one scalar Kalman update gives the place at contact and its sigma:

    rate = u - (heading + curvature x) v
    place at contact = y - offset - heading x - curvature x^2 / 2 + u t

x and y are the vehicle's position now, v is the closing speed and t the time to contact. If u is the
likeliest cause, the result is the rate extrapolated in a straight line. If the bend is, it is half of that,
which is how an object beside a bend moves. If our yaw rate was measured, that is what makes objects sweep,
whatever the path does later (`fcw.motion.bend.turn`); the rate of a standing object then says nothing about
the bend ahead. A vehicle that brakes before it reaches our path moves for less than t. Far to the side, the
rate is taken from the bearing (`_rate`). An error of the heading alone does not matter: a vehicle on a
collision course keeps its bearing, wherever the camera looks.

The constants follow from how people drive, as each one says. They were chosen and tried on KITTI tracking
0000 to 0010 and the simulated scenarios. No drive was left out, so neither set is evidence for them.
"""

import math
from dataclasses import dataclass

from fcw.motion.bend.turn import Turn, sweep_mps
from fcw.motion.state import OwnPath
from fcw.tracking.types import Track

ACROSS_SIGMA_MPS = 1.0
"""1-sigma of a vehicle's own speed across our path. A lane change takes 3 to 5 s; crossing cars are rarer."""
SURELY_SIGMAS = 2.0
CROSSING_MPS = 2.5
"""A lane change of 3.5 m in 3 s reaches at most 2.2 m/s across."""
LONGEST_S = 4.0
"""Lateral motion is extrapolated no farther than the largest TTC at which ISO 15623 asks for a warning: a
lane change ends."""
FAR_ASIDE_M = 4.5
"""Beyond the middle of the next lane, the bearing tells lateral motion better than the position does."""
SOONEST_S = 1.0
"""The bearing is used until this long before contact. After that it changes faster than its filter follows,
and the border of the picture cuts the box. Chosen on KITTI's drives: 0 gives warnings of vehicles that are
passed; 1 and 1.25 s give the same result."""
CHANGING_SLOPE = 0.5
"""A vehicle changes lane if its speed across the road is below this fraction of its speed along it. Faster
ones turn or cross."""


@dataclass(frozen=True, slots=True)
class PlaceAtContact:
    """Where a vehicle will be, across our path, when we reach it.

    Attributes:
        offset_m: lateral position of the middle of its rear from the middle of our path, positive to the
            left.
        sigma_m: 1-sigma of `offset_m`.
        comes_in: whether it surely moves towards the middle of our path now, because neither a bend nor the
            direction of the camera could explain its motion.
        crosses: whether it moves across faster than anyone changes lane.
    """

    offset_m: float
    sigma_m: float
    comes_in: bool
    crosses: bool


def place_at_contact(
    track: Track,
    path: OwnPath,
    reference_offset_m: float,
    contact_s: float,
    turn: Turn | None = None,
    oncoming: bool = False,
    own_mps: float | None = None,
) -> PlaceAtContact:
    """Where a vehicle will be when we reach it.

    Args:
        track: the vehicle.
        path: our own.
        reference_offset_m: how far the point from which distances are measured is ahead of the camera.
        contact_s: time until we reach it.
        turn: our turning now; None when unknown, in which case we are assumed to follow the path's bend.
        oncoming: whether it surely comes towards us.
        own_mps: own speed, which tells how fast it drives along the road; None when unknown.
    """
    x_m = track.distance_m + reference_offset_m
    time_s = min(contact_s, LONGEST_S)
    # Beyond the extrapolated time nothing sweeps either.
    speed_mps = track.distance_m / contact_s if contact_s > 0 else 0.0
    now_m = track.lateral_m - path.lateral_at(x_m)
    # The measured rate belongs to the closing speed now. A braking lead will sweep faster later.
    swept_mps = sweep_mps(path, turn, x_m, track.closing_speed_mps, oncoming)
    rate_mps, rate_sigma_mps, lateral_sigma_m = _rate(track, now_m, swept_mps, contact_s)
    across_mps = rate_mps - swept_mps
    heading_variance = path.heading_sigma_rad**2
    bend_variance = path.curvature_sigma_per_m**2
    time_s = _moving_s(now_m, across_mps, track.lateral_slowing_mps2, time_s)
    # How place and rate depend on the bend. If our turning is known, standing objects do not reveal the bend.
    bend_m, sweep_m2ps = x_m**2 / 2, x_m * speed_mps
    swept = speed_mps**2 * heading_variance + rate_sigma_mps**2
    if turn is not None:
        part = turn.measured_part
        sweep_m2ps = x_m * ((1 - part) * turn.own_mps - turn.its_mps(speed_mps, oncoming))
        swept += part * (x_m * turn.sigma_radps) ** 2
    swept += sweep_m2ps**2 * bend_variance
    # Beyond two sigmas it is no lane change, but a crossing car or our own turning.
    its_mps = max(ACROSS_SIGMA_MPS, abs(across_mps) / 2)
    seen = its_mps**2 + swept
    # Covariance of the rate and the place at contact.
    shared = its_mps**2 * time_s + x_m * speed_mps * heading_variance + bend_m * sweep_m2ps * bend_variance
    # On a curved path, the lateral offset from it depends on the distance.
    by_distance_m = path.slope_at(x_m) * (track.distance_m - track.distance_low_m)
    variance = (
        lateral_sigma_m**2
        + by_distance_m**2
        + path.offset_sigma_m**2
        + x_m**2 * heading_variance
        + bend_m**2 * bend_variance
        + (its_mps * time_s) ** 2
        - shared**2 / seen
    )
    offset_m = now_m + shared / seen * across_mps
    crosses = abs(across_mps) > CROSSING_MPS + SURELY_SIGMAS * math.sqrt(swept)
    comes_in = now_m * across_mps < 0 and across_mps**2 > SURELY_SIGMAS**2 * swept
    along_mps = 0.0 if own_mps is None else own_mps - track.closing_speed_mps
    if comes_in and now_m * offset_m < 0 and abs(across_mps) < CHANGING_SLOPE * along_mps:
        offset_m = 0.0  # a vehicle that changes into our lane stays there; it does not cross to the far side
    return PlaceAtContact(
        offset_m=offset_m,
        sigma_m=math.sqrt(max(variance, 0.0)),
        crosses=crosses,
        comes_in=comes_in,
    )


def _rate(track: Track, now_m: float, swept_mps: float, contact_s: float) -> tuple[float, float, float]:
    """Lateral speed, its sigma, and the 1-sigma error of the place at contact due to the distance.

    Our own turning contributes `swept_mps` to the lateral speed.

    Far to the side, an error of the distance scales the position and the rate alike, and so the place at
    contact as a whole. For a vehicle on a collision course that place is zero, and so is its error.
    """
    by_filter = track.lateral_speed_mps, track.lateral_speed_sigma_mps, track.lateral_sigma_m
    rate_mps, sigma_mps = track.lateral_speed_by_bearing_mps, track.lateral_speed_by_bearing_sigma_mps
    if rate_mps is None or abs(now_m) <= FAR_ASIDE_M or not SOONEST_S < contact_s <= LONGEST_S:
        return by_filter
    if sigma_mps * contact_s >= math.hypot(track.lateral_sigma_m, track.lateral_speed_sigma_mps * contact_s):
        return by_filter
    scale = (track.distance_m - track.distance_low_m) / track.distance_m
    return rate_mps, sigma_mps, scale * abs(now_m + (rate_mps - swept_mps) * contact_s)


def _moving_s(now_m: float, across_mps: float, slowing_mps2: float, time_s: float) -> float:
    """For how long a vehicle would have to move at its present rate to get as far as it will in `time_s`.

    This is shorter than `time_s` only for a vehicle that comes to a crossing, brakes and stops before our
    path. One that slows down beyond the middle of our path usually turns off there and clears it.
    """
    if slowing_mps2 <= 0 or now_m * across_mps >= 0:
        return time_s
    slows_s = min(time_s, abs(across_mps) / slowing_mps2)
    moves_s = slows_s - slowing_mps2 * slows_s**2 / (2 * abs(across_mps))
    return moves_s if abs(across_mps) * moves_s < abs(now_m) else time_s
