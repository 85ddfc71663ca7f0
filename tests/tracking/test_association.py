"""Which box is which vehicle's, and what a box of a part of it says."""

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.tracking.association import (
    WHOLE,
    Edges,
    associate,
    completed,
    cut_as_expected,
    free_edges,
    own_edges,
)
from fcw.tracking.ranging import BoxNoise
from fcw.tracking.settings import TrackerSettings
from fcw.tracking.tracker import Tracker

SIZE = ImageSize(1280, 720)
CAR = Box(600, 320, 100, 80)
NOISE = BoxNoise()
CAMERA = GroundPlaneCamera(
    height_m=1.3, pitch_rad=0.0, focal_y_px=1000.0, principal_row_px=300.0, principal_column_px=640.0
)


@pytest.mark.parametrize(
    ("found", "edges"),
    [
        (Box(603, 318, 98, 83), WHOLE),
        (Box(600, 320, 55, 80), Edges(right=False)),
        (Box(645, 320, 55, 80), Edges(left=False)),
        (Box(600, 350, 100, 50), Edges(top=False)),
        (Box(600, 320, 100, 50), Edges(bottom=False)),
        (Box(640, 320, 100, 80), WHOLE),  # elsewhere, not a part
        (Box(600, 320, 140, 80), WHOLE),  # it was expected too narrow
        (Box(560, 320, 140, 80), WHOLE),
    ],
)
def test_the_edge_that_is_not_where_it_was_expected_is_the_end_of_a_part(found, edges):
    assert own_edges(found, CAR, SIZE, NOISE) == edges


def test_the_border_of_the_picture_is_no_edge_that_was_expected():
    leaving = Box(1150, 320, 129.5, 100)
    assert own_edges(Box(1190, 320, 89.5, 100), leaving, SIZE, NOISE) == WHOLE


@pytest.mark.parametrize(
    ("predicted", "found", "right"),
    [
        (Box(1150, 320, 400, 300), Box(1160, 320, 95, 300), 1279.5),  # 24 px short, and goes on beyond
        (Box(1150, 320, 129.5, 300), Box(1160, 320, 95, 300), 1255.0),  # ends at the border
        (Box(1000, 320, 400, 300), Box(1010, 320, 140, 300), 1150.0),  # far from the border
    ],
)
def test_a_vehicle_that_goes_on_beyond_the_picture_is_cut_by_its_border(predicted, found, right):
    cut = cut_as_expected(found, predicted, SIZE, NOISE)
    assert (cut.x, cut.y, cut.right, cut.h) == pytest.approx((found.x, found.y, right, found.h))
    # And the same on the other side.
    across, mirrored = (Box(1279 - box.right, box.y, box.w, box.h) for box in (found, predicted))
    assert cut_as_expected(across, mirrored, SIZE, NOISE).x == pytest.approx(1279 - right)


@pytest.mark.parametrize(
    ("other", "free"),
    [
        (Box(660, 330, 120, 110), Edges(right=False, top=False)),
        (Box(520, 330, 85, 110), Edges(left=False, top=False)),
        (Box(705, 330, 120, 110), Edges(right=False, top=False)),  # beside it, closer than a tenth of it
        (Box(715, 330, 120, 110), WHOLE),  # apart
        (Box(660, 300, 120, 100), WHOLE),  # as far away
        (Box(660, 310, 60, 70), WHOLE),  # farther away
        (Box(620, 360, 60, 80), WHOLE),  # a part of it
        (Box(660, 405, 120, 110), WHOLE),  # below it
    ],
)
def test_edges_that_a_nearer_vehicle_touches_are_not_free(other, free):
    assert free_edges(CAR, [other, CAR], CAMERA, length_m=0.0) == free
    assert free_edges(CAR, [CAR], CAMERA, length_m=0.0) == WHOLE


def test_the_far_end_of_a_vehicle_beside_us_hides_nothing_that_is_nearer():
    lead = CAMERA.row_at(6.0)
    car = Box(560, lead - 200, 160, 200)
    beside = Box(715, 0, 500, CAMERA.row_at(4.0))  # a lorry that ends 4 m ahead of us, right of the axis
    assert free_edges(car, [beside], CAMERA, length_m=4.2) == WHOLE
    assert free_edges(car, [beside], CAMERA, length_m=1.5) == Edges(right=False, top=False)
    behind = Box(700, CAMERA.row_at(30.0) - 40, 60, 40)
    assert free_edges(behind, [beside], CAMERA, length_m=4.2) == Edges(right=False, top=False)
    aside = Box(645, lead - 200, 75, 200)  # parked beside the road: the next one before it may hide it
    assert free_edges(aside, [beside], CAMERA, length_m=4.2) == Edges(right=False, top=False)
    # Who stands across the axis shows its rear: its edges are as far away as that.
    assert free_edges(car, [Box(610, 200, 500, 500)], CAMERA, length_m=4.2) == Edges(right=False, top=False)


def test_a_part_is_completed_by_what_was_expected():
    part = Box(602, 321, 55, 80)
    assert completed(part, CAR, Edges(right=False)) == Box(602, 321, 98, 80)
    assert completed(part, CAR, WHOLE) == part


@pytest.mark.parametrize(
    ("found", "is_its"),
    [
        (Box(600, 320, 45, 80), True),  # its left part
        (Box(600, 300, 45, 50), False),  # a smaller car farther away, in front of which it stands
    ],
)
def test_a_part_belongs_to_the_vehicle_that_stands_there(found, is_its):
    assert bool(associate([CAR], [found], SIZE, TrackerSettings())) == is_its


def test_a_whole_box_goes_before_a_part():
    assert associate([CAR], [Box(600, 320, 45, 80), Box(602, 321, 99, 80)], SIZE, TrackerSettings()) == [
        (0, 1)
    ]


def test_half_a_second_of_boxes_of_its_left_part_changes_neither_place_nor_speed():
    calibration = Calibration.from_camera(GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), SIZE)
    tracker = Tracker(calibration)
    for frame in range(60):
        time_s = frame / 30
        box = calibration.ground_box(30 - 8 * time_s, 0.0, 1.7, 1.5)
        if 1.2 < time_s <= 1.7:
            box = Box(box.x, box.y, 0.55 * box.w, box.h)
        tracks = tracker.update(round(time_s * 1e9), [Detection(box, 1.0)])
        if time_s > 1.2:
            (track,) = tracks
            assert track.track_id == 1
            assert track.lateral_m == pytest.approx(0.0, abs=0.1)
            assert track.distance_m == pytest.approx(30 - 8 * time_s, rel=0.06)
            assert track.closing_speed_mps == pytest.approx(8.0, abs=1.0)


def test_a_vehicle_that_was_half_hidden_at_first_is_believed_as_wide_as_it_is_as_soon_as_it_is_seen():
    calibration = Calibration.from_camera(GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), SIZE)
    tracker = Tracker(calibration)
    for frame in range(60):
        time_s = frame / 30
        box = calibration.ground_box(30 - 8 * time_s, 3.0, 1.7, 1.5)
        if time_s <= 1.0:
            box = Box(box.x, box.y, 0.6 * box.w, box.h)
        tracks = tracker.update(round(time_s * 1e9), [Detection(box, 1.0)], assumed_ego(8.0))
        if time_s > 1.2:
            (track,) = tracks
            assert track.box.w == pytest.approx(box.w, rel=0.15)
            assert abs(track.lateral_speed_mps) < 0.7
