"""Points beside a road, as a camera sees them that drives through bends; without any picture."""

from collections.abc import Callable

import numpy as np

from fcw.motion.travel.tracks import FollowedPoints
from fcw.self_calibration.turning.lens import PlainLens

SIZE = (640, 360)
AXIS_PX = (319.5, 179.5)
EVERY_S = 0.1
PITCH_RAD = 0.04


def straight(time_s: float) -> float:
    """Yaw rate in rad/s."""
    return 0.0 * time_s


def one_bend(time_s: float) -> float:
    """A road that grows to a bend and falls back."""
    return 0.22 * float(np.sin(np.pi * min(max(time_s - 0.5, 0.0), 3.0) / 3.0) ** 2)


def bends(time_s: float) -> float:
    """To and fro."""
    return 0.2 * float(np.sin(2 * np.pi * time_s / 6.0))


def driven(
    lens: PlainLens,
    yaw_rate: Callable[[float], float],
    duration_s: float,
    seed: int = 0,
    noise_px: float = 0.15,
    speed_mps: float = 10.0,
) -> list[FollowedPoints]:
    """What is followed of trees, houses and kerbs.

    Args:
        lens: of the camera; its pictures are of `SIZE`.
        yaw_rate: of the car in rad/s, positive to the left, by the time in s.
        duration_s: of the drive.
        seed: of the places.
        noise_px: of each place in a picture.
        speed_mps: of the car; where it is 0, the camera turns alone.
    """
    random = np.random.default_rng(seed)
    count = 1500
    reach_m = speed_mps * duration_s + 80
    world = np.column_stack(
        (
            random.uniform(-reach_m, reach_m, count),
            1.3 - random.gamma(1.0, 3.0, count) * (random.random(count) < 0.7),
            random.uniform(-10, reach_m, count),
        )
    )
    cosine, sine = np.cos(PITCH_RAD), np.sin(PITCH_RAD)
    looks_down = np.array([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    place, heading_rad = np.zeros(3), 0.0
    pictures: list[FollowedPoints] = []
    for time_s in np.arange(0.0, duration_s, EVERY_S).tolist():
        right = np.array([np.cos(heading_rad), 0, np.sin(heading_rad)])
        ahead = np.array([-np.sin(heading_rad), 0, np.cos(heading_rad)])
        there = (world - place) @ np.column_stack((right, [0, 1, 0], ahead)) @ looks_down.T
        seen = np.flatnonzero((there[:, 2] > 2.0) & (np.abs(there[:, :2]) < 1.6 * there[:, 2:]).all(axis=1))
        bent = lens.bent(there[seen, :2] / there[seen, 2:])
        places = np.array(AXIS_PX) + lens.focal_px * bent + random.normal(0, noise_px, bent.shape)
        inside = ((places > 4) & (places < np.array(SIZE) - 5)).all(axis=1)
        numbers, places = seen[inside], places[inside].astype(np.float32)
        shift_px = 0.0
        if pictures:
            _, first, second = np.intersect1d(pictures[-1].numbers, numbers, return_indices=True)
            shift_px = float(np.median(places[second, 0] - pictures[-1].places[first, 0]))
        pictures.append(FollowedPoints(time_s, numbers, places, shift_px))
        for _ in range(10):  # a finer way between pictures
            heading_rad += yaw_rate(time_s) * EVERY_S / 10
            place = place + speed_mps * EVERY_S / 10 * np.array(
                [-np.sin(heading_rad), 0, np.cos(heading_rad)]
            )
    return pictures
