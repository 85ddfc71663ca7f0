"""Points followed through pictures."""

import cv2
import numpy as np
import pytest

from fcw.motion.travel.tracks import PointTracks
from fcw.self_calibration.turning.windows import turning_windows


def scene() -> np.ndarray:
    grey = np.random.default_rng(0).integers(0, 256, (60, 200), np.uint8)
    wide = cv2.resize(grey, (1200, 360), interpolation=cv2.INTER_CUBIC)
    return np.repeat(wide[:, :, None], 3, axis=2)


def test_points_keep_their_numbers_and_go_with_the_picture():
    tracks, wide = PointTracks(640), scene()
    for k in range(6):
        tracks.update(0.1 * k, np.ascontiguousarray(wide[:, 200 - 5 * k : 840 - 5 * k]))
    first, last = tracks.pictures[0], tracks.pictures[-1]
    _, before, after = np.intersect1d(first.numbers, last.numbers, return_indices=True)
    assert len(before) > 100
    moved = last.places[after] - first.places[before]
    assert np.median(moved, axis=0) == pytest.approx([25.0, 0.0], abs=0.1)
    assert last.shift_px == pytest.approx(5.0, abs=0.1)
    assert tracks.size == (640, 360)


def test_repeated_pictures_and_ones_too_near_in_time_are_left_out():
    tracks, wide = PointTracks(640), scene()
    for time_s, left in ((0.0, 200), (0.02, 195), (0.1, 200), (0.2, 190)):
        tracks.update(time_s, np.ascontiguousarray(wide[:, left : left + 640]))
    assert [picture.time_s for picture in tracks.pictures] == [0.0, 0.2]


def test_a_plain_picture_has_no_points():
    tracks = PointTracks(640)
    for k in range(30):
        tracks.update(0.1 * k, np.full((360, 640, 3), 8 + 4 * (k % 3), np.uint8))
    assert all(not len(picture.numbers) for picture in tracks.pictures)
    assert turning_windows(tracks.pictures, tracks.size[0]) == []
