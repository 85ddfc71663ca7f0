"""A vehicle of which a detector boxes a part for a while keeps its distance, its speed, and its warning."""

from collections.abc import Callable, Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.threat.of_tracker import threats_of
from fcw.tracking.tracker import Tracker
from fcw.tracking.types import Track
from fcw.warning.policies import make_policy
from fcw.warning.policy import WarningLevel

CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), ImageSize(1280, 720), reference_offset_m=1.5
)
TYRES_M = 0.75
FRAME_S = 1 / 30


def boxed(distance_m: float, lateral_m: float, part: float, from_right: bool) -> Box:
    """A car's box down to its tyres, or the left or right part of it."""
    rear = CALIBRATION.ground_box(distance_m, lateral_m, 1.75, 1.5)
    bottom = float(CALIBRATION.row_at(distance_m + TYRES_M))
    left = rear.x + (1 - part) * rear.w if from_right else rear.x
    return Box(left, rear.y, part * rear.w, bottom - rear.y)


def drive(
    distance_at: Callable[[float], float],
    part_at: Callable[[float], float],
    own_mps: float,
    lateral_m: float = 0.0,
    from_right: bool = False,
    until_s: float = 9.0,
) -> Iterator[tuple[float, Track | None, WarningLevel]]:
    """Time, the vehicle as it is believed, and the level of the warning, frame by frame."""
    tracker, policy, ego = Tracker(CALIBRATION), make_policy(), assumed_ego(own_mps)
    for frame in range(round(until_s / FRAME_S)):
        time_s = frame * FRAME_S
        box = boxed(distance_at(time_s), lateral_m, part_at(time_s), from_right)
        tracks = tracker.update(round(time_s * 1e9), [Detection(box, 1.0)], ego)
        threats = threats_of(tracker, tracks, ego)
        level = policy.update(round(time_s * 1e9), threats, own_mps).level
        yield time_s, tracks[0] if tracks else None, level


@pytest.mark.parametrize("from_right", [False, True], ids=["left", "right"])
@pytest.mark.parametrize("part", [0.4, 0.5, 0.6])
@pytest.mark.parametrize("gap_m", [10.0, 20.0])
def test_a_car_we_follow_seems_neither_to_fall_back_nor_to_close_while_a_part_of_it_is_boxed(
    gap_m: float, part: float, from_right: bool
):
    seen = drive(lambda _: gap_m, lambda t: part if 2 <= t < 6 else 1.0, gap_m, from_right=from_right)
    for time_s, track, level in seen:
        assert level <= WarningLevel.ADVISORY
        if time_s > 1.5:
            assert track is not None
            assert track.distance_m == pytest.approx(gap_m, rel=0.05)
            assert abs(track.closing_speed_mps) < 1.0
            assert abs(track.lateral_speed_mps) < 0.3


@pytest.mark.parametrize("part_from_s", [1.0, 2.0, 3.0])
def test_a_warning_lasts_when_less_of_the_vehicle_is_boxed(part_from_s: float):
    # 14 m/s behind a lead at 6 m/s: contact at 5.6 s.
    levels = [
        (time_s, level)
        for time_s, _, level in drive(
            lambda t: 45 - 8 * t, lambda t: 0.6 if t >= part_from_s else 1.0, 14.0, until_s=5.5
        )
    ]
    first_s = next(time_s for time_s, level in levels if level is WarningLevel.WARNING)
    assert 45 / 8 - first_s > 2.5
    assert all(level is WarningLevel.WARNING for time_s, level in levels if time_s >= first_s)


@given(at_s=st.floats(1.5, 5.0), part=st.floats(0.2, 0.9), gap_m=st.floats(8.0, 30.0))
@settings(max_examples=20, deadline=None)
def test_one_narrow_box_moves_nothing(at_s: float, part: float, gap_m: float):
    narrow = round(at_s / FRAME_S)
    seen = drive(lambda _: gap_m, lambda t: part if round(t / FRAME_S) == narrow else 1.0, gap_m, until_s=6.0)
    for time_s, track, _ in seen:
        if time_s > 1.5:
            assert track is not None
            assert track.distance_m == pytest.approx(gap_m, rel=0.05)
            assert abs(track.closing_speed_mps) < 1.0


def test_the_part_is_as_wide_as_it_is_boxed_and_the_whole_as_wide_as_before():
    widths_m = {
        round(time_s, 1): track.width_m
        for time_s, track, _ in drive(lambda _: 15.0, lambda t: 0.6 if 2 <= t < 6 else 1.0, 15.0)
        if track is not None
    }
    assert widths_m[5.5] == pytest.approx(0.6 * widths_m[1.9], rel=0.1)
    assert widths_m[8.5] == pytest.approx(widths_m[1.9], rel=0.03)


def test_a_car_that_pulls_away_is_not_taken_for_a_part_of_one():
    """Its lower edge goes up as its box becomes narrower."""
    for time_s, track, _ in drive(lambda t: 8 + 1.5 * max(t - 1, 0) ** 2, lambda _: 1.0, 8.0, until_s=4.0):
        if time_s > 1:
            assert track is not None
            assert track.distance_m == pytest.approx(8 + 1.5 * (time_s - 1) ** 2, rel=0.12)
            assert track.width_m == pytest.approx(1.75, rel=0.1)
