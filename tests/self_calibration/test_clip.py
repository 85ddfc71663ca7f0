"""A recorded clip calibrated by what it shows."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fcw.camera.calibration import Gaussian, GroundPoint, Priors
from fcw.camera.joint.evidence import Evidence
from fcw.camera.joint.known import Known
from fcw.camera.solve import calibrate
from fcw.detection.choice import searching_detector
from fcw.detection.detector import Detection
from fcw.errors import UserError
from fcw.frame import Frame, ImageSize, Source
from fcw.self_calibration.clip import (
    ClipObservations,
    calibrate_clip,
    observe_clip,
    rough_calibration,
)
from fcw.self_calibration.lane_lines import agreed_meeting
from fcw.self_calibration.speed import MeanSpeed, speeds_seen
from fcw.self_calibration.turning.by_turns import LensByTurns
from fcw.self_calibration.turning.lens import PlainLens
from fcw.sources import open_source
from fcw.sources.forwarding import ForwardingSource

SIZE = ImageSize(1280, 720)
DEMO = Path(__file__).parents[2] / "recordings" / "demo" / "drive.mp4"
DEMO_HORIZON_ROW_PX = 329.8
LENS = Priors(Gaussian(math.radians(58), math.radians(3)))
"""As a data sheet would say it; the chessboards say 57.8 degrees."""
UNSAID = Priors()


def stated(source: Source, height_m: Gaussian, priors: Priors = UNSAID) -> Known:
    """The height, and what else is said; nobody clicked anything."""
    return Known(Evidence(), source.image_size, height_m, priors=priors)


class Blind:
    """A detector that finds nothing."""

    name = "blind"

    def detect(self, image: NDArray[np.uint8]) -> tuple[Detection, ...]:
        return ()


def test_a_clip_of_a_car_that_stands_gives_no_height_by_its_speed(data_dir, tmp_path):
    first = next(iter(open_source(data_dir / "kitti-odometry-03" / "drive.mp4").frames())).image
    for number in range(40):
        cv2.imwrite(str(tmp_path / f"{number:02}.png"), first)
    source = open_source(tmp_path)
    detector = searching_detector(rough_calibration(source.image_size, 1.65))
    known = [speed for _, speed in speeds_seen(source.frames(), rough_calibration(source.image_size, 1.65))]
    assert sum(speed is not None for speed in known) > 10  # that it stands is known
    with pytest.raises(UserError, match="does not show how fast the road goes by"):
        calibrate_clip(source, detector, stated(source, Gaussian(1.65, 0.1)), speed_mps=10.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("clip", "rows_px", "true_height_m"),
    [
        ("udacity_test_small1", (592.62, 511.83, 454.12), 1.19),
        # Three seconds without a vehicle, on a road so plain that it tells hardly a speed.
        ("udacity_project_video_cut", (597.88, 516.50, 458.38), 1.205),
    ],
)
@pytest.mark.parametrize(
    ("height_m", "priors", "error"),
    [
        (Gaussian(1.2, 0.024), LENS, 0.08),
        (Gaussian(1.3, 0.12), Priors(), 0.20),
    ],
)
def test_the_udacity_clips_without_any_mark(clip, rows_px, true_height_m, height_m, priors, error, data_dir):
    """Vehicles within 8 % with lens and height, within 20 % with nothing; each inside its own interval."""
    source = open_source(data_dir / "clips" / f"{clip}.mp4")
    # `calibrations.txt`: by the chessboards, lane and dashes.
    truth = calibrate(list(map(GroundPoint, (8, 15, 40), rows_px)), SIZE, true_height_m, exact=True)
    guess = rough_calibration(SIZE, height_m.value, priors)
    detector = searching_detector(guess)
    shown = calibrate_clip(source, detector, stated(source, height_m, priors))
    assert shown.shows_road
    found = shown.calibration
    row_px = truth.row_at(30.0)
    assert found.distance_at(row_px) == pytest.approx(30, rel=error)
    low_m, high_m = found.distance_interval(row_px)
    assert low_m < 30 < high_m


@given(st.floats(5.0, 40.0), st.floats(0.7, 1.4))
def test_a_known_speed_gives_the_height_whatever_lens_was_taken_for_granted(speed_mps, wrong):
    """Seen through a lens that is thought to be longer, the road goes by faster by the same factor."""
    focal_px, height_m = 1000.0, 1.3
    seen = MeanSpeed(wrong * speed_mps / height_m, wrong * focal_px, ())
    scale_px_m = seen.scale_px_m(speed_mps)
    assert scale_px_m.value == pytest.approx(focal_px * height_m)
    assert scale_px_m.sigma == pytest.approx(0.04 * focal_px * height_m)


def test_a_clip_that_turns_gives_the_focal_length_as_evidence():
    focal_px = Gaussian(560.0, 60.0)
    by_turns = LensByTurns(focal_px)
    assert ClipObservations(None, None, (), 10, by_turns=by_turns).evidence() == Evidence(focal_px=focal_px)


def test_lanes_count_where_many_pictures_agree():
    straight = [(640.0 + k % 3, 330.0 + k % 5) for k in range(20)]
    agreed = agreed_meeting([*straight, (200.0, 100.0)], SIZE)
    assert agreed is not None
    assert agreed[1].value == pytest.approx(332.0, abs=1.0)
    common_px = 0.03 * SIZE.height  # beside the scatter
    assert common_px < agreed[1].sigma < common_px + 2.0
    assert agreed_meeting(straight[:4], SIZE) is None
    assert agreed_meeting([(640.0, 200.0 + 20.0 * k) for k in range(12)], SIZE) is None


def test_lanes_and_motion_count_by_how_sure_they_are():
    sure, unsure = Gaussian(300.0, 1.0), Gaussian(302.0, 3.0)
    both = ClipObservations((sure, sure), (unsure, unsure), (), 10).leads_to_px
    assert both is not None
    assert both[1].value == pytest.approx(300.2)
    assert both[1].sigma == pytest.approx(math.sqrt(0.9))
    assert ClipObservations(None, (sure, unsure), (), 10).leads_to_px == (sure, unsure)


def test_lanes_and_motion_that_contradict_each_other_are_less_sure_together():
    """Birge's ratio: 20 px apart with errors of 3 and 4 px are four times too far apart."""
    drive, lanes = Gaussian(300.0, 3.0), Gaussian(320.0, 4.0)
    both = ClipObservations((drive, drive), (lanes, lanes), (), 10).leads_to_px
    assert both is not None
    assert both[1].value == pytest.approx(307.2)
    assert both[1].sigma == pytest.approx(4 * 2.4)


