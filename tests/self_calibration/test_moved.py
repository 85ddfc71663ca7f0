"""A camera that is moved in the middle of a clip."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fcw.camera.calibration import Gaussian
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.detection.choice import searching_detector
from fcw.frame import Frame
from fcw.self_calibration.clip import BEFORE_MOVE_S, calibrate_clip, rough_calibration
from fcw.self_calibration.moved import moved_at
from fcw.sources import open_source
from fcw.sources.forwarding import ForwardingSource

DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
MOVED_S = 8.0
SHIFT_PX = 160


@given(st.lists(st.floats(-20, 20), min_size=12, max_size=12), st.booleans())
def test_a_shift_of_ten_degrees_between_signs_that_scatter_by_one_is_a_move(scatter_px, upwards):
    shift_px = 1000 * math.tan(math.radians(10)) * (1 if upwards else -1)
    signs = [(float(k), 300 + off_px + (shift_px if k > 4 else 0)) for k, off_px in enumerate(scatter_px)]
    assert moved_at(signs[::-1], 1000.0) == (4.0, 5.0)


@given(st.lists(st.floats(-40, 40), min_size=0, max_size=12), st.floats(-30, 30))
def test_signs_that_scatter_by_two_degrees_on_a_hill_are_none(scatter_px, hill_px):
    signs = [(float(k), 300 + off_px + (hill_px if k > 4 else 0)) for k, off_px in enumerate(scatter_px)]
    assert moved_at(signs, 1000.0) is None


def test_a_few_odd_signs_and_signs_all_over_the_picture_are_no_move():
    odd = [(float(k), 300.0 if k < 10 else 600.0) for k in range(12)]
    assert moved_at(odd, 1000.0) is None
    wild = [(float(k), 100.0 + 97 * k % 500) for k in range(20)]
    assert moved_at(wild, 1000.0) is None


class Knocked:
    """The first seconds of a drive, with ten pictures a second, whose camera turns up in the middle."""

    def __init__(self, end_s: float, moved_s: float = MOVED_S) -> None:
        self._drive, self._end_s, self._moved_s = open_source(DEMO), end_s, moved_s
        self.name, self.image_size = self._drive.name, self._drive.image_size

    def frames(self) -> Iterator[Frame]:
        for frame in self._drive.frames():
            time_s = frame.time_ns / 1e9
            if time_s > self._end_s:
                return
            if frame.index % 3 == 0:
                image = frame.image
                if time_s > self._moved_s:
                    image = np.roll(image, SHIFT_PX, axis=0)
                    image[:SHIFT_PX] = image[SHIFT_PX]
                yield replace(frame, image=image)


def calibrated(source):
    guess = rough_calibration(source.image_size, 1.3)
    detector = searching_detector(guess)
    return calibrate_clip(source, detector, Known(Evidence(), source.image_size, Gaussian(1.3, 0.12)))


@pytest.mark.slow
def test_a_clip_is_calibrated_until_its_camera_was_knocked():
    knocked = calibrated(Knocked(2 * MOVED_S))
    assert knocked.piece_s is not None
    assert knocked.piece_s[0] == 0.0
    assert knocked.piece_s[1] == pytest.approx(MOVED_S - BEFORE_MOVE_S, abs=1.5)
    whole = calibrated(Knocked(knocked.piece_s[1]))
    assert whole.piece_s is None
    assert knocked.calibration == whole.calibration


def test_lane_lines_that_jump_while_driving_leads_to_one_row_are_no_move(data_dir):
    """Lanes put the horizon 38 px lower from the second second on; the drive leads where it did."""

    class SecondHalf(ForwardingSource):
        def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
            return (frame for frame in super().frames(start_ns) if frame.index >= 148)

    source = SecondHalf(open_source(data_dir / "clips" / "muchlisin_driving.mp4"))
    found = calibrated(source)
    assert found.by_motion
    assert found.piece_s is None
