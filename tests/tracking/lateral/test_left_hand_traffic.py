"""Where people drive on the left all is the mirror image: the same vehicles must be followed and judged."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import Ego
from fcw.motion.state import Mount, OwnMotion, OwnPath
from fcw.threat.of_tracker import threats_of
from fcw.tracking.association import in_picture
from fcw.tracking.tracker import Tracker
from fcw.warning.policies import make_policy

WIDTH = 1280
CAMERA = GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 600.0)
SIZE = ImageSize(WIDTH, 720)
FRAME_NS = 66_666_667
CALIBRATIONS = tuple(
    Calibration.from_camera(replace(CAMERA, principal_column_px=column_px), SIZE, reference_offset_m=1.5)
    for column_px in (CAMERA.principal_column_px, WIDTH - 1 - CAMERA.principal_column_px)
)
"""Of a camera, and of its mirror image."""
BOXES = st.builds(Box, st.floats(-300.0, 1400.0), st.just(300.0), st.floats(2.0, 300.0), st.just(100.0))


def mirrored(box):
    return Box(WIDTH - 1 - box.right, box.y, box.w, box.h)


def ego(speed_mps, side, yaw_rate_radps, yaw_rad):
    """As we are, with side 1, or in the mirror, with -1."""
    motion = OwnMotion(
        speed_mps=speed_mps,
        speed_sigma_mps=0.3,
        yaw_rate_radps=side * yaw_rate_radps,
        yaw_rate_sigma_radps=0.003,
        mount=Mount(pitch_rad=0.03, yaw_rad=side * yaw_rad, pitch_sigma_rad=0.002, yaw_sigma_rad=0.002),
    )
    path = OwnPath(
        offset_m=0.1 * side,
        heading_rad=-side * yaw_rad,
        curvature_per_m=side * yaw_rate_radps / speed_mps,
        offset_sigma_m=0.3,
        heading_sigma_rad=0.007,
        curvature_sigma_per_m=1e-3,
    )
    return Ego(motion, path)


VEHICLES = st.lists(
    st.tuples(st.floats(8.0, 40.0), st.floats(-8.0, 8.0), st.floats(-4.0, 8.0), st.floats(-2.0, 2.0)),
    min_size=1,
    max_size=3,
    # Of two in the same place either may be the lead.
    unique_by=lambda vehicle: round(vehicle[0]),
)
"""Distance, place to the left, closing speed and speed to the left of each."""


@given(VEHICLES, st.floats(-0.2, 0.2), st.floats(-0.02, 0.02))
@examples(40)
def test_tracks_threats_and_warnings_of_the_mirror_image_are_mirrored(vehicles, yaw_rate_radps, yaw_rad):
    trackers = [Tracker(calibration) for calibration in CALIBRATIONS]
    policies = [make_policy(), make_policy()]
    for frame in range(25):
        time_s, boxes = frame * FRAME_NS / 1e9, []
        for distance_m, lateral_m, closing_mps, across_mps in vehicles:
            now_m = distance_m - closing_mps * time_s
            if now_m < 4.0:
                continue
            rear = CALIBRATIONS[0].ground_box(now_m, lateral_m + across_mps * time_s, 1.8, 1.5)
            left, right = max(rear.x, 0.0), min(rear.right, WIDTH - 1.0)
            if right - left > 2.0:
                boxes.append(Box(left, rear.y, right - left, rear.h))
        states, tracks, threats = [], [], []
        for tracker, policy, side in zip(trackers, policies, (1, -1), strict=True):
            seen = [Detection(box if side == 1 else mirrored(box), 10.0) for box in boxes]
            now = ego(12.0, side, yaw_rate_radps, yaw_rad)
            tracks.append(tracker.update(frame * FRAME_NS, seen, now))
            threats.append(threats_of(tracker, tracks[-1], now))
            states.append(policy.update(frame * FRAME_NS, threats[-1], now.motion.speed_mps))
        assert [t.track_id for t in tracks[1]] == [t.track_id for t in tracks[0]]
        assert trackers[1].lead_id == trackers[0].lead_id
        assert (states[1].level, states[1].track_id) == (states[0].level, states[0].track_id)
        for one, other in zip(*tracks, strict=True):
            assert other.box.x == pytest.approx(mirrored(one.box).x, abs=1e-5)
            assert other.distance_m == pytest.approx(one.distance_m, rel=1e-6)
            assert other.closing_speed_mps == pytest.approx(one.closing_speed_mps, rel=1e-6, abs=1e-6)
            assert other.lateral_m == pytest.approx(-one.lateral_m, rel=1e-6, abs=1e-6)
            assert other.lateral_speed_mps == pytest.approx(-one.lateral_speed_mps, rel=1e-6, abs=1e-6)
            assert (other.in_path, other.doubtful) == (one.in_path, one.doubtful)
        by_id = [sorted(some, key=lambda threat: threat.track.track_id) for some in threats]
        for one, other in zip(*by_id, strict=True):
            assert other.offset_m == pytest.approx(-one.offset_m, rel=1e-5, abs=1e-6)
            assert other.collision_probability == pytest.approx(one.collision_probability, abs=1e-6)
            assert (other.comes_in, other.crosses) == (one.comes_in, one.crosses)


@given(BOXES)
def test_what_is_beyond_the_right_edge_shows_as_much_as_what_is_beyond_the_left(box):
    shown, other = in_picture(box, SIZE), in_picture(mirrored(box), SIZE)
    assert (other.x, other.w) == pytest.approx((mirrored(shown).x, shown.w), abs=1e-9)
    assert -0.5 <= shown.x < shown.right <= WIDTH - 0.5
