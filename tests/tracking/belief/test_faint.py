"""What the detector is not sure of is a vehicle where one is followed already, and nothing elsewhere."""

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import SeenBy, Track

CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=1.5
)
FRAME_NS = 33_333_333
FOUND_S = 1.0


def lead(time_s: float, faint: bool = False, aside_px: float = 0.0) -> Detection:
    """A car that comes nearer at 5 m/s, whose tyres meet the road 0.75 m ahead of its rear."""
    distance_m = 30.0 - 5.0 * time_s
    rear, foot_px = CALIBRATION.ground_box(distance_m, 0.0, 1.7, 1.5), CALIBRATION.row_at(distance_m + 0.75)
    box = Box(rear.x + aside_px, rear.y, rear.w, float(foot_px) - rear.y)
    return Detection(box, 2.0 if faint else 10.0, faint)


def after(detections_at, seconds: float = 4.0) -> list[tuple[Track, ...]]:
    """Tracks of each frame of a car that is well found for a second; then `detections_at` says what is."""
    tracker = Tracker(CALIBRATION)
    times_ns = range(0, round(seconds * 1e9), FRAME_NS)
    return [
        tracker.update(
            time_ns, [lead(time_ns / 1e9)] if time_ns < FOUND_S * 1e9 else detections_at(time_ns / 1e9)
        )
        for time_ns in times_ns
    ]


def test_what_is_only_ever_faint_is_no_vehicle():
    tracker = Tracker(CALIBRATION)
    assert not any(tracker.update(k * FRAME_NS, [lead(k * FRAME_NS / 1e9, faint=True)]) for k in range(90))


def test_a_vehicle_that_is_found_faintly_is_followed_and_measured():
    (track,) = after(lambda time_s: [lead(time_s, faint=True)])[-1]
    assert (track.track_id, track.seen_by) == (1, SeenBy.DETECTOR)
    assert track.distance_m == pytest.approx(30.0 - 5.0 * 4.0, rel=0.02)
    assert track.closing_speed_mps == pytest.approx(5.0, rel=0.05)
    assert after(lambda time_s: [])[-1] == ()  # nothing else carries it here


def test_faint_finds_do_not_add_up_to_belief():
    """Two clear ones are too few for a vehicle; the same with a third is one."""
    for clear, believed in ((2, False), (3, True)):
        tracker = Tracker(CALIBRATION)
        shown = [
            tracker.update(k * FRAME_NS, [lead(k * FRAME_NS / 1e9, faint=k >= clear)]) for k in range(60)
        ]
        assert bool(shown[-1]) is believed


def test_a_clear_box_goes_before_a_faint_one_whatever_overlaps_more():
    both = after(lambda time_s: [lead(time_s, aside_px=6.0), lead(time_s, faint=True)])
    clear = after(lambda time_s: [lead(time_s, aside_px=6.0)])
    assert both == clear


def test_a_faint_box_that_is_little_where_the_vehicle_is_expected_is_not_it():
    half_aside_px = 0.5 * lead(FOUND_S).box.w  # an overlap of a third, enough for a clear box
    tracks = after(lambda time_s: [lead(time_s, faint=True, aside_px=half_aside_px)], seconds=1.3)
    assert tracks[-1][0].seen_by is SeenBy.COASTING
    tracks = after(lambda time_s: [lead(time_s, aside_px=half_aside_px)], seconds=1.3)
    assert tracks[-1][0].seen_by is SeenBy.DETECTOR
