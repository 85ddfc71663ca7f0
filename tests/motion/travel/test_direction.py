"""Where straight driving leads to, by points that were followed."""

import math

import numpy as np
import pytest
from helpers.drives.turning import AXIS_PX, PITCH_RAD, bends, driven, one_bend, straight
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import GroundPoint
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.camera.solve import calibrate
from fcw.motion.travel.direction import SLOPE_SIGMA_RAD, TravelDirection
from fcw.motion.travel.tracks import FollowedPoints, PointTracks
from fcw.self_calibration.clip import rough_calibration
from fcw.self_calibration.turning.lens import PlainLens
from fcw.sources import open_source

FOCAL_PX = 560.0
LENS = PlainLens(FOCAL_PX, 0.0, AXIS_PX)
TRUE_ROW_PX = AXIS_PX[1] - FOCAL_PX * math.tan(PITCH_RAD)


def told(pictures, focal_px=FOCAL_PX, boxes=(), factor=1):
    """What comes of them; the pitch that the camera is thought to have is far off."""
    axis_px = [(place + 0.5) * factor - 0.5 for place in AXIS_PX]
    camera = GroundPlaneCamera(math.radians(-9), focal_px * factor, axis_px[1], 1.3, axis_px[0])
    travel = TravelDirection(camera, factor)
    for picture in pictures:
        travel.update(picture, boxes)
    return travel.told()


def row_told(pictures):
    places = told(pictures)
    assert places is not None
    return places[1]


@settings(max_examples=6)
@given(st.integers(0, 2**31), st.sampled_from((0.75, 1.0, 1.35)))
def test_a_straight_drive_tells_both_whatever_lens_is_taken_for_granted(seed, wrong):
    places = told(driven(LENS, straight, 6.0, seed), wrong * FOCAL_PX)
    assert places is not None
    column, row = places
    assert column is not None
    assert abs(column.value - AXIS_PX[0]) < 2 * column.sigma
    assert abs(row.value - TRUE_ROW_PX) < 2 * row.sigma
    assert row.sigma < math.radians(0.5) * wrong * FOCAL_PX
    assert column.sigma < math.radians(1.0) * wrong * FOCAL_PX


@settings(max_examples=4)
@given(st.integers(0, 2**31), st.sampled_from((one_bend, bends)))
def test_bends_tell_the_row(seed, yaw_rate):
    row = row_told(driven(LENS, yaw_rate, 8.0, seed))
    assert abs(row.value - TRUE_ROW_PX) < 2 * row.sigma


def test_a_turning_direction_leaves_the_row_and_no_column():
    """The camera is turned aside by hand while we drive on: by 13 degrees, in two steps."""
    first, second, third = (driven(LENS, straight, 4.0, seed) for seed in range(3))
    pictures = []
    for number, piece in enumerate((first, second, third)):
        aside_px = 65.0 * number
        for picture in piece:
            places = picture.places + np.array((aside_px, 0.0), np.float32)
            time_s = picture.time_s + 4.0 * number
            pictures.append(FollowedPoints(time_s, picture.numbers + 10_000 * number, places, 0.0))
    places = told(pictures)
    assert places is not None
    column, row = places
    assert abs(row.value - TRUE_ROW_PX) < 2 * row.sigma
    assert column is None


@pytest.mark.parametrize("yaw_rate", [straight, bends])
def test_who_stands_drives_nowhere_though_the_camera_may_turn(yaw_rate):
    assert told(driven(LENS, yaw_rate, 6.0, speed_mps=0.0)) is None


def test_a_clip_of_a_second_tells_nothing():
    assert told(driven(LENS, straight, 1.0)) is None


def test_a_small_picture_tells_the_place_in_the_whole_one():
    pictures = driven(LENS, straight, 6.0)
    row, places = row_told(pictures), told(pictures, factor=2)
    assert places is not None
    whole_row = places[1]
    assert whole_row.value == pytest.approx(2 * row.value + 0.5)
    assert whole_row.sigma == pytest.approx(2 * row.sigma)


def with_traffic(pictures, part=0.6):
    """The same beside a lorry that overtakes: so many points again, which flow to the upper left corner."""
    random = np.random.default_rng(5)
    mixed = []
    for number, picture in enumerate(pictures):
        count = round(part * len(picture.places))
        start = random.uniform((30, 60), (300, 200), (count, 2)) if number % 10 == 0 else mixed[-1][1] * 0.98
        numbers = 50_000 + 1_000 * (number // 10) + np.arange(len(start))
        mixed.append((picture, start, numbers))
    return [
        FollowedPoints(
            picture.time_s,
            np.concatenate((picture.numbers, numbers)),
            np.concatenate((picture.places, places)).astype(np.float32),
            0.0,
        )
        for picture, places, numbers in mixed
    ]


def test_vehicles_do_not_count_where_they_are_boxed():
    pictures = driven(LENS, straight, 6.0)
    alone = told(pictures, boxes=[Box(-1, -1, 310, 210)])
    masked = told(with_traffic(pictures), boxes=[Box(-1, -1, 310, 210)])
    assert masked == alone


def test_a_third_of_points_that_flow_elsewhere_are_astray():
    row = row_told(with_traffic(driven(LENS, straight, 6.0), 0.5))
    assert abs(row.value - TRUE_ROW_PX) < 2 * row.sigma


@pytest.mark.slow
@pytest.mark.parametrize(
    ("clip", "rows_px"),
    [
        # `calibrations.txt`: rows of 8, 15 and 40 m. Own motion alone found no speed on the first two, and
        # two directions on the third.
        ("kb_dashcam1", (244.75, 212.67, 189.75)),
        ("kb_dashcam2", (344.00, 295.47, 260.80)),
        ("solidWhiteRight", (480.38, 397.83, 338.88)),
        ("tmo_countryroad", (273.12, 231.53, 201.82)),
        ("udacity_project_video_cut", (597.88, 516.50, 458.38)),
    ],
)
def test_real_drives_lead_to_the_horizon(clip, rows_px, data_dir):
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    size = source.image_size
    truth = calibrate(list(map(GroundPoint, (8, 15, 40), rows_px)), size, 1.3, exact=True)
    guess = rough_calibration(size, 1.3)
    tracks = PointTracks(size.width)
    travel = TravelDirection(guess.camera, tracks.factor)
    for frame in source.frames():
        if tracks.update(frame.time_ns / 1e9, frame.image):
            travel.update(tracks.pictures[-1], ())
    found = travel.told()
    assert found is not None
    row = found[1]
    assert abs(row.value - truth.horizon_row_px) < 2 * row.sigma
    assert row.sigma < 3 * SLOPE_SIGMA_RAD * guess.camera.focal_y_px
