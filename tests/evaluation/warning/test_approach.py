"""An approach made of one picture: its geometry is the camera's, and what is found in time is warned of."""

from functools import cache
from itertools import pairwise

import cv2
import numpy as np
import pytest

from fcw.box import Box
from fcw.camera.calibration import Calibration
from fcw.camera.ground_plane import GroundPlaneCamera
from fcw.detection.detector import Detection
from fcw.evaluation.warning.approach import (
    END_GAP_M,
    ApproachFrame,
    approach,
    closing_speed_mps,
    run_approach,
)
from fcw.frame import ImageSize
from fcw.warning.driver import EXPECTED_DRIVER
from fcw.warning.policies import make_policy

CALIBRATION = Calibration.from_camera(
    GroundPlaneCamera(0.02, 450.0, 175.0, 1.4, 319.5), ImageSize(640, 360), reference_offset_m=1.5
)
FIRST_GAP_M, WIDTH_M = 25.0, 1.75
VEHICLE = CALIBRATION.ground_box(FIRST_GAP_M, 0.6, WIDTH_M, 1.5)


def picture() -> np.ndarray:
    """A bright vehicle on a dark road."""
    image = np.full((360, 640, 3), 60, np.uint8)
    corner = round(VEHICLE.x + 0.5), round(VEHICLE.y + 0.5)
    last = round(VEHICLE.right - 0.5), round(VEHICLE.bottom - 0.5)
    cv2.rectangle(image, corner, last, (220, 220, 220), cv2.FILLED)
    return image


class FindsBright:
    """Stands in for a detector: what is bright is a vehicle."""

    name = "bright"

    def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
        x, y, w, h = cv2.boundingRect((image[:, :, 1] > 140).astype(np.uint8))
        return (Detection(Box(x - 0.5, y - 0.5, w, h), 10.0),) if w else ()


@cache
def approaching() -> tuple[ApproachFrame, ...]:
    return tuple(approach(picture(), VEHICLE, CALIBRATION))


def test_every_picture_shows_the_vehicle_where_the_camera_sees_it_at_that_distance():
    frames = approaching()
    gaps_m = [frame.gap_m for frame in frames]
    assert gaps_m[0] == pytest.approx(FIRST_GAP_M)
    assert gaps_m == sorted(gaps_m, reverse=True)
    assert END_GAP_M < gaps_m[-1] < END_GAP_M + 1
    for frame in frames:
        # A camera that looks down by a degree sees the nearest road a hundredth less magnified.
        row_px = CALIBRATION.row_at(frame.gap_m)
        allowed_px = 0.01 * (row_px - CALIBRATION.horizon_row_px)
        assert frame.box.bottom == pytest.approx(min(row_px, 359.5), abs=allowed_px)
        (found,) = FindsBright().detect(frame.image)
        for side in ("x", "y", "right", "bottom"):
            # A pixel of the first picture is as large as the vehicle has grown.
            allowed_px = 1.0 + (frames[0].gap_m + 1.5) / (frame.gap_m + 1.5)
            assert getattr(found.box, side) == pytest.approx(getattr(frame.box, side), abs=allowed_px)


def test_the_distance_falls_as_fast_as_is_said():
    frames = approaching()
    for before, after in pairwise(frames):
        passed_s = (after.time_ns - before.time_ns) / 1e9
        assert (before.gap_m - after.gap_m) / passed_s == pytest.approx(after.closing_mps, abs=0.3)


@pytest.mark.parametrize("needed_m", [2.0, 15.0, 60.0])
def test_the_closing_speed_is_that_which_needs_the_gap(needed_m: float):
    assert EXPECTED_DRIVER.needed_distance_m(closing_speed_mps(needed_m)) == pytest.approx(needed_m)


@pytest.mark.slow
def test_a_vehicle_that_is_found_is_warned_of_in_time():
    trial = run_approach(iter(approaching()), CALIBRATION, FindsBright(), make_policy())
    assert trial.in_time
    assert trial.found_part > 0.95
    assert trial.others == 0


@pytest.mark.slow
def test_a_vehicle_that_is_not_found_is_not_warned_of_and_that_is_said():
    class Blind(FindsBright):
        def detect(self, image: np.ndarray) -> tuple[Detection, ...]:
            return ()

    trial = run_approach(iter(approaching()), CALIBRATION, Blind(), make_policy())
    assert trial.found_part == trial.tracked_part == 0
    assert trial.warned_s is None
    assert not trial.in_time
    needed_m = EXPECTED_DRIVER.needed_distance_m(closing_speed_mps(0.6 * FIRST_GAP_M))
    due = next(f for f in approaching() if f.gap_m <= needed_m)
    assert trial.due_s == pytest.approx(due.time_ns / 1e9)
