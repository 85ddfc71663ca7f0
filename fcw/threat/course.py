"""Where a vehicle will be across our path when we reach it, and how well that is known.

Known are its place beside the camera's axis and the rate at which that changes, which is its own motion
across the road and ours: where we turn, or look aside, what stands still sweeps across the picture. So three
unknowns share what was measured: u, its own speed across our path, the heading and the curvature of the path.
Each has a prior, all is linear, and one scalar update (Kalman) gives the place at contact with its sigma:

    rate = u - (heading + curvature x) v
    place at contact = y - offset - heading x - curvature x^2 / 2 + u t

with x and y the vehicle's place now, v the closing speed and t the time to contact. Where u is the likeliest
cause, that is the straight extrapolation of the rate, and where the bend is, half of it: the way of a thing
that stands beside a road that bends. Where our turning now was measured it is that which sweeps, whatever the
path will do (`fcw.motion.bend.turn`): of what stands the rate then says nothing of the bend ahead. Who slows
before our path moves on for less than t. Far aside the bearing tells the rate (`_rate`). An error of the
heading alone does not matter: what is on a collision course keeps its bearing, wherever the camera looks.

The constants follow from how people drive, as each says; they were chosen and tried on KITTI tracking 0000 to
0010 and the simulated scenarios. Nothing was left out, so that neither is evidence for them.
"""

import math
from dataclasses import dataclass

from fcw.motion.bend.turn import Turn, sweep_mps
from fcw.motion.state import OwnPath
from fcw.tracking.types import Track

ACROSS_SIGMA_MPS = 1.0
"""1-sigma of a vehicle's own speed across our path: a change of lane takes 3 to 5 s, a crossing car is
rarer."""
SURELY_SIGMAS = 2.0
CROSSING_MPS = 2.5
"""A change of lane of 3.5 m in 3 s is at its fastest 2.2 m/s across."""
LONGEST_S = 4.0
"""Sideways motion is not extrapolated farther than ISO 15623's largest TTC of a warning: a change of lane has
an end."""
FAR_ASIDE_M = 4.5
"""Beyond the middle of the next lane the bearing of a vehicle tells better than its place how it moves
across."""
SOONEST_S = 1.0
"""The bearing counts until this long before contact: then it changes faster than its filter follows, and the
border of the picture cuts the box. Chosen on KITTI's drives: 0 brings warnings of what is passed, 1 and 1.25
s are alike."""
CHANGING_SLOPE = 0.5
"""A vehicle whose speed across the road is below this part of that along it changes lane; others turn, or
cross."""


@dataclass(frozen=True, slots=True)
class PlaceAtContact:
    """Where a vehicle will be, across our path, when we reach it.

    Attributes:
        offset_m: lateral position of the middle of its rear from the middle of our path, positive to the
            left.
        sigma_m: 1-sigma of `offset_m`.
        comes_in: whether it surely moves towards the middle of our path now: neither a bend nor the direction
            of the camera could explain its motion.
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
        reference_offset_m: how far the reference of distances is ahead of the camera.
        contact_s: time until we reach it.
        turn: our turning now; None where it is unknown, and we are taken to turn as the path bends.
        oncoming: whether it surely comes towards us.
        own_mps: own speed, which tells how fast it drives along the road; None when unknown.
    """
    x_m = track.distance_m + reference_offset_m
    time_s = min(contact_s, LONGEST_S)
    # What is not extrapolated does not sweep either.
    speed_mps = track.distance_m / contact_s if contact_s > 0 else 0.0
    now_m = track.lateral_m - path.lateral_at(x_m)
    # What was measured swept as fast as it closes now: a lead that brakes will sweep faster.
    swept_mps = sweep_mps(path, turn, x_m, track.closing_speed_mps, oncoming)
    rate_mps, rate_sigma_mps, lateral_sigma_m = _rate(track, now_m, swept_mps, contact_s)
    across_mps = rate_mps - swept_mps
    heading_variance = path.heading_sigma_rad**2
    bend_variance = path.curvature_sigma_per_m**2
    time_s = _moving_s(now_m, across_mps, track.lateral_slowing_mps2, time_s)
    # How place and rate hang on the bend: what stands ahead of a known turning does not show it.
    bend_m, sweep_m2ps = x_m**2 / 2, x_m * speed_mps
    swept = speed_mps**2 * heading_variance + rate_sigma_mps**2
    if turn is not None:
        part = turn.measured_part
        sweep_m2ps = x_m * ((1 - part) * turn.own_mps - turn.its_mps(speed_mps, oncoming))
        swept += part * (x_m * turn.sigma_radps) ** 2
    swept += sweep_m2ps**2 * bend_variance
    # Beyond two sigma it is no change of lane: a car that crosses, or our own turning.
    its_mps = max(ACROSS_SIGMA_MPS, abs(across_mps) / 2)
    seen = its_mps**2 + swept
    # Moved on by so much the way has been used up; the rest of heading and bend stays ahead.
    shared = its_mps**2 * time_s + x_m * speed_mps * heading_variance + bend_m * sweep_m2ps * bend_variance
    # On a path that bends the vehicle's place beside it hangs on its distance.
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
        offset_m = 0.0  # who changes into our lane stays there, and does not go on to its other side
    return PlaceAtContact(
        offset_m=offset_m,
        sigma_m=math.sqrt(max(variance, 0.0)),
        crosses=crosses,
        comes_in=comes_in,
    )


def _rate(track: Track, now_m: float, swept_mps: float, contact_s: float) -> tuple[float, float, float]:
    """Its lateral speed, with its sigma, and the sigma of its place at contact that its distance leaves.

    `swept_mps` of it is our turning.

    Far aside, an error of the distance is as large a part of the place as of the rate, and of their sum, the
    place at contact, alone: of what is on a collision course nothing is left of it.
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
    """For how long a vehicle must move at its present rate to come as far as it will in a time.

    Who comes to a crossing brakes, and stops before our path. Of all others it is the time: who slows beyond
    the middle of our path mostly turns off there, and clears it.
    """
    if slowing_mps2 <= 0 or now_m * across_mps >= 0:
        return time_s
    slows_s = min(time_s, abs(across_mps) / slowing_mps2)
    moves_s = slows_s - slowing_mps2 * slows_s**2 / (2 * abs(across_mps))
    return moves_s if abs(across_mps) * moves_s < abs(now_m) else time_s
