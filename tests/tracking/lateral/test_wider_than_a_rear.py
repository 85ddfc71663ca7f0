"""What is wider than a rear: a side beside our way, a car across it, and one that turns off."""

import math

import pytest

from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track

FRAME_NS = 33_333_333
WIDTH_M, HEIGHT_M, LENGTH_M = 1.75, 1.5, 4.2
CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.02, 1000.0, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=0.0
)


def tracked(distance_m: float, sides_m: list[tuple[float, float]], closing_mps: float = 0.0) -> list[Track]:
    """One vehicle by boxes that go, frame by frame, from one place across the road to another."""
    tracker, tracks = Tracker(CALIBRATION), []
    for frame, (left_m, right_m) in enumerate(sides_m):
        ahead_m = distance_m - closing_mps * frame / 30
        box = CALIBRATION.ground_box(ahead_m, (left_m + right_m) / 2, left_m - right_m, HEIGHT_M)
        tracks += tracker.update(frame * FRAME_NS, [Detection(box, 1.0)])
    assert {track.track_id for track in tracks} == {1}
    return tracks


def turning(turning_s: float) -> list[tuple[float, float]]:
    """The sides of a vehicle that goes ahead of us for a second, and then turns off to the right."""
    sides_m = []
    for frame in range(120):
        angle_rad = min(max(frame / 30 - 1.0, 0.0) / turning_s, 1.0) * math.pi / 2
        shown_m = WIDTH_M * math.cos(angle_rad) + LENGTH_M * math.sin(angle_rad)
        sides_m.append((WIDTH_M / 2, WIDTH_M / 2 - shown_m))
    return sides_m


@pytest.mark.parametrize("distance_m", [12.0, 20.0, 30.0])
@pytest.mark.parametrize("turning_s", [1.0, 2.0, 3.0])
def test_who_turns_off_does_not_come_nearer(distance_m, turning_s):
    tracks = tracked(distance_m, turning(turning_s))
    # Where its width counts as always, 5 to 12 m/s, 1 to 2 s, and more than a third nearer.
    assert max(track.closing_speed_mps for track in tracks) < 0.25 * distance_m
    assert min(track.ttc_s or math.inf for track in tracks) > 3.5
    assert min(track.distance_m for track in tracks) > 0.8 * distance_m


@pytest.mark.parametrize("turning_s", [2.0, 3.0])
def test_who_turns_into_our_way_still_comes_nearer(turning_s):
    tracks = tracked(45.0, turning(turning_s)[::-1], closing_mps=8.0)
    # A second later. Where its width counts as always, 5.4 m/s, and a fifth to a third too far away.
    assert tracks[-1].closing_speed_mps > 6.5
    assert tracks[-1].distance_m < 1.15 * (45.0 - 8.0 * 119 / 30)


@pytest.mark.parametrize("turning_s", [2.0, 3.0, 4.0])
@pytest.mark.parametrize(("distance_m", "closing_mps"), [(45.0, 8.0), (60.0, 12.0)])
def test_a_car_seen_from_its_side_keeps_its_distance_as_it_turns_into_our_way(
    turning_s, distance_m, closing_mps
):
    sides_m = []
    for frame in range(75):
        angle_rad = max(1 - frame / 30 / turning_s, 0.0) * math.radians(72.0)
        shown_m = WIDTH_M * math.cos(angle_rad) + LENGTH_M * math.sin(angle_rad)
        sides_m.append((WIDTH_M / 2, WIDTH_M / 2 - shown_m))
    tracks = tracked(distance_m, sides_m, closing_mps)
    # Where its width counts as that of a rear, a fifth to a third too far away, and half as fast or slower.
    for before_s, track in ((0.5, tracks[-16]), (0.0, tracks[-1])):
        true_m = distance_m - closing_mps * (74 / 30 - before_s)
        assert track.distance_m == pytest.approx(true_m, rel=0.13)
        assert track.closing_speed_mps > 0.6 * closing_mps


@pytest.mark.parametrize("distance_m", [12.0, 20.0])
def test_a_car_across_half_of_our_way_is_not_beside_it(distance_m):
    # First it is seen from behind; then it reaches from 3.3 m to the left to 1 m to the right.
    behind, across = (1.15 + WIDTH_M / 2, 1.15 - WIDTH_M / 2), (3.3, -1.0)
    *_, last = tracked(distance_m, 10 * [behind] + 10 * [across])
    assert last.lateral_m == pytest.approx(1.15, abs=0.3)
    assert last.distance_m == pytest.approx(distance_m, rel=0.1)


@pytest.mark.parametrize("distance_m", [12.0, 20.0])
def test_a_car_beside_our_way_shows_its_side(distance_m):
    left_m = 4.0
    # The far end of its inner side, as wide as it looks where its rear is.
    inner_m = (left_m - WIDTH_M) * distance_m / (distance_m + LENGTH_M)
    *_, last = tracked(distance_m, 30 * [(left_m, inner_m)])
    assert last.lateral_m == pytest.approx(left_m - WIDTH_M / 2, abs=0.35)
