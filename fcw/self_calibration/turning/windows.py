"""Some seconds of a clip in which it turns, as the points that were seen in them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fcw.camera.ground_plane import FloatArray
from fcw.motion.travel.tracks import FollowedPoints

LENGTH_S, HOP_S = 3.0, 2.0
KEY_COUNT = 12
"""Pictures of a window that are used are so many, evenly over time."""
FEWEST_KEYS = 5
LEAST_TURN = 0.06
"""A window turns where the picture goes to one side by so much of its width: by 4 degrees."""
MOST_TURN = 0.7
MOST_WINDOWS = 8
"""The ones that turn most."""
FEWEST_SEEN = 4
"""Pictures of a window that a point must be seen in: the focal length shows in how depths change."""
MOST_POINTS, FEWEST_POINTS = 250, 60
STILL_PX = 1.5
"""What moves by less over a window in which the picture turns is the own car, or on the glass."""


@dataclass(frozen=True, slots=True)
class TurningWindow:
    """Some seconds in which the picture turns.

    Attributes:
        times_s: (K,) of its pictures.
        places: (N, K, 2) columns and rows of points in them; NaN where a point is not seen.
        turn: to one side, in parts of the picture's width.
    """

    times_s: FloatArray
    places: FloatArray
    turn: float


def turning_windows(pictures: Sequence[FollowedPoints], width_px: int) -> list[TurningWindow]:
    """The windows in which a clip turns most, in no order; none of a straight drive or a standing car.

    Args:
        pictures: of the clip.
        width_px: of the small pictures.
    """
    if not pictures:
        return []
    times_s = np.array([picture.time_s for picture in pictures])
    shifts = np.cumsum([picture.shift_px for picture in pictures]) / width_px
    turns: list[tuple[float, list[int]]] = []
    for begin_s in np.arange(times_s[0], times_s[-1] - LENGTH_S / 3, HOP_S):
        inside = np.flatnonzero((times_s >= begin_s) & (times_s <= begin_s + LENGTH_S))
        if len(inside) < FEWEST_KEYS or np.ptp(shifts[inside]) < LEAST_TURN:
            continue
        keys = [int(inside[0])]
        for index in inside[1:].tolist():
            if times_s[index] - times_s[keys[-1]] >= LENGTH_S / KEY_COUNT - 1e-3:
                keys.append(index)
        keys = [key for key in keys if abs(shifts[key] - shifts[keys[0]]) < MOST_TURN]
        if len(keys) >= FEWEST_KEYS:
            turns.append((float(np.ptp(shifts[inside])), keys))
    turns.sort(key=lambda turn: -turn[0])
    windows = []
    for turn, keys in turns[:MOST_WINDOWS]:
        places = _places([pictures[key] for key in keys])
        if len(places) >= FEWEST_POINTS:
            windows.append(TurningWindow(times_s[keys], places, turn))
    return windows


def _places(pictures: Sequence[FollowedPoints]) -> FloatArray:
    """(N, K, 2) of points that are seen often and move, chosen by chance where there are many.

    The ones seen longest would be those of a vehicle ahead.
    """
    numbers = np.unique(np.concatenate([picture.numbers for picture in pictures]))
    places = np.full((len(numbers), len(pictures), 2), np.nan)
    for column, picture in enumerate(pictures):
        places[np.searchsorted(numbers, picture.numbers), column] = picture.places
    places = places[np.isfinite(places[:, :, 0]).sum(axis=1) >= FEWEST_SEEN]
    if not len(places):
        return places
    moved = np.nanmax(places, axis=1) - np.nanmin(places, axis=1)
    places = places[np.hypot(moved[:, 0], moved[:, 1]) > STILL_PX]
    return places[np.random.default_rng(0).permutation(len(places))[:MOST_POINTS]]