@pytest.mark.slow
def test_the_shipped_drive_leads_where_its_lanes_do():
    source = open_source(DEMO)
    detector = searching_detector(rough_calibration(SIZE, 1.3))
    seen = observe_clip(source, rough_calibration(SIZE, 1.3), detector, piece_s=(0.0, 4.0))
    assert seen.lanes_px is not None
    column, row = seen.lanes_px
    assert abs(row.value - DEMO_HORIZON_ROW_PX) < 2 * row.sigma
    assert abs(column.value - 639.5) < 2 * column.sigma


class Fisheye(ForwardingSource):
    """A clip as an equidistant lens of the same focal length would have seen it."""

    def frames(self, start_ns: int | None = None) -> Iterator[Frame]:
        size = self.image_size
        lens = PlainLens(721.5, -1 / 3, ((size.width - 1) / 2, (size.height - 1) / 2))
        columns, rows = np.meshgrid(np.arange(size.width), np.arange(size.height))
        rays = lens.rays(np.column_stack((columns.ravel(), rows.ravel())).astype(float)).places
        seen = (lens.focal_px * rays + lens.axis_px).astype(np.float32).reshape(size.height, size.width, 2)
        maps = cv2.convertMaps(seen, np.empty(0, np.float32), cv2.CV_16SC2)
        for frame in super().frames(start_ns):
            yield replace(frame, image=cv2.remap(frame.image, *maps, cv2.INTER_LINEAR))


@pytest.mark.slow
def test_a_clip_through_a_fisheye_tells_its_lens_and_nothing_else(data_dir):
    source = Fisheye(open_source(data_dir / "kitti-odometry-03" / "drive.mp4"))
    found = calibrate_clip(source, Blind(), stated(source, Gaussian(1.65, 0.05)))
    assert found.lens is not None
    assert found.lens.focal_x_px == pytest.approx(721.5, rel=0.15)
    straight = PlainLens(found.lens.focal_x_px, -1 / 3, (found.lens.column_px, found.lens.row_px))
    (k1, *_) = found.lens.coefficients
    assert k1 == pytest.approx(straight.fisheye(source.image_size).coefficients[0], abs=0.05)
    assert not found.shows_road


@pytest.mark.slow
def test_a_straight_clip_tells_no_focal_length(data_dir):
    source = open_source(data_dir / "clips" / "udacity_test_small1.mp4")
    assert observe_clip(source, rough_calibration(SIZE, 1.2), Blind(), asks_turns=True).by_turns is None
