"""Identity, births, deaths and the lead, on boxes projected by a known camera."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.tracking.ranging import BoxNoise
from fcw.tracking.tracker import Tracker, TrackerSettings
from fcw.tracking.types import SeenBy

CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=1.5
)
FRAME_NS = 33_333_333


def seen(distance_m, lateral_m=0.0, width_m=1.7):
    """Of a car whose tyres meet the road 0.75 m ahead of its rear."""
    rear = CALIBRATION.ground_box(distance_m, lateral_m, width_m, 1.5)
    return Detection(Box(rear.x, rear.y, rear.w, float(CALIBRATION.row_at(distance_m + 0.75)) - rear.y), 10.0)


def follow(tracker, frames, detections_at, ego_speed_mps=None):
    """Tracks of each frame, `detections_at` giving the detections at a time in seconds."""
    return [
        tracker.update(k * FRAME_NS, detections_at(k * FRAME_NS / 1e9), assumed_ego(ego_speed_mps))
        for k in range(frames)
    ]


def test_constant_closing_speed_gives_distance_speed_and_ttc_from_the_reference():
    tracks = follow(Tracker(CALIBRATION), 90, lambda t: [seen(50 - 10 * t)])[-1]
    (track,) = tracks
    true_m = 50 - 10 * 89 * FRAME_NS / 1e9
    assert track.distance_m == pytest.approx(true_m, rel=0.02)
    assert track.closing_speed_mps == pytest.approx(10, rel=0.05)
    assert track.ttc_s == pytest.approx(true_m / 10, rel=0.05)
    assert track.distance_low_m < true_m < track.distance_high_m
    assert track.lateral_m == pytest.approx(0, abs=0.05)
    assert track.box.bottom == pytest.approx(seen(true_m).box.bottom, abs=2)


def test_lateral_position_is_positive_to_the_left():
    rears_alone = TrackerSettings(box_noise=BoxNoise(shows_side=False))
    (track,) = follow(Tracker(CALIBRATION, rears_alone), 10, lambda t: [seen(20, lateral_m=3.0)])[-1]
    assert track.lateral_m == pytest.approx(3.0, rel=0.03)


def test_an_opening_gap_has_no_ttc():
    (track,) = follow(Tracker(CALIBRATION), 60, lambda t: [seen(15 + 5 * t)])[-1]
    assert track.closing_speed_mps < 0
    assert track.ttc_s is None


def test_false_alarms_of_two_frames_are_never_shown():
    tracks = follow(Tracker(CALIBRATION), 30, lambda t: [seen(20)] if 0.3 < t < 0.39 else [])
    assert not any(tracks)


def test_a_detection_that_flickers_rarely_is_never_shown():
    tracker = Tracker(CALIBRATION)
    shown = [tracker.update(k * FRAME_NS, [seen(20)] if k % 3 == 0 else []) for k in range(60)]
    assert not any(shown)


def test_identity_survives_a_short_miss_of_a_closing_vehicle():
    missed = follow(Tracker(CALIBRATION), 90, lambda t: [] if 1.5 < t < 2.0 else [seen(40 - 8 * t)])
    assert {track.track_id for tracks in missed for track in tracks} == {1}
    assert any(track.coasting for track in missed[50])
    assert not missed[-1][0].coasting


def test_a_vehicle_is_followed_as_well_where_every_second_frame_is_searched():
    tracker = Tracker(CALIBRATION)
    shown = [
        tracker.update(k * FRAME_NS, None if k % 2 else [seen(50 - 10 * k * FRAME_NS / 1e9)])
        for k in range(90)
    ]
    (track,) = shown[-1]
    true_m = 50 - 10 * 89 * FRAME_NS / 1e9
    assert track.distance_m == pytest.approx(true_m, rel=0.02)
    assert track.closing_speed_mps == pytest.approx(10, rel=0.05)
    assert track.box.bottom == pytest.approx(seen(true_m).box.bottom, abs=2)
    followed = [track for tracks in shown for track in tracks]
    assert {(track.track_id, track.seen_by, track.found_part) for track in followed} == {
        (1, SeenBy.DETECTOR, 1.0)
    }
    assert len(followed) == 90 - 4  # found for the third time in the fifth frame


@pytest.mark.parametrize(
    ("case", "wanted"),
    [
        # distance, closing speed, metres to the side
        ((40.0, 5.0, 0.0), False),
        ((40.0, 10.0, 0.0), True),
        ((20.0, 10.0, 4.0), True),
        ((20.0, 10.0, 8.0), False),
        ((10.0, 0.0, 0.0), False),
    ],
)
def test_every_frame_is_worth_a_search_at_first_and_while_we_may_soon_be_at_its_rear(case, wanted):
    distance_m, closing_mps, aside_m = case
    tracker = Tracker(CALIBRATION)
    assert not tracker.wants_search
    wishes = []
    for k in range(60):
        tracker.update(k * FRAME_NS, [seen(distance_m + closing_mps * (59 - k) / 30, aside_m)])
        wishes.append(tracker.wants_search)
    assert all(wishes[:15]) == (aside_m < 5)
    assert wishes[-1] == wanted


def test_a_frame_that_is_not_searched_says_nothing_of_a_vehicle_that_was_missed():
    tracker = Tracker(CALIBRATION)
    follow(tracker, 20, lambda t: [seen(20)])
    (missed,) = tracker.update(20 * FRAME_NS, [])
    (still,) = tracker.update(21 * FRAME_NS, None)
    assert missed.coasting
    assert still.coasting
    assert still.found_part == missed.found_part < 1.0


def test_what_is_missed_in_every_searched_frame_ends_though_others_are_not_searched():
    tracker = Tracker(CALIBRATION, TrackerSettings(coast_s=0.5))
    shown = [
        tracker.update(k * FRAME_NS, None if k % 2 else [seen(20)] if k <= 30 else []) for k in range(60)
    ]
    alive = [k for k, tracks in enumerate(shown) if tracks]
    assert alive[-1] == 30 + 15


@pytest.mark.parametrize("frame_ns", [33_333_333, 100_000_000])
def test_a_track_ends_after_coasting_so_many_seconds_whatever_the_frame_rate(frame_ns):
    tracker = Tracker(CALIBRATION, TrackerSettings(coast_s=0.5))
    times_ns = [k * frame_ns for k in range(3_000_000_000 // frame_ns)]
    last_seen_ns = max(t for t in times_ns if t <= 1_500_000_000)
    alive = [t for t in times_ns if tracker.update(t, [seen(20)] if t <= last_seen_ns else [])]
    assert alive[-1] == max(t for t in times_ns if t <= last_seen_ns + 500_000_000)


def test_a_long_gap_in_time_ends_every_track():
    tracker = Tracker(CALIBRATION)
    follow(tracker, 20, lambda t: [seen(20)])
    assert tracker.lead_id == 1
    assert tracker.update(10_000_000_000, [seen(20)]) == ()
    assert tracker.lead_id is None


def test_a_track_that_coasts_into_the_camera_ends_there_and_stays_finite():
    tracker = Tracker(CALIBRATION)

    frames = follow(tracker, 60, lambda t: [seen(30 - 20 * t)] if t < 1.3 else [])
    assert len(frames[38]) == 1
    assert all(0 <= track.distance_m < 60 and track.box.w < 1e5 for tracks in frames for track in tracks)
    assert frames[-1] == ()


def test_time_that_goes_back_is_refused():
    tracker = Tracker(CALIBRATION)
    tracker.update(1000, [])
    with pytest.raises(ValueError, match="went back from 1000 to 999"):
        tracker.update(999, [])


def test_two_frames_with_one_time_are_taken():
    tracker = Tracker(CALIBRATION)
    for time_ns in (0, FRAME_NS, FRAME_NS, 2 * FRAME_NS):
        tracks = tracker.update(time_ns, [seen(20)])
    assert tracks[0].distance_m == pytest.approx(20, rel=0.02)


def test_vehicles_that_cross_in_the_picture_keep_their_ids():
    # A near one changes lane from left to right in front of a far one that goes the other way.
    def both(t):
        return [seen(14, 4.0 - 2.5 * t), seen(35, -6.0 + 3.0 * t)]

    history = follow(Tracker(CALIBRATION), 100, both)
    near = {min(tracks, key=lambda x: x.distance_m).track_id for tracks in history if len(tracks) == 2}
    far = {max(tracks, key=lambda x: x.distance_m).track_id for tracks in history if len(tracks) == 2}
    assert len(history[-1]) == 2
    assert len(near) == len(far) == 1
    assert near != far


def test_a_box_cut_by_the_lower_border_keeps_its_track_by_its_width():
    # 4 m ahead of the bumper the road is in the picture, 0.5 m ahead it is below it.
    def approach(t):
        box = seen(max(4 - 2 * t, 0.5), width_m=1.8).box
        bottom = min(box.bottom, 719.5)
        return [Detection(Box(box.x, box.y, box.w, bottom - box.y), 10.0)]

    (track,) = follow(Tracker(CALIBRATION), 51, approach)[-1]
    assert track.distance_m == pytest.approx(4 - 2 * 50 * FRAME_NS / 1e9, abs=0.4)


def test_a_second_box_of_a_vehicle_does_not_take_it_to_its_side():
    # Parts of the flank of a car that we pass are boxed once within it, then beside it.
    vehicle, within, beside = (
        Detection(Box(x, y, w, h), score)
        for x, y, w, h, score in ((770, 308, 205, 140, 8), (830, 334, 142, 105, 3), (698, 326, 148, 108, 3))
    )
    boxed = {30: [vehicle, within], 31: [vehicle, beside]}
    tracks = follow(Tracker(CALIBRATION), 32, lambda t: boxed.get(round(t / FRAME_NS * 1e9), [vehicle]))[-1]
    assert [track.track_id for track in tracks] == [1]
    assert tracks[0].box.x == pytest.approx(770, abs=2)


def test_the_lead_is_the_nearest_in_the_own_path():
    tracker = Tracker(CALIBRATION)
    tracks = follow(tracker, 10, lambda t: [seen(40), seen(25), seen(10, lateral_m=3.5)])[-1]
    lead = next(track for track in tracks if track.track_id == tracker.lead_id)
    assert lead.distance_m == pytest.approx(25, rel=0.05)
    assert [track.track_id for track in tracks] == [1, 2, 3]
    assert [track.in_path for track in tracks] == [True, True, False]


def crossing(speed_mps, from_m=3.5, distance_m=20.0, frames=240):
    """Lateral position and whether it is in the path, of a vehicle that crosses the road to the right."""
    tracker = Tracker(CALIBRATION)
    history = follow(tracker, frames, lambda t: [seen(distance_m, lateral_m=from_m - speed_mps * t)])
    return [
        (from_m - speed_mps * k * FRAME_NS / 1e9, tracks[0].in_path)
        for k, tracks in enumerate(history)
        if tracks
    ]


def test_a_vehicle_that_drifts_slowly_enters_and_leaves_the_path_at_different_offsets():
    inside = [lateral_m for lateral_m, in_path in crossing(0.2, from_m=2.5, frames=780) if in_path]
    assert inside[0] == pytest.approx(1.2, abs=0.25)
    assert inside[-1] == pytest.approx(-1.8, abs=0.25)


def test_a_vehicle_that_cuts_in_is_in_the_path_half_a_second_before_it_is_there():
    inside = [lateral_m for lateral_m, in_path in crossing(1.5) if in_path]
    assert inside[0] == pytest.approx(1.2 + 1.5 * 0.5, abs=0.2)


def test_a_neighbour_that_weaves_in_its_lane_never_comes_into_the_path():
    tracker = Tracker(CALIBRATION)
    for tracks in follow(tracker, 300, lambda t: [seen(15, lateral_m=3.5 + 0.4 * math.sin(t))]):
        assert not any(track.in_path for track in tracks)


@pytest.mark.parametrize("side", [1, -1])
def test_a_neighbour_cut_by_the_border_as_we_pass_it_stays_beside_the_path(side):
    # Its rear is 2.6 to 4.4 m aside, its inner side 4.2 m longer: in the end half of it is out of sight.
    width_px, rate_mps, length_m = 1280, 1.5, 4.2

    def passing(t):
        distance_m = 12 - rate_mps * t
        box = CALIBRATION.ground_box(distance_m, side * 3.5, 1.8, 1.5)
        far = CALIBRATION.ground_box(distance_m + length_m, side * 3.5, 1.8, 1.5)
        left = max(min(box.x, far.x), 0.0)
        right = min(max(box.right, far.right), width_px - 1.0)
        return [Detection(Box(left, box.y, right - left, box.h), 10.0)]

    frames = round(10 / rate_mps * 1e9 / FRAME_NS)
    tracker = Tracker(CALIBRATION)
    history = [tracks[0] for tracks in follow(tracker, frames, passing) if tracks]
    cut = [track for track in history if track.box.x < 2 or track.box.right > width_px - 3]
    assert cut
    assert not any(track.in_path for track in history)
    # The middle of what is left in the picture would be 2.5 m aside at the end.
    assert cut[-1].lateral_m == pytest.approx(side * 3.5, abs=0.6)


@pytest.mark.parametrize("side", [1, -1])
def test_a_neighbour_whose_box_ends_short_of_the_border_stays_beside_the_path(side):
    # As detectors and labels have it: what goes on beyond the border ends 5 % of the picture before it.
    left_px, right_px = 0.05 * 1280, 0.95 * 1280

    def passing(t):
        box = CALIBRATION.ground_box(14 - 9 * t, side * 3.2, 2.5, 3.0)
        left, right, top = max(box.x, left_px), min(box.right, right_px), max(box.y, 0.0)
        return [Detection(Box(left, top, right - left, min(box.bottom, 719.0) - top), 10.0)]

    history = [tracks[0] for tracks in follow(Tracker(CALIBRATION), 40, passing, 9.0) if tracks]
    assert history[-1].box.w < 0.25 * 1280
    assert not any(track.in_path for track in history)
    # What is left in the picture comes nearer to the path; the vehicle does not.
    assert all(side * track.lateral_speed_mps > -0.3 for track in history)


@pytest.mark.parametrize("side", [1, -1])
def test_a_neighbour_keeps_its_identity_while_less_and_less_of_it_is_in_the_picture(side):
    def passing(t):
        box = CALIBRATION.ground_box(12 - 2.0 * t, side * 2.5, 1.8, 1.5)
        left, right = max(box.x, 0.0), min(box.right, 1279.0)
        return [Detection(Box(left, box.y, right - left, box.h), 10.0)] if right - left > 40 else []

    history = follow(Tracker(CALIBRATION), 170, passing)
    assert {track.track_id for tracks in history for track in tracks} == {1}
    (last,) = history[140]
    assert not last.coasting


def test_a_vehicle_that_is_passed_and_no_longer_found_never_comes_into_the_path():
    tracker = Tracker(CALIBRATION)
    for k in range(150):
        distance_m = 40 - 10 * k / 30
        tracker.update(k * FRAME_NS, [seen(distance_m, lateral_m=-3.6)] if distance_m > 8 else [])
        assert tracker.lead_id is None


def test_oncoming_traffic_is_no_lead_but_a_standing_vehicle_is():
    for closing_mps, is_lead in ((40.0, False), (20.0, True)):
        tracker = Tracker(CALIBRATION)
        follow(tracker, 45, lambda t, v=closing_mps: [seen(80 - v * t)], ego_speed_mps=20.0)
        assert (tracker.lead_id is not None) == is_lead


detections = st.lists(
    st.builds(
        lambda x, y, w, h: Detection(Box(x, y, w, h), 1.0),
        st.floats(-50, 1250),
        st.floats(0, 700),
        st.floats(4, 900),
        st.floats(4, 700),
    ),
    max_size=6,
)


@examples(60)
@given(st.lists(st.tuples(st.integers(0, 400_000_000), detections), max_size=25))
def test_whatever_the_detector_says_tracks_are_finite_ordered_and_ids_never_return(steps):
    tracker = Tracker(CALIBRATION)
    time_ns, ended, before = 0, set(), set()
    for step_ns, found in steps:
        time_ns += step_ns
        tracks = tracker.update(time_ns, found, assumed_ego(20.0))
        ids = [track.track_id for track in tracks]
        assert ids == sorted(set(ids))
        assert not ended & set(ids)
        ended |= before - set(ids)
        before = set(ids)
        assert tracker.lead_id is None or tracker.lead_id in ids
        for track in tracks:
            assert math.isfinite(track.distance_m)
            assert track.distance_m >= 0
            assert track.distance_low_m <= track.distance_m <= track.distance_high_m
            assert math.isfinite(track.closing_speed_mps)
            assert track.closing_speed_sigma_mps > 0
            assert track.ttc_s is None or track.ttc_s >= 0


@pytest.mark.slow
def test_a_mount_turned_in_mid_drive_is_told():
    tracker = Tracker(CALIBRATION)
    turned_px = 740 * math.tan(math.radians(0.5))
    told_s = []
    for k in range(4500):
        time_s = k / 10
        # Traffic: a new car every twelve seconds, overtaken or overtaking.
        distance_m = 12 + 30 * ((time_s / 12) % 1)
        box = seen(distance_m, lateral_m=0.5).box
        moved = Box(box.x, box.y - (turned_px if time_s >= 150 else 0.0), box.w, box.h)
        tracker.update(k * 100_000_000, [Detection(moved, 1.0)], assumed_ego(20.0))
        if tracker.mount.moved:
            told_s.append(time_s)
    assert told_s
    assert 150 < told_s[0] <= 420
    assert tracker.mount.note is not None
    assert "farther down" in tracker.mount.note
