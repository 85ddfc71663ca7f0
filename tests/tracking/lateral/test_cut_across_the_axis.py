"""A near vehicle that one side of the picture cuts, and that reaches across the camera's axis."""

import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.tracking.tracker import Tracker

FRAME_NS = 33_333_333
TYRES_M = 0.75
"""From a vehicle's rear to where its tyres meet the road."""


@pytest.mark.parametrize(
    ("focal_px", "width_px", "lateral_m", "size_m", "nearest_m"),
    [
        (1800.0, 1280, 0.5, (2.55, 3.3), 2.0),  # a lorry through a narrow lens
        (1000.0, 960, -0.4, (2.55, 3.3), 1.5),  # and in a picture whose right quarter was cut away
        (1000.0, 960, -0.4, (1.75, 1.5), 1.0),
    ],
)
def test_it_stays_where_it_is(focal_px, width_px, lateral_m, size_m, nearest_m):
    camera = GroundPlaneCamera(0.0, focal_px, 359.5, 1.3, 639.5)
    calibration = Calibration.from_camera(camera, ImageSize(width_px, 720), reference_offset_m=1.5)
    tracker, own_mps, cut = Tracker(calibration), 8.0, False
    for frame in range(round(30 * (30.0 - nearest_m) / 4.0)):
        distance_m = 30.0 - 4.0 * frame / 30
        whole = calibration.ground_box(distance_m, lateral_m, *size_m)
        left, right = max(whole.x, -0.5), min(whole.right, width_px - 0.5)
        bottom = min(float(calibration.row_at(distance_m + TYRES_M)), 719.5)
        top = max(whole.y, -0.5)
        seen = Detection(Box(left, top, right - left, bottom - top), 1.0)
        tracks = tracker.update(frame * FRAME_NS, [seen], assumed_ego(own_mps))
        cut |= (whole.x < left) != (right < whole.right)
        if tracks:
            assert tracks[0].lateral_m == pytest.approx(lateral_m, abs=0.5)
    assert cut
