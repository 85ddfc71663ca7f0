"""Pictures that come at uneven times: what is believed goes by time, not by how many there are."""

import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.frame import ImageSize
from fcw.motion.ego import assumed_ego
from fcw.tracking.tracker import Tracker

CALIBRATION = Calibration.from_camera(GroundPlaneCamera(0.03, 740.0, 359.5, 1.3, 639.5), ImageSize(1280, 720))
NOISE_PX = 2.0


@pytest.mark.parametrize("after_ns", [0, 1, 1000, 1_000_000])
@pytest.mark.parametrize("every", [False, True], ids=["one", "every one"])
def test_a_second_picture_of_nearly_the_same_time_moves_no_vehicle(after_ns: int, every: bool):
    """A live camera tells times a nanosecond apart where its clock stands still."""
    rng, tracker = np.random.default_rng(0), Tracker(CALIBRATION)
    ids, off_px = set[int](), list[float]()
    for frame in range(90):
        time_ns = round(frame * 1e9 / 30)
        true = CALIBRATION.ground_box(40 - 5 * time_ns / 1e9, 0.0, 1.7, 1.5)
        for at_ns in (time_ns, time_ns + after_ns) if every or frame == 9 else (time_ns,):
            left, top, right, bottom = rng.normal((true.x, true.y, true.right, true.bottom), NOISE_PX)
            found = Detection(Box(left, top, right - left, bottom - top), 10.0)
            tracks = tracker.update(at_ns, [found], assumed_ego(15.0))
            ids |= {track.track_id for track in tracks}
            off_px += [abs(track.box.center_x - true.center_x) for track in tracks]
    assert ids == {1}
    assert max(off_px) < 2 * NOISE_PX
